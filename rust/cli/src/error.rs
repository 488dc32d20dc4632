//! What can go wrong around the core: files and arguments. Every message is one sentence meant for the user.

use std::io;
use std::path::PathBuf;

/// An error of the command line or of reading and writing files.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum Error {
    /// The arguments break a rule: an unknown option, a suffix that stands for no format, and the like.
    #[error("{0}")]
    Usage(String),
    /// A file cannot be read or written.
    #[error("{}: {}", path.display(), sentence(source))]
    File {
        /// Which file.
        path: PathBuf,
        /// What the system said.
        source: io::Error,
    },
    /// A file was read, but its content is no image that the core takes.
    #[error("{}: {source}", path.display())]
    Photo {
        /// Which file; `-` is standard input.
        path: PathBuf,
        /// What is wrong with it.
        source: graphstipple_core::Error,
    },
    /// The core refused or failed.
    #[error(transparent)]
    Core(#[from] graphstipple_core::Error),
    /// A file that is there must not be written.
    #[error("{}: the file is read-only: force=True overwrites it", path.display())]
    ReadOnly {
        /// Which file.
        path: PathBuf,
    },
    /// All is written, but the drawing breaks rules that it must keep.
    #[error("{0}")]
    Broken(String),
    /// The user or the system asked to stop.
    #[error("interrupted")]
    Interrupted(
        /// The exit code that says by what.
        u8,
    ),
}

/// The exit code of a run that Ctrl-C stopped: as shells have it, 128 and the number of the signal.
pub const INTERRUPTED: u8 = 130;

/// The result type of this crate.
pub type Result<T, E = Error> = std::result::Result<T, E>;

impl Error {
    /// The exit code that stands for it: 1 failure, 2 usage, 3 rules that are broken, of an interruption its own.
    pub fn exit_code(&self) -> u8 {
        match self {
            Self::Usage(_) | Self::Core(graphstipple_core::Error::Option { .. }) => 2,
            Self::Broken(_) => 3,
            Self::Interrupted(code) => *code,
            Self::Core(graphstipple_core::Error::Cancelled) => INTERRUPTED,
            Self::File { .. } | Self::ReadOnly { .. } | Self::Photo { .. } | Self::Core(_) => 1,
        }
    }
}

/// The common cases in plain words, without the system's error numbers.
fn sentence(error: &io::Error) -> String {
    match error.kind() {
        io::ErrorKind::NotFound => "the file does not exist".into(),
        io::ErrorKind::PermissionDenied => "permission denied".into(),
        io::ErrorKind::IsADirectory => "this is a folder, not a file".into(),
        io::ErrorKind::StorageFull => "there is no space left on the disk".into(),
        _ => error.to_string(),
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use graphstipple_core::Error as Core;

    #[test]
    fn the_exit_code_says_who_can_help() {
        let option = Core::Option { option: "gamma".into(), value: "0".into(), allowed: "between 0.1 and 10".into() };
        let missing = Error::File { path: "a.svg".into(), source: io::ErrorKind::NotFound.into() };
        for (error, code) in [
            (Error::Usage("--gamma is 0".into()), 2),
            (Error::Core(option), 2),
            (Error::Core(Core::Input("the image is empty".into())), 1),
            (Error::Photo { path: "a.png".into(), source: Core::Decode("the file is empty".into()) }, 1),
            (missing, 1),
            (Error::ReadOnly { path: "a.svg".into() }, 1),
            (Error::Broken("the drawing breaks the rules: 1 gap".into()), 3),
            (Error::Core(Core::Cancelled), INTERRUPTED),
            (Error::Interrupted(143), 143),
        ] {
            assert_eq!(error.exit_code(), code, "{error}");
        }
    }
}
