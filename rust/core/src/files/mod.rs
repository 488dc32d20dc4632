//! A drawing as a file, and back. In: a [`Drawing`](crate::Drawing) and how it is to be written, an [`Export`]; out: SVG, PDF, EPS,
//! DXF, JSON or PNG; and drawings again, from SVG and JSON. Source: our own, after the specifications of the formats.

mod cubic;
mod dxf;
mod eps;
mod export;
mod json;
mod layers;
mod layout;
pub mod load;
mod pdf;
pub mod raster;
mod svg;

pub use dxf::to_dxf;
pub use eps::to_eps;
pub use export::Export;
pub use json::to_json;
pub use layers::{Area, Layer, Layers, Outline, Style};
pub use layout::{Layout, Length, Page, PixelPlacement, Placement, Sheet, Unit};
pub use pdf::to_pdf;
pub use svg::to_svg;
