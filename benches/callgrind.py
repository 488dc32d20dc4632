"""What every stage does on the processor, counted by callgrind: `python benches/callgrind.py`.

Counts do not depend on what else the machine does. Each stage runs once on one thread, at one megapixel; caches (32 kB, then 32 MB)
and the prediction of branches are simulated. Needs valgrind (Debian: valgrind), and takes ten minutes or more.
"""

from __future__ import annotations

import argparse
import json
import shutil
import subprocess
import sys
from pathlib import Path
from tempfile import TemporaryDirectory

from built import ROOT, bench_command

MARKED = "graphstipple_bench::stages::Stage::time"
"""The function whose costs are counted, each call for itself."""

CACHES = ("--I1=32768,8,64", "--D1=32768,8,64", "--LL=33554432,16,64")
"""Bytes, ways and bytes a line of the simulated caches: as most machines have them, and the same on all."""

COLUMNS = {
    "instructions": ("Ir",),
    "reads, writes": ("Dr", "Dw"),
    "L1 misses": ("D1mr", "D1mw"),
    "LL misses": ("DLmr", "DLmw"),
    "branches": ("Bc", "Bi"),
    "mispredicted": ("Bcm", "Bim"),
}
"""Titles of the table's columns, and the events whose counts are added up."""

SIZE, TINY_SIZE = (1152, 864), (96, 72)


def binary(is_smoke_run: bool) -> Path:
    """Build the benchmark and return where it is."""
    command = [*bench_command("threads", is_smoke_run), "--no-run", "--message-format", "json"]
    done = subprocess.run(command, cwd=ROOT, stdout=subprocess.PIPE, check=True)
    messages = [json.loads(line) for line in done.stdout.splitlines()]
    return Path(next(m["executable"] for m in messages if m.get("executable") and m["target"]["name"] == "threads"))


def counted(program: Path, size: tuple[int, int]) -> list[tuple[str, dict[str, int]]]:
    """Run the stages under callgrind and return their names with the counts of every event."""
    with TemporaryDirectory() as temporary:
        out = Path(temporary, "out")
        tool = ["valgrind", "--quiet", "--tool=callgrind", "--cache-sim=yes", "--branch-sim=yes", f"--callgrind-out-file={out}"]
        marks = ["--collect-atstart=no", f"--toggle-collect={MARKED}", f"--dump-after={MARKED}"]
        command = [*tool, *CACHES, *marks, str(program), "--once", *map(str, size)]
        done = subprocess.run(command, stdout=subprocess.PIPE, text=True, check=True)
        names = done.stdout.split()
        # One file a call, numbered from 1.
        parts = [read(Path(f"{out}.{number}")) for number in range(1, len(names) + 1)]
    return list(zip(names, parts, strict=True))


def read(path: Path) -> dict[str, int]:
    """Return the totals of a file of callgrind by the names of the events."""
    lines = path.read_text("utf-8").splitlines()
    events = next(line for line in lines if line.startswith("events:")).split()[1:]
    totals = next(line for line in lines if line.startswith(("summary:", "totals:"))).split()[1:]
    # Events at the end that never came are left out.
    counts = [int(count) for count in totals] + [0] * (len(events) - len(totals))
    return dict(zip(events, counts, strict=True))


def main() -> None:
    """Count and print."""
    parser = argparse.ArgumentParser(description="Instructions, cache misses and branch misses of every stage.")
    parser.add_argument("--smoke", action="store_true", help="a tiny photo and a test build: whether this still runs")
    parser.add_argument("--size", type=int, nargs=2, default=SIZE, metavar=("WIDTH", "HEIGHT"), help="of the photo, in pixels")
    arguments = parser.parse_args()
    if shutil.which("valgrind") is None:
        print("valgrind is not installed, so nothing is counted: on Debian and Ubuntu, apt-get install valgrind")
        sys.exit(0 if arguments.smoke else 1)
    size = TINY_SIZE if arguments.smoke else tuple(arguments.size)
    pixels = size[0] * size[1]
    print(f"{size[0]} x {size[1]} pixels, on one thread: counts per pixel\n")
    print(f"{'':<24}" + "".join(f"{title:>15}" for title in COLUMNS))
    for name, counts in counted(binary(arguments.smoke), size):
        cells = [sum(counts.get(event, 0) for event in events) / pixels for events in COLUMNS.values()]
        print(f"{name:<24}" + "".join(f"{cell:>15.{1 if cell >= 10 else 3}f}" for cell in cells))


if __name__ == "__main__":
    main()
