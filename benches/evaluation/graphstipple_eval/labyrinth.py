"""How far a drawing falls into labyrinths: many small regions, and long boundaries between them.

In middle greys, neighbouring dots join to short winding regions. Two numbers say how much of that there is:

- small regions: components of 2 to 12 nodes, per 1000 nodes;
- boundary: length of all curves between black and white regions per node, in pixels; outlines of dots and the frame are no curves.
"""

from __future__ import annotations

from collections.abc import Iterable

import numpy as np
import numpy.typing as npt

import graphstipple as gs

SMALLEST, LARGEST = 2, 12
"""Nodes of a small region. One node is a dot; what has more than a dozen holds tone over an area rather than texture."""


def measures(drawing: gs.Drawing) -> dict[str, float]:
    """Return both numbers of a drawing with its graph: `small_regions` per 1000 nodes and `boundary` in pixels per node."""
    length = boundary_length((region.exterior for region in drawing.regions), drawing.width, drawing.height)
    components = drawing.graph.components
    return {"small_regions": small_regions(components), "boundary": length / len(components)}


def small_regions(components: npt.NDArray[np.uint32]) -> float:
    """Return the number of components of `SMALLEST` to `LARGEST` nodes per 1000 nodes.

    Parameters
    ----------
    components : (n,) array of uint32
        The component of every node.
    """
    _, nodes = np.unique(components, return_counts=True)
    small = np.count_nonzero((nodes >= SMALLEST) & (nodes <= LARGEST))
    return float(1000 * small / len(components))


def boundary_length(exteriors: Iterable[npt.NDArray[np.float64]], width: int, height: int) -> float:
    """Return the length of all curves between regions, every curve once, without the frame.

    A closed curve is the exterior of the one region inside it. A curve that ends on the frame is part of the exteriors of the
    regions on both sides, and counts half in each. Holes add nothing: they are exteriors of other regions, or dots.

    Parameters
    ----------
    exteriors : iterable of (n, 2) arrays of float64
        The exteriors of all regions, black and white, as x, y in pixels; the first point is not repeated.
    width, height : int
        The canvas in pixels.
    """
    length = 0.0
    for ring in exteriors:
        following = np.roll(ring, -1, axis=0)
        sides = [ring == side for side in ((0.0, 0.0), (width, height))]
        on_frame = np.any([side & np.roll(side, -1, axis=0) for side in sides], axis=(0, 2))
        inside = np.hypot(*(following - ring)[~on_frame].T).sum()
        length += inside / 2 if on_frame.any() else inside
    return float(length)
