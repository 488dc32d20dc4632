"""Turn a photo into a black-and-white vector drawing of stipples and regions.

The method is *Graph-based Black and White Stylization* (Computer Graphics Forum 2026, doi 10.1111/cgf.70364).

>>> import graphstipple as gs
>>> drawing = gs.draw("photo.jpg")  # doctest: +SKIP
>>> drawing.save("drawing.svg")  # doctest: +SKIP

Everywhere, x runs right and y runs down, in pixels of the input image; the pixel in column c and row r covers
[c, c + 1) x [r, r + 1). Arrays of pixels are (height, width), arrays of points are (n, 2) as x, y. 0 is black, 1 is white.
"""

from importlib import import_module
from typing import TYPE_CHECKING, Any

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
from graphstipple.drawing import Drawing, Graph, RecordedOptions, Region, load
from graphstipple.options import Options, Preset, Published, presets

if TYPE_CHECKING:
    from graphstipple import metrics, stages
    from graphstipple.importance import saliency

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
    "Published",
    "RecordedOptions",
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

_LATER = {"metrics": "graphstipple.metrics", "stages": "graphstipple.stages", "saliency": "graphstipple.importance"}
"""What a drawing does not need, and so is imported when it is first used: names and where they are."""


def __getattr__(name: str) -> Any:
    """Import what is asked for the first time."""
    if name not in _LATER:
        raise AttributeError(f"module {__name__!r} has no attribute {name!r}")
    module = import_module(_LATER[name])
    value = module if _LATER[name] == f"{__name__}.{name}" else getattr(module, name)
    globals()[name] = value
    return value


def __dir__() -> list[str]:
    """Return the public names too that are not imported yet."""
    return sorted({*globals(), *__all__})
