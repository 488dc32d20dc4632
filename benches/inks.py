"""How near drawings of several inks come to their photos: `python benches/inks.py FOLDER...`, of photos .jpg.

For several sets of inks, photos are drawn, posterized to the same inks and the paper (every pixel the nearest, in RGB and in OKLab,
whichever serves the posterized photo better), and compared with the photos:

- colour: the mean of CIEDE2000 after a Gaussian blur of 3 px of both, as the default draws and of the posterized photo, and their
  ratio, which is to be at most .6;
- plain: the same of a drawing without emphasis (`sharpen=0, local_contrast=0`), where inks and paper can mix the blurred photo's
  colour, in all nine-pixel steps; to be at most 3;
- FLIP in colour at 67 pixels a degree, FLIP's own default, of the drawing and of vtracer's tracing of the posterized photo with all
  its specks, at equal coordinates: ours has as many nodes as that takes. The ratio is to be below 1.

Blurs are of sRGB-encoded values, which is how inks mix by default; `--linear` draws and blurs in linear light. Greys (`levels`) are
compared with the photo's grey. `--extra` adds scikit-image's colour photos, `--sets` names those that are drawn, `--every 4` takes
every fourth photo. Needs what `benches/evaluation` needs, and vtracer.

Without a folder it times six inks instead: the astronaut, enlarged to a megapixel, in 300,000 nodes, in turn with black and white;
the ratio of the medians is to be at most 2.
"""

from __future__ import annotations

import argparse
import io
import re
import statistics
import sys
import tempfile
import time
from concurrent.futures import ProcessPoolExecutor
from functools import partial
from itertools import product
from pathlib import Path

import flip_evaluator
import numpy as np
import numpy.typing as npt
import resvg_py
import vtracer
from PIL import Image
from scipy.ndimage import gaussian_filter
from scipy.optimize import nnls
from skimage import data
from skimage.color import deltaE_ciede2000, rgb2lab

import graphstipple as gs

sys.path.append(str(Path(__file__).parent / "evaluation"))

from graphstipple_eval.baselines.programs import count_coordinates

Picture = npt.NDArray[np.float64]

SETS: dict[str, dict[str, object]] = {
    "three": {"inks": "#1d1d1b,#ff48b0,#0078bf", "paper": "#f4efe2"},
    "extracted": {"extract_inks": 5},
    "greys": {"levels": 4},
    "cmyk": {"inks": "#00aeef,#ec008c,#fff200,#1d1d1b", "overprint": True},
    "six": {"inks": "#1d1d1b,#d7263d,#f2a900,#2e8b57,#1b4f9c,#7a4b2b"},
}
EXTRA = ("astronaut", "chelsea", "coffee", "camera", "rocket")

RUNS = 7
"""How often each is timed."""

MAGNIFICATION = 4
"""How much larger than the photo resvg paints: its polygons are coarse."""

STEP = 3
"""Pixels between those that are asked whether inks can mix their colour: a blur of 3 px leaves nothing in between."""

OUTSIDE = 0.01
"""How far in RGB the nearest mixture may be from a colour that inks can mix."""


def light(encoded: Picture) -> Picture:
    """Return sRGB's linear light."""
    return np.where(encoded <= 0.04045, encoded / 12.92, ((encoded + 0.055) / 1.055) ** 2.4)


def encoded(light: Picture) -> Picture:
    """Return linear light, sRGB-encoded."""
    light = np.clip(light, 0, 1)
    return np.where(light <= 0.0031308, 12.92 * light, 1.055 * light ** (1 / 2.4) - 0.055)


def oklab(rgb: Picture) -> Picture:
    """Return colours in OKLab."""
    to_cones = [[0.4122214708, 0.5363325363, 0.0514459929], [0.2119034982, 0.6806995451, 0.1073969566]]
    to_cones.append([0.0883024619, 0.2817188376, 0.6299787005])
    to_lab = [[0.2104542553, 0.7936177850, -0.0040720468], [1.9779984951, -2.4285922050, 0.4505937099]]
    to_lab.append([0.0259040371, 0.7827717662, -0.8086757660])
    return np.cbrt(light(rgb) @ np.array(to_cones).T) @ np.array(to_lab).T


def raster(drawing: gs.Drawing) -> Picture:
    """Return a drawing's pixels."""
    with tempfile.TemporaryDirectory() as folder:
        drawing.save(Path(folder, "drawing.png"))
        return np.asarray(Image.open(Path(folder, "drawing.png")).convert("RGB")) / 255.0


def colours(drawing: gs.Drawing, paper: str, overprint: bool) -> Picture:
    """Return the colours of the labels: the inks, or all sets of them over each other, and the paper."""

    def of(text: str) -> Picture:
        return np.frombuffer(bytes.fromhex(text.removeprefix("#")), np.uint8) / 255.0

    inks, bare = [of(ink) for ink in drawing.inks.values()], of(paper)
    if not overprint:
        return np.array([*inks, bare])
    ratios = [light(ink) / light(bare) for ink in inks]
    sets = product((False, True), repeat=len(inks))
    laid = [np.prod([ratio for ratio, is_laid in zip(ratios, laid, strict=True) if is_laid] or [np.ones(3)], 0) for laid in sets]
    return np.rint(255 * encoded(light(bare) * np.array(laid))) / 255


def posterized(photo: Picture, colours: Picture) -> list[Picture]:
    """Return the photo with every pixel's nearest colour: in RGB, and in OKLab."""
    found = []
    for space in (np.asarray, oklab):
        pixels, labels = space(photo).reshape(-1, 3), space(colours)
        found.append(colours[np.argmin([((pixels - label) ** 2).sum(1) for label in labels], 0)].reshape(photo.shape))
    return found


def traced(picture: Picture) -> tuple[Picture, int]:
    """Return vtracer's tracing of a posterized photo, and its coordinates."""
    height, width, _ = picture.shape
    file = io.BytesIO()
    Image.fromarray(np.rint(255 * picture).astype(np.uint8)).save(file, "PNG")
    svg = vtracer.convert_raw_image_to_svg(
        file.getvalue(), img_format="png", filter_speckle=0, color_precision=8, layer_difference=0
    )
    size = {"width": width * MAGNIFICATION, "height": height * MAGNIFICATION}
    painted = Image.open(io.BytesIO(bytes(resvg_py.svg_to_bytes(svg_string=svg, **size, background="#ffffff")))).convert("RGB")
    samples = np.asarray(painted).reshape(height, MAGNIFICATION, width, MAGNIFICATION, 3)
    return samples.mean((1, 3)) / 255.0, sum(map(count_coordinates, re.findall(r'<path[^>]* d="([^"]*)"', svg)))


def drawn_at(coordinates: int, photo: npt.NDArray[np.uint8], options: gs.Options, drawing: gs.Drawing) -> gs.Drawing:
    """Return a drawing of about so many coordinates, at most 3 % more: from the one of these options on, by its nodes."""
    for _ in range(8):
        ratio = coordinates / drawing.stats["coordinates"]
        if 0.97 <= ratio <= 1.03:
            break
        nodes = max(3, round(drawing.stats["nodes"] * ratio))
        drawing = gs.draw(photo, options=options.replace(nodes=nodes))
    return drawing


def flip(photo: Picture, picture: Picture) -> float:
    """Return the mean of FLIP."""
    options = {"inputsRGB": True, "applyMagma": False, "computeMeanError": False}
    errors, _, _ = flip_evaluator.evaluate(photo.astype(np.float32), picture.astype(np.float32), "LDR", **options)
    return float(np.mean(errors, dtype=np.float64))


def can_be_mixed(pixels: Picture, colours: Picture) -> npt.NDArray[np.bool_]:
    """Return which pixels lie among mixtures of colours."""
    system = np.vstack([colours.T, np.full(len(colours), 100.0)])
    return np.array([nnls(system, np.append(pixel, 100.0))[1] <= OUTSIDE for pixel in pixels])


def measured(work: tuple[str, npt.NDArray[np.uint8]], name: str, linear: bool) -> tuple[str, list[float]]:
    """Return a photo's name and its figures: colour errors of drawing, posterized photo and plain drawing, and FLIP of both."""
    title, pixels = work
    given = SETS[name]
    options = gs.Options(**given, linear=linear, threads=1)
    if "levels" in given:
        pixels = np.repeat(np.asarray(Image.fromarray(pixels).convert("L"))[:, :, np.newaxis], 3, 2)
    photo = pixels / 255.0
    of_light, to_light = (encoded, light) if linear else (np.asarray, np.asarray)

    def blurred(picture: Picture) -> Picture:
        return of_light(gaussian_filter(to_light(picture), (3, 3, 0)))

    target = rgb2lab(blurred(photo))

    def error(picture: Picture) -> Picture:
        return deltaE_ciede2000(target, rgb2lab(blurred(picture)))

    drawing = gs.draw(pixels, options=options)
    labels = colours(drawing, str(given.get("paper", "#ffffff")), bool(given.get("overprint", False)))
    flat = posterized(photo, labels)
    plain = raster(gs.draw(pixels, options=options.replace(sharpen=0, local_contrast=0)))
    steps = (slice(None, None, STEP),) * 2
    inside = can_be_mixed(to_light(blurred(photo)[steps]).reshape(-1, 3), to_light(labels))
    off = error(plain)[steps].ravel()[inside]
    theirs, coordinates = min((traced(picture) for picture in flat), key=lambda found: flip(photo, found[0]))
    ours = drawn_at(coordinates, pixels, options, drawing)
    return title, [
        float(error(raster(drawing)).mean()),
        min(float(error(picture).mean()) for picture in flat),
        float(off.mean()) if off.size else float("nan"),
        flip(photo, raster(ours)),
        flip(photo, theirs),
    ]


def timed() -> None:
    """Print how long six inks take, by how long black and white takes."""
    photo = np.asarray(Image.fromarray(data.astronaut()).resize((1000, 1000), Image.Resampling.BICUBIC))
    plain = gs.Options(nodes=300_000)
    seconds: dict[str, list[float]] = {"black and white": [], "six inks": []}
    for _ in range(RUNS):
        for name, options in (("black and white", plain), ("six inks", plain.replace(inks=SETS["six"]["inks"]))):
            begin = time.perf_counter()
            gs.draw(photo, options=options)
            seconds[name].append(time.perf_counter() - begin)
    plain_median, inks_median = (statistics.median(values) for values in seconds.values())
    for name, values in seconds.items():
        print(f"{name:16}", *(f"{value:.2f}" for value in values), "s")
    print(f"six inks / black and white: {inks_median / plain_median:.2f}, <= 2")


def report(name: str, found: list[tuple[str, list[float]]]) -> None:
    """Print the means over the photos, the worst of each and how many reach what is to be reached."""
    titles, (colour, poster, plain, ours, theirs) = [title for title, _ in found], np.array([row for _, row in found]).T
    print(f"{name}: {len(found)} photos")
    for what, of, values, limit in (
        ("colour", f"{colour.mean():.2f} / {poster.mean():.2f} = ", colour / poster, 0.6),
        ("plain", "", plain, 3.0),
        ("FLIP", f"{ours.mean():.3f} / {theirs.mean():.3f} = ", ours / theirs, 1.0),
    ):
        reached, counted = np.count_nonzero(values <= limit), np.count_nonzero(~np.isnan(values))
        worst = int(np.nanargmax(values))
        mean = f"{of}{np.nanmean(values):.3f}"
        print(f"  {what:7}{mean:24} worst {values[worst]:.3f} ({titles[worst]}), <= {limit}: {reached} of {counted}", flush=True)


def main() -> None:
    """Print the figures of every set of inks."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("folders", nargs="*", type=Path)
    parser.add_argument("--sets", default=",".join(SETS))
    parser.add_argument("--every", type=int, default=1)
    parser.add_argument("--extra", action="store_true")
    parser.add_argument("--linear", action="store_true")
    parser.add_argument("--all", action="store_true", help="a line a photo too")
    arguments = parser.parse_args()
    if not arguments.folders and not arguments.extra:
        timed()
        return
    paths = {path.stem: path for folder in arguments.folders for path in sorted(folder.glob("*.jpg"))}
    photos = [(stem, np.asarray(Image.open(path).convert("RGB"))) for stem, path in sorted(paths.items())[:: arguments.every]]
    if arguments.extra:
        photos += [(name, np.asarray(Image.fromarray(getattr(data, name)()).convert("RGB"))) for name in EXTRA]
    with ProcessPoolExecutor() as pool:
        for name in arguments.sets.split(","):
            found = list(pool.map(partial(measured, name=name, linear=arguments.linear), photos))
            if arguments.all:
                for title, row in found:
                    print(f"    {title:12}", *(f"{value:8.3f}" for value in row))
            report(name, found)


if __name__ == "__main__":
    main()
