"""Sizes of our SVG and of potrace's, which traces our own picture at four times the size: `python benches/potrace.py`.

Needs the program potrace (Debian and Homebrew: potrace) and scikit-image, which has the photos. Potrace runs with its
defaults.
"""

import subprocess
import sys
from pathlib import Path
from tempfile import TemporaryDirectory

import skimage.data
from PIL import Image

import graphstipple as gs

PHOTOS = ("astronaut", "camera", "chelsea", "coffee", "rocket")


def main() -> None:
    """Print one row a photo."""
    print(f"{'photo':<12}{'ours':>10}{'potrace':>10}{'ours / potrace':>16}")
    for name in PHOTOS:
        drawing = gs.draw(getattr(skimage.data, name)())
        with TemporaryDirectory() as folder:
            bitmap, traced = Path(folder, "picture.pbm"), Path(folder, "traced.svg")
            Image.fromarray(drawing.rasterize(4 * drawing.width) >= 128).save(bitmap)
            try:
                subprocess.run(["potrace", "--svg", "--output", traced, bitmap], check=True)
            except FileNotFoundError:
                sys.exit("potrace is not installed")
            ours, potrace = len(drawing.svg()), traced.stat().st_size
        print(f"{name:<12}{ours:>10}{potrace:>10}{ours / potrace:>16.2f}")


if __name__ == "__main__":
    main()
