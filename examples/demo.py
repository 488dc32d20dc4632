"""Draw scikit-image's astronaut (a NASA portrait, public domain): ``python examples/demo.py [FOLDER]``."""

import json
import sys
from pathlib import Path

from PIL import Image
from skimage import data

import graphstipple as gs

folder = Path(sys.argv[1] if len(sys.argv) > 1 else "out")
folder.mkdir(parents=True, exist_ok=True)
photo = folder / "astronaut.png"
Image.fromarray(data.astronaut()).save(photo)

drawing = gs.draw(photo)
drawing.save(folder / "astronaut.svg")
drawing.save(folder / "astronaut-drawn.png", width=2 * drawing.width)

print(json.dumps(drawing.stats, indent=2))
print("written:", ", ".join(str(folder / name) for name in ("astronaut.svg", "astronaut-drawn.png")))
