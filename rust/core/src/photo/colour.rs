//! The colour of a photo: red, green and blue, sRGB-encoded as the luma is, each a field of the luma's size.
//!
//! Planes that are equal are one: a grey photo has no planes besides its luma, however its file stores it. Others take 12 bytes a pixel.
//! What this module does not do: read files and convert profiles (see [`crate::stages::decode()`]).

use std::sync::Arc;

use crate::base::{Error, Result};
use crate::photo::field::Field;

/// Red, green and blue of a photo, sRGB-encoded in [0, 1]. Copies share the planes.
#[derive(Debug, Clone, PartialEq)]
pub struct Colour {
    planes: [Arc<Field>; 3],
}

impl Colour {
    /// The colour of three planes.
    ///
    /// # Errors
    /// [`Error::Input`] if the planes have different sizes.
    pub fn new(red: Field, green: Field, blue: Field) -> Result<Self> {
        for (name, plane) in [("green", &green), ("blue", &blue)] {
            check_same_size(name, plane, "red", &red)?;
        }
        if red == green && green == blue {
            return Ok(Self::grey(Arc::new(red)));
        }
        Ok(Self { planes: [red, green, blue].map(Arc::new) })
    }

    /// The colour whose three planes are one.
    pub fn grey(plane: Arc<Field>) -> Self {
        Self { planes: [Arc::clone(&plane), Arc::clone(&plane), plane] }
    }

    /// Red, green and blue.
    pub fn planes(&self) -> [&Field; 3] {
        self.planes.each_ref().map(|plane| &**plane)
    }

    /// Red.
    pub fn red(&self) -> &Field {
        &self.planes[0]
    }

    /// Green.
    pub fn green(&self) -> &Field {
        &self.planes[1]
    }

    /// Blue.
    pub fn blue(&self) -> &Field {
        &self.planes[2]
    }

    /// Red, green and blue of the pixel in `column` and `row`.
    pub fn at(&self, column: usize, row: usize) -> [f32; 3] {
        self.planes().map(|plane| plane.at(column, row))
    }

    /// Whether every pixel is grey.
    pub fn is_grey(&self) -> bool {
        self.planes[1..].iter().all(|plane| Arc::ptr_eq(plane, &self.planes[0]))
    }

    /// The colour reduced by a whole factor, by the boxes of [`Photo::reduced`](super::Photo::reduced).
    ///
    /// # Panics
    /// If the factor is 0.
    pub fn reduced(&self, factor: usize) -> Self {
        match factor {
            1 => self.clone(),
            _ if self.is_grey() => Self::grey(Arc::new(self.red().reduced(factor))),
            _ => Self { planes: self.planes().map(|plane| Arc::new(plane.reduced(factor))) },
        }
    }

    /// The colour for a photo of this luma, which a grey one shares.
    ///
    /// # Errors
    /// [`Error::Input`] if its size is another.
    pub(super) fn beside(self, luma: &Arc<Field>) -> Result<Self> {
        check_same_size("colour", self.red(), "luma", luma)?;
        Ok(if self.is_grey() && *self.planes[0] == **luma { Self::grey(Arc::clone(luma)) } else { self })
    }

    /// Whether it has no memory of its own beside this luma.
    #[cfg(test)]
    fn shares(&self, luma: &Field) -> bool {
        self.planes().iter().all(|plane| std::ptr::eq(*plane, luma))
    }
}

fn check_same_size(name: &str, plane: &Field, other: &str, of: &Field) -> Result<()> {
    let [width, height] = [plane.width(), plane.height()];
    if [width, height] == [of.width(), of.height()] {
        return Ok(());
    }
    Err(Error::Input(format!(
        "the {name} has {width} x {height} pixels, but it must have {} x {} as the {other} has",
        of.width(),
        of.height()
    )))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::photo::Photo;

    fn plane(width: usize, height: usize, step: usize) -> Field {
        Field::new(width, height, (0..width * height).map(|i| (i * step % 256) as f32 / 256.0).collect()).unwrap()
    }

    #[test]
    fn a_photo_keeps_the_colour_of_its_size() {
        let colour = Colour::new(plane(4, 3, 1), plane(4, 3, 5), plane(4, 3, 9)).unwrap();
        let photo = Photo::new(plane(4, 3, 7)).with_colour(colour.clone()).unwrap();
        assert_eq!(photo.colour(), Some(&colour));
        assert_eq!(colour.at(2, 1), [6.0 / 256.0, 30.0 / 256.0, 54.0 / 256.0]);
        assert!(!colour.is_grey() && photo.clone().without_colour() == Photo::new(plane(4, 3, 7)));
        let told = Photo::new(plane(3, 4, 7)).with_colour(colour).unwrap_err().to_string();
        assert_eq!(told, "the colour has 4 x 3 pixels, but it must have 3 x 4 as the luma has");
        let told = Colour::new(plane(4, 3, 1), plane(4, 3, 5), plane(4, 2, 9)).unwrap_err().to_string();
        assert_eq!(told, "the blue has 4 x 2 pixels, but it must have 4 x 3 as the red has");
    }

    #[test]
    fn grey_takes_no_memory_of_its_own() {
        let grey = plane(4, 3, 7);
        let photo = Photo::new(grey.clone()).with_colour(Colour::new(grey.clone(), grey.clone(), grey).unwrap()).unwrap();
        let colour = photo.colour().unwrap();
        assert!(colour.is_grey() && colour.shares(photo.luma()));
        let other = Photo::new(plane(4, 3, 9)).with_colour(colour.clone()).unwrap();
        assert!(other.colour().unwrap().is_grey() && !other.colour().unwrap().shares(other.luma()));
    }

    #[test]
    fn it_is_reduced_by_the_boxes_of_the_luma() {
        let planes = [1, 5, 9].map(|step| plane(11, 7, step));
        let [red, green, blue] = planes.clone();
        let colour = Colour::new(red, green, blue).unwrap().reduced(3);
        for (reduced, whole) in colour.planes().into_iter().zip(planes) {
            assert_eq!(reduced, Photo::reduced(whole, 3).luma());
        }
        let grey = Colour::grey(Arc::new(plane(11, 7, 5))).reduced(3);
        assert!(grey.is_grey() && grey.blue() == Photo::reduced(plane(11, 7, 5), 3).luma());
    }
}
