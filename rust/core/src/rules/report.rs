//! What breaks the rules, to be read by machines and looked at by people: as JSON, and as an SVG of the drawing with a mark at every
//! place.

use std::fmt::Write as _;

use kurbo::{BezPath, Point};
use serde::Serialize;
use serde_json::{Map, Value, json};

use crate::base::{Error, Result};
use crate::drawing::{Drawing, VERSION};
use crate::files::{Outline, Style};
use crate::offset::Polygon;
use crate::options::{Only, words};
use crate::rules::changes::Changes;
use crate::rules::rules::Rules;

words! {
    /// A file of a report.
    ReportFormat {
        /// For machines: [`Report::to_json`].
        Json = "json",
        /// For people: [`Report::to_svg`].
        Svg = "svg",
    }
}

impl ReportFormat {
    /// The suffixes of its files, as they are told.
    pub const SUFFIXES: &str = ".json or .svg";

    /// The format of a file's suffix, in upper or lower case.
    ///
    /// # Errors
    /// [`Error::Option`] with the suffixes that there are.
    pub fn of_suffix(suffix: &str) -> Result<Self> {
        let all = [Self::Json, Self::Svg];
        let found = all.into_iter().find(|format| format.name().eq_ignore_ascii_case(suffix));
        found.ok_or_else(|| Error::option("suffix", suffix, Self::SUFFIXES))
    }
}

/// What is wrong at a place.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Serialize)]
#[serde(rename_all = "lowercase")]
pub enum ViolationKind {
    /// Black is too narrow: a neck, a line, or a spike.
    Neck,
    /// White between black is too narrow.
    Gap,
    /// A dot is too small.
    Dot,
    /// A region is too small.
    Area,
    /// White falls out when the black is cut away.
    Island,
}

impl ViolationKind {
    /// All kinds, in the order of a report.
    pub const ALL: [Self; 5] = [Self::Neck, Self::Gap, Self::Dot, Self::Area, Self::Island];

    /// Its name in files.
    pub fn name(self) -> &'static str {
        match self {
            Self::Neck => "neck",
            Self::Gap => "gap",
            Self::Dot => "dot",
            Self::Area => "area",
            Self::Island => "island",
        }
    }

    /// What so many of it are called.
    pub fn counted(self, count: usize) -> &'static str {
        if count == 1 { self.name() } else { self.told().0 }
    }

    /// What several of it are called, and what each is told to be.
    fn told(self) -> (&'static str, &'static str) {
        match self {
            Self::Neck => ("necks", "black is too narrow"),
            Self::Gap => ("gaps", "white is too narrow"),
            Self::Dot => ("dots", "the dot is too small"),
            Self::Area => ("areas", "the region is too small"),
            Self::Island => ("islands", "it falls out of the sheet"),
        }
    }

    /// mm or mm^2.
    fn unit(self) -> &'static str {
        match self {
            Self::Neck | Self::Gap | Self::Dot => "mm",
            Self::Area | Self::Island => "mm\u{b2}",
        }
    }

    /// Colours that all eyes tell apart (Okabe and Ito, 2008).
    fn colour(self) -> &'static str {
        match self {
            Self::Neck => "#d55e00",
            Self::Gap => "#0072b2",
            Self::Dot => "#e69f00",
            Self::Area => "#cc79a7",
            Self::Island => "#009e73",
        }
    }
}

/// What a mark shows.
#[derive(Debug, Clone, PartialEq)]
pub(super) enum Shape {
    /// In mm.
    Area(Polygon),
    /// In pixels of the canvas.
    Region(BezPath),
    /// A radius in mm.
    Circle(f64),
    /// From one place to another, in mm.
    Way([[f64; 2]; 2]),
}

/// A place where a rule is broken.
#[derive(Debug, Clone, PartialEq)]
pub struct Violation {
    /// What is wrong.
    pub kind: ViolationKind,
    /// Where, in mm from the drawing's top left.
    pub x: f64,
    /// Where, in mm from the drawing's top left.
    pub y: f64,
    /// How wide it is in mm, or how large in mm^2: a neck and a gap where they are narrowest, a line where it is widest.
    pub measured: f64,
    /// What it must be at least; of an island 0, since there may be none.
    pub limit: f64,
    /// How long it is in mm, roughly.
    pub length: f64,
    pub(super) shape: Shape,
}

/// Where a drawing breaks rules.
#[derive(Debug, Clone, PartialEq)]
pub struct Report {
    /// Width of the drawing in mm.
    pub width: f64,
    /// Height of the drawing in mm.
    pub height: f64,
    /// mm to a pixel of the canvas.
    pub(super) scale: f64,
    /// What was looked for.
    pub rules: Rules,
    /// By kind, then from the top down.
    pub violations: Vec<Violation>,
    /// What was done to the drawing before it was checked, if it was made to keep the rules.
    pub changes: Option<Changes>,
}

/// Marks of a kind in a picture; what is wrong at more places is wrong everywhere, and viewers would take long.
const MOST_MARKS: usize = 5000;

impl Report {
    /// How many violations of a kind there are.
    pub fn count(&self, kind: ViolationKind) -> usize {
        let first = self.violations.partition_point(|violation| violation.kind < kind);
        self.violations[first..].partition_point(|violation| violation.kind == kind)
    }

    /// The number of every kind by its name, those with none too.
    pub fn counts(&self) -> Map<String, Value> {
        ViolationKind::ALL.iter().map(|kind| (kind.name().to_owned(), self.count(*kind).into())).collect()
    }

    /// The bytes of its file.
    ///
    /// # Errors
    /// As [`Report::to_svg`].
    pub fn write(&self, format: ReportFormat, drawing: &Drawing) -> Result<Vec<u8>> {
        let text = match format {
            ReportFormat::Json => self.to_json(),
            ReportFormat::Svg => self.to_svg(drawing)?,
        };
        Ok(text.into_bytes())
    }

    /// The report as a JSON document: `width` and `height` in mm, `rules`, `counts` by kind, `changes`, and `violations`, each with
    /// `kind`, `x` and `y` in mm from the drawing's top left, `measured` and `limit` in mm or mm^2, and `length` in mm.
    pub fn to_json(&self) -> String {
        let rounded = |value: f64| (value * 1e4).round() / 1e4;
        let head = json!({
            "format": "graphstipple report",
            "version": VERSION,
            "width": rounded(self.width),
            "height": rounded(self.height),
            "rules": self.rules,
            "counts": self.counts(),
            "changes": self.changes,
        });
        let mut text = serde_json::to_string(&head).expect("plain values always serialize");
        text.truncate(text.len() - 1);
        text.push_str(",\"violations\":[");
        for (number, violation) in self.violations.iter().enumerate() {
            let [x, y, measured, limit, length] =
                [violation.x, violation.y, violation.measured, violation.limit, violation.length].map(rounded);
            let kind = violation.kind.name();
            let one = json!({"kind": kind, "x": x, "y": y, "measured": measured, "limit": limit, "length": length});
            text.push_str(if number == 0 { "\n" } else { ",\n" });
            text.push_str(&one.to_string());
        }
        text.push_str("\n]}\n");
        text
    }

    /// The drawing that was checked in grey, and over it a layer for every kind with a mark at each place that says what is wrong there.
    /// Under the drawing stands what was found.
    ///
    /// # Errors
    /// [`crate::Error::Input`] if it is another drawing, of another size.
    pub fn to_svg(&self, drawing: &Drawing) -> Result<String> {
        let [width, height] = [drawing.width, drawing.height].map(|side| side as f64 * self.scale);
        if (width - self.width).abs() + (height - self.height).abs() > 1e-6 {
            return Err(Error::Input("the report is not about a drawing of this size".to_owned()));
        }
        // Text and marks are readable however large the sheet is.
        let em = (0.5 * (width + height) / 50.0).max(0.1);
        let kinds: Vec<ViolationKind> = ViolationKind::ALL.into_iter().filter(|kind| self.count(*kind) > 0).collect();
        let legend = em * (1.6 * kinds.len().max(1) as f64 + 1.2);
        let number = |value: f64| format!("{}", (value * 1e3).round() / 1e3);
        let mut svg = format!(
            "<svg xmlns=\"http://www.w3.org/2000/svg\" xmlns:inkscape=\"http://www.inkscape.org/namespaces/inkscape\" \
             width=\"{0}mm\" height=\"{1}mm\" viewBox=\"0 0 {0} {1}\">\n<title>graphstipple report</title>\n\
             <rect width=\"{0}\" height=\"{1}\" fill=\"#fff\"/>\n",
            number(width),
            number(height + legend)
        );
        let group = |svg: &mut String, id: &str, label: &str, paint: &str| {
            let _ = writeln!(svg, "<g id=\"{id}\" inkscape:groupmode=\"layer\" inkscape:label=\"{label}\" {paint}>");
        };
        let scale = format!("transform=\"scale({})\"", self.scale);
        group(&mut svg, "drawing", "Drawing", &format!("fill=\"#c4c4c4\" {scale}"));
        for layer in drawing.layers(Style::Flat, &Only::default(), None)?.layers {
            for area in &layer.areas {
                match &area.exterior {
                    Outline::Circle { x, y, radius } => {
                        let _ = writeln!(svg, "<circle cx=\"{x}\" cy=\"{y}\" r=\"{radius}\"/>");
                    }
                    Outline::Path(path) => {
                        let holes = area.holes.iter().map(|hole| match hole {
                            Outline::Path(path) => path.to_svg(),
                            Outline::Circle { x, y, radius } => {
                                format!(
                                    "M{} {y}a{radius} {radius} 0 1 0 {d} 0a{radius} {radius} 0 1 0 -{d} 0Z",
                                    x - radius,
                                    d = 2.0 * radius
                                )
                            }
                        });
                        let holes: String = holes.collect();
                        let _ = writeln!(svg, "<path fill-rule=\"evenodd\" d=\"{}{holes}\"/>", path.to_svg());
                    }
                }
            }
        }
        svg.push_str("</g>\n");
        let frame = format!("fill=\"none\" stroke=\"#c4c4c4\" stroke-width=\"{}\"", number(0.05 * em));
        let _ = writeln!(svg, "<rect width=\"{}\" height=\"{}\" {frame}/>", number(width), number(height));
        for kind in &kinds {
            let mut of_kind: Vec<&Violation> = self.violations.iter().filter(|violation| violation.kind == *kind).collect();
            let count = of_kind.len();
            // The worst of them, if they are too many; in their order again.
            if count > MOST_MARKS {
                of_kind.sort_by(|a, b| a.measured.total_cmp(&b.measured));
                of_kind.truncate(MOST_MARKS);
            }
            let (several, _) = kind.told();
            let colour = kind.colour();
            let paint = format!("fill=\"{colour}\" stroke=\"{colour}\" stroke-width=\"{}\"", number(0.12 * em));
            group(&mut svg, several, &format!("{count} {several}"), &paint);
            for violation in of_kind {
                self.mark(&mut svg, violation, em, &number);
            }
            svg.push_str("</g>\n");
        }
        let text = format!("font-family=\"sans-serif\" font-size=\"{}\" fill=\"#222\"", number(em));
        group(&mut svg, "legend", "Legend", &text);
        let line = |k: usize| height + em * (1.6 * k as f64 + 1.8);
        for (k, kind) in kinds.iter().enumerate() {
            let y = line(k);
            let sentence = self.sentence(*kind);
            let _ = writeln!(
                svg,
                "<circle cx=\"{0}\" cy=\"{1}\" r=\"{2}\" fill=\"{3}\"/><text x=\"{4}\" y=\"{5}\">{sentence}</text>",
                number(em),
                number(y - 0.35 * em),
                number(0.45 * em),
                kind.colour(),
                number(2.0 * em),
                number(y)
            );
        }
        if kinds.is_empty() {
            let _ = writeln!(svg, "<text x=\"{}\" y=\"{}\">Nothing breaks the rules.</text>", number(em), number(line(0)));
        }
        svg.push_str("</g>\n</svg>\n");
        Ok(svg)
    }

    /// What was found of a kind, in a line.
    fn sentence(&self, kind: ViolationKind) -> String {
        let count = self.count(kind);
        let called = kind.counted(count);
        let first = self.violations.partition_point(|violation| violation.kind < kind);
        let of_kind = &self.violations[first..first + count];
        let least = of_kind.iter().map(|violation| violation.measured).fold(f64::INFINITY, f64::min);
        let unit = kind.unit();
        // Dots of each ink have a limit of their own.
        let limits = of_kind.iter().map(|violation| violation.limit);
        let [low, high] = limits.fold([f64::INFINITY, 0.0_f64], |[low, high], limit| [low.min(limit), high.max(limit)]);
        let limit = if low < high { format!("{} or {}", told(low), told(high)) } else { told(high) };
        let shown = if count > MOST_MARKS { format!(", the smallest {MOST_MARKS} of them marked") } else { String::new() };
        match kind {
            ViolationKind::Island => format!("{count} {called}, white that falls out{shown}"),
            _ => format!("{count} {called} below {limit} {unit}, down to {} {unit}{shown}", told(least)),
        }
    }

    fn mark(&self, svg: &mut String, violation: &Violation, em: f64, number: &dyn Fn(f64) -> String) {
        let Violation { kind, x, y, measured, limit, .. } = violation;
        let (_, sentence) = kind.told();
        let unit = kind.unit();
        let least = if *limit > 0.0 { format!(", at least {} {unit}", told(*limit)) } else { String::new() };
        let (width, place) = (told(*measured), format!("({x:.2}, {y:.2}) mm"));
        let _ = write!(svg, "<g><title>{}: {sentence}: {width} {unit}{least}, at {place}</title>", kind.name());
        let _ = match &violation.shape {
            Shape::Area(area) => {
                let rounded: Polygon =
                    area.iter().map(|ring| ring.iter().map(|p| p.map(|v| (v * 1e3).round() / 1e3)).collect()).collect();
                write!(svg, "<path stroke=\"none\" d=\"{}\"/>", path_of(&rounded).to_svg())
            }
            Shape::Region(path) => {
                write!(
                    svg,
                    "<path stroke=\"none\" fill-opacity=\"0.6\" transform=\"scale({})\" d=\"{}\"/>",
                    self.scale,
                    path.to_svg()
                )
            }
            Shape::Circle(radius) => {
                write!(svg, "<circle stroke=\"none\" cx=\"{}\" cy=\"{}\" r=\"{}\"/>", number(*x), number(*y), number(*radius))
            }
            Shape::Way([[a, b], [c, d]]) => {
                let [a, b, c, d] = [a, b, c, d].map(|v| number(*v));
                let width = number((0.4 * limit).max(0.02));
                write!(svg, "<path fill=\"none\" stroke-width=\"{width}\" d=\"M{a} {b}L{c} {d}\"/>")
            }
        };
        let radius = number((0.5 * em).max(0.75 * violation.length.min(3.0 * em)));
        let _ = writeln!(svg, "<circle fill=\"none\" cx=\"{}\" cy=\"{}\" r=\"{radius}\"/></g>", number(*x), number(*y));
    }
}

/// A width or an area as people are told of it.
fn told(value: f64) -> String {
    let digits = if value >= 10.0 { 10.0 } else { 1000.0 };
    format!("{}", (value * digits).round() / digits)
}

/// A polygon as a path.
fn path_of(area: &Polygon) -> BezPath {
    let mut path = BezPath::new();
    for ring in area {
        for (k, [x, y]) in ring.iter().enumerate() {
            let p = Point::new(*x, *y);
            if k == 0 {
                path.move_to(p);
            } else {
                path.line_to(p);
            }
        }
        path.close_path();
    }
    path
}
