"""Plots: a drawing as paths for a pen. What is drawn is compared with what there is to draw, by pixels and by shapely."""

from __future__ import annotations

import json
from pathlib import Path
from typing import Any

import cv2
import numpy as np
import numpy.typing as npt
import pytest
import shapely
import skimage.data
from tests.commands import assert_one_sentence, native_binary, run
from tests.support import ROOT

import graphstipple as gs
from graphstipple import stages

WIDTH = 60.0
PEN = 0.3
PX_PER_MM = 24


@pytest.fixture(scope="module")
def drawing() -> gs.Drawing:
    """A drawing with dots of both inks, shapes, and parts narrower than the pen."""
    return gs.draw(skimage.data.camera()[60:316, 100:356], options=gs.Options(nodes=6000))


@pytest.fixture(scope="module")
def plots(drawing: gs.Drawing) -> dict[str, gs.Plot]:
    """The drawing by every fill."""
    return {fill: drawing.plot(f"{PEN}mm", f"{WIDTH}mm", fill=fill) for fill in ("contour", "hatch", "outline", "none")}


def painted(picture: gs.Drawing | gs.Plot) -> npt.NDArray[np.bool_]:
    """Black pixels."""
    return picture.rasterize(round(WIDTH * PX_PER_MM)) < 128


def length(path: npt.NDArray[np.float64]) -> float:
    return float(np.hypot(*np.diff(path, axis=0).T).sum())


@pytest.mark.parametrize("fill", ["contour", "hatch"])
def test_a_filled_plot_has_the_tone_of_the_drawing(drawing: gs.Drawing, plots: dict[str, gs.Plot], fill: str) -> None:
    wide = drawing.with_min_dot(f"{PEN / 2}mm", width=f"{WIDTH}mm")
    assert wide.stats["dots_enlarged"] + wide.stats["dots_dropped"] >= 0
    plot = wide.plot(f"{PEN}mm", f"{WIDTH}mm", fill=fill)
    assert plot.stats["small_dots"] == 0
    grey = [picture.rasterize(round(WIDTH * PX_PER_MM)).mean() / 255 for picture in (wide, plot)]
    assert abs(grey[0] - grey[1]) < 0.02
    del plots


@pytest.mark.parametrize("fill", ["contour", "hatch"])
def test_regions_are_covered_and_nothing_else(drawing: gs.Drawing, plots: dict[str, gs.Plot], fill: str) -> None:
    """Where a region is as wide as the pen it is drawn, and what lies a pen's half away from black stays white."""
    black, drawn = painted(drawing), painted(plots[fill])
    disc = cv2.getStructuringElement(cv2.MORPH_ELLIPSE, (round(PEN * PX_PER_MM) + 1,) * 2)
    wide = cv2.morphologyEx(black.astype(np.uint8), cv2.MORPH_OPEN, disc).astype(bool)
    assert (wide & ~drawn).sum() < 0.01 * wide.sum()
    far = cv2.dilate(black.astype(np.uint8), disc) == 0
    assert (far & drawn).sum() == 0
    assert abs(int(drawn.sum()) - int(black.sum())) < 0.04 * black.sum()


def test_white_dots_as_wide_as_the_pen_stay_open(drawing: gs.Drawing, plots: dict[str, gs.Plot]) -> None:
    scale = WIDTH / drawing.width
    dots = drawing.stipples[(drawing.stipples["ink"] == 1) & (2 * drawing.stipples["radius"] * scale >= PEN)]
    assert len(dots) > 20
    for fill in ("contour", "hatch", "outline"):
        drawn = painted(plots[fill])
        rows, columns = ((dots[axis] * scale * PX_PER_MM).astype(int) for axis in ("y", "x"))
        assert not drawn[rows, columns].any()


def test_paths_are_in_mm_and_in_the_drawing(plots: dict[str, gs.Plot]) -> None:
    for plot in plots.values():
        width, height = plot.size
        assert (width, round(height, 6)) == (pytest.approx(WIDTH), pytest.approx(WIDTH))
        points = np.concatenate(plot.paths)
        assert points.dtype == np.float64
        assert points.min() >= 0
        assert (points <= [width, height]).all()
        assert plot.stats["paths"] == len(plot.paths) == plot.stats["lifts"]
        assert plot.stats["presses"] == sum(len(path) == 1 for path in plot.paths)
        assert plot.stats["pen_down_mm"] == pytest.approx(sum(map(length, plot.paths)), rel=1e-3)


def test_dots_are_pressed_or_drawn(drawing: gs.Drawing) -> None:
    scale = WIDTH / drawing.width
    dots = drawing.stipples[drawing.stipples["ink"] == 0]
    diameters = 2 * dots["radius"] * scale
    # None is as wide as this, to the last digit.
    pen = round(float(np.median(diameters)), 3) + 0.0004
    plot = drawing.plot(f"{pen}mm", f"{WIDTH}mm", fill="none", order="none")
    assert len(plot.paths) == len(dots)
    assert [len(path) == 1 for path in plot.paths] == (diameters <= 1.15 * pen).tolist()
    assert plot.stats["small_dots"] == (diameters < pen).sum()
    for path, dot in zip(plot.paths, dots, strict=True):
        from_centre = np.hypot(*(path - [dot["x"] * scale, dot["y"] * scale]).T)
        assert from_centre.max() <= max(dot["radius"] * scale - pen / 2, 0) + 1e-6
    rims = drawing.plot(f"{pen}mm", f"{WIDTH}mm", fill="none", dots="circle", order="none")
    assert all(len(path) == 1 or (path[0] == path[-1]).all() for path in rims.paths)


def test_the_order_is_short_and_keeps_every_path(drawing: gs.Drawing) -> None:
    as_read, short = (drawing.plot("0.3mm", "60mm", order=order) for order in ("none", "short"))
    assert short.stats["pen_up_mm"] < 0.3 * as_read.stats["pen_up_mm"]
    assert short.stats["pen_down_mm"] == pytest.approx(as_read.stats["pen_down_mm"])

    def shapes(plot: gs.Plot) -> list[Any]:
        return sorted(
            (len(path), *np.round(np.sort(path, axis=0).sum(axis=0) - path[-1] * (path[0] == path[-1]).all(), 6))
            for path in plot.paths
        )

    assert [shape[0] for shape in shapes(as_read)] == [shape[0] for shape in shapes(short)]


@pytest.mark.parametrize("threads", ["1", "2"])
def test_the_command_line_and_python_write_the_same(tmp_path: Path, drawing: gs.Drawing, threads: str) -> None:
    photo = tmp_path / "photo.png"
    cv2.imwrite(str(photo), skimage.data.camera()[60:316, 100:356])
    drawing = gs.draw(photo, options=gs.Options(nodes=6000))
    plot = drawing.plot("0.4mm", "60mm", fill="hatch", angle=30, overlap=0.2, refill="2m")
    for suffix, machine in [("svg", None), ("gcode", "grbl"), ("hpgl", None)]:
        written, file = tmp_path / f"command.{suffix}", tmp_path / f"python.{suffix}"
        flags = [
            "--nodes",
            "6000",
            "--width",
            "60mm",
            "--pen",
            "0.4mm",
            "--pen-fill",
            "hatch",
            "--pen-angle",
            "30",
            "--pen-overlap",
            "0.2",
            "--pen-refill",
            "2m",
        ]
        flags += ["--threads", threads, *(["--machine", machine] if machine else [])]
        if suffix == "hpgl":
            # An HP-GL plotter has no command to wait with.
            refused = run(native_binary(), photo, "-o", written, *flags)
            assert_one_sentence(refused, 1)
            assert b"no command for a pause" in refused.stderr
            continue
        done = run(native_binary(), photo, "-o", written, *flags)
        assert (done.returncode, done.stderr) == (0, b"")
        plot.save(file, machine)
        assert written.read_bytes() == file.read_bytes()


def test_stats_and_preview_of_the_command_are_those_of_the_plot(tmp_path: Path) -> None:
    photo = tmp_path / "photo.png"
    cv2.imwrite(str(photo), skimage.data.camera()[60:316, 100:356])
    output, preview = tmp_path / "plot.svg", tmp_path / "preview.png"
    flags = ["--nodes", "3000", "--width", "60mm", "--pen", "0.5mm", "--stats"]
    done = run(native_binary(), photo, "-o", output, "--preview", preview, *flags)
    assert done.returncode == 0, done.stderr
    plot = gs.draw(photo, options=gs.Options(nodes=3000)).plot("0.5mm", "60mm")
    assert json.loads(done.stdout)["plot"] == pytest.approx(plot.stats)
    assert (cv2.imread(str(preview), cv2.IMREAD_UNCHANGED) == plot.rasterize()).all()


def test_the_finest_drawing_that_is_plotted_in_time(tmp_path: Path) -> None:
    photo = tmp_path / "photo.png"
    cv2.imwrite(str(photo), skimage.data.camera()[60:316, 100:356])
    whole = gs.draw(photo).plot("0.5mm", "60mm").time()
    most = int(whole / 2)
    flags = f"--width 60mm --pen 0.5mm --max-plot-time {most}s --stats".split()
    done = run(native_binary(), photo, "-o", tmp_path / "plot.svg", *flags)
    assert done.returncode == 0, done.stderr
    stats = json.loads(done.stdout)
    assert 0.85 * most < stats["plot"]["seconds"] <= most
    assert stats["within"]["seconds"] == np.ceil(stats["plot"]["seconds"])
    refused = run(native_binary(), photo, "-o", tmp_path / "none.svg", *flags[:-2], "2s")
    assert_one_sentence(refused, 2)
    assert b"error: --max-plot-time is 2s, but it must be at least " in refused.stderr
    assert not (tmp_path / "none.svg").exists()


@pytest.mark.parametrize(
    ("flags", "told"),
    [
        ("--pen 0mm", '--pen is "0mm", but it must be a width of at least 0.01mm'),
        ("--pen 0.3", "--pen is 0.3, but it must have a unit: 0.3mm"),
        ("--pen 80mm", "--pen is 80mm, but it must be at most the shorter side of the drawing, 60.000 mm"),
        ("--pen 0.3mm --pen-fill full", '--pen-fill is "full", but it must be "contour"'),
        ("--pen 0.3mm --pen-overlap 1", "--pen-overlap is 1, but it must be a number between -9 and 0.9"),
        ("--pen 0.3mm --pen-bleed 0.2mm", "--pen-bleed is 0.2mm, but it must be at most half the pen's width"),
        ("--pen 0.3mm --machine axi", "--machine is axi, but it must be axidraw, grbl"),
        ("--pen 0.3mm --machine ./none.toml", "./none.toml: the file does not exist"),
        ("--pen 0.3mm --max-plot-time soon", "--max-plot-time is soon, but it must be a time"),
        ("--pen-fill hatch", "the following required arguments were not provided: --pen"),
    ],
)
def test_what_is_wrong_is_told_in_one_sentence(tmp_path: Path, flags: str, told: str) -> None:
    photo = tmp_path / "photo.png"
    cv2.imwrite(str(photo), np.full((60, 60), 90, np.uint8))
    refused = run(native_binary(), photo, "-o", tmp_path / "plot.svg", "--width", "60mm", *flags.split())
    assert_one_sentence(refused, 1 if "none.toml" in flags else 2)
    assert refused.stderr.decode().startswith(f"graphstipple: error: {told}"), refused.stderr
    assert not (tmp_path / "plot.svg").exists()


def test_files_of_plots_need_a_pen(tmp_path: Path, drawing: gs.Drawing) -> None:
    with pytest.raises(gs.InvalidInputError, match=r"a file of \.gcode is a plot's, which needs the width of a pen"):
        drawing.save(tmp_path / "a.gcode")
    plot = drawing.plot("1mm", "60mm")
    with pytest.raises(gs.InvalidInputError, match=r"the suffix of a plot must be \.svg, \.gcode or \.hpgl"):
        plot.save(tmp_path / "a.pdf")
    with pytest.raises(gs.InvalidInputError, match="the machine GRBL plotter reads gcode, not svg"):
        plot.save(tmp_path / "a.svg", "grbl")
    with pytest.raises(gs.InvalidInputError, match="machine is None, but it must be the name"):
        plot.time(None)  # type: ignore[arg-type]  # what a type checker refuses
    with pytest.raises(gs.InvalidInputError, match='fill is "all", but it must be "contour"'):
        drawing.plot("1mm", fill="all")  # type: ignore[arg-type]  # likewise
    assert not list(tmp_path.iterdir())


@pytest.mark.parametrize("fill", ["contour", "hatch"])
def test_lines_may_lie_apart(drawing: gs.Drawing, fill: str) -> None:
    near, apart = (drawing.plot("0.3mm", "60mm", fill=fill, overlap=overlap) for overlap in (0, -2))
    assert apart.stats["pen_down_mm"] < 0.6 * near.stats["pen_down_mm"]
    assert (painted(apart) & ~painted(near)).sum() < 0.02 * painted(near).sum()


def test_machines_come_with_profiles(drawing: gs.Drawing, tmp_path: Path) -> None:
    plot = drawing.plot("1mm", "60mm")
    names = [machine.name for machine in gs.machines()]
    assert names[0] == "axidraw"
    times = [plot.time(name) for name in names]
    assert all(time > 0 for time in times)
    assert len(set(times)) > 1
    profile = tmp_path / "mine.toml"
    profile.write_text(gs.machines()[1].profile)
    assert plot.time(profile) == plot.time("grbl")


def test_the_profile_of_the_documentation_is_a_machine(drawing: gs.Drawing, tmp_path: Path) -> None:
    page = (ROOT / "docs/howto/plotter.md").read_text(encoding="utf-8")
    profile = tmp_path / "mine.toml"
    profile.write_text(page.split("```toml\n")[1].split("```")[0], encoding="utf-8")
    assert drawing.plot("1mm", "60mm").time(profile) > 0


def test_a_drawing_of_one_ink_is_plotted() -> None:
    black, white = (gs.draw(np.full((40, 60), value, np.uint8)) for value in (0, 255))
    assert white.plot("1mm", "60mm").paths == []
    plot = black.plot("1mm", "60mm")
    assert len(plot.paths) >= 1
    assert (plot.rasterize(600) < 128).mean() > 0.995
    both = black.plot("1mm", "60mm", only="black,white")
    assert [layer.ink for layer in both.layers] == ["black"]


# Areas that are moved in and out.


def polygons_of(drawing: gs.Drawing) -> list[list[npt.NDArray[np.float64]]]:
    return [[region.exterior, *region.holes] for region in drawing.regions if region.ink == 0]


def as_shapely(polygons: list[list[npt.NDArray[np.float64]]]) -> shapely.MultiPolygon:
    return shapely.MultiPolygon([shapely.Polygon(rings[0], rings[1:]) for rings in polygons])


@pytest.mark.parametrize("distance", [-3.0, -1.0, -0.4, 0.5, 2.0])
def test_moved_areas_are_those_of_shapely(drawing: gs.Drawing, distance: float) -> None:
    polygons = polygons_of(drawing)
    ours = as_shapely(stages.offset(polygons, distance, tolerance=0.002))
    theirs = as_shapely(polygons).buffer(distance, quad_segs=64)
    assert ours.is_valid
    assert ours.area == pytest.approx(theirs.area, rel=2e-3, abs=0.5)
    assert ours.symmetric_difference(theirs).area < 0.004 * as_shapely(polygons).length


def test_insets_are_where_a_distance_transform_has_them(drawing: gs.Drawing) -> None:
    scale = 8
    # Black dots too, and what lies outside the canvas is white.
    black = (drawing.rasterize(drawing.width * scale) < 128).astype(np.uint8)
    within = cv2.distanceTransform(cv2.copyMakeBorder(black, 1, 1, 1, 1, cv2.BORDER_CONSTANT), cv2.DIST_L2, cv2.DIST_MASK_PRECISE)
    polygons = [[np.array(ring.coords)[:-1] for ring in (area.exterior, *area.interiors)] for area in drawing.to_shapely().geoms]
    for distance in (0.5, 1.5, 4.0):
        moved = as_shapely(stages.offset(polygons, -distance)).area
        # From the middle of a pixel to the middle of the nearest white one.
        assert moved == pytest.approx((within > distance * scale + 0.5).sum() / scale**2, rel=0.01, abs=5)


def test_nested_insets_keep_few_points(drawing: gs.Drawing) -> None:
    polygons = polygons_of(drawing)
    counts = []
    for _ in range(6):
        counts.append(sum(len(ring) for polygon in polygons for ring in polygon))
        polygons = stages.offset(polygons, -0.4)
    assert max(counts) < 2 * counts[0]
    assert counts[-1] < 1.5 * counts[0]


def test_what_cannot_be_moved_is_told() -> None:
    square = np.array([[0.0, 0.0], [4.0, 0.0], [4.0, 4.0], [0.0, 4.0]])
    assert stages.offset([], 1.0) == []
    assert stages.offset([[square]], -3.0) == []
    with pytest.raises(gs.InvalidInputError, match="not finite"):
        stages.offset([[square * np.nan]], 1.0)
    with pytest.raises(gs.InvalidInputError, match="must be finite"):
        stages.offset([[square]], float("inf"))
    with pytest.raises(gs.InvalidInputError, match="must be finite, and the tolerance above 0"):
        stages.offset([[square]], 1.0, tolerance=0.0)
    with pytest.raises(gs.InvalidInputError, match=r"\(n, 2\)"):
        stages.offset([[np.zeros((3, 3))]], 1.0)
