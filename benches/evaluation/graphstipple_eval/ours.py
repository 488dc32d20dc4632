"""graphstipple's own methods: its defaults without single ideas, the paper's settings and their ablations, sweeps over one option.

`graphstipple` is what `graphstipple.draw` makes by default. `paper` has the settings of the preset `paper` (a lattice of one node a
pixel, every midpoint kept) with the node budget of the default drawing, 0.3 a pixel and at most 300,000, so that both draw with the
same number of nodes. The ablations change one thing in `paper` and keep its node budget:

- constant importance: `importance="constant:1"`, which the budget's factor brings to the same number of nodes;
- no relaxation: `relax=0`;
- alpha = 1: `published.alpha=1` where the tone is diffused; the importance is diffused as before, so the nodes are the same.

The other way round, the defaults without one of their ideas have the options of that idea as in the preset `paper`, and all others,
the node budget among them, as in the defaults:

- detail in the importance: `detail`, `floor`, `midtones`;
- emphasis: `sharpen`, `local_contrast`;
- smooth parts stippled: `stippling`;
- tonal alpha: `published.alpha`;
- nodes labelled row by row: `published.importance_order` where they are chosen, `published.order` where they become black or white;
- error weighted by area: `published.error_weighting`;
- labels refined: `refine`;
- correction of the mean tone: `tone_tolerance`;
- fused dots split: `split`;
- crossings by tone: `published.crossings`;
- outlines of fewer points: `tolerance`;
- alpha = 1 for the importance: `published.importance_alpha`.

With a fixed budget of coordinates, each of these methods, and each value of a sweep, is drawn with other numbers of nodes until it
writes so many; sweeps over the number of nodes are not.
"""

from __future__ import annotations

import dataclasses
import json
import operator
from collections.abc import Callable
from dataclasses import dataclass
from functools import partial

import numpy as np

import graphstipple as gs
from graphstipple_eval import labyrinth
from graphstipple_eval.method import Counts, Method, Photo, Picture

DEFAULT = "graphstipple"
"""The method whose counts are the budget of the others."""

PAPER = "paper"

COORDINATES_TOLERANCE = 0.02
"""How far from a fixed budget the coordinates may end, as a share: below what the node budget itself meets, searches fail."""

MOST_DRAWS = 12
"""Drawings of a search: most need three or four; more are for small drawings, where the node budget's own 2 % stands in the way."""


def _default(photo: Photo) -> gs.Options:
    return gs.Options(threads=1)


def _paper(photo: Photo) -> gs.Options:
    nodes = max(3, round(min(0.3 * photo.tone.size, 300_000)))
    return gs.Options.preset("paper", nodes=nodes, threads=1)


@dataclass(frozen=True)
class _Variant:
    """One of our methods: a name, a title, where it comes from, options for a photo, the changes to them and the importance."""

    name: str
    title: str
    source: str
    options: Callable[[Photo], gs.Options]
    changes: dict[str, object] = dataclasses.field(default_factory=dict)
    importance: str = "saliency"


_PUBLISHED = gs.Options().published
"""Our parameters of the published method."""

_WITHOUT: tuple[tuple[str, str, dict[str, object]], ...] = (
    ("no-detail-importance", "no detail in the importance", {"detail": 0, "floor": 0, "midtones": 0}),
    ("no-emphasis", "no emphasis", {"sharpen": 0, "local_contrast": 0}),
    ("no-stippling", "smooth parts not stippled", {"stippling": 0}),
    ("no-tonal-alpha", "dynamic alpha", {"published": _PUBLISHED.replace(alpha="dynamic")}),
    ("global-importance-order", "nodes chosen by priority", {"published": _PUBLISHED.replace(importance_order="global")}),
    ("global-order", "nodes labelled by priority", {"published": _PUBLISHED.replace(order="global")}),
    ("no-area", "error weighted by value", {"published": _PUBLISHED.replace(error_weighting="value")}),
    ("unrefined", "labels as diffused", {"refine": 0}),
    ("no-tone-correction", "no tone correction", {"tone_tolerance": None}),
    ("fused-dots", "fused dots left", {"split": 0}),
    ("midpoint-crossings", "crossings at midpoints", {"published": _PUBLISHED.replace(crossings="midpoint")}),
    ("unsimplified", "every point of the outlines kept", {"tolerance": 0}),
    ("dynamic-importance-alpha", "dynamic alpha for the importance", {"published": _PUBLISHED.replace(importance_alpha="dynamic")}),
)
"""The defaults without one idea: a name, a title, and the paper's values of the options that make the idea."""

_VARIANTS = (
    _Variant(DEFAULT, "graphstipple, defaults", "graphstipple", _default),
    _Variant(PAPER, "graphstipple, paper's settings", "Graph-based Black and White Stylization, 2026", _paper),
    _Variant("paper-constant-importance", "paper, constant importance", "the paper's ablation", _paper, importance="constant:1"),
    _Variant("paper-no-relaxation", "paper, no relaxation", "the paper's ablation", _paper, {"relax": 0}),
    _Variant("paper-alpha-1", "paper, alpha = 1", "the paper's ablation", _paper, {"published": gs.Published(alpha=1.0)}),
    *(_Variant(name, f"defaults, {title}", "graphstipple", _default, changes) for name, title, changes in _WITHOUT),
)

SETS_NODES = ("nodes", "nodes_per_pixel")
"""Options that say how many nodes there are: a sweep over one of them cannot be brought to a budget."""

ABLATIONS = ("paper-constant-importance", "paper-no-relaxation", "paper-alpha-1")
"""Names of the ablations of `paper`, in the order of the paper's Table 5."""

WITHOUT = tuple(name for name, _, _ in _WITHOUT)
"""Names of the defaults without one idea."""


def methods(coordinates: int | None) -> tuple[Method, ...]:
    """Return our methods.

    Parameters
    ----------
    coordinates : int, optional
        Coordinates that every drawing is to write; by default the drawings are as their options make them.
    """
    return tuple(_method(variant, coordinates is not None) for variant in _VARIANTS)


def _method(variant: _Variant, is_budgeted: bool) -> Method:
    draw = partial(_draw_at_budget if is_budgeted else _draw, variant)
    return Method(variant.name, variant.title, variant.source, draw, is_budgeted)


@dataclass(frozen=True)
class Sweep:
    """Values of one option, the others at their defaults.

    Parameters
    ----------
    option : str
        A field of `graphstipple.Options`, or `published.NAME` for one of `graphstipple.Published`.
    values : tuple
        Its values, as they are stored there.
    """

    option: str
    values: tuple[object, ...]

    @classmethod
    def parse(cls, text: str) -> Sweep:
        """Read `OPTION=VALUE,VALUE`; a value is JSON, or else text.

        Raises
        ------
        InvalidInputError
            If it has no such form, or there is no such option or value.
        """
        option, equals, values = text.partition("=")
        if not equals or not all(values.split(",")):
            raise gs.InvalidInputError(f"the sweep {text!r} is no sweep: it must be OPTION=VALUE,VALUE, such as shading=0,0.5")
        names = [field.name for field in dataclasses.fields(gs.Options) if field.name != "published"]
        names += [f"published.{field.name}" for field in dataclasses.fields(gs.Published)]
        if option not in names:
            raise gs.InvalidInputError(f"there is no option {option!r} to sweep over: it must be one of {', '.join(names)}")
        read = operator.attrgetter(option)
        checked = tuple(read(gs.Options().replace(**_changes(option, _value(value)))) for value in values.split(","))
        if len(set(checked)) < len(checked):
            raise gs.InvalidInputError(f"the sweep {text!r} has a value twice")
        return cls(option, checked)

    def methods(self, coordinates: int | None) -> tuple[Method, ...]:
        """Return one method a value, named `OPTION=VALUE`.

        Parameters
        ----------
        coordinates : int, optional
            Coordinates that every drawing is to write, unless the option says how many nodes there are; by default the drawings
            are as their options make them.
        """
        is_budgeted = coordinates is not None and self.option not in SETS_NODES
        made = []
        for value in self.values:
            short = str(value).removesuffix(".0")
            name, title = f"{self.option}={short}", f"{self.option} = {short}"
            made.append(_method(_Variant(name, title, "graphstipple", _default, _changes(self.option, value)), is_budgeted))
        return tuple(made)


def _value(text: str) -> object:
    try:
        return json.loads(text)
    except json.JSONDecodeError:
        return text


def _changes(option: str, value: object) -> dict[str, object]:
    """Return the changes to the defaults that give an option, `published.NAME` among them, a value."""
    group, _, name = option.rpartition(".")
    return {group: _PUBLISHED.replace(**{name: value})} if group else {name: value}


def _draw(variant: _Variant, photo: Photo, dots: int) -> Picture:
    """Draw with the variant's own number of nodes."""
    options = variant.options(photo).replace(**variant.changes)
    return _picture(gs.draw(photo.pixels, variant.importance, options), variant, {})


def _draw_at_budget(variant: _Variant, photo: Photo, dots: int) -> Picture:
    """Draw with as many nodes as make the drawing write `dots` coordinates, or come nearest to it."""
    options = variant.options(photo).replace(**variant.changes)
    drawing = nearest = gs.draw(photo.pixels, variant.importance, options)
    tried = {int(drawing.stats["nodes"]): int(drawing.stats["coordinates"])}
    # Without a density, the lattice grows with the nodes, to somewhat more than this.
    most = 15 * photo.tone.size if options.published.density is None else int(drawing.stats["lattice_nodes"])
    while abs(nearest.stats["coordinates"] - dots) > COORDINATES_TOLERANCE * dots and len(tried) < MOST_DRAWS:
        nodes = min(_next_nodes(tried, dots), most)
        if nodes in tried:
            break
        drawing = gs.draw(photo.pixels, variant.importance, options.replace(nodes=nodes))
        tried[nodes] = drawing.stats["coordinates"]
        nearest = min(nearest, drawing, key=lambda drawing: abs(drawing.stats["coordinates"] - dots))
    search: dict[str, object] = {"draws": len(tried)}
    written = nearest.stats["coordinates"]
    if abs(written - dots) > COORDINATES_TOLERANCE * dots:
        search["note"] = f"{written} coordinates instead of {dots}: no number of nodes that was tried comes nearer"
    return _picture(nearest, variant, search)


def _next_nodes(tried: dict[int, int], wanted: int) -> int:
    """Return the number of nodes to try next: in proportion from the one that came nearest, or beside that.

    Coordinates grow about as nodes do, but in small drawings not evenly: where the guess is known already, a number beside it may
    do better.
    """
    nearest = min(tried, key=lambda nodes: abs(tried[nodes] - wanted))
    guess = max(3, round(nearest * wanted / max(1, tried[nearest])))
    step = max(1, guess // 100)
    beside = (guess + sign * count * step for count in range(1, MOST_DRAWS) for sign in (1, -1))
    return next((nodes for nodes in (guess, *beside) if nodes >= 3 and nodes not in tried), guess)


def _picture(drawing: gs.Drawing, variant: _Variant, search: dict[str, object]) -> Picture:
    stats = drawing.stats
    counts = Counts(**{name: stats[name] for name in ("stipples", "regions", "vertices", "anchors", "coordinates", "nodes")})
    assert isinstance(drawing.options, gs.Options)  # it comes from no file
    settings = {"importance": variant.importance, **dataclasses.asdict(drawing.options), **search}
    raster = drawing.rasterize().astype(np.float32) / np.float32(255)
    dots = np.stack([drawing.stipples[name] for name in ("x", "y", "ink")], axis=1)
    return Picture(raster, counts, drawing.svg(), settings, labyrinth.measures(drawing), dots)
