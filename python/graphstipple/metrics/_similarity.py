"""What is computed from pixels alone: PSNR, SSIM, multi-scale SSIM, errors of tone, and the blur of a viewer at a distance.

Everything is computed in float64.
"""

from __future__ import annotations

import math
from numbers import Real
from typing import Any, TypeAlias

import numpy as np
import numpy.typing as npt

from graphstipple._errors import InvalidInputError, MissingPackageError
from graphstipple._inputs import check_range, unmasked

try:
    import cv2
except ImportError as error:
    raise MissingPackageError(f"metrics need OpenCV ({error}): pip install opencv-contrib-python-headless") from error

Field: TypeAlias = npt.NDArray[np.float64]

FAR_SIGMA = 1.5
"""Blur of the far comparison in pixels: less leaves single dots visible, more hides what a viewer still sees."""

FARTHER_SIGMA = 3.0
"""Blur of the farther comparison in pixels: some two spacings of nodes, so that dots are gone and only their tone is left."""

LOCAL_SIGMA, LOCAL_SHARE = 8.0, 95.0
"""Blur in pixels and percentile of the local tone: less blur lets the texture of dots in, more lets errors of opposite sign cancel;
a lower percentile lets faults on small parts of a picture pass, a higher one hangs on single edges."""

SIGMA_RANGE = (0.1, 1000.0)
"""Below the first no other pixel weighs anything; above the second the window is wider than any photo."""

WINDOW_SIDE, WINDOW_SIGMA = 11, 1.5
"""The window of SSIM in pixels (Wang et al. 2004)."""

K1, K2 = 0.01, 0.03
"""Constants of SSIM that keep its quotients finite in flat places (Wang et al. 2004); the data range is 1."""

SCALE_WEIGHTS = (0.0448, 0.2856, 0.3001, 0.2363, 0.1333)
"""Exponents of multi-scale SSIM, finest scale first (Wang, Simoncelli and Bovik 2003)."""

MSSSIM_LEAST_SIDE = (WINDOW_SIDE - 1) * 2 ** (len(SCALE_WEIGHTS) - 1) + 1
"""The shortest side whose coarsest scale still holds a window: 161."""


def psnr(picture: npt.NDArray[np.floating[Any]], reference: npt.NDArray[np.floating[Any]]) -> float:
    """Return the peak signal-to-noise ratio, 10 log10 of 1 over the mean squared difference.

    Parameters
    ----------
    picture, reference : array of floats, (height, width)
        In [0, 1], of one shape.

    Returns
    -------
    float
        In dB, at least 0; higher is nearer, infinite for equal pictures.

    Raises
    ------
    InvalidInputError
        If an array has a wrong shape, type or value.
    """
    error = float(np.mean(np.square(np.subtract(*checked_pair(picture, reference)))))
    return math.inf if error == 0 else 10 * math.log10(1 / error)


def ssim(picture: npt.NDArray[np.floating[Any]], reference: npt.NDArray[np.floating[Any]]) -> float:
    """Return the mean structural similarity (Wang et al. 2004).

    The window is a Gaussian of sigma 1.5 px, cut to 11 x 11; K1 = 0.01, K2 = 0.03; variances and covariance divide by the sum of
    the weights (biased). The mean is over the pixels whose window lies inside the picture.

    Parameters
    ----------
    picture, reference : array of floats, (height, width)
        In [0, 1], of one shape, at least 11 px a side.

    Returns
    -------
    float
        From -1 to 1; higher is nearer, 1 for equal pictures.

    Raises
    ------
    InvalidInputError
        If an array has a wrong shape, type or value.
    """
    return _window_means(*checked_pair(picture, reference, least_side=WINDOW_SIDE, metric="SSIM"))[0]


def msssim(picture: npt.NDArray[np.floating[Any]], reference: npt.NDArray[np.floating[Any]]) -> float:
    """Return the multi-scale structural similarity over five scales (Wang, Simoncelli and Bovik 2003).

    The product of the mean contrast-structure terms of the first four scales and of the mean SSIM of the last, each to the power
    of its scale's weight, with the window and constants of `ssim`. From one scale to the next, every block of 2 x 2 pixels
    becomes its mean; the last row or column of an odd side counts twice. A mean below 0, whose power is not real, counts as 0.

    Parameters
    ----------
    picture, reference : array of floats, (height, width)
        In [0, 1], of one shape, at least 161 px a side.

    Returns
    -------
    float
        From 0 to 1; higher is nearer, 1 for equal pictures.

    Raises
    ------
    InvalidInputError
        If an array has a wrong shape, type or value.
    """
    first, second = checked_pair(picture, reference, least_side=MSSSIM_LEAST_SIDE, metric="multi-scale SSIM")
    product = 1.0
    for weight in SCALE_WEIGHTS[:-1]:
        _, contrast_structure = _window_means(first, second)
        product *= max(contrast_structure, 0.0) ** weight
        first, second = _halved(first), _halved(second)
    similarity, _ = _window_means(first, second)
    return product * float(max(similarity, 0.0) ** SCALE_WEIGHTS[-1])


def tone_error(picture: npt.NDArray[np.floating[Any]], reference: npt.NDArray[np.floating[Any]]) -> float:
    """Return how much lighter the picture is than the reference: the difference of their means.

    Parameters
    ----------
    picture, reference : array of floats, (height, width)
        In [0, 1], of one shape.

    Returns
    -------
    float
        From -1 (black for white) to 1; 0 where the mean tone is kept.

    Raises
    ------
    InvalidInputError
        If an array has a wrong shape, type or value.
    """
    first, second = checked_pair(picture, reference)
    return float(first.mean() - second.mean())


def local_tone(picture: npt.NDArray[np.floating[Any]], reference: npt.NDArray[np.floating[Any]]) -> float:
    """Return how far the tone is off where it is worst: the 95th percentile of the absolute difference after a blur of 8 px.

    Both are `blurred`; between two pixels, the percentile is interpolated.

    Parameters
    ----------
    picture, reference : array of floats, (height, width)
        In [0, 1], of one shape.

    Returns
    -------
    float
        From 0 to 1; lower is nearer, 0 where the tone is kept everywhere.

    Raises
    ------
    InvalidInputError
        If an array has a wrong shape, type or value.
    """
    first, second = (blurred(values, LOCAL_SIGMA) for values in checked_pair(picture, reference))
    return float(np.percentile(np.abs(first - second), LOCAL_SHARE))


def blurred(picture: npt.NDArray[np.floating[Any]], sigma: float = FAR_SIGMA) -> Field:
    """Return the picture as a viewer at a distance sees it: after a Gaussian blur.

    The Gaussian is sampled at pixel centres, cut at 4 sigma (rounded to a whole pixel) and normalised. Beyond the border the
    picture is mirrored with its outermost pixels repeated: ``d c b a | a b c d | d c b a``.

    Parameters
    ----------
    picture : array of floats, (height, width)
        In [0, 1].
    sigma : float
        Standard deviation in pixels, 0.1 to 1000.

    Returns
    -------
    ndarray of float64, (height, width)
        In [0, 1].

    Raises
    ------
    InvalidInputError
        If the array has a wrong shape, type or value, or sigma lies outside its range.
    """
    least, most = SIGMA_RANGE
    if not (isinstance(sigma, Real) and least <= sigma <= most):
        raise InvalidInputError(f"sigma is {sigma!r}, but it must be a number of pixels from {least:g} to {most:g}")
    # Weights add up to 1 within rounding only, so a white picture could come out just above 1.
    return np.clip(_gaussian(checked(picture, "picture"), 2 * int(4 * sigma + 0.5) + 1, float(sigma)), 0.0, 1.0)


def checked_pair(picture: object, reference: object, least_side: int = 1, metric: str = "the comparison") -> tuple[Field, Field]:
    """Return both arrays as `checked` does, of one shape.

    Raises
    ------
    InvalidInputError
        As `checked`, and if the shapes differ.
    """
    first, second = checked(picture, "picture"), checked(reference, "reference", least_side, metric)
    if first.shape != second.shape:
        raise InvalidInputError(f"the picture has the shape {first.shape}, but it must be that of the reference, {second.shape}")
    return first, second


def checked(values: object, name: str, least_side: int = 1, metric: str = "the comparison") -> Field:
    """Return an array that is fit for comparison, as float64.

    Parameters
    ----------
    values : array of floats, (height, width)
        In [0, 1].
    name : str
        What the array is in messages.
    least_side : int
        What `metric` asks of height and width, in pixels.
    metric : str
        What asks for it.

    Returns
    -------
    ndarray of float64, (height, width)

    Raises
    ------
    InvalidInputError
        If it is no such array.
    """
    array = unmasked(values, name)
    if array.ndim != 2 or array.size == 0:
        raise InvalidInputError(f"the {name} has the shape {array.shape}, but it must be (height, width) with at least one pixel")
    if array.dtype.kind != "f":
        remedy = "; divide by 255" if array.dtype == np.uint8 else ""
        raise InvalidInputError(f"the {name} has values of type {array.dtype}, but they must be floats in [0, 1]{remedy}")
    check_range(array, name)
    if min(array.shape) < least_side:
        height, width = array.shape
        raise InvalidInputError(f"the {name} is {width} x {height} pixels, but {metric} needs at least {least_side} a side")
    return array.astype(np.float64, copy=False)


def _gaussian(values: Field, side: int, sigma: float) -> Field:
    """Return the values under a normalised Gaussian window of side x side pixels."""
    return np.asarray(cv2.GaussianBlur(values, (side, side), sigma, borderType=cv2.BORDER_REFLECT), np.float64)


def _window_means(picture: Field, reference: Field) -> tuple[float, float]:
    """Return the means of SSIM and of its contrast-structure term over the windows that lie inside the picture."""
    first, second = (_gaussian(values, WINDOW_SIDE, WINDOW_SIGMA) for values in (picture, reference))
    squares, products = picture**2 + reference**2, picture * reference
    variances = _gaussian(squares, WINDOW_SIDE, WINDOW_SIGMA) - (first**2 + second**2)
    covariance = _gaussian(products, WINDOW_SIDE, WINDOW_SIGMA) - first * second
    luminance = (2 * first * second + K1**2) / (first**2 + second**2 + K1**2)
    contrast_structure = (2 * covariance + K2**2) / (variances + K2**2)
    inside = np.s_[WINDOW_SIDE // 2 : -(WINDOW_SIDE // 2), WINDOW_SIDE // 2 : -(WINDOW_SIDE // 2)]
    return float((luminance * contrast_structure)[inside].mean()), float(contrast_structure[inside].mean())


def _halved(values: Field) -> Field:
    """Return the means of all 2 x 2 blocks; the last row or column of an odd side is repeated."""
    even = np.pad(values, [(0, side % 2) for side in values.shape], mode="edge")
    return (even[::2, ::2] + even[1::2, ::2] + even[::2, 1::2] + even[1::2, 1::2]) / 4
