"""How evenly dots are spaced: the distance to the nearest dot beside what it would be on a hexagonal lattice as dense.

No n dots on an area can all lie farther from one another than on a hexagonal lattice, where the nearest is at
sqrt(2 / (sqrt(3) n / area)). A dot's evenness is the distance to the nearest dot of its own ink divided by that: 1 on the lattice,
0.93 on a square grid, about 0.45 with a deviation of 0.21 where dots are thrown at random. Two numbers say how even a picture's
dots are:

- evenness: the mean over dots;
- evenness deviation: their standard deviation, which is lowest where all dots are spaced alike.

On a photo, dots are as dense as the tone asks, so density is local. Around a dot it is counted over the patch of its own Voronoi
cell and those of all dots whose cells touch it: dots in the patch, divided by the patch's area. Cells are those among dots of one
ink. The mean is over dots of both inks, except those around which no density can be told:

- at the border: a cell of the patch is not wholly on the canvas;
- where dots end, at a region or at bare paper or ink: a cell of the patch reaches farther from its dot than `FARTHEST` times the
  side of a square that is as large as a cell on average (the harmonic mean over that cell and its neighbours), as beside a gap of
  some four spacings.

Dots at the same place count each, at distance 0. Sizes of dots do not matter.
"""

from __future__ import annotations

from typing import Any

import numpy as np
import numpy.typing as npt
from scipy.spatial import QhullError, Voronoi

FARTHEST = 2.0
"""How far a cell may reach before dots are said to end there, in sides of a square of the usual cell's area: on a hexagonal lattice
cells reach 0.6. A smaller one leaves out dots that are only unevenly spaced, a larger one takes wider gaps for a low density."""

FEWEST = 20
"""Dots that must be left: the numbers of fewer say nothing."""


def measures(dots: npt.NDArray[np.float64], width: int, height: int) -> dict[str, float]:
    """Return both numbers of a picture's dots: `evenness` and `evenness_deviation`; nothing where too few dots can be judged.

    Parameters
    ----------
    dots : (n, 3) array of float64
        Centres as x, y in pixels, and inks: only dots of the same ink are one another's neighbours.
    width, height : int
        The canvas in pixels.
    """
    inks = dots[:, 2]
    found = np.concatenate([np.empty(0), *(ratios(dots[inks == ink, :2], width, height) for ink in np.unique(inks))])
    if len(found) < FEWEST:
        return {}
    return {"evenness": float(found.mean()), "evenness_deviation": float(found.std())}


def ratios(positions: npt.NDArray[np.floating[Any]], width: int, height: int) -> npt.NDArray[np.float64]:
    """Return the evenness of every dot that can be judged, of dots of one ink.

    Parameters
    ----------
    positions : (n, 2) array of floats
        Centres as x, y in pixels.
    width, height : int
        The canvas in pixels.
    """
    places, copies = np.unique(positions.astype(np.float64), axis=0, return_counts=True)
    try:
        diagram = Voronoi(places)
    except (QhullError, ValueError):  # all on one line, or hardly any
        return np.empty(0)
    count = len(places)
    # Every edge between two cells, seen from both.
    own, other = np.concatenate([diagram.ridge_points, diagram.ridge_points[:, ::-1]]).T
    vertices = np.tile(np.array(diagram.ridge_vertices), (2, 1))
    ends = diagram.vertices[vertices]
    is_open = (vertices < 0).any(axis=1)
    is_cut = is_open | ((ends < 0) | (ends > (width, height))).any(axis=(1, 2))
    apart = np.hypot(*(places[own] - places[other]).T)
    # A cell is made of the triangles from its dot to its edges, which are half of `apart` away.
    triangles = np.where(is_open, 0, np.hypot(*(ends[:, 0] - ends[:, 1]).T) * apart / 4)
    areas = np.bincount(own, triangles, count)
    nearest, reach = np.full(count, np.inf), np.zeros(count)
    np.minimum.at(nearest, own, apart)
    np.maximum.at(reach, own, np.hypot(*(ends - places[own][:, np.newaxis]).transpose(2, 0, 1)).max(axis=1))

    def in_patch(values: npt.NDArray[Any]) -> npt.NDArray[np.float64]:
        """Return the sum over every dot's own value and those of its neighbours."""
        return values + np.bincount(own, values[other], count).astype(np.float64)

    is_whole = np.bincount(own, is_cut, count) == 0
    density = np.where(is_whole, 1 / np.where(is_whole, areas, 1), 0)
    usual = in_patch(is_whole.astype(np.float64)) / np.maximum(in_patch(density), np.finfo(np.float64).tiny)
    ends_here = reach > FARTHEST * np.sqrt(usual)
    is_judged = in_patch(~is_whole | ends_here) == 0
    lattice = np.sqrt(2 / np.sqrt(3) * in_patch(areas)[is_judged] / in_patch(copies)[is_judged])
    single = np.where(copies == 1, nearest, 0)[is_judged] / lattice
    return np.repeat(single, copies[is_judged])
