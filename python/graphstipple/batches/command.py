"""``graphstipple batch``: many photos by one command. In: arguments; out: the exit code.

0 all are drawn, 1 some failed or the batch could not go on, 2 wrong usage, 128 and the number of the signal that stopped it.
How photos are drawn and written is said by the flags of a single drawing, which the native command line declares and checks.
"""

from __future__ import annotations

import argparse
import contextlib
import sys
from collections.abc import Iterator, Sequence
from pathlib import Path
from typing import Any

from graphstipple import _core
from graphstipple._errors import GraphStippleError, ImageFileError, ImageFileNotFoundError, InvalidInputError
from graphstipple._subcommand import FAILURE, USAGE, Parser, stopped_by_signals, tell
from graphstipple.batches import engines, sheet
from graphstipple.batches.addresses import reason
from graphstipple.batches.local import Stop
from graphstipple.batches.progress import Progress
from graphstipple.batches.run import MANIFEST, Asked, BatchResult, Engine, Run

BY_SIGNAL = 128
"""The exit code above which there are those of signals."""

SENTENCES = 5
"""Of photos that failed, at the end: the manifest has all."""

STANDARD = "-"
"""Standard input."""


class _Flag(argparse.Action):
    """A flag of a single drawing, kept with its value in the order of the command line."""

    def __call__(
        self, parser: argparse.ArgumentParser, given: argparse.Namespace, values: Any, option_string: str | None = None
    ) -> None:
        """Keep it."""
        value = () if self.nargs == 0 else (values,)
        given.flags = [*given.flags, (self.dest.replace("_", "-"), *value)]


class _HelpAll(argparse.Action):
    """Print the help of every flag."""

    def __call__(
        self, parser: argparse.ArgumentParser, given: argparse.Namespace, values: Any, option_string: str | None = None
    ) -> None:
        """Print it and exit."""
        _parser(with_all=True).print_help()
        parser.exit()


def main(arguments: list[str]) -> int:
    """Run the command and return its exit code."""
    given = _parser(with_all=False).parse_intermixed_args(arguments)
    try:
        return _run(given)
    except (GraphStippleError, OSError) as error:
        sentence = str(error).replace("allow_damaged", "--allow-damaged").replace("force=True", "--force")
        tell("error", sentence)
        return USAGE if isinstance(error, InvalidInputError) else FAILURE


def _parser(*, with_all: bool) -> Parser:
    parser = Parser(
        prog="graphstipple batch",
        usage="graphstipple batch PHOTO ... -o OUTPUT [OPTIONS]",
        description="Draws many photos, in processes of this machine or on a cluster. What was done already, with the same photo, "
        "options and version, is not done again.",
        epilog=None if with_all else "More options, for those who want to know exactly: --help-all",
        allow_abbrev=False,
        add_help=False,
    )
    parser.set_defaults(flags=[])
    files = parser.add_argument_group("Photos and drawings")
    files.add_argument(
        "photos",
        nargs="*",
        metavar="PHOTO",
        help='photo, folder, glob in quotes such as "photos/**/*.jpg", or an address of fsspec such as s3://bucket/photos',
    )
    files.add_argument(
        "--from",
        dest="lists",
        action="append",
        default=[],
        metavar="FILE",
        help="list of photos, one a line; - reads standard input",
    )
    files.add_argument(
        "-o",
        "--output",
        required=True,
        metavar="OUTPUT",
        help="folder to write to, or an address of one; it has the tree of the photos",
    )
    suffixes = ", ".join(suffix for suffix, *_ in _core.formats())
    files.add_argument("--format", default="svg", metavar="LIST", help=f"formats with commas, of {suffixes} [default svg]")
    files.add_argument("--no-recursive", dest="recursive", action="store_false", help="leave out folders in folders")
    files.add_argument(
        "--manifest", metavar="FILE", help=f"file that gets a line for every photo [default {MANIFEST} in the output]"
    )
    files.add_argument("--redo", action="store_true", help="do again what is done already")
    files.add_argument("--sheet", metavar="FILE", help="page of HTML to write, with photos and drawings beside each other")
    load = parser.add_argument_group("Load")
    load.add_argument(
        "-j",
        "--processes",
        type=_count,
        metavar="N",
        help="most processes; with their threads no more than there are cores [default the cores]",
    )
    load.add_argument(
        "--memory",
        metavar="SIZE",
        help="what photos may take at the same time, such as 8GB; with a scheduler, one photo [default half of the machine's]",
    )
    where = parser.add_argument_group("Other machines (pip install graphstipple[dask])")
    where.add_argument(
        "--scheduler", metavar="ADDRESS", help="scheduler of Dask whose workers draw, such as tcp://host:8786 or tls://host:8786"
    )
    where.add_argument("--cluster", choices=["local"], help="begin a cluster of Dask on this machine, for a start")
    where.add_argument("--dashboard", action="store_true", help="with --cluster: also the dashboard of Dask, on this machine")
    for name, what in (("ca", "certificate of the authority"), ("cert", "own certificate"), ("key", "key of the own certificate")):
        where.add_argument(f"--tls-{name}", metavar="FILE", help=f"{what}, for tls:// [default as Dask is configured]")
    others = parser.add_argument_group("Print")
    others.add_argument("--quiet", action="store_true", help="show no progress")
    others.add_argument("-h", "--help", action="help", help="print this help")
    others.add_argument("--help-all", action=_HelpAll, nargs=0, help="print the help of every option")
    groups: dict[str, Any] = {}
    for name, value_name, text, heading, is_everyday in _core.flags(with_all):
        title = "The drawings" if heading == "To begin with" else heading
        group = groups.setdefault(title, None) or parser.add_argument_group(title)
        groups[title] = group
        shown = text.replace("%", "%%") if with_all or is_everyday else argparse.SUPPRESS
        takes = {"metavar": value_name} if value_name else {"nargs": 0}
        group.add_argument(f"--{name}", action=_Flag, help=shown, **takes)
    return parser


def _count(text: str) -> int:
    if not (text.isascii() and text.isdecimal() and 1 <= int(text) <= 1 << 16):
        raise argparse.ArgumentTypeError(f"it is {text}, but it must be a whole number, at least 1")
    return int(text)


def _run(given: argparse.Namespace) -> int:
    run = Run(_asked(given))
    if run.warning:
        tell("warning", run.warning)
    # Before this, Ctrl-C is not waited for.
    with _stopping() as (stop, stopped_by):
        engine, threads = _engine(given, run, stop)
        run.begin()
        code = _drawn(given, run, engine, threads)
    return BY_SIGNAL + stopped_by[0] if stopped_by else code


def _drawn(given: argparse.Namespace, run: Run, engine: Engine, threads: int) -> int:
    """Draw, tell how far it is and what came of it, and return the exit code."""
    results: list[BatchResult] = []
    failures: list[str] = []
    warnings: list[str] = []
    counts = {"drawn": 0, "kept": 0, "failed": 0, "warned": 0}
    try:
        with Progress(len(run.photos), quiet=given.quiet) as progress, contextlib.closing(run.results(engine, threads)) as coming:
            for result in coming:
                progress.count(kept=result.kept, failed=result.error is not None)
                counts["failed" if result.error is not None else "kept" if result.kept else "drawn"] += 1
                failures += [result.error] if result.error is not None and len(failures) < SENTENCES else []
                counts["warned"] += len(result.warnings)
                told = result.warnings if len(warnings) < SENTENCES else []
                warnings += [it if result.photo in it else f"{result.photo}: {it}" for it in told]
                if given.sheet is not None:
                    results.append(result)
    finally:
        if given.sheet is not None and results:
            sheet.write(given.sheet, given.output, results)
    return _told(run, counts, failures, warnings, quiet=given.quiet)


def _told(run: Run, counts: dict[str, int], failures: Sequence[str], warnings: Sequence[str], *, quiet: bool) -> int:
    """Say what came of a run, and return its exit code."""
    if not quiet:
        words = ", ".join(f"{count} {name}" for name, count in counts.items() if count and name != "warned")
        tell("done", f"{words or 'nothing drawn'}: {run.manifest}")
    for warning in warnings[:SENTENCES]:
        tell("warning", warning)
    if counts["warned"] > SENTENCES:
        tell("warning", f"there are {counts['warned']} warnings; {run.manifest} has all")
    if not counts["failed"]:
        return 0
    tell("error", f"{counts['failed']} of {len(run.photos)} photos failed; {run.manifest} says why, and the first are:")
    for sentence in failures:
        tell("error", sentence.replace("allow_damaged", "--allow-damaged").replace("force=True", "--force"))
    return FAILURE


def _asked(given: argparse.Namespace) -> Asked:
    if not given.photos and not given.lists:
        raise InvalidInputError("there is no photo to draw: name photos, folders or globs, or a list by --from")
    if given.sheet is not None and not Path(given.sheet).absolute().parent.is_dir():
        raise ImageFileNotFoundError(f"{given.sheet}: the folder of the sheet does not exist")
    return Asked(
        named=given.photos,
        lines=_lines(given.lists),
        output=given.output,
        flags=given.flags,
        suffixes=[suffix.strip().removeprefix(".") for suffix in given.format.split(",")],
        recursive=given.recursive,
        manifest=given.manifest,
        redo=given.redo,
        others=[given.sheet] if given.sheet is not None else [],
    )


def _lines(lists: Sequence[str]) -> Iterator[str]:
    """Yield the lines of lists; names of files may hold bytes that no text has."""
    for path in lists:
        try:
            if path == STANDARD:
                yield from (line.decode("utf-8", "surrogateescape") for line in sys.stdin.buffer)
            else:
                with open(path, encoding="utf-8", errors="surrogateescape", newline="\n") as file:  # noqa: PTH123  # as it is named
                    yield from file
        except OSError as error:
            raise ImageFileError(f"{path}: the list cannot be read ({reason(error)})") from error


def _engine(given: argparse.Namespace, run: Run, stop: Stop) -> tuple[Engine, int]:
    """Return what draws, and on how many threads each drawing is made."""
    memory = None if given.memory is None else engines.memory_of(given.memory)
    if given.scheduler is not None and given.cluster is not None:
        raise InvalidInputError("--scheduler and --cluster are given, but the one or the other draws")
    if given.dashboard and given.cluster is None:
        raise InvalidInputError("--dashboard is given, but it must be left out unless --cluster is given")
    tls = (given.tls_ca, given.tls_cert, given.tls_key)
    if any(tls) and not (all(tls) and given.scheduler is not None):
        raise InvalidInputError("--tls-ca, --tls-cert and --tls-key belong together, with --scheduler")
    if given.scheduler is not None:
        if given.processes is not None:
            raise InvalidInputError("--processes is given, but workers of a scheduler are as many as there are")
        return engines.on_scheduler(given.scheduler, memory, stop, tls if all(tls) else None), 1
    processes, threads = engines.shares(len(run.photos), given.processes, run.threads)
    if given.cluster is not None:
        return engines.on_local_cluster(processes, memory, stop, dashboard=given.dashboard), threads
    return engines.on_this_machine(processes, memory, stop), threads


@contextlib.contextmanager
def _stopping() -> Iterator[tuple[Stop, list[int]]]:
    """Let signals end the run: after the photos that are being drawn; the second time, at once."""
    stop, stopped_by = Stop(), list[int]()

    def ask(number: int, frame: object) -> None:
        if not stop.asked:
            tell("stopping", "what is being drawn is drawn to the end; once more drops it")
        stop.ask()
        stopped_by.append(number)

    with stopped_by_signals(ask):
        yield stop, stopped_by
