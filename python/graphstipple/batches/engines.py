"""Engines. In: how many processes and how much memory, or a scheduler; out: what a run's tasks are done by."""

from __future__ import annotations

import contextlib
import os
import re
from collections.abc import Iterator
from typing import TYPE_CHECKING

from graphstipple._errors import InvalidInputError
from graphstipple._memory import half_of_the_memory
from graphstipple.batches import cluster, local
from graphstipple.batches.local import Stop
from graphstipple.batches.memory import Admission
from graphstipple.batches.run import Engine
from graphstipple.batches.work import Done, Drawing, Task

if TYPE_CHECKING:
    from distributed import Client

_UNITS = {"": 1, "kB": 10**3, "MB": 10**6, "GB": 10**9, "TB": 10**12, "KiB": 1 << 10, "MiB": 1 << 20, "GiB": 1 << 30}


def memory_of(text: int | str) -> int:
    """Return a number of bytes, which may have a unit.

    Raises
    ------
    InvalidInputError
        If it is none.
    """
    found = re.fullmatch(r"\s*(\d+(?:\.\d+)?)\s*([kMGTi]*B)?\s*", str(text))
    unit = _UNITS.get((found[2] or "") if found else "-")
    size = int(float(found[1]) * unit) if found and unit else 0
    if size < 1:
        raise InvalidInputError(f"memory is {text}, but it must be a number of bytes, at least 1, or one with a unit such as 8GB")
    return size


def cores() -> int:
    """Return how many cores this process may use."""
    try:
        return len(os.sched_getaffinity(0))
    except AttributeError:
        return os.cpu_count() or 1


def shares(photos: int, processes: int | None, threads: int | None) -> tuple[int, int]:
    """Return how many processes draw, each on how many threads, so that there are no more than cores.

    Raises
    ------
    InvalidInputError
        If there must be more.
    """
    most = cores()
    if processes is not None and processes < 1:
        raise InvalidInputError(f"processes is {processes}, but it must be at least 1")
    if threads is not None and threads > most:
        raise InvalidInputError(f"threads is {threads}, but it must be at most {most}, as many as there are cores")
    count = max(1, min(photos, processes or most, most // (threads or 1)))
    return count, threads or most // count


def on_this_machine(processes: int, memory: int | None, stop: Stop) -> Engine:
    """Return what draws by so many processes, with so much memory together: by default half of the machine's."""
    admission = Admission(memory or half_of_the_memory(), processes)

    def draw(tasks: Iterator[Task], work: Drawing) -> Iterator[tuple[Task, Done]]:
        return local.draw(tasks, work, processes, admission, stop)

    return draw


def on_local_cluster(processes: int, memory: int | None, stop: Stop, *, dashboard: bool) -> Engine:
    """Return what draws by a cluster of Dask on this machine, likewise."""
    admission = Admission(memory or half_of_the_memory(), cluster.WAITING * processes)

    def draw(tasks: Iterator[Task], work: Drawing) -> Iterator[tuple[Task, Done]]:
        with cluster.local(processes, dashboard) as client:
            yield from cluster.draw(tasks, work, client, admission, stop)

    return draw


def on_scheduler(scheduler: str | Client, memory: int | None, stop: Stop, tls: tuple[str, str, str] | None = None) -> Engine:
    """Return what draws by the workers of a scheduler, where no photo takes more than so much memory."""

    def draw(tasks: Iterator[Task], work: Drawing) -> Iterator[tuple[Task, Done]]:
        with contextlib.ExitStack() as ending:
            client = ending.enter_context(cluster.connect(scheduler, tls)) if isinstance(scheduler, str) else scheduler
            cluster.check(client, work)
            yield from cluster.draw(tasks, work, client, memory, stop)

    return draw
