"""`draw`: a photo in, a drawing out. `Session`: one photo, many drawings."""

from __future__ import annotations

import os
import time
import warnings
from collections.abc import Callable, Mapping
from pathlib import Path
from typing import TYPE_CHECKING, Any, NamedTuple, TypeAlias

import numpy as np
import numpy.typing as npt

from graphstipple import _core
from graphstipple._errors import GraphStippleError, GraphStippleWarning, InvalidInputError
from graphstipple._inputs import MAX_PIXELS, ImageLike, is_pil, is_text, path_to_read, read_photo, reading_of
from graphstipple.drawing import Drawing, RecordedOptions, known, plain_settings
from graphstipple.options import Options

AUTO = "auto"
"""The subject that is found."""

if TYPE_CHECKING:
    from PIL import Image

ImportanceMap: TypeAlias = "os.PathLike[str] | bytes | Image.Image | npt.NDArray[Any]"
"""A path, all bytes of a file, a PIL image or an array."""

ImportanceLike: TypeAlias = "str | ImportanceMap | Callable[[npt.NDArray[np.float32]], ImportanceMap | str] | None"
"""A name, a map, or what makes one of the photo's luma."""

SubjectLike: TypeAlias = "str | ImportanceMap | Callable[[npt.NDArray[np.uint8]], ImportanceMap | None] | None"
"""The word "auto", a mask, or what makes one of the photo's colours."""

Progress: TypeAlias = "Callable[[str, float], object]"
"""Called with a stage's name and the fraction of the whole drawing that is done."""


def draw(
    image: ImageLike,
    importance: ImportanceLike = "saliency",
    options: Options | RecordedOptions | None = None,
    progress: Progress | None = None,
    *,
    subject: SubjectLike = None,
    backdrop: str | None = None,
    max_bytes: int | str | None = None,
    max_points: int | None = None,
    written: Mapping[str, Any] | None = None,
    max_pixels: int = MAX_PIXELS,
    allow_damaged: bool = False,
) -> Drawing:
    """Draw a photo, in black and white or in inks of which the options tell.

    The interpreter lock is released during the work, and Ctrl-C stops it at once.

    Parameters
    ----------
    image : str, path, bytes, PIL image or ndarray
        The photo. A file (PNG, JPEG, TIFF, WebP), given by its path or by all its bytes, is decoded by Rust, as on the command
        line; one that Rust does not support, by Pillow: docs/formats.md has what is read. An array is (height, width) or
        (height, width, channels): grey, grey and alpha, sRGB, or sRGB and alpha; bool, uint8, uint16, or floats in [0, 1].
        A colour profile is applied, that of a file as that of a PIL image (`info["icc_profile"]`); arrays are sRGB.
    importance : str, path, bytes, PIL image, ndarray or callable
        Where detail is wanted: "saliency" (the default), "none" (everywhere), "constant:V" with V in (0, 1], or a map of any
        size, as a file, PIL image or array (height, width), white where detail is wanted. A callable gets the photo's luma, float32
        (height, width) in [0, 1], and returns any of these. The photo's own detail is mixed into saliency and maps as `detail`,
        `floor` and `midtones` of the options say. What has far more pixels than the drawing's nodes can use is reduced while it is
        read, the photo and a map each by its own size (see `stats`, and docs/method.md); a callable gets the luma as it is drawn.
    options : Options, optional
        By default ``Options()``. Those of a drawing that was loaded can be used too, where this version knows them all.
    progress : callable, optional
        Called with the stage's name and the fraction of the whole drawing that is done, some 50 times a second. What it raises
        stops the work.
    subject : str, path, bytes, PIL image, ndarray or callable, optional
        What the rest steps back from, as `backdrop` says: "auto" (found by OpenCV, see `find_subject`), or a mask of any size, as
        a file, PIL image or array (height, width), white where the subject is; its edge is refined by the photo's. A callable gets
        the photo's colours as it is drawn, sRGB, uint8 (height, width, 3), and returns a mask, or None where there is no subject.
    backdrop : str, optional
        What becomes of the rest: "keep", "soften", "fade", "paper" or "ink"; by default as the options say.
    max_bytes : int or str, optional
        Return the finest drawing whose file has at most so many bytes, at least 1, such as "100kB", "1MB" or "100KiB": if it is
        larger with these options, contours are simplified further (`tolerance`), then there are fewer `nodes`, in at most eight
        trials. The options of the drawing that is returned give it again. `written` says which file.
    max_points : int, optional
        Likewise with at most so many points, at least 1: coordinate pairs, control points included; a dot counts one.
    written : mapping, optional
        The file that `max_bytes` is about, by default a plain SVG: `suffix` ("svg", "pdf", ...), settings of `Drawing.save` by
        name, and `min_dot` as for `Drawing.with_min_dot`, which the drawing that is returned has then been through.
    max_pixels : int
        Refuse images with more pixels, before memory is taken for them; 1 to 250,000,000.
    allow_damaged : bool
        Draw what there is of a file that is cut short or damaged, the rest as background.

    Returns
    -------
    Drawing

    Raises
    ------
    InvalidInputError
        If the image, the importance, the subject or an option breaks a rule, or no drawing is small enough: then it says how small
        one can be.
    ImageFileError
        If a file cannot be read as an image; `ImageFileNotFoundError` if there is none.
    MissingPackageError
        If a subject is to be found without OpenCV.

    Warns
    -----
    GraphStippleWarning
        If the drawing is blank, though the photo is not flat; if a file lacks its end, or parts of it are drawn as background; if
        no subject was found, or a mask shows none: then the photo is drawn as it is.
    """
    options = _with_backdrop(known(options), subject, backdrop)
    limit = _limit(max_bytes, max_points, written)
    if limit is not None:
        session = Session(image, importance, subject=subject, max_pixels=max_pixels, allow_damaged=allow_damaged)
        return _drawing(*session._within(options, progress, limit, session._seconds))
    seconds: dict[str, float] = {}
    report = progress or _silent
    reading = reading_of(options._checked, max_pixels, allow_damaged)
    photo, heard = _read_photo(image, subject, reading, seconds, report, colour=options._checked.wants_colour())
    source, heard = _read_importance(importance, photo, reading, seconds, heard)
    result = _core.draw(photo, source, reading, options._checked, progress)
    report("outlines", 1.0)
    return _drawing(result, options, seconds, heard)


class Session:
    """One photo, drawn again and again without starting again.

    What a change of options does not touch is kept from the last drawing: the tone, the importance, the kept lattice nodes, the
    graph, the labels, the outlines. The drawings are the same, to the last byte, as those of `draw`. With another `shading` or
    `crispness`, the nodes are labelled anew but not chosen anew. What only shapes marks, such as `stipple_scale` and `tolerance`,
    leaves the labels as they are: docs/options.md says what each option is used for. How a drawing is written is no option:
    `Drawing.save` computes nothing anew.

    The image and the importance are read here, and once: a saliency or a callable is not evaluated again. Only a drawing with
    another `background` than the last one reads them again, since transparent parts then look different; and, where a photo or a
    map has more than a megapixel, one whose number of nodes asks for another reduction. The photo's colours are read with the
    first drawing of other inks than black.

    So is the subject; the `backdrop` that a drawing has is one of its options.

    A drawing shares its graph and its importance with the session; docs/performance.md says how much memory that is. Threads may
    use one session: they draw one after the other.

    A session can be pickled, for process pools and Dask, and copied: it then has its photo, 4 bytes a pixel as reduced, and its
    importance, and begins without what was kept. An image that may have to be read again (a file, a PIL image, an array with
    colours or transparency or of more than a megapixel) goes with it as it was given; a callable does not, for its map is there.

    Parameters
    ----------
    image : str, path, bytes, PIL image or ndarray
        The photo, as for `draw`.
    importance : str, path, bytes, PIL image, ndarray or callable
        Where detail is wanted, as for `draw`.
    subject : str, path, bytes, PIL image, ndarray or callable, optional
        What the rest steps back from, as for `draw`.
    max_pixels, allow_damaged
        As for `draw`.

    Raises
    ------
    InvalidInputError
        If the image or the importance breaks a rule.
    ImageFileError
        If a file cannot be read as an image; `ImageFileNotFoundError` if there is none.

    Examples
    --------
    >>> import numpy as np, graphstipple as gs
    >>> session = gs.Session(np.linspace(0, 1, 4800).reshape(60, 80))
    >>> session
    <graphstipple.Session 80 x 60: importance saliency>
    >>> first = session.draw()
    >>> second = session.draw(gs.Options(shading=0.8))
    >>> np.array_equal(first.graph.edges, second.graph.edges), second.svg() == first.svg()
    (True, False)
    """

    def __init__(
        self,
        image: ImageLike,
        importance: ImportanceLike = "saliency",
        *,
        subject: SubjectLike = None,
        max_pixels: int = MAX_PIXELS,
        allow_damaged: bool = False,
    ) -> None:
        self._image: ImageLike | None = image
        self._importance = importance
        self._subject = subject
        self._limits = (max_pixels, allow_damaged)
        self._seconds: dict[str, float] = {}
        self._state = self._begin(image, Options()._checked, self._seconds, _silent)
        self._may_change = True

    def with_importance(self, importance: ImportanceLike) -> Session:
        """Return a session on the same photo, which is not read again, with another importance.

        Parameters
        ----------
        importance : str, path, bytes, PIL image, ndarray or callable
            Where detail is wanted, as for `draw`.

        Returns
        -------
        Session

        Raises
        ------
        InvalidInputError, ImageFileError
            As for a new session.
        """
        (photo, _, background), heard = self._state.session.packed(), self._state.heard
        session = object.__new__(Session)
        session._limits, session._may_change, session._seconds = self._limits, self._may_change, {}
        session._image = self._image
        if self._may_change:
            session._importance, session._subject = importance, self._subject
        reading = _core.Reading(background, Options()._checked, *self._limits)
        session._state = _state(photo, heard._replace(of_importance=[]), importance, reading, session._seconds)
        return session

    def draw(
        self,
        options: Options | RecordedOptions | None = None,
        progress: Progress | None = None,
        *,
        max_bytes: int | str | None = None,
        max_points: int | None = None,
        written: Mapping[str, Any] | None = None,
    ) -> Drawing:
        """Draw the photo, as `draw` does, from where the options begin to differ from the last ones.

        The interpreter lock is released during the work, and Ctrl-C stops it at once. A drawing that fails or is stopped leaves the
        session as good as it was.

        Parameters
        ----------
        options : Options, optional
            By default ``Options()``, and not those of the last drawing.
        progress : callable, optional
            As for `draw`. What is kept counts as done, so the first fraction may be any.
        max_bytes, max_points, written
            As for `draw`.

        Returns
        -------
        Drawing
            In its `stats`, `seconds` has only the stages that this drawing took.

        Raises
        ------
        InvalidInputError
            If an option breaks a rule, or no drawing is small enough.
        ImageFileError
            If a file has to be read again and cannot.
        """
        options = known(options)
        limit = _limit(max_bytes, max_points, written)
        seconds: dict[str, float] = {}
        if limit is not None:
            return _drawing(*self._within(options, progress, limit, seconds))
        return _drawing(*self._drawn(options, progress, seconds))

    def _draw_quietly(self, options: Options, progress: Progress | None = None) -> tuple[Drawing, list[str]]:
        """Return the drawing that `draw` returns, and the sentences of its warnings, for threads: warnings are the process's."""
        core, _, seconds, heard = self._drawn(options, progress, {})
        return Drawing(core, options, seconds, heard.decoder), [*heard.of_photo, *heard.of_importance, *core.warnings]

    def _drawn(
        self, options: Options, progress: Progress | None, seconds: dict[str, float]
    ) -> tuple[_core.Drawing, Options, dict[str, float], _Heard]:
        """Return the drawing with these options, the options, the seconds of all else that was done, and what was heard."""
        report = progress or _silent
        state = self._fitting(options._checked, seconds, report)
        result = state.session.draw(options._checked, progress)
        report("outlines", 1.0)
        return result, options, seconds, state.heard

    def __reduce__(self) -> tuple[Callable[..., Session], tuple[object, ...]]:
        core, heard = self._state
        packed = core.packed()
        given = None
        if self._may_change:
            is_called = callable(self._importance)
            is_settled = isinstance(packed[1], str) or is_called or _is_opaque(self._importance)
            of_mask = self._subject is None or callable(self._subject) or self._finds_subject or _is_opaque(self._subject)
            if not (core.is_never_reduced and _is_opaque(self._image) and is_settled and of_mask):
                subject = _no_subject_packed if callable(self._subject) else self._subject
                given = (self._image, _not_packed if is_called else self._importance, subject)
        # What has no colour but its luma is not looked at for it.
        image = None if given is not None or getattr(self._image, "ndim", 3) == 2 else self._image
        return _unpacked, (packed, heard, given, self._limits, image)

    @classmethod
    def _of(
        cls,
        state: _State,
        given: tuple[ImageLike, ImportanceLike, SubjectLike] | None,
        limits: tuple[int, bool],
        image: ImageLike | None,
    ) -> Session:
        """Return a session with what it has read.

        `given` is what can be read again, if it may have to be, else `image` for its colour alone.
        """
        session = object.__new__(cls)
        session._state, session._limits, session._may_change = state, limits, given is not None
        session._seconds, session._image = {}, image
        if given is not None:
            session._image, session._importance, session._subject = given
        return session

    @property
    def _finds_subject(self) -> bool:
        return isinstance(self._subject, str) and self._subject == AUTO

    def __repr__(self) -> str:
        session = self._state.session
        width, height = session.size
        return f"<graphstipple.Session {width} x {height}: importance {session.importance}>"

    def _within(
        self, options: Options, progress: Progress | None, limit: _Limit, seconds: dict[str, float]
    ) -> tuple[_core.Drawing, Options, dict[str, float], _Heard]:
        """Return the finest drawing within a limit, its options, the seconds of all else that was done, and what was heard."""
        state = self._fitting(options._checked, seconds, _of_trial(progress, 0) or _silent)
        trials = _core.Trials(options._checked, state.session.size, *limit.most, limit.suffix, limit.settings)
        finest: _core.Drawing | None = None
        made, said = options, list[str]()
        count = 0
        while (trial := trials.next_options()) is not None:
            report = _of_trial(progress, count)
            count += 1
            state = self._fitting(trial, seconds, report or _silent)
            result = state.session.draw(trial, report)
            warned = result.warnings
            if limit.min_dot is not None:
                result = result.with_min_dot(limit.min_dot, limit.sizes)
            other: _core.Drawing | None = result
            if trials.tell(result):
                finest, other, made, said = result, finest, Options._of(trial), warned
            for stage, spent in other.stats()["seconds"].items() if other else ():
                if stage != "total":
                    seconds[stage] = seconds.get(stage, 0.0) + spent
        found = trials.found(finest)
        if found is None:
            raise GraphStippleError("internal error, please report it: what was found was not kept")
        if progress:
            progress("outlines", 1.0)
        heard = state.heard
        if limit.min_dot is not None:
            # The core says it of the drawing before the change.
            heard = heard._replace(of_importance=[*heard.of_importance, *said])
        return found, made, seconds, heard

    def _fitting(self, options: _core.Options, seconds: dict[str, float], report: Progress) -> _State:
        """Return the state that these options can be drawn from, read again if they ask for it."""
        state = self._state
        fits = not self._may_change or state.session.fits(options)
        image = self._image
        if image is None or (fits and state.session.has_colour_for(options)):
            return state
        read = self._with_colour if fits else self._begin
        state = read(image, options, seconds, report)
        # In one step: threads with different backgrounds each have their own, and the last one's stays.
        self._state = state
        return state

    def _begin(self, image: ImageLike, options: _core.Options, seconds: dict[str, float], report: Progress) -> _State:
        reading = reading_of(options, *self._limits)
        colour = options.wants_colour()
        photo, heard = _read_photo(image, self._subject, reading, seconds, report, colour=colour)
        return _state(photo, heard, self._importance, reading, seconds)

    def _with_colour(self, image: ImageLike, options: _core.Options, seconds: dict[str, float], report: Progress) -> _State:
        """Return the state with the photo's colour; subject and importance are as they were made."""
        state = self._state
        photo, importance, background = state.session.packed()
        reading = _core.Reading(background, options, *self._limits)
        read, _ = _read_photo(image, None, reading, seconds, report, colour=True)
        return _State(_core.Session(photo.with_colour_of(read), importance, reading), state.heard)


def _unpacked(
    packed: tuple[_core.Photo, str | _core.Photo, tuple[int, int, int]],
    heard: _Heard,
    given: tuple[ImageLike, ImportanceLike, SubjectLike] | None,
    limits: tuple[int, bool],
    image: ImageLike | None,
) -> Session:
    """Return the session that was pickled."""
    photo, importance, background = packed
    session = _core.Session(photo, importance, _core.Reading(background, None, *limits))
    return Session._of(_State(session, heard), given, limits, image)


def _not_packed(luma: npt.NDArray[np.float32]) -> str:
    """Refuse to stand for the callable that a session was begun with."""
    raise InvalidInputError(_LEFT_BEHIND.format("importance"))


def _no_subject_packed(rgb: npt.NDArray[np.uint8]) -> None:
    """Refuse likewise."""
    raise InvalidInputError(_LEFT_BEHIND.format("subject"))


_LEFT_BEHIND = (
    "these options ask for the {} to be made again by a callable, which was not pickled with the session: begin a new session"
)


def _is_opaque(given: object) -> bool:
    """Whether an image is known to look the same on every background: the last of two or four channels is opacity."""
    return isinstance(given, np.ndarray) and (given.ndim == 2 or given.shape[2] % 2 == 1)


class _Limit(NamedTuple):
    """How large a drawing may be, and what is measured."""

    most: tuple[object, object]
    """Bytes and points."""
    suffix: str
    settings: dict[str, Any]
    min_dot: object

    @property
    def sizes(self) -> dict[str, Any]:
        """The settings that are about the size on paper."""
        return {name: value for name, value in self.settings.items() if name in {"width", "margin", "page"}}


def _limit(max_bytes: object, max_points: object, written: Mapping[str, Any] | None) -> _Limit | None:
    """Return the limit of a drawing, if there is one.

    Raises
    ------
    InvalidInputError
        If the file that is measured is described without a limit, or as none can be.
    """
    if max_bytes is None and max_points is None:
        if written is not None:
            raise InvalidInputError("written is given, but it must be left out unless max_bytes or max_points is given")
        return None
    if written is not None and not isinstance(written, Mapping):
        raise InvalidInputError(f"written is {written!r}, but it must be a mapping of settings by name")
    settings = plain_settings(written or {})
    suffix, min_dot = settings.pop("suffix", "svg"), settings.pop("min_dot", None)
    if not isinstance(suffix, str):
        raise InvalidInputError(f"suffix is {suffix!r}, but it must be a str")
    most = plain_settings({"bytes": max_bytes, "points": max_points})
    return _Limit((most["bytes"], most["points"]), suffix.removeprefix("."), settings, min_dot)


def _of_trial(progress: Progress | None, trial: int) -> Progress | None:
    """Return what reports a trial: how many there will be nobody knows, so each has half of what is left."""
    if progress is None:
        return None
    left = 0.5**trial
    return lambda stage, fraction: progress(stage, 1 - left + left / 2 * fraction)


class _Heard(NamedTuple):
    """What is to be said of the files that were read, and what has decoded the photo's."""

    of_photo: list[str]
    of_importance: list[str]
    decoder: str | None


class _State(NamedTuple):
    """What a session has of an image on a background."""

    session: _core.Session
    heard: _Heard


def _state(
    photo: _core.Photo, heard: _Heard, importance: ImportanceLike, reading: _core.Reading, seconds: dict[str, float]
) -> _State:
    """Return what a session has of a photo that was read, of which `heard` is to be said, with an importance."""
    source, heard = _read_importance(importance, photo, reading, seconds, heard)
    session = _core.Session(photo, source, reading)
    for stage, spent in session.seconds.items():
        seconds[stage] = seconds.get(stage, 0.0) + spent
    if session.warning:
        heard.of_importance.append(session.warning)
    return _State(session, heard)


def _drawing(core: _core.Drawing, options: Options, seconds: dict[str, float], heard: _Heard) -> Drawing:
    """Return what the core has drawn, and pass its warnings, and those of the files, on to whoever called `draw`."""
    for warning in [*heard.of_photo, *heard.of_importance, *core.warnings]:
        warnings.warn(warning, GraphStippleWarning, stacklevel=3)
    return Drawing(core, options, seconds, heard.decoder)


def _read_photo(
    image: ImageLike,
    subject: SubjectLike,
    reading: _core.Reading,
    seconds: dict[str, float],
    report: Progress,
    *,
    colour: bool,
) -> tuple[_core.Photo, _Heard]:
    """Return the image for the core, with its subject if one is named, and what was heard of their files."""
    report("decoding", 0.0)
    start = time.perf_counter()
    photo, warning, decoder = read_photo(image, reading, colour=colour)
    seconds["decoding"] = time.perf_counter() - start
    heard = [warning] if warning else []
    if subject is not None:
        start = time.perf_counter()
        photo, warning = _with_subject(photo, image, subject, reading)
        seconds["subject"] = time.perf_counter() - start
        heard += [warning] if warning else []
    return photo, _Heard(heard, [], decoder)


def _with_backdrop(options: Options, subject: SubjectLike, backdrop: str | None) -> Options:
    """Return the options with a backdrop, if one is named.

    Raises
    ------
    InvalidInputError
        If there is no such backdrop, or nothing that it could be behind.
    """
    if backdrop is None:
        return options
    options = options.replace(backdrop=backdrop)
    if subject is None:
        raise InvalidInputError(f'backdrop is "{backdrop}", but it must be left out without a subject, from which it steps back')
    return options


def _with_subject(
    photo: _core.Photo, image: ImageLike, subject: SubjectLike, reading: _core.Reading
) -> tuple[_core.Photo, str | None]:
    """Return the photo with its subject, and what is to be said of that."""
    mask: Any = subject
    if callable(subject) or (isinstance(subject, str) and subject == AUTO):
        from graphstipple import subject as subjects  # noqa: PLC0415  # it is asked for OpenCV

        rgb = subjects.rgb_of(image, photo, reading)
        if callable(subject):
            mask = subject(rgb)
        else:
            found = subjects.found(rgb)
            mask = None if found is None else subjects.as_photo(found)
        if mask is None:
            # Named as the command line names it.
            name = f"{os.fsdecode(image)}: " if isinstance(image, str | os.PathLike) else ""
            return photo, name + subjects.NONE_FOUND
    elif isinstance(subject, str) and is_text(subject) and not any(character in subject for character in "./\\"):
        raise InvalidInputError(f'subject is "{subject}", but it must be "{AUTO}" or the path of an image file')
    warning = None
    if not isinstance(mask, _core.Photo):
        is_file = is_pil(mask) or isinstance(mask, str | os.PathLike | bytes)
        if not is_file and getattr(mask, "ndim", 2) != 2:
            raise InvalidInputError(f"the subject has the shape {np.asarray(mask).shape}, but it must be (height, width)")
        mask, warning, _ = read_photo(mask, reading, "subject")
    photo = photo.with_subject(mask)
    return photo, warning if photo.subject is not None else _core.NO_SUBJECT


def _read_importance(
    importance: ImportanceLike, photo: _core.Photo, reading: _core.Reading, seconds: dict[str, float], heard: _Heard
) -> tuple[str | _core.Photo, _Heard]:
    """Return the source of a photo's importance for the core (a name or a map), and what was heard of its file besides."""
    if importance is None:
        importance = "saliency"
    if callable(importance):
        importance = importance(photo.luma)
    if isinstance(importance, os.PathLike):
        # A path is no name, even where it looks like one.
        importance = str(Path(os.fsdecode(importance)).absolute())
    if isinstance(importance, str) and is_text(path_to_read(importance)):
        return importance, heard
    is_file = is_pil(importance) or isinstance(importance, bytes)
    if not is_file and getattr(importance, "ndim", 2) != 2:
        raise InvalidInputError(f"the importance has the shape {np.asarray(importance).shape}, but it must be (height, width)")
    start = time.perf_counter()
    map_, warning, _ = read_photo(importance, reading, "importance")
    seconds["decoding"] = seconds.get("decoding", 0.0) + time.perf_counter() - start
    return map_, heard._replace(of_importance=[warning] if warning else [])


def _silent(stage: str, fraction: float) -> None:
    """Report nothing."""
