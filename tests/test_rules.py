"""Rules: what OpenCV finds too thin in the written files, what shapely says of the geometry, and what is told."""

from __future__ import annotations

import hashlib
import json
import pickle
import re
from pathlib import Path
from typing import Any

import cv2
import numpy as np
import numpy.typing as npt
import pytest
import skimage.data
from tests import readers
from tests.commands import assert_one_sentence, native_binary, run
from tests.soundness import check_picture

import graphstipple as gs

WIDTH = 90.0
MM = 0.02
"""Millimetres to a pixel of what OpenCV looks at."""
ALLOWED = 0.02
"""Millimetres that anything may be narrower than its limit."""
RULES = gs.Rules(min_feature="0.4mm", min_gap="0.4mm", min_dot="0.5mm", min_area="2mm2", islands="bridge")
BROKEN = 3
"""Exit code."""

Pixels = npt.NDArray[np.bool_]


@pytest.fixture(scope="module")
def drawing() -> gs.Drawing:
    """A face: necks, gaps, small dots of both inks, islands."""
    return gs.draw(skimage.data.astronaut()[0:240, 90:330], options=gs.Options(nodes=9000))


@pytest.fixture(scope="module")
def kept(drawing: gs.Drawing) -> tuple[gs.Drawing, gs.Changes]:
    return drawing.enforce(RULES, width=f"{WIDTH}mm")


def in_px(document: str) -> str:
    """Return an SVG without its size on paper, which resvg does not scale."""
    return re.sub(r'(<svg [^>]*?)width="[^"]*" height="[^"]*"', r"\1", document, count=1)


def from_svg(path: Path) -> Pixels:
    """Black pixels of an SVG, by resvg."""
    return readers.svg(in_px(path.read_text()), round(WIDTH / MM)) < 128


def from_dxf(path: Path) -> Pixels:
    """Black pixels of a DXF, by ezdxf."""
    size = round(WIDTH / MM)
    rings = [ring for layer in readers.dxf_rings(readers.dxf(path), 0.002).values() for ring in layer]
    return readers.fill([np.column_stack([ring[:, 0], WIDTH - ring[:, 1]]) / MM for ring in rings], size, size)


def too_thin(ink: Pixels, limit: float, beyond: bool) -> int:
    """Return how many parts of an ink a disc of the limit does not fit into; `beyond` says whether the ink goes on there."""
    radius = (limit - ALLOWED) / MM / 2 - 1
    reach = int(np.ceil(radius))
    y, x = np.mgrid[-reach : reach + 1, -reach : reach + 1]
    disc = (x * x + y * y <= radius * radius).astype(np.uint8)
    around = cv2.copyMakeBorder(ink.astype(np.uint8), *[2 * reach] * 4, cv2.BORDER_CONSTANT, value=int(beyond))
    # Beyond its border OpenCV is to have neither.
    opened = cv2.morphologyEx(around, cv2.MORPH_OPEN, disc, borderType=cv2.BORDER_CONSTANT, borderValue=int(beyond))
    _, _, stats, _ = cv2.connectedComponentsWithStats(around & ~opened)
    # Corners are rounded by any knife; what is lost there is smaller.
    return int((stats[1:, cv2.CC_STAT_AREA] > (0.2 * limit / MM) ** 2).sum())


def pieces(white: Pixels) -> int:
    """Return how many pieces white hangs together in, with the sheet around."""
    around = cv2.copyMakeBorder(white.astype(np.uint8), 2, 2, 2, 2, cv2.BORDER_CONSTANT, value=1)
    return cv2.connectedComponents(around, connectivity=4)[0] - 1


@pytest.mark.parametrize(("suffix", "read"), [("svg", from_svg), ("dxf", from_dxf)])
def test_a_written_file_keeps_the_rules(
    drawing: gs.Drawing, kept: tuple[gs.Drawing, gs.Changes], suffix: str, read: Any, tmp_path: Path
) -> None:
    safe, changes = kept
    before, after = tmp_path / f"before.{suffix}", tmp_path / f"after.{suffix}"
    drawing.save(before, width=f"{WIDTH}mm")
    safe.save(after, width=f"{WIDTH}mm")
    was, black = read(before), read(after)
    assert too_thin(was, 0.4, False) > 20
    assert too_thin(~was, 0.4, True) > 20
    assert pieces(~was) > 20
    assert too_thin(black, 0.4, False) == 0
    assert too_thin(~black, 0.4, True) == 0
    assert pieces(~black) == 1
    assert abs((~black).mean() - changes.tone) < 0.005


def test_the_check_finds_nothing_then(drawing: gs.Drawing, kept: tuple[gs.Drawing, gs.Changes]) -> None:
    safe, changes = kept
    report, again = drawing.check(RULES, width=f"{WIDTH}mm"), safe.check(RULES, width=f"{WIDTH}mm")
    assert not report
    assert all(report.counts[kind] > 0 for kind in ("neck", "gap", "dot", "island"))
    assert again, again
    assert again.violations == []
    assert changes.islands_bridged > 0
    assert changes.bridges > 0
    assert changes.dots_enlarged > 0
    # What is above the limit is left as it is.
    assert changes.dots_kept > 0
    check_picture(safe, drawing.width, drawing.height)


@pytest.mark.parametrize(("number", "process"), list(enumerate(process.name for process in gs.processes())))
def test_every_process_is_kept(number: int, process: str) -> None:
    image = [skimage.data.coffee()[60:260, 150:400], skimage.data.camera()[60:316, 100:356]][number % 2]
    drawing = gs.draw(image, options=gs.Options.preset("stipple" if process == "pen" else "default"))
    rules = gs.Rules.process(process)
    safe, changes = drawing.enforce(rules, width="160mm")
    assert safe.check(rules, width="160mm"), safe.check(rules, width="160mm")
    check_picture(safe, drawing.width, drawing.height)
    before, after = (picture.rasterize().mean() / 255 for picture in (drawing, safe))
    assert abs((after - before) - (changes.tone - changes.tone_before)) < 0.01
    if process != "stencil":
        # White dots may be, so that tones can stay.
        assert abs(changes.tone - changes.tone_before) < 0.02


def test_shapes_are_cut_as_bold_as_they_are(tmp_path: Path) -> None:
    """A stencil of bold shapes keeps its tone; bridges follow where there is little black to lose."""
    drawing = gs.draw(skimage.data.astronaut(), options=gs.Options.preset("linocut"))
    rules = gs.Rules.process("stencil")
    safe, changes = drawing.enforce(rules, width="200mm")
    assert safe.check(rules, width="200mm")
    assert abs(changes.tone - changes.tone_before) < 0.02
    assert changes.bridges > 10
    # A file has no graph: its bridges are straight, and there is one white piece nonetheless.
    drawing.save(tmp_path / "drawing.json")
    straight, of_file = gs.load(tmp_path / "drawing.json").enforce(rules, width="200mm")
    assert straight.check(rules, width="200mm")
    assert of_file.bridges > 10
    assert straight.svg() != safe.svg()
    assert pieces(straight.rasterize(4000) >= 128) == 1


def test_what_keeps_the_rules_is_left_alone(kept: tuple[gs.Drawing, gs.Changes]) -> None:
    safe, _ = kept
    again, changes = safe.enforce(RULES, width=f"{WIDTH}mm")
    assert changes.features == changes.gaps == changes.bridges == changes.dots_dropped == 0
    assert changes.dots_kept == len(safe.stipples)
    assert np.array_equal(again.rasterize(), safe.rasterize())


def test_measures_are_those_of_what_was_drawn() -> None:
    """Bars of known widths, a disc and a ring."""
    image = np.full((400, 400), 255, np.uint8)
    image[40:60, 40:360] = 0
    image[100:108, 40:360] = 0
    image[150:200, 40:195] = 0
    image[150:200, 205:360] = 0
    cv2.circle(image, (120, 300), 60, 0, -1)
    cv2.circle(image, (120, 300), 30, 255, -1)
    drawing = gs.draw(image, importance="none", options=gs.Options(nodes=40000, stippling=0))
    rules = gs.Rules(min_feature="1.2mm", min_gap="1.4mm", min_area="15mm2", islands="report")
    report = drawing.check(rules, width="40mm")
    by_kind = {kind: [it for it in report.violations if it.kind == kind] for kind in report.counts}
    (neck,) = by_kind["neck"]
    (gap,) = by_kind["gap"]
    (island,) = by_kind["island"]
    assert neck.measured == pytest.approx(0.8, abs=0.1)
    assert neck.length == pytest.approx(32, abs=0.5)
    assert neck.y == pytest.approx(10.4, abs=0.2)
    assert gap.measured == pytest.approx(1.0, abs=0.1)
    assert (gap.x, gap.limit) == (pytest.approx(20, abs=0.2), 1.4)
    assert island.measured == pytest.approx(np.pi * 9, rel=0.03)
    assert np.hypot(island.x - 12, island.y - 30) < 3
    # The narrow bar has 26 mm^2, the island 28.
    assert by_kind["area"] == []
    assert drawing.check(rules.replace(min_area="40mm2"), width="40mm").counts["area"] == 2


def test_python_and_the_command_line_write_the_same(tmp_path: Path) -> None:
    photo = tmp_path / "photo.png"
    cv2.imwrite(str(photo), skimage.data.camera()[60:316, 100:356])
    flags = ["--process", "stencil", "--min-feature", "0.4mm", "--width", "120mm"]
    digests = set()
    for threads in (1, 2):
        out, report = tmp_path / "out.svg", tmp_path / "report.json"
        result = run(native_binary(), photo, "-o", out, *flags, "--check", report, "--strict", "--threads", threads)
        assert result.returncode == 0, result.stderr.decode()
        digests.add(hashlib.sha256(out.read_bytes() + report.read_bytes()).hexdigest())
    assert len(digests) == 1
    rules = gs.Rules.process("stencil", min_feature="0.4mm")
    safe, changes = gs.draw(photo).enforce(rules, width="120mm")
    assert safe.svg(width="120mm") == out.read_text()
    told = json.loads(report.read_text())
    assert told["changes"] == pytest.approx(changes._asdict())
    assert told["violations"] == []


def test_reports_are_files(drawing: gs.Drawing, tmp_path: Path) -> None:
    report = drawing.check(RULES, width=f"{WIDTH}mm")
    report.save(tmp_path / "report.json")
    report.save(tmp_path / "report.svg")
    told = json.loads((tmp_path / "report.json").read_text())
    assert told["counts"] == report.counts
    assert [it["kind"] for it in told["violations"]] == [it.kind for it in report.violations]
    assert told["rules"] == {"min_feature": 0.4, "min_gap": 0.4, "min_dot": 0.5, "min_area": 2.0, "islands": "bridge"}
    assert told["changes"] is None
    # Each kind has its colour in the picture.
    document = (tmp_path / "report.svg").read_text()
    assert document == report.svg()
    assert readers.svg(in_px(document), 900).shape[0] > 900
    for kind in ("necks", "gaps", "dots", "islands"):
        assert f'id="{kind}"' in document
    for violation in report.violations[:50]:
        assert 0 <= violation.x <= WIDTH
        assert 0 <= violation.y <= WIDTH
        assert violation.kind == "island" or violation.measured < violation.limit
    assert report.svg() == drawing.check(RULES, width=f"{WIDTH}mm").svg()


def test_the_command_line_tells_what_breaks_rules(tmp_path: Path) -> None:
    photo, out, report = tmp_path / "photo.png", tmp_path / "out.svg", tmp_path / "report.json"
    cv2.imwrite(str(photo), skimage.data.coffee()[60:260, 150:400])
    flags = ["-o", out, "--width", "100mm", "--process", "vinyl", "--check", report, "--check-only"]
    result = run(native_binary(), photo, *flags, "--strict")
    assert result.returncode == BROKEN
    assert result.stderr.decode().startswith("graphstipple: error: the drawing breaks the rules: ")
    # It is written nonetheless, as it was drawn.
    assert out.read_text() == gs.draw(photo).svg(width="100mm")
    assert sum(json.loads(report.read_text())["counts"].values()) > 100
    lenient = run(native_binary(), photo, *flags)
    assert lenient.returncode == 0
    assert lenient.stderr.decode().startswith("graphstipple: warning: the drawing breaks the rules: ")
    stats = json.loads(run(native_binary(), photo, *flags[:6], "--stats").stdout)
    assert set(stats["rules"]["violations"].values()) == {0}
    assert stats["rules"]["changes"]["rounds"] > 0
    assert stats["seconds"]["rules"] > 0


def test_a_least_dot_on_the_command_line_is_a_radius(tmp_path: Path) -> None:
    cv2.imwrite(str(tmp_path / "photo.png"), skimage.data.camera()[60:316, 100:356])
    flags = ["--width", "120mm", "--process", "laser", "--min-dot", "0.4mm", "-o", tmp_path / "out.svg"]
    result = run(native_binary(), tmp_path / "photo.png", *flags)
    assert result.returncode == 0, result.stderr.decode()
    expected, _ = gs.draw(tmp_path / "photo.png").enforce(gs.Rules.process("laser", min_dot="0.8mm"), width="120mm")
    assert (tmp_path / "out.svg").read_text() == expected.svg(width="120mm")
    assert expected.stipples["radius"].min() * 120 / 256 >= 0.39


@pytest.mark.parametrize(
    ("flags", "code", "told"),
    [
        (["--process", "vinil", "--width", "9cm"], 2, "--process is vinil, but it must be laser, vinyl"),
        (["--process", "vinyl"], 2, "--process is about sizes on paper: give --width or --page too"),
        (["--strict", "--width", "9cm"], 2, "--strict needs rules: give --process"),
        (["--min-gap", "0.4", "--width", "9cm"], 2, "--min-gap is 0.4, but it must have a unit: 0.4mm"),
        (["--min-area", "2mm", "--width", "9cm"], 2, '--min-area is "2mm", but it must be an area from 0.0001mm2'),
        (["--min-feature", "0mm", "--width", "9cm"], 2, '--min-feature is "0mm", but it must be a length from 0.01mm'),
        (["--islands", "sink", "--width", "9cm"], 2, '--islands is "sink", but it must be "allow", "report" or "bridge"'),
        (["--process", "vinyl", "--width", "2mm"], 1, "the rules leave nothing of a drawing 2 mm wide: it must be at least "),
        (["--process", "vinyl", "--width", "9cm", "--check", "out.svg"], 2, "the report must be another file than the drawing"),
        (["--process", "vinyl", "--width", "9cm", "--check", "out.txt"], 2, "the suffix of a report must be .json or .svg"),
        (["--process", "vinyl", "--page", "A9"], 2, '--page is "A9", but it must be A3'),
    ],
)
def test_bad_input_is_told_in_a_sentence(flags: list[str], code: int, told: str, tmp_path: Path) -> None:
    cv2.imwrite(str(tmp_path / "photo.png"), skimage.data.camera()[100:164, 180:244])
    result = run(native_binary(), "photo.png", "-o", "out.svg", *flags, cwd=tmp_path)
    assert_one_sentence(result, code)
    assert told in result.stderr.decode()
    assert sorted(path.name for path in tmp_path.iterdir()) == ["photo.png"]


def test_the_width_that_is_told_leaves_something(drawing: gs.Drawing) -> None:
    rules = gs.Rules(min_feature="6mm", min_gap="6mm")
    with pytest.raises(gs.InvalidInputError, match="leave nothing of a drawing 4 mm wide: it must be at least") as caught:
        drawing.enforce(rules, width="4mm")
    width = str(caught.value).rsplit("at least ", 1)[1].removesuffix(" wide").replace(" ", "")
    safe, _ = drawing.enforce(rules, width=width)
    assert len(safe.regions) + len(safe.stipples) > 1


@pytest.mark.parametrize(
    ("make", "told"),
    [
        (gs.Rules, "the rules hold no limit"),
        (lambda: gs.Rules(min_gap=-1), "min_gap is -1, but it must be a length from 0.01mm"),
        (lambda: gs.Rules(min_area="2mm"), 'min_area is "2mm", but it must be an area'),
        (lambda: gs.Rules(islands="sink"), "islands is"),  # type: ignore[arg-type]
        (lambda: gs.Rules.process("vynil"), "process is vynil, but it must be laser"),
        (lambda: gs.Rules.process("vinyl", min_hole="2mm"), "there is no rule min_hole"),
    ],
)
def test_rules_that_are_none(make: Any, told: str) -> None:
    with pytest.raises(gs.InvalidInputError, match=told):
        make()


def test_what_is_no_rules_and_no_size(drawing: gs.Drawing) -> None:
    with pytest.raises(gs.InvalidInputError, match=r"it must be graphstipple\.Rules"):
        drawing.check("vinyl", width="90mm")  # type: ignore[arg-type]
    for call in (drawing.check, drawing.enforce):
        with pytest.raises(gs.InvalidInputError, match="so the drawing needs a size: give a width or a page"):
            call(RULES)
        with pytest.raises(gs.InvalidInputError, match="has room for"):
            call(RULES, width="300mm", page="A4")


def test_rules_are_values() -> None:
    rules = gs.Rules(min_feature=np.float32(2), min_gap="1pt", min_area="0.02cm2")
    assert (rules.min_feature, rules.min_area, rules.min_dot, rules.islands) == ("0.529166667mm", "2mm2", None, "allow")
    assert pickle.loads(pickle.dumps(rules)) == rules == rules.replace()
    assert hash(rules) == hash(rules.replace(min_gap="1pt"))
    assert gs.Rules.process("stencil").islands == "bridge"
    assert {process.name for process in gs.processes()} >= {"laser", "vinyl", "stencil", "screen-print", "lino", "pen"}
