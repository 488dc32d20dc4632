"""What differs between two drawings is said and shown right: a golden drawing, and the same with one thing changed."""

from __future__ import annotations

import copy
import dataclasses
from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest
from tests import differences, test_golden
from tests.differences import CAME, CAPTION, GAP, PIXELS, WENT, ZOOM, State
from tests.support import GOLDEN, options_with

import graphstipple as gs

NO_PIXELS = "pixels: none differs by more than 3 grey levels"


@pytest.fixture(scope="module")
def golden() -> State:
    """Return a drawing with 27 dots, 8 curves, 9 regions and 704 nodes."""
    return test_golden.expected("camera")


def with_file(state: State, change: Callable[[dict[str, list]], object]) -> State:
    """Return a drawing whose file was changed."""
    file = copy.deepcopy(state.file)
    change(file)
    return dataclasses.replace(state, file=file)


def said(old: State, new: State) -> list[str]:
    """Return what is said of a change that does not show in the pixels."""
    *lines, pixels = differences.in_words(old, new)
    assert pixels == NO_PIXELS
    return lines


def test_of_a_drawing_that_is_the_same_nothing_is_said(golden: State) -> None:
    assert differences.in_words(golden, with_file(golden, lambda file: file.update(version="9.9.9"))) == []


def test_a_dot_that_came_and_one_that_went(golden: State) -> None:
    without = with_file(golden, lambda file: file["stipples"].pop(5))
    assert said(golden, without) == ["dots: 1 went, 26 as before"]
    assert said(without, golden) == ["dots: 1 came, 26 as before"]
    (dot,) = differences.dot_changes(golden, without).went
    assert dot == differences.dots(golden)[5]


def test_a_dot_that_moved_and_changed_its_radius(golden: State) -> None:
    def move(file: dict[str, list]) -> None:
        file["stipples"][3]["x"] += 0.3
        file["stipples"][3]["y"] -= 0.4
        file["stipples"][4]["radius"] += 0.125

    lines = said(golden, with_file(golden, move))
    assert lines == ["dots: 1 moved by up to 0.5 px, 1 changed radius by up to 0.125 px, 25 as before"]


def test_a_dot_is_matched_with_the_nearest_of_its_ink_within_reach(golden: State) -> None:
    def far(file: dict[str, list]) -> None:
        file["stipples"][3]["x"] += differences.REACH + 0.01

    assert said(golden, with_file(golden, far)) == ["dots: 1 came, 1 went, 26 as before"]

    def ink(file: dict[str, list]) -> None:
        file["stipples"][3]["ink"] = 1 - file["stipples"][3]["ink"]

    assert said(golden, with_file(golden, ink)) == ["dots: 1 came, 1 went, 26 as before"]

    def beside(dot: dict[str, float], *shifts: float) -> list[dict[str, float]]:
        return [{**dot, "x": dot["x"] + shift} for shift in shifts]

    def two(*shifts: float) -> State:
        return with_file(golden, lambda file: file.update(stipples=beside(file["stipples"][0], *shifts)))

    # Either could be either's, but the nearest are matched first: 1 with 1.25, and then 0 with -0.5.
    change = differences.dot_changes(two(0, 1), two(1.25, -0.5))
    assert sorted(round(b.x - a.x, 9) for a, b in change.changed) == [-0.5, 0.25]


def test_a_curve_that_changed_came_or_went(golden: State) -> None:
    paths = golden.file["curves"]
    at = next(i for i, path in enumerate(paths) if " Q" in path)

    def bend(file: dict[str, list]) -> None:
        # Its first Bézier's control point is elsewhere.
        start, control, rest = file["curves"][at].split(" ", 2)
        x, y = control[1:].split(",")
        file["curves"][at] = f"{start} Q{float(x) + 1.5},{y} {rest}"

    bent = with_file(golden, bend)
    assert said(golden, bent) == ["curves: 1 changed, 7 as before"]
    assert differences.curve_changes(golden, bent).changed == [(paths[at], bent.file["curves"][at])]
    without = with_file(golden, lambda file: file["curves"].pop(at))
    assert said(golden, without) == ["curves: 1 went, 7 as before"]
    assert said(without, golden) == ["curves: 1 came, 7 as before"]


def test_a_region_that_changed_its_ink_or_its_outline(golden: State) -> None:
    def ink(file: dict[str, list]) -> None:
        file["regions"][2]["ink"] = 1 - file["regions"][2]["ink"]

    assert said(golden, with_file(golden, ink)) == ["regions: 1 came, 1 went, 8 as before"]

    def move(file: dict[str, list]) -> None:
        file["regions"][2]["exterior"][0][0] += 0.1

    assert said(golden, with_file(golden, move)) == ["regions: 1 changed, 8 as before"]


def test_another_order_is_a_difference(golden: State) -> None:
    assert said(golden, with_file(golden, lambda file: file["stipples"].reverse())) == ["dots: 27 as before, in another order"]
    assert said(golden, with_file(golden, lambda file: file["curves"].reverse())) == ["curves: 8 as before, in another order"]


def test_labels_that_are_the_other_ones(golden: State) -> None:
    labels = golden.labels.copy()
    labels[[3, 50, 700]] ^= 1
    assert said(golden, dataclasses.replace(golden, labels=labels)) == [
        "labels: 3 of 704 nodes, in their order, have the other one"
    ]
    fewer = dataclasses.replace(golden, labels=labels[:-1])
    assert said(golden, fewer) == ["labels: of 703 nodes instead of 704"]


def test_counts_options_and_the_canvas_are_said_old_and_new(golden: State) -> None:
    counted = dataclasses.replace(golden, counts={**golden.counts, "regions": 11})
    assert said(golden, counted) == ["counts: regions 9 → 11"]

    def options(file: dict[str, dict]) -> None:
        file["options"]["sharpen"] = 3.0
        file["options"]["published"]["k1"] = 2.0
        file["canvas"]["width"] = 97

    new = said(golden, with_file(golden, options))
    assert new == [
        "options: sharpen 2.5 → 3.0, k1 1.0 → 2.0",
        "file: canvas {'width': 96, 'height': 64} → {'width': 97, 'height': 64}",
    ]


def test_pixels_are_counted_beyond_what_platforms_may_differ_by(golden: State) -> None:
    grey = dataclasses.replace(golden, raster=np.full_like(golden.raster, 100))
    raster = grey.raster.copy()
    raster[10, 20:23] = 103, 97, 101
    assert differences.in_words(grey, dataclasses.replace(grey, raster=raster)) == []
    raster[11, 20:23] = 104, 0, 100
    (line,) = differences.in_words(grey, dataclasses.replace(grey, raster=raster))
    assert line == "pixels: 2 of 24576 differ by more than 3 grey levels, by up to 100, by 52 on average"
    assert differences.in_words(grey, dataclasses.replace(grey, raster=raster[:-2])) == ["pixels: 192 x 126 instead of 192 x 128"]


def test_the_picture_shows_expected_difference_and_got_side_by_side(golden: State) -> None:
    dot = differences.dots(golden)[5]

    def move(file: dict[str, list]) -> None:
        file["stipples"].pop(5)
        file["stipples"].append({"x": 80.0, "y": 50.0, "radius": 2.0, "ink": dot.ink})

    raster = golden.raster.copy()
    raster[:4, :6] ^= 255
    new = dataclasses.replace(with_file(golden, move), raster=raster)
    sheet = np.asarray(differences.picture(golden, new))
    height, width = 64 * ZOOM, 96 * ZOOM
    assert sheet.shape == (height + CAPTION + 2 * GAP, 3 * width + 4 * GAP, 3)
    expected, difference, got = (
        sheet[CAPTION + GAP : CAPTION + GAP + height, GAP + i * (width + GAP) :][:, :width] for i in range(3)
    )
    each = ZOOM // 2
    assert np.array_equal(expected[each // 2 :: each, each // 2 :: each, 0], golden.raster)
    assert np.array_equal(got[each // 2 :: each, each // 2 :: each, 0], raster)
    assert {tuple(colour) for colour in difference[: 4 * each, : 6 * each].reshape(-1, 3)} == {PIXELS}

    def middle(colour: tuple[int, int, int]) -> np.ndarray:
        y, x = np.nonzero((difference == colour).all(axis=2))
        return np.array([x.min() + x.max() + 1, y.min() + y.max() + 1]) / 2 / ZOOM

    assert middle(WENT) == pytest.approx([dot.x, dot.y], abs=0.5)
    assert middle(CAME) == pytest.approx([80, 50], abs=0.5)
    # Captions stand above the panels, and the colours among them say what they mean.
    captions = sheet[: CAPTION + GAP // 2]
    for i in range(3):
        assert captions[:, GAP + i * (width + GAP) :][:, :60].min() < 64
    assert all((captions == colour).all(axis=2).any() for colour in (CAME, WENT, PIXELS))


def test_a_golden_test_fails_with_all_that_differs_and_the_path_of_the_picture(tmp_path: Path) -> None:
    changed = gs.draw(GOLDEN / "camera.png", options=options_with(density=1.0, refine=0))
    golden, new = test_golden.expected("camera"), test_golden.got(changed)
    with pytest.raises(pytest.fail.Exception) as failed:
        test_golden.assert_same("camera", golden, new, tmp_path / "golden")
    first, *lines = str(failed.value).splitlines()
    assert first == f"the drawing of camera is another one; expected, difference, got: {tmp_path / 'golden' / 'camera.png'}"
    assert [line.strip().split(":")[0] for line in lines] == ["dots", "curves", "regions", "labels", "counts", "options", "pixels"]
    assert "refine 12 → 0" in lines[5]
    change = differences.dot_changes(golden, new)
    came, went, pairs = map(len, (change.came, change.went, change.changed))
    assert golden.counts["stipples"] == change.same + pairs + went
    assert new.counts["stipples"] == change.same + pairs + came
    assert f"stipples {golden.counts['stipples']} → {new.counts['stipples']}" in lines[4]
    assert (tmp_path / "golden" / "camera.png").is_file()
    test_golden.assert_same("camera", golden, golden, tmp_path / "none")
    assert not (tmp_path / "none").exists()
