"""Photos for batches, small and many, some of them bad; and works for worker processes that do what they should not."""

from __future__ import annotations

import os
import signal
import subprocess
import sys
import time
from collections.abc import Iterable
from functools import cache
from pathlib import Path

import numpy as np
from PIL import Image

import graphstipple as gs
from graphstipple.batches.work import Done, Task

CONSOLE_SCRIPT = Path(sys.executable).with_name("graphstipple")

COUNT, BAD = 200, 10

OPTIONS = gs.Options(nodes=150)
FLAGS = ("--nodes", "150")
"""Few nodes, since it is not the drawings that are looked at."""


def name_of(number: int) -> str:
    """Return the name of a photo in its folder, some in folders of their own."""
    return f"{'deep/er/' if number % 4 == 0 else ''}photo {number:03}.png"


def is_bad(number: int, count: int = COUNT) -> bool:
    """Whether this photo cannot be drawn: every twentieth."""
    return number % (COUNT // BAD) == 7


def pixels(number: int) -> np.ndarray:
    """Return a photo, of a size and a tone of its own."""
    rows, columns = np.mgrid[0 : 16 + number % 7, 0 : 20 + number % 5]
    return ((rows * 9 + columns * (3 + number % 11) + number * 5) % 256).astype(np.uint8)


def make(folder: Path, count: int = COUNT) -> Path:
    """Write photos to a folder, the first so many."""
    for number in range(count):
        path = folder / name_of(number)
        path.parent.mkdir(parents=True, exist_ok=True)
        if is_bad(number):
            path.write_bytes(b"this is no image" if number % 3 else path.with_name("photo 000.png").name.encode())
        else:
            Image.fromarray(pixels(number)).save(path)
    return folder


@cache
def expected(count: int = COUNT) -> dict[str, bytes]:
    """Return the drawings of the photos one by one, by the names of their files."""
    good = (number for number in range(count) if not is_bad(number))
    names = ((str(Path(name_of(number)).with_suffix(".svg")), number) for number in good)
    return {name: gs.draw(pixels(number), options=OPTIONS).svg().encode() for name, number in names}


def drawn(folder: Path, suffix: str = ".svg") -> dict[str, bytes]:
    """Return the drawings in a folder; whatever else is there but the manifest is none."""
    files = [path for path in folder.rglob("*") if path.is_file() and path.name != "manifest.jsonl"]
    assert [path for path in files if path.suffix != suffix] == []
    return {path.relative_to(folder).as_posix(): path.read_bytes() for path in files}


def check(results: Iterable[gs.BatchResult], count: int = COUNT) -> None:
    """Check that every photo was drawn or told of, each once."""
    found = list(results)
    bad = [number for number in range(count) if is_bad(number, count)]
    assert len(found) == len({result.photo for result in found}) == count
    failed = [result for result in found if result.error is not None]
    assert sorted(result.photo.rpartition("/")[2] for result in failed) == [Path(name_of(number)).name for number in bad]
    assert all(result.photo in (result.error or "") for result in failed)


def batch(*arguments: object, cwd: Path, **more: str) -> subprocess.CompletedProcess[str]:
    """Run the command to its end."""
    command = [CONSOLE_SCRIPT, "batch", *map(str, arguments)]
    environment = {**os.environ, **more}
    return subprocess.run(
        command, cwd=cwd, env=environment, capture_output=True, text=True, timeout=120, stdin=subprocess.DEVNULL, check=False
    )


def deadly(task: Task, granted: int) -> Done:
    """End this process, if the task says so."""
    if task.address == "deadly":
        os.kill(os.getpid(), signal.SIGKILL)
    if task.address.startswith("once:"):
        mark = Path(task.address.removeprefix("once:"))
        if not mark.exists():
            mark.touch()
            os.kill(os.getpid(), signal.SIGKILL)
    return Done("drawn")


def greedy(task: Task, granted: int) -> Done:
    """Take as much memory as the task says, and write down when."""
    wanted = int(task.names[0])
    if granted < wanted:
        return Done("large", bytes_needed=wanted)
    begin = time.monotonic_ns()
    sum(range(100_000))
    with Path(task.address).open("a", encoding="ascii") as file:
        file.write(f"{begin} {time.monotonic_ns()} {granted}\n")
    return Done("drawn")
