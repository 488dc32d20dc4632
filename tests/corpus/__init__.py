"""Small image files of every kind, made when the tests run, and what should come of each.

One deterministic picture is written by Pillow, imagecodecs and the writers of this package, which know every layout that formats
allow. What is right is told by the picture itself where a kind keeps it without loss, by other programs (Pillow with Little CMS,
tifffile) where it does not, and by the formulas of the standards for what those leave out.
"""

from tests.corpus import jpeg, others, png, tiff, webp
from tests.corpus.case import CLOSE, Case, Drawn, Made, Refused, Warned

CASES: tuple[Case, ...] = (*jpeg.cases(), *png.cases(), *tiff.cases(), *webp.cases(), *others.cases())
BY_NAME = {case.name: case for case in CASES}
assert len(BY_NAME) == len(CASES)

__all__ = ["BY_NAME", "CASES", "CLOSE", "Case", "Drawn", "Made", "Refused", "Warned"]
