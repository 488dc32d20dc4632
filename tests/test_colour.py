"""The colour of photos: the same from files, bytes, PIL images, arrays and Pillow's files."""

from __future__ import annotations

import io
import pickle
from pathlib import Path

import numpy as np
import numpy.typing as npt
import pytest
from PIL import Image

import graphstipple as gs
from graphstipple import _core
from graphstipple._inputs import NOTHING, read_luma, read_photo

WHITE = (255, 255, 255)
LEVEL = 1.01 / 255


def picture(mode: str = "RGB") -> Image.Image:
    """Return a picture of 90 x 60 pixels, smooth, so that JPEG stays near it; in mode RGBA fading to the right."""
    y, x = np.mgrid[:60, :90]
    planes = [x * 2.8, y * 4.2, 255 - x - y, 255 - x * 2]
    return Image.fromarray(np.stack(planes[: len(mode)], 2).astype(np.uint8), mode)


def composited(image: Image.Image, background: tuple[int, int, int]) -> npt.NDArray[np.float64]:
    """Return its colour over a background, in [0, 1]."""
    samples = np.asarray(image) / 255.0
    if samples.shape[2] == 3:
        return samples
    return samples[..., :3] * samples[..., 3:] + np.array(background) / 255 * (1 - samples[..., 3:])


def saved(image: Image.Image, kind: str, **how: object) -> bytes:
    """Return the file."""
    buffer = io.BytesIO()
    image.save(buffer, kind, **how)
    return buffer.getvalue()


@pytest.mark.parametrize("mode", ["RGB", "RGBA"])
@pytest.mark.parametrize("background", [WHITE, (200, 30, 90)])
def test_all_inputs_have_one_colour(tmp_path: Path, mode: str, background: tuple[int, int, int]) -> None:
    image = picture(mode)
    options = gs.Options(background="#{:02x}{:02x}{:02x}".format(*background))
    expected = composited(image, background)
    data = saved(image, "PNG")
    path = tmp_path / "photo.png"
    path.write_bytes(data)
    floats = (np.asarray(image) / 255).astype(np.float32)
    deep = np.asarray(image).astype(np.uint16) * 257
    for given in (path, str(path), data, image, np.asarray(image), floats, deep):
        colour = gs.stages.colour(given, options)
        assert colour.dtype == np.float32
        assert colour.shape == (60, 90, 3)
        assert abs(colour - expected).max() < 1e-6
        luma = read_luma(given, background)
        assert abs(colour @ np.array([0.299, 0.587, 0.114]) - luma).max() < 1e-6


@pytest.mark.parametrize("kind", ["PNG", "JPEG", "TIFF", "WEBP", "BMP", "PPM"])
def test_files_of_all_kinds_and_their_images_agree(kind: str) -> None:
    data = saved(picture(), kind, **({"quality": 95, "subsampling": 0} if kind == "JPEG" else {}))
    ours, theirs = gs.stages.colour(data), gs.stages.colour(Image.open(io.BytesIO(data)))
    # Decoders of JPEG and WebP round differently.
    assert abs(ours - theirs).max() <= (2 * LEVEL if kind in {"JPEG", "WEBP"} else 1e-6)
    assert abs(ours - composited(picture(), WHITE)).mean() < 0.01


def test_a_palette_a_turned_photo_and_inks_have_their_colours() -> None:
    indexed = picture().quantize(32)
    assert abs(gs.stages.colour(saved(indexed, "PNG")) - np.asarray(indexed.convert("RGB")) / 255).max() < 1e-6
    exif = Image.Exif()
    exif[0x0112] = 6
    turned = gs.stages.colour(saved(picture(), "PNG", exif=exif))
    assert abs(turned - np.rot90(composited(picture(), WHITE), -1)).max() < 1e-6
    inks = picture().convert("CMYK")
    for given in (saved(inks, "TIFF"), inks):
        assert abs(gs.stages.colour(given) - np.asarray(inks.convert("RGB")) / 255).max() <= LEVEL


def test_grey_is_grey() -> None:
    grey = np.linspace(0, 1, 35, dtype=np.float32).reshape(5, 7)
    assert np.array_equal(gs.stages.colour(grey), np.repeat(grey[..., np.newaxis], 3, 2))


@pytest.mark.parametrize("colour", [False, True])
def test_colour_is_kept_only_where_it_is_asked_for_and_leaves_the_luma_alone(colour: bool) -> None:
    options = gs.Options(nodes=500)
    rng = np.random.default_rng(1)
    samples = rng.integers(0, 256, (1400, 1700, 3), np.uint8)
    reading = _core.Reading(WHITE, options._checked, _core.MAX_PIXELS, False)
    reduced, _, _ = read_photo(samples, reading, colour=colour)
    assert reduced.factor > 1
    assert np.array_equal(reduced.luma, _core.photo(samples, NOTHING, reading).luma)
    assert not options._checked.wants_colour()
    if not colour:
        assert reduced.colour is None
        return
    k = reduced.factor
    assert reduced.colour is not None
    assert abs(reduced.colour[0, 0] - samples[:k, :k].mean((0, 1)) / 255).max() < 1e-6
    assert reduced.colour.shape == (*reduced.luma.shape, 3)


def test_a_pickled_photo_has_its_colour() -> None:
    reading = _core.Reading(WHITE, None, _core.MAX_PIXELS, False)
    photo = _core.photo(np.asarray(picture()), NOTHING, reading, colour=True)
    again = pickle.loads(pickle.dumps(photo))
    assert np.array_equal(again.colour, photo.colour)
    assert np.array_equal(again.luma, photo.luma)
    # Grey is packed once.
    grey = _core.photo(np.asarray(picture().convert("L"))[..., np.newaxis], NOTHING, reading, colour=True)
    size = len(pickle.dumps(grey))
    assert size < 2 * grey.luma.nbytes
    assert pickle.loads(pickle.dumps(grey)).colour is not None
    with pytest.raises(gs.InvalidInputError, match="the colour has 2 x 2 pixels, but it must have 90 x 60 as the luma has"):
        _core.Photo(photo.luma, photo.size, 1, [np.zeros((2, 2), np.float32)] * 3)


def test_a_session_is_without_the_colour_that_no_option_wants() -> None:
    options = gs.Options(nodes=400)
    session = gs.Session(picture())
    photo, _, _ = session._state.session.packed()
    assert photo.colour is None
    assert session.draw(options).svg() == gs.draw(picture(), options=options).svg()
    assert pickle.loads(pickle.dumps(session)).draw(options).svg() == session.draw(options).svg()
