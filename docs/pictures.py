"""Make the pictures of the documentation: ``python docs/pictures.py [FOLDER]``, by default into docs/images, and the site's mark.

The photo is scikit-image's astronaut (a NASA portrait, public domain). Every picture is a strip of panels.
"""

import io
import re
import sys
from pathlib import Path
from xml.etree import ElementTree

import numpy as np
import resvg_py
from PIL import Image, ImageDraw
from skimage import data

import graphstipple as gs

GAP = 8
"""White pixels between two panels."""

HEAD = (110, 0, 310, 200)
"""The part of the photo that most panels show: left, top, right, bottom in pixels."""

SMOOTH = 4
"""How much larger graphs are drawn before they are reduced, for want of antialiasing."""

EYE = (190, 84, 230, 124)
"""The part in which single nodes can be seen."""

FACE = (166, 66, 266, 166)
"""The part that shows styles and inks."""

CHEEK = (160, 122, 220, 200)
"""The part that shows edges: a stroke, the rim of a large shape, and dots."""

FILLS = (("contour", 0.1), ("hatch", -1.0), ("outline", 0.1), ("none", 0.1))
"""How plots are filled, and by how much their lines overlap."""

COLOURS = 48
"""Colours of a picture of a report."""


def write(path: Path, panels: list[Image.Image], greys: int = 16) -> None:
    """Write grey panels side by side, in few greys: in line art the eye sees no difference, and files are a fraction as large."""
    strip = np.asarray(beside(panels, "L"))
    levels = Image.fromarray(np.round(strip / 255 * (greys - 1)).astype(np.uint8)).convert("P")
    levels.putpalette([round(255 * level / (greys - 1)) for level in range(greys) for _ in range(3)])
    levels.save(path, optimize=True, bits=4 if greys <= 16 else 8)


def beside(panels: list[Image.Image], mode: str) -> Image.Image:
    """Return panels side by side."""
    width = sum(panel.width for panel in panels) + GAP * (len(panels) - 1)
    strip = Image.new(mode, (width, max(panel.height for panel in panels)), "white")
    left = 0
    for panel in panels:
        strip.paste(panel, (left, 0))
        left += panel.width + GAP
    return strip


def write_in_colours(path: Path, panels: list[Image.Image]) -> None:
    """Write panels side by side, in few colours."""
    beside(panels, "RGB").quantize(COLOURS).save(path, optimize=True)


def field(values: np.ndarray, part: tuple[int, int, int, int], scale: int) -> Image.Image:
    """Return a part of a field in [0, 1], enlarged without smoothing."""
    left, top, right, bottom = part
    crop = Image.fromarray(np.round(255 * values[top:bottom, left:right]).astype(np.uint8))
    return crop.resize((scale * crop.width, scale * crop.height), Image.Resampling.NEAREST)


def drawn(drawing: gs.Drawing, part: tuple[int, int, int, int], scale: int) -> Image.Image:
    """Return a part of a drawing, enlarged."""
    left, top, right, bottom = (scale * side for side in part)
    return Image.fromarray(drawing.rasterize(width=scale * drawing.width)[top:bottom, left:right])


def plotted(plot: gs.Plot, part: tuple[int, int, int, int], width: int, scale: int) -> Image.Image:
    """Return what a pen draws of a part of a drawing so many pixels wide, enlarged."""
    left, top, right, bottom = (scale * side for side in part)
    return Image.fromarray(plot.rasterize(scale * width)[top:bottom, left:right])


def reported(report: gs.Report, part: tuple[int, int, int, int], width: int, scale: int) -> Image.Image:
    """Return a part of a report on a drawing so many pixels wide, enlarged."""
    png = bytes(resvg_py.svg_to_bytes(svg_string=report.svg(), width=scale * width, dpi=96))
    left, top, right, bottom = (scale * side for side in part)
    return Image.open(io.BytesIO(png)).convert("RGB").crop((left, top, right, bottom))


def graph(sites: np.ndarray, edges: np.ndarray, grey: np.ndarray, part: tuple[int, int, int, int], scale: int) -> Image.Image:
    """Return a part of a graph: edges as grey lines, nodes as dots with a black rim, filled with their grey in [0, 1]."""
    left, top, right, bottom = part
    size = (scale * (right - left), scale * (bottom - top))
    image = Image.new("L", (SMOOTH * size[0], SMOOTH * size[1]), 255)
    canvas = ImageDraw.Draw(image)
    points = (sites - (left, top)) * scale * SMOOTH
    near = np.all((sites > (left - 9, top - 9)) & (sites < (right + 9, bottom + 9)), axis=1)
    for a, b in edges[near[edges[:, 0]] & near[edges[:, 1]]] if len(edges) else []:
        canvas.line([*points[a], *points[b]], fill=170, width=SMOOTH)
    for (x, y), value in zip(points[near], grey[near], strict=True):
        for radius, fill in ((2.6 * SMOOTH, 0), (1.8 * SMOOTH, round(255 * float(value)))):
            canvas.ellipse([x - radius, y - radius, x + radius, y + radius], fill=fill)
    return image.resize(size, Image.Resampling.BOX)


def stacked(drawing: gs.Drawing, part: tuple[int, int, int, int], scale: int, *, layered: bool) -> Image.Image:
    """Return how many shapes of a file lie over each other in a part: white for none, and darker with each.

    A layered file begins with its paper, which also stands for the white regions that touch the frame.
    """
    left, top, right, bottom = part
    fine = SMOOTH * scale
    count = np.full((fine * (bottom - top), fine * (right - left)), int(layered), np.int16)

    def add(ring: np.ndarray, change: int) -> None:
        points = (ring - (left, top)) * fine
        first = np.clip(np.floor(points.min(axis=0)).astype(int), 0, count.shape[::-1])
        last = np.clip(np.ceil(points.max(axis=0)).astype(int) + 1, 0, count.shape[::-1])
        if (last > first).all():
            mask = Image.new("1", (last[0] - first[0], last[1] - first[1]))
            ImageDraw.Draw(mask).polygon([tuple(point) for point in points - first], fill=1)
            count[first[1] : last[1], first[0] : last[0]] += change * np.asarray(mask)

    for region in drawing.regions:
        is_paper = ((region.exterior <= 0) | (region.exterior >= (drawing.width, drawing.height))).any()
        if region.ink == 0 or (layered and not is_paper):
            add(region.exterior, 1)
        if not layered and region.ink == 0:
            for hole in region.holes:
                add(hole, -1)
    angles = np.linspace(0, 2 * np.pi, 24, endpoint=False)
    circle = np.stack([np.cos(angles), np.sin(angles)], axis=1)
    for dot in drawing.stipples:
        if layered or dot["ink"] == 0:
            add(circle * dot["radius"] + (dot["x"], dot["y"]), 1)
    picture = Image.fromarray(np.clip(255 - 45 * count, 0, 255).astype(np.uint8))
    return picture.resize((scale * (right - left), scale * (bottom - top)), Image.Resampling.BOX)


def anchors(drawing: gs.Drawing) -> np.ndarray:
    """Return the points that the curves of the black regions pass through, (n, 2), from the drawing's SVG."""
    root = ElementTree.fromstring(drawing.svg())
    group = next(group for group in root.iter() if group.get("id") == "black-regions")
    scale = float(group.get("transform", "scale(1)").removeprefix("scale(").removesuffix(")"))
    # How many numbers a command takes, of which the last two, or the one, lead to the next point.
    counts = {"m": 2, "l": 2, "t": 2, "h": 1, "v": 1, "q": 4, "s": 4, "c": 6, "a": 7}
    points = []
    for path in group.iter("{http://www.w3.org/2000/svg}path"):
        here = start = np.zeros(2)
        for letter, text in re.findall(r"([a-z])([^a-z]*)", path.get("d", "")):
            numbers = [float(number) for number in re.findall(r"-?(?:\d+\.?\d*|\.\d+)", text)]
            if letter == "z":
                here = start
                continue
            for step in range(0, len(numbers), counts[letter]):
                x, y = (0.0, *numbers[step : step + counts[letter]])[-2:]
                here = here + {"h": (y, 0.0), "v": (0.0, y)}.get(letter, (x, y))
                start = here if letter == "m" and step == 0 else start
                points.append(here * scale)
    return np.array(points)


def with_anchors(drawing: gs.Drawing, part: tuple[int, int, int, int], scale: int) -> Image.Image:
    """Return a part of a drawing, its black in grey, with the points that its curves pass through."""
    left, top, right, bottom = part
    picture = np.asarray(drawn(drawing, part, SMOOTH * scale))
    image = Image.fromarray((170 + picture / 3).astype(np.uint8))
    canvas = ImageDraw.Draw(image)
    for x, y in (anchors(drawing) - (left, top)) * scale * SMOOTH:
        canvas.ellipse([x - 1.4 * SMOOTH, y - 1.4 * SMOOTH, x + 1.4 * SMOOTH, y + 1.4 * SMOOTH], fill=0)
    return image.resize((scale * (right - left), scale * (bottom - top)), Image.Resampling.BOX)


def mark() -> gs.Drawing:
    """Return the sign of the site: a ball in light from the upper left, in few nodes."""
    row, column = np.mgrid[:64, :64] + 0.5
    light = np.clip(1.1 - np.hypot(column - 24, row - 22) / 34, 0, 1)
    ball = np.where(np.hypot(column - 32, row - 32) < 27, light, 1.0)
    options = gs.Options(nodes=300, stippling=0.9, sharpen=0, local_contrast=0)
    return gs.draw(ball, importance="none", options=options)


def write_subjects(folder: Path, photo: np.ndarray) -> None:
    """Write what steps back from a subject that is found, and from one that a mask shows."""
    # docs/howto/subject.md: a part that has a flag, a wall and a rocket behind the portrait; nodes large enough to be seen.
    part, budget = (20, 0, 420, 400), gs.Options(nodes=24_000)
    found = gs.Session(photo, subject="auto")
    panels = [gs.draw(photo, options=budget), *(found.draw(budget.replace(backdrop=word)) for word in ("fade", "paper"))]
    write(folder / "subject.png", [drawn(one, part, 1) for one in panels], greys=8)

    cup = gs.Session(data.coffee(), subject="auto")
    panels = [cup.draw(gs.Options(nodes=16_000, backdrop=word)) for word in ("soften", "fade", "paper", "ink")]
    write(folder / "backdrops.png", [Image.fromarray(one.rasterize(360)) for one in panels], greys=8)


def write_machines(folder: Path, photo: np.ndarray, drawing: gs.Drawing) -> None:
    """Write what machines make of a photo."""
    # docs/howto/plotter.md: a pen of 0.5 mm on 180 mm, by every fill.
    plots = [drawing.plot("0.5mm", "180mm", fill=fill, overlap=overlap) for fill, overlap in FILLS]
    write(folder / "plots.png", [plotted(plot, FACE, drawing.width, 3) for plot in plots])

    # docs/howto/laser-and-vinyl.md and stencil-and-screen-print.md: what breaks the rules of a process, and what keeps them.
    bold = gs.draw(photo, options=gs.Options.preset("linocut"))
    whole = (0, 0, bold.width, bold.height)
    for name, process, width, part, scale in (("report", "vinyl", "300mm", HEAD, 3), ("stencil", "stencil", "200mm", whole, 2)):
        rules = gs.Rules.process(process)
        before = reported(bold.check(rules, width=width), part, bold.width, scale)
        kept, _ = bold.enforce(rules, width=width)
        write_in_colours(folder / f"{name}.png", [before, drawn(kept, part, scale)])


def write_inks(folder: Path, photo: np.ndarray) -> None:
    """Write a photo in inks: three on cream paper, five of its own, greys, and four over each other."""
    part, budget = (96, 20, 346, 290), gs.Options(nodes=60_000)
    inks = [
        {"inks": "#1d1d1b,pink=#ff48b0,#0078bf", "paper": "#f4efe2"},
        {"extract_inks": 5},
        {"levels": 4},
        {"inks": "#00aeef,#ec008c,#fff200,#1d1d1b", "overprint": True},
    ]
    panels = [drawn(gs.draw(photo, options=budget.replace(**one)), part, 1) for one in inks]
    write_in_colours(folder / "colours.png", panels)


def write_contours(folder: Path, photo: np.ndarray) -> None:
    """Draw how many points a tolerance leaves, and edges as by hand: first as they are, then each kind at 0.2 and at 1."""
    simpler = [gs.draw(photo, options=gs.Options(tolerance=tolerance)) for tolerance in (0, 0.25, 0.5, 1, 2)]
    write(folder / "tolerance.png", [with_anchors(one, EYE, 6) for one in simpler])

    edges = [(edge, wobble) for edge in ("smooth", "inked", "torn") for wobble in (0.2, 1)]
    hands = [gs.Options(), *(gs.Options(wobble=wobble, edge=edge) for edge, wobble in edges)]
    write(folder / "wobble.png", [drawn(gs.draw(photo, options=options), CHEEK, 5) for options in hands])


def main() -> None:
    """Draw everything."""
    folder = Path(sys.argv[1]) if len(sys.argv) > 1 else Path(__file__).resolve().parent / "images"
    folder.mkdir(parents=True, exist_ok=True)
    mark().save(folder / "mark.svg", style="layered")
    photo = data.astronaut()
    luma = gs.stages.tone(photo)
    drawing = gs.draw(photo)

    # What the README opens with.
    size = 640
    grey = Image.fromarray(np.round(255 * luma).astype(np.uint8)).resize((size, size), Image.Resampling.BICUBIC)
    write(folder / "astronaut.png", [grey, Image.fromarray(drawing.rasterize(width=size))], greys=48)

    # The stages: tone, importance, kept lattice nodes, second graph with its labels, drawing.
    first = gs.stages.lattice_labels(drawing.importance)
    kept = first.sites[first.labels == 1]
    second = drawing.graph
    panels = [
        field(luma, EYE, 6),
        field(drawing.importance, EYE, 6),
        graph(kept, np.empty((0, 2), int), np.zeros(len(kept)), EYE, 6),
        graph(second.sites, second.edges, second.labels, EYE, 6),
        drawn(drawing, EYE, 6),
    ]
    write(folder / "stages.png", panels)

    # An importance that grows from left to right, and the nodes that each order keeps of it.
    slope = np.tile(np.linspace(0.02, 1, 150, dtype=np.float32), (100, 1))
    panels = []
    ours = gs.Options().published
    for order in ("global", "rows"):
        chosen = gs.stages.lattice_labels(slope, gs.Options(nodes=2_500, published=ours.replace(importance_order=order)))
        kept = chosen.sites[chosen.labels == 1]
        panels.append(graph(kept, np.empty((0, 2), int), np.zeros(len(kept)), (0, 0, 150, 100), 4))
    write(folder / "order.png", panels)

    budgets = [gs.draw(photo, options=gs.Options(nodes=nodes)) for nodes in (5_000, 20_000, 80_000)]
    write(folder / "nodes.png", [drawn(one, HEAD, 2) for one in budgets])

    stippled = [gs.draw(photo, options=gs.Options(stippling=stippling)) for stippling in (0, 0.5, 0.8)]
    write(folder / "stippling.png", [drawn(one, HEAD, 2) for one in stippled])

    # docs/steps.md: the default without its importance by detail, its emphasis, its dots in smooth parts.
    without: list[dict[str, float]] = [
        {"detail": 0, "floor": 0, "midtones": 0},
        {"sharpen": 0, "local_contrast": 0},
        {"stippling": 0},
    ]
    steps = [drawing, *(gs.draw(photo, options=gs.Options(**changes)) for changes in without)]
    write(folder / "steps.png", [drawn(one, HEAD, 2) for one in steps])

    shapes = gs.Options(stippling=0)
    published = [ours.replace(alpha=alpha) for alpha in (0, "tonal", 1)]
    alphas = [gs.draw(photo, options=shapes.replace(published=one, refine=0)) for one in published]
    write(folder / "alpha.png", [drawn(one, HEAD, 2) for one in alphas])

    refinements = (shapes.replace(refine=0), shapes, shapes.replace(crispness=8, cohesion=1))
    refined = [gs.draw(photo, options=options) for options in refinements]
    write(folder / "refinement.png", [drawn(one, HEAD, 2) for one in refined])

    # A map of one's own: a bright disc on the face, dim elsewhere.
    row, column = np.mgrid[: luma.shape[0], : luma.shape[1]]
    face = np.where(np.hypot(column - 222, row - 112) < 60, 1.0, 0.1)
    budget = gs.Options(nodes=20_000)
    maps = [gs.draw(photo, importance=importance, options=budget) for importance in ("none", "saliency", face)]
    write(folder / "importance.png", [drawn(one, HEAD, 2) for one in maps])

    write_subjects(folder, photo)
    write_inks(folder, photo)

    # docs/output.md: what lies over what, and which ink on which paper.
    picture = drawn(drawing, FACE, 3)
    write(folder / "styles.png", [picture, *(stacked(drawing, FACE, 3, layered=layered) for layered in (True, False))])
    white = np.asarray(picture) / 255
    black_on_grey, white_on_grey = (Image.fromarray(np.round(grey).astype(np.uint8)) for grey in (190 * white, 90 + 165 * white))
    write(folder / "inks.png", [black_on_grey, white_on_grey, picture])

    write_contours(folder, photo)
    write_machines(folder, photo, drawing)


if __name__ == "__main__":
    main()
