"""Multi-class inverted stippling (Schulz et al. 2021): black dots for the darkness, white dots for the light, one canvas.

Two classes, black dots of density 1 - tone and white ones of density tone, are stippled by Linde-Buzo-Gray steps at once, each with
Voronoi cells of its own. They are coupled: by chance, a site goes not to the centroid of its own cell but to that of its cell among
the sites of both classes, so that black and white dots keep apart. Between the dots the ground is filled with the ink that is
denser there, so that dark areas become white dots on black.

Readings of the paper, after the program that its authors published:

- A dot's diameter grows with the mean density of its cell, from the least where it is 0 to twice that where it is 1. The
  graph-stylization paper drew at twice the photo's size with 2 to 4 px, that is 1 to 2 px of the photo; the example of the authors'
  program has 2 to 4 px of the photo. `mlbg` draws the former. Its dots are as many as the densities ask for.
- A cell splits, or its site is lost, by the ink of its dot and the hysteresis of `linde_buzo_gray`. Each class begins with
  100 random sites, or as many as it is expected to have if these are fewer.
- The sites of a split lie half the radius of a disc of the cell's area to either side of its centroid; the program has half the
  diameter of the stipple.
- The mean density is the plain average over the cell; the program's default leaves a cell's empty area out of it, from 20 to 30 %
  of the cell on.
- The chance of a coupled move is the class's mean density under the dot: dense classes make room for sparse ones. It is taken over
  the whole disc; the program takes what the stipple shares with its own cell.
- There are at most 50 steps, and none after one that splits and removes nothing. By default, the program goes on until nothing
  splits or vanishes and the mean squared error changes by less than 0.1 %.
- Cells go by the distance from the dots' centres, where the program takes their edges.
- Dots are painted in the order of falling mean density under them, so that sparse ones lie on top; that is the order in which
  the program blends the two dots nearest to a pixel.
- What no dot covers falls into connected areas (8 neighbours); each is filled with the ink of the class that is denser in it on
  average, white if they are equal.

What is written: under the dots lies black, as paths, wherever black ground is nearer than white; of the dots, only those that
change something when they are painted over that, in order. They are about half of all: black dots on black and white ones on
white are left out. The raster paints the same with 64 samples a pixel, which is nearly what painting it at double size and
halving gives.

`mlbg-equal` writes about as many coordinates as the budget has, points of the black ground included. It chooses the least
diameter: the picture is drawn, the number of dots corrected by the share of coordinates that it wrote, and drawn again, as long
as it is off by more than 4 %; the nearest is kept. Its time is that of all draws.
"""

from __future__ import annotations

import math
from dataclasses import replace

import cv2
import numpy as np
import numpy.typing as npt

from graphstipple_eval.baselines.density import Cells, Density
from graphstipple_eval.baselines.dots import (
    BLACK,
    SAMPLES_PER_PIXEL,
    WHITE,
    Dots,
    bands,
    box_average,
    check_dots,
    circles,
    covered,
    paint,
    svg,
)
from graphstipple_eval.baselines.linde_buzo_gray import MOST_STEPS, SURPLUS, first_sites, hysteresis, next_sites
from graphstipple_eval.method import Counts, Method, Photo, Picture

SOURCE = "Schulz et al. 2021"

SEED = 1
LEAST_DIAMETER = 1.0
"""In pixels of the photo, as the graph-stylization paper has it."""

LARGEST_TO_LEAST = 2.0

COORDINATES_PER_DOT = 0.52
"""Coordinates written for every dot placed, on photos: a first guess, which the first draw corrects."""

BUDGET_TOLERANCE = 0.04
"""How far from the budget the coordinates may end, as a share: a draw more takes as long as the first."""

MOST_DRAWS = 5
"""Draws to come so near: photos need one or two, a few hundred dots up to five; for a handful, or one ink alone, none may do."""

LARGEST_CORRECTION = 4.0
"""How many times the dots of the first draw may be placed: where next to nothing shows, the number would grow beyond measure."""

UNDER_SAMPLES = 2
"""Samples along one axis of a pixel by which the density under a dot is measured, as in the program. It only orders the dots and
gives a chance; four would take half of the time."""

OUTLINE_TOLERANCE = 0.5
"""How far the outline of black may lie from where it belongs, in least diameters: it lies under dots, where nothing shows."""

LARGEST_TOLERANCE = 1 / 8
"""The same in shorter sides of the canvas, at most: an outline as large as the canvas must not shrink to a line."""


def dot_areas(density: npt.NDArray[np.float64], least: float) -> npt.NDArray[np.float64]:
    """Return the areas of dots, px^2, in cells of these mean densities, for a least diameter in px."""
    return np.pi / 4 * (least * (1 + (LARGEST_TO_LEAST - 1) * density)) ** 2


def expected_dots(tone: npt.NDArray[np.float64], least: float) -> float:
    """Return how many dots of both classes the densities ask for, for a least diameter in px."""
    return SURPLUS * float(sum((density / dot_areas(density, least)).sum() for density in (tone, 1 - tone)))


def mean_under(
    values: npt.NDArray[np.float64], positions: npt.NDArray[np.float64], areas: npt.NDArray[np.float64]
) -> npt.NDArray[np.float64]:
    """Return the mean of a field, (height, width), under each of n discs, (n,)."""
    height, width = values.shape
    grid = (height * UNDER_SAMPLES, width * UNDER_SAMPLES)
    sums, counts = np.zeros(len(areas)), np.zeros(len(areas), np.intp)
    for disc, sample in covered(positions, np.sqrt(areas / np.pi), grid, UNDER_SAMPLES):
        row, column = np.divmod(sample, grid[1])
        sums += np.bincount(disc, values[row // UNDER_SAMPLES, column // UNDER_SAMPLES], len(areas))
        counts += np.bincount(disc, minlength=len(areas))
    x, y = np.minimum(positions.astype(np.intp), [width - 1, height - 1]).T
    # A disc between the samples takes the value of its pixel.
    return np.where(counts > 0, sums / np.maximum(counts, 1), values[y, x])


def place(tone: npt.NDArray[np.float64], least: float) -> tuple[Dots, int]:
    """Return the dots of both classes in painting order, for a least diameter in px, and the number of steps."""
    height, width = tone.shape
    fields = {ink: field for ink, field in ((BLACK, 1 - tone), (WHITE, tone)) if field.any()}
    # One grid for both, as fine as half of the dots need: a class has about as many.
    each = math.ceil(expected_dots(tone, least) / 2)
    densities = {ink: Density(field, each) for ink, field in fields.items()}
    generator = np.random.default_rng(SEED)
    sites = {ink: first_sites(width, height, each, generator) for ink in fields}
    changed, steps = True, 0
    while changed and steps < MOST_STEPS:
        together = densities[next(iter(fields))].runs(np.concatenate(list(sites.values())))
        changed, first = False, 0
        for ink, density in densities.items():
            of_class, count = sites[ink], len(sites[ink])
            runs = density.runs(of_class)
            cells = density.cells(of_class, runs)
            areas = dot_areas(mean_densities(cells), least)
            is_own = (together.owners >= first) & (together.owners < first + count)
            coupled = density.cells(of_class, replace(together, owners=np.where(is_own, together.owners - first, count)))
            is_coupled = (generator.random(count) < mean_under(fields[ink], of_class, areas)) & (coupled.masses > 0)
            targets = np.where(is_coupled[:, np.newaxis], coupled.centroids, cells.centroids)
            sites[ink], class_changed = next_sites(density, runs, cells, targets, dot_areas=areas, hysteresis=hysteresis(steps))
            changed |= class_changed
            first += count
        steps += 1
    parts = []
    for ink, density in densities.items():
        areas = dot_areas(mean_densities(density.cells(sites[ink], density.runs(sites[ink]))), least)
        parts.append((sites[ink], areas, np.full(len(areas), ink, np.uint8), mean_under(fields[ink], sites[ink], areas)))
    positions, areas, inks, under = (np.concatenate(part) for part in zip(*parts, strict=True))
    order = np.argsort(-under, kind="stable")
    return Dots(positions[order], np.sqrt(areas[order] / np.pi), inks[order]), steps


def mean_densities(cells: Cells) -> npt.NDArray[np.float64]:
    """Return the mean density in every cell; 0 in one without samples."""
    return np.divide(cells.masses, cells.areas, out=np.zeros_like(cells.masses), where=cells.areas > 0)


def black_ground(dots: Dots, tone: npt.NDArray[np.float64]) -> npt.NDArray[np.bool_]:
    """Return the samples that lie nearer to black ground than to white, (height * s, width * s): what is black under the dots."""
    height, width = (side * SAMPLES_PER_PIXEL for side in tone.shape)
    is_covered = np.zeros((height, width), np.uint8)
    paint(replace(dots, inks=np.ones_like(dots.inks)), is_covered, SAMPLES_PER_PIXEL)
    # The nearest area between the dots (8 neighbours), numbered from 1, of every sample.
    areas = cv2.distanceTransformWithLabels(is_covered, cv2.DIST_L2, cv2.DIST_MASK_5, labelType=cv2.DIST_LABEL_CCOMP)[1]
    count = int(areas.max()) + 1
    sums, sizes = np.zeros(count), np.zeros(count)
    for begin, end in bands(tone.shape[0], SAMPLES_PER_PIXEL * width):
        band = slice(begin * SAMPLES_PER_PIXEL, end * SAMPLES_PER_PIXEL)
        row, column = np.nonzero(is_covered[band] == 0)
        area = areas[band][row, column]
        sums += np.bincount(area, tone[begin + row // SAMPLES_PER_PIXEL, column // SAMPLES_PER_PIXEL], count)
        sizes += np.bincount(area, minlength=count)
    is_black = sums < 0.5 * sizes
    black: npt.NDArray[np.bool_] = is_black[areas]
    return black


def outlines(black: npt.NDArray[np.bool_], tolerance: float) -> tuple[list[npt.NDArray[np.int32]], int]:
    """Return rings around black samples, holes too, simplified to a tolerance in samples, and how many of them are no holes.

    A ring, (n, 1, 2), has columns and rows of samples.
    """
    # Outlines run through the outermost samples' centres: by the frame, those at the edge run outside the canvas.
    framed = cv2.copyMakeBorder(black.astype(np.uint8), 1, 1, 1, 1, cv2.BORDER_REPLICATE)
    found, hierarchy = cv2.findContours(framed, cv2.RETR_CCOMP, cv2.CHAIN_APPROX_SIMPLE, offset=(-1, -1))
    simple = [cv2.approxPolyDP(ring, tolerance, closed=True) for ring in found]
    kept = [number for number, ring in enumerate(simple) if len(ring) > 2]
    return [simple[number].astype(np.int32) for number in kept], sum(int(hierarchy[0, number, 3]) < 0 for number in kept)


def paint_what_shows(dots: Dots, samples: npt.NDArray[np.uint8]) -> Dots:
    """Paint the dots onto samples, in place, and return those that changed any."""
    flat = samples.reshape(-1)
    shows = np.zeros(len(dots.radii), bool)
    for discs, indices in covered(dots.positions, dots.radii, samples.shape, SAMPLES_PER_PIXEL):
        begins = np.flatnonzero(np.diff(discs, prepend=-1))
        for disc, index in zip(discs[begins].tolist(), np.split(indices, begins)[1:], strict=True):
            ink = dots.inks[disc]
            if (flat[index] != ink).any():
                flat[index] = ink
                shows[disc] = True
    return Dots(dots.positions[shows], dots.radii[shows], dots.inks[shows])


def draw(tone: npt.NDArray[np.float64], least: float) -> Picture:
    """Return the picture of black and white dots for a least diameter in px."""
    height, width = tone.shape
    placed, steps = place(tone, least)
    tolerance = min(OUTLINE_TOLERANCE * least, LARGEST_TOLERANCE * min(tone.shape)) * SAMPLES_PER_PIXEL
    rings, regions = outlines(black_ground(placed, tone), tolerance)
    samples = np.full((height * SAMPLES_PER_PIXEL, width * SAMPLES_PER_PIXEL), WHITE, np.uint8)
    cv2.fillPoly(samples, rings, BLACK)
    shown = paint_what_shows(placed, samples)
    path = "".join(
        "M" + " ".join(f"{x:.2f},{y:.2f}" for x, y in ((ring[:, 0] + 0.5) / SAMPLES_PER_PIXEL).tolist()) + "Z" for ring in rings
    )
    stipples = len(shown.radii)
    return Picture(
        raster=box_average(samples, SAMPLES_PER_PIXEL),
        counts=Counts(stipples=stipples, regions=regions, coordinates=stipples + sum(map(len, rings))),
        svg=svg(f'<path fill-rule="evenodd" d="{path}"/>\n{circles(shown)}', width, height),
        settings={"seed": SEED, "steps": steps, "least_diameter": least, "largest_diameter": LARGEST_TO_LEAST * least},
        dots=shown.table(),
    )


def stipple(photo: Photo, dots: int) -> Picture:
    """Return the picture with the sizes of the graph-stylization paper, however many dots that takes."""
    return draw(photo.tone.astype(np.float64), LEAST_DIAMETER)


def stipple_equal(photo: Photo, dots: int) -> Picture:
    """Return the picture that writes about as many coordinates as dots are asked for, as near as `MOST_DRAWS` come to it."""
    wanted = check_dots(dots)
    tone = photo.tone.astype(np.float64)
    expected = wanted / COORDINATES_PER_DOT
    most, draws, off = LARGEST_CORRECTION * expected, 0, math.inf
    while off > BUDGET_TOLERANCE and draws < MOST_DRAWS:
        drawn = draw(tone, math.sqrt(expected_dots(tone, 1.0) / expected))
        draws += 1
        written = drawn.counts.coordinates or 0
        if abs(written / wanted - 1) < off:
            off, best = abs(written / wanted - 1), drawn
        if expected == most and written < wanted:
            break
        expected = min(expected * wanted / max(written, 1), most)
    settings = {**best.settings, "draws": draws}
    if off > BUDGET_TOLERANCE:
        settings["note"] = f"{best.counts.coordinates:,} coordinates instead of {wanted:,}, the nearest of {draws} draws"
    return replace(best, settings=settings)


METHODS = (
    Method("mlbg", "Multi-class LBG, 2 to 4 px at double size", SOURCE, stipple),
    Method("mlbg-equal", "Multi-class LBG, equal budget", SOURCE, stipple_equal, is_budgeted=True),
)
