//! The command line as data: what may be given, the help that says so, and what it comes to.
//!
//! The options of a drawing and the settings of its file have flags, help and messages by their declarations in the core; what stands
//! here is what only a command has: paths, presets, what is printed.

use std::ffi::OsString;
use std::path::{Path, PathBuf};

use clap::builder::{PossibleValuesParser, TypedValueParser as _};
use clap::{Arg, ArgAction, ArgMatches, Command, value_parser};
use graphstipple_core::stages::{
    Audience, Checked, DECLARATIONS, Declaration, Group, Inks, KINDS, Kind, Length, MAX_PIXELS, MAX_SIDE, PUBLISHED, Preset,
    Reading, Rule, SETTINGS, Setting, Source, Style, Value, Writer, named_length, preset,
};
use graphstipple_core::{Export, Format, Options, presets};

use crate::error::{Error, Result};
use crate::files::format_of_path;
use crate::writing::is_same_file;

/// The path that stands for standard input or output.
pub(crate) const STANDARD: &str = "-";

/// What stands before the lists of options in the help.
const EXAMPLES: &str = "\
Examples:
  graphstipple photo.jpg -o drawing.svg
  graphstipple photo.jpg -o drawing.pdf --preset portrait --page A4
  graphstipple photo.jpg -o drawing.svg --nodes 100000 --preview preview.png";

/// The options that most people begin with, above all others in the help.
const FIRST: [&str; 5] = ["output", "preset", "nodes", "width", "preview"];

/// Their heading.
const FIRST_HEADING: &str = "To begin with";

/// The flag that shows every option.
pub(crate) const HELP_ALL: &str = "help-all";

/// The flag that prints the options as a JSON schema.
pub(crate) const OPTIONS_SCHEMA: &str = "options-schema";

/// The flag that prints the presets.
pub(crate) const LIST_PRESETS: &str = "list-presets";

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
        .chain([importance(with_all), published(with_all)])
        .chain(of_reading(with_all))
        .chain(of_print(with_all))
        .collect();
    let (first, others): (Vec<Arg>, Vec<Arg>) =
        arguments.into_iter().partition(|argument| FIRST.contains(&argument.get_id().as_str()));
    for name in FIRST {
        let argument = first.iter().find(|argument| argument.get_id() == name).cloned();
        command = command.args(argument.map(|argument| argument.help_heading(FIRST_HEADING)));
    }
    if !with_all {
        command = command.after_help("More options, for those who want to know exactly: --help-all");
    }
    command.args(others)
}

fn photo() -> Arg {
    Arg::new("photo")
        .value_name("PHOTO")
        .required(true)
        .value_parser(value_parser!(PathBuf))
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
        .help(format!("File to write, {} by its suffix; {STANDARD} writes SVG to standard output", Format::suffixes()));
    let preview = Arg::new("preview")
        .long("preview")
        .value_name("FILE")
        .value_parser(value_parser!(PathBuf))
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
        .help("Least radius of a dot: smaller ones grow where there is room, else they go")
        .help_heading(SIZE);
    let force = Arg::new("force")
        .long("force")
        .action(ArgAction::SetTrue)
        .help("Overwrite files that are read-only")
        .help_heading(OUTPUT)
        .hide(!with_all);
    let settings = SETTINGS.iter().map(of_setting);
    [output, preview].into_iter().chain(settings).chain([preview_width, min_dot, force]).collect()
}

/// Headings of the help.
const OUTPUT: &str = "File";
const SIZE: &str = "Size on paper";

/// An argument of a setting of the file.
fn of_setting(setting: &'static Setting) -> Arg {
    let takers: Vec<&Format> = Format::ALL.iter().filter(|format| format.settings.contains(&setting.name)).collect();
    let only = match takers[..] {
        [format] => format!(" (.{} only)", format.suffix),
        _ => String::new(),
    };
    let flag = flag(setting.name).help_heading(if setting.is_size { SIZE } else { OUTPUT });
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
        .help(format!("Where detail is wanted: {} [default {}]", kinds.join(", "), KINDS[0].form))
        .help_heading(Group::Nodes.title())
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
        .help(format!("Begin with the options of a preset: {}", names.join(", ")))
        .value_parser(PossibleValuesParser::new(names).try_map(|name: String| preset(&name)))
        .hide_possible_values(true);
    let printed = [
        switch(LIST_PRESETS, "Print the presets and what they give"),
        switch("stats", "Print counts and times as JSON (on standard error when the SVG goes to -o -)"),
        switch("quiet", "Show no progress bar"),
        switch(OPTIONS_SCHEMA, "Print the options of a drawing as a JSON schema, for user interfaces").hide(!with_all),
        switch("help", "Print this help").short('h'),
        switch(HELP_ALL, "Print the help of every option"),
        switch("version", "Print the version").short('V'),
    ];
    [preset].into_iter().chain(printed.map(|argument| argument.help_heading("Print"))).collect()
}

/// Everything that a run needs, checked as far as it can be without reading a file.
#[derive(Debug, Clone)]
pub(crate) struct Job {
    /// `None` is standard input.
    pub(crate) photo: Option<PathBuf>,
    /// `None` is SVG on standard output.
    pub(crate) output: Option<PathBuf>,
    /// Its format, and what it is written with.
    pub(crate) writer: Writer,
    /// A picture of it, and its width.
    pub(crate) preview: Option<(PathBuf, Option<usize>)>,
    pub(crate) importance: Source,
    pub(crate) options: Checked<Options>,
    /// How the photo and a map are read.
    pub(crate) reading: Reading,
    /// The least radius of a stipple on paper.
    pub(crate) min_dot: Option<Length>,
    /// Whether counts and times are printed.
    pub(crate) stats: bool,
    /// Whether no progress is shown.
    pub(crate) quiet: bool,
    /// Whether files that are read-only are overwritten.
    pub(crate) force: bool,
}

impl Job {
    /// What these arguments ask for; the first is the program's name.
    ///
    /// # Errors
    /// [`Error::Usage`] for the first rule that they break.
    pub(crate) fn of(arguments: Vec<OsString>) -> Result<Self> {
        let matches = command(false).try_get_matches_from(arguments).map_err(|error| Error::Usage(one_line(&error.to_string())))?;
        let path = |name: &str| matches.get_one::<PathBuf>(name).cloned();
        let text = |name: &str| matches.get_one::<String>(name).map(String::as_str);
        let preset = matches.get_one::<Preset>("preset");

        let options = options(&matches, preset).and_then(Options::check).map_err(in_flags)?;
        let importance = Source::parse(text("importance").unwrap_or(KINDS[0].form)).map_err(in_flags)?;
        let photo = path("photo").filter(|photo| photo != Path::new(STANDARD));
        let output = path("output").filter(|output| output != Path::new(STANDARD));
        let format = output.as_deref().map_or_else(|| Ok(Format::ALL[0]), format_of_path)?;
        let export = export(&matches, preset).and_then(Export::check).map_err(in_flags)?;
        let writer = format.writer(export).map_err(in_flags)?;
        let min_dot = text("min_dot").map(|text| named_length("min_dot", &Value::Word(text.to_owned())));
        let min_dot = min_dot.transpose().map_err(in_flags)?;
        let preview = path("preview").map(|path| (path, matches.get_one::<usize>("preview_width").copied()));
        let [stats, quiet, force] = ["stats", "quiet", "force"].map(|name| matches.get_flag(name));
        let reading = Reading {
            background: options.background.rgb(),
            max_pixels: matches.get_one("max_pixels").copied().unwrap_or(MAX_PIXELS),
            allow_damaged: matches.get_flag("allow_damaged"),
            options: Some(options.clone()),
        };
        let job = Self { photo, output, writer, preview, importance, options, reading, min_dot, stats, quiet, force };
        job.check_paths()?;
        Ok(job)
    }

    /// The files that it writes.
    pub(crate) fn paths_to_write(&self) -> impl Iterator<Item = &Path> {
        self.output.as_deref().into_iter().chain(self.preview.iter().map(|preview| preview.0.as_path()))
    }

    /// Checks that no file is written twice, or over what the drawing is made from.
    fn check_paths(&self) -> Result<()> {
        if let Some((preview, _)) = &self.preview {
            if !format_of_path(preview).is_ok_and(Format::has_pixels) {
                return Err(Error::Usage(format!("{}: the suffix of a preview must be .png", preview.display())));
            }
            if self.output.as_ref().is_some_and(|output| is_same_file(preview, output)) {
                return Err(Error::Usage(format!("{}: the preview must be another file than the output", preview.display())));
            }
        }
        let mut sources: Vec<&Path> = self.photo.as_deref().into_iter().collect();
        if let Source::File(map) = &self.importance {
            sources.push(Path::new(map));
        }
        for written in self.paths_to_write() {
            if sources.iter().any(|source| is_same_file(written, source)) {
                return Err(Error::Usage(format!(
                    "{}: the drawing would replace an image that it is made from",
                    written.display()
                )));
            }
        }
        Ok(())
    }
}

/// The options of the drawing: those of the preset, changed by single ones.
fn options(matches: &ArgMatches, preset: Option<&Preset>) -> graphstipple_core::Result<Options> {
    let mut options = preset.map_or_else(Options::default, |preset| preset.options.clone());
    for declaration in DECLARATIONS.iter().filter(|declaration| declaration.group != Group::Method) {
        if declaration.rule == Rule::Switch {
            if matches.get_flag(declaration.name) {
                options.set(declaration.name, &Value::Switch(true))?;
            }
        } else if let Some(text) = matches.get_one::<String>(declaration.name) {
            options.set(declaration.name, &declaration.parse(text))?;
        }
    }
    for text in matches.get_many::<String>(PUBLISHED).into_iter().flatten() {
        let (name, value) = text.split_once('=').unwrap_or_default();
        let of_name = DECLARATIONS
            .iter()
            .find(|declaration| declaration.group == Group::Method && declaration.name == name.replace('-', "_"));
        let declaration = of_name.ok_or_else(|| {
            let names: Vec<&str> = DECLARATIONS.iter().filter(|d| d.group == Group::Method).map(|d| d.name).collect();
            let allowed = format!("NAME=VALUE with one of the names {}", names.join(", "));
            graphstipple_core::Error::Option { option: PUBLISHED.to_owned(), value: text.clone(), allowed }
        })?;
        options.set(&declaration.full_name(), &declaration.parse(value))?;
    }
    Ok(options)
}

/// How the file is written.
fn export(matches: &ArgMatches, preset: Option<&Preset>) -> graphstipple_core::Result<Export> {
    let mut export = Export::default();
    for setting in SETTINGS {
        if setting.value_name.is_empty() {
            if matches.get_flag(setting.name) {
                export.set(setting.name, &Value::Switch(true))?;
            }
        } else if let Some(text) = matches.get_one::<String>(setting.name) {
            let number = (setting.value_name == "NUMBER").then(|| text.parse().ok().map(Value::Number)).flatten();
            export.set(setting.name, &number.unwrap_or_else(|| Value::Word(text.clone())))?;
        }
    }
    // A layered drawing has both inks, whatever the preset suggests.
    if export.style == Style::Flat && !matches.contains_id("inks") {
        export.inks = preset.map_or(Inks::default(), |preset| preset.inks);
    }
    Ok(export)
}

/// Names the flag instead of the core's option.
pub(crate) fn in_flags(error: graphstipple_core::Error) -> Error {
    match error {
        graphstipple_core::Error::Option { option, value, allowed } => {
            let flag = match option.strip_prefix(PUBLISHED).and_then(|rest| rest.strip_prefix('.')) {
                Some(parameter) => format!("{PUBLISHED} {parameter}"),
                None => option.replace('_', "-"),
            };
            // What Python calls None has a word of its own here.
            let absent = Declaration::named(&option).ok().and_then(|declaration| declaration.absent);
            let allowed = match (absent, allowed.strip_prefix("None")) {
                (Some(absent), Some(rest)) => format!("{}{rest}", absent.word),
                _ => allowed,
            };
            // Other options stand there by their names.
            let others = DECLARATIONS.iter().filter(|it| it.group != Group::Method && it.name.contains('_'));
            let allowed =
                others.fold(allowed, |allowed, other| allowed.replace(other.name, &format!("--{}", other.name.replace('_', "-"))));
            Error::Usage(format!("--{flag} is {value}, but it must be {allowed}"))
        }
        other => Error::Core(other),
    }
}

fn parse_pixels(text: &str) -> Result<u64, String> {
    match text.parse() {
        Ok(pixels) if (1..=MAX_PIXELS).contains(&pixels) => Ok(pixels),
        _ => Err(format!("it must be between 1 and {MAX_PIXELS} pixels")),
    }
}

fn parse_width(text: &str) -> Result<usize, String> {
    match text.parse() {
        Ok(width) if (1..=MAX_SIDE).contains(&width) => Ok(width),
        _ => Err(format!("it must be between 1 and {MAX_SIDE} pixels")),
    }
}

/// What clap says, without its usage block: the message and its tip.
fn one_line(text: &str) -> String {
    let told = text.split("\n\nUsage:").next().unwrap_or(text).split("\n\nFor more information").next().unwrap_or(text);
    let told = told.trim_start_matches("error: ");
    // Clap's own tip would be a flag that happens to look alike.
    let method = DECLARATIONS.iter().filter(|declaration| declaration.group == Group::Method);
    let parameter =
        method.map(|declaration| declaration.name.replace('_', "-")).find(|name| told.contains(&format!("'--{name}' found")));
    let told = match parameter {
        Some(name) => format!(
            "unexpected argument '--{name}' found: it is a parameter of the published method, --{PUBLISHED} {}=...",
            name.replace('-', "_")
        ),
        None => told.replace("\n\n  tip: ", "; "),
    };
    told.split_whitespace().collect::<Vec<_>>().join(" ") + " (see graphstipple --help)"
}

#[cfg(test)]
mod tests {
    use super::*;

    fn job(arguments: &str) -> Result<Job> {
        let words = "graphstipple photo.png -o out.svg".split(' ').chain(arguments.split_whitespace());
        Job::of(words.map(OsString::from).collect())
    }

    fn told(arguments: &str) -> String {
        let error = job(arguments).unwrap_err();
        assert_eq!(error.exit_code(), 2, "{arguments}");
        error.to_string()
    }

    /// A value that an option does not have by default, as a command line has it.
    fn another(declaration: &Declaration) -> String {
        let is_default = |text: &String| declaration.parse(text) != declaration.value(&Options::default());
        let texts: Vec<String> = match declaration.rule {
            Rule::Within(least, most) => vec![((least + most) / 4.0).to_string(), most.to_string()],
            Rule::UpTo(most) => vec![(most / 2.0).to_string()],
            Rule::Whole(least, most) => vec![(least + most.min(100) / 2).to_string()],
            Rule::Words(words) | Rule::WordsOrWithin(words, ..) => words.iter().map(|word| (*word).to_owned()).collect(),
            Rule::Color => vec!["#0aF01b".to_owned()],
            Rule::Switch => vec!["true".to_owned()],
        };
        texts.into_iter().find(is_default).expect("there is another value")
    }

    #[test]
    fn the_definition_is_sound() {
        command(false).debug_assert();
        command(true).debug_assert();
    }

    #[test]
    fn no_options_are_the_defaults_and_a_preset_is_where_others_begin() {
        let plain = job("").unwrap();
        assert_eq!(*plain.options, Options::default());
        assert!(matches!(plain.importance, Source::OfPhoto { name: "saliency", .. }));
        assert_eq!(*job("--preset paper").unwrap().options, Options::paper());
        assert_eq!(*job("--preset paper --relax 3").unwrap().options, Options { relax: 3, ..Options::paper() });
        let mut options = Options::paper();
        (options.published.k1, options.published.density) = (2.0, None);
        assert_eq!(*job("--preset paper --published k1=2 --published density=auto").unwrap().options, options);
        let importance = job("--importance constant:0.5").unwrap().importance;
        assert!(matches!(importance, Source::Constant(value) if value == 0.5));
    }

    #[test]
    fn every_option_arrives() {
        for declaration in DECLARATIONS {
            let text = another(declaration);
            let flag = declaration.name.replace('_', "-");
            let arguments = match (declaration.group, declaration.rule) {
                (Group::Method, _) => format!("--published {flag}={text}"),
                (_, Rule::Switch) => format!("--{flag}"),
                _ => format!("--{flag} {text}"),
            };
            let mut expected = Options::default();
            expected.set(&declaration.full_name(), &declaration.parse(&text)).unwrap();
            assert_eq!(*job(&arguments).unwrap().options, expected, "{arguments}");
            assert_ne!(expected, Options::default(), "{arguments}");
        }
        assert_eq!(job("--tone-tolerance off").unwrap().options.tone_tolerance, None);
        assert_eq!(job("--background #0aF01b").unwrap().options.background.rgb(), [10, 240, 27]);
    }

    #[test]
    fn a_preset_suggests_inks() {
        let writer = |arguments: &str| job(arguments).unwrap().writer;
        let with = |inks, style| Format::ALL[0].writer(Export { inks, style, ..Export::default() }.check().unwrap()).unwrap();
        assert_eq!(writer("--preset scratchboard"), with(Inks::White, Style::Flat));
        assert_eq!(writer("--preset scratchboard --inks both"), with(Inks::Both, Style::Flat));
        assert_eq!(writer("--preset scratchboard --style layered"), with(Inks::Black, Style::Layered));
    }

    #[test]
    fn what_the_output_is_written_with_arrives() {
        let plain = Format::of_suffix("svg").unwrap().writer(Export::default().check().unwrap()).unwrap();
        assert_eq!(job("").unwrap().writer, plain);
        let all = "photo.png -o out.png --style layered --inks both --one-bit --width 20cm --margin 5mm --page letter --dpi 600";
        let words = "graphstipple".split(' ').chain(all.split(' ')).chain(["--min-dot", "0.3mm"]);
        let found = Job::of(words.map(OsString::from).collect()).unwrap();
        let mut export = Export::default();
        for (name, text) in [("style", "layered"), ("inks", "both"), ("width", "20cm"), ("margin", "5mm"), ("page", "letter")] {
            export.set(name, &Value::Word(text.to_owned())).unwrap();
        }
        (export.one_bit, export.layout.dpi) = (true, Some(600.0));
        assert_eq!(found.writer, Format::of_suffix("png").unwrap().writer(export.check().unwrap()).unwrap());
        assert_eq!(found.min_dot, Some("0.3mm".parse().unwrap()));
    }

    #[test]
    fn what_is_wrong_is_told_by_the_flags_name() {
        for (arguments, message) in [
            ("--published detail-gain=-1", "--published detail_gain is -1, but it must be between 0 and 1000"),
            ("--published hops=x", "--published hops is \"x\", but it must be a whole number between 1 and 16 hops"),
            ("--gamma NaN", "--gamma is NaN, but it must be between 0.1 and 10"),
            ("--nodes many", "--nodes is \"many\", but it must be auto or a whole number between 3 and 1000000000 nodes"),
            (
                "--published alpha=1.5",
                "--published alpha is 1.5, but it must be \"tonal\", \"dynamic\" or a number between 0 and 1",
            ),
            ("--importance constant:2", "--importance is constant:2, but it must be constant:V with V above 0 and at most 1"),
            ("--stipple-min 2 --stipple-max 1", "--stipple-max is 1, but it must be at least --stipple-min"),
            ("--irregularity 1.1", "--irregularity is 1.1, but it must be between 0 and 1"),
            ("--width 0mm", "--width is 0mm, but it must be between 0.1mm and 100000mm"),
            ("--margin 1e9", "--margin is 1000000000px, but it must be between 0 and 100000mm"),
            ("--dpi 300", "--dpi is 300, but it must be left out unless the file is a .png: the others have no pixels"),
            ("--one-bit", "--one-bit is True, but it must be left out unless the file is a .png: the others have no pixels"),
            (
                "--style layered --inks white",
                "--inks is white, but it must be left out when style is layered: a layered drawing has both inks",
            ),
            ("--preview out.svg", "out.svg: the suffix of a preview must be .png"),
        ] {
            assert_eq!(told(arguments), message);
        }
        for unknown in ["k9=1", "k1", "=1"] {
            let message = told(&format!("--published {unknown}"));
            assert!(message.contains("NAME=VALUE with one of the names lattice, density"), "{message}");
        }
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
