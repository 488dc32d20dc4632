"""Pictures of black and white pixels: error diffusion in raster order, and the threshold that diffuses nothing."""

from __future__ import annotations

import numpy as np
import numpy.typing as npt

from graphstipple_eval.method import Counts, Method, Photo, Picture

THRESHOLD = 0.5
"""The least tone that becomes white: what both methods ask of a pixel."""


def floyd_steinberg(tone: npt.NDArray[np.float32]) -> npt.NDArray[np.float32]:
    """Return the error diffusion of Floyd and Steinberg (1976) of a tone: 0 or 1 for every pixel, (height, width).

    Every row runs from left to right. A pixel's error goes to its right neighbour (7/16) and to the three below it, left to right
    (3/16, 5/16, 1/16); what falls off the picture is lost.
    """
    height, width = tone.shape
    # A column more on both sides and a row more below take what falls off.
    values = np.zeros((height + 1, width + 2))
    values[:height, 1:-1] = tone
    # A pixel waits for its left neighbour and the three above it, so those with the same column + 2 * row can be done at once.
    for wave in range(width + 2 * (height - 1)):
        rows = np.arange(max(0, (wave - width + 2) // 2), min(height - 1, wave // 2) + 1)
        columns = wave - 2 * rows + 1
        value = values[rows, columns]
        white = value >= THRESHOLD
        values[rows, columns] = white
        error = value - white
        for down, right, weight in ((1, -1, 3 / 16), (1, 0, 5 / 16), (1, 1, 1 / 16), (0, 1, 7 / 16)):
            values[rows + down, columns + right] += weight * error
    return values[:height, 1:-1].astype(np.float32)


def _diffuse(photo: Photo, dots: int) -> Picture:
    return Picture(raster=floyd_steinberg(photo.tone), counts=Counts(), settings={"threshold": THRESHOLD})


def _cut(photo: Photo, dots: int) -> Picture:
    return Picture(raster=(photo.tone >= THRESHOLD).astype(np.float32), counts=Counts(), settings={"threshold": THRESHOLD})


METHODS = (
    Method("floyd-steinberg", "Floyd-Steinberg", "Floyd and Steinberg 1976", _diffuse),
    Method("threshold", "Threshold at 0.5", "Every pixel for itself", _cut),
)
