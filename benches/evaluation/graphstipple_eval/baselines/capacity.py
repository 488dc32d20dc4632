"""Capacity-constrained Voronoi stippling (Balzer, Schlömer and Deussen 2009): every dot stands for exactly the same ink.

Points are drawn from the darkness, so many for every site. Each site owns the same number of them, its capacity. Where two sites
can exchange points so that all of them come nearer to their owners, they do, pair by pair of sites; then every site moves to the
centroid of its points; until nothing is left to exchange. The result is a Voronoi diagram whose cells hold equal ink.

Readings of the paper, and what makes it fast:

- Points are spread over the darkness by `draw_points`, rather than drawn independently: the few that a site has would make noise.
- At first, a site owns the next points in their order, where the paper has them assigned at random; fewer exchanges are left.
- Two sites are looked at only if the bounding circles of their points meet (Li et al. 2010), and if one of them has changed since.
  Pairs without a site in common are looked at together, in random order.
- The time grows faster than the number of sites, so there are at most 1,500; with fewer dots than asked for, each is larger.
- Dots are equal discs whose areas add up to the darkness; where they overlap, ink is lost.
"""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np
import numpy.typing as npt

from graphstipple_eval.baselines.density import draw_points
from graphstipple_eval.baselines.dots import check_dots, equal_black_dots, picture
from graphstipple_eval.method import Method, Photo, Picture

MOST_DOTS = 1500
"""Dots at most: about 10 seconds, most of them for exchanges between sites that hardly move any more."""

CAPACITY = 128
"""Points that a site owns: with half as many, cells are visibly uneven; twice as many take twice as long."""

MOST_SWEEPS = 300
"""Sweeps over all pairs at most; photos need 40 to 80."""

LEAST_GAIN = 1e-9
"""Squared pixels by which an exchange must bring two points nearer to their owners: less may be rounding, and never end."""

SEED = 1


def settle(
    points: npt.NDArray[np.float64], generator: np.random.Generator
) -> tuple[npt.NDArray[np.float64], npt.NDArray[np.float64], int]:
    """Exchange points between sites until nothing is left to gain.

    Parameters
    ----------
    points : (n, capacity, 2) array of float64
        What every site owns at first.
    generator : numpy.random.Generator
        Orders the pairs.

    Returns
    -------
    points : (n, capacity, 2) array of float64
        What every site owns at last.
    sites : (n, 2) array of float64
        Their means.
    sweeps : int
        How often all pairs were looked at, at most `MOST_SWEEPS`.
    """
    points = points.copy()
    sites = points.mean(axis=1)
    pairs = np.stack(np.triu_indices(len(sites), 1), axis=1)
    changed = np.ones(len(sites), bool)
    sweeps = 0
    while changed.any() and sweeps < MOST_SWEEPS:
        radii = np.sqrt(((points - sites[:, np.newaxis]) ** 2).sum(axis=2).max(axis=1))
        near = np.hypot(*(sites[pairs[:, 0]] - sites[pairs[:, 1]]).T) < radii[pairs].sum(axis=1)
        looked_at = generator.permutation(pairs[near & changed[pairs].any(axis=1)])
        changed[:] = False
        for disjoint in matchings(looked_at, len(sites)):
            changed[disjoint[exchange(points, sites, disjoint)]] = True
        sites = points.mean(axis=1)
        sweeps += 1
    return points, sites, sweeps


def matchings(pairs: npt.NDArray[np.int64], sites: int) -> Iterator[npt.NDArray[np.int64]]:
    """Split pairs, (m, 2), into sets in which no site occurs twice; earlier pairs come first."""
    while len(pairs):
        number = np.arange(len(pairs))
        first = np.full(sites, len(pairs))
        np.minimum.at(first, pairs.ravel(), np.repeat(number, 2))
        is_first = (first[pairs] == number[:, np.newaxis]).all(axis=1)
        yield pairs[is_first]
        pairs = pairs[~is_first]


def exchange(
    points: npt.NDArray[np.float64], sites: npt.NDArray[np.float64], pairs: npt.NDArray[np.int64]
) -> npt.NDArray[np.bool_]:
    """Exchange points within disjoint pairs of sites, in place, and return which of the pairs, (m, 2), changed.

    To give a point x of site a to site b costs |x - b|^2 - |x - a|^2 = 2 x (a - b) + constant; what a point y of b gains on its way
    back is 2 y (a - b) with the same constant. So the points of a with the lowest 2 x (a - b) go for those of b with the highest,
    one for one, while that gains.
    """
    one, other = pairs.T
    direction = 2 * (sites[one] - sites[other])
    cost = np.einsum("mcd,md->mc", points[one], direction)
    gain_back = np.einsum("mcd,md->mc", points[other], direction)
    lowest, highest = np.argsort(cost, axis=1, kind="stable"), np.argsort(-gain_back, axis=1, kind="stable")
    gains = np.take_along_axis(gain_back, highest, axis=1) - np.take_along_axis(cost, lowest, axis=1) > LEAST_GAIN
    given = np.take_along_axis(points[one], lowest[:, :, np.newaxis], axis=1)
    taken = np.take_along_axis(points[other], highest[:, :, np.newaxis], axis=1)
    points[one] = np.where(gains[:, :, np.newaxis], taken, given)
    points[other] = np.where(gains[:, :, np.newaxis], given, taken)
    changed: npt.NDArray[np.bool_] = gains.any(axis=1)
    return changed


def stipple(photo: Photo, dots: int) -> Picture:
    """Return the picture of equal dots, at most `MOST_DOTS`."""
    count = min(check_dots(dots), MOST_DOTS)
    height, width = photo.tone.shape
    darkness = 1 - photo.tone.astype(np.float64)
    ink = float(darkness.sum())
    generator = np.random.default_rng(SEED)
    sites, sweeps = np.empty((0, 2)), 0
    if ink > 0:
        points = draw_points(darkness, count * CAPACITY, generator).reshape(count, CAPACITY, 2)
        _, sites, sweeps = settle(points, generator)
    settings: dict[str, object] = {"seed": SEED, "most_dots": MOST_DOTS, "capacity": CAPACITY, "sweeps": sweeps}
    if count < dots:
        settings["note"] = f"{count:,} dots instead of {dots:,}: more take too long"
    return picture(equal_black_dots(sites, ink), width, height, settings)


METHODS = (
    Method(
        "ccvt",
        f"Capacity-constrained Voronoi, at most {MOST_DOTS:,} dots",
        "Balzer, Schlömer and Deussen 2009",
        stipple,
        is_budgeted=True,
    ),
)
