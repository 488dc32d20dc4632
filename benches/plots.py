"""Plots beside their limits, and vpype's `linesort` beside our order of the same dots: `python benches/plots.py`.

The limits are those of the Rust benchmark `plots`, which this runs and hands on. vpype is measured where it is installed, as the
command `vpype` or as a package of this Python, and is named as missing else; its seconds are those of `linesort` alone, by a clock
before and one after it in its pipeline, without its start and its files. Lengths are those of the pen's way between the dots.
"""

from __future__ import annotations

import argparse
import importlib.util
import re
import shutil
import subprocess
import sys
from dataclasses import dataclass
from pathlib import Path
from tempfile import TemporaryDirectory

from built import ROOT, bench_command

DOTS, MANY_DOTS, TINY_DOTS = 20_000, 100_000, 50

LIMIT = 600
"""Seconds after which vpype is stopped."""

CLOCK = """
import time

def generate():
    print("clock", time.perf_counter())
    return []
"""
"""What vpype runs to tell the time."""

READ = """
import time
import numpy as np

def generate():
    x, y = np.loadtxt({path!r}, ndmin=2).T
    # It knows no line without a length.
    lines = [np.array([dot, dot + 1e-6]) for dot in x + 1j * y]
    print("clock", time.perf_counter())
    return lines
"""
"""What vpype runs to have the dots."""


@dataclass(frozen=True)
class Sorted:
    """Dots in order: seconds, and how far the pen goes."""

    seconds: float
    way: float


def ours(count: int, path: Path, is_smoke_run: bool) -> Sorted:
    """Write dots and put them in order."""
    command = [*bench_command("plots", is_smoke_run), "--quiet", "--", "--dots", str(count), str(path)]
    seconds, way = subprocess.run(command, cwd=ROOT, stdout=subprocess.PIPE, text=True, check=True).stdout.split()
    return Sorted(float(seconds), float(way))


def find_vpype() -> list[str] | None:
    """Return how vpype is run, or None."""
    if found := shutil.which("vpype"):
        return [found]
    return [sys.executable, "-m", "vpype_cli"] if importlib.util.find_spec("vpype_cli") else None


def theirs(vpype: list[str], path: Path) -> Sorted | str:
    """Sort the dots of a file, or return why that cannot be."""
    reader, clock = path.with_suffix(".reader.py"), path.with_suffix(".clock.py")
    reader.write_text(READ.format(path=str(path)), "utf-8")
    clock.write_text(CLOCK, "utf-8")
    command = [*vpype, "script", str(reader), "linesort", "script", str(clock), "stat"]
    try:
        done = subprocess.run(command, capture_output=True, text=True, check=False, timeout=LIMIT)
    except subprocess.TimeoutExpired:
        return f"stopped after {LIMIT} s"
    times = [float(time) for time in re.findall(r"^clock (\S+)$", done.stdout, re.MULTILINE)]
    way = re.search(r"Pen-up length: ([\d.e+-]+)", done.stdout)
    if done.returncode != 0 or len(times) != 2 or way is None:
        said = done.stderr.strip().splitlines() or ["nothing"]
        return f"exit code {done.returncode}, and said: {said[-1]}"
    return Sorted(times[1] - times[0], float(way[1]))


def beside_vpype(counts: list[int], is_smoke_run: bool) -> str:
    """Return the table of our order and vpype's."""
    vpype = find_vpype()
    columns = ("dots", "ours, s", "way, m", "vpype, s", "way, m", "vpype/ours", "of its way")
    lines = [f"{'order beside vpype':<24}" + "".join(f"{column:>12}" for column in columns)]
    for count in counts:
        with TemporaryDirectory() as folder:
            path = Path(folder, "dots")
            own = ours(count, path, is_smoke_run)
            other: Sorted | str = "vpype is not installed" if vpype is None else theirs(vpype, path)
        line = f"{'':<24}{count:>12}{own.seconds:>12.3f}{own.way / 1e3:>12.2f}"
        if isinstance(other, Sorted):
            line += f"{other.seconds:>12.3f}{other.way / 1e3:>12.2f}"
            line += f"{other.seconds / own.seconds:>12.1f}{own.way / other.way:>12.3f}"
        else:
            line += f"  {other}"
        lines.append(line)
    return "\n".join(lines)


def main() -> None:
    """Measure and print."""
    parser = argparse.ArgumentParser(description="Plots beside their limits, and vpype's order beside ours.")
    parser.add_argument("--many", action="store_true", help=f"{MANY_DOTS} dots beside vpype, too: minutes")
    parser.add_argument("--smoke", action="store_true", help="few dots and a tiny photo: whether this still runs")
    arguments = parser.parse_args()
    counts = [TINY_DOTS] if arguments.smoke else [DOTS, *([MANY_DOTS] if arguments.many else [])]
    done = subprocess.run(
        [*bench_command("plots", arguments.smoke), "--quiet"], cwd=ROOT, stdout=subprocess.PIPE, text=True, check=True
    )
    print(done.stdout)
    print(beside_vpype(counts, arguments.smoke))


if __name__ == "__main__":
    main()
