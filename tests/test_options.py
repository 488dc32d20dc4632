"""Options: the same in Python and in Rust, checked where they are made."""

import dataclasses
import json
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import graphstipple as gs
from graphstipple import _core


def known_to_rust(options: gs.Options) -> dict[str, Any]:
    values = dataclasses.asdict(options)
    del values["threads"]  # not part of the metadata
    return values


def test_defaults_are_rusts() -> None:
    assert known_to_rust(gs.Options()) == json.loads(_core.default_options())
    assert list(known_to_rust(gs.Options())) == list(json.loads(_core.default_options()))


def test_paper_is_rusts_and_changes_apply() -> None:
    assert known_to_rust(gs.Options.paper()) == json.loads(_core.preset_options("paper"))
    ours = {
        "detail": 0,
        "floor": 0,
        "midtones": 0,
        "sharpen": 0,
        "local_contrast": 0,
        "refine": 0,
        "tone_tolerance": None,
        "split": 0,
        "crossings": "midpoint",
    }
    diffusion = {"base": 0.5, "importance_alpha": "dynamic", "alpha": "dynamic", "carry": "value"}
    diffusion |= {"importance_order": "global", "order": "global"}
    expected = gs.Options(density=0.5, relax=2, tolerance=0, **ours, **diffusion)  # type: ignore[arg-type]
    assert gs.Options.paper(relax=2, density=0.5) == expected


def test_presets_are_options_by_name() -> None:
    names = [preset.name for preset in gs.presets()]
    assert names[:2] == ["default", "paper"]
    assert len(set(names)) == len(names) >= 6
    options = [gs.Options.preset(name) for name in names]
    assert options[0] == gs.Options()
    assert options[1] == gs.Options.paper()
    assert len(set(options)) == len(options)
    assert gs.Options.preset("linocut", relax=4) == gs.Options.preset("linocut").replace(relax=4)
    assert {preset.name: preset.inks for preset in gs.presets()}["scratchboard"] == "white"
    with pytest.raises(gs.InvalidInputError, match="preset is lino, but it must be default, paper, "):
        gs.Options.preset("lino")


def test_the_gallery_shows_every_preset() -> None:
    page = (Path(__file__).resolve().parent.parent / "docs" / "gallery.md").read_text(encoding="utf-8").lower()
    for preset in gs.presets():
        assert f"### {preset.name}\n\n{preset.description.lower()}.\n" in page


def test_options_are_frozen_hashable_and_replaceable() -> None:
    options = gs.Options(density=1)
    with pytest.raises(dataclasses.FrozenInstanceError):
        options.density = 2.0  # type: ignore[misc]
    assert options == gs.Options(density=1.0)
    assert hash(options) == hash(gs.Options(density=1.0))
    assert options.replace(relax=0) == gs.Options(density=1.0, relax=0)


def test_numpy_scalars_are_numbers() -> None:
    assert gs.Options(density=np.float32(0.5), relax=np.int64(2), invert=np.True_) == gs.Options(density=0.5, relax=2, invert=True)


@pytest.mark.parametrize(
    ("changes", "message"),
    [
        ({"density": 0}, "density is 0, but it must be above 0 and at most 16"),
        ({"density": "fine"}, 'density is "fine", but it must be a number'),
        ({"density": float("nan")}, "density is nan"),
        ({"density": np.float32("inf")}, "density is inf"),
        ({"nodes": 2}, "nodes is 2, but it must be between 3"),
        ({"nodes": 100, "nodes_per_pixel": 0.1}, "nodes_per_pixel is 0.1, but it must be left out"),
        ({"relax": -1}, "relax is -1"),
        ({"relax": 1.5}, "relax is 1.5, but it must be a whole number"),
        ({"rings": 0}, "rings is 0, but it must be between 1 and 16"),
        ({"alpha": 1.5}, "alpha is 1.5"),
        ({"alpha": "static"}, 'alpha is "static", but it must be "tonal", "dynamic" or a number'),
        ({"importance_alpha": -0.1}, "importance_alpha is -0.1"),
        ({"order": "random"}, 'order is "random", but it must be "rows" or "global"'),
        ({"carry": "all"}, 'carry is "all", but it must be "value" or "area"'),
        ({"crossings": "edge"}, 'crossings is "edge", but it must be "midpoint" or "tone"'),
        ({"split": 13}, "split is 13, but it must be between 0 and 12 nodes"),
        ({"refine": 101}, "refine is 101, but it must be between 0 and 100 sweeps"),
        ({"crispness": -1}, "crispness is -1, but it must be between 0 and 100"),
        ({"cohesion": 101}, "cohesion is 101, but it must be between 0 and 100"),
        ({"tone_tolerance": -0.1}, "tone_tolerance is -0.1, but it must be between 0 and 1"),
        ({"fineness": 0}, "fineness is 0, but it must be above 0 and at most 16"),
        ({"detail": 1.5}, "detail is 1.5, but it must be between 0 and 1"),
        ({"sharpen": 101}, "sharpen is 101, but it must be between 0 and 100"),
        ({"lattice": "triangular"}, "must be `hexagonal` or `square`"),
        ({"stipple_scale": 5}, "stipple_scale is 5"),
        ({"stipple_min": -1}, "stipple_min is -1, but it must be between 0 and 1000 pixels"),
        ({"stipple_max": 0}, "stipple_max is 0, but it must be above 0 and at most 1000 pixels"),
        ({"stipple_min": 2, "stipple_max": 1.5}, "stipple_max is 1.5, but it must be at least stipple_min"),
        ({"irregularity": 1.5}, "irregularity is 1.5, but it must be between 0 and 1"),
        ({"seed": 2**53 + 1}, "seed is 9007199254740993, but it must be between 0 and 9007199254740992"),
        ({"seed": 0.5}, "seed is 0.5, but it must be a whole number"),
        ({"linear": 1}, "linear is 1, but it must be True or False"),
        ({"tolerance": -0.1}, "tolerance is -0.1, but it must be between 0 and 2"),
        ({"tolerance": 2.5}, "tolerance is 2.5"),
        ({"tolerance": "fine"}, 'tolerance is "fine", but it must be a number'),
        ({"gamma": 0}, "gamma is 0"),
        ({"contrast": 11}, "contrast is 11"),
        ({"invert": "yes"}, "invert is"),
        ({"threads": 0}, "threads is 0"),
        ({"background": "red"}, "background is .*red"),
        ({"background": "#12345"}, "background"),
        ({"background": "#+12345"}, "background"),
        ({"k1": object()}, "a type that no option has"),
    ],
)
def test_wrong_values_are_named(changes: dict[str, Any], message: str) -> None:
    with pytest.raises(gs.InvalidInputError, match=message):
        gs.Options(**changes)


def test_unknown_names_are_type_errors() -> None:
    with pytest.raises(TypeError, match="densty"):
        gs.Options(densty=1)  # type: ignore[call-arg]
