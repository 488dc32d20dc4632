"""WebP files: both codings, alpha, animations, profiles and EXIF."""

from __future__ import annotations

import io
import struct
from collections.abc import Callable
from typing import Any

import numpy as np
from PIL import Image
from tests.corpus import colour
from tests.corpus.case import Case, Drawn, Made, Refused, Warned
from tests.corpus.colour import Samples, by_pillow, by_pillow_cms, luma_of, luma_of_pil, on_white, picture, quantised


def rgb() -> Samples:
    return quantised(picture(), 8)


def rgba() -> Samples:
    return np.dstack([rgb(), quantised(colour.opacity(), 8)])


def saved(samples: Samples, lossless: bool, **named: Any) -> bytes:
    file = io.BytesIO()
    Image.fromarray(samples).save(file, "webp", lossless=lossless, quality=80, method=2, exact=True, **named)
    return file.getvalue()


def plain(transparent: bool, lossless: bool) -> Made:
    data = saved(rgba() if transparent else rgb(), lossless)
    if not lossless:
        return Made(data, Drawn(by_pillow(data)))
    luma = on_white(rgb() / 255, rgba()[..., 3] / 255) if transparent else luma_of(rgb() / 255)
    return Made(data, Drawn(luma), by_pillow(data))


def with_mode(mode: str) -> Made:
    file = io.BytesIO()
    Image.fromarray(rgb()).convert(mode).save(file, "webp", lossless=True)
    return Made(file.getvalue(), Drawn(by_pillow(file.getvalue())))


def animated(lossless: bool) -> Made:
    file = io.BytesIO()
    frames = [Image.fromarray(samples) for samples in (rgba(), 255 - rgba())]
    frames[0].save(file, "webp", save_all=True, append_images=frames[1:], lossless=lossless, exact=True)
    image = Image.open(io.BytesIO(file.getvalue()))
    assert getattr(image, "n_frames", 1) == 2
    return Made(file.getvalue(), Drawn(luma_of_pil(image)))


def profiled(lossless: bool, transparent: bool = False, padding: int = 0) -> Made:
    profile = colour.rgb_profile(colour.ADOBE_XY, 563 / 256, padding)
    data = saved(rgba() if transparent else rgb(), lossless, icc_profile=profile)
    if transparent:
        colours = colour.converted((rgb() / 255) ** (563 / 256), colour.ADOBE_XY)
        return Made(data, Drawn(on_white(colours, rgba()[..., 3] / 255)))
    return Made(data, Drawn(by_pillow_cms(data)))


def turned(orientation: int, transparent: bool = False) -> Made:
    samples = rgba() if transparent else rgb()
    data = saved(colour.stored(samples, orientation), True, exif=b"Exif\0\0" + colour.exif(orientation))
    return Made(data, Drawn(luma_of(rgb() / 255) if not transparent else on_white(rgb() / 255, rgba()[..., 3] / 255)))


def turned_without_prefix() -> Made:
    """Return a file whose EXIF begins with its TIFF header, as the format has it."""
    data = bytearray(saved(colour.stored(rgb(), 6), True, exif=b"Exif\0\0" + colour.exif(6)))
    at = data.index(b"EXIF")
    content = colour.exif(6)
    tail = b"EXIF" + struct.pack("<I", len(content)) + content + bytes(len(content) % 2)
    changed = bytes(data[:at]) + tail
    return Made(changed[:4] + struct.pack("<I", len(changed) - 8) + changed[8:], Drawn(luma_of(rgb() / 255)))


def marked(adobe_rgb: str) -> Made:
    data = saved(rgb(), True, exif=b"Exif\0\0" + colour.exif(1, adobe_rgb))
    return Made(data, Drawn(luma_of(colour.converted((rgb() / 255) ** (563 / 256), colour.ADOBE_XY))))


def trailing() -> Made:
    return Made(saved(rgb(), True) + b"more", Drawn(luma_of(rgb() / 255)))


def without_end() -> Made:
    """Return a file with all its pixels that ends amid its EXIF."""
    data = saved(rgb(), True, exif=b"Exif\0\0" + colour.exif(1) + bytes(200))
    return Made(data[:-150], Warned(luma_of(rgb() / 255), words=("end",)))


def cut(lossless: bool, share: float, transparent: bool = False, **named: Any) -> Made:
    data = saved(rgba() if transparent else rgb(), lossless, **named)
    return Made(data[: round(len(data) * share)], Refused(("cut short",), without=()))


def cut_and_closed(lossless: bool) -> Made:
    """Return a file half of whose data is missing, with lengths that hide it."""
    data = saved(rgb(), lossless)
    half = data[20 : 20 + (len(data) - 20) // 4 * 2]
    name = data[12:16]
    body = b"WEBP" + name + struct.pack("<I", len(half)) + half
    return Made(b"RIFF" + struct.pack("<I", len(body)) + body, Refused(any_of=("cut short", "damaged"), without=()))


def claims_more() -> Made:
    """Return 68 bytes that claim a chunk of 4 gigabytes."""
    head = b"WEBPVP8X" + struct.pack("<I", 10) + bytes([0x20, 0, 0, 0, 9, 0, 0, 9, 0, 0])
    body = head + b"ICCP" + struct.pack("<I", 0xFFFF_FFF0) + bytes(30)
    return Made(b"RIFF" + struct.pack("<I", 0xFFFF_FFF6) + body, Refused(any_of=("cut short", "damaged"), without=()))


def case(name: str, pixel_type: str, make: Callable[..., Made], *arguments: Any, **named: Any) -> Case:
    return Case(f"webp_{name}", "WebP", pixel_type, lambda: make(*arguments, **named))


def cases() -> list[Case]:
    """Return all cases of WebP."""
    rows = []
    for lossless in (False, True):
        word = "lossless" if lossless else "lossy"
        rows.append(case(word, word, plain, False, lossless))
        rows.append(case(f"{word}_alpha", f"{word} with alpha", plain, True, lossless))
        rows.append(case(f"{word}_animated", "animation, the first frame", animated, lossless))
        rows.append(case(f"{word}_icc", "ICC profile", profiled, lossless))
        rows.append(case(f"{word}_cut_half", "cut short", cut, lossless, 0.5))
        rows.append(case(f"{word}_cut_and_closed", "cut short", cut_and_closed, lossless))
    rows.append(case("grey", "lossless", with_mode, "L"))
    rows.append(case("palette", "lossless", with_mode, "P"))
    rows.append(case("icc_alpha", "ICC profile", profiled, True, True))
    rows.append(case("icc_large", "ICC profile", profiled, False, padding=600_000))
    rows += [case(f"orientation{i}", "EXIF orientation", turned, i) for i in range(1, 9)]
    rows.append(case("orientation_alpha", "EXIF orientation", turned, 6, True))
    rows.append(case("orientation_without_prefix", "EXIF orientation", turned_without_prefix))
    rows += [case(f"exif_adobe_{kind}", "EXIF mark of Adobe RGB", marked, kind) for kind in ("uncalibrated", "two")]
    rows.append(case("trailing", "bytes after the end", trailing))
    rows.append(case("no_end", "all pixels, no end", without_end))
    rows.append(case("alpha_cut_half", "cut short", cut, False, 0.5, True))
    rows.append(case("icc_cut_half", "cut short", cut, False, 0.5, icc_profile=colour.rgb_profile()))
    rows.append(case("claims_more", "cut short", claims_more))
    return rows
