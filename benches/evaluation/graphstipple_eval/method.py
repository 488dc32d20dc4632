"""What a method of the comparison is: a photo in, a black-and-white picture out."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, field

import numpy as np
import numpy.typing as npt


@dataclass(frozen=True)
class Photo:
    """A photo at the size at which methods are compared.

    Parameters
    ----------
    name : str
        The file's name without suffix.
    checksum : str
        SHA-256 of the file, hexadecimal.
    pixels : (height, width) or (height, width, 3) array of uint8
        The photo, reduced to the size; sRGB.
    tone : (height, width) array of float32
        What every method draws and every picture is compared with: `graphstipple.stages.tone` of `pixels`, 0 black to 1 white.
    """

    name: str
    checksum: str
    pixels: npt.NDArray[np.uint8]
    tone: npt.NDArray[np.float32]


@dataclass(frozen=True)
class Counts:
    """How much a picture is made of; None where the method has no such thing.

    Parameters
    ----------
    stipples, regions : int, optional
        Dots, and closed shapes other than dots.
    vertices : int, optional
        Points before smoothing and simplification, a dot counting one.
    coordinates : int, optional
        Coordinate pairs written, control points included, a dot counting one.
    nodes : int, optional
        Nodes of the graph.
    anchors : int, optional
        Coordinate pairs written that lie on the curves, a dot counting one.
    """

    stipples: int | None = None
    regions: int | None = None
    vertices: int | None = None
    coordinates: int | None = None
    nodes: int | None = None
    anchors: int | None = None


@dataclass(frozen=True)
class Picture:
    """What a method made of a photo.

    Parameters
    ----------
    raster : (height, width) array of float32
        The picture at the size of the photo, antialiased; 0 black, 1 white.
    counts : Counts
        What it is made of.
    svg : str, optional
        The vector file, from methods that make one.
    settings : dict
        Everything that the result depends on besides the photo, as JSON values: options, seeds, numbers of dots and steps.
    labyrinth : dict
        The numbers of `labyrinth.measures`, from methods that have a graph.
    dots : (n, 3) array of float64, optional
        x and y of every dot's centre in pixels, and its ink, 0 black or 1 white; None from methods that have no dots.
    """

    raster: npt.NDArray[np.float32]
    counts: Counts
    svg: str | None = None
    settings: dict[str, object] = field(default_factory=dict)
    labyrinth: dict[str, float] = field(default_factory=dict)
    dots: npt.NDArray[np.float64] | None = None


@dataclass(frozen=True)
class Method:
    """A method of the comparison.

    Parameters
    ----------
    name : str
        Lower case and dashes: on the command line, in results and in file names.
    title : str
        In tables.
    source : str
        Authors and year, or the program's name.
    draw : callable
        `draw(photo, dots)` gives the picture. `dots` is how many dots a stippling method draws; methods that have no such number
        ignore it. Called once a photo in a process of its own; deterministic; uses one thread where it can.
    is_budgeted : bool
        Whether `dots` means anything to the method.
    missing : callable
        Returns None if the method can run here, or one sentence that says what it needs.
    """

    name: str
    title: str
    source: str
    draw: Callable[[Photo, int], Picture]
    is_budgeted: bool = False
    missing: Callable[[], str | None] = lambda: None
