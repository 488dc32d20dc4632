"""Golden drawings: compared as data, which says what changed, and as pixels, which says whether it shows.

Of each drawing `tests/golden` has the photo, `NAME.png`; the drawing, `NAME.svg`; its counts and labels, `NAME.json`; its pixels,
`NAME.drawing.png`. Where one differs, the message says what does (`tests/differences.py`), and `out/golden/NAME.png` shows what was
expected, the difference, and what was got.

`GRAPHSTIPPLE_UPDATE_GOLDEN=1 pytest tests/test_golden.py` writes them anew, and fails, so that it does not pass unnoticed.
"""

from __future__ import annotations

import json
import os
from pathlib import Path

import numpy as np
import pytest
from PIL import Image
from tests import differences
from tests.differences import State
from tests.support import GOLDEN, GOLDEN_CASES, ROOT, options_with, photo

import graphstipple as gs

OUT = ROOT / "out" / "golden"
UPDATE = bool(os.environ.get("GRAPHSTIPPLE_UPDATE_GOLDEN"))

SIZE = (96, 64)
COUNTS = ("stipples", "regions", "nodes", "lattice_nodes", "vertices", "anchors", "coordinates")


def drawn(name: str) -> gs.Drawing:
    """Draw a golden photo."""
    return gs.draw(GOLDEN / f"{name}.png", options=options_with(**GOLDEN_CASES[name]))


def got(drawing: gs.Drawing) -> State:
    """Return what is compared of a drawing."""
    counts = {name: drawing.stats[name] for name in COUNTS}
    return State(json.loads(drawing.json()), counts, drawing.graph.labels, drawing.rasterize(2 * SIZE[0]))


def expected(name: str) -> State:
    """Return what is compared of a golden drawing, from its files."""
    data = json.loads((GOLDEN / f"{name}.json").read_text())
    labels = np.unpackbits(np.frombuffer(bytes.fromhex(data["labels"]), np.uint8), count=data["counts"]["nodes"])
    with Image.open(GOLDEN / f"{name}.drawing.png") as raster:
        return State(json.loads(gs.load(GOLDEN / f"{name}.svg").json()), data["counts"], labels, np.asarray(raster))


def write(name: str, drawing: gs.Drawing, state: State) -> None:
    """Write a golden drawing's files."""
    drawing.save(GOLDEN / f"{name}.svg")
    # Bit i of byte k is the label of node 8 k + i, the highest bit first.
    data = {"counts": state.counts, "labels": np.packbits(state.labels).tobytes().hex()}
    (GOLDEN / f"{name}.json").write_text(json.dumps(data, indent=1) + "\n")
    Image.fromarray(state.raster).save(GOLDEN / f"{name}.drawing.png", optimize=True)


def assert_same(name: str, golden: State, now: State, folder: Path) -> None:
    """Fail with what differs, and with a picture of it in the folder."""
    lines = differences.in_words(golden, now)
    if lines:
        folder.mkdir(parents=True, exist_ok=True)
        path = folder / f"{name}.png"
        differences.picture(golden, now).save(path)
        pytest.fail(
            "\n  ".join([f"the drawing of {name} is another one; expected, difference, got: {path}", *lines]), pytrace=False
        )


@pytest.mark.parametrize("name", GOLDEN_CASES)
def test_golden(name: str) -> None:
    if UPDATE:
        GOLDEN.mkdir(exist_ok=True)
        Image.fromarray(photo(name, *SIZE)).save(GOLDEN / f"{name}.png", optimize=True)
    drawing = drawn(name)
    if UPDATE:
        write(name, drawing, got(drawing))
        pytest.fail(f"wrote the golden {name} anew: look at its files, then run without GRAPHSTIPPLE_UPDATE_GOLDEN", pytrace=False)
    assert_same(name, expected(name), got(drawing), OUT)
