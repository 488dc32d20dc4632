"""A JPEG encoder of the plain kind (baseline, Huffman) that writes every layout of scans, samplings and components.

Encoders that users have write few of them; the standard allows all, and scanners, cameras and old programs have written them.
"""

from __future__ import annotations

import struct
from collections.abc import Iterable, Sequence
from typing import Any

import numpy as np
from numpy.typing import NDArray
from scipy.fft import dctn

Plane = NDArray[np.floating[Any]]

ZIGZAG = sorted(range(64), key=lambda k: (k // 8 + k % 8, k // 8 if (k // 8 + k % 8) % 2 else k % 8))
"""Position in a block, row by row, of the k-th coefficient."""

# Figures of the standard's annex K.3: how many codes there are of each length, and what they stand for.
DC_COUNTS = (0, 1, 5, 1, 1, 1, 1, 1, 1, 0, 0, 0, 0, 0, 0, 0)
DC_VALUES = tuple(range(12))
AC_COUNTS = (0, 2, 1, 3, 3, 2, 4, 3, 5, 5, 4, 4, 0, 0, 1, 125)
AC_VALUES = tuple(
    bytes.fromhex(
        "01020300041105122131410613516107227114328191a1082342b1c11552d1f02433627282090a161718191a25262728292a3435363738393a4344454647"
        "48494a535455565758595a636465666768696a737475767778797a838485868788898a92939495969798999aa2a3a4a5a6a7a8a9aab2b3b4b5b6b7b8b9ba"
        "c2c3c4c5c6c7c8c9cad2d3d4d5d6d7d8d9dae1e2e3e4e5e6e7e8e9eaf1f2f3f4f5f6f7f8f9fa"
    )
)


def codes(counts: Sequence[int], values: Sequence[int]) -> dict[int, tuple[int, int]]:
    """Return the Huffman code and its length by value."""
    table, code, k = {}, 0, 0
    for length, count in enumerate(counts, 1):
        for _ in range(count):
            table[values[k]] = (code, length)
            code, k = code + 1, k + 1
        code <<= 1
    return table


DC, AC = codes(DC_COUNTS, DC_VALUES), codes(AC_COUNTS, AC_VALUES)


def segment(marker: int, content: bytes) -> bytes:
    return struct.pack(">BBH", 0xFF, marker, len(content) + 2) + content


class Bits:
    """Entropy-coded data."""

    def __init__(self) -> None:
        self.bits: list[str] = []

    def put(self, value: int, length: int) -> None:
        if length:
            self.bits.append(format(value, f"0{length}b"))

    def number(self, value: int) -> None:
        """Add the bits that tell a value from others of its size."""
        size = abs(value).bit_length()
        self.put(value if value > 0 else value + (1 << size) - 1, size)

    def done(self) -> bytes:
        text = "".join(self.bits)
        self.bits = []
        text += "1" * (-len(text) % 8)
        return int(text, 2).to_bytes(len(text) // 8, "big").replace(b"\xff", b"\xff\0") if text else b""


def coefficients(plane: Plane, across: int, down: int, step: int) -> NDArray[np.int64]:
    """Return the quantised coefficients of so many blocks of a plane with values up to 255, its edges repeated outwards."""
    padded = np.pad(plane, [(0, 8 * down - plane.shape[0]), (0, 8 * across - plane.shape[1])], mode="edge")
    blocks = padded.reshape(down, 8, across, 8).swapaxes(1, 2) - 128.0
    found: NDArray[np.int64] = np.round(dctn(blocks, axes=(2, 3), norm="ortho") / step).astype(np.int64)
    return found.reshape(down, across, 64)


def shrunk(plane: Plane, across: int, down: int) -> Plane:
    """Return a plane with every so many columns and rows averaged."""
    height, width = plane.shape
    padded = np.pad(plane, [(0, -height % down), (0, -width % across)], mode="edge")
    small: Plane = padded.reshape(padded.shape[0] // down, down, -1, across).mean(axis=(1, 3))
    return small


def encode(
    planes: Sequence[Plane],
    sampling: Sequence[tuple[int, int]],
    scans: Iterable[Sequence[int]] | None = None,
    *,
    step: int = 3,
    restart: int = 0,
    before: bytes = b"",
    names: Sequence[int] = (1, 2, 3, 4),
    dnl: bool = False,
    frame: int = 0xC0,
) -> bytes:
    """Return a JPEG of planes of full size with values up to 255.

    `sampling` has each component's horizontal and vertical factors, `scans` the components of each scan (all in one if None),
    `restart` is the restart interval, `before` what follows the start of the image, `dnl` leaves the height to a marker after the
    first scan.
    """
    height, width = planes[0].shape
    most_across, most_down = (max(factors[i] for factors in sampling) for i in range(2))
    units_across, units_down = -(-width // (8 * most_across)), -(-height // (8 * most_down))
    blocks, sizes = [], []
    for plane, (across, down) in zip(planes, sampling, strict=True):
        small = resized(plane, across, most_across, down, most_down)
        sizes.append((-(-small.shape[1] // 8), -(-small.shape[0] // 8)))
        blocks.append(coefficients(small, units_across * across, units_down * down, step))

    data = b"\xff\xd8" + before + segment(0xDB, bytes([0]) + bytes([step] * 64))
    parts = b"".join(bytes([names[i], 16 * a + d, 0]) for i, (a, d) in enumerate(sampling))
    data += segment(frame, struct.pack(">BHHB", 8, 0 if dnl else height, width, len(planes)) + parts)
    data += segment(0xC4, bytes([0x00, *DC_COUNTS, *DC_VALUES])) + segment(0xC4, bytes([0x10, *AC_COUNTS, *AC_VALUES]))
    if restart:
        data += segment(0xDD, struct.pack(">H", restart))
    for number, scan in enumerate([range(len(planes))] if scans is None else scans):
        data += segment(0xDA, bytes([len(scan)]) + b"".join(bytes([names[i], 0]) for i in scan) + bytes([0, 63, 0]))
        if len(scan) == 1:
            across, down = sizes[scan[0]]
            units = [[(scan[0], y, x)] for y in range(down) for x in range(across)]
        else:
            units = [
                [
                    (i, y * sampling[i][1] + v, x * sampling[i][0] + h)
                    for i in scan
                    for v in range(sampling[i][1])
                    for h in range(sampling[i][0])
                ]
                for y in range(units_down)
                for x in range(units_across)
            ]
        data += entropy_coded(units, blocks, restart)
        if dnl and number == 0:
            data += segment(0xDC, struct.pack(">H", height))
    return data + b"\xff\xd9"


def resized(plane: Plane, across: int, most_across: int, down: int, most_down: int) -> Plane:
    """Return a plane as large as its factors make it: whole ratios only, so that every reader means the same by them."""
    assert most_across % across == 0
    assert most_down % down == 0
    return shrunk(plane, most_across // across, most_down // down)


def entropy_coded(units: list[list[tuple[int, int, int]]], blocks: list[NDArray[np.int64]], restart: int) -> bytes:
    """Return the data of a scan: `units` lists each unit's blocks as component, row and column."""
    bits, data, before = Bits(), b"", [0] * len(blocks)
    for k, unit in enumerate(units):
        if restart and k and k % restart == 0:
            data += bits.done() + bytes([0xFF, 0xD0 + (k // restart - 1) % 8])
            before = [0] * len(blocks)
        for component, row, column in unit:
            block = blocks[component][row, column]
            difference = int(block[0]) - before[component]
            before[component] = int(block[0])
            bits.put(*DC[abs(difference).bit_length()])
            bits.number(difference)
            zeros = 0
            last = max((i for i in range(1, 64) if block[ZIGZAG[i]]), default=0)
            for i in range(1, last + 1):
                value = int(block[ZIGZAG[i]])
                if value == 0:
                    zeros += 1
                    continue
                for _ in range(zeros // 16):
                    bits.put(*AC[0xF0])
                bits.put(*AC[16 * (zeros % 16) + abs(value).bit_length()])
                bits.number(value)
                zeros = 0
            if last < 63:
                bits.put(*AC[0])
    return data + bits.done()
