"""Everything that can be drawn, and what is refused."""

import os
import sys
from pathlib import Path
from typing import Any

import cv2
import numpy as np
import pytest
from PIL import Image
from tests.support import options_with

import graphstipple as gs
from graphstipple import metrics


def same(first: gs.Drawing, second: gs.Drawing) -> bool:
    return first.svg() == second.svg()


@pytest.fixture(scope="module")
def expected(small: np.ndarray) -> gs.Drawing:
    return gs.draw(small)


def test_path_pil_and_array_give_the_same_bytes(small: np.ndarray, expected: gs.Drawing, tmp_path: Path) -> None:
    path = tmp_path / "photo.png"
    Image.fromarray(small).save(path)
    assert same(gs.draw(path), expected)
    assert same(gs.draw(str(path)), expected)
    assert same(gs.draw(Image.open(path)), expected)
    assert same(gs.draw(Image.fromarray(small)), expected)


@pytest.mark.parametrize("suffix", ["tiff", "webp"])
def test_lossless_files_of_other_formats_give_the_same_bytes(
    small: np.ndarray, expected: gs.Drawing, tmp_path: Path, suffix: str
) -> None:
    path = tmp_path / f"photo.{suffix}"
    Image.fromarray(small).save(path, lossless=True) if suffix == "webp" else Image.fromarray(small).save(path)
    assert same(gs.draw(path), expected)


def test_layouts_and_byte_orders_do_not_matter(small: np.ndarray, expected: gs.Drawing) -> None:
    assert same(gs.draw(np.asfortranarray(small)), expected)
    assert same(gs.draw(np.flip(np.flip(small, 1).copy(), 1)), expected)
    wide = small.astype(np.uint16) * 257
    assert same(gs.draw(wide.astype(">u2")), gs.draw(wide))


def test_depths_agree(small: np.ndarray) -> None:
    grey = small[:, :, 1]
    by_bytes = gs.draw(grey)
    assert same(gs.draw(grey[:, :, np.newaxis]), by_bytes)
    assert same(gs.draw(grey.astype(np.uint16) * 257), by_bytes)
    assert same(gs.draw((grey / np.float32(255)).astype(np.float32)), by_bytes)
    assert same(gs.draw(grey / 255), gs.draw((grey / 255).astype(np.float32)))


def test_linear_light_decodes_srgb() -> None:
    grey = np.array([[0.0, 0.04, 0.5, 1.0]])
    tone = gs.stages.tone(grey, gs.Options(linear=True))
    np.testing.assert_allclose(tone, [[0.0, 0.04 / 12.92, 0.2140, 1.0]], atol=1e-4)
    # Before gamma and inversion.
    adjusted = gs.stages.tone(grey, gs.Options(linear=True, gamma=2.0, invert=True))
    np.testing.assert_allclose(adjusted, 1 - np.sqrt(tone), atol=1e-6)


def test_bool_is_black_and_white(small: np.ndarray) -> None:
    mask = small[:, :, 1] > 127
    assert same(gs.draw(mask), gs.draw(mask.astype(np.uint8) * 255))


def test_16_bits_are_kept(tmp_path: Path) -> None:
    # A ramp inside one 8-bit step: as 8 bits it would be flat, and every tone the same.
    ramp = np.linspace(0x8000, 0x80FF, 4096).round().astype(np.uint16).reshape(64, 64)
    path = tmp_path / "ramp.png"
    Image.fromarray(ramp).save(path)
    drawing = gs.draw(ramp, importance="none")
    assert len(np.unique(drawing.graph.tone)) > 100
    assert same(gs.draw(path, importance="none"), drawing)
    assert same(gs.draw(Image.open(path), importance="none"), drawing)


@pytest.mark.parametrize("background", ["white", "black", "#4080c0"])
def test_transparency_lies_over_the_background(small: np.ndarray, tmp_path: Path, background: str) -> None:
    transparent = np.dstack([small, np.zeros(small.shape[:2], np.uint8)])
    colour = {"white": (255, 255, 255), "black": (0, 0, 0), "#4080c0": (0x40, 0x80, 0xC0)}[background]
    flat = np.full_like(small, colour)
    options = gs.Options(background=background)
    assert same(gs.draw(transparent, options=options), gs.draw(flat, options=options))
    path = tmp_path / "transparent.png"
    # Between nothing and all.
    transparent[:, :, 3] = np.linspace(0, 255, small.shape[1]).astype(np.uint8)
    Image.fromarray(transparent).save(path)
    assert same(gs.draw(path, options=options), gs.draw(transparent, options=options))
    assert same(gs.draw(Image.open(path), options=options), gs.draw(transparent, options=options))


@pytest.mark.parametrize(
    "mode", ["1", "L", "LA", "La", "RGB", "RGBA", "RGBa", "P", "PA", "CMYK", "YCbCr", "HSV", "LAB", "I", "F", "I;16"]
)
def test_every_pil_mode_is_drawn(small: np.ndarray, mode: str) -> None:
    grey = Image.fromarray(small[:, :, 1])
    colour = Image.fromarray(small)
    image = {
        "I": lambda: Image.fromarray(small[:, :, 1].astype(np.int32) * 257),
        "F": lambda: Image.fromarray(small[:, :, 1].astype(np.float32) / 255),
        "I;16": lambda: Image.fromarray(small[:, :, 1].astype(np.uint16) * 257),
        "LA": lambda: colour.convert("LA"),
        "La": lambda: colour.convert("LA").convert("La"),
        "RGBa": lambda: colour.convert("RGBA").convert("RGBa"),
        "PA": lambda: colour.convert("P").convert("PA"),
    }.get(mode, lambda: grey if mode == "L" else colour.convert(mode) if mode != "LAB" else Image.new("LAB", colour.size))()
    assert image.mode == mode
    drawing = gs.draw(image, importance="none")
    assert (drawing.width, drawing.height) == colour.size
    if mode in {"I", "I;16", "F", "L"}:
        assert same(drawing, gs.draw(small[:, :, 1], importance="none"))


def test_transparent_palettes_and_colour_keys_agree_with_the_file(small: np.ndarray, tmp_path: Path) -> None:
    palette = Image.fromarray(small).convert("P")
    for name, image, key in [
        ("p", palette, 3),
        ("l", Image.fromarray(small[:, :, 1]), 120),
        ("rgb", Image.fromarray(small), tuple(small[5, 5])),
    ]:
        path = tmp_path / f"{name}.png"
        image.save(path, transparency=key if isinstance(key, int) else tuple(int(v) for v in key))
        options = gs.Options(background="black")
        assert same(gs.draw(path, options=options), gs.draw(Image.open(path), options=options)), name


def test_exif_orientation_is_applied(small: np.ndarray, tmp_path: Path) -> None:
    upright = gs.draw(np.rot90(small, -1))
    path = tmp_path / "turned.png"
    exif = Image.Exif()
    exif[0x0112] = 6  # turn by a quarter clockwise to see it upright
    Image.fromarray(small).save(path, exif=exif)
    assert same(gs.draw(Image.open(path)), upright)
    assert same(gs.draw(path), upright)


@pytest.mark.parametrize("shape", [(1, 1), (1, 2), (3, 3), (1, 500), (500, 1)])
def test_extreme_shapes_are_drawn(shape: tuple[int, int]) -> None:
    drawing = gs.draw(np.linspace(0, 1, shape[0] * shape[1]).reshape(shape))
    assert drawing.rasterize().shape == shape


@pytest.mark.parametrize(
    ("image", "message"),
    [
        (np.zeros((0, 5)), "no pixels"),
        (np.zeros((5, 0, 3), np.uint8), "no pixels"),
        (np.zeros(5), "shape"),
        (np.zeros((2, 3, 5)), "shape"),
        (np.zeros((2, 3, 0)), "shape"),
        (np.zeros((2, 3, 3, 1)), "shape"),
        (np.zeros((4, 4), np.int64), "int64"),
        (np.zeros((4, 4), complex), "complex"),
        (np.full((4, 4), "a"), "type"),
        (np.full((4, 4), np.nan), "nan at column 0, row 0"),
        (np.array([[0.5, 1.5]]), "1.5 at column 1, row 0"),
        (np.array([[0.5], [-0.25]]), "-0.25 at column 0, row 1"),
        (np.zeros((1, 70_000), np.uint8), "65535"),
        (7, "type int"),
        ([[1, 2], [3, 4]], "type list"),
        (None, "type NoneType"),
    ],
)
def test_wrong_images_are_refused(image: Any, message: str) -> None:
    with pytest.raises(gs.InvalidInputError, match=message):
        gs.draw(image)


def test_files_that_are_no_images_are_refused(small: np.ndarray, tmp_path: Path) -> None:
    with pytest.raises(FileNotFoundError, match=r"missing\.png") as missing:
        gs.draw(tmp_path / "missing.png")
    assert isinstance(missing.value, gs.GraphStippleError)
    with pytest.raises(gs.ImageFileError, match="this is a folder, not a file"):
        gs.draw(tmp_path)
    whole = tmp_path / "whole.png"
    Image.fromarray(small).save(whole)
    for name, content in [("empty.png", b""), ("text.jpg", b"not an image at all"), ("cut.png", whole.read_bytes()[:2000])]:
        (tmp_path / name).write_bytes(content)
        with pytest.raises(gs.ImageFileError, match=name) as error:
            gs.draw(tmp_path / name)
        assert not isinstance(error.value, FileNotFoundError)
        assert "\n" not in str(error.value)


LONELY = "\ud800.png"
CUT_BY_NUL = "photo\0.png"


@pytest.mark.skipif(sys.platform == "win32", reason="file names of Windows may hold lone surrogates")
@pytest.mark.parametrize(
    "read",
    [
        gs.draw,
        gs.Session,
        gs.saliency,
        gs.stages.tone,
        gs.load,
        lambda path: gs.draw(np.zeros((4, 4)), importance=path),
        lambda path: gs.Session(np.zeros((4, 4)), importance=path),
        lambda path: gs.draw(np.zeros((4, 4)), importance=lambda _: path),
    ],
)
@pytest.mark.parametrize("kind", [str, Path])
@pytest.mark.parametrize(("name", "character"), [(LONELY, "U\\+D800"), (CUT_BY_NUL, "U\\+0000")])
def test_names_that_no_file_can_have_are_not_found(read: Any, kind: Any, name: str, character: str) -> None:
    with pytest.raises(
        gs.ImageFileNotFoundError, match=f"the file does not exist, as no file name can hold .* {character}$"
    ) as error:
        read(kind(name))
    assert str(error.value).isprintable()
    assert ascii(name)[1:-1] in str(error.value)


@pytest.mark.skipif(sys.platform == "win32", reason="file names of Windows may hold lone surrogates")
@pytest.mark.parametrize(("name", "character"), [("\ud800.svg", "U\\+D800"), ("drawing\0.svg", "U\\+0000")])
def test_names_that_no_file_can_have_are_not_written(expected: gs.Drawing, tmp_path: Path, name: str, character: str) -> None:
    for path in (name, tmp_path / name, str(tmp_path / name)):
        with pytest.raises(gs.ImageFileError, match=f"cannot be written, as no .* character {character}$") as error:
            expected.save(path)
        assert str(error.value).isprintable()
    assert not list(tmp_path.iterdir())


@pytest.mark.skipif(sys.platform != "linux", reason="file names are bytes")
def test_names_that_are_no_text_name_files(small: np.ndarray, expected: gs.Drawing, tmp_path: Path) -> None:
    path = tmp_path / os.fsdecode(b"caf\xe9.png")
    Image.fromarray(small).save(path)
    assert same(gs.draw(path), expected)
    assert same(gs.draw(os.fsencode(path).decode(errors="surrogateescape")), expected)
    map_ = gs.draw(small, importance=small[:, :, 0])
    Image.fromarray(small[:, :, 0]).save(path)
    for importance in (path, str(path)):
        assert same(gs.draw(small, importance=importance), map_)
    expected.save(tmp_path / os.fsdecode(b"caf\xe9.svg"))
    assert same(gs.load(tmp_path / os.fsdecode(b"caf\xe9.svg")), expected)


# Masked arrays -------------------------------------------------------------------------------------------------------------------


def masked(array: np.ndarray, *places: tuple[int, ...]) -> np.ma.MaskedArray:
    """Return an array with some values masked."""
    mask = np.zeros(array.shape, bool)
    for place in places:
        mask[place] = True
    return np.ma.MaskedArray(array, mask)


def test_masked_values_are_refused(small: np.ndarray) -> None:
    grey = small[:, :, 1]
    two, pixel = masked(grey, (3, 4), (5, 6)), masked(small, (3, 4))
    with pytest.raises(gs.InvalidInputError, match=r"^2 values of the image are masked, .*: image\.filled\(value\) fills") as error:
        gs.draw(two)
    assert "\n" not in str(error.value)
    for read in (gs.draw, gs.Session, gs.saliency, gs.stages.tone):
        with pytest.raises(gs.InvalidInputError, match=r"^3 values of the image are masked"):
            read(pixel)
    with pytest.raises(gs.InvalidInputError, match=r"^1 value of the image is masked"):
        gs.draw(masked(grey / 255, (0, 0)))
    for importance in (two, lambda _: two):
        for read in (gs.draw, gs.Session):
            with pytest.raises(gs.InvalidInputError, match=r"^2 values of the importance are masked, .*: importance\.filled\("):
                read(small, importance)
    assert same(gs.draw(two.filled(9)), gs.draw(np.where(two.mask, np.uint8(9), grey)))


def test_masked_values_are_refused_by_stages_and_metrics() -> None:
    tone = np.linspace(0, 1, 900).reshape(30, 30)
    one = masked(tone, (3, 4))
    with pytest.raises(gs.InvalidInputError, match=r"^1 value of the tone is masked"):
        gs.stages.emphasize(one)
    with pytest.raises(gs.InvalidInputError, match=r"^1 value of the map_ is masked"):
        gs.stages.importance(tone, one)
    with pytest.raises(gs.InvalidInputError, match=r"^2 values of the labels are masked"):
        gs.stages.components([[0, 1], [1, 2]], masked(np.zeros(3, np.uint8), (0,), (2,)))
    with pytest.raises(gs.InvalidInputError, match=r"^1 value of the picture is masked"):
        metrics.ssim(one, tone)
    with pytest.raises(gs.InvalidInputError, match=r"^1 value of the reference is masked"):
        metrics.psnr(tone, one)
    with pytest.raises(gs.InvalidInputError, match=r"^1 value of the picture is masked"):
        metrics.blurred(one)


def test_masked_arrays_without_masked_values_are_their_data(small: np.ndarray, expected: gs.Drawing) -> None:
    # With a mask of nothing, and with none.
    for whole in (masked(small), np.ma.MaskedArray(small)):
        assert same(gs.draw(whole), expected)
        assert same(gs.draw(small, importance=whole[:, :, 0]), gs.draw(small, importance=small[:, :, 0]))
        np.testing.assert_array_equal(gs.stages.emphasize(whole[:, :, 0] / 255), gs.stages.emphasize(small[:, :, 0] / 255))
        assert metrics.psnr(whole[:, :, 0] / 255, small[:, :, 0] / 255) == np.inf


def test_saliency_is_the_default_importance(small: np.ndarray, expected: gs.Drawing) -> None:
    map_ = gs.saliency(small)
    assert map_.shape == small.shape[:2]
    assert map_.dtype == np.float32
    assert map_.min() >= 0
    assert map_.max() <= 1
    np.testing.assert_array_equal(expected.importance, gs.stages.importance(gs.stages.tone(small), map_))
    assert same(gs.draw(small, importance="saliency"), expected)
    assert same(gs.draw(small, importance=None), expected)
    alone = gs.Options(detail=0.0, floor=0.0, midtones=0.0)
    given = gs.draw(small, importance=expected.importance, options=alone)
    np.testing.assert_array_equal(given.graph.sites, expected.graph.sites)


def test_saliency_by_another_method(astronaut: np.ndarray) -> None:
    map_ = gs.saliency(astronaut, method="spectral-residual")
    assert map_.shape == astronaut.shape[:2]
    assert map_.dtype == np.float32
    assert map_.min() >= 0
    assert 0.5 < map_.max() <= 1
    assert not np.array_equal(map_, gs.saliency(astronaut, method="fine-grained"))
    np.testing.assert_array_equal(gs.saliency(astronaut), gs.saliency(astronaut, method="fine-grained"))
    assert gs.draw(astronaut, importance=map_).stats["nodes"] > 1000
    with pytest.raises(gs.InvalidInputError, match='method is "coarse", but it must be "fine-grained" or "spectral-residual"'):
        gs.saliency(astronaut, method="coarse")  # type: ignore[arg-type]


@pytest.mark.parametrize("method", ["fine-grained", "spectral-residual"])
def test_saliency_without_opencvs_says_what_to_install(
    small: np.ndarray, expected: gs.Drawing, monkeypatch: pytest.MonkeyPatch, method: Any
) -> None:
    # Another wheel of OpenCV has taken its place.
    with monkeypatch.context() as patch:
        patch.delattr(cv2, "saliency")
        with pytest.raises(gs.MissingPackageError, match=r"pip install .*opencv-contrib-python-headless$") as missing:
            gs.saliency(small, method=method)
        assert "\n" not in str(missing.value)
        assert same(gs.draw(small), expected)
        assert same(gs.Session(small).draw(), expected)
    with monkeypatch.context() as patch:
        patch.setitem(sys.modules, "cv2", None)
        with pytest.raises(gs.MissingPackageError, match=r"pip install opencv-contrib-python-headless$"):
            gs.saliency(small, method=method)
        assert same(gs.draw(small), expected)


@pytest.mark.parametrize("image", [np.full((40, 60), 0.3), np.zeros((1, 1)), np.zeros((2, 2)), np.ones((1, 300))])
def test_saliency_of_flat_and_tiny_images_is_zero(image: np.ndarray) -> None:
    map_ = gs.saliency(image)
    assert map_.shape == image.shape
    assert not map_.any()


def test_importance_by_name() -> None:
    ramp = np.linspace(0, 1, 64 * 64).reshape(64, 64)
    fine = options_with(density=1.0)
    everywhere = gs.draw(ramp, importance="none", options=fine)
    assert (everywhere.importance == 1).all()
    assert everywhere.stats["nodes"] == everywhere.stats["lattice_nodes"]
    third = gs.draw(ramp, importance="constant:0.3", options=fine)
    np.testing.assert_array_equal(third.importance, np.float32(0.3))
    assert third.stats["nodes"] == pytest.approx(0.3 * everywhere.stats["nodes"], rel=0.01)
    # A map of ones is everywhere, too, whatever its size.
    alone = options_with(density=1.0, detail=0.0, floor=0.0, midtones=0.0)
    for ones in (np.ones((64, 64)), np.ones((10, 7))):
        np.testing.assert_array_equal(gs.draw(ramp, importance=ones, options=alone).graph.sites, everywhere.graph.sites)


def test_importance_maps_of_every_kind_agree(small: np.ndarray, tmp_path: Path) -> None:
    map_ = np.zeros((48, 64), np.uint8)
    map_[:, 32:] = 255
    by_array = gs.draw(small, importance=map_)
    path = tmp_path / "map.png"
    Image.fromarray(map_).save(path)
    for other in [path, str(path), Image.fromarray(map_), map_ / 255, map_.astype(np.uint16) * 257, map_ > 0]:
        assert same(gs.draw(small, importance=other), by_array)
    right = by_array.graph.sites[:, 0] > by_array.width / 2
    assert right.mean() > 0.95


@pytest.mark.parametrize(
    ("importance", "message"),
    [
        ("constant:2", "constant"),
        ("constant:", "constant"),
        (np.zeros((4, 4, 3)), "shape"),
        (np.full((4, 4), np.nan), "nan"),
        (np.full((4, 4), 2.0), "2.0"),
        (np.zeros((0, 4)), "no pixels"),
        (np.zeros((4, 0)), "no pixels"),
        (np.zeros((4, 4, 4, 4)), "shape"),
        (3, "type int"),
    ],
)
def test_wrong_importances_are_refused(small: np.ndarray, importance: Any, message: str) -> None:
    with pytest.raises(gs.InvalidInputError, match=message):
        gs.draw(small, importance=importance)


def test_missing_importance_files_are_named(small: np.ndarray) -> None:
    with pytest.raises(FileNotFoundError, match=r"missing\.png"):
        gs.draw(small, importance="missing.png")
    with pytest.raises(gs.InvalidInputError, match="importance is salience, but it must be saliency, none"):
        gs.draw(small, importance="salience")


# Points, and drawings that come out blank ----------------------------------------------------------------------------------------


def soft_spot(low: float, high: float) -> np.ndarray:
    """Return a soft dark spot in the middle of a light ground, between two greys."""
    y, x = np.mgrid[-1:1:64j, -1.5:1.5:96j]
    return (high - (high - low) * np.exp(-3 * (x * x + y * y))).astype(np.float32)


@pytest.mark.parametrize(("low", "high", "colour"), [(0.93, 1.0, "white"), (0.0, 0.06, "black")])
def test_a_blank_drawing_is_told_and_points_show_its_subject(low: float, high: float, colour: str) -> None:
    faint = soft_spot(low, high)
    with pytest.warns(gs.GraphStippleWarning, match=f"the whole drawing is {colour}, as the photo's tones lie between {low:.2f}"):
        gs.draw(faint, options=gs.Options(stippling=0))
    session = gs.Session(faint)
    with pytest.warns(gs.GraphStippleWarning, match="white point and black point to auto"):
        session.draw(gs.Options(stippling=0))
    # Nothing is said where there is something to see, or nothing in the photo: warnings are errors here.
    assert gs.draw(faint).stats["stipples"] > 10
    options = gs.Options(white_point="auto", black_point="auto", stippling=0)
    for drawing in (gs.draw(faint, options=options), session.draw(options)):
        middle, corner = drawing.rasterize()[24:40, 36:60], drawing.rasterize()[:16, :24]
        assert middle.mean() < 40
        assert corner.mean() > 215
    gs.draw(np.full((20, 30), 235, np.uint8))
    gs.draw(np.tile(np.array([[254, 255]], np.uint8), (20, 15)))


def test_points_are_greys_of_the_photo() -> None:
    luma = np.array([[0.2, 0.4, 0.5, 0.6, 0.9]])
    stretched = gs.stages.tone(luma, gs.Options(black_point=0.4, white_point=0.6))
    np.testing.assert_allclose(stretched, [[0, 0, 0.5, 1, 1]], atol=1e-6)
    # As percentiles have it, of a noise with specks.
    noise = np.random.default_rng(3).uniform(0.3, 0.7, (100, 200)).astype(np.float32)
    noise[0, :50], noise[0, 50:100] = 0, 1
    black, white = np.sort(noise.ravel())[[99, 19900]]
    tone = gs.stages.tone(noise, gs.Options(black_point="auto", white_point="auto"))
    np.testing.assert_allclose(tone, np.clip((noise - black) / (white - black), 0, 1), atol=1e-6)
    with pytest.raises(gs.InvalidInputError, match=r"the photo's white point is 0\.900, but it must be above its black point"):
        gs.draw(luma, options=gs.Options(black_point=0.95, white_point="auto"))
    with pytest.raises(gs.InvalidInputError, match=r"white_point is 0\.3, but it must be above black_point, which is 0\.4"):
        gs.Options(black_point=0.4, white_point=0.3)
