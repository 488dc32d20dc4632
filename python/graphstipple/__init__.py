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
from graphstipple._errors import (
    GraphStippleError,
    GraphStippleWarning,
    ImageFileError,
    ImageFileNotFoundError,
    InvalidInputError,
    MissingPackageError,
    MissingWeightsError,
)

if TYPE_CHECKING:
    from graphstipple import metrics, stages
    from graphstipple._draw import Session, draw
    from graphstipple.batches.api import batch
    from graphstipple.batches.run import BatchResult
    from graphstipple.drawing import Drawing, Graph, RecordedOptions, Region, load
    from graphstipple.importance import saliency
    from graphstipple.options import Options, Preset, Published, presets
    from graphstipple.plots import Machine, Plot, PlotLayer, machines
    from graphstipple.rules import Changes, Process, Report, Rules, Violation, processes
    from graphstipple.studio.notebook import Studio
    from graphstipple.subject import find_subject

__all__ = [
    "BatchResult",
    "Changes",
    "Drawing",
    "Graph",
    "GraphStippleError",
    "GraphStippleWarning",
    "ImageFileError",
    "ImageFileNotFoundError",
    "InvalidInputError",
    "Machine",
    "MissingPackageError",
    "MissingWeightsError",
    "Options",
    "Plot",
    "PlotLayer",
    "Preset",
    "Process",
    "Published",
    "RecordedOptions",
    "Region",
    "Report",
    "Rules",
    "Session",
    "Studio",
    "Violation",
    "__version__",
    "batch",
    "draw",
    "find_subject",
    "load",
    "machines",
    "metrics",
    "presets",
    "processes",
    "saliency",
    "stages",
]

_LATER = {
    "_draw": ("Session", "draw"),
    "batches.api": ("batch",),
    "batches.run": ("BatchResult",),
    "drawing": ("Drawing", "Graph", "RecordedOptions", "Region", "load"),
    "importance": ("saliency",),
    "options": ("Options", "Preset", "Published", "presets"),
    "plots": ("Machine", "Plot", "PlotLayer", "machines"),
    "rules": ("Changes", "Process", "Report", "Rules", "Violation", "processes"),
    "studio.notebook": ("Studio",),
    "subject": ("find_subject",),
}
"""What is imported when it is first used, by module: the command line starts without NumPy, a drawing without OpenCV and Pillow."""

_MODULES = ("drawing", "importance", "metrics", "options", "stages", "subject")
"""Modules, likewise."""


def _imported(name: str) -> Any:
    """Import what is asked for the first time."""
    if name in _MODULES:
        return import_module(f"{__name__}.{name}")
    for module, names in _LATER.items():
        if name in names:
            value = getattr(import_module(f"{__name__}.{module}"), name)
            globals()[name] = value
            return value
    raise AttributeError(f"module {__name__!r} has no attribute {name!r}")


if not TYPE_CHECKING:
    # Type checkers know the names from above, and are to say which there are not.
    __getattr__ = _imported


def __dir__() -> list[str]:
    """Return the public names too that are not imported yet."""
    return sorted({*globals(), *__all__})
