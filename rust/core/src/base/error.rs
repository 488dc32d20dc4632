//! What can go wrong, as one enum: every message names what is wrong, the value, and what is allowed.

/// An error of the core. Its text is one sentence meant for the user.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum Error {
    /// An option is out of its range.
    #[error("{option} is {value}, but it must be {allowed}")]
    Option {
        /// The option's name, as in [`crate::Options`].
        option: String,
        /// The value that was given.
        value: String,
        /// What is allowed.
        allowed: String,
    },
    /// An input array or a stage's argument breaks a rule: shapes differ, a value is not finite, and the like.
    #[error("{0}")]
    Input(String),
    /// An image file's bytes cannot be read as an image: they are none, or damaged, or too many.
    #[error("{0}")]
    Decode(String),
    /// A file may be a sound image, but of a format or with a feature that is not read here; other programs may read it.
    #[error("{0}")]
    Unsupported(String),
    /// The caller asked to stop through [`crate::Control::cancel`].
    #[error("the work was cancelled")]
    Cancelled,
    /// A rule that the program itself must keep is broken: a defect of graphstipple.
    #[error("internal error, please report it: {0}")]
    Internal(String),
}

/// The core's result type.
pub type Result<T, E = Error> = std::result::Result<T, E>;

impl Error {
    /// An option with this value, which is not allowed.
    pub(crate) fn option(option: impl Into<String>, value: impl ToString, allowed: impl Into<String>) -> Self {
        Self::Option { option: in_one_line(&option.into()), value: in_one_line(&value.to_string()), allowed: allowed.into() }
    }
}

/// What somebody gave, as a sentence may quote it: without line breaks and what else controls a terminal.
pub(crate) fn in_one_line(given: &str) -> String {
    let shown = |c: char| if c.is_control() { c.escape_default().to_string() } else { c.to_string() };
    given.chars().map(shown).collect()
}
