"""Structure-preserving stippling (Li and Mould 2011): error diffusion that takes the most extreme pixels first.

Pixels are taken in the order of their distance from middle grey, by their current values. One that is dark becomes a dot, one that
is light stays paper, and the error is spread over the pixels nearby that are still open: weights fall with distance, and light
pixels take more of what makes lighter, dark pixels more of what makes darker, so that contrast grows and edges stay.

Readings of the paper, which is known here by its abstract, by that of the halftoning that it extends (Li and Mould 2010), and by a
public program after it:

- The weight of a pixel is its tone where the error is positive, 1 - tone where it is negative, over the square of its distance;
  tones are current ones, kept in [0, 1] for this. Weights add up to 1. Pixels farther than 3.5 are out of reach.
- A dot has the ink of one pixel of the grid. The paper's exponents, which shrink or exaggerate errors for larger dots and fewer of
  them, are not used: the tone is kept.
- Priorities go by the levels of a photo of 8 bits; ties by position, row by row.
- The paper takes the photo's pixels. Here the number of dots is given, so the grid is as coarse or fine as its darkness in pixels
  asks for, at most twice as fine as the photo, and the photo is resampled to it. The dots are drawn with areas that add up to
  the darkness; neighbours overlap a little, which loses ink.

The diffusion among the stages of the package takes nodes in the same order, but its weights know no sign of the error.
"""

from __future__ import annotations

import heapq
import math

import cv2
import numpy as np
import numpy.typing as npt

from graphstipple_eval.baselines.dots import check_dots, equal_black_dots, picture
from graphstipple_eval.method import Method, Photo, Picture

REACH = 3.5
"""Radius of the mask in pixels of the grid."""

LEVELS = 255
"""Steps of tone from black to white by which pixels are ordered. More cost time: a pixel that changes its level queues up again."""

LEAST_WEIGHT = 1e-3
"""Tone, or 1 - tone, that a weight has at least: with 0, error would be lost among pixels that are all black or all white."""

FINEST_GRID = 2.0
"""Pixels of the grid to one of the photo, along one axis, at most: finer ones only repeat it, and take longer."""


def diffuse(tone: npt.NDArray[np.float64]) -> npt.NDArray[np.bool_]:
    """Return which pixels of a grid become dots, (height, width)."""
    height, width = tone.shape
    margin = int(REACH)
    stride = width + 2 * margin
    reach = range(-margin, margin + 1)
    offsets = [
        (row * stride + column, 1 / (row**2 + column**2)) for row in reach for column in reach if 0 < row**2 + column**2 <= REACH**2
    ]
    # A frame of closed pixels around the grid.
    values = np.pad(tone.astype(np.float64), margin).ravel().tolist()
    is_open = np.pad(np.ones(tone.shape, bool), margin).ravel().tolist()
    levels = [round(abs(value - 0.5) * 2 * LEVELS) for value in values]
    size = len(values)
    queue = [-levels[place] * size + place for place in range(size) if is_open[place]]
    heapq.heapify(queue)
    is_dot = np.zeros(size, bool)
    while queue:
        key = heapq.heappop(queue)
        place = key % size
        if not is_open[place] or (key - place) // -size != levels[place]:
            # Done before, or its level has changed since.
            continue
        is_open[place] = False
        is_dot[place] = values[place] < 0.5
        error = values[place] - (0 if is_dot[place] else 1)
        weights = []
        for offset, nearness in offsets:
            other = place + offset
            if is_open[other]:
                share = values[other] if error > 0 else 1 - values[other]
                weights.append((other, nearness * min(max(share, LEAST_WEIGHT), 1.0)))
        total = sum(weight for _, weight in weights)
        for other, weight in weights:
            values[other] = changed = values[other] + error * weight / total
            level = round(abs(changed - 0.5) * 2 * LEVELS)
            if level != levels[other]:
                levels[other] = level
                heapq.heappush(queue, other - level * size)
    return is_dot.reshape(height + 2 * margin, stride)[margin:-margin, margin:-margin]


def stipple(photo: Photo, dots: int) -> Picture:
    """Return the picture of equal dots."""
    count = check_dots(dots)
    height, width = photo.tone.shape
    ink = float((1 - photo.tone.astype(np.float64)).sum())
    fineness = min(math.sqrt(count / ink), FINEST_GRID) if ink > 0 else 1.0
    columns, rows = (max(1, round(side * fineness)) for side in (width, height))
    grid = cv2.resize(photo.tone, (columns, rows), interpolation=cv2.INTER_AREA).astype(np.float64)
    dark_rows, dark_columns = np.nonzero(diffuse(grid))
    positions = (np.stack([dark_columns, dark_rows], axis=1) + 0.5) * [width / columns, height / rows]
    return picture(equal_black_dots(positions, ink), width, height, {"grid": [columns, rows]})


METHODS = (Method("sps", "Structure-preserving", "Li and Mould 2011", stipple, is_budgeted=True),)
