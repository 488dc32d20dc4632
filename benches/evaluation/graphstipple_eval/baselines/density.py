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
"""Samples of a grid, at most, unless there are more pixels: half a gigabyte while cells are measured."""


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


class Density:
    """A density over the canvas, constant within every pixel.

    Parameters
    ----------
    values : (height, width) array
        Mass a px^2, at least 0.
    sites : int
        How many sites its cells are measured for, roughly: it chooses the grid of samples.
    """

    def __init__(self, values: npt.NDArray[np.floating[Any]], sites: int) -> None:
        self.height, self.width = values.shape
        pixels = values.astype(np.float64)
        self.total = float(pixels.sum())
        wanted = math.ceil(math.sqrt(SAMPLES_PER_SITE * sites / values.size))
        self.samples_per_pixel = max(1, min(wanted, MOST_SAMPLES_PER_PIXEL, math.isqrt(MOST_SAMPLES // values.size)))
        samples = np.repeat(np.repeat(pixels, self.samples_per_pixel, axis=0), self.samples_per_pixel, axis=1)
        rows, columns = samples.shape
        self._mass = samples.ravel() / self.samples_per_pixel**2
        self._x = np.tile((np.arange(columns) + 0.5) / self.samples_per_pixel, rows)
        self._y = np.repeat((np.arange(rows) + 0.5) / self.samples_per_pixel, columns)
        self._moments = self._mass * self._x, self._mass * self._y

    def owners(self, sites: npt.NDArray[np.float64]) -> npt.NDArray[np.intp]:
        """Return the nearest of the sites, (n, 2), of every sample."""
        return stages.owners(sites, self.width, self.height, self.samples_per_pixel).ravel().astype(np.intp)

    def cells(self, sites: npt.NDArray[np.float64], owners: npt.NDArray[np.intp]) -> Cells:
        """Measure the cells that samples belong to by `owners`; samples whose owner is no site are left out."""
        masses = self._sum(self._mass, sites, owners)
        moments = np.stack([self._sum(moment, sites, owners) for moment in self._moments], axis=1)
        has_mass = (masses > 0)[:, np.newaxis]
        centroids = np.where(has_mass, moments / np.where(has_mass, masses[:, np.newaxis], 1), sites)
        areas = np.bincount(owners, minlength=len(sites))[: len(sites)] / self.samples_per_pixel**2
        return Cells(masses, areas, centroids)

    def axes(self, cells: Cells, owners: npt.NDArray[np.intp], chosen: npt.NDArray[np.bool_]) -> npt.NDArray[np.float64]:
        """Return the unit vector along which the mass is spread most, (m, 2), of the chosen cells, (n,)."""
        samples = np.flatnonzero(chosen[owners])
        cell = (np.cumsum(chosen) - 1)[owners[samples]]
        centroids = cells.centroids[chosen]
        x, y = self._x[samples] - centroids[cell, 0], self._y[samples] - centroids[cell, 1]
        mass = self._mass[samples]
        along_x, along_y, mixed = (np.bincount(cell, mass * moment, len(centroids)) for moment in (x * x, y * y, x * y))
        angle = np.arctan2(2 * mixed, along_x - along_y) / 2
        return np.stack([np.cos(angle), np.sin(angle)], axis=1)

    @staticmethod
    def _sum(
        values: npt.NDArray[np.float64], sites: npt.NDArray[np.float64], owners: npt.NDArray[np.intp]
    ) -> npt.NDArray[np.float64]:
        return np.bincount(owners, values, len(sites))[: len(sites)].astype(np.float64)


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
