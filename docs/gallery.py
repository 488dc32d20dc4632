"""Make the gallery: ``python docs/gallery.py`` writes docs/gallery.md and its pictures in docs/images.

The photos are those that scikit-image's wheel holds (public domain), at most 512 pixels wide and high.
"""

import sys
from pathlib import Path

import numpy as np
from pictures import FACE, write
from PIL import Image
from skimage import data

import graphstipple as gs

FOLDER = Path(__file__).resolve().parent

SIDE = 512
"""Pixels of the longer side of a photo."""

PRESET_PHOTOS = {"astronaut": (96, 20, 356, 280), "chelsea": (90, 30, 350, 290)}
"""Which part of which photo shows the presets, in pixels: left, top, right, bottom."""

SMALL = 160
"""Pixels of the side of a small picture of a preset, in the strip that the README shows."""

NOTES = {
    "astronaut": (
        "the face and the wall have their tones; hair, flag, badges and the folds of the suit can be read, edges are clean.",
        "a white seam, as wide as the emphasis reaches, stands between the head and the dots of the wall.",
    ),
    "camera": (
        "face, camera, tripod and buildings are sharp; the sky is grey and no longer bare, and the coat has folds.",
        "the far half of the lawn has the texture of its nodes, dots and short strokes, and not of grass.",
    ),
    "chelsea": (
        "eyes, whiskers and the run of the fur; the soft background is quiet, where it was a labyrinth with holes.",
        "a line runs through soft middle grey, where dots change from black on white to white on black.",
    ),
    "coffee": (
        "cup and saucer are round by their shades, the coffee is smooth, and the table is wood.",
        "the grain of the table's light end is dotted rather than drawn.",
    ),
    "rocket": (
        "the evening sky goes from light to dark without an end of dots or a black hole, and the towers stand before it.",
        "thin girders break into pieces, and the far ones go under in the dots.",
    ),
}
"""What is better than without stippling and under the paper's settings, and what is still wrong."""


def photo(name: str) -> np.ndarray:
    """Return a photo as luma in 8 bits."""
    image = Image.fromarray(getattr(data, name)()).convert("L")
    image.thumbnail((SIDE, SIDE), Image.Resampling.LANCZOS)
    return np.asarray(image)


def raster(drawing: gs.Drawing) -> Image.Image:
    """Return a drawing at the size of its photo."""
    return Image.fromarray(drawing.rasterize())


def face(drawing: gs.Drawing) -> Image.Image:
    """Return the portrait's face, small."""
    scale = SMALL / (FACE[2] - FACE[0])
    left, top, right, bottom = (round(scale * side) for side in FACE)
    return Image.fromarray(drawing.rasterize(width=round(scale * drawing.width))[top:bottom, left:right])


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
    small = []
    for preset in gs.presets():
        options = gs.Options.preset(preset.name)
        panels = []
        for name, part in PRESET_PHOTOS.items():
            drawing = gs.draw(photo(name), options=options)
            if not panels:
                small.append(face(drawing))
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
    write(images / "presets.png", small, greys=16)
    page += [
        "## The default and the paper's settings",
        "",
        "Left the preset `paper` with the default's node budget, in the middle the default with `stippling` 0, right the",
        "default: the same number of nodes, a pixel of the picture for each of the photo's. [evaluation.md](evaluation.md) says",
        "how they are measured against each other.",
        "",
    ]
    for name, (better, wrong) in NOTES.items():
        image = photo(name)
        nodes = round(0.3 * image.size)
        settings = (gs.Options.preset("paper", nodes=nodes), gs.Options(nodes=nodes, stippling=0), gs.Options(nodes=nodes))
        drawings = [gs.draw(image, options=options) for options in settings]
        write(images / f"compare-{name}.png", [raster(drawing) for drawing in drawings], greys=8)
        counts = ", ".join(f"{drawing.stats['vertices']:,}" for drawing in drawings)
        page += [
            f"### {name}",
            "",
            f"![{name}: the paper's settings, the default without stippling, the default](images/compare-{name}.png)",
            "",
            f"*{counts} vertices.*",
            "",
            f"Better: {better}",
            "",
            f"Still wrong: {wrong}",
            "",
        ]
    (folder / "gallery.md").write_text("\n".join(page), encoding="utf-8")


if __name__ == "__main__":
    main()
