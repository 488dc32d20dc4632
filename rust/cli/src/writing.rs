//! Drawings out: in, the bytes of files; out, files that are there whole or not at all.
//!
//! A file is written without its name, in its own folder, and takes it when it is complete. It then is a new file: it keeps the
//! permissions of the one whose place it takes, and its owner where the system allows, but other hard links go on to show the old one.
//! Through symbolic links, what they lead to is written. What is no regular file, such as a device or a pipe, is opened and written to.
//! What this module does not do: know any format (the core does).

use std::ffi::OsStr;
use std::fs::{self, File, Metadata, OpenOptions};
use std::io::{self, Write};
use std::path::{Path, PathBuf, is_separator};

use graphstipple_core::Drawing;
use graphstipple_core::stages::Writer;

use crate::error::{Error, Result};
use crate::scratch::Scratch;

/// Writes a drawing to a file; one that is read-only, by `force` alone.
///
/// # Errors
/// As [`Target::find`], [`Writer::write`] and [`Target::write`]; then no file is left behind, and one that was there is as it was.
pub fn save(drawing: &Drawing, path: &Path, writer: &Writer, force: bool) -> Result<()> {
    let target = Target::find(path, force)?;
    target.write(&writer.write(drawing)?)
}

/// Where bytes are written to.
#[derive(Debug)]
pub struct Target {
    /// As it was given.
    path: PathBuf,
    /// Where its symbolic links lead.
    real: PathBuf,
    /// What is there.
    before: Option<Metadata>,
    is_stream: bool,
}

impl Target {
    /// Finds out what is at a path, and whether it may be written: what can be told before the work starts.
    ///
    /// # Errors
    /// [`Error::File`] if its folder is not there, or it is a folder itself; [`Error::ReadOnly`] for a file that nobody may write, or
    /// not whoever runs this, without `force`.
    pub fn find(path: &Path, force: bool) -> Result<Self> {
        let failed = |source| Error::File { path: path.to_owned(), source };
        let no_folder = |folder: &Path| failed(io::Error::other(format!("the folder {} does not exist", folder.display())));
        if !folder_of(path).is_dir() {
            return Err(no_folder(folder_of(path)));
        }
        let before = match fs::metadata(path) {
            Ok(before) => Some(before),
            Err(error) if error.kind() == io::ErrorKind::NotFound => None,
            Err(error) => return Err(failed(error)),
        };
        // Only a folder may be called so, even where there is nothing yet.
        let ends_as_folder = path.as_os_str().as_encoded_bytes().last().is_some_and(|last| is_separator(char::from(*last)));
        if ends_as_folder || before.as_ref().is_some_and(Metadata::is_dir) {
            return Err(failed(io::ErrorKind::IsADirectory.into()));
        }
        let End { path: real, is_descriptor } = end_of(path).map_err(failed)?;
        if !is_descriptor && !folder_of(&real).is_dir() {
            return Err(no_folder(folder_of(&real)));
        }
        let is_stream = is_descriptor || before.as_ref().is_some_and(|before| !before.is_file());
        let is_kept = |before: &Metadata| before.permissions().readonly() || may_not_be_written(&real);
        if !force && !is_stream && before.as_ref().is_some_and(is_kept) {
            return Err(Error::ReadOnly { path: path.to_owned() });
        }
        Ok(Self { path: path.to_owned(), real, before, is_stream })
    }

    /// Whether it is written to as it is: it may then take any time, until somebody reads what comes out.
    pub fn is_stream(&self) -> bool {
        self.is_stream
    }

    /// Writes these bytes, to a file whole or not at all.
    ///
    /// # Errors
    /// [`Error::File`]; then nothing is left behind, and a file that was there is as it was.
    pub fn write(&self, bytes: &[u8]) -> Result<()> {
        if self.is_stream { self.pour(bytes) } else { self.lay_out(bytes)?.take_its_place() }
    }

    fn failed(&self, source: io::Error) -> Error {
        Error::File { path: self.path.clone(), source }
    }

    /// Writes to what is there. A reader that has gone away is no error.
    fn pour(&self, bytes: &[u8]) -> Result<()> {
        // A file that the process was given open goes on where it ends.
        let goes_on = self.before.as_ref().is_some_and(Metadata::is_file);
        let opened = OpenOptions::new().write(true).append(goes_on).open(&self.path);
        match opened.and_then(|mut stream| stream.write_all(bytes)) {
            Err(error) if error.kind() != io::ErrorKind::BrokenPipe => Err(self.failed(error)),
            _ => Ok(()),
        }
    }

    /// Writes the whole file, but for its name.
    fn lay_out(&self, bytes: &[u8]) -> Result<Complete<'_>> {
        let written = Scratch::new_in(folder_of(&self.real)).and_then(|scratch| {
            scratch.file().write_all(bytes)?;
            if let Some(before) = &self.before {
                be_as(scratch.file(), before);
            }
            Ok(scratch)
        });
        Ok(Complete { target: self, scratch: written.map_err(|error| self.failed(error))? })
    }
}

/// A file that is complete but for its name; gone if it is dropped.
struct Complete<'a> {
    target: &'a Target,
    scratch: Scratch,
}

impl Complete<'_> {
    fn take_its_place(self) -> Result<()> {
        self.scratch.take_name(&self.target.real).map_err(|error| self.target.failed(error))
    }
}

/// Writes several files. None takes its name before all of them are complete on the disk, and what is no file was written to by
/// `pour`, which may wait for [`Target::write`] in its own way.
///
/// # Errors
/// As [`Target::write`], for the first that fails; what `pour` fails with.
pub fn write_all(files: Vec<(Target, Vec<u8>)>, mut pour: impl FnMut(Target, Vec<u8>) -> Result<()>) -> Result<()> {
    let (streams, files): (Vec<_>, Vec<_>) = files.into_iter().partition(|(target, _)| target.is_stream);
    let complete = files.iter().map(|(target, bytes)| target.lay_out(bytes)).collect::<Result<Vec<_>>>()?;
    for (stream, bytes) in streams {
        pour(stream, bytes)?;
    }
    complete.into_iter().try_for_each(Complete::take_its_place)
}

/// Gives a file the owner, the group and the permissions of another, as far as the system allows.
fn be_as(file: &File, other: &Metadata) {
    #[cfg(unix)]
    {
        use std::os::unix::fs::{MetadataExt, fchown};
        // Only root gives files away, but whoever is in a group may give them to it.
        let _ = fchown(file, Some(other.uid()), None);
        let _ = fchown(file, None, Some(other.gid()));
    }
    // After the owner, whose change takes permissions away.
    let _ = file.set_permissions(other.permissions());
}

/// Whether the system would not let whoever runs this write to a file that is there.
fn may_not_be_written(path: &Path) -> bool {
    // Opened so, it is left as it is.
    OpenOptions::new().write(true).open(path).is_err_and(|error| error.kind() == io::ErrorKind::PermissionDenied)
}

/// Where a path ends.
#[derive(PartialEq)]
struct End {
    /// The folder without links, and a name in it that is none.
    path: PathBuf,
    /// Whether it is a file that the process was given open, under the name that the system has for that.
    is_descriptor: bool,
}

/// Links that are followed one after the other, as many as Linux follows.
const MOST_LINKS: usize = 40;

/// Follows symbolic links, also to where nothing is yet.
fn end_of(path: &Path) -> io::Result<End> {
    let mut at = path.to_owned();
    for _ in 0..=MOST_LINKS {
        // Where a link leads to a folder that is not there, there it ends.
        let folder = fs::canonicalize(folder_of(&at)).unwrap_or_else(|_| folder_of(&at).to_owned());
        if folder == Path::new("/dev/fd") || folder.starts_with("/proc") && folder.file_name() == Some(OsStr::new("fd")) {
            return Ok(End { path: at, is_descriptor: true });
        }
        match fs::read_link(&at) {
            Ok(next) => at = folder.join(next),
            Err(_) => {
                let name = at.file_name().unwrap_or_default();
                return Ok(End { path: folder.join(name), is_descriptor: false });
            }
        }
    }
    Err(io::Error::other("there are too many symbolic links"))
}

/// Whether two paths lead to one file, by whatever names or links, which need not be there yet. Devices, such as the null device, take
/// whatever comes.
pub(crate) fn is_same_file(a: &Path, b: &Path) -> bool {
    if let (Ok(a), Ok(b)) = (fs::metadata(a), fs::metadata(b)) {
        if is_device(&a) {
            return false;
        }
        if is_one(&a, &b) {
            return true;
        }
    }
    matches!((end_of(a), end_of(b)), (Ok(a), Ok(b)) if a == b)
}

#[cfg(unix)]
fn is_device(file: &Metadata) -> bool {
    std::os::unix::fs::FileTypeExt::is_char_device(&file.file_type())
}

#[cfg(not(unix))]
fn is_device(_: &Metadata) -> bool {
    false
}

/// Whether the system says that two files are one.
#[cfg(unix)]
fn is_one(a: &Metadata, b: &Metadata) -> bool {
    use std::os::unix::fs::MetadataExt;
    (a.dev(), a.ino()) == (b.dev(), b.ino())
}

#[cfg(not(unix))]
fn is_one(_: &Metadata, _: &Metadata) -> bool {
    false
}

fn folder_of(path: &Path) -> &Path {
    match path.parent() {
        Some(folder) if !folder.as_os_str().is_empty() => folder,
        _ => Path::new("."),
    }
}

#[cfg(test)]
mod tests {
    use std::io::BufReader;

    use graphstipple_core::stages::{Ink, Mark, Provenance, Stipple, Value};
    use graphstipple_core::{Export, Format};

    use super::*;
    use crate::files::format_of_path;

    fn dot() -> Drawing {
        Drawing {
            palette: graphstipple_core::stages::Palette::default(),
            width: 20,
            height: 10,
            curves: vec![],
            stipples: vec![Stipple { x: 10.0, y: 5.0, radius: 4.0, ink: Ink::BLACK, level: 1 }],
            regions: vec![],
            order: vec![Mark::Stipple(0)],
            units: 8.0,
            provenance: Provenance::default(),
        }
    }

    fn names(folder: &Path) -> Vec<String> {
        let mut names: Vec<_> = fs::read_dir(folder).unwrap().map(|e| e.unwrap().file_name().into_string().unwrap()).collect();
        names.sort();
        names
    }

    /// Writes the dot as a file of this name, so wide.
    fn save_at(path: &Path, width: &str) -> Result<()> {
        let mut export = Export::default();
        export.set("width", &Value::Word(width.to_owned())).unwrap();
        save(&dot(), path, &format_of_path(path)?.writer(export.check()?)?, false)
    }

    fn write(path: &Path, bytes: &[u8]) -> Result<()> {
        Target::find(path, false)?.write(bytes)
    }

    #[test]
    fn save_writes_every_format_and_nothing_else() {
        let folder = tempfile::tempdir().unwrap();
        let path = |name: &str| folder.path().join(name);
        for (name, begin) in [
            ("a.svg", "<svg "),
            ("a.svgz", "\u{1f}\u{8b}"),
            ("a.pdf", "%PDF-"),
            ("a.eps", "%!PS-Adobe-3.0 EPSF-3.0\n"),
            ("a.dxf", "999\ngraphstipple "),
            ("a.json", "{"),
            ("a.png", "\u{89}PNG"),
        ] {
            save_at(&path(name), "40px").unwrap();
            let text: String = fs::read(path(name)).unwrap().into_iter().map(char::from).collect();
            assert!(text.starts_with(begin), "{name}: {text}");
        }
        let png = png::Decoder::new(BufReader::new(File::open(path("a.png")).unwrap())).read_info().unwrap();
        assert_eq!(png.info().size(), (40, 20));
        for name in ["b.svg", "b.svgz", "b.pdf", "b.eps", "b.dxf", "b.png"] {
            assert!(save_at(&path(name), "0").is_err(), "{name}");
        }
        assert_eq!(names(folder.path()), ["a.dxf", "a.eps", "a.json", "a.pdf", "a.png", "a.svg", "a.svgz"]);
        assert_eq!(Format::ALL.len(), 7);
    }

    #[test]
    fn a_missing_folder_is_one_sentence() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("none").join("a.svg");
        let error = save_at(&path, "40px").unwrap_err();
        let expected = format!("{}: the folder {} does not exist", path.display(), folder.path().join("none").display());
        assert_eq!((error.to_string(), error.exit_code()), (expected, 1));
        assert_eq!(names(folder.path()), Vec::<String>::new());
    }

    #[test]
    fn when_one_file_fails_none_is_written() {
        let folder = tempfile::tempdir().unwrap();
        let (good, bad) = (folder.path().join("a.svg"), folder.path().join("folder.png"));
        fs::write(&good, "before").unwrap();
        let files = [&good, &bad].map(|path| (Target::find(path, false).unwrap(), b"after".to_vec()));
        // It is in the way when all is complete, and the first file has its name by then.
        fs::create_dir(folder.path().join("gone")).unwrap();
        let lost = Target::find(&folder.path().join("gone").join("b.svg"), false).unwrap();
        fs::remove_dir(folder.path().join("gone")).unwrap();
        let all = files.into_iter().chain([(lost, vec![])]).collect();
        let error = write_all(all, |_, _| unreachable!("there are only files")).unwrap_err();
        assert!(error.to_string().contains("b.svg: "), "{error}");
        assert_eq!(fs::read(&good).unwrap(), b"before");
        assert_eq!(names(folder.path()), ["a.svg"]);
        fs::create_dir(&bad).unwrap();
        for bad in [bad, folder.path().join("new.svg/")] {
            let error = Target::find(&bad, false).unwrap_err();
            assert_eq!(error.to_string(), format!("{}: this is a folder, not a file", bad.display()));
        }
    }

    #[test]
    fn a_read_only_file_is_overwritten_by_force_alone() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("a.svg");
        fs::write(&path, "before").unwrap();
        let mut permissions = fs::metadata(&path).unwrap().permissions();
        permissions.set_readonly(true);
        fs::set_permissions(&path, permissions).unwrap();
        let error = write(&path, b"after").unwrap_err();
        let expected = format!("{}: the file is read-only: force=True overwrites it", path.display());
        assert_eq!((error.to_string(), error.exit_code()), (expected, 1));
        assert_eq!(fs::read(&path).unwrap(), b"before");
        if cfg!(unix) {
            Target::find(&path, true).unwrap().write(b"after").unwrap();
            assert_eq!(fs::read(&path).unwrap(), b"after");
            assert!(fs::metadata(&path).unwrap().permissions().readonly());
        }
    }

    #[test]
    fn files_are_told_apart_whatever_their_names() {
        let folder = tempfile::tempdir().unwrap();
        let path = |name: &str| folder.path().join(name);
        fs::create_dir(path("sub")).unwrap();
        fs::write(path("there"), "").unwrap();
        for [a, b] in [["there", "sub/../there"], ["new", "./new"], ["sub/../new", "new"], ["sub/new", "sub/./new"]] {
            assert!(is_same_file(&path(a), &path(b)), "{a} {b}");
        }
        for [a, b] in [["there", "new"], ["new", "sub/new"], ["new", "newer"], ["none/new", "none/newer"]] {
            assert!(!is_same_file(&path(a), &path(b)), "{a} {b}");
        }
    }

    #[cfg(unix)]
    mod on_unix {
        use std::os::unix::fs::{MetadataExt, PermissionsExt, symlink};
        use std::thread;

        use super::*;

        fn mode(path: &Path) -> u32 {
            fs::metadata(path).unwrap().permissions().mode() & 0o7777
        }

        #[test]
        fn new_files_have_ordinary_permissions_and_old_ones_keep_theirs() {
            let folder = tempfile::tempdir().unwrap();
            let (plain, ours) = (folder.path().join("plain"), folder.path().join("ours"));
            fs::write(&plain, "").unwrap();
            write(&ours, b"one").unwrap();
            assert_eq!(mode(&ours), mode(&plain));
            for kept in [0o600, 0o640, 0o666, 0o755, 0o200] {
                fs::set_permissions(&ours, PermissionsExt::from_mode(kept)).unwrap();
                write(&ours, b"two").unwrap();
                assert_eq!(mode(&ours), kept);
            }
            // Whoever may not give it away keeps it.
            let is_given = std::os::unix::fs::chown(&ours, Some(4321), Some(8765)).is_ok();
            write(&ours, b"three").unwrap();
            let now = fs::metadata(&ours).unwrap();
            assert_eq!((now.uid(), now.gid()) == (4321, 8765), is_given);
        }

        #[test]
        fn links_stay_links_and_hard_links_part() {
            let folder = tempfile::tempdir().unwrap();
            let path = |name: &str| folder.path().join(name);
            write(&path("ours"), b"one").unwrap();
            symlink("ours", path("link")).unwrap();
            symlink("link", path("longer")).unwrap();
            fs::hard_link(path("ours"), path("twin")).unwrap();
            write(&path("longer"), b"two").unwrap();
            assert!(["link", "longer"].iter().all(|name| path(name).is_symlink()));
            assert_eq!((fs::read(path("ours")).unwrap(), fs::read(path("twin")).unwrap()), (b"two".to_vec(), b"one".to_vec()));
            // What a link leads to is made where it is not there yet, and its folder is not.
            symlink("later", path("dangling")).unwrap();
            write(&path("dangling"), b"three").unwrap();
            assert!(path("dangling").is_symlink() && !path("later").is_symlink());
            assert_eq!(fs::read(path("later")).unwrap(), b"three");
            symlink("none/later", path("astray")).unwrap();
            let error = write(&path("astray"), b"").unwrap_err().to_string();
            assert!(error.ends_with("none does not exist"), "{error}");
            symlink("round", path("round")).unwrap();
            assert!(write(&path("round"), b"").is_err());
            assert_eq!(names(folder.path()), ["astray", "dangling", "later", "link", "longer", "ours", "round", "twin"]);
        }

        #[test]
        fn links_lead_to_one_file() {
            let folder = tempfile::tempdir().unwrap();
            let path = |name: &str| folder.path().join(name);
            symlink("new", path("link")).unwrap();
            symlink(folder.path(), path("here")).unwrap();
            assert!(is_same_file(&path("link"), &path("here/new")));
            fs::write(path("new"), "").unwrap();
            fs::hard_link(path("new"), path("twin")).unwrap();
            assert!(is_same_file(&path("link"), &path("here/new")) && is_same_file(&path("twin"), &path("link")));
            for name in ["a.svg", "b.png"] {
                symlink("/dev/null", path(name)).unwrap();
            }
            assert!(!is_same_file(&path("a.svg"), &path("b.png")));
        }

        #[test]
        fn devices_and_pipes_are_written_to() {
            let folder = tempfile::tempdir().unwrap();
            let null = folder.path().join("null.svg");
            symlink("/dev/null", &null).unwrap();
            let target = Target::find(&null, false).unwrap();
            target.write(b"gone").unwrap();
            assert!(target.is_stream() && null.is_symlink());
            assert!(!fs::metadata("/dev/null").unwrap().is_file());

            let pipe = folder.path().join("pipe.svg");
            assert!(std::process::Command::new("mkfifo").arg(&pipe).status().unwrap().success());
            let target = Target::find(&pipe, false).unwrap();
            let long = vec![b'x'; 1 << 20];
            let written = long.clone();
            let writer = thread::spawn(move || target.write(&written));
            assert_eq!(fs::read(&pipe).unwrap(), long);
            writer.join().unwrap().unwrap();
            assert_eq!(names(folder.path()), ["null.svg", "pipe.svg"]);
        }

        #[test]
        fn a_file_that_was_given_open_goes_on_where_it_ends() {
            use std::os::fd::AsRawFd;
            let folder = tempfile::tempdir().unwrap();
            let (log, link) = (folder.path().join("log"), folder.path().join("link.svg"));
            fs::write(&log, "before ").unwrap();
            let open = OpenOptions::new().append(true).open(&log).unwrap();
            symlink(format!("/dev/fd/{}", open.as_raw_fd()), &link).unwrap();
            write(&link, b"after").unwrap();
            assert_eq!(fs::read(&log).unwrap(), b"before after");
            assert_eq!(names(folder.path()), ["link.svg", "log"]);
        }
    }
}
