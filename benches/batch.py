"""Batches: `python benches/batch.py`. Two processes beside one, and what a client of a thousand workers does itself.

Photos are drawn by one process of one thread and by two, in turns, and the rates are compared: what the processes have in common
is files, memory and the one that feeds them. Then a real scheduler of Dask hands photos to a thousand threads of one worker, which
only wait for as long as drawings took that were measured before; the processor seconds of the client, with all its threads, are
what it does itself for a photo: sending it, taking what came of it, and writing the manifest.
"""

from __future__ import annotations

import argparse
import itertools
import json
import statistics
import subprocess
import sys
import time
from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path
from tempfile import TemporaryDirectory

import numpy as np
from PIL import Image

import graphstipple as gs
from graphstipple.batches import cluster, engines
from graphstipple.batches.local import Stop
from graphstipple.batches.run import Asked, Run
from graphstipple.batches.work import Done, Drawing, Task

SIZE, TINY_SIZE = (577, 433), (40, 30)
PHOTOS, TINY_PHOTOS = 24, 4
"""By every process."""

TURNS = 3
LEAST_RATIO = 1.8
"""Two processes over one."""

WORKERS, TINY_WORKERS = 1000, 20
SENT, TINY_SENT = 10_000, 100
"""Photos that are sent to them."""

MOST_MILLISECONDS = 5.0
"""Of the client, for a photo."""

PATIENCE = 60
"""Seconds in which a scheduler starts."""


@dataclass(frozen=True)
class Waits:
    """Waits as long as drawings took."""

    seconds: tuple[float, ...]

    def __call__(self, task: Task, granted: int) -> Done:
        """Wait for a photo's turn of them."""
        number = int(Path(task.address).stem)
        time.sleep(self.seconds[number % len(self.seconds)])
        hashes = dict.fromkeys(task.names, f"sha256:{number:064x}")
        return Done("drawn", f"sha256:{number:064x}", hashes, {"stipples": number, "regions": number, "nodes": number}, 0.5)


def write_photos(folder: Path, size: tuple[int, int], count: int) -> None:
    """Write photos with fine and coarse parts."""
    columns, rows = np.meshgrid(np.linspace(0, 1, size[0]), np.linspace(0, 1, size[1]))
    noise = np.random.default_rng(1)
    for number in range(count):
        waves = np.sin(columns * (9 + number)) * np.cos(rows * (7 + number)) * 0.3 + 0.5
        values = waves + noise.normal(0, 0.06, waves.shape) * (columns > 0.5)
        Image.fromarray((values.clip(0, 1) * 255).astype(np.uint8)).save(folder / f"{number:03}.png")


def rate(folder: Path, output: Path, processes: int, count: int) -> tuple[float, list[float]]:
    """Return photos a second by so many processes of one thread, from the first that was done on, and the seconds of each."""
    run = Run(Asked([str(folder)], str(output), redo=True))
    results = run.results(engines.on_this_machine(processes, None, Stop()), threads=1)
    # Those that were begun with the first are done with it, more or less.
    first = [next(results) for _ in range(processes)]
    began = time.perf_counter()
    rest = list(results)
    seconds = [result.seconds for result in [*first, *rest]]
    assert all(result.error is None for result in rest)
    assert len(seconds) == count
    return len(rest) / (time.perf_counter() - began), seconds


def client_work(folder: Path, seconds: list[float], workers: int, count: int) -> tuple[float, float]:
    """Return the client's processor seconds and all seconds for so many photos, by so many workers that pretend."""
    run = Run(Asked([], str(folder / "out"), lines=[f"s3://bucket/{number:08}.jpg" for number in range(count)]))
    waits = Waits(tuple(seconds))
    with scheduler(folder, workers) as address, cluster.connect(address) as client:
        client.wait_for_workers(1)

        def engine(tasks: Iterator[Task], work: Drawing) -> Iterator[tuple[Task, Done]]:
            return cluster.draw(tasks, waits, client, None, Stop())

        began, own = time.perf_counter(), time.process_time()
        done = sum(1 for _ in run.results(engine))
        own, whole = time.process_time() - own, time.perf_counter() - began
    assert done == count
    return own, whole


class scheduler:  # noqa: N801  # it is used as a function
    """A scheduler and a worker with so many threads, as others start them."""

    def __init__(self, folder: Path, threads: int) -> None:
        file = folder / "scheduler.json"
        where = ["--host", "127.0.0.1", "--no-dashboard", "--scheduler-file", str(file)]
        dask = str(Path(sys.executable).with_name("dask"))
        self._commands = [
            [dask, "scheduler", "--port", "0", *where],
            [dask, "worker", "--nthreads", str(threads), "--no-nanny", *where],
        ]
        self._file = file
        self._processes: list[subprocess.Popen[bytes]] = []

    def __enter__(self) -> str:
        for command in self._commands:
            self._processes.append(subprocess.Popen(command, stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL))
            for _ in range(PATIENCE * 10):
                if self._file.exists() and self._file.read_text().endswith("}"):
                    break
                time.sleep(0.1)
        return str(json.loads(self._file.read_text())["address"])

    def __exit__(self, *_: object) -> None:
        for process in self._processes:
            process.terminate()
            process.wait()


def main() -> None:
    """Measure and print."""
    parser = argparse.ArgumentParser(description="Two processes of a batch beside one, and the work of a client.")
    parser.add_argument("--smoke", action="store_true", help="tiny photos and few: whether this still runs")
    smoke = parser.parse_args().smoke
    size, photos, turns = (TINY_SIZE, TINY_PHOTOS, 1) if smoke else (SIZE, PHOTOS, TURNS)
    workers, sent = (TINY_WORKERS, TINY_SENT) if smoke else (WORKERS, SENT)
    with TemporaryDirectory() as folder_:
        folder = Path(folder_)
        for processes in (1, 2):
            (folder / str(processes)).mkdir()
            write_photos(folder / str(processes), size, photos * processes)
        pairs, seconds = [], []
        for _ in range(turns):
            (one, taken), (two, _) = (rate(folder / str(n), folder / f"out-{n}", n, photos * n) for n in (1, 2))
            pairs.append((one, two))
            seconds += taken
        ones, twos = zip(*pairs, strict=True)
        print(f"{size[0]} x {size[1]} pixels, {photos} photos a process, medians of {turns} turns; {engines.cores()} processors\n")
        print(f"photos a second, one process of one thread  {statistics.median(ones):8.2f}")
        print(f"photos a second, two                        {statistics.median(twos):8.2f}")
        ratio = statistics.median(two / one for one, two in pairs)
        verdict = "met" if ratio >= LEAST_RATIO else "missed"
        print(f"two / one                                   {ratio:8.2f}  >= {LEAST_RATIO:g}  {verdict}\n")
        # As if each were a photo of a camera.
        longer = [second * scale for second, scale in itertools.product(seconds, (2, 4, 8))]
        own, whole = client_work(folder, longer, workers, sent)
    milliseconds = own / sent * 1000
    verdict = "met" if milliseconds <= MOST_MILLISECONDS else "missed"
    print(f"{workers} workers that pretend, {sent} photos of {statistics.mean(longer):.2f} s on average, Dask {version()}\n")
    print(f"client, processor ms a photo                {milliseconds:8.2f}  <= {MOST_MILLISECONDS:g}    {verdict}")
    print(f"scheduler and client, photos a second       {sent / whole:8.0f}")
    print(f"graphstipple {gs.__version__}", file=sys.stderr)


def version() -> str:
    """Return the version of Dask."""
    import distributed  # noqa: PLC0415  # it is slow to import

    return str(distributed.__version__)


if __name__ == "__main__":
    main()
