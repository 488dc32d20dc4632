//! The options of a drawing: plain data with documented defaults, units and ranges, and one [`Options::validate`].
//!
//! The same names, defaults and ranges hold in Rust, Python, the command line and the metadata of a drawing (as JSON, by serde).

use serde::{Deserialize, Serialize};

use crate::error::{Error, Result};

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
#[derive(Debug, Clone, Copy, PartialEq, Default, Serialize, Deserialize)]
#[serde(untagged, from = "AlphaForm", into = "AlphaForm")]
pub enum Alpha {
    /// `base + detail_gain * |I0 - A|` if the label fell on the side of 0.5 where the node's own value lies, else 0.
    #[default]
    Dynamic,
    /// The same share for every node: 1 is plain halftoning, 0 is thresholding. In [0, 1].
    Constant(f64),
}

/// How [`Alpha`] looks in JSON: the word "dynamic" or a number.
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
}

impl From<AlphaForm> for Alpha {
    fn from(form: AlphaForm) -> Self {
        match form {
            AlphaForm::Word(AlphaWord::Dynamic) => Self::Dynamic,
            AlphaForm::Number(value) => Self::Constant(value),
        }
    }
}

impl From<Alpha> for AlphaForm {
    fn from(alpha: Alpha) -> Self {
        match alpha {
            Alpha::Dynamic => Self::Word(AlphaWord::Dynamic),
            Alpha::Constant(value) => Self::Number(value),
        }
    }
}

/// Everything that shapes a drawing besides the photo and the importance map.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct Options {
    /// The first graph.
    pub lattice: LatticeKind,
    /// Lattice nodes per pixel, in (0, 16]. `None`: as fine as the node budget needs, and no finer.
    pub density: Option<f64>,
    /// Node budget: how many nodes to keep, at least 3 (within 2 %). At most one of `nodes` and `nodes_per_pixel`.
    pub nodes: Option<u64>,
    /// Node budget per pixel, in (0, 16].
    pub nodes_per_pixel: Option<f64>,
    /// Lloyd steps between the two graphs, 0 to 100.
    pub relax: u32,
    /// Weight of the difference of values between two nodes, in [0, 1000].
    pub k1: f64,
    /// Weight of the distance between two nodes, per pixel, in [0, 1000].
    pub k2: f64,
    /// Dynamic alpha where there is no detail, in [0, 1].
    pub base: f64,
    /// The paper's lambda: how much dynamic alpha grows with |value - local mean|, in [0, 1000].
    pub detail_gain: f64,
    /// Radius of the local mean in rings of the graph, 1 to 16.
    pub rings: u32,
    /// Alpha of the first diffusion (importance on the lattice).
    pub importance_alpha: Alpha,
    /// Alpha of the second diffusion (tone on the Delaunay graph).
    pub alpha: Alpha,
    /// A stipple's area relative to its node's cell, in (0, 4].
    pub stipple_scale: f64,
    /// How far the curves of regions may lie from the splines through the midpoints of the graph's edges, in pixels, in [0, 2]:
    /// more means fewer points. 0 keeps every midpoint.
    pub tolerance: f64,
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
            relax: 1,
            k1: 1.0,
            k2: 0.1,
            base: 0.5,
            detail_gain: 6.0,
            rings: 1,
            importance_alpha: Alpha::Dynamic,
            alpha: Alpha::Dynamic,
            stipple_scale: 1.0,
            tolerance: 0.25,
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

/// What [`Options::density`] and the budget options come to for a canvas.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Budget {
    /// Lattice nodes per pixel.
    pub density: f64,
    /// How many nodes to keep; `None`: whatever the importance keeps.
    pub nodes: Option<f64>,
}

impl Options {
    /// The paper's settings: density 1, no node budget, one Lloyd step, k1 = 1, k2 = 0.1, base = 0.5, lambda = 6, dynamic alpha,
    /// every midpoint kept.
    pub fn paper() -> Self {
        Self { density: Some(1.0), tolerance: 0.0, ..Self::default() }
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
        range("relax", f64::from(self.relax), 0.0, 100.0, "between 0 and 100 steps")?;
        range("k1", self.k1, 0.0, 1000.0, "between 0 and 1000")?;
        range("k2", self.k2, 0.0, 1000.0, "between 0 and 1000 per pixel")?;
        range("base", self.base, 0.0, 1.0, "between 0 and 1")?;
        range("detail_gain", self.detail_gain, 0.0, 1000.0, "between 0 and 1000")?;
        range("rings", f64::from(self.rings), 1.0, 16.0, "between 1 and 16")?;
        for (option, alpha) in [("importance_alpha", self.importance_alpha), ("alpha", self.alpha)] {
            if let Alpha::Constant(value) = alpha {
                range(option, value, 0.0, 1.0, "\"dynamic\" or a number between 0 and 1")?;
            }
        }
        range("stipple_scale", self.stipple_scale, ABOVE_ZERO, 4.0, "above 0 and at most 4")?;
        range("tolerance", self.tolerance, 0.0, 2.0, "between 0 and 2 pixels")?;
        range("gamma", self.gamma, 0.1, 10.0, "between 0.1 and 10")?;
        range("contrast", self.contrast, 0.0, 10.0, "between 0 and 10")?;
        if let Some(threads) = self.threads {
            range("threads", threads as f64, 1.0, 1024.0, "between 1 and 1024")?;
        }
        crate::tone::parse_color(&self.background)?;
        Ok(())
    }

    /// Lattice density and node budget on a canvas of `pixels` pixels.
    ///
    /// With a density alone there is no budget, as in the paper. With a budget alone the lattice is as fine as it needs:
    /// 1 / 0.3 lattice nodes for every node kept. With neither, the budget is 0.3 nodes a pixel and at most 300,000.
    pub fn budget(&self, pixels: f64) -> Budget {
        let asked = self.nodes.map(|n| n as f64).or(self.nodes_per_pixel.map(|n| n * pixels));
        let nodes = match (asked, self.density) {
            (Some(nodes), _) => Some(nodes),
            (None, Some(_)) => None,
            (None, None) => Some((DEFAULT_NODES_PER_PIXEL * pixels).min(DEFAULT_MAX_NODES)),
        };
        let fitting = nodes.map_or(1.0, |n| (n / (DEFAULT_NODES_PER_PIXEL * pixels)).min(16.0));
        Budget { density: self.density.unwrap_or(fitting), nodes }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn options_survive_json() {
        let options = Options { alpha: Alpha::Constant(0.25), density: Some(1.5), ..Options::default() };
        let json = serde_json::to_string(&options).unwrap();
        assert!(json.contains("\"importance_alpha\":\"dynamic\"") && json.contains("\"alpha\":0.25"), "{json}");
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
    fn the_default_budget_is_capped_and_the_lattice_follows_it() {
        let small = Options::default().budget(100_000.0);
        assert_eq!((small.density, small.nodes), (1.0, Some(30_000.0)));
        let large = Options::default().budget(24e6);
        assert_eq!((large.density, large.nodes), (1.0 / 24.0, Some(300_000.0)));
        assert_eq!(Options::paper().budget(24e6), Budget { density: 1.0, nodes: None });
    }
}
