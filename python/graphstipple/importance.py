"""Saliency by OpenCV: what stands out of a photo, as a map to draw with or to look at."""

from __future__ import annotations

from typing import Any, Literal, TypeAlias

import numpy as np
import numpy.typing as npt

from graphstipple import _core
from graphstipple._errors import InvalidInputError, MissingPackageError
from graphstipple._inputs import ImageLike, read_luma
from graphstipple._interruptible import run
from graphstipple.options import Options

Method: TypeAlias = Literal["fine-grained", "spectral-residual"]
"""How saliency is found."""

FACTORIES = {
    "fine-grained": "StaticSaliencyFineGrained_create",
    "spectral-residual": "StaticSaliencySpectralResidual_create",
}
"""OpenCV's functions by method."""


def saliency(image: ImageLike, *, method: Method = "fine-grained", background: str = "white") -> npt.NDArray[np.float32]:
    """Return the saliency of an image, by OpenCV.

    Parameters
    ----------
    image : path, PIL image or array
        As for `draw`.
    method : {"fine-grained", "spectral-residual"}
        Fine-grained (Montabone & Soto 2010): what differs from its surroundings; `draw` makes the same map, to the last bit,
        without OpenCV. Spectral residual (Hou & Zhang 2007): what is unlikely in the photo's spectrum; coarse spots.
    background : str
        What lies under transparent pixels: "white", "black", "#rrggbb" or "#rgb".

    Returns
    -------
    ndarray of float32, (height, width)
        In [0, 1], 0 everywhere for flat and for tiny images; fine-grained it holds multiples of 1/255.

    Raises
    ------
    InvalidInputError, ImageFileError
        As `draw`; `InvalidInputError` also if there is no such method.
    MissingPackageError
        If OpenCV, or its module `saliency`, is not installed.
    """
    if method not in FACTORIES:
        raise InvalidInputError(f'method is "{method}", but it must be "fine-grained" or "spectral-residual"')
    values = _core.luma_to_u8(read_luma(image, Options(background=background)._checked.background))
    create = getattr(_opencv_saliency(), FACTORIES[method])

    def compute() -> npt.NDArray[np.float32]:
        found, result = create().computeSaliency(values)
        map_: npt.NDArray[np.float32] = np.asarray(result, np.float32)
        if not found or map_.shape != values.shape or not np.isfinite(map_).all():
            return np.zeros(values.shape, np.float32)
        return np.clip(map_, 0.0, 1.0)

    return run(compute)


def _opencv_saliency() -> Any:
    """Return OpenCV's module of saliency; wheels of OpenCV replace one another, and only some have it."""
    way_out = "pip uninstall the other wheels of OpenCV, then pip install --force-reinstall opencv-contrib-python-headless"
    try:
        import cv2  # noqa: PLC0415  # a drawing does not need it
    except ImportError as error:
        raise MissingPackageError(f"saliency needs OpenCV ({error}): pip install opencv-contrib-python-headless") from error
    if not hasattr(cv2, "saliency"):
        raise MissingPackageError(f"saliency needs the contributed modules of OpenCV, which the installed one lacks: {way_out}")
    return cv2.saliency
