"""Make the gallery: ``python docs/gallery.py`` writes docs/gallery.md and its pictures in docs/images.

The photos are those that scikit-image's wheel holds (public domain), at most 512 pixels wide and high.
"""

import sys
from pathlib import Path

import numpy as np
from pictures import write
from PIL import Image
from skimage import data

import graphstipple as gs

FOLDER = Path(__file__).resolve().parent

SIDE = 512
"""Pixels of the longer side of a photo."""

PRESET_PHOTOS = {"astronaut": (96, 20, 356, 280), "chelsea": (90, 30, 350, 290)}
"""Which part of which photo shows the presets, in pixels: left, top, right, bottom."""

NOTES = {
    "astronaut": (
        "the face is a face; hair, flag, badges and the folds of the suit can be read, edges are clean, and no blobs stand around.",
        "clouds of dots on the wall end where its grey gets light, and a few dots are left in between.",
    ),
    "camera": (
        "the face, the camera, the tripod's legs and the buildings are sharp, and the lawn is one even grey.",
        "the coat is one black area with hardly a fold; the lawn's grey is dots and short strokes, not grass.",
    ),
    "chelsea": (
        "eyes, whiskers, nose and the run of the fur; the paper's settings lose the cat.",
        "the white of chin and chest has more dots than the photo has grey; the soft background ends in steps, black or dotted.",
    ),
    "coffee": (
        "cup, spoon and saucer have their outlines, the coffee is smooth, and the table is wood.",
        "the light end of the table is rougher than in the photo, and a few dots lie in the dark saucer by chance.",
    ),
    "rocket": (
        "rocket, lamps and the towers' girders are there, and the evening sky is a gradient of even dots.",
        "the brightest part of the sky winds into a labyrinth, its darkest part is black; thin girders break into pieces.",
    ),
}
"""What is better than under the paper's settings, and what is still wrong."""


def photo(name: str) -> np.ndarray:
    """Return a photo as luma in 8 bits."""
    image = Image.fromarray(getattr(data, name)()).convert("L")
    image.thumbnail((SIDE, SIDE), Image.Resampling.LANCZOS)
    return np.asarray(image)


def raster(drawing: gs.Drawing) -> Image.Image:
    """Return a drawing at the size of its photo."""
    return Image.fromarray(drawing.rasterize())


def main() -> None:
    """Write the page and its pictures."""
    folder = Path(sys.argv[1]) if len(sys.argv) > 1 else FOLDER
    images = folder / "images"
    images.mkdir(parents=True, exist_ok=True)
    page = [
        "# Gallery",
        "",
        "Made by `docs/gallery.py`, from the photos that come with scikit-image.",
        "",
        "## Presets",
        "",
        "A preset is a set of options under a name: `--preset NAME` on the command line (`--list-presets` prints this list),",
        '`gs.Options.preset("NAME")` in Python. Any option can be changed on top of it.',
        "",
    ]
    for preset in gs.presets():
        options = gs.Options.preset(preset.name)
        panels = []
        for name, part in PRESET_PHOTOS.items():
            drawing = gs.draw(photo(name), options=options)
            width = 2 * drawing.width
            panels.append(Image.fromarray(drawing.rasterize(width=width)).crop(tuple(2 * side for side in part)))
        write(images / f"preset-{preset.name}.png", panels, greys=8)
        page += [
            f"### {preset.name}",
            "",
            f"{preset.description[0].upper()}{preset.description[1:]}.",
            "",
            f"![{preset.name}](images/preset-{preset.name}.png)",
            "",
        ]
    page += [
        "## The default and the paper's settings",
        "",
        "Left `Options.paper()` with the default's node budget, right the default: the same number of nodes, a pixel of the",
        "picture for each of the photo's. docs/evaluation.md says how the two are measured against each other.",
        "",
    ]
    for name, (better, wrong) in NOTES.items():
        image = photo(name)
        nodes = round(0.3 * image.size)
        drawings = [gs.draw(image, options=options) for options in (gs.Options.paper(nodes=nodes), gs.Options(nodes=nodes))]
        write(images / f"compare-{name}.png", [raster(drawing) for drawing in drawings], greys=8)
        counts = [f"{drawing.stats['vertices']:,} vertices" for drawing in drawings]
        page += [
            f"### {name}",
            "",
            f"![{name}: the paper's settings, the default](images/compare-{name}.png)",
            "",
            f"*{counts[0]}, {counts[1]}.*",
            "",
            f"Better: {better}",
            "",
            f"Still wrong: {wrong}",
            "",
        ]
    (folder / "gallery.md").write_text("\n".join(page), encoding="utf-8")


if __name__ == "__main__":
    main()
