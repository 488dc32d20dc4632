"""JPEG files: every process, layout of scans and sampling, colour space and mark, and every way of ending too early.

`arithmetic.jpg` and `arithmetic_progressive.jpg` are `jpeg()` of this module after `jpegtran -arithmetic` and `jpegtran -arithmetic
-progressive`, which change the coding and no coefficient: few encoders write that coding.
"""

from __future__ import annotations

import io
from collections.abc import Callable, Sequence
from pathlib import Path
from typing import Any

import imagecodecs
import numpy as np
from PIL import Image
from tests.corpus import baseline, colour
from tests.corpus.baseline import Plane, segment
from tests.corpus.case import CLOSE_CMYK, Case, Drawn, Made, Refused, Warned
from tests.corpus.colour import by_pillow, by_pillow_cms, luma_of, luma_of_pil, picture, quantised

HERE = Path(__file__).parent
END = b"\xff\xd9"
APART = ((0,), (1,), (2,))
"""Scans of single components."""
JFIF = segment(0xE0, b"JFIF\0\x01\x01\0\0\x01\0\x01\0\0")


def adobe(transform: int) -> bytes:
    return segment(0xEE, b"Adobe\0\x64\0\0\0\0" + bytes([transform]))


def app1(exif: bytes) -> bytes:
    return segment(0xE1, b"Exif\0\0" + exif)


def app2(profile: bytes) -> bytes:
    """Return a profile in as many segments as it needs."""
    pieces = [profile[i : i + 60_000] for i in range(0, len(profile), 60_000)]
    return b"".join(segment(0xE2, b"ICC_PROFILE\0" + bytes([i, len(pieces)]) + piece) for i, piece in enumerate(pieces, 1))


def rgb_planes(colours: np.ndarray[Any, Any]) -> list[Plane]:
    return [255 * colours[..., i] for i in range(colours.shape[2])]


def ycc_planes(colours: np.ndarray[Any, Any]) -> list[Plane]:
    """Return Y, Cb and Cr of colours in [0, 1]."""
    luma = luma_of(colours)
    blue = (colours[..., 2] - luma) / 1.772 * 255 + 128
    red = (colours[..., 0] - luma) / 1.402 * 255 + 128
    return [255 * luma, blue, red]


def jpeg(
    sampling: tuple[int, int] = (2, 2),
    scans: Sequence[Sequence[int]] | None = None,
    colours: np.ndarray[Any, Any] | None = None,
    *,
    before: bytes = JFIF,
    **named: Any,
) -> bytes:
    """Return the picture as Y, Cb and Cr, so many samples of the first to one of the others."""
    planes = ycc_planes(picture() if colours is None else colours)
    return baseline.encode(planes, [sampling, (1, 1), (1, 1)], scans, before=before, **named)


def as_pillow_reads(data: bytes) -> Made:
    return Made(data, Drawn(by_pillow(data)))


def as_its_twin(data: bytes, twin: bytes) -> Made:
    """Return a file that should be read as Pillow reads another one with the same coefficients."""
    return Made(data, Drawn(by_pillow(twin)))


def laid_out(**named: Any) -> Made:
    return as_pillow_reads(jpeg(**named))


def saved(mode: str = "RGB", **named: Any) -> Made:
    """Return the picture as Pillow writes it."""
    file = io.BytesIO()
    Image.fromarray(quantised(picture(), 8)).convert(mode).save(file, "jpeg", quality=90, **named)
    return as_pillow_reads(file.getvalue())


def grey(sampling: tuple[int, int] = (1, 1)) -> Made:
    return as_pillow_reads(baseline.encode(ycc_planes(picture())[:1], [sampling], before=JFIF))


def with_height_after() -> Made:
    return as_its_twin(jpeg(dnl=True), jpeg())


def with_height_after_apart() -> Made:
    """Return a file whose height comes after the first of three scans."""
    scans = [[0], [1], [2]]
    return as_its_twin(jpeg(scans=scans, dnl=True), jpeg(scans=scans))


def arithmetic(name: str) -> Made:
    return as_its_twin((HERE / name).read_bytes(), jpeg())


def two_beginnings() -> Made:
    return as_its_twin(b"\xff\xd8" + jpeg(), jpeg())


def fill_bytes() -> Made:
    """Return a file with fill bytes before its markers."""
    data = jpeg()
    for marker in (b"\xff\xdb", b"\xff\xc0", b"\xff\xda"):
        data = data.replace(marker, b"\xff\xff\xff" + marker, 1)
    return as_its_twin(data, jpeg())


# Colour --------------------------------------------------------------------------------------------------------------------------


def as_rgb(marked: bool) -> Made:
    """Return a file of R, G and B: marked by Adobe's segment, or by the names of its components alone."""
    planes, names = rgb_planes(picture()), (1, 2, 3) if marked else tuple(b"RGB")
    return as_pillow_reads(baseline.encode(planes, [(1, 1)] * 3, before=adobe(0) if marked else b"", names=names))


def inks(transform: int, profile: bytes = b"", sampling: tuple[int, int] = (1, 1)) -> Made:
    """Return a file of inks as Photoshop writes them: inverted, and as Y, Cb, Cr and K if the transform is 2."""
    inverted = 1 - colour.inks_of(picture())
    planes = rgb_planes(inverted)
    if transform == 2:
        planes[:3] = ycc_planes(1 - inverted[..., :3])
    factors = [sampling, (1, 1), (1, 1), sampling]
    data = baseline.encode(planes, factors, before=adobe(transform) + (app2(profile) if profile else b""))
    return Made(data, Drawn(by_pillow_cms(data) if profile else by_pillow(data), CLOSE_CMYK))


def profiled(profile: bytes, **named: Any) -> Made:
    data = jpeg(before=JFIF + app2(profile), **named)
    return Made(data, Drawn(by_pillow_cms(data)))


def profiled_backwards() -> Made:
    """Return a file whose profile comes in pieces of which the last is first."""
    profile = colour.rgb_profile(colour.ADOBE_XY, 1.0, padding=100)
    pieces = [profile[i : i + 200] for i in range(0, len(profile), 200)]
    parts = [segment(0xE2, b"ICC_PROFILE\0" + bytes([i, len(pieces)]) + piece) for i, piece in enumerate(pieces, 1)]
    data = jpeg(before=JFIF + b"".join(reversed(parts)))
    return as_its_profiled_twin(data, jpeg(before=JFIF + app2(profile)))


def as_its_profiled_twin(data: bytes, twin: bytes) -> Made:
    return Made(data, Drawn(by_pillow_cms(twin)))


def profiled_grey() -> Made:
    plane = 255 * colour.grey_picture()
    data = baseline.encode([plane], [(1, 1)], before=JFIF + app2(colour.grey_profile(1.75)))
    return Made(data, Drawn(by_pillow_cms(data)))


def profile_for_other_pixels() -> Made:
    """Return a grey file with a profile for colours: it says nothing about these pixels."""
    data = baseline.encode(ycc_planes(picture())[:1], [(1, 1)], before=JFIF + app2(colour.rgb_profile(colour.ADOBE_XY, 1.0)))
    return as_pillow_reads(data)


def broken_profile() -> Made:
    """Return a file with a profile that is none: no reason to refuse a photo."""
    return as_pillow_reads(jpeg(before=JFIF + app2(b"not a profile" * 20)))


def turned(orientation: int) -> Made:
    data = jpeg(colours=colour.stored(picture(), orientation), before=app1(colour.exif(orientation)), step=1)
    plain = luma_of_pil(Image.open(io.BytesIO(data)))
    upright = {5: plain.T, 6: np.rot90(plain, -1), 7: np.rot90(plain, 2).T, 8: np.rot90(plain, 1)}
    straight = {1: plain, 2: plain[:, ::-1], 3: plain[::-1, ::-1], 4: plain[::-1]}
    return Made(data, Drawn((upright | straight)[orientation]), luma_of(quantised(picture(), 8) / 255))


def marked_as_unknown() -> Made:
    """Return a file that says only that it is not sRGB, as phones do beside a profile: here there is none."""
    return as_pillow_reads(jpeg(before=app1(colour.exif(1, "unknown"))))


def marked(adobe_rgb: str, profile: bytes = b"") -> Made:
    """Return a camera's file with its mark of Adobe RGB; a profile beside it says what holds."""
    data = jpeg(before=app1(colour.exif(1, adobe_rgb)) + (app2(profile) if profile else b""))
    if profile:
        return Made(data, Drawn(by_pillow_cms(data)))
    meant = jpeg(before=JFIF + app2(colour.rgb_profile(colour.ADOBE_XY, 563 / 256)))
    return as_its_profiled_twin(data, meant)


# Ends ----------------------------------------------------------------------------------------------------------------------------


def without_end(data: bytes, after: bytes = b"") -> Made:
    assert data.endswith(END)
    return Made(data[:-2] + after, Warned(by_pillow(data), words=("end",)))


def thumbnailed() -> Made:
    """Return a file without its end whose thumbnail has one."""
    segments = app1(colour.exif(1) + jpeg(colours=picture()[::4, ::4]))
    return without_end(jpeg(before=segments))


def trailing(after: bytes) -> Made:
    return as_its_twin(jpeg() + after, jpeg())


def cut(data: bytes, share: float, after: bytes = b"") -> Made:
    """Return a file of which a part of its scans is left."""
    start = data.index(b"\xff\xda")
    return Made(data[: start + round((len(data) - start) * share)] + after, Refused(("cut short",), without=()))


def header_only() -> Made:
    data = jpeg()
    return Made(data[: data.index(b"\xff\xc0") + 5], Refused(("cut short",), without=()))


def missing_scan() -> Made:
    """Return a file of three scans that ends after the first."""
    data = jpeg(scans=[[0], [1], [2]])
    return Made(data[: data.index(b"\xff\xda\0\x08\x01\x02")] + END, Refused(("cut short",), without=()))


def progressive() -> bytes:
    file = io.BytesIO()
    Image.fromarray(quantised(picture(), 8)).save(file, "jpeg", quality=90, progressive=True)
    return file.getvalue()


def two_pictures() -> Made:
    """Return a camera's multi-picture file: the first is the photo, the second a smaller one for screens."""
    file = io.BytesIO()
    image = Image.fromarray(quantised(picture(), 8))
    image.save(file, "mpo", save_all=True, append_images=[image.resize((40, 30))], quality=90)
    return as_pillow_reads(file.getvalue())


# Other processes -----------------------------------------------------------------------------------------------------------------


def twelve_bits() -> Made:
    data = imagecodecs.jpeg8_encode(quantised(colour.grey_picture(), 12), bitspersample=12)
    return Made(bytes(data), Refused(any_of=("12-bit", "12 bit")))


def lossless() -> Made:
    samples = quantised(colour.grey_picture(), 8)
    return Made(bytes(imagecodecs.jpeg8_encode(samples, lossless=True)), Drawn(samples / 255))


def jpeg_ls() -> Made:
    return Made(bytes(imagecodecs.jpegls_encode(quantised(colour.grey_picture(), 8))), Refused(("JPEG-LS",)))


def case(name: str, pixel_type: str, make: Callable[..., Made], *arguments: Any, **named: Any) -> Case:
    return Case(f"jpeg_{name}", "JPEG", pixel_type, lambda: make(*arguments, **named))


def lazily(make: Callable[..., Made], data: Callable[[], bytes], *arguments: Any) -> Callable[[], Made]:
    return lambda: make(data(), *arguments)


def layouts() -> list[Case]:
    """Return cases of processes, scans and samplings."""
    samplings = [(1, 1), (2, 1), (2, 2), (1, 2), (4, 1), (4, 2), (3, 1), (1, 4)]
    apart, partly = APART, [[0, 1], [2]]
    rows = [case(f"{a}x{d}", "Y'CbCr, every sampling", laid_out, sampling=(a, d)) for a, d in samplings]
    for a, d in [(1, 1), (2, 1), (2, 2), (1, 2), (4, 1)]:
        rows.append(case(f"apart_{a}x{d}", "scans of single components", laid_out, sampling=(a, d), scans=apart))
        rows.append(case(f"partly_{a}x{d}", "scans of some components", laid_out, sampling=(a, d), scans=partly))
    rows.append(case("partly_luma_first", "scans of some components", laid_out, scans=[[0], [1, 2]]))
    rows.append(case("restart", "restart intervals", laid_out, restart=3))
    rows.append(case("restart_apart", "restart intervals", laid_out, restart=4, scans=apart))
    rows.append(case("extended", "extended sequential", laid_out, frame=0xC1))
    for subsampling in (0, 1, 2):
        rows.append(case(f"progressive_{subsampling}", "progressive", saved, progressive=True, subsampling=subsampling))
    rows.append(case("progressive_grey", "progressive", saved, "L", progressive=True))
    rows.append(case("progressive_restart", "progressive", saved, progressive=True, restart_marker_blocks=4))
    rows.append(case("optimised", "Y'CbCr, every sampling", saved, optimize=True))
    rows.append(case("arithmetic", "arithmetic coding", arithmetic, "arithmetic.jpg"))
    rows.append(case("arithmetic_progressive", "arithmetic coding", arithmetic, "arithmetic_progressive.jpg"))
    rows.append(case("grey", "grey", grey))
    rows.append(case("grey_2x2", "grey", grey, (2, 2)))
    rows.append(case("dnl", "height after the first scan (DNL)", with_height_after))
    rows.append(case("dnl_apart", "height after the first scan (DNL)", with_height_after_apart))
    rows.append(case("two_beginnings", "two beginnings", two_beginnings))
    rows.append(case("fill_bytes", "fill bytes", fill_bytes))
    rows.append(case("two_pictures", "several pictures (MPO), the first", two_pictures))
    rows.append(case("twelve_bits", "12 bits", twelve_bits))
    rows.append(case("lossless", "lossless", lossless))
    rows.append(case("jpeg_ls", "JPEG-LS", jpeg_ls))
    return rows


def meanings() -> list[Case]:
    """Return cases of colour spaces, profiles, marks and orientations."""
    rows = []
    rows.append(case("rgb_adobe", "RGB", as_rgb, True))
    rows.append(case("rgb_names", "RGB", as_rgb, False))
    rows.append(case("cmyk", "CMYK", inks, 0))
    rows.append(case("ycck", "YCCK", inks, 2))
    rows.append(case("ycck_2x2", "YCCK", inks, 2, sampling=(2, 2)))
    rows.append(case("cmyk_pillow", "CMYK", saved, "CMYK"))
    rows.append(Case("jpeg_cmyk_profile", "JPEG", "CMYK with a profile", lambda: inks(0, colour.cmyk_profile())))
    rows.append(Case("jpeg_ycck_profile", "JPEG", "YCCK with a profile", lambda: inks(2, colour.cmyk_profile(), (2, 2))))
    words = "ICC profile"
    rows.append(case("icc", words, profiled, colour.rgb_profile(colour.ADOBE_XY, 563 / 256)))
    rows.append(case("icc_linear", words, profiled, colour.rgb_profile(colour.P3_XY, 1.0)))
    rows.append(Case("jpeg_icc_large", "JPEG", words, lambda: profiled(colour.rgb_profile(colour.ADOBE_XY, 1.0, 600_000))))
    rows.append(case("icc_backwards", words, profiled_backwards))
    rows.append(case("icc_grey", words, profiled_grey))
    rows.append(case("icc_of_other_pixels", "a profile that is none for its pixels", profile_for_other_pixels))
    rows.append(case("icc_broken", "a profile that is none for its pixels", broken_profile))
    rows += [case(f"orientation{i}", "EXIF orientation", turned, i) for i in range(1, 9)]
    rows += [case(f"exif_adobe_{kind}", "EXIF mark of Adobe RGB", marked, kind) for kind in ("uncalibrated", "two")]
    linear = colour.rgb_profile(colour.SRGB_XY, 1.0)
    rows.append(case("exif_unknown", "EXIF without a mark", marked_as_unknown))
    rows.append(case("exif_adobe_icc", words, marked, "uncalibrated", linear))
    return rows


def damage() -> list[Case]:
    """Return cases of files that are not whole."""
    rows = []
    missing = "all pixels, no end"
    rows.append(Case("jpeg_no_end", "JPEG", missing, lazily(without_end, jpeg)))
    rows.append(Case("jpeg_no_end_trailing", "JPEG", missing, lazily(without_end, jpeg, bytes(300) + b"something else")))
    rows.append(Case("jpeg_no_end_apart", "JPEG", missing, lazily(without_end, lambda: jpeg(scans=APART))))
    rows.append(Case("jpeg_no_end_restart", "JPEG", missing, lazily(without_end, lambda: jpeg(restart=4))))
    rows.append(Case("jpeg_no_end_progressive", "JPEG", missing, lazily(without_end, progressive)))
    rows.append(case("no_end_thumbnail", missing, thumbnailed))
    rows.append(case("trailing", "bytes after the end", trailing, bytes(300) + b"more"))
    rows.append(case("trailing_jpeg", "bytes after the end", trailing, jpeg(colours=1 - picture())))
    short = "cut short"
    rows.append(Case("jpeg_cut_half", "JPEG", short, lazily(cut, jpeg, 0.5)))
    rows.append(Case("jpeg_cut_half_ended", "JPEG", short, lazily(cut, jpeg, 0.5, END)))
    rows.append(Case("jpeg_cut_half_trailing", "JPEG", short, lazily(cut, jpeg, 0.5, END + bytes(4000))))
    rows.append(Case("jpeg_cut_half_apart", "JPEG", short, lazily(cut, lambda: jpeg(scans=APART), 0.5, END)))
    rows.append(Case("jpeg_cut_half_restart", "JPEG", short, lazily(cut, lambda: jpeg(restart=3), 0.5, END)))
    rows.append(Case("jpeg_cut_half_progressive", "JPEG", short, lazily(cut, progressive, 0.5)))
    rows.append(Case("jpeg_cut_half_progressive_ended", "JPEG", short, lazily(cut, progressive, 0.5, END)))
    rows.append(case("cut_header", short, header_only))
    rows.append(case("missing_scan", short, missing_scan))
    return rows


def cases() -> list[Case]:
    """Return all cases of JPEG."""
    return [*layouts(), *meanings(), *damage()]
