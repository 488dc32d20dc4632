//! Photos in, drawings out: the only module that touches the file system, for the command line and for Python alike.
//!
//! A file is written under a temporary name in its own folder and renamed when it is complete, so a drawing is there whole or
//! not at all. What this module does not do: know any image or vector format (the core does).

use std::ffi::OsStr;
use std::fs;
use std::io::{self, Read, Write};
use std::path::{Path, PathBuf};

use graphstipple_core::{Drawing, Field, decode, raster, svg};

use crate::error::{Error, Result};

/// What a drawing is written as.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Format {
    /// Vector, layered: `.svg`.
    Svg,
    /// 8-bit greyscale raster: `.png`.
    Png,
}

impl Format {
    /// The format that a path's suffix stands for, in upper or lower case.
    ///
    /// # Errors
    /// [`Error::Usage`] for any other suffix or none, with those that are allowed.
    pub fn of_path(path: &Path) -> Result<Self> {
        match path.extension().and_then(OsStr::to_str).map(str::to_ascii_lowercase).as_deref() {
            Some("svg") => Ok(Self::Svg),
            Some("png") => Ok(Self::Png),
            Some(_) => Err(Error::Usage(format!("{}: the suffix must be .svg or .png", path.display()))),
            None => Err(Error::Usage(format!("{}: the file name needs a suffix, .svg or .png", path.display()))),
        }
    }
}

/// Reads an image file as luma, transparent parts composited on `background` (sRGB).
///
/// # Errors
/// [`Error::File`] if the file cannot be read, [`Error::Photo`] if it is no image that the core takes.
pub fn read_photo(path: &Path, background: [u8; 3]) -> Result<Field> {
    let bytes = fs::read(path).map_err(|source| Error::File { path: path.to_owned(), source })?;
    decode_photo(path, &bytes, background)
}

/// Reads an image from standard input, as [`read_photo`] does from a file.
///
/// # Errors
/// As [`read_photo`]; the path in the error is `-`.
pub fn read_standard_input(background: [u8; 3]) -> Result<Field> {
    let path = Path::new("-");
    let mut bytes = Vec::new();
    io::stdin().lock().read_to_end(&mut bytes).map_err(|source| Error::File { path: path.to_owned(), source })?;
    decode_photo(path, &bytes, background)
}

fn decode_photo(path: &Path, bytes: &[u8], background: [u8; 3]) -> Result<Field> {
    decode::decode(bytes, background).map_err(|source| Error::Photo { path: path.to_owned(), source })
}

/// The bytes of a drawing's file. `width` is the width of a PNG in pixels; `None` is the canvas's own.
///
/// # Errors
/// [`Error::Usage`] for an SVG with a width, [`Error::Core`] as [`raster::rasterize`].
pub fn encode(drawing: &Drawing, format: Format, width: Option<usize>) -> Result<Vec<u8>> {
    match (format, width) {
        (Format::Svg, None) => Ok(svg::to_svg(drawing).into_bytes()),
        (Format::Svg, Some(_)) => Err(Error::Usage("an SVG has no width in pixels: leave width out, or write a .png".into())),
        (Format::Png, width) => Ok(raster::encode_png(&raster::rasterize(drawing, width)?)?),
    }
}

/// Writes a drawing as the format that the path's suffix stands for. `width` is the width of a PNG in pixels; `None` is the
/// canvas's own.
///
/// # Errors
/// As [`Format::of_path`], [`encode`] and [`write_atomically`]; then no file is left behind, and one that was there is as it was.
pub fn save(drawing: &Drawing, path: &Path, width: Option<usize>) -> Result<()> {
    let format = Format::of_path(path)?;
    check_target(path)?;
    write_atomically(path, &encode(drawing, format, width)?)
}

/// Checks what can be checked before the work starts: that the folder of a file to write is there, and the file is not a folder.
///
/// # Errors
/// [`Error::File`] with the path.
pub fn check_target(path: &Path) -> Result<()> {
    let refuse = |kind, text: String| Err(Error::File { path: path.to_owned(), source: io::Error::new(kind, text) });
    let folder = folder_of(path);
    if !folder.is_dir() {
        return refuse(io::ErrorKind::Other, format!("the folder {} does not exist", folder.display()));
    }
    if path.is_dir() {
        return refuse(io::ErrorKind::IsADirectory, String::new());
    }
    Ok(())
}

/// Writes a file whole or not at all, with the permissions that the process gives new files.
///
/// # Errors
/// [`Error::File`]; then nothing is left behind, and a file that was there is as it was.
pub fn write_atomically(path: &Path, bytes: &[u8]) -> Result<()> {
    write_all_atomically(&[(path, bytes)])
}

/// Writes several files as [`write_atomically`] does. None takes its name before all of them are complete on the disk.
///
/// # Errors
/// [`Error::File`] for the first that fails.
pub fn write_all_atomically(files: &[(&Path, &[u8])]) -> Result<()> {
    let mut complete = Vec::with_capacity(files.len());
    for &(path, bytes) in files {
        check_target(path)?;
        let target = real_path(path);
        let failed = |source| Error::File { path: path.to_owned(), source };
        let mut file = temporary_file(folder_of(&target)).map_err(failed)?;
        file.write_all(bytes).map_err(failed)?;
        complete.push((file, target, path));
    }
    for (file, target, path) in complete {
        file.persist(target).map_err(|error| Error::File { path: path.to_owned(), source: error.error })?;
    }
    Ok(())
}

fn temporary_file(folder: &Path) -> io::Result<tempfile::NamedTempFile> {
    let mut builder = tempfile::Builder::new();
    builder.prefix(".graphstipple-").suffix(".tmp");
    // Temporary files are private by default; this one becomes an ordinary file. The process's umask applies.
    #[cfg(unix)]
    builder.permissions(std::os::unix::fs::PermissionsExt::from_mode(0o666));
    builder.tempfile_in(folder)
}

/// Where a write through a symbolic link ends: the rename would replace the link itself.
fn real_path(path: &Path) -> PathBuf {
    fs::canonicalize(path).unwrap_or_else(|_| path.to_owned())
}

/// Whether two paths name the same file, if both are there.
pub(crate) fn is_same_file(a: &Path, b: &Path) -> bool {
    matches!((fs::canonicalize(a), fs::canonicalize(b)), (Ok(a), Ok(b)) if a == b)
}

fn folder_of(path: &Path) -> &Path {
    match path.parent() {
        Some(folder) if !folder.as_os_str().is_empty() => folder,
        _ => Path::new("."),
    }
}

#[cfg(test)]
mod tests {
    use graphstipple_core::drawing::{Ink, Mark, Provenance, Stipple};

    use super::*;

    fn dot() -> Drawing {
        Drawing {
            width: 20,
            height: 10,
            curves: vec![],
            stipples: vec![Stipple { x: 10.0, y: 5.0, radius: 4.0, ink: Ink::Black, component: 0, level: 1 }],
            regions: vec![],
            order: vec![Mark::Stipple(0)],
            provenance: Provenance {
                version: "0".into(),
                importance: "none".into(),
                options: graphstipple_core::Options::default(),
            },
        }
    }

    fn names(folder: &Path) -> Vec<String> {
        let mut names: Vec<_> = fs::read_dir(folder).unwrap().map(|e| e.unwrap().file_name().into_string().unwrap()).collect();
        names.sort();
        names
    }

    #[test]
    fn the_suffix_says_the_format() {
        assert_eq!(Format::of_path(Path::new("a/b.SVG")).unwrap(), Format::Svg);
        assert_eq!(Format::of_path(Path::new("b.png")).unwrap(), Format::Png);
        for (path, message) in [
            ("a.pdf", "a.pdf: the suffix must be .svg or .png"),
            ("a", "a: the file name needs a suffix, .svg or .png"),
            (".svg", ".svg: the file name needs a suffix, .svg or .png"),
        ] {
            let error = Format::of_path(Path::new(path)).unwrap_err();
            assert_eq!((error.to_string().as_str(), error.exit_code()), (message, 2));
        }
    }

    #[test]
    fn save_writes_both_formats_and_nothing_else() {
        let folder = tempfile::tempdir().unwrap();
        save(&dot(), &folder.path().join("a.svg"), None).unwrap();
        save(&dot(), &folder.path().join("a.png"), Some(40)).unwrap();
        assert!(fs::read_to_string(folder.path().join("a.svg")).unwrap().starts_with("<svg "));
        let png = image::open(folder.path().join("a.png")).unwrap();
        assert_eq!((png.width(), png.height()), (40, 20));
        assert!(save(&dot(), &folder.path().join("b.svg"), Some(40)).is_err());
        assert!(save(&dot(), &folder.path().join("b.png"), Some(0)).is_err());
        assert_eq!(names(folder.path()), ["a.png", "a.svg"]);
    }

    #[test]
    fn a_missing_folder_is_one_sentence() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("none").join("a.svg");
        let error = save(&dot(), &path, None).unwrap_err();
        let expected = format!("{}: the folder {} does not exist", path.display(), folder.path().join("none").display());
        assert_eq!((error.to_string(), error.exit_code()), (expected, 1));
        assert_eq!(names(folder.path()), Vec::<String>::new());
    }

    #[test]
    fn when_one_file_fails_none_is_written() {
        let folder = tempfile::tempdir().unwrap();
        let (good, bad) = (folder.path().join("a.svg"), folder.path().join("folder.png"));
        fs::write(&good, "before").unwrap();
        fs::create_dir(&bad).unwrap();
        let error = write_all_atomically(&[(&good, b"after"), (&bad, b"after")]).unwrap_err();
        assert_eq!(error.to_string(), format!("{}: this is a folder, not a file", bad.display()));
        assert_eq!(fs::read(&good).unwrap(), b"before");
        assert_eq!(names(folder.path()), ["a.svg", "folder.png"]);
    }

    #[cfg(unix)]
    #[test]
    fn files_have_ordinary_permissions_and_links_stay_links() {
        use std::os::unix::fs::PermissionsExt;
        let folder = tempfile::tempdir().unwrap();
        let (plain, ours, link) = (folder.path().join("plain"), folder.path().join("ours"), folder.path().join("link"));
        fs::write(&plain, "").unwrap();
        write_atomically(&ours, b"one").unwrap();
        let mode = |path: &Path| fs::metadata(path).unwrap().permissions().mode();
        assert_eq!(mode(&ours), mode(&plain));
        std::os::unix::fs::symlink(&ours, &link).unwrap();
        write_atomically(&link, b"two").unwrap();
        assert!(fs::symlink_metadata(&link).unwrap().is_symlink());
        assert_eq!(fs::read(&ours).unwrap(), b"two");
    }

    #[test]
    fn files_that_cannot_be_read() {
        let folder = tempfile::tempdir().unwrap();
        let missing = folder.path().join("none.png");
        let error = read_photo(&missing, [255; 3]).unwrap_err();
        assert_eq!(error.to_string(), format!("{}: the file does not exist", missing.display()));
        let error = read_photo(folder.path(), [255; 3]).unwrap_err();
        assert_eq!(error.to_string(), format!("{}: this is a folder, not a file", folder.path().display()));
    }
}
