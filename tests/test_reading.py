"""Every kind of image file is read right, or refused in the user's words.

The files are those of `tests/corpus`. The table in `docs/formats.md` is what this run found:
`GRAPHSTIPPLE_UPDATE_FORMATS=1 pytest tests/test_reading.py` writes it anew, and fails, so that it does not pass unnoticed.
"""

from __future__ import annotations

import functools
import io
import os
import re
import warnings
from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest
from PIL import Image
from tests.commands import FAILURE, assert_one_sentence, done, native_binary, run
from tests.corpus import BY_NAME, CASES, CLOSE, Case, Drawn, Made, Refused, Warned, jpeg, png, tiff, tiff_writer, webp
from tests.corpus.colour import luma_of_pil
from tests.corpus.others import Foreign, foreign
from tests.support import ROOT

import graphstipple as gs
from graphstipple import _core
from graphstipple._inputs import read_luma

WHITE = (255, 255, 255)
FORMATS = ROOT / "docs" / "formats.md"
UPDATE = bool(os.environ.get("GRAPHSTIPPLE_UPDATE_FORMATS"))
BEGIN, END = "<!-- The table begins: made by tests/test_reading.py. -->", "<!-- The table ends. -->"
CORE = ("JPEG", "PNG", "TIFF", "WebP")
"""Containers that the core reads."""

WAYS_OUT = re.compile(r"\b(convert|save|export|open|unpack|extract|download|fetch|pull|render|install|develop|take)", re.IGNORECASE)
"""One of these is said of a format that is not read."""
NO_WAY_OUT = {"notes.jpg", "noise.jpg", "nothing.jpg"}
"""Of these there is nothing to be said but that they are no images."""

DEBUG_PRINTS = ("unknown(", "chunktype", "error", "some(", "panicked", "\n", "{", "::", "internal")

on_every_case = pytest.mark.parametrize("name", BY_NAME)
on_every_foreign = pytest.mark.parametrize("file", foreign(), ids=lambda file: file.name)


@functools.cache
def made(name: str) -> Made:
    return BY_NAME[name].make()


def written(name: str, folder: Path) -> Path:
    """Write a case's file, without a suffix: the content tells what it is."""
    path = folder / name
    path.write_bytes(made(name).data)
    return path


def distance(luma: np.ndarray, expected: Drawn) -> float:
    """Return the mean difference of two lumas over all pixels."""
    assert luma.shape == expected.luma.shape
    return float(np.abs(luma - expected.luma).mean())


def assert_plain(message: str) -> None:
    """Check that a message is in the user's words."""
    assert 15 < len(message) < 400
    assert not [word for word in DEBUG_PRINTS if word in message.lower()], message


def refusal(path: Path) -> str:
    """Return why a file is not read, without its path."""
    with pytest.raises(gs.ImageFileError) as error:
        read_luma(path, WHITE)
    message = str(error.value).replace(str(path), "")
    assert_plain(message)
    return message


def assert_says(message: str, expected: Refused) -> None:
    lower = message.lower()
    assert all(word.lower() in lower for word in expected.words), message
    assert not [word for word in expected.without if word.lower() in lower], message
    assert not expected.any_of or any(word.lower() in lower for word in expected.any_of), message


# The corpus ----------------------------------------------------------------------------------------------------------------------


@on_every_case
def test_what_is_expected_is_what_others_read(name: str) -> None:
    expected, witness = made(name).expect, made(name).witness
    if witness is not None:
        assert isinstance(expected, Drawn)
        assert distance(witness, expected) <= expected.tolerance


@on_every_case
def test_a_file_is_read_right_or_refused(name: str, tmp_path: Path) -> None:
    path, expected = written(name, tmp_path), made(name).expect
    if isinstance(expected, Refused):
        # Of numbers, the core speaks as of those of arrays.
        if name == "tiff_float32_nan":
            with pytest.raises(gs.GraphStippleError, match=r"(?i)\bnan\b|not a number"):
                read_luma(path, WHITE)
            return
        assert_says(refusal(path), expected)
        return
    with warnings.catch_warnings():
        # Where nothing is wrong with a file, nothing is said: warnings are errors here.
        if isinstance(expected, Warned):
            warnings.simplefilter("ignore", gs.GraphStippleWarning)
        luma = read_luma(path, WHITE)
    assert luma.dtype == np.float32
    assert distance(luma, expected) <= expected.tolerance


@pytest.mark.parametrize("name", [case.name for case in CASES if case.pixel_type.startswith("all pixels")])
def test_what_lacks_its_end_only_is_drawn_with_a_warning(name: str, tmp_path: Path) -> None:
    path, expected = written(name, tmp_path), made(name).expect
    assert isinstance(expected, Warned)
    with pytest.warns(gs.GraphStippleWarning) as told:
        drawing = gs.draw(path)
    assert (drawing.height, drawing.width) == expected.luma.shape
    messages = [str(warning.message).replace(str(path), "") for warning in told]
    assert any(all(word in message.lower() for word in expected.words) for message in messages), messages
    for message in messages:
        assert_plain(message)


# Turned and profiled as PIL images -----------------------------------------------------------------------------------------------

AS_PIL = [
    *[f"{container}_orientation{i}" for container in ("jpeg", "png", "tiff", "webp") for i in range(1, 9)],
    *["png_iccp_rgb8", "png_iccp_grey8", "png_iccp_rgba8", "png_iccp_palette", "webp_lossy_icc", "webp_icc_alpha"],
    *["jpeg_icc", "jpeg_icc_linear", "jpeg_icc_grey", "jpeg_cmyk", "jpeg_cmyk_profile", "jpeg_ycck_profile", "jpeg_icc_broken"],
    *["tiff_icc_rgb8", "tiff_icc_grey8", "tiff_icc_alpha8", "tiff_associated_rgb8"],
]


@pytest.mark.parametrize("name", AS_PIL)
def test_a_pil_image_is_read_as_its_file(name: str) -> None:
    expected = made(name).expect
    assert isinstance(expected, Drawn)
    luma = read_luma(Image.open(io.BytesIO(made(name).data)), WHITE)
    # Pillow has 8 bits, and rounds once more where it undoes a product with alpha.
    assert distance(luma, expected) <= max(expected.tolerance, 1.5 * CLOSE)


# Cut short -----------------------------------------------------------------------------------------------------------------------

WHOLE: dict[str, Callable[[], bytes]] = {
    "baseline.jpg": jpeg.jpeg,
    "progressive.jpg": jpeg.progressive,
    "apart.jpg": lambda: jpeg.jpeg(scans=[[0], [1], [2]]),
    "arithmetic.jpg": (jpeg.HERE / "arithmetic.jpg").read_bytes,
    "rgb.png": png.whole,
    "interlaced.png": lambda: png.plain(png.RGB, 8, interlaced=True).data,
    "strips.tif": lambda: tiff_writer.tiff(tiff.rgb()),
    "first.tif": lambda: tiff_writer.directory_first(tiff.rgb()),
    "lzw.tif": lambda: tiff_writer.directory_first(tiff.rgb(compression=tiff_writer.LZW)),
    "tiles.tif": lambda: tiff_writer.directory_first(tiff.rgb(compression=tiff_writer.DEFLATE, tile=tiff.TILE)),
    "big.tif": lambda: tiff_writer.tiff(tiff.rgb(), big=True),
    "lossy.webp": lambda: webp.saved(webp.rgb(), False),
    "lossless.webp": lambda: webp.saved(webp.rgb(), True),
    "alpha.webp": lambda: webp.saved(webp.rgba(), False),
}


@pytest.mark.parametrize("name", WHOLE)
@pytest.mark.parametrize("share", [0.5, 0.3, 0.1])
def test_what_has_half_of_its_pixels_is_refused(name: str, share: float, tmp_path: Path) -> None:
    data = WHOLE[name]()
    path = tmp_path / name
    path.write_bytes(data[: round(len(data) * share)])
    assert "cut short" in refusal(path).lower()


@pytest.mark.parametrize("name", WHOLE)
def test_what_is_cut_anywhere_is_never_drawn_in_silence(name: str, tmp_path: Path) -> None:
    data = WHOLE[name]()
    path = tmp_path / name
    for length in {*range(1, len(data) - 1, max(1, len(data) // 25)), *range(len(data) - 12, len(data))}:
        path.write_bytes(data[:length])
        with warnings.catch_warnings(record=True) as told:
            warnings.simplefilter("always")
            try:
                read_luma(path, WHITE)
            except gs.ImageFileError as error:
                assert_plain(str(error).replace(str(path), ""))
                continue
        assert told, f"{name} of {length} of {len(data)} bytes was read as if it were whole"


# Other formats -------------------------------------------------------------------------------------------------------------------


@pytest.fixture(scope="session")
def binary() -> Path:
    return native_binary()


@on_every_foreign
def test_the_native_binary_names_a_format_and_the_way_out(file: Foreign, binary: Path, tmp_path: Path) -> None:
    path = tmp_path / file.name
    path.write_bytes(file.data)
    result = run(binary, path, "-o", tmp_path / "out.svg")
    assert_one_sentence(result, FAILURE)
    message = result.stderr.decode().rstrip("\n").replace(str(path), "").removeprefix("graphstipple: error: ")
    assert_says(message, Refused(any_of=file.words))
    assert_plain(message)
    assert file.name in NO_WAY_OUT or WAYS_OUT.search(message), message


@on_every_foreign
def test_python_reads_what_pillow_reads_and_names_the_rest(file: Foreign, tmp_path: Path) -> None:
    path = tmp_path / file.name
    path.write_bytes(file.data)
    if file.by_pillow:
        with Image.open(path) as image:
            expected = luma_of_pil(image.convert("RGB"))
        assert distance(read_luma(path, WHITE), Drawn(expected)) <= CLOSE
    else:
        assert_says(refusal(path), Refused(any_of=file.words))


@pytest.mark.parametrize("name", ["jpeg_2x2", "png_rgba16", "tiff_grey12", "webp_lossless_alpha"])
def test_the_native_binary_draws_what_python_does(name: str, binary: Path, tmp_path: Path) -> None:
    path = written(name, tmp_path)
    done(binary, path, "-o", tmp_path / "out.svg")
    assert gs.draw(path).svg() == (tmp_path / "out.svg").read_text(encoding="utf-8")


# The table in the docs -----------------------------------------------------------------------------------------------------------


def reader(case: Case, folder: Path) -> str:
    """Return who reads a case rightly: the core, Pillow, or nobody."""
    path, expected = written(case.name, folder), made(case.name).expect
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", gs.GraphStippleWarning)
        for name in ("core", "Pillow"):
            try:
                luma = _by_the_core(path) if name == "core" else read_luma(path, WHITE)
            except gs.GraphStippleError:
                continue
            if isinstance(expected, Refused) or luma.shape != expected.luma.shape:
                return "wrong"
            if distance(luma, expected) > expected.tolerance:
                return "wrong"
            return f"{name}, with a warning" if isinstance(expected, Warned) else name
    return "refused"


def _by_the_core(path: Path) -> np.ndarray:
    """Read a file, unless Pillow has to."""
    photo, _, decoder = _core.read_photo(str(path), _core.Reading(WHITE, None, _core.MAX_PIXELS, False))
    if decoder != "graphstipple":
        raise gs.ImageFileError(decoder)
    return photo.luma


def table(folder: Path) -> str:
    """Return what is read, by container and pixel type, as a table."""
    found: dict[tuple[str, str], list[str]] = {}
    for case in CASES:
        readers = found.setdefault((case.container, case.pixel_type), [])
        who = reader(case, folder)
        if who not in readers:
            readers.append(who)
    lines = ["| Container | What is in it | Read by |", "|---|---|---|"]
    lines += [f"| {container} | {what} | {' or '.join(readers)} |" for (container, what), readers in found.items()]
    return "\n".join(lines)


def test_the_table_of_formats_is_what_is_read(tmp_path: Path) -> None:
    text = FORMATS.read_text(encoding="utf-8")
    head, rest = text.split(BEGIN)
    tail = rest.split(END)[1]
    current = f"{head}{BEGIN}\n\n{table(tmp_path)}\n\n{END}{tail}"
    if UPDATE:
        FORMATS.write_text(current, encoding="utf-8")
        pytest.fail("wrote the table of docs/formats.md anew: look at it, then run without GRAPHSTIPPLE_UPDATE_FORMATS")
    assert text == current, "the table of docs/formats.md is stale: GRAPHSTIPPLE_UPDATE_FORMATS=1 pytest tests/test_reading.py"
