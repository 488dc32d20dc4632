"""The options of a drawing: the same names, defaults and ranges as in Rust, on the command line and in a drawing's metadata."""

from __future__ import annotations

import dataclasses
import json
import math
from dataclasses import dataclass
from typing import Any, Literal, NamedTuple

import numpy as np

from graphstipple import _core
from graphstipple._errors import InvalidInputError


@dataclass(frozen=True, kw_only=True)
class Options:
    """Everything that shapes a drawing besides the photo and the importance.

    Checked when made, by the Rust core; unchangeable afterwards (see `replace`).

    Parameters
    ----------
    lattice : {"hexagonal", "square"}
        The regular first graph.
    density : float, optional
        Lattice nodes per pixel, above 0, at most 16. By default as fine as the node budget needs, and no finer.
    nodes : int, optional
        Node budget: how many nodes to keep (within 1 %), at least 3. At most one of `nodes` and `nodes_per_pixel`; without
        either and without a density, 0.3 a pixel and at most 300,000.
    nodes_per_pixel : float, optional
        Node budget per pixel, above 0, at most 16.
    fineness : float
        Factor on the node budget of a drawing without `density`, `nodes` and `nodes_per_pixel`, above 0, at most 16: below 1 shapes
        are larger, above 1 finer.
    detail : float
        Share of the photo's own detail in the importance, against saliency (or, with a map of one's own, against 1), 0 to 1.
    floor : float
        The least importance, 0 to 1, before `midtones`: no part of the photo is left without nodes.
    midtones : float
        By how much less important black and white are than middle grey, 0 to 1.
    relax : int
        Lloyd steps between the two graphs, 0 to 100.
    k1, k2 : float
        Weights of the difference of values between two nodes and of their distance (per pixel), 0 to 1000.
    base : float
        Tonal alpha in middle tones, or dynamic alpha where there is no detail, 0 to 1.
    detail_gain : float
        The paper's lambda: how much dynamic alpha grows with detail, 0 to 1000.
    rings : int
        Radius of the local mean in rings of the graph, 1 to 16.
    importance_alpha, alpha : "tonal", "dynamic" or float
        Share of a node's error that is passed on, when the importance and when the tone is diffused: tonal (`base` in middle
        tones, none at black and white), dynamic (the paper's), or the same everywhere, 0 (thresholding) to 1 (halftoning).
    importance_order, order : {"rows", "global"}
        In which order nodes are labelled, when the importance and when the tone is diffused: row by row, or one order by priority
        over all nodes (the paper's). When the tone is, the latter keeps more of the photo's structure where `refine` is 0.
    carry : {"area", "value"}
        What is passed on when the tone is diffused: the error times the area of the node's cell, or the error's value.
    refine : int
        Sweeps that refine the labels, at most, 0 to 100; 0 leaves them as the diffusion gave them, whatever their mean.
    crispness : float
        Weight of a node's own tone in the refinement, 0 to 100: more makes crisper shapes, less keeps the tone of small parts.
    cohesion : float
        Weight of the neighbours' labels in the refinement, 0 to 100: more makes larger shapes with smoother boundaries.
    tone_tolerance : float, optional
        How far the drawing's mean may be from the tone's before the refinement moves it there, 0 to 1; None leaves it as it comes.
    split : int
        Dots that fused by chance, up to this many nodes together, are taken apart where there is room, 0 to 12; below 2 none are.
    crossings : {"tone", "midpoint"}
        Where boundaries cross the edges between nodes: where the tone passes middle grey, or in the middle.
    sharpen, local_contrast : float
        Emphasis of details as fine as the nodes, and three times as coarse, before the diffusion, 0 to 100.
    stipple_scale : float
        A stipple's area relative to its node's cell, above 0, at most 4.
    stipple_min : float
        Least radius of a stipple where the triangles around its node have room for it, in pixels, 0 to 1000.
    stipple_max : float, optional
        Largest radius of a stipple, in pixels, above 0, at most 1000, not below `stipple_min`; by default as large as its cell
        asks for.
    irregularity : float
        How far stipples are from round, 0 to 1. Above 0 they look made by hand: they are closed curves and count as regions.
    seed : int
        Which of the irregular shapes stipples have, 0 to 2^53.
    tolerance : float
        How far a region's outline may lie from the one through all crossings when it is drawn with fewer points, in pixels,
        0 to 2; 0 keeps every crossing.
    linear : bool
        Take the tone in linear light: the share of white that is drawn then reflects as much light as the photo's grey on a
        screen.
    gamma : float
        The tone is raised to the power 1 / gamma (above 1 brightens), 0.1 to 10.
    contrast : float
        Factor on the tone's distance from middle grey, 0 to 10.
    invert : bool
        Swap black and white in the tone.
    threads : int, optional
        Worker threads, 1 to 1024; by default one a core. The drawing does not depend on it.
    background : str
        What lies under transparent pixels of the image: "white", "black", "#rrggbb" or "#rgb".

    Raises
    ------
    InvalidInputError
        If a value has the wrong type or lies outside its range.
    """

    lattice: Literal["hexagonal", "square"] = "hexagonal"
    density: float | None = None
    nodes: int | None = None
    nodes_per_pixel: float | None = None
    fineness: float = 1.0
    detail: float = 0.95
    floor: float = 0.07
    midtones: float = 0.8
    relax: int = 1
    k1: float = 1.0
    k2: float = 0.1
    base: float = 0.15
    detail_gain: float = 6.0
    rings: int = 1
    importance_alpha: Literal["tonal", "dynamic"] | float = 1.0
    alpha: Literal["tonal", "dynamic"] | float = "tonal"
    importance_order: Literal["rows", "global"] = "rows"
    order: Literal["rows", "global"] = "rows"
    carry: Literal["area", "value"] = "area"
    refine: int = 12
    crispness: float = 1.9
    cohesion: float = 0.2
    tone_tolerance: float | None = 0.014
    split: int = 4
    crossings: Literal["tone", "midpoint"] = "tone"
    sharpen: float = 2.5
    local_contrast: float = 1.5
    stipple_scale: float = 1.0
    stipple_min: float = 0.0
    stipple_max: float | None = None
    irregularity: float = 0.0
    seed: int = 0
    tolerance: float = 0.5
    linear: bool = False
    gamma: float = 1.0
    contrast: float = 1.0
    invert: bool = False
    threads: int | None = None
    background: str = "white"

    def __post_init__(self) -> None:
        for field in dataclasses.fields(self):
            value = getattr(self, field.name)
            if isinstance(value, np.generic):
                object.__setattr__(self, field.name, value.item())
            if isinstance(value, (float, np.floating)) and not math.isfinite(value):
                raise InvalidInputError(f"{field.name} is {value}, but it must be a finite number")
        # What Rust makes of the values is stored, so that density=1 and density=1.0 are equal options.
        for name, value in json.loads(_core.validated_options(self._json())).items():
            object.__setattr__(self, name, value)

    @classmethod
    def paper(cls, **changes: Any) -> Options:
        """Return the paper's settings, with single ones changed by keyword.

        Density 1, no node budget, none of what we add to the method, tolerance 0.

        Parameters
        ----------
        **changes
            Options that differ from the paper's.

        Returns
        -------
        Options
        """
        return cls.preset("paper", **changes)

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
        return cls(**{**json.loads(_core.preset_options(name)), **changes})

    def replace(self, **changes: Any) -> Options:
        """Return the same options with single ones changed by keyword.

        Parameters
        ----------
        **changes
            Options to change.

        Returns
        -------
        Options
        """
        return dataclasses.replace(self, **changes)

    def _json(self) -> str:
        """Return the options as JSON, the form in which the core takes them."""
        try:
            return json.dumps(dataclasses.asdict(self), allow_nan=False)
        except TypeError as error:
            raise InvalidInputError(f"an option has a type that no option has: {error}") from None


class Preset(NamedTuple):
    """A named set of options: ``Options.preset(name)``."""

    name: str
    description: str
    """What it gives, in a few words."""
    inks: Literal["black", "white", "both"]
    """What a flat vector file is best written with: the `inks` of `Drawing.save`. The command line does so by itself."""


def presets() -> list[Preset]:
    """Return all presets, the default first.

    Returns
    -------
    list of Preset
    """
    return [Preset(name, description, inks) for name, description, inks in _core.presets()]
