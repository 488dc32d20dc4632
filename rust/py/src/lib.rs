//! The extension module `graphstipple._core`: extract, detach from the interpreter, call, convert; nothing else.
//!
//! Long work runs on a thread of its own that never calls Python ([`watch`]), but to ask Pillow ([`fallback`]) and OpenCV ([`subject`]); core errors become Python exceptions in one place
//! ([`errors`]). What this crate does not do: check or convert what users pass (that is Python's, where the copies are visible),
//! and anything of the method itself (that is the core's).

mod arrays;
mod drawing;
mod errors;
mod fallback;
mod options;
mod photo;
mod plot;
mod recipe;
mod rules;
mod session;
mod stages;
mod subject;
mod values;
mod watch;
mod within;

use pyo3::prelude::*;

/// The Rust half of graphstipple; import `graphstipple` instead.
#[pymodule]
mod _core {
    #[pymodule_export]
    use crate::drawing::{Drawing, draw, load, unpacked};
    #[pymodule_export]
    use crate::options::{Options, formats, of_preset, options_schema, presets, settings, sources};
    #[pymodule_export]
    use crate::photo::{Photo, Reading, adjust, luma_to_u8, photo, read_photo, saliency};
    #[pymodule_export]
    use crate::plot::{Plot, machines, of_drawing, pen_settings};
    #[pymodule_export]
    use crate::recipe::{Recipe, flags};
    #[pymodule_export]
    use crate::rules::{Report, Rules, check, enforce, processes};
    #[pymodule_export]
    use crate::session::Session;
    #[pymodule_export]
    use crate::stages::{
        cells, clean, components, diffuse, emphasize, grounds, lattice, lattice_labels, mixed_importance, offset, outline, owners,
        refine, relax, samples_per_pixel, split, stipple, triangulate,
    };
    use crate::watch;
    #[pymodule_export]
    use crate::within::Trials;
    use pyo3::prelude::*;
    use std::ffi::OsString;

    #[pymodule_init]
    fn init(_module: &Bound<'_, PyModule>) -> PyResult<()> {
        graphstipple_cli::files::set_fallback(crate::fallback::by_pillow);
        graphstipple_cli::files::set_segmenter(crate::subject::by_opencv);
        Ok(())
    }

    /// The version of graphstipple.
    #[pymodule_export]
    #[allow(non_upper_case_globals, reason = "Python's name for it")]
    const __version__: &str = env!("CARGO_PKG_VERSION");

    /// The most pixels that an image may have.
    #[pymodule_export]
    const MAX_PIXELS: u64 = graphstipple_core::stages::MAX_PIXELS;

    /// What is said of a mask that shows no subject.
    #[pymodule_export]
    const NO_SUBJECT: &str = graphstipple_cli::files::NO_SUBJECT;

    /// Runs the command line with these arguments (the program's name first) and returns its exit code.
    #[pyfunction]
    fn cli(py: Python<'_>, args: Vec<OsString>) -> u8 {
        py.detach(|| graphstipple_cli::run(args, &watch::interrupted))
    }
}
