"""Write seeds for the fuzz targets into `fuzz/corpus`: the files of the tests' corpus, and of the files and folders that are named.

From the root of the project: `python -m fuzz.seeds [FILE_OR_FOLDER ...]`.
"""

from __future__ import annotations

import hashlib
import io
import json
import sys
from collections.abc import Iterator
from pathlib import Path

import numpy as np
from PIL import Image, ImageCms
from tests.corpus import CASES
from tests.test_loading import STYLES, small_drawings

from graphstipple import Options, draw, presets

CORPUS = Path(__file__).parent / "corpus"

MOST_BYTES = 24_000
"""Larger files are left out: they make every run slower, and say nothing that a small one cannot."""

MARKS = {"jpeg": (b"\xff\xd8",), "png": (b"\x89PNG",), "webp": (b"RIFF",), "tiff": (b"II*\0", b"MM\0*", b"II+\0", b"MM\0+")}

KINDS = (0, 2, 4, 6, 8, 10, 67, 71, 75)
"""Grey, colours and inks of every depth, as the target `profile` has them in its first byte."""


def files(names: list[str]) -> Iterator[bytes]:
    """Yield the corpus of the tests, then what is named."""
    for case in CASES:
        yield case.make().data
    for name in names:
        path = Path(name)
        for file in sorted(path.rglob("*")) if path.is_dir() else [path]:
            if file.is_file():
                yield file.read_bytes()


def write(target: str, data: bytes) -> None:
    """Write a seed of a target, unless it is large."""
    if len(data) <= MOST_BYTES:
        folder = CORPUS / target
        folder.mkdir(parents=True, exist_ok=True)
        (folder / hashlib.sha1(data).hexdigest()).write_bytes(data)


def exif(data: bytes) -> bytes:
    """Return the EXIF data of a JPEG, or nothing."""
    start = data.find(b"Exif\0\0")
    return data[start + 6 : start + 2000] if start >= 0 else b""


def main(names: list[str]) -> None:
    """Write all seeds."""
    for data in files(names):
        target = next((target for target, marks in MARKS.items() if data.startswith(marks)), "exif_and_any")
        write(target, data)
        write("exif_and_any", data[:200] if len(data) > 1000 else data)
        if target == "jpeg" and exif(data):
            write("exif_and_any", exif(data))
        if target in MARKS:
            profile_of(data)
    for wide in (False, True):
        for space, inputs in ((b"CMYK", 4), (b"RGB ", 3), (b"GRAY", 1)):
            of_kinds(of_table(space, inputs, wide))
    for name in ("sRGB", "LAB", "XYZ"):
        of_kinds(ImageCms.ImageCmsProfile(ImageCms.createProfile(name)).tobytes())
    for number in (b"\0\0\xb1\x8f", b"\0\1\x86\xa0" * 9):
        for kind in KINDS[:6]:
            write("profile", bytes([128 + kind]) + number)
    for preset in presets():
        write("options", json.dumps(of_metadata(preset.name)).encode())
    drawings()
    areas()
    lines = ["gamma=1.5", "nodes=1e5", "published.alpha=tonal", "preset=linocut", "page=A4", "width=20cm", "dpi=300", "margin=5",
             "style=layered", "only=white", "one_bit=true", "background=#fff", "page=300x200mm", "suffix=svg"]  # fmt: skip
    write("options", "\n".join(lines).encode())
    for line in lines:
        write("options", line.encode())


def drawings() -> None:
    """Write small drawings, and shapes of every kind as the target `drawing_json` has them in bytes."""
    for drawing in small_drawings():
        write("drawing_json", drawing.json().encode())
        for how in STYLES:
            write("drawing_svg", drawing.svg(**how).encode())
    for kind in (0, 4, 74, 78, 75, 110, 111, 1, 33):
        write("drawing_json", bytes([15, 15, 128, kind]) + bytes(range(8, 120, 7)))


def areas() -> None:
    """Write polygons of every size as the target `areas` has them in bytes: a square with a hole, and some that cross."""
    square = [4, 10, 10, 60, 10, 60, 60, 10, 60, 0x84, 20, 20, 20, 40, 40, 40, 40, 20]
    crossing = [4, 10, 10, 60, 60, 60, 10, 10, 60, 3, 0, 0, 200, 1, 0, 2, 0x44, 90, 90, 90, 90, 90, 130, 130, 130]
    for kind in range(32):
        write("areas", bytes([kind, 8, 0, *square]))
        write("areas", bytes([kind, 30, 3, *crossing]))


def of_metadata(preset: str) -> object:
    """Return the options of a preset as the metadata of a drawing have them."""
    drawing = draw(np.full((4, 4), 0.5, np.float32), options=Options.preset(preset))
    return json.loads(drawing.json())["options"]


def of_table(space: bytes, inputs: int, wide: bool) -> bytes:
    """Make a profile whose colours stand in a small table, 2 entries an axis (ICC.1, lut8Type and lut16Type)."""
    step = (lambda v: v.to_bytes(2, "big")) if wide else (lambda v: bytes([v >> 8]))
    ramp = [step(v) for v in ((0, 65535) if wide else range(0, 65536, 257))]
    table = b"mft2" if wide else b"mft1"
    table += bytes([0, 0, 0, 0, inputs, 3, 2, 0])
    table += b"".join(int(65536 * (i % 4 == 0)).to_bytes(4, "big") for i in range(9))
    table += bytes([0, 2, 0, 2]) if wide else b""
    table += b"".join(ramp * inputs)
    table += b"".join(step(65535 - i * 65535 // 2**inputs) + step(32896) * 2 for i in range(2**inputs))
    table += b"".join(ramp * 3)
    white = b"XYZ \0\0\0\0" + b"".join(v.to_bytes(4, "big") for v in (0xF6D6, 0x10000, 0xD32D))
    tags = [(b"wtpt", white), (b"A2B0", table)]
    at = 128 + 4 + 12 * len(tags)
    listed, content = len(tags).to_bytes(4, "big"), b""
    for name, data in tags:
        listed += name + (at + len(content)).to_bytes(4, "big") + len(data).to_bytes(4, "big")
        content += data + bytes(-len(data) % 4)
    head = bytes(4) + b"lcms\x02\x40\0\0prtr" + space + b"Lab " + bytes(12) + b"acsp" + bytes(28)
    head += b"".join(v.to_bytes(4, "big") for v in (0xF6D6, 0x10000, 0xD32D))
    profile = head.ljust(128, b"\0") + listed + content
    return len(profile).to_bytes(4, "big") + profile[4:]


def of_kinds(profile: bytes) -> None:
    """Write a profile for samples of every kind."""
    for kind in KINDS:
        write("profile", bytes([kind]) + profile)


def profile_of(data: bytes) -> None:
    """Write the profile of a file, if it has one."""
    try:
        profile = Image.open(io.BytesIO(data)).info.get("icc_profile")
    except Exception:  # What Pillow does not open has no profile for us.
        return
    if profile:
        of_kinds(profile)


if __name__ == "__main__":
    main(sys.argv[1:])
