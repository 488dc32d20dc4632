//! A file for each ink: in, a path with `{ink}` in its name; out, the path of every plate.
//!
//! Names of inks are of a-z, 0-9 and -, so every one of them makes a name of a file, and no two the same.

use std::path::{Path, PathBuf};

use graphstipple_core::Drawing;
use graphstipple_core::stages::{Palette, Writer};

use crate::error::{Error, Result};

/// What stands for the name of an ink.
const INK: &str = "{ink}";

/// Whether a path is one for each ink.
///
/// # Errors
/// [`Error::Usage`] if the place for the ink is in the name of a folder.
pub fn is_for_each_ink(path: &Path) -> Result<bool> {
    let folder = path.parent().unwrap_or(Path::new(""));
    if folder.to_string_lossy().contains(INK) {
        return Err(Error::Usage(format!(
            "{}: {INK} may stand in the name of the file, but not in that of a folder",
            path.display()
        )));
    }
    Ok(path.file_name().and_then(|name| name.to_str()).is_some_and(|name| name.contains(INK)))
}

/// Checks that a path that has no plates is for none.
///
/// # Errors
/// [`Error::Usage`] if there is a place for an ink in it.
pub(crate) fn check_is_for_none(path: &Path, what: &str) -> Result<()> {
    if is_for_each_ink(path)? {
        return Err(Error::Usage(format!(
            "{}: {INK} is for the drawing's own file: there is one {what} for all inks",
            path.display()
        )));
    }
    Ok(())
}

/// The paths of the plates of a drawing with this palette.
///
/// # Errors
/// As [`Writer::plates`].
pub(crate) fn paths(path: &Path, palette: &Palette, writer: &Writer) -> graphstipple_core::Result<Vec<PathBuf>> {
    Ok(writer.plates(palette)?.into_iter().map(|plate| path_of(path, &plate.name)).collect())
}

/// The plates of a drawing, each with its path.
///
/// # Errors
/// As [`Writer::plates`] and [`Writer::write`].
pub fn files(path: &Path, drawing: &Drawing, writer: &Writer) -> graphstipple_core::Result<Vec<(PathBuf, Vec<u8>)>> {
    let plates = writer.plates(&drawing.palette)?;
    plates.into_iter().map(|plate| Ok((path_of(path, &plate.name), plate.write(drawing)?))).collect()
}

fn path_of(path: &Path, ink: &str) -> PathBuf {
    let name = path.file_name().and_then(|name| name.to_str()).unwrap_or_default();
    path.with_file_name(name.replace(INK, ink))
}

#[cfg(test)]
mod tests {
    use graphstipple_core::{Export, Format};

    use super::*;

    #[test]
    fn a_name_has_a_place_for_the_ink_and_a_folder_has_none() {
        for (path, is_for_each) in [("a/{ink}.pdf", true), ("{ink}-{ink}.svg", true), ("a/ink.pdf", false), ("{pink}.pdf", false)] {
            assert_eq!(is_for_each_ink(Path::new(path)).unwrap(), is_for_each, "{path}");
        }
        let error = is_for_each_ink(Path::new("{ink}/a.pdf")).unwrap_err();
        let expected = "{ink}/a.pdf: {ink} may stand in the name of the file, but not in that of a folder";
        assert_eq!((error.to_string(), error.exit_code()), (expected.to_owned(), 2));
        let error = check_is_for_none(Path::new("{ink}.png"), "preview").unwrap_err().to_string();
        assert_eq!(error, "{ink}.png: {ink} is for the drawing's own file: there is one preview for all inks");
    }

    #[test]
    fn every_ink_that_is_drawn_has_a_path() {
        let inks = ["black", "pink=#ff48b0"].map(|ink| graphstipple_core::stages::NamedInk::parse(ink).unwrap());
        let palette = Palette::new(inks.to_vec(), [255; 3], false).unwrap();
        let paths_of = |export: Export| {
            let writer = Format::of_suffix("pdf").unwrap().writer(export.check().unwrap()).unwrap();
            paths(Path::new("plates/a-{ink}.pdf"), &palette, &writer)
        };
        let named = |names: &[&str]| names.iter().map(PathBuf::from).collect::<Vec<_>>();
        assert_eq!(paths_of(Export::default()).unwrap(), named(&["plates/a-black.pdf", "plates/a-pink.pdf"]));
        let mut export = Export::default();
        export.set("only", &graphstipple_core::stages::Value::Word("paper,pink".into())).unwrap();
        assert_eq!(paths_of(export).unwrap(), named(&["plates/a-pink.pdf", "plates/a-paper.pdf"]));
        let layered = Export { style: graphstipple_core::stages::Style::Layered, ..Export::default() };
        let error = paths_of(layered).unwrap_err().to_string();
        assert_eq!(error, "style is layered, but it must be flat where each ink has a file of its own");
    }
}
