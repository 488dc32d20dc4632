//! Colour profiles, gammas and chromaticities, applied to a few samples of every model and depth.
#![no_main]

use fuzz::{Counting, check_error, prepare};
use graphstipple_core::Control;
use graphstipple_core::stages::{PhotoBuilder, Reading, Samples, Tags};
use libfuzzer_sys::fuzz_target;

#[global_allocator]
static COUNTING: Counting = Counting;

fuzz_target!(|data: &[u8]| {
    prepare();
    let [kind, rest @ ..] = data else { return };
    let channels = usize::from(kind % 4) + 1;
    let inks = channels == 4 && kind & 64 != 0;
    let number = |at: usize| rest.get(4 * at..4 * at + 4).map(|b| f64::from(u32::from_be_bytes([b[0], b[1], b[2], b[3]])) / 1e5);
    let tags = if kind & 128 == 0 {
        // A profile says how long it is, and which mark it has.
        let mut profile = rest.to_vec();
        if profile.len() > 40 {
            let length = (profile.len() as u32).to_be_bytes();
            profile[..4].copy_from_slice(&length);
            profile[36..40].copy_from_slice(b"acsp");
        }
        Tags { inks, profile: Some(profile), ..Tags::default() }
    } else {
        let all: Vec<f64> = (1..9).map_while(number).collect();
        let corners: Vec<[f64; 2]> = all.chunks_exact(2).map(|pair| [pair[0], pair[1]]).collect();
        Tags { inks, gamma: number(0), chromaticities: corners.try_into().ok(), ..Tags::default() }
    };
    let bytes: Vec<u8> = (0..16 * channels).map(|i| (i * 37 % 256) as u8).collect();
    let words: Vec<u16> = bytes.iter().map(|byte| u16::from(*byte) * 257).collect();
    let floats: Vec<f32> = bytes.iter().map(|byte| f32::from(*byte) / 255.0).collect();
    let samples = match kind >> 2 & 3 {
        0 | 3 => Samples::U8(&bytes),
        1 => Samples::U16(&words),
        _ => Samples::F32(&floats),
    };
    let control = Control::new();
    let photo = PhotoBuilder::new([4, 4, channels], samples, &tags, &Reading::default(), &control).and_then(|mut builder| {
        builder.take(samples)?;
        builder.finish()
    });
    match photo {
        Ok(photo) => assert!(photo.luma().values().iter().all(|value| (0.0..=1.0).contains(value))),
        Err(error) => check_error(&error),
    }
});
