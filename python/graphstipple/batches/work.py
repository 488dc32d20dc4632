"""One photo. In: a task; out: its files in the output, with hashes, counts and times, or the sentence that says what is wrong.

This is all that a worker does, in a process of this machine or on another: it is imported there without NumPy. The bytes of a file
are those that the command line writes, by the same code.
"""

from __future__ import annotations

import os
import signal
import stat
import time
from collections.abc import Callable
from dataclasses import dataclass, field, replace
from functools import lru_cache
from typing import Any, Literal, TypeAlias

from graphstipple import _core
from graphstipple._errors import GraphStippleError
from graphstipple.batches.addresses import is_address, opened, reason, shown
from graphstipple.batches.manifest import Earlier
from graphstipple.batches.memory import needed
from graphstipple.batches.store import OutputLostError, Store, hash_of

MOST_BYTES = 1 << 31
"""Bytes of a photo's file: it is in memory whole."""


@dataclass(frozen=True)
class Recipe:
    """How every photo is drawn and written.

    Parameters
    ----------
    flags : tuple of str
        As the command line has them.
    suffixes : tuple of str
        The formats.
    map : bytes, optional
        The file of an importance map, which goes with the recipe to other machines.
    """

    flags: tuple[str, ...]
    suffixes: tuple[str, ...]
    map: bytes | None = field(default=None, repr=False)


@dataclass(frozen=True)
class Task:
    """A photo to draw.

    Parameters
    ----------
    address : str
        Its path or its address.
    names : tuple of str
        The names of its drawings, one for each format.
    data : bytes, optional
        The bytes of its file, where the worker cannot open it.
    earlier : Earlier, optional
        What an earlier run has made of it.
    """

    address: str = field(repr=False)
    names: tuple[str, ...]
    data: bytes | None = field(default=None, repr=False)
    earlier: Earlier | None = None


@dataclass
class Done:
    """What came of a photo.

    Parameters
    ----------
    kind : {"drawn", "kept", "failed", "lost", "large"}
        Drawn; kept as an earlier run has left it; failed; the output is lost, so that no other photo can be drawn either; or it
        needs more memory than was granted.
    """

    kind: Literal["drawn", "kept", "failed", "lost", "large"]
    photo_hash: str | None = None
    outputs: dict[str, str] = field(default_factory=dict)
    counts: dict[str, int] = field(default_factory=dict)
    seconds: float = 0.0
    warnings: list[str] = field(default_factory=list)
    sentence: str = ""
    bytes_needed: int = 0


Work: TypeAlias = "Callable[[Task, int], Done]"
"""What a worker does with a task and the memory that it is granted."""


@dataclass(frozen=True)
class Drawing:
    """The work of drawing photos: a function that can be sent to other processes.

    Parameters
    ----------
    recipe : Recipe
        How.
    store : Store
        Where to.
    """

    recipe: Recipe
    store: Store

    def __call__(self, task: Task, granted: int) -> Done:
        """Draw a photo with so many bytes of memory."""
        began = time.perf_counter()
        done = Done("failed")
        try:
            self._draw(task, granted, done)
        except OutputLostError as error:
            done.kind, done.sentence = "lost", str(error)
        except GraphStippleError as error:
            name, sentence = shown(task.address), shown(str(error))
            # What is wrong with a drawing is said without the photo's name.
            done.sentence = sentence if sentence.startswith(name) else f"{name}: {sentence}"
        except MemoryError:
            done.sentence = f"{shown(task.address)}: there is not enough memory"
        except OSError as error:
            done.sentence = f"{shown(task.address)}: {reason(error)}"
        except Exception as error:  # a defect, or of a file system: it is one photo's, and the others go on
            done.sentence = f"{shown(task.address)}: {type(error).__name__}: {reason(error)}"
        done.seconds = round(time.perf_counter() - began, 4)
        return done

    def _draw(self, task: Task, granted: int, done: Done) -> None:
        self.store.check(task.names)
        data = read(task.address) if task.data is None else task.data
        done.photo_hash = hash_of(data)
        if is_kept(task.earlier, done.photo_hash, self.store):
            done.kind = "kept"
            done.outputs = task.earlier.outputs if task.earlier else {}
            return
        recipe = _made(self.recipe)
        wanted = needed(data, recipe.options)
        if wanted is None or wanted > granted:
            done.kind, done.bytes_needed = "large", -1 if wanted is None else wanted
            return
        files, stats, done.warnings = recipe.draw(shown(task.address), data)
        self.store.write(dict(zip(task.names, files, strict=True)))
        done.outputs = {name: hash_of(file) for name, file in zip(task.names, files, strict=True)}
        done.counts = {name: value for name, value in stats.items() if isinstance(value, int)}
        done.kind = "drawn"


def is_kept(earlier: Earlier | None, photo_hash: str, store: Store) -> bool:
    """Whether a photo was drawn already, and its drawings are as they were written."""
    if earlier is None or earlier.photo_hash != photo_hash:
        return False
    return all(store.hash_of(name) == recorded for name, recorded in earlier.outputs.items())


def packed(task: Task, store: Store) -> Task | Done:
    """Return a task for workers that do not see the files of this machine, or what comes of it without them."""
    if is_address(task.address):
        return task
    try:
        data = read(task.address)
    except OSError as error:
        return Done("failed", sentence=f"{shown(task.address)}: {reason(error)}")
    photo_hash = hash_of(data)
    if task.earlier is not None and is_kept(task.earlier, photo_hash, store):
        return Done("kept", photo_hash, task.earlier.outputs)
    return replace(task, data=data, earlier=None)


def read(address: str) -> bytes:
    """Return the bytes of a photo's file.

    Raises
    ------
    OSError
        If it cannot be read.
    """
    if is_address(address):
        file_system, path = opened(address)
        with file_system.open(path, "rb") as remote:
            return _whole(remote.read(MOST_BYTES + 1))
    # What is no file may have no end, or nobody who writes it.
    with open(os.open(address, os.O_RDONLY | getattr(os, "O_NONBLOCK", 0) | getattr(os, "O_BINARY", 0)), "rb") as file:  # noqa: PTH123  # of a descriptor
        mode = os.fstat(file.fileno()).st_mode
        if stat.S_ISDIR(mode):
            raise IsADirectoryError
        if not stat.S_ISREG(mode):
            raise OSError("this is no file")
        return _whole(file.read(MOST_BYTES + 1))


def _whole(data: bytes) -> bytes:
    if len(data) > MOST_BYTES:
        raise OSError(f"the file is too large: at most {MOST_BYTES >> 30} GiB are read")
    return data


@lru_cache(maxsize=4)
def _made(recipe: Recipe) -> _core.Recipe:
    """Return what draws by a recipe; a worker has the same for all photos."""
    return _core.Recipe(recipe.flags, recipe.suffixes, recipe.map)


def begin() -> int:
    """Begin as a worker of this machine, and return the number of the process.

    Ctrl-C and SIGTERM, which may come to the whole group, are for the one who waits for workers; when that one is gone, they go
    too.
    """
    import multiprocessing  # noqa: PLC0415  # other workers have no parent
    import threading  # noqa: PLC0415

    for number in (signal.SIGINT, signal.SIGTERM):
        signal.signal(number, signal.SIG_IGN)
    parent = multiprocessing.parent_process()
    if parent is not None and not _begun:
        threading.Thread(target=_end_with, args=(parent,), daemon=True).start()
        _begun.append(True)
    return os.getpid()


_begun: list[bool] = []


def _end_with(parent: Any) -> None:
    parent.join()
    os._exit(1)
