//! How many nodes the options ask for on a canvas.

use super::Options;

/// Nodes that a drawing without `density`, `nodes` and `nodes_per_pixel` has at most, so that the effort does not grow with a
/// camera's megapixels: more than a print shows, and a few seconds of work.
pub const DEFAULT_MAX_NODES: f64 = 300_000.0;

/// Nodes per pixel of a drawing below that cap, and the share of lattice nodes that a budget keeps when no density is given:
/// enough lattice nodes to choose from, few enough to be quick.
pub const DEFAULT_NODES_PER_PIXEL: f64 = 0.3;

/// Nodes of such a drawing at least, however small the photo, up to [`MOST_NODES_PER_PIXEL`]: fewer are blobs. It is what 60 x 60 pixels
/// have anyway.
const DEFAULT_MIN_NODES: f64 = 1_080.0;

/// More nodes a pixel show nothing that the photo has.
const MOST_NODES_PER_PIXEL: f64 = 4.0;

/// What the density of [`super::Published`] and the budget options come to for a canvas.
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
    /// Lattice density and node budget on a canvas of `pixels` pixels.
    ///
    /// With a density alone there is no budget, as in the paper. With a budget alone the lattice is as fine as it needs:
    /// 1 / 0.3 lattice nodes for every node kept. With neither, the budget is `fineness` times 0.3 nodes a pixel, at most
    /// `fineness` times 300,000, and at least `fineness` times 1,080 or 4 a pixel.
    pub fn budget(&self, pixels: f64) -> Budget {
        let asked = self.nodes.map(|n| n as f64).or(self.nodes_per_pixel.map(|n| n * pixels));
        let nodes = match (asked, self.published.density) {
            (Some(nodes), _) => Some(nodes),
            (None, Some(_)) => None,
            (None, None) => Some(self.fineness * default_nodes(pixels)),
        };
        let fitting = nodes.map_or(1.0, |n| (n / (DEFAULT_NODES_PER_PIXEL * pixels)).min(16.0));
        let density = self.published.density.unwrap_or(fitting);
        // What an importance keeps without a budget is known only after the diffusion: about as much as the default budget.
        let kept = nodes.unwrap_or(DEFAULT_NODES_PER_PIXEL * density * pixels);
        Budget { density, nodes, spacing: (2.0 / 3f64.sqrt() * pixels / kept).sqrt() }
    }
}

fn default_nodes(pixels: f64) -> f64 {
    let least = DEFAULT_MIN_NODES.min(MOST_NODES_PER_PIXEL * pixels);
    (DEFAULT_NODES_PER_PIXEL * pixels).clamp(least, DEFAULT_MAX_NODES)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_default_budget_is_capped_and_the_lattice_follows_it() {
        let small = Options::default().budget(100_000.0);
        assert_eq!((small.density, small.nodes), (1.0, Some(30_000.0)));
        let tiny = Options::default().budget(256.0);
        assert_eq!((tiny.density, tiny.nodes), (4.0 / 0.3, Some(1024.0)));
        assert_eq!(Options::default().budget(2500.0).nodes, Some(1080.0));
        let large = Options::default().budget(24e6);
        assert_eq!((large.density, large.nodes), (1.0 / 24.0, Some(300_000.0)));
        let paper = Options::paper().budget(24e6);
        assert_eq!((paper.density, paper.nodes), (1.0, None));
        assert!((small.spacing - 1.96).abs() < 0.01 && (paper.spacing - small.spacing).abs() < 1e-9 && large.spacing > 9.0);
    }
}
