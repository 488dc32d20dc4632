"""Make the pictures of the documentation: ``python docs/pictures.py [FOLDER]``, by default into docs/images.

The photo is scikit-image's astronaut (a NASA portrait, public domain). Every picture is a strip of panels.
"""

import sys
from pathlib import Path

import numpy as np
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


def write(path: Path, panels: list[Image.Image], greys: int = 16) -> None:
    """Write grey panels side by side, in few greys: in line art the eye sees no difference, and files are a fraction as large."""
    width = sum(panel.width for panel in panels) + GAP * (len(panels) - 1)
    strip = Image.new("L", (width, max(panel.height for panel in panels)), 255)
    left = 0
    for panel in panels:
        strip.paste(panel, (left, 0))
        left += panel.width + GAP
    levels = Image.fromarray(np.round(np.asarray(strip) / 255 * (greys - 1)).astype(np.uint8)).convert("P")
    levels.putpalette([round(255 * level / (greys - 1)) for level in range(greys) for _ in range(3)])
    levels.save(path, optimize=True, bits=4 if greys <= 16 else 8)


def field(values: np.ndarray, part: tuple[int, int, int, int], scale: int) -> Image.Image:
    """Return a part of a field in [0, 1], enlarged without smoothing."""
    left, top, right, bottom = part
    crop = Image.fromarray(np.round(255 * values[top:bottom, left:right]).astype(np.uint8))
    return crop.resize((scale * crop.width, scale * crop.height), Image.Resampling.NEAREST)


def drawn(drawing: gs.Drawing, part: tuple[int, int, int, int], scale: int) -> Image.Image:
    """Return a part of a drawing, enlarged."""
    left, top, right, bottom = (scale * side for side in part)
    return Image.fromarray(drawing.rasterize(width=scale * drawing.width)[top:bottom, left:right])


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


def main() -> None:
    """Draw everything."""
    folder = Path(sys.argv[1]) if len(sys.argv) > 1 else Path(__file__).resolve().parent / "images"
    folder.mkdir(parents=True, exist_ok=True)
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

    budgets = [gs.draw(photo, options=gs.Options(nodes=nodes)) for nodes in (5_000, 20_000, 80_000)]
    write(folder / "nodes.png", [drawn(one, HEAD, 2) for one in budgets])

    alphas = [gs.draw(photo, options=gs.Options(alpha=alpha)) for alpha in (0, "dynamic", 1)]
    write(folder / "alpha.png", [drawn(one, HEAD, 2) for one in alphas])

    # A map of one's own: a bright disc on the face, dim elsewhere.
    row, column = np.mgrid[: luma.shape[0], : luma.shape[1]]
    face = np.where(np.hypot(column - 222, row - 112) < 60, 1.0, 0.1)
    budget = gs.Options(nodes=20_000)
    maps = [gs.draw(photo, importance=importance, options=budget) for importance in ("none", "saliency", face)]
    write(folder / "importance.png", [drawn(one, HEAD, 2) for one in maps])


if __name__ == "__main__":
    main()
