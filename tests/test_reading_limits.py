"""Bounds of what is read: pixels, profiles and memory; what there is of a damaged file; who has read it."""

from __future__ import annotations

import io
import json
import struct
import subprocess
import sys
import zlib
from pathlib import Path

import numpy as np
import pytest
from numpy.typing import NDArray
from PIL import Image
from tests.commands import FAILURE, USAGE, assert_one_sentence, done, native_binary, run
from tests.corpus import BY_NAME
from tests.corpus.colour import ADOBE_XY, rgb_profile

import graphstipple as gs
from graphstipple._inputs import read_luma

WHITE = (255, 255, 255)


def picture(height: int = 240, width: int = 96) -> NDArray[np.uint8]:
    """Return a smooth picture with nothing of white in it."""
    y, x = np.mgrid[:height, :width]
    return np.stack([60 + x, 40 + y * 150 // height, 90 + (x + y) // 4], axis=-1).astype(np.uint8)


def file_of(kind: str, image: Image.Image, **options: object) -> bytes:
    data = io.BytesIO()
    image.save(data, kind, **options)
    return data.getvalue()


def chunk(name: bytes, content: bytes) -> bytes:
    return struct.pack(">I", len(content)) + name + content + struct.pack(">I", zlib.crc32(name + content))


def bomb(width: int, height: int) -> bytes:
    """Return a PNG of one bit a pixel that is small and legal."""
    header = struct.pack(">IIBBBBB", width, height, 1, 0, 0, 0, 0)
    rows = zlib.compress(bytes((width + 7) // 8 + 1) * height, 9)
    return b"\x89PNG\r\n\x1a\n" + chunk(b"IHDR", header) + chunk(b"IDAT", rows) + chunk(b"IEND", b"")


@pytest.fixture
def written(tmp_path: Path) -> Path:
    path = tmp_path / "photo"
    path.write_bytes(file_of("PNG", Image.fromarray(picture())))
    return path


def test_images_with_more_pixels_than_allowed_are_refused(written: Path) -> None:
    pixels = 240 * 96
    gs.draw(written, max_pixels=pixels)
    told = f"96 x 240 pixels, but at most {pixels - 1} pixels are read"
    with Image.open(written) as opened:
        for image in (written, opened, picture()):
            with pytest.raises(gs.GraphStippleError, match=told) as error:
                gs.draw(image, max_pixels=pixels - 1)
            # A file cannot be read; an image or an array breaks a rule.
            assert isinstance(error.value, gs.ImageFileError if image is written else gs.InvalidInputError)
    with pytest.raises(gs.GraphStippleError, match=told):
        gs.Session(written, max_pixels=pixels - 1)
    with pytest.raises(gs.ImageFileError, match=told):
        gs.draw(np.full((20, 20), 0.5), written, max_pixels=pixels - 1)


@pytest.mark.parametrize("wrong", [0, -1, 250_000_001, 1.5, "many", True, None, float("nan")])
def test_a_limit_that_is_none_is_refused(written: Path, wrong: object) -> None:
    with pytest.raises(gs.InvalidInputError, match=r"max_pixels is .*, but it must be between 1 and 250000000 pixels"):
        gs.draw(written, max_pixels=wrong)  # type: ignore[arg-type]  # what the test is about


def test_the_command_line_has_the_limit_too(written: Path, tmp_path: Path) -> None:
    target = tmp_path / "a.svg"
    refused = run(native_binary(), str(written), "-o", str(target), "--max-pixels", "23039")
    assert_one_sentence(refused, FAILURE)
    assert "at most 23039 pixels" in refused.stderr.decode()
    for wrong in ("0", "-3", "many", "250000001"):
        assert_one_sentence(run(native_binary(), str(written), "-o", str(target), "--max-pixels", wrong), USAGE)
    assert not target.exists()
    done(native_binary(), str(written), "-o", str(target), "--max-pixels", "23040")


def peak(code: str, path: Path) -> int:
    """Return the most memory, in kB, that a program takes which draws a file; it must print something."""
    # Not by getrusage, which counts what this process had when it started the other.
    told = "print([line for line in open('/proc/self/status') if line.startswith('VmHWM')][0].split()[1])\n"
    done = subprocess.run([sys.executable, "-c", code + told, str(path)], capture_output=True, text=True, check=True)
    first, kilobytes = done.stdout.split()
    assert first
    return int(kilobytes)


on_linux = pytest.mark.skipif(not sys.platform.startswith("linux"), reason="the bounds of memory are told and kept by Linux alone")


@on_linux
def test_a_bomb_is_refused_before_it_takes_memory(tmp_path: Path) -> None:
    path = tmp_path / "bomb.png"
    path.write_bytes(bomb(15_000, 15_000))
    assert path.stat().st_size < 60_000
    code = (
        "import sys, graphstipple as gs\n"
        "try:\n    gs.draw(sys.argv[1], max_pixels=1_000_000)\n"
        "except gs.ImageFileError:\n    print('refused')\n"
    )
    assert peak(code, path) < 150_000


@on_linux
def test_a_large_photo_is_read_in_little_memory(tmp_path: Path) -> None:
    path = tmp_path / "large.png"
    path.write_bytes(bomb(12_000, 12_000))
    code = "import sys, graphstipple as gs\nprint(gs.draw(sys.argv[1], 'none', gs.Options(nodes=20)).stats['reduction'])\n"
    # The pixels alone would take 576 MB as luma.
    assert peak(code, path) < 300_000


@on_linux
@pytest.mark.parametrize("kind", ["JPEG", "WEBP"])
def test_too_little_memory_is_one_sentence(kind: str, tmp_path: Path) -> None:
    path = tmp_path / "photo"
    Image.new("RGB", (12_000, 12_000), "grey").save(path, kind, **({"method": 0} if kind == "WEBP" else {}))
    refused = run(
        Path("/bin/sh"), "-c", 'ulimit -v 400000; exec "$@"', "sh", native_binary(), str(path), "-o", str(tmp_path / "a.svg")
    )
    assert_one_sentence(refused, FAILURE)
    assert "there is not enough memory to read the image" in refused.stderr.decode()


@pytest.mark.parametrize("container", ["PNG", "JPEG", "WEBP", "TIFF"])
def test_an_embedded_profile_has_a_largest_size(container: str, tmp_path: Path) -> None:
    path = tmp_path / "photo"
    small = Image.fromarray(picture(8, 8))
    profile = rgb_profile(ADOBE_XY, 2.2)
    for size, is_read in ((3 << 20, True), (17 << 20, False)):
        if container == "JPEG" and not is_read:
            continue  # No JPEG can hold as much.
        path.write_bytes(file_of(container, small, icc_profile=profile + bytes(size - len(profile))))
        if is_read:
            assert abs(read_luma(path, WHITE) - read_luma(small, WHITE)).mean() > 0.005
        else:
            with pytest.raises(gs.ImageFileError, match="colour profile of"):
                read_luma(path, WHITE)


def cut(kind: str) -> tuple[bytes, NDArray[np.float32]]:
    """Return a file that lacks its lower third or so, and the luma of the whole."""
    image = Image.fromarray(picture())
    whole = file_of(kind, image, **({"quality": 95} if kind == "JPEG" else {}))
    luma = read_luma(Image.open(io.BytesIO(whole)), WHITE)
    if kind != "TIFF":
        return whole[: len(whole) * 2 // 3], luma
    made = BY_NAME["tiff_directory_first"].make()
    return made.data[: len(made.data) * 2 // 3], np.asarray(made.expect.luma, np.float32)  # type: ignore[union-attr]  # it is drawn


@pytest.mark.parametrize("kind", ["PNG", "JPEG", "TIFF"])
def test_what_there_is_of_a_damaged_file_is_drawn_if_that_is_wanted(kind: str, tmp_path: Path) -> None:
    path, target = tmp_path / "photo", tmp_path / "a.svg"
    data, luma = cut(kind)
    path.write_bytes(data)
    with pytest.raises(gs.ImageFileError, match=r"cut short.* \(allow_damaged draws what is there\)"):
        gs.draw(path)
    refused = run(native_binary(), str(path), "-o", str(target))
    assert_one_sentence(refused, FAILURE)
    assert refused.stderr.decode().rstrip().endswith("(--allow-damaged draws what is there)")

    seen: list[NDArray[np.float32]] = []
    with pytest.warns(gs.GraphStippleWarning, match="cut short.*; the rest is background"):
        drawing = gs.draw(path, lambda luma: seen.append(luma) or "none", allow_damaged=True)
    assert (drawing.height, drawing.width) == luma.shape == seen[0].shape
    rows = len(luma)
    there = next((y for y in range(rows) if (seen[0][y] == 1).all()), rows)
    assert rows // 3 < there < rows
    assert (seen[0][there:] == 1).all()
    assert abs(seen[0][:there] - luma[:there]).mean() < 0.004

    drawn = done(native_binary(), str(path), "-o", str(target), "--importance", "none", "--allow-damaged")
    assert "warning: " in drawn.stderr.decode()
    assert "the rest is background" in drawn.stderr.decode()
    with pytest.warns(gs.GraphStippleWarning):
        assert gs.draw(path, "none", allow_damaged=True).svg().encode() == target.read_bytes()
    with pytest.warns(gs.GraphStippleWarning):
        assert gs.Session(path, "none", allow_damaged=True).draw().svg().encode() == target.read_bytes()


def test_a_damaged_map_is_told_of_too(tmp_path: Path) -> None:
    path = tmp_path / "map.png"
    path.write_bytes(cut("PNG")[0])
    with pytest.raises(gs.ImageFileError, match="cut short"):
        gs.draw(picture(), path)
    with pytest.warns(gs.GraphStippleWarning, match="map.png: the PNG file is cut short"):
        gs.draw(picture(), path, allow_damaged=True)


def test_stats_say_who_has_read_the_file(written: Path, tmp_path: Path) -> None:
    assert gs.draw(written).stats["decoder"] == "graphstipple"
    assert gs.draw(picture()).stats["decoder"] is None
    gif = tmp_path / "photo.gif"
    Image.fromarray(picture()[..., 0]).save(gif)
    assert gs.draw(gif).stats["decoder"].startswith("Pillow ")
    assert gs.Session(gif).draw().stats["decoder"].startswith("Pillow ")


def test_the_command_that_pip_installs_asks_pillow(tmp_path: Path) -> None:
    python, ours = Path(sys.executable), ["-m", "graphstipple"]
    gif, png = tmp_path / "photo.gif", tmp_path / "photo.png"
    grey = Image.fromarray(picture()[..., 0])
    grey.save(gif)
    grey.save(png)
    target = tmp_path / "a.svg"
    svgs = set()
    for image, decoder in ((gif, "Pillow "), (png, "graphstipple")):
        drawn = done(python, *ours, image, "-o", str(target), "--stats", "--quiet")
        assert json.loads(drawn.stdout)["decoder"].startswith(decoder)
        svgs.add(target.read_bytes())
        piped = subprocess.run(
            [python, *ours, "-", "-o", str(target), "--quiet"], input=image.read_bytes(), check=True, capture_output=True
        )
        assert not piped.stderr
        svgs.add(target.read_bytes())
    assert len(svgs) == 1

    refused = run(native_binary(), str(gif), "-o", str(target))
    assert_one_sentence(refused, FAILURE)
    assert "GIF" in refused.stderr.decode()
    assert "Python" in refused.stderr.decode()


@pytest.mark.parametrize("kind", ["GIF", "BMP", "PPM"])
def test_what_pillow_cannot_finish_is_one_sentence(kind: str, tmp_path: Path) -> None:
    path = tmp_path / "photo"
    data = file_of(kind, Image.fromarray(picture()[..., 0]))
    path.write_bytes(data[: len(data) // 2])
    with pytest.raises(gs.ImageFileError, match="damaged or cut short: Pillow cannot read its picture"):
        gs.draw(path)
    with pytest.raises(gs.ImageFileError, match="at most 99 pixels"):
        gs.draw(path, max_pixels=99)


def test_pil_images_say_what_their_files_say() -> None:
    image = Image.fromarray(picture())
    linear = file_of("PNG", image)
    at = linear.index(b"IDAT") - 4
    linear = linear[:at] + chunk(b"gAMA", struct.pack(">I", 100_000)) + linear[at:]
    exif = Image.Exif()
    exif.get_ifd(0x8769)[0xA001] = 2
    marked = file_of("JPEG", image, exif=exif, quality=95, subsampling=0)
    profiled = file_of("PNG", image, icc_profile=rgb_profile(ADOBE_XY, 1.8))
    plain = read_luma(image, WHITE)
    for data in (linear, marked, profiled):
        opened = Image.open(io.BytesIO(data))
        path_luma = _luma_of(data)
        assert abs(path_luma - plain).mean() > 0.004
        assert abs(read_luma(opened, WHITE) - path_luma).mean() < 0.001


def _luma_of(data: bytes) -> NDArray[np.float32]:
    import tempfile

    with tempfile.TemporaryDirectory() as folder:
        path = Path(folder) / "photo"
        path.write_bytes(data)
        return read_luma(path, WHITE)


def test_phones_photos_are_read_where_pillow_can(tmp_path: Path) -> None:
    heif = pytest.importorskip("pillow_heif", reason="pillow-heif is not installed: pip install graphstipple[heif]")
    path = tmp_path / "IMG_0001.jpg"
    heif.from_pillow(Image.fromarray(picture())).save(path, quality=95)
    drawing = gs.draw(path)
    assert (drawing.width, drawing.height) == (96, 240)
    assert drawing.stats["decoder"].startswith("Pillow ")
    assert abs(read_luma(path, WHITE) - read_luma(picture(), WHITE)).mean() < 0.01
    refused = run(native_binary(), str(path), "-o", str(tmp_path / "a.svg"))
    assert_one_sentence(refused, FAILURE)
    assert "HEIC" in refused.stderr.decode()
