//! NumPy arrays to the core's slices and structs, and back. Results move into their arrays without a copy where the layouts agree.

use graphstipple_core::Field;
use numpy::ndarray::Array2;
use numpy::{Element, IntoPyArray, PyArray2, PyArrayMethods, PyReadonlyArray1, PyReadonlyArray2, PyUntypedArrayMethods};
use pyo3::prelude::*;

use crate::errors;

/// A field of its own from an array (height, width).
///
/// # Errors
/// `InvalidInputError` as [`Field::new`].
pub(crate) fn field(array: &PyReadonlyArray2<'_, f32>) -> PyResult<Field> {
    let shape = array.shape();
    Field::new(shape[1], shape[0], array.as_array().iter().copied().collect()).map_err(errors::from_core)
}

/// An array (height, width) from a field.
pub(crate) fn from_field(py: Python<'_>, field: Field) -> PyResult<Bound<'_, PyArray2<f32>>> {
    let shape = [field.height(), field.width()];
    field.into_values().into_pyarray(py).reshape(shape)
}

/// The rows of an array (n, 2).
///
/// # Errors
/// `InvalidInputError` if the array has other than two columns.
pub(crate) fn pairs<T: Element + Copy>(name: &str, array: &PyReadonlyArray2<'_, T>) -> PyResult<Vec<[T; 2]>> {
    if array.shape()[1] != 2 {
        return Err(errors::invalid(format!("{name} has the shape {:?}, but it must be (n, 2)", array.shape())));
    }
    Ok(array.as_array().rows().into_iter().map(|row| [row[0], row[1]]).collect())
}

/// An array (n, 2) with these rows.
pub(crate) fn from_pairs<T: Element>(py: Python<'_>, pairs: Vec<[T; 2]>) -> PyResult<Bound<'_, PyArray2<T>>> {
    let rows = pairs.len();
    from_rows(py, [rows, 2], pairs.into_iter().flatten().collect())
}

/// An array of this shape with these values, row by row.
pub(crate) fn from_rows<T: Element>(py: Python<'_>, shape: [usize; 2], values: Vec<T>) -> PyResult<Bound<'_, PyArray2<T>>> {
    let array = Array2::from_shape_vec(shape, values).map_err(|error| errors::invalid(error.to_string()))?;
    Ok(array.into_pyarray(py))
}

/// The values of an array (n,).
pub(crate) fn values<T: Element + Copy>(array: &PyReadonlyArray1<'_, T>) -> Vec<T> {
    array.as_array().to_vec()
}
