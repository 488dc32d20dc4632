//! Photos in, and drawings that were saved: with [`crate::writing`] the only module that touches the file system, for the command line
//! and for Python alike. What this module does not do: know any image or vector format (the core does).

use std::collections::BTreeMap;
use std::ffi::OsStr;
use std::fs;
use std::io::{self, BufReader, Cursor, Read, Seek};
use std::path::{Path, PathBuf};
use std::sync::OnceLock;
use std::time::Instant;

use graphstipple_core::stages::{Decoded, MAX_FILE_BYTES, MachineFormat, Reading, ReportFormat, Source, decode};
use graphstipple_core::{Control, Drawing, Field, Format, Importance, Photo};

use crate::error::{Error, Result};

/// The format that a path's suffix stands for, in upper or lower case.
///
/// # Errors
/// [`Error::Usage`] for any other suffix or none, with those that are allowed.
pub fn format_of_path(path: &Path) -> Result<Format> {
    match path.extension().and_then(OsStr::to_str) {
        Some(suffix) => Format::of_suffix(suffix).map_err(|error| match error {
            graphstipple_core::Error::Option { .. } if MachineFormat::of_suffix(suffix).is_ok() => Error::Usage(format!(
                "{}: a file of .{} is a plot's, which needs the width of a pen",
                path.display(),
                suffix.to_ascii_lowercase()
            )),
            graphstipple_core::Error::Option { allowed, .. } => {
                Error::Usage(format!("{}: the suffix must be {allowed}", path.display()))
            }
            other => Error::Core(other),
        }),
        None => Err(Error::Usage(format!("{}: the file name needs a suffix: {}", path.display(), Format::suffixes()))),
    }
}

/// The format of plots that a path's suffix stands for, in upper or lower case.
///
/// # Errors
/// [`Error::Usage`] for any other suffix or none, with those that are allowed.
pub fn suffix_of_plot(path: &Path) -> Result<MachineFormat> {
    by_suffix(path, |suffix| MachineFormat::of_suffix(suffix).ok(), "plot", MachineFormat::SUFFIXES)
}

/// The format of a report by its file's suffix.
///
/// # Errors
/// [`Error::Usage`] for any other suffix or none, with those that are allowed.
pub fn suffix_of_report(path: &Path) -> Result<ReportFormat> {
    by_suffix(path, |suffix| ReportFormat::of_suffix(suffix).ok(), "report", ReportFormat::SUFFIXES)
}

/// What a path's suffix stands for, or what is allowed for such a file.
fn by_suffix<T>(path: &Path, read: impl Fn(&str) -> Option<T>, file: &str, allowed: &str) -> Result<T> {
    let found = path.extension().and_then(OsStr::to_str).and_then(read);
    found.ok_or_else(|| Error::Usage(format!("{}: the suffix of a {file} must be {allowed}", path.display())))
}

/// What another program is handed of an image that the core does not support.
#[derive(Debug, Clone, Copy)]
pub enum Handed<'a> {
    /// The path of a file.
    Path(&'a Path),
    /// All bytes of a file.
    Bytes(&'a [u8]),
}

/// Another program that reads images; `None` if it does not read this one either.
pub type Fallback = fn(Handed, &Reading) -> Option<graphstipple_core::Result<Decoded>>;

static FALLBACK: OnceLock<Fallback> = OnceLock::new();

/// Says who is asked, from now on, to read the images that the core does not support. The first that is named stays.
pub fn set_fallback(fallback: Fallback) {
    FALLBACK.get_or_init(|| fallback);
}

/// Another program that finds the subject of a photo, given by its file and as it was read: the mask, of any size, and a sentence for
/// the user where there is something to say; no mask where it finds none.
pub type Segmenter = fn(Handed, &Photo, &Reading) -> graphstipple_core::Result<(Option<Photo>, Option<String>)>;

static SEGMENTER: OnceLock<Segmenter> = OnceLock::new();

/// Says who is asked, from now on, to find subjects. The first that is named stays.
pub fn set_segmenter(segmenter: Segmenter) {
    SEGMENTER.get_or_init(|| segmenter);
}

/// Where the subject of a photo comes from, as users name it.
#[derive(Debug, Clone, PartialEq, Eq)]
pub enum Subject {
    /// The [`Segmenter`] finds it.
    Auto,
    /// A mask in an image file: white is the subject.
    File(PathBuf),
}

impl Subject {
    /// Reads a name.
    ///
    /// # Errors
    /// [`graphstipple_core::Error::Option`] if it is neither `auto` nor the path of an image file; [`Error::Usage`] for `auto` where
    /// nobody can be asked.
    pub fn parse(name: &str) -> Result<Self> {
        match name {
            "auto" if SEGMENTER.get().is_none() => Err(Error::Usage(
                "--subject auto comes with Python's command, and this one is without: pip install graphstipple, or give a mask"
                    .to_owned(),
            )),
            "auto" => Ok(Self::Auto),
            // As for an importance: a word that could be no image file is a name misspelt.
            _ if name.contains(['.', '/', '\\']) => Ok(Self::File(name.into())),
            _ => Err(Error::Core(graphstipple_core::Error::Option {
                option: "subject".to_owned(),
                value: name.to_owned(),
                allowed: "auto or the path of an image file".to_owned(),
            })),
        }
    }
}

/// What is said of a mask that shows no subject.
pub const NO_SUBJECT: &str = "the subject's mask is below a half everywhere, so the photo is drawn as it is";

/// The photo of an input with its subject, and what is to be said of that.
///
/// # Errors
/// As [`Input::read`]; those of the segmenter.
pub fn with_subject(
    photo: Photo,
    input: &Input,
    subject: &Subject,
    reading: &Reading,
    control: &Control,
) -> Result<(Photo, Option<String>)> {
    let (mask, warning) = match subject {
        Subject::Auto => {
            let Some(segmenter) = SEGMENTER.get() else { return Ok((photo, None)) };
            let found = segmenter(input.handed(), &photo, reading);
            let (mask, warning) = found.map_err(|error| of_photo(input.path(), error))?;
            (mask, warning.map(|warning| told(input.path(), &warning)))
        }
        Subject::File(path) => {
            let decoded = Input::file(path).read(&without_colour(reading), control)?;
            (Some(decoded.photo), decoded.warning.map(|warning| told(path, &warning)))
        }
    };
    let Some(mask) = mask else { return Ok((photo, warning)) };
    let photo = photo.with_subject(&mask)?;
    let none = photo.subject().is_none().then(|| NO_SUBJECT.to_owned());
    Ok((photo, none.or(warning)))
}

/// Reads an image file.
///
/// # Errors
/// As [`Input::read`].
pub fn read_photo(path: &Path, reading: &Reading, control: &Control) -> Result<Decoded> {
    Input::file(path).read(reading, control)
}

/// An image file, the bytes of one, or standard input, that can be read more than once: what comes through a pipe comes once, and is
/// kept.
#[derive(Debug)]
pub struct Input {
    path: PathBuf,
    is_standard: bool,
    piped: Option<Vec<u8>>,
}

impl Input {
    /// The file of this path.
    pub fn file(path: &Path) -> Self {
        Self { path: path.to_owned(), is_standard: false, piped: None }
    }

    /// Standard input.
    pub fn standard() -> Self {
        Self { path: PathBuf::from("-"), is_standard: true, piped: None }
    }

    /// Bytes that somebody has of a file, under the name by which messages tell of it.
    pub fn bytes(name: &Path, bytes: Vec<u8>) -> Self {
        Self { path: name.to_owned(), is_standard: false, piped: Some(bytes) }
    }

    /// Its path; that of standard input is `-`.
    pub fn path(&self) -> &Path {
        &self.path
    }

    /// What another program is handed of it.
    fn handed(&self) -> Handed<'_> {
        self.piped.as_ref().map_or(Handed::Path(&self.path), |bytes| Handed::Bytes(bytes))
    }

    /// Reads the image.
    ///
    /// # Errors
    /// [`Error::File`] if the file cannot be read, [`Error::Photo`] if it is no image that the core takes, nor one that the
    /// [`Fallback`] does.
    pub fn read(&mut self, reading: &Reading, control: &Control) -> Result<Decoded> {
        let path = &*self.path;
        let bytes = match &mut self.piped {
            Some(bytes) => bytes,
            none if self.is_standard => none.insert(all_of(path, io::stdin().lock())?),
            none => {
                let failed = |source| Error::File { path: path.to_owned(), source };
                let file = fs::File::open(path).map_err(failed)?;
                if file.metadata().map_err(failed)?.is_dir() {
                    return Err(failed(io::ErrorKind::IsADirectory.into()));
                }
                let mut file = BufReader::with_capacity(READ_AT_ONCE, file);
                if file.stream_position().is_ok() {
                    let decoded = decode(&mut file, reading, control).or_else(|error| ask(error, Handed::Path(path), reading));
                    return decoded.map_err(|error| of_photo(path, error));
                }
                // A pipe has a path too, but no end to look at.
                none.insert(all_of(path, file)?)
            }
        };
        let decoded =
            decode(&mut Cursor::new(&*bytes), reading, control).or_else(|error| ask(error, Handed::Bytes(bytes), reading));
        decoded.map_err(|error| of_photo(path, error))
    }
}

/// Bytes of a file that are read at once.
const READ_AT_ONCE: usize = 1 << 16;

/// All bytes of a stream, up to a limit.
fn all_of(path: &Path, stream: impl Read) -> Result<Vec<u8>> {
    let mut bytes = Vec::new();
    let read = stream.take(MAX_FILE_BYTES + 1).read_to_end(&mut bytes);
    read.map_err(|source| Error::File { path: path.to_owned(), source })?;
    if bytes.len() as u64 > MAX_FILE_BYTES {
        let sentence = format!("there are too many bytes: at most {MAX_FILE_BYTES} are read from a pipe");
        return Err(of_photo(path, graphstipple_core::Error::Decode(sentence)));
    }
    Ok(bytes)
}

/// Asks the fallback for what the core does not support.
fn ask(error: graphstipple_core::Error, handed: Handed, reading: &Reading) -> graphstipple_core::Result<Decoded> {
    let asked = match (&error, FALLBACK.get()) {
        (graphstipple_core::Error::Unsupported(_), Some(fallback)) => fallback(handed, reading),
        _ => None,
    };
    asked.unwrap_or(Err(error))
}

fn of_photo(path: &Path, source: graphstipple_core::Error) -> Error {
    match source {
        graphstipple_core::Error::Cancelled => Error::Core(source),
        source => Error::Photo { path: path.to_owned(), source },
    }
}

/// An importance, and what is to be said of the file that it was read from.
#[derive(Debug)]
pub struct Evaluated {
    /// The importance.
    pub importance: Importance,
    /// One sentence for the user.
    pub warning: Option<String>,
}

/// How what is a map or a mask is read: as the photo is, but for its colour.
fn without_colour(reading: &Reading) -> Reading {
    Reading { colour: false, ..reading.clone() }
}

/// The importance of a photo, given as the luma that is drawn. Files are read as the photo is, without colour, and reduced by their own
/// size; one whose bytes are given as `map` is not opened. The seconds that it took are added under their stage: `saliency`, or
/// `decoding` for a file.
///
/// # Errors
/// As [`read_photo`]; [`Error::Core`] where it was cancelled.
pub fn evaluate(
    source: Source,
    map: Option<&Vec<u8>>,
    luma: &Field,
    reading: &Reading,
    seconds: &mut BTreeMap<String, f64>,
    control: &Control,
) -> Result<Evaluated> {
    let (began, stage) = (Instant::now(), source.stage());
    let mut warning = None;
    let read = |path: &str| {
        let path = Path::new(path);
        let mut input = map.map_or_else(|| Input::file(path), |bytes| Input::bytes(path, bytes.clone()));
        let decoded = input.read(&without_colour(reading), control)?;
        warning = decoded.warning.map(|warning| told(path, &warning));
        Ok::<_, Error>(decoded.photo)
    };
    let importance = source.evaluate(luma, read, control)?;
    control.check()?;
    *seconds.entry(stage.to_owned()).or_default() += began.elapsed().as_secs_f64();
    Ok(Evaluated { importance, warning })
}

/// A warning with the file that it is about.
pub fn told(path: &Path, warning: &str) -> String {
    format!("{}: {warning}", path.display())
}

/// Reads a drawing again from a file that [`save`](crate::writing::save) wrote, of a format that holds all of it.
///
/// # Errors
/// [`Error::Usage`] for another suffix, [`Error::File`] if the file cannot be read, [`Error::Photo`] if it holds no drawing of
/// ours.
pub fn load(path: &Path, control: &Control) -> Result<Drawing> {
    let format = format_of_path(path).ok().filter(|format| format.can_be_read());
    let Some(format) = format else {
        let suffixes = Format::suffixes_to_load();
        return Err(Error::Usage(format!("{}: the suffix of a drawing to load must be {suffixes}", path.display())));
    };
    let bytes = fs::read(path).map_err(|source| Error::File { path: path.to_owned(), source })?;
    graphstipple_core::load(&bytes, format, control).map_err(|source| of_photo(path, source))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_suffix_says_the_format() {
        assert_eq!(format_of_path(Path::new("a/b.SVG")).unwrap().suffix, "svg");
        assert_eq!(format_of_path(Path::new("b.png")).unwrap().suffix, "png");
        let suffixes = Format::suffixes();
        for (path, rule) in
            [("a.gif", "the suffix must be"), ("a", "the file name needs a suffix:"), (".svg", "the file name needs a suffix:")]
        {
            let error = format_of_path(Path::new(path)).unwrap_err();
            assert_eq!((error.to_string(), error.exit_code()), (format!("{path}: {rule} {suffixes}"), 2));
        }
    }

    #[test]
    fn files_that_cannot_be_read() {
        let folder = tempfile::tempdir().unwrap();
        let missing = folder.path().join("none.png");
        let error = read_photo(&missing, &Reading::default(), &Control::new()).unwrap_err();
        assert_eq!(error.to_string(), format!("{}: the file does not exist", missing.display()));
        let error = read_photo(folder.path(), &Reading::default(), &Control::new()).unwrap_err();
        assert_eq!(error.to_string(), format!("{}: this is a folder, not a file", folder.path().display()));
    }
}
