"""Long calls into other libraries that Ctrl-C can still stop."""

from __future__ import annotations

import threading
from collections.abc import Callable
from typing import Generic, TypeVar

T = TypeVar("T")


class _Call(threading.Thread, Generic[T]):
    """A call on a thread of its own; a daemon, so that an abandoned call does not keep the interpreter alive."""

    result: T
    raised: BaseException | None = None

    def __init__(self, function: Callable[[], T]) -> None:
        super().__init__(name="graphstipple", daemon=True)
        self._function = function

    def run(self) -> None:
        """Call, and keep what comes of it."""
        try:
            self.result = self._function()
        except BaseException as error:
            self.raised = error


def run(function: Callable[[], T]) -> T:
    """Return what the function returns; KeyboardInterrupt comes through at once, and the call is left to end on its own."""
    call = _Call(function)
    call.start()
    while call.is_alive():
        # With a timeout, so that the main thread handles signals on every platform.
        call.join(0.02)
    if call.raised is not None:
        raise call.raised
    return call.result
