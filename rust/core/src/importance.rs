//! Where the importance comes from, as users name it, and the field that the first diffusion works on.
//!
//! Importance says where detail is wanted: 1 keeps every node, 0 none. What this module does not do: compute the saliency
//! (see [`crate::saliency`]) or read files.

use crate::error::{Error, Result};
use crate::field::Field;

/// What a user asks for by a name: `saliency`, `none`, `constant:V`, or else the path of an image file.
#[derive(Debug, Clone, PartialEq)]
pub enum Source {
    /// Fine-grained saliency of the photo.
    Saliency,
    /// The same value everywhere, in (0, 1]; `none` is 1.
    Constant(f32),
    /// A map in an image file: white is important.
    File(String),
}

impl Source {
    /// Reads a name.
    ///
    /// # Errors
    /// [`Error::Option`] if the value after `constant:` is not a number above 0 and at most 1.
    pub fn parse(name: &str) -> Result<Self> {
        match name {
            "saliency" => return Ok(Self::Saliency),
            "none" => return Ok(Self::Constant(1.0)),
            _ => {}
        }
        let Some(value) = name.strip_prefix("constant:") else {
            // A word that could be no image file is a name misspelt; such a file can still be given as ./word.
            if !name.contains(['.', '/', '\\']) {
                return Err(Error::Option {
                    option: "importance",
                    value: name.to_owned(),
                    allowed: "saliency, none, constant:V or the path of an image file",
                });
            }
            return Ok(Self::File(name.to_owned()));
        };
        match value.parse::<f32>() {
            Ok(v) if v > 0.0 && v <= 1.0 => Ok(Self::Constant(v)),
            _ => Err(Error::Option {
                option: "importance",
                value: name.to_owned(),
                allowed: "constant:V with V above 0 and at most 1",
            }),
        }
    }
}

/// The importance of a drawing, ready to use.
#[derive(Debug, Clone, PartialEq)]
pub enum Importance {
    /// A saliency map of the photo.
    Saliency(Field),
    /// The same value everywhere, in (0, 1].
    Constant(f32),
    /// The user's map, of any size: it is resampled to the photo.
    Map(Field),
}

impl Importance {
    /// How the metadata names it: `saliency`, `none`, `constant:V` or `map`.
    pub fn name(&self) -> String {
        match self {
            Self::Saliency(_) => "saliency".into(),
            Self::Constant(1.0) => "none".into(),
            Self::Constant(v) => format!("constant:{v}"),
            Self::Map(_) => "map".into(),
        }
    }

    /// The importance as a field of the canvas. A map that is 0 everywhere says nothing about where detail is wanted, so it
    /// stands for 1 everywhere (the saliency of flat and of tiny images is such a map).
    ///
    /// # Errors
    /// As [`Field::resample`].
    pub fn field(&self, width: usize, height: usize) -> Result<Field> {
        match self {
            Self::Constant(value) => Field::constant(width, height, *value),
            Self::Saliency(map) | Self::Map(map) if map.values().iter().all(|v| *v == 0.0) => Field::constant(width, height, 1.0),
            Self::Saliency(map) | Self::Map(map) => map.resample(width, height),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn names() {
        assert_eq!(Source::parse("none").unwrap(), Source::Constant(1.0));
        assert_eq!(Source::parse("constant:0.25").unwrap(), Source::Constant(0.25));
        assert_eq!(Source::parse("map.png").unwrap(), Source::File("map.png".into()));
        assert_eq!(Source::parse("./map").unwrap(), Source::File("./map".into()));
        for bad in ["salience", "constant:0", "constant:1.1", "constant:", "constant:NaN"] {
            assert!(Source::parse(bad).is_err(), "{bad}");
        }
    }

    #[test]
    fn an_empty_map_stands_for_one_everywhere() {
        let map = Importance::Map(Field::constant(3, 2, 0.0).unwrap());
        assert_eq!(map.field(4, 4).unwrap(), Field::constant(4, 4, 1.0).unwrap());
    }
}
