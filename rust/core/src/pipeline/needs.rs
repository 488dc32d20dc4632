//! What every stage needs of the options, from their declarations: in, the options; out, a copy of them for each stage.
//!
//! No stage sees the options themselves. It is handed a copy in which all that it has no use for stands at its default. So an option
//! that is not declared for a stage cannot reach it, in any drawing; and where two copies are equal, so are the results. That is how
//! a [`super::session::Session`] knows what it may keep.
//!
//! What a stage needs includes what the stages before it need whose results it takes: its copy stands for all that its result
//! depends on, besides the photo and the importance.

use crate::importance::Importance;
use crate::options::{DECLARATIONS, Options, Stage};

/// The options as each stage sees them.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct Needs {
    of_stages: [Options; Stage::ALL.len()],
}

impl Needs {
    pub(crate) fn of(options: &Options, given: &Importance) -> Self {
        let takes_from_photo = given.takes_from_photo(options);
        let of_stages = Stage::ALL.map(|stage| {
            let of = with_those_before(stage, takes_from_photo);
            let mut needs = Options::default();
            for declaration in DECLARATIONS {
                if of.iter().any(|stage| declaration.is_used(*stage, options)) {
                    declaration.copy(&mut needs, options);
                }
            }
            if !takes_from_photo && of.contains(&Stage::Importance) {
                // The map alone: by these three it takes nothing from the photo, whatever the tone.
                (needs.detail, needs.floor, needs.midtones) = (0.0, 0.0, 0.0);
            }
            needs
        });
        Self { of_stages }
    }

    /// What a stage sees.
    pub(crate) fn at(&self, stage: Stage) -> &Options {
        &self.of_stages[stage as usize]
    }
}

/// A stage, and all those on whose results its own depends.
fn with_those_before(stage: Stage, takes_from_photo: bool) -> Vec<Stage> {
    let before: &[Stage] = match stage {
        Stage::Tone => &[],
        Stage::Emphasis => &[Stage::Tone],
        Stage::Importance if !takes_from_photo => &[],
        Stage::Importance => &[Stage::Emphasis],
        Stage::FirstGraph => &[Stage::Importance],
        Stage::SecondGraph => &[Stage::FirstGraph],
        Stage::Cells => &[Stage::SecondGraph, Stage::Emphasis],
        Stage::Labels => &[Stage::Cells],
        Stage::Outlines => &[Stage::Labels],
    };
    let mut all = vec![stage];
    all.extend(before.iter().flat_map(|stage| with_those_before(*stage, takes_from_photo)));
    all
}

#[cfg(test)]
pub(crate) mod tests {
    use std::collections::BTreeSet;

    use proptest::prelude::*;

    use super::*;
    use crate::base::NamedInk;
    use crate::options::{Alpha, Backdrop, Crossings, Edge, ErrorWeighting, InkList, LatticeKind, Order, Point};
    use crate::photo::{Field, Photo};

    /// Every option at another value than in [`busy`] and in the defaults. Some of them do not go together.
    pub(crate) const CHANGES: [fn(&mut Options); DECLARATIONS.len()] = [
        |o| o.nodes = Some(300),
        |o| o.fineness = 0.6,
        |o| o.nodes_per_pixel = Some(0.2),
        |o| o.detail = 0.4,
        |o| o.floor = 0.3,
        |o| o.midtones = 0.1,
        |o| o.relax = 2,
        |o| o.stippling = 0.7,
        |o| o.shading = 0.6,
        |o| o.crispness = 1.0,
        |o| o.cohesion = 0.5,
        |o| o.sharpen = 0.5,
        |o| o.local_contrast = 0.2,
        |o| o.tone_tolerance = None,
        |o| o.tolerance = 0.6,
        |o| o.wobble = 0.3,
        |o| o.edge = Edge::Torn,
        |o| o.refine = 0,
        |o| o.split = 0,
        |o| o.stipple_scale = 0.5,
        |o| o.stipple_min = 1.0,
        |o| o.stipple_max = Some(0.6),
        |o| o.irregularity = 0.9,
        |o| o.seed = 7,
        |o| o.white_point = Some(Point::At(0.9)),
        |o| o.black_point = Some(Point::At(0.1)),
        |o| o.linear = true,
        |o| o.gamma = 1.6,
        |o| o.contrast = 0.6,
        |o| o.invert = true,
        |o| o.backdrop = Backdrop::Ink,
        |o| o.background = "black".parse().unwrap(),
        |o| o.inks = Some(InkList(vec![NamedInk::of_colour([200, 0, 0])])),
        |o| o.levels = Some(5),
        |o| o.extract_inks = Some(5),
        |o| (o.overprint, o.extract_inks) = (true, Some(3)),
        |o| (o.paper, o.levels) = (Some("#eeeecc".parse().unwrap()), Some(4)),
        |o| o.threads = Some(1),
        |o| o.published.lattice = LatticeKind::Square,
        |o| o.published.density = Some(0.7),
        |o| o.published.k1 = 3.0,
        |o| o.published.k2 = 0.4,
        |o| o.published.base = 0.6,
        |o| o.published.detail_gain = 1.0,
        |o| o.published.hops = 2,
        |o| o.published.importance_alpha = Alpha::Tonal,
        |o| o.published.alpha = Alpha::Constant(0.8),
        |o| o.published.importance_order = Order::Global,
        |o| o.published.order = Order::Global,
        |o| o.published.error_weighting = ErrorWeighting::Value,
        |o| o.published.crossings = Crossings::Midpoint,
    ];

    /// Options under which every option matters.
    pub(crate) fn busy() -> Options {
        let mut options =
            Options { shading: 0.8, irregularity: 0.4, wobble: 0.1, split: 12, tone_tolerance: Some(0.001), ..Options::default() };
        options.published.importance_alpha = Alpha::Dynamic;
        options.published.base = 0.8;
        options
    }

    /// Options with some of the changes, by the bits of a number.
    pub(crate) fn changed(mut options: Options, bits: u64) -> Options {
        CHANGES.iter().enumerate().filter(|(i, _)| bits >> i & 1 == 1).for_each(|(_, change)| change(&mut options));
        options
    }

    /// One importance of every kind, for a photo of this size.
    pub(crate) fn importances(width: usize, height: usize) -> [Importance; 3] {
        let values = (0..width * height).map(|i| (i % width) as f32 / width as f32).collect();
        let map = Field::new(width, height, values).unwrap();
        [Importance::Constant(0.5), Importance::Map(Photo::new(Field::constant(3, 2, 0.7).unwrap())), Importance::saliency(map)]
    }

    #[test]
    fn every_option_is_among_the_changes() {
        for base in [Options::default(), busy()] {
            let changed = |i: usize| changed(base.clone(), 1 << i);
            let different: BTreeSet<String> = (0..CHANGES.len()).map(|i| format!("{:?}", changed(i))).collect();
            assert_eq!(different.len(), CHANGES.len());
            for (i, declaration) in DECLARATIONS.iter().enumerate() {
                assert_ne!(declaration.value(&changed(i)), declaration.value(&base), "{} is not changed", declaration.name);
            }
        }
    }

    proptest! {
        /// Equal needs stand for equal results: so they must say what the stages before needed.
        #[test]
        fn needs_include_those_of_the_stages_before(bits: u64, which in 0usize..3, is_busy: bool) {
            let given = &importances(8, 6)[which];
            let options = changed(if is_busy { busy() } else { Options::paper() }, bits);
            let needs = Needs::of(&options, given);
            prop_assert_eq!(&Needs::of(needs.at(Stage::Outlines), given), &needs);
            for later in Stage::ALL {
                let again = Needs::of(needs.at(later), given);
                for before in with_those_before(later, given.takes_from_photo(&options)) {
                    prop_assert_eq!(again.at(before), needs.at(before), "{:?} for {:?}", before, later);
                }
            }
        }
    }

    #[test]
    fn a_stage_sees_only_what_is_declared_for_it_or_for_those_before() {
        let options =
            Options { gamma: 2.0, cohesion: 3.0, tolerance: 0.1, background: "black".parse().unwrap(), ..Options::default() };
        let needs = Needs::of(&options, &importances(8, 6)[2]);
        assert_eq!(needs.at(Stage::Tone), &Options { gamma: 2.0, ..Options::default() });
        assert_eq!(needs.at(Stage::Labels), &Options { gamma: 2.0, cohesion: 3.0, ..Options::default() });
        assert_eq!(needs.at(Stage::Outlines), &Options { background: Options::default().background, ..options });
    }
}
