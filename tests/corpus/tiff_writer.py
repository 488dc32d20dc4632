"""A TIFF writer for every layout of samples, byte order, compression and directory."""

from __future__ import annotations

import io
import lzma
import struct
import zlib
from collections.abc import Sequence
from dataclasses import dataclass, field
from typing import Any, Literal

import imagecodecs
import numpy as np
from numpy.typing import NDArray
from PIL import Image
from tests.corpus import baseline
from tests.corpus.colour import Samples

NONE, RLE, GROUP3, GROUP4, LZW, OLD_JPEG, JPEG, DEFLATE = 1, 2, 3, 4, 5, 6, 7, 8
OLD_DEFLATE, PACKBITS, LZMA, ZSTD, WEBP = 32946, 32773, 34925, 50000, 50001
WHITE_IS_ZERO, BLACK_IS_ZERO, RGB, PALETTE, MASK, CMYK, YCBCR, LAB, ICC_LAB = 0, 1, 2, 3, 4, 5, 6, 8, 9
CFA, LINEAR_RAW = 32803, 34892
UNSIGNED, SIGNED, FLOAT = 1, 2, 3
ASSOCIATED, UNASSOCIATED, UNSPECIFIED = 1, 2, 0

BYTE, ASCII, SHORT, LONG, RATIONAL, UNDEFINED, IFD = 1, 2, 3, 4, 5, 7, 13
REVERSED = bytes(int(f"{i:08b}"[::-1], 2) for i in range(256))

Order = Literal["<", ">"]
Tag = tuple[int, Any]
"""The type of a tag and its values: bytes, numbers or pairs of them, pages (sub-directories), or tags (a directory of EXIF)."""


@dataclass
class Page:
    """An image of a file, and how it is stored."""

    samples: Samples
    """(height, width, channels), unsigned of `bits` bits, signed, or floats."""
    bits: int
    photometric: int
    compression: int = NONE
    predictor: int = 1
    planar: int = 1
    tile: tuple[int, int] | None = None
    """Width and height of the tiles; strips if None."""
    rows: int = 16
    """Of a strip."""
    extra: Sequence[int] = ()
    """What the last channels are."""
    fill: int = 1
    sampling: tuple[int, int] = (1, 1)
    """Of Y', beside Cb and Cr."""
    shared_tables: bool = True
    """Whether JPEG's tables stand in a tag of their own."""
    tags: dict[int, Tag] = field(default_factory=dict)
    without: Sequence[int] = ()
    """Tags that are left out."""


def pieces(page: Page) -> list[Samples]:
    """Return the strips or tiles, (rows, columns, channels), in their order in the file."""
    planes = [page.samples] if page.planar == 1 else list(np.moveaxis(page.samples, 2, 0)[..., np.newaxis])
    found = []
    for plane in planes:
        height, width = plane.shape[:2]
        if page.tile is None:
            found += [plane[y : y + page.rows] for y in range(0, height, page.rows)]
            continue
        across, down = page.tile
        # Black, so that it shows where it should not, but where it would stain colours of fewer samples than pixels.
        mode: Any = "edge" if page.photometric == YCBCR else "constant"
        padded = np.pad(plane, [(0, -height % down), (0, -width % across), (0, 0)], mode=mode)
        found += [padded[y : y + down, x : x + across] for y in range(0, height, down) for x in range(0, width, across)]
    return found


def packed(samples: Samples, bits: int, order: Order) -> NDArray[np.uint8]:
    """Return rows of bytes, (rows, bytes)."""
    flat = samples.reshape(samples.shape[0], -1)
    if bits in {8, 16, 32, 64}:
        return flat.astype(flat.dtype.newbyteorder(order)).view(np.uint8)
    places = np.arange(bits - 1, -1, -1)
    return np.packbits(((flat[..., np.newaxis] >> places) & 1).astype(np.uint8).reshape(len(flat), -1), axis=1)


def differences(samples: Samples) -> Samples:
    """Return every sample less its left neighbour: predictor 2."""
    result = samples.copy()
    result[:, 1:] -= samples[:, :-1]
    return result


def float_differences(samples: Samples) -> NDArray[np.uint8]:
    """Return rows of bytes, the highest of all samples first, less their left neighbours: predictor 3."""
    height, width, channels = samples.shape
    size = samples.dtype.itemsize
    big = samples.astype(samples.dtype.newbyteorder(">")).view(np.uint8).reshape(height, width * channels, size)
    ordered = np.moveaxis(big, 2, 1).reshape(height, -1)
    left = np.pad(ordered, [(0, 0), (channels, 0)])[:, : ordered.shape[1]]
    return ordered - left


def subsampled(samples: Samples, across: int, down: int) -> NDArray[np.uint8]:
    """Return rows of the units of Y', Cb, Cr: of a block of Y' all, and one of each other."""
    height, width = samples.shape[:2]
    padded = np.pad(samples, [(0, -height % down), (0, -width % across), (0, 0)], mode="edge").astype(np.float64)
    blocks = padded.reshape(padded.shape[0] // down, down, -1, across, 3).swapaxes(1, 2)
    luma = blocks[..., 0].reshape(*blocks.shape[:2], -1)
    units = np.concatenate([luma, np.round(blocks[..., 1:].mean(axis=(2, 3)))], axis=2)
    return units.astype(np.uint8).reshape(len(units), -1)


def jpeg_parts(page: Page, samples: Samples) -> tuple[bytes, bytes]:
    """Return the tables and the stream of a strip or tile; the stream has them too where they are not shared."""
    planes = [samples[..., i].astype(np.float64) for i in range(samples.shape[2])]
    factors = [page.sampling] + [(1, 1)] * (len(planes) - 1)
    data = baseline.encode(planes, factors, step=2)
    start, end = data.index(b"\xff\xdb"), data.index(b"\xff\xda")
    frame = data.index(b"\xff\xc0")
    frame_end = frame + 2 + int.from_bytes(data[frame + 2 : frame + 4], "big")
    tables = b"\xff\xd8" + data[start:frame] + data[frame_end:end] + b"\xff\xd9"
    if not page.shared_tables:
        return b"", data
    return tables, data[:start] + data[frame:frame_end] + data[end:]


def compressed(page: Page, samples: Samples, order: Order) -> bytes:
    """Return the bytes of a strip or tile."""
    if page.compression == JPEG:
        return jpeg_parts(page, samples)[1]
    if page.compression == WEBP:
        return bytes(imagecodecs.webp_encode(np.ascontiguousarray(samples), level=80, lossless=True))
    if page.compression in {RLE, GROUP3, GROUP4}:
        data = fax(page, samples)
    else:
        if page.sampling != (1, 1):
            rows = subsampled(samples, *page.sampling)
        elif page.predictor == 3:
            rows = float_differences(samples)
        else:
            rows = packed(differences(samples) if page.predictor == 2 else samples, page.bits, order)
        if page.compression == PACKBITS:
            data = b"".join(bytes(imagecodecs.packbits_encode(row.tobytes())) for row in rows)
        else:
            raw = rows.tobytes()
            data = {
                NONE: lambda: raw,
                LZW: lambda: bytes(imagecodecs.lzw_encode(raw)),
                DEFLATE: lambda: zlib.compress(raw),
                OLD_DEFLATE: lambda: zlib.compress(raw),
                LZMA: lambda: lzma.compress(raw),
                ZSTD: lambda: bytes(imagecodecs.zstd_encode(raw)),
            }[page.compression]()
    return data.translate(REVERSED) if page.fill == 2 else data


def fax(page: Page, samples: Samples) -> bytes:
    """Return rows of bits as a fax: 0 is white in all three codings, whatever the photometric tag makes of it."""
    names = {RLE: "tiff_ccitt", GROUP3: "group3", GROUP4: "group4"}
    file = io.BytesIO()
    options = page.tags.get(292, (LONG, [0]))[1][0]
    # Pillow writes white as 1, with a tag that says so, and libtiff codes bits as they are.
    image = Image.fromarray(samples[..., 0].astype(bool))
    info: dict[int, Any] = {278: image.height}
    if page.compression == GROUP3:
        info[292] = options
    image.save(file, "tiff", compression=names[page.compression], tiffinfo=info)
    written = Image.open(io.BytesIO(file.getvalue()))
    tags: Any = getattr(written, "tag_v2")  # noqa: B009  # of TIFF files only
    (start,), (count,) = tags[273], tags[279]
    return file.getvalue()[start : start + count]


class Writer:
    """The bytes of a file as they grow."""

    def __init__(self, order: Order, big: bool) -> None:
        self.order, self.big = order, big
        self.data = bytearray(b"II" if order == "<" else b"MM")
        self.data += self.pack("HHHQ", 43, 8, 0, 0) if big else self.pack("HI", 42, 0)

    def pack(self, form: str, *values: Any) -> bytes:
        return struct.pack(self.order + form, *values)

    def append(self, content: bytes) -> int:
        """Add bytes at an even place, and return it."""
        self.data += bytes(len(self.data) % 2)
        at = len(self.data)
        self.data += content
        return at

    def value(self, kind: int, values: Any) -> tuple[int, int, bytes]:
        """Return the type, the count and the bytes of a tag."""
        if isinstance(values, bytes):
            return kind, len(values), values
        if isinstance(values, dict):
            values = [self.directory(values, None)]
        elif values and isinstance(values[0], Page):
            values = [self.page(page) for page in values]
        if kind in {LONG, IFD} and self.big and any(v > 0xFFFF_FFFF for v in values):
            kind = 16
        if kind == RATIONAL:
            return kind, len(values), b"".join(self.pack("II", *pair) for pair in values)
        form = {BYTE: "B", SHORT: "H", LONG: "I", IFD: "I", 16: "Q"}[kind]
        return kind, len(values), self.pack(f"{len(values)}{form}", *values)

    def directory(self, tags: dict[int, Tag], link: int | None) -> int:
        """Add a directory, let the place of a link point to it, and return its own place."""
        room = 8 if self.big else 4
        entries = b""
        for tag, (kind, values) in sorted(tags.items()):
            kind, count, content = self.value(kind, values)  # noqa: PLW2901
            head = self.pack("HHQ" if self.big else "HHI", tag, kind, count)
            if len(content) > room:
                content = self.pack("Q" if self.big else "I", self.append(content))
            entries += head + content.ljust(room, b"\0")
        at = self.append(self.pack("Q" if self.big else "H", len(tags)) + entries)
        self.next_link = len(self.data)
        self.data += bytes(room)
        if link is not None:
            self.data[link : link + room] = self.pack("Q" if self.big else "I", at)
        return at

    def page(self, page: Page, link: int | None = None) -> int:
        """Add an image and its directory."""
        contents = [compressed(page, part, self.order) for part in pieces(page)]
        starts = [self.append(content) for content in contents]
        return self.directory(tags_of(page, starts, [len(content) for content in contents]), link)


def tags_of(page: Page, starts: list[int], counts: list[int]) -> dict[int, Tag]:
    """Return an image's directory, where its strips or tiles are and how long."""
    height, width, channels = page.samples.shape
    tags: dict[int, Tag] = {
        256: (LONG, [width]),
        257: (LONG, [height]),
        258: (SHORT, [page.bits] * channels),
        259: (SHORT, [page.compression]),
        262: (SHORT, [page.photometric]),
        277: (SHORT, [channels]),
        284: (SHORT, [page.planar]),
    }
    kind = {"u": UNSIGNED, "i": SIGNED, "f": FLOAT}[page.samples.dtype.kind]
    if kind != UNSIGNED:
        tags[339] = (SHORT, [kind] * channels)
    if page.fill != 1:
        tags[266] = (SHORT, [page.fill])
    if page.predictor != 1:
        tags[317] = (SHORT, [page.predictor])
    if page.extra:
        tags[338] = (SHORT, list(page.extra))
    if page.photometric == YCBCR:
        tags[530] = (SHORT, list(page.sampling))
    if page.compression == JPEG and page.shared_tables:
        tags[347] = (UNDEFINED, jpeg_parts(page, pieces(page)[0])[0])
    if page.tile is None:
        tags |= {273: (LONG, starts), 279: (LONG, counts), 278: (LONG, [page.rows])}
    else:
        tags |= {324: (LONG, starts), 325: (LONG, counts), 322: (LONG, [page.tile[0]]), 323: (LONG, [page.tile[1]])}
    return {tag: value for tag, value in (tags | page.tags).items() if tag not in page.without}


def tiff(*pages: Page, order: Order = "<", big: bool = False) -> bytes:
    """Return a file of images, their pixels before their directories."""
    writer = Writer(order, big)
    link = 8 if big else 4
    for page in pages:
        writer.page(page, link)
        link = writer.next_link
    return bytes(writer.data)


def directory_first(page: Page) -> bytes:
    """Return a file of one image whose directory comes before its pixels."""
    contents = [compressed(page, part, "<") for part in pieces(page)]
    counts = [len(content) for content in contents]
    size = 0
    # Once for its length, once with the places that follow from it.
    for _ in range(2):
        starts = [size + sum(counts[:i]) for i in range(len(counts))]
        writer = Writer("<", big=False)
        writer.directory(tags_of(page, starts, counts), 4)
        size = len(writer.data)
    return bytes(writer.data) + b"".join(contents)
