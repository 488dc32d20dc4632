//! The photo as it is drawn: its luma, reduced by a whole factor where it has far more pixels than its nodes can use.
//!
//! A photo of W x H pixels, the *canvas*, that is reduced by a factor k becomes a raster of W / k x H / k pixels, divided without the
//! remainder. Each is the mean of a box of k x k pixels; those of the last column and the last row take the remainder too, and are up
//! to 2 k - 1 wide. What is drawn of the raster is k times as large on the canvas, so that everything stands where it does in the
//! photo. What this module does not do: say by how much a photo is to be reduced (see [`Options::reduction`]).

use std::sync::Arc;

use crate::base::{Error, Result};
use crate::options::Options;
use crate::photo::colour::Colour;
use crate::photo::field::{Field, boxes, check_size};
use crate::photo::subject::Subject;

/// A photo's luma, whole or reduced, the canvas that it is drawn on, its colour if somebody wanted it, and where its subject is, if that
/// is known. Copies share them.
#[derive(Debug, Clone, PartialEq)]
pub struct Photo {
    luma: Arc<Field>,
    colour: Option<Colour>,
    width: usize,
    height: usize,
    factor: usize,
    subject: Option<Arc<Subject>>,
}

impl Photo {
    /// A photo as it is.
    pub fn new(luma: Field) -> Self {
        let (width, height) = (luma.width(), luma.height());
        Self { luma: Arc::new(luma), colour: None, width, height, factor: 1, subject: None }
    }

    /// A photo reduced by a whole factor of at least 1, but not below a pixel a side.
    ///
    /// # Panics
    /// If the factor is 0.
    pub fn reduced(luma: Field, factor: usize) -> Self {
        if factor == 1 {
            return Self::new(luma);
        }
        let (width, height) = (luma.width(), luma.height());
        Self { luma: Arc::new(luma.reduced(factor)), colour: None, width, height, factor, subject: None }
    }

    /// A photo of `width` x `height` pixels that was reduced by a factor while it was read, as its luma then is.
    ///
    /// # Errors
    /// [`Error::Input`] if the sizes do not fit each other, or the canvas is not one that a [`Field`] may have.
    pub fn of_reduced(luma: Field, width: usize, height: usize, factor: usize) -> Result<Self> {
        check_size(width, height)?;
        let [columns, rows] = [luma.width(), luma.height()];
        if factor == 0 || [columns, rows] != [width, height].map(|side| boxes(side, factor)) {
            return Err(Error::Input(format!(
                "the luma has {columns} x {rows} pixels, which are not {width} x {height} pixels reduced by {factor}"
            )));
        }
        Ok(Self { luma: Arc::new(luma), colour: None, width, height, factor, subject: None })
    }

    /// The photo with the subject that a mask of any size shows, 1 where it is: the mask is resampled to the photo's raster, and its edge
    /// moved to that of the photo. Without one, where the mask is below a half everywhere (see [`Photo::subject`]).
    ///
    /// # Errors
    /// As [`Field::resample`].
    pub fn with_subject(self, mask: &Self) -> Result<Self> {
        let read = [mask.width, mask.height, mask.factor];
        let subject = Subject::of(&mask.luma, read, &self.luma)?.map(Arc::new);
        Ok(Self { subject, ..self })
    }

    /// The photo with a subject as [`Photo::subject`] and [`Photo::mask_read`] tell of it.
    ///
    /// # Errors
    /// [`Error::Input`] if the mask has not the size of the luma.
    pub fn with_refined_subject(self, mask: Field, read: [usize; 3]) -> Result<Self> {
        if [mask.width(), mask.height()] != [self.luma.width(), self.luma.height()] {
            let (has, needs) = ((mask.width(), mask.height()), (self.luma.width(), self.luma.height()));
            return Err(Error::Input(format!("the mask has {} x {} pixels, but the luma {} x {}", has.0, has.1, needs.0, needs.1)));
        }
        Ok(Self { subject: Some(Arc::new(Subject { mask, read })), ..self })
    }

    /// Where the subject is, on the photo's raster: 1 within, 0 outside, in between at its edge; `None` if none is known.
    pub fn subject(&self) -> Option<&Field> {
        self.subject.as_ref().map(|subject| &subject.mask)
    }

    /// Width and height of the mask that the subject was given by, and by how much it was reduced.
    pub fn mask_read(&self) -> Option<[usize; 3]> {
        self.subject.as_ref().map(|subject| subject.read)
    }

    /// The photo with a colour of the size of its luma.
    ///
    /// # Errors
    /// [`Error::Input`] if the size is another.
    pub fn with_colour(mut self, colour: Colour) -> Result<Self> {
        self.colour = Some(colour.beside(&self.luma)?);
        Ok(self)
    }

    /// The photo with its luma for a colour.
    pub fn with_grey(mut self) -> Self {
        self.colour = Some(Colour::grey(Arc::clone(&self.luma)));
        self
    }

    /// The photo without its colour.
    pub fn without_colour(self) -> Self {
        Self { colour: None, ..self }
    }

    /// The colour of what is drawn, of the size of the luma, if it was kept.
    pub fn colour(&self) -> Option<&Colour> {
        self.colour.as_ref()
    }

    /// The luma that is drawn.
    pub fn luma(&self) -> &Field {
        &self.luma
    }

    /// The luma, without the canvas; a copy of it if others have it too.
    pub fn into_luma(self) -> Field {
        Arc::unwrap_or_clone(self.luma)
    }

    /// The luma, shared.
    pub(crate) fn shared_luma(&self) -> Arc<Field> {
        Arc::clone(&self.luma)
    }

    /// Width of the canvas in pixels, that of the photo.
    pub fn width(&self) -> usize {
        self.width
    }

    /// Height of the canvas in pixels, that of the photo.
    pub fn height(&self) -> usize {
        self.height
    }

    /// By how much it is reduced: 1 if it is as it was.
    pub fn factor(&self) -> usize {
        self.factor
    }

    /// Whether it, and the mask of its subject, are reduced as these options ask for.
    pub fn fits(&self, options: &Options) -> bool {
        self.sizes().all(|[width, height, factor]| options.reduction(width, height) == factor)
    }

    /// Width, height and factor of all that was read of it: the photo, and the mask of its subject.
    pub fn sizes(&self) -> impl Iterator<Item = [usize; 3]> {
        [[self.width, self.height, self.factor]].into_iter().chain(self.mask_read())
    }
}

impl Field {
    /// A field of a photo that was reduced by a factor, on its canvas of `width` x `height` pixels: each value stands everywhere in its
    /// box.
    ///
    /// # Errors
    /// As [`Photo::of_reduced`].
    pub fn on_canvas(&self, width: usize, height: usize, factor: usize) -> Result<Self> {
        if [width, height, factor] == [self.width(), self.height(), 1] {
            return Ok(self.clone());
        }
        let Photo { luma, .. } = Photo::of_reduced(self.clone(), width, height, factor)?;
        let mut values = Vec::with_capacity(width * height);
        for y in 0..height {
            let row = (y / factor).min(luma.height() - 1) * luma.width();
            values.extend((0..width).map(|x| luma.values()[row + (x / factor).min(luma.width() - 1)]));
        }
        Ok(Self::of_valid(width, height, values))
    }
}

#[cfg(test)]
mod tests {
    use proptest::prelude::*;

    use super::*;

    /// Whole grey levels of 8 bits, which sums hold exactly.
    fn luma(width: usize, height: usize) -> Field {
        Field::new(width, height, (0..width * height).map(|i| (i * 37 % 256) as f32 / 256.0).collect()).unwrap()
    }

    /// The first pixel of a box on an axis, and the one after its last.
    fn range(index: usize, side: usize, factor: usize) -> std::ops::Range<usize> {
        let count = (side / factor).max(1);
        index * factor..if index + 1 == count { side } else { (index + 1) * factor }
    }

    #[test]
    fn the_last_boxes_take_the_remainder() {
        let values = [0.0, 0.5, 1.0, 1.0, 0.0, 0.25, 0.25, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 0.0, 0.75];
        let photo = Photo::reduced(Field::new(5, 3, values.to_vec()).unwrap(), 2);
        assert_eq!((photo.luma().width(), photo.luma().height(), photo.width(), photo.height()), (2, 1, 5, 3));
        assert_eq!(photo.luma().values(), [1.0 / 6.0, 3.75 / 9.0].map(|v: f64| v as f32));
        // Wider than the photo: one pixel.
        let one = Photo::reduced(luma(3, 2), 7);
        assert_eq!((one.luma().width(), one.luma().height(), one.factor()), (1, 1, 7));
    }

    proptest! {
        #[test]
        fn a_reduced_photo_has_the_means_of_its_boxes(width in 1usize..40, height in 1usize..40, factor in 1usize..9) {
            let whole = luma(width, height);
            let photo = Photo::reduced(whole.clone(), factor);
            for y in 0..photo.luma().height() {
                for x in 0..photo.luma().width() {
                    let (columns, rows) = (range(x, width, factor), range(y, height, factor));
                    let count = (columns.len() * rows.len()) as f64;
                    let all = rows.flat_map(|y| columns.clone().map(move |x| (x, y)));
                    let sum: f64 = all.map(|(x, y)| f64::from(whole.at(x, y))).sum();
                    prop_assert_eq!(photo.luma().at(x, y), (sum / count) as f32);
                }
            }
            let again = Photo::of_reduced(photo.luma().clone(), width, height, factor).unwrap();
            prop_assert_eq!(again, photo);
        }
    }

    #[test]
    fn what_does_not_fit_is_refused() {
        let told = Photo::of_reduced(luma(3, 2), 8, 4, 2).unwrap_err().to_string();
        assert_eq!(told, "the luma has 3 x 2 pixels, which are not 8 x 4 pixels reduced by 2");
        assert!(Photo::of_reduced(luma(3, 2), 3, 2, 0).is_err() && Photo::of_reduced(luma(1, 1), 0, 2, 2).is_err());
    }

    #[test]
    fn on_the_canvas_each_value_fills_its_box() {
        let field = Field::new(2, 1, vec![0.25, 0.5]).unwrap();
        let canvas = field.on_canvas(5, 3, 2).unwrap();
        assert_eq!(canvas.values(), [0.25, 0.25, 0.5, 0.5, 0.5].repeat(3));
        assert_eq!(field.on_canvas(2, 1, 1).unwrap(), field);
        assert!(field.on_canvas(7, 3, 2).is_err());
    }
}
