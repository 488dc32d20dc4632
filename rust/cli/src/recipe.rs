//! Many photos by the flags of one command line: in, the flags and the formats; out, of any photo the bytes of its files.
//!
//! What this module does not do: find photos, write files, or share the work among processes (Python's `graphstipple.batch` does).

use std::ffi::OsString;
use std::sync::Arc;

use graphstipple_core::stages::{Checked, Stats};
use graphstipple_core::{Control, Format, Options};

use crate::arguments::Job;
use crate::command;
use crate::drawn::{self, Drawn};
use crate::error::{Error, Result};
use crate::files::{Input, Subject};
use crate::rules::of_tone;

/// How any photo is drawn and written.
#[derive(Debug, Clone)]
pub struct Recipe {
    job: Job,
}

/// What came of a photo.
#[derive(Debug)]
pub struct Written {
    /// The bytes of a file for every format, in their order.
    pub files: Vec<Vec<u8>>,
    /// Counts and times.
    pub stats: Stats,
    /// Sentences for the user.
    pub warnings: Vec<String>,
}

impl Recipe {
    /// What the flags of a command line ask for, without a photo and an output; files are written in each of the formats. Limits and the
    /// least radius of a dot are about the first of them, and the others have the same drawing. The file of an importance map is not
    /// opened where its bytes are given.
    ///
    /// # Errors
    /// As the command line's own.
    pub fn of(flags: Vec<OsString>, formats: &[Format], map: Option<Vec<u8>>) -> Result<Self> {
        let job = Job::of_flags(flags, formats)?;
        if let Some(Subject::File(mask)) = &job.subject {
            return Err(Error::Usage(format!(
                "--subject is {}, but of many photos it must be auto: each has a subject of its own",
                mask.display()
            )));
        }
        Ok(Self { job: Job { map: map.map(Arc::new), ..job } })
    }

    /// The options of every drawing.
    pub fn options(&self) -> &Checked<Options> {
        &self.job.options
    }

    /// Whether files that are read-only are overwritten.
    pub fn force(&self) -> bool {
        self.job.force
    }

    /// Draws a photo; the bytes are those that the command line writes.
    ///
    /// # Errors
    /// As the command line's own.
    pub fn draw(&self, input: Input, control: &Control) -> Result<Written> {
        let Drawn { outcome, changes, mut warnings } = drawn::draw(&self.job, input, control)?;
        warnings.extend(changes.as_ref().and_then(of_tone));
        let mut files = Vec::new();
        for writer in [&self.job.writer].into_iter().chain(&self.job.others) {
            control.check()?;
            warnings.extend(writer.warning(&outcome.drawing));
            files.push(writer.write(&outcome.drawing)?);
        }
        Ok(Written { files, stats: outcome.stats, warnings })
    }
}

/// A flag of a [`Recipe`].
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Flag {
    /// Without its hyphens.
    pub name: String,
    /// What its value is called; nothing for a switch.
    pub value_name: String,
    /// What it does.
    pub help: String,
    /// Under what it stands in the help.
    pub heading: String,
    /// Whether it is shown where not all are.
    pub is_everyday: bool,
}

/// Every flag that a [`Recipe`] takes, with all that there is to say of each, or the first of it.
pub fn flags(with_all: bool) -> Vec<Flag> {
    let flag = |argument: &clap::Arg| Flag {
        name: argument.get_long().unwrap_or_default().to_owned(),
        value_name: argument.get_value_names().and_then(|names| names.first()).map(ToString::to_string).unwrap_or_default(),
        help: argument.get_help().map(ToString::to_string).unwrap_or_default(),
        heading: argument.get_help_heading().unwrap_or_default().to_owned(),
        is_everyday: !argument.is_hide_set(),
    };
    command::of_any_photo(with_all).iter().map(flag).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    fn formats(suffixes: &[&str]) -> Vec<Format> {
        suffixes.iter().map(|suffix| Format::of_suffix(suffix).unwrap()).collect()
    }

    fn recipe(flags: &str, suffixes: &[&str]) -> Result<Recipe> {
        Recipe::of(flags.split_whitespace().map(OsString::from).collect(), &formats(suffixes), None)
    }

    #[test]
    fn settings_of_pixels_go_to_formats_with_pixels() {
        assert!(recipe("--dpi 300 --one-bit", &["svg", "png"]).is_ok());
        assert!(recipe("--dpi 300 --one-bit", &["png", "json"]).is_ok());
        let told = recipe("--dpi 300", &["svg", "pdf"]).unwrap_err().to_string();
        assert!(told.starts_with("--dpi is 300, but it must be left out"), "{told}");
        assert!(recipe("", &[]).is_err());
    }

    #[test]
    fn flags_are_those_of_the_command_line_without_files_and_prints() {
        let all = flags(true);
        let named = |name: &str| all.iter().find(|flag| flag.name == name);
        for name in ["output", "preview", "preview-width", "stats", "help", "version", "man", "photo", "pen", "check", "strict"] {
            assert_eq!(named(name), None, "{name}");
        }
        for name in [
            "preset",
            "nodes",
            "published",
            "importance",
            "page",
            "max-bytes",
            "min-dot",
            "process",
            "min-gap",
            "allow-damaged",
            "force",
        ] {
            assert!(named(name).is_some(), "{name}");
        }
        assert_eq!(named("invert").map(|flag| flag.value_name.as_str()), Some(""));
        assert_eq!(named("nodes").map(|flag| flag.value_name.as_str()), Some("N"));
    }
}
