"""`draw`: a photo in, a drawing out."""

from __future__ import annotations

import os
import time
from collections.abc import Callable
from typing import Any, TypeAlias

import numpy as np
import numpy.typing as npt
from PIL import Image

from graphstipple import _core, importance
from graphstipple._errors import InvalidInputError
from graphstipple._inputs import ImageLike, read_luma
from graphstipple.drawing import Drawing
from graphstipple.options import Options

ImportanceMap: TypeAlias = "os.PathLike[str] | Image.Image | npt.NDArray[Any]"
"""A path, a PIL image or an array."""

ImportanceLike: TypeAlias = "str | ImportanceMap | Callable[[npt.NDArray[np.float32]], ImportanceMap | str] | None"
"""A name, a map, or what makes one of the photo's luma."""

Progress: TypeAlias = "Callable[[str, float], object]"
"""Called with a stage's name and the fraction of the whole drawing that is done."""


def draw(
    image: ImageLike,
    importance: ImportanceLike = "saliency",
    options: Options | None = None,
    progress: Progress | None = None,
) -> Drawing:
    """Draw a photo in black and white.

    The interpreter lock is released during the work, and Ctrl-C stops it at once.

    Parameters
    ----------
    image : str, path, PIL image or ndarray
        The photo. A file (PNG, JPEG, TIFF, WebP) is decoded by Rust, as on the command line. An array is (height, width) or
        (height, width, channels): grey, grey and alpha, sRGB, or sRGB and alpha; bool, uint8, uint16, or floats in [0, 1].
        A colour profile is applied to files only: PIL images and arrays are taken as sRGB.
    importance : str, path, PIL image, ndarray or callable
        Where detail is wanted: "saliency" (the default), "none" (everywhere), "constant:V" with V in (0, 1], or a map of any
        size, as a file, PIL image or array (height, width), white where detail is wanted. A callable gets the photo's luma, float32
        (height, width) in [0, 1], and returns any of these. The photo's own detail is mixed into saliency and maps as `detail`,
        `floor` and `midtones` of the options say.
    options : Options, optional
        By default ``Options()``.
    progress : callable, optional
        Called with the stage's name and the fraction of the whole drawing that is done, some 50 times a second. What it raises
        stops the work.

    Returns
    -------
    Drawing

    Raises
    ------
    InvalidInputError
        If the image, the importance or an option breaks a rule.
    ImageFileError
        If a file cannot be read as an image; `ImageFileNotFoundError` if there is none.
    """
    if options is None:
        options = Options()
    if not isinstance(options, Options):
        raise InvalidInputError(f"options is of type {type(options).__name__}, but it must be graphstipple.Options")
    seconds: dict[str, float] = {}
    report = progress or _silent

    report("decoding", 0.0)
    start = time.perf_counter()
    luma = read_luma(image, options.background)
    seconds["decoding"] = time.perf_counter() - start

    source, map_ = _importance(importance, luma, options.background, seconds, report)
    result = _core.draw(luma, source, map_, options._json(), progress)
    report("outlines", 1.0)
    return Drawing(result, options, seconds)


def _importance(
    wanted: ImportanceLike, luma: npt.NDArray[np.float32], background: str, seconds: dict[str, float], report: Progress
) -> tuple[str, npt.NDArray[np.float32] | None]:
    """Return the importance's name for the core, with the map if it has one."""
    if wanted is None:
        wanted = "saliency"
    start = time.perf_counter()
    if callable(wanted):
        wanted = wanted(luma.copy())
    if isinstance(wanted, str):
        kind = _core.importance_source(wanted)
        if kind == "constant":
            return wanted, None
        if kind == "saliency":
            report("saliency", 0.0)
            map_ = importance.of_luma(luma)
            seconds["saliency"] = time.perf_counter() - start
            return "saliency", map_
    elif not isinstance(wanted, (os.PathLike, Image.Image)) and getattr(wanted, "ndim", 2) != 2:
        raise InvalidInputError(f"the importance has the shape {np.shape(wanted)}, but it must be (height, width)")
    map_ = read_luma(wanted, background, "importance")
    seconds["decoding"] += time.perf_counter() - start
    return "map", map_


def _silent(stage: str, fraction: float) -> None:
    """Report nothing."""
