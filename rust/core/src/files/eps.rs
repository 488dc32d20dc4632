//! A drawing as Encapsulated PostScript: filled paths of lines, cubic curves and arcs, for programs that take no PDF.
//!
//! Coordinates are whole units under one transform that also turns the y axis, and relative; operators have names of one letter,
//! and curves are [fitted](super::fitting) by fewer cubics. Only PostScript level 1 is used,
//! but for other inks than black and white, which are separations of level 2. Layers, which PostScript does not have, are told apart by `%%BeginObject` comments. The
//! nonzero rule fills: holes run against their exteriors. There are no dates, so the same drawing always gives the same bytes.
//!
//! What this module does not do: compress, and clip: nothing lies outside the canvas.

use crate::base::Result;
use crate::drawing::Drawing;
use crate::files::cubic::{self, Piece, Sizes};
use crate::files::export::Export;
use crate::files::fitting::with_few_cubics;
use crate::files::layers::{Area, Outline};
use crate::files::plates::{ALL, PROCESS};

/// A path is filled and another one begun after this many points, since old interpreters refuse paths of 1500. Areas are not split:
/// a single one may have more.
const PATH_POINTS: usize = 1000;

/// No line is longer, as the conventions for document structure ask.
const LINE_BYTES: usize = 255;

/// What the names stand for. Lines and curves are relative; `o` and `i` take centre and radius of a circle that is an outer or an
/// inner boundary: they move to its rightmost point first, so that no line leads there.
const PROLOG: &str = "\
%%BeginProlog
/graphstipple 8 dict def
graphstipple begin
/m {moveto} bind def
/l {rlineto} bind def
/c {rcurveto} bind def
/h {closepath} bind def
/f {fill} bind def
/o {dup 3 index add 2 index moveto 0 360 arc closepath} bind def
/i {dup 3 index add 2 index moveto 360 0 arcn closepath} bind def
end
%%EndProlog
";

/// The drawing as an EPS document.
///
/// # Errors
/// As [`super::layout::Layout::place`].
///
/// # Runtime
/// Linear in the number of coordinates.
pub(super) fn to_eps(drawing: &Drawing, export: &Export) -> Result<String> {
    let placement = export.layout.place(drawing.width, drawing.height)?;
    let units = cubic::units_per_pixel(drawing);
    let drawing = &with_few_cubics(drawing, units);
    let layers = export.layers_of(drawing, &placement)?;
    let separations = layers.separations(&drawing.palette);
    let [width, height] = placement.page;
    let elements: usize = drawing.curves.iter().map(|curve| curve.elements().len()).sum();
    let text = String::with_capacity(1024 + 30 * elements + 24 * drawing.stipples.len());
    let mut writer = Writer { text, line: 0, units, sizes: Sizes::default(), current: [0, 0] };
    let (whole_width, whole_height) = (width.ceil(), height.ceil());
    writer.text.push_str(&format!(
        "%!PS-Adobe-3.0 EPSF-3.0\n%%BoundingBox: 0 0 {whole_width} {whole_height}\n%%HiResBoundingBox: 0 0 {} {}\n\
         %%Creator: graphstipple {}\n%%LanguageLevel: {}\n%%DocumentData: Clean7Bit\n%%Pages: 1\n{}%%EndComments\n{PROLOG}\
         %%Page: 1 1\ngraphstipple begin\ngsave\n{} {} translate\n{} {} scale\n",
        decimal(width),
        decimal(height),
        env!("CARGO_PKG_VERSION"),
        if separations.is_empty() { 1 } else { 2 },
        told(&separations),
        decimal(placement.origin[0]),
        decimal(height - placement.origin[1]),
        placement.scale / units,
        -placement.scale / units,
    ));
    for ground in &layers.grounds {
        writer.begin(ground.label, &colour(ground.rgb));
        let sides = ground.rectangle([drawing.width, drawing.height], &placement);
        let [left, top, right, bottom] = sides.map(|v| v * units);
        let [left, top, across, down] = [left, top, right - left, bottom - top].map(decimal);
        writer.text.push_str(&format!("{left} {top} m {across} 0 l 0 {down} l -{across} 0 l h f\n%%EndObject\n"));
    }
    for layer in &layers.layers {
        let overprint = if layers.overprint { "true setoverprint\n" } else { "" };
        let paint = layer.separation(&drawing.palette).map_or_else(|| colour(layer.rgb), |name| separation(name, layer.rgb));
        writer.begin(&layer.label, &format!("{overprint}{paint}"));
        writer.fill(&layer.areas);
        writer.text.push_str("%%EndObject\n");
    }
    writer.text.push_str("grestore\nend\nshowpage\n%%Trailer\n%%EOF\n");
    Ok(writer.text)
}

/// A length in points or units, short and exact enough for a box.
fn decimal(length: f64) -> f64 {
    (length * 1e4).round() / 1e4 + 0.0
}

/// A value of 8 bits as a part of the whole.
fn share(value: u8) -> f64 {
    decimal(f64::from(value) / 255.0)
}

/// Sets a colour, as grey where it is one.
fn colour(rgb: [u8; 3]) -> String {
    let [red, green, blue] = rgb.map(share);
    if red == green && green == blue { format!("{red} setgray") } else { format!("{red} {green} {blue} setrgbcolor") }
}

/// Sets the full tint of a separation; where there is none, this colour stands for it.
fn separation(name: &str, rgb: [u8; 3]) -> String {
    let [red, green, blue] = rgb.map(|value| decimal(share(value) - 1.0));
    let tint = format!("dup {red} mul 1 add exch dup {green} mul 1 add exch {blue} mul 1 add");
    format!("[/Separation ({name}) cvn /DeviceRGB {{{tint}}}] setcolorspace 1 setcolor")
}

/// The comments that tell of separations.
fn told(separations: &[(&str, [u8; 3])]) -> String {
    type Named<'a> = Vec<(&'a str, [u8; 3])>;
    let inks = separations.iter().copied().filter(|(name, _)| *name != ALL);
    let (of_press, spots): (Named<'_>, Named<'_>) = inks.partition(|(name, _)| PROCESS.contains(name));
    let of_press: Vec<&str> = of_press.into_iter().map(|(name, _)| name).collect();
    let of_press = (!of_press.is_empty()).then(|| format!("%%DocumentProcessColors: {}\n", of_press.join(" ")));
    let names = spots.iter().enumerate().map(|(place, (name, _))| {
        let keyword = if place == 0 { "%%DocumentCustomColors:" } else { "%%+" };
        format!("{keyword} ({name})\n")
    });
    let colours = spots.iter().enumerate().map(|(place, (name, rgb))| {
        let keyword = if place == 0 { "%%RGBCustomColor:" } else { "%%+" };
        let [red, green, blue] = rgb.map(share);
        format!("{keyword} {red} {green} {blue} ({name})\n")
    });
    of_press.into_iter().chain(names).chain(colours).collect()
}

/// Writes words separated by spaces, and line ends where a line would become too long.
struct Writer {
    text: String,
    /// Bytes on the current line.
    line: usize,
    /// Units to a pixel.
    units: f64,
    sizes: Sizes,
    /// The point that numbers are relative to.
    current: [i32; 2],
}

impl Writer {
    fn begin(&mut self, label: &str, paint: &str) {
        self.text.push_str(&format!("%%BeginObject: {label}\n{paint}\n"));
    }

    fn fill(&mut self, areas: &[Area]) {
        let mut points = 0;
        for (i, area) in areas.iter().enumerate() {
            points += self.outline(&area.exterior, "o");
            for hole in &area.holes {
                points += self.outline(hole, "i");
            }
            if points >= PATH_POINTS || i + 1 == areas.len() {
                self.word("f");
                self.end_line();
                points = 0;
            }
        }
    }

    /// Adds an outline to the path; returns its number of points.
    fn outline(&mut self, outline: &Outline, circle: &str) -> usize {
        match *outline {
            Outline::Circle { x, y, radius } => {
                let radius = self.sizes.radius(radius) * self.units;
                for number in [(x * self.units).round(), (y * self.units).round(), radius] {
                    self.word(&number.to_string());
                }
                self.word(circle);
                // An interpreter makes a circle of four curves.
                13
            }
            Outline::Path(ref path) => {
                let mut points = 0;
                cubic::for_each_piece(path, self.units, |piece| match piece {
                    Piece::Move(p) => {
                        points += 1;
                        self.current = [0, 0];
                        self.relative(&[p], "m");
                    }
                    Piece::Line(p) => {
                        points += 1;
                        self.relative(&[p], "l");
                    }
                    Piece::Curve(controls) => {
                        points += 3;
                        self.relative(&controls, "c");
                    }
                    Piece::Close => self.word("h"),
                });
                points
            }
        }
    }

    /// Points relative to the current one, and an operator that leads to the last of them.
    fn relative(&mut self, points: &[[i32; 2]], operator: &str) {
        for [x, y] in points {
            self.word(&(x - self.current[0]).to_string());
            self.word(&(y - self.current[1]).to_string());
        }
        self.current = points[points.len() - 1];
        self.word(operator);
    }

    fn word(&mut self, word: &str) {
        if self.line > 0 {
            // The line end itself is a byte.
            if self.line + 1 + word.len() >= LINE_BYTES {
                self.end_line();
            } else {
                self.text.push(' ');
                self.line += 1;
            }
        }
        self.text.push_str(word);
        self.line += word.len();
    }

    fn end_line(&mut self) {
        self.text.push('\n');
        self.line = 0;
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::files::layers::Style;
    use crate::files::layout::Layout;
    use crate::files::svg::samples;
    use crate::options::Only;

    fn words(text: &str, word: &str) -> usize {
        let body = &text[text.find("%%EndProlog").unwrap()..];
        body.split_ascii_whitespace().filter(|w| *w == word).count()
    }

    #[test]
    fn the_document_has_its_comments_and_marks() {
        let drawing = samples::nested();
        let text = to_eps(&drawing, &Export::default()).unwrap();
        assert_eq!(text, to_eps(&drawing, &Export::default()).unwrap());
        let units = cubic::units_per_pixel(&drawing);
        let head = "%!PS-Adobe-3.0 EPSF-3.0\n%%BoundingBox: 0 0 48 36\n%%HiResBoundingBox: 0 0 48 36\n%%Creator: graphstipple ";
        assert!(text.starts_with(head), "{text}");
        assert!(
            text.contains(&format!("\n0 36 translate\n{0} -{0} scale\n%%BeginObject: Black regions\n0 setgray\n", 0.75 / units)),
            "{text}"
        );
        assert!(text.contains("%%BeginObject: Black stipples") && !text.contains("White") && !text.contains("Date"));
        assert!(text.ends_with("%%EndObject\ngrestore\nend\nshowpage\n%%Trailer\n%%EOF\n"));
        let curves: usize = [0, 2].map(|i| drawing.curves[i].segments().count()).iter().sum();
        assert_eq!((words(&text, "o"), words(&text, "f")), (4, 2));
        assert!((1..=curves).contains(&words(&text, "c")), "{text}");
        assert_eq!((words(&text, "m"), words(&text, "h")), (2, 2));
    }

    #[test]
    fn circles_in_holes_run_backwards() {
        let mut drawing = samples::nested();
        let stipple = crate::drawing::RingPart::Stipple { index: 0 };
        drawing.regions[1].holes.push(crate::drawing::Ring { parts: vec![stipple] });
        let text = to_eps(&drawing, &Export { only: Only::named(&["white"]), ..Export::default() }).unwrap();
        let units = cubic::units_per_pixel(&drawing);
        let [x, y] = [15.7, 23.9].map(|v: f64| (v * units).round());
        let circle = text.lines().find(|line| line.ends_with(" i f")).unwrap().to_owned();
        let numbers: Vec<f64> = circle.split(' ').filter_map(|word| word.parse().ok()).collect();
        let [.., their_x, their_y, radius] = numbers[..] else { panic!("{circle}") };
        assert_eq!([their_x, their_y], [x, y]);
        assert!((radius / units / 2.35 - 1.0).abs() < 0.008, "{radius}");
        let (right, bottom) = (64.0 * units, 48.0 * units);
        let paper = format!("%%BeginObject: Paper\n0 setgray\n0 0 m {right} 0 l 0 {bottom} l -{right} 0 l h f\n%%EndObject\n");
        assert!(text.contains(&paper), "{text}");
    }

    #[test]
    fn a_paper_covers_the_page_and_both_inks_lie_on_black() {
        let layout = Layout { margin: "8px".parse().unwrap(), ..Layout::default() };
        let paper = Some("#ff8000".parse().unwrap());
        let text =
            to_eps(&samples::nested(), &Export { layout, paper, only: Only::named(&["black", "white"]), ..Export::default() })
                .unwrap();
        let page = "-128 -128 m 1280 0 l 0 1024 l -1280 0 l h f\n%%EndObject\n";
        let canvas = "0 0 m 1024 0 l 0 768 l -1024 0 l h f\n%%EndObject\n";
        let expected = format!(
            "%%BeginObject: Paper\n1 0.502 0 setrgbcolor\n{page}%%BeginObject: Underlay\n0 setgray\n{canvas}%%BeginObject: Black"
        );
        assert!(text.contains(&expected), "{text}");
    }

    #[test]
    fn the_bounding_box_is_the_page() {
        let layout = Layout { width: Some("4in".parse().unwrap()), margin: "1.25mm".parse().unwrap(), ..Layout::default() };
        let text = to_eps(&samples::nested(), &Export { layout, style: Style::Layered, ..Export::default() }).unwrap();
        assert!(text.contains("%%BoundingBox: 0 0 296 224\n%%HiResBoundingBox: 0 0 295.0866 223.0866\n"), "{text}");
        assert!(
            text.contains(&format!("3.5433 219.5433 translate\n{0} -{0} scale", 4.5 / cubic::units_per_pixel(&samples::nested()))),
            "{text}"
        );
    }

    #[test]
    fn lines_and_paths_stay_short() {
        let text = to_eps(&samples::field_of_blobs(4000), &Export::default()).unwrap();
        assert!(text.lines().all(|line| line.len() < LINE_BYTES));
        assert!(text.is_ascii());
        let mut points = 0;
        for word in text[text.find("Black regions").unwrap()..].split_ascii_whitespace() {
            points += match word {
                "m" | "l" => 1,
                "c" => 3,
                "o" => 13,
                _ => 0,
            };
            if word == "f" {
                assert!(points < 1100, "{points}");
                points = 0;
            }
        }
        assert_eq!((words(&text, "m"), words(&text, "o")), (4000, 4000));
    }
}
