//! Where the canvas lies on paper: lengths, pages, margins and resolution.
//!
//! A [`Layout`] is what the user asks for, as lengths with units; a [`Placement`] is what it comes to for a canvas, in points (1/72
//! inch), and a [`PixelPlacement`] the same for a PNG, in pixels. Lengths and pages are written as text everywhere: `200mm`,
//! `12in x 8in`, `A4`. A number alone is px, which is 1/96 inch as in CSS and SVG.
//!
//! What this module does not do: draw anything; every writer asks it for the placement and draws the canvas there.

use std::fmt;
use std::str::FromStr;

use crate::base::{Error, Result};
use crate::photo::MAX_SIDE;

/// The longest side of a page or of a drawing in points: 100 m, more than any printer's roll.
const LONGEST: f64 = 100_000.0 * 72.0 / 25.4;

/// The shortest width of a drawing or side of a page in points: 0.1 mm, about the finest line that can be printed.
const SHORTEST: f64 = 0.1 * 72.0 / 25.4;

/// The same two for messages.
const SIZES: &str = "between 0.1mm and 100000mm";

/// What a PNG is painted at when a size on paper is given and no resolution is: what print shops ask for.
const PRINT_DPI: f64 = 300.0;

/// px to the inch.
pub(super) const PX_PER_INCH: f64 = 96.0;

/// Sizes may differ by this share before one counts as the larger: conversions between units round.
const ROUNDING: f64 = 1e-9;

/// A unit of length.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum Unit {
    /// Millimetre.
    Mm,
    /// Centimetre.
    Cm,
    /// Inch, 25.4 mm.
    In,
    /// Point, 1/72 inch.
    Pt,
    /// 1/96 inch; in a PNG whose size is given in px alone, a pixel.
    #[default]
    Px,
}

impl Unit {
    const ALL: [Self; 5] = [Self::Mm, Self::Cm, Self::In, Self::Pt, Self::Px];

    /// As it is written: `mm`, `cm`, `in`, `pt` or `px`.
    pub fn name(self) -> &'static str {
        match self {
            Self::Mm => "mm",
            Self::Cm => "cm",
            Self::In => "in",
            Self::Pt => "pt",
            Self::Px => "px",
        }
    }

    /// How many points it is.
    pub fn points(self) -> f64 {
        match self {
            Self::Mm => 72.0 / 25.4,
            Self::Cm => 72.0 / 2.54,
            Self::In => 72.0,
            Self::Pt => 1.0,
            Self::Px => 72.0 / PX_PER_INCH,
        }
    }
}

/// A length on paper, at least 0: `200mm`, `8.5in`, or a number alone, which is px.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct Length {
    /// How many of the unit.
    pub value: f64,
    /// The unit.
    pub unit: Unit,
}

impl Length {
    /// What is read as one, for messages.
    pub(crate) const ALLOWED: &str = "a number, at least 0, with mm, cm, in, pt or px (px when there is no unit), such as 200mm";

    /// The length in points.
    pub fn points(self) -> f64 {
        self.value * self.unit.points()
    }

    /// The length in mm.
    pub fn mm(self) -> f64 {
        self.points() / 72.0 * 25.4
    }
}

impl fmt::Display for Length {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{}{}", self.value, self.unit.name())
    }
}

impl FromStr for Length {
    type Err = Error;

    fn from_str(text: &str) -> Result<Self> {
        parse_number(text)
            .map(|(value, unit)| Self { value, unit: unit.unwrap_or_default() })
            .ok_or_else(|| Error::option("length", text.trim(), Self::ALLOWED))
    }
}

/// A finite number of at least 0, and its unit if it has one.
fn parse_number(text: &str) -> Option<(f64, Option<Unit>)> {
    let text = text.trim().to_ascii_lowercase();
    let unit = Unit::ALL.into_iter().find(|unit| text.ends_with(unit.name()));
    let number = unit.map_or(text.as_str(), |unit| text[..text.len() - unit.name().len()].trim_end());
    // Rust reads "inf" and "nan" as numbers.
    let value: f64 = number.parse().ok()?;
    // A minus before the zero would only show up again in messages.
    (value.is_finite() && value >= 0.0).then_some((value.abs(), unit))
}

/// A sheet that has a name.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Sheet {
    /// 297 x 420 mm.
    A3,
    /// 210 x 297 mm.
    A4,
    /// 148 x 210 mm.
    A5,
    /// 105 x 148 mm.
    A6,
    /// 8.5 x 11 in.
    Letter,
    /// 8.5 x 14 in.
    Legal,
    /// 11 x 17 in.
    Tabloid,
}

impl Sheet {
    /// All sheets.
    pub const ALL: [Self; 7] = [Self::A3, Self::A4, Self::A5, Self::A6, Self::Letter, Self::Legal, Self::Tabloid];

    /// As it is written.
    pub fn name(self) -> &'static str {
        match self {
            Self::A3 => "A3",
            Self::A4 => "A4",
            Self::A5 => "A5",
            Self::A6 => "A6",
            Self::Letter => "letter",
            Self::Legal => "legal",
            Self::Tabloid => "tabloid",
        }
    }

    /// Width and height, upright.
    fn size(self) -> [Length; 2] {
        let (width, height, unit) = match self {
            Self::A3 => (297.0, 420.0, Unit::Mm),
            Self::A4 => (210.0, 297.0, Unit::Mm),
            Self::A5 => (148.0, 210.0, Unit::Mm),
            Self::A6 => (105.0, 148.0, Unit::Mm),
            Self::Letter => (8.5, 11.0, Unit::In),
            Self::Legal => (8.5, 14.0, Unit::In),
            Self::Tabloid => (11.0, 17.0, Unit::In),
        };
        [Length { value: width, unit }, Length { value: height, unit }]
    }
}

/// The sheet that a drawing lies on.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Page {
    /// A sheet by its name, turned to landscape for a canvas that is wider than high.
    Sheet(Sheet),
    /// Width and height, taken as they are.
    Size(Length, Length),
}

impl Page {
    /// What is read as one, for messages.
    pub(crate) const ALLOWED: &str = "A3, A4, A5, A6, letter, legal, tabloid, or width x height such as 300x200mm";

    /// Width and height for a canvas of `width` x `height` pixels.
    fn size(self, width: usize, height: usize) -> [Length; 2] {
        match self {
            Self::Sheet(sheet) => {
                let [short, long] = sheet.size();
                if width > height { [long, short] } else { [short, long] }
            }
            Self::Size(width, height) => [width, height],
        }
    }
}

impl fmt::Display for Page {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Sheet(sheet) => f.write_str(sheet.name()),
            Self::Size(width, height) if width.unit == height.unit => write!(f, "{}x{height}", width.value),
            Self::Size(width, height) => write!(f, "{width}x{height}"),
        }
    }
}

impl FromStr for Page {
    type Err = Error;

    fn from_str(text: &str) -> Result<Self> {
        let text = text.trim();
        if let Some(sheet) = Sheet::ALL.into_iter().find(|sheet| sheet.name().eq_ignore_ascii_case(text)) {
            return Ok(Self::Sheet(sheet));
        }
        // The unit px has an x of its own, so each x is tried as the one between width and height.
        let parsed = text.match_indices(['x', 'X']).find_map(|(at, _)| {
            let ((width, first), (height, second)) = (parse_number(&text[..at])?, parse_number(&text[at + 1..])?);
            let second = second.unwrap_or(first.unwrap_or_default());
            Some(Self::Size(Length { value: width, unit: first.unwrap_or(second) }, Length { value: height, unit: second }))
        });
        parsed.ok_or_else(|| Error::option("page", text, Self::ALLOWED))
    }
}

/// The size on paper, and the resolution of pixels.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct Layout {
    /// Width of the drawing without margins, 0.1 mm to 100 m; the height follows. `None`: as large as fits the page, or without a
    /// page one px to a pixel of the canvas.
    pub width: Option<Length>,
    /// Empty paper on all four sides.
    pub margin: Length,
    /// The sheet, in whose middle the drawing lies. `None`: the drawing and its margins.
    pub page: Option<Page>,
    /// Pixels to the inch of a PNG, 1 to 10000. `None`: 300 where a width or page is given in other units than px.
    pub dpi: Option<f64>,
}

/// Where the canvas lies on its page.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Placement {
    /// Points (1/72 inch) to a pixel of the canvas.
    pub scale: f64,
    /// Width and height of the page in points.
    pub page: [f64; 2],
    /// The canvas's corner (0, 0) on the page, in points from the page's upper left corner.
    pub origin: [f64; 2],
}

/// Where the canvas lies on a PNG, in whole pixels.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct PixelPlacement {
    /// Width and height of the image.
    pub page: [usize; 2],
    /// Width and height of the drawing on it.
    pub drawing: [usize; 2],
    /// The drawing's upper left corner on the image.
    pub origin: [usize; 2],
    /// Pixels to the inch, if the file is to say so.
    pub dpi: Option<f64>,
}

/// What lengths are counted in, and how messages tell them.
struct Measure<'a> {
    /// A length as a number.
    of: &'a dyn Fn(Length) -> f64,
    /// The unit for messages, and how many of it one is.
    told: (&'static str, f64),
}

/// Sizes and positions in units of a [`Measure`].
struct Arrangement {
    drawing: [f64; 2],
    page: [f64; 2],
    origin: [f64; 2],
}

impl Layout {
    /// Checks every field by itself.
    ///
    /// # Errors
    /// [`Error::Option`] for the first field out of its range.
    pub fn validate(&self) -> Result<()> {
        let printable = |points: f64| (SHORTEST * (1.0 - ROUNDING)..=LONGEST * (1.0 + ROUNDING)).contains(&points);
        if let Some(width) = self.width.filter(|width| !printable(width.points())) {
            return Err(Error::option("width", width, SIZES));
        }
        if !(0.0..=LONGEST).contains(&self.margin.points()) {
            return Err(Error::option("margin", self.margin, "between 0 and 100000mm"));
        }
        if let Some(page @ Page::Size(width, height)) = self.page
            && !(printable(width.points()) && printable(height.points()))
        {
            return Err(Error::option("page", page, "between 0.1mm and 100000mm a side"));
        }
        if let Some(dpi) = self.dpi.filter(|dpi| !(1.0..=10_000.0).contains(dpi)) {
            return Err(Error::option("dpi", dpi, "between 1 and 10000 pixels per inch"));
        }
        Ok(())
    }

    /// Places a canvas of `width` x `height` pixels. Every field must keep its rule: see [`crate::Export::check`].
    ///
    /// # Errors
    /// [`Error::Input`] if the canvas is empty, the drawing does not fit its page inside the margins, or
    /// the page comes out longer than 100 m.
    pub fn place(&self, width: usize, height: usize) -> Result<Placement> {
        let measure = Measure { of: &Length::points, told: ("mm", 25.4 / 72.0) };
        let placed = self.arrange([width, height], Unit::Px.points(), &measure)?;
        if placed.page.iter().any(|side| *side > LONGEST * (1.0 + ROUNDING)) {
            return Err(Error::Input(format!(
                "the page would be {} mm, but a side may have at most 100000",
                size_in(placed.page, measure.told.1)
            )));
        }
        Ok(Placement { scale: placed.drawing[0] / width as f64, page: placed.page, origin: placed.origin })
    }

    /// Places a canvas of `width` x `height` pixels on a PNG.
    ///
    /// If all that is said of width and page is in px, a px is a pixel; other lengths (the margin's) are then taken at the
    /// resolution given, or 96 pixels to the inch. If the width or the page has another unit, everything is inches times the
    /// resolution.
    ///
    /// # Errors
    /// As [`Layout::place`]; [`Error::Input`] also if a side comes out at more than 65535 pixels. How many pixels there may be in
    /// all is for [`super::raster`] to say.
    pub fn place_pixels(&self, width: usize, height: usize) -> Result<PixelPlacement> {
        let in_px = |length: Length| length.unit == Unit::Px;
        let physical = self.width.is_some_and(|width| !in_px(width))
            || self.page.is_some_and(|page| !page.size(width, height).into_iter().all(in_px));
        let dpi = self.dpi.or(physical.then_some(PRINT_DPI));
        let per_inch = dpi.unwrap_or(PX_PER_INCH);
        let pixels = |length: Length| {
            if in_px(length) && !physical { length.value } else { length.points() / 72.0 * per_inch }
        };
        let told = if physical { ("mm", 25.4 / per_inch) } else { ("px", 1.0) };
        let placed = self.arrange([width, height], 1.0, &Measure { of: &pixels, told })?;
        if let Some(longest) = placed.page.into_iter().reduce(f64::max).filter(|longest| longest.round() > MAX_SIDE as f64) {
            return Err(Error::Input(format!(
                "the image would be {} pixels, but a side may have at most {MAX_SIDE}: {} is too long",
                size_in(placed.page, 1.0),
                longest.round()
            )));
        }
        let whole = |value: f64| value.round().max(1.0) as usize;
        let drawing_width = whole(placed.drawing[0]);
        // The height as the preview's, from the width in whole pixels.
        let mut drawing = [drawing_width, whole(height as f64 * drawing_width as f64 / width as f64)];
        let mut page = [0; 2];
        let mut origin = [0; 2];
        for axis in 0..2 {
            origin[axis] = placed.origin[axis].round() as usize;
            if self.page.is_some() {
                page[axis] = whole(placed.page[axis]);
                drawing[axis] = drawing[axis].min(page[axis]);
                origin[axis] = origin[axis].min(page[axis] - drawing[axis]);
            } else {
                page[axis] = drawing[axis] + 2 * origin[axis];
            }
        }
        Ok(PixelPlacement { page, drawing, origin, dpi })
    }

    /// The least radius of a stipple in pixels of a canvas of `width` x `height`, given as a length on paper.
    ///
    /// # Errors
    /// [`Error::Option`] if `min_dot` is above 1 m, and as [`Layout::place`].
    pub fn least_radius(&self, min_dot: Length, width: usize, height: usize) -> Result<f64> {
        if min_dot.points() > LONGEST / 100.0 {
            return Err(Error::option("min_dot", min_dot, "at most 1000mm"));
        }
        Ok(min_dot.points() / self.place(width, height)?.scale)
    }

    /// Millimetres to a pixel of a canvas of `width` x `height` pixels, for what can be said of a drawing on paper alone.
    ///
    /// # Errors
    /// [`Error::Input`] if there is neither a width nor a page, and as [`Layout::place`].
    pub fn mm_per_pixel(&self, width: usize, height: usize) -> Result<f64> {
        if self.width.is_none() && self.page.is_none() {
            return Err(Error::Input(
                "limits are lengths on paper, so the drawing needs a size: give a width or a page".to_owned(),
            ));
        }
        Ok(self.place(width, height)?.scale * 25.4 / 72.0)
    }

    /// Sizes and positions; `natural` is the size of a canvas pixel when neither width nor page is given.
    fn arrange(&self, canvas: [usize; 2], natural: f64, measure: &Measure<'_>) -> Result<Arrangement> {
        let [width, height] = canvas;
        if width == 0 || height == 0 {
            return Err(Error::Input(format!("the drawing is {width} x {height} pixels, but it must have at least one")));
        }
        let canvas = canvas.map(|side| side as f64);
        let margin = (measure.of)(self.margin);
        let given = self.width.map(|width| (measure.of)(width) / canvas[0]);
        let Some(sheet) = self.page else {
            let drawing = canvas.map(|side| side * given.unwrap_or(natural));
            return Ok(Arrangement { drawing, page: drawing.map(|side| side + 2.0 * margin), origin: [margin; 2] });
        };
        let page = sheet.size(width, height).map(|side| (measure.of)(side));
        let room = page.map(|side| side - 2.0 * margin);
        let (unit, factor) = measure.told;
        if room[0] <= 0.0 || room[1] <= 0.0 {
            return Err(Error::Input(format!(
                "the margin of {} leaves nothing of the page {sheet}: {} {unit}",
                self.margin,
                size_in(page, factor)
            )));
        }
        let scale = given.unwrap_or((room[0] / canvas[0]).min(room[1] / canvas[1]));
        let drawing = canvas.map(|side| side * scale);
        if (0..2).any(|axis| drawing[axis] > room[axis] * (1.0 + ROUNDING)) {
            return Err(Error::Input(format!(
                "the drawing would be {} {unit}, but the page {sheet} has room for {} {unit} inside its margins",
                size_in(drawing, factor),
                size_in(room, factor)
            )));
        }
        Ok(Arrangement { drawing, page, origin: [0, 1].map(|axis| (page[axis] - drawing[axis]) / 2.0) })
    }
}

/// Two sides for a message, to a hundredth and without trailing zeros.
fn size_in(sides: [f64; 2], factor: f64) -> String {
    let [width, height] = sides.map(|side| (side * factor * 100.0).round() / 100.0);
    format!("{width} x {height}")
}

#[cfg(test)]
mod tests {
    use super::*;

    fn length(text: &str) -> Length {
        text.parse().unwrap()
    }

    fn layout(width: &str, margin: &str, page: &str) -> Layout {
        Layout {
            width: (!width.is_empty()).then(|| length(width)),
            margin: length(margin),
            page: (!page.is_empty()).then(|| page.parse().unwrap()),
            dpi: None,
        }
    }

    fn close(a: [f64; 2], b: [f64; 2]) -> bool {
        a.iter().zip(b).all(|(a, b)| (a - b).abs() < 1e-9 * b.abs().max(1.0))
    }

    #[test]
    fn lengths_are_read_in_every_unit() {
        for (text, points, shown) in [
            ("1in", 72.0, "1in"),
            (" 2.54 CM ", 72.0, "2.54cm"),
            ("25.4mm", 72.0, "25.4mm"),
            ("72pt", 72.0, "72pt"),
            ("96", 72.0, "96px"),
            ("96 px", 72.0, "96px"),
            ("1e2pt", 100.0, "100pt"),
            ("-0", 0.0, "0px"),
        ] {
            let length = length(text);
            assert!((length.points() - points).abs() < 1e-9, "{text}");
            assert_eq!(length.to_string(), shown);
            assert_eq!(shown.parse::<Length>().unwrap(), length);
        }
        for text in ["", "mm", "-1mm", "1 m", "1ft", "inf", "infin", "nan", "nanpx", "1,5mm", "200 mm mm"] {
            let message = text.parse::<Length>().unwrap_err().to_string();
            assert!(message.starts_with(&format!("length is {text}, but it must be a number")), "{message}");
        }
    }

    #[test]
    fn pages_are_read_by_name_and_by_size() {
        for (text, shown) in [
            ("a4", "A4"),
            ("Letter", "letter"),
            ("300x200mm", "300x200mm"),
            ("12in x 8in", "12x8in"),
            ("12in x 20cm", "12inx20cm"),
            ("800x600", "800x600px"),
            ("800px X 600px", "800x600px"),
            ("800pxx600px", "800x600px"),
            ("12inx96px", "12inx96px"),
            ("12inx8", "12x8in"),
        ] {
            let page: Page = text.parse().unwrap();
            assert_eq!(page.to_string(), shown, "{text}");
            assert_eq!(shown.parse::<Page>().unwrap(), page);
        }
        for text in ["", "A7", "300mm", "x", "300xmm", "1x2x3", "-1x2mm", "px"] {
            let message = text.parse::<Page>().unwrap_err().to_string();
            assert!(message.starts_with(&format!("page is {text}, but it must be A3, A4")), "{message}");
        }
    }

    #[test]
    fn ranges_are_told() {
        for (layout, message) in [
            (layout("0mm", "0", ""), "width is 0mm, but it must be between 0.1mm and 100000mm"),
            (layout("1e9mm", "0", ""), "width is 1000000000mm, but it must be between 0.1mm and 100000mm"),
            (layout("", "101000mm", ""), "margin is 101000mm, but it must be between 0 and 100000mm"),
            (layout("", "0", "0x10mm"), "page is 0x10mm, but it must be between 0.1mm and 100000mm a side"),
            (Layout { dpi: Some(0.5), ..Layout::default() }, "dpi is 0.5, but it must be between 1 and 10000 pixels per inch"),
            (Layout { dpi: Some(f64::NAN), ..Layout::default() }, "dpi is NaN, but it must be between 1 and 10000 pixels per inch"),
        ] {
            assert_eq!(layout.validate().unwrap_err().to_string(), message);
        }
        layout("0.1mm", "0", "").validate().unwrap();
        layout("100000mm", "0", "").validate().unwrap();
    }

    #[test]
    fn without_a_page_the_page_is_the_drawing_and_its_margins() {
        let plain = Layout::default().place(400, 300).unwrap();
        assert_eq!(plain, Placement { scale: 0.75, page: [300.0, 225.0], origin: [0.0, 0.0] });
        let inches = layout("4in", "1in", "").place(400, 300).unwrap();
        assert!((inches.scale - 0.72).abs() < 1e-12);
        assert!(close(inches.page, [6.0 * 72.0, 5.0 * 72.0]) && close(inches.origin, [72.0, 72.0]), "{inches:?}");
        assert!(
            layout("100000mm", "1mm", "").place(4, 3).unwrap_err().to_string().starts_with("the page would be 100002 x 75002 mm")
        );
        assert!(Layout::default().place(0, 3).is_err());
    }

    #[test]
    fn a_page_holds_the_drawing_in_its_middle() {
        let mm = 72.0 / 25.4;
        let upright = layout("", "10mm", "A4").place(300, 400).unwrap();
        assert!(close(upright.page, [210.0 * mm, 297.0 * mm]), "{upright:?}");
        assert!((upright.scale - 190.0 / 300.0 * mm).abs() < 1e-9);
        assert!(close(upright.origin, [10.0 * mm, (297.0 - 190.0 * 4.0 / 3.0) / 2.0 * mm]), "{upright:?}");
        let landscape = layout("100mm", "10mm", "A4").place(400, 300).unwrap();
        assert!(close(landscape.page, [297.0 * mm, 210.0 * mm]));
        assert!(close(landscape.origin, [98.5 * mm, 67.5 * mm]), "{landscape:?}");
        // A size is taken as it is; a drawing exactly as wide as the room fits.
        let exact = layout("180mm", "1cm", "200x300mm").place(4000, 300).unwrap();
        assert!(close(exact.page, [200.0 * mm, 300.0 * mm]));
        for (layout, message) in [
            (
                layout("200mm", "10mm", "A4"),
                "the drawing would be 200 x 266.67 mm, but the page A4 has room for 190 x 277 mm inside its margins",
            ),
            (layout("", "10cm", "A5"), "the margin of 10cm leaves nothing of the page A5: 148 x 210 mm"),
        ] {
            assert_eq!(layout.place(300, 400).unwrap_err().to_string(), message);
            assert_eq!(layout.place_pixels(300, 400).unwrap_err().to_string(), message);
        }
    }

    #[test]
    fn a_sheet_is_turned_for_what_is_wider_than_high_alone() {
        let page = |width, height| layout("", "0", "A4").place(width, height).unwrap().page.map(|side| side * 25.4 / 72.0);
        assert!(close(page(101, 100), [297.0, 210.0]));
        assert!(close(page(100, 100), [210.0, 297.0]) && close(page(99, 100), [210.0, 297.0]));
    }

    #[test]
    fn millimetres_to_a_pixel_need_a_size() {
        let told = |layout: Layout| layout.mm_per_pixel(1000, 500);
        assert!((told(layout("200mm", "10mm", "")).unwrap() - 0.2).abs() < 1e-12);
        assert!((told(layout("", "10mm", "220x220mm")).unwrap() - 0.2).abs() < 1e-12);
        assert!(told(Layout::default()).unwrap_err().to_string().ends_with("so the drawing needs a size: give a width or a page"));
    }

    #[test]
    fn the_least_radius_follows_the_size_on_paper() {
        let radius = layout("200mm", "10mm", "").least_radius(length("0.3mm"), 1000, 10).unwrap();
        assert!((radius - 1.5).abs() < 1e-9, "{radius}");
        assert_eq!(Layout::default().least_radius(length("2"), 1000, 10).unwrap(), 2.0);
        let error = Layout::default().least_radius(length("2000mm"), 10, 10).unwrap_err();
        assert_eq!(error.to_string(), "min_dot is 2000mm, but it must be at most 1000mm");
    }

    #[test]
    fn px_are_pixels_of_a_png() {
        let of = |layout: Layout| layout.place_pixels(400, 300).unwrap();
        let plain = PixelPlacement { page: [400, 300], drawing: [400, 300], origin: [0, 0], dpi: None };
        assert_eq!(of(Layout::default()), plain);
        assert_eq!(of(Layout { dpi: Some(72.0), ..Layout::default() }), PixelPlacement { dpi: Some(72.0), ..plain });
        let wide = of(Layout { dpi: Some(200.0), ..layout("1000", "7", "") });
        let expected = PixelPlacement { page: [1014, 764], drawing: [1000, 750], origin: [7, 7], dpi: Some(200.0) };
        assert_eq!(wide, expected);
        assert_eq!(of(layout("", "25.4mm", "")).origin, [96, 96]);
        let page = of(layout("", "0", "500x500px"));
        assert_eq!((page.page, page.drawing, page.origin), ([500, 500], [500, 375], [0, 63]));
        let error = layout("600px", "0", "500x500px").place_pixels(400, 300).unwrap_err().to_string();
        assert!(error.starts_with("the drawing would be 600 x 450 px, but"), "{error}");
    }

    #[test]
    fn other_units_are_inches_times_the_resolution() {
        let of = |layout: Layout| layout.place_pixels(400, 300).unwrap();
        let print = of(layout("4in", "0.5in", ""));
        assert_eq!(print, PixelPlacement { page: [1500, 1200], drawing: [1200, 900], origin: [150, 150], dpi: Some(300.0) });
        let draft = of(Layout { dpi: Some(100.0), ..layout("4in", "48px", "") });
        assert_eq!(draft, PixelPlacement { page: [500, 400], drawing: [400, 300], origin: [50, 50], dpi: Some(100.0) });
        let sheet = of(layout("", "0", "A4"));
        assert_eq!((sheet.page, sheet.drawing, sheet.origin), ([3508, 2480], [3307, 2480], [100, 0]));
        assert!(
            layout("10000mm", "0", "").place_pixels(400, 300).unwrap_err().to_string().starts_with("the image would be 118110")
        );
        // Less than a pixel is a pixel.
        assert_eq!(layout("0.1mm", "0", "").place_pixels(400, 1).unwrap().drawing, [1, 1]);
    }
}
