"""A look: all that makes a drawing's file besides the photo. In: what a page says; out: checked values, and the same as a command.

What comes from a page is names, numbers and short texts; none of it is ever taken for the path of a file.
"""

from __future__ import annotations

import json
import re
import shlex
from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import PurePath
from typing import Any, TypeGuard

from graphstipple import _core
from graphstipple._errors import InvalidInputError
from graphstipple._flags import METHOD, flat, of_options, of_settings, short
from graphstipple.options import Options

PAINTED = "painted"
"""The importance that was painted on the page."""

MAP_NAME = "importance.png"
"""The file of it, as the page names it where it is downloaded."""

LONGEST_TEXT = 200
"""Characters of a text that a page sends."""

SUBCOMMANDS = ("batch", "studio")
"""First arguments that are no photo's path."""

PAPER, NO_PAPER = "paper", "none"
"""The setting and the option of the paper's colour, and the setting where it has none."""

_BARE = re.compile(r"\s*\d*\.?\d*\s*([xX]\s*\d*\.?\d*\s*)?")
"""A length, or a size, without a unit."""


class _Setting:
    """A setting of a file, as it is declared."""

    def __init__(self, declared: tuple[str, str, str, list[str], bool, str, list[str]]) -> None:
        self.name, self.description, self.default, self.formats, self.everyday, value_name, self.words = declared
        kinds = {"": "switch", "LENGTH": "length", "PAGE": "page", "NUMBER": "number", "COLOR": "color"}
        self.kind = kinds.get(value_name, "words")
        self.is_length = self.kind in {"length", "page"}


SETTINGS = {declared[0]: _Setting(declared) for declared in _core.settings()}
"""Every setting by name."""

FORMATS = {suffix: name for suffix, name, *_ in _core.formats()}
"""Names of the formats by suffix."""

_WITH_PIXELS = {suffix for suffix in FORMATS if suffix in SETTINGS["dpi"].formats}

_SOURCES = [form for form, _ in _core.sources()]


@dataclass(frozen=True)
class Look:
    """What a page asks for.

    Parameters
    ----------
    preset : str
        Name of the preset that it began with.
    changed : dict
        Options that differ from the preset's, by full name.
    options : Options
        All of them.
    importance : str
        The name of a source, or `PAINTED`.
    settings : dict
        Settings of the file that the format takes, by name, as far as they were given.
    min_dot : str or None
        The least radius of a dot.
    suffix : str
        The format.
    """

    preset: str
    changed: dict[str, Any]
    options: Options
    importance: str
    settings: dict[str, Any]
    min_dot: str | None
    suffix: str

    @classmethod
    def of(cls, said: object) -> Look:
        """Return the look that a page has said.

        Raises
        ------
        InvalidInputError
            For the first thing that is none.
        """
        if not isinstance(said, dict):
            raise InvalidInputError(f"the look is of type {type(said).__name__}, but it must be a table")
        preset, suffix = _text(said, "preset", "default"), _text(said, "suffix", "svg")
        if suffix not in FORMATS:
            raise InvalidInputError(f"suffix is {suffix!r}, but it must be one of {', '.join(FORMATS)}")
        values = flat(_core.preset(preset).values())
        settings = _settings(_table(said, "settings"), suffix)
        # As on the command line, the paper of the inks and that of the file are one.
        of_file = settings.get(PAPER, NO_PAPER)
        given = ({PAPER: of_file} if of_file != NO_PAPER else {}) | _table(said, "options")
        # By the declarations' own order, and as Rust has them, so that the same options are the same look.
        checked = _core.Options(values | given)
        ours = flat(checked.values())
        changed = {name: value for name, value in ours.items() if value != values[name]}
        min_dot = said.get("min_dot")
        if min_dot is not None and not _is_text(min_dot):
            raise InvalidInputError(f"min_dot is {_told(min_dot)}, but it must be a length such as 0.3mm")
        if suffix in SETTINGS[PAPER].formats and ours[PAPER] is not None:
            settings[PAPER] = ours[PAPER]
        if suffix not in _WITH_PIXELS:
            _check_unit("min_dot", min_dot)
        only = {name: only for name, _, only in _core.presets()}[preset]
        # As on the command line: a layered drawing has all inks.
        if only and suffix in SETTINGS["only"].formats and "only" not in settings and settings.get("style", "flat") == "flat":
            settings["only"] = only
        return cls(preset, changed, Options._of(checked), _importance(said), settings, min_dot or None, suffix)

    @property
    def sizes(self) -> dict[str, Any]:
        """The settings that are about the size on paper, which a least dot goes by."""
        return {name: value for name, value in self.settings.items() if SETTINGS[name].is_length}

    def output(self, photo: str) -> str:
        """Return the name of the file for a photo's."""
        return f"{PurePath(photo).stem or 'photo'}-drawing.{self.suffix}"

    def as_command(self, photo: str) -> str:
        """Return the command line that writes the same file."""
        # What begins with a hyphen is no flag, and what is called as a subcommand is none.
        path = f"./{photo}" if photo.startswith("-") or photo in SUBCOMMANDS else photo
        words = ["graphstipple", path, "-o", PurePath(self.output(path)).name]
        words[3] = f"./{words[3]}" if words[3].startswith("-") else words[3]
        if self.preset != "default":
            words += ["--preset", self.preset]
        words += of_options(self.changed)
        if self.importance != _SOURCES[0]:
            words += ["--importance", self._importance_named]
        words += of_settings({name: value for name, value in self._written().items() if name not in self.changed})
        if self.min_dot is not None:
            words += ["--min-dot", self.min_dot]
        return " ".join(_shell_word(word) for word in words)

    def as_python(self, photo: str) -> str:
        """Return lines of Python that write the same file."""
        plain = {name: value for name, value in self.changed.items() if not name.startswith(f"{METHOD}.")}
        method = {name.removeprefix(f"{METHOD}."): value for name, value in self.changed.items() if name not in plain}
        given = [_arguments(plain)] if plain else []
        if method:
            begin = f"gs.Options.preset({_source(self.preset)})"
            given.append(f"{METHOD}={begin}.{METHOD}.replace({_arguments(method)})")
        drawn = [_source(photo)]
        if self.importance != _SOURCES[0]:
            drawn.append(f"importance={_source(self._importance_named)}")
        if self.preset != "default":
            drawn.append(f"options=gs.Options.preset({', '.join([_source(self.preset), *given])})")
        elif given:
            drawn.append(f"options=gs.Options({', '.join(given)})")
        lines = ["import graphstipple as gs", "", f"drawing = gs.draw({', '.join(drawn)})"]
        if self.min_dot is not None:
            arguments = ", ".join([_source(self.min_dot), *([_arguments(self.sizes)] if self.sizes else [])])
            lines.append(f"drawing = drawing.with_min_dot({arguments})")
        written = self._written(for_python=True)
        lines.append(f"drawing.save({', '.join([_source(self.output(photo)), *([_arguments(written)] if written else [])])})")
        return "\n".join(lines) + "\n"

    @property
    def _importance_named(self) -> str:
        return MAP_NAME if self.importance == PAINTED else self.importance

    def _written(self, *, for_python: bool = False) -> dict[str, Any]:
        """Return the settings that have to be said, beyond what a preset suggests on the command line."""
        only = {name: only for name, _, only in _core.presets()}[self.preset]
        usual = "" if for_python else only
        written = {name: value for name, value in self.settings.items() if value is not False}
        if written.get("only", "") == usual:
            written.pop("only", None)
        return written


def _importance(said: dict[str, Any]) -> str:
    """Return the importance that is said: a name of a source, never a file's."""
    name = _text(said, "importance", _SOURCES[0])
    begin, _, number = name.partition(":")
    is_constant = f"{begin}:V" in _SOURCES and re.fullmatch(r"\d*\.?\d+", number) is not None and 0 < float(number) <= 1
    if name != PAINTED and not (is_constant or (name in _SOURCES and " " not in name)):
        named = ", ".join(form for form in _SOURCES if " " not in form)
        raise InvalidInputError(f"importance is {_told(name)}, but it must be {named}, with V above 0 and at most 1, or {PAINTED}")
    return name


def _settings(given: dict[str, Any], suffix: str) -> dict[str, Any]:
    """Return those that the format takes, without what is at its default."""
    taken: dict[str, Any] = {}
    for name, value in given.items():
        setting = SETTINGS.get(name)
        if setting is None:
            raise InvalidInputError(f"there is no setting {_told(name)}: there are {', '.join(SETTINGS)}")
        if suffix not in setting.formats or value in (None, ""):
            continue
        if not (isinstance(value, bool | int | float) or _is_text(value)):
            raise InvalidInputError(f"{name} is {_told(value)}, but it must be a short text, a number, or on or off")
        if setting.is_length and suffix not in _WITH_PIXELS:
            _check_unit(name, value)
        if setting.kind == "number" and isinstance(value, str):
            try:
                value = float(value)  # noqa: PLW2901  # a number that was typed
            except ValueError:
                raise InvalidInputError(f"{name} is {_told(value)}, but it must be a number") from None
        taken[name] = value.strip() if isinstance(value, str) else value
    return taken


def _check_unit(name: str, value: object) -> None:
    """Refuse lengths on paper without a unit, as the command line does: px, which they would be, is hardly meant."""
    text = str(value).strip()
    if value is not None and _BARE.fullmatch(text) and text.strip("0.xX "):
        raise InvalidInputError(f"{name} is {_told(text)}, but it must have a unit: {text}mm, or {text}px for pixels of 1/96 inch")


def _table(said: dict[str, Any], name: str) -> dict[str, Any]:
    table = said.get(name, {})
    if not isinstance(table, dict):
        raise InvalidInputError(f"{name} is of type {type(table).__name__}, but it must be a table")
    return table


def _text(said: dict[str, Any], name: str, default: str) -> str:
    text = said.get(name, default)
    if not _is_text(text):
        raise InvalidInputError(f"{name} is {_told(text)}, but it must be a short text")
    return text


def _is_text(value: object) -> TypeGuard[str]:
    return isinstance(value, str) and len(value) <= LONGEST_TEXT


def _told(value: object) -> str:
    """Return a value for a sentence, cut where it is long."""
    text = repr(value)
    return text if len(text) <= 80 else f"{text[:77]}..."


def _arguments(values: Mapping[str, Any]) -> str:
    return ", ".join(f"{name}={_source(value)}" for name, value in values.items())


def _source(value: object) -> str:
    """Return a value as people write it in Python: texts in double quotes."""
    if not isinstance(value, str):
        return repr(short(value))
    quoted = json.dumps(value, ensure_ascii=False)
    return "".join(it if it.isprintable() else it.encode("unicode_escape").decode() for it in quoted)


def _shell_word(text: str) -> str:
    """Return a word as a shell has it; what a terminal would act upon when it is pasted is escaped, as in bash and zsh."""
    if text.isprintable():
        return shlex.quote(text)
    escaped = text.replace("\\", "\\\\").replace("'", "\\'")
    return "$'" + "".join(it if it.isprintable() else _octets(it) for it in escaped) + "'"


def _octets(character: str) -> str:
    return "".join(f"\\x{octet:02x}" for octet in character.encode("utf-8", "surrogateescape"))
