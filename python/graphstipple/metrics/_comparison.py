"""All metrics at once, near, far and farther, of many pictures against one photo."""

from __future__ import annotations

from typing import Any, ClassVar

import numpy as np
import numpy.typing as npt

from graphstipple.metrics._lpips import Lpips
from graphstipple.metrics._similarity import (
    FARTHER_SIGMA,
    MSSSIM_LEAST_SIDE,
    blurred,
    checked,
    checked_pair,
    local_tone,
    msssim,
    psnr,
    ssim,
    tone_error,
)


class Comparison:
    """All metrics of any number of pictures against one reference, whose own part of the work is done once.

    *Near* compares the pictures as they are; *far* after a Gaussian blur of 1.5 px of both (`blurred`); *farther* after one of
    3 px.

    Parameters
    ----------
    reference : array of floats, (height, width)
        In [0, 1], at least 161 px a side.
    lpips : bool
        Whether to compute LPIPS, which needs weights and by far most of the time.

    Raises
    ------
    InvalidInputError
        If the array has a wrong shape, type or value.
    MissingWeightsError
        If the weights of LPIPS are asked for and are not in the cache folder.
    """

    LEAST_SIDE: ClassVar[int] = MSSSIM_LEAST_SIDE
    """The least height and width that can be compared, in pixels: 161, what multi-scale SSIM asks for."""

    def __init__(self, reference: npt.NDArray[np.floating[Any]], lpips: bool = True) -> None:
        self._near = checked(reference, "reference", self.LEAST_SIDE, "multi-scale SSIM")
        self._far = blurred(self._near)
        self._farther = blurred(self._near, FARTHER_SIGMA)
        self._near_distances: dict[str, Lpips] = {}
        self._far_distances: dict[str, Lpips] = {}
        if lpips:
            self._near_distances = {"near_lpips_alex": Lpips(self._near, "alex"), "near_lpips_vgg": Lpips(self._near, "vgg")}
            self._far_distances = {"far_lpips_alex": Lpips(self._far, "alex")}

    def __call__(self, picture: npt.NDArray[np.floating[Any]]) -> dict[str, float]:
        """Return the metrics of a picture.

        Parameters
        ----------
        picture : array of floats, (height, width)
            In [0, 1], of the reference's shape.

        Returns
        -------
        dict of str to float
            ``near_psnr`` (dB, infinite for equal pictures), ``near_ssim``, ``near_msssim``, ``near_lpips_alex``,
            ``near_lpips_vgg``; ``far_psnr``, ``far_ssim``, ``far_msssim``, ``far_lpips_alex``; ``farther_psnr``,
            ``farther_ssim``; ``local_tone``; ``tone_error``. Without LPIPS, the keys that hold ``lpips`` are left out.

        Raises
        ------
        InvalidInputError
            If the array has a wrong shape, type or value.
        """
        near, _ = checked_pair(picture, self._near)
        far, farther = blurred(near), blurred(near, FARTHER_SIGMA)
        return {
            "near_psnr": psnr(near, self._near),
            "near_ssim": ssim(near, self._near),
            "near_msssim": msssim(near, self._near),
            **{name: distance(near) for name, distance in self._near_distances.items()},
            "far_psnr": psnr(far, self._far),
            "far_ssim": ssim(far, self._far),
            "far_msssim": msssim(far, self._far),
            **{name: distance(far) for name, distance in self._far_distances.items()},
            "farther_psnr": psnr(farther, self._farther),
            "farther_ssim": ssim(farther, self._farther),
            "local_tone": local_tone(near, self._near),
            "tone_error": tone_error(near, self._near),
        }
