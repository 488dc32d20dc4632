//! The importance of a drawing, and what becomes of it on the canvas with the photo's detail: the field that the first diffusion works on.
//!
//! Importance says where detail is wanted: 1 keeps every node, 0 none. What this module does not do: make a map of the photo (see
//! [`super::saliency`]) or know names (see [`super::source`]).
//!
//! # Ours
//! Saliency alone (the paper's importance) leaves dark faces and wide skies without nodes, since it asks what differs from its
//! surroundings at the scale of objects. What a drawing needs nodes for is local: detail as fine as the nodes can show, in tones
//! that are neither black nor white anyway. So the importance is a floor, plus saliency and local detail in a given proportion, less
//! where the tone is near black or white, where solid ink or bare paper will do. A user's map says where detail is wanted, so it is
//! a factor on all of that; a constant is taken as it is.

use std::borrow::Cow;

use rayon::prelude::*;

use crate::base::Result;
use crate::options::Options;
use crate::photo::{FINE, Field, Photo, off_blurred};

/// The importance of a drawing, ready to use.
#[derive(Debug, Clone, PartialEq)]
pub enum Importance {
    /// A map that the program made of the photo.
    OfPhoto {
        /// As users name it.
        name: &'static str,
        /// In [0, 1].
        map: Field,
    },
    /// The same value everywhere, in (0, 1].
    Constant(f32),
    /// The user's map, of any size, as it was read: it is resampled to the photo's raster.
    Map(Photo),
}

impl Importance {
    /// A saliency map of the photo.
    pub fn saliency(map: Field) -> Self {
        Self::OfPhoto { name: "saliency", map }
    }

    /// How the metadata names it: `saliency`, `none`, `constant:V` or `map`.
    pub fn name(&self) -> String {
        match self {
            Self::OfPhoto { name, .. } => (*name).into(),
            Self::Constant(1.0) => "none".into(),
            Self::Constant(v) => format!("constant:{v}"),
            Self::Map(_) => "map".into(),
        }
    }

    /// The importance that the nodes are chosen by, on the canvas of `tone`: the map alone, or with the photo's detail mixed in as
    /// `detail`, `floor` and `midtones` of the options say. `emphasized` is the tone that is drawn, and `spacing` the distance of
    /// kept nodes in pixels.
    ///
    /// # Errors
    /// As [`Field::resample`].
    pub fn mixed(&self, tone: &Field, emphasized: &Field, spacing: f64, options: &Options) -> Result<Field> {
        let off = self.needs_detail(options).then(|| off_blurred(tone, spacing));
        self.mixed_with(off, emphasized, spacing, options)
    }

    /// Whether the photo's detail is mixed in.
    pub(crate) fn needs_detail(&self, options: &Options) -> bool {
        options.detail > 0.0 && !matches!(self, Self::Constant(_))
    }

    /// As [`Importance::mixed`], with what the tone's detail is made of ([`off_blurred`]) if [`Importance::needs_detail`].
    pub(crate) fn mixed_with(&self, off: Option<Field>, emphasized: &Field, spacing: f64, options: &Options) -> Result<Field> {
        let Options { detail: share, floor, midtones, .. } = *options;
        let (width, height) = (emphasized.width(), emphasized.height());
        let map = self.on_canvas(width, height)?;
        if !self.takes_from_photo(options) {
            return Ok(map.into_owned());
        }
        let detail = off.map(|off| detail(off, spacing));
        let is_factor = matches!(self, Self::Map(_));
        let mix = |i: usize, map: f32| {
            let map = f64::from(map);
            let guess = if is_factor { 1.0 } else { map };
            let detail = detail.as_ref().map_or(0.0, |d| f64::from(d.of(i)));
            let wanted = floor + (1.0 - floor) * ((1.0 - share) * guess + share * detail);
            let off_middle = 2.0 * f64::from(emphasized.values()[i]) - 1.0;
            let factor = if is_factor { map } else { 1.0 };
            (factor * wanted * (1.0 - midtones * off_middle * off_middle)).clamp(0.0, 1.0) as f32
        };
        let values = map.values().par_iter().enumerate().map(|(i, map)| mix(i, *map)).collect();
        Ok(Field::of_valid(width, height, values))
    }

    /// Whether [`Importance::mixed`] takes anything from the photo, or the map alone.
    pub(crate) fn takes_from_photo(&self, options: &Options) -> bool {
        !matches!(self, Self::Constant(_)) && [options.detail, options.floor, options.midtones] != [0.0; 3]
    }

    /// The map as a field of the canvas. A map that is 0 everywhere says nothing about where detail is wanted, so it
    /// stands for 1 everywhere (the saliency of flat and of tiny images is such a map).
    ///
    /// # Errors
    /// As [`Field::resample`].
    pub fn field(&self, width: usize, height: usize) -> Result<Field> {
        self.on_canvas(width, height).map(Cow::into_owned)
    }

    /// As [`Importance::field`], without a copy of a map that has the canvas's size.
    fn on_canvas(&self, width: usize, height: usize) -> Result<Cow<'_, Field>> {
        match self {
            Self::Constant(value) => Field::constant(width, height, *value).map(Cow::Owned),
            Self::OfPhoto { map, .. } => on_canvas(map, width, height),
            Self::Map(map) => on_canvas(map.luma(), width, height),
        }
    }
}

fn on_canvas(map: &Field, width: usize, height: usize) -> Result<Cow<'_, Field>> {
    if map.values().iter().all(|v| *v == 0.0) {
        return Field::constant(width, height, 1.0).map(Cow::Owned);
    }
    if [map.width(), map.height()] == [width, height] {
        return Ok(Cow::Borrowed(map));
    }
    map.resample(width, height).map(Cow::Owned)
}

/// The share of pixels whose detail counts as 1: single strong edges must not make all else seem flat.
const STRONGEST: f64 = 0.01;

/// The part of the largest detail that counts as 1 at least, where most of a photo is flat and its details are few.
const LEAST_OF_LARGEST: f32 = 0.1;

/// The detail that counts as 1 at least: half a grey level of 8-bit images, so that the noise of a flat photo is none.
const LEAST_DETAIL: f32 = 1.0 / 510.0;

/// Local detail of a tone.
struct Detail {
    blurred: Field,
    /// What counts as 1.
    one: f32,
}

impl Detail {
    /// The detail of a pixel, in [0, 1].
    fn of(&self, pixel: usize) -> f32 {
        (self.blurred.values()[pixel] / self.one).min(1.0)
    }
}

/// Local detail: how far the tone is from its mean at the scale of the nodes, which is `off`, averaged over as much.
fn detail(off: Field, spacing: f64) -> Detail {
    let blurred = off.blurred(FINE * spacing);
    drop(off);
    let rank = ((1.0 - STRONGEST) * (blurred.values().len() - 1) as f64) as usize;
    let (strong, largest) = blurred.of_rank(rank);
    Detail { blurred, one: strong.max(LEAST_OF_LARGEST * largest).max(LEAST_DETAIL) }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn an_empty_map_stands_for_one_everywhere() {
        let map = Importance::Map(Photo::new(Field::constant(3, 2, 0.0).unwrap()));
        assert_eq!(map.field(4, 4).unwrap(), Field::constant(4, 4, 1.0).unwrap());
    }

    #[test]
    fn the_mix_has_a_floor_detail_and_less_of_black_and_white() {
        // Flat black, flat middle grey, and a texture around middle grey.
        let tone = |x: usize, y: usize| match x {
            0..20 => 0.0,
            20..40 => 0.5,
            _ => 0.5 + if (x + y).is_multiple_of(2) { 0.1 } else { -0.1 },
        };
        let photo = Field::new(60, 20, (0..1200).map(|i| tone(i % 60, i / 60)).collect()).unwrap();
        let saliency = Importance::saliency(Field::constant(60, 20, 0.5).unwrap());
        let options = Options { detail: 1.0, floor: 0.25, midtones: 0.8, ..Options::default() };
        let at = |importance: &Importance, options: &Options| {
            let field = importance.mixed(&photo, &photo, 2.0, options).unwrap();
            [10, 30, 50].map(|x| (f64::from(field.at(x, 10)) * 1e4).round() / 1e4)
        };
        let [black, flat, textured] = at(&saliency, &options);
        assert_eq!([black, flat], [0.05, 0.25]);
        assert!(textured > 0.4, "{textured}");
        // Saliency takes its share; alone it is taken as it is.
        assert_eq!(at(&saliency, &Options { detail: 0.0, ..options.clone() })[1], 0.625);
        assert_eq!(at(&saliency, &Options { detail: 0.0, floor: 0.0, midtones: 0.0, ..options.clone() }), [0.5; 3]);
        // A user's map is a factor, a constant is what it says.
        let map = Importance::Map(Photo::new(Field::constant(60, 20, 0.5).unwrap()));
        assert_eq!(at(&map, &options)[1], 0.125);
        assert_eq!(at(&Importance::Constant(0.4), &options), [0.4; 3]);
        // A texture on less than a hundredth of an empty photo is detail all the same.
        let texture = |i: usize| if i % 200 < 8 && i < 8 * 200 && (i % 200 + i / 200).is_multiple_of(2) { 0.2 } else { 0.5 };
        let sparse = Field::new(200, 100, (0..20_000).map(texture).collect()).unwrap();
        let mixed = saliency.mixed(&sparse, &sparse, 2.0, &options).unwrap();
        assert!(mixed.at(4, 4) > 0.5 && mixed.at(100, 50) < 0.26, "{}", mixed.at(4, 4));
        // A faint texture is some detail where there is a strong one, if only in a corner, and all there is where there is none.
        let faint = |i: usize| 0.5 + if (i % 200 + i / 200).is_multiple_of(2) { 0.01 } else { -0.01 };
        let both = |i: usize| if i % 200 < 8 && i < 8 * 200 { texture(i) } else { faint(i) };
        let [alone, beside] =
            [Field::new(200, 100, (0..20_000).map(faint).collect()), Field::new(200, 100, (0..20_000).map(both).collect())]
                .map(|photo| photo.and_then(|photo| saliency.mixed(&photo, &photo, 2.0, &options)).unwrap().at(100, 50));
        assert!(alone > 0.9 && (0.3..0.8).contains(&beside), "{alone} {beside}");
        // Of a flat photo nothing is detail.
        let grey = Field::constant(9, 9, 0.5).unwrap();
        assert!(saliency.mixed(&grey, &grey, 2.0, &options).unwrap().values().iter().all(|v| *v == 0.25));
    }
}
