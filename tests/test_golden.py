"""Golden drawings: compared as data first, which says what changed, then as pixels, which says whether it shows.

`GRAPHSTIPPLE_UPDATE_GOLDEN=1 pytest tests/test_golden.py` writes them anew, and fails, so that it does not pass unnoticed.
"""

from __future__ import annotations

import hashlib
import json
import os

import numpy as np
import pytest
from PIL import Image
from tests.support import GOLDEN, GOLDEN_CASES, ROOT, options_with, photo

import graphstipple as gs

OUT = ROOT / "out" / "golden"
UPDATE = bool(os.environ.get("GRAPHSTIPPLE_UPDATE_GOLDEN"))

SIZE = (96, 64)
COUNTS = ("stipples", "regions", "nodes", "lattice_nodes", "vertices", "anchors", "coordinates")

# The raster is deterministic on one platform. Between platforms, antialiasing may round a level or two the other way.
PIXEL_TOLERANCE = 3


def digest(drawing: gs.Drawing) -> str:
    """Of all outlines and dots, to a thousandth of a pixel."""
    rings = [ring for region in drawing.regions for ring in (region.exterior, *region.holes)]
    dots = np.stack([drawing.stipples[name] for name in ("x", "y", "radius")], axis=1)
    # Adding 0.0 turns -0.0 into 0.0.
    text = "\n".join(" ".join(f"{v:.3f}" for v in (np.round(a, 3) + 0.0).ravel()) for a in [*rings, dots])
    return hashlib.sha256(text.encode()).hexdigest()


def described(drawing: gs.Drawing, changes: dict[str, object]) -> dict[str, object]:
    """Return a drawing as data."""
    return {
        "options": changes,
        "counts": {name: drawing.stats[name] for name in COUNTS},
        # Bit i of byte k is the label of node 8 k + i, the highest bit first.
        "labels": np.packbits(drawing.graph.labels).tobytes().hex(),
        "outlines": digest(drawing),
    }


def side_by_side(expected: np.ndarray, actual: np.ndarray) -> np.ndarray:
    """Join expected | difference | actual."""
    difference = np.abs(expected.astype(int) - actual).astype(np.uint8)
    return np.concatenate([expected, difference, actual], axis=1)


@pytest.mark.parametrize("name", GOLDEN_CASES)
def test_golden(name):
    changes = GOLDEN_CASES[name]
    image, data, picture = (GOLDEN / f"{name}{suffix}" for suffix in (".png", ".json", ".drawing.png"))
    if UPDATE:
        GOLDEN.mkdir(exist_ok=True)
        Image.fromarray(photo(name, *SIZE)).save(image, optimize=True)
    drawing = gs.draw(image, options=options_with(**changes))
    actual, raster = described(drawing, changes), drawing.rasterize(2 * SIZE[0])
    if UPDATE:
        data.write_text(json.dumps(actual, indent=1) + "\n")
        Image.fromarray(raster).save(picture, optimize=True)
        pytest.fail(f"wrote {data.name} and {picture.name} anew: look at them, then run without GRAPHSTIPPLE_UPDATE_GOLDEN")

    expected = json.loads(data.read_text())
    expected_raster = np.asarray(Image.open(picture))
    worst = np.abs(expected_raster.astype(int) - raster).max()
    if actual != expected or worst > PIXEL_TOLERANCE:
        OUT.mkdir(parents=True, exist_ok=True)
        Image.fromarray(side_by_side(expected_raster, raster)).save(OUT / f"{name}.png")
    for key in expected:
        assert actual[key] == expected[key], f"{key} of {name} changed; see {OUT / name}.png"
    assert worst <= PIXEL_TOLERANCE, f"{name} looks different; see {OUT / name}.png"
