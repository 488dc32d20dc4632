//! The options of a drawing: plain data with documented defaults, units and ranges, and one [`Options::validate`].
//!
//! The same names, defaults and ranges hold in Rust, Python, the command line and the metadata of a drawing (as JSON, by serde).

use serde::{Deserialize, Serialize};

use crate::base::{Error, Result};

/// The regular first graph (the paper uses the hexagonal one).
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Serialize, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum LatticeKind {
    /// Six neighbours a node, all at the same distance.
    #[default]
    Hexagonal,
    /// Four neighbours a node.
    Square,
}

/// How much of a node's error is passed on.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[serde(untagged, from = "AlphaForm", into = "AlphaForm")]
pub enum Alpha {
    /// The paper's: `base + detail_gain * |I0 - A|` if the label fell on the side of 0.5 where the node's own value lies, else 0.
    Dynamic,
    /// `base` in middle tones, less towards black and white, where it is 0: see [`crate::stages::tonal_share`].
    Tonal,
    /// The same share for every node: 1 is plain halftoning, 0 is thresholding. In [0, 1].
    Constant(f64),
}

/// How [`Alpha`] looks in JSON: a word or a number.
#[derive(Serialize, Deserialize)]
#[serde(untagged)]
enum AlphaForm {
    Word(AlphaWord),
    Number(f64),
}

#[derive(Serialize, Deserialize)]
#[serde(rename_all = "lowercase")]
enum AlphaWord {
    Dynamic,
    Tonal,
}

impl From<AlphaForm> for Alpha {
    fn from(form: AlphaForm) -> Self {
        match form {
            AlphaForm::Word(AlphaWord::Dynamic) => Self::Dynamic,
            AlphaForm::Word(AlphaWord::Tonal) => Self::Tonal,
            AlphaForm::Number(value) => Self::Constant(value),
        }
    }
}

impl From<Alpha> for AlphaForm {
    fn from(alpha: Alpha) -> Self {
        match alpha {
            Alpha::Dynamic => Self::Word(AlphaWord::Dynamic),
            Alpha::Tonal => Self::Word(AlphaWord::Tonal),
            Alpha::Constant(value) => Self::Number(value),
        }
    }
}

/// In which order nodes are labelled when errors are diffused.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum Order {
    /// The paper's: one order by priority over all nodes.
    Global,
    /// Row by row, many bands of rows at a time: see [`crate::stages::diffuse_lattice`] and, for the second graph,
    /// [`crate::stages::diffuse`].
    Rows,
}

/// What of a node's error its neighbours receive.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum Carry {
    /// The paper's: the error itself, as if all cells were equal.
    Value,
    /// The error times the area of the node's cell, over that of the neighbour's: what is black here is missing there.
    Area,
}

/// Where a boundary crosses an edge of the second graph, between a black and a white node.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum Crossings {
    /// The paper's: in the middle.
    Midpoint,
    /// Where the tone between the nodes passes middle grey, if it does: see [`crate::stages::crossing`].
    Tone,
}

/// Everything that shapes a drawing besides the photo and the importance map.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct Options {
    /// The first graph.
    pub lattice: LatticeKind,
    /// Lattice nodes per pixel, in (0, 16]. `None`: as fine as the node budget needs, and no finer.
    pub density: Option<f64>,
    /// Node budget: how many nodes to keep, at least 3 (within 1 %). At most one of `nodes` and `nodes_per_pixel`.
    pub nodes: Option<u64>,
    /// Node budget per pixel, in (0, 16].
    pub nodes_per_pixel: Option<f64>,
    /// Factor on the node budget of a drawing without `density`, `nodes` and `nodes_per_pixel`, above 0, at most 16: below 1 shapes
    /// are larger, above 1 finer.
    pub fineness: f64,
    /// Share of the photo's own detail in the importance, against saliency (or, with a user's map, against 1), in [0, 1].
    pub detail: f64,
    /// The least importance, in [0, 1], before `midtones`: no part of the photo is left without nodes.
    pub floor: f64,
    /// By how much less important black and white are than middle grey, in [0, 1].
    pub midtones: f64,
    /// Lloyd steps between the two graphs, 0 to 100.
    pub relax: u32,
    /// Weight of the difference of values between two nodes, in [0, 1000].
    pub k1: f64,
    /// Weight of the distance between two nodes, per pixel, in [0, 1000].
    pub k2: f64,
    /// Tonal alpha in middle tones, or dynamic alpha where there is no detail, in [0, 1].
    pub base: f64,
    /// The paper's lambda: how much dynamic alpha grows with |value - local mean|, in [0, 1000].
    pub detail_gain: f64,
    /// Radius of the local mean in rings of the graph, 1 to 16.
    pub rings: u32,
    /// Alpha of the first diffusion (importance on the lattice).
    pub importance_alpha: Alpha,
    /// Alpha of the second diffusion (tone on the Delaunay graph).
    pub alpha: Alpha,
    /// The order of nodes in the first diffusion.
    pub importance_order: Order,
    /// The order of nodes in the second diffusion.
    pub order: Order,
    /// What is passed on when the tone is diffused.
    pub carry: Carry,
    /// Sweeps over the labels that refine them, at most, 0 to 100: see [`crate::stages::refine`]. 0: labels stay as diffusion gave
    /// them.
    pub refine: u32,
    /// Weight of a node's own tone in the refinement, in [0, 100]: more makes crisper shapes, less keeps the tone of small parts.
    pub crispness: f64,
    /// Weight of the neighbours' labels in the refinement, in [0, 100]: more makes larger shapes with smoother boundaries.
    pub cohesion: f64,
    /// How far the mean of the drawing may be from that of the tone, in [0, 1], before the refinement moves all nodes towards it.
    /// `None`: as it comes.
    pub tone_tolerance: Option<f64>,
    /// Dots that fused by chance, up to this many nodes together, are taken apart where there is room, 0 to 12: see
    /// [`crate::stages::split`]. Below 2: none.
    pub split: u32,
    /// Where boundaries cross the edges of the graph.
    pub crossings: Crossings,
    /// Emphasis of details as fine as the nodes, before the diffusion, in [0, 100]: see [`crate::stages::emphasize`].
    pub sharpen: f64,
    /// Emphasis of details three times as coarse, in [0, 100].
    pub local_contrast: f64,
    /// A stipple's area relative to its node's cell, in (0, 4].
    pub stipple_scale: f64,
    /// Least radius of a stipple where the triangles around its node have room for it, in pixels, in [0, 1000].
    pub stipple_min: f64,
    /// Largest radius of a stipple, in pixels, in (0, 1000] and not below `stipple_min`. `None`: as large as its cell asks for.
    pub stipple_max: Option<f64>,
    /// How far stipples are from round, in [0, 1]. Above 0 they look made by hand: they are closed curves and count as regions.
    pub irregularity: f64,
    /// Which of the irregular shapes stipples have, 0 to 2^53.
    pub seed: u64,
    /// How far the curves of regions may lie from the splines through the crossings of the graph's edges, in pixels, in [0, 2]:
    /// more means fewer points. 0 keeps every crossing.
    pub tolerance: f64,
    /// Take the tone in linear light: the share of white that is drawn then reflects as much light as the photo's grey on a screen.
    pub linear: bool,
    /// The tone is raised to the power 1 / gamma (above 1 brightens), in [0.1, 10].
    pub gamma: f64,
    /// Factor on the tone's distance from 0.5, in [0, 10].
    pub contrast: f64,
    /// Swap black and white in the tone.
    pub invert: bool,
    /// Worker threads, 1 to 1024; `None`: one a core. The drawing does not depend on it, so it is not part of the metadata.
    #[serde(skip_serializing)]
    pub threads: Option<usize>,
    /// What lies under transparent parts of the photo and of a map: `white`, `black`, `#rrggbb` or `#rgb`. Whoever decodes them
    /// lays them over it; it stands here so that a drawing can be made again.
    pub background: String,
}

impl Default for Options {
    fn default() -> Self {
        Self {
            lattice: LatticeKind::Hexagonal,
            density: None,
            nodes: None,
            nodes_per_pixel: None,
            fineness: 1.0,
            detail: 0.95,
            floor: 0.07,
            midtones: 0.8,
            relax: 1,
            k1: 1.0,
            k2: 0.1,
            base: 0.15,
            detail_gain: 6.0,
            rings: 1,
            importance_alpha: Alpha::Constant(1.0),
            alpha: Alpha::Tonal,
            importance_order: Order::Rows,
            order: Order::Rows,
            carry: Carry::Area,
            refine: 12,
            crispness: 1.9,
            cohesion: 0.2,
            tone_tolerance: Some(0.014),
            split: 4,
            crossings: Crossings::Tone,
            sharpen: 2.5,
            local_contrast: 1.5,
            stipple_scale: 1.0,
            stipple_min: 0.0,
            stipple_max: None,
            irregularity: 0.0,
            seed: 0,
            tolerance: 0.5,
            linear: false,
            gamma: 1.0,
            contrast: 1.0,
            invert: false,
            threads: None,
            background: "white".to_owned(),
        }
    }
}

/// Nodes that a drawing without `density`, `nodes` and `nodes_per_pixel` has at most, so that the effort does not grow with a
/// camera's megapixels: more than a print shows, and a few seconds of work.
pub const DEFAULT_MAX_NODES: f64 = 300_000.0;

/// Nodes per pixel of a drawing below that cap, and the share of lattice nodes that a budget keeps when no density is given:
/// enough lattice nodes to choose from, few enough to be quick.
pub const DEFAULT_NODES_PER_PIXEL: f64 = 0.3;

/// The largest seed, 2^53: every program that reads JSON holds it exactly.
const MAX_SEED: u64 = 1 << 53;

/// What [`Options::density`] and the budget options come to for a canvas.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Budget {
    /// Lattice nodes per pixel.
    pub density: f64,
    /// How many nodes to keep; `None`: whatever the importance keeps.
    pub nodes: Option<f64>,
    /// How far apart the kept nodes are about, in pixels, were they spread evenly.
    pub spacing: f64,
}

impl Options {
    /// The paper's settings: density 1, no node budget, saliency alone, one Lloyd step, k1 = 1, k2 = 0.1, base = 0.5, lambda = 6,
    /// dynamic alpha, the tone as it is, every midpoint kept.
    pub fn paper() -> Self {
        Self {
            density: Some(1.0),
            detail: 0.0,
            floor: 0.0,
            midtones: 0.0,
            base: 0.5,
            importance_alpha: Alpha::Dynamic,
            alpha: Alpha::Dynamic,
            importance_order: Order::Global,
            order: Order::Global,
            carry: Carry::Value,
            refine: 0,
            tone_tolerance: None,
            split: 0,
            crossings: Crossings::Midpoint,
            sharpen: 0.0,
            local_contrast: 0.0,
            tolerance: 0.0,
            ..Self::default()
        }
    }

    /// Checks every field.
    ///
    /// # Errors
    /// [`Error::Option`] for the first field out of its range.
    pub fn validate(&self) -> Result<()> {
        let range = |option: &'static str, value: f64, low: f64, high: f64, allowed: &'static str| {
            if value >= low && value <= high { Ok(()) } else { Err(Error::Option { option, value: value.to_string(), allowed }) }
        };
        // Ranges that exclude 0 start at the smallest value that still makes sense on the largest canvas.
        const ABOVE_ZERO: f64 = 1e-9;
        if let Some(density) = self.density {
            range("density", density, ABOVE_ZERO, 16.0, "above 0 and at most 16 nodes per pixel")?;
        }
        if let Some(nodes) = self.nodes {
            range("nodes", nodes as f64, 3.0, 1e9, "between 3 and 1000000000")?;
        }
        if let Some(nodes_per_pixel) = self.nodes_per_pixel {
            range("nodes_per_pixel", nodes_per_pixel, ABOVE_ZERO, 16.0, "above 0 and at most 16")?;
        }
        if let (Some(_), Some(value)) = (self.nodes, self.nodes_per_pixel) {
            return Err(Error::Option {
                option: "nodes_per_pixel",
                value: value.to_string(),
                allowed: "left out when nodes is given: the budget is one or the other",
            });
        }
        range("fineness", self.fineness, ABOVE_ZERO, 16.0, "above 0 and at most 16")?;
        for (option, share) in [("detail", self.detail), ("floor", self.floor), ("midtones", self.midtones)] {
            range(option, share, 0.0, 1.0, "between 0 and 1")?;
        }
        range("relax", f64::from(self.relax), 0.0, 100.0, "between 0 and 100 steps")?;
        range("k1", self.k1, 0.0, 1000.0, "between 0 and 1000")?;
        range("k2", self.k2, 0.0, 1000.0, "between 0 and 1000 per pixel")?;
        range("base", self.base, 0.0, 1.0, "between 0 and 1")?;
        range("detail_gain", self.detail_gain, 0.0, 1000.0, "between 0 and 1000")?;
        range("rings", f64::from(self.rings), 1.0, 16.0, "between 1 and 16")?;
        for (option, alpha) in [("importance_alpha", self.importance_alpha), ("alpha", self.alpha)] {
            if let Alpha::Constant(value) = alpha {
                range(option, value, 0.0, 1.0, "\"tonal\", \"dynamic\" or a number between 0 and 1")?;
            }
        }
        range("refine", f64::from(self.refine), 0.0, 100.0, "between 0 and 100 sweeps")?;
        range("crispness", self.crispness, 0.0, 100.0, "between 0 and 100")?;
        range("cohesion", self.cohesion, 0.0, 100.0, "between 0 and 100")?;
        if let Some(tone_tolerance) = self.tone_tolerance {
            range("tone_tolerance", tone_tolerance, 0.0, 1.0, "between 0 and 1")?;
        }
        range("split", f64::from(self.split), 0.0, 12.0, "between 0 and 12 nodes")?;
        range("sharpen", self.sharpen, 0.0, 100.0, "between 0 and 100")?;
        range("local_contrast", self.local_contrast, 0.0, 100.0, "between 0 and 100")?;
        range("stipple_scale", self.stipple_scale, ABOVE_ZERO, 4.0, "above 0 and at most 4")?;
        range("stipple_min", self.stipple_min, 0.0, 1000.0, "between 0 and 1000 pixels")?;
        if let Some(largest) = self.stipple_max {
            range("stipple_max", largest, ABOVE_ZERO, 1000.0, "above 0 and at most 1000 pixels")?;
            range("stipple_max", largest, self.stipple_min, f64::INFINITY, "at least stipple_min")?;
        }
        range("irregularity", self.irregularity, 0.0, 1.0, "between 0 and 1")?;
        if self.seed > MAX_SEED {
            let value = self.seed.to_string();
            return Err(Error::Option { option: "seed", value, allowed: "between 0 and 9007199254740992" });
        }
        range("tolerance", self.tolerance, 0.0, 2.0, "between 0 and 2 pixels")?;
        range("gamma", self.gamma, 0.1, 10.0, "between 0.1 and 10")?;
        range("contrast", self.contrast, 0.0, 10.0, "between 0 and 10")?;
        if let Some(threads) = self.threads {
            range("threads", threads as f64, 1.0, 1024.0, "between 1 and 1024")?;
        }
        crate::base::parse_color(&self.background)?;
        Ok(())
    }

    /// Lattice density and node budget on a canvas of `pixels` pixels.
    ///
    /// With a density alone there is no budget, as in the paper. With a budget alone the lattice is as fine as it needs:
    /// 1 / 0.3 lattice nodes for every node kept. With neither, the budget is `fineness` times 0.3 nodes a pixel and at most
    /// `fineness` times 300,000.
    pub fn budget(&self, pixels: f64) -> Budget {
        let asked = self.nodes.map(|n| n as f64).or(self.nodes_per_pixel.map(|n| n * pixels));
        let nodes = match (asked, self.density) {
            (Some(nodes), _) => Some(nodes),
            (None, Some(_)) => None,
            (None, None) => Some(self.fineness * (DEFAULT_NODES_PER_PIXEL * pixels).min(DEFAULT_MAX_NODES)),
        };
        let fitting = nodes.map_or(1.0, |n| (n / (DEFAULT_NODES_PER_PIXEL * pixels)).min(16.0));
        let density = self.density.unwrap_or(fitting);
        // What an importance keeps without a budget is known only after the diffusion: about as much as the default budget.
        let kept = nodes.unwrap_or(DEFAULT_NODES_PER_PIXEL * density * pixels);
        Budget { density, nodes, spacing: (2.0 / 3f64.sqrt() * pixels / kept).sqrt() }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn options_survive_json() {
        let options = Options { alpha: Alpha::Constant(0.25), density: Some(1.5), ..Options::default() };
        let json = serde_json::to_string(&options).unwrap();
        assert!(json.contains("\"importance_alpha\":1.0") && json.contains("\"alpha\":0.25"), "{json}");
        assert_eq!(serde_json::from_str::<Options>(&json).unwrap(), options);
        assert!(serde_json::from_str::<Options>("{\"densty\":1}").is_err());
    }

    #[test]
    fn validate_names_the_option_the_value_and_the_range() {
        let error = Options { gamma: f64::NAN, ..Options::default() }.validate().unwrap_err().to_string();
        assert_eq!(error, "gamma is NaN, but it must be between 0.1 and 10");
        assert!(Options { density: Some(0.0), ..Options::default() }.validate().is_err());
        assert!(Options { nodes: Some(10), nodes_per_pixel: Some(0.1), ..Options::default() }.validate().is_err());
        Options::paper().validate().unwrap();
    }

    #[test]
    fn the_largest_stipple_is_not_below_the_least_and_a_seed_is_exact_in_json() {
        let radii =
            |stipple_min, stipple_max| Options { stipple_min, stipple_max: Some(stipple_max), ..Options::default() }.validate();
        radii(2.0, 2.0).unwrap();
        assert_eq!(radii(2.0, 1.5).unwrap_err().to_string(), "stipple_max is 1.5, but it must be at least stipple_min");
        assert!(radii(0.0, 0.0).is_err());
        let seeded = |seed| Options { seed, ..Options::default() }.validate();
        seeded(1 << 53).unwrap();
        assert_eq!(
            seeded((1 << 53) + 1).unwrap_err().to_string(),
            "seed is 9007199254740993, but it must be between 0 and 9007199254740992"
        );
    }

    #[test]
    fn the_default_budget_is_capped_and_the_lattice_follows_it() {
        let small = Options::default().budget(100_000.0);
        assert_eq!((small.density, small.nodes), (1.0, Some(30_000.0)));
        let large = Options::default().budget(24e6);
        assert_eq!((large.density, large.nodes), (1.0 / 24.0, Some(300_000.0)));
        let paper = Options::paper().budget(24e6);
        assert_eq!((paper.density, paper.nodes), (1.0, None));
        assert!((small.spacing - 1.96).abs() < 0.01 && (paper.spacing - small.spacing).abs() < 1e-9 && large.spacing > 9.0);
    }
}
