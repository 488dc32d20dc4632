//! The stages, each callable alone, and the data that they hand to one another; in the order of the data.
//!
//! A stage that works in parallel does so in the pool of threads that it is called in, as rayon's own functions do: [`Pool`] gives one.
//! [`draw`](crate::draw) and what reads and writes files make their own where there is none.

// What all stages share: the geometry of the canvas, inks and colours.
pub use crate::base::{Color, Ink, MOST_INKS, MOST_OVERPRINTED, NamedInk, Palette, Side, nearest, signed_area};
// Threads that the stages work on.
pub use crate::base::Pool;
// What options hold.
pub use crate::base::Checked;
pub use crate::options::{
    Absent, Alpha, Audience, Backdrop, Budget, Crossings, DECLARATIONS, DEFAULT_MAX_NODES, DEFAULT_NODES_PER_PIXEL, Declaration,
    DeclarationOf, Edge, ErrorWeighting, Group, InkList, LEAST_PIXELS, LatticeKind, Only, Order, PIXELS_PER_NODE, PUBLISHED, Point,
    Preset, Rule, Stage, Value, preset, schema, seconds, whole,
};
// From a photo to the tone, and its colour.
pub use crate::photo::{Colour, MAX_SIDE, Pixels, Samples, adjust, emphasize, luma, luma_to_u8};
// From files to photos.
pub use crate::decoding::{Decoded, MAX_FILE_BYTES, MAX_PIXELS, PhotoBuilder, Reading, Source as ImageSource, Tags, decode};
// Where detail is wanted.
pub use crate::importance::{KINDS, Kind, Source, fine_grained};
// Graphs, and what is found on them.
pub use crate::graph::{
    Adjacency, Beside, Cells, Components, FRAME_MARGIN, Graph, Lattice, TonedCells, Triangulation, cells, components,
    lattice_means, owners, samples_per_pixel, toned_cells, triangulate,
};
// Colours as mixtures of inks.
pub use crate::inks::{MOST_LABELS, Mixing, Mixture, extract, mixtures};
// Error diffusion on any graph.
pub use crate::diffusion::{Diffusion, diffuse, diffuse_inks, tonal_share};
// Where nodes are.
pub use crate::sites::{FirstGraph, diffuse_lattice, first_graph, kept_sites, relax};
// What is black and what is white.
pub use crate::labels::{Labels, Marks, OfInks, Refinement, STRUCTURED, Stippled, clean, grounds, refine, split, stipple};
// What has which of several inks.
pub use crate::labels::{Inked, NO_GROUND, clean_inks, grounds_inks, label_inks, refine_inks, split_inks, stipple_inks};
// From labels to shapes.
pub use crate::outlines::{Bands, Nodes, Outlines, Parts, Shaping, Stipple, Tones, crossing, outline};
// The drawing as data.
pub use crate::drawing::{DotChanges, Level, Mark, Provenance, Region, Ring, RingPart, Stats, Within, assemble};
// How files are written.
pub use crate::files::{
    Area, Curves, Dots, Elements, Ground, Layer, Layers, Layout, Length, Outline, Page, PixelPlacement, Placement, Plate, SETTINGS,
    Setting, Sheet, Style, Unit, Writer, named_length, raster,
};
// The whole method, giving back its memory as it goes.
pub use crate::pipeline::draw_owned;
// The finest drawing that is not too large.
pub use crate::pipeline::{Limits, Trials};
// Areas moved in and out.
pub use crate::offset::{
    Polygon, SIMPLIFIED, area, closed, intersection, offset, opened, simplified, simplified_line, subtracted, united,
};
// Paths for pens, and the machines that draw them.
pub use crate::plot::{
    Corner, Cornering, Fill, Limit, Machine, MachineFormat, PEN_SETTINGS, PROFILE_KEYS, Path, Pen, PenDots, PenOrder, PenSetting,
    Plot, PlotLayer, PlotStats, ProfileKey, ShippedProfile, Timing, Upward, ordered, picture, plot, travelled,
};
// What falls out of a stencil, and what keeps it in.
pub use crate::rules::{Bridge, Bridged, Bridging, Island, bridge, islands, islands_between, straight};
// What machines can make.
pub use crate::rules::{
    Changes, Islands, PROCESSES, Process, ProcessRule, RULES, Report, ReportFormat, Rules, Violation, ViolationKind, check, enforce,
};
