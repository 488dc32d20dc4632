//! Areas moved in and out. In: polygons with holes, in mm, and a distance; out: polygons again, simplified to a hundredth of a mm. Source: our own,
//! over the crate `i_overlay`.
//!
//! A polygon is a list of rings, closed without a repeated point: its exterior, whose signed area is positive (x right, y down), then
//! its holes, whose areas are negative. Polygons that go in are disjoint, and so are those that come out. The same
//! polygons always give the same, whatever the number of threads.

mod needles;
mod offset;
mod simplify;

pub use offset::{Polygon, area, closed, intersection, offset, opened, subtracted, united};
pub(crate) use simplify::keep;
pub use simplify::{SIMPLIFIED, simplified, simplified_line};
