"""Densities over the canvas: what the Voronoi cells of sites hold of them, and points as dense as they."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Any

import numpy as np
import numpy.typing as npt

from graphstipple import stages

SAMPLES_PER_SITE = 100
"""Samples to a cell on average, at least, up to the limits below: with fewer, the small cells of dark areas move in visible steps;
with more, nothing changes but the time."""

MOST_SAMPLES_PER_PIXEL = 4
"""Samples along one axis of a pixel, at most: within cells smaller than a pixel the photo says nothing more."""

MOST_SAMPLES = 1 << 23
"""Samples of a grid, at most, unless there are more pixels: 200 MB while cells are measured, and time. At 1024 x 1024 px,
twice as many change the far PSNR of a multi-class picture by less than 0.1 dB."""


@dataclass(frozen=True)
class Cells:
    """What a density's samples say of every site's Voronoi cell.

    Parameters
    ----------
    masses : (n,) array of float64
        Integral of the density, px^2.
    areas : (n,) array of float64
        In px^2.
    centroids : (n, 2) array of float64
        Centre of mass; the site itself where there is none.
    """

    masses: npt.NDArray[np.float64]
    areas: npt.NDArray[np.float64]
    centroids: npt.NDArray[np.float64]


@dataclass(frozen=True)
class Runs:
    """Samples by owner: every row of samples is cut wherever the owner changes.

    Parameters
    ----------
    owners : (m,) array of intp
        The number of the site that owns a run.
    rows, begins, ends : (m,) array of intp
        Where it lies: in a row of samples, from a column to before another.
    """

    owners: npt.NDArray[np.intp]
    rows: npt.NDArray[np.intp]
    begins: npt.NDArray[np.intp]
    ends: npt.NDArray[np.intp]

    def sum(self, values: npt.NDArray[np.floating[Any]] | npt.NDArray[np.intp], count: int) -> npt.NDArray[np.float64]:
        """Return the sums of the runs' values, (m,), for each of `count` owners; other owners' are left out."""
        return np.bincount(self.owners, values, count)[:count].astype(np.float64)


class Density:
    """A density over the canvas, constant within every pixel.

    Parameters
    ----------
    values : (height, width) array
        Mass a px^2, at least 0.
    expected_sites : int
        How many sites its cells are measured for, roughly: it chooses the grid of samples.
    """

    def __init__(self, values: npt.NDArray[np.floating[Any]], expected_sites: int) -> None:
        self.height, self.width = values.shape
        pixels = values.astype(np.float64)
        self.total = float(pixels.sum())
        wanted = math.ceil(math.sqrt(SAMPLES_PER_SITE * expected_sites / values.size))
        self.samples_per_pixel = max(1, min(wanted, MOST_SAMPLES_PER_PIXEL, math.isqrt(MOST_SAMPLES // values.size)))
        # Of every row of pixels, the mass and its moments about the left edge, cumulated; all its rows of samples are alike.
        mass = np.repeat(pixels, self.samples_per_pixel, axis=1) / self.samples_per_pixel**2
        x = (np.arange(mass.shape[1]) + 0.5) / self.samples_per_pixel
        self._cumulated = [np.pad(np.cumsum(mass * x**power, axis=1), ((0, 0), (1, 0))) for power in range(3)]

    def owners(self, sites: npt.NDArray[np.float64]) -> npt.NDArray[np.integer[Any]]:
        """Return the number of the nearest of the sites, (n, 2), for every sample."""
        return stages.owners(sites, self.width, self.height, self.samples_per_pixel)

    def runs(self, sites: npt.NDArray[np.float64]) -> Runs:
        """Return the samples by the nearest of the sites, (n, 2)."""
        owners = self.owners(sites)
        is_first = np.ones(owners.shape, bool)
        np.not_equal(owners[:, 1:], owners[:, :-1], out=is_first[:, 1:])
        first = np.flatnonzero(is_first)
        rows, begins = np.divmod(first, owners.shape[1])
        return Runs(owners.ravel()[first].astype(np.intp), rows, begins, begins + np.diff(first, append=owners.size))

    def cells(self, sites: npt.NDArray[np.float64], runs: Runs) -> Cells:
        """Measure the cells that runs belong to by their owners; runs whose owner is no site are left out."""
        count = len(sites)
        mass, moment = (self._between(power, runs) for power in range(2))
        masses = runs.sum(mass, count)
        moments = np.stack([runs.sum(moment, count), runs.sum(mass * self._y(runs), count)], axis=1)
        has_mass = (masses > 0)[:, np.newaxis]
        centroids = np.where(has_mass, moments / np.where(has_mass, masses[:, np.newaxis], 1), sites)
        return Cells(masses, runs.sum(runs.ends - runs.begins, count) / self.samples_per_pixel**2, centroids)

    def axes(self, cells: Cells, runs: Runs) -> npt.NDArray[np.float64]:
        """Return the unit vector along which each cell's mass is spread most, (n, 2)."""
        count = len(cells.masses)
        mass, moment, second = (self._between(power, runs) for power in range(3))
        x, y = cells.centroids[runs.owners].T
        down = self._y(runs) - y
        along_x = runs.sum(second - 2 * x * moment + x * x * mass, count)
        along_y = runs.sum(mass * down * down, count)
        mixed = runs.sum((moment - x * mass) * down, count)
        angle = np.arctan2(2 * mixed, along_x - along_y) / 2
        return np.stack([np.cos(angle), np.sin(angle)], axis=1)

    def _between(self, power: int, runs: Runs) -> npt.NDArray[np.float64]:
        """Return the sum of mass * x**power over every run, (m,)."""
        cumulated = self._cumulated[power].ravel()
        left = runs.rows // self.samples_per_pixel * self._cumulated[power].shape[1]
        between: npt.NDArray[np.float64] = cumulated[left + runs.ends] - cumulated[left + runs.begins]
        return between

    def _y(self, runs: Runs) -> npt.NDArray[np.float64]:
        return (runs.rows + 0.5) / self.samples_per_pixel


def draw_points(density: npt.NDArray[np.floating[Any]], count: int, generator: np.random.Generator) -> npt.NDArray[np.float64]:
    """Return points as dense as a density, (height, width): one at random from each of as many parts of equal mass.

    The parts lie in the order of a Z-order curve over the pixels, so most of them hold together, and the points are spread far more
    evenly than independent ones, whose clumps Lloyd steps do not smooth out.

    Returns
    -------
    ndarray of float64, (count, 2)
        In the order of the curve; none if the density is 0 everywhere.
    """
    height, width = density.shape
    order = np.argsort(z_order(*np.mgrid[:height, :width].reshape(2, -1)))
    cumulated = np.cumsum(density.ravel()[order], dtype=np.float64)
    if cumulated[-1] == 0:
        return np.empty((0, 2))
    places = (np.arange(count) + generator.random(count)) / count * cumulated[-1]
    # By rounding, the last place may lie behind the last pixel that has mass.
    last = np.searchsorted(cumulated, cumulated[-1])
    row, column = np.divmod(order[np.minimum(np.searchsorted(cumulated, places, side="right"), last)], width)
    return np.stack([column, row], axis=1) + generator.random((count, 2))


def z_order(row: npt.NDArray[np.int64], column: npt.NDArray[np.int64]) -> npt.NDArray[np.int64]:
    """Return the place on a Z-order curve: the bits of row and column in turn (Morton 1966)."""
    place = np.zeros_like(row)
    for bit in range(31):
        place |= (column >> bit & 1) << (2 * bit) | (row >> bit & 1) << (2 * bit + 1)
    return place
