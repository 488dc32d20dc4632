//! A file that is written before it has its name: in, a folder; out, a file that takes a name in it when it is complete.
//!
//! On Linux it has no name until then, where the file system can do that: so it is gone with the process, however that ends. Elsewhere
//! it has a temporary name, which is gone when it is dropped, but stays if the process is killed meanwhile.

use std::fs::File;
use std::io;
use std::path::Path;

use tempfile::{Builder, NamedTempFile};

/// A file that takes its name later.
#[derive(Debug)]
pub(crate) enum Scratch {
    #[cfg(target_os = "linux")]
    Unnamed(File),
    Named(NamedTempFile),
}

impl Scratch {
    /// An empty file in a folder, with the permissions that the process gives new files.
    pub(crate) fn new_in(folder: &Path) -> io::Result<Self> {
        #[cfg(target_os = "linux")]
        if let Ok(file) = unnamed::open(folder) {
            return Ok(Self::Unnamed(file));
        }
        named().tempfile_in(folder).map(Self::Named)
    }

    /// The file to write to.
    pub(crate) fn file(&self) -> &File {
        match self {
            #[cfg(target_os = "linux")]
            Self::Unnamed(file) => file,
            Self::Named(file) => file.as_file(),
        }
    }

    /// Gives the file its name, a path in its folder; what had it before is replaced.
    pub(crate) fn take_name(self, path: &Path) -> io::Result<()> {
        match self {
            #[cfg(target_os = "linux")]
            Self::Unnamed(file) => unnamed::take_name(file, path),
            Self::Named(file) => file.persist(path).map(drop).map_err(|error| error.error),
        }
    }
}

/// Temporary names.
fn named() -> Builder<'static, 'static> {
    let mut builder = Builder::new();
    builder.prefix(".graphstipple-").suffix(".tmp");
    // Temporary files are private by default; this one becomes an ordinary file. The process's umask applies.
    #[cfg(unix)]
    builder.permissions(std::os::unix::fs::PermissionsExt::from_mode(0o666));
    builder
}

#[cfg(target_os = "linux")]
mod unnamed {
    use std::io::Seek;
    use std::os::fd::AsRawFd;

    use rustix::fs::{AtFlags, CWD, Mode, OFlags};

    use super::*;

    /// Fails where the file system has no files without names.
    pub(super) fn open(folder: &Path) -> io::Result<File> {
        let file = rustix::fs::open(folder, OFlags::TMPFILE | OFlags::RDWR | OFlags::CLOEXEC, Mode::from_raw_mode(0o666))?;
        Ok(file.into())
    }

    pub(super) fn take_name(mut file: File, path: &Path) -> io::Result<()> {
        let link = |path: &Path| link(&file, path);
        // A name that nobody has is taken at once; one that somebody has, by a file with a name.
        if link(path).is_ok() {
            return Ok(());
        }
        let folder = path.parent().unwrap_or(Path::new("."));
        if let Ok(file) = named().make_in(folder, link) {
            return file.persist(path).map(drop).map_err(|error| error.error);
        }
        // Where the system does not give it a name, another file has what is in it.
        let mut copy = named().tempfile_in(folder)?;
        file.rewind()?;
        io::copy(&mut file, &mut copy)?;
        copy.as_file().set_permissions(file.metadata()?.permissions())?;
        copy.persist(path).map(drop).map_err(|error| error.error)
    }

    fn link(file: &File, path: &Path) -> io::Result<()> {
        let open = format!("/proc/self/fd/{}", file.as_raw_fd());
        Ok(rustix::fs::linkat(CWD, open.as_str(), CWD, path, AtFlags::SYMLINK_FOLLOW)?)
    }
}

#[cfg(test)]
mod tests {
    use std::fs;
    use std::io::Write;

    use super::*;

    #[test]
    fn both_kinds_take_names_that_are_free_and_those_that_are_not() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("a");
        let with_name = || Scratch::Named(named().tempfile_in(folder.path()).unwrap());
        for number in 0..4u8 {
            let scratch = if number % 2 == 0 { Scratch::new_in(folder.path()).unwrap() } else { with_name() };
            scratch.file().write_all(&[number; 9]).unwrap();
            scratch.take_name(&path).unwrap();
            assert_eq!(fs::read(&path).unwrap(), [number; 9]);
            assert_eq!(fs::read_dir(folder.path()).unwrap().count(), 1);
        }
        drop(with_name());
        assert_eq!(fs::read_dir(folder.path()).unwrap().count(), 1);
    }
}
