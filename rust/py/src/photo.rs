//! Photos to luma, and luma to saliency.

use std::path::PathBuf;

use graphstipple_cli::files;
use graphstipple_core::stages::{self as core, Pixels, Samples, fine_grained};
use numpy::{Element, PyArray2, PyReadonlyArray2, PyReadonlyArray3, PyUntypedArrayMethods};
use pyo3::prelude::*;

use crate::options::Options;
use crate::{arrays, errors, watch};

/// The luma of an image file, (height, width) in [0, 1], its transparency laid over the background (R, G, B).
#[pyfunction]
pub(crate) fn read_luma(py: Python<'_>, path: PathBuf, background: [u8; 3]) -> PyResult<Bound<'_, PyArray2<f32>>> {
    let field = watch::run(py, None, errors::from_files, move |_| files::read_photo(&path, background))?;
    arrays::from_field(py, field)
}

/// Samples of an image, owned.
enum Owned {
    U8(Vec<u8>),
    U16(Vec<u16>),
    F32(Vec<f32>),
}

/// The luma of samples (height, width, channels) of uint8, uint16 or float32, (height, width) in [0, 1].
#[pyfunction]
pub(crate) fn luma<'py>(py: Python<'py>, samples: &Bound<'py, PyAny>, background: [u8; 3]) -> PyResult<Bound<'py, PyArray2<f32>>> {
    fn copied<T: Element + Copy>(array: &PyReadonlyArray3<'_, T>) -> Vec<T> {
        array.as_array().iter().copied().collect()
    }
    let (shape, samples) = if let Ok(array) = samples.extract::<PyReadonlyArray3<'_, u8>>() {
        (array.shape().to_vec(), Owned::U8(copied(&array)))
    } else if let Ok(array) = samples.extract::<PyReadonlyArray3<'_, u16>>() {
        (array.shape().to_vec(), Owned::U16(copied(&array)))
    } else if let Ok(array) = samples.extract::<PyReadonlyArray3<'_, f32>>() {
        (array.shape().to_vec(), Owned::F32(copied(&array)))
    } else {
        return Err(errors::invalid("the samples must be a three-dimensional array of uint8, uint16 or float32"));
    };
    let field = watch::run_core(py, move |_| {
        let samples = match &samples {
            Owned::U8(values) => Samples::U8(values),
            Owned::U16(values) => Samples::U16(values),
            Owned::F32(values) => Samples::F32(values),
        };
        core::luma(&Pixels { width: shape[1], height: shape[0], channels: shape[2], samples }, background)
    })?;
    arrays::from_field(py, field)
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
