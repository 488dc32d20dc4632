"""Options as the flags of a command line. In: options by full name; out: words that the command line takes for them."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

from graphstipple import _core

METHOD = "published"
"""The table of the published method's parameters: the full name of one is ``published.NAME``."""


def flat(values: Mapping[str, Any]) -> dict[str, Any]:
    """Return values of options by full name."""
    plain = {name: value for name, value in values.items() if name != METHOD}
    return plain | {f"{METHOD}.{name}": value for name, value in values[METHOD].items()}


def value_words() -> dict[str, str]:
    """Return what no value is called, by full name of the options that may have none."""
    properties = dict(_core.options_schema()["properties"])
    method = properties.pop(METHOD)["properties"]
    all_of_them = properties | {f"{METHOD}.{name}": option for name, option in method.items()}
    return {name: option["x-absent"]["word"] for name, option in all_of_them.items() if "x-absent" in option}


def flag(name: str) -> str:
    """Return the flag of a name."""
    return "--" + name.replace("_", "-")


def short(value: object) -> object:
    """Return a whole number without its fraction."""
    return int(value) if isinstance(value, float) and value.is_integer() else value


def of_options(values: Mapping[str, Any]) -> list[str]:
    """Return the words for options by full name, as far as they differ from those that the command line begins with."""
    words: list[str] = []
    absent = value_words()
    for name, value in values.items():
        text = absent[name] if value is None else str(short(value))
        if name.startswith(f"{METHOD}."):
            words += [f"--{METHOD}", f"{name.removeprefix(METHOD + '.')}={text}"]
        elif value is True:
            words.append(flag(name))
        else:
            words += [flag(name), text]
    return words


def of_settings(values: Mapping[str, Any]) -> list[str]:
    """Return the words for whatever else the command line takes, by name."""
    words: list[str] = []
    for name, value in values.items():
        if value is not False and value is not None:
            words += [flag(name)] if value is True else [flag(name), str(short(value))]
    return words
