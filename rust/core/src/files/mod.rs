//! A drawing as a file, and back. In: a [`Drawing`](crate::Drawing) and how it is to be written, an [`Export`]; out: SVG, PDF, EPS,
//! DXF, JSON or PNG; and drawings again, from SVG and JSON. Source: our own, after the specifications of the formats.
//!
//! Formats are one table, [`Format::ALL`]: whoever writes another one adds a line to it and the file that it names.

mod cubic;
mod dxf;
mod eps;
mod export;
mod fitting;
mod json;
mod layers;
mod layout;
mod load;
mod load_json;
mod load_svg;
mod pdf;
mod plates;
pub mod raster;
mod read_path;
mod registration;
mod sources;
mod strips;
mod strokes;
mod svg;
mod svgz;
mod trap;
mod write_path;

use std::borrow::Cow;

use crate::base::{Checked, Control, Error, Palette, Pool, Result, or_nearest};
use crate::drawing::{Drawing, Ring, RingPart};

pub(crate) use export::length;
pub use export::{Curves, Dots, Elements, Export, SETTINGS, Setting, named_length};
pub use layers::{Area, Ground, Layer, Layers, Outline, Style};
pub use layout::{Layout, Length, Page, PixelPlacement, Placement, Sheet, Unit};
pub use plates::Plate;
pub(crate) use svg::{INKSCAPE, NAMESPACE, escape, hexadecimal};

/// A format that drawings are written in. [`Format::ALL`] is the table of them: the suffix says which one a file has, and help,
/// messages, documentation and tests are driven by the rest.
#[derive(Debug, Clone, Copy)]
pub struct Format {
    /// Of files, in lower case and without its dot.
    pub suffix: &'static str,
    /// As people call it.
    pub name: &'static str,
    /// What a file of it holds, for whoever has to choose.
    pub holds: &'static str,
    /// The settings that it takes, by name: see [`SETTINGS`].
    pub settings: &'static [&'static str],
    /// Whether the drawing can have the size on paper, or in pixels, that is asked for.
    fits: fn(&Export, usize, usize) -> Result<()>,
    write: fn(&Drawing, &Export) -> Result<Vec<u8>>,
    /// Reads a drawing back from a file's bytes, where the format holds all of it.
    read: Option<Read>,
}

/// What reads a drawing back from the bytes of its file.
type Read = fn(&[u8], &Control) -> Result<Drawing>;

/// What every vector format takes.
const OF_VECTORS: &[&str] = &["style", "only", "paper", "trap", "registration_marks", "width", "margin", "page"];

/// What SVG takes.
const OF_SVG: &[&str] = &["style", "only", "paper", "elements", "dots", "trap", "registration_marks", "width", "margin", "page"];

impl Format {
    /// All formats.
    pub const ALL: &'static [Self] = &[
        Self {
            suffix: "svg",
            name: "SVG",
            holds: "curves and circles in named layers, with the options and the version",
            settings: OF_SVG,
            fits: fits_on_paper,
            write: |drawing, export| svg::to_svg(drawing, export).map(String::into_bytes),
            read: Some(load_svg::from_svg),
        },
        Self {
            suffix: "svgz",
            name: "compressed SVG",
            holds: "the SVG in a quarter to a half of its bytes",
            settings: OF_SVG,
            fits: fits_on_paper,
            write: svgz::to_svgz,
            read: Some(svgz::from_svgz),
        },
        Self {
            suffix: "pdf",
            name: "PDF",
            holds: "curves in named layers, one page",
            settings: OF_VECTORS,
            fits: fits_on_paper,
            write: pdf::to_pdf,
            read: None,
        },
        Self {
            suffix: "eps",
            name: "EPS",
            holds: "curves and circles as PostScript",
            settings: OF_VECTORS,
            fits: fits_on_paper,
            write: |drawing, export| eps::to_eps(drawing, export).map(String::into_bytes),
            read: None,
        },
        Self {
            suffix: "dxf",
            name: "DXF",
            holds: "closed polylines or splines, and circles, in millimetres, for cutters and CAD",
            settings: &["style", "only", "curves", "trap", "registration_marks", "width", "margin", "page"],
            fits: fits_on_paper,
            write: |drawing, export| dxf::to_dxf(drawing, export).map(String::into_bytes),
            read: None,
        },
        Self {
            suffix: "png",
            name: "PNG",
            holds: "grey pixels with smooth edges, or black and white ones",
            // Style and inks make a difference on coloured paper.
            settings: &["style", "only", "paper", "trap", "registration_marks", "width", "margin", "page", "dpi", "one_bit"],
            fits: raster::fits,
            write: raster::to_png,
            read: None,
        },
        Self {
            suffix: "json",
            name: "JSON",
            holds: "canvas, stipples, regions and curves as data, with the options and the version",
            settings: &[],
            fits: |_, _, _| Ok(()),
            write: |drawing, _| Ok(json::to_json(drawing).into_bytes()),
            read: Some(load_json::from_json),
        },
    ];

    /// The format of a suffix, in upper or lower case.
    ///
    /// # Errors
    /// [`Error::Option`] with the suffixes that there are.
    pub fn of_suffix(suffix: &str) -> Result<Self> {
        let found = Self::ALL.iter().find(|format| format.suffix.eq_ignore_ascii_case(suffix));
        found.copied().ok_or_else(|| {
            let all = Self::ALL.iter().map(|format| format.suffix);
            Error::option("suffix", suffix, or_nearest(&Self::suffixes(), suffix, all, |suffix| format!(".{suffix}")))
        })
    }

    /// All suffixes, for messages: `.svg, .pdf or .json`.
    pub fn suffixes() -> String {
        Self::listed(Self::ALL.iter())
    }

    /// The suffixes of those that can be read back, for messages.
    pub fn suffixes_to_load() -> String {
        Self::listed(Self::ALL.iter().filter(|format| format.read.is_some()))
    }

    fn listed<'a>(formats: impl Iterator<Item = &'a Self>) -> String {
        let suffixes: Vec<String> = formats.map(|format| format!(".{}", format.suffix)).collect();
        let (last, rest) = suffixes.split_last().expect("there are formats");
        if rest.is_empty() { last.clone() } else { format!("{} or {last}", rest.join(", ")) }
    }

    /// Whether a file of it gives the drawing back.
    pub fn can_be_read(self) -> bool {
        self.read.is_some()
    }

    /// Whether it is written as pixels.
    pub fn has_pixels(self) -> bool {
        self.settings.contains(&"dpi")
    }

    /// What writes drawings in this format as the export says.
    ///
    /// # Errors
    /// [`Error::Option`] for a setting that this format cannot have. What makes no difference to it is no error.
    pub fn writer(self, export: Checked<Export>) -> Result<Writer> {
        let others = SETTINGS.iter().filter(|setting| !self.settings.contains(&setting.name));
        let given = |setting: &'static Setting| Some((setting, setting.refused?(&export)?));
        if let Some((setting, value)) = others.filter_map(given).next() {
            let with = Self::listed(Self::ALL.iter().filter(|format| format.settings.contains(&setting.name)));
            let allowed = format!("left out unless the file is a {with}: the others have no pixels");
            return Err(Error::option(setting.name, value, allowed));
        }
        Ok(Writer { format: self, export })
    }
}

/// Formats are told apart by their suffixes.
impl PartialEq for Format {
    fn eq(&self, other: &Self) -> bool {
        self.suffix == other.suffix
    }
}

/// A format with what a drawing is to be written with.
#[derive(Debug, Clone, PartialEq)]
pub struct Writer {
    format: Format,
    export: Checked<Export>,
}

impl Writer {
    /// Whether a drawing on a canvas of `width` x `height` pixels can be written so: to be asked before the work is done.
    ///
    /// # Errors
    /// [`Error::Input`] if it does not fit its page, or would have too many pixels.
    pub fn check_size(&self, width: usize, height: usize) -> Result<()> {
        (self.format.fits)(&self.export, width, height)
    }

    /// Whether a drawing of this palette can be written so: to be asked before the work is done.
    ///
    /// # Errors
    /// [`Error::Option`] for an ink that is none of the palette's, for a style that its inks cannot have, and for a paper on which nothing
    /// would show.
    pub fn check_palette(&self, palette: &Palette) -> Result<()> {
        if self.format.settings.is_empty() { Ok(()) } else { self.export.check_palette(palette) }
    }

    /// A least radius of dots on paper, in pixels of the canvas.
    ///
    /// # Errors
    /// As [`Layout::least_radius`].
    pub fn least_radius(&self, min_dot: Length, width: usize, height: usize) -> Result<f64> {
        self.export.layout.least_radius(min_dot, width, height)
    }

    /// Width and height of the page, then those of the drawing on it, of a canvas of `width` x `height` pixels: in pixels for a format
    /// that has them, else in mm. `None` if the format has no size.
    ///
    /// # Errors
    /// As [`Writer::check_size`].
    pub fn sheet(&self, width: usize, height: usize) -> Result<Option<[f64; 4]>> {
        self.check_size(width, height)?;
        let layout = &self.export.layout;
        if self.format.has_pixels() {
            let PixelPlacement { page, drawing, .. } = layout.place_pixels(width, height)?;
            return Ok(Some([page[0], page[1], drawing[0], drawing[1]].map(|side| side as f64)));
        }
        if !self.format.settings.contains(&"width") {
            return Ok(None);
        }
        let Placement { scale, page, .. } = layout.place(width, height)?;
        let [across, down] = [width, height].map(|side| side as f64 * scale);
        Ok(Some([page[0], page[1], across, down].map(|points| points / 72.0 * 25.4)))
    }

    /// What whoever gets the drawing's file should know: one sentence, if there is something to say.
    pub fn warning(&self, drawing: &Drawing) -> Option<String> {
        let has_paths = !self.format.has_pixels() && self.format.settings.contains(&"style");
        has_paths.then(|| too_long(drawing)).flatten()
    }

    /// The bytes of a drawing's file. The same drawing always gives the same.
    ///
    /// # Errors
    /// As [`Writer::check_size`].
    pub fn write(&self, drawing: &Drawing) -> Result<Vec<u8>> {
        self.check_palette(&drawing.palette)?;
        let mut export = Cow::Borrowed(&*self.export);
        if export.paper.is_none()
            && !export.no_paper
            && let Some(paper) = drawing.given_paper()
        {
            export.to_mut().paper = Some(paper);
        }
        Pool::new(None).run(|| (self.format.write)(drawing, &export))
    }
}

/// Reads a drawing back from the bytes of a file that [`Writer::write`] made, of a format that holds all of it.
///
/// # Errors
/// [`Error::Input`] if they are something else, [`Error::Option`] if the format does not hold enough, [`Error::Cancelled`].
pub fn load(bytes: &[u8], format: Format, control: &Control) -> Result<Drawing> {
    let Some(read) = format.read else {
        return Err(Error::option("suffix", format!(".{}", format.suffix), Format::suffixes_to_load()));
    };
    Pool::new(None).run(|| read(bytes, control))
}

/// A file as text.
fn text_of(bytes: &[u8]) -> Result<&str> {
    std::str::from_utf8(bytes).map_err(|_| Error::Input("the file is not text in UTF-8".into()))
}

/// Points of a path that Illustrator takes; of a longer one it says nothing and leaves it out.
const MOST_POINTS: usize = 32_000;

/// A warning about the longest boundary, if programs leave paths of so many points out.
fn too_long(drawing: &Drawing) -> Option<String> {
    let points_of = |ring: &Ring| -> usize {
        let of_part = |part: &RingPart| match *part {
            RingPart::Curve { index, .. } => drawing.curves[index as usize].segments().count(),
            _ => 1,
        };
        ring.parts.iter().map(of_part).sum()
    };
    let rings = drawing.regions.iter().flat_map(|region| std::iter::once(&region.exterior).chain(&region.holes));
    let longest = rings.map(points_of).max().filter(|points| *points > MOST_POINTS)?;
    Some(format!(
        "a boundary has {longest} points, but Illustrator leaves out a path of more than {MOST_POINTS}: \
         draw with fewer nodes or a larger tolerance for it"
    ))
}

fn fits_on_paper(export: &Export, width: usize, height: usize) -> Result<()> {
    export.layout.place(width, height).map(|_| ())
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::options::Value;

    #[test]
    fn the_table_is_sound() {
        for (number, format) in Format::ALL.iter().enumerate() {
            assert!(Format::ALL[..number].iter().all(|other| other.suffix != format.suffix && other.holds != format.holds));
            assert_eq!(Format::of_suffix(&format.suffix.to_uppercase()).unwrap(), *format);
            for name in format.settings {
                assert!(SETTINGS.iter().any(|setting| setting.name == *name), "{name}");
            }
        }
        let suffixes = Format::suffixes();
        assert!(suffixes.starts_with(".svg, .svgz, ") && suffixes.ends_with(" or .json"), "{suffixes}");
        assert_eq!(suffixes.matches('.').count(), Format::ALL.len());
        let error = Format::of_suffix("gif").unwrap_err().to_string();
        assert_eq!(error, format!("suffix is gif, but it must be {suffixes}"));
        let error = Format::of_suffix("sgv").unwrap_err().to_string();
        assert_eq!(error, format!("suffix is sgv, but it must be {suffixes}; did you mean .svg?"));
    }

    #[test]
    fn only_pixels_have_a_resolution_and_bits() {
        let one_bit = Export { one_bit: true, ..Export::default() };
        let mut fine = Export::default();
        fine.layout.dpi = Some(600.0);
        for format in Format::ALL {
            let refused = |export: &Export| format.writer(export.clone().check().unwrap()).err().map(|error| error.to_string());
            let rule = "but it must be left out unless the file is a .png: the others have no pixels";
            let expected = |told: &str| (!format.has_pixels()).then(|| format!("{told}, {rule}"));
            assert_eq!(refused(&one_bit), expected("one_bit is True"));
            assert_eq!(refused(&fine), expected("dpi is 600"));
        }
    }

    #[test]
    fn a_boundary_that_programs_leave_out_is_told_of() {
        let told = |count: usize, suffix: &str| {
            let long = svg::samples::blob([300.0, 300.0], 200.0, count);
            let drawing = svg::samples::drawing(600, 600, vec![(long, 1)], &[]);
            let writer = Format::of_suffix(suffix).unwrap().writer(Export::default().check().unwrap()).unwrap();
            writer.warning(&drawing)
        };
        let sentence = "a boundary has 32001 points, but Illustrator leaves out a path of more than 32000: \
                        draw with fewer nodes or a larger tolerance for it";
        for format in Format::ALL {
            let has_paths = !format.has_pixels() && format.suffix != "json";
            assert_eq!(told(32_001, format.suffix), has_paths.then(|| sentence.to_owned()), "{}", format.suffix);
            assert_eq!(told(32_000, format.suffix), None);
        }
    }

    #[test]
    fn what_does_not_hold_a_drawing_is_not_loaded() {
        let error = load(b"", Format::of_suffix("dxf").unwrap(), &Control::new()).unwrap_err().to_string();
        assert_eq!(error, "suffix is .dxf, but it must be .svg, .svgz or .json");
        let error = load(b"\xff", Format::of_suffix("svg").unwrap(), &Control::new()).unwrap_err().to_string();
        assert_eq!(error, "the file is not text in UTF-8");
    }

    #[test]
    fn the_sheet_is_told_in_mm_or_in_pixels() {
        let sheet = |suffix: &str, settings: &[(&str, &str)]| {
            let mut export = Export::default();
            for (name, value) in settings {
                export.set(name, &Value::Word((*value).to_owned())).unwrap();
            }
            Format::of_suffix(suffix).unwrap().writer(export.check().unwrap()).unwrap().sheet(300, 200)
        };
        let near = |sides: [f64; 4], expected: [f64; 4]| (0..4).all(|i| (sides[i] - expected[i]).abs() < 1e-9);
        let on_a4 = sheet("pdf", &[("page", "A4"), ("margin", "10mm")]).unwrap().unwrap();
        assert!(near(on_a4, [297.0, 210.0, 277.0, 277.0 * 2.0 / 3.0]), "{on_a4:?}");
        assert!(near(sheet("svg", &[("width", "60mm"), ("margin", "5mm")]).unwrap().unwrap(), [70.0, 50.0, 60.0, 40.0]));
        assert_eq!(sheet("png", &[("width", "600px"), ("margin", "3px")]).unwrap(), Some([606.0, 406.0, 600.0, 400.0]));
        assert_eq!(sheet("json", &[]).unwrap(), None);
        assert!(sheet("svg", &[("page", "A6"), ("margin", "90mm")]).is_err());
    }
}
