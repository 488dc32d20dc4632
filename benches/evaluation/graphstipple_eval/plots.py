"""Scatter plots of the methods' means, as SVG files in which every point is labelled."""

from __future__ import annotations

import io
import math
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import matplotlib as mpl
from matplotlib.axes import Axes
from matplotlib.axis import Axis
from matplotlib.backends.backend_svg import FigureCanvasSVG
from matplotlib.figure import Figure
from matplotlib.ticker import FuncFormatter, LogLocator, NullFormatter
from matplotlib.transforms import Bbox

STYLE: dict[Any, Any] = {
    "font.family": "DejaVu Sans",  # comes with matplotlib
    "font.size": 10,
    "axes.edgecolor": "#888888",
    "axes.labelcolor": "#222222",
    "xtick.color": "#555555",
    "ytick.color": "#555555",
    "axes.spines.top": False,
    "axes.spines.right": False,
    "axes.grid": True,
    "grid.color": "#e8e8e8",
    "svg.hashsalt": "graphstipple",  # the same identifiers in every run
}

OURS, OTHERS = "#c2410c", "#334155"
"""Colours of points: our own methods and the others."""

OFFSETS = [(6, 0, "left", "center"), (-6, 0, "right", "center"), (0, 6, "center", "bottom"), (0, -6, "center", "top")]
OFFSETS += [(sign * 8, up, side, "center") for up in (12, -12, 24, -24, 36, -36) for sign, side in ((1, "left"), (-1, "right"))]
"""Where a label may stand, from its point, in points: x, y, horizontal and vertical alignment; the first free place is taken."""


@dataclass(frozen=True)
class Point:
    """A labelled point."""

    label: str
    x: float
    y: float
    is_ours: bool


@dataclass(frozen=True)
class Quantity:
    """What an axis shows."""

    title: str
    is_logarithmic: bool = False


def scatter(points: Sequence[Point], x: Quantity, y: Quantity) -> str:
    """Return a scatter plot as an SVG document."""
    with mpl.rc_context(STYLE):
        figure = Figure(figsize=(6.4, 4.6), layout="constrained")
        FigureCanvasSVG(figure)
        axes = figure.add_subplot()
        axes.set_xlabel(x.title)
        axes.set_ylabel(y.title)
        axes.set_xscale("log" if x.is_logarithmic else "linear")
        axes.set_yscale("log" if y.is_logarithmic else "linear")
        axes.margins(0.14)
        axes.set_axisbelow(True)
        colours = [OURS if point.is_ours else OTHERS for point in points]
        axes.scatter([point.x for point in points], [point.y for point in points], c=colours, s=28, zorder=3)
        for part in (axes.xaxis, axes.yaxis):
            if part.get_scale() == "log":
                part.set_major_locator(LogLocator(subs=(1, 2, 5) if _decades(part) < 2.5 else (1,)))
                part.set_major_formatter(FuncFormatter(lambda value, _: f"{value:,g}".replace(",", "\N{NARROW NO-BREAK SPACE}")))
                part.set_minor_formatter(NullFormatter())
        figure.draw_without_rendering()
        _label(axes, points, colours)
        buffer = io.BytesIO()
        figure.savefig(buffer, format="svg", metadata={"Date": None})
    return buffer.getvalue().decode()


def _decades(axis: Axis) -> float:
    """Return how many powers of ten an axis spans."""
    low, high = axis.get_view_interval()
    return math.log10(high / low)


def _label(axes: Axes, points: Sequence[Point], colours: Sequence[str]) -> None:
    """Write the labels beside the points, none over another or over a point where there is room."""
    taken = []
    for point in points:
        x, y = axes.transData.transform((point.x, point.y))
        taken.append(Bbox.from_bounds(x - 4, y - 4, 8, 8))
    for point, colour in zip(points, colours, strict=True):
        for dx, dy, horizontal, vertical in OFFSETS:
            text = axes.annotate(
                point.label,
                (point.x, point.y),
                (dx, dy),
                textcoords="offset points",
                ha=horizontal,
                va=vertical,
                fontsize=8.5,
                color=colour,
            )
            box = text.get_window_extent()
            is_free = _within(axes, box) and not any(box.overlaps(other) for other in taken)
            if is_free or (dx, dy, horizontal, vertical) == OFFSETS[-1]:
                break
            text.remove()
        taken.append(box)
        if abs(dx) + abs(dy) > 6:  # it does not stand right beside its point
            line = {"arrowstyle": "-", "color": "#aaaaaa", "linewidth": 0.6, "shrinkA": 0, "shrinkB": 3}
            axes.annotate("", (point.x, point.y), (dx, dy), textcoords="offset points", arrowprops=line)


def _within(axes: Axes, box: Bbox) -> bool:
    frame = axes.get_window_extent()
    return bool(box.x0 >= frame.x0 and box.x1 <= frame.x1 and box.y0 >= frame.y0 and box.y1 <= frame.y1)
