//! Options cross the boundary as JSON, the form that a drawing's metadata has too.

use graphstipple_core::stages::{Inks, Source};
use graphstipple_core::{Error, Options, presets as core_presets};
use pyo3::prelude::*;
use serde_json::{Map, Value};

use crate::errors;

/// Options from JSON, every value in its range.
///
/// # Errors
/// `InvalidInputError` that names the option, its value and what is allowed.
pub(crate) fn parse(json: &str) -> PyResult<Options> {
    let wrong = |error: serde_json::Error| errors::invalid(format!("the options are not valid: {error}"));
    let values: Map<String, Value> = serde_json::from_str(json).map_err(wrong)?;
    // One by one first: serde's message for the whole does not say which option has the wrong type.
    for (name, value) in &values {
        let alone = Value::Object(Map::from_iter([(name.clone(), value.clone())]));
        if let Err(error) = serde_json::from_value::<Options>(alone) {
            let allowed = match name.as_str() {
                "alpha" | "importance_alpha" => "it must be \"tonal\", \"dynamic\" or a number between 0 and 1".to_owned(),
                "seed" => "it must be a whole number between 0 and 9007199254740992".to_owned(),
                "tone_tolerance" => "it must be None or a number between 0 and 1".to_owned(),
                "importance_order" | "order" => "it must be \"rows\" or \"global\"".to_owned(),
                "carry" => "it must be \"value\" or \"area\"".to_owned(),
                "crossings" => "it must be \"midpoint\" or \"tone\"".to_owned(),
                _ => in_plain_words(&error.to_string()),
            };
            return Err(errors::invalid(format!("{name} is {value}, but {allowed}")));
        }
    }
    let options: Options = serde_json::from_value(Value::Object(values)).map_err(wrong)?;
    options.validate().map_err(errors::from_core)?;
    Ok(options)
}

/// What serde expected, without Rust's names of types.
fn in_plain_words(message: &str) -> String {
    let Some((_, expected)) = message.rsplit_once("expected ") else {
        return message.to_owned();
    };
    let plain = match expected.split(" at line").next().unwrap_or(expected) {
        "f64" => "a number",
        "u32" | "u64" | "usize" => "a whole number",
        "a boolean" => "True or False",
        "a string" => "text",
        other => other,
    };
    format!("it must be {plain}")
}

fn to_json(options: &Options) -> PyResult<String> {
    serde_json::to_string(options).map_err(|error| errors::from_core(Error::Internal(error.to_string())))
}

/// Check options given as JSON and return them in full, defaults included (threads left out, as in a drawing's metadata).
#[pyfunction]
pub(crate) fn validated_options(json: &str) -> PyResult<String> {
    to_json(&parse(json)?)
}

/// The default options as JSON.
#[pyfunction]
pub(crate) fn default_options() -> PyResult<String> {
    to_json(&Options::default())
}

/// A preset's options as JSON.
#[pyfunction]
pub(crate) fn preset_options(name: &str) -> PyResult<String> {
    to_json(&core_presets::preset(name).map_err(errors::from_core)?.options)
}

/// Name, description and inks of every preset.
#[pyfunction]
pub(crate) fn presets() -> Vec<(&'static str, &'static str, &'static str)> {
    let inks = |inks| match inks {
        Inks::Black => "black",
        Inks::White => "white",
        Inks::Both => "both",
    };
    core_presets::presets().into_iter().map(|preset| (preset.name, preset.description, inks(preset.inks))).collect()
}

/// What an importance name stands for: "saliency", "constant" or "file".
#[pyfunction]
pub(crate) fn importance_source(name: &str) -> PyResult<&'static str> {
    Ok(match Source::parse(name).map_err(errors::from_core)? {
        Source::Saliency => "saliency",
        Source::Constant(_) => "constant",
        Source::File(_) => "file",
    })
}
