"""The fields of options, made by `tools/generate.py` from `rust/core/src/options/declared.rs`: change them there."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any, Literal


@dataclass(frozen=True, kw_only=True)
class PublishedFields:
    """The parameters of the published method's graphs and diffusions, by default the paper's.

    Checked when made, by the Rust core; unchangeable afterwards (see `replace`).

    Parameters
    ----------
    lattice : {"hexagonal", "square"}
        First graph: six or four neighbours a node. Hexagonal, square.
    density : float, optional
        Lattice nodes per pixel. Given without a number of nodes, the importance decides how many are kept. Above 0 to 16
        nodes per pixel. None: as fine as the number of nodes needs.
    k1 : float
        How much errors avoid neighbours of another value. The weight of the difference of values between two nodes. 0 to
        1,000.
    k2 : float
        How much errors avoid neighbours far away. The weight of the distance between two nodes. 0 to 1,000 per pixel.
    base : float
        Dynamic alpha where there is no detail. 0 to 1.
    detail_gain : float
        How much dynamic alpha grows with detail: the paper's lambda. 0 to 1,000.
    hops : int
        Radius of the local mean that dynamic alpha measures detail against. 1 to 16 hops.
    importance_alpha : {"tonal", "dynamic"} or float
        Share of the error passed on while nodes are chosen. A number, tonal (see alpha) or dynamic (the paper's). Tonal,
        dynamic or 0 to 1.
    alpha : {"tonal", "dynamic"} or float
        Share of the error passed on while nodes turn black or white. Tonal (see shading), dynamic (the paper's), or a
        number from 0 (threshold) to 1 (halftone). Tonal, dynamic or 0 to 1.
    importance_order : {"rows", "global"}
        Order in which nodes are chosen. Row by row, or one order by priority over all nodes (the paper's). Rows, global.
    order : {"rows", "global"}
        Order in which nodes turn black or white. Without refinement, global (the paper's) keeps more of the photo's
        structure. Rows, global.
    error_weighting : {"area", "value"}
        How an error counts between cells of different areas. By area, or its bare value (the paper's). Area, value.
    crossings : {"tone", "midpoint"}
        Where contours cross edges between nodes. Where the tone passes middle grey, or at the midpoint (the paper's). Tone,
        midpoint.

    Raises
    ------
    InvalidInputError
        If a value has the wrong type or lies outside its range.
    """

    lattice: Literal["hexagonal", "square"] = "hexagonal"
    density: float | None = 1.0
    k1: float = 1.0
    k2: float = 0.1
    base: float = 0.5
    detail_gain: float = 6.0
    hops: int = 1
    importance_alpha: Literal["tonal", "dynamic"] | float = "dynamic"
    alpha: Literal["tonal", "dynamic"] | float = "dynamic"
    importance_order: Literal["rows", "global"] = "global"
    order: Literal["rows", "global"] = "global"
    error_weighting: Literal["area", "value"] = "value"
    crossings: Literal["tone", "midpoint"] = "midpoint"


OURS: dict[str, Any] = {
    "lattice": "hexagonal",
    "density": None,
    "k1": 1.0,
    "k2": 0.1,
    "base": 0.5,
    "detail_gain": 6.0,
    "hops": 1,
    "importance_alpha": 1.0,
    "alpha": "tonal",
    "importance_order": "rows",
    "order": "rows",
    "error_weighting": "area",
    "crossings": "tone",
}
"""The parameters of `Options` by default."""


@dataclass(frozen=True, kw_only=True)
class OptionFields:
    """Everything that shapes a drawing besides the photo and the importance.

    Checked when made, by the Rust core; unchangeable afterwards (see `replace`).

    Parameters
    ----------
    nodes : int, optional
        Nodes to keep, within 1 %: more make a finer drawing. 3 to 1,000,000,000 nodes. None: 0.3 a pixel, 1,080 to 300,000.
    fineness : float
        Factor on the default number of nodes: above 1 finer, below 1 bolder. Above 0 to 16.
    nodes_per_pixel : float, optional
        Nodes to keep for every pixel: another way to say nodes. Above 0 to 16 nodes per pixel. None: see nodes.
    detail : float
        Share of the photo's own detail in the importance. The rest is saliency, or 1 with a map of one's own. 0 to 1.
    floor : float
        The least importance: no part of the photo is left without nodes. It comes before midtones. 0 to 1.
    midtones : float
        By how much less important black and white are than middle grey. 0 to 1.
    relax : int
        Lloyd steps that even out the kept nodes. 0 to 100 steps.
    stippling : float
        How much of the photo is dots. Where it is smooth, single dots of changing size carry the tone on bare paper or
        solid ink, evenly spaced, and no shapes; 0 stipples nothing, 1 everything, and in between parts count as smooth that
        are rougher and rougher. 0 to 1.
    shading : float
        Error passed on in middle tones: more makes dots, less makes shapes. The alpha that is called tonal: none at black
        and white. 0 to 1.
    crispness : float
        Data weight: more makes crisper shapes. How much a node's own tone counts in the refinement of labels; less keeps
        the tone of small parts. 0 to 100.
    cohesion : float
        Smoothness weight: more makes larger shapes. How much the neighbours' labels count in the refinement; more makes
        smoother contours too. 0 to 100.
    sharpen : float
        Emphasis of details as fine as the nodes. 0 to 100.
    local_contrast : float
        Emphasis of details three times as coarse. 0 to 100.
    tone_tolerance : float, optional
        How far the mean may be from the photo's. Beyond that the refinement moves all labels towards it. 0 to 1. None: the
        mean is left as it comes.
    tolerance : float
        How far a contour may be simplified: more means fewer points. It is the distance from the contour through all
        crossings, of which 0 keeps every one. 0 to 2 pixels.
    wobble : float
        How far edges look drawn by hand. Contours waver, by up to a third of the gaps beside them, and dots are irregular.
        0 to 1.
    edge : {"smooth", "inked", "torn"}
        How edges that wobble look. Smooth ones waver, inked ones swell and thin as under a pen too, torn ones are rough and
        have corners. Smooth, inked, torn.
    refine : int
        Sweeps of the refinement of labels at most. With 0 they stay as they were diffused, whatever their mean. 0 to 100
        sweeps.
    split : int
        Dots that fused by chance, up to so many, are taken apart where there is room. Below 2 none are. 0 to 12 nodes.
    stipple_scale : float
        Area of a stipple relative to its node's cell. Above 0 to 4.
    stipple_min : float
        Least radius of a stipple where there is room for it. The room is the triangles around its node. 0 to 1,000 pixels.
    stipple_max : float, optional
        Largest radius of a stipple. It may not be below stipple_min. Above 0 to 1,000 pixels. None: as its cell asks for.
    irregularity : float
        How far stipples are from round. They look made by hand; above 0 they are paths and count as regions. 0 to 1.
    seed : int
        Which of the irregular shapes stipples and edges have. 0 to 2^53.
    white_point : {"auto"} or float, optional
        The photo's grey that becomes white. For scans and photos of paper; auto leaves half a percent of the pixels beyond
        it. Auto or 0.004 to 1. None: 1.
    black_point : {"auto"} or float, optional
        The photo's grey that becomes black. It lies below the white point; auto as there. Auto or 0 to 0.996. None: 0.
    linear : bool
        Takes the tone in linear light. White then reflects as much light as the photo's grey on a screen. True, False.
    gamma : float
        Above 1 lighter, below darker. The tone is raised to the power 1 / gamma. 0.1 to 10.
    contrast : float
        Contrast around middle grey. Distances from it are multiplied. 0 to 10.
    invert : bool
        Swaps black and white in the photo. True, False.
    backdrop : {"keep", "soften", "fade", "paper", "ink"}
        What becomes of all but the subject. Where a subject is given: keep leaves it as it is; soften has half the contrast
        and fewer nodes; fade has dots around the subject that grow smaller to nothing; paper is white, ink black. Keep,
        soften, fade, paper, ink.
    background : str
        What shows through transparent parts. Those of the photo, and of a map of one's own. White, black, #rrggbb, #rgb.
    inks : str, optional
        Inks, with commas between them. Up to 15, each a colour, with a name before it if it has one, as in
        "#1d1d1b,pink=#ff48b0". White, black, #rrggbb, #rgb. None: black.
    levels : int, optional
        Greys of even spacing. Black and white are among them. Another way to say inks. 2 to 16 greys. None: see inks.
    extract_inks : int, optional
        Inks of the photo's own. So many are taken from its colours. Another way to say inks. 1 to 15 inks. None: see inks.
    overprint : bool
        Lays inks over each other, up to six. What the light of each is to that of the paper is multiplied; without it every
        place has one ink or none. True, False.
    paper : str, optional
        Colour of the whole page. Inks mix with it, and white marks that are paper have it too. White, black, #rrggbb, #rgb.
        None: white.
    threads : int, optional
        Worker threads; the drawing does not depend on them. 1 to 1,024. None: one a core.
    published : Published
        The parameters of the published method's graphs and diffusions; by default ours.

    Raises
    ------
    InvalidInputError
        If a value has the wrong type or lies outside its range.
    """

    nodes: int | None = None
    fineness: float = 1.0
    nodes_per_pixel: float | None = None
    detail: float = 0.95
    floor: float = 0.15
    midtones: float = 0.8
    relax: int = 1
    stippling: float = 0.5
    shading: float = 0.15
    crispness: float = 1.9
    cohesion: float = 0.2
    sharpen: float = 2.5
    local_contrast: float = 1.5
    tone_tolerance: float | None = 0.014
    tolerance: float = 0.5
    wobble: float = 0.0
    edge: Literal["smooth", "inked", "torn"] = "smooth"
    refine: int = 12
    split: int = 4
    stipple_scale: float = 1.0
    stipple_min: float = 0.0
    stipple_max: float | None = None
    irregularity: float = 0.0
    seed: int = 0
    white_point: Literal["auto"] | float | None = None
    black_point: Literal["auto"] | float | None = None
    linear: bool = False
    gamma: float = 1.0
    contrast: float = 1.0
    invert: bool = False
    backdrop: Literal["keep", "soften", "fade", "paper", "ink"] = "fade"
    background: str = "white"
    inks: str | None = None
    levels: int | None = None
    extract_inks: int | None = None
    overprint: bool = False
    paper: str | None = None
    threads: int | None = None
