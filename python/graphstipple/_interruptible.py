"""Long calls into other libraries that Ctrl-C can still stop."""

from __future__ import annotations

import threading
from collections import deque
from collections.abc import Callable
from queue import SimpleQueue
from typing import Any, Generic, TypeVar

T = TypeVar("T")


class _Call(Generic[T]):
    """A call, and what comes of it."""

    result: T
    raised: BaseException | None = None

    def __init__(self, function: Callable[[], T]) -> None:
        self.done = threading.Event()
        self._function = function

    def make(self) -> None:
        """Call, and keep what comes of it."""
        try:
            self.result = self._function()
        except BaseException as error:
            self.raised = error


class _Worker(threading.Thread):
    """A thread that makes one call after another: OpenCV keeps some memory of every thread that ever called it.

    A daemon, so that an abandoned call does not keep the interpreter alive.
    """

    def __init__(self) -> None:
        super().__init__(name="graphstipple", daemon=True)
        self.calls: SimpleQueue[_Call[Any]] = SimpleQueue()

    def run(self) -> None:
        """Make the calls."""
        while True:
            call = self.calls.get()
            call.make()
            # Before the caller hears of it, so that its next call finds this thread.
            _idle.append(self)
            call.done.set()
            # Not kept until the next call: it holds a picture.
            del call


_idle: deque[_Worker] = deque()
"""Threads without a call. One whose call was abandoned comes back when that ends."""


def run(function: Callable[[], T]) -> T:
    """Return what the function returns; KeyboardInterrupt comes through at once, and the call is left to end on its own."""
    call = _Call(function)
    _idle_worker().calls.put(call)
    # With a timeout, so that the main thread handles signals on every platform.
    while not call.done.wait(0.02):
        pass
    if call.raised is not None:
        raise call.raised
    return call.result


def _idle_worker() -> _Worker:
    """Return a thread without a call, for one call."""
    while _idle:
        try:
            worker = _idle.pop()
        except IndexError:  # another caller was faster
            break
        # After a fork, the threads of the parent are none of the child's.
        if worker.is_alive():
            return worker
    worker = _Worker()
    worker.start()
    return worker
