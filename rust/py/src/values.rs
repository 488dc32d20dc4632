//! Values of options and settings between Python and the core: objects in, objects out.

use graphstipple_core::stages::Value;
use pyo3::IntoPyObjectExt;
use pyo3::prelude::*;
use pyo3::types::{PyBool, PyDict, PyFloat, PyInt, PyList, PyString};
use serde_json::Value as Json;

/// A value that a user gave; what no option takes is kept as it shows itself.
pub(crate) fn from_python(object: &Bound<'_, PyAny>) -> PyResult<Value> {
    Ok(if object.is_none() {
        Value::Absent
    } else if let Ok(is_on) = object.cast::<PyBool>() {
        Value::Switch(is_on.is_true())
    } else if object.is_instance_of::<PyInt>() {
        match (object.extract::<u64>(), object.extract::<i64>()) {
            (Ok(whole), _) => Value::Whole(whole),
            (Err(_), Ok(negative)) => Value::Number(negative as f64),
            // Beyond what any option takes.
            (Err(_), Err(_)) => Value::Foreign(object.repr()?.to_string()),
        }
    } else if object.is_instance_of::<PyFloat>() {
        Value::Number(object.extract()?)
    } else if let Ok(word) = object.cast::<PyString>() {
        Value::Word(word.to_string())
    } else {
        Value::Foreign(object.repr()?.to_string())
    })
}

/// The object that stands for a value.
pub(crate) fn to_python(py: Python<'_>, value: &Value) -> PyResult<Py<PyAny>> {
    data(py, &value.into())
}

/// Data as Python has them: tables as dicts, lists as lists.
pub(crate) fn data(py: Python<'_>, json: &Json) -> PyResult<Py<PyAny>> {
    match json {
        Json::Null => Ok(py.None()),
        Json::Bool(is_on) => is_on.into_py_any(py),
        Json::Number(number) => match (number.as_u64(), number.as_i64()) {
            (Some(whole), _) => whole.into_py_any(py),
            (None, Some(whole)) => whole.into_py_any(py),
            (None, None) => number.as_f64().into_py_any(py),
        },
        Json::String(text) => text.into_py_any(py),
        Json::Array(values) => {
            let values = values.iter().map(|value| data(py, value)).collect::<PyResult<Vec<_>>>()?;
            PyList::new(py, values)?.into_py_any(py)
        }
        Json::Object(table) => table_of(py, table.iter().map(|(name, value)| (name.as_str(), value))),
    }
}

/// A dict of named data.
pub(crate) fn table_of<'a>(py: Python<'_>, values: impl Iterator<Item = (&'a str, &'a Json)>) -> PyResult<Py<PyAny>> {
    let table = PyDict::new(py);
    for (name, value) in values {
        table.set_item(name, data(py, value)?)?;
    }
    table.into_py_any(py)
}
