"""The speeds and sizes that are to be reached, measured and printed as one table: `python benches/ratios.py`.

Times are ratios of two that are measured in turn in one process, or of two commands in turn, so that what else the machine does
meets both; each is a median. Every size and every peak of memory is that of a fresh process. Missing a limit is printed and
fails nothing.

The photo is the made-up one of the Rust benchmarks at one megapixel; density is 1, with 0.3 nodes a pixel, unless a line says else.
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
from measured import measure
from PIL import Image

import graphstipple as gs
from graphstipple import _core

ROOT = Path(__file__).resolve().parents[1]
OPTIONS = {"density": 1.0, "nodes_per_pixel": 0.3}
LIMIT = 600
"""Seconds after which a command is stopped."""


@dataclass(frozen=True)
class Sizes:
    """What is measured at which size, and how often."""

    one: tuple[int, int] = (1152, 864)
    sixteen: tuple[int, int] = (4608, 3456)
    twenty_four: tuple[int, int] = (6000, 4000)
    runs: int = 7
    runs_at_sixteen: int = 3


TINY = Sizes((40, 30), (80, 60), (96, 64), 1, 1)


@dataclass(frozen=True)
class Figure:
    """A line of the table; without a limit it only says how things are."""

    title: str
    value: float
    digits: int = 2
    at_most: float | None = None
    at_least: float | None = None
    note: str = ""

    def __str__(self) -> str:
        shown, verdict = "", ""
        if self.at_most is not None:
            shown, verdict = f"<= {self.at_most:.3g}", "met" if self.value <= self.at_most else "missed"
        elif self.at_least is not None:
            shown, verdict = f">= {self.at_least:g}", "met" if self.value >= self.at_least else "missed"
        return f"{self.title:<58}{self.value:>10.{self.digits}f}{shown:>10}  {verdict:<8}{self.note}".rstrip()


class Benches:
    """The Rust benchmarks as programs: those of a release build, or of a test build, which a smoke run makes do with."""

    def __init__(self, is_smoke_run: bool) -> None:
        # The packages of `make test`, so that nothing is built twice.
        test = ["test", "--workspace", "--exclude", "graphstipple-py"]
        self._command = ["cargo", *(test if is_smoke_run else ["bench", "--package", "graphstipple-bench"]), "--quiet", "--locked"]

    def run(self, bench: str, *arguments: object) -> list[list[str]]:
        """Return the lines that one writes, cut at tabs."""
        command = [*self._command, "--bench", bench, "--", *map(str, arguments)]
        try:
            done = subprocess.run(command, cwd=ROOT, stdout=subprocess.PIPE, text=True, check=True)
        except subprocess.CalledProcessError as error:
            sys.exit(f"the benchmark {bench} failed: {error}")
        return [line.split("\t") for line in done.stdout.splitlines() if line]

    def scale(self, size: tuple[int, int], runs: int, *nodes: object) -> dict[str, float]:
        """Return the medians of drawings of the made-up photo in a process of its own."""
        return {name: float(value) for name, value in self.run("scale", "--bare", *size, runs, *nodes)}


def core(benches: Benches, sizes: Sizes) -> list[Figure]:
    """Photo and map to drawing, beside spade, and how it grows in time and memory."""
    nodes = tuple(OPTIONS.values())
    one = benches.scale(sizes.one, sizes.runs, *nodes)
    sixteen = benches.scale(sizes.sixteen, sizes.runs_at_sixteen, *nodes)
    large = benches.scale(sizes.twenty_four, 1, *nodes)
    by_default = benches.scale(sizes.twenty_four, 1, "default")
    return [
        Figure(
            "core / spade's bulk load of the same sites",
            one["ratio"],
            at_most=2.5,
            note=f"{one['total']:.3f} s, spade {one['spade']:.3f} s",
        ),
        Figure("core at 16 megapixels / at 1", sixteen["total"] / one["total"], 1, at_most=18, note=f"{sixteen['total']:.2f} s"),
        Figure("24 megapixels: peak memory, GB", _gigabytes(large), at_most=2.4, note=f"{large['total']:.2f} s"),
        Figure(
            "24 megapixels, default budget: peak memory, GB",
            _gigabytes(by_default),
            at_most=1.0,
            note=f"{by_default['total']:.2f} s",
        ),
    ]


def _gigabytes(measures: dict[str, float]) -> float:
    # Only Linux says.
    return measures.get("memory", float("nan")) / 1e9


def python(photo: npt.NDArray[np.uint8], runs: int) -> Figure:
    """`gs.draw`, saliency included, beside OpenCV's saliency alone, in turn in this process."""
    options = gs.Options(**OPTIONS)
    saliency = cv2.saliency.StaticSaliencyFineGrained_create()
    ours, theirs = medians(runs, lambda: gs.draw(photo, options=options), lambda: saliency.computeSaliency(photo))
    return Figure(
        "Python, with saliency / OpenCV's saliency", ours / theirs, at_most=5, note=f"{ours:.3f} s, OpenCV {theirs:.3f} s"
    )


def relabel(photo: npt.NDArray[np.uint8], runs: int) -> Figure:
    """Draw again in a session with another share of the error passed on, beside `gs.draw`, which has to find all; in turn."""
    session = gs.Session(photo)
    options = gs.Options(**OPTIONS)
    others = itertools.cycle([options.replace(base=2 * options.base), options])
    session.draw(options)
    again, whole = medians(runs, lambda: session.draw(next(others)), lambda: gs.draw(photo, options=options))
    note = f"{again:.3f} s; saliency is in the whole"
    return Figure("session redrawn with another base / whole drawing", again / whole, at_most=1 / 3, note=note)


def command(path: Path, runs: int) -> Figure:
    """Run the native binary as a whole process, beside its parts called alone in this one: decoding, saliency, core."""
    binary = Path(os.environ.get("GRAPHSTIPPLE_BINARY", ROOT / "target" / "release" / "graphstipple"))
    flags = [f"--{name.replace('_', '-')}={value}" for name, value in OPTIONS.items()]
    drawn = path.with_suffix(".svg")
    options = gs.Options(**OPTIONS)._json()

    def whole() -> None:
        done = measure([str(binary), str(path), "-o", str(drawn), "--quiet", *flags], LIMIT)
        if done.failure is not None:
            sys.exit(f"the command line failed: {done.failure}")
        seconds.append(done.seconds)

    seconds: list[float] = []
    luma = _core.read_luma(str(path), (255, 255, 255))
    found = _core.saliency(luma)
    decoding, saliency, alone, _ = medians(
        runs,
        lambda: _core.read_luma(str(path), (255, 255, 255)),
        lambda: _core.saliency(luma),
        lambda: _core.draw(luma, "saliency", found, options),
        whole,
    )
    ours = statistics.median(seconds)
    parts = decoding + saliency + alone
    note = f"{ours:.3f} s; decoding {decoding:.3f}, saliency {saliency:.3f}, core {alone:.3f} s"
    return Figure("command line, start to file / decoding + saliency + core", ours / parts, at_most=1.6, note=note)


def threads(benches: Benches) -> list[Figure]:
    """Every stage on one thread and on two."""
    figures = []
    for name, kind, one, two in benches.run("threads", "--bare"):
        at_least = 1.5 if kind == "parallel" else None
        note = f"{kind}; {float(one):.4f} s, {float(two):.4f} s"
        figures.append(Figure(f"one thread / two: {name}", float(one) / float(two), at_least=at_least, note=note))
    return figures


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
    parser = argparse.ArgumentParser(description="Ratios of times, and peaks of memory, beside their limits.")
    parser.add_argument("--smoke", action="store_true", help="tiny photos and single runs: whether this still runs")
    arguments = parser.parse_args()
    sizes = TINY if arguments.smoke else Sizes()
    benches = Benches(arguments.smoke)
    print(f"density {OPTIONS['density']:g}, {OPTIONS['nodes_per_pixel']} nodes a pixel, {os.cpu_count()} processors; ", end="")
    print(f"medians of {sizes.runs} runs, at 16 megapixels {sizes.runs_at_sixteen}, at 24 megapixels 1\n")
    print(f"{'':<58}{'measured':>10}{'limit':>10}", flush=True)
    with TemporaryDirectory() as temporary:
        path = Path(temporary, "photo.png")
        benches.run("scale", "--photo", *sizes.one, path.with_suffix(".pgm"))
        with Image.open(path.with_suffix(".pgm")) as image:
            image.save(path)
            photo = np.asarray(image)
        lines = [
            *core(benches, sizes),
            python(photo, sizes.runs),
            relabel(photo, sizes.runs),
            command(path, sizes.runs),
            *threads(benches),
        ]
    print("\n".join(map(str, lines)))


if __name__ == "__main__":
    main()
