"""Tables as data: what the report prints and its test reads, and gains over a reference, which other commands print in Markdown."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterable, Sequence
from dataclasses import dataclass
from typing import Literal, NamedTuple

import numpy as np
import numpy.typing as npt

from graphstipple_eval import ours, quoted
from graphstipple_eval.flip import PIXELS_PER_DEGREE
from graphstipple_eval.method import Method
from graphstipple_eval.results import Result


@dataclass(frozen=True)
class Column:
    """A column of numbers.

    Parameters
    ----------
    key : str
        Name of the number in `Result.numbers`.
    title : str
        Its heading.
    digits : int
        Decimals that are shown.
    best : "low" or "high", optional
        Which value is the best; None for columns that do not judge, and for the tone error, in whose mean errors cancel.
    group : str
        Heading over several columns.
    """

    key: str
    title: str
    digits: int
    best: Literal["low", "high"] | None = None
    group: str = ""

    def text(self, value: float | None) -> str:
        """Return a value as it is printed: with thousands apart, a real minus sign, a dash for none."""
        if value is None:
            return "\N{EN DASH}"
        if math.isinf(value):
            return "\N{INFINITY}"
        return f"{value:,.{self.digits}f}".replace(",", "\N{NARROW NO-BREAK SPACE}").replace("-", "\N{MINUS SIGN}")

    @property
    def heading(self) -> str:
        """The title, with an arrow to the better side."""
        return self.title + {"low": "\N{NO-BREAK SPACE}↓", "high": "\N{NO-BREAK SPACE}↑", None: ""}[self.best]


NEAR, FAR, FARTHER = "near: as drawn", "far: blurred, 1.5 px", "farther: blurred, 3 px"
FLIP, TONE, DOTS = "FLIP, pixels a degree", "tone", "dots"

QUALITY = (
    Column("near_lpips_alex", "LPIPS Alex", 3, "low", NEAR),
    Column("near_lpips_vgg", "LPIPS VGG", 3, "low", NEAR),
    Column("near_psnr", "PSNR", 2, "high", NEAR),
    Column("near_ssim", "SSIM", 3, "high", NEAR),
    Column("near_msssim", "MS\N{NON-BREAKING HYPHEN}SSIM", 3, "high", NEAR),
    Column("far_lpips_alex", "LPIPS Alex", 3, "low", FAR),
    Column("far_psnr", "PSNR", 2, "high", FAR),
    Column("far_ssim", "SSIM", 3, "high", FAR),
    Column("far_msssim", "MS\N{NON-BREAKING HYPHEN}SSIM", 3, "high", FAR),
    Column("tone_error", "tone error", 4, None, "mean"),
)
"""Columns of Table 3 and Table 5."""

SEEN = (
    *(Column(f"flip_{pixels}", f"FLIP {pixels}", 3, "low", FLIP) for pixels in PIXELS_PER_DEGREE),
    Column("farther_psnr", "PSNR", 2, "high", FARTHER),
    Column("farther_ssim", "SSIM", 3, "high", FARTHER),
    Column("local_tone", "local tone", 3, "low", TONE),
    Column("evenness", "evenness", 3, None, DOTS),
    Column("evenness_deviation", "deviation", 3, None, DOTS),
)
"""What a viewer sees: differences at a distance, tone, and how evenly dots are spaced. Evenness does not judge: the dots of one
method are its whole picture, those of another stand between regions."""

COUNTS = (
    Column("stipples", "stipples", 0),
    Column("regions", "regions", 0),
    Column("vertices", "vertices", 0),
    Column("anchors", "anchors", 0),
    Column("coordinates", "coordinates", 0),
    Column("nodes", "nodes", 0),
    Column("small_regions", "small regions", 1),
    Column("boundary", "boundary", 2),
    Column("svg_bytes", "SVG bytes", 0),
    Column("seconds", "seconds", 2),
)
"""Columns of Table 4, and how far a drawing falls into labyrinths."""

_SWEEP_KEYS = {"near_lpips_alex", "near_lpips_vgg", "near_ssim", "far_lpips_alex", "far_psnr", "far_ssim"}
_SWEEP_KEYS |= {"farther_psnr", "flip_80", "flip_160", "local_tone", "tone_error", "evenness"}

SWEEP = tuple(column for column in QUALITY + SEEN if column.key in _SWEEP_KEYS) + tuple(
    Column(column.key, column.title, column.digits, column.best, "counts")
    for column in COUNTS
    if column.key in {"stipples", "regions", "coordinates", "small_regions", "boundary", "seconds"}
)
"""Columns of a sweep, and of what each idea brings."""


@dataclass(frozen=True)
class Row:
    """A row: what it is of, its values in the order of the columns, which of them are the best of their column, and a remark."""

    name: str
    title: str
    values: tuple[float | None, ...]
    best: tuple[bool, ...]
    remark: str = ""


@dataclass(frozen=True)
class Table:
    """Rows of numbers under columns."""

    columns: tuple[Column, ...]
    rows: tuple[Row, ...]

    def groups(self) -> list[tuple[str, int]]:
        """Return the headings over columns, each with how many columns it spans."""
        spans: list[tuple[str, int]] = []
        for column in self.columns:
            if spans and spans[-1][0] == column.group:
                spans[-1] = (column.group, spans[-1][1] + 1)
            else:
                spans.append((column.group, 1))
        return spans


def means(results: Iterable[Result], keys: Iterable[str]) -> dict[str, float | None]:
    """Return the mean of every number over the results that have it; None where none has it."""
    numbers = [result.numbers() for result in results]
    return {key: _mean([value for entry in numbers if (value := entry.get(key)) is not None]) for key in keys}


def _mean(values: Sequence[float]) -> float | None:
    return math.fsum(values) / len(values) if values else None


def table(methods: Sequence[Method], results: Sequence[Result], columns: tuple[Column, ...]) -> Table:
    """Return the means over photos, a row a method; methods without any result have no row.

    Parameters
    ----------
    methods : sequence of Method
        The rows.
    results : sequence of Result
        The results of all methods at one size.
    columns : tuple of Column
        The columns.
    """
    photos = len({result.photo for result in results})
    drawn = {method.name: [result for result in results if result.method == method.name] for method in methods}
    shown = [method for method in methods if drawn[method.name]]
    rows = {method.name: tuple(means(drawn[method.name], [c.key for c in columns]).values()) for method in shown}
    # A mean over fewer photos is not to be compared with the others.
    whole = [rows[method.name] for method in shown if len(drawn[method.name]) == photos]
    bests = [_best(column, [row[i] for row in whole]) for i, column in enumerate(columns)]
    return Table(
        columns,
        tuple(
            Row(
                method.name,
                method.title,
                rows[method.name],
                tuple(
                    len(drawn[method.name]) == photos and column.text(value) == best
                    for column, value, best in zip(columns, rows[method.name], bests, strict=True)
                ),
                "" if len(drawn[method.name]) == photos else f"{len(drawn[method.name])} of {photos} photos",
            )
            for method in shown
        ),
    )


def _best(column: Column, values: Sequence[float | None]) -> str | None:
    """Return the best value as it is printed, so that equal prints are equally good; None if there is nothing to choose."""
    known = [value for value in values if value is not None]
    if column.best is None or len(known) < 2:
        return None
    return column.text(min(known) if column.best == "low" else max(known))


def compared(methods: Sequence[Method]) -> list[Method]:
    """Return the methods of Table 3: all but the ablations."""
    return [method for method in methods if method.name not in {*ours.ABLATIONS, *ours.WITHOUT}]


def ablated(methods: Sequence[Method]) -> list[Method]:
    """Return the methods of Table 5 in the paper's order; none if no ablation was drawn."""
    by_name = {method.name: method for method in methods}
    if not by_name.keys() & set(ours.ABLATIONS):
        return []
    return [by_name[name] for name in quoted.ABLATIONS if name in by_name]


def ideas(methods: Sequence[Method]) -> list[Method]:
    """Return the methods of "what each idea brings": the default, without each of its ideas, the paper; none without such a one."""
    by_name = {method.name: method for method in methods}
    if not by_name.keys() & set(ours.WITHOUT):
        return []
    return [by_name[name] for name in (ours.DEFAULT, *ours.WITHOUT, ours.PAPER) if name in by_name]


class Figure(NamedTuple):
    """What is measured of a picture, to be compared with that of a reference."""

    title: str
    read: Callable[[Result], float]
    """NaN for a result that has no such number."""
    is_relative: bool = True
    """Whether a gain is a share of the reference's mean, else the difference from it."""
    digits: int = 3
    target: float | None = None
    """The gain that is wanted; None for figures that no score knows."""

    def text(self, value: float) -> str:
        """Return a value as it is printed."""
        return f"{value:.{self.digits}f}"

    def gain_text(self, gain: float) -> str:
        """Return a gain as it is printed."""
        return f"{100 * gain:+.1f} %" if self.is_relative else f"{gain:+.{self.digits}f}"


def by_method(results: Iterable[Result], figures: Sequence[Figure]) -> dict[str, npt.NDArray[np.float64]]:
    """Return the figures of every method by its name, (photos, figures) arrays, in the order of the results."""
    read: dict[str, list[list[float]]] = {}
    for result in results:
        read.setdefault(result.method, []).append([figure.read(result) for figure in figures])
    return {name: np.array(rows) for name, rows in read.items()}


def gains(figures: Sequence[Figure], own: npt.NDArray[np.float64], reference: npt.NDArray[np.float64]) -> npt.NDArray[np.float64]:
    """Return the gains over a reference in the means over photos: shares or differences, as the figures say.

    Parameters
    ----------
    figures : sequence of Figure
        What the columns are.
    own, reference : (photos, figures) array
        The figures of both. Where one has none of a photo, that photo does not count for that figure.

    Returns
    -------
    (figures,) array
        NaN where no photo counts.
    """
    counts = ~(np.isnan(own) | np.isnan(reference))
    photos = np.where(counts.any(axis=0), counts.sum(axis=0), np.nan)
    mean, base = (np.where(counts, values, 0).sum(axis=0) / photos for values in (own, reference))
    gained: npt.NDArray[np.float64] = (mean - base) / np.where([figure.is_relative for figure in figures], base, 1)
    return gained


def markdown(head: Sequence[str], rows: Iterable[Sequence[str]]) -> str:
    """Return a table in Markdown."""
    return "\n".join(f"| {' | '.join(cells)} |" for cells in (head, ["---"] * len(head), *rows))
