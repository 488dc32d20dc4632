"""The paper's settings against constant alpha = 1 on scikit-image's five photos: SSIM, PSNR and counts.

The paper's ablation (its Table 5) reports that dynamic alpha lowers PSNR and raises SSIM. Both pictures are compared with the
photo's luma at the photo's own size: *near* as drawn, *far* after a Gaussian blur of 1.5 px of both, for a viewer at a distance.
Run with ``.venv/bin/python benches/alpha_ablation.py``.
"""

import numpy as np
from scipy.ndimage import gaussian_filter
from skimage import data
from skimage.metrics import peak_signal_noise_ratio, structural_similarity

import graphstipple as gs

PHOTOS = ("astronaut", "camera", "chelsea", "coffee", "rocket")
FAR_SIGMA = 1.5


def similarity(picture: np.ndarray, reference: np.ndarray) -> tuple[float, float]:
    """SSIM (Gaussian window, sigma 1.5) and PSNR in dB of two pictures in [0, 1]."""
    ssim = structural_similarity(picture, reference, gaussian_weights=True, use_sample_covariance=False, data_range=1.0)
    return float(ssim), float(peak_signal_noise_ratio(reference, picture, data_range=1.0))


def main() -> None:
    """Print one row a photo and setting, and the means."""
    header = ("photo", "alpha", "near SSIM", "far SSIM", "far PSNR", "tone error", "stipples", "regions", "vertices")
    print(("{:>10} " * len(header)).format(*header))
    rows: dict[str, list[list[float]]] = {"dynamic": [], "1": []}
    for name in PHOTOS:
        photo = getattr(data, name)()
        luma = gs.stages.tone(photo).astype(float)
        for label, options in (("dynamic", gs.Options.paper()), ("1", gs.Options.paper(alpha=1.0))):
            drawing = gs.draw(photo, options=options)
            picture = drawing.rasterize() / 255.0
            near, _ = similarity(picture, luma)
            far, psnr = similarity(gaussian_filter(picture, FAR_SIGMA), gaussian_filter(luma, FAR_SIGMA))
            counts = [drawing.stats[key] for key in ("stipples", "regions", "vertices")]
            rows[label].append([near, far, psnr, float(picture.mean() - luma.mean()), *counts])
            print(f"{name:>10} {label:>10} " + " ".join(f"{value:10.3f}" for value in rows[label][-1]))
    for label, values in rows.items():
        print(f"{'mean':>10} {label:>10} " + " ".join(f"{value:10.3f}" for value in np.mean(values, axis=0)))


if __name__ == "__main__":
    main()
