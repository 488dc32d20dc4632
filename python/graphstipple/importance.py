"""Where detail is wanted: the fine-grained saliency of a photo, by OpenCV."""

from __future__ import annotations

from typing import Any

import cv2
import numpy as np
import numpy.typing as npt

from graphstipple import _core
from graphstipple._inputs import ImageLike, read_luma
from graphstipple._interruptible import run


def saliency(image: ImageLike, *, background: str = "white") -> npt.NDArray[np.float32]:
    """Return the fine-grained saliency (Montabone & Soto) of an image: the default importance.

    Parameters
    ----------
    image : path, PIL image or array
        As for `draw`.
    background : str
        What lies under transparent pixels: "white", "black", "#rrggbb" or "#rgb".

    Returns
    -------
    ndarray of float32, (height, width)
        In [0, 1], multiples of 1/255; 0 everywhere for flat and for tiny images.

    Raises
    ------
    InvalidInputError, ImageFileError
        As `draw`.
    """
    return of_luma(read_luma(image, background))


def of_luma(luma: npt.NDArray[np.float32]) -> npt.NDArray[np.float32]:
    """Return the saliency of luma (height, width) in [0, 1]."""
    values = _core.luma_to_u8(luma)

    def compute() -> npt.NDArray[np.float32]:
        # OpenCV's own stubs leave the name out.
        method: Any = cv2.saliency.StaticSaliencyFineGrained_create()  # type: ignore[attr-defined]
        found, result = method.computeSaliency(values)
        map_: npt.NDArray[np.float32] = np.asarray(result, np.float32)
        if not found or map_.shape != values.shape or not np.isfinite(map_).all():
            return np.zeros(values.shape, np.float32)
        return map_

    return run(compute)
