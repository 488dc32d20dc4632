"""What differs between two drawings: in words, mark by mark, and as a picture of both with what came and went between them.

Marks that are equal to the last digit of a drawing's file are the same. The others are matched, nearest first, with marks of their
own ink: a pair has changed, what is left over came or went.
"""

from __future__ import annotations

from collections import Counter
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import Any, Generic, TypeVar

import numpy as np
from numpy.typing import NDArray
from PIL import Image, ImageDraw, ImageFont
from scipy.spatial.distance import cdist

REACH = 2.0
"""How far, in pixels, a mark may move and still be the same one: less than from dot to dot, more than a node is moved by changes
that are meant to be small."""

PIXEL_TOLERANCE = 3
"""Grey levels by which pixels may differ: the raster is deterministic on one platform, but between platforms antialiasing may round
a level or two the other way."""

CAME, WENT, PIXELS = (0, 90, 220), (225, 60, 0), (255, 225, 90)
"""Colours of marks that came, of marks that went, and of pixels that differ: blue, orange and yellow."""

ZOOM, CAPTION, GAP = 6, 22, 8
"""Pixels of the picture for one of the canvas, height of its captions, and the space between its parts."""

Mark = TypeVar("Mark")


@dataclass(frozen=True)
class State:
    """A drawing, and what is compared of it.

    Parameters
    ----------
    file : dict
        What its JSON file holds.
    counts : dict
        Some of its `stats`.
    labels : ndarray of uint8
        The label of every node.
    raster : ndarray of uint8, (height, width)
        Its pixels.
    """

    file: dict[str, Any]
    counts: dict[str, int]
    labels: NDArray[np.uint8]
    raster: NDArray[np.uint8]


@dataclass(frozen=True)
class Change(Generic[Mark]):
    """Marks of one kind that are not the same in two drawings."""

    came: list[Mark]
    went: list[Mark]
    changed: list[tuple[Mark, Mark]]
    """Pairs of the expected one and the one that was got."""
    same: int
    is_reordered: bool
    """Whether those that are the same stand in another order."""

    def __bool__(self) -> bool:
        return bool(self.came or self.went or self.changed or self.is_reordered)

    def text(self, *of_pairs: str) -> str:
        """Return it in words, with what is to be said of the pairs."""
        parts = [f"{len(self.came)} came"] * bool(self.came) + [f"{len(self.went)} went"] * bool(self.went)
        parts += [*of_pairs, f"{self.same} as before"]
        return ", ".join(parts) + ", in another order" * self.is_reordered


@dataclass(frozen=True)
class Dot:
    """A dot as a drawing's file has it."""

    x: float
    y: float
    radius: float
    ink: int


@dataclass(frozen=True)
class Region:
    """A region as a drawing's file has it."""

    ink: int
    rings: tuple[tuple[tuple[float, float], ...], ...]
    """The exterior and the holes."""


def dots(state: State) -> list[Dot]:
    """Return the dots of a drawing."""
    return [Dot(**dot) for dot in state.file["stipples"]]


def regions(state: State) -> list[Region]:
    """Return the regions of a drawing."""
    found = []
    for region in state.file["regions"]:
        rings = (region["exterior"], *region["holes"])
        found.append(Region(region["ink"], tuple(tuple((x, y) for x, y in ring) for ring in rings)))
    return found


def dot_changes(expected: State, got: State) -> Change[Dot]:
    """Return what became of the dots."""
    return _changes(dots(expected), dots(got), lambda dot: (dot.ink, np.array([[dot.x, dot.y]])))


def curve_changes(expected: State, got: State) -> Change[str]:
    """Return what became of the curves between regions, as paths."""
    return _changes(expected.file["curves"], got.file["curves"], lambda path: (0, _points(path)))


def region_changes(expected: State, got: State) -> Change[Region]:
    """Return what became of the regions."""
    return _changes(regions(expected), regions(got), lambda region: (region.ink, np.array(region.rings[0])))


def _changes(
    expected: Sequence[Mark], got: Sequence[Mark], place: Callable[[Mark], tuple[int, NDArray[np.float64]]]
) -> Change[Mark]:
    """Match marks: the same with the same, then the nearest within reach, by their ink and points, which `place` gives."""
    before, after = Counter(expected), Counter(got)
    went, came, same = list((before - after).elements()), list((after - before).elements()), before & after
    distances = _distances([place(mark) for mark in went], [place(mark) for mark in came])
    pairs: dict[int, int] = {}
    for i, j in sorted(distances, key=lambda pair: distances[pair]):
        if i not in pairs and j not in pairs.values():
            pairs[i] = j
    return Change(
        came=[mark for j, mark in enumerate(came) if j not in pairs.values()],
        went=[mark for i, mark in enumerate(went) if i not in pairs],
        changed=[(went[i], came[j]) for i, j in pairs.items()],
        same=same.total(),
        is_reordered=[mark for mark in expected if mark in same] != [mark for mark in got if mark in same],
    )


def _distances(
    some: Sequence[tuple[int, NDArray[np.float64]]], others: Sequence[tuple[int, NDArray[np.float64]]]
) -> dict[tuple[int, int], float]:
    """Return the distances of all pairs of one ink within reach: of the points of one to the other, the larger of both means."""
    found = {}
    for i, (ink, points) in enumerate(some):
        for j, (other_ink, other_points) in enumerate(others):
            gap = np.maximum(points.min(axis=0) - other_points.max(axis=0), other_points.min(axis=0) - points.max(axis=0))
            if ink != other_ink or gap.max() > REACH:
                continue
            apart = cdist(points, other_points)
            distance = max(apart.min(axis=0).mean(), apart.min(axis=1).mean())
            if distance <= REACH:
                found[i, j] = float(distance)
    return found


def _points(path: str) -> NDArray[np.float64]:
    """Return points on a curve: those that a path of M, L, Q and Z has on it, and more along its Béziers."""
    numbers = "".join(" " if letter in "MLQZ," else letter for letter in path).split()
    commands = [letter for letter in path if letter in "MLQ"]
    left = iter(np.array(numbers, float).reshape(-1, 2))
    points: list[NDArray[np.float64]] = []
    for command in commands:
        if command == "Q":
            start, control, end = points[-1], next(left), next(left)
            points += [(1 - t) ** 2 * start + 2 * t * (1 - t) * control + t**2 * end for t in (0.25, 0.5, 0.75, 1)]
        else:
            points.append(next(left))
    return np.array(points)


def in_words(expected: State, got: State) -> list[str]:
    """Return what differs, a line for each kind of thing; none if the drawings are the same and look the same."""
    lines = []
    change = dot_changes(expected, got)
    if change:
        moved = [float(np.hypot(a.x - b.x, a.y - b.y)) for a, b in change.changed if (a.x, a.y) != (b.x, b.y)]
        resized = [abs(a.radius - b.radius) for a, b in change.changed if a.radius != b.radius]
        said = [f"{len(moved)} moved by up to {max(moved):.3g} px"] if moved else []
        said += [f"{len(resized)} changed radius by up to {max(resized):.3g} px"] if resized else []
        lines.append(f"dots: {change.text(*said)}")
    shapes: dict[str, Change[Any]] = {"curves": curve_changes(expected, got), "regions": region_changes(expected, got)}
    for name, shape in shapes.items():
        if shape:
            lines.append(f"{name}: {shape.text(*[f'{len(shape.changed)} changed'] * bool(shape.changed))}")
    if len(expected.labels) != len(got.labels):
        lines.append(f"labels: of {len(got.labels)} nodes instead of {len(expected.labels)}")
    elif flipped := np.count_nonzero(expected.labels != got.labels):
        lines.append(f"labels: {flipped} of {len(got.labels)} nodes, in their order, have the other one")
    values = {
        "counts": (expected.counts, got.counts),
        "options": (_flat(expected.file["options"]), _flat(got.file["options"])),
        "file": (_rest(expected), _rest(got)),
    }
    for name, (old, new) in values.items():
        differing = [f"{key} {old.get(key)} → {new.get(key)}" for key in {**old, **new} if old.get(key) != new.get(key)]
        if differing:
            lines.append(f"{name}: {', '.join(differing)}")
    pixels = _pixels_in_words(expected.raster, got.raster)
    if lines or pixels is not None:
        lines.append(f"pixels: {pixels or f'none differs by more than {PIXEL_TOLERANCE} grey levels'}")
    return lines


def _flat(options: dict[str, Any]) -> dict[str, Any]:
    """Return options with those of the published method beside the others."""
    return {**options, **options["published"], "published": None}


def _rest(state: State) -> dict[str, Any]:
    """Return what else a drawing's file holds; but for the version, which changes without a change of the drawing."""
    return {key: value for key, value in state.file.items() if key not in {"stipples", "curves", "regions", "options", "version"}}


def _pixels_in_words(expected: NDArray[np.uint8], got: NDArray[np.uint8]) -> str | None:
    """Return how many pixels differ and by how much; None if they do not show."""
    if expected.shape != got.shape:
        (old_height, old_width), (height, width) = expected.shape, got.shape
        return f"{width} x {height} instead of {old_width} x {old_height}"
    by = np.abs(expected.astype(int) - got)
    if by.max() <= PIXEL_TOLERANCE:
        return None
    shown = by[by > PIXEL_TOLERANCE]
    return (
        f"{shown.size} of {by.size} differ by more than {PIXEL_TOLERANCE} grey levels, by up to {shown.max()}, "
        f"by {shown.mean():.0f} on average"
    )


def picture(expected: State, got: State) -> Image.Image:
    """Return expected, difference and got side by side, with captions.

    The difference is both, pale, with the pixels that differ, and the outlines of dots and curves that came, went or changed.
    """
    old, new = _panel(expected), _panel(got)
    width, height = max(old.width, new.width), max(old.height, new.height)
    font = ImageFont.load_default(14)
    sheet = Image.new("RGB", (3 * width + 4 * GAP, height + CAPTION + 2 * GAP), "white")
    draw = ImageDraw.Draw(sheet)
    panels = {"expected": old, "difference:": _difference(old, new, expected, got), "got": new}
    for i, (caption, panel) in enumerate(panels.items()):
        left = GAP + i * (width + GAP)
        sheet.paste(panel, (left, CAPTION + GAP))
        draw.text((left, GAP // 2), caption, "black", font)
    left = GAP + width + GAP + round(draw.textlength("difference:  ", font))
    for meaning, colour in {"came": CAME, "went": WENT, "pixels": PIXELS}.items():
        draw.rectangle([left, GAP // 2 + 3, left + 12, GAP // 2 + 15], colour)
        draw.text((left + 18, GAP // 2), meaning, "black", font)
        left += 18 + round(draw.textlength(f"{meaning}  ", font))
    return sheet


def _panel(state: State) -> Image.Image:
    """Return the drawing's pixels at the picture's scale."""
    size = (ZOOM * state.file["canvas"]["width"], ZOOM * state.file["canvas"]["height"])
    return Image.fromarray(state.raster).convert("RGB").resize(size, Image.Resampling.NEAREST)


def _difference(old: Image.Image, new: Image.Image, expected: State, got: State) -> Image.Image:
    """Return what differs over a pale mean of both drawings."""
    both = np.stack([np.asarray(panel.resize(new.size), float) for panel in (old, new)])
    levels = (192 + both.mean(axis=0) / 4).astype(np.uint8)
    levels[np.ptp(both, axis=0).max(axis=-1) > PIXEL_TOLERANCE] = PIXELS
    panel = Image.fromarray(levels)
    draw = ImageDraw.Draw(panel)
    dot, curve = dot_changes(expected, got), curve_changes(expected, got)
    for colour, circles, paths in (
        (WENT, [*dot.went, *(a for a, _ in dot.changed)], [*curve.went, *(a for a, _ in curve.changed)]),
        (CAME, [*dot.came, *(b for _, b in dot.changed)], [*curve.came, *(b for _, b in curve.changed)]),
    ):
        for path in paths:
            points = _points(path)
            points = np.concatenate([points, points[:1]]) if path.endswith("Z") else points
            draw.line([(x, y) for x, y in ZOOM * points], colour, 2)
        for circle in circles:
            draw.circle((ZOOM * circle.x, ZOOM * circle.y), ZOOM * circle.radius, outline=colour, width=2)
    return panel
