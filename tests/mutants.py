"""Files of drawings that were changed by chance, as a slip of the hand, a bad editor or somebody who means harm would.

In: the text of a JSON or SVG file that graphstipple wrote, and a random generator; out: another text. Whether it is still a drawing
is for the loader to say, and for the tests to judge.
"""

from __future__ import annotations

import json
import math
import re
from collections.abc import Callable
from typing import Any

from numpy.random import Generator

NUMBER = re.compile(r"-?(?:\d+\.?\d*|\.\d+)(?:[eE][-+]?\d+)?")

SUBPATH = re.compile(r"m[^mz\"]*z")
"""A closed curve in the path data of our SVG."""

EXTREMES = ("0", "-0", "1e14", "-1e300", "1e999", "nan", "NaN", "1e-320", "65536", "4294967296", "0.1", "")
"""What stands in for a number once in a while."""

CHARACTERS = '0123456789-.,e"<>mlhvqtcsaz{}[] '
"""What is written over others."""


def mutant_of_json(text: str, random: Generator) -> str:
    """Return the text with one to three changes."""
    # Some come more often than others, so that more mutants are drawings.
    changes = [_anywhere, _sizes, _inks, _curves, _dots, *2 * [_in_curve], *3 * [_move_curve], *3 * [_dot]]
    for _ in range(_count(random)):
        change = _chosen(changes, random)
        if change is _anywhere:
            return _anywhere(text, random)
        document = json.loads(text)
        change(document, random)
        text = json.dumps(document)
    return text


def mutant_of_svg(text: str, random: Generator) -> str:
    """Return the text with one to three changes."""
    changes = [_anywhere, _attribute, _layers, *3 * [_in_subpath], *2 * [_subpaths]]
    for _ in range(_count(random)):
        text = _chosen(changes, random)(text, random)
    return text


def _count(random: Generator) -> int:
    """Return the number of changes: most often one, since the more there are the fewer can be accepted."""
    return int(random.choice([1, 1, 1, 2, 3]))


def _chosen(of: Any, random: Generator) -> Any:
    return of[int(random.integers(len(of)))]


def _anywhere(text: str, random: Generator) -> str:
    """Delete, repeat or overwrite a few characters."""
    begin = int(random.integers(len(text)))
    end = begin + int(random.integers(1, 12))
    noise = "".join(_chosen(CHARACTERS, random) for _ in range(3))
    instead = _chosen(["", 2 * text[begin:end], noise], random)
    return text[:begin] + instead + text[end:]


def _number(text: str, random: Generator) -> str:
    """Return another number: near, mirrored, far, or none at all."""
    value = float(text) if math.isfinite(float(text)) else 0.0
    near = 2.0 ** -float(random.integers(2, 20))
    others = [value + near, value - near, value + random.normal(0, 0.1), value + random.normal(0, 2), -value]
    others += [round(value + random.normal(0, 40)), value * random.choice([0.5, 2, 16])]
    return str(_chosen([_chosen(EXTREMES, random), *map(_plain, others)], random))


def _plain(value: float) -> str:
    """Return a number without an exponent."""
    return f"{value:.12f}".rstrip("0").rstrip(".")


def _with_other_number(text: str, random: Generator) -> str:
    """Return a text in which one of its numbers is another."""
    numbers = list(NUMBER.finditer(text))
    if not numbers:
        return text
    found = _chosen(numbers, random)
    other = _number(found[0], random)
    # What stood apart because of its sign still does.
    apart = " " if found[0].startswith("-") and not other.startswith("-") else ""
    return text[: found.start()] + apart + other + text[found.end() :]


# JSON ----------------------------------------------------------------------------------------------------------------------------


def _with_points(path: str, change: Callable[[float, float], tuple[float, float]]) -> str:
    """Return absolute path data with all points changed."""
    return re.sub(r"(-?[\d.e+-]+),(-?[\d.e+-]+)", lambda m: "{!r},{!r}".format(*change(float(m[1]), float(m[2]))), path)


def _in_curve(document: dict[str, Any], random: Generator) -> None:
    curves = document["curves"]
    if curves:
        number = int(random.integers(len(curves)))
        curves[number] = _with_other_number(curves[number], random)


def _move_curve(document: dict[str, Any], random: Generator) -> None:
    """Move a curve as a whole, or make it larger or smaller, or mirror it."""
    curves = document["curves"]
    if not curves:
        return
    number = int(random.integers(len(curves)))
    x, y = (float(v) for v in random.normal(0, _chosen([0.05, 1, 10], random), 2))
    a, b = float(random.choice([1, 1, 0.5, 1.1, -1])), float(random.choice([1, 1, 0.5, 1.1, -1]))
    points = re.findall(r"(-?[\d.e+-]+),(-?[\d.e+-]+)", curves[number])
    if not points:
        return
    u, v = (sum(float(point[axis]) for point in points) / len(points) for axis in (0, 1))
    curves[number] = _with_points(curves[number], lambda p, q: (u + a * (p - u) + x, v + b * (q - v) + y))


def _in_list(items: list[Any], random: Generator) -> None:
    """Drop an item, have it twice, or exchange two."""
    if not items:
        return
    one, other = (int(i) for i in random.integers(len(items), size=2))
    match random.integers(3):
        case 0:
            items.pop(one)
        case 1:
            items.insert(other, json.loads(json.dumps(items[one])))
        case _:
            items[one], items[other] = items[other], items[one]


def _curves(document: dict[str, Any], random: Generator) -> None:
    _in_list(document["curves"], random)


def _dot(document: dict[str, Any], random: Generator) -> None:
    """Move a dot, or make it larger or smaller."""
    if document["stipples"]:
        dot = _chosen(document["stipples"], random)
        name = _chosen(["x", "y", "radius"], random)
        other = _number(repr(float(dot[name])), random)
        dot[name] = float(other) if other else None


def _dots(document: dict[str, Any], random: Generator) -> None:
    _in_list(document["stipples"], random)


def _sizes(document: dict[str, Any], random: Generator) -> None:
    """Change the canvas or the grid."""
    name = _chosen(["width", "height", "units"], random)
    where = document if name == "units" else document["canvas"]
    others = [0, 1, 7, 64, 65536, -5, 1.5, "3", None]
    if isinstance(where[name], (int, float)):
        others += [2 * where[name], where[name] + 1, where[name] / 2]
    where[name] = _chosen(others, random)


def _inks(document: dict[str, Any], random: Generator) -> None:
    marks = document["stipples"] + document["regions"]
    mark = _chosen(marks, random)
    mark["ink"] = _chosen([0, 1, 0 if mark["ink"] else 1, 2, -1, "black"], random)


# SVG -----------------------------------------------------------------------------------------------------------------------------


def _in_subpath(text: str, random: Generator) -> str:
    found = list(SUBPATH.finditer(text))
    if not found:
        return text
    subpath = _chosen(found, random)
    return text[: subpath.start()] + _with_other_number(subpath[0], random) + text[subpath.end() :]


def _subpaths(text: str, random: Generator) -> str:
    """Drop a subpath, have it twice, or exchange two."""
    found = list(SUBPATH.finditer(text))
    if not found:
        return text
    one, other = sorted((_chosen(found, random) for _ in range(2)), key=re.Match.start)
    match random.integers(3):
        case 0:
            return text[: one.start()] + text[one.end() :]
        case 1:
            return text[: other.start()] + one[0] + text[other.start() :]
        case _ if one.start() == other.start():
            return text
        case _:
            return text[: one.start()] + other[0] + text[one.end() : other.start()] + one[0] + text[other.end() :]


def _attribute(text: str, random: Generator) -> str:
    """Change a number in an attribute that is no path data."""
    found = list(re.finditer(r' (?!d=|xmlns|id=)[\w:-]+="[^"]*\d[^"]*"', text))
    attribute = _chosen(found, random)
    return text[: attribute.start()] + _with_other_number(attribute[0], random) + text[attribute.end() :]


def _layers(text: str, random: Generator) -> str:
    """Give a group the other ink's name or colour, or drop a group."""
    groups = list(re.finditer(r"<g .*?</g>", text, re.DOTALL))
    if not groups:
        return text
    group = _chosen(groups, random)
    match random.integers(4):
        case 0:
            other = ""
        case 1:
            other = re.sub("black|white", lambda m: {"black": "white", "white": "black"}[m[0]], group[0], count=1)
        case 2:
            colour = _chosen(["", ' fill="#fff"', ' fill="#000"', ' fill="#f00"'], random)
            other = re.sub(r' fill="[^"]*"', colour, group[0], count=1)
        case _:
            other = 2 * group[0]
    return text[: group.start()] + other + text[group.end() :]
