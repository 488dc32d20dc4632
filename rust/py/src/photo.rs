//! Photos to luma and colour, as they are or reduced, and luma to saliency.

use std::path::PathBuf;

use graphstipple_cli::files::{self, Input};
use graphstipple_core::stages::{self as core, PhotoBuilder, Pool, Samples, Tags, fine_grained};
use graphstipple_core::{Control, Field as CoreField, Photo as CorePhoto};
use numpy::{Element, IntoPyArray, PyArray2, PyArray3, PyArrayMethods, PyReadonlyArray2, PyReadonlyArray3, PyUntypedArrayMethods};
use pyo3::prelude::*;
use pyo3::types::PyType;

use crate::options::Options;
use crate::watch::Watch;
use crate::{arrays, errors, watch};

/// Planes (height, width) of red, green and blue.
type Planes<'py> = (Bound<'py, PyArray2<f32>>, Bound<'py, PyArray2<f32>>, Bound<'py, PyArray2<f32>>);

/// Where a subject is, and width, height and factor of the mask by which it was given.
type PackedSubject<'py> = (Bound<'py, PyArray2<f32>>, [usize; 3]);

/// Luma, size of the canvas, factor, colour and subject of a photo.
type PackedPhoto<'py> = (Bound<'py, PyArray2<f32>>, (usize, usize), usize, Option<Planes<'py>>, Option<PackedSubject<'py>>);

/// A photo or a map that was read, with the size of its canvas.
#[pyclass(frozen, module = "graphstipple._core")]
pub(crate) struct Photo {
    pub(crate) photo: CorePhoto,
}

#[pymethods]
impl Photo {
    /// A photo of luma (height, width) that was reduced by a factor from a canvas of this width and height, with its colour if it has
    /// one: red, green and blue, each of the luma's shape; and with its subject.
    #[new]
    #[pyo3(signature = (luma, size, factor, colour=None, subject=None))]
    fn new(
        luma: PyReadonlyArray2<'_, f32>,
        size: (usize, usize),
        factor: usize,
        colour: Option<[PyReadonlyArray2<'_, f32>; 3]>,
        subject: Option<(PyReadonlyArray2<'_, f32>, [usize; 3])>,
    ) -> PyResult<Self> {
        let mut photo = CorePhoto::of_reduced(arrays::field(&luma)?, size.0, size.1, factor).map_err(errors::from_core)?;
        if let Some([red, green, blue]) = &colour {
            let colour = core::Colour::new(arrays::field(red)?, arrays::field(green)?, arrays::field(blue)?);
            photo = colour.and_then(|colour| photo.with_colour(colour)).map_err(errors::from_core)?;
        }
        if let Some((mask, read)) = subject {
            photo = photo.with_refined_subject(arrays::field(&mask)?, read).map_err(errors::from_core)?;
        }
        Ok(Self { photo })
    }

    /// The photo with the subject that a mask shows; without one where it shows none.
    fn with_subject(&self, py: Python<'_>, mask: &Self) -> PyResult<Self> {
        let (photo, mask) = (self.photo.clone(), mask.photo.clone());
        let photo = watch::run_core(py, None, move |_| photo.with_subject(&mask))?;
        Ok(Self { photo })
    }

    /// The photo with the colour of another reading of it.
    fn with_colour_of(&self, other: &Self) -> PyResult<Self> {
        let colour = other.photo.colour().cloned();
        let photo = self.photo.clone();
        Ok(Self { photo: colour.map_or(Ok(photo.clone()), |colour| photo.with_colour(colour)).map_err(errors::from_core)? })
    }

    /// Where the subject is, (height, width) of the luma in [0, 1]; `None` if none is known.
    #[getter]
    fn subject<'py>(&self, py: Python<'py>) -> PyResult<Option<Bound<'py, PyArray2<f32>>>> {
        self.photo.subject().map(|mask| arrays::from_field(py, mask.clone())).transpose()
    }

    /// What a pickle has of it.
    fn __reduce__<'py>(slf: &Bound<'py, Self>) -> PyResult<(Bound<'py, PyType>, PackedPhoto<'py>)> {
        let (py, photo) = (slf.py(), slf.get());
        let luma = photo.luma(py)?;
        let colour = photo.photo.colour();
        // A pickle has once what is the same array.
        let packed = colour.map(|colour| match colour.planes() {
            [red, ..] if colour.is_grey() && std::ptr::eq(red, photo.photo.luma()) => {
                Ok((luma.clone(), luma.clone(), luma.clone()))
            }
            planes => {
                let [red, green, blue] = planes.map(|plane| arrays::from_field(py, plane.clone()));
                Ok::<_, PyErr>((red?, green?, blue?))
            }
        });
        let subject = photo.subject(py)?.zip(photo.photo.mask_read());
        Ok((slf.get_type(), (luma, photo.size(), photo.factor(), packed.transpose()?, subject)))
    }

    /// A copy of the luma that is drawn, (height, width) in [0, 1].
    #[getter]
    fn luma<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyArray2<f32>>> {
        arrays::from_field(py, self.photo.luma().clone())
    }

    /// A copy of the colour of what is drawn, (height, width, 3) of sRGB in [0, 1], if it was kept.
    #[getter]
    fn colour<'py>(&self, py: Python<'py>) -> PyResult<Option<Bound<'py, PyArray3<f32>>>> {
        let Some(colour) = self.photo.colour() else { return Ok(None) };
        let [red, green, blue] = colour.planes().map(CoreField::values);
        let values: Vec<f32> = red.iter().zip(green).zip(blue).flat_map(|((red, green), blue)| [*red, *green, *blue]).collect();
        values.into_pyarray(py).reshape([colour.red().height(), colour.red().width(), 3]).map(Some)
    }

    /// Width and height of the canvas in pixels.
    #[getter]
    fn size(&self) -> (usize, usize) {
        (self.photo.width(), self.photo.height())
    }

    /// By how much it was reduced; 1 if it is as it was.
    #[getter]
    fn factor(&self) -> usize {
        self.photo.factor()
    }
}

/// How images are read: what transparent parts show, what the photo will be drawn with (without options every pixel is kept), the most
/// pixels, and whether what there is of a damaged file is read.
#[pyclass(frozen, module = "graphstipple._core")]
pub(crate) struct Reading {
    pub(crate) reading: core::Reading,
}

#[pymethods]
impl Reading {
    #[new]
    fn new(background: [u8; 3], options: Option<&Options>, max_pixels: u64, allow_damaged: bool) -> Self {
        let options = options.map(|options| options.checked.clone());
        Self { reading: core::Reading { background, max_pixels, allow_damaged, options, colour: false } }
    }

    /// What lies under transparent pixels: red, green and blue.
    #[getter]
    fn background(&self) -> (u8, u8, u8) {
        self.reading.background.into()
    }

    /// Raises if an image of this size is not read.
    fn check(&self, width: usize, height: usize) -> PyResult<()> {
        self.reading.factor(width, height).map(drop).map_err(errors::from_core)
    }
}

/// How many threads read.
pub(crate) fn threads_of(reading: &core::Reading) -> Option<usize> {
    reading.options.as_ref().and_then(|options| options.threads)
}

/// An image file, what is to be said of it, and what decoded it. Where somebody has its bytes already, no file is opened, and the path
/// is the name by which messages tell of it. The photo keeps its colour if that is asked for.
#[pyfunction]
#[pyo3(signature = (path, reading, data=None, *, colour=false))]
pub(crate) fn read_photo(
    py: Python<'_>,
    path: PathBuf,
    reading: &Reading,
    data: Option<Vec<u8>>,
    colour: bool,
) -> PyResult<(Photo, Option<String>, String)> {
    let said = core::Reading { colour, ..reading.reading.clone() };
    let read = move |control: &_| {
        let mut input = data.map_or_else(|| Input::file(&path), |bytes| Input::bytes(&path, bytes));
        let decoded = input.read(&said, control)?;
        let warning = decoded.warning.map(|warning| files::told(&path, &warning));
        Ok((Photo { photo: decoded.photo }, warning, decoded.decoder))
    };
    let threads = threads_of(&reading.reading);
    watch::run(py, Watch::on(threads), errors::from_files, read)
}

/// What the file of an image said of its samples: whether they are inks, an embedded profile, PNG's gamma and chromaticities (white,
/// red, green, blue), and whether a camera says that they are Adobe RGB's.
type Said = (bool, Option<Vec<u8>>, Option<f64>, Option<[[f64; 2]; 4]>, bool);

/// An image of samples (height, width, channels) of uint8, uint16 or float32, likewise.
#[pyfunction]
#[pyo3(signature = (samples, said, reading, *, colour=false))]
pub(crate) fn photo(py: Python<'_>, samples: &Bound<'_, PyAny>, said: Said, reading: &Reading, colour: bool) -> PyResult<Photo> {
    let reading = core::Reading { colour, ..reading.reading.clone() };
    let (inks, profile, gamma, chromaticities, adobe_rgb) = said;
    let tags = Tags { inks, profile, gamma, chromaticities, adobe_rgb };
    if let Ok(array) = samples.extract::<PyReadonlyArray3<'_, u8>>() {
        built(py, &array, |values| Samples::U8(values), &tags, &reading)
    } else if let Ok(array) = samples.extract::<PyReadonlyArray3<'_, u16>>() {
        built(py, &array, |values| Samples::U16(values), &tags, &reading)
    } else if let Ok(array) = samples.extract::<PyReadonlyArray3<'_, f32>>() {
        built(py, &array, |values| Samples::F32(values), &tags, &reading)
    } else {
        Err(errors::invalid("the samples must be a three-dimensional array of uint8, uint16 or float32"))
    }
}

/// Samples that are copied out of an array at once: few, so that Ctrl-C is heard and next to no memory is taken, and enough to be quick.
const COPIED: usize = 1 << 20;

/// The photo of an array, which is copied band by band: while a band is worked on, other Python threads may run and write to the array.
fn built<T: Element + Copy + Sync>(
    py: Python<'_>,
    array: &PyReadonlyArray3<'_, T>,
    samples: for<'a> fn(&'a [T]) -> Samples<'a>,
    tags: &Tags,
    reading: &core::Reading,
) -> PyResult<Photo> {
    let &[height, width, channels] = array.shape() else { return Err(errors::invalid("the samples have no three dimensions")) };
    let all = array.as_slice().map_err(|error| errors::invalid(format!("the samples: {error}")))?;
    let control = Control::new();
    let size = [width, height, channels];
    let mut builder = PhotoBuilder::new(size, samples(&[]), tags, reading, &control).map_err(errors::from_core)?;
    let rows = (COPIED / (width * channels).max(1)).max(1);
    let pool = Pool::new(threads_of(reading));
    for band in all.chunks((rows * width * channels).max(1)) {
        let band = band.to_vec();
        py.detach(|| pool.run(|| builder.take(samples(&band)))).map_err(errors::from_core)?;
        py.check_signals()?;
    }
    let photo = py.detach(|| pool.run(|| builder.finish())).map_err(errors::from_core)?;
    Ok(Photo { photo })
}

/// The tone of luma, (height, width) in [0, 1], adjusted as the options say.
#[pyfunction]
pub(crate) fn adjust<'py>(
    py: Python<'py>,
    luma: PyReadonlyArray2<'py, f32>,
    options: &Options,
) -> PyResult<Bound<'py, PyArray2<f32>>> {
    let options = options.checked.clone();
    let field = arrays::field(&luma)?;
    let tone = watch::run_core(py, options.threads, move |_| core::adjust(&field, &options))?;
    arrays::from_field(py, tone)
}

/// Luma as 8-bit values, (height, width): what the saliency is computed on.
#[pyfunction]
pub(crate) fn luma_to_u8<'py>(py: Python<'py>, luma: PyReadonlyArray2<'py, f32>) -> PyResult<Bound<'py, PyArray2<u8>>> {
    let field = arrays::field(&luma)?;
    let shape = [field.height(), field.width()];
    arrays::from_rows(py, shape, watch::run_core(py, None, move |_| Ok(core::luma_to_u8(&field)))?)
}

/// The core's own fine-grained saliency of luma, (height, width) in [0, 1].
#[pyfunction]
pub(crate) fn saliency<'py>(py: Python<'py>, luma: PyReadonlyArray2<'py, f32>) -> PyResult<Bound<'py, PyArray2<f32>>> {
    let field = arrays::field(&luma)?;
    let map = watch::run_core(py, None, move |_| Ok(fine_grained(&core::luma_to_u8(&field), field.width(), field.height())))?;
    arrays::from_field(py, map)
}
