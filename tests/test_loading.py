"""What is loaded: all of our own drawings, and of other files what is a drawing, as judges say that know nothing of the loader."""

from __future__ import annotations

import functools
import json
import math
import os
import re
import subprocess
import sys
from pathlib import Path
from typing import Any
from xml.etree import ElementTree

import numpy as np
import pytest
from numpy.typing import NDArray
from tests import oracles, readers
from tests.mutants import mutant_of_json, mutant_of_svg
from tests.soundness import check_picture, noise
from tests.support import PHOTOS, options_with, photo

import graphstipple as gs

# Small pictures often come out blank, which is told and is not what these tests are about.
pytestmark = pytest.mark.filterwarnings("ignore:the whole drawing is:graphstipple.GraphStippleWarning")

STYLES: list[dict[str, Any]] = [{}, {"style": "layered"}, {"only": "white"}, {"only": "black,white"}]

SHOWN = (0, 1, 2)
"""The styles of which a picture is compared: with both inks, the paper shines through where they meet."""

FINE = 4
"""Pictures are compared this many times as large and averaged, so that how a program antialiases hardly counts."""

MUTANTS = int(os.environ.get("GRAPHSTIPPLE_MUTANTS", "150"))
"""How many mutants of each format are tried."""

MEAN_TOLERANCE = 2.5
"""Mean difference of two pictures, of 255: as in test_formats.py."""

PIXEL_TOLERANCE = 64.0
"""Largest difference of a pixel, of 255: small dots in it, and lines between marks that meet where the paper shines through."""


@functools.cache
def small_drawings() -> list[gs.Drawing]:
    """Draw what mutants are made of: some dots, some regions, curves that end on the frame, rings in rings."""
    images: list[tuple[NDArray[np.uint8], gs.Options]] = [
        (photo("camera", 40, 30), gs.Options()),
        (photo("coffee", 24, 32), options_with(density=0.5, tolerance=0.25)),
        (noise(1, 28, 20), gs.Options()),
        (noise(2, 12, 12), options_with(density=2.0, tolerance=0.0)),
        (noise(5, 20, 26), gs.Options(irregularity=1.0, seed=3)),
        (noise(6, 22, 18), gs.Options(wobble=1.0, edge="torn")),
        (255 - noise(7, 16, 9), options_with(density=1.0, stipple_scale=2.0)),
    ]
    return [gs.draw(image, options=options) for image, options in images]


def same_files(one: gs.Drawing, other: gs.Drawing) -> bool:
    """Whether two drawings give the same bytes in all formats that can be read."""
    return one.json() == other.json() and all(one.svg(**how) == other.svg(**how) for how in STYLES)


# Our own -------------------------------------------------------------------------------------------------------------------------


@pytest.mark.parametrize(
    ("name", "preset"), [(PHOTOS[number % len(PHOTOS)], preset.name) for number, preset in enumerate(gs.presets())]
)
def test_every_drawing_survives_every_file_and_least_dot(name: str, preset: str, tmp_path: Path) -> None:
    image = np.ascontiguousarray(photo(name)[::4, ::4])
    drawing = gs.draw(image, options=gs.Options.preset(preset))
    drawing.save(tmp_path / "drawing.json")
    saved = [tmp_path / "drawing.json"]
    for number, how in enumerate(STYLES):
        saved.append(tmp_path / f"{number}.svg")
        drawing.save(saved[-1], **how)
    for path in saved:
        assert same_files(gs.load(path), drawing), path.name

    # As in the README: on paper 200 mm wide.
    for millimetres in (0.1, 0.6) if PHOTOS.index(name) % 2 else (0.3, 1.0):
        larger = drawing.with_min_dot(f"{millimetres}mm", width="200mm")
        least = millimetres * image.shape[1] / 200
        assert (larger.stipples["radius"] >= least * (1 - 1e-9)).all()
        kept = {tuple(dot) for dot in drawing.stipples[drawing.stipples["radius"] > least * (1 + 1e-9)].tolist()}
        assert kept <= {tuple(dot) for dot in larger.stipples.tolist()}
        # Of regions, none goes, none comes, and none has another outline.
        assert len(larger.regions) == len(drawing.regions)
        for region, before in zip(larger.regions, drawing.regions, strict=True):
            assert region.ink == before.ink
            np.testing.assert_array_equal(region.exterior, before.exterior)
        assert larger.stats["dots_dropped"] == len(drawing.stipples) - len(larger.stipples)
        check_picture(larger, larger.width, larger.height)
        larger.save(tmp_path / "larger.json")
        larger.save(tmp_path / "larger.svg", style="layered")
        assert same_files(gs.load(tmp_path / "larger.json"), larger)
        assert same_files(gs.load(tmp_path / "larger.svg"), larger)


@pytest.mark.parametrize(
    ("seed", "size", "options"),
    [
        (8480, (6, 22), {"density": 0.3, "tolerance": 2.0, "stipple_max": 0.4}),
        (9566, (11, 29), {"density": 1.0, "tolerance": 1.0, "stipple_scale": 4.0, "stipple_max": 0.4}),
        (18757, (28, 33), {"density": 1.0, "tolerance": 2.0, "stipple_scale": 4.0, "stipple_min": 0.8, "stipple_max": 0.9}),
    ],
)
def test_control_points_on_the_edge_of_the_canvas_survive_every_file(
    seed: int, size: tuple[int, int], options: dict[str, float], tmp_path: Path
) -> None:
    # Rounded up to the edge from beyond it, a coordinate was -0, which relative numbers do not keep.
    drawing = gs.draw(noise(seed, *size), importance="none", options=options_with(**options))
    assert "-0," not in drawing.json()
    for number, how in enumerate(STYLES):
        drawing.save(tmp_path / f"{number}.svg", **how)
        assert same_files(gs.load(tmp_path / f"{number}.svg"), drawing)


# Several inks --------------------------------------------------------------------------------------------------------------------

RISO: dict[str, Any] = {"inks": "#1d1d1b,pink=#ff48b0,#0078bf", "paper": "#f4efe2"}

INKS: dict[str, dict[str, Any]] = {
    "one": {"inks": "#c81e1e"},
    "levels": {"levels": 5},
    "extracted": {"extract_inks": 4},
    "solid": RISO,
    "overprint": {**RISO, "overprint": True},
}


def coloured(seed: int) -> NDArray[np.uint8]:
    """Return a small picture of waves, of noise, or of few colours, by turns."""
    random = np.random.default_rng(seed)
    height, width = random.integers(8, 36, 2).tolist()
    if seed % 3 == 0:
        y, x = np.mgrid[:height, :width]
        waves = [np.sin(x * a + y * b + c) for a, b, c in random.uniform(0.0, 1.0, (3, 3))]
        return (127.5 + 127.5 * np.stack(waves, axis=-1)).astype(np.uint8)
    if seed % 3 == 1:
        return random.integers(0, 256, (height, width, 3)).astype(np.uint8)
    image = np.full((height, width, 3), random.integers(0, 256, 3), dtype=np.uint8)
    image[height // 3 :, width // 4 :] = random.integers(0, 256, 3)
    image[: height // 2, width // 2 :] = random.integers(0, 256, 3)
    return image


def ways_of_inks(drawing: gs.Drawing, *, overprint: bool) -> list[dict[str, Any]]:
    """Return the settings with which an SVG tells all of a drawing."""
    names = [*drawing.inks, "paper"]
    ways: list[dict[str, Any]] = [{}, {"elements": "marks"}, {"only": ",".join(names), "margin": "3mm"}]
    if not overprint:
        ways += [{"style": "layered"}, {"style": "layered", "elements": "marks"}]
        ways += [{"only": ",".join(names[:-2] + names[-1:])}, {"only": ",".join(names[1:]), "paper": "none"}]
    return ways


@pytest.mark.parametrize("kind", INKS)
@pytest.mark.parametrize("further", [{}, {"irregularity": 1.0}, {"nodes_per_pixel": 1.0}], ids=["plain", "irregular", "dense"])
def test_drawings_of_inks_survive_every_file(kind: str, further: dict[str, Any], tmp_path: Path) -> None:
    for seed in range(6):
        drawing = gs.draw(coloured(seed), options=gs.Options(**INKS[kind], **further))
        drawing.save(tmp_path / "drawing.json")
        assert gs.load(tmp_path / "drawing.json").json() == drawing.json()
        for how in ways_of_inks(drawing, overprint=kind == "overprint"):
            drawing.save(tmp_path / "drawing.svg", **how)
            loaded = gs.load(tmp_path / "drawing.svg")
            assert loaded.json() == drawing.json(), (seed, how)
            assert loaded.svg(**how) == drawing.svg(**how), (seed, how)
        # Radii of strokes are rounded once.
        drawing.save(tmp_path / "strokes.svg", dots="strokes")
        assert gs.load(tmp_path / "strokes.svg").svg(dots="strokes") == (tmp_path / "strokes.svg").read_text()


def test_a_file_that_leaves_inks_out_is_refused_in_one_sentence(tmp_path: Path) -> None:
    path = tmp_path / "drawing.svg"
    for kind, only in (("solid", "pink,0078bf"), ("solid", "pink,paper"), ("overprint", "1d1d1b,pink,paper")):
        gs.draw(coloured(0), options=gs.Options(**INKS[kind])).save(path, only=only)
        rule = "alone of its inks is not read back: save the drawing with all of them, or as .json"
        assert refusal(path) == f"{path}: an SVG with {only} {rule}"


@pytest.mark.parametrize("kind", ["levels", "solid", "overprint"])
def test_mutants_of_inks_are_drawings_or_refused(kind: str, tmp_path: Path) -> None:
    path, accepted = tmp_path / "mutant.svg", 0
    drawings = [gs.draw(coloured(seed), options=gs.Options(**INKS[kind])) for seed in range(4)]
    for seed in range(MUTANTS):
        random = np.random.default_rng(seed)
        drawing = drawings[seed % len(drawings)]
        ways = ways_of_inks(drawing, overprint=kind == "overprint")
        path.write_text(mutant_of_svg(drawing.svg(**ways[int(random.integers(len(ways)))]), random))
        loaded = loaded_or_refused(path)
        if loaded is None:
            continue
        accepted += 1
        try:
            check_picture(loaded, loaded.width, loaded.height)
            for how in ways_of_inks(loaded, overprint=kind == "overprint"):
                loaded.save(tmp_path / "again.svg", **how)
                assert gs.load(tmp_path / "again.svg").json() == loaded.json()
        except Exception as error:
            raise AssertionError(f"mutant {seed} was loaded") from error
    # Some change nothing that is drawn; a boundary that is moved in one layer alone is no drawing's.
    assert 0 < accepted < 0.6 * MUTANTS


# Others --------------------------------------------------------------------------------------------------------------------------

NO_DRAWING = "this is not a drawing that graphstipple wrote: "


def document(
    width: int,
    height: int,
    curves: list[str],
    dots: list[tuple[float, float, float, int]] | None = None,
    *,
    units: float = 16.0,
    regions: list[tuple[int, float]] | None = None,
) -> str:
    """Return a JSON file of curves and dots (x, y, radius, ink), which bound regions of these inks and areas."""
    names = ("x", "y", "radius", "ink")
    told = {
        "format": "graphstipple drawing",
        "version": gs.__version__,
        "importance": "none",
        "options": {},
        "canvas": {"width": width, "height": height},
        "units": units,
        "stipples": [dict(zip(names, dot, strict=True)) for dot in dots or []],
        "regions": [{"ink": ink, "area": area} for ink, area in regions or [(1, 0.0)]],
        "curves": curves,
    }
    return json.dumps(told)


def ring(*points: tuple[float, float]) -> str:
    """Return the path data of a closed curve."""
    return "M" + " L".join(f"{x},{y}" for x, y in (*points, points[0])) + " Z"


def square(begin: float, end: float, *, black: bool = True) -> str:
    """Return a square with two of its corners on the diagonal; black, or white in black."""
    corners = [(begin, begin), (end, begin), (end, end), (begin, end)]
    return ring(*(corners if black else corners[::-1]))


def disc(radius: float) -> float:
    """Return the area of a dot."""
    return math.pi * radius**2


def check_loaded(drawing: gs.Drawing, folder: Path) -> None:
    """Check what was loaded, by judges that know nothing of the loader."""
    check_picture(drawing, drawing.width, drawing.height)
    raster = drawing.rasterize(FINE * drawing.width)
    white = sum(region.area for region in drawing.regions if region.ink == 1)
    white += (np.pi * drawing.stipples["radius"] ** 2 * (drawing.stipples["ink"] == 1)).sum()
    # Values are rounded to 1/255, and a flattened outline lies 0.01 pixels inside its curve.
    assert raster.mean() / 255 == pytest.approx(white / (drawing.width * drawing.height), abs=0.006)
    for number in SHOWN:
        check_same_picture(drawing.svg(**STYLES[number]), drawing)
    drawing.save(folder / "again.json")
    assert same_files(gs.load(folder / "again.json"), drawing)
    for how in STYLES:
        drawing.save(folder / "again.svg", **how)
        assert same_files(gs.load(folder / "again.svg"), drawing)


def check_same_picture(svg: str, drawing: gs.Drawing) -> None:
    """Check that resvg paints a document as we paint the drawing."""
    ours = oracles.box_average(drawing.rasterize(FINE * drawing.width), FINE)
    theirs = oracles.box_average(readers.svg(svg, 2 * FINE * drawing.width), 2 * FINE)
    assert theirs.shape == ours.shape
    difference = np.abs(theirs - ours)
    assert difference.mean() < MEAN_TOLERANCE
    assert difference.max() < PIXEL_TOLERANCE


def is_plain(svg: str, drawing: gs.Drawing) -> bool:
    """Whether a document is as large as its drawing, and has no paper of its own."""
    root, width, height = ElementTree.fromstring(svg), str(drawing.width), str(drawing.height)
    is_canvas = (root.get("width"), root.get("height"), root.get("viewBox")) == (width, height, f"0 0 {width} {height}")
    return is_canvas and 'id="paper"' not in svg


def loaded_or_refused(path: Path) -> gs.Drawing | None:
    """Return the drawing of a file, or none where the file is refused in one sentence."""
    try:
        return gs.load(path)
    except gs.ImageFileError:
        refusal(path)
        return None


def refusal(path: Path) -> str:
    """Return the sentence with which a file is refused."""
    with pytest.raises(gs.ImageFileError) as refused:
        gs.load(path)
    sentence = str(refused.value)
    assert sentence.startswith(f"{path}: ")
    assert sentence.isprintable()
    return sentence


@pytest.mark.parametrize("suffix", ["json", "svg"])
def test_mutants_are_drawings_or_refused(suffix: str, tmp_path: Path) -> None:
    path = tmp_path / f"mutant.{suffix}"
    drawings, accepted, shown = small_drawings(), 0, 0
    for seed in range(MUTANTS):
        random = np.random.default_rng(seed)
        drawing = drawings[seed % len(drawings)]
        style = int(random.integers(len(STYLES)))
        is_svg = suffix == "svg"
        mutant = mutant_of_svg(drawing.svg(**STYLES[style]), random) if is_svg else mutant_of_json(drawing.json(), random)
        path.write_text(mutant)
        loaded = loaded_or_refused(path)
        if loaded is None:
            continue
        accepted += 1
        try:
            check_loaded(loaded, tmp_path)
            if is_svg and style in SHOWN and is_plain(mutant, loaded):
                shown += 1
                check_same_picture(mutant, loaded)
        except Exception as error:
            raise AssertionError(f"mutant {seed} was loaded") from error
    # Enough of both kinds.
    assert 0.05 * MUTANTS < accepted < 0.9 * MUTANTS
    assert suffix == "json" or shown > 0.02 * MUTANTS


WHOLE = square(2, 8)

KINDS: dict[str, tuple[str, str]] = {
    "a ring twice": (document(10, 10, [WHOLE, WHOLE]), "touches or crosses"),
    "a ring on a ring": (document(10, 10, [WHOLE, square(8, 9)]), "touches or crosses"),
    "rings that cross": (document(10, 10, [WHOLE, square(4, 9)]), "touches or crosses"),
    "a region of the other ink": (document(10, 10, [WHOLE], regions=[(1, 64.0), (1, 36.0)]), "region 1 is told to have ink 1"),
    "a bow-tie": (document(10, 10, [ring((2, 2), (8, 8), (8, 2), (2, 8))]), "touches or crosses itself"),
    "a spike": (document(10, 10, [ring((2, 2), (8, 2), (8, 8), (8, 5))]), "touches or crosses itself"),
    "open curves that cross": (document(10, 10, ["M0,2L10,8", "M0,8L10,2"]), "touches or crosses"),
    "an open curve inside": (document(10, 10, ["M2,2L8,8"]), "neither closed nor goes from frame to frame"),
    "a line along the frame": (document(10, 10, ["M8,0L2,0"]), "edge of the canvas"),
    "rings of both inks on the canvas": (
        document(20, 20, [square(2, 8), square(10, 16, black=False)], regions=[(1, 328.0), (0, 36.0), (1, 36.0)]),
        "black .* white|white .* black",
    ),
    "a dot whose polygon crosses a curve": (
        document(20, 20, [ring((12.96, 11.22), (19, 11), (19, 14))], [(10, 10, 3.125, 0)], units=1),
        "touches or crosses",
    ),
    "a curve along the frame": (document(10, 10, [ring((0, 2), (5, 5), (0, 8))]), "edge of the canvas"),
    "a curve off the canvas": (document(10, 10, [square(2, 11)]), "leaves the canvas"),
    "a bulge off the canvas": (document(10, 10, ["M2,2L8,2Q14,5 8,8L2,8L2,2Z"]), "edge of the canvas"),
    "a control point far away": (document(10, 10, ["M2,2L8,2Q1e14,5 8,8L2,8L2,2Z"]), "leaves the canvas"),
    "no number": (document(10, 10, ["M2,2L8,2LNaN,8L2,8L2,2Z"]), "path data|no numbers"),
    "an infinite number": (document(10, 10, ["M2,2L8,2L1e999,8L2,8L2,2Z"]), "path data|no numbers"),
    "two curves in one": (document(10, 10, [square(1, 4) + square(5, 9)]), "not one curve"),
    "nothing enclosed": (document(10, 10, ["M2,2L8,8L2,2Z"]), "encloses nothing|itself"),
    "a single point": (document(10, 10, ["M2,2Z"]), "encloses nothing|not one curve"),
    "inks that do not alternate": (document(10, 10, [WHOLE, square(4, 6)]), "black .* white|white .* black"),
    "a dot in a dot": (document(10, 10, [], [(5, 5, 4, 0), (5, 5, 2, 0)]), "lies in"),
    "dots that overlap": (document(10, 10, [], [(4, 5, 3, 0), (6, 5, 3, 0)]), "touches or crosses"),
    "a dot twice": (document(10, 10, [], [(4, 5, 3, 0), (4, 5, 3, 0)]), "touches or crosses"),
    "a dot on a curve": (document(10, 10, [WHOLE], [(2, 5, 1, 1)]), "touches or crosses"),
    "a dot in its own ink": (document(10, 10, [WHOLE], [(5, 5, 1, 0)]), "is black and lies in black"),
    "dots of both inks in one place": (document(10, 10, [], [(3, 5, 1, 0), (7, 5, 1, 1)]), "is white and lies in white"),
    "a dot over the edge": (document(10, 10, [], [(0.5, 5, 1, 0)]), "does not lie on the canvas"),
    "a dot of no size": (document(10, 10, [], [(5, 5, 0, 0)]), "no radius above 0"),
    "a dot turned inside out": (document(10, 10, [], [(5, 5, -1, 0)]), "no radius above 0"),
    "no grid": (document(10, 10, [WHOLE], units=0), "units"),
    "an endless grid": (document(10, 10, [WHOLE], units=2.0**60), "units"),
    "a crooked grid": (document(10, 10, [WHOLE], units=15.5), "units"),
    "no canvas": (document(0, 10, []), "each side must be"),
    "an endless canvas": (document(10, 65536, []), "each side must be"),
}


@pytest.mark.parametrize("kind", KINDS)
def test_what_breaks_a_rule_is_refused(kind: str, tmp_path: Path) -> None:
    path = tmp_path / "drawing.json"
    text, rule = KINDS[kind]
    path.write_text(text)
    assert re.search(rule, refusal(path))


def test_what_keeps_the_rules_is_loaded(tmp_path: Path) -> None:
    # As near as the rules allow: rings and dots a hair apart, open curves that begin beside each other, a spiral.
    hair = 2.0**-12
    spiral = [(8, 8), (24, 8), (24, 24), (10, 24), (10, 12), (20, 12), (20, 20), (14, 20), (14, 16)]
    inner = [(14 + hair, 16), (14 + hair, 20 - hair), (20 - hair, 20 - hair), (20 - hair, 12 + hair)]
    inner += [(10 + hair, 12 + hair), (10 + hair, 24 - hair), (24 - hair, 24 - hair), (24 - hair, 8 + hair), (8, 8 + hair)]
    dots = [(16.0, 2.0, 1.75, 0), (30.0, 16.0, 1.0, 0), (30.0, 19.0, 1.5, 0)]
    # From the top down.
    regions = [(1, 128 - disc(1.75)), (0, 32 * hair), (1, 896 - 2 - disc(1) - disc(1.5)), (0, 0.02), (0, 1), (0, 1)]
    band = ["M0,4 L32,4", f"M32,{4 + hair} L0,{4 + hair}"]
    curves = [ring(*spiral, *inner), square(26, 27), square(27 + hair, 28), *band]
    fine = document(32, 32, curves, dots, regions=regions)
    (tmp_path / "drawing.json").write_text(fine)
    loaded = gs.load(tmp_path / "drawing.json")
    assert [region.ink for region in loaded.regions].count(0) == 4
    check_loaded(loaded, tmp_path)


# Limits --------------------------------------------------------------------------------------------------------------------------

MEASURE = """
import resource, sys
import graphstipple as gs
gs.load(sys.argv[1])
begin = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss
try:
    drawing = gs.load(sys.argv[2])
except gs.ImageFileError as error:
    print(error)
else:
    for how in ({}, {"style": "layered"}):
        drawing.save(sys.argv[3], **how)
        again = gs.load(sys.argv[3])
        assert len(again.stipples) == len(drawing.stipples) and len(again.regions) == len(drawing.regions)
    drawing.rasterize(min(drawing.width, 1000))
    print(len(drawing.stipples), len(drawing.regions))
print(resource.getrusage(resource.RUSAGE_SELF).ru_maxrss - begin)
"""


def measured(text: str, tmp_path: Path) -> tuple[str, float]:
    """Load, save and paint a drawing in a process of its own; return what it told, and how many megabytes all that took."""
    small, large = tmp_path / "small.json", tmp_path / "large.json"
    small.write_text(dots_on(10, 10, [(1, 1, 0.5, 0)]))
    large.write_text(text)
    command = [sys.executable, "-c", MEASURE, str(small), str(large), str(tmp_path / "again.svg")]
    done = subprocess.run(command, capture_output=True, text=True, check=True, timeout=300)
    told, kilobytes = done.stdout.splitlines()
    return told, float(kilobytes) / (1 << 20 if sys.platform == "darwin" else 1 << 10)


def posts(count: int) -> str:
    """Return as many open curves from the top of a high canvas to its bottom."""
    curves = [f"M{k / 128},{0 if k % 2 else 65535} L{k / 128},{65535 if k % 2 else 0}" for k in range(1, count + 1)]
    regions = [(k % 2, 65535 / 128) for k in range(count)]
    return document(10, 65535, curves, regions=[*regions, (count % 2, 65535 * (10 - count / 128))])


def dots_on(width: int, height: int, dots: list[tuple[float, float, float, int]]) -> str:
    """Return dots on white paper."""
    return document(width, height, [], dots, regions=[(1, width * height - sum(disc(dot[2]) for dot in dots))])


def nested(count: int) -> str:
    """Return as many rings in one another, an eighth of a pixel apart."""
    sides = [count / 4 + 1 - k / 4 for k in range(1, count + 1)]
    side = math.ceil(count / 4 + 1)
    areas = [outer**2 - inner**2 for outer, inner in zip([side, *sides], [*sides, 0], strict=True)]
    curves = [square(k / 8, k / 8 + length, black=k % 2 == 1) for k, length in enumerate(sides, 1)]
    return document(side, side, curves, regions=[(1 - k % 2, area) for k, area in enumerate(areas)])


def comb(count: int, *, sound: bool = True) -> str:
    """Return a ring that runs up and down as many times, and at the end into its last tooth, if it is not sound."""
    teeth = [(1 + k / 4, 2 + 60.0 * (k % 2)) for k in range(2 * count)]
    last = teeth[-1][0]
    points = [*teeth, (last + (0.125 if sound else -0.375), 2.0), (last + 0.25, 2.0), (last + 0.25, 63.0), (0.5, 63.0), (0.5, 2.0)]
    width, area = int(last) + 2, abs(oracles.signed_area(np.array(points)))
    curve = ring(*points)
    return document(width, 64, [curve], regions=[(1, 64 * width - area), (0, area)])


LARGE: dict[str, tuple[str, str]] = {
    "a high canvas": (posts(1200), "0 1201"),
    "a broad canvas of dots": (dots_on(65535, 24, [(3 + 5 * k, 8 + k % 9, 2, 0) for k in range(8000)]), "8000 1"),
    "rings in rings": (nested(3000), "0 3001"),
    "a row of dots": (dots_on(65535, 8, [(1.5 + 3 * k, 4, 1.25, 0) for k in range(20_000)]), "20000 1"),
    "a long zigzag": (comb(20_000), "0 2"),
    "a long zigzag that ends in itself": (comb(20_000, sound=False), "touches or crosses itself"),
    "a far control point": (document(10, 10, ["M2,2L8,2C1e14,5 -1e14,5 8,8L2,8L2,2Z"]), "leaves the canvas"),
    "curves that bend without end": (document(10, 10, ["M2,2C20,2 -10,8 2,8L2,2Z"] * 5000, units=2.0**20), "bends further"),
}

MOST_MEGABYTES = 200
"""What loading, saving and painting any of these may take beside the interpreter: some fifty times the file."""


@pytest.mark.skipif(sys.platform == "win32", reason="POSIX")
@pytest.mark.parametrize("kind", LARGE)
def test_memory_follows_the_size_of_the_file(kind: str, tmp_path: Path) -> None:
    text, expected = LARGE[kind]
    told, megabytes = measured(text, tmp_path)
    assert expected in told
    assert megabytes < MOST_MEGABYTES


INTERRUPTED = """
import os, signal, sys, threading
from graphstipple import load

signal.signal(signal.SIGINT, signal.default_int_handler)
threading.Timer(0.05, os.kill, (os.getpid(), signal.SIGINT)).start()
try:
    load(sys.argv[1])
except KeyboardInterrupt:
    print("interrupted")
"""


@pytest.mark.skipif(sys.platform == "win32", reason="POSIX signals")
def test_ctrl_c_ends_the_loading_of_a_large_file(tmp_path: Path) -> None:
    # Few curves, which bend so far on so fine a grid that they are some millions of points: seconds of work.
    ways = [("M0,{0}Q20,{1} 40,{0}", "M40,{0}Q20,{1} 0,{0}")[k % 2].format(k, k + 60) for k in range(1, 651)]
    regions = [(0, 840.0), *((k % 2, 40.0) for k in range(1, 650)), (0, 2000.0)]
    (tmp_path / "drawing.json").write_text(document(40, 720, ways, units=2.0**20, regions=regions))
    command = [sys.executable, "-c", INTERRUPTED, str(tmp_path / "drawing.json")]
    done = subprocess.run(command, capture_output=True, text=True, check=True, timeout=300)
    assert done.stdout == "interrupted\n"
