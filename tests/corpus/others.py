"""Formats that the core does not read: some by Pillow, in Python; others by nothing here, which are named and refused."""

from __future__ import annotations

import io
import struct
from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

import numpy as np
from PIL import Image
from tests.corpus import colour, png
from tests.corpus import tiff_writer as w
from tests.corpus.case import Case, Drawn, Made
from tests.corpus.colour import by_pillow, fraction, picture, quantised


def saved(container: str, mode: str = "RGB", **named: Any) -> bytes:
    file = io.BytesIO()
    Image.fromarray(quantised(picture(), 8)).convert(mode).save(file, container, **named)
    return file.getvalue()


def lossless(container: str, mode: str = "RGB", **named: Any) -> Made:
    """Return a file whose colours are the picture's."""
    data = saved(container, mode, **named)
    image = Image.fromarray(quantised(picture(), 8)).convert(mode)
    return Made(data, Drawn(colour.luma_of_pil(image.convert("RGB"))), by_pillow(data))


def as_pillow_reads(container: str, mode: str = "RGB", **named: Any) -> Made:
    data = saved(container, mode, **named)
    return Made(data, Drawn(colour.luma_of_pil(Image.open(io.BytesIO(data)).convert("RGBA"))))


def animated_gif() -> Made:
    frames = [Image.fromarray(quantised(values, 8)).quantize(200) for values in (picture(), 1 - picture())]
    file = io.BytesIO()
    frames[0].save(file, "gif", save_all=True, append_images=frames[1:])
    return Made(file.getvalue(), Drawn(by_pillow(file.getvalue())))


def transparent_gif() -> Made:
    return as_pillow_reads("gif", "P", transparency=3)


def deep_grey() -> Made:
    """Return a PGM of 16 bits."""
    samples = quantised(colour.grey_picture(), 16)
    data = f"P5\n{colour.WIDTH} {colour.HEIGHT}\n65535\n".encode() + samples.astype(">u2").tobytes()
    return Made(data, Drawn(fraction(samples, 16)))


def case(name: str, container: str, pixel_type: str, make: Callable[..., Made], *arguments: Any, **named: Any) -> Case:
    return Case(name, container, pixel_type, lambda: make(*arguments, **named))


def cases() -> list[Case]:
    """Return all cases of formats that Pillow reads."""
    return [
        case("gif", "GIF", "palette", as_pillow_reads, "gif"),
        case("gif_transparent", "GIF", "palette with transparency", transparent_gif),
        case("gif_animated", "GIF", "animation, the first frame", animated_gif),
        case("bmp_rgb", "BMP", "8-bit RGB", lossless, "bmp"),
        case("bmp_grey", "BMP", "8-bit grey", lossless, "bmp", "L"),
        case("bmp_palette", "BMP", "palette", lossless, "bmp", "P"),
        case("bmp_bilevel", "BMP", "1 bit", lossless, "bmp", "1"),
        case("ppm", "PNM", "8-bit RGB", lossless, "ppm"),
        case("pgm", "PNM", "8-bit grey", lossless, "ppm", "L"),
        case("pbm", "PNM", "1 bit", lossless, "ppm", "1"),
        case("pgm16", "PNM", "16-bit grey", deep_grey),
        case("jpeg2000", "JPEG 2000", "8-bit RGB", lossless, "jpeg2000"),
        case("jpeg2000_grey", "JPEG 2000", "8-bit grey", lossless, "jpeg2000", "L"),
        case("avif", "AVIF", "8-bit RGB", as_pillow_reads, "avif", quality=85),
    ]


# Foreign files -------------------------------------------------------------------------------------------------------------------


@dataclass(frozen=True)
class Foreign:
    """A file that the core does not read, and what its user should hear."""

    name: str
    """With the suffix that it comes with."""
    data: bytes
    words: tuple[str, ...]
    """One of them must be in the message, in any case of letters."""
    by_pillow: bool = False
    """Whether Pillow is asked for it, in Python."""


def boxes(brand: bytes, *compatible: bytes) -> bytes:
    """Return the beginning of a file of ISO's base media format."""
    content = brand + bytes(4) + b"".join(compatible)
    return struct.pack(">I", len(content) + 8) + b"ftyp" + content + b"\0\0\0\x08free" * 20


def camera(
    maker: bytes, model: bytes, signature: bytes = b"II*\0", *, compression: int = 1, below: bool = True, dng: bool = False
) -> bytes:
    """Return a raw file like a TIFF: a thumbnail, and the sensor's samples below it."""
    sensor = w.Page(
        quantised(colour.grey_picture(), 16)[..., np.newaxis], 16, w.CFA, tags={33421: (w.SHORT, [2, 2]), 254: (w.LONG, [0])}
    )
    thumbnail = w.Page(quantised(picture(), 8)[::4, ::4], 8, w.RGB, tags={254: (w.LONG, [1])})
    thumbnail.tags |= {271: (w.ASCII, maker + b"\0"), 272: (w.ASCII, model + b"\0")}
    if compression != 1:
        sensor.tags[259] = (w.SHORT, [compression])
    if dng:
        thumbnail.tags[50706] = (w.BYTE, [1, 4, 0, 0])
    if below:
        thumbnail.tags[330] = (w.LONG, [sensor])
        return signature + w.tiff(thumbnail)[4:]
    return signature + w.tiff(thumbnail, sensor)[4:]


def cr2() -> bytes:
    """Return Canon's older kind: its name follows the header, and the directories follow each other."""
    data = camera(b"Canon", b"Canon EOS 5D", below=False)
    # The pixels of the first image begin where the name should be.
    return data[:8] + b"CR\x02\0" + data[12:]


def cgbi() -> bytes:
    """Return a PNG as Xcode makes it for phones: B, G, R and alpha, without zlib's frame."""
    whole = png.png(np.dstack([quantised(picture(), 8), png.alpha(8)]), 8, png.RGBA)
    return whole[:8] + png.chunk(b"CgBI", b"\x50\0\x20\x02") + whole[8:]


def foreign() -> list[Foreign]:
    """Return files of all formats that are recognised by their first bytes."""
    pointer = b"version https://git-lfs.github.com/spec/v1\noid sha256:" + b"4d7a" * 16 + b"\nsize 84977953\n"
    page = b"<!DOCTYPE html>\n<html><head><title>Not found</title></head><body>Log in</body></html>\n"
    drawing = b'<svg xmlns="http://www.w3.org/2000/svg" width="9" height="9"></svg>\n'
    photoshop = b"8BPS\0\x01" + bytes(6) + b"\0\x03\0\0\0\x46\0\0\0\x5d\0\x08\0\x03" + bytes(40)
    heic = ("HEIC", "HEIF")
    films = ("video", "film", "movie")
    raw = ("raw",)
    return [
        Foreign("photo.heic", boxes(b"heic", b"mif1", b"heic"), heic),
        Foreign("IMG_0001.jpg", boxes(b"heic", b"mif1", b"heic"), heic),
        Foreign("photo.heif", boxes(b"mif1", b"mif1", b"heic"), heic),
        Foreign("sequence.heics", boxes(b"hevc", b"msf1"), heic),
        Foreign("photo.avif", saved("avif"), ("AVIF",), by_pillow=True),
        Foreign("photo.gif", saved("gif"), ("GIF",), by_pillow=True),
        Foreign("photo.bmp", saved("bmp"), ("BMP",), by_pillow=True),
        Foreign("photo.ppm", saved("ppm"), ("PNM", "PPM", "Netpbm"), by_pillow=True),
        Foreign("photo.jp2", saved("jpeg2000"), ("JPEG 2000",), by_pillow=True),
        Foreign("photo.j2k", saved("jpeg2000", no_jp2=True), ("JPEG 2000",), by_pillow=True),
        Foreign("icon.ico", saved("ico"), ("ICO", "icon")),
        Foreign("photo.png", cgbi(), ("CgBI", "Xcode", "iPhone", "iOS", "Apple")),
        Foreign("photo.jxl", b"\xff\x0a" + bytes(range(40)), ("JPEG XL",)),
        Foreign("boxed.jxl", b"\0\0\0\x0cJXL \r\n\x87\n" + boxes(b"jxl "), ("JPEG XL",)),
        Foreign("photo.dng", camera(b"Leica", b"M8", dng=True), ("DNG",)),
        Foreign("photo.cr2", cr2(), raw),
        Foreign("photo.nef", camera(b"NIKON CORPORATION", b"NIKON D90", compression=34713), raw),
        Foreign("photo.arw", camera(b"SONY", b"ILCE-7", compression=32767), raw),
        Foreign("photo.cr3", boxes(b"crx ", b"crx ", b"isom"), raw),
        Foreign("photo.raf", b"FUJIFILMCCD-RAW 0201FF389501X-T1" + bytes(100), raw),
        Foreign("photo.orf", camera(b"OLYMPUS", b"E-M5", b"IIRO"), raw),
        Foreign("photo.rw2", camera(b"Panasonic", b"DMC-GH4", b"IIU\0"), raw),
        Foreign("page.pdf", b"%PDF-1.7\n%\xe2\xe3\xcf\xd3\n1 0 obj\n<<>>\nendobj\n", ("PDF",)),
        Foreign("page.eps", b"%!PS-Adobe-3.0 EPSF-3.0\n%%BoundingBox: 0 0 9 9\n", ("PostScript", "EPS")),
        Foreign("drawing.svg", drawing, ("SVG",)),
        Foreign("headed.svg", b'\xef\xbb\xbf<?xml version="1.0"?>\n<!-- a comment -->\n' + drawing, ("SVG",)),
        Foreign("layers.psd", photoshop, ("Photoshop", "PSD")),
        Foreign("layers.xcf", b"gimp xcf v011\0" + bytes(40), ("GIMP", "XCF")),
        Foreign("scan.dcm", bytes(128) + b"DICM\x02\0\0\0UL\x04\0" + bytes(40), ("DICOM",)),
        Foreign("light.exr", b"\x76\x2f\x31\x01\x02\0\0\0channels\0" + bytes(40), ("OpenEXR", "EXR")),
        Foreign("light.hdr", b"#?RADIANCE\nFORMAT=32-bit_rle_rgbe\n\n-Y 70 +X 93\n", ("Radiance", "HDR")),
        Foreign("film.mp4", boxes(b"isom", b"isom", b"avc1"), (*films, "MP4")),
        Foreign("film.mov", boxes(b"qt  "), (*films, "QuickTime", "MOV")),
        Foreign("photos.zip", b"PK\x03\x04\x14\0\0\0\x08\0" + bytes(40), ("ZIP", "archive")),
        Foreign("pulled.jpg", pointer, ("Git LFS",)),
        Foreign("saved.jpg", page, ("HTML", "web page")),
        Foreign("spaced.png", b"\r\n\n  " + page.replace(b"<!DOCTYPE html>", b"").lower(), ("HTML", "web page")),
        Foreign("notes.jpg", b"This is only a text.\n" * 9, ("not an image",)),
        Foreign("noise.jpg", np.random.default_rng(7).bytes(500), ("not an image",)),
        Foreign("nothing.jpg", b"", ("empty",)),
    ]
