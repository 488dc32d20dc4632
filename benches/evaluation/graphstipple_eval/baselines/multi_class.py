"""Multi-class inverted stippling (Schulz et al. 2021): black dots for the darkness, white dots for the light, one canvas.

Two classes, black dots of density 1 - tone and white ones of density tone, are stippled by Linde-Buzo-Gray steps at once, each with
Voronoi cells of its own. They are coupled: by chance, a site goes not to the centroid of its own cell but to that of its cell among
the sites of both classes, so that black and white dots keep apart. Between the dots the ground is filled with the ink that is
denser there, so that dark areas become white dots on black.

Readings of the paper, after the program that its authors published:

- A dot's diameter grows with the mean density of its cell, from the least where it is 0 to twice that where it is 1; the program
  has 2 to 4 px at twice the photo's size. Here the number of dots is given, and the least diameter follows from it.
- A cell splits, or its site is lost, by the ink of its dot and the hysteresis of `linde_buzo_gray`. Each class begins with
  100 random sites.
- The chance of a coupled move is the class's mean density under the dot: dense classes make room for sparse ones.
- Cells go by the distance from the dots' centres, where the program takes their edges.
- Dots are painted in the order of falling mean density under them, so that sparse ones lie on top; that is the order in which
  the program blends the two dots nearest to a pixel.
- What no dot covers falls into connected areas (8 neighbours); each is filled with the ink of the class that is denser in it on
  average, white if they are equal.

The picture is painted with 64 samples a pixel, which gives what painting it at double size and halving gives. As an SVG, the black
ground between dots is paths under the dots.
"""

from __future__ import annotations

import cv2
import numpy as np
import numpy.typing as npt

from graphstipple_eval.baselines.density import Cells, Density
from graphstipple_eval.baselines.dots import (
    BLACK,
    SAMPLES_PER_PIXEL,
    WHITE,
    Dots,
    box_average,
    check_dots,
    circles,
    covered,
    paint,
    svg,
)
from graphstipple_eval.baselines.linde_buzo_gray import MOST_STEPS, SURPLUS, first_sites, hysteresis, next_sites
from graphstipple_eval.method import Counts, Method, Photo, Picture

SEED = 1
LARGEST_TO_LEAST = 2.0

UNCOVERED = 2
"""What a sample holds that no dot covers, beside the two inks."""

UNDER_SAMPLES = 2
"""Samples along one axis of a pixel by which the density under a dot is measured, as in the program. It only orders the dots and
gives a chance; four would take half of the time."""

OUTLINE_TOLERANCE = 1.0
"""How far the outline of the ground may lie from the samples, in samples: an eighth of a pixel, most of it under dots."""


def dot_areas(density: npt.NDArray[np.float64], least: float) -> npt.NDArray[np.float64]:
    """Return the areas of dots, px^2, in cells of these mean densities, for a least diameter in px."""
    return np.pi / 4 * (least * (1 + (LARGEST_TO_LEAST - 1) * density)) ** 2


def least_diameter(tone: npt.NDArray[np.float64], dots: int) -> float:
    """Return the least diameter in px for which the densities ask for this number of dots of both classes."""
    per_pixel = sum(density / dot_areas(density, 1.0) for density in (tone, 1 - tone))
    return float(np.sqrt(SURPLUS * np.sum(per_pixel) / dots))


def mean_under(
    values: npt.NDArray[np.float64], positions: npt.NDArray[np.float64], areas: npt.NDArray[np.float64]
) -> npt.NDArray[np.float64]:
    """Return the mean of a field, (height, width), under each of n discs, (n,)."""
    height, width = values.shape
    grid = (height * UNDER_SAMPLES, width * UNDER_SAMPLES)
    disc, sample = covered(positions, np.sqrt(areas / np.pi), grid, UNDER_SAMPLES)
    row, column = np.divmod(sample, grid[1])
    sums = np.bincount(disc, values[row // UNDER_SAMPLES, column // UNDER_SAMPLES], len(areas))
    counts = np.bincount(disc, minlength=len(areas))
    x, y = np.minimum(positions.astype(np.intp), [width - 1, height - 1]).T
    # A disc between the samples takes the value of its pixel.
    return np.where(counts > 0, sums / np.maximum(counts, 1), values[y, x])


def place(tone: npt.NDArray[np.float64], dots: int, least: float) -> tuple[Dots, int]:
    """Return the dots of both classes in painting order, for a least diameter in px, and the number of steps.

    `dots` is how many to expect; it chooses the grid of samples.
    """
    height, width = tone.shape
    fields = {ink: field for ink, field in ((BLACK, 1 - tone), (WHITE, tone)) if field.any()}
    # One grid for both, as fine as half of the dots need: a class has about as many.
    densities = {ink: Density(field, max(1, dots // 2)) for ink, field in fields.items()}
    generator = np.random.default_rng(SEED)
    sites = {ink: first_sites(width, height, generator) for ink in fields}
    changed, steps = True, 0
    while changed and steps < MOST_STEPS:
        together = densities[next(iter(fields))].owners(np.concatenate(list(sites.values())))
        changed, first = False, 0
        for ink, density in densities.items():
            of_class, count = sites[ink], len(sites[ink])
            owners = density.owners(of_class)
            cells = density.cells(of_class, owners)
            areas = dot_areas(mean_densities(cells), least)
            coupled = density.cells(of_class, np.where((together >= first) & (together < first + count), together - first, count))
            is_coupled = (generator.random(count) < mean_under(fields[ink], of_class, areas)) & (coupled.masses > 0)
            targets = np.where(is_coupled[:, np.newaxis], coupled.centroids, cells.centroids)
            sites[ink], class_changed = next_sites(density, owners, cells, targets, dot_areas=areas, hysteresis=hysteresis(steps))
            changed |= class_changed
            first += count
        steps += 1
    parts = []
    for ink, density in densities.items():
        areas = dot_areas(mean_densities(density.cells(sites[ink], density.owners(sites[ink]))), least)
        parts.append((sites[ink], areas, np.full(len(areas), ink, np.uint8), mean_under(fields[ink], sites[ink], areas)))
    positions, areas, inks, under = (np.concatenate(part) for part in zip(*parts, strict=True))
    order = np.argsort(-under, kind="stable")
    return Dots(positions[order], np.sqrt(areas[order] / np.pi), inks[order]), steps


def mean_densities(cells: Cells) -> npt.NDArray[np.float64]:
    """Return the mean density in every cell; 0 in one without samples."""
    return np.divide(cells.masses, cells.areas, out=np.zeros_like(cells.masses), where=cells.areas > 0)


def fill_ground(samples: npt.NDArray[np.uint8], tone: npt.NDArray[np.float64]) -> npt.NDArray[np.bool_]:
    """Give the uncovered samples an ink, in place, and return which of them became black."""
    uncovered = samples == UNCOVERED
    count, areas = cv2.connectedComponents(uncovered.astype(np.uint8), connectivity=8)
    of_sample = areas[uncovered]
    row, column = (place // SAMPLES_PER_PIXEL for place in np.nonzero(uncovered))
    tones = np.bincount(of_sample, tone[row, column], count) / np.maximum(np.bincount(of_sample, minlength=count), 1)
    samples[uncovered] = np.where(tones[of_sample] < 0.5, BLACK, WHITE)
    black: npt.NDArray[np.bool_] = uncovered & (samples == BLACK)
    return black


def outlines(ground: npt.NDArray[np.bool_]) -> list[npt.NDArray[np.float64]]:
    """Return the outlines of the black ground as rings of points in pixels, (n, 2), holes too."""
    # OpenCV's outlines run through the outermost samples' centres; a sample more all around lies under dots or outside the canvas.
    framed = cv2.copyMakeBorder(ground.astype(np.uint8), 1, 1, 1, 1, cv2.BORDER_REPLICATE)
    wider = cv2.dilate(framed, np.ones((3, 3), np.uint8))
    rings, _ = cv2.findContours(wider, cv2.RETR_CCOMP, cv2.CHAIN_APPROX_SIMPLE)
    rings = [cv2.approxPolyDP(ring, OUTLINE_TOLERANCE, closed=True)[:, 0] for ring in rings]
    return [(ring - 0.5) / SAMPLES_PER_PIXEL for ring in rings if len(ring) > 2]


def stipple(photo: Photo, dots: int) -> Picture:
    """Return the picture of black and white dots."""
    count = check_dots(dots)
    height, width = photo.tone.shape
    tone = photo.tone.astype(np.float64)
    least = least_diameter(tone, count)
    placed, steps = place(tone, count, least)
    samples = np.full((height * SAMPLES_PER_PIXEL, width * SAMPLES_PER_PIXEL), UNCOVERED, np.uint8)
    paint(placed, samples, SAMPLES_PER_PIXEL)
    rings = outlines(fill_ground(samples, tone))
    path = "".join("M" + " ".join(f"{x:.2f},{y:.2f}" for x, y in ring.tolist()) + "Z" for ring in rings)
    found = len(placed.radii)
    points = found + sum(map(len, rings))
    return Picture(
        raster=box_average(samples, SAMPLES_PER_PIXEL),
        counts=Counts(stipples=found, regions=len(rings), vertices=points, coordinates=points),
        svg=svg(f'<path fill-rule="evenodd" d="{path}"/>\n{circles(placed)}', width, height),
        settings={"seed": SEED, "steps": steps, "least_diameter": least, "largest_diameter": LARGEST_TO_LEAST * least},
    )


METHODS = (Method("mlbg", "Multi-class LBG, inverted", "Schulz et al. 2021", stipple, is_budgeted=True),)
