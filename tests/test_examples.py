"""The examples in Python run, and do what they say; that in Rust is tested where it stands."""

from __future__ import annotations

import ast
import json
import re
import subprocess
import sys
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from PIL import Image
from tests.support import ROOT

import graphstipple as gs

EXAMPLES = ROOT / "examples"


def notebook() -> dict[str, Any]:
    """Return the notebook as it is stored."""
    return json.loads((EXAMPLES / "drawing.ipynb").read_text(encoding="utf-8"))


def run_cell(source: str, names: dict[str, Any]) -> object:
    """Run a cell as a notebook does, and return the value of its last line; None if that is no expression."""
    tree = ast.parse(source)
    last = tree.body.pop() if isinstance(tree.body[-1], ast.Expr) else None
    exec(compile(tree, "cell", "exec"), names)
    return eval(compile(ast.Expression(last.value), "cell", "eval"), names) if last else None


def shown(value: Any) -> str | bytes:
    """Return what a notebook shows of a value: its SVG, its PNG, or its text."""
    for name in ("_repr_svg_", "_repr_png_"):
        picture = getattr(value, name, lambda: None)()
        if picture is not None:
            return picture
    return repr(value)


def test_the_notebook_is_stored_without_what_its_cells_made() -> None:
    book = notebook()
    assert (book["nbformat"], book["nbformat_minor"]) == (4, 5)
    assert book["metadata"]["language_info"]["name"] == "python"
    ids = [cell["id"] for cell in book["cells"]]
    assert len(set(ids)) == len(ids)
    assert all(re.fullmatch(r"[a-zA-Z0-9-_]{1,64}", name) for name in ids)
    for cell in book["cells"]:
        assert "".join(cell["source"]).strip() == "".join(cell["source"])
        if cell["cell_type"] == "code":
            assert set(cell) == {"cell_type", "execution_count", "id", "metadata", "outputs", "source"}
            assert (cell["execution_count"], cell["outputs"], cell["metadata"]) == (None, [], {})
        else:
            assert set(cell) == {"cell_type", "id", "metadata", "source"}
            assert cell["cell_type"] == "markdown"
    assert (EXAMPLES / "drawing.ipynb").stat().st_size < 30_000


def test_the_notebook_runs_from_top_to_bottom_and_what_it_says_is_so(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.chdir(tmp_path)
    names: dict[str, Any] = {"__name__": "__main__"}
    values = [run_cell("".join(cell["source"]), names) for cell in notebook()["cells"] if cell["cell_type"] == "code"]
    values = [value for value in values if value is not None]
    drawings = [value for value in values if isinstance(value, gs.Drawing)]
    assert [drawing.width for drawing in drawings] == [200, 200, 200]
    assert all(shown(drawing).startswith("<svg ") for drawing in drawings)
    pictures = [value for value in values if isinstance(value, Image.Image)]
    assert [picture.size for picture in pictures] == [(200, 200), (900, 300)]
    assert all(shown(picture).startswith(b"\x89PNG") for picture in pictures)
    # The session draws what a fresh call would, and more of the photo is stippled from drawing to drawing.
    assert names["drawings"][0.8].svg() == gs.draw(names["photo"], options=gs.Options(stippling=0.8)).svg()
    stipples = [drawing.stats["stipples"] for drawing in names["drawings"].values()]
    assert stipples == sorted(set(stipples))
    assert drawings[1].svg() == gs.draw(names["photo"], options=gs.Options.preset("linocut")).svg()
    # The face has most of the nodes.
    said = capsys.readouterr().out
    (of_nodes, of_photo) = map(int, re.search(r"(\d+)% of the nodes are on (\d+)% of the photo", said).groups())
    assert of_photo < 50 < of_nodes
    assert len(names["detailed"].graph.sites) == pytest.approx(4_000, rel=0.02)
    # Dots bring back the tone, and cost likeness of small windows.
    figures = list(names["figures"].values())
    assert [figure["farther_psnr"] for figure in figures] == sorted(figure["farther_psnr"] for figure in figures)
    assert figures[0]["near_ssim"] > figures[-1]["near_ssim"]
    assert said.count("near_ssim") == 3
    assert values[-1] is True
    assert sorted(path.name for path in (tmp_path / "out").iterdir()) == ["face.png", "face.svg"]
    with Image.open(tmp_path / "out" / "face.png") as picture:
        assert picture.size == (800, 800)


def test_the_demo_draws_the_astronaut(tmp_path: Path) -> None:
    command = [sys.executable, EXAMPLES / "demo.py", tmp_path]
    ended = subprocess.run(command, capture_output=True, text=True, timeout=240, check=False)
    assert ended.returncode == 0, ended.stderr
    loaded = gs.load(tmp_path / "astronaut.svg")
    assert f'"stipples": {len(loaded.stipples)}' in ended.stdout
    with Image.open(tmp_path / "astronaut-drawn.png") as picture:
        assert np.array_equal(np.asarray(picture), loaded.rasterize(2 * loaded.width))
