//! Photos to luma, as they are or reduced, and luma to saliency.

use std::path::PathBuf;

use graphstipple_cli::files;
use graphstipple_core::Photo as CorePhoto;
use graphstipple_core::stages::{self as core, Pixels, Reducer, Samples, fine_grained};
use numpy::{Element, PyArray2, PyReadonlyArray2, PyReadonlyArray3, PyUntypedArrayMethods};
use pyo3::prelude::*;

use crate::options::Options;
use crate::{arrays, errors, watch};

/// A photo or a map that was read, with the size of its canvas.
#[pyclass(frozen, module = "graphstipple._core")]
pub(crate) struct Photo {
    pub(crate) photo: CorePhoto,
}

#[pymethods]
impl Photo {
    /// A copy of the luma that is drawn, (height, width) in [0, 1].
    #[getter]
    fn luma<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyArray2<f32>>> {
        arrays::from_field(py, self.photo.luma().clone())
    }

    /// Width and height of the canvas in pixels.
    #[getter]
    fn size(&self) -> (usize, usize) {
        (self.photo.width(), self.photo.height())
    }

    /// By how much it was reduced; 1 if it is as it was.
    #[getter]
    fn factor(&self) -> usize {
        self.photo.factor()
    }
}

/// An image file, its transparency laid over the background (R, G, B), reduced as the options ask for; without options as it is.
#[pyfunction]
pub(crate) fn read_photo(py: Python<'_>, path: PathBuf, background: [u8; 3], options: Option<&Options>) -> PyResult<Photo> {
    let options = options.map(|options| options.checked.clone());
    let read = move |_: &_| files::read_photo(&path, background, options.as_deref());
    Ok(Photo { photo: watch::run(py, None, errors::from_files, read)? })
}

/// An image of samples (height, width, channels) of uint8, uint16 or float32, likewise.
#[pyfunction]
pub(crate) fn photo(py: Python<'_>, samples: &Bound<'_, PyAny>, background: [u8; 3], options: Option<&Options>) -> PyResult<Photo> {
    if let Ok(array) = samples.extract::<PyReadonlyArray3<'_, u8>>() {
        reduced(py, &array, |values| Samples::U8(values), background, options)
    } else if let Ok(array) = samples.extract::<PyReadonlyArray3<'_, u16>>() {
        reduced(py, &array, |values| Samples::U16(values), background, options)
    } else if let Ok(array) = samples.extract::<PyReadonlyArray3<'_, f32>>() {
        reduced(py, &array, |values| Samples::F32(values), background, options)
    } else {
        Err(errors::invalid("the samples must be a three-dimensional array of uint8, uint16 or float32"))
    }
}

/// Samples that are copied out of an array at once: few, so that Ctrl-C is heard and next to no memory is taken, and enough to be quick.
const COPIED: usize = 1 << 20;

/// The photo of an array, which is copied band by band: while a band is worked on, other Python threads may run and write to the array.
fn reduced<T: Element + Copy + Sync>(
    py: Python<'_>,
    array: &PyReadonlyArray3<'_, T>,
    samples: for<'a> fn(&'a [T]) -> Samples<'a>,
    background: [u8; 3],
    options: Option<&Options>,
) -> PyResult<Photo> {
    let &[height, width, channels] = array.shape() else { return Err(errors::invalid("the samples have no three dimensions")) };
    let factor = options.map_or(1, |options| options.checked.reduction(width, height));
    let mut reducer = Reducer::new(width, height, factor).map_err(errors::from_core)?;
    let all = array.as_slice().map_err(|error| errors::invalid(format!("the samples: {error}")))?;
    let rows = (COPIED / (width * channels).max(1)).max(1);
    for band in all.chunks((rows * width * channels).max(1)) {
        let band = band.to_vec();
        py.detach(|| {
            let pixels = Pixels { width, height: band.len() / (width * channels), channels, samples: samples(&band) };
            reducer.take(core::luma(&pixels, background)?.values());
            Ok(())
        })
        .map_err(errors::from_core)?;
        py.check_signals()?;
    }
    Ok(Photo { photo: reducer.finish().map_err(errors::from_core)? })
}

/// The tone of luma, (height, width) in [0, 1], adjusted as the options say.
#[pyfunction]
pub(crate) fn adjust<'py>(
    py: Python<'py>,
    luma: PyReadonlyArray2<'py, f32>,
    options: &Options,
) -> PyResult<Bound<'py, PyArray2<f32>>> {
    let options = options.checked.clone();
    let field = arrays::field(&luma)?;
    let tone = watch::run_core(py, move |_| core::adjust(&field, &options))?;
    arrays::from_field(py, tone)
}

/// Luma as 8-bit values, (height, width): what the saliency is computed on.
#[pyfunction]
pub(crate) fn luma_to_u8<'py>(py: Python<'py>, luma: PyReadonlyArray2<'py, f32>) -> PyResult<Bound<'py, PyArray2<u8>>> {
    let field = arrays::field(&luma)?;
    let shape = [field.height(), field.width()];
    arrays::from_rows(py, shape, py.detach(|| core::luma_to_u8(&field)))
}

/// The core's own fine-grained saliency of luma, (height, width) in [0, 1].
#[pyfunction]
pub(crate) fn saliency<'py>(py: Python<'py>, luma: PyReadonlyArray2<'py, f32>) -> PyResult<Bound<'py, PyArray2<f32>>> {
    let field = arrays::field(&luma)?;
    let map = watch::run_core(py, move |_| Ok(fine_grained(&core::luma_to_u8(&field), field.width(), field.height())))?;
    arrays::from_field(py, map)
}
