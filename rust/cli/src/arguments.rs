//! What the arguments of a command line come to: in, its words; out, a [`Job`], checked as far as it can be without reading a file.

use std::ffi::OsString;
use std::path::{Path, PathBuf};
use std::sync::Arc;

use clap::ArgMatches;
use graphstipple_core::stages::{
    Checked, DECLARATIONS, Group, KINDS, Length, Limits, MAX_PIXELS, Only, PUBLISHED, Preset, Reading, ReportFormat, Rule,
    SETTINGS, Source, Style, Value, Writer, named_length, preset, seconds, whole,
};
use graphstipple_core::{Export, Format, Options};

use crate::command::{STANDARD, command};
use crate::error::{Error, Result};
use crate::files::{Subject, format_of_path};
use crate::messages::{in_flags, usage};
use crate::plates::{self, check_is_for_none, is_for_each_ink};
use crate::plotter::Plotter;
use crate::rules::Keeper;
use crate::writing::is_same_file;

/// Everything that a run needs, checked as far as it can be without reading a file.
#[derive(Debug, Clone)]
pub(crate) struct Job {
    /// `None` is standard input.
    pub(crate) photo: Option<PathBuf>,
    /// `None` is SVG on standard output.
    pub(crate) output: Option<PathBuf>,
    /// Whether it is one for each ink.
    pub(crate) has_plates: bool,
    /// The files of the drawing, as far as their names are known.
    pub(crate) outputs: Vec<PathBuf>,
    /// Its format, and what it is written with.
    pub(crate) writer: Writer,
    /// What writes the same drawing in other formats.
    pub(crate) others: Vec<Writer>,
    /// A picture of it, and its width.
    pub(crate) preview: Option<(PathBuf, Option<usize>)>,
    pub(crate) importance: Source,
    /// Where the photo's subject comes from, if the rest is to step back.
    pub(crate) subject: Option<Subject>,
    /// The bytes of the map's file, where somebody has them already.
    pub(crate) map: Option<Arc<Vec<u8>>>,
    pub(crate) options: Checked<Options>,
    /// How the photo and a map are read.
    pub(crate) reading: Reading,
    /// The least radius of a stipple on paper.
    pub(crate) min_dot: Option<Length>,
    /// How large the drawing may be.
    pub(crate) limits: Limits,
    /// The rules that it is to keep.
    pub(crate) keeper: Option<Keeper>,
    /// What plots it, if a pen does.
    pub(crate) plotter: Option<Plotter>,
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
        let matches = matches(arguments)?;
        let output = matches.get_one::<PathBuf>("output").filter(|output| *output != Path::new(STANDARD));
        // What a pen draws has formats of its own; the size on paper is that of an SVG.
        let has_pen = matches.contains_id("pen");
        let format = output.filter(|_| !has_pen).map_or_else(|| Ok(Format::ALL[0]), |output| format_of_path(output))?;
        let job = Self::of_matches(&matches, &[format])?;
        job.check_paths(&job.outputs)?;
        Ok(job)
    }

    /// What these flags ask of any photo, written in these formats. What is about a file, as its limits are, is about the first of them.
    ///
    /// # Errors
    /// [`Error::Usage`] for the first rule that they break.
    pub(crate) fn of_flags(flags: Vec<OsString>, formats: &[Format]) -> Result<Self> {
        let begin = ["graphstipple", "--output", STANDARD].map(OsString::from);
        let end = ["--", STANDARD].map(OsString::from);
        Self::of_matches(&matches(begin.into_iter().chain(flags).chain(end).collect())?, formats)
    }

    fn of_matches(matches: &ArgMatches, formats: &[Format]) -> Result<Self> {
        let path = |name: &str| matches.get_one::<PathBuf>(name).cloned();
        let text = |name: &str| matches.get_one::<String>(name).map(String::as_str);
        let preset = text("preset").map(preset).transpose().map_err(in_flags)?;

        let options = options(matches, preset.as_ref()).and_then(Options::check).map_err(in_flags)?;
        let importance = Source::parse(text("importance").unwrap_or(KINDS[0].form)).map_err(in_flags)?;
        let subject = text("subject").map(Subject::parse).transpose().map_err(|error| match error {
            Error::Core(error) => in_flags(error),
            other => other,
        })?;
        if let (None, Some(backdrop)) = (&subject, text("backdrop")) {
            return Err(Error::Usage(format!(
                "--backdrop is {backdrop}, but it must be left out without a --subject, from which it steps back"
            )));
        }
        let photo = one_photo(matches)?.filter(|photo| photo != Path::new(STANDARD));
        let output = path("output").filter(|output| output != Path::new(STANDARD));
        // A preset knows of black and white alone.
        let suggesting = preset.as_ref().filter(|_| !options.wants_colour());
        let writer_of = |format: &Format| {
            let export = export(matches, suggesting, *format, formats).and_then(Export::check)?;
            format.writer(export)
        };
        let mut writers =
            formats.iter().map(writer_of).collect::<graphstipple_core::Result<Vec<_>>>().map_err(in_flags)?.into_iter();
        let Some(writer) = writers.next() else { return Err(Error::Usage("there is no format to write".to_owned())) };
        let others: Vec<Writer> = writers.collect();
        let has_plates = output.as_deref().map_or(Ok(false), is_for_each_ink)?;
        let mut outputs: Vec<PathBuf> = output.iter().cloned().collect();
        if has_plates {
            writer.check_plates().map_err(in_flags)?;
        }
        // Inks of a photo are known when it has been read.
        if options.extract_inks.is_none() {
            let palette = options.palette(|_| Vec::new()).map_err(in_flags)?;
            match &output {
                Some(path) if has_plates => outputs = plates::paths(path, &palette, &writer).map_err(in_flags)?,
                _ => {
                    let mut writers = [&writer].into_iter().chain(&others);
                    writers.try_for_each(|writer| writer.check_palette(&palette)).map_err(in_flags)?;
                }
            }
        }
        let min_dot = text("min_dot").map(|text| named_length("min_dot", &Value::Word(text.to_owned())));
        let min_dot = min_dot.transpose().map_err(in_flags)?;
        formats.iter().try_for_each(|format| check_units(matches, *format))?;
        let keeper = Keeper::of(matches, suggesting, min_dot)?;
        if keeper.is_some() && options.wants_colour() {
            return Err(Error::Usage(
                "rules are for one ink: draw with several, and keep rules for the plates one by one".to_owned(),
            ));
        }
        if has_plates && matches.contains_id("pen") {
            return Err(Error::Usage("{ink} must be left out with --pen: a plot has a layer for the pen of each ink".to_owned()));
        }
        let plotter = Plotter::of(matches, output.as_deref(), suggesting)?;
        let limits = limits(matches).map_err(in_flags)?;
        for (name, what) in [("preview", "preview"), ("check", "report")] {
            path(name).map_or(Ok(()), |path| check_is_for_none(&path, what))?;
        }
        let preview = path("preview").map(|path| (path, matches.get_one::<usize>("preview_width").copied()));
        let [stats, quiet, force] = ["stats", "quiet", "force"].map(|name| matches.get_flag(name));
        let reading = Reading {
            background: options.background.rgb(),
            max_pixels: matches.get_one("max_pixels").copied().unwrap_or(MAX_PIXELS),
            allow_damaged: matches.get_flag("allow_damaged"),
            options: Some(options.clone()),
            colour: options.wants_colour(),
        };
        Ok(Self {
            photo,
            output,
            has_plates,
            outputs,
            writer,
            others,
            preview,
            importance,
            subject,
            map: None,
            options,
            reading,
            min_dot,
            limits,
            keeper,
            plotter,
            stats,
            quiet,
            force,
        })
    }

    /// The file of the report.
    pub(crate) fn report(&self) -> Option<&(PathBuf, ReportFormat)> {
        self.keeper.as_ref()?.report.as_ref()
    }

    /// The files that it writes.
    pub(crate) fn paths_to_write(&self) -> impl Iterator<Item = &Path> {
        self.outputs.iter().map(PathBuf::as_path).chain(self.beside())
    }

    /// Those that are no drawing.
    fn beside(&self) -> impl Iterator<Item = &Path> {
        let report = self.report().map(|(path, _)| path.as_path());
        self.preview.iter().map(|preview| preview.0.as_path()).chain(report)
    }

    /// Checks that no file is written twice, or over what the drawing is made from; these are the drawing's own.
    pub(crate) fn check_paths(&self, outputs: &[PathBuf]) -> Result<()> {
        if let Some((preview, _)) = &self.preview {
            if !format_of_path(preview).is_ok_and(Format::has_pixels) {
                return Err(Error::Usage(format!("{}: the suffix of a preview must be .png", preview.display())));
            }
            if outputs.iter().any(|output| is_same_file(preview, output)) {
                return Err(Error::Usage(format!("{}: the preview must be another file than the output", preview.display())));
            }
        }
        if let Some((report, _)) = self.report() {
            let others = outputs.iter().chain(self.preview.iter().map(|preview| &preview.0));
            if others.into_iter().any(|other| is_same_file(report, other)) {
                return Err(Error::Usage(format!("{}: the report must be another file than the drawing", report.display())));
            }
        }
        let mut sources: Vec<&Path> = self.photo.as_deref().into_iter().collect();
        if let Source::File(map) = &self.importance {
            sources.push(Path::new(map));
        }
        if let Some(Subject::File(mask)) = &self.subject {
            sources.push(mask);
        }
        for written in outputs.iter().map(PathBuf::as_path).chain(self.beside()) {
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

/// The arguments, told apart.
fn matches(arguments: Vec<OsString>) -> Result<ArgMatches> {
    command(false).try_get_matches_from(arguments).map_err(|error| usage(&error))
}

/// The photo, of which there is one.
fn one_photo(matches: &ArgMatches) -> Result<Option<PathBuf>> {
    let photos: Vec<&PathBuf> = matches.get_many("photo").into_iter().flatten().collect();
    if photos.len() > 1 {
        let each = r#"for photo in *.jpg; do graphstipple "$photo" -o "${photo%.*}.svg"; done"#;
        return Err(Error::Usage(format!(
            "there are {} photos, but a run draws one; a shell draws all with: {each}",
            photos.len()
        )));
    }
    Ok(photos.first().map(|photo| photo.to_path_buf()))
}

/// Checks that lengths on paper have a unit: a number alone, which is px, was probably meant to be millimetres. In pixels, and without a
/// size, there is nothing else that it could be.
fn check_units(matches: &ArgMatches, format: Format) -> Result<()> {
    if format.has_pixels() || !format.settings.contains(&"width") {
        return Ok(());
    }
    for name in ["width", "margin", "page", "min_dot", "min_feature", "min_gap", "min_area", "pen", "pen_bleed", "trap"] {
        let Some(text) = matches.get_one::<String>(name).map(|text| text.trim()) else { continue };
        let is_bare = text.split(['x', 'X']).all(|side| side.trim().parse().is_ok_and(|number: f64| number != 0.0));
        if is_bare {
            let flag = name.replace('_', "-");
            let square = if name == "min_area" { "2" } else { "" };
            return Err(Error::Usage(format!(
                "--{flag} is {text}, but it must have a unit: {text}mm{square}, or {text}px{square} for pixels of 1/96 inch"
            )));
        }
    }
    Ok(())
}

/// How large the drawing may be, and how long its plot may take.
fn limits(matches: &ArgMatches) -> graphstipple_core::Result<Limits> {
    let max_seconds = matches.get_one::<String>("max_plot_time").map(|text| {
        let read = seconds(text).filter(|seconds| *seconds > 0);
        read.ok_or_else(|| graphstipple_core::Error::Option {
            option: "max_plot_time".to_owned(),
            value: text.clone(),
            allowed: "a time of at least a second, such as 2h, 90min or 1h30min".to_owned(),
        })
    });
    let given = |name: &str| matches.get_one::<String>(name);
    let bytes = given("max_bytes").map(|text| Value::Word(text.clone()));
    let points = given("max_points").map(|text| whole(text).map_or_else(|| Value::Word(text.clone()), Value::Whole));
    Ok(Limits { max_seconds: max_seconds.transpose()?, ..Limits::read(bytes.as_ref(), points.as_ref())? })
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

/// How a file of a format is written. What only pixels have is left out of others where one of the formats has pixels.
pub(crate) fn export(
    matches: &ArgMatches,
    preset: Option<&Preset>,
    format: Format,
    formats: &[Format],
) -> graphstipple_core::Result<Export> {
    let of_pixels = |name| Format::ALL.iter().filter(|it| it.settings.contains(&name)).all(|it| it.has_pixels());
    let is_for_another = |name| !format.has_pixels() && formats.iter().any(|it| it.has_pixels()) && of_pixels(name);
    let mut export = Export::default();
    for setting in SETTINGS.iter().filter(|setting| !is_for_another(setting.name)) {
        if setting.value_name.is_empty() {
            if matches.get_flag(setting.name) {
                export.set(setting.name, &Value::Switch(true))?;
            }
        } else if let Some(text) = matches.get_one::<String>(setting.name) {
            let number = (setting.value_name == "NUMBER").then(|| text.parse().ok().map(Value::Number)).flatten();
            export.set(setting.name, &number.unwrap_or_else(|| Value::Word(text.clone())))?;
        }
    }
    // A layered drawing has all inks, whatever the preset suggests.
    if export.style == Style::Flat && !matches.contains_id("only") {
        export.only = preset.map_or(Only::default(), |preset| preset.only.clone());
    }
    Ok(export)
}

#[cfg(test)]
mod tests {
    use graphstipple_core::stages::Declaration;

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
            Rule::Inks => vec!["#1d1d1b,pink=#ff48b0".to_owned()],
        };
        texts.into_iter().find(is_default).expect("there is another value")
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
            let mut expected = Options::default();
            let arguments = match (declaration.group, declaration.rule) {
                (Group::Method, _) => format!("--published {flag}={text}"),
                // Inks are laid over each other if there are some.
                _ if declaration.name == "overprint" => {
                    expected.set("extract_inks", &Value::Whole(3)).unwrap();
                    "--overprint --extract-inks 3".to_owned()
                }
                (_, Rule::Switch) => format!("--{flag}"),
                // It is behind a subject alone.
                _ if declaration.name == "backdrop" => format!("--{flag} {text} --subject mask.png"),
                _ => format!("--{flag} {text}"),
            };
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
        let with = |only, style| Format::ALL[0].writer(Export { only, style, ..Export::default() }.check().unwrap()).unwrap();
        assert_eq!(writer("--preset scratchboard"), with(Only::named(&["white"]), Style::Flat));
        assert_eq!(writer("--preset scratchboard --only black,white"), with(Only::named(&["black", "white"]), Style::Flat));
        assert_eq!(writer("--preset scratchboard --inks #f00,#00f"), with(Only::default(), Style::Flat));
        assert_eq!(writer("--preset scratchboard --style layered"), with(Only::default(), Style::Layered));
    }

    #[test]
    fn what_the_output_is_written_with_arrives() {
        let plain = Format::of_suffix("svg").unwrap().writer(Export::default().check().unwrap()).unwrap();
        assert_eq!(job("").unwrap().writer, plain);
        let all = "photo.png -o out.png --style layered --one-bit --width 20cm --margin 5mm --page letter --dpi 600";
        let words = "graphstipple".split(' ').chain(all.split(' ')).chain(["--min-dot", "0.3mm"]);
        let found = Job::of(words.map(OsString::from).collect()).unwrap();
        let mut export = Export::default();
        for (name, text) in [("style", "layered"), ("width", "20cm"), ("margin", "5mm"), ("page", "letter")] {
            export.set(name, &Value::Word(text.to_owned())).unwrap();
        }
        (export.one_bit, export.layout.dpi) = (true, Some(600.0));
        assert_eq!(found.writer, Format::of_suffix("png").unwrap().writer(export.check().unwrap()).unwrap());
        assert_eq!(found.min_dot, Some("0.3mm".parse().unwrap()));
    }

    #[test]
    fn whole_numbers_are_read_as_people_write_them() {
        for text in ["100000", "100_000", "1e5", "100k", "0.1M"] {
            assert_eq!(job(&format!("--nodes {text}")).unwrap().options.nodes, Some(100_000), "{text}");
        }
        let job = job("--preview p.png --preview-width 2k --max-pixels 20M --seed 1e9 --max-points 20k --max-bytes 0.1MB").unwrap();
        assert_eq!((job.preview.unwrap().1, job.reading.max_pixels, job.options.seed), (Some(2000), 20_000_000, 1_000_000_000));
        assert_eq!(job.limits, Limits { max_bytes: Some(100_000), max_points: Some(20_000), max_seconds: None });
    }

    #[test]
    fn lengths_on_paper_have_a_unit() {
        let told = |output: &str, arguments: &str| {
            let words = ["graphstipple", "photo.png", "-o", output].into_iter().chain(arguments.split_whitespace());
            Job::of(words.map(OsString::from).collect()).err().map(|error| error.to_string())
        };
        for (flag, value) in
            [("width", "200"), ("width", "1e2"), ("margin", "5"), ("min-dot", "0.3"), ("page", "300x200"), ("page", "3X2")]
        {
            let sentence = format!("--{flag} is {value}, but it must have a unit: {value}mm, or {value}px for pixels of 1/96 inch");
            for output in ["a.svg", "a.pdf", "a.eps", "a.dxf", "-"] {
                assert_eq!(told(output, &format!("--{flag} {value}")), Some(sentence.clone()), "{output}");
            }
            // Pixels are pixels, and data have no size.
            for output in ["a.png", "a.json"] {
                assert_eq!(told(output, &format!("--{flag} {value}")), None, "{output} --{flag} {value}");
            }
        }
        for fine in ["--width 200px", "--margin 0", "--margin 0.0", "--min-dot 0", "--page 300x200mm", "--page 12inx8", "--page A4"]
        {
            assert_eq!(told("a.svg", fine), None, "{fine}");
        }
        assert!(told("a.svg", "--width wide").unwrap().starts_with("--width is \"wide\", but it must be a number"));
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
            ("--nodes 1.0005k", "--nodes is \"1.0005k\", but it must be auto or a whole number between 3 and 1000000000 nodes"),
            (
                "--preset potrait",
                "--preset is potrait, but it must be default, paper, stipple, portrait, linocut, poster or scratchboard; did you mean portrait?",
            ),
            ("--style flatt", "--style is \"flatt\", but it must be \"flat\" or \"layered\"; did you mean \"flat\"?"),
            ("--presset poster", "unexpected argument '--presset' found; did you mean --preset? (see graphstipple --help)"),
            ("--sharpenn=2", "unexpected argument '--sharpenn' found; did you mean --sharpen? (see graphstipple --help)"),
            (
                "--k1=2",
                "unexpected argument '--k1' found: it is a parameter of the published method, --published k1=... (see graphstipple --help)",
            ),
            ("--engrave", "unexpected argument '--engrave' found (see graphstipple --help)"),
            (
                "other.jpg third.jpg",
                "there are 3 photos, but a run draws one; a shell draws all with: for photo in *.jpg; \
                 do graphstipple \"$photo\" -o \"${photo%.*}.svg\"; done",
            ),
            ("--max-points 0", "--max-points is 0, but it must be a whole number, at least 1"),
            (
                "--max-bytes many",
                "--max-bytes is \"many\", but it must be a number of bytes, at least 1, or one with a unit such as 100kB, 1MB or 100KiB",
            ),
            ("--width 0mm", "--width is 0mm, but it must be between 0.1mm and 100000mm"),
            ("--margin 1e9px", "--margin is 1000000000px, but it must be between 0 and 100000mm"),
            ("--dpi 300", "--dpi is 300, but it must be left out unless the file is a .png: the others have no pixels"),
            ("--one-bit", "--one-bit is True, but it must be left out unless the file is a .png: the others have no pixels"),
            (
                "--style layered --only white",
                "--only is white, but it must be left out when style is layered: a layered drawing has all inks",
            ),
            ("--preview out.svg", "out.svg: the suffix of a preview must be .png"),
            (
                "--preview-width 10",
                "the following required arguments were not provided: --preview <FILE> (see graphstipple --help)",
            ),
            (
                "--preview p.png --preview-width 0",
                "invalid value '0' for '--preview-width <PX>': it must be between 1 and 65535 pixels (see graphstipple --help)",
            ),
            ("--published density=inf", "--published density is inf, but it must be above 0 and at most 16 nodes per pixel"),
            (
                "--published density=two",
                "--published density is \"two\", but it must be auto or a number above 0 and at most 16 nodes per pixel",
            ),
            (
                "--density 1",
                "unexpected argument '--density' found: it is a parameter of the published method, --published density=... (see graphstipple --help)",
            ),
            ("--published k1=5000", "--published k1 is 5000, but it must be between 0 and 1000"),
            ("--published k1=x", "--published k1 is \"x\", but it must be a number between 0 and 1000"),
            (
                "--published alpha=dynamical",
                "--published alpha is \"dynamical\", but it must be \"tonal\", \"dynamic\" or a number between 0 and 1; did you mean \"dynamic\"?",
            ),
            (
                "--published lattice=hex",
                "--published lattice is \"hex\", but it must be \"hexagonal\" or \"square\"; did you mean \"hexagonal\"?",
            ),
            ("--relax 101", "--relax is 101, but it must be between 0 and 100 steps"),
            ("--tone-tolerance none", "--tone-tolerance is \"none\", but it must be off or a number between 0 and 1"),
            (
                "--nodes 1000 --nodes-per-pixel 0.2",
                "--nodes-per-pixel is 0.2, but it must be left out when nodes is given: the budget is one or the other",
            ),
            ("--threads 0", "--threads is 0, but it must be between 1 and 1024"),
            ("--background red", "--background is \"red\", but it must be white, black, #rrggbb or #rgb"),
            ("--importance constant:0", "--importance is constant:0, but it must be constant:V with V above 0 and at most 1"),
            ("--importance constant:nan", "--importance is constant:nan, but it must be constant:V with V above 0 and at most 1"),
            (
                "--inks red",
                "--inks is \"red\", but it must be colours with commas between them, each white, black, #rrggbb or #rgb, or name=colour with a name of a-z, 0-9 and -",
            ),
            (
                "--width -5",
                "--width is \"-5\", but it must be a number, at least 0, with mm, cm, in, pt or px (px when there is no unit), such as 200mm",
            ),
            (
                "--page A9",
                "--page is \"A9\", but it must be A3, A4, A5, A6, letter, legal, tabloid, or width x height such as 300x200mm",
            ),
        ] {
            assert_eq!(told(arguments), message);
        }
        let names: Vec<&str> = DECLARATIONS.iter().filter(|it| it.group == Group::Method).map(|it| it.name).collect();
        for unknown in ["k9=1", "k1", "=1", "gamma=1"] {
            let names = names.join(", ");
            let message = format!("--published is {unknown}, but it must be NAME=VALUE with one of the names {names}");
            assert_eq!(told(&format!("--published {unknown}")), message);
        }
    }
}
