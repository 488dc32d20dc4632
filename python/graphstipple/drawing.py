"""The drawing: pictures and files of it, its marks as data, what the stages made on the way to it, and reading it again."""

from __future__ import annotations

import os
import warnings
from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from functools import cached_property
from typing import TYPE_CHECKING, Any, Literal, NamedTuple, TypeAlias, overload

import numpy as np
import numpy.typing as npt

from graphstipple import _core
from graphstipple._errors import GraphStippleError, GraphStippleWarning, InvalidInputError, MissingPackageError
from graphstipple._inputs import checked_width, path_to_read, path_to_write, plain
from graphstipple.options import Options
from graphstipple.plots import HEAVY_SVG_BYTES, Fill, PenDots, PenOrder, Plot
from graphstipple.rules import Changes, Report, Rules, checked_rules

if TYPE_CHECKING:
    import shapely

Length: TypeAlias = "float | str"
"""Pixels (1/96 inch each on paper), or text with a unit: "200mm", "20cm", "8in", "600pt", "800px"."""

Style: TypeAlias = Literal["flat", "layered"]
Curves: TypeAlias = Literal["polylines", "splines"]
"""How a vector file expresses the picture."""

Elements: TypeAlias = Literal["layers", "marks"]
"""What the elements of an SVG are."""

Dots: TypeAlias = Literal["circles", "strokes"]
"""What the dots of an SVG are."""

NOTEBOOK_WIDTH = 1600
"""Widest PNG shown in a notebook, in pixels: wider than any notebook's column."""

_WITHOUT = "this drawing was loaded from a file or a pickle, which hold no {}: draw the photo again to get it"
"""What is said where a drawing is asked for what its stages made, and has it no more."""

STIPPLE_DTYPE = np.dtype([("x", np.float64), ("y", np.float64), ("radius", np.float64), ("ink", np.uint8)])
"""Fields of `Drawing.stipples`."""


class Graph(NamedTuple):
    """The second graph of a drawing, node by node."""

    sites: npt.NDArray[np.float64]
    """Position of every node, (n, 2) as x, y in pixels."""
    edges: npt.NDArray[np.uint32]
    """Every edge once, (m, 2), lower node first."""
    tone: npt.NDArray[np.float32]
    """Tone of every node, (n,) in [0, 1]."""
    labels: npt.NDArray[np.uint8]
    """Label of every node, (n,): 0 black, 1 white; of other inks as `Region.ink`."""
    components: npt.NDArray[np.uint32]
    """Component of every node, (n,)."""


@dataclass(frozen=True, eq=False)
class Region:
    """A region of the flat picture: one exterior and its holes, curves flattened to within 0.05 px, or less where nodes are close.

    Parameters
    ----------
    exterior : ndarray of float64, (n, 2)
        Outer boundary as x, y in pixels; the first point is not repeated.
    holes : list of ndarray of float64, (m, 2)
        Inner boundaries.
    area : float
        Area in px^2, without the holes.
    ink : int
        Its label: 0 black, 1 white. Of other inks their number in `Drawing.inks`, the paper comes last; with `overprint` the
        number that the missing inks make, where ink k counts 2^k.
    """

    exterior: npt.NDArray[np.float64]
    holes: list[npt.NDArray[np.float64]]
    area: float
    ink: int


class _Regions(Sequence[Region]):
    """The regions of a drawing, each built when it is asked for."""

    def __init__(self, core: _core.Drawing) -> None:
        self._core = core

    def __len__(self) -> int:
        return self._core.region_count

    @overload
    def __getitem__(self, index: int) -> Region: ...
    @overload
    def __getitem__(self, index: slice) -> list[Region]: ...
    def __getitem__(self, index: int | slice) -> Region | list[Region]:
        if isinstance(index, slice):
            return [self[i] for i in range(*index.indices(len(self)))]
        # A range checks the index and counts from the end where it is negative.
        return Region(*self._core.region(range(len(self))[index]))

    def __repr__(self) -> str:
        return f"<{len(self)} regions>"


class RecordedOptions(Mapping[str, Any]):
    """The options of a drawing that another version of graphstipple made, as they stand in its file: names and plain values.

    `draw` takes them as it takes `Options`, and says what it does not know of them.
    """

    def __init__(self, values: dict[str, Any], unknown: str) -> None:
        self._values = values
        self._unknown = unknown

    def __getitem__(self, name: str) -> Any:
        return self._values[name]

    def __iter__(self) -> Iterator[str]:
        return iter(self._values)

    def __len__(self) -> int:
        return len(self._values)

    def __repr__(self) -> str:
        return f"RecordedOptions({self._values!r})"


def known(options: Options | RecordedOptions | None) -> Options:
    """Return the options to work with, by default the default ones.

    Raises
    ------
    InvalidInputError
        If they are of another type, or those of a file of which this version does not know one.
    """
    if options is None:
        return Options()
    if isinstance(options, RecordedOptions):
        raise InvalidInputError(options._unknown)
    if not isinstance(options, Options):
        raise InvalidInputError(f"options is of type {type(options).__name__}, but it must be graphstipple.Options")
    return options


class Drawing:
    """A drawing of stipples and regions, as `draw` and `load` return it.

    It never changes, so a copy of it is the drawing itself. It can be pickled, for process pools and Dask: what a pickle holds is
    what a JSON file of it does, and its `stats`; not the graph and the importance.
    """

    def __init__(
        self,
        core: _core.Drawing,
        options: Options | RecordedOptions,
        seconds: dict[str, float],
        decoder: str | None = None,
    ) -> None:
        self._core = core
        self._options = options
        self._seconds = seconds
        self._decoder = decoder

    @property
    def width(self) -> int:
        """Width of the canvas in pixels: the image's."""
        return self._core.width

    @property
    def height(self) -> int:
        """Height of the canvas in pixels: the image's."""
        return self._core.height

    @property
    def options(self) -> Options | RecordedOptions:
        """The options that it was made with; those of a file that this version does not all know, as they stand there."""
        return self._options

    @property
    def version(self) -> str:
        """The version of graphstipple that made it."""
        version: str = self._core.provenance()["version"]
        return version

    def save(
        self,
        path: str | os.PathLike[str],
        width: Length | None = None,
        *,
        margin: Length | None = None,
        page: str | None = None,
        dpi: float | None = None,
        style: Style = "flat",
        only: str | Sequence[str] | None = None,
        paper: str | None = None,
        elements: Elements = "layers",
        dots: Dots = "circles",
        curves: Curves = "polylines",
        one_bit: bool = False,
        trap: Length | None = None,
        registration_marks: bool = False,
        force: bool = False,
    ) -> None:
        """Write the drawing to a file, whole or not at all, in the format that its suffix stands for (docs/options.md lists them).

        With "{ink}" in its name there is a file for each ink that is drawn, with that ink alone and no paper: "plates/{ink}.pdf"
        are plates/black.pdf, plates/pink.pdf and so on, all of one size, so that they register. All of them are written or none.

        A new file takes the place of one that is there, with its permissions, and its owner where the system allows; other hard
        links go on to show the old one. A symbolic link stays one; what it leads to is replaced. Devices and pipes are written to.

        Lengths are numbers of pixels or text with a unit (mm, cm, in, pt, px); on paper, a pixel is 1/96 inch. JSON has no size.

        Parameters
        ----------
        path : str or path
            Where to; an existing file is replaced, unless it is read-only. "{ink}" in the file's name stands for each ink.
        width : float or str, optional
            Width of the drawing, without margins; the height follows. By default as large as the page allows, without a page one
            pixel for a pixel of the canvas. For a PNG, a number is the width in pixels.
        margin : float or str, optional
            Paper on all four sides of the drawing; on a page, the least of it.
        page : str, optional
            "A3", "A4", "A5", "A6", "letter", "legal", "tabloid", turned to the drawing's format, or width x height such as
            "300x200mm". The drawing is centred on it. By default the page is the drawing with its margins.
        dpi : float, optional
            Pixels per inch of a PNG, 1 to 10000, by default 300 where a width or page is given in other units than pixels;
            written into the file.
        style : {"flat", "layered"}
            How vector formats express the picture: as disjoint areas with holes, or as white over black over white.
        only : str or sequence of str, optional
            The inks that a flat vector file is written with, by their names: "black", "white" on black paper, or "black,white" in
            layers of their own over an underlay of black, so that nothing shines through where they meet; of a drawing of several
            inks any of `inks`, and "paper" for what they leave. By default all inks and not the paper.
        paper : str, optional
            Colour of the whole page, margins included: "white", "black", "#rrggbb" or "#rgb". White marks that are paper have it
            too: all of a layered drawing, and those of a PNG. By default, or with "none", what is not drawn is transparent, in a
            PNG white; what a layered drawing and white ink need under them is painted on the canvas.
        elements : {"layers", "marks"}
            What the elements of an SVG are: one path a layer, or one element a mark, a circle for a dot and a path with its holes
            for a region, which drawing programs pick one by one. Their ids have the numbers of `stipples` and `regions`:
            "white-stipple-7" is `stipples[7]`, "black-region-12" is `regions[12]`.
        dots : {"circles", "strokes"}
            What the dots of an SVG are: circles, or short strokes with round caps, which take a fifth of the bytes. Radii are
            rounded for that, by less than 1.6 per cent, without loss of ink; a file has the rounded ones, and so has what `load`
            makes of it.
        curves : {"polylines", "splines"}
            What the curves of a DXF are: polylines within 0.05 px of them, or splines that are exactly they.
        one_bit : bool
            Whether a PNG holds black and white alone, one bit a pixel; of several inks, a file for each or with one alone, whose
            film it is.
        trap : float or str, optional
            How far the lighter of two inks spreads under the darker one beside it, above 0 and at most "5mm", so that no paper
            shows between them where plates are printed a little apart. By default not at all. It is for solid drawings of
            several inks.
        registration_marks : bool
            Whether there are registration marks around the drawing, at the same place on all plates; margins are then 10 mm or
            more.
        force : bool
            Whether a file that is read-only is replaced, too.

        Raises
        ------
        InvalidInputError
            If the suffix is not known, a value breaks its rule, the drawing does not fit on the page, `dpi` or `one_bit` is
            given for a format without pixels, the paper has the colour of the ink, strokes shall be elements for every mark,
            or `trap` is given for a drawing of one ink, of inks over each other, or in layers.
        ImageFileError
            If the file cannot be written, or is read-only; `ImageFileNotFoundError` if its folder does not exist.

        Warns
        -----
        GraphStippleWarning
            If a vector file has a boundary of so many points that programs leave it out.
        """
        settings = _given(width=width, margin=margin, page=page, dpi=dpi, paper=paper, trap=trap, only=_names(only))
        settings |= _plain(style=style, elements=elements, dots=dots, curves=curves, one_bit=one_bit)
        settings |= _plain(registration_marks=registration_marks)
        warning = self._core.save(path_to_write(path), settings, bool(force))
        if warning:
            warnings.warn(warning, GraphStippleWarning, stacklevel=2)

    def svg(
        self,
        *,
        width: Length | None = None,
        margin: Length | None = None,
        page: str | None = None,
        style: Style = "flat",
        only: str | Sequence[str] | None = None,
        paper: str | None = None,
        elements: Elements = "layers",
        dots: Dots = "circles",
        trap: Length | None = None,
        registration_marks: bool = False,
    ) -> str:
        """Return the drawing as an SVG document, the same that `save` writes with these parameters."""
        settings = _given(width=width, margin=margin, page=page, paper=paper, trap=trap, only=_names(only))
        settings |= _plain(style=style, elements=elements, dots=dots, registration_marks=registration_marks)
        return self._core.encode("svg", settings).decode()

    def json(self) -> str:
        """Return the drawing as a JSON document, the same that `save` writes: canvas, stipples, regions, curves, options."""
        return self._core.encode("json", {}).decode()

    def with_min_dot(
        self, length: Length, *, width: Length | None = None, margin: Length | None = None, page: str | None = None
    ) -> Drawing:
        """Return the drawing without dots that a pen, a drill or a screen cannot make.

        Smaller dots are enlarged, but only as far as they touch nothing; where that is not far enough they are dropped and
        what surrounds them fills their place. How many is in the new drawing's `stats`: `dots_enlarged` and `dots_dropped`.
        Irregular dots are regions and stay as they are.

        Parameters
        ----------
        length : float or str
            Least radius of a dot on paper, such as "0.3mm". A number is pixels: those of the canvas when no size is given.
        width, margin, page
            The size that the drawing will be saved at, as for `save`.

        Returns
        -------
        Drawing

        Raises
        ------
        InvalidInputError
            As `save`.
        """
        core = self._core.with_min_dot(_plain(length=length)["length"], _given(width=width, margin=margin, page=page))
        return Drawing(core, self._options, self._seconds, self._decoder)

    def plot(
        self,
        pen: Length,
        width: Length | None = None,
        *,
        margin: Length | None = None,
        page: str | None = None,
        fill: Fill = "contour",
        dots: PenDots = "press",
        order: PenOrder = "short",
        overlap: float = 0.1,
        bleed: Length = 0,
        angle: float = 45,
        refill: Length | None = None,
        only: str | Sequence[str] | None = None,
        paper: str | None = None,
    ) -> Plot:
        """Return the drawing as paths for a pen, in the order in which they are drawn, instead of outlines of areas.

        Lengths are as for `save`; sizes of pens and dots are diameters.

        Parameters
        ----------
        pen : float or str
            Width of the pen, such as "0.3mm", at least 0.01 mm.
        width, margin, page
            The size on paper, as for `save`.
        fill : {"contour", "hatch", "outline", "none"}
            How areas are filled: by lines along their outlines, one inside the other and joined where they nest; by their rims and
            parallel lines; not, only their rims are drawn; or not at all, dots alone are drawn. What is narrower than the pen is
            one line along its middle, which `Plot.stats` counts as `thin`.
        dots : {"press", "circle"}
            How dots are drawn: by one press of the pen where they are at most 1.15 pens wide, larger ones filled; or all larger
            ones by their rims.
        order : {"short", "none"}
            In which order: with short ways of the lifted pen, or regions and then dots from the top down.
        overlap : float
            How much of a line in an area the next one covers, as a part of the pen's width, -9 to 0.9; below 0 paper shows between.
        bleed : float or str
            How far lines reach beyond the edges of areas, at most half the pen.
        angle : float
            Angle of hatching in degrees, counter-clockwise from level lines.
        refill : float or str, optional
            Pause to fill the pen again after so much line, such as "50m".
        only : str or sequence of str, optional
            The inks that are drawn, as for `save`, with a pen each.
        paper : str, optional
            Colour of the page, as for `save`, for how an SVG is shown.

        Returns
        -------
        Plot

        Raises
        ------
        InvalidInputError
            If a value breaks its rule, the pen is wider than the drawing, or the drawing does not fit on its page.
        """
        settings = _given(width=width, margin=margin, page=page, paper=paper, only=_names(only))
        pens = _plain(pen=pen, fill=fill, dots=dots, order=order, overlap=overlap, bleed=bleed, angle=angle)
        return Plot(_core.plot(self._core, pens | _given(refill=refill), settings))

    def check(self, rules: Rules, *, width: Length | None = None, margin: Length | None = None, page: str | None = None) -> Report:
        """Return what of the drawing breaks rules at its size on paper: what is too narrow or too small, and what falls out.

        Parameters
        ----------
        rules : Rules
            What can be made.
        width, margin, page
            The size on paper, as for `save`: a width or a page is needed.

        Returns
        -------
        Report

        Raises
        ------
        InvalidInputError
            If there is no size, or the drawing does not fit on its page.
        """
        return Report(_core.check(self._core, checked_rules(rules), _given(width=width, margin=margin, page=page)), rules)

    def enforce(
        self, rules: Rules, *, width: Length | None = None, margin: Length | None = None, page: str | None = None
    ) -> tuple[Drawing, Changes]:
        """Return the drawing as rules allow it at its size on paper, and what was done to it.

        What is too narrow goes or becomes wide enough, what is too small goes, and dots that are too small come together in fewer
        large ones, so that the tone stays. Islands get bridges if the rules say so: such as the drawing itself might have had, by
        turning nodes of its graph white, or straight ones if the drawing was loaded from a file or changed already.

        Parameters
        ----------
        rules : Rules
            What can be made.
        width, margin, page
            The size that the drawing will be saved at, as for `save`: a width or a page is needed.

        Returns
        -------
        Drawing
            It keeps the rules: what little might be left in the end is told by `check`.
        Changes

        Raises
        ------
        InvalidInputError
            If there is no size, the drawing does not fit on its page, or the rules leave nothing: then which width would do.
        """
        settings = _given(width=width, margin=margin, page=page)
        core, changes = _core.enforce(self._core, checked_rules(rules), settings)
        return Drawing(core, self._options, self._seconds, self._decoder), Changes(**changes)

    def rasterize(
        self, width: int | None = None, *, part: tuple[float, float, float, float] | None = None
    ) -> npt.NDArray[np.uint8]:
        """Return the drawing, or a part of it, as antialiased grey pixels.

        Parameters
        ----------
        width : int, optional
            Width in pixels, the height follows; by default a pixel for one of the canvas.
        part : tuple of float, optional
            Left, top, right and bottom of what is painted, in pixels of the canvas: a look at single dots takes milliseconds
            whatever the scale. By default the whole canvas.

        Returns
        -------
        ndarray of uint8, (height, width)
            0 black, 255 white.

        Raises
        ------
        InvalidInputError
            If the width is out of range, or the part is not on the canvas.
        """
        return self._core.rasterize(checked_width(width), None if part is None else _checked_part(part))

    @cached_property
    def stipples(self) -> npt.NDArray[np.void]:
        """The dots: a structured array (n,) with the fields x, y, radius (in pixels) and ink, which is a label as of regions."""
        return stipple_array(*self._core.stipples())

    @property
    def regions(self) -> Sequence[Region]:
        """The regions of the flat picture, each built when it is asked for."""
        return _Regions(self._core)

    def to_shapely(self, ink: str | None = None) -> shapely.MultiPolygon:
        """Return all areas of an ink as one shapely geometry, for plotters, maps and measurements.

        Its polygons are the regions of that ink with their holes, in the order of `regions`, then the stipples, in the order of
        `stipples`, as polygons: curves are flattened as for `regions` and neighbours share their points. So the polygons of all
        inks and the paper are disjoint and their areas add up to the canvas. Coordinates are pixels of the canvas, y running down.
        Of inks laid over each other, those of an ink are its plate's.

        Parameters
        ----------
        ink : str, optional
            The name of an ink, or of the paper: "white" in black and white, else "paper". By default the first ink, black.

        Returns
        -------
        shapely.MultiPolygon

        Raises
        ------
        MissingPackageError
            If shapely is not installed.
        InvalidInputError
            If there is no such ink.
        """
        number = 0 if ink is None else self._number_of(ink)
        try:
            import shapely  # noqa: PLC0415  # only this method needs it
        except ImportError as error:
            raise MissingPackageError(f"to_shapely needs the package shapely ({error}): pip install shapely") from error
        core, label = (self._core.plate(number), 0) if self.overprint else (self._core, number)
        points, ring_of_point, area_of_ring = core.polygons(label)
        rings = shapely.linearrings(points, indices=ring_of_point)
        return shapely.multipolygons(shapely.polygons(rings, indices=area_of_ring))

    @property
    def inks(self) -> dict[str, str]:
        """The inks by name, with their colours as "#rrggbb": of black and white, black alone."""
        inks, _, _ = self._core.palette
        return {name: _hex(rgb) for name, rgb in inks}

    @property
    def paper(self) -> tuple[str, str]:
        """What no ink covers: its name, "white" in black and white, else "paper"; and its colour as "#rrggbb"."""
        _, (name, rgb), _ = self._core.palette
        return name, _hex(rgb)

    @property
    def overprint(self) -> bool:
        """Whether inks lie over each other."""
        return self._core.palette[2]

    def plate(self, ink: str) -> Drawing:
        """Return what one ink covers, as a drawing of that ink alone: for cutters, rules, or a file for each ink.

        Parameters
        ----------
        ink : str
            The name of one of `inks`, or "paper".

        Raises
        ------
        InvalidInputError
            If there is no such ink.
        """
        return Drawing(self._core.plate(self._number_of(ink)), self._options, self._seconds, self._decoder)

    def _number_of(self, ink: str) -> int:
        """Return the number of an ink, or the one behind the last for the paper."""
        names = [*self.inks, self.paper[0]]
        if ink not in names:
            allowed = ", ".join(f'"{name}"' for name in names[:-1]) + f' or "{names[-1]}"'
            raise InvalidInputError(f"ink is {ink!r}, but it must be {allowed}")
        return names.index(ink)

    @cached_property
    def stats(self) -> dict[str, Any]:
        """What was counted (stipples, regions, nodes, vertices, anchors, coordinates, ...), and the seconds that every stage took.

        `decoder` is what decoded the photo's file: "graphstipple", or Pillow and its version; None where there was no file. A
        drawing that was loaded has the counts that it tells itself, and no seconds. Where bytes or points were limited, `within`
        has what it took and came to: trials, bytes (None unless they were limited), points, nodes, tolerance.
        """
        stats = self._core.stats()
        if "seconds" in stats:
            stats["decoder"] = self._decoder
            seconds = stats["seconds"]
            for stage, spent in self._seconds.items():
                seconds[stage] = seconds.get(stage, 0.0) + spent
            seconds["total"] = seconds.get("total", 0.0) + sum(self._seconds.values())
        return stats

    @cached_property
    def graph(self) -> Graph:
        """The second graph: sites, edges, tone, labels and components of its nodes. A drawing that was loaded has none."""
        graph = self._core.graph()
        if graph is None:
            raise GraphStippleError(_WITHOUT.format("graph"))
        return Graph(*graph)

    @cached_property
    def importance(self) -> npt.NDArray[np.float32]:
        """The importance on the canvas, (height, width) in [0, 1], before the node budget's factor. A loaded drawing has none.

        Of a photo that was reduced, each value fills the box of pixels that it stands for.
        """
        importance = self._core.importance()
        if importance is None:
            raise GraphStippleError(_WITHOUT.format("importance"))
        return importance

    def __copy__(self) -> Drawing:
        return self

    def __deepcopy__(self, memo: object) -> Drawing:
        return self

    def __reduce__(self) -> tuple[Callable[..., Drawing], tuple[object, ...]]:
        return _unpacked, (self._core.packed(), self._seconds, self._decoder)

    def __repr__(self) -> str:
        counts = f"{self._core.stipple_count} stipples, {self._core.region_count} regions"
        return f"<graphstipple.Drawing {self.width} x {self.height}: {counts}>"

    @cached_property
    def _light_svg(self) -> str | None:
        """The SVG, unless it is heavy. Layered, because that brings its own paper: black ink alone is lost on a dark page."""
        svg = self.svg(style="layered")
        return svg if len(svg) <= HEAVY_SVG_BYTES else None

    def _repr_svg_(self) -> str | None:
        return self._light_svg

    def _repr_png_(self) -> bytes | None:
        return self._core.encode("png", {"width": min(self.width, NOTEBOOK_WIDTH)}) if self._light_svg is None else None


def load(path: str | os.PathLike[str]) -> Drawing:
    """Read a drawing again from a .json, .svg or .svgz file that graphstipple wrote.

    It is the same drawing: regions, stipples, options and version, and so every file of it. What the file does not hold is the
    graph and the importance. Of an SVG with `dots="strokes"` it is the drawing with the rounded radii. An SVG that another program
    has changed is read if all that it draws can be a drawing, and refused otherwise.

    Parameters
    ----------
    path : str or path
        The file.

    Returns
    -------
    Drawing

    Raises
    ------
    InvalidInputError
        If the suffix is none of these.
    ImageFileError
        If the file cannot be read or holds no drawing of graphstipple; `ImageFileNotFoundError` if there is none.
    """
    return _with_its_options(_core.load(path_to_read(path)), {}, None)


def _unpacked(packed: tuple[bytes, str, list[str]], seconds: dict[str, float], decoder: str | None) -> Drawing:
    """Return the drawing that was pickled."""
    return _with_its_options(_core.unpacked(*packed), seconds, decoder)


def _with_its_options(core: _core.Drawing, seconds: dict[str, float], decoder: str | None) -> Drawing:
    """Return a drawing that was read, with the options that it tells itself."""
    options: Options | RecordedOptions
    try:
        options = Options._of(core.options())
    except InvalidInputError as error:
        options = RecordedOptions(core.provenance()["options"], str(error))
    return Drawing(core, options, seconds, decoder)


def stipple_array(circles: npt.NDArray[np.float64], inks: npt.NDArray[np.uint8]) -> npt.NDArray[np.void]:
    """Return circles (n, 3) and inks (n,) as one structured array."""
    stipples = np.empty(len(inks), STIPPLE_DTYPE)
    stipples["x"], stipples["y"], stipples["radius"] = circles.T
    stipples["ink"] = inks
    return stipples


def _checked_part(part: object) -> tuple[float, float, float, float]:
    """Return the part as floats, likewise."""
    try:
        left, top, right, bottom = (float(side) for side in part)  # type: ignore[attr-defined]  # what fails is told
    except (TypeError, ValueError):
        raise InvalidInputError(f"part is {part!r}, but it must be four numbers: left, top, right and bottom") from None
    return left, top, right, bottom


def plain_settings(settings: Mapping[str, Any]) -> dict[str, Any]:
    """Return settings by name with NumPy's scalars as Python's."""
    return {name: plain(value) for name, value in settings.items()}


def _plain(**settings: Any) -> dict[str, Any]:
    """Return settings of how a file is written likewise."""
    return plain_settings(settings)


def _hex(rgb: bytes) -> str:
    """Return a colour as it is written."""
    return f"#{rgb.hex()}"


def _names(only: str | Sequence[str] | None) -> str | None:
    """Return names of inks with commas between them."""
    return only if only is None or isinstance(only, str) else ",".join(only)


def _given(**settings: Any) -> dict[str, Any]:
    """Return likewise those that are given."""
    return _plain(**{name: value for name, value in settings.items() if value is not None})
