//! Where the importance comes from, as users name it: in, a name or a map; out, an [`Importance`].
//!
//! Each kind of source is a line of [`KINDS`], from which help and messages come too. Names that stand for nothing here are paths of
//! image files, which whoever asks reads: the core opens none.

use super::{Importance, saliency};
use crate::base::{Control, Error, Pool, Result, Step};
use crate::photo::{Field, Photo};

/// Where the importance comes from.
#[derive(Debug, Clone)]
pub enum Source {
    /// A map that the program makes of the photo.
    OfPhoto {
        /// As users name it.
        name: &'static str,
        /// The map, in [0, 1], of a photo's luma.
        make: fn(&Field) -> Field,
    },
    /// The same value everywhere, in (0, 1].
    Constant(f32),
    /// A map in an image file: white is important.
    File(String),
    /// A map of any size: 1 is important.
    Map(Photo),
}

/// A kind of source that has a name.
#[derive(Debug, Clone, Copy)]
pub struct Kind {
    /// The name, as it is written.
    pub form: &'static str,
    /// What it stands for, in a few words.
    pub sentence: &'static str,
    /// Reads a name of this kind; `None` where it is none.
    read: fn(&str) -> Option<Result<Source>>,
}

/// Every kind of source, the default first; those that are tried later take what the earlier leave.
pub const KINDS: &[Kind] = &[
    Kind {
        form: "saliency",
        sentence: "what stands out of the photo, by fine-grained saliency",
        read: |name| (name == "saliency").then_some(Ok(Source::OfPhoto { name: "saliency", make: saliency::of_luma })),
    },
    Kind {
        form: "none",
        sentence: "the same detail everywhere",
        read: |name| (name == "none").then_some(Ok(Source::Constant(1.0))),
    },
    Kind {
        form: "constant:V",
        sentence: "the importance V, above 0 and at most 1, everywhere",
        read: |name| {
            let value = name.strip_prefix("constant:")?;
            Some(match value.parse::<f32>() {
                Ok(v) if v > 0.0 && v <= 1.0 => Ok(Source::Constant(v)),
                _ => Err(Error::option("importance", name, "constant:V with V above 0 and at most 1")),
            })
        },
    },
    Kind {
        form: "the path of an image file",
        sentence: "a map: white where detail is wanted",
        // A word that could be no image file is a name misspelt; such a file can still be given as ./word.
        read: |name| name.contains(['.', '/', '\\']).then(|| Ok(Source::File(name.to_owned()))),
    },
];

/// The forms of all kinds, for help and messages: `saliency, none, ... or the path of an image file`.
fn forms() -> String {
    let forms: Vec<&str> = KINDS.iter().map(|kind| kind.form).collect();
    forms.split_last().map_or_else(String::new, |(last, rest)| format!("{} or {last}", rest.join(", ")))
}

impl Source {
    /// Reads a name.
    ///
    /// # Errors
    /// [`Error::Option`] if it is of no kind, or the value after `constant:` is not a number above 0 and at most 1.
    pub fn parse(name: &str) -> Result<Self> {
        KINDS.iter().find_map(|kind| (kind.read)(name)).unwrap_or_else(|| Err(Error::option("importance", name, forms())))
    }

    /// What takes the time, for whoever measures it: making a map of the photo, or reading one.
    pub fn stage(&self) -> &'static str {
        match self {
            Self::OfPhoto { name, .. } => name,
            _ => "decoding",
        }
    }

    /// The importance of a photo, given as the luma that is drawn. `read` makes a map of the path of an image file.
    ///
    /// # Errors
    /// Those of `read`; [`Error::Cancelled`].
    pub fn evaluate<E: From<Error>>(
        self,
        luma: &Field,
        read: impl FnOnce(&str) -> Result<Photo, E>,
        control: &Control,
    ) -> Result<Importance, E> {
        control.begin(Step::Saliency)?;
        Ok(match self {
            Self::OfPhoto { name, make } => Importance::OfPhoto { name, map: Pool::new(None).run(|| make(luma)) },
            Self::Constant(value) => Importance::Constant(value),
            Self::File(path) => Importance::Map(read(&path)?),
            Self::Map(map) => Importance::Map(map),
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn names_stand_for_sources() {
        let luma = Field::constant(8, 6, 0.5).unwrap();
        let map = Photo::new(Field::constant(2, 2, 0.25).unwrap());
        let of = |name: &str| {
            let read = |path: &str| {
                assert_eq!(path, "map.png");
                Ok(map.clone())
            };
            Source::parse(name).unwrap().evaluate::<Error>(&luma, read, &Control::new())
        };
        assert_eq!(of("none").unwrap(), Importance::Constant(1.0));
        assert_eq!(of("constant:0.25").unwrap(), Importance::Constant(0.25));
        assert_eq!(of("map.png").unwrap(), Importance::Map(map.clone()));
        assert_eq!(of("saliency").unwrap(), Importance::OfPhoto { name: "saliency", map: saliency::of_luma(&luma) });
        assert!(matches!(Source::parse("./map"), Ok(Source::File(path)) if path == "./map"));
        for bad in ["constant:0", "constant:1.1", "constant:", "constant:NaN"] {
            assert!(Source::parse(bad).is_err(), "{bad}");
        }
        assert_eq!(
            Source::parse("salience").unwrap_err().to_string(),
            "importance is salience, but it must be saliency, none, constant:V or the path of an image file"
        );
    }
}
