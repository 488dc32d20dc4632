"""Calls into other libraries: on threads that are used again, whatever came of the calls before."""

import _thread
import gc
import os
import signal
import subprocess
import sys
import threading
import weakref
from collections.abc import Iterator
from concurrent.futures import ThreadPoolExecutor

import numpy as np
import pytest
from tests.support import wait_until

import graphstipple as gs
from graphstipple import _interruptible
from graphstipple._interruptible import run


@pytest.fixture(autouse=True)
def _from_the_start() -> None:
    # No thread of an earlier test is idle.
    _interruptible._idle.clear()


def test_two_calls_use_one_thread() -> None:
    first, second = run(threading.current_thread), run(threading.current_thread)
    assert first is second
    assert first is not threading.current_thread()
    assert first.daemon


def test_exceptions_pass_through_and_the_thread_stays() -> None:
    def fail() -> None:
        raise LookupError("as it is")

    thread = run(threading.current_thread)
    with pytest.raises(LookupError, match="as it is"):
        run(fail)
    assert run(threading.current_thread) is thread


@pytest.fixture
def _ctrl_c_interrupts() -> Iterator[None]:
    # It does not where tests run in the background of a shell.
    handler = signal.signal(signal.SIGINT, signal.default_int_handler)
    yield
    signal.signal(signal.SIGINT, handler)


@pytest.mark.usefixtures("_ctrl_c_interrupts")
def test_an_interrupted_call_leaves_the_next_one_working() -> None:
    thread = run(threading.current_thread)
    end = threading.Event()

    def call() -> None:
        _thread.interrupt_main()
        end.wait()

    with pytest.raises(KeyboardInterrupt):
        run(call)
    other = run(threading.current_thread)
    assert other is not thread
    assert run(threading.current_thread) is other
    # When the call that nobody waits for ends, its thread is of use again.
    end.set()
    wait_until(lambda: len(_interruptible._idle) == 2)
    assert set(_interruptible._idle) == {thread, other}
    assert run(lambda: "done") == "done"


def test_calls_from_several_threads_at_once() -> None:
    callers = 6
    together = threading.Barrier(callers)

    def call(number: int) -> tuple[int, threading.Thread]:
        def work() -> tuple[int, threading.Thread]:
            together.wait(60)
            return number, threading.current_thread()

        return run(work)

    with ThreadPoolExecutor(callers) as pool:
        for _ in range(3):
            results = list(pool.map(call, range(callers)))
            assert [number for number, _ in results] == list(range(callers))
            assert len({thread for _, thread in results}) == callers
    assert len(_interruptible._idle) == callers


def test_nothing_of_a_call_is_kept() -> None:
    class Picture:
        pass

    picture = Picture()
    kept = weakref.ref(picture)
    assert run(lambda picture=picture: picture) is picture
    del picture
    gc.collect()
    assert kept() is None


def test_saliencies_use_one_thread() -> None:
    before = threading.active_count()
    for _ in range(5):
        gs.saliency(np.zeros((8, 8)))
    assert len(_interruptible._idle) == 1
    assert threading.active_count() <= before + 1


@pytest.mark.skipif(not hasattr(os, "fork"), reason="POSIX")
def test_a_forked_process_has_threads_of_its_own() -> None:
    program = """
import os
from graphstipple._interruptible import run
run(int)
child = os.fork()
if child == 0:
    os._exit(run(lambda: 7))
print(os.waitstatus_to_exitcode(os.waitpid(child, 0)[1]), run(lambda: 8))
"""
    done = subprocess.run([sys.executable, "-c", program], capture_output=True, text=True, timeout=60, check=True)
    assert done.stdout.split() == ["7", "8"], done.stderr
