"""How near a picture comes to its photo: PSNR, SSIM, multi-scale SSIM, LPIPS, and how far its tone is off.

Pictures are arrays (height, width) of floats in [0, 1], 0 black to 1 white; what is compared has one shape. docs/metrics.md says
what each number means. LPIPS needs weights that ``python -m graphstipple.metrics fetch`` fetches once.

>>> import numpy as np
>>> from graphstipple import metrics
>>> reference = np.tile(np.linspace(0, 1, 64), (64, 1))
>>> round(metrics.psnr(np.round(reference), reference), 2)
10.86
"""

from graphstipple.metrics._comparison import Comparison
from graphstipple.metrics._lpips import Lpips, lpips
from graphstipple.metrics._similarity import blurred, local_tone, msssim, psnr, ssim, tone_error

__all__ = ["Comparison", "Lpips", "blurred", "local_tone", "lpips", "msssim", "psnr", "ssim", "tone_error"]
