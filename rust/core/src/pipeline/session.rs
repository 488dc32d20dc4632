//! A session: one photo drawn again and again, each time from where the options begin to differ.
//!
//! Every stage's last result is kept with what the stage needed of the options (see [`super::needs`]). A stage that needs the same
//! as last time is not run. That is all: the stages, their order and what they return are those of [`crate::draw`], which is a
//! session that keeps nothing, so a drawing does not depend on what was drawn before it.
//!
//! # Memory
//! A session holds the luma and the importance as given, and keeps what every slot of its memory has; docs/performance.md counts the
//! bytes. While it draws, this comes on top of what [`crate::draw`] needs. The parts that an [`Outcome`] has are shared with it, not
//! copied.

use std::borrow::Cow;
use std::fmt;

use crate::base::{Checked, Control, Result};
use crate::importance::Importance;
use crate::options::Options;
use crate::photo::Photo;
use crate::pipeline::draw::{Outcome, draw_with};
use crate::pipeline::memory::Memory;

/// A photo and its importance, with what the last drawing of them left.
pub struct Session {
    photo: Photo,
    importance: Importance,
    memory: Memory,
}

impl Session {
    /// A session on a photo, reduced as it is; nothing is computed yet.
    pub fn new(photo: Photo, importance: Importance) -> Self {
        Self { photo, importance, memory: Memory::new(true) }
    }

    /// The photo.
    pub fn photo(&self) -> &Photo {
        &self.photo
    }

    /// The importance as given.
    pub fn importance(&self) -> &Importance {
        &self.importance
    }

    /// Whether the photo, and a map that was given, are reduced as these options ask for. Else they are to be read again, for another
    /// session: then the drawing is the one that the options give from the start.
    pub fn fits(&self, options: &Options) -> bool {
        let map = if let Importance::Map(map) = &self.importance { Some(map) } else { None };
        std::iter::once(&self.photo).chain(map).all(|photo| photo.fits(options))
    }

    /// Draws the photo as [`crate::draw`] does, to the last bit, but runs only the stages that these options change: those, and
    /// no others, are in the stats' seconds.
    ///
    /// # Errors
    /// As [`crate::draw`]. The session can be used afterwards as if that drawing had not been asked for; what was finished is kept.
    pub fn draw(&mut self, options: &Checked<Options>, control: &Control) -> Result<Outcome> {
        draw_with(self.photo.clone(), Cow::Borrowed(&self.importance), options, control, &mut self.memory)
    }
}

impl fmt::Debug for Session {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let size = (self.photo.width(), self.photo.height());
        f.debug_struct("Session").field("size", &size).field("importance", &self.importance.name()).finish_non_exhaustive()
    }
}

#[cfg(test)]
mod tests {
    use std::sync::Arc;
    use std::sync::atomic::{AtomicBool, Ordering};

    use super::*;
    use crate::base::{Error, Step};
    use crate::drawing::Stats;
    use crate::files::{Export, Format};
    use crate::options::{Alpha, Backdrop, Point, Published};
    use crate::photo::Field;
    use crate::pipeline::draw::draw;
    use crate::pipeline::needs::tests::{CHANGES, busy, importances};

    /// Blobs, a gradient and an edge.
    fn photo(width: usize, height: usize) -> Photo {
        let value = |i: usize| {
            let (x, y) = ((i % width) as f64, (i / width) as f64);
            let wave = 0.5 + 0.25 * (x * 0.7).sin() * (y * 0.5).cos() + 0.2 * (x / width as f64 - 0.5);
            (if x > y + 20.0 { 0.6 * wave } else { wave }) as f32
        };
        Photo::new(Field::new(width, height, (0..width * height).map(value).collect()).unwrap())
    }

    /// A subject in the middle, of a mask of another size.
    fn mask() -> Photo {
        let within = |i: usize| (6..18).contains(&(i % 24)) && (4..14).contains(&(i / 24));
        Photo::new(Field::new(24, 18, (0..24 * 18).map(|i| f32::from(u8::from(within(i)))).collect()).unwrap())
    }

    fn session(which: usize) -> Session {
        Session::new(photo(48, 36).with_subject(&mask()).unwrap(), importances(48, 36)[which].clone())
    }

    /// The same options drawn from the start.
    fn fresh(session: &Session, options: &Options) -> Result<Outcome> {
        draw(session.photo(), session.importance(), &options.clone().check()?, &Control::new())
    }

    /// Draws with options that may break a rule.
    fn try_to_draw(session: &mut Session, options: &Options, control: &Control) -> Result<Outcome> {
        session.draw(&options.clone().check()?, control)
    }

    fn redrawn(session: &mut Session, options: &Options) -> Outcome {
        try_to_draw(session, options, &Control::new()).unwrap()
    }

    fn assert_equal(made: Outcome, expected: Outcome) {
        let without_times = |outcome: &Outcome| Stats { seconds: Default::default(), ..outcome.stats.clone() };
        assert_eq!(without_times(&made), without_times(&expected));
        for format in Format::ALL.iter().filter(|format| format.can_be_read()) {
            let writer = format.writer(Export::default().check().unwrap()).unwrap();
            assert_eq!(writer.write(&made.drawing).unwrap(), writer.write(&expected.drawing).unwrap());
        }
        assert!(
            made.drawing == expected.drawing
                && made.graph == expected.graph
                && made.labels == expected.labels
                && made.cells == expected.cells
        );
        assert!(made.components == expected.components && made.importance == expected.importance);
    }

    /// The stages that a drawing took.
    fn stages(outcome: &Outcome) -> Vec<&str> {
        outcome.stats.seconds.keys().map(String::as_str).filter(|name| *name != "total").collect()
    }

    #[test]
    fn every_option_there_and_back() {
        let mut session = session(2);
        let first = redrawn(&mut session, &busy());
        for change in CHANGES {
            let mut options = busy();
            change(&mut options);
            let made = redrawn(&mut session, &options);
            // All but these show (no dots are fused after the refinement): an option that reached its stage too late, or not at
            // all, would not.
            let Options { background, split, .. } = busy();
            let shows = options.threads.is_none() && (options.background == background) && options.split == split;
            let differs = made.drawing.curves != first.drawing.curves || made.drawing.stipples != first.drawing.stipples;
            assert_eq!(differs, shows, "{options:?}");
            assert_equal(made, fresh(&session, &options).unwrap());
            assert_equal(redrawn(&mut session, &busy()), first.clone());
        }
        let published = Published { alpha: Alpha::Constant(1.0), ..Published::ours() };
        let dark = Options { refine: 0, gamma: 0.4, sharpen: 0.0, local_contrast: 0.0, published, ..Options::default() };
        let [fused, apart] = [0, 12].map(|split| redrawn(&mut session, &Options { split, ..dark.clone() }));
        assert_ne!(fused.labels, apart.labels);
    }

    #[test]
    fn only_what_changed_is_run() {
        type Step = (fn(&mut Options), &'static [&'static str]);
        let steps: [Step; 9] = [
            (|_| (), &["diffusion", "importance", "lattice", "outlines", "relaxation", "tone", "triangulation"]),
            (|_| (), &[]),
            (|o| o.threads = Some(2), &[]),
            (|o| o.background = "black".parse().unwrap(), &[]),
            // Tonal alpha does not ask for it.
            (|o| o.published.detail_gain = 2.0, &[]),
            (|o| o.stipple_scale = 0.9, &["outlines"]),
            (|o| o.published.alpha = Alpha::Dynamic, &["diffusion", "outlines"]),
            (|o| o.published.detail_gain = 3.0, &["diffusion", "outlines"]),
            (|o| o.relax = 2, &["diffusion", "outlines", "relaxation", "tone", "triangulation"]),
        ];
        let (mut session, mut options) = (session(2), Options::default());
        for (change, expected) in steps {
            change(&mut options);
            let made = redrawn(&mut session, &options);
            assert_eq!(stages(&made), expected, "{options:?}");
            assert_equal(made, fresh(&session, &options).unwrap());
        }
    }

    #[test]
    fn nodes_that_do_not_depend_on_the_tone_stay() {
        let mut session = session(0);
        let before = redrawn(&mut session, &Options::default());
        let brighter = Options { gamma: 1.3, ..Options::default() };
        let made = redrawn(&mut session, &brighter);
        assert_eq!(stages(&made), ["diffusion", "lattice", "outlines", "tone"]);
        assert!(Arc::ptr_eq(&made.graph, &before.graph));
        assert_equal(made, fresh(&session, &brighter).unwrap());
    }

    #[test]
    fn a_backdrop_matters_with_a_subject_alone() {
        let ink = Options { backdrop: Backdrop::Ink, ..Options::default() };
        let mut without = Session::new(photo(48, 36), Importance::Constant(1.0));
        let first = redrawn(&mut without, &Options::default());
        assert!(!first.drawing.provenance.options.contains_key("backdrop"));
        let again = redrawn(&mut without, &ink);
        assert!(stages(&again).is_empty() && Arc::ptr_eq(&again.drawing, &first.drawing));
        // What is kept is drawn as if there were no subject.
        let mut with = Session::new(photo(48, 36).with_subject(&mask()).unwrap(), Importance::Constant(1.0));
        let kept = redrawn(&mut with, &Options { backdrop: Backdrop::Keep, ..Options::default() });
        assert_eq!((&kept.drawing.curves, &kept.drawing.stipples), (&first.drawing.curves, &first.drawing.stipples));
        assert_eq!(kept.drawing.provenance.options["backdrop"], "keep");
        let made = redrawn(&mut with, &ink);
        assert_ne!(made.drawing.curves, first.drawing.curves);
        assert_equal(made, fresh(&with, &ink).unwrap());
        let blank = photo(48, 36).with_subject(&Photo::new(Field::constant(2, 2, 0.2).unwrap())).unwrap();
        assert_eq!(blank, photo(48, 36));
    }

    #[test]
    fn a_blank_drawing_of_a_photo_that_is_not_flat_is_told() {
        let of = |low: f32, high: f32| {
            let value = |i: usize| low + (high - low) * (i % 60) as f32 / 59.0;
            Session::new(Photo::new(Field::new(60, 40, (0..2400).map(value).collect()).unwrap()), Importance::Constant(1.0))
        };
        let bare = Options { stippling: 0.0, ..Options::default() };
        let told = redrawn(&mut of(0.94, 1.0), &bare).warning.unwrap();
        assert!(told.starts_with("the whole drawing is white, as the photo's tones lie between 0.94 and 1.00"), "{told}");
        assert!(redrawn(&mut of(0.0, 0.05), &bare).warning.unwrap().contains("is black"));
        let auto = Options { white_point: Some(Point::Auto), black_point: Some(Point::Auto), ..bare.clone() };
        let stretched = redrawn(&mut of(0.94, 1.0), &auto);
        assert!(stretched.warning.is_none() && stretched.stats.regions > 1);
        assert!(redrawn(&mut of(0.99, 0.99), &bare).warning.is_none());
        assert!(redrawn(&mut of(0.0, 1.0), &bare).warning.is_none());
        // Dots show it by default.
        assert!(redrawn(&mut of(0.94, 1.0), &Options::default()).stats.stipples > 10);
    }

    #[test]
    fn options_that_change_nothing_give_the_last_drawing_again() {
        let mut session = session(2);
        let [first, again] = [None, Some(2)].map(|threads| redrawn(&mut session, &Options { threads, ..Options::default() }));
        assert!(Arc::ptr_eq(&first.drawing, &again.drawing) && Arc::ptr_eq(&first.graph, &again.graph));
        // To the last bit: what is written as -0 is not what is written as 0.
        let minus = Options { tolerance: -0.0, ..Options::default() };
        assert_equal(redrawn(&mut session, &minus), fresh(&session, &minus).unwrap());
    }

    #[test]
    fn what_fails_leaves_the_session_as_it_was() {
        let mut session = session(2);
        let first = redrawn(&mut session, &Options::default());
        assert!(try_to_draw(&mut session, &Options { gamma: 0.0, ..Options::default() }, &Control::new()).is_err());
        let again = redrawn(&mut session, &Options::default());
        assert!(stages(&again).is_empty() && Arc::ptr_eq(&again.drawing, &first.drawing));
        // Refused only when the lattice is there.
        let published = Published { density: Some(0.5), ..Published::ours() };
        let too_many = Options { nodes: Some(100_000), gamma: 1.5, published, ..Options::default() };
        assert!(matches!(try_to_draw(&mut session, &too_many, &Control::new()), Err(Error::Input(_))));
        let again = redrawn(&mut session, &Options::default());
        assert_eq!(stages(&again), ["lattice"]);
        assert_equal(again, first);
    }

    #[test]
    fn a_session_goes_on_after_being_stopped_anywhere() {
        let mut session = Session::new(photo(160, 120), importances(160, 120)[2].clone());
        let options = [Options::default(), Options { gamma: 1.4, relax: 3, ..Options::default() }];
        let expected = options.clone().map(|options| fresh(&session, &options).unwrap());
        for (i, at) in Step::ALL.iter().skip(1).map(|(_, name, _)| *name).enumerate() {
            let (control, is_done) = (Control::new(), AtomicBool::new(false));
            std::thread::scope(|scope| {
                scope.spawn(|| {
                    while control.progress().0 != at && !is_done.load(Ordering::Relaxed) {
                        std::hint::spin_loop();
                    }
                    control.cancel();
                });
                // It may be done before it is stopped: what counts is what comes next.
                let stopped = try_to_draw(&mut session, &options[(i + 1) % 2], &control);
                is_done.store(true, Ordering::Relaxed);
                assert!(matches!(stopped, Ok(_) | Err(Error::Cancelled)));
            });
            assert_equal(redrawn(&mut session, &options[i % 2]), expected[i % 2].clone());
        }
        let control = Control::new();
        control.cancel();
        assert!(matches!(try_to_draw(&mut session, &Options { relax: 5, ..Options::default() }, &control), Err(Error::Cancelled)));
    }
}
