"""Plots: a drawing as paths for a pen, in the order in which they are drawn, with the time that a machine takes for them."""

from __future__ import annotations

import os
from functools import cached_property
from typing import TYPE_CHECKING, Any, Literal, NamedTuple, TypeAlias

import numpy as np
import numpy.typing as npt

from graphstipple import _core
from graphstipple._errors import InvalidInputError
from graphstipple._inputs import checked_width, path_to_write

if TYPE_CHECKING:
    from collections.abc import Sequence

Fill: TypeAlias = Literal["contour", "hatch", "outline", "none"]
"""How a pen fills areas."""

PenDots: TypeAlias = Literal["press", "circle"]
"""How a pen draws dots."""

PenOrder: TypeAlias = Literal["short", "none"]
"""In which order paths are drawn."""

USUAL_MACHINE = "axidraw"
"""The machine whose time `Plot.stats` tells."""

HEAVY_SVG_BYTES = 2_000_000
"""Above this, a notebook shows the PNG: browsers take seconds for larger SVGs, and every notebook file would hold them."""


class PlotLayer(NamedTuple):
    """What one pen draws."""

    ink: str
    """The pen's ink: "black" or "white"."""
    paths: list[npt.NDArray[np.float64]]
    """Its paths in order, (n, 2) each."""


class Machine(NamedTuple):
    """A machine whose profile comes with graphstipple."""

    name: str
    """What it is asked for by."""
    description: str
    """What machine that is."""
    profile: str
    """The profile as TOML: saved to a file and changed, it is one of a machine of one's own."""


class Plot:
    """A drawing as paths for a pen, as `Drawing.plot` returns it.

    It never changes. All lengths are mm. Sizes of pens and dots are diameters.
    """

    def __init__(self, core: _core.Plot) -> None:
        self._core = core

    @cached_property
    def layers(self) -> list[PlotLayer]:
        """What each pen draws, in the order in which they are taken."""
        names = ["black", "white"]
        return [
            PlotLayer(names[ink], np.split(points, ends[:-1].tolist())) for ink, points, ends in self._core.layers() if len(ends)
        ]

    @property
    def paths(self) -> Sequence[npt.NDArray[np.float64]]:
        """All paths in the order in which they are drawn: x and y in mm from the drawing's top left corner, (n, 2) each.

        A path of one point is a press of the pen; one that ends where it begins is closed.
        """
        return [path for layer in self.layers for path in layer.paths]

    @property
    def pen(self) -> float:
        """Width of the pen in mm."""
        return self._core.sizes[0]

    @property
    def size(self) -> tuple[float, float]:
        """Width and height of the drawing in mm."""
        width, height = self._core.sizes[1]
        return width, height

    @property
    def page(self) -> tuple[float, float]:
        """Width and height of the sheet in mm."""
        width, height = self._core.sizes[2]
        return width, height

    @cached_property
    def stats(self) -> dict[str, Any]:
        """What was counted and measured, and the time on an AxiDraw; `time` has that of others.

        `pen_down_mm` and `pen_up_mm` are lengths of line and of ways between, `lifts` how often the pen is lifted, `paths` and
        `presses` how many there are of each, `thin` how many parts narrower than the pen are drawn as one line along their
        middle, `small_dots` how many dots are narrower than the pen and pressed nonetheless; `seconds` is the sum of `drawing_s`,
        `travel_s`, `pen_s` (lowering and lifting it) and `dwell_s` (presses), on the machine of the name `machine`.
        """
        stats: dict[str, Any] = self._core.stats(USUAL_MACHINE)
        return stats

    def time(self, machine: str | os.PathLike[str] = USUAL_MACHINE) -> float:
        """Return the seconds that a machine takes, without pauses for somebody to fill or change the pen.

        Speed grows and falls with the machine's acceleration, and corners are taken as fast as its junction deviation allows.

        Parameters
        ----------
        machine : str or path
            The name of one of `machines`, or the file of a profile.

        Returns
        -------
        float

        Raises
        ------
        InvalidInputError
            If there is no machine of the name.
        ImageFileError
            If the profile's file cannot be read, or breaks a rule; `ImageFileNotFoundError` if there is none.
        """
        stats: dict[str, Any] = self._core.stats(_machine_name(machine))
        seconds: float = stats["seconds"]
        return seconds

    def save(self, path: str | os.PathLike[str], machine: str | os.PathLike[str] | None = None, *, force: bool = False) -> None:
        """Write the plot to a file, whole or not at all: .svg, .gcode or .hpgl.

        Parameters
        ----------
        path : str or path
            Where to; an existing file is replaced, unless it is read-only.
        machine : str or path, optional
            The name of one of `machines`, or the file of a profile. By default an SVG is for any machine, G-code for a pen plotter
            with GRBL ("grbl"), and HP-GL for an HP 7475A with A4 paper ("hp7475a").
        force : bool
            Whether a file that is read-only is replaced, too.

        Raises
        ------
        InvalidInputError
            If the suffix is not known, there is no machine of the name, or it reads other files or does not reach all of the plot.
        ImageFileError
            If a file cannot be read or written, or a profile breaks a rule; `ImageFileNotFoundError` if it or its folder does not
            exist.
        """
        self._core.save(path_to_write(path), None if machine is None else _machine_name(machine), bool(force))

    def svg(self) -> str:
        """Return the plot as an SVG document, the same that `save` writes."""
        return self._core.encode("svg").decode()

    def rasterize(self, width: int | None = None) -> npt.NDArray[np.uint8]:
        """Return what the pen draws as antialiased grey pixels, with round ends.

        Parameters
        ----------
        width : int, optional
            Width in pixels, the height follows; by default a pixel for one of the drawing's canvas.

        Returns
        -------
        ndarray of uint8, (height, width)
            0 black, 255 white.

        Raises
        ------
        InvalidInputError
            If the width is out of range.
        """
        return self._core.rasterize(checked_width(width))

    def __repr__(self) -> str:
        width, height = self.size
        return f"<graphstipple.Plot {width:.1f} x {height:.1f} mm, pen {self.pen:g} mm: {self.stats['paths']} paths>"

    def _repr_svg_(self) -> str | None:
        svg = self.svg()
        return svg if len(svg) <= HEAVY_SVG_BYTES else None


def machines() -> list[Machine]:
    """Return the machines whose profiles come with graphstipple."""
    return [Machine(*machine) for machine in _core.machines()]


def _machine_name(machine: object) -> str:
    """Return a machine's name or the path of its profile as text."""
    if not isinstance(machine, (str, os.PathLike)):
        raise InvalidInputError(f"machine is {machine!r}, but it must be the name of a machine or the path of a profile")
    return os.fsdecode(machine)
