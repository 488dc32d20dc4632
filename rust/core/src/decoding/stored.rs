//! Pixels as files store them: what their samples are, how many, and which way up.

use crate::photo::Samples;

/// What the samples of a pixel are, in their order.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Model {
    Grey,
    Rgb,
    /// Ink: 0 is none.
    Cmyk,
}

/// How the pixels of an image are stored.
#[derive(Debug, Clone, Copy)]
pub(super) struct Stored {
    pub(super) width: usize,
    pub(super) height: usize,
    pub(super) model: Model,
    /// Whether the last sample of a pixel is its opacity.
    pub(super) alpha: bool,
    /// Whether the others have been multiplied by it.
    pub(super) premultiplied: bool,
    /// As EXIF counts, 1 to 8.
    pub(super) orientation: u8,
}

impl Stored {
    /// Samples of a pixel.
    pub(super) fn channels(&self) -> usize {
        let colours = match self.model {
            Model::Grey => 1,
            Model::Rgb => 3,
            Model::Cmyk => 4,
        };
        colours + usize::from(self.alpha)
    }

    /// Width and height when it is upright.
    pub(super) fn upright(&self) -> [usize; 2] {
        if self.orientation < 5 { [self.width, self.height] } else { [self.height, self.width] }
    }
}

/// The depth of samples.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Depth {
    U8,
    U16,
    F32,
}

/// Samples that belong to whoever has them.
#[derive(Debug, Clone)]
pub(super) enum Owned {
    U8(Vec<u8>),
    U16(Vec<u16>),
    F32(Vec<f32>),
}

impl Owned {
    pub(super) fn as_samples(&self) -> Samples<'_> {
        match self {
            Self::U8(values) => Samples::U8(values),
            Self::U16(values) => Samples::U16(values),
            Self::F32(values) => Samples::F32(values),
        }
    }

    /// In [0, 1].
    pub(super) fn into_floats(self) -> Vec<f32> {
        match self {
            Self::U8(values) => values.into_iter().map(|v| f32::from(v) / 255.0).collect(),
            Self::U16(values) => values.into_iter().map(|v| f32::from(v) / 65_535.0).collect(),
            Self::F32(values) => values,
        }
    }

    /// Colours that were multiplied by their opacity, as they were before; `channels` of them a pixel.
    pub(super) fn divided(self, opacity: &[f32], channels: usize) -> Self {
        let mut values = self.into_floats();
        for (pixel, opacity) in values.chunks_exact_mut(channels).zip(opacity) {
            for value in pixel {
                *value = if *opacity > 0.0 { (*value / opacity).min(1.0) } else { 0.0 };
            }
        }
        Self::F32(values)
    }
}

impl<'a> Samples<'a> {
    pub(super) fn part(self, from: usize, to: usize) -> Self {
        match self {
            Self::U8(values) => Self::U8(&values[from..to]),
            Self::U16(values) => Self::U16(&values[from..to]),
            Self::F32(values) => Self::F32(&values[from..to]),
        }
    }

    /// One channel, in [0, 1].
    pub(super) fn channel(self, index: usize, channels: usize) -> Vec<f32> {
        match self {
            Self::U8(values) => values.chunks_exact(channels).map(|p| f32::from(p[index]) / 255.0).collect(),
            Self::U16(values) => values.chunks_exact(channels).map(|p| f32::from(p[index]) / 65_535.0).collect(),
            Self::F32(values) => values.chunks_exact(channels).map(|p| p[index]).collect(),
        }
    }

    /// A copy, without the last channel if `drop` says so.
    pub(super) fn without_last(self, channels: usize, drop: bool) -> Owned {
        fn kept<T: Copy>(values: &[T], channels: usize, drop: bool) -> Vec<T> {
            if drop {
                values.chunks_exact(channels).flat_map(|p| p[..channels - 1].iter().copied()).collect()
            } else {
                values.to_vec()
            }
        }
        match self {
            Self::U8(values) => Owned::U8(kept(values, channels, drop)),
            Self::U16(values) => Owned::U16(kept(values, channels, drop)),
            Self::F32(values) => Owned::F32(kept(values, channels, drop)),
        }
    }
}
