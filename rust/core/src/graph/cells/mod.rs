//! Voronoi cells on a grid of samples. In: sites on a canvas and a field; out: areas, centroids and means of the sites' cells.
//!
//! Two ways lead there: a pass over the tiles of the canvas, for any sites, and means over the cells of a lattice in closed form.
//! What this folder does not do: exact polygonal cells. Source: the paper (node values); how they are found is our own.

mod bins;
mod block;
mod lattice;
mod raster;
mod sampling;
mod sums;
mod voronoi;

pub use lattice::lattice_means;
pub(crate) use raster::Samples;
pub use sampling::samples_per_pixel;
pub(crate) use sampling::{centroid_of, check_sampling};
pub(crate) use voronoi::cell_means;
pub use voronoi::{Cells, TonedCells, cells, owners, toned_cells};
