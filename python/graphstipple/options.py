"""The options of a drawing: the same names, defaults and ranges as in Rust, on the command line and in a drawing's metadata.

What the fields are stands in `_option_fields`, which is made from the declarations in Rust.
"""

from __future__ import annotations

import dataclasses
from collections.abc import Callable
from dataclasses import dataclass
from typing import Any, NamedTuple, TypeVar

from graphstipple import _core
from graphstipple._errors import InvalidInputError
from graphstipple._inputs import plain
from graphstipple._option_fields import OURS, OptionFields, PublishedFields

T = TypeVar("T", bound="_Checked")


class _Checked:
    """What options of both kinds have in common: values that Rust has checked when they were made."""

    _checked: _core.Options
    """What the core takes; no field, so that it does not count where options are compared."""

    def replace(self: T, **changes: Any) -> T:
        """Return the same with single values changed by keyword.

        Parameters
        ----------
        **changes
            Values to change.

        Returns
        -------
        Options or Published

        Raises
        ------
        InvalidInputError
            If a value has the wrong type or lies outside its range.
        """
        return _made(type(self), {**_fields(self), **changes})

    def __reduce__(self: T) -> tuple[Callable[..., T], tuple[type[T], dict[str, Any]]]:
        return _made, (type(self), _fields(self))


def _fields(options: Any) -> dict[str, Any]:
    """Return the values of options by name."""
    return {field.name: getattr(options, field.name) for field in dataclasses.fields(options)}


def _store(options: PublishedFields | OptionFields, core: _core.Options, values: dict[str, Any]) -> None:
    """Keep the values as Rust has them, and what it has checked."""
    for name, value in values.items():
        object.__setattr__(options, name, value)
    object.__setattr__(options, "_checked", core)


def _made(kind: type[T], values: dict[str, Any]) -> T:
    """Make options of these values."""
    return kind(**values)


@dataclass(frozen=True, kw_only=True)
class Published(PublishedFields, _Checked):  # noqa: D101  # it has that of its fields
    __doc__ = PublishedFields.__doc__

    def __post_init__(self) -> None:
        core = _core.Options({f"published.{name}": plain(value) for name, value in _fields(self).items()})
        # What Rust makes of the values is stored, so that density=1 and density=1.0 are equal.
        _store(self, core, core.values()["published"])


@dataclass(frozen=True, kw_only=True)
class Options(OptionFields, _Checked):  # noqa: D101  # it has that of its fields
    __doc__ = OptionFields.__doc__

    published: Published = Published(**OURS)

    def __post_init__(self) -> None:
        if not isinstance(self.published, Published):
            raise InvalidInputError(f"published is {self.published!r}, but it must be graphstipple.Published")
        values = {name: plain(value) for name, value in _fields(self).items() if name != "published"}
        core = _core.Options(values, self.published._checked)
        _store(self, core, {name: value for name, value in core.values().items() if name != "published"})

    @classmethod
    def preset(cls, name: str, **changes: Any) -> Options:
        """Return the options of a preset (see `graphstipple.presets`), with single ones changed by keyword.

        Parameters
        ----------
        name : str
            Name of the preset.
        **changes
            Options that differ from the preset's.

        Returns
        -------
        Options

        Raises
        ------
        InvalidInputError
            If there is no preset of this name.
        """
        options = cls._of(_core.preset(name))
        return options.replace(**changes) if changes else options

    @classmethod
    def _of(cls, core: _core.Options) -> Options:
        """Return what Rust has checked already."""
        values = core.values()
        published, options = object.__new__(Published), object.__new__(cls)
        _store(published, core, values.pop("published"))
        _store(options, core, {**values, "published": published})
        return options


class Preset(NamedTuple):
    """A named set of options: ``Options.preset(name)``."""

    name: str
    description: str
    """What it gives, in a few words."""
    only: str
    """What a flat vector file is best written with: the `only` of `Drawing.save`, or "" for all inks. The command line does so by
    itself."""


def presets() -> list[Preset]:
    """Return all presets, the default first.

    Returns
    -------
    list of Preset
    """
    return [Preset(name, description, only) for name, description, only in _core.presets()]
