"""Structure-preserving stippling (Li and Mould 2011): error diffusion that takes the most extreme pixels first.

Pixels are taken in the order of their distance from middle grey, by their current values. One that is dark becomes a dot, one that
is light stays paper, and the error is spread over the pixels nearby that are still open: weights fall with distance, and light
pixels take more of what makes lighter, dark pixels more of what makes darker, so that contrast grows and edges stay. Before that,
the error is scaled: what dots leave behind is exaggerated and what paper leaves is shrunk, so that a dot stands for more than its
pixel, and few dots still show the structure.

Readings of the paper, which is known here by its abstract, by that of the halftoning that it extends (Li and Mould 2010), and by a
public program after it:

- The weight of a pixel is its tone where the error is positive, 1 - tone where it is negative, over the square of its distance.
  Weights add up to 1. Pixels farther than 3.5 are out of reach.
- Positive errors, those of dots, are multiplied by a scale, negative ones divided by it; then values are kept between 1/255 and
  254/255. The program has the dot's radius to a power for it. Here the number of dots is given, and the scale is searched for that
  gives it within 1 %, or as near as it comes; at a scale of 1 the tone is kept. The little error that the program adds for dots
  larger than a pixel is left out.
- A pixel is taken as soon as none in the square of 7 x 7 pixels around it is more extreme, so that many are taken at once, where
  the program takes one after the other from the whole photo. At a scale of 1 that makes a tenth of a percent of the dots.
- Priorities go by the levels of a photo of 8 bits; ties are random.
- The pixels are the photo's own. Only if even the largest scale leaves too many dots, the photo is halved until it does not.
- All dots have one size, so that their areas add up to the darkness; where they overlap, ink is lost.

The diffusion among the stages of the package takes nodes in the same order, but its weights know no sign of the error.
"""

from __future__ import annotations

import math

import cv2
import numpy as np
import numpy.typing as npt

from graphstipple_eval.baselines.dots import check_dots, equal_black_dots, picture
from graphstipple_eval.method import Method, Photo, Picture

SEED = 1

REACH = 3.5
"""Radius of the mask in pixels."""

LEVELS = 255
"""Steps of tone from black to white by which pixels are ordered."""

LEAST_WEIGHT = 1e-3
"""Tone, or 1 - tone, that a weight has at least: with 0, error would be lost among pixels that are all black or all white."""

LARGEST_LOG_SCALE = 4.0
"""Natural logarithm of the scale of errors, at most, and its negative at least: one pixel in 10 to 20 becomes a dot, and nearly all
do. Beyond, hardly anything changes, as values have bounds."""

TOLERANCE = 0.01
"""How far from the number of dots a search may end, as a share."""

MOST_RUNS = 10
"""Diffusions of a search, at most; photos need about four."""


def diffuse(tone: npt.NDArray[np.float64], log_scale: float) -> npt.NDArray[np.bool_]:
    """Return which pixels become dots, (height, width), for the natural logarithm of the scale of errors."""
    margin = int(REACH)
    stride = tone.shape[1] + 2 * margin
    row, column = np.mgrid[-margin : margin + 1, -margin : margin + 1].reshape(2, -1)
    square = row**2 + column**2
    is_near = (square > 0) & (square <= REACH**2)
    offsets, nearness = (row * stride + column)[is_near], 1 / square[is_near]
    # A frame of closed pixels around the photo.
    values = np.pad(tone, margin).ravel()
    is_open = np.pad(np.ones(tone.shape, bool), margin).ravel()
    ties = np.random.default_rng(SEED).permutation(values.size) / values.size
    priorities = np.where(is_open, priority(values) + ties, -1.0).astype(np.float32)
    window = np.ones((2 * margin + 1, 2 * margin + 1), np.uint8)
    is_dot = np.zeros(values.size, bool)
    while is_open.any():
        highest = cv2.dilate(priorities.reshape(-1, stride), window).ravel()
        taken = np.flatnonzero(is_open & (priorities == highest))
        is_open[taken], priorities[taken] = False, -1
        dark = values[taken] < 0.5
        is_dot[taken] = dark
        errors = np.where(dark, values[taken] * math.exp(log_scale), (values[taken] - 1) * math.exp(-log_scale))
        near = taken[:, np.newaxis] + offsets
        reached = is_open[near]
        shares = np.where(dark[:, np.newaxis], values[near], 1 - values[near])
        weights = np.where(reached, nearness * np.clip(shares, LEAST_WEIGHT, 1), 0)
        totals = np.maximum(weights.sum(axis=1), LEAST_WEIGHT / REACH**2)
        changed = near[reached]
        np.add.at(values, changed, (weights * (errors / totals)[:, np.newaxis])[reached])
        values[changed] = np.clip(values[changed], 1 / LEVELS, 1 - 1 / LEVELS)
        priorities[changed] = priority(values[changed]) + ties[changed]
    return is_dot.reshape(-1, stride)[margin:-margin, margin:-margin]


def priority(values: npt.NDArray[np.float64]) -> npt.NDArray[np.float64]:
    """Return the distance from middle grey, (n,), in whole levels."""
    levels: npt.NDArray[np.float64] = np.rint(np.abs(values - 0.5) * 2 * LEVELS)
    return levels


def search(tone: npt.NDArray[np.float64], dots: int) -> tuple[npt.NDArray[np.bool_], float]:
    """Return which pixels become dots, about so many or as near as it comes, and the logarithm of the scale that gives that.

    The first run is at the end of the scale on whose side the number lies; the next ones are at the interpolated place.
    """
    # More dots need smaller scales; a scale of 1 gives as many as the darkness in pixels.
    ink = float((1 - tone).sum())
    log_scale = math.copysign(LARGEST_LOG_SCALE, ink - dots)
    known = {0.0: math.log(ink)}
    best, best_scale, off = np.zeros(tone.shape, bool), 0.0, math.inf
    for run in range(MOST_RUNS):
        is_dot = diffuse(tone, log_scale)
        found = int(is_dot.sum())
        if abs(found - dots) < off:
            best, best_scale, off = is_dot, log_scale, abs(found - dots)
        is_beyond = run == 0 and (found - dots) * log_scale > 0
        if off <= TOLERANCE * dots or is_beyond:
            break
        known[log_scale] = math.log(max(found, 0.5))
        scales = sorted(known, reverse=True)
        log_scale = float(np.interp(math.log(dots), np.maximum.accumulate([known[scale] for scale in scales]), scales))
        if log_scale in known:
            break
    return best, best_scale


def stipple(photo: Photo, dots: int) -> Picture:
    """Return the picture of equal dots."""
    count = check_dots(dots)
    height, width = photo.tone.shape
    tone = photo.tone.astype(np.float64)
    ink = float((1 - tone).sum())
    settings: dict[str, object] = {"seed": SEED}
    positions = np.empty((0, 2))
    if ink > 0:
        is_dot, log_scale = search(tone, count)
        while is_dot.sum() > (1 + TOLERANCE) * count and log_scale == LARGEST_LOG_SCALE and tone.size > 1:
            rows, columns = tone.shape
            half = (columns + 1) // 2, (rows + 1) // 2
            tone = cv2.resize(tone, half, interpolation=cv2.INTER_AREA).astype(np.float64)
            is_dot, log_scale = search(tone, count)
        rows, columns = tone.shape
        dark_rows, dark_columns = np.nonzero(is_dot)
        positions = (np.stack([dark_columns, dark_rows], axis=1) + 0.5) * [width / columns, height / rows]
        settings |= {"grid": [columns, rows], "error_scale": math.exp(log_scale)}
        if abs(len(positions) - count) > TOLERANCE * count:
            settings["note"] = f"{len(positions):,} dots instead of {count:,}: no scale of errors comes nearer on these pixels"
    return picture(equal_black_dots(positions, ink), width, height, settings)


METHODS = (Method("sps", "Structure-preserving", "Li and Mould 2011", stipple, is_budgeted=True),)
