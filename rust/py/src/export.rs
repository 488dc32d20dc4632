//! How a file is written crosses the boundary as JSON too: sizes are numbers or text with a unit, as on the command line.

use graphstipple_core::Export;
use graphstipple_core::stages::Length;
use pyo3::prelude::*;
use serde::de::DeserializeOwned;
use serde_json::{Map, Value};

use crate::errors;

/// An export from JSON: `style`, `inks`, `one_bit`, and a `layout` with `width`, `margin`, `page` and `dpi`.
///
/// # Errors
/// `InvalidInputError` that names the argument, its value and what is allowed.
pub(crate) fn parse(json: &str) -> PyResult<Export> {
    let wrong = |error: serde_json::Error| errors::invalid(format!("the arguments are not valid: {error}"));
    let values: Map<String, Value> = serde_json::from_str(json).map_err(wrong)?;
    // One by one first: serde's message for the whole does not say which argument is wrong.
    let alone = |name: &str, value: Value| Value::Object(Map::from_iter([(name.to_owned(), value)]));
    for (name, value) in &values {
        match value {
            Value::Object(sizes) => {
                for (size, value) in sizes {
                    named::<Export>(size, value, alone(name, alone(size, value.clone())))?;
                }
            }
            _ => {
                named::<Export>(name, value, alone(name, value.clone()))?;
            }
        }
    }
    let export: Export = serde_json::from_value(Value::Object(values)).map_err(wrong)?;
    export.validate().map_err(errors::from_core)?;
    Ok(export)
}

/// A length from JSON: a number of pixels, or text with a unit.
///
/// # Errors
/// As [`parse`].
pub(crate) fn length(name: &str, json: &str) -> PyResult<Length> {
    let value: Value = serde_json::from_str(json).map_err(|error| errors::invalid(format!("{name} is not valid: {error}")))?;
    named(name, &value, value.clone())
}

/// What `json` stands for; the error says that it is the argument `name` with this value.
fn named<T: DeserializeOwned>(name: &str, value: &Value, json: Value) -> PyResult<T> {
    serde_json::from_value(json).map_err(|error| {
        let reason = error.to_string();
        // The core's sentence for a length does not know which one it is, and serde has words of its own: what is allowed counts.
        let allowed = reason.split_once("but it must be ").or_else(|| reason.split_once("expected "));
        let Some((_, allowed)) = allowed else { return errors::invalid(format!("{name} is not valid: {reason}")) };
        errors::invalid(format!("{name} is {value}, but it must be {}", allowed.replace('`', "\"")))
    })
}
