"""A desk: one photo and its drawings, for one page. In: the page's messages; out: messages, some with bytes.

One thread works for a desk. What is wanted lies on the desk and is overwritten by what is wanted later, so the latest value wins
and nothing queues up. A drawing that nobody waits for any more is stopped, unless it is so quick that stopping it would show
nothing at all while a slider moves. Whoever brings a message never waits.

What a desk does not do: carry messages (`server` and `notebook` do), and open files that a page names.
"""

from __future__ import annotations

import io
import os
import threading
import time
from collections import deque
from collections.abc import Callable
from functools import cache, partial
from pathlib import Path, PurePath
from typing import Any, NamedTuple, TypeAlias

import numpy as np
import numpy.typing as npt
from PIL import Image

from graphstipple import _core
from graphstipple._draw import Session
from graphstipple._errors import GraphStippleError, InvalidInputError
from graphstipple._flags import flat
from graphstipple._memory import in_words
from graphstipple.drawing import Drawing
from graphstipple.options import Options
from graphstipple.studio.look import PAINTED, PAPER, SETTINGS, Look

Send: TypeAlias = "Callable[[dict[str, Any], bytes | None], object]"
"""Takes a message to the page, and its bytes; called from any thread."""

MOST_OFFERED = 2_000_000
"""Nodes that a slider offers at most; more can be typed, as far as memory goes."""

SMALL = 30_000
"""Nodes of the small version, which is drawn while a slider moves: more would show more, later."""

QUICK = 50_000
"""Nodes of a drawing that is not stopped, and that needs no small version: it is done in less than a tenth of a second."""

PATIENT = 400_000
"""Nodes of a drawing that is waited for without a small version, when nothing moves: it takes about half a second."""

PRESET_SIDE = 160
"""Longest side of a preset's picture, in pixels of the photo; it has the default number of nodes for so many."""

PRESET_SCALE = 2
"""Pixels of the picture for one of them."""

SEEN_SIDE = 2048
"""Longest side of the picture that stands for a photo that browsers do not know, and of a map."""

MOST_SEEN = 8192
"""Most pixels that a page can ask for on a side."""

SEEN_AS_IT_IS = 40_000_000
"""Pixels of a photo whose file is shown as it is: browsers take a second or two for as many."""

AT_REST = 0.2
"""Seconds without a wish after which the size of the file is found."""

PATIENCE = 0.5
"""Seconds of a drawing before the page is told how far it is: to tell it takes time from the drawing."""

STEP_OF_PROGRESS = 0.05
"""Share of a drawing after which it is told again."""

EXAMPLE = Path(__file__).parent / "page" / "example.jpg"
"""A photo to begin with: NASA's of Eileen Collins, in the public domain."""

BYTES_A_NODE, BYTES_A_PIXEL = 600, 24
"""What a session, the drawing that is seen and one that is being made take at most, beside docs/performance.md: 570 and 20."""

MOST_UPLOADED = 256 << 20
"""Bytes of a photo or a map that are taken from a page."""

MOST_SAVES = 8
"""Files that wait to be made."""

MOST_MEASURED = 50_000_000
"""Pixels of a file whose size is told beforehand: it is written for that, in a second or so."""

SHOWN_BY_BROWSERS = {b"\x89PNG\r\n\x1a\n": "image/png", b"\xff\xd8\xff": "image/jpeg"}
"""First bytes of files that every browser shows as they are."""

MIMES = {"svg": "image/svg+xml", "svgz": "image/svg+xml", "pdf": "application/pdf", "eps": "application/postscript"}
MIMES |= {"dxf": "image/vnd.dxf", "png": "image/png", "json": "application/json"}


class Budget:
    """Memory that the desks of a server share, and the most bytes of an upload."""

    def __init__(self, memory: int, upload: int) -> None:
        self.memory = memory
        self.upload = upload
        self._taken: dict[object, int] = {}
        self._lock = threading.Lock()

    def take(self, desk: object, size: float) -> None:
        """Let a desk have so many bytes, instead of what it had.

        Raises
        ------
        InvalidInputError
            If that is more than there is left.
        """
        with self._lock:
            others = sum(taken for owner, taken in self._taken.items() if owner is not desk)
            if size > self.memory - others:
                free = max(self.memory - others, 0)
                raise InvalidInputError(
                    f"this would take {in_words(size)} of memory, but the studio has {in_words(free)} left for it: "
                    "take fewer nodes or a smaller photo"
                )
            self._taken[desk] = int(size)

    def give_back(self, desk: object) -> None:
        """Take back all that a desk has."""
        with self._lock:
            self._taken.pop(desk, None)


class _View(NamedTuple):
    """What a page shows of the canvas: left, top, right, bottom in its pixels, and how many pixels wide."""

    part: tuple[float, float, float, float]
    columns: int


class _Wanted(NamedTuple):
    """A drawing that is wanted."""

    id: int
    look: Look
    moving: bool


class _Drawn(NamedTuple):
    """A drawing that is seen."""

    id: int
    look: Look
    map: int
    """Which of the maps that were painted it is drawn with."""
    drawing: Drawing
    warnings: list[str]
    whole: bool

    def has(self, look: Look, map_: int) -> bool:
        """Whether a look has the same drawing."""
        ours = self.look
        same = ours.options == look.options and ours.importance == look.importance and ours.min_dot == look.min_dot
        same_map = look.importance != PAINTED or self.map == map_
        return same and same_map and (look.min_dot is None or ours.sizes == look.sizes)


class _Photo(NamedTuple):
    """A photo that is open."""

    name: str
    data: Any
    """What a session is begun with: bytes of a file, or whatever `draw` takes."""
    session: Session
    """With the usual importance."""
    width: int
    height: int

    @property
    def luma(self) -> npt.NDArray[np.float32]:
        """A copy of the luma that is drawn by default, (height, width) in [0, 1], reduced where the photo is large."""
        photo, _, _ = self.session._state.session.packed()
        return photo.luma


class _Stopped(Exception):  # noqa: N818  # it is no error
    """Nobody waits for this drawing any more."""


class Desk:
    """One photo and its drawings.

    Parameters
    ----------
    send : callable
        Takes a message, a dict that JSON can hold, and bytes or None, to the page. Called from the desk's thread.
    photo : tuple of str and object, optional
        The photo to begin with: its name, and what `draw` takes.
    budget : Budget
        Memory, shared with other desks.
    """

    def __init__(self, send: Send, photo: tuple[str, Any] | None, budget: Budget) -> None:
        self.send = send
        self.seen: _Drawn | None = None
        """The whole drawing that was sent last."""
        self._budget = budget
        self._changed = threading.Condition()
        self._closed = False
        # What is wanted; only taken and put with the lock.
        self._photo_wanted: tuple[str, Any] | None = photo
        self._wanted: _Wanted | None = None
        self._view_wanted = False
        self._saves: deque[tuple[int, Look]] = deque()
        self._map_wanted = False
        self._photo_shown = True
        self._presets: deque[str] = deque()
        self._map: bytes | None = None
        self._maps = 0
        # What the thread alone works with.
        self._view: _View | None = None
        self._photo: _Photo | None = None
        self._drawn: _Drawn | None = None
        self._sessions: dict[bool, tuple[tuple[str, int], Session]] = {}
        self._to_measure: _Drawn | None = None
        self._picture: tuple[tuple[Drawing, tuple[float, float, float, float], int], int, bytes] | None = None
        self._thread = threading.Thread(target=self._work, name="graphstipple-desk", daemon=True)

    def close(self) -> None:
        """Stop, and let go of everything."""
        with self._changed:
            self._closed = True
            self._changed.notify()

    def join(self, timeout: float) -> None:
        """Wait until the thread has ended."""
        if self._thread.ident is not None:
            self._thread.join(timeout)

    def greet(self) -> None:
        """Say what there is to a page that has just come."""
        photo = self._photo
        open_ = None if photo is None else {"name": photo.name, "width": photo.width, "height": photo.height}
        self.send({"type": "ready", "fresh": photo is None, "photo": open_, **_said_once(self._budget)}, None)
        with self._changed:
            if photo is not None:
                self._photo_shown, self._presets = False, _all_presets()
            if self._thread.ident is None:
                # Not before the page has been greeted.
                self._thread.start()
            self._changed.notify()

    def receive(self, message: object, data: bytes | None = None) -> None:
        """Take a message of the page."""
        try:
            if not isinstance(message, dict):
                raise InvalidInputError(f"a message is of type {type(message).__name__}, but it must be a table")
            self._take(message, data)
        except Exception as error:
            # Whatever it is, the page is told, and the next message is taken.
            kind = str(message.get("type")) if isinstance(message, dict) else ""
            self._refuse(_KINDS.get(kind, "message"), error, _id(message))

    def _take(self, message: dict[str, Any], data: bytes | None) -> None:
        kind = str(message.get("type"))
        if kind == "hello":
            self.greet()
            return
        number = _id(message)
        with self._changed:
            if kind == "draw":
                self._wanted = _Wanted(number, self._look(message.get("look")), message.get("moving") is True)
            elif kind == "view":
                self._view = _view(message)
                self._view_wanted = True
            elif kind == "save":
                if len(self._saves) >= MOST_SAVES:
                    raise InvalidInputError(f"{MOST_SAVES} files are being made already: wait until one has come")
                self._saves.append((number, self._look(message.get("look"))))
            elif kind == "saliency":
                self._map_wanted = True
            elif kind == "example":
                self._photo_wanted = (EXAMPLE.name, EXAMPLE.read_bytes())
            elif kind in {"open", "importance"}:
                self._upload(kind, message, data)
            else:
                raise InvalidInputError(f"there is no message {kind!r:.40}")
            self._changed.notify()

    def _upload(self, kind: str, message: dict[str, Any], data: bytes | None) -> None:
        if data is None:
            raise InvalidInputError(f"the message {kind} comes without bytes")
        if len(data) > self._budget.upload:
            raise InvalidInputError(f"the file has {in_words(len(data))}, but at most {in_words(self._budget.upload)} are taken")
        if kind == "open":
            name = message.get("name")
            # A name for messages and for the file that is saved: what leads elsewhere is cut off.
            plain = "".join(it if it.isprintable() else "_" for it in str(name).replace("\\", "/"))
            self._photo_wanted = (PurePath(plain).name[:200] or "photo", data)
        else:
            self._map = data
            self._maps += 1

    # The thread

    def _work(self) -> None:
        while True:
            with self._changed:
                while not (self._closed or self._is_wanted() or self._to_measure):
                    self._changed.wait()
                measured = self._to_measure
                if measured is not None and not (self._closed or self._is_wanted()):
                    # Writing a file takes its time, in which no slider is to wait.
                    self._changed.wait(AT_REST)
                if self._closed:
                    break
                if self._is_wanted():
                    job = self._next()
                else:
                    job, self._to_measure = partial(self._measure, measured), None
            try:
                job()
            except _Stopped:
                pass
            except MemoryError:
                self._refuse("draw", GraphStippleError("there is not enough memory for this drawing"), None)
            except BaseException as error:
                # Whatever it is, a panic in Rust too, the page is told, and the desk goes on.
                self._refuse("draw", error, None)
        # Nothing is kept for a page that has gone.
        self._sessions.clear()
        self._photo = self._drawn = self.seen = self._map = self._to_measure = self._picture = None
        self._budget.give_back(self)

    def _is_wanted(self) -> bool:
        is_shown = self._photo_shown and not self._view_wanted and not self._map_wanted
        return bool(self._photo_wanted or self._wanted or self._saves or self._presets or not is_shown)

    def _next(self) -> Callable[[], object]:
        """Take the most urgent of what is wanted."""
        photo = self._photo
        job: Callable[[], object]
        if self._photo_wanted:
            (name, data), self._photo_wanted = self._photo_wanted, None
            job = partial(self._open, name, data, self._saves_left())
        elif photo is None:
            # Nothing can be drawn yet; a page says again what it wants when there is a photo.
            self._wanted, self._view_wanted, self._map_wanted, self._photo_shown = None, False, False, True
            self._presets.clear()
            job = partial(self._refuse_to_save, self._saves_left(), "there is no photo yet: open one")
        elif not self._photo_shown:
            self._photo_shown = True
            job = partial(self._show_photo, photo)
        elif self._wanted:
            wanted, self._wanted, self._view_wanted = self._wanted, None, False
            job = partial(self._draw, photo, wanted)
        elif self._view_wanted:
            self._view_wanted = False
            job = partial(self._show, photo)
        elif self._saves:
            job = partial(self._save, photo, *self._saves.popleft())
        elif self._map_wanted:
            self._map_wanted = False
            job = partial(self._show_saliency, photo)
        else:
            job = partial(self._show_preset, photo, self._presets.popleft())
        return job

    def _saves_left(self) -> list[int]:
        """Take the numbers of the files that are still to be made."""
        numbers = [number for number, _ in self._saves]
        self._saves.clear()
        return numbers

    def _refuse_to_save(self, numbers: list[int], sentence: str) -> None:
        for number in numbers:
            self._refuse("save", InvalidInputError(sentence), number)

    def _open(self, name: str, data: Any, left: list[int]) -> None:
        # They were of the last one.
        self._refuse_to_save(left, "another photo was opened")
        try:
            session = Session(data)
            width, height = session._state.session.size
            self._budget.take(self, self._needed(data, Look.of({}), width, height))
        except (GraphStippleError, MemoryError) as error:
            said = str(error) or "there is not enough memory for this photo"
            # The name that the reader has for bytes is not the file's.
            self._refuse("photo", InvalidInputError(said.replace("image: ", f"{name}: ", 1)), None)
            return
        self._photo = _Photo(name, data, session, width, height)
        self._drawn = self.seen = self._to_measure = self._picture = None
        self._sessions.clear()
        with self._changed:
            self._view, self._photo_shown, self._presets = None, False, _all_presets()

    def _needed(self, data: Any, look: Look, width: int, height: int) -> float:
        """Return the bytes that a photo, a drawing of it and its file take at most."""
        held = sum(len(it) for it in (data, self._map) if isinstance(it, bytes))
        core = look.options._checked
        pixels = width * height / core.reduction(width, height) ** 2
        return held + BYTES_A_PIXEL * pixels + BYTES_A_NODE * core.most_nodes(width, height)

    def _session(self, photo: _Photo, look: Look, *, whole: bool) -> Session:
        """Return the session for a look; one for whole drawings, another for small ones, so that each keeps what it has."""
        source: Any = look.importance
        key = (look.importance, 0)
        if look.importance == PAINTED:
            with self._changed:
                source, key = self._map, (PAINTED, self._maps)
        held = self._sessions.get(whole)
        if held is not None and held[0] == key:
            return held[1]
        session = photo.session if whole and source == photo.session._importance else photo.session.with_importance(source)
        self._sessions[whole] = (key, session)
        return session

    def _draw(self, photo: _Photo, wanted: _Wanted) -> None:
        look, core, seen = wanted.look, wanted.look.options._checked, self.seen
        if seen is not None and seen.has(look, self._maps):
            # Said again when the slider rests, or with another file: it is seen already.
            self._drawn = self.seen = seen._replace(id=wanted.id, look=look)
            self._show(photo)
            self._tell(photo, self.seen)
            return
        try:
            self._budget.take(self, self._needed(photo.data, look, photo.width, photo.height))
            nodes = core.most_nodes(photo.width, photo.height)
            if nodes > (QUICK if wanted.moving else PATIENT):
                small = Options._of(core.with_at_most(SMALL, photo.width, photo.height))
                self._drawn = self._drawing(photo, wanted, small, whole=False)
                self._show(photo)
                if self._is_stale():
                    return
            drawn = self._drawing(photo, wanted, look.options, whole=True)
        except GraphStippleError as error:
            self._refuse("draw", error, wanted.id)
            return
        self._drawn = self.seen = drawn
        self._show(photo)
        self._tell(photo, drawn)

    def _drawing(self, photo: _Photo, wanted: _Wanted, options: Options, *, whole: bool) -> _Drawn:
        look, map_ = wanted.look, self._maps
        # More threads than processors only take their time.
        processors = os.cpu_count() or 1
        if (options.threads or 1) > processors:
            options = options.replace(threads=processors)
        can_stop = whole and options._checked.most_nodes(photo.width, photo.height) > QUICK
        began, last = time.monotonic(), 0.0

        def progress(stage: str, fraction: float) -> None:
            nonlocal last
            if self._closed or (can_stop and self._is_stale()):
                raise _Stopped
            if fraction - last >= STEP_OF_PROGRESS and time.monotonic() - began > PATIENCE:
                last = fraction
                self.send({"type": "progress", "id": wanted.id, "stage": stage, "fraction": round(fraction, 3)}, None)

        drawing, said = self._session(photo, look, whole=whole)._draw_quietly(options, progress)
        if look.min_dot is not None:
            drawing = drawing.with_min_dot(look.min_dot, **look.sizes)
        return _Drawn(wanted.id, look, map_, drawing, said, whole)

    def _is_stale(self) -> bool:
        """Whether something else is wanted than what is being drawn."""
        return self._closed or self._wanted is not None or self._photo_wanted is not None

    def _show(self, photo: _Photo) -> None:
        """Send what the page shows of the drawing."""
        drawn, view = self._drawn, self._view
        if drawn is None or view is None:
            return
        left, top, right, bottom = view.part
        part = (max(left, 0.0), max(top, 0.0), min(right, photo.width), min(bottom, photo.height))
        # What is cut off may have been what kept it in proportion.
        tall = view.columns * (part[3] - part[1]) / max(part[2] - part[0], 1e-9)
        columns = view.columns if tall <= MOST_SEEN else max(int(view.columns * MOST_SEEN / tall), 1)
        key = (drawn.drawing, part, columns)
        if self._picture is None or self._picture[0] != key:
            try:
                self._picture = (key, *drawn.drawing._core.picture(columns, part))
            except GraphStippleError as error:
                self._refuse("view", error, None)
                return
        _, rows, png = self._picture
        header = {"type": "picture", "id": drawn.id, "whole": drawn.whole, "part": part}
        self.send({**header, "columns": columns, "rows": rows}, png)

    def _tell(self, photo: _Photo, drawn: _Drawn) -> None:
        """Send what is to be said of a whole drawing."""
        look, stats = drawn.look, drawn.drawing.stats
        counts = {name: value for name, value in stats.items() if isinstance(value, int | float)}
        warnings, told = list(drawn.warnings), None
        try:
            sheet = drawn.drawing._core.sheet(look.suffix, look.settings)
            has_pixels = look.suffix in SETTINGS["dpi"].formats
            if sheet is not None:
                told = {"page": sheet[:2], "drawing": sheet[2:], "unit": "px" if has_pixels else "mm"}
            is_large = has_pixels and sheet is not None and sheet[0] * sheet[1] > MOST_MEASURED
            self._to_measure = None if is_large else drawn
        except GraphStippleError as error:
            # The drawing is there; it cannot be written so.
            self._refuse("save", error, drawn.id)
        message = {"type": "drawn", "id": drawn.id, "stats": counts, "seconds": stats["seconds"]["total"], "sheet": told}
        in_words = {"command": look.as_command(photo.name), "python": look.as_python(photo.name)}
        self.send({**message, "warnings": warnings, **in_words}, None)

    def _measure(self, drawn: _Drawn | None) -> None:
        """Send the size of the file."""
        if drawn is None:
            return
        try:
            data = drawn.drawing._core.encode(drawn.look.suffix, drawn.look.settings)
        except GraphStippleError as error:
            self._refuse("save", error, drawn.id)
            return
        self.send({"type": "size", "id": drawn.id, "suffix": drawn.look.suffix, "bytes": len(data)}, None)

    def _save(self, photo: _Photo, number: int, look: Look) -> None:
        try:
            drawn = self.seen
            if drawn is None or not drawn.has(look, self._maps):
                self._budget.take(self, self._needed(photo.data, look, photo.width, photo.height))
                drawn = self._drawing(photo, _Wanted(number, look, moving=False), look.options, whole=True)
            data = drawn.drawing._core.encode(look.suffix, look.settings)
        except _Stopped:
            # It is wanted all the same, when what is more urgent is done.
            with self._changed:
                self._saves.append((number, look))
        except GraphStippleError as error:
            self._refuse("save", error, number)
        else:
            header = {"type": "file", "id": number, "name": look.output(photo.name), "mime": MIMES[look.suffix]}
            self.send(header, data)

    def _look(self, said: object) -> Look:
        """Return the look that a page has said, with a map if it asks for one."""
        look = Look.of(said)
        if look.importance == PAINTED and self._map is None:
            raise InvalidInputError("the importance is painted, but nothing was painted yet")
        return look

    def _show_photo(self, photo: _Photo) -> None:
        data = photo.data
        header = {"type": "photo", "name": photo.name, "width": photo.width, "height": photo.height}
        if isinstance(data, bytes) and photo.width * photo.height <= SEEN_AS_IT_IS:
            for begin, mime in SHOWN_BY_BROWSERS.items():
                if data.startswith(begin):
                    self.send({**header, "mime": mime}, data)
                    return
        self.send({**header, "mime": "image/png"}, _png(_core.luma_to_u8(photo.luma), SEEN_SIDE))

    def _show_saliency(self, photo: _Photo) -> None:
        self.send({"type": "map", "name": "saliency"}, _png(_core.luma_to_u8(_core.saliency(photo.luma)), SEEN_SIDE))

    def _show_preset(self, photo: _Photo, name: str) -> None:
        small = Image.fromarray(photo.luma)
        small.thumbnail((PRESET_SIDE, PRESET_SIDE), Image.Resampling.BOX)
        values = np.clip(np.asarray(small, np.float32), 0, 1)
        drawing, _ = Session(values)._draw_quietly(Options.preset(name), self._give_way)
        self.send({"type": "preset", "name": name}, _png(drawing.rasterize(PRESET_SCALE * drawing.width)))

    def _give_way(self, stage: str, fraction: float) -> None:
        """Stop at the desk's end."""
        if self._closed:
            raise _Stopped

    def _refuse(self, of: str, error: BaseException, number: int | None) -> None:
        sentence = str(error) if isinstance(error, GraphStippleError) else f"internal error, please report it: {error!r}"
        self.send({"type": "refused", "of": of, "id": number, "sentence": sentence}, None)


OF_SUBJECT = "backdrop"
"""The option that matters with a subject alone."""

_KINDS = {"draw": "draw", "view": "view", "save": "save", "open": "photo", "example": "photo", "importance": "importance"}
"""What a refusal is about, by the message that is refused."""


def _all_presets() -> deque[str]:
    return deque(name for name, *_ in _core.presets())


def _said_once(budget: Budget) -> dict[str, Any]:
    """Return what every page is told at its begin."""
    return {**_declared(), "limits": {"upload": budget.upload, "nodes": min(budget.memory // BYTES_A_NODE // 2, MOST_OFFERED)}}


@cache
def _declared() -> dict[str, Any]:
    """Return the declarations of options, settings, formats, sources and presets."""
    settings = [
        {
            "name": it.name,
            "description": it.description,
            "default": it.default,
            "formats": it.formats,
            "kind": it.kind,
            "words": it.words or None,
            "everyday": it.everyday,
        }
        # Its option stands for it.
        for it in SETTINGS.values()
        if it.name != PAPER
    ]
    schema = _core.options_schema()
    # A page has no subject that anything could step back from.
    del schema["properties"][OF_SUBJECT]

    def values(preset: str) -> dict[str, Any]:
        return {name: value for name, value in flat(_core.preset(preset).values()).items() if name != OF_SUBJECT}

    return {
        "version": _core.__version__,
        "schema": schema,
        "settings": settings,
        "formats": [{"suffix": suffix, "name": name, "description": holds} for suffix, name, holds, _ in _core.formats()],
        # A path is what a page may not name.
        "sources": [{"form": form, "description": stands} for form, stands in _core.sources() if " " not in form],
        "presets": [
            {"name": name, "description": description, "only": only, "values": values(name)}
            for name, description, only in _core.presets()
        ],
    }


def _id(message: object) -> int:
    """Return the number of a message."""
    number = message.get("id") if isinstance(message, dict) else None
    return number if isinstance(number, int) and abs(number) < 2**53 else 0


def _view(message: dict[str, Any]) -> _View:
    """Return what a page shows of the canvas."""
    part, columns = message.get("part"), message.get("columns")
    are_sides = isinstance(part, list) and len(part) == 4 and all(isinstance(side, int | float) for side in part)
    if part is None or not are_sides or not isinstance(columns, int) or not 1 <= columns <= MOST_SEEN:
        allowed = f"left, top, right and bottom, and at most {MOST_SEEN} columns"
        raise InvalidInputError(f"the view is {part!r:.80} in {columns!r:.20} columns, but it must be {allowed}")
    left, top, right, bottom = (float(side) for side in part)
    # False for what is no number, too.
    if not (right > left and 0 < (bottom - top) / (right - left) * columns <= MOST_SEEN):
        raise InvalidInputError(f"the view is {part!r:.80}, but it must have an area, and at most {MOST_SEEN} rows")
    return _View((left, top, right, bottom), columns)


def _png(pixels: npt.NDArray[np.uint8], side: int | None = None) -> bytes:
    """Return grey pixels as a PNG, reduced where a side is longer."""
    image = Image.fromarray(pixels)
    if side is not None:
        image.thumbnail((side, side), Image.Resampling.BOX)
    file = io.BytesIO()
    # Level 1 is done in a fifth of the time of the usual 6, for a tenth more bytes, which do not travel far.
    image.save(file, "PNG", compress_level=1)
    return file.getvalue()
