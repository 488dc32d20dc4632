//! Options and settings: the metadata of a drawing as JSON, and words as a command line has them.
#![no_main]

use fuzz::{check_error, prepare};
use graphstipple_core::stages::{DECLARATIONS, Declaration, Value, named_length, preset};
use graphstipple_core::{Export, Format, Options, Result};
use libfuzzer_sys::fuzz_target;

fuzz_target!(|data: &[u8]| {
    prepare();
    let Ok(text) = std::str::from_utf8(data) else { return };
    if let Ok(serde_json::Value::Object(json)) = serde_json::from_str(text) {
        told(Options::from_json(&json).and_then(checked));
    }
    // Lines of a name and a value, set one after the other.
    let (mut options, mut export) = (Options::default(), Export::default());
    for line in text.lines().take(50) {
        let (name, word) = line.split_once('=').unwrap_or((line, ""));
        if let Some(declaration) = told(Declaration::named(name)) {
            told(options.set(name, &declaration.parse(word)));
        }
        if let Some(preset) = told(preset(word)) {
            options = preset.options;
        }
        told(export.set(name, &Value::Word(word.to_owned())));
        let number = word.parse().map(Value::Number);
        if let Ok(number) = &number {
            told(export.set(name, number));
            told(options.set(name, number));
        }
        told(named_length(name, &number.unwrap_or(Value::Foreign(word.to_owned()))));
        told(Format::of_suffix(word));
    }
    told(checked(options));
    for format in Format::ALL {
        let writer = told(export.clone().check().and_then(|export| format.writer(export)));
        for [width, height] in [[1, 1], [640, 480], [65_535, 1], [0, 7]] {
            writer.as_ref().map(|writer| told(writer.check_size(width, height)));
        }
    }
});

/// What was made, unless it is an error, which then has to be for the user.
fn told<T>(result: Result<T>) -> Option<T> {
    result.inspect_err(check_error).ok()
}

/// Options that keep their rules can be written and read again, and say how far photos are reduced.
fn checked(options: Options) -> Result<()> {
    let checked = options.check()?;
    let again = Options::from_json(&checked.to_json())?;
    let threads = DECLARATIONS.iter().find(|declaration| declaration.name == "threads").map(|threads| threads.value(&checked));
    let mut again_with_threads = again;
    threads.map(|threads| again_with_threads.set("threads", &threads)).transpose()?;
    assert_eq!(*checked, again_with_threads);
    for [width, height] in [[1, 1], [65_535, 3815], [15_000, 15_000]] {
        let factor = checked.reduction(width, height);
        assert!(factor >= 1 && factor <= width.min(height));
    }
    Ok(())
}
