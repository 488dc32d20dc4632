"""The command line, the native binary and the console script, against Python."""

from __future__ import annotations

import dataclasses
import json
import math
import os
import re
import subprocess
import sysconfig
from collections.abc import Iterable
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from PIL import Image
from tests import readers
from tests.commands import FAILURE, USAGE, assert_one_sentence, done, native_binary, run
from tests.support import PUBLISHED, options_with, photo

import graphstipple as gs
from graphstipple import _core

SUFFIXES = [suffix for suffix, *_ in _core.formats()]

CONSOLE_SCRIPT = Path(sysconfig.get_path("scripts")) / "graphstipple"


@pytest.fixture(scope="session")
def command() -> Path:
    return native_binary()


@pytest.fixture(scope="session", params=["native", "console script"])
def program(request: pytest.FixtureRequest) -> Path:
    """Each way in."""
    if request.param == "native":
        return request.getfixturevalue("command")
    assert CONSOLE_SCRIPT.is_file(), "pip installs the console script beside this interpreter's other scripts"
    return CONSOLE_SCRIPT


@pytest.fixture(scope="session")
def photos(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Make a folder with a few photos in the formats that users have."""
    folder = tmp_path_factory.mktemp("photos")
    Image.fromarray(photo("coffee", 150, 110)).save(folder / "coffee.png")
    Image.fromarray(photo("astronaut", 150, 110)).save(folder / "astronaut.jpg", quality=85)
    turned = Image.fromarray(photo("chelsea", 150, 110))
    exif = turned.getexif()
    exif[0x0112] = 6
    turned.save(folder / "turned.jpg", quality=90, exif=exif)
    Image.fromarray(photo("camera", 150, 110).astype(np.uint16) * 257 + 13).save(folder / "deep.png")
    clear = np.dstack([photo("rocket", 150, 110), np.linspace(0, 255, 150).astype(np.uint8)[None].repeat(110, 0)])
    Image.fromarray(clear).save(folder / "clear.png")
    Image.fromarray(photo("rocket", 150, 110)).save(folder / "rocket.webp", quality=80)
    Image.fromarray(photo("camera", 150, 110)).save(folder / "camera.tif")
    Image.fromarray(photo("coffee", 75, 50)[..., 0]).save(folder / "map.png")
    return folder


def flags(**changes: object) -> list[object]:
    """Return what changes these options on the command line, parameters of the published method among them."""
    return [
        part
        for name, value in changes.items()
        for part in (("--published", f"{name}={value}") if name in PUBLISHED else (f"--{name.replace('_', '-')}", value))
    ]


# The same drawing on all ways in -------------------------------------------------------------------------------------------------

FILES = ["coffee.png", "astronaut.jpg", "turned.jpg", "deep.png", "clear.png", "rocket.webp", "camera.tif"]


@pytest.mark.parametrize("name", FILES)
def test_the_same_file_gives_the_same_svg(program, photos, tmp_path, name):
    done(program, photos / name, "-o", tmp_path / "out.svg")
    assert (tmp_path / "out.svg").read_bytes() == gs.draw(photos / name).svg().encode()


@pytest.mark.parametrize("name", ["coffee.png", "astronaut.jpg"])
def test_the_same_map_gives_the_same_svg(program, photos, tmp_path, name):
    arguments = [
        "--importance",
        photos / "map.png",
        "--published",
        "density=1.5",
        "--nodes",
        4000,
        "--relax",
        2,
        "--published",
        "alpha=1",
        "--published",
        "lattice=square",
    ]
    done(program, photos / name, "-o", tmp_path / "out.svg", *arguments, "--threads", 2)
    options = options_with(density=1.5, nodes=4000, relax=2, alpha=1.0, lattice="square")
    assert (tmp_path / "out.svg").read_bytes() == gs.draw(
        photos / name, importance=photos / "map.png", options=options
    ).svg().encode()


@pytest.mark.parametrize("importance", ["none", "constant:0.3", "saliency"])
def test_importance_by_name(command, photos, tmp_path, importance):
    done(command, photos / "coffee.png", "-o", tmp_path / "out.svg", "--importance", importance)
    drawing = gs.draw(photos / "coffee.png", importance=importance)
    assert (tmp_path / "out.svg").read_text() == drawing.svg()


@pytest.mark.parametrize(
    ("arguments", "options"),
    [
        (
            flags(k1=2, k2=0.5, base=0.4, detail_gain=3, hops=2, alpha="dynamic"),
            {"k1": 2, "k2": 0.5, "base": 0.4, "detail_gain": 3, "hops": 2, "alpha": "dynamic"},
        ),
        (
            ["--published", "importance-alpha=0.8", "--published", "detail-gain=3", "--published", "alpha=dynamic"],
            {"importance_alpha": 0.8, "detail_gain": 3, "alpha": "dynamic"},
        ),
        (
            ["--linear", "--gamma", 1.4, "--contrast", 1.2, "--invert"],
            {"linear": True, "gamma": 1.4, "contrast": 1.2, "invert": True},
        ),
        (["--stipple-min", 0.6, "--stipple-max", 1.5], {"stipple_min": 0.6, "stipple_max": 1.5}),
        (
            ["--irregularity", 0.7, "--seed", 2**53, "--wobble", 0.2, "--edge", "inked"],
            {"irregularity": 0.7, "seed": 2**53, "wobble": 0.2, "edge": "inked"},
        ),
        (
            ["--shading", 0.4, "--stipple-scale", 0.7, "--tolerance", 0.25],
            {"shading": 0.4, "stipple_scale": 0.7, "tolerance": 0.25},
        ),
        (["--nodes-per-pixel", 0.2, "--relax", 0], {"nodes_per_pixel": 0.2, "relax": 0}),
        (
            ["--detail", 0.5, "--floor", 0.3, "--midtones", 0.2, "--sharpen", 1, "--local-contrast", 2, "--fineness", 0.5],
            {"detail": 0.5, "floor": 0.3, "midtones": 0.2, "sharpen": 1, "local_contrast": 2, "fineness": 0.5},
        ),
        (
            ["--refine", 3, "--crispness", 1.5, "--cohesion", 0.5, "--split", 2],
            {"refine": 3, "crispness": 1.5, "cohesion": 0.5, "split": 2},
        ),
        (
            ["--tone-tolerance", "off", *flags(error_weighting="value", crossings="midpoint", order="global", density="auto")],
            {"tone_tolerance": None, "error_weighting": "value", "crossings": "midpoint", "order": "global"},
        ),
    ],
    ids=["diffusion", "kebab case", "tone", "radii", "irregular dots", "shapes", "budget", "detail", "refinement", "ours off"],
)
def test_every_option_means_the_same(command, photos, tmp_path, arguments, options):
    done(command, photos / "coffee.png", "-o", tmp_path / "out.svg", *arguments)
    assert (tmp_path / "out.svg").read_text() == gs.draw(photos / "coffee.png", options=options_with(**options)).svg()


ONLY = {preset.name: preset.only or None for preset in gs.presets()}
"""What every preset is written with."""


@pytest.mark.parametrize("name", ONLY)
def test_a_preset_means_the_same(command, photos, tmp_path, name):
    done(command, photos / "coffee.png", "-o", tmp_path / "out.svg", "--preset", name)
    assert (tmp_path / "out.svg").read_text() == gs.draw(photos / "coffee.png", options=gs.Options.preset(name)).svg(
        only=ONLY[name]
    )


def test_presets_are_listed_without_a_photo(command):
    lines = done(command, "--list-presets").stdout.decode().splitlines()
    assert [line.split()[0] for line in lines] == [preset.name for preset in gs.presets()]
    assert all(line.endswith(preset.description) for line, preset in zip(lines, gs.presets(), strict=True))


# Outputs -------------------------------------------------------------------------------------------------------------------------


def test_png_and_preview_are_the_raster(program, photos, tmp_path):
    done(program, photos / "coffee.png", "-o", tmp_path / "out.png")
    done(program, photos / "coffee.png", "-o", tmp_path / "out.svg", "--preview", tmp_path / "small.png", "--preview-width", 400)
    drawing = gs.draw(photos / "coffee.png")
    np.testing.assert_array_equal(np.asarray(Image.open(tmp_path / "out.png").convert("L")), drawing.rasterize())
    np.testing.assert_array_equal(np.asarray(Image.open(tmp_path / "small.png").convert("L")), drawing.rasterize(400))
    drawing.save(tmp_path / "python.png")
    assert (tmp_path / "python.png").read_bytes() == (tmp_path / "out.png").read_bytes()
    drawing.save(tmp_path / "python.svg")
    assert (tmp_path / "python.svg").read_bytes() == (tmp_path / "out.svg").read_bytes()


@pytest.mark.parametrize(
    ("suffix", "keywords"),
    [
        *((suffix, {}) for suffix in SUFFIXES),
        ("svg", {"width": "120mm", "margin": "5mm", "elements": "marks"}),
        ("pdf", {"style": "layered", "page": "A5", "paper": "#fed"}),
        ("dxf", {"only": "white", "width": "300px", "curves": "splines"}),
        ("svgz", {"only": "black,white", "width": "4in", "dots": "strokes"}),
        ("png", {"width": "3in", "margin": "0.5in", "dpi": 100, "one_bit": True}),
        ("eps", {"width": "4in", "registration_marks": True}),
    ],
    ids=str,
)
def test_every_format_is_the_file_of_python(command, photos, tmp_path, suffix, keywords):
    given = {f"--{name.replace('_', '-')}": value for name, value in keywords.items()}
    arguments = [part for flag, value in given.items() for part in ([flag] if value is True else [flag, value])]
    done(command, photos / "coffee.png", "-o", tmp_path / f"out.{suffix}", *arguments)
    gs.draw(photos / "coffee.png").save(tmp_path / f"python.{suffix}", **keywords)
    assert (tmp_path / f"out.{suffix}").read_bytes() == (tmp_path / f"python.{suffix}").read_bytes()


def test_every_setting_is_given_on_the_command_line_above() -> None:
    (mark,) = (it for it in test_every_format_is_the_file_of_python.pytestmark if it.name == "parametrize")
    given = {name for _, keywords in mark.args[1] for name in keywords}
    # There is nothing to trap in black and white.
    assert given | {"trap"} == {name for name, *_ in _core.settings()}


def test_a_dash_writes_svg_to_standard_output(program, photos, tmp_path):
    result = done(program, photos / "coffee.png", "-o", "-", cwd=tmp_path)
    drawing = gs.draw(photos / "coffee.png")
    assert (result.stdout.decode(), result.stderr) == (drawing.svg(), b"")
    # Figures are then told beside it.
    result = done(program, photos / "coffee.png", "-o", "-", "--stats", cwd=tmp_path)
    assert result.stdout.decode() == drawing.svg()
    assert json.loads(result.stderr)["nodes"] == drawing.stats["nodes"]
    assert not list(tmp_path.iterdir())


def test_stats_have_the_keys_of_python(program, photos, tmp_path):
    result = done(program, photos / "astronaut.jpg", "-o", tmp_path / "out.svg", "--stats")
    found, expected = json.loads(result.stdout), gs.draw(photos / "astronaut.jpg").stats
    assert found.keys() == expected.keys()
    assert found["seconds"].keys() >= {"total"}
    assert all(value >= 0 for value in found["seconds"].values())
    for stats in (found, expected):
        del stats["seconds"]
    assert found == expected


def test_no_progress_bar_when_piped(program, photos, tmp_path):
    result = done(program, photos / "coffee.png", "-o", tmp_path / "out.svg")
    assert result.stdout == result.stderr == b""


# Help ----------------------------------------------------------------------------------------------------------------------------

SCHEMA = _core.options_schema()["properties"]
OPTIONS = {name: it for name, it in SCHEMA.items() if name != "published"}

OWN = {"output", "preset", "preview", "preview-width", "importance", "min-dot", "process", "pen"}
OWN |= {"list-presets", "stats", "quiet", "help", "help-all", "version"}
"""Flags that only a command has, besides the options of a drawing and the settings of its file."""

FURTHER = {
    "subject",
    "force",
    "options-schema",
    "max-bytes",
    "max-points",
    "min-feature",
    "min-gap",
    "min-area",
    "islands",
    "check",
    "check-only",
    "strict",
    "max-plot-time",
    "machine",
    "max-pixels",
    "allow-damaged",
    "completions",
    "man",
}
"""More of them, in the long help alone."""


def kebab(names: Iterable[str]) -> set[str]:
    return {name.replace("_", "-") for name in names}


def shown(text: str) -> list[str]:
    """Return the flags of a help, in its order."""
    return re.findall(r"^ +(?:-\w, )?--([a-z0-9-]+)", text, flags=re.MULTILINE)


def in_words(text: str) -> str:
    """Return a text on one line."""
    return " ".join(text.split())


def test_help_is_short_and_shows_what_people_turn(command):
    text = done(command, "--help", columns=80).stdout.decode()
    assert done(command, "-h", columns=80).stdout.decode() == text
    assert text.endswith("\n")
    assert text.count("\n") <= 100
    assert max(map(len, text.splitlines())) <= 80
    everyday = {name for name, it in OPTIONS.items() if it["x-everyday"]}
    settings = {name for name, _, _, _, is_everyday, *_ in _core.settings() if is_everyday}
    assert len(shown(text)) == len(set(shown(text)))
    assert set(shown(text)) == kebab(everyday | settings) | OWN
    # Three examples, the five that most begin with, then the groups.
    assert re.findall(r"^  graphstipple photo", text, flags=re.MULTILINE) == ["  graphstipple photo"] * 3
    assert shown(text)[:5] == ["output", "preset", "nodes", "width", "preview"]
    headings = re.findall(r"^([A-Z][A-Za-z ]+):$", text, flags=re.MULTILINE)
    groups = list(dict.fromkeys(it["x-group"] for it in OPTIONS.values() if it["x-everyday"]))
    assert headings == ["Examples", "To begin with", "File", "Size on paper", *groups, "Machines", "Print"]
    for name in everyday:
        assert in_words(OPTIONS[name]["description"]).partition(". ")[0].rstrip(".") in in_words(text)
    assert "--help-all" in text.splitlines()[-1]


def test_the_long_help_shows_everything(command):
    text = done(command, "--help-all", columns=80).stdout.decode()
    settings = {name for name, *_ in _core.settings()}
    of_pen = {f"pen-{name}" for name, *_ in _core.pen_settings() if name != "pen"}
    assert set(shown(text)) == kebab({*SCHEMA, *settings}) | of_pen | OWN | FURTHER
    for name, it in SCHEMA["published"]["properties"].items():
        assert f" {name}: {it['description'].rstrip('.')} [" in in_words(text), name
    for name, it in OPTIONS.items():
        assert f" {it['description'].rstrip('.')}" in in_words(text), name
    assert "--published <NAME=VALUE>" in text
    for form, sentence in _core.sources():
        assert f"{form} ({sentence})" in in_words(text)
    for preset in gs.presets():
        assert preset.name in text


def test_both_programs_give_the_same_help(command):
    for flag in ("--help", "--help-all", "--options-schema", "--list-presets", "--version", "--man"):
        assert done(command, flag).stdout == done(CONSOLE_SCRIPT, flag).stdout


def test_version(command):
    for flag in ("--version", "-V"):
        assert done(command, flag).stdout.decode() == f"graphstipple {gs.__version__}\n"


def satisfies(value: object, schema: dict[str, Any]) -> bool:
    """Whether a value keeps a JSON schema, of which the options' needs these few words."""
    kinds: dict[str, Any] = {
        "number": (int, float),
        "integer": int,
        "boolean": bool,
        "string": str,
        "null": type(None),
        "object": dict,
    }
    if "anyOf" in schema:
        return any(satisfies(value, form) for form in schema["anyOf"])
    if not isinstance(value, kinds[schema["type"]]) or isinstance(value, bool) != (schema["type"] == "boolean"):
        return False
    if isinstance(value, dict):
        properties = schema["properties"]
        assert schema["additionalProperties"] is False
        return all(name in properties and satisfies(it, properties[name]) for name, it in value.items())
    if isinstance(value, str):
        return value in schema.get("enum", [value]) and re.search(schema.get("pattern", ""), value) is not None
    if isinstance(value, (int, float)) and schema["type"] != "boolean":
        above = schema.get("exclusiveMinimum", -math.inf)
        return above < value and schema.get("minimum", value) <= value <= schema.get("maximum", value)
    return True


def test_the_schema_of_options(command):
    schema = json.loads(done(command, "--options-schema").stdout)
    assert schema == _core.options_schema()
    assert schema["$schema"] == "https://json-schema.org/draft/2020-12/schema"
    assert schema["type"] == "object"
    gamma, nodes = schema["properties"]["gamma"], schema["properties"]["nodes"]
    assert (gamma["type"], gamma["minimum"], gamma["maximum"], gamma["default"]) == ("number", 0.1, 10, 1)
    assert nodes["anyOf"] == [{"type": "integer", "minimum": 3, "maximum": 10**9}, {"type": "null"}]
    assert schema["properties"]["published"]["properties"]["lattice"]["enum"] == ["hexagonal", "square"]
    # What it says is what drawings have, and what Python takes and refuses.
    for options in (gs.Options(), gs.Options.preset("paper"), *(gs.Options.preset(preset.name) for preset in gs.presets())):
        assert satisfies(dataclasses.asdict(options), schema)
    for name, it in OPTIONS.items():
        assert satisfies(it["default"], it), name
        assert it["description"], name
        for value in (-1, 0, 0.05, 1, 1.5, 7, 17, 101, 5000, 2**53, 2**53 + 1, True, None, "white", "#12", "#123", "lots"):
            try:
                gs.Options(**{name: value})
            except gs.InvalidInputError as error:
                # What does not go together is no matter of one.
                if "nothing of the drawing would be seen" in str(error) or "must be left out without" in str(error):
                    continue
                assert not satisfies(value, it), (name, value)
            else:
                assert satisfies(value, it), (name, value)
    for name, it in SCHEMA["published"]["properties"].items():
        assert satisfies(it["default"], it), name
        assert satisfies(it["x-paper"], it), name
        for value in (-1, 0, 0.05, 1, 1.5, 7, 17, 5000, True, None, "tonal", "rows", "area", "tone", "square", "lots"):
            try:
                gs.Published(**{name: value})
            except gs.InvalidInputError:
                assert not satisfies(value, it), (name, value)
            else:
                assert satisfies(value, it), (name, value)


def test_formats_are_one_table(command, bad_files, tmp_path):
    suffixes = [f".{suffix}" for suffix in SUFFIXES]
    listed = f"{', '.join(suffixes[:-1])} or {suffixes[-1]}"
    assert len(suffixes) == len(set(suffixes)) >= 6
    assert f"File to write, {listed} by its suffix" in in_words(done(command, "--help").stdout.decode())
    drawing = gs.draw(np.zeros((8, 8), np.uint8))
    for name in ("out.gif", "out"):
        result = run(command, bad_files / "good.png", "-o", name, cwd=tmp_path)
        assert_one_sentence(result, USAGE)
        assert result.stderr.decode().endswith(f"{listed}\n")
        with pytest.raises(gs.InvalidInputError, match=f"{re.escape(listed)}$"):
            drawing.save(tmp_path / name)
    assert not list(tmp_path.iterdir())
    # Each is written, and those that say so are read.
    read = [f".{suffix}" for suffix, _, _, is_read in _core.formats() if is_read]
    for suffix in suffixes:
        drawing.save(tmp_path / f"out{suffix}")
        if suffix in read:
            assert gs.load(tmp_path / f"out{suffix}").svg() == drawing.svg()
        else:
            with pytest.raises(gs.InvalidInputError, match=re.escape(f"{', '.join(read[:-1])} or {read[-1]}")):
                gs.load(tmp_path / f"out{suffix}")


# The published method ------------------------------------------------------------------------------------------------------------


def test_the_paper_with_one_parameter_changed(program, photos, tmp_path):
    done(program, photos / "coffee.png", "-o", tmp_path / "out.svg", "--preset", "paper", "--published", "k1=2")
    options = gs.Options.preset("paper", published=gs.Published(k1=2.0))
    assert (tmp_path / "out.svg").read_bytes() == gs.draw(photos / "coffee.png", options=options).svg().encode()
    ours = gs.Options(published=gs.Options().published.replace(k1=2.0))
    assert gs.draw(photos / "coffee.png", options=ours).svg() != gs.draw(photos / "coffee.png", options=options).svg()


# Errors --------------------------------------------------------------------------------------------------------------------------


@pytest.fixture(scope="session")
def bad_files(photos, tmp_path_factory) -> Path:
    folder = tmp_path_factory.mktemp("bad")
    (folder / "empty.png").touch()
    jpeg = (photos / "astronaut.jpg").read_bytes()
    (folder / "truncated.jpg").write_bytes(jpeg[: len(jpeg) // 2])
    (folder / "head.jpg").write_bytes(jpeg[:40])
    png = (photos / "coffee.png").read_bytes()
    (folder / "truncated.png").write_bytes(png[: len(png) // 2])
    (folder / "text.png").write_text("This is not a picture.\n")
    (folder / "folder.png").mkdir()
    (folder / "good.png").write_bytes(png)
    return folder


BAD_INPUTS = {
    "missing.png": "the file does not exist",
    "empty.png": "the file is empty",
    "truncated.jpg": "the JPEG file is cut short",
    "head.jpg": "the JPEG file is cut short",
    "truncated.png": "the PNG file is cut short",
    "text.png": "the file is text, not an image in a format that is read",
    "folder.png": "this is a folder, not a file",
}


@pytest.mark.parametrize("name", BAD_INPUTS)
def test_a_bad_file_fails_with_one_sentence(program, bad_files, tmp_path, name):
    result = run(program, bad_files / name, "-o", "out.svg", "--preview", "preview.png", cwd=tmp_path)
    assert_one_sentence(result, FAILURE)
    assert result.stderr.decode().startswith(f"graphstipple: error: {bad_files / name}: {BAD_INPUTS[name]}")
    assert not list(tmp_path.iterdir())


@pytest.mark.parametrize("name", ["missing.png", "text.png"])
def test_a_bad_map_fails_with_one_sentence(program, bad_files, tmp_path, name):
    result = run(program, bad_files / "good.png", "-o", "out.svg", "--importance", bad_files / name, cwd=tmp_path)
    assert_one_sentence(result, FAILURE)
    assert result.stderr.decode().startswith(f"graphstipple: error: {bad_files / name}: {BAD_INPUTS[name]}")
    assert not list(tmp_path.iterdir())


@pytest.mark.parametrize(
    ("output", "message"),
    [
        ("missing/out.svg", "the folder missing does not exist"),
        ("missing/out.png", "the folder missing does not exist"),
        ("out.svg/", "this is a folder, not a file"),
    ],
)
def test_a_missing_output_folder_fails(program, bad_files, tmp_path, output, message):
    result = run(program, bad_files / "good.png", "-o", output, cwd=tmp_path)
    assert_one_sentence(result, FAILURE)
    assert result.stderr.decode() == f"graphstipple: error: {output}: {message}\n"
    with pytest.raises(gs.ImageFileError, match=re.escape(output)):
        gs.draw(bad_files / "good.png").save(f"{tmp_path}/{output}")
    assert not list(tmp_path.iterdir())


def test_a_missing_preview_folder_leaves_nothing(program, bad_files, tmp_path):
    result = run(program, bad_files / "good.png", "-o", "out.svg", "--preview", "missing/preview.png", cwd=tmp_path)
    assert_one_sentence(result, FAILURE)
    assert result.stderr.decode() == "graphstipple: error: missing/preview.png: the folder missing does not exist\n"
    assert not list(tmp_path.iterdir())


SEE = " (see graphstipple --help)"


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        ([], f"the following required arguments were not provided: --output <FILE>{SEE}"),
        (["-o", "out.svg", "--dense"], f"unexpected argument '--dense' found{SEE}"),
        (["-o", "out.svg", "--relax", "-1"], "--relax is -1, but it must be between 0 and 100 steps"),
        (["-o", "-", "--dpi", "300"], "--dpi is 300, but it must be left out unless the file is a .png: the others have no pixels"),
        (["-o", "out.svg", "--min-dot", "2000mm"], "--min-dot is 2000mm, but it must be at most 1000mm"),
        (["-o", "good.png"], "good.png: the drawing would replace an image that it is made from"),
    ],
    ids=lambda it: " ".join(it) if isinstance(it, list) else "",
)
def test_wrong_usage(program, bad_files, tmp_path, arguments, message):
    """One of each kind; `rust/cli/src/arguments.rs` has all of them."""
    (tmp_path / "good.png").write_bytes((bad_files / "good.png").read_bytes())
    result = run(program, "good.png", *arguments, cwd=tmp_path)
    assert_one_sentence(result, USAGE)
    assert result.stderr.decode() == f"graphstipple: error: {message}\n"
    assert [path.name for path in tmp_path.iterdir()] == ["good.png"]


def test_no_arguments_at_all(program):
    result = run(program)
    assert_one_sentence(result, USAGE)
    assert "were not provided: --output <FILE> <PHOTO>..." in result.stderr.decode()


@pytest.mark.skipif(os.name != "posix", reason="a closed pipe looks different elsewhere")
def test_a_reader_that_goes_away_is_no_error(program, photos):
    with subprocess.Popen(
        [program, photos / "coffee.png", "-o", "-"], stdin=subprocess.DEVNULL, stdout=subprocess.PIPE, stderr=subprocess.PIPE
    ) as process:
        process.stdout.close()
        assert process.stderr.read() == b""
    assert process.returncode == 0


def test_dots_have_a_least_radius_on_paper(command, photos, tmp_path):
    def stats(*arguments: object) -> dict[str, float]:
        return json.loads(done(command, photos / "astronaut.jpg", "-o", tmp_path / "dots.dxf", "--stats", *arguments).stdout)

    def least() -> float:
        return min(circle.dxf.radius for circle in readers.dxf(tmp_path / "dots.dxf").modelspace().query("CIRCLE"))

    before = stats("--width", "100mm")
    assert (before["dots_enlarged"], before["dots_dropped"]) == (0, 0)
    assert least() < 0.4
    after = stats("--width", "100mm", "--min-dot", "0.4mm")
    assert after["dots_enlarged"] > 0
    assert after["stipples"] == before["stipples"] - after["dots_dropped"]
    assert least() == pytest.approx(0.4, abs=2e-3)
    # The same length on larger paper is fewer pixels.
    large = stats("--width", "1000mm", "--min-dot", "0.4mm")
    assert large["dots_enlarged"] + large["dots_dropped"] < after["dots_enlarged"] + after["dots_dropped"]


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        (
            ["-o", "no.pdf", "--page", "A4", "--width", "300mm"],
            "the drawing would be 300 x 220 mm, but the page A4 has room for 297 x 210 mm inside its margins",
        ),
        (["-o", "no.svg", "--page", "A6", "--margin", "6cm"], "the margin of 6cm leaves nothing of the page A6: 148 x 105 mm"),
        (["-o", "no.png", "--width", "60in", "--dpi", "2000"], "the image would be 120000 x 88000 pixels"),
        (["-o", "no.png", "--width", "60000"], "the raster would be 60000 x 44000 pixels"),
    ],
    ids=lambda it: " ".join(it[2:]) if isinstance(it, list) else "",
)
def test_sizes_that_the_drawing_cannot_have(command, bad_files, tmp_path, arguments, message):
    result = run(command, bad_files / "good.png", *arguments, cwd=tmp_path)
    assert_one_sentence(result, FAILURE)
    assert message in result.stderr.decode()
    assert not list(tmp_path.iterdir())


def test_a_blank_drawing_is_one_line_on_standard_error(program, tmp_path):
    faint = np.tile(np.linspace(240, 255, 60).astype(np.uint8), (40, 1))
    Image.fromarray(faint).save(tmp_path / "fog.png")
    result = done(program, "fog.png", "-o", "fog.svg", "--stippling", "0", cwd=tmp_path)
    told = result.stderr.decode()
    assert told.startswith("graphstipple: warning: the whole drawing is white, as the photo's tones lie between 0.94 and 1.00")
    assert len(told.splitlines()) == 1
    assert (tmp_path / "fog.svg").exists()
    result = done(program, "fog.png", "-o", "fog.svg", "--white-point", "auto", "--black-point", "auto", cwd=tmp_path)
    assert result.stderr == b""
