"""What Python and the command line are to reach, beside their parts: `python benches/ratios.py`.

Times are ratios of two that are measured in turn in one process, or of a command and of calls in turn, so that what else the
machine does meets both; each is a median. Missing a limit is printed and fails nothing. What the core is to reach stands below the
tables of `scale.rs` and `threads.rs`.

The photo is the made-up one of the Rust benchmarks at one megapixel; density is 1, with 0.3 nodes a pixel.
"""

from __future__ import annotations

import argparse
import itertools
import os
import statistics
import subprocess
import sys
import time
from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path
from tempfile import TemporaryDirectory

import cv2
import numpy as np
import numpy.typing as npt
from built import ROOT, bench_command, native_binary
from measured import measure
from PIL import Image

import graphstipple as gs
from graphstipple import _core

DENSITY, NODES_PER_PIXEL = 1.0, 0.3
OPTIONS = gs.Options(nodes_per_pixel=NODES_PER_PIXEL, published=gs.Options().published.replace(density=DENSITY))
FLAGS = [f"--nodes-per-pixel={NODES_PER_PIXEL}", f"--published=density={DENSITY}"]
"""The same on the command line."""

LIMIT = 600
"""Seconds after which a command is stopped."""


SIZE, TINY_SIZE = (1152, 864), (40, 30)
RUNS = 7
"""Of every call and command."""


@dataclass(frozen=True)
class Figure:
    """A line of the table."""

    title: str
    value: float
    at_most: float
    note: str

    def __str__(self) -> str:
        shown, verdict = f"<= {self.at_most:.3g}", "met" if self.value <= self.at_most else "missed"
        return f"{self.title:<58}{self.value:>10.2f}{shown:>10}  {verdict:<8}{self.note}"


def write_photo(path: Path, size: tuple[int, int], is_smoke_run: bool) -> npt.NDArray[np.uint8]:
    """Write the made-up photo as a PNG file and return it."""
    grey_map = path.with_suffix(".pgm")
    command = [*bench_command("scale", is_smoke_run), "--quiet", "--", "--photo", *map(str, size), str(grey_map)]
    try:
        subprocess.run(command, cwd=ROOT, stdout=subprocess.DEVNULL, check=True)
    except subprocess.CalledProcessError as error:
        sys.exit(f"the benchmark scale, which has the photo, failed: {error}")
    with Image.open(grey_map) as image:
        image.save(path)
        return np.asarray(image)


def python(photo: npt.NDArray[np.uint8], runs: int) -> Figure:
    """`gs.draw`, saliency included, beside OpenCV's saliency alone, in turn in this process."""
    saliency = cv2.saliency.StaticSaliencyFineGrained_create()
    ours, theirs = medians(runs, lambda: gs.draw(photo, options=OPTIONS), lambda: saliency.computeSaliency(photo))
    return Figure(
        "Python, with saliency / OpenCV's saliency", ours / theirs, at_most=5, note=f"{ours:.3f} s, OpenCV {theirs:.3f} s"
    )


def relabel(photo: npt.NDArray[np.uint8], runs: int) -> Figure:
    """Draw again in a session with another share of the error passed on, beside `gs.draw`, which has to find all; in turn."""
    session = gs.Session(photo)
    others = itertools.cycle([OPTIONS.replace(shading=2 * OPTIONS.shading), OPTIONS])
    session.draw(OPTIONS)
    again, whole = medians(runs, lambda: session.draw(next(others)), lambda: gs.draw(photo, options=OPTIONS))
    note = f"{again:.3f} s; saliency is in the whole"
    return Figure("session redrawn with another shading / whole drawing", again / whole, at_most=1 / 3, note=note)


def command(path: Path, runs: int) -> Figure:
    """Run the native binary as a whole process, beside its parts called alone in this one: decoding; saliency and core."""
    binary = str(native_binary())
    drawn = path.with_suffix(".svg")

    def whole() -> None:
        done = measure([binary, str(path), "-o", str(drawn), "--quiet", *FLAGS], LIMIT)
        if done.failure is not None:
            sys.exit(f"the command line failed: {done.failure}")
        seconds.append(done.seconds)

    seconds: list[float] = []
    reading = _core.Reading((255, 255, 255), OPTIONS._checked, _core.MAX_PIXELS, False)
    photo, _, _ = _core.read_photo(str(path), reading)
    decoding, drawing, _ = medians(
        runs,
        lambda: _core.read_photo(str(path), reading),
        lambda: _core.draw(photo, "saliency", reading, OPTIONS._checked),
        whole,
    )
    ours = statistics.median(seconds)
    note = f"{ours:.3f} s; decoding {decoding:.3f}, saliency and core {drawing:.3f} s"
    title = "command line, start to file / decoding + saliency + core"
    return Figure(title, ours / (decoding + drawing), at_most=1.6, note=note)


def medians(runs: int, *calls: Callable[[], object]) -> list[float]:
    """Return the median seconds of calls that take turns."""
    seconds: list[list[float]] = [[] for _ in calls]
    for _ in range(runs):
        for call, times in zip(calls, seconds, strict=True):
            began = time.perf_counter()
            call()
            times.append(time.perf_counter() - began)
    return [statistics.median(times) for times in seconds]


def main() -> None:
    """Measure and print."""
    parser = argparse.ArgumentParser(description="Ratios of times beside their limits.")
    parser.add_argument("--smoke", action="store_true", help="a tiny photo and single runs: whether this still runs")
    arguments = parser.parse_args()
    size, runs = (TINY_SIZE, 1) if arguments.smoke else (SIZE, RUNS)
    print(f"density {DENSITY:g}, {NODES_PER_PIXEL} nodes a pixel, {os.cpu_count()} processors; ", end="")
    print(f"medians of {runs} runs\n")
    print(f"{'':<58}{'measured':>10}{'limit':>10}", flush=True)
    with TemporaryDirectory() as temporary:
        path = Path(temporary, "photo.png")
        photo = write_photo(path, size, arguments.smoke)
        lines = [python(photo, runs), relabel(photo, runs), command(path, runs)]
    print("\n".join(map(str, lines)))


if __name__ == "__main__":
    main()
