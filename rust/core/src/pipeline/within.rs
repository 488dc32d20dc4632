//! The finest drawing within a limit: in, the options of a drawing and how many bytes or points it may have, or how long its plot may take; out, the options of the
//! next drawing to try, until one of those that were tried is the answer.
//!
//! Who asks draws the trials, best in a [`super::Session`]: they differ in their tolerance or in their nodes, and the session makes
//! again only what that changes. What is found is an ordinary drawing: its options, drawn without any limit, give the same.

use crate::base::{Checked, Error, Result};
use crate::drawing::{Drawing, Within};
use crate::files::Writer;
use crate::options::{Options, Typed, Value, bytes, in_hours};
use crate::pipeline::search::{Search, Trial};

/// What a blank sheet counts as to the search, as a share of the limit: there is room for a finer drawing.
const BLANK: f64 = 0.5;

/// How large a drawing may be. Without any of them every drawing fits.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct Limits {
    /// The most bytes of its file, and what writes that.
    pub max_bytes: Option<u64>,
    /// The most points: coordinate pairs, control points included; a dot counts one.
    pub max_points: Option<u64>,
    /// The most seconds that a machine may take for its plot.
    pub max_seconds: Option<u64>,
}

impl Limits {
    /// Limits as front ends have them: bytes as a number or as text such as `100kB`, points as a number.
    ///
    /// # Errors
    /// [`Error::Option`] for what is no such number, or less than 1.
    pub fn read(max_bytes: Option<&Value>, max_points: Option<&Value>) -> Result<Self> {
        let at_least_one = |name: &str, given: &Value, read: Option<u64>, allowed: &str| {
            read.filter(|number| *number > 0).ok_or_else(|| Error::option(name, given, allowed))
        };
        let size = |given: &Value| {
            let read = if let Value::Word(text) = given { bytes(text) } else { u64::read(given) };
            at_least_one("max_bytes", given, read, "a number of bytes, at least 1, or one with a unit such as 100kB, 1MB or 100KiB")
        };
        let count = |given: &Value| at_least_one("max_points", given, u64::read(given), "a whole number, at least 1");
        Ok(Self { max_bytes: max_bytes.map(size).transpose()?, max_points: max_points.map(count).transpose()?, max_seconds: None })
    }

    /// Whether there is none.
    pub fn is_none(&self) -> bool {
        *self == Self::default()
    }
}

/// The search for the finest drawing within limits.
#[derive(Debug, Clone)]
pub struct Trials {
    options: Checked<Options>,
    writer: Writer,
    limits: Limits,
    search: Search,
    next: Option<Trial>,
    /// The finest that fits, and the share of the limits that it is.
    best: Option<(f64, Within)>,
    /// Bytes, points and seconds of the smallest drawing, and the share of the limits that they are.
    smallest: Option<(f64, [u64; 3])>,
    /// Whether the drawing as it was asked for is of one ink alone.
    is_blank_as_asked: bool,
}

impl Trials {
    /// A search from these options on, of a photo with a canvas of so many pixels, that is written so.
    pub fn new(options: Checked<Options>, pixels: f64, writer: Writer, limits: Limits) -> Self {
        let search = Search::new(options.tolerance, options.budget(pixels).spacing);
        let next = search.next();
        Self { options, writer, limits, search, next, best: None, smallest: None, is_blank_as_asked: false }
    }

    /// The options of the drawing to make next; `None` when the search is over.
    ///
    /// # Errors
    /// [`Error::Option`] if they do not go together; they do where those do that were asked for.
    pub fn next_options(&self) -> Result<Option<Checked<Options>>> {
        let Some(trial) = self.next else { return Ok(None) };
        let mut options = Options { tolerance: trial.tolerance, ..(*self.options).clone() };
        if trial.nodes.is_some() {
            (options.nodes, options.nodes_per_pixel) = (trial.nodes, None);
        }
        options.check().map(Some)
    }

    /// Says which drawing these options gave, how many nodes it has, and where time is limited, how many seconds its plot takes. Returns
    /// whether it is the finest so far that fits.
    ///
    /// # Errors
    /// As [`Writer::write`].
    pub fn tell(&mut self, drawing: &Drawing, nodes: usize, seconds: Option<f64>) -> Result<bool> {
        let Some(trial) = self.next else { return Ok(false) };
        let points = drawing.count_written().1 as u64;
        let bytes = self.limits.max_bytes.map(|_| self.writer.write(drawing).map(|file| file.len() as u64)).transpose()?;
        let of_limit = |size: u64, limit: Option<u64>| limit.map_or(0.0, |limit| size as f64 / limit as f64);
        // To the second, as limits are told.
        let seconds = seconds.map(|seconds| seconds.ceil() as u64);
        let share = of_limit(bytes.unwrap_or(0), self.limits.max_bytes)
            .max(of_limit(points, self.limits.max_points))
            .max(of_limit(seconds.unwrap_or(0), self.limits.max_seconds));
        // A blank sheet has few bytes and no points, but is no drawing of a photo that shows something.
        let is_blank = drawing.stipples.is_empty() && drawing.regions.len() < 2;
        if self.search.trials() == 0 {
            self.is_blank_as_asked = is_blank;
        }
        let counts = !is_blank || self.is_blank_as_asked;
        if counts && self.smallest.is_none_or(|(smallest, _)| share < smallest) {
            self.smallest = Some((share, [bytes.unwrap_or(0), points, seconds.unwrap_or(0)]));
        }
        self.search.tell(trial, if counts { share } else { BLANK }, nodes as u64);
        self.next = self.search.next();
        let is_finest = counts && share <= 1.0 && self.best.as_ref().is_none_or(|(largest, _)| share > *largest);
        if is_finest {
            self.best = Some((share, Within { trials: 0, bytes, points, seconds, nodes, tolerance: trial.tolerance }));
        }
        Ok(is_finest)
    }

    /// What the finest drawing that fits came to.
    ///
    /// # Errors
    /// [`Error::Option`] if none fits: it says how small the coarsest is. [`Error::Input`] before the first drawing.
    pub fn found(&self) -> Result<Within> {
        if let Some((_, best)) = &self.best {
            return Ok(Within { trials: self.search.trials(), ..best.clone() });
        }
        let Some((_, [bytes, points, seconds])) = self.smallest else {
            return Err(Error::Input("no drawing was made to find the finest among".into()));
        };
        if let Some(limit) = self.limits.max_seconds.filter(|limit| seconds > *limit) {
            let allowed = format!("at least {}: the coarsest drawing that was tried takes so long", in_hours(seconds));
            return Err(Error::option("max_plot_time", in_hours(limit), allowed));
        }
        let (name, limit, least, unit) = match (self.limits.max_bytes, self.limits.max_points) {
            (Some(limit), _) if bytes > limit => ("max_bytes", limit, bytes, "bytes"),
            (_, limit) => ("max_points", limit.unwrap_or(0), points, "points"),
        };
        Err(Error::option(name, limit, format!("at least {least}: the coarsest drawing that was tried has so many {unit}")))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::base::Control;
    use crate::files::{Export, Format};
    use crate::importance::Importance;
    use crate::photo::{Field, Photo};
    use crate::pipeline::{Outcome, Session};

    /// Waves of several lengths: dots, shapes and smooth parts.
    fn photo(kind: usize) -> Photo {
        let (width, height) = (120, 90);
        let value = |i: usize| {
            let (x, y) = ((i % width) as f64, (i / width) as f64);
            let wave = (x * (0.05 + 0.1 * kind as f64)).sin() * (y * 0.11).cos();
            let edge = if x + y * kind as f64 > 90.0 { 0.2 } else { -0.1 };
            (0.5 + 0.3 * wave + edge).clamp(0.0, 1.0) as f32
        };
        Photo::new(Field::new(width, height, (0..width * height).map(value).collect()).unwrap())
    }

    fn writer(suffix: &str) -> Writer {
        Format::of_suffix(suffix).unwrap().writer(Export::default().check().unwrap()).unwrap()
    }

    /// The finest drawing within limits, and what it came to.
    fn drawn(photo: &Photo, options: &Options, suffix: &str, limits: &Limits) -> Result<(Outcome, Within)> {
        let mut session = Session::new(photo.clone(), Importance::Constant(1.0));
        let pixels = (photo.width() * photo.height()) as f64;
        let mut trials = Trials::new(options.clone().check()?, pixels, writer(suffix), limits.clone());
        let mut finest = None;
        while let Some(options) = trials.next_options()? {
            let outcome = session.draw(&options, &Control::new())?;
            if trials.tell(&outcome.drawing, outcome.stats.nodes, Some(outcome.stats.nodes as f64))? {
                finest = Some(outcome);
            }
        }
        let found = trials.found()?;
        Ok((finest.unwrap(), found))
    }

    fn bytes_of(outcome: &Outcome, suffix: &str) -> u64 {
        writer(suffix).write(&outcome.drawing).unwrap().len() as u64
    }

    #[test]
    fn points_are_limited_alone_and_beside_bytes() {
        let photo = photo(1);
        let (whole, within) = drawn(&photo, &Options::default(), "svg", &Limits::default()).unwrap();
        let (points, bytes) = (within.points, bytes_of(&whole, "svg"));
        let limits = Limits { max_bytes: None, max_points: Some(points / 2), ..Limits::default() };
        let (_, found) = drawn(&photo, &Options::default(), "svg", &limits).unwrap();
        assert!(found.points <= points / 2 && found.points as f64 >= 0.9 * (points / 2) as f64 && found.bytes.is_none());
        assert!(found.tolerance > Options::default().tolerance && found.nodes < whole.stats.nodes);
        let limits = Limits { max_bytes: Some(bytes / 2), max_points: Some(points / 3), ..Limits::default() };
        let (_, found) = drawn(&photo, &Options::default(), "svg", &limits).unwrap();
        assert!(found.points <= points / 3 && found.bytes.unwrap() <= bytes / 2);
        // What fits is left as it is.
        let limits = Limits { max_bytes: Some(bytes), max_points: Some(points), ..Limits::default() };
        let (found, within) = drawn(&photo, &Options::default(), "svg", &limits).unwrap();
        assert!(within.trials == 1 && found.drawing == whole.drawing);
    }

    #[test]
    fn seconds_are_limited_as_bytes_are() {
        // Here a plot takes a second a node.
        let photo = photo(1);
        let (whole, _) = drawn(&photo, &Options::default(), "svg", &Limits::default()).unwrap();
        let limits = Limits { max_seconds: Some(whole.stats.nodes as u64 / 2), ..Limits::default() };
        let (_, found) = drawn(&photo, &Options::default(), "svg", &limits).unwrap();
        let most = limits.max_seconds.unwrap();
        assert!(found.seconds.is_some_and(|seconds| seconds <= most && seconds as f64 >= 0.9 * most as f64), "{found:?}");
        let limits = Limits { max_seconds: Some(1), ..Limits::default() };
        let told = drawn(&photo, &Options::default(), "svg", &limits).unwrap_err().to_string();
        assert!(told.starts_with("max_plot_time is 1s, but it must be at least "), "{told}");
    }

    #[test]
    fn what_cannot_be_is_told_with_the_least_that_can() {
        let told = |limits: &Limits| drawn(&photo(0), &Options::default(), "svg", limits).unwrap_err().to_string();
        let least = |told: &str| -> u64 {
            let rest = told.split("at least ").nth(1).expect("the sentence has it");
            rest.split(':').next().unwrap().parse().unwrap()
        };
        let message = told(&Limits { max_bytes: Some(10), max_points: None, ..Limits::default() });
        let bytes = least(&message);
        assert_eq!(
            message,
            format!("max_bytes is 10, but it must be at least {bytes}: the coarsest drawing that was tried has so many bytes")
        );
        assert!((500..5000).contains(&bytes), "{message}");
        // Other limits lead to other trials, and the coarsest of them to others by a node or two.
        let limits = Limits { max_bytes: Some(bytes + bytes / 4), max_points: None, ..Limits::default() };
        let (found, within) = drawn(&photo(0), &Options::default(), "svg", &limits).unwrap();
        assert!(within.bytes.unwrap() <= bytes + bytes / 4 && found.drawing.regions.len() > 1, "{within:?}");
        let message = told(&Limits { max_bytes: Some(1_000_000), max_points: Some(1), ..Limits::default() });
        assert!(message.starts_with("max_points is 1, but it must be at least ") && least(&message) < 100, "{message}");
    }

    #[test]
    fn a_blank_sheet_is_no_answer_but_to_a_blank_photo() {
        let limits = Limits { max_bytes: None, max_points: Some(1), ..Limits::default() };
        assert!(drawn(&photo(0), &Options::default(), "svg", &limits).is_err());
        let flat = Photo::new(Field::constant(40, 30, 1.0).unwrap());
        let (found, within) = drawn(&flat, &Options::default(), "svg", &limits).unwrap();
        assert_eq!((within.trials, within.points, found.drawing.regions.len()), (1, 0, 1));
    }

    #[test]
    fn limits_are_read_from_numbers_and_text() {
        let word = |text: &str| Value::Word(text.to_owned());
        let read = |bytes: Value, points: Value| Limits::read(Some(&bytes), Some(&points));
        let limits = Limits { max_bytes: Some(100_000), max_points: Some(20_000), ..Limits::default() };
        assert_eq!(read(word("100kB"), Value::Whole(20_000)).unwrap(), limits);
        assert_eq!(read(Value::Number(1e5), Value::Number(2e4)).unwrap(), limits);
        assert!(Limits::read(None, None).unwrap().is_none() && !limits.is_none());
        for wrong in [word("0"), word("0.5B"), word("many"), Value::Whole(0), Value::Number(-1.0), Value::Switch(true)] {
            let told = read(wrong.clone(), Value::Whole(1)).unwrap_err().to_string();
            assert!(told.starts_with(&format!("max_bytes is {wrong}, but it must be a number of bytes, at least 1")), "{told}");
            let told = read(Value::Whole(1), wrong.clone()).unwrap_err().to_string();
            assert_eq!(told, format!("max_points is {wrong}, but it must be a whole number, at least 1"));
        }
    }
}
