"""Makes and measures the pictures of a run: one task a picture, spread over processes, with what is there already left as it is.

A task is one method on one photo at one size. Its process draws, writes the picture, reads it back and measures it. The last
photo's `Comparison` and `Flip` are kept, and tasks come photo by photo, so each process does the work on the photo alone once. The
default drawings come first: their counts are the budgets of stippling methods.
"""

from __future__ import annotations

import multiprocessing
import os
import signal
import threading
import time
from collections.abc import Callable, Iterator, Sequence
from concurrent.futures import Executor, ProcessPoolExecutor, as_completed
from contextlib import contextmanager
from dataclasses import asdict, dataclass
from functools import lru_cache
from multiprocessing import resource_tracker
from pathlib import Path

import cv2
import numpy as np
import numpy.typing as npt
from PIL import Image

import graphstipple as gs
from graphstipple.metrics import Comparison
from graphstipple_eval import evenness, files, ours, results
from graphstipple_eval.baselines import programs
from graphstipple_eval.flip import Flip
from graphstipple_eval.method import Method, Photo, Picture
from graphstipple_eval.photos import PhotoFile, png
from graphstipple_eval.results import Failure, Result
from graphstipple_eval.selection import Selection

ONE_THREAD = dict.fromkeys(("OMP_NUM_THREADS", "OPENBLAS_NUM_THREADS", "MKL_NUM_THREADS", "RAYON_NUM_THREADS"), "1")
"""Environment of the processes: seconds are those of one thread, and processes do not crowd each other out."""


@dataclass(frozen=True)
class Task:
    """A picture to make.

    Parameters
    ----------
    photo : PhotoFile
        The photo at its size.
    method : str
        Name of the method.
    dots : int
        The budget.
    code : str
        The fingerprint of the code.
    key : str
        The result's key.
    """

    photo: PhotoFile
    method: str
    dots: int
    code: str
    key: str

    @property
    def path(self) -> Path:
        """The result's JSON file; the picture's files have the same name with their own suffixes."""
        return self.photo.folder / f"{self.method}-{self.key}.json"


@dataclass(frozen=True)
class Outcome:
    """What a run came to: pictures in the order of photos and methods, failures, and how many pictures were there already."""

    results: tuple[Result, ...]
    failures: tuple[Failure, ...]
    kept: int


Progress = Callable[[int, int, Task, "Result | Failure"], None]
"""Called after every picture that was made: number done, number of all, the task, what came of it."""


def run(photos: Sequence[PhotoFile], selection: Selection, root: Path, executor: Executor, progress: Progress) -> Outcome:
    """Make and measure all pictures that are not there yet.

    Parameters
    ----------
    photos : sequence of PhotoFile
        The photos, at all sizes.
    selection : Selection
        The methods and their budget.
    root : Path
        The report's folder.
    executor : Executor
        Runs the tasks.
    progress : callable
        As `Progress`.

    Raises
    ------
    BrokenExecutor
        If a process ends before its task.
    OSError
        If a file cannot be written.
    """
    methods = selection.all()
    fingerprint, versions = results.fingerprint(), programs.versions()
    done: dict[tuple[PhotoFile, str], Result | Failure] = {}
    kept = 0

    def work(tasks: list[Task]) -> None:
        nonlocal kept
        to_do = []
        for task in tasks:
            result = results.load(task.path, root)
            if result is None:
                to_do.append(task)
            else:
                done[task.photo, task.method] = result
                kept += 1
        with _interrupts_kept_from_processes():
            futures = {executor.submit(make, task, selection, root): task for task in to_do}
        for future in as_completed(futures):
            task = futures[future]
            done[task.photo, task.method] = future.result()
            progress(len(done), len(photos) * len(methods), task, future.result())

    def task(photo: PhotoFile, method: Method, dots: int) -> Task:
        wanted = dots if method.is_budgeted else None
        key = results.key(photo.checksum, photo.size, method.name, wanted, fingerprint, versions.get(method.name))
        return Task(photo, method.name, dots, fingerprint, key)

    work([task(photo, methods[ours.DEFAULT], selection.dots(None) or 0) for photo in photos])
    others = []
    for photo in photos:
        default = done[photo, ours.DEFAULT]
        dots = selection.dots(default.counts if isinstance(default, Result) else None)
        for method in methods.values():
            if method.name == ours.DEFAULT:
                continue
            if dots is None and method.is_budgeted:
                reason = f"there is no budget, because {ours.DEFAULT} failed on this photo"
                done[photo, method.name] = Failure(photo.name, photo.size, method.name, reason)
            else:
                others.append(task(photo, method, dots or 0))
    work(others)

    ordered = [done[photo, name] for photo in photos for name in methods]
    made = tuple(entry for entry in ordered if isinstance(entry, Result))
    return Outcome(made, tuple(entry for entry in ordered if isinstance(entry, Failure)), kept)


@contextmanager
def _interrupts_kept_from_processes() -> Iterator[None]:
    """Keep Ctrl-C from processes that are started here: the terminal sends it to all, and this process alone should answer.

    They inherit that it is blocked. Here it waits meanwhile, and is not lost: other threads of this process do not block it, so it
    is noted too, and raised when the processes have all that they start with.
    """
    # Where it starts with the first process, it would unblock Ctrl-C.
    resource_tracker.ensure_running()
    noted: list[int] = []
    handler = signal.signal(signal.SIGINT, lambda number, _: noted.append(number))
    signal.pthread_sigmask(signal.SIG_BLOCK, {signal.SIGINT})
    try:
        yield
    finally:
        signal.pthread_sigmask(signal.SIG_UNBLOCK, {signal.SIGINT})
        signal.signal(signal.SIGINT, handler)
    if noted:
        raise KeyboardInterrupt


@contextmanager
def processes(jobs: int) -> Iterator[Executor]:
    """Give so many processes of one thread each, to run tasks in; what they have not done when an exception comes is dropped."""
    os.environ.update(ONE_THREAD)
    context = multiprocessing.get_context("spawn")
    with ProcessPoolExecutor(jobs, mp_context=context, initializer=_set_up_process) as pool:
        try:
            yield pool
        except BaseException:
            pool.shutdown(wait=False, cancel_futures=True)
            for process in multiprocessing.active_children():
                process.terminate()
            raise


def _set_up_process() -> None:
    """Hold a process of the run to one thread, as far as `ONE_THREAD` does not, and let it end when its parent is gone."""
    cv2.setNumThreads(1)
    threading.Thread(target=_end_with_parent, daemon=True).start()


def _end_with_parent() -> None:
    parent = multiprocessing.parent_process()
    assert parent is not None
    parent.join()
    os._exit(1)


def make(task: Task, selection: Selection, root: Path) -> Result | Failure:
    """Draw a picture, write its files, measure what was written."""
    method = selection.all()[task.method]
    photo, compare, flip = _photo(task.photo)
    try:
        start = time.perf_counter()
        picture = method.draw(photo, task.dots)
        seconds = time.perf_counter() - start
        pixels = _pixels(picture, photo)
    except Exception as error:  # whatever goes wrong in a method, the others go on
        reason = " ".join(str(error).split()) or "no message"
        own = isinstance(error, gs.GraphStippleError)
        return Failure(photo.name, task.photo.size, method.name, reason if own else f"{type(error).__name__}: {reason}")
    contents = {task.path.with_suffix(".png"): png(pixels)}
    if picture.svg is not None:
        contents[task.path.with_suffix(".svg")] = picture.svg.encode()
    for path, content in contents.items():
        files.write(path, content)
    with Image.open(task.path.with_suffix(".png")) as image:
        written = np.asarray(image).astype(np.float64) / 255
    result = Result(
        key=task.key,
        photo=photo.name,
        checksum=photo.checksum,
        size=task.photo.size,
        width=task.photo.width,
        height=task.photo.height,
        method=method.name,
        dots=task.dots if method.is_budgeted else None,
        settings=picture.settings,
        versions=results.versions(),
        code=task.code,
        files={path.relative_to(root).as_posix(): files.checksum(content) for path, content in contents.items()},
        seconds=seconds,
        svg_bytes=None if picture.svg is None else len(picture.svg.encode()),
        counts=asdict(picture.counts),
        metrics={**compare(written), **flip(written)},
        labyrinth=picture.labyrinth,
        evenness={} if picture.dots is None else evenness.measures(picture.dots, task.photo.width, task.photo.height),
    )
    results.save(result, task.path)
    return result


@lru_cache(maxsize=1)
def _photo(photo: PhotoFile) -> tuple[Photo, Comparison, Flip]:
    """Return the photo and the comparisons with it. A comparison holds hundreds of megabytes, so only the last one is kept."""
    read = photo.read()
    return read, Comparison(read.tone.astype(np.float64)), Flip(read.tone)


def _pixels(picture: Picture, photo: Photo) -> npt.NDArray[np.uint8]:
    """Return the picture as 8-bit grey levels.

    Raises
    ------
    InvalidInputError
        If it has another size than the photo, or values that are not in [0, 1].
    """
    raster = picture.raster
    if raster.shape != photo.tone.shape:
        raise gs.InvalidInputError(f"the picture has the shape {raster.shape}, but the photo has {photo.tone.shape}")
    if not np.all((raster >= 0) & (raster <= 1)):
        raise gs.InvalidInputError(f"the picture has values from {raster.min()} to {raster.max()}, but they must be in [0, 1]")
    return np.round(raster * 255).astype(np.uint8)
