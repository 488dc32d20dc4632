"""How well subjects are found: `python benches/subjects.py FOLDER`, of photos .jpg with masks .png of the same names, white within.

Prints the intersection over union of every photo's mask with the one that is found at a half (0 where none is found), the seconds
that it took, and the means over all photos and over every other one.
"""

from __future__ import annotations

import sys
import time
from pathlib import Path

import numpy as np
from PIL import Image

import graphstipple as gs


def overlap(found: np.ndarray, mask: np.ndarray) -> float:
    """Return the intersection over union of two masks."""
    return float(np.count_nonzero(found & mask) / max(1, np.count_nonzero(found | mask)))


def main(folder: Path) -> None:
    """Print how well subjects are found in a folder's photos."""
    overlaps = []
    photos = sorted(path for path in folder.glob("*.jpg") if path.with_suffix(".png").exists())
    if not photos:
        sys.exit(f"{folder}: there are no photos .jpg with masks .png")
    for path in photos:
        mask = np.asarray(Image.open(path.with_suffix(".png")).convert("L")) >= 128
        began = time.perf_counter()
        found = gs.find_subject(path)
        spent = time.perf_counter() - began
        overlaps.append(0.0 if found is None else overlap(found >= 0.5, mask))
        told = "" if found is not None else ", none found"
        print(f"{path.stem}: {overlaps[-1]:.3f} ({spent:.1f} s{told})", flush=True)
    even, odd = np.mean(overlaps[::2]), np.mean(overlaps[1::2])
    print(f"mean over {len(overlaps)}: {np.mean(overlaps):.3f}; over every other one: {even:.3f} and {odd:.3f}")


if __name__ == "__main__":
    main(Path(sys.argv[1]))
