"""What the paper reports, to print beside our own figures and never as ours.

From *Graph-based Black and White Stylization* (Computer Graphics Forum 2026, doi 10.1111/cgf.70364): averages over the 20 images of
the NPR benchmark (Mould and Rosin), which are not ours, with an LPIPS network and a blur that the paper does not name.
"""

from __future__ import annotations

from typing import NamedTuple


class Quality(NamedTuple):
    """A row of the paper's Table 3 or Table 5."""

    title: str
    size: int | None
    """Longest side in pixels; None where it is not said."""
    lpips: float
    psnr: float
    msssim: float


class Count(NamedTuple):
    """A row of the paper's Table 4; vertices are rounded to thousands there."""

    title: str
    stipples: int
    regions: int
    vertices: int


QUALITY = (
    Quality("the paper's method", 1024, 0.566, 16.77, 0.505),
    Quality("the paper's method", 512, 0.550, 16.75, 0.405),
    Quality("the paper's method", 256, 0.530, 16.80, 0.440),
    Quality("MLBG (Schulz et al.)", 1024, 0.607, 19.56, 0.599),
    Quality("MLBG (Schulz et al.)", 512, 0.594, 19.59, 0.391),
    Quality("MLBG (Schulz et al.)", 256, 0.566, 19.42, 0.397),
    Quality("LBG", 1024, 0.647, 17.97, 0.468),
    Quality("RWT", 1024, 0.664, 15.92, 0.336),
    Quality("SBE", 1024, 0.668, 15.34, 0.300),
    Quality("WCVD", 1024, 0.706, 10.82, 0.177),
    Quality("SPS", 1024, 0.739, 5.37, 0.008),
    Quality("CCVT", 1024, 0.761, 9.61, 0.075),
)
"""Table 3."""

COUNTS = (
    Count("parrot, medium", 1623, 522, 50_000),
    Count("parrot, high", 7346, 1743, 165_000),
    Count("poker", 1474, 169, 24_000),
    Count("coupe", 2125, 781, 62_000),
    Count("frog", 788, 362, 54_000),
    Count("portrait", 2765, 927, 80_000),
    Count("toque", 2904, 604, 59_000),
    Count("Oparara", 2422, 516, 26_000),
    Count("rim", 1016, 251, 24_000),
    Count("headlight", 1931, 364, 53_000),
)
"""Table 4."""

ABLATIONS = {
    "paper-constant-importance": Quality("constant importance", None, 0.550, 17.07, 0.399),
    "paper-no-relaxation": Quality("no relaxation", None, 0.550, 16.75, 0.405),
    "paper-alpha-1": Quality("constant alpha = 1", None, 0.564, 17.59, 0.389),
    "paper": Quality("full", None, 0.543, 16.96, 0.420),
}
"""Table 5, by the name of our method."""
