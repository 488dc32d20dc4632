"""Our command line beside stipplers and tracers that people use, in one run: `python benches/peers.py`.

Peers are two stipplers of PyPI, inksep and stippler; a textbook weighted Voronoi stippling (Secord 2002), the evaluation's, whose
nearest dots are found by SciPy's k-d tree on all processors; and two tracers, which draw no tone: potrace and vtracer. What is
missing is put into a folder of its own, out/peers, and never into the project's environment: from PyPI by pip, from Debian by
unpacking a package. What cannot be had, fails or takes longer than the limit is named with its reason, and the rest goes on.

Every run is a process of its own. Its seconds are those of the whole command, from its start to its end: start (of Python too,
where the program is a Python one), decoding, drawing, writing an SVG file. All read the same 8-bit grey photo. potrace knows no
grey and is run twice: behind mkbitmap, which comes with it to make bitmaps of photos (given as PGM, since it reads no PNG), and
alone, on a bitmap made before, cut at Otsu's threshold. Programs take turns, so that what else the machine does meets all of them;
one whose first run is slow has no second.

Stipplers make files with as many written coordinate pairs as our default drawing of the photo has. A circle is one pair; the
dots of stippler are polygons of 16, so it has a sixteenth of the dots, which makes it faster.
"""

from __future__ import annotations

import argparse
import json
import os
import re
import shlex
import statistics
import sys
from collections.abc import Callable, Sequence
from dataclasses import dataclass, field, replace
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import Any

import numpy as np
import numpy.typing as npt
import skimage.data
from built import ROOT, native_binary
from measured import Measured, measure
from PIL import Image
from scipy.spatial import KDTree

import graphstipple as gs
from graphstipple_eval import installation
from graphstipple_eval.baselines import dots, programs, weighted_voronoi
from graphstipple_eval.baselines.density import Density

FOLDER = ROOT / "out" / "peers"

PHOTOS = ("astronaut", "camera", "chelsea", "coffee", "rocket")
LARGE, LARGE_SIZE = "coffee-12MP", (4000, 3000)
"""An upscale of the middle of coffee."""

TINY, TINY_WIDTH, TINY_COORDINATES = "tiny", 96, 400
"""What a smoke run draws: a small coffee, by stipplers with so many coordinates."""

STIPPLER_VERTICES = 16
"""Vertices of a dot of stippler: its default."""

LEAST_GAIN, MOST_LOSS = 20.0, 5.0
"""To reach: how many times as long as we every stippler takes, and how many times as long as every tracer we may take."""

VTRACER = "import sys, vtracer; vtracer.convert_image_to_svg_py(sys.argv[1], sys.argv[2], colormode='binary')"


@dataclass(frozen=True)
class Work:
    """A photo as files.

    Parameters
    ----------
    grey, grey_map, bitmap : Path
        8-bit grey PNG, the same as PGM, and PBM.
    svg : Path
        What is to be written.
    coordinates : int
        Coordinate pairs that stipplers write.
    """

    grey: Path
    grey_map: Path
    bitmap: Path
    svg: Path
    coordinates: int


@dataclass(frozen=True)
class Program:
    """Ours or a peer: `command` is what is measured, `missing` why there is none."""

    name: str
    kind: str
    command: Callable[[Work], list[str]]
    missing: str | None = None


@dataclass
class Row:
    """What a program did with a photo."""

    program: Program
    runs: list[Measured] = field(default_factory=list)
    marks: int = 0
    points: int = 0
    size: int = 0
    failure: str | None = None

    @property
    def seconds(self) -> float:
        """Median of the runs."""
        return statistics.median(run.seconds for run in self.runs)

    @property
    def is_timed_out(self) -> bool:
        """Whether it was stopped, so that its seconds are the limit."""
        return bool(self.failure and self.failure.startswith("stopped"))


# Peers and where they come from ---------------------------------------------------------------------------------------------------


def find_peers(may_install: bool) -> list[Program]:
    """Return the peers; those that are missing say why."""
    folder = installation.Folder(FOLDER, None if may_install else "a smoke run installs nothing")

    def inksep(work: Work) -> list[str]:
        darkness = 1 - gs.stages.tone(work.grey).astype(np.float64)
        options = programs.inksep_options(darkness, work.coordinates)
        return programs.inksep_command(str(folder.find("inksep")), work.grey, work.svg, options)

    def stippler(work: Work) -> list[str]:
        count = max(1, work.coordinates // STIPPLER_VERTICES)
        command = [str(folder.find("stippler")), str(work.grey), "--n_point", str(count), "--seed", "1"]
        return [*command, "--out", str(work.svg)]

    def textbook(work: Work) -> list[str]:
        return [sys.executable, __file__, "--textbook", str(work.grey), str(work.svg), str(work.coordinates)]

    def trace(work: Work) -> list[str]:
        return [*folder.environment, *programs.potrace_command(str(folder.find("potrace")), str(work.bitmap), str(work.svg))]

    def make_bitmap_and_trace(work: Work) -> list[str]:
        first = [str(folder.find("mkbitmap")), "--output", "-", str(work.grey_map)]
        second = programs.potrace_command(str(folder.find("potrace")), "-", str(work.svg))
        return [*folder.environment, "sh", "-c", f"{shlex.join(first)} | {shlex.join(second)}"]

    def vtracer(work: Work) -> list[str]:
        return [str(folder.python), "-c", VTRACER, str(work.grey), str(work.svg)]

    missing_potrace = folder.missing("potrace")
    return [
        Program("inksep", "stippler", inksep, folder.missing("inksep")),
        Program("stippler", "stippler", stippler, folder.missing("stippler")),
        Program("textbook", "stippler", textbook),
        Program("mkbitmap", "tracer", make_bitmap_and_trace, missing_potrace),
        Program("potrace", "tracer", trace, missing_potrace),
        Program("vtracer", "tracer", vtracer, folder.missing("vtracer")),
    ]


def our_program() -> Program:
    """Return the native binary."""
    binary = str(native_binary())
    return Program("graphstipple", "ours", lambda work: [binary, str(work.grey), "-o", str(work.svg), "--stats"])


class TreeDensity(Density):
    """The evaluation's density, but the nearest site of every sample is found in a k-d tree and not by us."""

    def owners(self, sites: npt.NDArray[np.float64]) -> npt.NDArray[np.integer[Any]]:
        """Return the number of the nearest of the sites, (n, 2), for every sample."""
        rows, columns = np.mgrid[: self.height * self.samples_per_pixel, : self.width * self.samples_per_pixel]
        samples = (np.stack([columns, rows], axis=-1) + 0.5) / self.samples_per_pixel
        _, owners = KDTree(sites).query(samples, workers=-1)
        return owners


def write_textbook(grey: Path, drawn: Path, coordinates: int) -> None:
    """Stipple a photo to an SVG file by weighted Voronoi stippling."""
    tone = gs.stages.tone(grey)
    placed, _ = weighted_voronoi.place(tone, coordinates, density=TreeDensity)
    height, width = tone.shape
    drawn.write_text(dots.svg(dots.circles(placed), width, height), "utf-8")


# Photos ---------------------------------------------------------------------------------------------------------------------------


def photo(name: str) -> Image.Image:
    """Return a photo in grey."""
    if name in PHOTOS:
        return Image.fromarray(getattr(skimage.data, name)()).convert("L")
    coffee = Image.fromarray(skimage.data.coffee()).convert("L")
    if name == TINY:
        return coffee.resize((TINY_WIDTH, TINY_WIDTH * 2 // 3), Image.Resampling.LANCZOS)
    width = coffee.height * LARGE_SIZE[0] // LARGE_SIZE[1]
    left = (coffee.width - width) // 2
    middle = coffee.crop((left, 0, left + width, coffee.height))
    return middle.resize(LARGE_SIZE, Image.Resampling.LANCZOS)


def prepare(image: Image.Image, folder: Path) -> Work:
    """Write a photo as the files that the programs read; the coordinates are not known yet."""
    work = Work(folder / "grey.png", folder / "grey.pgm", folder / "cut.pbm", folder / "drawn.svg", 0)
    image.save(work.grey)
    image.save(work.grey_map)
    white, _ = programs.otsu_bitmap(gs.stages.tone(work.grey))
    Image.fromarray(white).save(work.bitmap, "PPM")
    return work


# Measuring ------------------------------------------------------------------------------------------------------------------------


def counts(svg: str) -> tuple[int, int]:
    """Return the marks and the coordinate pairs of a peer's SVG: circles, polygons, and outlines of paths."""
    circles = len(re.findall(r"<circle\b", svg))
    polygons = re.findall(r'<polygon[^>]*?\bpoints="([^"]*)"', svg)
    paths = re.findall(r'<path\b[^>]*?\bd="([^"]*)"', svg, re.DOTALL)
    marks = circles + len(polygons) + sum(len(re.findall("[Mm]", path)) for path in paths)
    corners = sum(len(re.findall(programs.NUMBER, polygon)) // 2 for polygon in polygons)
    return marks, circles + corners + sum(map(programs.count_coordinates, paths))


def run_once(row: Row, work: Work, limit: float) -> None:
    """Run a program once and count what it wrote."""
    work.svg.unlink(missing_ok=True)
    run = measure(row.program.command(work), limit)
    row.runs.append(run)
    row.failure = run.failure
    if run.failure is not None:
        return
    if not work.svg.is_file():
        row.failure = "it wrote no file"
        return
    row.size = work.svg.stat().st_size
    if row.program.kind == "ours":
        stats = json.loads(run.stdout)
        row.marks, row.points = stats["stipples"] + stats["regions"], stats["coordinates"]
    else:
        row.marks, row.points = counts(work.svg.read_text("utf-8", errors="replace"))


def measure_photo(name: str, chosen: Sequence[Program], arguments: argparse.Namespace) -> list[Row]:
    """Run all programs on a photo, in turn."""
    with TemporaryDirectory() as temporary:
        image = photo(name)
        work = prepare(image, Path(temporary))
        print(f"{name}, {image.width} x {image.height}:", end="", file=sys.stderr)
        rows = [Row(program, failure=program.missing) for program in [our_program(), *chosen]]
        ours = rows[0]
        for number in range(arguments.runs):
            for row in rows:
                slow = bool(row.runs) and row.runs[0].seconds > arguments.slow
                if row.failure is None and not slow:
                    print(f" {row.program.name}", end="", flush=True, file=sys.stderr)
                    run_once(row, work, arguments.limit)
                if row is ours and number == 0:
                    if ours.failure is not None:
                        sys.exit(f"our own program failed on {name}: {ours.failure}")
                    coordinates = TINY_COORDINATES if name == TINY else ours.points
                    work = replace(work, coordinates=coordinates)
        print(file=sys.stderr)
    return rows


# Tables ---------------------------------------------------------------------------------------------------------------------------


def table(name: str, rows: Sequence[Row]) -> str:
    """Return the table of a photo."""
    ours = rows[0]
    head = f"{'':<14}{'seconds':>10}{'runs':>6}{'CPU s':>10}{'peers/ours':>12}{'marks':>11}{'points':>11}{'kB':>9}{'peak MB':>9}"
    lines = [name, "", head]
    for row in rows:
        if row.failure is not None and not row.is_timed_out:
            lines.append(f"{row.program.name:<14}{row.failure}")
            continue
        sign = ">" if row.is_timed_out else ""
        processor = statistics.median(run.processor_seconds for run in row.runs)
        memory = max(run.memory for run in row.runs) / 1e6
        counted = ("-", "-", "-") if row.is_timed_out else (f"{row.marks}", f"{row.points}", f"{row.size / 1e3:.0f}")
        lines.append(
            f"{row.program.name:<14}{sign + format(row.seconds, '.3f'):>10}{len(row.runs):>6}{processor:>10.3f}"
            f"{sign + format(row.seconds / ours.seconds, '.2f'):>12}{counted[0]:>11}{counted[1]:>11}{counted[2]:>9}{memory:>9.0f}"
        )
    return "\n".join(lines)


def targets(tables: dict[str, list[Row]]) -> str:
    """Return what is to be reached, for each peer over all photos."""
    lines = [f"{'to reach, on every photo':<44}{'worst':>10}{'on':>14}{'limit':>9}"]
    for index, first in enumerate(next(iter(tables.values()))[1:], start=1):
        program = first.program
        is_stippler = program.kind == "stippler"
        found = []
        for name, rows in tables.items():
            row = rows[index]
            if row.failure is None or row.is_timed_out:
                ratio = row.seconds / rows[0].seconds
                found.append((ratio if is_stippler else 1 / ratio, name))
        title = f"{program.name}: times as long as ours" if is_stippler else f"ours: times as long as {program.name}"
        if not found:
            lines.append(f"{title:<44}{'-':>10}{'':>14}{'':>9}  not measured")
            continue
        worst, name = min(found) if is_stippler else max(found)
        met = worst >= LEAST_GAIN if is_stippler else worst <= MOST_LOSS
        limit = f">= {LEAST_GAIN:.0f}" if is_stippler else f"<= {MOST_LOSS:.0f}"
        lines.append(f"{title:<44}{worst:>10.2f}{name:>14}{limit:>9}  {'met' if met else 'missed'}")
    return "\n".join(lines)


def main() -> None:
    """Measure and print."""
    parser = argparse.ArgumentParser(description="Seconds, marks, points, bytes and memory of ours and of peers.")
    parser.add_argument("--photos", default=",".join([*PHOTOS, LARGE]), help="names with commas (default: %(default)s)")
    parser.add_argument("--peers", help="names with commas (default: all)")
    parser.add_argument("--runs", type=int, default=5, help="of every program (default: %(default)s)")
    parser.add_argument("--slow", type=float, default=10, help="a first run of more seconds is the only one (default: %(default)s)")
    parser.add_argument("--limit", type=float, default=300, help="seconds after which a run is stopped (default: %(default)s)")
    parser.add_argument("--smoke", action="store_true", help="a tiny photo, once, with what is installed: whether this still runs")
    parser.add_argument("--textbook", nargs=3, metavar=("GREY", "SVG", "COORDINATES"), help=argparse.SUPPRESS)
    arguments = parser.parse_args()
    if arguments.textbook:
        grey, drawn, coordinates = arguments.textbook
        write_textbook(Path(grey), Path(drawn), int(coordinates))
        return
    names = [TINY] if arguments.smoke else arguments.photos.split(",")
    if arguments.smoke:
        arguments.runs = 1
    for name in names:
        if name not in {*PHOTOS, LARGE, TINY}:
            parser.error(f"there is no photo {name!r}: it must be one of {', '.join([*PHOTOS, LARGE])}")
    peers = find_peers(not arguments.smoke)
    if arguments.peers:
        wanted = arguments.peers.split(",")
        peers = [peer for peer in peers if peer.name in wanted]
    print(
        f"Whole commands, from start to file written: medians of up to {arguments.runs} runs in turn, one where a run takes"
        f" more than {arguments.slow:.0f} s;\nstopped after {arguments.limit:.0f} s. {os.cpu_count()} processors.\n"
    )
    tables = {}
    for name in names:
        tables[name] = measure_photo(name, peers, arguments)
        print(table(name, tables[name]), end="\n\n", flush=True)
    print(targets(tables))


if __name__ == "__main__":
    main()
