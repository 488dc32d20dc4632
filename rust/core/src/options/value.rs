//! Values as front ends have them, and the rules that say which of them an option takes.
//!
//! A command line has words, Python has objects, a file has JSON: each makes [`Value`]s of them, once, and an option's [`Rule`] says
//! whether it takes one and what it takes instead.

use std::fmt;

use super::numbers::{exact, whole};
use crate::base::{Color, or_nearest};

/// A value that somebody gives to an option, or that an option has.
#[derive(Debug, Clone, PartialEq)]
pub enum Value {
    /// None at all: the option then has a meaning of its own.
    Absent,
    /// Yes or no.
    Switch(bool),
    /// A whole number of at least 0.
    Whole(u64),
    /// Any other number.
    Number(f64),
    /// A word.
    Word(String),
    /// What no option takes, as it is told to whoever gave it.
    Foreign(String),
}

impl fmt::Display for Value {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Absent => f.write_str("None"),
            Self::Switch(true) => f.write_str("True"),
            Self::Switch(false) => f.write_str("False"),
            Self::Whole(number) => number.fmt(f),
            // Not three hundred digits.
            Self::Number(number) if number.abs() >= 1e17 => write!(f, "{number:e}"),
            Self::Number(number) => number.fmt(f),
            Self::Word(word) => write!(f, "\"{word}\""),
            Self::Foreign(text) => f.write_str(text),
        }
    }
}

impl Value {
    /// What is allowed in place of this value, and after it which of these words it was probably meant to be.
    pub(crate) fn or_nearest<'a>(&self, allowed: &str, words: impl IntoIterator<Item = &'a str>) -> String {
        let Self::Word(given) = self else { return allowed.to_owned() };
        or_nearest(allowed, given, words, |word| format!("\"{word}\""))
    }
}

impl From<&Value> for serde_json::Value {
    fn from(value: &Value) -> Self {
        match value {
            Value::Absent => Self::Null,
            Value::Switch(is_on) => (*is_on).into(),
            Value::Whole(number) => (*number).into(),
            Value::Number(number) => (*number).into(),
            Value::Word(text) | Value::Foreign(text) => text.as_str().into(),
        }
    }
}

impl From<&serde_json::Value> for Value {
    fn from(json: &serde_json::Value) -> Self {
        match json {
            serde_json::Value::Null => Self::Absent,
            serde_json::Value::Bool(is_on) => Self::Switch(*is_on),
            serde_json::Value::Number(number) => match (number.as_u64(), number.as_f64()) {
                (Some(whole), _) => Self::Whole(whole),
                (None, Some(number)) => Self::Number(number),
                (None, None) => Self::Foreign(number.to_string()),
            },
            serde_json::Value::String(text) => Self::Word(text.clone()),
            other => Self::Foreign(other.to_string()),
        }
    }
}

/// A type that an option's field has.
pub(crate) trait Typed: Sized {
    /// The value as this type, if it is one; ranges are the rule's.
    fn read(value: &Value) -> Option<Self>;

    /// As front ends see it.
    fn value(&self) -> Value;
}

impl Typed for bool {
    fn read(value: &Value) -> Option<Self> {
        if let Value::Switch(is_on) = value { Some(*is_on) } else { None }
    }

    fn value(&self) -> Value {
        Value::Switch(*self)
    }
}

impl Typed for f64 {
    fn read(value: &Value) -> Option<Self> {
        match value {
            Value::Number(number) => Some(*number),
            Value::Whole(number) => Some(*number as f64),
            _ => None,
        }
    }

    fn value(&self) -> Value {
        Value::Number(*self)
    }
}

impl Typed for u64 {
    /// Floats that are whole numbers too, such as 1e5.
    fn read(value: &Value) -> Option<Self> {
        match value {
            Value::Whole(number) => Some(*number),
            Value::Number(number) => exact(*number),
            _ => None,
        }
    }

    fn value(&self) -> Value {
        Value::Whole(*self)
    }
}

impl Typed for u32 {
    fn read(value: &Value) -> Option<Self> {
        u64::read(value)?.try_into().ok()
    }

    fn value(&self) -> Value {
        Value::Whole(u64::from(*self))
    }
}

impl Typed for usize {
    fn read(value: &Value) -> Option<Self> {
        u64::read(value)?.try_into().ok()
    }

    fn value(&self) -> Value {
        Value::Whole(*self as u64)
    }
}

impl Typed for Color {
    fn read(value: &Value) -> Option<Self> {
        if let Value::Word(word) = value { word.parse().ok() } else { None }
    }

    fn value(&self) -> Value {
        Value::Word(self.to_string())
    }
}

impl<T: Typed> Typed for Option<T> {
    fn read(value: &Value) -> Option<Self> {
        if *value == Value::Absent { Some(None) } else { T::read(value).map(Some) }
    }

    fn value(&self) -> Value {
        self.as_ref().map_or(Value::Absent, T::value)
    }
}

/// Which values an option takes, besides [`Value::Absent`].
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Rule {
    /// Numbers from the first to the second.
    Within(f64, f64),
    /// Numbers above 0, up to this one.
    UpTo(f64),
    /// Whole numbers from the first to the second.
    Whole(u64, u64),
    /// `True` or `False`; on the command line a flag by itself.
    Switch,
    /// One of these words.
    Words(&'static [&'static str]),
    /// One of these words, or a number from the first to the second.
    WordsOrWithin(&'static [&'static str], f64, f64),
    /// `white`, `black`, `#rrggbb` or `#rgb`.
    Color,
    /// Colours with commas between them, each with a name before it if it has one.
    Inks,
}

/// The least number that counts as above 0: smaller ones mean nothing even on the largest canvas.
const ABOVE_ZERO: f64 = 1e-9;

/// What is read as inks, for messages.
const INKS_ALLOWED: &str =
    "colours with commas between them, each white, black, #rrggbb or #rgb, or name=colour with a name of a-z, 0-9 and -";

impl Rule {
    /// Whether a value keeps the rule.
    pub fn takes(self, value: &Value) -> bool {
        let within = |least: f64, most: f64| f64::read(value).is_some_and(|number| number >= least && number <= most);
        let among = |words: &[&str]| matches!(value, Value::Word(word) if words.contains(&word.as_str()));
        match self {
            Self::Within(least, most) => within(least, most),
            Self::UpTo(most) => within(ABOVE_ZERO, most),
            Self::Whole(least, most) => matches!(value, Value::Whole(number) if (least..=most).contains(number)),
            Self::Switch => matches!(value, Value::Switch(_)),
            Self::Words(words) => among(words),
            Self::WordsOrWithin(words, least, most) => among(words) || within(least, most),
            // A field of this type holds nothing else.
            Self::Color | Self::Inks => matches!(value, Value::Word(_)),
        }
    }

    /// The words that it takes, if they are all known.
    pub fn words(self) -> impl Iterator<Item = &'static str> {
        let words = match self {
            Self::Words(words) | Self::WordsOrWithin(words, ..) => words,
            _ => &[],
        };
        words.iter().copied()
    }

    /// The value that a word on a command line stands for.
    pub(super) fn parse(self, text: &str) -> Value {
        let number = || text.parse().map_or_else(|_| Value::Word(text.to_owned()), Value::Number);
        match self {
            Self::Within(..) | Self::UpTo(_) | Self::WordsOrWithin(..) => number(),
            Self::Whole(..) => whole(text).map_or_else(number, Value::Whole),
            Self::Switch => match text {
                "true" => Value::Switch(true),
                "false" => Value::Switch(false),
                _ => Value::Word(text.to_owned()),
            },
            Self::Words(_) | Self::Color | Self::Inks => Value::Word(text.to_owned()),
        }
    }

    /// What is allowed, as the end of a sentence that begins with "it must be".
    pub fn allowed(self) -> String {
        match self {
            Self::Within(least, most) => format!("between {least} and {most}"),
            Self::UpTo(most) => format!("above 0 and at most {most}"),
            Self::Whole(least, most) => format!("between {least} and {most}"),
            Self::Switch => "True or False".to_owned(),
            Self::Words(words) => listed(words),
            Self::WordsOrWithin(words, least, most) => {
                let words: Vec<String> = words.iter().map(|word| format!("\"{word}\"")).collect();
                format!("{} or a number between {least} and {most}", words.join(", "))
            }
            Self::Color => Color::ALLOWED.to_owned(),
            Self::Inks => INKS_ALLOWED.to_owned(),
        }
    }

    /// What sort of value it takes, where values of another sort are refused: "a number ", or nothing where `allowed` says it.
    pub(super) fn sort(self, given: &Value) -> &'static str {
        match (self, given) {
            (Self::Within(..) | Self::UpTo(_), Value::Number(_) | Value::Whole(_)) | (Self::Whole(..), Value::Whole(_)) => "",
            (Self::Within(..) | Self::UpTo(_), _) => "a number ",
            (Self::Whole(..), Value::Number(number)) if *number < 0.0 => "",
            (Self::Whole(..), _) => "a whole number ",
            _ => "",
        }
    }
}

/// Words in quotes, the last after "or".
pub(crate) fn listed(words: &[&str]) -> String {
    let quoted: Vec<String> = words.iter().map(|word| format!("\"{word}\"")).collect();
    match quoted.split_last() {
        Some((last, rest)) if !rest.is_empty() => format!("{} or {last}", rest.join(", ")),
        _ => quoted.join(""),
    }
}

/// An enumeration whose variants are words, the same in Rust, Python, the command line and files.
macro_rules! words {
    ($(#[$about:meta])* $name:ident { $($(#[$doc:meta])* $variant:ident = $word:literal,)+ }) => {
        $(#[$about])*
        #[derive(Debug, Clone, Copy, PartialEq, Eq)]
        pub enum $name { $($(#[$doc])* $variant,)+ }

        impl Default for $name {
            /// The first.
            fn default() -> Self {
                [$(Self::$variant),+][0]
            }
        }

        impl $name {
            /// All words.
            pub const WORDS: &'static [&'static str] = &[$($word),+];

            /// As it is written.
            pub fn name(self) -> &'static str {
                match self { $(Self::$variant => $word,)+ }
            }
        }

        impl $crate::options::Typed for $name {
            fn read(value: &$crate::options::Value) -> Option<Self> {
                match value {
                    $($crate::options::Value::Word(word) if word == $word => Some(Self::$variant),)+
                    _ => None,
                }
            }

            fn value(&self) -> $crate::options::Value {
                $crate::options::Value::Word(self.name().to_owned())
            }
        }
    };
}
pub(crate) use words;

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn words_on_a_command_line_are_what_the_rule_takes() {
        let whole = Rule::Whole(0, 1 << 53);
        for (text, value) in [
            ("7", Value::Whole(7)),
            ("1e5", Value::Whole(100_000)),
            ("100k", Value::Whole(100_000)),
            ("9007199254740993", Value::Whole(9_007_199_254_740_993)),
            ("1.5", Value::Number(1.5)),
            ("-1", Value::Number(-1.0)),
            ("1e300", Value::Number(1e300)),
            ("many", Value::Word("many".into())),
        ] {
            assert_eq!(whole.parse(text), value);
        }
        assert_eq!(
            [1e5, -1.0, 0.5, 1e300, f64::NAN].map(|number| u64::read(&Value::Number(number))),
            [Some(100_000), None, None, None, None]
        );
        assert_eq!(Rule::Within(0.0, 1.0).parse("inf"), Value::Number(f64::INFINITY));
        assert_eq!(Rule::WordsOrWithin(&["tonal"], 0.0, 1.0).parse("0.5"), Value::Number(0.5));
        assert_eq!(Rule::Words(&["rows"]).parse("3"), Value::Word("3".into()));
        assert_eq!(Rule::Switch.parse("true"), Value::Switch(true));
    }

    #[test]
    fn rules_take_what_they_say() {
        let numbers = |rule: Rule| [-0.1, 0.0, 1e-12, 0.5, 1.0, 1.1, f64::NAN].map(|number| rule.takes(&Value::Number(number)));
        assert_eq!(numbers(Rule::Within(0.0, 1.0)), [false, true, true, true, true, false, false]);
        assert_eq!(numbers(Rule::UpTo(1.0)), [false, false, false, true, true, false, false]);
        assert!(Rule::Within(0.0, 4.0).takes(&Value::Whole(3)) && !Rule::Within(0.0, 4.0).takes(&Value::Switch(true)));
        assert!(Rule::Whole(3, 4).takes(&Value::Whole(3)) && !Rule::Whole(3, 4).takes(&Value::Number(3.0)));
        assert!(Rule::Words(&["a", "b"]).takes(&Value::Word("b".into())) && !Rule::Words(&["a"]).takes(&Value::Word("c".into())));
        assert_eq!(Rule::Words(&["a", "b", "c"]).allowed(), "\"a\", \"b\" or \"c\"");
    }
}
