//! Where the nodes of the drawing are. In: the importance on the canvas; out: the first graph with the nodes that are kept, and
//! their sites after Lloyd steps. Source: the paper; the scan and the budget are our own.

mod budget;
mod first_graph;
mod relaxation;
mod scan;

pub use first_graph::{FirstGraph, first_graph, kept_sites};
pub(crate) use first_graph::{keep, lattice_values};
pub use relaxation::relax;
pub use scan::diffuse_lattice;
