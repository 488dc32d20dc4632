//! Drawings as JSON: what begins as a document as it is, all else as shapes in a few bytes each, so that most inputs are curves and
//! dots that may lie anywhere.
#![no_main]

use fuzz::{Counting, examine_drawing, prepare};
use libfuzzer_sys::fuzz_target;
use serde_json::{Value, json};

#[global_allocator]
static COUNTING: Counting = Counting;

fuzz_target!(|data: &[u8]| {
    prepare();
    if data.first() == Some(&b'{') {
        examine_drawing(data, "json");
    } else {
        examine_drawing(document(data).as_bytes(), "json");
    }
});

/// Parts of a pixel in which places are given.
const PARTS: f64 = 8.0;

/// A document of a canvas, a grid, and as many shapes as the bytes are enough for.
fn document(bytes: &[u8]) -> String {
    let mut bytes = bytes.iter().copied();
    let mut byte = || bytes.next();
    let [width, height, kind] = [(); 3].map(|()| byte().unwrap_or(7));
    let (width, height) = (width % 32 + 1, height % 32 + 1);
    let (mut dots, mut curves) = (Vec::new(), Vec::new());
    while let Some(shape) = shape(&mut byte, [f64::from(width), f64::from(height)]) {
        if shape.is_object() { &mut dots } else { &mut curves }.push(shape);
    }
    let document = json!({
        "format": "graphstipple drawing", "version": "0", "importance": "none", "options": {},
        "canvas": {"width": width, "height": height}, "units": 1 << (kind >> 5),
        "stipples": dots, "regions": [{"ink": kind % 2}], "curves": curves,
    });
    document.to_string()
}

/// The next shape on a canvas of this size: an object for a dot, text for a curve.
fn shape(mut byte: impl FnMut() -> Option<u8>, sides: [f64; 2]) -> Option<Value> {
    let kind = byte()?;
    let mut place = || {
        let [x, y] = sides.map(|side| byte().map(|v| (f64::from(v) / PARTS).min(side)));
        Some([x?, y?])
    };
    let [x, y] = place()?;
    if kind % 4 == 0 {
        let [radius, _] = place()?;
        return Some(json!({"x": x, "y": y, "radius": radius, "ink": kind >> 2 & 1}));
    }
    let mut curve = format!("M{x},{y}");
    for _ in 0..=kind >> 5 {
        let (letter, points) = match kind >> 2 & 3 {
            0 | 1 => ('L', 1),
            2 => ('Q', 2),
            _ => ('C', 3),
        };
        curve.push(letter);
        for _ in 0..points {
            let [x, y] = place()?;
            curve += &format!(" {x},{y}");
        }
    }
    // Open, or closed with or without a line.
    curve += &match kind % 4 {
        1 => String::new(),
        2 => "Z".to_owned(),
        _ => format!("L{x},{y}Z"),
    };
    Some(Value::String(curve))
}
