"""Linde-Buzo-Gray stippling (Deussen, Spicker and Zheng 2017): cells split and vanish until each holds the ink of its dot.

A few sites grow into as many as the tone asks for. In every step the Voronoi cells of the sites are measured. A cell with much more
ink than a dot has splits in two, along the axis on which its ink is spread most; one with much less loses its site; every other
site moves to its cell's centroid. How much more or less is allowed, the hysteresis, grows with every step: so the sites settle.

Readings of the paper, most of them after the programs of its authors: a cell is kept while its ink lies within (1 +- hysteresis /
2) of the dot's area; the two sites of a split lie half the radius of a disc of the cell's area to either side of its centroid;
there are at most 50 steps, and none after one that splits and removes nothing. The hysteresis grows from 0.01 towards 1, 0.98 at
the last step, as in the later program for several classes; from 0.6, where the first program begins, the ink of the cells varies
half as much again. All dots have one size. The paper chooses it and gets their number; here the number is given. The dots are
drawn with areas that add up to the darkness; where they overlap, ink is lost.
"""

from __future__ import annotations

import numpy as np
import numpy.typing as npt

from graphstipple_eval.baselines.density import Cells, Density, Runs
from graphstipple_eval.baselines.dots import check_dots, equal_black_dots, keep_inside, picture
from graphstipple_eval.method import Method, Photo, Picture

SEED = 1
FIRST_SITES = 100
"""Random sites to begin with, as in the later program, but no more than dots. From one alone, an even tone is only ever halved,
whatever is asked for; from 100, a handful of dots is not met."""

MOST_STEPS = 50
FIRST_HYSTERESIS, LAST_HYSTERESIS = 0.01, 1.0

SURPLUS = 1.03
"""Dots that come out for every one that the ink would fill: so much more ink a dot is given. On photos, from 20 dots on, the number
that is wanted of one class is then met within 5 %, from 300 on within 1 % or so."""


def hysteresis(step: int) -> float:
    """Return the hysteresis of a step, counted from 0."""
    return FIRST_HYSTERESIS + (LAST_HYSTERESIS - FIRST_HYSTERESIS) * step / MOST_STEPS


def first_sites(width: int, height: int, dots: int, generator: np.random.Generator) -> npt.NDArray[np.float64]:
    """Return `FIRST_SITES` random sites, (n, 2), or as many as dots if these are fewer."""
    return keep_inside(generator.random((min(FIRST_SITES, dots), 2)) * [width, height], width, height)


def next_sites(
    density: Density,
    runs: Runs,
    cells: Cells,
    targets: npt.NDArray[np.float64],
    *,
    dot_areas: npt.NDArray[np.float64] | float,
    hysteresis: float,
) -> tuple[npt.NDArray[np.float64], bool]:
    """Return the sites of the next step, (m, 2), and whether a cell was split or a site lost.

    Parameters
    ----------
    density : Density
        Of ink.
    runs, cells
        What the n sites own of it.
    targets : (n, 2) array of float64
        Where a site goes that is kept.
    dot_areas : float, or (n,) array
        The ink of every site's dot, px^2.
    hysteresis : float
        In [0, 2].
    """
    splits = cells.masses > (1 + hysteresis / 2) * dot_areas
    keeps = ~splits & (cells.masses >= (1 - hysteresis / 2) * dot_areas)
    if not (splits | keeps).any():
        # All cells have a little less ink than a dot, which happens to a handful: one stays, as from none nothing grows.
        keeps[np.argmax(cells.masses)] = True
    halves = density.axes(cells, runs)[splits] * (np.sqrt(cells.areas[splits] / np.pi) / 2)[:, np.newaxis]
    sites = np.concatenate([targets[keeps], cells.centroids[splits] - halves, cells.centroids[splits] + halves])
    return keep_inside(sites, density.width, density.height), not bool(keeps.all())


def stipple(photo: Photo, dots: int) -> Picture:
    """Return the picture of equal dots."""
    count = check_dots(dots)
    height, width = photo.tone.shape
    density = Density(1 - photo.tone.astype(np.float64), count)
    dot_area = SURPLUS * density.total / count
    sites = first_sites(width, height, count, np.random.default_rng(SEED)) if density.total > 0 else np.empty((0, 2))
    changed, steps = len(sites) > 0, 0
    while changed and steps < MOST_STEPS:
        runs = density.runs(sites)
        cells = density.cells(sites, runs)
        sites, changed = next_sites(density, runs, cells, cells.centroids, dot_areas=dot_area, hysteresis=hysteresis(steps))
        steps += 1
    return picture(equal_black_dots(sites, density.total), width, height, {"seed": SEED, "steps": steps, "dot_area": dot_area})


METHODS = (Method("lbg", "Linde-Buzo-Gray", "Deussen, Spicker and Zheng 2017", stipple, is_budgeted=True),)
