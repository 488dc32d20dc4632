"""TIFF files: every layout, compression and pixel type, several images, raw files of cameras, and files cut short."""

from __future__ import annotations

import io
from collections.abc import Callable, Sequence
from dataclasses import replace
from functools import partial
from typing import Any

import numpy as np
import tifffile
from PIL import Image, ImageCms
from tests.corpus import baseline, colour
from tests.corpus import tiff_writer as w
from tests.corpus.baseline import shrunk
from tests.corpus.case import CLOSE_CMYK, Case, Drawn, Made, Refused
from tests.corpus.colour import Luma, Samples, by_pillow, fraction, luma_of, on_white, picture, quantised
from tests.corpus.tiff_writer import Page, tiff

Meaning = Callable[[Samples], Luma]
"""From samples (height, width, channels) as they are stored to luma."""

PROFILE = 34675


def grey_samples(bits: int) -> Samples:
    return quantised(colour.grey_picture(), bits)[..., np.newaxis]


def rgb_samples(bits: int = 8) -> Samples:
    return quantised(picture(), bits)


def alpha_samples(bits: int) -> Samples:
    return quantised(colour.opacity(), bits)[..., np.newaxis]


def bits_of_a_fax() -> Samples:
    return colour.bilevel().astype(np.uint8)[..., np.newaxis]


def meaning(bits: int) -> Meaning:
    """Return what unsigned greys or colours mean."""

    def luma(samples: Samples) -> Luma:
        values = fraction(samples, bits)
        return luma_of(values[..., 0] if values.shape[2] == 1 else values[..., :3])

    return luma


def by_tifffile(data: bytes, page: Page) -> Samples | None:
    """Return the samples of a file's first image as tifffile reads them, None where it cannot."""
    try:
        found = tifffile.imread(io.BytesIO(data), key=0)
    except (ValueError, NotImplementedError, RuntimeError):
        return None
    if page.planar == 2 and found.ndim == 3:
        found = np.moveaxis(found, 0, 2)
    # Bits come as booleans.
    return found.astype(page.samples.dtype, copy=False).reshape(page.samples.shape)


def drawn(page: Page, luma: Meaning, tolerance: float = 0.002, **named: Any) -> Made:
    """Return a file of one image, of samples that are stored without loss, and a witness for them."""
    data = tiff(page, **named)
    found = by_tifffile(data, page)
    return Made(data, Drawn(luma(page.samples), tolerance), None if found is None else luma(found))


def plain(page: Callable[[], Page], **named: Any) -> Made:
    """Return a file of plain greys or colours."""
    made = page()
    return drawn(made, meaning(made.bits), **named)


def rgb(bits: int = 8, **named: Any) -> Page:
    return Page(rgb_samples(bits), bits, w.RGB, **named)


def grey(bits: int = 8, **named: Any) -> Page:
    return Page(grey_samples(bits), bits, w.BLACK_IS_ZERO, **named)


# Pixel types ---------------------------------------------------------------------------------------------------------------------


def white_is_zero(bits: int, **named: Any) -> Made:
    samples = 2**bits - 1 - grey_samples(bits)
    page = Page(samples, bits, w.WHITE_IS_ZERO, **named)
    return drawn(page, lambda stored: 1 - fraction(stored, bits)[..., 0])


def white_is_zero_with_alpha(bits: int) -> Made:
    """Return grey whose 0 is white, with alpha, of which 0 is clear as always."""
    samples = np.concatenate([2**bits - 1 - grey_samples(bits), alpha_samples(bits)], axis=2)
    page = Page(samples, bits, w.WHITE_IS_ZERO, extra=(w.UNASSOCIATED,))
    return drawn(page, lambda stored: on_white(1 - fraction(stored, bits)[..., 0], fraction(stored, bits)[..., 1]))


def palette(bits: int, **named: Any) -> Made:
    image = Image.fromarray(rgb_samples()).quantize(2**bits, dither=Image.Dither.NONE)
    values = image.getpalette()
    assert values is not None
    colours = np.zeros((2**bits, 3), np.uint16)
    found = np.array(values, np.uint16).reshape(-1, 3)
    # With lower bytes of their own: the colours have 16 bits.
    colours[: len(found)] = found * 257 ^ 0x35
    # One colour of the file is so dark that its bytes would do: those of the others say that all have 16 bits.
    colours[colours[: len(found)].sum(axis=1).argmin()] = 9
    page = Page(np.asarray(image)[..., np.newaxis], bits, w.PALETTE, **named)
    page.tags[320] = (w.SHORT, [int(v) for v in colours.T.ravel()])
    return drawn(page, lambda stored: luma_of(colours[stored[..., 0]] / 65535))


def floats(kind: str, grey: bool, spread: float = 1.0, order: w.Order = "<", **named: Any) -> Made:
    """Return floats, spread around the middle beyond [0, 1], where they are refused as those of arrays are, if that is above 1."""
    values = colour.grey_picture()[..., np.newaxis] if grey else picture()
    samples = ((values - 0.5) * spread + 0.5).astype(kind)
    page = Page(samples, 8 * samples.itemsize, w.BLACK_IS_ZERO if grey else w.RGB, **named)

    def luma(stored: Samples) -> Luma:
        clipped = np.clip(stored.astype(np.float64), 0, 1)
        return luma_of(clipped[..., 0] if grey else clipped)

    return beyond(page) if spread > 1 else drawn(page, luma, order=order)


def beyond(page: Page) -> Made:
    return Made(w.tiff(page), Refused(("between 0 and 1",)))


def not_numbers() -> Made:
    samples = picture().astype(np.float32)
    samples[3, 4, 1] = np.nan
    return Made(tiff(Page(samples, 32, w.RGB)), Refused(any_of=("nan", "not a number")))


def signed(bits: int, channels: int) -> Made:
    samples = np.round((picture() - 0.5) * (2**bits - 1)).astype(f"i{bits // 8}")[..., :channels]
    page = Page(samples, bits, w.RGB if channels == 3 else w.BLACK_IS_ZERO)
    return Made(tiff(page), Refused(("signed",), ("damaged", "cut short", "unsigned")))


def complex_numbers() -> Made:
    page = grey(32)
    page.tags[339] = (w.SHORT, [6])
    page.tags[258] = (w.SHORT, [64])
    return Made(tiff(replace(page, samples=np.repeat(page.samples, 2, axis=1))), Refused(("complex",)))


def with_alpha(base: Samples, bits: int, kind: int, more: Sequence[int] = (), **named: Any) -> Made:
    """Return greys or colours with alpha, and more channels that mean nothing; `kind` says what the alpha is."""
    opacity = alpha_samples(bits)
    if base.dtype.kind == "f":
        opacity = colour.opacity()[..., np.newaxis].astype(base.dtype)
    solid = float(1 if base.dtype.kind == "f" else 2**bits - 1)
    if kind == w.ASSOCIATED:
        product = base * (opacity / solid)
        base = product.astype(base.dtype) if base.dtype.kind == "f" else np.round(product).astype(base.dtype)
    others = [np.full_like(opacity, 0 if i else solid / 3) for i in range(len(more))]
    samples = np.concatenate([base, opacity, *others], axis=2)
    channels = base.shape[2]
    page = Page(samples, bits, w.BLACK_IS_ZERO if channels == 1 else w.RGB, extra=(kind, *more), **named)

    def luma(stored: Samples) -> Luma:
        values = stored[..., : channels + 1].astype(np.float64) / solid
        colours = values[..., 0] if channels == 1 else values[..., :3]
        if kind == w.ASSOCIATED:
            return luma_of(colours) + 1 - values[..., channels]
        return on_white(colours, values[..., channels]) if kind == w.UNASSOCIATED else luma_of(colours)

    return drawn(page, luma)


def as_its_alpha(samples: Callable[[], Samples], bits: int, kind: int, **named: Any) -> Made:
    return with_alpha(samples(), bits, kind, **named)


def float_alpha(kind: str, extra: int) -> Made:
    return with_alpha(picture().astype(kind), 8 * np.dtype(kind).itemsize, extra)


def ink_samples(bits: int) -> Samples:
    return quantised(colour.inks_of(picture()), bits)


def inks(bits: int, profile: bool = False, alpha: bool = False, **named: Any) -> Made:
    samples = ink_samples(bits)
    page = Page(samples, bits, w.CMYK, **named)
    if alpha:
        page = replace(page, samples=np.concatenate([samples, alpha_samples(bits)], axis=2), extra=(w.UNASSOCIATED,))
    if profile:
        page.tags[PROFILE] = (w.UNDEFINED, colour.cmyk_profile())

    def luma(stored: Samples) -> Luma:
        values = fraction(stored, bits)
        colours = colour.plain_cmyk(values[..., :4])
        if profile:
            colours = colour.colours_of_lab(colour.cmyk_colours(values[..., :4]))
        return on_white(colours, values[..., 4]) if alpha else luma_of(colours)

    made = drawn(page, luma, CLOSE_CMYK)
    if profile and bits == 8 and not alpha:
        return replace(made, witness=colour.by_pillow_cms(made.data))
    return made


def lab(bits: int, offset: bool = False) -> Made:
    """Return CIE L*a*b*: a* and b* signed, or offset as profiles have them."""
    values = colour.lab_of(picture())
    if bits == 8:
        lightness, scale = 255 / 100, 1
    else:
        lightness, scale = (65280 if offset else 65535) / 100, 256
    light = np.round(values[..., :1] * lightness)
    chroma = np.round(values[..., 1:] * scale) + (128 * scale if offset else 0)
    samples = (np.concatenate([light, chroma], axis=2).astype(np.int64) % 2**bits).astype(f"u{bits // 8}")

    def luma(stored: Samples) -> Luma:
        chroma = stored[..., 1:].astype(np.float64) - 128 * scale if offset else stored[..., 1:].astype(f"i{bits // 8}")
        found = np.concatenate([stored[..., :1] / lightness, chroma / scale], axis=2)
        return luma_of(colour.colours_of_lab(found))

    made = drawn(Page(samples, bits, w.ICC_LAB if offset else w.LAB), luma)
    if bits == 8 and not offset:
        space = ImageCms.ImageCmsProfile(ImageCms.createProfile("LAB")).tobytes()
        image = colour.through_profile(Image.open(io.BytesIO(made.data)), space)
        return replace(made, witness=colour.luma_of_pil(image))
    return made


def ycbcr_planes(bits: int = 8) -> Samples:
    assert bits == 8
    return np.asarray(Image.fromarray(rgb_samples()).convert("YCbCr"))


def ycbcr(sampling: tuple[int, int], **named: Any) -> Made:
    """Return Y', Cb and Cr without JPEG's coding."""
    page = Page(ycbcr_planes(), 8, w.YCBCR, sampling=sampling, **named)
    page.tags.setdefault(532, (w.RATIONAL, [(v, 1) for v in (0, 255, 128, 255, 128, 255)]))
    across, down = sampling
    luma = page.samples[..., 0].astype(np.float64)
    blue, red = (np.round(shrunk(page.samples[..., i].astype(np.float64), across, down)) - 128 for i in (1, 2))
    blue, red = (np.kron(v, np.ones((down, across)))[: luma.shape[0], : luma.shape[1]] for v in (blue, red))
    green = luma - (0.114 * 1.772 * blue + 0.299 * 1.402 * red) / 0.587
    colours = np.stack([luma + 1.402 * red, green, luma + 1.772 * blue], axis=2)
    return Made(tiff(page), Drawn(luma_of(np.clip(colours / 255, 0, 1))))


# Compressions --------------------------------------------------------------------------------------------------------------------


def jpeg(photometric: int, sampling: tuple[int, int] = (1, 1), shared_tables: bool = True, **named: Any) -> Made:
    makers = {w.YCBCR: ycbcr_planes, w.RGB: rgb_samples, w.BLACK_IS_ZERO: grey_samples, w.CMYK: ink_samples}
    samples = makers[photometric](8)
    page = Page(samples, 8, photometric, w.JPEG, sampling=sampling, shared_tables=shared_tables, **named)
    data = tiff(page)
    return Made(data, Drawn(by_pillow(data)))


def old_jpeg() -> Made:
    """Return a file in the way of TIFF 6.0, which was soon given up: a whole JPEG, and tags that tell its place."""
    planes = [ycbcr_planes()[..., i].astype(np.float64) for i in range(3)]
    data = baseline.encode(planes, [(2, 2), (1, 1), (1, 1)])
    writer = w.Writer("<", big=False)
    start = writer.append(data)
    page = Page(ycbcr_planes(), 8, w.YCBCR, w.OLD_JPEG, sampling=(2, 2), rows=colour.HEIGHT)
    page.tags |= {512: (w.SHORT, [1]), 513: (w.LONG, [start]), 514: (w.LONG, [len(data)])}
    writer.directory(w.tags_of(page, [start], [len(data)]), 4)
    return Made(bytes(writer.data), Drawn(by_pillow(data)), by_pillow(bytes(writer.data)))


def fax(compression: int, photometric: int = w.BLACK_IS_ZERO, options: int = 0, rows: int = 16, **named: Any) -> Made:
    samples = bits_of_a_fax()
    page = Page(samples, 1, photometric, compression, rows=rows, **named)
    if compression == w.GROUP3:
        page.tags[292] = (w.LONG, [options])
    data = tiff(page)
    white = 1.0 - samples[..., 0] if photometric == w.WHITE_IS_ZERO else samples[..., 0].astype(np.float64)
    return Made(data, Drawn(white), by_pillow(data))


# Colour --------------------------------------------------------------------------------------------------------------------------


def profiled(page: Page, linear: bool, primaries: tuple[tuple[float, float], ...], top: float = 1.0) -> Made:
    """Return a file with a profile of these primaries, linear or of Adobe's power; floats reach up to `top`."""
    is_float = page.samples.dtype.kind == "f"
    channels = page.samples.shape[2]
    solid = 1.0 if is_float else 2**page.bits - 1
    power = 1.0 if linear else 563 / 256
    page = replace(page, samples=(page.samples * top).astype(page.samples.dtype))
    grey = channels <= 2
    profile = colour.grey_profile(power) if grey else colour.rgb_profile(primaries, power)
    page.tags[PROFILE] = (w.UNDEFINED, profile)

    def luma(stored: Samples) -> Luma:
        values = stored.astype(np.float64) / solid
        alpha = values[..., -1] if page.extra else np.ones(values.shape[:2])
        colours = values[..., 0] if grey else values[..., :3]
        spread = alpha if grey else alpha[..., np.newaxis]
        if page.extra and page.extra[0] == w.ASSOCIATED:
            colours = np.clip(np.divide(colours, spread, where=spread > 0, out=np.zeros_like(colours)), 0, 1)
        light = colours**power
        return on_white(colour.srgb_encoded(light) if grey else colour.converted(light, primaries), alpha)

    return drawn(page, luma)


def profiled_rgb(bits: int, kind: int | None = None) -> Made:
    """Return 8 or 16 bits with a profile, and alpha where its kind is given."""
    samples = rgb_samples(bits)
    if kind is None:
        return profiled(rgb(bits), False, colour.ADOBE_XY)
    opacity = alpha_samples(bits)
    if kind == w.ASSOCIATED:
        samples = np.round(samples * (opacity / (2**bits - 1))).astype(samples.dtype)
    page = Page(np.concatenate([samples, opacity], axis=2), bits, w.RGB, extra=(kind,))
    return profiled(page, False, colour.ADOBE_XY)


def profiled_floats(kind: str, grey: bool, top: float = 1.0) -> Made:
    values = colour.grey_picture()[..., np.newaxis] if grey else picture()
    samples = colour.srgb_decoded(values).astype(kind)
    page = Page(samples, 8 * samples.itemsize, w.BLACK_IS_ZERO if grey else w.RGB)
    made = profiled(page, True, colour.SRGB_XY, top)
    return Made(made.data, Refused(("between 0 and 1",))) if top > 1 else made


def profiled_grey(bits: int) -> Made:
    return profiled(grey(bits), False, colour.SRGB_XY)


def profiled_palette() -> Made:
    made = palette(8)
    image = Image.open(io.BytesIO(made.data)).convert("RGB")
    data = palette(8, tags={PROFILE: (w.UNDEFINED, colour.rgb_profile(colour.ADOBE_XY, 1.0))}).data
    return Made(data, Drawn(luma_of(colour.converted(np.asarray(image) / 255, colour.ADOBE_XY))))


def marked(adobe_rgb: str) -> Made:
    """Return a file with a camera's mark of Adobe RGB."""
    entries: dict[int, w.Tag] = {0xA001: (w.SHORT, [2 if adobe_rgb == "two" else 0xFFFF])}
    if adobe_rgb == "uncalibrated":
        entries[0xA005] = (w.LONG, {1: (w.ASCII, b"R03\0")})
    page = rgb()
    page.tags[0x8769] = (w.LONG, entries)
    luma = luma_of(colour.converted((page.samples / 255) ** (563 / 256), colour.ADOBE_XY))
    return Made(tiff(page), Drawn(luma))


def turned(orientation: int, compression: int = w.NONE) -> Made:
    samples = colour.stored(rgb_samples(), orientation)
    page = Page(samples, 8, w.RGB, compression, tags={274: (w.SHORT, [orientation])})
    return Made(tiff(page), Drawn(meaning(8)(rgb_samples())))


# Several images ------------------------------------------------------------------------------------------------------------------


def small(**tags: w.Tag) -> Page:
    """Return a smaller image that looks other than the picture."""
    numbers = {int(name.removeprefix("tag")): value for name, value in tags.items()}
    return Page(255 - rgb_samples()[::3, ::3], 8, w.RGB, tags=numbers)


def reduced() -> Page:
    return small(tag254=(w.LONG, [1]))


def several(*pages: Callable[[], Page]) -> Made:
    return Made(tiff(*[page() for page in pages]), Drawn(meaning(8)(rgb_samples())))


def full() -> Page:
    return rgb(tags={254: (w.LONG, [0])})


def negative() -> Page:
    return Page(255 - rgb_samples(), 8, w.RGB)


def old_thumbnail() -> Page:
    """Return a thumbnail by the older tag."""
    return small(tag255=(w.SHORT, [2]))


def mask() -> Page:
    return Page(bits_of_a_fax(), 1, w.MASK, tags={254: (w.LONG, [4])})


def full_below() -> Page:
    """Return a thumbnail with the photo in a directory below it."""
    page = reduced()
    page.tags[330] = (w.LONG, [full()])
    return page


def reduced_below() -> Page:
    """Return a photo with its reduced sizes below it, as pyramids have them."""
    page = rgb()
    page.tags[330] = (w.LONG, [reduced()])
    return page


def sensor() -> Page:
    """Return a sensor's samples behind its colour filters."""
    tags: dict[int, w.Tag] = {
        254: (w.LONG, [0]),
        33421: (w.SHORT, [2, 2]),
        33422: (w.BYTE, [0, 1, 1, 2]),
    }
    return Page(grey_samples(16), 16, w.CFA, tags=tags)


def raw(dng: bool, below: bool, photometric: int = w.CFA) -> Made:
    """Return a camera's raw file: the sensor's samples alone, or below a thumbnail."""
    page = sensor()
    if photometric == w.LINEAR_RAW:
        page = Page(rgb_samples(16), 16, photometric, tags={254: (w.LONG, [0])})
    if below:
        thumbnail = reduced()
        thumbnail.tags[330] = (w.LONG, [page])
        page = thumbnail
    if dng:
        page.tags[50706] = (w.BYTE, [1, 4, 0, 0])
    return Made(tiff(page), Refused(("raw", "DNG") if dng else ("raw",)))


# Layouts and damage --------------------------------------------------------------------------------------------------------------


def first_directory(page: Callable[[], Page]) -> Made:
    made = page()
    return Made(w.directory_first(made), Drawn(meaning(8)(made.samples)))


def cut(share: float, before: bool, **named: Any) -> Made:
    """Return a file of which a part is left, its directory before or after its pixels."""
    data = w.directory_first(rgb(**named)) if before else tiff(rgb(**named))
    return Made(data[: round(len(data) * share)], Refused(("cut short",), without=()))


def missing_strips() -> Made:
    """Return a file that ends as it should and lists half of its strips."""
    page = rgb()
    whole = w.pieces(page)
    half = replace(page, samples=np.concatenate(whole[: len(whole) // 2]), tags={257: (w.LONG, [colour.HEIGHT])})
    return Made(tiff(half), Refused(any_of=("cut short", "damaged"), without=()))


def trailing() -> Made:
    return Made(tiff(rgb()) + bytes(500), Drawn(meaning(8)(rgb_samples())))


def unknown_compression() -> Made:
    page = rgb(tags={259: (w.SHORT, [34676])})
    return Made(tiff(page), Refused(any_of=("SGI", "compression")))


def refused(page: Callable[[], Page], *any_of: str) -> Made:
    return Made(tiff(page()), Refused(any_of=any_of))


def case(name: str, pixel_type: str, make: Callable[..., Made], *arguments: Any, **named: Any) -> Case:
    return Case(f"tiff_{name}", "TIFF", pixel_type, lambda: make(*arguments, **named))


def page_case(name: str, pixel_type: str, page: Callable[..., Page], bits: int = 8, **named: Any) -> Case:
    """Return a case of plain greys or colours; byte order and kind of file are told from the rest."""
    file = {key: named.pop(key) for key in ("order", "big") if key in named}
    return Case(f"tiff_{name}", "TIFF", pixel_type, lambda: plain(lambda: page(bits, **named), **file))


TILE = (32, 48)
LOSSLESS = {
    "none": w.NONE,
    "lzw": w.LZW,
    "deflate": w.DEFLATE,
    "old_deflate": w.OLD_DEFLATE,
    "packbits": w.PACKBITS,
    "zstd": w.ZSTD,
    "lzma": w.LZMA,
}
WORDS = {
    "none": "not compressed",
    "lzw": "LZW",
    "deflate": "Deflate",
    "old_deflate": "Deflate",
    "packbits": "PackBits",
    "zstd": "Zstandard",
    "lzma": "LZMA",
}


def layouts() -> list[Case]:
    """Return cases of byte orders, strips, tiles, planes, predictors and compressions."""
    rows = []
    for order, name in [("<", "little"), (">", "big")]:
        for bits in (8, 16):
            rows.append(page_case(f"{name}_rgb{bits}", f"{bits}-bit RGB", rgb, bits, order=order))
        rows.append(page_case(f"{name}_bigtiff", "BigTIFF", rgb, 16, order=order, big=True))
        rows.append(page_case(f"{name}_tiles16", "tiles", rgb, 16, order=order, tile=TILE))
        rows.append(page_case(f"{name}_predictor16", "predictor", rgb, 16, order=order, compression=w.LZW, predictor=2))
    rows.append(page_case("bigtiff_tiles", "BigTIFF", grey, 8, big=True, tile=TILE, compression=w.DEFLATE))
    rows.append(page_case("one_strip", "8-bit RGB", rgb, rows=1000))
    rows.append(page_case("strips_of_a_row", "8-bit RGB", rgb, rows=1))
    rows.append(page_case("no_rows_tag", "8-bit RGB", rgb, rows=colour.HEIGHT, without=(278,)))
    rows.append(case("directory_first", "8-bit RGB", first_directory, rgb))
    for planar in (1, 2):
        for tile in (None, TILE):
            name = f"{'tiles' if tile else 'strips'}_{'planes' if planar == 2 else 'pixels'}"
            words = "separate planes" if planar == 2 else "tiles" if tile else "8-bit RGB"
            for compression in ("none", "lzw", "deflate"):
                code = LOSSLESS[compression]
                rows.append(page_case(f"{name}_{compression}", words, rgb, planar=planar, tile=tile, compression=code))
            rows.append(page_case(f"{name}_16", words, rgb, 16, planar=planar, tile=tile, compression=w.DEFLATE, predictor=2))
    for compression, code in LOSSLESS.items():
        rows.append(page_case(f"{compression}_grey", WORDS[compression], grey, compression=code))
        rows.append(page_case(f"{compression}_rgb16", WORDS[compression], rgb, 16, compression=code))
        rows.append(page_case(f"{compression}_grey4", WORDS[compression], grey, 4, compression=code))
    for code, name in [(w.LZW, "lzw"), (w.DEFLATE, "deflate"), (w.ZSTD, "zstd")]:
        rows.append(page_case(f"predictor_{name}_rgb8", "predictor", rgb, compression=code, predictor=2))
    rows.append(page_case("predictor_grey32", "predictor", grey, 32, compression=w.LZW, predictor=2))
    for kind in ("f2", "f4", "f8"):
        for tile in (None, TILE):
            name = f"predictor_{kind}{'_tiles' if tile else ''}"
            rows.append(case(name, "predictor", floats, kind, False, compression=w.DEFLATE, predictor=3, tile=tile))
    rows.append(case("predictor_f4_grey", "predictor", floats, "f4", True, compression=w.LZW, predictor=3))
    rows.append(case("predictor_f4_big", "predictor", floats, "f4", False, order=">", compression=w.LZW, predictor=3))
    rows.append(case("predictor_palette", "predictor", palette, 8, compression=w.LZW, predictor=2))
    for bits, name in [(1, "1"), (8, "8_lzw"), (16, "16")]:
        code = w.LZW if name == "8_lzw" else w.NONE
        rows.append(page_case(f"lsb_{name}", "bits in reverse order", grey, bits, fill=2, compression=code))
    rows.append(page_case("lsb_packbits", "bits in reverse order", rgb, fill=2, compression=w.PACKBITS))
    rows.append(page_case("lsb_deflate", "bits in reverse order", rgb, fill=2, compression=w.DEFLATE))
    return rows


def codings() -> list[Case]:
    """Return cases of JPEG and fax inside TIFF."""
    rows = []
    for sampling in [(1, 1), (2, 1), (2, 2)]:
        name = f"jpeg_ycbcr_{sampling[0]}x{sampling[1]}"
        rows.append(case(name, "JPEG, Y'CbCr", jpeg, w.YCBCR, sampling))
        rows.append(case(f"{name}_tiles", "JPEG, Y'CbCr", jpeg, w.YCBCR, sampling, tile=TILE))
    rows.append(case("jpeg_ycbcr_own_tables", "JPEG, Y'CbCr", jpeg, w.YCBCR, (2, 2), shared_tables=False))
    rows.append(case("jpeg_ycbcr_one_strip", "JPEG, Y'CbCr", jpeg, w.YCBCR, (2, 2), rows=80))
    rows.append(case("jpeg_rgb", "JPEG, RGB", jpeg, w.RGB))
    rows.append(case("jpeg_rgb_tiles", "JPEG, RGB", jpeg, w.RGB, tile=TILE))
    rows.append(case("jpeg_grey", "JPEG, grey", jpeg, w.BLACK_IS_ZERO))
    rows.append(case("jpeg_grey_own_tables", "JPEG, grey", jpeg, w.BLACK_IS_ZERO, shared_tables=False))
    rows.append(case("jpeg_grey_tiles", "JPEG, grey", jpeg, w.BLACK_IS_ZERO, tile=TILE))
    rows.append(case("jpeg_rgb_planes", "JPEG, RGB", jpeg, w.RGB, planar=2))
    rows.append(case("jpeg_cmyk", "JPEG, CMYK", jpeg, w.CMYK))
    rows.append(case("jpeg_old", "JPEG of the old kind", old_jpeg))
    for code, name, words in [(w.RLE, "rle", "RLE"), (w.GROUP3, "group3", "Group 3"), (w.GROUP4, "group4", "Group 4")]:
        words = f"CCITT {words}"  # noqa: PLW2901
        rows.append(case(name, words, fax, code))
        rows.append(case(f"{name}_white_is_zero", words, fax, code, w.WHITE_IS_ZERO))
        rows.append(case(f"{name}_lsb", words, fax, code, fill=2))
        rows.append(case(f"{name}_one_strip", words, fax, code, rows=colour.HEIGHT))
    rows.append(case("group3_2d", "CCITT Group 3", fax, w.GROUP3, options=1))
    rows.append(case("group3_2d_lsb", "CCITT Group 3", fax, w.GROUP3, options=1, fill=2))
    rows.append(case("group3_filled", "CCITT Group 3", fax, w.GROUP3, options=4))
    rows.append(page_case("webp", "WebP inside", rgb, compression=w.WEBP, rows=colour.HEIGHT))
    return rows


def pixel_types() -> list[Case]:
    """Return cases of samples."""
    rows = [page_case(f"grey{bits}", f"{bits}-bit grey", grey, bits) for bits in (1, 2, 4, 8, 12, 16, 32)]
    rows += [page_case(f"rgb{bits}", f"{bits}-bit RGB", rgb, bits) for bits in (4, 12, 32)]
    rows.append(page_case("grey1_no_bits_tag", "1-bit grey", grey, 1, without=(258, 277)))
    rows.append(page_case("grey12_big", "12-bit grey", grey, 12, order=">"))
    rows.append(page_case("rgb32_big", "32-bit RGB", rgb, 32, order=">"))
    rows.append(page_case("grey32_planes", "32-bit RGB", rgb, 32, planar=2))
    rows.append(page_case("rgb16_void", "16-bit RGB", rgb, 16, tags={339: (w.SHORT, [4, 4, 4])}))
    rows.append(page_case("grey2_tiles", "2-bit grey", grey, 2, tile=(16, 16)))
    rows.append(page_case("grey4_tiles", "4-bit grey", grey, 4, tile=(48, 32)))
    rows += [case(f"white_is_zero{bits}", f"{bits}-bit grey, 0 is white", white_is_zero, bits) for bits in (1, 4, 8, 16)]
    rows += [case(f"palette{bits}", f"{bits}-bit palette", palette, bits) for bits in (1, 2, 4, 8)]
    rows.append(case("palette8_tiles", "8-bit palette", palette, 8, tile=TILE, compression=w.DEFLATE))
    for kind, bits in [("f2", 16), ("f4", 32), ("f8", 64)]:
        rows.append(case(f"float{bits}_grey", f"{bits}-bit float grey", floats, kind, True))
        rows.append(case(f"float{bits}_rgb", f"{bits}-bit float RGB", floats, kind, False))
    rows.append(case("float32_grey_beyond", "floats beyond 0 to 1", floats, "f4", True, 1.6))
    rows.append(case("float32_rgb_beyond", "floats beyond 0 to 1", floats, "f4", False, 1.6))
    rows.append(case("float64_big_tiles", "64-bit float RGB", floats, "f8", False, tile=TILE))
    rows.append(case("float32_nan", "floats that are no numbers", not_numbers))
    for bits in (8, 16, 32):
        rows.append(case(f"signed{bits}_grey", "signed integers", signed, bits, 1))
        rows.append(case(f"signed{bits}_rgb", "signed integers", signed, bits, 3))
    rows.append(case("complex", "complex numbers", complex_numbers))

    return rows


def alphas() -> list[Case]:
    """Return cases of alpha, of either kind."""
    rows = []
    for kind, name, words in [
        (w.ASSOCIATED, "associated", "premultiplied alpha"),
        (w.UNASSOCIATED, "unassociated", "alpha"),
    ]:
        for bits in (8, 16):
            grey_make, rgb_make = partial(grey_samples, bits), partial(rgb_samples, bits)
            rows.append(case(f"{name}_grey{bits}", f"grey + {words}", as_its_alpha, grey_make, bits, kind))
            rows.append(case(f"{name}_rgb{bits}", f"RGB + {words}", as_its_alpha, rgb_make, bits, kind))
            rows.append(case(f"{name}_planes{bits}", f"RGB + {words}", as_its_alpha, rgb_make, bits, kind, planar=2))
            packed: dict[str, Any] = {"compression": w.DEFLATE, "predictor": 2, "tile": TILE}
            rows.append(case(f"{name}_tiles{bits}", f"RGB + {words}", as_its_alpha, rgb_make, bits, kind, **packed))
        rows.append(case(f"{name}_float32", f"float RGB + {words}", float_alpha, "f4", kind))
        rows.append(case(f"{name}_float16", f"float RGB + {words}", float_alpha, "f2", kind))
        more = [w.UNSPECIFIED]
        rows.append(case(f"{name}_and_more", f"RGB + {words}", as_its_alpha, rgb_samples, 8, kind, more=more))
    rows += [case(f"unassociated_white_is_zero{bits}", "grey + alpha", white_is_zero_with_alpha, bits) for bits in (8, 16)]
    rows.append(case("unspecified_rgb", "channels that are no alpha", as_its_alpha, rgb_samples, 8, w.UNSPECIFIED))
    rows.append(case("unspecified_grey", "channels that are no alpha", as_its_alpha, partial(grey_samples, 8), 8, w.UNSPECIFIED))
    return rows


def colour_spaces() -> list[Case]:
    """Return cases of colours other than R'G'B'."""
    rows = []
    for bits in (8, 16):
        rows.append(case(f"cmyk{bits}", "CMYK", inks, bits))
        rows.append(case(f"cmyk{bits}_profile", "CMYK with a profile", inks, bits, True))
        rows.append(case(f"lab{bits}", "CIELab", lab, bits))
        rows.append(case(f"icc_lab{bits}", "ICCLab", lab, bits, True))
    rows.append(case("cmyk_alpha", "CMYK + alpha", inks, 8, alpha=True))
    rows.append(case("cmyk_alpha_profile", "CMYK + alpha", inks, 8, profile=True, alpha=True))
    rows.append(case("cmyk_planes", "CMYK", inks, 8, planar=2, compression=w.LZW))
    rows.append(case("cmyk_tiles", "CMYK", inks, 8, tile=TILE, compression=w.DEFLATE, predictor=2))
    for sampling in [(1, 1), (2, 1), (2, 2), (4, 2)]:
        rows.append(case(f"ycbcr_{sampling[0]}x{sampling[1]}", "Y'CbCr", ycbcr, sampling))
    rows.append(case("ycbcr_2x2_lzw", "Y'CbCr", ycbcr, (2, 2), compression=w.LZW))
    rows.append(case("ycbcr_2x2_tiles", "Y'CbCr", ycbcr, (2, 2), tile=TILE))
    return rows


def meanings() -> list[Case]:
    """Return cases of profiles, marks, orientations and several images."""
    rows = []
    words = "ICC profile"
    for bits in (8, 16):
        rows.append(case(f"icc_rgb{bits}", words, profiled_rgb, bits))
        rows.append(case(f"icc_grey{bits}", words, profiled_grey, bits))
        rows.append(case(f"icc_alpha{bits}", words, profiled_rgb, bits, w.UNASSOCIATED))
        rows.append(case(f"icc_premultiplied{bits}", words, profiled_rgb, bits, w.ASSOCIATED))
    for kind, bits in [("f2", 16), ("f4", 32), ("f8", 64)]:
        rows.append(case(f"icc_float{bits}", words, profiled_floats, kind, False))
    rows.append(case("icc_float32_beyond", "floats beyond 0 to 1", profiled_floats, "f4", False, 1.7))
    rows.append(case("icc_float32_grey", words, profiled_floats, "f4", True))
    rows.append(case("icc_palette", words, profiled_palette))
    rows += [case(f"exif_adobe_{kind}", "EXIF mark of Adobe RGB", marked, kind) for kind in ("uncalibrated", "two")]
    rows += [case(f"orientation{i}", "orientation", turned, i) for i in range(1, 9)]
    rows.append(case("orientation6_lzw", "orientation", turned, 6, w.LZW))

    pages = "several images, the largest"
    files: list[tuple[str, list[Callable[[], Page]]]] = [
        ("thumbnail_first", [reduced, full]),
        ("thumbnail_first_old", [old_thumbnail, rgb]),
        ("thumbnail_last", [rgb, reduced]),
        ("mask_first", [mask, rgb]),
        ("mask_last", [rgb, mask]),
        ("smaller_first", [small, rgb]),
        ("smaller_last", [rgb, small]),
        ("same_size", [rgb, negative]),
        ("full_below", [full_below]),
        ("reduced_below", [reduced_below]),
    ]
    for name, make in files:
        rows.append(case(name, pages, several, *make))
    raws = "a camera's raw file"
    rows.append(case("dng", raws, raw, True, True))
    rows.append(case("dng_alone", raws, raw, True, False))
    rows.append(case("dng_linear", raws, raw, True, True, w.LINEAR_RAW))
    rows.append(case("sensor", raws, raw, False, False))
    rows.append(case("sensor_below", raws, raw, False, True))
    return rows


def damage() -> list[Case]:
    """Return cases of files that are not whole."""
    short = "cut short"
    rows = [
        case("cut_half", short, cut, 0.5, False),
        case("cut_half_directory_first", short, cut, 0.5, True),
        case("missing_strips", short, missing_strips),
        case("trailing", "bytes after the end", trailing),
        case("unknown_compression", "other compressions", unknown_compression),
    ]
    for name in ("lzw", "deflate", "packbits", "zstd"):
        rows.append(case(f"cut_half_{name}", short, cut, 0.5, True, compression=LOSSLESS[name], rows=colour.HEIGHT))
    rows.append(case("cut_half_tiles", short, cut, 0.5, True, tile=TILE))
    return rows


def cases() -> list[Case]:
    """Return all cases of TIFF."""
    return [*layouts(), *codings(), *pixel_types(), *alphas(), *colour_spaces(), *meanings(), *damage()]
