//! Draws a photo with the core alone: `cargo run --release --package graphstipple-core --example draw -- PHOTO [FOLDER]`.
//!
//! The core knows no files: what reads and writes them here is the standard library.

use std::error::Error;
use std::ffi::OsStr;
use std::fs::{self, File};
use std::io::BufReader;
use std::path::{Path, PathBuf};

use graphstipple_core::stages::{Layout, Length, Reading, Unit, decode, fine_grained, luma_to_u8};
use graphstipple_core::{Control, Export, Format, Importance, Options, Outcome, draw};

fn main() -> Result<(), Box<dyn Error>> {
    let mut arguments = std::env::args_os().skip(1).map(PathBuf::from);
    let photo = arguments.next().ok_or("usage: draw PHOTO [FOLDER]")?;
    let folder = arguments.next().unwrap_or_else(|| PathBuf::from("out"));
    let outcome = draw_to(&photo, &folder)?;
    println!("{} stipples and {} regions in {}", outcome.stats.stipples, outcome.stats.regions, folder.display());
    Ok(())
}

/// Draws a photo, and writes the drawing to a folder as SVG and as PNG.
fn draw_to(photo: &Path, folder: &Path) -> Result<Outcome, Box<dyn Error>> {
    // Options are plain data until they are checked; what is wrong with them is one sentence.
    let options = Options { nodes: Some(20_000), crispness: 3.0, ..Options::default() }.check()?;

    // Another thread may ask a control how far the work is, and stop it.
    let control = Control::new();

    // With the options, a photo with far more pixels than its nodes can use is reduced while it is read.
    let reading = Reading { options: Some(options.clone()), ..Reading::default() };
    let decoded = decode(&mut BufReader::new(File::open(photo)?), &reading, &control)?;
    if let Some(warning) = &decoded.warning {
        eprintln!("{warning}");
    }

    // Where detail is wanted: what draws the eye, or with Importance::Map a map of your own.
    let luma = decoded.photo.luma();
    let importance = Importance::saliency(fine_grained(&luma_to_u8(luma), luma.width(), luma.height()));
    let outcome = draw(&decoded.photo, &importance, &options, &control)?;

    // An SVG 120 mm wide, and a PNG of twice the canvas's width.
    let on_paper = Layout { width: Some(Length { value: 120.0, unit: Unit::Mm }), ..Layout::default() };
    let wide = 2.0 * decoded.photo.width() as f64;
    let on_screen = Layout { width: Some(Length { value: wide, unit: Unit::Px }), ..Layout::default() };
    fs::create_dir_all(folder)?;
    for (suffix, layout) in [("svg", on_paper), ("png", on_screen)] {
        let writer = Format::of_suffix(suffix)?.writer(Export { layout, ..Export::default() }.check()?)?;
        let name = Path::new(photo.file_stem().unwrap_or(OsStr::new("drawing"))).with_extension(suffix);
        fs::write(folder.join(name), writer.write(&outcome.drawing)?)?;
    }
    Ok(outcome)
}

#[cfg(test)]
mod tests {
    use graphstipple_core::load;

    use super::*;

    #[test]
    fn a_photo_becomes_an_svg_that_holds_the_drawing_and_a_png_of_its_size() -> Result<(), Box<dyn Error>> {
        let photo = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../tests/golden/coffee.png");
        let folder = std::env::temp_dir().join(format!("graphstipple-example-{}", std::process::id()));
        let outcome = draw_to(&photo, &folder)?;
        let [svg, png] = ["svg", "png"].map(|suffix| fs::read(folder.join("coffee").with_extension(suffix)));
        fs::remove_dir_all(&folder)?;
        let (svg, png) = (svg?, png?);

        assert!(outcome.stats.stipples > 0 && outcome.stats.regions > 0);
        assert_eq!(load(&svg, Format::of_suffix("svg")?, &Control::new())?, *outcome.drawing);
        assert!(String::from_utf8(svg)?.contains("width=\"120mm\" height=\"80mm\""));
        // The width and the height, big-endian, behind the signature and the length and name of the first chunk.
        assert_eq!(png[16..24], [0, 0, 0, 192, 0, 0, 0, 128]);
        Ok(())
    }

    #[test]
    fn a_photo_that_is_none_is_an_error() {
        let page = Path::new(env!("CARGO_MANIFEST_DIR")).join("Cargo.toml");
        let error = draw_to(&page, Path::new("never made")).unwrap_err().to_string();
        assert!(error.contains("PNG, JPEG, TIFF"), "{error}");
        assert!(!Path::new("never made").exists());
    }
}
