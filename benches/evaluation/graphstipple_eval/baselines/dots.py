"""Dots on a canvas: where they lie, how large they are, and how they become a picture.

Every stippling method ends here, so that all are painted alike: the raster is the share of every pixel that is white, by hard
samples, so that dots that overlap count once; the SVG holds the same dots in the same order.
"""

from __future__ import annotations

import math
import operator
from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from graphstipple import InvalidInputError
from graphstipple_eval.method import Counts, Picture

BLACK, WHITE = 0, 1

SAMPLES_PER_PIXEL = 8
"""Samples of a painted picture along one axis of a pixel: 65 greys. Half as many make the ink of a small dot vary more than twice
as much with its place; twice as many take four times the memory."""

SAMPLES_AT_ONCE = 1 << 20
"""Samples of dots that are listed at once, and twice that at most: about 60 MB. More are no faster."""

FRAME_MARGIN = 1e-3
"""How far inside the canvas a position is kept, in pixels: the least that `graphstipple.stages` allows."""


@dataclass(frozen=True)
class Dots:
    """Discs of one ink or two, painted in order.

    Parameters
    ----------
    positions : (n, 2) array of float64
        Centres as x, y in pixels.
    radii : (n,) array of float64
        In pixels.
    inks : (n,) array of uint8
        0 black, 1 white.
    """

    positions: npt.NDArray[np.float64]
    radii: npt.NDArray[np.float64]
    inks: npt.NDArray[np.uint8]

    def table(self) -> npt.NDArray[np.float64]:
        """Return x, y and ink of every dot, (n, 3), for `Picture`."""
        return np.column_stack([self.positions, self.inks])


def check_dots(dots: int) -> int:
    """Return the number of dots that is asked for.

    Raises
    ------
    InvalidInputError
        If it is no whole number of at least 1.
    """
    try:
        count = operator.index(dots)
    except TypeError:
        count = 0
    if count < 1:
        raise InvalidInputError(f"dots is {dots!r}, but it must be a whole number of at least 1")
    return count


def keep_inside(positions: npt.NDArray[np.float64], width: int, height: int) -> npt.NDArray[np.float64]:
    """Return (n, 2) positions, moved to inside the canvas where they are not."""
    return np.clip(positions, FRAME_MARGIN, np.array([width, height]) - FRAME_MARGIN)


def equal_black_dots(positions: npt.NDArray[np.float64], ink: float) -> Dots:
    """Return equal black discs whose areas add up to `ink` px^2."""
    count = len(positions)
    radius = np.sqrt(ink / (np.pi * max(count, 1)))
    return Dots(positions, np.full(count, radius), np.full(count, BLACK, np.uint8))


def paint(dots: Dots, samples: npt.NDArray[np.uint8], samples_per_pixel: int) -> None:
    """Paint dots onto samples, later ones over earlier ones; what lies outside is left out.

    Parameters
    ----------
    dots : Dots
        In pixels.
    samples : (height * s, width * s) array of uint8
        Inks, changed in place. Sample (column, row) lies at ((column + offset(row)) / s, (row + 0.5) / s), see `sample_offsets`.
    samples_per_pixel : int
        The s above.
    """
    flat = samples.reshape(-1)
    for disc, index in covered(dots.positions, dots.radii, samples.shape, samples_per_pixel):
        # NumPy assigns in order, so the last dot that covers a sample gives it its ink.
        flat[index] = dots.inks[disc]


def picture(dots: Dots, width: int, height: int, settings: dict[str, object]) -> Picture:
    """Return what black and white dots on white paper look like; `settings` goes into it unchanged."""
    samples = np.full((height * SAMPLES_PER_PIXEL, width * SAMPLES_PER_PIXEL), WHITE, np.uint8)
    paint(dots, samples, SAMPLES_PER_PIXEL)
    count = len(dots.radii)
    return Picture(
        raster=box_average(samples, SAMPLES_PER_PIXEL),
        counts=Counts(stipples=count, regions=0, vertices=count, coordinates=count),
        svg=svg(circles(dots), width, height),
        settings=settings,
        dots=dots.table(),
    )


def box_average(samples: npt.NDArray[np.uint8], samples_per_pixel: int) -> npt.NDArray[np.float32]:
    """Return the mean of every pixel's samples, (height, width)."""
    height, width = (side // samples_per_pixel for side in samples.shape)
    rows = samples.reshape(height, samples_per_pixel, width * samples_per_pixel).sum(axis=1, dtype=np.uint16)
    sums = rows.reshape(height, width, samples_per_pixel).sum(axis=2, dtype=np.uint16)
    means: npt.NDArray[np.float32] = (sums / samples_per_pixel**2).astype(np.float32)
    return means


def circles(dots: Dots) -> str:
    """Return SVG circles in painting order, to a hundredth of a pixel; black is what they are by default."""
    fill = {BLACK: "", WHITE: ' fill="#fff"'}
    marks = zip(dots.positions.tolist(), dots.radii.tolist(), dots.inks.tolist(), strict=True)
    return "\n".join(f'<circle cx="{x:.2f}" cy="{y:.2f}" r="{radius:.4g}"{fill[ink]}/>' for (x, y), radius, ink in marks)


def svg(marks: str, width: int, height: int) -> str:
    """Return an SVG document of marks that are black by default, on white paper, of `width` x `height` pixels."""
    return (
        f'<svg xmlns="http://www.w3.org/2000/svg" width="{width}" height="{height}" viewBox="0 0 {width} {height}">\n'
        f'<rect width="{width}" height="{height}" fill="#fff"/>\n{marks}\n</svg>\n'
    )


def sample_offsets(rows: int) -> npt.NDArray[np.float64]:
    """Return how far to the right of its cell's left edge every sample of a row lies, in samples, (rows,).

    Multiples of the golden ratio: on a plain square grid, a small disc in the middle of a pixel would win or lose a tenth of its
    ink, and so would all like it.
    """
    multiples = np.arange(rows, dtype=np.float64) * (math.sqrt(5) - 1) / 2
    return multiples - np.floor(multiples)


def bands(rows: int, samples_per_row: int) -> list[tuple[int, int]]:
    """Return begin and end of bands of rows that hold at most `SAMPLES_AT_ONCE` samples each, but at least a row."""
    step = max(1, SAMPLES_AT_ONCE // samples_per_row)
    return [(begin, min(begin + step, rows)) for begin in range(0, rows, step)]


def covered(
    positions: npt.NDArray[np.float64], radii: npt.NDArray[np.float64], shape: tuple[int, ...], samples_per_pixel: int
) -> Iterator[tuple[npt.NDArray[np.intp], npt.NDArray[np.int64]]]:
    """Yield every sample in every disc, in parts of bounded size: the number of the disc and the flat index of the sample.

    The parts go through the grid in bands of rows, and through each band disc by disc: of all discs that cover a sample, the later
    ones come later.

    Parameters
    ----------
    positions, radii
        Of n discs, as in `Dots`.
    shape : (int, int)
        Height and width of the grid of samples.
    samples_per_pixel : int
        As for `paint`.
    """
    height, width = shape
    x, y = (positions * samples_per_pixel).T
    y = y - 0.5
    radius = radii * samples_per_pixel
    side = 2 * np.ceil(radius) + 1
    offsets = sample_offsets(height)
    for begin, end in bands(height, width):
        reaching = np.flatnonzero((y + radius >= begin) & (y - radius < end))
        boxes = np.minimum(side[reaching], width) * np.minimum(side[reaching], end - begin)
        for first, last in _runs((np.cumsum(boxes) // SAMPLES_AT_ONCE).astype(np.int64)):
            discs = reaching[first:last]
            top = np.clip(np.ceil(y[discs] - radius[discs]), begin, end).astype(np.int64)
            rows = np.clip(np.floor(y[discs] + radius[discs]) + 1, top, end).astype(np.int64) - top
            number, row = _ranges(top, rows)
            disc = discs[number]
            half = np.sqrt(np.maximum(radius[disc] ** 2 - (row - y[disc]) ** 2, 0))
            middle = x[disc] - offsets[row]
            left = np.clip(np.ceil(middle - half), 0, width).astype(np.int64)
            columns = np.clip(np.floor(middle + half) + 1, left, width).astype(np.int64) - left
            span, column = _ranges(left, columns)
            yield disc[span], row[span] * width + column


def _runs(values: npt.NDArray[np.int64]) -> list[tuple[int, int]]:
    """Return begin and end of every run of equal values."""
    if not len(values):
        return []
    ends = [*(np.flatnonzero(np.diff(values)) + 1).tolist(), len(values)]
    return list(zip([0, *ends[:-1]], ends, strict=True))


def _ranges(begin: npt.NDArray[np.int64], count: npt.NDArray[np.int64]) -> tuple[npt.NDArray[np.int64], npt.NDArray[np.int64]]:
    """Return the ranges `begin[i]` to `begin[i] + count[i]` end to end, and the i of every element before them."""
    number = np.repeat(np.arange(len(count)), count)
    return number, np.arange(len(number)) - np.repeat(np.cumsum(count) - count, count) + begin[number]
