"""`Studio`: the studio as a widget of a notebook, with the same page."""

from __future__ import annotations

import os
import re
from pathlib import Path
from typing import TYPE_CHECKING, Any

from graphstipple._errors import MissingPackageError
from graphstipple._inputs import ImageLike
from graphstipple._memory import half_of_the_memory
from graphstipple.drawing import Drawing
from graphstipple.options import Options
from graphstipple.studio.desk import MOST_UPLOADED, Budget, Desk

MISSING: ImportError | None = None
"""Why there are no widgets, if there are none."""

if TYPE_CHECKING:
    from anywidget import AnyWidget
else:
    try:
        from anywidget import AnyWidget
    except ImportError as error:
        # The name is there all the same, for `from graphstipple import *`.
        AnyWidget, MISSING = object, error

PAGE = Path(__file__).parent / "page"

_IMPORT = re.compile(r'^import \{[^}]*\} from "\./([\w-]+\.js)";\n', re.MULTILINE)

_EXPORT = re.compile(r"^export (?=(?:async )?function|class|const)", re.MULTILINE)


def _joined(entry: str) -> str:
    """Return a module of the page with all that it imports, as one: a widget has one file."""
    joined: dict[str, str] = {}

    def add(name: str) -> None:
        if name in joined:
            return
        source = (PAGE / name).read_text(encoding="utf-8")
        joined[name] = ""
        for imported in _IMPORT.findall(source):
            add(imported)
        # After what it imports.
        del joined[name]
        joined[name] = _EXPORT.sub("", _IMPORT.sub("", source))

    add(entry)
    return "\n".join(joined.values())


class Studio(AnyWidget):
    """The studio in a notebook: a photo, its drawing, and the options to turn.

    As the last line of a cell it shows itself. What is turned is seen at once, and `drawing` and `options` are what is seen.

    Parameters
    ----------
    image : str, path, bytes, PIL image or ndarray, optional
        The photo, as for `draw`. Others can be dropped on the widget.

    Raises
    ------
    MissingPackageError
        If anywidget is not installed: ``pip install graphstipple[studio]``.

    Examples
    --------
    >>> import graphstipple as gs
    >>> studio = gs.Studio("photo.jpg")  # doctest: +SKIP
    >>> studio.drawing.save("drawing.svg")  # doctest: +SKIP
    """

    _esm = _joined("widget.js")
    _css = (PAGE / "studio.css").read_text(encoding="utf-8")

    def __init__(self, image: ImageLike | None = None) -> None:
        if MISSING is not None:
            way_out = "pip install graphstipple[studio]"
            raise MissingPackageError(f"the studio needs the package anywidget in a notebook ({MISSING}): {way_out}") from MISSING
        photo = None if image is None else (_name(image), image)
        self._desk = Desk(self._from_desk, photo, Budget(half_of_the_memory(), MOST_UPLOADED))
        super().__init__()
        self.on_msg(self._from_page)

    @property
    def drawing(self) -> Drawing | None:
        """The drawing that is seen; None before the first one is there."""
        return None if self._desk.seen is None else self._desk.seen.drawing

    @property
    def options(self) -> Options | None:
        """The options that it is made with; None before the first drawing is there."""
        return None if self._desk.seen is None else self._desk.seen.look.options

    def close(self) -> None:
        """Close the widget, and let go of the photo and its drawings."""
        self._desk.close()
        super().close()

    def _from_desk(self, message: dict[str, Any], data: bytes | None) -> None:
        self.send(message, None if data is None else [data])

    def _from_page(self, widget: object, content: object, buffers: list[Any]) -> None:
        self._desk.receive(content, bytes(buffers[0]) if buffers else None)


def _name(image: ImageLike) -> str:
    """Return what a photo is called in the copied command."""
    return os.fsdecode(image) if isinstance(image, str | os.PathLike) else "photo.png"
