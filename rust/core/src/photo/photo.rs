//! The photo as it is drawn: its luma, reduced by a whole factor where it has far more pixels than its nodes can use.
//!
//! A photo of W x H pixels, the *canvas*, that is reduced by a factor k becomes a raster of W / k x H / k pixels, divided without the
//! remainder. Each is the mean of a box of k x k pixels; those of the last column and the last row take the remainder too, and are up
//! to 2 k - 1 wide. What is drawn of the raster is k times as large on the canvas, so that everything stands where it does in the
//! photo. What this module does not do: say by how much a photo is to be reduced (see [`Options::reduction`]).

use std::sync::Arc;

use crate::base::{Error, Result};
use crate::options::Options;
use crate::photo::field::{Field, check_size};

/// A photo's luma, whole or reduced, and the canvas that it is drawn on. Copies share the luma.
#[derive(Debug, Clone, PartialEq)]
pub struct Photo {
    luma: Arc<Field>,
    width: usize,
    height: usize,
    factor: usize,
}

impl Photo {
    /// A photo as it is.
    pub fn new(luma: Field) -> Self {
        let (width, height) = (luma.width(), luma.height());
        Self { luma: Arc::new(luma), width, height, factor: 1 }
    }

    /// A photo reduced by a whole factor of at least 1, but not below a pixel a side.
    ///
    /// # Panics
    /// If the factor is 0.
    pub fn reduced(luma: Field, factor: usize) -> Self {
        if factor == 1 {
            return Self::new(luma);
        }
        let mut reducer = Reducer::new(luma.width(), luma.height(), factor).expect("a field's sides are allowed");
        reducer.take(luma.values());
        reducer.finish().expect("a field has all its rows")
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
        Ok(Self { luma: Arc::new(luma), width, height, factor })
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
    pub(crate) fn into_shared_luma(self) -> Arc<Field> {
        self.luma
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

    /// Whether it is reduced as these options ask for.
    pub fn fits(&self, options: &Options) -> bool {
        options.reduction(self.width, self.height) == self.factor
    }
}

/// Boxes on a side of so many pixels.
fn boxes(side: usize, factor: usize) -> usize {
    (side / factor).max(1)
}

/// Reduces a photo while its rows come in, so that the whole of it need not be in memory.
#[derive(Debug, Clone)]
pub struct Reducer {
    width: usize,
    height: usize,
    factor: usize,
    /// The values of the rows of boxes that are done.
    values: Vec<f32>,
    /// Sums of the boxes of the row that is not.
    sums: Vec<f64>,
    /// Rows of the photo that are taken.
    rows: usize,
}

impl Reducer {
    /// For a photo of `width` x `height` pixels, to be reduced by a whole factor of at least 1.
    ///
    /// # Errors
    /// [`Error::Input`] if the size is not one that a [`Field`] may have.
    ///
    /// # Panics
    /// If the factor is 0.
    pub fn new(width: usize, height: usize, factor: usize) -> Result<Self> {
        assert!(factor > 0, "nothing is reduced by 0");
        check_size(width, height)?;
        let [columns, rows] = [width, height].map(|side| boxes(side, factor));
        Ok(Self { width, height, factor, values: Vec::with_capacity(columns * rows), sums: vec![0.0; columns], rows: 0 })
    }

    /// Takes the next rows of the photo's luma, from the top down.
    ///
    /// # Panics
    /// If the values are no whole rows, or more than the photo has.
    pub fn take(&mut self, values: &[f32]) {
        assert!(
            values.len().is_multiple_of(self.width) && values.len() / self.width <= self.height - self.rows,
            "rows of the photo"
        );
        if self.factor == 1 {
            self.values.extend_from_slice(values);
            self.rows += values.len() / self.width;
            return;
        }
        let (columns, last_row) = (self.sums.len(), boxes(self.height, self.factor) - 1);
        for row in values.chunks_exact(self.width) {
            // All boxes but the last are as wide as the factor.
            let (even, last) = row.split_at((columns - 1) * self.factor);
            for (sum, part) in self.sums.iter_mut().zip(even.chunks_exact(self.factor).chain([last])) {
                *sum = part.iter().fold(*sum, |sum, value| sum + f64::from(*value));
            }
            self.rows += 1;
            let box_row = ((self.rows - 1) / self.factor).min(last_row);
            let end = if box_row == last_row { self.height } else { (box_row + 1) * self.factor };
            if self.rows == end {
                let (high, wide) = ((end - box_row * self.factor) as f64, self.factor as f64);
                let widest = (self.width - (columns - 1) * self.factor) as f64;
                let width_of = |column: usize| if column == columns - 1 { widest } else { wide };
                self.values.extend(self.sums.iter().enumerate().map(|(column, sum)| (sum / (high * width_of(column))) as f32));
                self.sums.fill(0.0);
            }
        }
    }

    /// The photo.
    ///
    /// # Errors
    /// [`Error::Input`] if a row is missing, or a value was not in [0, 1].
    pub fn finish(self) -> Result<Photo> {
        if self.rows < self.height {
            return Err(Error::Input(format!("the photo has {} rows, but only {} came", self.height, self.rows)));
        }
        let luma = Field::new(self.sums.len(), boxes(self.height, self.factor), self.values)?;
        Photo::of_reduced(luma, self.width, self.height, self.factor)
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
        fn a_reduced_photo_has_the_means_of_its_boxes(width in 1usize..40, height in 1usize..40, factor in 1usize..9, band in 1usize..7) {
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
            // Whatever the rows come in.
            let mut reducer = Reducer::new(width, height, factor).unwrap();
            whole.values().chunks(band * width).for_each(|rows| reducer.take(rows));
            prop_assert_eq!(&reducer.finish().unwrap(), &photo);
            let again = Photo::of_reduced(photo.luma().clone(), width, height, factor).unwrap();
            prop_assert_eq!(again, photo);
        }
    }

    #[test]
    fn what_does_not_fit_is_refused() {
        let told = Photo::of_reduced(luma(3, 2), 8, 4, 2).unwrap_err().to_string();
        assert_eq!(told, "the luma has 3 x 2 pixels, which are not 8 x 4 pixels reduced by 2");
        assert!(Photo::of_reduced(luma(3, 2), 3, 2, 0).is_err() && Photo::of_reduced(luma(1, 1), 0, 2, 2).is_err());
        let mut reducer = Reducer::new(4, 4, 2).unwrap();
        reducer.take(&[0.5; 12]);
        assert_eq!(reducer.finish().unwrap_err().to_string(), "the photo has 4 rows, but only 3 came");
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
