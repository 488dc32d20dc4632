"""Turn a photo into a black-and-white vector drawing of stipples and regions.

The method is *Graph-based Black and White Stylization* (Computer Graphics Forum 2026, doi 10.1111/cgf.70364).

>>> import graphstipple as gs
>>> drawing = gs.draw("photo.jpg")  # doctest: +SKIP
>>> drawing.save("drawing.svg")  # doctest: +SKIP

Everywhere, x runs right and y runs down, in pixels of the input image; the pixel in column c and row r covers
[c, c + 1) x [r, r + 1). Arrays of pixels are (height, width), arrays of points are (n, 2) as x, y. 0 is black, 1 is white.
"""

from graphstipple import metrics, stages
from graphstipple._core import __version__
from graphstipple._draw import Session, draw
from graphstipple._errors import (
    GraphStippleError,
    ImageFileError,
    ImageFileNotFoundError,
    InvalidInputError,
    MissingPackageError,
    MissingWeightsError,
)
from graphstipple.drawing import Drawing, Graph, Region, load
from graphstipple.importance import saliency
from graphstipple.options import Options, Preset, presets

__all__ = [
    "Drawing",
    "Graph",
    "GraphStippleError",
    "ImageFileError",
    "ImageFileNotFoundError",
    "InvalidInputError",
    "MissingPackageError",
    "MissingWeightsError",
    "Options",
    "Preset",
    "Region",
    "Session",
    "__version__",
    "draw",
    "load",
    "metrics",
    "presets",
    "saliency",
    "stages",
]
