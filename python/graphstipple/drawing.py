"""The drawing: pictures and files of it, its marks as data, and what the stages made on the way to it."""

from __future__ import annotations

import json
import os
from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property
from typing import Any, NamedTuple, overload

import numpy as np
import numpy.typing as npt

from graphstipple import _core
from graphstipple._errors import InvalidInputError
from graphstipple.options import Options

HEAVY_SVG_BYTES = 2_000_000
"""Above this, a notebook shows the PNG: browsers take seconds for larger SVGs, and every notebook file would hold them."""

NOTEBOOK_WIDTH = 1600
"""Widest PNG shown in a notebook, in pixels: wider than any notebook's column."""

STIPPLE_DTYPE = np.dtype([("x", np.float64), ("y", np.float64), ("radius", np.float64), ("ink", np.uint8)])
"""Fields of `Drawing.stipples`."""


class Graph(NamedTuple):
    """The second graph of a drawing, node by node."""

    sites: npt.NDArray[np.float64]
    """Position of every node, (n, 2) as x, y in pixels."""
    edges: npt.NDArray[np.uint32]
    """Every edge once, (m, 2), lower node first."""
    tone: npt.NDArray[np.float32]
    """Tone of every node, (n,) in [0, 1]."""
    labels: npt.NDArray[np.uint8]
    """Label of every node, (n,): 0 black, 1 white."""
    components: npt.NDArray[np.uint32]
    """Component of every node, (n,)."""


@dataclass(frozen=True, eq=False)
class Region:
    """A region of the flat picture: one exterior and its holes, curves flattened to within 0.05 px.

    Parameters
    ----------
    exterior : ndarray of float64, (n, 2)
        Outer boundary as x, y in pixels; the first point is not repeated.
    holes : list of ndarray of float64, (m, 2)
        Inner boundaries.
    area : float
        Area in px^2, without the holes.
    ink : int
        0 black, 1 white.
    """

    exterior: npt.NDArray[np.float64]
    holes: list[npt.NDArray[np.float64]]
    area: float
    ink: int


class _Regions(Sequence[Region]):
    """The regions of a drawing, each built when it is asked for."""

    def __init__(self, core: _core.Drawing) -> None:
        self._core = core

    def __len__(self) -> int:
        return self._core.region_count

    @overload
    def __getitem__(self, index: int) -> Region: ...
    @overload
    def __getitem__(self, index: slice) -> list[Region]: ...
    def __getitem__(self, index: int | slice) -> Region | list[Region]:
        if isinstance(index, slice):
            return [self[i] for i in range(*index.indices(len(self)))]
        # A range checks the index and counts from the end where it is negative.
        return Region(*self._core.region(range(len(self))[index]))

    def __repr__(self) -> str:
        return f"<{len(self)} regions>"


class Drawing:
    """A drawing of stipples and regions, as `draw` returns it."""

    def __init__(self, core: _core.Drawing, options: Options, seconds: dict[str, float]) -> None:
        self._core = core
        self._options = options
        self._seconds = seconds

    @property
    def width(self) -> int:
        """Width of the canvas in pixels: the image's."""
        return self._core.width

    @property
    def height(self) -> int:
        """Height of the canvas in pixels: the image's."""
        return self._core.height

    @property
    def options(self) -> Options:
        """The options that it was made with."""
        return self._options

    def save(self, path: str | os.PathLike[str], width: int | None = None) -> None:
        """Write the drawing to a file: SVG or PNG by suffix. The file is written whole or not at all.

        Parameters
        ----------
        path : str or path
            Where to; an existing file is replaced.
        width : int, optional
            Width of a PNG in pixels; by default the image's own.

        Raises
        ------
        InvalidInputError
            If the suffix is not known, or the width is out of range or given for a vector format.
        ImageFileError
            If the file cannot be written; `ImageFileNotFoundError` if its folder does not exist.
        """
        self._core.save(os.fsdecode(path), _checked_width(width))

    def svg(self) -> str:
        """Return the drawing as an SVG document."""
        return self._core.svg()

    def rasterize(self, width: int | None = None) -> npt.NDArray[np.uint8]:
        """Return the drawing as antialiased grey pixels.

        Parameters
        ----------
        width : int, optional
            Width in pixels, the height follows; by default the image's own size.

        Returns
        -------
        ndarray of uint8, (height, width)
            0 black, 255 white.

        Raises
        ------
        InvalidInputError
            If the width is out of range.
        """
        return self._core.rasterize(_checked_width(width))

    @cached_property
    def stipples(self) -> npt.NDArray[np.void]:
        """The dots: a structured array (n,) with the fields x, y, radius (in pixels) and ink (0 black, 1 white)."""
        return stipple_array(*self._core.stipples())

    @property
    def regions(self) -> Sequence[Region]:
        """The regions of the flat picture, each built when it is asked for."""
        return _Regions(self._core)

    @cached_property
    def stats(self) -> dict[str, Any]:
        """Counts (stipples, regions, nodes, vertices, anchors, coordinates, ...) and the seconds that every stage took."""
        stats: dict[str, Any] = json.loads(self._core.stats())
        seconds = stats["seconds"]
        seconds.update(self._seconds)
        seconds["total"] = seconds.get("total", 0.0) + sum(self._seconds.values())
        return stats

    @cached_property
    def graph(self) -> Graph:
        """The second graph: sites, edges, tone, labels and components of its nodes."""
        core = self._core
        return Graph(core.sites(), core.edges(), core.tone(), core.labels(), core.components())

    @cached_property
    def importance(self) -> npt.NDArray[np.float32]:
        """The importance on the canvas, (height, width) in [0, 1], before the node budget's factor."""
        return self._core.importance()

    def __repr__(self) -> str:
        return f"<graphstipple.Drawing {self.width} x {self.height}: {len(self._core.labels())} nodes, {len(self.regions)} regions>"

    @cached_property
    def _light_svg(self) -> str | None:
        """The SVG, unless it is heavy."""
        svg = self.svg()
        return svg if len(svg) <= HEAVY_SVG_BYTES else None

    def _repr_svg_(self) -> str | None:
        return self._light_svg

    def _repr_png_(self) -> bytes | None:
        return self._core.png(min(self.width, NOTEBOOK_WIDTH)) if self._light_svg is None else None


def stipple_array(circles: npt.NDArray[np.float64], inks: npt.NDArray[np.uint8]) -> npt.NDArray[np.void]:
    """Return circles (n, 3) and inks (n,) as one structured array."""
    stipples = np.empty(len(inks), STIPPLE_DTYPE)
    stipples["x"], stipples["y"], stipples["radius"] = circles.T
    stipples["ink"] = inks
    return stipples


def _checked_width(width: object) -> int | None:
    """Return the width; what Rust cannot take as an unsigned integer is said in our words."""
    if width is None:
        return None
    if isinstance(width, bool) or not isinstance(width, (int, np.integer)) or not 1 <= width < 2**31:
        raise InvalidInputError(f"width is {width!r}, but it must be a whole number of pixels, at least 1")
    return int(width)
