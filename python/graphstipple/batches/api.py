"""`batch`: many photos in, what came of each out, as it comes."""

from __future__ import annotations

import os
from collections.abc import Iterable, Iterator, Mapping
from pathlib import Path
from typing import TYPE_CHECKING, Any

from graphstipple import _core
from graphstipple._errors import InvalidInputError
from graphstipple._flags import flat, of_options, of_settings
from graphstipple.batches import engines
from graphstipple.batches.local import Stop
from graphstipple.batches.run import Asked, BatchResult, Run
from graphstipple.drawing import RecordedOptions, known, plain_settings
from graphstipple.options import Options

if TYPE_CHECKING:
    from distributed import Client


def batch(
    photos: str | os.PathLike[str] | Iterable[str | os.PathLike[str]],
    output: str | os.PathLike[str],
    options: Options | RecordedOptions | None = None,
    importance: str | os.PathLike[str] = "saliency",
    *,
    subject: str | None = None,
    formats: Iterable[str] = ("svg",),
    settings: Mapping[str, Any] | None = None,
    recursive: bool = True,
    processes: int | None = None,
    memory: int | str | None = None,
    manifest: str | os.PathLike[str] | None = None,
    redo: bool = False,
    scheduler: str | Client | None = None,
) -> Iterator[BatchResult]:
    """Draw many photos, and yield what came of each as it is done.

    The files are those that `draw` and `Drawing.save` give, under the names of the photos. What an earlier call has drawn, with the
    same photo, options and version, is kept; a photo that cannot be drawn is told in its result, and the others go on. Everything
    that can be checked is, when this is called. Processes are started when the first result is asked for, by importing the script
    that runs: so a script calls this under ``if __name__ == "__main__":``.

    Parameters
    ----------
    photos : str, path, or iterable of them
        Photos, folders, globs such as ``"photos/**/*.jpg"``, and addresses of fsspec such as ``"s3://bucket/photos"``.
    output : str or path
        A folder, or an address of one. It has the tree of the folders that are drawn.
    options : Options, optional
        By default ``Options()``.
    importance : str or path
        A name, or the file of a map, as for `draw`.
    subject : str, optional
        "auto": what the rest of every photo steps back from, as `backdrop` of the options says.
    formats : iterable of str
        The suffixes of the files that are written of every drawing.
    settings : mapping, optional
        Settings of `Drawing.save` by name, and what else the command line takes: `min_dot`, `max_bytes`, `max_points`, which are
        about the first format, `max_pixels`, `allow_damaged`, `force`.
    recursive : bool
        Whether folders in folders are drawn.
    processes : int, optional
        The most processes that draw, by default as many as there are cores. Each has `threads` of the options, or its share of the
        cores.
    memory : int or str, optional
        What photos that are drawn at the same time may take, such as "8GB", by default half of the machine's memory. With a
        scheduler, what one photo may take, by default what the limit of a worker leaves for each of its threads.
    manifest : str or path, optional
        The file that gets a line for every photo, by default ``manifest.jsonl`` in the output; in the working folder, if the output
        is an address.
    redo : bool
        Whether what is done already is done again.
    scheduler : str or distributed.Client, optional
        A scheduler of Dask whose workers draw, instead of processes of this machine.

    Yields
    ------
    BatchResult

    Raises
    ------
    InvalidInputError
        If an option breaks a rule, two photos would be drawn to one file, or there is no photo.
    ImageFileError
        If the output cannot be, or is full or gone, which ends the batch.
    MissingPackageError
        If a scheduler is given and Dask is not installed, or what an address needs is not.
    """
    values, usual = flat(known(options)._checked.values()), flat(_core.Options({}).values())
    words = of_options({name: value for name, value in values.items() if value != usual[name]})
    text = os.fspath(importance)
    if text != "saliency" or not isinstance(importance, str):
        # A path is no name, even where it looks like one.
        words += ["--importance", text if isinstance(importance, str) else str(Path(text).absolute())]
    if subject is not None:
        words += ["--subject", os.fspath(subject)]
    words += of_settings(plain_settings(settings or {}))
    named = [photos] if isinstance(photos, str | os.PathLike) else photos
    asked = Asked(
        named=[os.fspath(name) for name in named],
        output=os.fspath(output),
        flags=_told_apart(words),
        suffixes=[suffix.removeprefix(".") for suffix in ([formats] if isinstance(formats, str) else formats)],
        recursive=recursive,
        manifest=None if manifest is None else os.fspath(manifest),
        redo=redo,
    )
    bytes_ = None if memory is None else engines.memory_of(memory)
    run = Run(asked)
    if scheduler is not None:
        engine, threads = engines.on_scheduler(scheduler, bytes_, Stop()), 1
    else:
        count, threads = engines.shares(len(run.photos), processes, run.threads)
        engine = engines.on_this_machine(count, bytes_, Stop())
    run.begin()
    return run.results(engine, threads)


def _told_apart(words: list[str]) -> list[tuple[str, ...]]:
    """Return words as flags with their values.

    Raises
    ------
    InvalidInputError
        If there is no such flag.
    """
    takes = {name: bool(value_name) for name, value_name, *_ in _core.flags(False)}
    flags: list[tuple[str, ...]] = []
    rest = iter(words)
    for word in rest:
        name = word.removeprefix("--")
        if name not in takes:
            raise InvalidInputError(f"there is no setting {name.replace('-', '_')!r}")
        flags.append((name, next(rest)) if takes[name] else (name,))
    return flags
