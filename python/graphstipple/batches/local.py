"""Processes of this machine. In: tasks and the work; out: what came of each, as it comes.

Every worker is a pool of one process, so that it is known which photo a worker had that has died: a photo is tried on a new one,
and after three times it is said that it ends its workers. A photo begins when there is memory for it.
"""

from __future__ import annotations

import contextlib
import multiprocessing
import os
import signal
from collections import deque
from collections.abc import Iterator
from concurrent.futures import FIRST_COMPLETED, Future, ProcessPoolExecutor, wait
from concurrent.futures.process import BrokenProcessPool
from dataclasses import dataclass, field
from typing import Any

from graphstipple._errors import GraphStippleError
from graphstipple._memory import in_words
from graphstipple.batches import work as works
from graphstipple.batches.addresses import shown
from graphstipple.batches.memory import Admission
from graphstipple.batches.work import Done, Task, Work

TRIES = 3
"""How many workers a photo may end: fewer would give up one beside which the system ran out of memory, more would cost as many."""

LOOK_EVERY = 0.1
"""Seconds after which it is seen that somebody wants to stop."""

DOES_NOT_START = "worker processes end before they begin: a script has to call graphstipple.batch under if __name__ == '__main__':"


class Stop:
    """Whether somebody wants to stop: after the photos that are being drawn, or at once."""

    def __init__(self) -> None:
        self.asked = False
        self.at_once = False

    def ask(self) -> None:
        """Ask to stop; the second time nobody wants to wait."""
        self.at_once = self.asked
        self.asked = True


@dataclass
class _Wish:
    """A photo that waits for a worker."""

    task: Task
    bytes_wanted: int
    ended: int = 0
    """How many workers it has ended."""


@dataclass
class _Worker:
    pool: ProcessPoolExecutor
    future: Future[Any]
    process: int = 0
    """Its number; 0 while it starts."""
    wish: _Wish | None = None


@dataclass
class _Workers:
    """All workers, and the photos that wait."""

    work: Work
    count: int
    memory: Admission
    busy: list[_Worker] = field(default_factory=list)
    idle: list[_Worker] = field(default_factory=list)
    waiting: deque[_Wish] = field(default_factory=deque)
    failed_starts: int = 0

    def start(self) -> None:
        """Start a worker; it is busy until it has said that it is there."""
        pool = ProcessPoolExecutor(1, multiprocessing.get_context("spawn"))
        with without_interrupts():
            future = pool.submit(works.begin)
        self.busy.append(_Worker(pool, future))

    def give(self, wish: _Wish) -> None:
        """Give a photo to a worker that has nothing to do."""
        worker = self.idle.pop()
        try:
            worker.future = worker.pool.submit(self.work, wish.task, wish.bytes_wanted)
        except BrokenProcessPool:
            # It was ended while it had nothing to do.
            worker.pool.shutdown(wait=False)
            self.waiting.appendleft(wish)
            self.start()
            return
        worker.wish = wish
        self.busy.append(worker)

    def granted(self) -> list[int]:
        """Return the memory that photos have."""
        return [worker.wish.bytes_wanted for worker in self.busy if worker.wish is not None]

    def take(self, worker: _Worker) -> tuple[Task, Done] | None:
        """Take what a worker has done; nothing if its photo is not done yet."""
        self.busy.remove(worker)
        wish, worker.wish = worker.wish, None
        try:
            result = worker.future.result()
        except BrokenProcessPool:
            return self._lost(worker, wish)
        self.idle.append(worker)
        if wish is None:
            worker.process, self.failed_starts = result, 0
            return None
        done: Done = result
        if done.kind != "large":
            return wish.task, done
        wanted = self.memory.total if done.bytes_needed < 0 else done.bytes_needed
        if wanted <= wish.bytes_wanted or wanted > self.memory.total:
            return wish.task, too_large(wish.task, done, self.memory.total)
        self.waiting.appendleft(_Wish(wish.task, wanted, wish.ended))
        return None

    def _lost(self, worker: _Worker, wish: _Wish | None) -> tuple[Task, Done] | None:
        """Begin anew after the death of a worker."""
        worker.pool.shutdown(wait=False)
        if wish is None:
            self.failed_starts += 1
            if self.failed_starts >= TRIES:
                raise GraphStippleError(DOES_NOT_START)
        else:
            wish.ended += 1
            if wish.ended < TRIES:
                # Before all others, so that it is soon known what it is about it.
                self.waiting.appendleft(wish)
        self.start()
        return None if wish is None or wish.ended < TRIES else (wish.task, ended_its_worker(wish.task))

    def close(self, at_once: bool) -> None:
        """End the workers, when they have done what they are at, or at once."""
        if at_once:
            for worker in self.busy:
                if worker.process:
                    with contextlib.suppress(OSError):
                        # They listen to no other; Windows has but this one.
                        os.kill(worker.process, getattr(signal, "SIGKILL", signal.SIGTERM))
        for worker in [*self.idle, *self.busy]:
            worker.pool.shutdown(wait=True, cancel_futures=True)


def draw(tasks: Iterator[Task], work: Work, processes: int, memory: Admission, stop: Stop) -> Iterator[tuple[Task, Done]]:
    """Yield what came of every task, in the order in which they are done.

    When somebody asks to stop, no more is begun, and what is being done is yielded still.

    Raises
    ------
    GraphStippleError
        If no worker can be started.
    """
    workers = _Workers(work, processes, memory)
    try:
        for _ in range(processes):
            workers.start()
        while True:
            _feed(workers, tasks, stop)
            if not any(worker.wish for worker in workers.busy) and (stop.asked or not (workers.waiting or workers.busy)):
                return
            ready, _ = wait([worker.future for worker in workers.busy], LOOK_EVERY, FIRST_COMPLETED)
            if stop.at_once:
                return
            done = [workers.take(worker) for worker in list(workers.busy) if worker.future in ready]
            # The next are begun before anybody looks at these.
            _feed(workers, tasks, stop)
            yield from filter(None, done)
    finally:
        workers.close(stop.at_once)


def _feed(workers: _Workers, tasks: Iterator[Task], stop: Stop) -> None:
    """Give every idle worker a photo, as far as there is memory."""
    while workers.idle and not stop.asked:
        if not workers.waiting:
            task = next(tasks, None)
            if task is None:
                return
            workers.waiting.append(_Wish(task, workers.memory.share))
        # One that needs much is not overtaken by those that need little, or it would wait for ever.
        if not workers.memory.grants(workers.waiting[0].bytes_wanted, workers.granted()):
            return
        workers.give(workers.waiting.popleft())


def ended_its_worker(task: Task) -> Done:
    """Return what is said of a photo that is given up."""
    return Done("failed", sentence=f"{shown(task.address)}: it ended its worker each time that it was tried")


def too_large(task: Task, done: Done, most: int) -> Done:
    """Return what is said of a photo that would take more memory than there is."""
    wanted = "an unknown amount" if done.bytes_needed < 0 else f"about {in_words(done.bytes_needed)}"
    done.kind = "failed"
    done.sentence = f"{shown(task.address)}: it needs {wanted} of memory, but {in_words(most)} are allowed: raise memory"
    return done


@contextlib.contextmanager
def without_interrupts() -> Iterator[None]:
    """Start processes that Ctrl-C does not reach; one that comes meanwhile is heard afterwards."""
    if not hasattr(signal, "pthread_sigmask"):
        yield
        return
    before = signal.pthread_sigmask(signal.SIG_BLOCK, {signal.SIGINT})
    try:
        yield
    finally:
        signal.pthread_sigmask(signal.SIG_SETMASK, before)
