//! Presets: options under a name that says what they give.
//!
//! Each differs from the defaults in a few options; any of them can be changed again. A preset may suggest the inks to write with.

use crate::base::{Error, Result, or_nearest};

use super::{Only, Options};

/// A named set of options.
#[derive(Debug, Clone, PartialEq)]
pub struct Preset {
    /// One lower-case word.
    pub name: &'static str,
    /// What it gives, in a few words.
    pub description: &'static str,
    /// Its options in full.
    pub options: Options,
    /// What a flat vector file is best drawn with.
    pub only: Only,
}

/// All presets, the default first.
pub fn presets() -> Vec<Preset> {
    let of = |name, description, options| Preset { name, description, options, only: Only::default() };
    let defaults = Options::default;
    vec![
        of("default", "clean shapes, dots where tone needs them", defaults()),
        of("paper", "the published method as it is, without what we add to it", Options::paper()),
        of(
            "stipple",
            "evenly spaced dots for every tone, white on black in the dark; shapes at strong edges alone",
            Options { stippling: 0.8, floor: 0.4, midtones: 0.5, ..defaults() },
        ),
        of(
            "portrait",
            "soft shading: dots for skin of any tone, shapes for features, gentle emphasis",
            Options { stippling: 0.65, crispness: 1.2, floor: 0.25, sharpen: 1.5, local_contrast: 1.0, ..defaults() },
        ),
        of(
            "linocut",
            "bold: large smooth shapes, few marks, hardly a dot",
            Options {
                fineness: 1.0 / 3.0,
                stippling: 0.0,
                shading: 0.04,
                crispness: 8.0,
                cohesion: 1.0,
                midtones: 0.9,
                sharpen: 0.0,
                local_contrast: 3.0,
                tolerance: 1.0,
                ..defaults()
            },
        ),
        of(
            "poster",
            "boldest: a few flat areas of black and white",
            Options {
                fineness: 0.2,
                stippling: 0.0,
                shading: 0.0,
                crispness: 30.0,
                cohesion: 3.0,
                sharpen: 0.0,
                local_contrast: 2.0,
                tone_tolerance: None,
                tolerance: 1.0,
                ..defaults()
            },
        ),
        Preset {
            only: Only::named(&["white"]),
            ..of(
                "scratchboard",
                "white lines and dots scratched out of black (written as white ink on black paper)",
                Options {
                    gamma: 0.5,
                    shading: 0.15,
                    crispness: 3.0,
                    sharpen: 5.0,
                    local_contrast: 1.0,
                    tone_tolerance: None,
                    ..defaults()
                },
            )
        },
    ]
}

/// The preset of a name.
///
/// # Errors
/// [`Error::Option`] that lists the names.
pub fn preset(name: &str) -> Result<Preset> {
    let all = presets();
    all.iter().find(|preset| preset.name == name).cloned().ok_or_else(|| {
        let names: Vec<&str> = all.iter().map(|preset| preset.name).collect();
        let (last, rest) = names.split_last().expect("there are presets");
        let allowed = format!("{} or {last}", rest.join(", "));
        Error::option("preset", name, or_nearest(&allowed, name, names, str::to_owned))
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn presets_are_valid_differ_and_are_found_by_name() {
        let all = presets();
        for (i, one) in all.iter().enumerate() {
            one.options.clone().check().unwrap();
            assert_eq!(preset(one.name).unwrap(), *one);
            assert!(all[..i].iter().all(|other| other.name != one.name && other.options != one.options));
        }
        assert_eq!((all[0].options.clone(), all[1].options.clone()), (Options::default(), Options::paper()));
        let error = preset("lino").unwrap_err().to_string();
        assert!(all.iter().all(|one| error.contains(one.name)), "{error}");
        let error = preset("potrait").unwrap_err().to_string();
        assert!(error.ends_with("poster or scratchboard; did you mean portrait?"), "{error}");
        assert!(preset("engraving").unwrap_err().to_string().ends_with("poster or scratchboard"));
    }
}
