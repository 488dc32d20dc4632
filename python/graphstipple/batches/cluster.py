"""Dask distributed. In: tasks and the work; out: what came of each, as it comes, from workers wherever they are.

Sharing the work, trying again, and workers that come and go are Dask's. The client sends photos whose files it alone has as bytes,
waits for what came of them, and keeps no more on the way than the workers need to be busy.
"""

from __future__ import annotations

import contextlib
import itertools
import logging
import queue
import secrets
import time
import warnings
from collections import deque
from collections.abc import Iterator
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any, NamedTuple

from graphstipple import _core
from graphstipple._errors import GraphStippleError, MissingPackageError
from graphstipple.batches import work as works
from graphstipple.batches.addresses import reason
from graphstipple.batches.local import LOOK_EVERY, TRIES, Stop, ended_its_worker, too_large, without_interrupts
from graphstipple.batches.memory import Admission
from graphstipple.batches.work import Done, Drawing, Task, Work

if TYPE_CHECKING:
    from distributed import Client, Future, LocalCluster

WAITING = 2
"""Photos for every thread of the workers: one that it draws, and one that it finds when that is done. More would only lie there."""

LEAST_ON_THE_WAY = 8
"""Photos on the way where there are few workers yet, or none."""

MOST_BYTES_ON_THE_WAY = 1 << 30
"""Bytes of photos that are on the way: they go through the scheduler."""

PATIENCE = 10
"""Seconds in which a scheduler answers."""

LOOK_AT_WORKERS = 2.0
"""Seconds after which their number is asked for again."""

GONE = "the scheduler is gone: run it again when it is back, and what is done is not done again"

NO_LIMIT = 1 << 50
"""Bytes that no photo takes."""

HEAVY = 1 << 20
"""Bytes of a photo of which Dask would say that they are many: so they are."""


class _Wish(NamedTuple):
    """A photo to send."""

    task: Task
    granted: int
    dropped: int = 0
    """How often the scheduler has lost it."""
    ended: int = 0
    """How many workers have ended that had it; they may have had others too."""


@dataclass(frozen=True)
class _OnWorker:
    """The work, where each worker knows how much memory it has."""

    work: Work
    most: int | None
    """Bytes that a photo may take anywhere."""
    version: str = _core.__version__

    def __call__(self, task: Task, granted: int) -> Done:
        if self.version != _core.__version__:
            # It has come after the others were asked.
            raise GraphStippleError(f"it has graphstipple {_core.__version__}, but the client {self.version}")
        if granted:
            return self.work(task, granted)
        granted = self.most or _memory_of_this_thread()
        done = self.work(task, granted)
        return too_large(task, done, granted) if done.kind == "large" else done


def _memory_of_this_thread() -> int:
    """Return what a worker's limit leaves for each of its threads; there may be no limit."""
    import distributed  # noqa: PLC0415  # only clusters need it

    worker = distributed.get_worker()
    limit = int(worker.memory_manager.memory_limit or NO_LIMIT)
    return limit // max(int(worker.state.nthreads), 1)


def connect(address: str, tls: tuple[str, str, str] | None = None) -> Client:
    """Return a client of a scheduler; `tls` names the files of an authority's certificate, a certificate and its key.

    Raises
    ------
    MissingPackageError
        If Dask is not installed.
    GraphStippleError
        If there is no scheduler.
    """
    distributed = _distributed()
    try:
        security = None
        if tls is not None:
            authority, certificate, key = tls
            security = distributed.Security(
                tls_ca_file=authority, tls_client_cert=certificate, tls_client_key=key, require_encryption=True
            )
        client: Client = distributed.Client(address, security=security, timeout=PATIENCE, set_as_default=False)
    except Exception as error:  # Dask has many
        raise GraphStippleError(f"{address}: there is no scheduler that answers ({reason(error)})") from error
    return client


@contextlib.contextmanager
def local(workers: int, dashboard: bool) -> Iterator[Client]:
    """Begin a cluster of processes on this machine, which is reached from nowhere else, and yield its client.

    Raises
    ------
    MissingPackageError
        If Dask is not installed.
    """
    distributed = _distributed()
    import dask  # noqa: PLC0415  # it comes with the other

    settings: dict[str, Any] = {
        # It is tried again one by one.
        "distributed.scheduler.allowed-failures": 0,
    }
    if not dashboard:
        # There is a server of HTTP anyway, with nothing on it.
        settings |= {"distributed.scheduler.http.routes": [], "distributed.worker.http.routes": []}
    with dask.config.set(settings), contextlib.ExitStack() as running:
        with without_interrupts():
            cluster: LocalCluster = distributed.LocalCluster(
                n_workers=workers,
                threads_per_worker=1,
                processes=True,
                host="127.0.0.1",
                # The client admits photos by their memory.
                memory_limit=0,
                dashboard_address="127.0.0.1:0",
                worker_dashboard_address="127.0.0.1:0",
                scheduler_kwargs={"dashboard": dashboard},
                silence_logs=logging.CRITICAL,
            )
            running.enter_context(cluster)
            client: Client = running.enter_context(distributed.Client(cluster, set_as_default=False))
        yield client


def _distributed() -> Any:
    try:
        import distributed  # noqa: PLC0415  # only clusters need it
    except ImportError as error:
        raise MissingPackageError(
            f"clusters need a package that is not installed ({error}): pip install graphstipple[dask]"
        ) from error
    return distributed


def check(client: Client, work: Drawing) -> None:
    """Check that every worker that is there has this version, and sees the output.

    Raises
    ------
    GraphStippleError
        If one has not.
    """
    folder = work.store.folder
    mark = work.store.mark()
    try:
        found = client.run(_look, None if mark is None else str(mark), on_error="return")
    except Exception as error:  # of workers that have no graphstipple, perhaps
        raise GraphStippleError(f"the workers cannot be asked for their version ({reason(error)})") from error
    finally:
        if mark is not None:
            mark.unlink(missing_ok=True)
    for worker, answer in found.items():
        if isinstance(answer, Exception):
            raise GraphStippleError(f"worker {worker} cannot draw: {reason(answer)}")
        version, sees = answer
        if version != _core.__version__:
            raise GraphStippleError(f"worker {worker} has graphstipple {version}, but this is {_core.__version__}")
        if not sees:
            raise GraphStippleError(
                f"worker {worker} does not see the folder {folder}: name one that all machines share, or an address such as s3://"
            )


def _look(mark: str | None) -> tuple[str, bool]:
    """Return the version that a worker has, and whether it sees a file."""
    from pathlib import Path  # noqa: PLC0415  # it runs on the worker

    return _core.__version__, mark is None or Path(mark).exists()


def draw(
    tasks: Iterator[Task], work: Work, client: Client, memory: Admission | int | None, stop: Stop
) -> Iterator[tuple[Task, Done]]:
    """Yield what came of every task, in the order in which they are done.

    `memory` is what photos have together, for workers of this machine, or the most bytes that any may have; without it each worker
    goes by its own limit. When somebody asks to stop, no more is sent, and what is on the way is yielded still.

    Raises
    ------
    GraphStippleError
        If the scheduler goes, or a worker cannot work.
    """
    way = _Way(client, work, memory, stop)
    try:
        while True:
            yield from way.fill(tasks)
            if not way.sent and (stop.asked or not (way.waiting or way.suspects)):
                return
            done = way.come()
            if stop.at_once:
                return
            yield from done
    finally:
        way.close()


class _Way:
    """Photos that are on the way to workers and back."""

    def __init__(self, client: Client, work: Work, memory: Admission | int | None, stop: Stop) -> None:
        self._client = client
        self._admission = memory if isinstance(memory, Admission) else None
        self._work = work
        self._on_worker = _OnWorker(work, memory if isinstance(memory, int) else None)
        self._stop = stop
        self._back: queue.SimpleQueue[Future[Done]] = queue.SimpleQueue()
        self._numbers = itertools.count()
        self._run = secrets.token_hex(6)
        self._bytes = 0
        self._looked = 0.0
        self._most = LEAST_ON_THE_WAY
        self.sent: dict[str, tuple[Future[Done], _Wish]] = {}
        self.waiting: deque[_Wish] = deque()
        self.suspects: deque[_Wish] = deque()

    def fill(self, tasks: Iterator[Task]) -> Iterator[tuple[Task, Done]]:
        """Send as many as there is room for, and yield those that need no worker."""
        if self.suspects and not self._stop.asked and not any(wish.ended for _, wish in self.sent.values()):
            # One after the other, so that it is known which of them it is.
            self._send(self.suspects.popleft())
        while not self._stop.asked:
            if not self.waiting:
                task = next(tasks, None)
                if task is None:
                    return
                packed = works.packed(task, self._work.store) if isinstance(self._work, Drawing) else task
                if isinstance(packed, Done):
                    yield task, packed
                    continue
                self.waiting.append(_Wish(packed, self._admission.share if self._admission else 0))
            if not self._has_room(self.waiting[0]):
                return
            self._send(self.waiting.popleft())

    def _has_room(self, wish: _Wish) -> bool:
        if not self.sent:
            return True
        if self._admission and not self._admission.grants(wish.granted, (sent.granted for _, sent in self.sent.values())):
            return False
        now = time.monotonic()
        if now - self._looked > LOOK_AT_WORKERS:
            with contextlib.suppress(OSError):  # that the scheduler is gone is seen elsewhere
                self._most = max(LEAST_ON_THE_WAY, WAITING * sum(self._client.nthreads().values()))
            self._looked = now
        return len(self.sent) < self._most and self._bytes < MOST_BYTES_ON_THE_WAY

    def _send(self, wish: _Wish) -> None:
        size = len(wish.task.data or b"")
        with warnings.catch_warnings() if size >= HEAVY else contextlib.nullcontext():
            if size >= HEAVY:
                warnings.simplefilter("ignore")
            key = f"graphstipple-{self._run}-{next(self._numbers)}"
            future = self._client.submit(self._on_worker, wish.task, wish.granted, key=key, pure=False)
        self.sent[key] = future, wish
        self._bytes += size
        future.add_done_callback(self._back.put)

    def come(self) -> list[tuple[Task, Done]]:
        """Return what came of photos; after a while, nothing."""
        come: list[Future[Done]] = []
        with contextlib.suppress(queue.Empty):
            come.append(self._back.get(timeout=LOOK_EVERY))
            while True:
                come.append(self._back.get_nowait())
        if not come and self._client.status != "running":
            raise GraphStippleError(GONE)
        found = self._found(come)
        taken = [self._take(future, found.get(future.key)) for future in come if future.key in self.sent]
        return [it for it in taken if it is not None]

    def _found(self, come: list[Future[Done]]) -> dict[str, Done]:
        """Return the results of those that have one, all in one message."""
        finished = [future for future in come if future.status == "finished"]
        try:
            return dict(zip((future.key for future in finished), self._client.gather(finished), strict=True))
        except Exception:  # a worker has gone with its results
            found = {}
            for future in finished:
                with contextlib.suppress(Exception):
                    found[future.key] = future.result(timeout=PATIENCE)
            return found

    def _take(self, future: Future[Done], done: Done | None) -> tuple[Task, Done] | None:
        """Return what came of a photo; nothing if it has to be sent again."""
        _, wish = self.sent.pop(future.key)
        self._bytes -= len(wish.task.data or b"")
        if done is None and future.status == "error":
            error = future.exception()
            if type(error).__name__ != "KilledWorker":
                raise GraphStippleError(f"a worker cannot draw: {reason(error)}") from error
            ended = wish.ended + error.allowed_failures + 1
            if not wish.ended or ended < TRIES:
                self.suspects.append(wish._replace(ended=ended))
                return None
            done = ended_its_worker(wish.task)
        elif done is None:
            if self._client.status != "running":
                raise GraphStippleError(GONE)
            if wish.dropped + 1 < TRIES:
                self.waiting.appendleft(wish._replace(dropped=wish.dropped + 1))
                return None
            done = ended_its_worker(wish.task)
        elif done.kind == "large" and self._admission:
            wanted = self._admission.total if done.bytes_needed < 0 else done.bytes_needed
            if wish.granted < wanted <= self._admission.total:
                self.waiting.appendleft(wish._replace(granted=wanted))
                return None
            done = too_large(wish.task, done, self._admission.total)
        return wish.task, done

    def close(self) -> None:
        """Forget what is on the way."""
        with contextlib.suppress(Exception):  # the scheduler may be gone
            self._client.cancel([future for future, _ in self.sent.values()])
