"""The command line, the native binary and the console script, against Python."""

from __future__ import annotations

import io
import json
import os
import subprocess
import sys
import sysconfig
from pathlib import Path
from xml.etree import ElementTree

import numpy as np
import pytest
from PIL import Image
from tests import oracles
from tests.commands import FAILURE, USAGE, assert_one_sentence, done, native_binary, run
from tests.support import GOLDEN, GOLDEN_CASES, ROOT, photo

import graphstipple as gs

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
        "--density",
        1.5,
        "--nodes",
        4000,
        "--relax",
        2,
        "--alpha",
        1,
        "--lattice",
        "square",
    ]
    done(program, photos / name, "-o", tmp_path / "out.svg", *arguments, "--threads", 2)
    options = gs.Options(density=1.5, nodes=4000, relax=2, alpha=1.0, lattice="square")
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
            ["--k1", 2, "--k2", 0.5, "--base", 0.4, "--detail-gain", 3, "--rings", 2],
            {"k1": 2, "k2": 0.5, "base": 0.4, "detail_gain": 3, "rings": 2},
        ),
        (
            ["--linear", "--gamma", 1.4, "--contrast", 1.2, "--invert"],
            {"linear": True, "gamma": 1.4, "contrast": 1.2, "invert": True},
        ),
        (["--stipple-min", 0.6, "--stipple-max", 1.5], {"stipple_min": 0.6, "stipple_max": 1.5}),
        (["--irregularity", 0.7, "--seed", 2**53], {"irregularity": 0.7, "seed": 2**53}),
        (
            ["--importance-alpha", 0.8, "--alpha", "dynamic", "--stipple-scale", 0.7, "--tolerance", 0.5],
            {"importance_alpha": 0.8, "alpha": "dynamic", "stipple_scale": 0.7, "tolerance": 0.5},
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
            ["--tone-tolerance", "off", "--carry", "value", "--crossings", "midpoint", "--order", "global"],
            {"tone_tolerance": None, "carry": "value", "crossings": "midpoint", "order": "global"},
        ),
    ],
    ids=["diffusion", "tone", "radii", "irregular dots", "alphas and outlines", "budget", "detail", "refinement", "ours off"],
)
def test_every_option_means_the_same(command, photos, tmp_path, arguments, options):
    done(command, photos / "coffee.png", "-o", tmp_path / "out.svg", *arguments)
    assert (tmp_path / "out.svg").read_text() == gs.draw(photos / "coffee.png", options=gs.Options(**options)).svg()


@pytest.mark.parametrize("name", [preset.name for preset in gs.presets()])
def test_a_preset_means_the_same(command, photos, tmp_path, name):
    done(command, photos / "coffee.png", "-o", tmp_path / "out.svg", "--preset", name)
    inks = {preset.name: preset.inks for preset in gs.presets()}[name]
    assert (tmp_path / "out.svg").read_text() == gs.draw(photos / "coffee.png", options=gs.Options.preset(name)).svg(inks=inks)


def test_presets_are_listed_without_a_photo(command):
    lines = done(command, "--list-presets").stdout.decode().splitlines()
    assert [line.split()[0] for line in lines] == [preset.name for preset in gs.presets()]
    assert all(line.endswith(preset.description) for line, preset in zip(lines, gs.presets(), strict=True))


@pytest.mark.parametrize("name", GOLDEN_CASES)
def test_the_command_makes_the_golden_drawings(command, tmp_path, name):
    options = GOLDEN_CASES[name]
    arguments = [part for key, value in options.items() for part in (f"--{key.replace('_', '-')}", value)]
    result = done(command, GOLDEN / f"{name}.png", "-o", tmp_path / "out.svg", "--stats", *arguments)
    stats = json.loads(result.stdout)
    assert {key: stats[key] for key in json.loads((GOLDEN / f"{name}.json").read_text())["counts"]} == json.loads(
        (GOLDEN / f"{name}.json").read_text()
    )["counts"]
    assert (tmp_path / "out.svg").read_text() == gs.draw(GOLDEN / f"{name}.png", options=gs.Options(**options)).svg()


def test_rust_saliency_is_opencvs_on_a_jpeg(photos):
    # The binary's default importance has no OpenCV: this is what keeps the two ways in the same.
    gray = np.asarray(Image.open(photos / "astronaut.jpg").convert("L"))
    np.testing.assert_array_equal(gs._core.saliency(gray.astype(np.float32) / 255), oracles.saliency(gray))


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


@pytest.mark.parametrize("suffix", ["svg", "pdf", "eps", "dxf", "png", "json"])
@pytest.mark.parametrize(
    "keywords",
    [{}, {"width": "120mm", "margin": "5mm"}, {"style": "layered", "page": "A5"}, {"inks": "white", "width": 300}],
    ids=["plain", "size", "layered", "white"],
)
def test_every_format_is_the_file_of_python(command, photos, tmp_path, suffix, keywords):
    arguments = [part for name, value in keywords.items() for part in (f"--{name}", value)]
    done(command, photos / "coffee.png", "-o", tmp_path / f"out.{suffix}", *arguments)
    gs.draw(photos / "coffee.png").save(tmp_path / f"python.{suffix}", **keywords)
    assert (tmp_path / f"out.{suffix}").read_bytes() == (tmp_path / f"python.{suffix}").read_bytes()


def test_a_dash_writes_svg_to_standard_output(program, photos, tmp_path):
    result = done(program, photos / "coffee.png", "-o", "-", cwd=tmp_path)
    assert result.stdout.decode() == gs.draw(photos / "coffee.png").svg()
    assert result.stderr == b""
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


def test_help_and_version(program):
    text = done(program, "--help").stdout.decode()
    for option in ("--density", "--nodes", "--nodes-per-pixel", "--relax", "--k1", "--k2", "--base", "--detail-gain", "--rings"):
        assert option in text
    for option in ("--importance", "--importance-alpha", "--alpha", "--lattice", "--gamma", "--contrast", "--invert", "--threads"):
        assert option in text
    for option in ("--stipple-scale", "--background", "--preview", "--preview-width", "--stats", "--output"):
        assert option in text
    for option in ("--style", "--inks", "--one-bit", "--tolerance", "--width", "--margin", "--page", "--dpi", "--min-dot"):
        assert option in text
    assert gs.__version__ in done(program, "--version").stdout.decode()


def test_both_programs_give_the_same_help(command):
    assert done(command, "--help").stdout == done(CONSOLE_SCRIPT, "--help").stdout


def test_module_run(photos, tmp_path):
    result = done(Path(sys.executable), "-m", "graphstipple", photos / "coffee.png", "-o", tmp_path / "out.svg")
    assert result.stdout == b""
    assert ElementTree.parse(tmp_path / "out.svg").getroot().tag.endswith("svg")


def test_an_old_output_is_replaced(program, photos, tmp_path):
    (tmp_path / "out.svg").write_text("old" * 1_000_000)
    done(program, photos / "coffee.png", "-o", tmp_path / "out.svg")
    assert (tmp_path / "out.svg").read_text() == gs.draw(photos / "coffee.png").svg()
    assert [path.name for path in tmp_path.iterdir()] == ["out.svg"]


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


BAD_INPUTS = ["missing.png", "empty.png", "truncated.jpg", "head.jpg", "truncated.png", "text.png", "folder.png"]


@pytest.mark.parametrize("name", BAD_INPUTS)
def test_a_bad_file_fails_with_one_sentence(program, bad_files, tmp_path, name):
    result = run(program, bad_files / name, "-o", "out.svg", "--preview", "preview.png", cwd=tmp_path)
    assert_one_sentence(result, FAILURE)
    assert name in result.stderr.decode()
    assert not list(tmp_path.iterdir())


@pytest.mark.parametrize("name", BAD_INPUTS)
def test_a_bad_file_raises_in_python(bad_files, name):
    with pytest.raises(gs.ImageFileError) as caught:
        gs.draw(bad_files / name)
    assert name in str(caught.value)
    assert "\n" not in str(caught.value)
    assert isinstance(caught.value, FileNotFoundError) == (name == "missing.png")


@pytest.mark.parametrize("name", ["missing.png", "text.png"])
def test_a_bad_map_fails_with_one_sentence(program, bad_files, tmp_path, name):
    result = run(program, bad_files / "good.png", "-o", "out.svg", "--importance", bad_files / name, cwd=tmp_path)
    assert_one_sentence(result, FAILURE)
    assert name in result.stderr.decode()
    assert not list(tmp_path.iterdir())


@pytest.mark.parametrize("output", ["missing/out.svg", "missing/out.png", "out.svg/"])
def test_a_missing_output_folder_fails(program, bad_files, tmp_path, output):
    result = run(program, bad_files / "good.png", "-o", output, cwd=tmp_path)
    assert result.returncode in (FAILURE, USAGE)
    assert "panicked" not in result.stderr.decode()
    assert not list(tmp_path.iterdir())
    with pytest.raises(gs.GraphStippleError):
        gs.draw(bad_files / "good.png").save(f"{tmp_path}/{output}")
    assert not list(tmp_path.iterdir())


def test_a_missing_preview_folder_leaves_nothing(program, bad_files, tmp_path):
    result = run(program, bad_files / "good.png", "-o", "out.svg", "--preview", "missing/preview.png", cwd=tmp_path)
    assert_one_sentence(result, FAILURE)
    assert not list(tmp_path.iterdir())


@pytest.mark.parametrize(
    "arguments",
    [
        ["-o", "out.gif"],
        ["-o", "out"],
        [],
        ["-o", "out.svg", "--preview", "preview.bmp"],
        ["-o", "out.svg", "--gamma", "nan"],
        ["-o", "out.svg", "--density", "inf"],
        ["-o", "out.svg", "--density", "0"],
        ["-o", "out.svg", "--density", "17"],
        ["-o", "out.svg", "--density", "two"],
        ["-o", "out.svg", "--relax", "101"],
        ["-o", "out.svg", "--relax", "-1"],
        ["-o", "out.svg", "--rings", "0"],
        ["-o", "out.svg", "--alpha", "2"],
        ["-o", "out.svg", "--alpha", "dynamical"],
        ["-o", "out.svg", "--preset", "lino"],
        ["-o", "out.svg", "--tone-tolerance", "none"],
        ["-o", "out.svg", "--nodes", "2"],
        ["-o", "out.svg", "--nodes", "1000", "--nodes-per-pixel", "0.2"],
        ["-o", "out.svg", "--lattice", "triangular"],
        ["-o", "out.svg", "--threads", "0"],
        ["-o", "out.svg", "--importance", "constant:0"],
        ["-o", "out.svg", "--importance", "constant:nan"],
        ["-o", "out.svg", "--preview", "preview.png", "--preview-width", "0"],
        ["-o", "out.svg", "--dense"],
        ["-o", "out.svg", "--tolerance", "2.5"],
        ["-o", "out.svg", "--style", "round"],
        ["-o", "out.svg", "--style", "layered", "--inks", "white"],
        ["-o", "out.svg", "--inks", "red"],
        ["-o", "out.svg", "--one-bit"],
        ["-o", "-", "--dpi", "300"],
        ["-o", "out.png", "--dpi", "0"],
        ["-o", "out.svg", "--width", "wide"],
        ["-o", "out.svg", "--width", "0mm"],
        ["-o", "out.svg", "--width", "-5"],
        ["-o", "out.pdf", "--width", "101000mm"],
        ["-o", "out.svg", "--margin", "-1mm"],
        ["-o", "out.svg", "--page", "A9"],
        ["-o", "out.svg", "--min-dot", "small"],
    ],
    ids=" ".join,
)
def test_wrong_usage(program, bad_files, tmp_path, arguments):
    result = run(program, bad_files / "good.png", *arguments, cwd=tmp_path)
    assert_one_sentence(result, USAGE)
    assert not list(tmp_path.iterdir())


def test_no_arguments_at_all(program):
    assert run(program).returncode == USAGE


@pytest.mark.parametrize(
    ("options", "names"),
    [
        ({"gamma": float("nan")}, "gamma"),
        ({"density": float("inf")}, "density"),
        ({"density": 0.0}, "density"),
        ({"relax": 101}, "relax"),
        ({"relax": -1}, "relax"),
        ({"rings": 0}, "rings"),
        ({"alpha": 2.0}, "alpha"),
        ({"alpha": "dynamical"}, "alpha"),
        ({"nodes": 1000, "nodes_per_pixel": 0.2}, "nodes"),
        ({"lattice": "triangular"}, "lattice"),
        ({"threads": 0}, "threads"),
        ({"k1": "much"}, "k1"),
    ],
    ids=str,
)
def test_wrong_options_in_python(options, names):
    with pytest.raises(gs.InvalidInputError) as caught:
        gs.Options(**options)
    assert names in str(caught.value)
    assert "\n" not in str(caught.value)


@pytest.mark.parametrize(
    "image",
    [
        np.zeros((0, 5), np.uint8),
        np.zeros((5,), np.uint8),
        np.zeros((4, 4, 5), np.uint8),
        np.full((4, 4), np.nan),
        np.full((4, 4), 1.5),
        np.zeros((4, 4), np.int64),
        np.zeros((4, 4), complex),
        None,
        [[0, 1]],
    ],
    ids=["no rows", "1-d", "5 channels", "NaN", "1.5", "int64", "complex", "None", "a list"],
)
def test_wrong_images_in_python(image):
    with pytest.raises(gs.InvalidInputError) as caught:
        gs.draw(image)
    assert "\n" not in str(caught.value)
    assert len(str(caught.value)) > 15


@pytest.mark.parametrize(
    "importance", [np.zeros((4, 0)), np.full((4, 4), np.nan), np.full((4, 4), 2.0), np.zeros((4, 4, 4, 4)), "constant:2"]
)
def test_wrong_importance_in_python(importance):
    with pytest.raises(gs.InvalidInputError):
        gs.draw(np.zeros((8, 8), np.uint8), importance=importance)


def test_wrong_width_in_python():
    drawing = gs.draw(np.zeros((8, 8), np.uint8))
    for width in (0, -1, 1.5, 10**9):
        with pytest.raises(gs.InvalidInputError):
            drawing.rasterize(width)


@pytest.mark.skipif(os.name != "posix", reason="a closed pipe looks different elsewhere")
def test_a_closed_pipe_is_no_panic(command, photos):
    script = f'"{command}" "{photos / "coffee.png"}" -o - | head -c 10'
    result = subprocess.run(["bash", "-c", script], capture_output=True, timeout=60, cwd=ROOT, check=False)
    assert b"panicked" not in result.stderr


# Images in memory ----------------------------------------------------------------------------------------------------------------


@pytest.mark.parametrize("name", ["coffee.png", "astronaut.jpg", "clear.png", "deep.png"])
def test_arrays_and_pil_images_give_the_tone_of_files(photos, name):
    image = Image.open(photos / name)
    tones = [gs.draw(way, importance="none").graph.tone for way in (photos / name, str(photos / name), image, np.asarray(image))]
    for tone in tones[1:]:
        # JPEG decoders may differ by a level or two.
        np.testing.assert_allclose(tone, tones[0], atol=0.02 if name.endswith("jpg") else 1e-6)


def test_transparency_lies_on_the_background(photos):
    clear = np.zeros((20, 30, 4), np.uint8)
    for background, value in (("white", 255), ("black", 0)):
        drawing = gs.draw(clear, options=gs.Options(background=background))
        assert (drawing.rasterize() == value).all()


def test_sixteen_bits_are_kept():
    ramp = np.linspace(30000, 30200, 64 * 48).reshape(48, 64).astype(np.uint16)
    assert len(np.unique(gs.draw(ramp, importance="none", options=gs.Options(density=1.0)).graph.tone)) > 100


def test_the_file_of_a_drawing_is_its_svg_with_a_preview(tmp_path):
    drawing = gs.draw(photo("camera", 60, 40))
    drawing.save(tmp_path / "out.svg")
    drawing.save(tmp_path / "out.png", width=200)
    assert (tmp_path / "out.svg").read_text() == drawing.svg()
    np.testing.assert_array_equal(
        np.asarray(Image.open(io.BytesIO((tmp_path / "out.png").read_bytes())).convert("L")), drawing.rasterize(200)
    )
