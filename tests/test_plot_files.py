"""Files of plots, opened by programs that are not ours (vpype, hp2xx, gcode-simulator, Inkscape), and read again by hand.

Each is compared with `Plot.paths`: nothing is lost, added or moved, and times are those of the simulator.
"""

from __future__ import annotations

import contextlib
import io
import itertools
import re
import shutil
import subprocess
import sys
from collections.abc import Iterator
from pathlib import Path
from typing import Any
from xml.etree import ElementTree

import numpy as np
import pytest
from numpy.typing import NDArray
from PIL import Image
from scipy import ndimage
from tests import readers
from tests.support import ROOT, photo

import graphstipple as gs

if sys.version_info >= (3, 11):
    import tomllib
else:
    import tomli as tomllib

HP2XX = shutil.which("hp2xx")
"""Where hp2xx is, if it is installed."""

PROFILES = {machine.name: machine for machine in gs.machines()}

SVG, INKSCAPE = "{http://www.w3.org/2000/svg}", "{http://www.inkscape.org/namespaces/inkscape}"

FILLS = ("contour", "hatch", "outline", "none")

MM = 96 / 25.4
"""What vpype, which counts in px, has to the mm."""

Way = NDArray[np.float64]


def drawn(name: str, width: int = 160, height: int = 120, preset: str = "default") -> gs.Drawing:
    """Return the drawing of a piece of a photo."""
    return gs.draw(photo(name, width, height), options=gs.Options.preset(preset))


@pytest.fixture(scope="module")
def drawing() -> gs.Drawing:
    """Regions of all sizes, and dots."""
    return drawn("camera")


@pytest.fixture(scope="module", params=FILLS)
def plot(request: pytest.FixtureRequest, drawing: gs.Drawing) -> gs.Plot:
    """The drawing in every fill, on a page with a margin."""
    return drawing.plot("0.4mm", "150mm", page="A4", fill=request.param)


@pytest.fixture(scope="module")
def blank() -> gs.Plot:
    """A plot of white paper."""
    return gs.draw(np.full((30, 40), 255, np.uint8)).plot("0.4mm", "40mm")


@pytest.fixture(scope="module")
def one_press() -> gs.Plot:
    """A plot of one dot."""
    luma = np.full((30, 40), 255, np.uint8)
    luma[14:16, 19:21] = 0
    plot = gs.draw(luma).plot("4mm", "40mm")
    assert [len(path) for path in plot.paths] == [1], "the dot is no press: make it smaller"
    return plot


def lengths(paths: list[Way]) -> NDArray[np.float64]:
    """Return how long each path is."""
    return np.array([np.hypot(*np.diff(path, axis=0).T).sum() for path in paths])


def origin(plot: gs.Plot) -> Way:
    """Return where the drawing's corner lies on its page: in the middle of what is left."""
    return (np.array(plot.page) - plot.size) / 2


def saved(plot: gs.Plot, path: Path, machine: str | Path | None = None) -> str:
    """Return the text of the plot's file."""
    plot.save(path, machine)
    return path.read_text("ascii")


def rounded(path: Way, step: float) -> Way:
    """Return a path in whole steps, without points that are where the one before them is."""
    steps = np.round(path / step)
    return steps[np.r_[True, np.any(np.diff(steps, axis=0) != 0, axis=1)]] * step


# Read again by hand --------------------------------------------------------------------------------------------------------------


def read_gcode(text: str, down: str = "M3", up: str = "M5") -> Iterator[Way]:
    """Yield what is drawn while the pen is down, as a controller takes it: modal coordinates, `G1` alone draws."""
    at, path = np.zeros(2), []
    for line in text.splitlines():
        words = line.split(";")[0].split()
        if not words:
            continue
        if words[0] == down:
            path = path or [at.copy()]
        elif words[0] == up:
            if path:
                yield np.array(path)
            path = []
        elif words[0] in ("G0", "G1"):
            assert (words[0] == "G1") == bool(path), f"{line} with the pen {'down' if path else 'up'}"
            for word in words[1:]:
                if word[0] in "XY":
                    at["XY".index(word[0])] = float(word[1:])
            if path:
                path.append(at.copy())
    assert not path, "the pen is left on the paper"
    np.testing.assert_array_equal(at, 0, "the machine is not at zero in the end")


def read_hpgl(text: str) -> Iterator[tuple[int, Way]]:
    """Yield what is drawn, in mm, with the number of the pen."""
    pen, at, path = 0, (0.0, 0.0), []
    for instruction in filter(None, (piece.strip() for piece in text.split(";"))):
        name, numbers = instruction[:2], [float(number) for number in instruction[2:].split(",") if number]
        points = list(zip(numbers[::2], numbers[1::2], strict=True)) if name in ("PU", "PD") else []
        if name == "SP":
            pen = int(numbers[0])
        elif name == "PD":
            path = [*(path or [at]), *points]
        elif name == "PU":
            if path:
                yield pen, np.array(path) / 40
            path = []
        at = points[-1] if points else at
    assert not path
    assert (pen, at) == (0, (0.0, 0.0)), "the pen is not put away"


def on_machine(plot: gs.Plot, profile: dict[str, Any]) -> list[Way]:
    """Return the paths where a machine whose zero is at the bottom left draws them, its y running up."""
    width, height = plot.page
    is_bare = np.allclose(plot.page, plot.size)
    offset = np.zeros(2) if is_bare else np.array(profile.get("offset", (0, 0)))
    across, up = profile["area"]
    beyond = max(width - across, 0) + max(height - up, 0)
    is_turned = max(height - across, 0) + max(width - up, 0) < beyond
    corner = origin(plot)
    ways = []
    for path in plot.paths:
        x, y = (path + corner).T
        ways.append((np.c_[y, x] if is_turned else np.c_[x, height - y]) - offset)
    return ways


def same_ways(found: list[Way], expected: list[Way], step: float) -> None:
    """Compare paths, within rounding to steps."""
    assert len(found) == len(expected)
    for way, path in zip(found, expected, strict=True):
        wanted = rounded(path, step)
        # Half a step may be rounded either way.
        if way.shape == wanted.shape:
            np.testing.assert_allclose(way, wanted, atol=1.01 * step)
        else:
            assert abs(lengths([way])[0] - lengths([path])[0]) < 4 * step * len(path)


@pytest.mark.parametrize("machine", ["grbl", "grbl-laser"])
def test_gcode_draws_the_paths_in_order(plot: gs.Plot, machine: str, tmp_path: Path) -> None:
    profile = tomllib.loads(PROFILES[machine].profile)
    text = saved(plot, tmp_path / "plot.gcode", machine)
    if machine == "grbl-laser":
        # Both switch it on, and M4 comes first.
        text = text.replace("M4 S300\nM3 S300", "M4 S300").replace("M4", "M3")
    same_ways(list(read_gcode(text)), on_machine(plot, profile), 0.001)
    assert all(len(line) <= 72 for line in text.splitlines())
    low, high = np.zeros(2), np.array(profile["area"])
    points = np.concatenate(list(read_gcode(text)))
    assert np.all(points >= low - 0.01)
    assert np.all(points <= high + 0.01)


@pytest.mark.parametrize("machine", ["hp7475a", "hp7475a-a3"])
def test_hpgl_draws_the_paths_in_order(plot: gs.Plot, machine: str, tmp_path: Path) -> None:
    profile = tomllib.loads(PROFILES[machine].profile)
    text = saved(plot, tmp_path / "plot.hpgl", machine)
    pens, ways = zip(*read_hpgl(text), strict=True)
    assert set(pens) == {1}
    same_ways(list(ways), on_machine(plot, profile), 0.025)
    assert max(map(len, text.split(";"))) < 512, "an instruction is longer than a buffer"


def test_svg_has_an_element_for_every_path(plot: gs.Plot, tmp_path: Path) -> None:
    root = ElementTree.fromstring(saved(plot, tmp_path / "plot.svg"))
    width, height = plot.page
    assert [root.get(name) for name in ("width", "height", "viewBox")] == [
        f"{width:g}mm",
        f"{height:g}mm",
        f"0 0 {width:g} {height:g}",
    ]
    layers = root.findall(f"{SVG}g")
    assert [layer.get(f"{INKSCAPE}label") for layer in layers] == ["1 black"]
    assert len(layers[0].findall(f"{SVG}path")) == len(plot.paths)
    assert {name: layers[0].get(name) for name in ("fill", "stroke-width", "stroke-linecap", "stroke-linejoin")} == {
        "fill": "none",
        "stroke-width": "0.4",
        "stroke-linecap": "round",
        "stroke-linejoin": "round",
    }


def test_the_same_plot_is_the_same_file(drawing: gs.Drawing, tmp_path: Path) -> None:
    first = drawing.plot("0.4mm", "150mm")
    again = drawn("camera").plot("0.4mm", "150mm")
    for suffix in ("svg", "gcode", "hpgl"):
        texts = [saved(plot, tmp_path / f"{i}.{suffix}") for i, plot in enumerate((first, again))]
        assert texts[0] == texts[1]
        assert str(tmp_path) not in texts[0]
        assert str(ROOT) not in texts[0]
        assert suffix == "hpgl" or gs.__version__ in texts[0]


# vpype ---------------------------------------------------------------------------------------------------------------------------


def read_by_vpype(path: Path) -> tuple[Any, dict[int, list[Way]]]:
    """Return a document of vpype, and the paths of its layers in mm."""
    vpype = pytest.importorskip("vpype", reason="vpype is for Python 3.11 and newer")
    document = vpype.read_multilayer_svg(str(path), quantization=0.01)
    ways = {number: [np.c_[line.real, line.imag] / MM for line in layer] for number, layer in document.layers.items()}
    return document, ways


def test_vpype_reads_the_paths_in_order(plot: gs.Plot, tmp_path: Path) -> None:
    plot.save(tmp_path / "plot.svg")
    document, ways = read_by_vpype(tmp_path / "plot.svg")
    np.testing.assert_allclose(np.array(document.page_size) / MM, plot.page, atol=0.001)
    assert list(ways) == [1]
    paths = [path + origin(plot) for path in plot.paths]
    assert len(ways[1]) == len(paths)
    presses = [len(path) == 1 for path in paths]
    for way, path, is_press in zip(ways[1], paths, presses, strict=True):
        np.testing.assert_allclose(way[0], path[0], atol=0.006)
        np.testing.assert_allclose(way[-1], path[-1], atol=0.006)
        if is_press:
            np.testing.assert_allclose(way[1] - way[0], (0.01, 0), atol=1e-6)
    assert sum(lengths(ways[1])) == pytest.approx(sum(lengths(paths)) + 0.01 * sum(presses), rel=1e-3)
    assert sum(lengths(plot.paths)) == pytest.approx(plot.stats["pen_down_mm"], rel=1e-4)
    assert document.layers[1].metadata["vp_pen_width"] / MM == pytest.approx(0.4, abs=1e-4)


def test_vpype_keeps_a_layer_for_every_pen(drawing: gs.Drawing, tmp_path: Path) -> None:
    both = drawing.plot("0.5mm", "120mm", only="black,white", refill="2m", paper="#808080")
    paths = {number: layer.paths for number, layer in enumerate(both.layers, 1)}
    assert list(paths) == [1, 2]
    for machine, pause in [(None, ""), ("axidraw", "!")]:
        text = saved(both, tmp_path / "plot.svg", machine)
        labels = re.findall('inkscape:label="([^"]*)"', text)
        assert labels[0] == "1 black"
        assert labels[1] == f"{pause}1 black, filling 2"
        assert f"{pause}2 white" in labels
        document, ways = read_by_vpype(tmp_path / "plot.svg")
        assert {number: len(layer) for number, layer in ways.items()} == {number: len(layer) for number, layer in paths.items()}
        colours = [document.layers[number].metadata["vp_color"].as_hex() for number in (1, 2)]
        assert colours == ["#000000", "#ffffff"]


# hp2xx ---------------------------------------------------------------------------------------------------------------------------

needs_hp2xx = pytest.mark.skipif(HP2XX is None, reason="hp2xx is not installed")


def by_hp2xx(path: Path, *arguments: str) -> str:
    """Convert a file by hp2xx at its true size; return what it says."""
    assert HP2XX is not None
    run = subprocess.run([HP2XX, "-t", *arguments, str(path)], capture_output=True, text=True, check=True, timeout=120)
    return run.stdout + run.stderr


@needs_hp2xx
def test_hp2xx_draws_as_much_and_as_large(plot: gs.Plot, tmp_path: Path) -> None:
    plot.save(tmp_path / "plot.hpgl", "hp7475a-a3")
    told = by_hp2xx(tmp_path / "plot.hpgl", "-m", "svg", "-f", str(tmp_path / "out.svg"))
    sides = re.search(r"Width\s+x\s+height:\s*([\d.]+) x\s*([\d.]+) mm, true sizes", told)
    assert sides is not None, told
    points = np.concatenate(plot.paths)
    # A portrait of A4 is turned on this machine or not, but as large.
    np.testing.assert_allclose(sorted(map(float, sides.groups())), sorted(np.ptp(points, axis=0)), atol=0.03)
    # It cuts long paths, and has points of 1/72 inch.
    pieces = re.findall(r'd="M([^"]*)"', (tmp_path / "out.svg").read_text("ascii"))
    ways = [np.array(re.findall(r"-?[\d.]+", piece), float).reshape(-1, 2) * 25.4 / 72 for piece in pieces]
    assert sum(lengths(ways)) == pytest.approx(plot.stats["pen_down_mm"], rel=0.005, abs=0.01)
    assert len(ways) >= len(plot.paths)


@needs_hp2xx
def test_hp2xx_paints_the_plot(plot: gs.Plot, tmp_path: Path) -> None:
    plot.save(tmp_path / "plot.hpgl", "hp7475a-a3")
    # Ten pixels to the mm, and lines of one pixel: what hp2xx makes of wider ones is joined at random.
    by_hp2xx(tmp_path / "plot.hpgl", "-m", "png", "-d", "254", "-p", "1", "-f", str(tmp_path / "out.png"))
    lines = np.asarray(Image.open(tmp_path / "out.png").convert("L")) < 128
    ours = plot.rasterize(round(10 * plot.size[0])) < 128
    # It leaves out the paper around what is drawn, and we have half a pen there.
    lines, ours = (ink[ndimage.find_objects(ink.astype(np.uint8))[0]] for ink in (lines, ours))
    around = np.subtract(ours.shape, lines.shape)
    assert np.all((around >= 0) & (around <= 4)), around
    lines = np.pad(lines, tuple((more // 2, more - more // 2) for more in around))
    assert ndimage.distance_transform_edt(~ours)[lines].max() <= 2, "a line is where nothing is drawn"
    assert ndimage.distance_transform_edt(~lines)[ours].max() <= 4, "a line is missing"


# gcode-simulator -----------------------------------------------------------------------------------------------------------------

OWN = """
name = "Own"
format = "gcode"
area = [400, 400]
draw_speed = {draw}
travel_speed = [{travel}, {travel}]
acceleration = [{acceleration}, {acceleration}]
junction_deviation = {deviation}
pen_down_seconds = 0.2
pen_up_seconds = 0.12
press_seconds = 0.3
pen_down = "M3\\nG4 P{{seconds}}"
pen_up = "M5\\nG4 P{{seconds}}"
"""

FAST = OWN.format(draw=150, travel=300, acceleration=3000, deviation=0.02)
SLOW = OWN.format(draw=40, travel=50, acceleration=100, deviation=0.01)


def simulated(path: Path, profile: dict[str, Any]) -> float:
    """Return the seconds that gcode-simulator finds for a file."""
    simulator = pytest.importorskip("gcode_simulator")
    (across, up), (quick, quicker) = profile["travel_speed"], profile["acceleration"]
    settings = simulator.GrblSettings(60 * across, 60 * up, quick, quicker, profile["junction_deviation"])
    # It prints where a corner comes too soon for its own planning.
    with contextlib.redirect_stdout(io.StringIO()):
        seconds, _ = simulator.GCodeSimulator(settings).estimate_time(path.read_text("ascii"))
    return float(seconds)


@pytest.mark.parametrize("machine", ["grbl", "grbl-laser", FAST, SLOW], ids=["grbl", "grbl-laser", "fast", "slow"])
def test_time_is_that_of_the_simulator(plot: gs.Plot, machine: str, tmp_path: Path) -> None:
    name: str | Path = machine
    profile = tomllib.loads(machine) if "=" in machine else tomllib.loads(PROFILES[machine].profile)
    if "=" in machine:
        name = tmp_path / "own.toml"
        name.write_text(machine)
    plot.save(tmp_path / "plot.gcode", name)
    assert plot.time(name) == pytest.approx(simulated(tmp_path / "plot.gcode", profile), rel=0.05)


@pytest.mark.parametrize(("name", "preset"), [("astronaut", "poster"), ("chelsea", "stipple"), ("coffee", "linocut")])
def test_time_of_long_curves_and_many_dots_is_that_of_the_simulator(name: str, preset: str, tmp_path: Path) -> None:
    drawing = drawn(name, 200, 160, preset)
    profile = tomllib.loads(PROFILES["grbl"].profile)
    for fill, dots in [("contour", "press"), ("hatch", "circle")]:
        plot = drawing.plot("0.7mm", "190mm", fill=fill, dots=dots)
        plot.save(tmp_path / "plot.gcode")
        assert plot.time("grbl") == pytest.approx(simulated(tmp_path / "plot.gcode", profile), rel=0.05)


def test_time_is_the_sum_of_its_parts(plot: gs.Plot, tmp_path: Path) -> None:
    parts = ("drawing_s", "travel_s", "pen_s", "dwell_s")
    assert plot.stats["seconds"] == pytest.approx(sum(plot.stats[part] for part in parts))
    assert plot.stats["lifts"] == len(plot.paths)
    assert plot.stats["presses"] == sum(len(path) == 1 for path in plot.paths)
    profile = PROFILES["grbl"].profile
    quick = tmp_path / "quick.toml"
    quick.write_text(profile.replace("draw_speed = 30", "draw_speed = 60").replace("[500, 500]", "[1000, 1000]"))
    sudden = tmp_path / "sudden.toml"
    sudden.write_text(profile + 'cornering = "grbl"\n')
    # Along the way alone, nothing can be faster than the pen.
    least = plot.stats["pen_down_mm"] / 30
    assert plot.time(quick) < plot.time("grbl")
    assert least < plot.time(sudden) <= plot.time("grbl")


# Inkscape ------------------------------------------------------------------------------------------------------------------------


def by_inkscape(path: Path, dpi: float) -> Way:
    """Paint an SVG by Inkscape on white paper, as a share of white."""
    png = path.with_suffix(".png")
    command = [str(readers.INKSCAPE), str(path), "--export-type=png", f"--export-dpi={dpi}", f"--export-filename={png}"]
    subprocess.run([*command, "--export-background=#ffffff"], check=True, capture_output=True, timeout=300)
    return np.asarray(Image.open(png).convert("L")) / 255


@pytest.mark.skipif(readers.INKSCAPE is None, reason="Inkscape is not installed")
@pytest.mark.parametrize("fill", ["contour", "none"])
def test_inkscape_paints_the_plot(drawing: gs.Drawing, fill: Any, tmp_path: Path) -> None:
    plot = drawing.plot("0.4mm", "160mm", fill=fill)
    plot.save(tmp_path / "plot.svg")
    painted = by_inkscape(tmp_path / "plot.svg", 254)
    ours = plot.rasterize(1600) / 255
    assert painted.shape == ours.shape
    assert abs(painted.mean() - ours.mean()) < 0.002
    assert np.abs(painted - ours).mean() < 0.01
    for path in plot.paths:
        x, y = (10 * path[0]).astype(int)
        assert painted[y, x] < 0.5, f"nothing is drawn at {path[0]} mm"


# Nothing, and one press ----------------------------------------------------------------------------------------------------------


def test_a_plot_of_nothing_is_a_sound_file(blank: gs.Plot, tmp_path: Path) -> None:
    assert blank.paths == []
    assert blank.stats["seconds"] == 0
    assert list(read_gcode(saved(blank, tmp_path / "plot.gcode"))) == []
    assert list(read_hpgl(saved(blank, tmp_path / "plot.hpgl"))) == []
    root = ElementTree.fromstring(saved(blank, tmp_path / "plot.svg"))
    assert root.findall(f".//{SVG}path") == []
    document, ways = read_by_vpype(tmp_path / "plot.svg")
    np.testing.assert_allclose(np.array(document.page_size) / MM, (40, 30), atol=0.001)
    assert not any(ways.values())


def test_one_press_is_drawn(one_press: gs.Plot, tmp_path: Path) -> None:
    [[[x, y]]] = one_press.paths
    [way] = read_gcode(saved(one_press, tmp_path / "plot.gcode"))
    np.testing.assert_allclose(way, [(x, 30 - y)], atol=0.001)
    [(_, way)] = read_hpgl(saved(one_press, tmp_path / "plot.hpgl"))
    assert len(np.unique(way, axis=0)) == 1
    np.testing.assert_allclose(way[0], (x, 30 - y), atol=0.013)
    one_press.save(tmp_path / "plot.svg")
    _, ways = read_by_vpype(tmp_path / "plot.svg")
    assert lengths(ways[1]) == pytest.approx([0.01], abs=1e-6)
    profile = tomllib.loads(PROFILES["grbl"].profile)
    assert one_press.time("grbl") == pytest.approx(simulated(tmp_path / "plot.gcode", profile), rel=0.001)


def test_a_pen_is_filled_and_changed(drawing: gs.Drawing, tmp_path: Path) -> None:
    one = drawing.plot("0.4mm", "120mm", refill="1500mm")
    text = saved(one, tmp_path / "plot.gcode")
    pieces = text.split("M0\n")
    assert len(pieces) > 2
    for i, piece in enumerate(pieces):
        ways = list(read_gcode(piece + ("" if i == len(pieces) - 1 else "G0 X0 Y0\n")))
        line = lengths(ways)
        if i < len(pieces) - 1:
            assert sum(line[:-1]) <= 1500.1, "it drew on without ink"
            assert sum(line) > 1499.9, "it was filled too soon"
    both = drawing.plot("0.4mm", "120mm", only="black,white")
    assert saved(both, tmp_path / "plot.gcode").count("M0\n") == 1
    pens = [pen for pen, _ in read_hpgl(saved(both, tmp_path / "plot.hpgl"))]
    assert [pen for pen, _ in itertools.groupby(pens)] == [1, 2]
    with pytest.raises(gs.InvalidInputError, match="waits until its pen is filled again, but the machine HP 7475A"):
        one.save(tmp_path / "other.hpgl")


# What is refused -----------------------------------------------------------------------------------------------------------------


def test_what_a_machine_does_not_reach_is_refused_with_a_width_that_fits(drawing: gs.Drawing, tmp_path: Path) -> None:
    for settings, suffix, machine in [
        ({"width": "600mm"}, "gcode", "grbl"),
        ({"width": "600mm"}, "svg", "axidraw"),
        ({"page": "A3"}, "gcode", "grbl"),
        ({"page": "A4"}, "hpgl", "hp7475a"),
    ]:
        with pytest.raises(gs.InvalidInputError, match=r"but the machine .* a width of .*mm would fit") as caught:
            drawing.plot("1mm", fill="outline", **settings).save(tmp_path / f"plot.{suffix}", machine)
        message = str(caught.value)
        assert "\n" not in message
        assert not (tmp_path / f"plot.{suffix}").exists()
        width = re.search(r"a width of ([\d.]+mm) would fit", message)
        assert width is not None, message
        # And so it does, where somewhat more does not.
        fitting = settings | {"width": width[1]}
        drawing.plot("1mm", fill="outline", **fitting).save(tmp_path / f"plot.{suffix}", machine)
        (tmp_path / f"plot.{suffix}").unlink()
        larger = settings | {"width": f"{1.03 * float(width[1][:-2]) + 3}mm"}
        with pytest.raises(gs.InvalidInputError):
            drawing.plot("1mm", fill="outline", **larger).save(tmp_path / f"plot.{suffix}", machine)


@pytest.mark.parametrize(
    ("profile", "message"),
    [
        ("", "the profile of the machine lacks name, format, area, draw_speed, travel_speed and acceleration"),
        ("G21\nG90\n", "line 1 of the machine's profile is no TOML"),
        (FAST + "wings = 2", "there is no key wings in the profile of a machine"),
        (FAST + "pres_seconds = 2", r"there is no key pres_seconds in the profile of a machine; did you mean press_seconds\?"),
        (FAST.replace("speed = 150", "speed = -150"), "draw_speed is -150, but it must be a number between 0.001 and 10000"),
        (FAST.replace("area = [400, 400]", "area = 400"), "area is 400, but it must be two numbers between 1 and 100000"),
        (FAST.replace('"gcode"', '"svg"'), "pen_down is a key of machines for gcode, but this one is for svg"),
        (FAST.replace("{seconds}", "{secnds}"), r"pen_down has {secnds}, which stands for nothing; did you mean {seconds}\?"),
    ],
    ids=["empty", "no TOML", "unknown", "nearly", "negative", "one number", "of another format", "placeholder"],
)
def test_profiles_with_mistakes_are_refused_in_one_sentence(one_press: gs.Plot, profile: str, message: str, tmp_path: Path) -> None:
    path = tmp_path / "own.toml"
    path.write_text(profile)
    for act in (lambda: one_press.time(path), lambda: one_press.save(tmp_path / "plot.gcode", path)):
        with pytest.raises(gs.GraphStippleError, match=message) as caught:
            act()
        assert "\n" not in str(caught.value)
    assert not (tmp_path / "plot.gcode").exists()


def test_a_machine_takes_files_of_its_own_kind(one_press: gs.Plot, tmp_path: Path) -> None:
    with pytest.raises(gs.InvalidInputError, match="the machine AxiDraw V3 reads svg, not gcode"):
        one_press.save(tmp_path / "plot.gcode", "axidraw")
    with pytest.raises(gs.InvalidInputError, match=r"axidrw, but it must be axidraw, .* did you mean axidraw\?"):
        one_press.time("axidrw")
