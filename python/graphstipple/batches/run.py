"""A run. In: what is named, how it is drawn, where to; out: what came of each photo, as it comes, and the manifest.

All that can be told before anything is drawn is told then: flags, names that collide, an output that cannot be.
"""

from __future__ import annotations

import contextlib
from collections.abc import Callable, Generator, Iterable, Iterator, Sequence
from dataclasses import dataclass, field, replace
from pathlib import Path
from typing import Any, TypeAlias

from graphstipple import _core
from graphstipple._errors import ImageFileError, InvalidInputError
from graphstipple._flags import METHOD, flat
from graphstipple.batches import names, sources, work
from graphstipple.batches.addresses import reason, shown
from graphstipple.batches.manifest import Manifest
from graphstipple.batches.store import OutputLostError, Store, hash_of
from graphstipple.batches.work import Done, Drawing, Recipe, Task

MANIFEST = "manifest.jsonl"
"""The manifest, in the output, or in the working folder if the output is no folder."""

NOT_RECORDED = ("threads", "force")
"""Flags that make no difference to a drawing."""

Engine: TypeAlias = "Callable[[Iterator[Task], Drawing], Iterator[tuple[Task, Done]]]"
"""What has tasks done."""


@dataclass(frozen=True)
class BatchResult:
    """What came of a photo.

    Parameters
    ----------
    photo : str
        Its path, or its address without credentials.
    outputs : tuple of str
        The names of its drawings in the output, one for each format; none if it failed.
    counts : dict
        What was counted, as in `Drawing.stats`; nothing of what an earlier run has drawn.
    seconds : float
        How long it took.
    warnings : list of str
        Sentences of the kind of `GraphStippleWarning`.
    error : str or None
        The sentence that says why it failed.
    kept : bool
        Whether an earlier run has drawn it, so that there was nothing to do.
    """

    photo: str
    outputs: tuple[str, ...] = ()
    counts: dict[str, int] = field(default_factory=dict)
    seconds: float = 0.0
    warnings: list[str] = field(default_factory=list)
    error: str | None = None
    kept: bool = False


@dataclass(frozen=True)
class Asked:
    """What is asked for.

    Parameters
    ----------
    named : sequence of str
        Paths, folders, globs and addresses.
    lines : iterable of str
        Of lists of photos.
    output : str
        A folder or an address.
    flags : sequence of tuple of str
        How photos are drawn and written: names without hyphens, and values where they have one.
    suffixes : sequence of str
        The formats.
    recursive : bool
        Whether folders in folders are drawn.
    manifest : str, optional
        Where the manifest is.
    redo : bool
        Whether what an earlier run has done is done again.
    others : sequence of str
        Files of the run that no drawing may take the place of.
    """

    named: Sequence[str]
    output: str
    flags: Sequence[tuple[str, ...]] = ()
    suffixes: Sequence[str] = ("svg",)
    lines: Iterable[str] = ()
    recursive: bool = True
    manifest: str | None = None
    redo: bool = False
    others: Sequence[str] = ()


class Run:
    """A run that may begin: everything was checked that can be.

    Parameters
    ----------
    asked : Asked
        What is asked for.

    Raises
    ------
    InvalidInputError
        If a flag breaks a rule, names collide, or there is no photo.
    ImageFileError
        If a file cannot be read.
    """

    def __init__(self, asked: Asked) -> None:
        if len(set(asked.suffixes)) != len(asked.suffixes):
            raise InvalidInputError(f"the formats are {', '.join(asked.suffixes)}, but each must be named once")
        words = [word for flag in asked.flags for word in (f"--{flag[0]}", *flag[1:])]
        made = _core.Recipe(words, asked.suffixes)
        importance, self.warning = _map(asked.flags, made)
        self._recipe = Recipe(tuple(words), tuple(asked.suffixes), importance)
        if "{ink}" in asked.output:
            raise InvalidInputError(
                "the output of a batch is a folder, with a file for each photo and format: {ink} has no place in it"
            )
        self._store = Store(asked.output, made.force)
        folder = self._store.folder
        self.manifest = Path(asked.manifest) if asked.manifest is not None else Path(folder or ".", MANIFEST)
        self._redo = asked.redo
        self.threads: int | None = made.options.values()["threads"]
        self.photos = [*sources.find(asked.named, recursive=asked.recursive, output=asked.output), *sources.of_list(asked.lines)]
        if not self.photos:
            raise InvalidInputError("there is no photo to draw")
        maps = [flag[1] for flag in asked.flags if flag[0] == "importance"] if importance is not None else []
        output = asked.output if folder is None else str(folder)
        names.check(self.photos, asked.suffixes, output, [str(self.manifest), *asked.others, *maps])
        self._is_own_manifest = asked.manifest is None
        self._recorded = _recorded(asked.flags, made, importance)
        self._lines: Manifest | None = None

    def begin(self) -> Manifest:
        """Make the output's folder and open the manifest, if that is not done yet.

        Raises
        ------
        ImageFileError
            If one of them cannot be.
        InvalidInputError
            If the manifest is something else.
        """
        if self._lines is None:
            self._store.make()
            if self._is_own_manifest and self.manifest.is_symlink():
                raise InvalidInputError(f"{self.manifest}: a link leads out of the output")
            self._lines = Manifest(self.manifest, self._recorded)
        return self._lines

    def results(self, engine: Engine, threads: int = 1) -> Generator[BatchResult, None, None]:
        """Draw by an engine, and yield what came of each photo; `threads` is what each drawing is done on unless a flag says it.

        Raises
        ------
        OutputLostError
            If the output is full or gone.
        GraphStippleError
            If the engine cannot go on.
        """
        flags = self._recipe.flags if self.threads else (*self._recipe.flags, "--threads", str(threads))
        drawing = Drawing(replace(self._recipe, flags=flags), self._store)
        manifest = self.begin()
        with contextlib.ExitStack() as ending:
            ending.callback(manifest.close)
            ending.callback(self._store.sweep)
            done = engine(self._tasks(manifest), drawing)
            # Workers are ended before what they may have left is removed.
            ending.callback(getattr(done, "close", lambda: None))
            for task, came in done:
                if came.kind == "lost":
                    raise OutputLostError(came.sentence)
                result = BatchResult(
                    shown(task.address),
                    () if came.kind == "failed" else task.names,
                    came.counts,
                    came.seconds,
                    came.warnings,
                    came.sentence if came.kind == "failed" else None,
                    came.kind == "kept",
                )
                if not result.kept:
                    manifest.append(_record(result, came))
                yield result

    def _tasks(self, manifest: Manifest) -> Iterator[Task]:
        for photo in self.photos:
            outputs = names.of(photo.place, self._recipe.suffixes)
            yield Task(photo.address, outputs, earlier=None if self._redo else manifest.earlier(outputs))


def _record(result: BatchResult, done: Done) -> dict[str, Any]:
    """Return what the manifest says of a photo, besides options and version."""
    record: dict[str, Any] = {"photo": result.photo, "photo_hash": done.photo_hash}
    if result.error is not None:
        return {**record, "error": result.error, "seconds": done.seconds}
    record |= {"outputs": done.outputs, "counts": done.counts, "seconds": done.seconds}
    return {**record, "warnings": done.warnings} if done.warnings else record


def _map(flags: Iterable[tuple[str, ...]], recipe: _core.Recipe) -> tuple[bytes | None, str | None]:
    """Return the file of the importance map, if there is one, and what is to be said of it.

    Raises
    ------
    ImageFileError
        If it cannot be read.
    """
    named = [flag[1] for flag in flags if flag[0] == "importance"]
    kinds = [form for form, _ in _core.sources() if " " not in form]
    if not named or any(named[-1] == form or (":" in form and named[-1].startswith(form.split(":")[0] + ":")) for form in kinds):
        return None, None
    try:
        data = work.read(named[-1])
    except OSError as error:
        raise ImageFileError(f"{shown(named[-1])}: {reason(error)}") from error
    damaged = any(flag[0] == "allow-damaged" for flag in flags)
    reading = _core.Reading(recipe.options.background, recipe.options, _core.MAX_PIXELS, damaged)
    _, warning, _ = _core.read_photo(shown(named[-1]), reading, data)
    return data, warning


def _recorded(flags: Iterable[tuple[str, ...]], recipe: _core.Recipe, importance: bytes | None) -> dict[str, Any]:
    """Return what makes drawings what they are: options that differ from the defaults, and other flags as they were given."""
    usual, values = flat(_core.Options({}).values()), flat(recipe.options.values())
    recorded = {name: value for name, value in values.items() if value != usual[name] and name not in NOT_RECORDED}
    for name, *value in flags:
        plain = name.replace("-", "_")
        if plain not in values and plain not in (METHOD, *NOT_RECORDED):
            recorded[plain] = shown(value[0]) if value else True
    if importance is not None:
        recorded["importance_hash"] = hash_of(importance)
    return recorded
