"""Colour for the corpus: the picture, its luma, profiles, and the formulas of the standards in NumPy."""

from __future__ import annotations

import io
import struct
from collections.abc import Callable
from typing import Any

import numpy as np
from numpy.typing import NDArray
from PIL import Image, ImageCms

HEIGHT, WIDTH = 70, 93
"""No multiples of 8 or 16 in any direction, so that padding shows, and an odd width, so that half bytes do."""

Luma = NDArray[np.float64]
Samples = NDArray[Any]

D50 = np.array([0.9642, 1.0, 0.8249])
"""The white of profile connection spaces."""
D65_XY = (0.3127, 0.3290)
SRGB_XY = ((0.64, 0.33), (0.30, 0.60), (0.15, 0.06))
ADOBE_XY = ((0.64, 0.33), (0.21, 0.71), (0.15, 0.06))
P3_XY = ((0.680, 0.320), (0.265, 0.690), (0.150, 0.060))
BRADFORD = np.array([[0.8951, 0.2664, -0.1614], [-0.7502, 1.7135, 0.0367], [0.0389, -0.0685, 1.0296]])


def picture() -> NDArray[np.float64]:
    """Return the picture, (height, width, 3) in [0, 1]: smooth, coloured, structured, different under every turn and mirror."""
    y, x = np.mgrid[0 : 1 : HEIGHT * 1j, 0 : 1 : WIDTH * 1j]
    wave = 0.5 + 0.5 * np.sin(9 * x + 5 * y * y)
    spot = np.exp(-14 * ((x - 0.3) ** 2 + (y - 0.65) ** 2))
    red = 0.03 + 0.85 * x * wave + 0.1 * spot
    green = 0.02 + 0.78 * y + 0.18 * wave * (1 - y) - 0.5 * spot * y
    blue = 0.85 - 0.6 * x - 0.25 * y * wave + 0.2 * spot
    colours: NDArray[np.float64] = np.clip(np.stack([red, green, blue], axis=2), 0, 1)
    return colours


def grey_picture() -> NDArray[np.float64]:
    """Return the picture without its colours, (height, width), from near black to near white."""
    luma = luma_of(picture())
    grey: Luma = 0.02 + 0.96 * (luma - luma.min()) / (luma.max() - luma.min())
    return grey


def opacity() -> NDArray[np.float64]:
    """Return an alpha channel, (height, width): a slope with parts that are clear and parts that are solid."""
    y, x = np.mgrid[0 : 1 : HEIGHT * 1j, 0 : 1 : WIDTH * 1j]
    slope: NDArray[np.float64] = np.clip(1.6 * (x + y) / 2 - 0.2, 0, 1)
    return slope


def bilevel() -> NDArray[np.bool_]:
    """Return the picture in black and white, (height, width), True for white: runs of all lengths, and some noise."""
    noise = np.random.default_rng(21).uniform(-0.08, 0.08, (HEIGHT, WIDTH))
    white: NDArray[np.bool_] = grey_picture() + noise > 0.45
    return white


def quantised(values: NDArray[np.float64], bits: int) -> Samples:
    """Return values in [0, 1] as unsigned samples."""
    kind = np.uint8 if bits <= 8 else np.uint16 if bits <= 16 else np.uint32
    samples: Samples = np.round(values * (2**bits - 1)).astype(kind)
    return samples


def fraction(samples: Samples, bits: int) -> NDArray[np.float64]:
    """Return unsigned samples divided by their maximum."""
    values: NDArray[np.float64] = samples.astype(np.float64) / (2**bits - 1)
    return values


def luma_of(colours: NDArray[np.floating[Any]]) -> Luma:
    """Return the luma of sRGB-encoded colours, (height, width, 3) or already grey (height, width)."""
    values = np.asarray(colours, np.float64)
    luma: Luma = values if values.ndim == 2 else values[..., :3] @ np.array([0.299, 0.587, 0.114])
    return luma


def on_white(colours: NDArray[np.floating[Any]], alpha: NDArray[np.floating[Any]]) -> Luma:
    """Return the luma of colours over white."""
    luma: Luma = luma_of(colours) * alpha + (1 - alpha)
    return luma


def luma_of_pil(image: Image.Image) -> Luma:
    """Return the luma of a PIL image of 8 bits as it is, over white."""
    if image.mode in {"L", "RGB"} and "transparency" not in image.info:
        return luma_of(np.asarray(image) / 255)
    if image.mode == "CMYK":
        return luma_of(plain_cmyk(np.asarray(image) / 255))
    rgba = np.asarray(image.convert("RGBA")) / 255
    return on_white(rgba[..., :3], rgba[..., 3])


def by_pillow(data: bytes) -> Luma:
    """Return the luma of a file of 8-bit samples as Pillow reads it, no profile applied."""
    return luma_of_pil(Image.open(io.BytesIO(data)))


def by_pillow_cms(data: bytes) -> Luma:
    """Return the luma of a file as Pillow reads it, its profile converted by Little CMS."""
    image = Image.open(io.BytesIO(data))
    return luma_of_pil(through_profile(image, image.info["icc_profile"]))


def through_profile(image: Image.Image, profile: bytes) -> Image.Image:
    """Return a PIL image in sRGB.

    Little CMS is kept from its shortcuts, tables for 8 bits: they miss the mean luma of CIELab by 0.004, that of linear greys by
    0.0026, more than a photo may be off here.
    """
    source = ImageCms.ImageCmsProfile(io.BytesIO(profile))
    target = ImageCms.createProfile("sRGB")
    intent, exactly = ImageCms.Intent.RELATIVE_COLORIMETRIC, ImageCms.Flags.NOOPTIMIZE
    converted = ImageCms.profileToProfile(image, source, target, intent, outputMode="RGB", flags=exactly)
    assert converted is not None
    return converted


def plain_cmyk(inks: NDArray[np.floating[Any]]) -> NDArray[np.float64]:
    """Return the colours of inks without a profile."""
    inks = np.asarray(inks, np.float64)
    return (1 - inks[..., :3]) * (1 - inks[..., 3:4])


def inks_of(colours: NDArray[np.float64]) -> NDArray[np.float64]:
    """Return inks, (height, width, 4), whose plain colours are the given ones, half of the possible black in K."""
    black = 0.5 * (1 - colours.max(axis=2, keepdims=True))
    return np.concatenate([1 - colours / (1 - black), black], axis=2)


# Transfer functions and primaries ------------------------------------------------------------------------------------------------


def srgb_encoded(linear: NDArray[np.floating[Any]]) -> NDArray[np.float64]:
    """Return sRGB-encoded values, clipped to [0, 1]."""
    linear = np.clip(np.asarray(linear, np.float64), 0, 1)
    return np.where(linear <= 0.0031308, 12.92 * linear, 1.055 * linear ** (1 / 2.4) - 0.055)


def srgb_decoded(encoded: NDArray[np.floating[Any]]) -> NDArray[np.float64]:
    """Return linear light."""
    encoded = np.asarray(encoded, np.float64)
    return np.where(encoded <= 0.04045, encoded / 12.92, ((encoded + 0.055) / 1.055) ** 2.4)


def bt709_decoded(encoded: NDArray[np.floating[Any]]) -> NDArray[np.float64]:
    """Return linear light: the inverse of the function of ITU-R BT.709, H.273's transfer characteristics 1."""
    encoded = np.asarray(encoded, np.float64)
    return np.where(encoded < 4.5 * 0.018, encoded / 4.5, ((encoded + 0.099) / 1.099) ** (1 / 0.45))


def xyz_of(x: float, y: float) -> NDArray[np.float64]:
    """Return the colour of a chromaticity, with Y = 1."""
    return np.array([x / y, 1.0, (1 - x - y) / y])


def to_xyz(primaries: tuple[tuple[float, float], ...], white: tuple[float, float] = D65_XY) -> NDArray[np.float64]:
    """Return the matrix from linear R, G, B to X, Y, Z."""
    columns: NDArray[np.float64] = np.stack([xyz_of(*xy) for xy in primaries], axis=1)
    matrix: NDArray[np.float64] = columns * np.linalg.solve(columns, xyz_of(*white))
    return matrix


def adaptation(source: NDArray[np.float64], target: NDArray[np.float64]) -> NDArray[np.float64]:
    """Return the Bradford matrix from one white to another."""
    scale = (BRADFORD @ target) / (BRADFORD @ source)
    matrix: NDArray[np.float64] = np.linalg.inv(BRADFORD) @ np.diag(scale) @ BRADFORD
    return matrix


def to_d50(primaries: tuple[tuple[float, float], ...], white: tuple[float, float] = D65_XY) -> NDArray[np.float64]:
    """Return the matrix from linear R, G, B to X, Y, Z adapted to D50, as profiles have it."""
    return adaptation(xyz_of(*white), D50) @ to_xyz(primaries, white)


def converted(
    linear: NDArray[np.floating[Any]], primaries: tuple[tuple[float, float], ...], white: tuple[float, float] = D65_XY
) -> NDArray[np.float64]:
    """Return the sRGB-encoded colours of linear ones of other primaries, clipped."""
    matrix = np.linalg.inv(to_d50(SRGB_XY)) @ to_d50(primaries, white)
    return srgb_encoded(np.asarray(linear, np.float64) @ matrix.T)


def lab_of(colours: NDArray[np.float64]) -> NDArray[np.float64]:
    """Return CIE L*, a*, b* under D50 of sRGB colours."""
    ratio = (srgb_decoded(colours) @ to_d50(SRGB_XY).T) / D50
    f = np.where(ratio > (6 / 29) ** 3, np.cbrt(ratio), ratio / (3 * (6 / 29) ** 2) + 4 / 29)
    return np.stack([116 * f[..., 1] - 16, 500 * (f[..., 0] - f[..., 1]), 200 * (f[..., 1] - f[..., 2])], axis=-1)


def colours_of_lab(lab: NDArray[np.floating[Any]]) -> NDArray[np.float64]:
    """Return sRGB colours of CIE L*, a*, b* under D50, clipped."""
    lightness = (np.asarray(lab, np.float64)[..., 0] + 16) / 116
    f = np.stack([lightness + lab[..., 1] / 500, lightness, lightness - lab[..., 2] / 200], axis=-1)
    xyz = D50 * np.where(f > 6 / 29, f**3, 3 * (6 / 29) ** 2 * (f - 4 / 29))
    return srgb_encoded(xyz @ np.linalg.inv(to_d50(SRGB_XY)).T)


# Profiles ------------------------------------------------------------------------------------------------------------------------

Transfer = Callable[[NDArray[np.float64]], NDArray[np.float64]]


def fixed(value: float) -> bytes:
    return struct.pack(">i", round(value * 65536))


def xyz_tag(values: NDArray[np.float64]) -> bytes:
    return b"XYZ \0\0\0\0" + b"".join(fixed(float(v)) for v in values)


def curve_tag(gamma: float) -> bytes:
    """Return a curve: a table with no entries is the identity, one with one entry is a power of 8.8 bits."""
    return b"curv\0\0\0\0" + (struct.pack(">I", 0) if gamma == 1 else struct.pack(">IHxx", 1, round(gamma * 256)))


def profile(kind: bytes, space: bytes, connection: bytes, tags: dict[bytes, bytes]) -> bytes:
    """Return an ICC profile of version 2.4 from its class, its colour space and its tags."""
    tags = {
        b"desc": b"desc\0\0\0\0" + struct.pack(">I", 5) + b"test\0" + bytes(4 + 4 + 2 + 1 + 67),
        b"cprt": b"text\0\0\0\0none\0",
        b"wtpt": xyz_tag(D50),
        **tags,
    }
    table, body = b"", b""
    start = 128 + 4 + 12 * len(tags)
    for name, content in tags.items():
        table += name + struct.pack(">II", start + len(body), len(content))
        body += content + bytes(-len(content) % 4)
    total = start + len(body)
    header = struct.pack(">I4sI4s4s4s", total, b"none", 0x02400000, kind, space, connection)
    header += struct.pack(">6H", 2026, 1, 1, 0, 0, 0) + b"acsp" + bytes(4 + 4 + 4 + 4 + 8 + 4)
    header += b"".join(fixed(float(v)) for v in D50)
    return header.ljust(128, b"\0") + struct.pack(">I", len(tags)) + table + body


def rgb_profile(primaries: tuple[tuple[float, float], ...] = SRGB_XY, gamma: float = 1.0, padding: int = 0) -> bytes:
    """Return a profile of primaries under D65 and a power, with so many bytes of noise in a private tag."""
    matrix = to_d50(primaries)
    tags = {name: xyz_tag(matrix[:, i]) for i, name in enumerate([b"rXYZ", b"gXYZ", b"bXYZ"])}
    tags |= {name: curve_tag(gamma) for name in [b"rTRC", b"gTRC", b"bTRC"]}
    if padding:
        tags[b"nois"] = b"data\0\0\0\0\0\0\0\x01" + np.random.default_rng(3).bytes(padding)
    return profile(b"mntr", b"RGB ", b"XYZ ", tags)


def grey_profile(gamma: float = 1.0) -> bytes:
    """Return a profile of greys."""
    return profile(b"mntr", b"GRAY", b"XYZ ", {b"kTRC": curve_tag(gamma)})


def cmyk_colours(inks: NDArray[np.floating[Any]]) -> NDArray[np.float64]:
    """Return the L*, a*, b* of a press of soft inks on a yellowish paper: quite other than the plain rule."""
    inks = np.asarray(inks, np.float64)
    cyan, magenta, yellow, black = (inks[..., i] for i in range(4))
    lightness = 94 * (1 - 0.42 * cyan) * (1 - 0.45 * magenta) * (1 - 0.1 * yellow) * (1 - 0.85 * black)
    fade = 1 - 0.8 * black
    red_green = (1 - 30 * cyan + 55 * magenta - 4 * yellow) * fade
    yellow_blue = (4 - 35 * cyan - 8 * magenta + 65 * yellow) * fade
    return np.stack([lightness, 0.8 * red_green, 0.8 * yellow_blue], axis=-1)


def cmyk_profile(grid: int = 9) -> bytes:
    """Return a printer's profile with a table of 16 bits from inks to L*, a*, b*."""
    levels = np.linspace(0, 1, grid)
    lab = cmyk_colours(np.stack(np.meshgrid(levels, levels, levels, levels, indexing="ij"), axis=-1))
    # The 16-bit encoding of version 2: L* up to 100 is FF00, a* and b* are offset by 128.
    encoded = np.stack([lab[..., 0] * 652.8, (lab[..., 1] + 128) * 256, (lab[..., 2] + 128) * 256], axis=-1)
    table = np.clip(np.round(encoded), 0, 65535).astype(">u2").tobytes()
    ramp = struct.pack(">2H", 0, 65535)
    identity = b"".join(fixed(v) for v in (1, 0, 0, 0, 1, 0, 0, 0, 1))
    head = b"mft2\0\0\0\0" + bytes([4, 3, grid, 0]) + identity + struct.pack(">2H", 2, 2)
    lut = head + 4 * ramp + table + 3 * ramp
    return profile(b"prtr", b"CMYK", b"Lab ", {b"A2B0": lut, b"A2B1": lut})


# Camera marks --------------------------------------------------------------------------------------------------------------------


def exif(orientation: int | None = None, adobe_rgb: str | None = None) -> bytes:
    """Return EXIF as a little-endian TIFF: an orientation, and Adobe RGB as cameras mark it.

    `adobe_rgb` is "uncalibrated" (ColorSpace FFFF with the interoperability index R03), "two" (ColorSpace 2), or "unknown"
    (FFFF alone, which says only that it is not sRGB).
    """

    def directory(entries: list[tuple[int, int, int, bytes]]) -> bytes:
        rows = b"".join(struct.pack("<HHI", tag, kind, count) + value.ljust(4, b"\0") for tag, kind, count, value in entries)
        return struct.pack("<H", len(entries)) + rows + bytes(4)

    main: list[tuple[int, int, int, bytes]] = []
    if orientation is not None:
        main.append((0x0112, 3, 1, struct.pack("<H", orientation)))
    rest = b""
    if adobe_rgb is not None:
        at = 8 + 2 + 12 * (len(main) + 1) + 4
        main.append((0x8769, 4, 1, struct.pack("<I", at)))
        space = 2 if adobe_rgb == "two" else 0xFFFF
        entries = [(0xA001, 3, 1, struct.pack("<H", space))]
        if adobe_rgb != "uncalibrated":
            rest = directory(entries)
        else:
            after = at + 2 + 12 * 2 + 4
            rest = directory([*entries, (0xA005, 4, 1, struct.pack("<I", after))]) + directory([(1, 2, 4, b"R03\0")])
    return b"II*\0\x08\0\0\0" + directory(main) + rest


def stored(upright: Samples, orientation: int) -> Samples:
    """Return an image (height, width, ...) as a file with this orientation stores it."""
    turned = {
        1: lambda a: a,
        2: lambda a: a[:, ::-1],
        3: lambda a: a[::-1, ::-1],
        4: lambda a: a[::-1],
        5: lambda a: np.swapaxes(a, 0, 1),
        6: lambda a: np.rot90(a, 1),
        7: lambda a: np.swapaxes(a[::-1, ::-1], 0, 1),
        8: lambda a: np.rot90(a, -1),
    }[orientation](upright)
    return np.ascontiguousarray(turned)
