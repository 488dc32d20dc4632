//! The command line as data: what may be given, the help that says so, and the values that shells may complete.
//!
//! The options of a drawing and the settings of its file have flags and help by their declarations in the core; what stands here is what
//! only a command has: paths, presets, limits, what is printed.

use std::path::PathBuf;

use clap::builder::PossibleValuesParser;
use clap::{Arg, ArgAction, Command, ValueHint, value_parser};
use clap_complete::Shell;
use graphstipple_core::stages::{
    Audience, DECLARATIONS, Declaration, Group, Islands, KINDS, Kind, MAX_PIXELS, MAX_SIDE, Machine, MachineFormat, PEN_SETTINGS,
    PROCESSES, PUBLISHED, PenSetting, ProcessRule, RULES, ReportFormat, Rule, SETTINGS, Setting, Sheet, Value, whole,
};
use graphstipple_core::{Format, Options, presets};

/// The path that stands for standard input or output.
pub(crate) const STANDARD: &str = "-";

/// What stands before the lists of options in the help.
pub(crate) const EXAMPLES: &str = "\
Examples:
  graphstipple photo.jpg -o drawing.svg
  graphstipple photo.jpg -o drawing.pdf --preset portrait --page A4
  graphstipple photo.jpg -o drawing.svg --nodes 100000 --preview preview.png";

/// The options that most people begin with, above all others in the help.
const FIRST: [&str; 5] = ["output", "preset", "nodes", "width", "preview"];

/// Their heading.
const FIRST_HEADING: &str = "To begin with";

/// The first argument of the command that turns options in the browser, which only Python's has.
pub(crate) const STUDIO: &str = "studio";

/// The first argument of the command that draws many photos, which only Python's has.
pub(crate) const BATCH: &str = "batch";

/// The flag that shows every option.
pub(crate) const HELP_ALL: &str = "help-all";

/// The flag that prints the options as a JSON schema.
pub(crate) const OPTIONS_SCHEMA: &str = "options-schema";

/// The flag that prints the presets.
pub(crate) const LIST_PRESETS: &str = "list-presets";

/// The flag that prints what a shell completes with.
pub(crate) const COMPLETIONS: &str = "completions";

/// The flag that prints the manual page.
pub(crate) const MAN: &str = "man";

/// The shells that there are completions for.
pub(crate) const SHELLS: [(&str, Shell); 3] = [("bash", Shell::Bash), ("zsh", Shell::Zsh), ("fish", Shell::Fish)];

/// Widest help in columns.
const WIDEST: usize = 120;

/// The command; its help has every option, or those that people turn.
pub(crate) fn command(with_all: bool) -> Command {
    let mut command = Command::new("graphstipple")
        .bin_name("graphstipple")
        .version(env!("CARGO_PKG_VERSION"))
        .about("Turns a photo into a black-and-white vector drawing of stipples and regions")
        .override_usage("graphstipple <PHOTO> --output <FILE> [OPTIONS]")
        .help_template("{about}\n\nUsage: {usage}\n\n{before-help}{all-args}{after-help}")
        .before_help(EXAMPLES)
        .max_term_width(WIDEST)
        .disable_help_flag(true)
        .disable_version_flag(true)
        .arg(photo());
    let of_options = DECLARATIONS.iter().filter(|d| d.group != Group::Method).map(|d| of_option(d, with_all));
    let arguments: Vec<Arg> = of_output(with_all)
        .into_iter()
        .chain(of_options)
        .chain(of_rules(with_all))
        .chain(of_pen(with_all))
        .chain([importance(with_all), subject(with_all), published(with_all)])
        .chain(of_reading(with_all))
        .chain(of_print(with_all))
        .collect();
    let (first, others): (Vec<Arg>, Vec<Arg>) =
        arguments.into_iter().partition(|argument| FIRST.contains(&argument.get_id().as_str()));
    for name in FIRST {
        let argument = first.iter().find(|argument| argument.get_id() == name).cloned();
        command = command.args(argument.map(|argument| argument.help_heading(FIRST_HEADING)));
    }
    let more = if with_all { "" } else { "All options: --help-all. " };
    command = command.after_help(format!("{more}With Python: graphstipple {STUDIO}, graphstipple {BATCH}"));
    command.args(others)
}

/// The command with the words that its flags take, for shells to complete. In a run the core checks them, in sentences of its own.
pub(crate) fn with_words() -> Command {
    command(true).mut_args(|argument| {
        let words = words(argument.get_id().as_str());
        if words.is_empty() { argument } else { argument.value_parser(PossibleValuesParser::new(words)) }
    })
}

/// The words that a flag takes, if they are all known.
fn words(name: &str) -> Vec<&'static str> {
    let of_option = || DECLARATIONS.iter().filter(|it| it.group != Group::Method && it.name == name).flat_map(|it| it.rule.words());
    match name {
        "preset" => presets().iter().map(|preset| preset.name).collect(),
        "process" => PROCESSES.iter().map(|process| process.name).collect(),
        "islands" => Islands::WORDS.to_vec(),
        "page" => Sheet::ALL.map(Sheet::name).to_vec(),
        COMPLETIONS => SHELLS.map(|(name, _)| name).to_vec(),
        _ => SETTINGS
            .iter()
            .filter(|it| it.name == name && !it.value_name.is_empty())
            .flat_map(Setting::words)
            .chain(PEN_SETTINGS.iter().filter(|it| it.full_name() == name).flat_map(PenSetting::words))
            .chain(of_option())
            .collect(),
    }
}

/// The flags that say how any photo is drawn and written, for front ends that draw many: all but those of a single file, of a pen, of
/// reports and of what is printed.
pub(crate) fn of_any_photo(with_all: bool) -> Vec<Arg> {
    let printed = of_print(with_all).into_iter().filter(|argument| argument.get_id() != "preset");
    let others: Vec<String> = printed.map(|argument| argument.get_id().to_string()).collect();
    let is_of_one = |argument: &Arg| {
        let name = argument.get_id().as_str();
        let is_rule = name == "process" || RULES.iter().any(|rule| rule.name == name);
        let is_of_machine = argument.get_help_heading() == Some(MACHINES) && !is_rule;
        argument.get_long().is_none()
            || is_of_machine
            || name == "output"
            || name.starts_with("preview")
            || others.iter().any(|it| it == name)
    };
    command(with_all).get_arguments().filter(|argument| !is_of_one(argument)).cloned().collect()
}

fn photo() -> Arg {
    Arg::new("photo")
        .value_name("PHOTO")
        .required(true)
        // More than one is told in words.
        .num_args(1..)
        .value_parser(value_parser!(PathBuf))
        .value_hint(ValueHint::FilePath)
        .help(format!("Image to draw: PNG, JPEG, TIFF or WebP; {STANDARD} reads standard input"))
        .help_heading(FIRST_HEADING)
}

/// An argument of an option of the drawing.
fn of_option(declaration: &'static Declaration, with_all: bool) -> Arg {
    let flag = flag(declaration.name).help(help_of(declaration, with_all)).help_heading(declaration.group.title());
    let flag = flag.hide(!with_all && declaration.audience == Audience::Further);
    let value_name = match (declaration.rule, declaration.unit) {
        (Rule::Switch, _) => return flag.action(ArgAction::SetTrue),
        (Rule::Color, _) => "COLOR",
        (Rule::Inks, _) => "INK[,INK]",
        (Rule::Words(_) | Rule::WordsOrWithin(..), _) => "WORD",
        (_, "pixels") => "PX",
        _ => "N",
    };
    flag.value_name(value_name).allow_negative_numbers(true)
}

/// A flag of this name, in kebab case.
fn flag(name: &'static str) -> Arg {
    Arg::new(name).long(name.replace('_', "-"))
}

/// What an option does, takes and is by default; its first sentence alone, or all of them.
fn help_of(declaration: &Declaration, with_all: bool) -> String {
    let does = if with_all { declaration.description().trim_end_matches('.').to_owned() } else { declaration.sentence() };
    let default = match (declaration.value(&Options::default()), declaration.absent) {
        (Value::Switch(_), _) => return does,
        (Value::Absent, Some(absent)) => absent.meaning.to_owned(),
        (Value::Word(word), _) => word,
        (value, _) => value.to_string(),
    };
    let takes = match declaration.rule {
        Rule::Within(least, most) => format!("{least} to {most}"),
        Rule::UpTo(most) => format!("above 0 to {most}"),
        Rule::Whole(least, most) if most >= 1 << 30 => format!("at least {least}"),
        Rule::Whole(least, most) => format!("{least} to {most}"),
        Rule::WordsOrWithin(words, least, most) => format!("{}, {least} to {most}", words.join(", ")),
        Rule::Inks => "#rrggbb or name=#rrggbb".to_owned(),
        rule => rule.allowed().replace('"', ""),
    };
    let or_word =
        declaration.absent.filter(|absent| absent.word == "off").map_or_else(String::new, |absent| format!(", {}", absent.word));
    format!("{does} [{takes}{or_word}; default {default}]")
}

/// A file and how it is written.
fn of_output(with_all: bool) -> Vec<Arg> {
    let output = Arg::new("output")
        .short('o')
        .long("output")
        .value_name("FILE")
        .required(true)
        .value_parser(value_parser!(PathBuf))
        .value_hint(ValueHint::FilePath)
        .help(format!("File to write, {} by its suffix; {STANDARD} writes SVG to standard output", Format::suffixes()));
    let preview = Arg::new("preview")
        .long("preview")
        .value_name("FILE")
        .value_parser(value_parser!(PathBuf))
        .value_hint(ValueHint::FilePath)
        .help("Also write a .png of the drawing");
    let preview_width = Arg::new("preview_width")
        .long("preview-width")
        .value_name("PX")
        .value_parser(parse_width)
        .requires("preview")
        .help("Width of the preview [default the photo's]")
        .help_heading(OUTPUT);
    let min_dot = Arg::new("min_dot")
        .long("min-dot")
        .value_name("LENGTH")
        .allow_hyphen_values(true)
        .help("Least radius (not diameter) of a dot: smaller ones grow where there is room, else they go")
        .help_heading(SIZE);
    let limits = [
        (
            "max_bytes",
            "SIZE",
            "Draw as finely as a file of this size allows, such as 100kB, 1MB or 100KiB: first with simpler contours, then with fewer nodes",
        ),
        ("max_points", "N", "Draw as finely as so many points allow, control points included; a dot counts one"),
    ];
    let limits = limits.map(|(name, value_name, help)| {
        flag(name).value_name(value_name).allow_negative_numbers(true).help(help).help_heading(OUTPUT).hide(!with_all)
    });
    let force = Arg::new("force")
        .long("force")
        .action(ArgAction::SetTrue)
        .help("Overwrite files that are read-only")
        .help_heading(OUTPUT)
        .hide(!with_all);
    // The flag of an option stands for the setting of its name too.
    let of_option = |setting: &&Setting| DECLARATIONS.iter().any(|declaration| declaration.name == setting.name);
    let settings = SETTINGS.iter().filter(|setting| !of_option(setting)).map(|setting| of_setting(setting, with_all));
    [output, preview].into_iter().chain(settings).chain(limits).chain([preview_width, min_dot, force]).collect()
}

/// A pen and the machine that has it.
fn of_pen(with_all: bool) -> Vec<Arg> {
    let of_setting = |setting: &'static PenSetting| {
        let name = setting.full_name();
        let is_pen = setting.name == "pen";
        let help = if is_pen {
            format!("{} ({})", setting.sentence, MachineFormat::SUFFIXES)
        } else {
            format!("{} [default {}]", setting.sentence, setting.default)
        };
        let argument = Arg::new(name.clone()).long(name.replace('_', "-")).value_name(setting.value_name);
        let argument = argument.allow_hyphen_values(true).help(help).hide(!with_all && !is_pen);
        if is_pen { argument } else { argument.requires("pen") }
    };
    let names: Vec<&str> = Machine::SHIPPED.iter().map(|machine| machine.name).collect();
    let machine = Arg::new("machine")
        .long("machine")
        .value_name("MACHINE")
        .requires("pen")
        .value_hint(ValueHint::FilePath)
        .help(format!("Machine that the file and the times are for: {}, or the file of a profile", names.join(", ")))
        .hide(!with_all);
    let time = flag("max_plot_time")
        .value_name("TIME")
        .requires("pen")
        .help("Draw as finely as the machine can plot in so long, such as 2h or 90min")
        .hide(!with_all);
    PEN_SETTINGS.iter().map(of_setting).chain([machine, time]).map(|argument| argument.help_heading(MACHINES)).collect()
}

/// What can be made.
fn of_rules(with_all: bool) -> Vec<Arg> {
    let names: Vec<&str> = PROCESSES.iter().map(|process| process.name).collect();
    let process = flag("process").value_name("PROCESS").help(format!(
        "Keep to what can be made (needs a size): {}",
        if with_all {
            PROCESSES.iter().map(|process| format!("{} ({})", process.name, process.sentence)).collect::<Vec<_>>().join("; ")
        } else {
            names.join(", ")
        }
    ));
    let of_rule = |rule: &'static ProcessRule| {
        let default = if rule.name == "islands" { Islands::default().name() } else { "no limit" };
        let help = format!("{} [default {default}, or as the process has it]", rule.sentence);
        flag(rule.name).value_name(rule.value_name).allow_hyphen_values(true).help(help).hide(!with_all)
    };
    // The flag that there is for dots anyway stands for the rule too.
    let rules = RULES.iter().filter(|rule| rule.name != "min_dot").map(of_rule);
    let check = Arg::new("check")
        .long("check")
        .value_name("FILE")
        .value_parser(value_parser!(PathBuf))
        .value_hint(ValueHint::FilePath)
        .help(format!("Also write what of the drawing breaks the rules, {} by its suffix", ReportFormat::SUFFIXES))
        .hide(!with_all);
    let only = flag("check_only").action(ArgAction::SetTrue).help("Only check: leave the drawing as it is").hide(!with_all);
    let strict = flag("strict").action(ArgAction::SetTrue).help("Exit with 3 if the drawing breaks a rule").hide(!with_all);
    [process].into_iter().chain(rules).chain([check, only, strict]).map(|argument| argument.help_heading(MACHINES)).collect()
}

/// Headings of the help.
const MACHINES: &str = "Machines";
const OUTPUT: &str = "File";
const SIZE: &str = "Size on paper";

/// An argument of a setting of the file.
fn of_setting(setting: &'static Setting, with_all: bool) -> Arg {
    let takers: Vec<&Format> = Format::ALL.iter().filter(|format| format.settings.contains(&setting.name)).collect();
    let only = match takers[..] {
        [format] => format!(" (.{} only)", format.suffix),
        _ => String::new(),
    };
    let flag = flag(setting.name).help_heading(if setting.is_size { SIZE } else { OUTPUT });
    let flag = flag.hide(!with_all && setting.audience == Audience::Further);
    if setting.value_name.is_empty() {
        return flag.action(ArgAction::SetTrue).help(format!("{}{only}", setting.sentence));
    }
    let flag = flag.value_name(setting.value_name).help(format!("{}{only} [default {}]", setting.sentence, setting.default));
    // A length that begins with a minus is told in words.
    flag.allow_hyphen_values(setting.value_name == "LENGTH").allow_negative_numbers(true)
}

/// Where detail is wanted.
fn importance(with_all: bool) -> Arg {
    let of_kind = |kind: &Kind| if with_all { format!("{} ({})", kind.form, kind.sentence) } else { kind.form.to_owned() };
    let kinds: Vec<String> = KINDS.iter().map(of_kind).collect();
    Arg::new("importance")
        .long("importance")
        .value_name("SOURCE")
        .value_hint(ValueHint::FilePath)
        .help(format!("Where detail is wanted: {} [default {}]", kinds.join(", "), KINDS[0].form))
        .help_heading(Group::Nodes.title())
}

/// What the rest steps back from.
fn subject(with_all: bool) -> Arg {
    let more = if with_all { " (white where it is), of any size; auto comes with Python's command" } else { "" };
    Arg::new("subject")
        .long("subject")
        .value_name("SOURCE")
        .value_hint(ValueHint::FilePath)
        .help(format!("What the rest steps back from: auto, or the path of a mask{more}"))
        .help_heading(Group::Tones.title())
        .hide(!with_all)
}

/// The parameters of the published method, any number of them.
fn published(with_all: bool) -> Arg {
    let of_group = DECLARATIONS.iter().filter(|declaration| declaration.group == Group::Method);
    let list: Vec<String> =
        of_group.map(|declaration| format!("{}: {}", declaration.name, help_of(declaration, with_all))).collect();
    Arg::new(PUBLISHED)
        .long(PUBLISHED)
        .value_name("NAME=VALUE")
        .action(ArgAction::Append)
        .help(format!(
            "Change one parameter of the published method's graphs and diffusions, any number of times; the paper's values of all \
             come with --preset paper\n{}",
            list.join("\n")
        ))
        .help_heading(Group::Method.title())
        .hide(!with_all)
}

/// How photos and maps are read.
fn of_reading(with_all: bool) -> [Arg; 2] {
    let max_pixels =
        Arg::new("max_pixels").long("max-pixels").value_name("N").value_parser(parse_pixels).allow_negative_numbers(true).help(
            format!("Refuse images with more pixels, before memory is taken for them [1 to {MAX_PIXELS}; default {MAX_PIXELS}]"),
        );
    let allow_damaged = Arg::new("allow_damaged")
        .long("allow-damaged")
        .action(ArgAction::SetTrue)
        .help("Draw what there is of an image that is cut short or damaged; the rest is background");
    [max_pixels, allow_damaged].map(|argument| argument.help_heading("Reading").hide(!with_all))
}

/// What is printed, and where the options come from.
fn of_print(with_all: bool) -> Vec<Arg> {
    let names: Vec<&'static str> = presets().iter().map(|preset| preset.name).collect();
    let switch = |name: &'static str, help: &'static str| Arg::new(name).long(name).action(ArgAction::SetTrue).help(help);
    let preset = Arg::new("preset")
        .long("preset")
        .value_name("NAME")
        .help(format!("Begin with the options of a preset: {}", names.join(", ")));
    let printed = [
        switch(LIST_PRESETS, "Print the presets and what they give"),
        switch("stats", "Print counts and times as JSON (to stderr with -o -)"),
        switch("quiet", "Show no progress bar"),
        switch(OPTIONS_SCHEMA, "Print the options of a drawing as a JSON schema, for user interfaces").hide(!with_all),
        Arg::new(COMPLETIONS)
            .long(COMPLETIONS)
            .value_name("SHELL")
            .help(format!("Print what lets a shell complete this command: {}", SHELLS.map(|(name, _)| name).join(", ")))
            .hide(!with_all),
        switch(MAN, "Print the manual page").hide(!with_all),
        switch("help", "Print this help").short('h'),
        switch(HELP_ALL, "Print the help of every option"),
        switch("version", "Print the version").short('V'),
    ];
    [preset].into_iter().chain(printed.map(|argument| argument.help_heading("Print"))).collect()
}

fn parse_pixels(text: &str) -> Result<u64, String> {
    match whole(text) {
        Some(pixels) if (1..=MAX_PIXELS).contains(&pixels) => Ok(pixels),
        _ => Err(format!("it must be between 1 and {MAX_PIXELS} pixels")),
    }
}

fn parse_width(text: &str) -> Result<usize, String> {
    match whole(text).and_then(|width| width.try_into().ok()) {
        Some(width) if (1..=MAX_SIDE).contains(&width) => Ok(width),
        _ => Err(format!("it must be between 1 and {MAX_SIDE} pixels")),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_definition_is_sound() {
        command(false).debug_assert();
        command(true).debug_assert();
        with_words().debug_assert();
    }

    #[test]
    fn flags_that_take_words_have_them() {
        assert!(words("preset").contains(&"portrait") && words("page").contains(&"letter"));
        assert_eq!((words("white_point"), words("style")), (vec!["auto"], vec!["flat", "layered"]));
        assert!(words("nodes").is_empty() && words("one_bit").is_empty() && words("width").is_empty());
    }

    #[test]
    fn the_help_tells_every_option_with_its_default() {
        let (short, long) = (command(false).render_help().to_string(), command(true).render_help().to_string());
        for declaration in DECLARATIONS {
            let flag = format!("--{} ", declaration.name.replace('_', "-"));
            let is_shown = declaration.audience == Audience::Everyday;
            assert_eq!(short.contains(&flag), is_shown, "{flag}");
            let begin = if declaration.group == Group::Method { format!("{}: ", declaration.name) } else { flag };
            let words = |text: &str| text.split_whitespace().collect::<Vec<_>>().join(" ");
            let told = words(&long);
            assert!(told.contains(&begin) && told.contains(&words(&help_of(declaration, true))), "{begin}");
        }
        assert!(short.lines().count() <= 100 && !short.contains("--published"));
    }
}
