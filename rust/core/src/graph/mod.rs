//! Graphs on the canvas. In: sizes or sites, and labels; out: the lattice, the Delaunay graph of any sites, their cells, and the
//! connected components of equal labels. Source: the paper; closed forms and tiles are our own.

mod cells;
mod components;
mod graph;
mod lattice;
mod tiles;
mod triangulation;

pub(crate) use cells::cell_means;
pub use cells::{Cells, TonedCells, cells, lattice_means, owners, samples_per_pixel, toned_cells};
pub(crate) use cells::{Samples, centroid_of, check_sampling};
pub use components::{Components, components};
pub use graph::{Adjacency, FRAME_MARGIN, Graph};
pub(crate) use graph::{check_areas, check_finite, check_labels, check_one_a_node, distance_squared};
pub use lattice::Lattice;
pub(crate) use triangulation::Edges;
pub use triangulation::{Beside, Triangulation, triangulate};
