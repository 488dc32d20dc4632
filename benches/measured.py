"""One command in a process of its own: its seconds, its processor seconds, and the most memory that it held.

Linux counts in the memory of a process what the one that started it held at that moment. So the command is not started from here
but from a small Python, which is this file too; what it holds itself, some 12 MB, is the least that can be measured.
"""

from __future__ import annotations

import json
import os
import signal
import subprocess
import sys
import tempfile
import threading
import time
from dataclasses import dataclass


@dataclass(frozen=True)
class Measured:
    """What a command took.

    Parameters
    ----------
    seconds, processor_seconds : float
        Wall time from its start to its end, and time on all processors.
    memory : int
        Its highest resident size, bytes.
    failure : str, optional
        Why it has no result: its last words, or that it was stopped. None if it ended well.
    stdout : str
        What it wrote.
    """

    seconds: float
    processor_seconds: float
    memory: int
    failure: str | None
    stdout: str


def measure(command: list[str], limit: float) -> Measured:
    """Run a command to its end, or stop it after `limit` seconds."""
    starter = [sys.executable, "-IS", __file__, str(limit), *command]
    done = subprocess.run(starter, capture_output=True, text=True, check=True)
    return Measured(**json.loads(done.stdout))


def _run(command: list[str], limit: float) -> Measured:
    was_stopped = threading.Event()
    with tempfile.TemporaryFile("w+b") as stdout, tempfile.TemporaryFile("w+b") as stderr:
        began = time.perf_counter()
        # A session of its own, so that what it starts is stopped with it.
        process = subprocess.Popen(command, stdin=subprocess.DEVNULL, stdout=stdout, stderr=stderr, start_new_session=True)

        def stop() -> None:
            was_stopped.set()
            os.killpg(process.pid, signal.SIGKILL)

        timer = threading.Timer(limit, stop)
        timer.start()
        try:
            _, status, usage = os.wait4(process.pid, 0)
        except BaseException:
            os.killpg(process.pid, signal.SIGKILL)
            raise
        finally:
            timer.cancel()
        seconds = time.perf_counter() - began
        process.returncode = os.waitstatus_to_exitcode(status)
        stdout.seek(0)
        stderr.seek(0)
        words = stderr.read().decode(errors="replace").strip().splitlines() or ["nothing"]
        failure = None
        if was_stopped.is_set():
            failure = f"stopped after {limit:.0f} s"
        elif process.returncode != 0:
            failure = f"exit code {process.returncode}, and said: {words[-1]}"
        return Measured(seconds, usage.ru_utime + usage.ru_stime, 1024 * usage.ru_maxrss, failure, stdout.read().decode())


if __name__ == "__main__":
    print(json.dumps(_run(sys.argv[2:], float(sys.argv[1])).__dict__))
