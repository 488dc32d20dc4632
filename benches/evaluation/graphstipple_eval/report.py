"""The report: results as JSON, CSV and HTML pages in one folder, which opens without a server.

index.html              tables, plots, sweeps, failures
protocol.html           what is compared with what
photos/NAME-SIZE.html   the pictures of a photo side by side
plots/                  scatter plots
pictures/NAME-SIZE/     the photo, and the files of its pictures
results.json, results.csv
.graphstipple-eval      says that the folder is a report
"""

from __future__ import annotations

import csv
import functools
import importlib.resources
import inspect
import io
import json
import re
from collections.abc import Sequence
from itertools import groupby
from pathlib import Path
from typing import Any

import jinja2
from markupsafe import Markup, escape

from graphstipple_eval import files, ours, plots, quoted, results, tables
from graphstipple_eval.method import Method
from graphstipple_eval.photos import PhotoFile
from graphstipple_eval.plots import Point, Quantity
from graphstipple_eval.results import Result
from graphstipple_eval.run import Outcome
from graphstipple_eval.selection import Selection

PICTURES = "pictures"
"""Folder of the photos and pictures."""

MARKER = ".graphstipple-eval"
"""The file that is written first: in a folder without it, nothing is overwritten or deleted."""

STATIC = ("style.css", "script.js")

LPIPS_NEAR, LPIPS_FAR = "LPIPS Alex, near (lower is better)", "LPIPS Alex, far (lower is better)"

PLOTS = (
    ("near-far", "Near against far", "near_lpips_alex", Quantity(LPIPS_NEAR), "far_lpips_alex", Quantity(LPIPS_FAR)),
    (
        "coordinates-near",
        "Quality near against coordinates written",
        "coordinates",
        Quantity("coordinates written", is_logarithmic=True),
        "near_lpips_alex",
        Quantity(LPIPS_NEAR),
    ),
    (
        "coordinates-far",
        "Quality far against coordinates written",
        "coordinates",
        Quantity("coordinates written", is_logarithmic=True),
        "far_lpips_alex",
        Quantity(LPIPS_FAR),
    ),
    (
        "marks-seconds",
        "Seconds against marks",
        "marks",
        Quantity("marks (stipples and regions)", is_logarithmic=True),
        "seconds",
        Quantity("seconds", is_logarithmic=True),
    ),
)
"""File, title, and the number and title of both axes. All means over photos."""


def write(root: Path, photos: Sequence[PhotoFile], selection: Selection, outcome: Outcome) -> Path:
    """Write the report and return the place of its first page.

    Parameters
    ----------
    root : Path
        The report's folder.
    photos : sequence of PhotoFile
        The photos of the run, at all sizes.
    selection : Selection
        The methods of the run.
    outcome : Outcome
        What the run came to.

    Raises
    ------
    OSError
        If a file cannot be written.
    """
    methods = selection.compared
    compared = tables.compared(methods)
    shared = {
        "budget": _budget(selection),
        "ablations_at": "at equal coordinates" if selection.coordinates else "at equal numbers of nodes",
        "is_fixed": selection.coordinates is not None,
        "missing": selection.missing,
        "ours": [method.name for method in methods if _is_ours(method)],
        "versions": results.versions(),
        "quoted": quoted,
        "photos": photos,
        "names": sorted({photo.name for photo in photos}),
    }
    written = numbers(photos, selection, outcome)
    for name in STATIC:
        written[name] = (importlib.resources.files("graphstipple_eval") / "static" / name).read_text("utf-8")

    sections = []
    for size, group in groupby(outcome.results, lambda result: result.size):
        made = list(group)
        here = [photo for photo in photos if photo.size == size]
        sections.append(
            {
                "size": size,
                "photos": len(here),
                "smaller": sum(_is_smaller(photo) for photo in here),
                "quality": tables.table(compared, made, tables.QUALITY),
                "seen": tables.table(methods, made, tables.SEEN),
                "counts": tables.table(compared, made, tables.COUNTS),
                "ablations": tables.table(tables.ablated(methods), made, tables.QUALITY),
                "ideas": tables.table(tables.ideas(methods), made, tables.SWEEP),
                "plots": _plots(size, compared, made, written),
            }
        )
    pages = [_page(photo, outcome.results, root) for photo in photos]
    environment = _environment()
    written["index.html"] = environment.get_template("index.html").render(
        **shared,
        up="",
        compared=compared,
        sections=sections,
        sweeps=[_sweep(sweep, selection.coordinates, outcome.results) for sweep in selection.sweeps],
        pages=pages,
        failures=outcome.failures,
    )
    title = next((method.title for method in methods if method.name == ours.PAPER), ours.PAPER)
    written["protocol.html"] = environment.get_template("protocol.html").render(
        **shared, up="", readings=_readings(methods), paper_title=title
    )
    template = environment.get_template("photo.html")
    everything = list(selection.all().values())
    for index, (photo, page) in enumerate(zip(photos, pages, strict=True)):
        made = _of(photo, outcome.results)
        written[page["href"]] = template.render(
            **shared,
            up="../",
            page=page,
            before=pages[index - 1] if index else None,
            after=pages[index + 1] if index + 1 < len(pages) else None,
            panes=_panes(photo, everything, made, root),
            quality=tables.table(everything, made, tables.QUALITY),
            seen=tables.table(everything, made, tables.SEEN),
            counts=tables.table(everything, made, tables.COUNTS),
            failures=[failure for failure in outcome.failures if (failure.photo, failure.size) == (photo.name, photo.size)],
        )

    for name, text in written.items():
        files.write(root / name, text.encode())
    for path in [*root.glob("photos/*.html"), *root.glob("plots/*.svg")]:
        if path.relative_to(root).as_posix() not in written:  # of a run with other photos or sizes
            path.unlink()
    return root / "index.html"


def _environment() -> jinja2.Environment:
    environment = jinja2.Environment(
        loader=jinja2.PackageLoader("graphstipple_eval"),
        autoescape=True,
        trim_blocks=True,
        lstrip_blocks=True,
        undefined=jinja2.StrictUndefined,
    )
    environment.globals["whole"] = tables.COUNTS[0].text
    return environment


def _budget(selection: Selection) -> str:
    """Return a sentence that states the budget."""
    if isinstance(selection.budget, int):
        return f"Stippling methods draw {selection.budget:,} dots, and our own drawings are brought to as many coordinates."
    what = {"coordinates": "writes coordinate pairs", "marks": "has marks, stipples and regions together"}[selection.budget]
    return f"Stippling methods draw as many dots as the default drawing of the same photo {what}."


def _is_ours(method: Method) -> bool:
    return inspect.getmodule(_function(method)) is ours


def _function(method: Method) -> Any:
    """Return the function that draws, without arguments that are bound to it."""
    return method.draw.func if isinstance(method.draw, functools.partial) else method.draw


def _is_smaller(photo: PhotoFile) -> bool:
    """Return whether a photo is smaller than the size, so that it is at its own."""
    return max(photo.width, photo.height) < photo.size


def _of(photo: PhotoFile, made: Sequence[Result]) -> list[Result]:
    return [result for result in made if (result.photo, result.size) == (photo.name, photo.size)]


def numbers(photos: Sequence[PhotoFile], selection: Selection, outcome: Outcome) -> dict[str, str]:
    """Return the files that hold a run's numbers by their names, `results.json` and `results.csv`."""
    return {"results.json": _json(photos, selection, outcome), "results.csv": _csv(outcome.results)}


def _json(photos: Sequence[PhotoFile], selection: Selection, outcome: Outcome) -> str:
    content = {
        "budget": selection.budget,
        "versions": results.versions(),
        "methods": [{"name": method.name, "title": method.title, "source": method.source} for method in selection.all().values()],
        "missing": selection.missing,
        "photos": [{"name": p.name, "checksum": p.checksum, "size": p.size, "width": p.width, "height": p.height} for p in photos],
        "pictures": [result.json() for result in outcome.results],
        "failures": [vars(failure) for failure in outcome.failures],
    }
    return json.dumps(content, indent=1, allow_nan=False) + "\n"


def _csv(made: Sequence[Result]) -> str:
    """Return a row a picture: what it is of, then every number."""
    numbers = list(dict.fromkeys(name for result in made for name in result.numbers()))
    buffer = io.StringIO()
    rows = csv.writer(buffer, lineterminator="\n")
    rows.writerow(["photo", "checksum", "size", "width", "height", "method", "dots", *numbers, "png", "key"])
    for result in made:
        row = result.numbers()
        head = [result.photo, result.checksum, result.size, result.width, result.height, result.method, result.dots]
        rows.writerow([*head, *(row.get(name) for name in numbers), result.png, result.key])
    return buffer.getvalue()


def _plots(size: int, methods: Sequence[Method], made: Sequence[Result], written: dict[str, str]) -> list[dict[str, str]]:
    """Make the scatter plots of a size; methods that lack one of the two numbers are not in them."""
    found = []
    for file, title, x, x_axis, y, y_axis in PLOTS:
        points = []
        for method in methods:
            mean = tables.means((r for r in made if r.method == method.name), (x, y, "stipples", "regions"))
            if "marks" in {x, y} and mean["stipples"] is not None:
                mean["marks"] = mean["stipples"] + (mean["regions"] or 0)
            at, value = mean[x], mean[y]
            is_drawable = all(
                number is not None and (number > 0 or not axis.is_logarithmic) for number, axis in ((at, x_axis), (value, y_axis))
            )
            if is_drawable and at is not None and value is not None:
                points.append(Point(method.name, at, value, _is_ours(method)))
        if points:
            path = f"plots/{file}-{size}.svg"
            written[path] = plots.scatter(points, x_axis, y_axis)
            found.append({"path": path, "title": title})
    return found


def _page(photo: PhotoFile, made: Sequence[Result], root: Path) -> dict[str, Any]:
    """Return what pages say of a photo at a size, and where its page is."""
    drawing = next((result.png for result in _of(photo, made) if result.method == ours.DEFAULT), None)
    file = f"{photo.folder.name}.html"
    return {
        "name": photo.name,
        "size": photo.size,
        "width": photo.width,
        "height": photo.height,
        "is_smaller": _is_smaller(photo),
        "label": f"{photo.name}, {photo.size} px",
        "file": file,
        "href": f"photos/{file}",
        "photo": photo.path.relative_to(root).as_posix(),
        "drawing": drawing,
    }


def _panes(photo: PhotoFile, methods: Sequence[Method], made: Sequence[Result], root: Path) -> list[dict[str, Any]]:
    """Return the photo and its pictures with what stands under them, in the order of the methods."""
    original = {"name": "photo", "title": "the photo's tone", "png": photo.path.relative_to(root).as_posix(), "quality": {}}
    panes: list[dict[str, Any]] = [original]
    by_method = {result.method: result for result in made}
    for method in methods:
        if method.name not in by_method:
            continue
        result = by_method[method.name]
        numbers = result.numbers()
        counted = [column for column in tables.COUNTS if numbers.get(column.key) is not None]
        tone = next(column for column in tables.QUALITY if column.key == "tone_error")
        seen = [column for column in tables.SEEN if column.group != tables.FARTHER and numbers.get(column.key) is not None]
        panes.append(
            {
                "name": method.name,
                "title": method.title,
                "png": result.png,
                "svg": result.svg,
                "json": Path(result.png).with_suffix(".json").as_posix(),
                "quality": {column.key: column.text(numbers.get(column.key)) for column in (*tables.QUALITY, *tables.SEEN)},
                "counts": [
                    {"key": column.key, "title": column.title, "text": column.text(numbers[column.key])}
                    for column in (tone, *seen, *counted)
                ],
                "settings": _by_full_name(result.settings),
                "note": result.settings.get("note"),
            }
        )
    return panes


def _by_full_name(settings: dict[str, object]) -> dict[str, object]:
    """Return settings with those of a group one by one, as `GROUP.NAME`."""
    flat: dict[str, object] = {}
    for name, value in settings.items():
        flat |= {f"{name}.{inner}": it for inner, it in value.items()} if isinstance(value, dict) else {name: value}
    return flat


def _sweep(sweep: ours.Sweep, coordinates: int | None, made: Sequence[Result]) -> dict[str, Any]:
    """Return a sweep's tables and strips, size by size."""
    methods = {method.name: method for method in sweep.methods(coordinates)}
    parts = []
    for size, group in groupby((r for r in made if r.method in methods), lambda result: result.size):
        here = list(group)
        strips = [
            {
                "href": f"photos/{photo}-{size}.html",
                "images": [{"path": r.png, "title": f"{photo}, {methods[r.method].title}"} for r in row],
            }
            for photo, row in groupby(here, lambda result: result.photo)
        ]
        parts.append({"size": size, "table": tables.table(list(methods.values()), here, tables.SWEEP), "strips": strips})
    is_budgeted = any(method.is_budgeted for method in methods.values())
    return {"option": sweep.option, "coordinates": coordinates if is_budgeted else None, "parts": parts}


def _readings(methods: Sequence[Method]) -> list[dict[str, Any]]:
    """Return how methods are read: the documentation of each module that draws, with the methods of that module."""
    grouped: dict[Any, list[Method]] = {}
    for method in methods:
        grouped.setdefault(inspect.getmodule(_function(method)), []).append(method)
    return [{"methods": group, "text": _html(inspect.getdoc(module) or "")} for module, group in grouped.items()]


def _html(text: str) -> Markup:
    """Return a docstring as HTML: paragraphs, lists of lines that begin with a dash, code in backticks."""
    blocks = []
    for block in re.split(r"\n\s*\n", inspect.cleandoc(text)):
        inside = re.sub(r"`+([^`]+)`+", r"<code>\1</code>", str(escape(block)))
        inside = re.sub(r"\*([^*\s][^*]*)\*", r"<em>\1</em>", inside)
        lead, *items = re.split(r"(?:^|\n)- ", inside)
        blocks.append(f"<p>{lead}</p>" if lead else "")
        blocks.append("<ul>" + "".join(f"<li>{item}</li>" for item in items) + "</ul>" if items else "")
    return Markup("".join(blocks))
