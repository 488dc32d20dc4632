"""Weighted Voronoi stippling (Secord 2002): equal dots at the centroids of their weighted Voronoi cells.

A sample of the density is moved by Lloyd's method: every point goes to the centre of mass of its Voronoi cell, again and again. The
paper's density is the darkness, 1 - tone. In the limit, the points of such a tessellation do not lie as dense as that, but, in two
dimensions, as dense as its square root (Gersho 1979), so that light areas come out too dark and dark ones too light. With the
square of the darkness as the density, the dots lie as dense as the tone asks.

Readings of the paper: the first points are spread evenly and as dense as what they converge to, the square root of the density; the
paper takes a random sample of the density and says that a start near the goal is useful. From a random one, clumps are left.
Dots are discs of one size, which the paper leaves to the user: here their areas add up to the photo's darkness. Where dots
overlap, ink is lost.
"""

from __future__ import annotations

import numpy as np
import numpy.typing as npt

from graphstipple_eval.baselines.density import Density, draw_points
from graphstipple_eval.baselines.dots import Dots, check_dots, equal_black_dots, keep_inside, picture
from graphstipple_eval.method import Method, Photo, Picture

SOURCE = "Secord 2002"

SEED = 1
MOST_STEPS = 100
"""Lloyd steps at most. The later ones make the spacing of the dots more even by less and less."""

STILL = 0.002
"""Steps end when the points move by less than this share of their mean distance, on average."""


def relax(density: Density, sites: npt.NDArray[np.float64]) -> tuple[npt.NDArray[np.float64], int]:
    """Return the sites, (n, 2), after Lloyd steps on the density, and how many steps those were."""
    still = STILL * np.sqrt(density.width * density.height / len(sites))
    moved, steps = np.inf, 0
    while moved >= still and steps < MOST_STEPS:
        centroids = keep_inside(density.cells(sites, density.runs(sites)).centroids, density.width, density.height)
        moved = np.hypot(*(centroids - sites).T).mean()
        sites = centroids
        steps += 1
    return sites, steps


def place(tone: npt.NDArray[np.float32], dots: int, power: int = 1, density: type[Density] = Density) -> tuple[Dots, int]:
    """Return the dots, and after how many steps.

    Parameters
    ----------
    tone : (height, width) array of float32
        Of the photo, 0 black to 1 white.
    dots : int
        How many.
    power : int
        The density is this power of the darkness.
    density : type
        What finds the cells in it.
    """
    count = check_dots(dots)
    height, width = tone.shape
    darkness = 1 - tone.astype(np.float64)
    sites, steps = np.empty((0, 2)), 0
    if darkness.any():
        start = draw_points(darkness ** (power / 2), count, np.random.default_rng(SEED))
        sites, steps = relax(density(darkness**power, count), keep_inside(start, width, height))
    return equal_black_dots(sites, float(darkness.sum())), steps


def _stipple(photo: Photo, dots: int, power: int) -> Picture:
    height, width = photo.tone.shape
    placed, steps = place(photo.tone, dots, power)
    return picture(placed, width, height, {"seed": SEED, "steps": steps, "weight_power": power})


def weighted(photo: Photo, dots: int) -> Picture:
    """Return the paper's picture: the density is the darkness."""
    return _stipple(photo, dots, 1)


def squared(photo: Photo, dots: int) -> Picture:
    """Return the picture that keeps the tone: the density is the square of the darkness."""
    return _stipple(photo, dots, 2)


METHODS = (
    Method("wvs", "Weighted Voronoi", SOURCE, weighted, is_budgeted=True),
    Method("wvs-squared", "Weighted Voronoi, squared weight", SOURCE, squared, is_budgeted=True),
)
