"""The command `graphstipple-eval`, and what commands that print tables share with it."""

from __future__ import annotations

import argparse
import os
import shutil
import sys
from collections.abc import Callable, Sequence
from concurrent.futures import BrokenExecutor
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import NoReturn

import numpy as np

import graphstipple as gs
from graphstipple.metrics import Comparison
from graphstipple_eval import files, photos, report, run
from graphstipple_eval.photos import PhotoFile
from graphstipple_eval.results import Failure, Result
from graphstipple_eval.selection import Selection, parse_budget, parse_names, parse_sweeps

DONE, FAILED, USAGE, INTERRUPTED = 0, 1, 2, 130
"""Exit codes."""


class _Parser(argparse.ArgumentParser):
    def error(self, message: str) -> NoReturn:
        """Say in one line what is wrong, without the usage."""
        raise gs.InvalidInputError(f"{message} (see graphstipple-eval --help)")


def _parser() -> argparse.ArgumentParser:
    parser = _Parser(prog="graphstipple-eval", description="Compare methods and settings on photos; write a report in HTML.")
    parser.add_argument("photos", nargs="+", type=Path, metavar="FOLDER|FILE", help="folders of photos, or single photos")
    parser.add_argument(
        "--size", default="512", metavar="PIXELS[,...]", help="longest sides that photos are reduced to (default: %(default)s)"
    )
    parser.add_argument("--methods", default="all", metavar="NAME[,...]", help="names of methods (default: %(default)s)")
    parser.add_argument("--out", type=Path, default=Path("report"), metavar="FOLDER", help="the report (default: %(default)s)")
    parser.add_argument(
        "--budget",
        default="coordinates",
        metavar="coordinates|marks|N",
        help="dots of stippling methods: as many as the default drawing has coordinates or marks, or a number, to which the "
        "coordinates of our own drawings are brought too (default: %(default)s)",
    )
    parser.add_argument(
        "--sweep", action="append", default=[], metavar="OPTION=VALUE,...", help="also draw with these values of an option"
    )
    parser.add_argument("--jobs", default=None, metavar="N", help="processes (default: one a core)")
    return parser


def main(arguments: Sequence[str] | None = None) -> int:
    """Run the command and return its exit code.

    Parameters
    ----------
    arguments : sequence of str, optional
        By default the program's.
    """
    try:
        return _evaluate(_parser().parse_args(arguments))
    except gs.GraphStippleError as error:
        return _ended(USAGE, str(error))
    except OSError as error:
        return _ended(FAILED, f"a file cannot be read or written: {error}")
    except BrokenExecutor:
        return _ended(
            FAILED, "a process was ended from outside, perhaps for want of memory: try fewer --jobs; what is done is kept"
        )
    except KeyboardInterrupt:
        return _ended(INTERRUPTED, "interrupted; what is done is kept, and the same command goes on from there")


def _ended(code: int, message: str) -> int:
    print(f"graphstipple-eval: {message}", file=sys.stderr)
    return code


def _evaluate(arguments: argparse.Namespace) -> int:
    sizes = list(dict.fromkeys(_whole("--size", text, Comparison.LEAST_SIDE) for text in arguments.size.split(",")))
    jobs = os.cpu_count() or 1 if arguments.jobs is None else _whole("--jobs", arguments.jobs, 1)
    selection = Selection(parse_names(arguments.methods), parse_sweeps(arguments.sweep), parse_budget(arguments.budget))
    root: Path = arguments.out
    check_out(root)
    # Without the weights of LPIPS, this fails now and not after the first drawing.
    Comparison(np.zeros((Comparison.LEAST_SIDE, Comparison.LEAST_SIDE)))
    decoded = photos.decode(photos.find(arguments.photos), sizes, Comparison.LEAST_SIDE, root / report.PICTURES)
    mark(root)
    prepared = photos.write(decoded)
    outcome = run_and_show(prepared, selection, root, jobs)
    index = report.write(root, prepared, selection, outcome)
    print(f"{_pictures(len(outcome.results))}, {outcome.kept} of them from before: {index}")
    if outcome.failures:
        first = outcome.failures[0]
        example = f"{first.method} on {first.photo} at {first.size}: {first.reason}"
        return _ended(FAILED, f"{_pictures(len(outcome.failures))} failed, as the report says; for example {example}")
    return DONE


def _pictures(count: int) -> str:
    return "1 picture" if count == 1 else f"{count} pictures"


def _whole(name: str, text: str, least: int) -> int:
    if not text.isdecimal() or int(text) < least:
        raise gs.InvalidInputError(f"{name} is {text!r}, but it must be a whole number of at least {least}")
    return int(text)


def mark(root: Path) -> None:
    """Say in a folder that it is a report, whole or to be."""
    files.write(root / report.MARKER, b"This folder is a report of graphstipple-eval, which writes and deletes files here.\n")


def check_out(root: Path) -> None:
    """Refuse to spread a report over a folder of other things, or where nothing can be written."""
    there = next(path for path in (root.absolute(), *root.absolute().parents) if path.exists())
    if not there.is_dir():
        raise gs.InvalidInputError(f"--out is {root}, but {there} is a file: give a folder")
    if not os.access(there, os.W_OK | os.X_OK):
        raise gs.InvalidInputError(f"--out is {root}, but {there} cannot be written to: give another folder")
    if root.is_dir() and any(root.iterdir()) and not (root / report.MARKER).is_file():
        raise gs.InvalidInputError(f"--out is {root}, but that folder holds other things than a report: give another one")


def run_and_show(prepared: Sequence[PhotoFile], selection: Selection, root: Path, jobs: int) -> run.Outcome:
    """Make and measure all pictures that are not there yet, in so many processes, and show progress (`run.run`)."""
    try:
        with run.processes(jobs) as pool:
            outcome = run.run(prepared, selection, root, pool, show)
    finally:
        if sys.stderr.isatty():
            print(file=sys.stderr)
    return outcome


def all_made(paths: Sequence[Path], size: int, selection: Selection, root: Path, jobs: int) -> tuple[list[PhotoFile], run.Outcome]:
    """Draw photos and measure everything that is not in the folder yet.

    Raises
    ------
    GraphStippleError
        If a photo cannot be taken, or a picture could not be made.
    """
    prepared = photos.write(photos.decode(paths, [size], Comparison.LEAST_SIDE, root / report.PICTURES))
    outcome = run_and_show(prepared, selection, root, jobs)
    if outcome.failures:
        failure = outcome.failures[0]
        raise gs.GraphStippleError(f"{failure.method} failed on {failure.photo}: {failure.reason}")
    return prepared, outcome


def print_tables(
    name: str,
    description: str,
    tables: Callable[[Sequence[Path], int, Path, int], str],
    kept: str,
    arguments: Sequence[str] | None,
) -> None:
    """Run a command that prints tables in Markdown, and keeps them as `NAME.md`, with the pictures, if a folder is given.

    Parameters
    ----------
    name, description : str
        The module's name, and what it does.
    tables : callable
        Returns the tables of places of photos, their size, the folder of the pictures and a number of processes.
    kept : str
        What is kept in the folder, for the help.
    arguments : sequence of str, optional
        By default the program's.

    Raises
    ------
    SystemExit
        If there is something wrong with the arguments or the photos, or a picture cannot be made; with one sentence.
    """
    parser = argparse.ArgumentParser(prog=f"python -m graphstipple_eval.{name}", description=description)
    parser.add_argument("photos", nargs="+", type=Path, metavar="FOLDER|FILE", help="folders of photos, or single photos")
    parser.add_argument("--size", type=int, default=512, help="longest side that photos are reduced to (default: %(default)s)")
    parser.add_argument("--jobs", type=int, default=2, help="processes (default: %(default)s)")
    parser.add_argument(
        "--out",
        type=Path,
        metavar="FOLDER",
        help=f"also write {kept} there, and keep the pictures, so that another run makes only what has changed",
    )
    given = parser.parse_args(arguments)
    try:
        with TemporaryDirectory() as temporary:
            text = tables(given.photos, given.size, given.out or Path(temporary), given.jobs)
    except gs.GraphStippleError as error:
        sys.exit(f"{name}: {error}")
    print(text, end="")
    if given.out is not None:
        files.write(given.out / f"{name}.md", text.encode())


def show(done: int, of_all: int, task: run.Task, entry: Result | Failure) -> None:
    """Show progress on standard error: one line that changes on a terminal, else a line a picture."""
    took = f"{entry.seconds:.1f} s" if isinstance(entry, Result) else f"failed: {entry.reason}"
    line = f"[{done}/{of_all}] {task.method}, {task.photo.name} at {task.photo.size}: {took}"
    if not sys.stderr.isatty():
        # With its end in one write: an interruption between two would put its message behind the line.
        print(f"{line}\n", end="", file=sys.stderr, flush=True)
        return
    width = shutil.get_terminal_size().columns
    print(f"\r\x1b[K{line[: width - 1]}", end="", file=sys.stderr, flush=True)
