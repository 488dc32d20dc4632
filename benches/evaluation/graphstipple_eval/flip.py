"""FLIP: how different a picture looks from its photo to an eye so far away (Andersson et al. 2020), by NVIDIA's own program.

FLIP models someone who flips between two pictures at one place: it takes away what the eye cannot resolve at a distance, compares
what is left in lightness and colour, and counts differences of edges and points for more. It is LDR-FLIP as the package
`flip-evaluator` computes it: grey is repeated to three channels, values are sRGB-encoded, as those of photo and picture are; the
figure is the mean of the map of differences, from 0 (equal) to 1.

The distance is a number of pixels a degree of the eye's field: 40 is near enough to see dots, 80 about arm's length from a screen,
160 twice as far.
"""

from __future__ import annotations

from typing import Any

import flip_evaluator
import numpy as np
import numpy.typing as npt

PIXELS_PER_DEGREE = (40, 80, 160)
"""Distances. More of them would take more time: the farther the eye, the wider the filters."""


class Flip:
    """FLIP of any number of pictures against one reference.

    Parameters
    ----------
    reference : (height, width) array of floats
        In [0, 1], 0 black to 1 white, sRGB-encoded.
    """

    def __init__(self, reference: npt.NDArray[np.floating[Any]]) -> None:
        self._reference = _three_channels(reference)

    def __call__(self, picture: npt.NDArray[np.floating[Any]]) -> dict[str, float]:
        """Return FLIP at every distance: `flip_40`, `flip_80` and `flip_160`, lower is nearer.

        Parameters
        ----------
        picture : (height, width) array of floats
            As the reference, and of its shape.
        """
        channels = _three_channels(picture)
        return {f"flip_{pixels}": self._mean(channels, pixels) for pixels in PIXELS_PER_DEGREE}

    def _mean(self, channels: npt.NDArray[np.float32], pixels: int) -> float:
        options = {"inputsRGB": True, "applyMagma": False, "computeMeanError": False, "parameters": {"ppd": float(pixels)}}
        errors, _, _ = flip_evaluator.evaluate(self._reference, channels, "LDR", **options)
        # Its own mean is summed in float32, and good to five digits only.
        return float(np.mean(errors, dtype=np.float64))


def _three_channels(grey: npt.NDArray[np.floating[Any]]) -> npt.NDArray[np.float32]:
    return np.repeat(grey.astype(np.float32)[:, :, np.newaxis], 3, axis=2)
