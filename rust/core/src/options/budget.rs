//! How many nodes the options ask for on a canvas.

use std::borrow::Cow;

use super::{Options, Published};

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

/// Fewer nodes make no triangle.
const LEAST_NODES: f64 = 3.0;

/// Pixels that a photo keeps for every node at least, where it is reduced: five times as many as the nodes of a smaller photo have by
/// default ([`DEFAULT_NODES_PER_PIXEL`]), so that even where the importance draws them together each has pixels of its own. Fewer would
/// be seen; more cost memory and time for what is averaged away over the nodes' cells.
pub const PIXELS_PER_NODE: f64 = 16.0;

/// Pixels that it keeps at least, however few its nodes are: 512 x 512. Below a megapixel no photo is reduced, as it costs nothing to
/// keep, and saliency looks a hundred pixels around.
pub const LEAST_PIXELS: f64 = 262_144.0;

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

    /// The whole factor by which a photo of `width` x `height` pixels is reduced before it is drawn: the largest that leaves it
    /// [`PIXELS_PER_NODE`] pixels for every node and [`LEAST_PIXELS`] in all; 1 if there is none above. The nodes are those of the
    /// budget, and those that a given density stands for. By default that is 1 below 19.2 megapixels and 7 for 250.
    pub fn reduction(&self, width: usize, height: usize) -> usize {
        let pixels = width as f64 * height as f64;
        let budget = self.budget(pixels);
        let of_density = self.published.density.map_or(0.0, |density| DEFAULT_NODES_PER_PIXEL * density * pixels);
        let kept = (PIXELS_PER_NODE * budget.nodes.unwrap_or(0.0).max(of_density)).max(LEAST_PIXELS);
        let leaves_enough = |factor: usize| kept * (factor * factor) as f64 <= pixels;
        (2..=width.min(height)).take_while(|factor| leaves_enough(*factor)).last().unwrap_or(1)
    }

    /// How many nodes a drawing on a canvas of `pixels` pixels may come to have: its budget, and without one all lattice nodes.
    pub fn most_nodes(&self, pixels: f64) -> f64 {
        let budget = self.budget(pixels);
        budget.nodes.unwrap_or(budget.density * pixels).max(LEAST_NODES)
    }

    /// The same drawing asked for more coarsely, where it may have more than so many nodes on a canvas of `pixels` pixels.
    pub fn with_at_most(&self, nodes: u64, pixels: f64) -> Cow<'_, Self> {
        if self.most_nodes(pixels) <= nodes as f64 {
            return Cow::Borrowed(self);
        }
        let published = Published { density: None, ..self.published };
        Cow::Owned(Self { nodes: Some(nodes), nodes_per_pixel: None, fineness: 1.0, published, ..self.clone() })
    }

    /// The same drawing asked for on a raster that is reduced by a whole factor, of a canvas of `pixels` pixels: nodes as on the canvas,
    /// and in the raster's pixels what the stages up to the labels measure in pixels. Outlines are made on the canvas.
    pub(crate) fn on_raster(&self, pixels: f64, factor: usize) -> Cow<'_, Self> {
        if factor == 1 {
            return Cow::Borrowed(self);
        }
        let k = factor as f64;
        let published = Published {
            density: self.published.density.map(|density| density * k * k),
            k2: self.published.k2 * k,
            ..self.published
        };
        let nodes = self.budget(pixels).nodes.map(|nodes| nodes.round().max(LEAST_NODES) as u64);
        Cow::Owned(Self { nodes, nodes_per_pixel: None, fineness: 1.0, published, ..self.clone() })
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

    #[test]
    fn a_photo_is_reduced_where_it_has_far_more_pixels_than_nodes() {
        let by = |options: &Options, width: usize, height: usize| options.reduction(width, height);
        let default = Options::default();
        for (width, height, factor) in [
            (4800, 3999, 1),
            (4800, 4000, 2),
            (6000, 4000, 2),
            (15_000, 16_666, 7),
            (65_535, 65_535, 29),
            (65_535, 1, 1),
            (1, 1, 1),
            (1024, 1023, 1),
        ] {
            assert_eq!(by(&default, width, height), factor, "{width} x {height}");
        }
        let few = Options { nodes: Some(1000), ..Options::default() };
        assert_eq!([(1024, 1023), (1024, 1024), (5120, 5120)].map(|(w, h)| by(&few, w, h)), [1, 2, 10]);
        // As many a pixel: at every size by as much.
        let sparse = Options { nodes_per_pixel: Some(0.005), ..Options::default() };
        assert_eq!([(500, 500), (2000, 1500), (10_000, 9000)].map(|(w, h)| by(&sparse, w, h)), [1, 3, 3]);
        // A density counts for the nodes that it gives, and the lattice that it asks for is had.
        assert_eq!(by(&Options::paper(), 15_000, 16_666), 1);
        let published = |density| Published { density: Some(density), ..Published::default() };
        assert_eq!(by(&Options { published: published(0.01), ..Options::paper() }, 6000, 4000), 4);
        assert_eq!(by(&Options { published: published(1.0), ..few.clone() }, 6000, 4000), 1);
        // Whatever is asked for, both sides are left.
        for options in [few, Options { fineness: 1e-9, ..Options::default() }] {
            for (width, height) in [(65_535, 17), (40, 65_535), (65_535, 65_535)] {
                let factor = by(&options, width, height);
                assert!(width / factor >= 8 && height / factor >= 8, "{factor}");
            }
        }
    }

    #[test]
    fn on_a_raster_options_ask_for_the_same_drawing() {
        let pixels = 24e6;
        let of = |options: &Options| options.on_raster(pixels, 2).into_owned();
        let default = Options { fineness: 0.5, ..Options::default() };
        assert_eq!(
            of(&default),
            Options { nodes: Some(150_000), published: Published { k2: 0.2, ..default.published }, ..Options::default() }
        );
        let (canvas, raster) = (default.budget(pixels), of(&default).budget(pixels / 4.0));
        assert_eq!((raster.density, raster.nodes), (4.0 * canvas.density, canvas.nodes));
        assert!((2.0 * raster.spacing - canvas.spacing).abs() < 1e-9);
        let published = Published { density: Some(0.01), ..Published::default() };
        let sparse = Options { nodes_per_pixel: Some(0.001), tolerance: 0.3, published, ..Options::default() };
        let made = of(&sparse);
        assert_eq!((made.published.density, made.nodes, made.nodes_per_pixel), (Some(0.04), Some(24_000), None));
        assert_eq!(made.tolerance, 0.3);
        assert!(matches!(sparse.on_raster(pixels, 1), Cow::Borrowed(_)));
        assert_eq!(of(&Options { published, ..Options::default() }).nodes, None);
    }

    #[test]
    fn a_coarse_drawing_has_at_most_so_many_nodes() {
        let pixels = 2e6;
        let published = Published { density: Some(2.0), ..Published::default() };
        for options in [
            Options::default(),
            Options { fineness: 4.0, ..Options::default() },
            Options { nodes_per_pixel: Some(0.1), ..Options::default() },
            Options { nodes: Some(70_000), published, ..Options::default() },
            Options { published, ..Options::default() },
        ] {
            let coarse = options.with_at_most(40_000, pixels);
            assert_eq!(coarse.most_nodes(pixels), 40_000.0);
            assert_eq!(coarse.clone().into_owned().check().unwrap().nodes, Some(40_000));
            assert_eq!(*options.with_at_most(10_000_000, pixels), options);
        }
        assert_eq!(Options { published, ..Options::default() }.most_nodes(pixels), 4e6);
    }
}
