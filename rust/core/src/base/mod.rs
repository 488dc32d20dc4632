//! What every folder stands on: errors, progress, threads, pseudo-random numbers, colours, inks, and the geometry of the plane.
//! In: numbers and words; out: numbers, errors and progress, nothing of photos, graphs or drawings. Source: our own.

mod checked;
mod colour;
mod control;
mod error;
mod ink;
mod nearest;
mod noise;
mod palette;
mod paths;
mod plane;
mod pool;

pub use checked::Checked;
pub use colour::Color;
pub use control::Control;
pub(crate) use control::Step;
pub(crate) use error::in_one_line;
pub use error::{Error, Result};
pub use ink::Ink;
pub use nearest::nearest;
pub(crate) use nearest::or_nearest;
pub(crate) use noise::{mixed, noise};
pub(crate) use palette::Written as WrittenPalette;
pub use palette::{MOST_INKS, MOST_OVERPRINTED, NamedInk, Palette};
pub(crate) use paths::{
    POLYGON_REACH, ROOM, STAR_FILL, bend_of_cubic, bend_of_quad, circle_polygon, flatten_cubic, flatten_path, flatten_quad,
    flattened_edges, flattening_steps, flattening_tolerance, is_closed, is_mirrored,
};
pub(crate) use plane::{End, FINEST_GRID, Frame, Place, distance_to_segment, segments_meet, side_of, snap};
pub use plane::{Side, signed_area};
pub use pool::Pool;
