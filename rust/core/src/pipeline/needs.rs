//! What every stage needs of the options: the one place that says which option matters where.
//!
//! No stage sees the options themselves. It is handed a copy in which all that it has no use for stands at its default. So what
//! is not named here for a stage cannot reach it, in any drawing; and where two copies are equal, so are the results. That is how a
//! [`super::session::Session`] knows what it may keep.
//!
//! What a stage needs includes what the stages before it need whose results it takes: its copy stands for all that its result
//! depends on, besides the photo and the importance.

use crate::importance::Importance;
use crate::options::{Alpha, Options};

/// The options as each stage sees them.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct Needs {
    pub(crate) tone: Options,
    pub(crate) emphasis: Options,
    /// The importance on the canvas.
    pub(crate) importance: Options,
    /// The lattice, and which of its nodes are kept.
    pub(crate) first_graph: Options,
    /// The sites and their triangulation.
    pub(crate) second_graph: Options,
    /// Areas and tones of the nodes' cells.
    pub(crate) cells: Options,
    /// Labels, and so components too.
    pub(crate) labels: Options,
    pub(crate) outlines: Options,
}

impl Needs {
    pub(crate) fn of(options: &Options, given: &Importance) -> Self {
        // No `..` here: a new option has to be put in its place below, or it is an unused variable.
        let Options {
            lattice,
            density,
            nodes,
            nodes_per_pixel,
            fineness,
            detail,
            floor,
            midtones,
            relax,
            k1,
            k2,
            base,
            detail_gain,
            rings,
            importance_alpha,
            alpha,
            importance_order,
            order,
            carry,
            refine,
            crispness,
            cohesion,
            tone_tolerance,
            split,
            crossings,
            sharpen,
            local_contrast,
            stipple_scale,
            stipple_min,
            stipple_max,
            irregularity,
            seed,
            tolerance,
            linear,
            gamma,
            contrast,
            invert,
            // Neither matters to any stage: a drawing does not depend on its threads, and the background is in the luma.
            threads: _,
            background: _,
        } = *options;
        let of_alpha = |alpha: Alpha, rest: Options| match alpha {
            Alpha::Constant(_) => rest,
            Alpha::Tonal => Options { base, ..rest },
            Alpha::Dynamic => Options { base, detail_gain, rings, ..rest },
        };
        let of_tone = |rest: Options| Options { linear, gamma, contrast, invert, ..rest };
        let of_emphasis = |rest: Options| Options { sharpen, local_contrast, ..of_tone(rest) };
        let of_budget = |rest: Options| Options { density, nodes, nodes_per_pixel, fineness, ..rest };

        let tone = of_tone(Options::default());
        let emphasis = of_budget(of_emphasis(Options::default()));
        let importance = if given.takes_from_photo(options) {
            Options { detail, floor, midtones, ..emphasis.clone() }
        } else {
            // The map alone: by these three it takes nothing from the photo, whatever the tone.
            Options { detail: 0.0, floor: 0.0, midtones: 0.0, ..Options::default() }
        };
        let kept = Options { lattice, importance_alpha, importance_order, k1, k2, ..of_budget(importance.clone()) };
        let first_graph = of_alpha(importance_alpha, kept);
        let second_graph = Options { relax, ..first_graph.clone() };
        let cells = of_emphasis(second_graph.clone());
        let of_refinement = |rest: Options| match refine {
            0 => Options { refine, ..rest },
            _ => Options { refine, crispness, cohesion, tone_tolerance, ..rest },
        };
        let labels = of_refinement(of_alpha(alpha, Options { alpha, order, carry, split, ..cells.clone() }));
        let shapes = Options { stipple_scale, stipple_min, stipple_max, irregularity, seed, tolerance, ..labels.clone() };
        let outlines = Options { crossings, ..shapes };
        Self { tone, emphasis, importance, first_graph, second_graph, cells, labels, outlines }
    }
}

/// Whether options are the same to the last bit: `==` takes -0 for 0, which are written differently.
pub(crate) fn identical(a: &Options, b: &Options) -> bool {
    format!("{a:?}") == format!("{b:?}")
}

#[cfg(test)]
pub(crate) mod tests {
    use std::collections::BTreeSet;

    use proptest::prelude::*;

    use super::*;
    use crate::options::{Carry, Crossings, LatticeKind, Order};
    use crate::photo::Field;

    /// Every option at another value than in [`busy`] and in the defaults. Some of them do not go together.
    pub(crate) const CHANGES: [fn(&mut Options); 39] = [
        |o| o.lattice = LatticeKind::Square,
        |o| o.density = Some(0.7),
        |o| o.nodes = Some(300),
        |o| o.nodes_per_pixel = Some(0.2),
        |o| o.fineness = 0.6,
        |o| o.detail = 0.4,
        |o| o.floor = 0.3,
        |o| o.midtones = 0.1,
        |o| o.relax = 2,
        |o| o.k1 = 3.0,
        |o| o.k2 = 0.4,
        |o| o.base = 0.6,
        |o| o.detail_gain = 1.0,
        |o| o.rings = 2,
        |o| o.importance_alpha = Alpha::Tonal,
        |o| o.alpha = Alpha::Constant(0.8),
        |o| o.importance_order = Order::Global,
        |o| o.order = Order::Global,
        |o| o.carry = Carry::Value,
        |o| o.refine = 0,
        |o| o.crispness = 1.0,
        |o| o.cohesion = 0.5,
        |o| o.tone_tolerance = None,
        |o| o.split = 0,
        |o| o.crossings = Crossings::Midpoint,
        |o| o.sharpen = 0.5,
        |o| o.local_contrast = 0.2,
        |o| o.stipple_scale = 0.5,
        |o| o.stipple_min = 1.0,
        |o| o.stipple_max = Some(0.6),
        |o| o.irregularity = 0.9,
        |o| o.seed = 7,
        |o| o.tolerance = 0.6,
        |o| o.linear = true,
        |o| o.gamma = 1.6,
        |o| o.contrast = 0.6,
        |o| o.invert = true,
        |o| o.threads = Some(1),
        |o| o.background = "black".to_owned(),
    ];

    /// Options under which every option matters.
    pub(crate) fn busy() -> Options {
        let alpha = Alpha::Dynamic;
        Options {
            alpha,
            importance_alpha: alpha,
            base: 0.8,
            irregularity: 0.4,
            split: 12,
            tone_tolerance: Some(0.001),
            ..Options::default()
        }
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
        [Importance::Constant(0.5), Importance::Map(Field::constant(3, 2, 0.7).unwrap()), Importance::Saliency(map)]
    }

    /// The names of the fields, as Debug writes them.
    fn fields(options: &Options) -> Vec<String> {
        format!("{options:#?}")
            .lines()
            .filter(|line| line.starts_with("    ") && !line.starts_with("     "))
            .map(str::to_owned)
            .collect()
    }

    #[test]
    fn every_option_is_among_the_changes() {
        for base in [Options::default(), busy()] {
            let text = format!("{base:?}");
            let different: BTreeSet<String> = (0..CHANGES.len()).map(|i| format!("{:?}", changed(base.clone(), 1 << i))).collect();
            assert!(different.len() == CHANGES.len() && !different.contains(&text));
        }
        let names = fields(&Options::default()).iter().filter(|line| line.contains(": ")).count();
        assert_eq!(names, CHANGES.len(), "an option has no line in CHANGES");
    }

    proptest! {
        /// Equal needs stand for equal results: so they must say what the stages before needed.
        #[test]
        fn needs_include_those_of_the_stages_before(bits: u64, which in 0usize..3, is_busy: bool) {
            let given = &importances(8, 6)[which];
            let options = changed(if is_busy { busy() } else { Options::paper() }, bits);
            let needs = Needs::of(&options, given);
            let Needs { tone, emphasis, importance, first_graph, second_graph, cells, labels, outlines } = &needs;
            prop_assert_eq!(&Needs::of(outlines, given), &needs);
            for later in [labels, cells, emphasis] {
                let again = Needs::of(later, given);
                prop_assert_eq!((&again.tone, &again.emphasis), (tone, emphasis));
            }
            for later in [labels, cells, second_graph, first_graph] {
                prop_assert_eq!(&Needs::of(later, given).importance, importance);
                prop_assert_eq!(&Needs::of(later, given).first_graph, first_graph);
            }
            for later in [labels, cells] {
                prop_assert_eq!(&Needs::of(later, given).second_graph, second_graph);
                prop_assert_eq!(&Needs::of(later, given).cells, cells);
            }
            prop_assert_eq!(&Needs::of(tone, given).tone, tone);
        }
    }

    #[test]
    fn minus_nought_is_not_nought() {
        let [plus, minus] = [0.0, -0.0].map(|tolerance| Options { tolerance, ..Options::default() });
        assert!(plus == minus && !identical(&plus, &minus) && identical(&minus, &minus.clone()));
    }
}
