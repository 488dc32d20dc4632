//! Machines by name or by the file of a profile.

use std::fs::File;
use std::io::Read;
use std::path::Path;

use graphstipple_core::stages::Machine;

use crate::error::{Error, Result};

/// The largest file that is read as a profile, in bytes. Those that come with the program have a few thousand.
const LARGEST: u64 = 1 << 20;

/// The machine of this name, or of the profile in this file.
///
/// # Errors
/// [`Error::Core`] with the names if it is neither; [`Error::File`] if the file cannot be read; [`Error::Photo`] if it is no profile.
pub fn machine(name: &str) -> Result<Machine> {
    let path = Path::new(name);
    let is_name = path.extension().is_none() && path.parent().is_none_or(|folder| folder.as_os_str().is_empty());
    if is_name {
        return Ok(Machine::shipped(name)?);
    }
    let failed = |source| Error::File { path: path.to_owned(), source };
    let file = File::open(path).map_err(failed)?;
    let mut bytes = Vec::new();
    file.take(LARGEST + 1).read_to_end(&mut bytes).map_err(failed)?;
    let refused = |source| Error::Photo { path: path.to_owned(), source };
    if bytes.len() as u64 > LARGEST {
        let told = format!("a profile has at most {LARGEST} bytes, and this file has more");
        return Err(refused(graphstipple_core::Error::Input(told)));
    }
    let text =
        String::from_utf8(bytes).map_err(|_| refused(graphstipple_core::Error::Input("the file is not text in UTF-8".into())))?;
    Machine::parse(&text).map_err(refused)
}
