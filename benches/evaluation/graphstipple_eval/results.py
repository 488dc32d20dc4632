"""Results on disk: of every picture its PNG, its SVG where there is one, and a JSON file with all that is known of it.

The files of a picture are named after its method and its key, a checksum of all that it depends on. So a result that is found
under its key need not be computed again, and a change of the code or of the settings never meets an old result. The JSON file is
written last: where it stands, the picture is whole.
"""

from __future__ import annotations

import dataclasses
import importlib.metadata
import json
from dataclasses import dataclass
from pathlib import Path

import graphstipple as gs
import graphstipple_eval
from graphstipple_eval import files
from graphstipple_eval.baselines import programs

KEY_LENGTH = 16
"""Hexadecimal digits of a key: 64 bits, so that no two pictures meet by chance, in names that can still be read."""

NOT_METHODS = ("__main__.py", "ablation.py", "cli.py", "cross_validation.py", "plots.py", "quoted.py", "report.py", "tables.py")
"""Modules of the evaluation that cannot change a picture or its metrics."""

PACKAGES = ("flip-evaluator", "numpy", "opencv-contrib-python-headless", "pillow", "resvg-py", "scikit-image", "scipy")
"""Packages that pictures and metrics may depend on."""


@dataclass(frozen=True)
class Result:
    """A picture that a method made, and what was measured.

    Parameters
    ----------
    key : str
        Checksum of all that the result depends on.
    photo, checksum : str
        Name of the photo and SHA-256 of its file.
    size, width, height : int
        The size asked for and the picture's own, in pixels.
    method : str
        Name of the method, or `OPTION=VALUE` of a sweep.
    dots : int, optional
        The count that the method was asked for; None for methods that have no such number.
    settings : dict
        Options, seeds and the like, as the method tells them.
    versions : dict
        Versions of the packages and programs, as `versions` gives them.
    code : str
        The `fingerprint` of the code.
    files : dict
        SHA-256 of the picture's files, by their place in the report's folder: the PNG, and the SVG where there is one.
    seconds : float
        Wall time of drawing.
    svg_bytes : int, optional
        Size of the SVG.
    counts : dict
        What the picture is made of (`method.Counts`).
    metrics : dict
        The metrics of `graphstipple.metrics.Comparison` and of `flip.Flip`.
    labyrinth : dict
        The numbers of `labyrinth.measures`; empty for methods without a graph.
    evenness : dict
        The numbers of `evenness.measures`; empty for methods without dots, and where there are too few.
    """

    key: str
    photo: str
    checksum: str
    size: int
    width: int
    height: int
    method: str
    dots: int | None
    settings: dict[str, object]
    versions: dict[str, str]
    code: str
    files: dict[str, str]
    seconds: float
    svg_bytes: int | None
    counts: dict[str, int | None]
    metrics: dict[str, float]
    labyrinth: dict[str, float]
    evenness: dict[str, float]

    def json(self) -> dict[str, object]:
        """Return it as JSON values; an infinite metric (the PSNR of equal pictures) becomes the text "inf"."""
        values = dataclasses.asdict(self)
        values["metrics"] = {name: "inf" if value == float("inf") else value for name, value in self.metrics.items()}
        return values

    @classmethod
    def of_json(cls, values: dict[str, object]) -> Result:
        """Return the result that `json` made these values of."""
        result = cls(**values)  # type: ignore[arg-type]  # what `json` wrote
        return dataclasses.replace(result, metrics={name: float(value) for name, value in result.metrics.items()})

    @property
    def png(self) -> str:
        """The PNG's place in the report's folder."""
        return next(name for name in self.files if name.endswith(".png"))

    @property
    def svg(self) -> str | None:
        """The SVG's place in the report's folder, if there is one."""
        return next((name for name in self.files if name.endswith(".svg")), None)

    def numbers(self) -> dict[str, float | None]:
        """Return everything that tables show, by name: metrics, counts, labyrinth, evenness, seconds, bytes."""
        own = {"seconds": self.seconds, "svg_bytes": self.svg_bytes}
        return {**self.metrics, **self.counts, **self.labyrinth, **self.evenness, **own}


@dataclass(frozen=True)
class Failure:
    """A picture that a method could not make."""

    photo: str
    size: int
    method: str
    reason: str


def versions() -> dict[str, str]:
    """Return the versions of graphstipple, of the evaluation, of `PACKAGES` and of the programs, as far as they are installed."""
    return {**_package_versions(), **programs.versions()}


def _package_versions() -> dict[str, str]:
    found = {"graphstipple": gs.__version__, "graphstipple-eval": graphstipple_eval.__version__}
    for name in PACKAGES:
        try:
            found[name] = importlib.metadata.version(name)
        except importlib.metadata.PackageNotFoundError:
            continue
    return found


def fingerprint() -> str:
    """Return a checksum of the code that makes pictures and measures them: both packages, the compiled core, versions.

    The versions of programs are not in it: each is in the keys of its own pictures alone.
    """
    package, evaluation = Path(gs.__file__).parent, Path(graphstipple_eval.__file__).parent
    paths = [path for path in package.rglob("*") if path.suffix in {".py", ".so", ".pyd"}]
    paths += [path for path in evaluation.rglob("*.py") if path.relative_to(evaluation).as_posix() not in NOT_METHODS]
    sums = [files.checksum(path.read_bytes()) for path in sorted(paths)]
    return files.checksum(json.dumps([sums, _package_versions()]).encode())


def key(*parts: str | int | None) -> str:
    """Return the key of a result that depends on these parts."""
    return files.checksum(json.dumps(parts).encode())[:KEY_LENGTH]


def save(result: Result, path: Path) -> None:
    """Write a result's JSON file."""
    files.write(path, (json.dumps(result.json(), indent=1) + "\n").encode())


def load(path: Path, root: Path) -> Result | None:
    """Read a result's JSON file; None if there is none or if one of the picture's files is not as it was written.

    Parameters
    ----------
    path : Path
        The JSON file.
    root : Path
        The report's folder, in which the picture's files have their places.
    """
    try:
        result = Result.of_json(json.loads(path.read_bytes()))
        intact = all(files.checksum((root / name).read_bytes()) == sum_ for name, sum_ in result.files.items())
    except (FileNotFoundError, ValueError, TypeError):
        return None
    return result if intact else None
