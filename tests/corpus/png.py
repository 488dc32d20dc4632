"""PNG files, of every pixel type, with every chunk that changes what the pixels mean."""

from __future__ import annotations

import io
import struct
import zlib
from collections.abc import Callable
from typing import Any

import numpy as np
from PIL import Image
from tests.corpus import colour
from tests.corpus.case import Case, Drawn, Made, Refused, Warned
from tests.corpus.colour import Luma, Samples, fraction, luma_of, on_white, picture, quantised

SIGNATURE = b"\x89PNG\r\n\x1a\n"
GREY, RGB, PALETTE, GREY_ALPHA, RGBA = 0, 2, 3, 4, 6
PASSES = ((0, 0, 8, 8), (4, 0, 8, 8), (0, 4, 4, 8), (2, 0, 4, 4), (0, 2, 2, 4), (1, 0, 2, 2), (0, 1, 1, 2))
"""Of Adam7: first column and row, and the steps."""


def chunk(name: bytes, content: bytes) -> bytes:
    return struct.pack(">I", len(content)) + name + content + struct.pack(">I", zlib.crc32(name + content))


def rows(samples: Samples, bits: int) -> bytes:
    """Return the rows of samples (height, width, channels) packed, each of another filter: none, and the difference to the left."""
    height = samples.shape[0]
    flat = samples.reshape(height, -1)
    if bits == 16:
        packed = flat.astype(">u2").view(np.uint8)
    elif bits == 8:
        packed = flat.astype(np.uint8)
    else:
        places = np.arange(bits - 1, -1, -1)
        packed = np.packbits(((flat[..., np.newaxis] >> places) & 1).astype(np.uint8).reshape(height, -1), axis=1)
    step = max(1, bits * samples.shape[2] // 8)
    left = np.pad(packed, [(0, 0), (step, 0)])[:, : packed.shape[1]]
    return b"".join(b"\x01" + (packed[y] - left[y]).tobytes() if y % 2 else b"\0" + packed[y].tobytes() for y in range(height))


def pixels(samples: Samples, bits: int, interlaced: bool = False) -> bytes:
    """Return the data of an image, not yet compressed."""
    if not interlaced:
        return rows(samples, bits)
    parts = [samples[y::down, x::across] for x, y, across, down in PASSES]
    return b"".join(rows(part, bits) for part in parts if part.size)


def header(samples: Samples, bits: int, colour_type: int, interlaced: bool = False) -> bytes:
    height, width = samples.shape[:2]
    return chunk(b"IHDR", struct.pack(">2I5B", width, height, bits, colour_type, 0, 0, int(interlaced)))


def png(
    samples: Samples, bits: int, colour_type: int, before: bytes = b"", *, after: bytes = b"", interlaced: bool = False
) -> bytes:
    """Return a PNG of samples (height, width, channels), with chunks before and after its data."""
    data = zlib.compress(pixels(samples, bits, interlaced))
    half = len(data) // 2
    parts = chunk(b"IDAT", data[:half]) + chunk(b"IDAT", data[half:])
    return SIGNATURE + header(samples, bits, colour_type, interlaced) + before + parts + after + chunk(b"IEND", b"")


def grey(bits: int) -> Samples:
    return quantised(colour.grey_picture(), bits)[..., np.newaxis]


def rgb(bits: int = 8) -> Samples:
    return quantised(picture(), bits)


def rgb_luma(bits: int = 8) -> Luma:
    return luma_of(fraction(rgb(bits), bits))


def alpha(bits: int) -> Samples:
    return quantised(colour.opacity(), bits)[..., np.newaxis]


def palette(bits: int) -> tuple[Samples, Samples]:
    """Return indices (height, width, 1) and colours (n, 3)."""
    image = Image.fromarray(rgb()).quantize(min(2**bits, 250), dither=Image.Dither.NONE)
    values = image.getpalette()
    assert values is not None
    return np.asarray(image)[..., np.newaxis], np.array(values, np.uint8).reshape(-1, 3)


def witnessed(data: bytes, luma: Luma) -> Made:
    """Return a file that Pillow reads too."""
    return Made(data, Drawn(luma), colour.by_pillow(data))


def plain(kind: int, bits: int, interlaced: bool = False) -> Made:
    """Return a file without any extra."""
    opacity = fraction(alpha(bits), bits)[..., 0]
    if kind == GREY:
        samples, luma = grey(bits), fraction(grey(bits), bits)[..., 0]
    elif kind == RGB:
        samples, luma = rgb(bits), rgb_luma(bits)
    elif kind == GREY_ALPHA:
        samples = np.concatenate([grey(bits), alpha(bits)], axis=2)
        luma = on_white(fraction(grey(bits), bits)[..., 0], opacity)
    else:
        samples = np.concatenate([rgb(bits), alpha(bits)], axis=2)
        luma = on_white(fraction(rgb(bits), bits), opacity)
    data = png(samples, bits, kind, interlaced=interlaced)
    return witnessed(data, luma) if bits == 8 else Made(data, Drawn(luma))


def with_palette(bits: int, transparent: bool, interlaced: bool = False) -> Made:
    indices, colours = palette(bits)
    # Shorter than the palette: the rest is solid.
    clear = np.linspace(0, 255, max(1, len(colours) - 1)).astype(np.uint8) if transparent else np.zeros(0, np.uint8)
    opacity = np.pad(clear, (0, len(colours) - len(clear)), constant_values=255) / 255
    before = chunk(b"PLTE", colours.tobytes()) + (chunk(b"tRNS", clear.tobytes()) if transparent else b"")
    data = png(indices, bits, PALETTE, before, interlaced=interlaced)
    return witnessed(data, on_white(colours[indices[..., 0]] / 255, opacity[indices[..., 0]]))


def colour_key(kind: int, bits: int) -> Made:
    """Return a file one of whose colours is clear; in 16 bits its neighbours differ in the lower byte only, and are not."""
    samples = grey(bits) if kind == GREY else rgb(bits)
    samples = np.where(np.arange(samples.shape[1])[:, np.newaxis] % 3 == 1, samples[5, 5], samples).astype(samples.dtype)
    if bits == 16:
        samples[20:40, 20:40] = samples[5, 5] ^ 1
    key = samples[5, 5]
    clear = (samples == key).all(axis=2)
    data = png(samples, bits, kind, chunk(b"tRNS", key.astype(">u2").tobytes()))
    values = fraction(samples, bits)
    luma = on_white(values[..., 0] if kind == GREY else values, np.where(clear, 0.0, 1.0))
    return witnessed(data, luma) if bits == 8 else Made(data, Drawn(luma))


def gama(value: float) -> bytes:
    return chunk(b"gAMA", struct.pack(">I", round(value * 100_000)))


def chrm(primaries: tuple[tuple[float, float], ...]) -> bytes:
    numbers = [v for xy in (colour.D65_XY, *primaries) for v in xy]
    return chunk(b"cHRM", b"".join(struct.pack(">I", round(v * 100_000)) for v in numbers))


def cicp(primaries: int, transfer: int, matrix: int = 0, full: int = 1) -> bytes:
    return chunk(b"cICP", bytes([primaries, transfer, matrix, full]))


def iccp(profile: bytes) -> bytes:
    return chunk(b"iCCP", b"test\0\0" + zlib.compress(profile))


SRGB_CHUNK = chunk(b"sRGB", b"\0")


def linear_samples(bits: int) -> Samples:
    """Return the picture in linear light."""
    return quantised(colour.srgb_decoded(picture()), bits)


def coloured(before: bytes, expected: Callable[[Samples], Samples], bits: int = 8, samples: Samples | None = None) -> Made:
    """Return an RGB file with chunks, and its luma by a formula from the values in [0, 1]."""
    given = rgb(bits) if samples is None else samples
    return Made(png(given, bits, RGB, before), Drawn(luma_of(expected(fraction(given, bits)))))


def as_is(values: Samples) -> Samples:
    return values


def linear_alpha(bits: int) -> Made:
    samples, opacity = linear_samples(bits), alpha(bits)
    data = png(np.concatenate([samples, opacity], axis=2), bits, RGBA, gama(1.0))
    return Made(data, Drawn(on_white(colour.srgb_encoded(fraction(samples, bits)), fraction(opacity, bits)[..., 0])))


def linear_grey(bits: int) -> Made:
    samples = quantised(colour.srgb_decoded(colour.grey_picture()), bits)
    data = png(samples[..., np.newaxis], bits, GREY, gama(1.0))
    return Made(data, Drawn(colour.srgb_encoded(fraction(samples, bits))))


def linear_palette() -> Made:
    indices, colours = palette(8)
    data = png(indices, 8, PALETTE, gama(1.0) + chunk(b"PLTE", colours.tobytes()))
    return Made(data, Drawn(luma_of(colour.srgb_encoded(colours / 255)[indices[..., 0]])))


def profiled(bits: int, kind: int = RGB, padding: int = 0, before: bytes = b"") -> Made:
    """Return a file with a profile: the power 1.75 for greys, Adobe's colours in linear light otherwise."""
    if kind in {GREY, GREY_ALPHA}:
        values = grey(bits)
        profile, expected = colour.grey_profile(1.75), colour.srgb_encoded(fraction(values, bits) ** 1.75)[..., 0]
    else:
        values = linear_samples(bits)
        profile = colour.rgb_profile(colour.ADOBE_XY, 1.0, padding)
        expected = colour.converted(fraction(values, bits), colour.ADOBE_XY)
    opacity = fraction(alpha(bits), bits)[..., 0]
    transparent = kind in {GREY_ALPHA, RGBA}
    samples = np.concatenate([values, alpha(bits)], axis=2) if transparent else values
    data = png(samples, bits, kind, before + iccp(profile))
    luma = on_white(expected, opacity) if transparent else luma_of(expected)
    witness = None
    if bits == 8 and not transparent:
        witness = colour.by_pillow_cms(data)
    return Made(data, Drawn(luma), witness)


def profile_without_use(kind: int, profile: bytes) -> Made:
    """Return a file with a profile that says nothing about its pixels, which are shown as they are."""
    luma = fraction(grey(8), 8)[..., 0] if kind == GREY else rgb_luma()
    return witnessed(png(grey(8) if kind == GREY else rgb(), 8, kind, profile), luma)


def profiled_palette() -> Made:
    indices, colours = palette(8)
    data = png(indices, 8, PALETTE, iccp(colour.rgb_profile(colour.ADOBE_XY, 1.0)) + chunk(b"PLTE", colours.tobytes()))
    return Made(data, Drawn(luma_of(colour.converted(colours / 255, colour.ADOBE_XY)[indices[..., 0]])))


def turned(orientation: int) -> Made:
    data = png(colour.stored(rgb(), orientation), 8, RGB, chunk(b"eXIf", colour.exif(orientation)))
    return Made(data, Drawn(rgb_luma()))


def turned_after() -> Made:
    """Return a file whose EXIF comes after its pixels."""
    return Made(png(colour.stored(rgb(), 6), 8, RGB, after=chunk(b"eXIf", colour.exif(6))), Drawn(rgb_luma()))


def marked(adobe_rgb: str) -> Made:
    """Return a file with a camera's mark of Adobe RGB."""
    data = png(rgb(), 8, RGB, chunk(b"eXIf", colour.exif(adobe_rgb=adobe_rgb)))
    return Made(data, Drawn(luma_of(colour.converted(fraction(rgb(), 8) ** (563 / 256), colour.ADOBE_XY))))


def animated(default_is_frame: bool) -> Made:
    """Return an APNG: what programs show that know nothing of animations."""
    height, width = rgb().shape[:2]
    control = chunk(b"acTL", struct.pack(">2I", 2 if default_is_frame else 1, 0))

    def frame(number: int) -> bytes:
        return chunk(b"fcTL", struct.pack(">5I2H2B", number, width, height, 0, 0, 1, 10, 0, 0))

    other = zlib.compress(pixels(255 - rgb(), 8))
    before = control + (frame(0) if default_is_frame else b"")
    number = 1 if default_is_frame else 0
    after = frame(number) + chunk(b"fdAT", struct.pack(">I", number + 1) + other)
    data = png(rgb(), 8, RGB, before, after=after)
    image = Image.open(io.BytesIO(data))
    return Made(data, Drawn(rgb_luma()), colour.luma_of_pil(image.convert("RGB")))


def whole() -> bytes:
    return png(rgb(), 8, RGB)


def without_end() -> Made:
    return Made(whole()[:-12], Warned(rgb_luma(), words=("end",)))


def without_last_checksum() -> Made:
    """Return a file with all its pixels that ends amid the checksum of its last data."""
    return Made(whole()[:-14], Warned(rgb_luma(), words=("end",)))


def wrong_checksum() -> Made:
    """Return a file with all its pixels, and a wrong checksum at the last of them."""
    data = bytearray(whole())
    data[-13] ^= 0x55
    return Made(bytes(data), Warned(rgb_luma(), words=()))


def cut(share: float) -> Made:
    data = whole()
    return Made(data[: round(len(data) * share)], Refused(("cut short",), without=()))


def half_of_the_rows() -> Made:
    """Return a file that ends as it should, with half of the rows that its header promises."""
    data = zlib.compress(pixels(rgb()[:35], 8))
    parts = SIGNATURE + header(rgb(), 8, RGB) + chunk(b"IDAT", data) + chunk(b"IEND", b"")
    return Made(parts, Refused(("cut short",), without=()))


def trailing() -> Made:
    return Made(whole() + b"\0" * 700 + b"more", Drawn(rgb_luma()))


def unknown_chunk() -> Made:
    """Return a file with private chunks that do not matter."""
    return witnessed(png(rgb(), 8, RGB, chunk(b"prVt", b"abc"), after=chunk(b"zzZz", b"")), rgb_luma())


def gamma_of(power: float) -> Callable[[Samples], Samples]:
    def convert(values: Samples) -> Samples:
        return colour.srgb_encoded(values**power)

    return convert


def case(name: str, pixel_type: str, make: Callable[..., Made], *arguments: Any, **named: Any) -> Case:
    return Case(f"png_{name}", "PNG", pixel_type, lambda: make(*arguments, **named))


def pixel_types() -> list[Case]:
    """Return cases of samples."""
    rows = [case(f"grey{bits}", f"{bits}-bit grey", plain, GREY, bits) for bits in (1, 2, 4, 8, 16)]
    for kind, short, words in [(RGB, "rgb", "RGB"), (GREY_ALPHA, "grey_alpha", "grey + alpha"), (RGBA, "rgba", "RGB + alpha")]:
        rows += [case(f"{short}{bits}", f"{bits}-bit {words}", plain, kind, bits) for bits in (8, 16)]
    for bits in (1, 2, 4, 8):
        rows.append(case(f"palette{bits}", f"{bits}-bit palette", with_palette, bits, False))
        rows.append(case(f"palette{bits}_trns", f"{bits}-bit palette with transparency", with_palette, bits, True))
    for bits in (8, 16):
        rows.append(case(f"key_grey{bits}", f"{bits}-bit grey with a transparent colour", colour_key, GREY, bits))
        rows.append(case(f"key_rgb{bits}", f"{bits}-bit RGB with a transparent colour", colour_key, RGB, bits))
    for name, kind, bits in [("grey1", GREY, 1), ("grey16", GREY, 16), ("rgb8", RGB, 8), ("rgba16", RGBA, 16)]:
        rows.append(case(f"adam7_{name}", "interlaced", plain, kind, bits, interlaced=True))
    rows.append(case("adam7_palette4", "interlaced", with_palette, 4, True, interlaced=True))
    rows.append(case("animated", "animation, its default image", animated, True))
    rows.append(case("animated_apart", "animation, its default image", animated, False))
    return rows


def meanings() -> list[Case]:
    """Return cases of chunks that say what the samples mean, and of orientations."""
    rows = []
    gamma = "gAMA and cHRM"
    for bits in (8, 16):
        rows.append(case(f"gama_linear{bits}", gamma, coloured, gama(1.0), gamma_of(1.0), bits, linear_samples(bits)))
    rows.append(case("gama_linear_rgba8", gamma, linear_alpha, 8))
    rows.append(case("gama_linear_grey8", gamma, linear_grey, 8))
    rows.append(case("gama_linear_grey16", gamma, linear_grey, 16))
    rows.append(case("gama_linear_palette", gamma, linear_palette))
    rows.append(case("gama_18", gamma, coloured, gama(1 / 1.8), gamma_of(1 / round(1 / 1.8, 5))))
    rows.append(case("gama_22", gamma, coloured, gama(1 / 2.2), gamma_of(1 / round(1 / 2.2, 5))))
    rows.append(case("gama_3", gamma, coloured, gama(1 / 3), gamma_of(1 / round(1 / 3, 5))))
    adobe = chrm(colour.ADOBE_XY)
    rows.append(case("gama_chrm_adobe", gamma, coloured, gama(256 / 563) + adobe, from_adobe))
    rows.append(case("gama_chrm_linear_p3", gamma, coloured, gama(1.0) + chrm(colour.P3_XY), from_p3, 16, linear_samples(16)))
    rows.append(case("gama_srgb", "sRGB chunk", coloured, gama(1.0) + SRGB_CHUNK, as_is))
    rows.append(case("srgb_adobe_chrm", "sRGB chunk", coloured, SRGB_CHUNK + gama(1.0) + adobe, as_is))
    rows.append(case("gama_iccp", "iCCP profile", profiled, 8, before=gama(1 / 3)))
    rows.append(case("iccp_rgb8", "iCCP profile", profiled, 8))
    rows.append(case("iccp_rgb16", "iCCP profile", profiled, 16))
    rows.append(case("iccp_rgba8", "iCCP profile", profiled, 8, RGBA))
    rows.append(case("iccp_rgba16", "iCCP profile", profiled, 16, RGBA))
    rows.append(case("iccp_grey8", "iCCP profile", profiled, 8, GREY))
    rows.append(case("iccp_grey16", "iCCP profile", profiled, 16, GREY))
    rows.append(case("iccp_grey_alpha8", "iCCP profile", profiled, 8, GREY_ALPHA))
    rows.append(case("iccp_palette", "iCCP profile", profiled_palette))
    rows.append(case("iccp_large", "iCCP profile", profiled, 8, padding=600_000))
    words = "a profile that is none for its pixels"
    rows.append(case("iccp_of_other_pixels", words, profile_without_use, GREY, iccp(colour.rgb_profile(colour.ADOBE_XY))))
    rows.append(case("iccp_broken", words, profile_without_use, RGB, iccp(b"not a profile" * 20)))
    rows.append(case("cicp_srgb", "cICP", coloured, cicp(1, 13) + gama(1.0), as_is))
    rows.append(case("cicp_linear", "cICP", coloured, cicp(1, 8), gamma_of(1.0), 16, linear_samples(16)))
    rows.append(case("cicp_p3", "cICP", coloured, cicp(12, 13), p3_as_screens_have_it))
    rows.append(case("cicp_bt709", "cICP", coloured, cicp(1, 1), from_bt709))
    rows.append(case("cicp_over_iccp", "cICP", coloured, cicp(1, 13) + iccp(colour.rgb_profile(colour.ADOBE_XY, 1.0)), as_is))
    rows += [case(f"orientation{i}", "EXIF orientation", turned, i) for i in range(1, 9)]
    rows.append(case("orientation_after", "EXIF orientation", turned_after))
    rows += [case(f"exif_adobe_{kind}", "EXIF mark of Adobe RGB", marked, kind) for kind in ("uncalibrated", "two")]
    return rows


def damage() -> list[Case]:
    """Return cases of files that are not whole."""
    rows = []
    rows.append(case("no_end", "all pixels, no end", without_end))
    rows.append(case("no_last_checksum", "all pixels, no end", without_last_checksum))
    rows.append(case("wrong_checksum", "all pixels, a wrong checksum", wrong_checksum))
    rows.append(case("cut_half", "cut short", cut, 0.5))
    rows.append(case("cut_early", "cut short", cut, 0.1))
    rows.append(case("half_of_the_rows", "cut short", half_of_the_rows))
    rows.append(case("trailing", "bytes after the end", trailing))
    rows.append(case("unknown_chunk", "private chunks", unknown_chunk))
    return rows


def cases() -> list[Case]:
    """Return all cases of PNG."""
    return [*pixel_types(), *meanings(), *damage()]


def from_adobe(values: Samples) -> Samples:
    return colour.converted(values ** (1 / round(256 / 563, 5)), colour.ADOBE_XY)


def from_p3(values: Samples) -> Samples:
    return colour.converted(values, colour.P3_XY)


def p3_as_screens_have_it(values: Samples) -> Samples:
    return colour.converted(colour.srgb_decoded(values), colour.P3_XY)


def from_bt709(values: Samples) -> Samples:
    return colour.srgb_encoded(colour.bt709_decoded(values))
