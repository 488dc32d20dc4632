//! The command line as data: what may be given, the help that says so, and the core's options that it comes to.
//!
//! Every option of the core has one flag, in kebab case. Ranges are the core's: [`Options::validate`] judges them.

use std::path::{Path, PathBuf};

use clap::Parser;
use graphstipple_core::stages::{
    Alpha, Carry, Crossings, Inks, LatticeKind, Layout, Length, MAX_SIDE, Order, Page, Preset, Source, Style, parse_color,
};
use graphstipple_core::{Export, Options, presets};

use crate::error::{Error, Result};
use crate::files::{Format, is_same_file};

/// The path that stands for standard input or output.
const STANDARD: &str = "-";

/// Turns a photo into a black-and-white vector drawing of stipples and regions.
#[derive(Debug, Parser)]
#[command(name = "graphstipple", bin_name = "graphstipple", version, max_term_width = 120)]
pub(crate) struct Arguments {
    /// Image to draw: PNG, JPEG, TIFF or WebP; - reads standard input
    pub(crate) photo: PathBuf,

    /// File to write, .svg, .pdf, .eps, .dxf, .png or .json by its suffix; - writes SVG to standard output
    #[arg(short, long, value_name = "FILE", help_heading = "Output")]
    pub(crate) output: PathBuf,

    /// How a vector file expresses the picture: flat (disjoint areas with holes) or layered (black over white over black);
    /// default flat
    #[arg(long, value_name = "STYLE", value_parser = parse_style, help_heading = "Output")]
    style: Option<Style>,

    /// What a flat vector file is drawn with: black (on white paper), white (on black paper) or both; default black
    #[arg(long, value_name = "INKS", value_parser = parse_inks, help_heading = "Output")]
    inks: Option<Inks>,

    /// Write black and white alone to a .png, one bit a pixel, instead of grey edges
    #[arg(long, help_heading = "Output")]
    one_bit: bool,

    /// Also write a .png of the drawing
    #[arg(long, value_name = "FILE", help_heading = "Output")]
    pub(crate) preview: Option<PathBuf>,

    /// Width of the preview in pixels, 1 to 65535; default: the photo's
    #[arg(long, value_name = "PIXELS", value_parser = parse_width, requires = "preview", help_heading = "Output")]
    pub(crate) preview_width: Option<usize>,

    /// Print counts and times as JSON on standard output (on standard error when the SVG goes there)
    #[arg(long, help_heading = "Output")]
    pub(crate) stats: bool,

    /// Show no progress bar; without it there is one on a terminal, after a second of work
    #[arg(long, help_heading = "Output")]
    pub(crate) quiet: bool,

    /// Width of the drawing without margins: a number with mm, cm, in, pt or px (1/96 inch, in a .png a pixel), px by itself;
    /// default: as large as fits the page, or a px for each of the photo's pixels
    #[arg(long, value_name = "LENGTH", value_parser = parse_length, allow_hyphen_values = true, help_heading = "Size on paper")]
    width: Option<Length>,

    /// Empty paper on all four sides; default 0
    #[arg(long, value_name = "LENGTH", value_parser = parse_length, allow_hyphen_values = true, help_heading = "Size on paper")]
    margin: Option<Length>,

    /// Sheet with the drawing in its middle: A3, A4, A5, A6, letter, legal, tabloid (turned as the photo is), or a size such as
    /// 300x200mm; default: the drawing and its margins
    #[arg(long, value_name = "PAGE", value_parser = parse_page, help_heading = "Size on paper")]
    page: Option<Page>,

    /// Pixels per inch of a .png, 1 to 10000; default: 300 if the width or the page has another unit than px
    #[arg(long, value_name = "NUMBER", allow_negative_numbers = true, help_heading = "Size on paper")]
    dpi: Option<f64>,

    /// Least radius of a dot on paper: smaller dots are enlarged where that touches nothing, and dropped where it would;
    /// default: as they are
    #[arg(long, value_name = "LENGTH", value_parser = parse_length, allow_hyphen_values = true, help_heading = "Size on paper")]
    min_dot: Option<Length>,

    /// Start from the options of a preset, see --list-presets; other options change single ones; default default
    #[arg(long, value_name = "NAME", value_parser = parse_preset, help_heading = "Nodes")]
    preset: Option<Preset>,

    /// Print the presets and what they give, and do nothing else
    // Acted on before the arguments are parsed, since it needs no photo: here for the help.
    #[arg(long, help_heading = "Nodes")]
    list_presets: bool,

    /// Where detail is wanted: saliency, none (everywhere), constant:V with V above 0 to 1, or an image file (white is important);
    /// default saliency
    #[arg(long, value_name = "SOURCE", default_value = "saliency", hide_default_value = true, help_heading = "Nodes")]
    importance: String,

    /// First graph: hexagonal or square; default hexagonal
    #[arg(long, value_name = "KIND", value_parser = parse_lattice, help_heading = "Nodes")]
    lattice: Option<LatticeKind>,

    /// Lattice nodes per pixel, above 0 to 16; default: as fine as the node budget needs
    #[arg(long, value_name = "NUMBER", allow_negative_numbers = true, help_heading = "Nodes")]
    density: Option<f64>,

    /// Node budget: how many nodes to keep, at least 3; default: 0.3 per pixel and at most 300000, none with --density
    #[arg(long, value_name = "COUNT", help_heading = "Nodes")]
    nodes: Option<u64>,

    /// Node budget per pixel instead, above 0 to 16; default: see --nodes
    #[arg(long, value_name = "NUMBER", allow_negative_numbers = true, help_heading = "Nodes")]
    nodes_per_pixel: Option<f64>,

    /// Factor on the default node budget: below 1 larger shapes, above 1 finer ones, above 0 to 16; default 1
    #[arg(long, value_name = "FACTOR", allow_negative_numbers = true, help_heading = "Nodes")]
    fineness: Option<f64>,

    /// Share of the photo's own detail in the importance, against saliency (or against 1, with an image file), 0 to 1; default 0.95
    #[arg(long, value_name = "SHARE", allow_negative_numbers = true, help_heading = "Nodes")]
    detail: Option<f64>,

    /// Least importance, so that no part is left without nodes, 0 to 1; default 0.07
    #[arg(long, value_name = "SHARE", allow_negative_numbers = true, help_heading = "Nodes")]
    floor: Option<f64>,

    /// By how much less important black and white are than middle grey, 0 to 1; default 0.8
    #[arg(long, value_name = "SHARE", allow_negative_numbers = true, help_heading = "Nodes")]
    midtones: Option<f64>,

    /// Lloyd steps that even out the kept nodes, 0 to 100; default 1
    #[arg(long, value_name = "STEPS", help_heading = "Nodes")]
    relax: Option<u32>,

    /// Weight of the difference of values between two nodes, 0 to 1000; default 1
    #[arg(long, value_name = "NUMBER", allow_negative_numbers = true, help_heading = "Diffusion")]
    k1: Option<f64>,

    /// Weight of the distance between two nodes, per pixel, 0 to 1000; default 0.1
    #[arg(long, value_name = "NUMBER", allow_negative_numbers = true, help_heading = "Diffusion")]
    k2: Option<f64>,

    /// Tonal alpha in middle tones, or dynamic alpha where there is no detail, 0 to 1; default 0.15
    #[arg(long, value_name = "NUMBER", allow_negative_numbers = true, help_heading = "Diffusion")]
    base: Option<f64>,

    /// How much dynamic alpha grows with local detail (the paper's lambda), 0 to 1000; default 6
    #[arg(long, value_name = "NUMBER", allow_negative_numbers = true, help_heading = "Diffusion")]
    detail_gain: Option<f64>,

    /// Radius of the local mean in rings of the graph, 1 to 16; default 1
    #[arg(long, value_name = "RINGS", help_heading = "Diffusion")]
    rings: Option<u32>,

    /// Share of the error that is passed on when nodes are chosen by importance: 0 to 1, tonal or dynamic; default 1
    #[arg(long, value_name = "ALPHA", value_parser = parse_alpha, allow_negative_numbers = true, help_heading = "Diffusion")]
    importance_alpha: Option<Alpha>,

    /// Share of the error that is passed on when nodes become black or white: tonal (none at black and white), dynamic (the
    /// paper's), or 0 (threshold) to 1 (halftone); default tonal
    #[arg(long, value_name = "ALPHA", value_parser = parse_alpha, allow_negative_numbers = true, help_heading = "Diffusion")]
    alpha: Option<Alpha>,

    /// Order in which nodes are chosen by importance: rows (row by row) or global (one order by priority, the paper's); default rows
    #[arg(long, value_name = "ORDER", value_parser = parse_order, help_heading = "Diffusion")]
    importance_order: Option<Order>,

    /// Order in which nodes become black or white: rows or global, as above; global keeps more of the photo where `--refine` is 0;
    /// default rows
    #[arg(long, value_name = "ORDER", value_parser = parse_order, help_heading = "Diffusion")]
    order: Option<Order>,

    /// What is passed on: the error's value, or value times area of the node's cell; default area
    #[arg(long, value_name = "KIND", value_parser = parse_carry, help_heading = "Diffusion")]
    carry: Option<Carry>,

    /// Sweeps that refine the labels, at most, 0 to 100: 0 leaves them as the diffusion gave them, whatever their mean; default 12
    #[arg(long, value_name = "SWEEPS", allow_negative_numbers = true, help_heading = "Refinement")]
    refine: Option<u32>,

    /// Weight of a node's own tone: more makes crisper shapes, less keeps the tone of small parts, 0 to 100; default 1.9
    #[arg(long, value_name = "NUMBER", allow_negative_numbers = true, help_heading = "Refinement")]
    crispness: Option<f64>,

    /// Weight of the neighbours' labels: more makes larger shapes with smoother boundaries, 0 to 100; default 0.2
    #[arg(long, value_name = "NUMBER", allow_negative_numbers = true, help_heading = "Refinement")]
    cohesion: Option<f64>,

    /// Take apart dots that fused by chance, up to so many together, where there is room, 0 to 12; default 4
    #[arg(long, value_name = "NODES", allow_negative_numbers = true, help_heading = "Refinement")]
    split: Option<u32>,

    /// How far the drawing's mean may be from the tone's before the refinement moves it there, 0 to 1; off: as it comes; default 0.014
    #[arg(long, value_name = "NUMBER", value_parser = parse_tone_tolerance, allow_negative_numbers = true, help_heading = "Refinement")]
    tone_tolerance: Option<MaybeNumber>,

    /// Emphasis of details as fine as the nodes, 0 to 100; default 2.5
    #[arg(long, value_name = "AMOUNT", allow_negative_numbers = true, help_heading = "Tone")]
    sharpen: Option<f64>,

    /// Emphasis of details three times as coarse, 0 to 100; default 1.5
    #[arg(long, value_name = "AMOUNT", allow_negative_numbers = true, help_heading = "Tone")]
    local_contrast: Option<f64>,

    /// Where boundaries cross the edges between nodes: at their midpoint, or where the tone passes middle grey; default tone
    #[arg(long, value_name = "WHERE", value_parser = parse_crossings, help_heading = "Outlines")]
    crossings: Option<Crossings>,

    /// Area of a stipple relative to its node's cell, above 0 to 4; default 1
    #[arg(long, value_name = "NUMBER", allow_negative_numbers = true, help_heading = "Stipples")]
    stipple_scale: Option<f64>,

    /// Least radius of a stipple where there is room for it, in pixels, 0 to 1000; default 0
    #[arg(long, value_name = "PIXELS", allow_negative_numbers = true, help_heading = "Stipples")]
    stipple_min: Option<f64>,

    /// Largest radius of a stipple, in pixels, above 0 to 1000; default: as large as its cell asks for
    #[arg(long, value_name = "PIXELS", allow_negative_numbers = true, help_heading = "Stipples")]
    stipple_max: Option<f64>,

    /// How far stipples are from round, as if made by hand, 0 to 1; above 0 they are paths, counted as regions; default 0
    #[arg(long, value_name = "NUMBER", allow_negative_numbers = true, help_heading = "Stipples")]
    irregularity: Option<f64>,

    /// Which of the irregular shapes stipples have, 0 to 2^53; default 0
    #[arg(long, value_name = "NUMBER", help_heading = "Stipples")]
    seed: Option<u64>,

    /// How far curves may leave the boundaries that they smooth, in pixels, 0 (keep every point) to 2; default 0.5
    #[arg(long, value_name = "PIXELS", allow_negative_numbers = true, help_heading = "Outlines")]
    tolerance: Option<f64>,

    /// Take the tone in linear light: white then reflects as much light as the photo's grey on a screen
    #[arg(long, help_heading = "Tone")]
    linear: bool,

    /// Brightens above 1, darkens below, 0.1 to 10; default 1
    #[arg(long, value_name = "NUMBER", allow_negative_numbers = true, help_heading = "Tone")]
    gamma: Option<f64>,

    /// Factor on the tone's distance from middle grey, 0 to 10; default 1
    #[arg(long, value_name = "NUMBER", allow_negative_numbers = true, help_heading = "Tone")]
    contrast: Option<f64>,

    /// Swap black and white in the photo
    #[arg(long, help_heading = "Tone")]
    invert: bool,

    /// What shows through transparent parts of the photo: white, black, #rrggbb or #rgb; default white
    #[arg(long, value_name = "COLOR", help_heading = "Tone")]
    background: Option<String>,

    /// Worker threads, 1 to 1024; default: one per core. The drawing does not depend on it
    #[arg(long, value_name = "COUNT")]
    threads: Option<usize>,
}

/// Everything that a run needs, checked as far as it can be without reading a file.
#[derive(Debug, Clone)]
pub(crate) struct Job {
    /// `None` is standard input.
    pub(crate) photo: Option<PathBuf>,
    pub(crate) output: Output,
    pub(crate) preview: Option<(PathBuf, Option<usize>)>,
    pub(crate) importance: Source,
    pub(crate) options: Options,
    /// The options' background.
    pub(crate) background: [u8; 3],
    /// What the output is written with.
    pub(crate) export: Export,
    /// The least radius of a stipple on paper.
    pub(crate) min_dot: Option<Length>,
}

/// Where the drawing goes.
#[derive(Debug, Clone)]
pub(crate) enum Output {
    /// SVG on standard output.
    Standard,
    File {
        path: PathBuf,
        format: Format,
    },
}

impl Output {
    pub(crate) fn format(&self) -> Format {
        match self {
            Self::Standard => Format::Svg,
            Self::File { format, .. } => *format,
        }
    }
}

impl Arguments {
    /// What these arguments ask for.
    ///
    /// # Errors
    /// [`Error::Usage`] for the first rule that they break.
    pub(crate) fn job(&self) -> Result<Job> {
        let options = self.options();
        options.validate().map_err(in_flags)?;
        let background = parse_color(&options.background).map_err(in_flags)?;
        let importance = Source::parse(&self.importance).map_err(in_flags)?;
        let photo = (self.photo != Path::new(STANDARD)).then(|| self.photo.clone());
        let output = if self.output == Path::new(STANDARD) {
            Output::Standard
        } else {
            Output::File { format: Format::of_path(&self.output)?, path: self.output.clone() }
        };
        let export = self.export();
        output.format().check(&export).map_err(in_flags)?;
        if let Some(preview) = &self.preview {
            if Format::of_path(preview)? != Format::Png {
                return Err(Error::Usage(format!("{}: the suffix of a preview must be .png", preview.display())));
            }
            if *preview == self.output || is_same_file(preview, &self.output) {
                return Err(Error::Usage(format!("{}: the preview must be another file than the output", preview.display())));
            }
        }
        let mut sources: Vec<&Path> = photo.as_deref().into_iter().collect();
        if let Source::File(map) = &importance {
            sources.push(Path::new(map));
        }
        for written in [Some(&self.output), self.preview.as_ref()].into_iter().flatten() {
            if sources.iter().any(|source| is_same_file(written, source)) {
                return Err(Error::Usage(format!(
                    "{}: the drawing would replace an image that it is made from",
                    written.display()
                )));
            }
        }
        let preview = self.preview.clone().map(|path| (path, self.preview_width));
        Ok(Job { photo, output, preview, importance, options, background, export, min_dot: self.min_dot })
    }

    fn export(&self) -> Export {
        let style = self.style.unwrap_or_default();
        // A layered drawing has both inks, whatever the preset suggests.
        let suggested = self.preset.as_ref().filter(|_| style == Style::Flat).map(|preset| preset.inks);
        Export {
            style,
            inks: self.inks.or(suggested).unwrap_or_default(),
            layout: Layout { width: self.width, margin: self.margin.unwrap_or_default(), page: self.page, dpi: self.dpi },
            one_bit: self.one_bit,
        }
    }

    fn options(&self) -> Options {
        fn set<T>(option: &mut T, given: Option<T>) {
            if let Some(value) = given {
                *option = value;
            }
        }
        let mut options = self.preset.as_ref().map_or_else(Options::default, |preset| preset.options.clone());
        set(&mut options.lattice, self.lattice);
        set(&mut options.density, self.density.map(Some));
        set(&mut options.nodes, self.nodes.map(Some));
        set(&mut options.nodes_per_pixel, self.nodes_per_pixel.map(Some));
        set(&mut options.fineness, self.fineness);
        set(&mut options.detail, self.detail);
        set(&mut options.floor, self.floor);
        set(&mut options.midtones, self.midtones);
        set(&mut options.relax, self.relax);
        set(&mut options.k1, self.k1);
        set(&mut options.k2, self.k2);
        set(&mut options.base, self.base);
        set(&mut options.detail_gain, self.detail_gain);
        set(&mut options.rings, self.rings);
        set(&mut options.importance_alpha, self.importance_alpha);
        set(&mut options.alpha, self.alpha);
        set(&mut options.importance_order, self.importance_order);
        set(&mut options.order, self.order);
        set(&mut options.carry, self.carry);
        set(&mut options.tone_tolerance, self.tone_tolerance.map(|MaybeNumber(number)| number));
        set(&mut options.refine, self.refine);
        set(&mut options.crispness, self.crispness);
        set(&mut options.cohesion, self.cohesion);
        set(&mut options.split, self.split);
        set(&mut options.crossings, self.crossings);
        set(&mut options.sharpen, self.sharpen);
        set(&mut options.local_contrast, self.local_contrast);
        set(&mut options.stipple_scale, self.stipple_scale);
        set(&mut options.stipple_min, self.stipple_min);
        set(&mut options.stipple_max, self.stipple_max.map(Some));
        set(&mut options.irregularity, self.irregularity);
        set(&mut options.seed, self.seed);
        set(&mut options.tolerance, self.tolerance);
        set(&mut options.linear, self.linear.then_some(true));
        set(&mut options.gamma, self.gamma);
        set(&mut options.contrast, self.contrast);
        set(&mut options.invert, self.invert.then_some(true));
        set(&mut options.threads, self.threads.map(Some));
        set(&mut options.background, self.background.clone());
        options
    }
}

/// Names the flag instead of the core's option.
pub(crate) fn in_flags(error: graphstipple_core::Error) -> Error {
    match error {
        graphstipple_core::Error::Option { option, value, allowed } => {
            Error::Usage(format!("--{} is {value}, but it must be {allowed}", option.replace('_', "-")))
        }
        other => Error::Core(other),
    }
}

fn parse_width(text: &str) -> Result<usize, String> {
    match text.parse() {
        Ok(width) if (1..=MAX_SIDE).contains(&width) => Ok(width),
        _ => Err(format!("it must be between 1 and {} pixels", MAX_SIDE)),
    }
}

fn parse_length(text: &str) -> Result<Length, String> {
    text.parse().map_err(rule)
}

fn parse_page(text: &str) -> Result<Page, String> {
    text.parse().map_err(rule)
}

/// What is allowed: the flag and the value are told by the parser of the arguments.
fn rule(error: graphstipple_core::Error) -> String {
    match error {
        graphstipple_core::Error::Option { allowed, .. } => format!("it must be {allowed}"),
        other => other.to_string(),
    }
}

fn parse_preset(text: &str) -> Result<Preset, String> {
    presets::preset(text).map_err(rule)
}

fn parse_style(text: &str) -> Result<Style, String> {
    match text {
        "flat" => Ok(Style::Flat),
        "layered" => Ok(Style::Layered),
        _ => Err("it must be flat or layered".into()),
    }
}

fn parse_inks(text: &str) -> Result<Inks, String> {
    match text {
        "black" => Ok(Inks::Black),
        "white" => Ok(Inks::White),
        "both" => Ok(Inks::Both),
        _ => Err("it must be black, white or both".into()),
    }
}

fn parse_lattice(text: &str) -> Result<LatticeKind, String> {
    match text {
        "hexagonal" => Ok(LatticeKind::Hexagonal),
        "square" => Ok(LatticeKind::Square),
        _ => Err("it must be hexagonal or square".into()),
    }
}

fn parse_alpha(text: &str) -> Result<Alpha, String> {
    match text {
        "tonal" => Ok(Alpha::Tonal),
        "dynamic" => Ok(Alpha::Dynamic),
        _ => text.parse().map(Alpha::Constant).map_err(|_| "it must be tonal, dynamic or a number between 0 and 1".into()),
    }
}

fn parse_order(text: &str) -> Result<Order, String> {
    match text {
        "global" => Ok(Order::Global),
        "rows" => Ok(Order::Rows),
        _ => Err("it must be rows or global".into()),
    }
}

fn parse_carry(text: &str) -> Result<Carry, String> {
    match text {
        "value" => Ok(Carry::Value),
        "area" => Ok(Carry::Area),
        _ => Err("it must be value or area".into()),
    }
}

fn parse_crossings(text: &str) -> Result<Crossings, String> {
    match text {
        "midpoint" => Ok(Crossings::Midpoint),
        "tone" => Ok(Crossings::Tone),
        _ => Err("it must be midpoint or tone".into()),
    }
}

/// A number, or `off`.
#[derive(Debug, Clone, Copy)]
struct MaybeNumber(Option<f64>);

fn parse_tone_tolerance(text: &str) -> Result<MaybeNumber, String> {
    match text {
        "off" => Ok(MaybeNumber(None)),
        _ => text.parse().map(|number| MaybeNumber(Some(number))).map_err(|_| "it must be off or a number between 0 and 1".into()),
    }
}

#[cfg(test)]
mod tests {
    use clap::CommandFactory;

    use super::*;

    fn job(arguments: &str) -> Result<Job> {
        let words = ["graphstipple", "photo.png", "-o", "out.svg"].into_iter().chain(arguments.split_whitespace());
        Arguments::try_parse_from(words).unwrap().job()
    }

    #[test]
    fn the_definition_is_sound() {
        Arguments::command().debug_assert();
    }

    #[test]
    fn no_options_are_the_defaults_and_paper_is_the_papers() {
        let plain = job("").unwrap();
        assert_eq!((plain.options, plain.importance, plain.background), (Options::default(), Source::Saliency, [255; 3]));
        assert_eq!(job("--preset paper").unwrap().options, Options::paper());
        assert_eq!(job("--preset paper --relax 3").unwrap().options, Options { relax: 3, ..Options::paper() });
    }

    #[test]
    fn a_preset_suggests_inks() {
        let inks = |arguments| job(arguments).unwrap().export.inks;
        assert_eq!(inks("--preset scratchboard"), Inks::White);
        assert_eq!(inks("--preset scratchboard --inks both"), Inks::Both);
        assert_eq!(inks("--preset scratchboard --style layered"), Inks::Black);
    }

    #[test]
    fn every_option_arrives() {
        let all = "--lattice square --density 1.5 --nodes 60000 --fineness 2 --detail 0.7 --floor 0.1 --midtones 0.5 --relax 2 \
                   --k1 3 --k2 0.25 --base 0.75 --detail-gain 5 --rings 4 --importance-alpha 0.5 --importance-order global --alpha 1 --order global \
                   --carry value --refine 5 --crispness 3 --cohesion 0.5 --tone-tolerance off --split 3 --crossings midpoint --sharpen 3 --local-contrast 2 --stipple-scale 0.9 --stipple-min 0.5 \
                   --stipple-max 2 --irregularity 0.25 --seed 7 --tolerance 0.75 --linear --gamma 1.1 --contrast 1.2 --invert \
                   --threads 2 --background #0aF01b";
        let expected = Options {
            lattice: LatticeKind::Square,
            density: Some(1.5),
            nodes: Some(60_000),
            nodes_per_pixel: None,
            fineness: 2.0,
            detail: 0.7,
            floor: 0.1,
            midtones: 0.5,
            relax: 2,
            k1: 3.0,
            k2: 0.25,
            base: 0.75,
            detail_gain: 5.0,
            rings: 4,
            importance_alpha: Alpha::Constant(0.5),
            importance_order: Order::Global,
            alpha: Alpha::Constant(1.0),
            order: Order::Global,
            carry: Carry::Value,
            tone_tolerance: None,
            refine: 5,
            crispness: 3.0,
            cohesion: 0.5,
            split: 3,
            crossings: Crossings::Midpoint,
            sharpen: 3.0,
            local_contrast: 2.0,
            stipple_scale: 0.9,
            stipple_min: 0.5,
            stipple_max: Some(2.0),
            irregularity: 0.25,
            seed: 7,
            tolerance: 0.75,
            linear: true,
            gamma: 1.1,
            contrast: 1.2,
            invert: true,
            threads: Some(2),
            background: "#0aF01b".to_owned(),
        };
        assert_eq!(job(all).unwrap().options, expected);
        assert_eq!(job("--tone-tolerance 0.1").unwrap().options.tone_tolerance, Some(0.1));
        assert_eq!(job("--nodes-per-pixel 0.2").unwrap().options.nodes_per_pixel, Some(0.2));
        let job = job("--importance constant:0.5 --background #0aF01b").unwrap();
        assert_eq!((job.importance, job.background), (Source::Constant(0.5), [10, 240, 27]));
    }

    #[test]
    fn what_the_output_is_written_with_arrives() {
        assert_eq!(job("").unwrap().export, Export::default());
        let all =
            "-o out.png --style layered --inks both --one-bit --width 20cm --margin 5mm --page letter --dpi 600 --min-dot 0.3mm";
        let words = ["graphstipple", "photo.png"].into_iter().chain(all.split_whitespace());
        let found = Arguments::try_parse_from(words).unwrap().job().unwrap();
        let length = |text: &str| text.parse::<Length>().unwrap();
        let layout =
            Layout { width: Some(length("20cm")), margin: length("5mm"), page: Some("letter".parse().unwrap()), dpi: Some(600.0) };
        assert_eq!(found.export, Export { style: Style::Layered, inks: Inks::Both, layout, one_bit: true });
        assert_eq!(found.min_dot, Some(length("0.3mm")));
    }

    #[test]
    fn ranges_are_told_by_the_flags_name() {
        for (arguments, message) in [
            ("--detail-gain -1", "--detail-gain is -1, but it must be between 0 and 1000"),
            ("--gamma NaN", "--gamma is NaN, but it must be between 0.1 and 10"),
            ("--alpha 1.5", "--alpha is 1.5, but it must be \"tonal\", \"dynamic\" or a number between 0 and 1"),
            ("--importance constant:2", "--importance is constant:2, but it must be constant:V with V above 0 and at most 1"),
            ("--stipple-min 2 --stipple-max 1", "--stipple-max is 1, but it must be at least stipple_min"),
            ("--irregularity 1.1", "--irregularity is 1.1, but it must be between 0 and 1"),
            ("--width 0mm", "--width is 0mm, but it must be between 0.1mm and 100000mm"),
            ("--margin 1e9", "--margin is 1000000000px, but it must be between 0 and 100000mm"),
            ("--dpi 300", "--dpi is 300, but it must be left out unless the file is a .png: the others have no pixels"),
            ("--one-bit", "--one-bit is true, but it must be left out unless the file is a .png: the others have no pixels"),
            (
                "--style layered --inks white",
                "--inks is white, but it must be left out when style is layered: a layered drawing has both inks",
            ),
            ("--preview out.svg", "out.svg: the suffix of a preview must be .png"),
        ] {
            let error = job(arguments).unwrap_err();
            assert_eq!((error.to_string().as_str(), error.exit_code()), (message, 2));
        }
    }

    #[test]
    fn the_help_tells_every_option_with_its_default() {
        let command = Arguments::command();
        let serde_json::Value::Object(mut defaults) = serde_json::to_value(Options::default()).unwrap() else { panic!() };
        // Not part of the metadata, but an option all the same.
        defaults.insert("threads".into(), serde_json::Value::Null);
        for (name, value) in defaults {
            let argument = command.get_arguments().find(|a| a.get_id() == name.as_str()).unwrap_or_else(|| panic!("no --{name}"));
            assert_eq!(argument.get_long(), Some(name.replace('_', "-").as_str()));
            let help = argument.get_help().unwrap().to_string();
            let told = match value {
                serde_json::Value::Null => "default: ".to_owned(),
                serde_json::Value::Bool(false) => continue,
                serde_json::Value::String(word) => format!("default {word}"),
                number => format!("default {}", number.as_f64().unwrap()),
            };
            assert!(help.contains(&told), "the help of {name} does not say {told:?}: {help}");
        }
    }
}
