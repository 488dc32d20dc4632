"""Options: the same in Python and in Rust, declared in one place, checked where they are made, kept in files."""

import ast
import copy
import dataclasses
import inspect
import io
import json
import pickle
import re
import subprocess
import tokenize
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from tests.support import PUBLISHED, ROOT, options_with

import graphstipple as gs
from graphstipple import _core

SCHEMA = _core.options_schema()["properties"]
PUBLISHED_SCHEMA = SCHEMA["published"]["properties"]
NAMES = [name for name in SCHEMA if name != "published"]


def test_fields_and_defaults_are_rusts() -> None:
    declared = {name: SCHEMA[name]["default"] for name in NAMES}
    ours, papers = ({name: it[key] for name, it in PUBLISHED_SCHEMA.items()} for key in ("default", "x-paper"))
    assert dataclasses.asdict(gs.Options()) == {**declared, "published": ours}
    assert list(dataclasses.asdict(gs.Options())) == [*declared, "published"]
    assert dataclasses.asdict(gs.Published()) == papers
    assert list(dataclasses.asdict(gs.Published())) == list(papers) == list(PUBLISHED)
    assert dataclasses.asdict(gs.Options()) == _core.preset("default").values()
    assert len(NAMES) > 20
    assert len(PUBLISHED) > 10
    # A name means one thing.
    assert not set(NAMES) & set(PUBLISHED)


def test_paper_is_rusts_and_changes_apply() -> None:
    assert dataclasses.asdict(gs.Options.preset("paper")) == _core.preset("paper").values()
    assert gs.Options.preset("paper").published == gs.Published()
    ours = {"detail": 0, "floor": 0, "midtones": 0, "sharpen": 0, "local_contrast": 0}
    ours |= {"stippling": 0, "refine": 0, "tone_tolerance": None, "split": 0}
    method = {"importance_alpha": "dynamic", "alpha": "dynamic", "error_weighting": "value", "crossings": "midpoint"}
    method |= {"importance_order": "global", "order": "global"}
    published = gs.Options().published.replace(density=0.5, **method)
    expected = gs.Options(relax=2, tolerance=0, published=published, **ours)  # type: ignore[arg-type]
    assert (
        gs.Options.preset("paper", relax=2, published=gs.Published(density=0.5))
        == expected
        == options_with("paper", relax=2, density=0.5)
    )


def test_presets_are_options_by_name() -> None:
    names = [preset.name for preset in gs.presets()]
    assert names[:2] == ["default", "paper"]
    assert len(set(names)) == len(names) >= 6
    options = [gs.Options.preset(name) for name in names]
    assert options[0] == gs.Options()
    assert options[1] == gs.Options.preset("paper")
    assert len(set(options)) == len(options)
    assert gs.Options.preset("linocut", relax=4) == gs.Options.preset("linocut").replace(relax=4)
    assert {preset.name: preset.only for preset in gs.presets()}["scratchboard"] == "white"
    with pytest.raises(gs.InvalidInputError, match="preset is lino, but it must be default, paper, "):
        gs.Options.preset("lino")


def test_the_gallery_shows_every_preset() -> None:
    page = (Path(__file__).resolve().parent.parent / "docs" / "gallery.md").read_text(encoding="utf-8").lower()
    for preset in gs.presets():
        assert f"### {preset.name}\n\n{preset.description.lower()}.\n" in page


def test_options_are_frozen_hashable_and_replaceable() -> None:
    options = gs.Options(gamma=1, published=gs.Published(density=2))
    with pytest.raises(dataclasses.FrozenInstanceError):
        options.gamma = 2.0  # type: ignore[misc]
    with pytest.raises(dataclasses.FrozenInstanceError):
        options.published.density = 1.0  # type: ignore[misc]
    same = gs.Options(gamma=1.0, published=gs.Published(density=2.0))
    assert options == same
    assert hash(options) == hash(same)
    assert options != same.replace(published=gs.Published(density=3))
    assert options.replace(relax=0) == gs.Options(relax=0, published=gs.Published(density=2))
    assert options.published.replace(k1=2) == gs.Published(density=2, k1=2)
    assert gs.Options().published.replace(density=1).alpha == "tonal"


def pickled(it: Any) -> Any:
    return pickle.loads(pickle.dumps(it))


@pytest.mark.parametrize("again", [copy.copy, copy.deepcopy, pickled])
def test_options_survive_pickle_and_copies(again: Callable[[Any], Any], small: np.ndarray) -> None:
    options = gs.Options(nodes=900, seed=2**53, tone_tolerance=None, published=gs.Published(k1=3, alpha=0.5, lattice="square"))
    for it in (options, options.published, gs.Options(), gs.Published()):
        found = again(it)
        assert type(found) is type(it)
        assert found == it
        assert hash(found) == hash(it)
        assert repr(found) == repr(it)
    assert again(options).replace(relax=0) == options.replace(relax=0)
    assert gs.draw(small, options=again(options)).svg() == gs.draw(small, options=options).svg()
    with_published = options.replace(published=again(options.published))
    assert gs.draw(small, options=with_published).svg() == gs.draw(small, options=options).svg()


def test_numpy_scalars_are_numbers() -> None:
    options = gs.Options(gamma=np.float32(0.5), relax=np.int64(2), invert=np.True_, background=np.str_("black"))
    assert options == gs.Options(gamma=0.5, relax=2, invert=True, background="black")
    assert gs.Published(density=np.float32(0.5), hops=np.uint8(2)) == gs.Published(density=0.5, hops=2)
    assert type(options.gamma) is float


@pytest.mark.parametrize(
    ("changes", "message"),
    [
        ({"nodes": 2}, "nodes is 2, but it must be between 3"),
        ({"nodes": 100, "nodes_per_pixel": 0.1}, "nodes_per_pixel is 0.1, but it must be left out"),
        ({"relax": -1}, "relax is -1"),
        ({"relax": 101}, "relax is 101, but it must be between 0 and 100 steps"),
        ({"relax": 1.5}, "relax is 1.5, but it must be a whole number"),
        ({"split": 13}, "split is 13, but it must be between 0 and 12 nodes"),
        ({"refine": 101}, "refine is 101, but it must be between 0 and 100 sweeps"),
        ({"crispness": -1}, "crispness is -1, but it must be between 0 and 100"),
        ({"cohesion": 101}, "cohesion is 101, but it must be between 0 and 100"),
        ({"tone_tolerance": -0.1}, "tone_tolerance is -0.1, but it must be between 0 and 1"),
        ({"fineness": 0}, "fineness is 0, but it must be above 0 and at most 16"),
        ({"detail": 1.5}, "detail is 1.5, but it must be between 0 and 1"),
        ({"sharpen": 101}, "sharpen is 101, but it must be between 0 and 100"),
        ({"stipple_scale": 5}, "stipple_scale is 5"),
        ({"stipple_min": -1}, "stipple_min is -1, but it must be between 0 and 1000 pixels"),
        ({"stipple_max": 0}, "stipple_max is 0, but it must be above 0 and at most 1000 pixels"),
        ({"stipple_min": 2, "stipple_max": 1.5}, "stipple_max is 1.5, but it must be at least stipple_min"),
        ({"irregularity": 1.5}, "irregularity is 1.5, but it must be between 0 and 1"),
        ({"wobble": 1.5}, "wobble is 1.5, but it must be between 0 and 1"),
        ({"wobble": "much"}, 'wobble is "much", but it must be a number between 0 and 1'),
        ({"edge": "rough"}, 'edge is "rough", but it must be "smooth", "inked" or "torn"'),
        ({"seed": 2**53 + 1}, "seed is 9007199254740993, but it must be between 0 and 9007199254740992"),
        ({"seed": 0.5}, "seed is 0.5, but it must be a whole number"),
        ({"linear": 1}, "linear is 1, but it must be True or False"),
        ({"tolerance": -0.1}, "tolerance is -0.1, but it must be between 0 and 2"),
        ({"tolerance": 2.5}, "tolerance is 2.5"),
        ({"tolerance": "fine"}, 'tolerance is "fine", but it must be a number'),
        ({"shading": 1.5}, "shading is 1.5, but it must be between 0 and 1"),
        ({"gamma": 0}, "gamma is 0"),
        ({"gamma": float("nan")}, "gamma is NaN, but it must be between 0.1 and 10"),
        ({"gamma": object()}, "gamma is <object object .*>, but it must be a number between 0.1 and 10"),
        ({"contrast": 11}, "contrast is 11"),
        ({"invert": "yes"}, "invert is"),
        ({"threads": 0}, "threads is 0"),
        ({"background": "red"}, 'background is "red", but it must be white, black, #rrggbb or #rgb'),
        ({"background": "#12345"}, "background"),
        ({"background": "#+12345"}, "background"),
        ({"published": {"k1": 2}}, "published is {'k1': 2}, but it must be graphstipple.Published"),
    ],
)
def test_wrong_values_are_named(changes: dict[str, Any], message: str) -> None:
    with pytest.raises(gs.InvalidInputError, match=f"^{message}"):
        gs.Options(**changes)


@pytest.mark.parametrize(
    ("changes", "message"),
    [
        ({"density": 0}, "density is 0, but it must be above 0 and at most 16"),
        ({"density": "fine"}, 'density is "fine", but it must be None or a number above 0'),
        ({"density": float("nan")}, "density is NaN"),
        ({"density": np.float32("inf")}, "density is inf"),
        ({"alpha": 1.5}, "alpha is 1.5"),
        ({"alpha": "static"}, 'alpha is "static", but it must be "tonal", "dynamic" or a number'),
        ({"importance_alpha": -0.1}, "importance_alpha is -0.1"),
        ({"order": "random"}, 'order is "random", but it must be "rows" or "global"'),
        ({"crossings": "edge"}, 'crossings is "edge", but it must be "tone" or "midpoint"'),
        ({"lattice": "triangular"}, 'lattice is "triangular", but it must be "hexagonal" or "square"'),
        ({"k1": object()}, "k1 is <object object .*>, but it must be a number between 0 and 1000"),
        ({"hops": 0}, "hops is 0, but it must be between 1 and 16 hops"),
        ({"base": 2}, "base is 2, but it must be between 0 and 1"),
        ({"error_weighting": "all"}, 'error_weighting is "all", but it must be "area" or "value"'),
    ],
)
def test_wrong_values_of_the_published_method_are_named(changes: dict[str, Any], message: str) -> None:
    with pytest.raises(gs.InvalidInputError, match=f"^published.{message}"):
        gs.Published(**changes)


def test_unknown_names_are_type_errors() -> None:
    with pytest.raises(TypeError, match="densty"):
        gs.Published(densty=1)  # type: ignore[call-arg]
    # What is of the published method is not an option by itself.
    for name in ("k1", "rings", "carry", "base"):
        with pytest.raises(TypeError, match=name):
            gs.Options(**{name: 1})


# Options in files ----------------------------------------------------------------------------------------------------------------


@pytest.fixture(scope="module")
def made(small: np.ndarray) -> gs.Drawing:
    """Return a drawing whose options are not the default ones."""
    return gs.draw(small, options=gs.Options(gamma=1.2, published=gs.Published(k1=2)))


def text_of(drawing: gs.Drawing, suffix: str) -> str:
    return drawing.json() if suffix == "json" else drawing.svg()


def reloaded(drawing: gs.Drawing, suffix: str, folder: Path, *edits: tuple[str, str]) -> tuple[str, gs.Drawing]:
    """Return the edited text of a drawing's file, and the drawing that is read from it."""
    text = text_of(drawing, suffix)
    for old, new in edits:
        assert text.count(old) == 1
        text = text.replace(old, new)
    (folder / f"edited.{suffix}").write_text(text, encoding="utf-8")
    return text, gs.load(folder / f"edited.{suffix}")


in_both_files = pytest.mark.parametrize("suffix", ["json", "svg"])
NEWER = ('"version":"' + gs.__version__, '"version":"99.1')


@in_both_files
def test_options_that_are_known_come_back_as_options(made: gs.Drawing, suffix: str, tmp_path: Path, small: np.ndarray) -> None:
    text, loaded = reloaded(made, suffix, tmp_path, NEWER)
    assert type(loaded.options) is gs.Options
    assert loaded.options == made.options
    assert hash(loaded.options) == hash(made.options)
    assert loaded.version == "99.1"
    assert text_of(loaded, suffix) == text
    assert gs.draw(small, options=loaded.options).svg() == made.svg()


@in_both_files
@pytest.mark.parametrize(
    ("edit", "shown", "unknown"),
    [
        (('"gamma":1.2', '"gamma":1.2,"glitter":[0.5,{"of":null}]'), {"gamma": 1.2, "glitter": [0.5, {"of": None}]}, "glitter"),
        (('"gamma":1.2', '"rings":1,"carry":"area","gamma":1.2'), {"rings": 1, "carry": "area"}, "rings, carry"),
        (('"k1":2.0', '"k1":2.0,"k9":"x"'), {"gamma": 1.2}, "published.k9"),
    ],
    ids=["newer", "older", "published"],
)
def test_options_that_are_unknown_here_are_kept_as_data(  # noqa: PLR0917
    made: gs.Drawing, suffix: str, edit: tuple[str, str], shown: dict[str, object], unknown: str, tmp_path: Path, small: np.ndarray
) -> None:
    text, loaded = reloaded(made, suffix, tmp_path, NEWER, edit)
    recorded = loaded.options
    assert isinstance(recorded, gs.RecordedOptions)
    assert {name: recorded[name] for name in shown} == shown
    assert recorded["published"]["k1"] == 2
    assert dict(recorded) == json.loads(re.search(r'"options":(\{.*?\}\})', text).group(1))  # type: ignore[union-attr]
    assert len(recorded) == len(list(recorded))
    assert "densty" not in recorded
    with pytest.raises(KeyError):
        recorded["densty"]
    assert repr(recorded).startswith("RecordedOptions({'nodes': None, ")
    # The drawing is the same, and is written as it was.
    assert loaded.version == "99.1"
    assert np.array_equal(loaded.rasterize(), made.rasterize())
    loaded.save(tmp_path / f"again.{suffix}")
    assert (tmp_path / f"again.{suffix}").read_text(encoding="utf-8") == text
    assert text_of(loaded.with_min_dot(0), suffix) == text
    message = (
        f"the drawing was made by graphstipple 99.1 with options that this version, {gs.__version__}, does not know: {unknown}"
    )
    for draw in (gs.draw, lambda image, options: gs.Session(image).draw(options)):
        with pytest.raises(gs.InvalidInputError) as refused:
            draw(small, options=recorded)
        assert str(refused.value) == message


@in_both_files
@pytest.mark.parametrize("value", ["12.5", "true", '{"a":1}'])
def test_values_that_are_not_taken_here_are_kept_as_data(
    made: gs.Drawing, suffix: str, value: str, tmp_path: Path, small: np.ndarray
) -> None:
    text, loaded = reloaded(made, suffix, tmp_path, ('"gamma":1.2', f'"gamma":{value}'))
    assert isinstance(loaded.options, gs.RecordedOptions)
    assert loaded.options["gamma"] == json.loads(value)
    assert text_of(loaded, suffix) == text
    with pytest.raises(gs.InvalidInputError, match=r"in this version, \S+, gamma is .*, but it must be .*between 0.1 and 10$"):
        gs.draw(small, options=loaded.options)


@in_both_files
def test_options_that_a_file_does_not_have_are_ours(made: gs.Drawing, suffix: str, tmp_path: Path) -> None:
    _, loaded = reloaded(made, suffix, tmp_path, ('"gamma":1.2,', ""))
    assert loaded.options == made.options.replace(gamma=1.0)
    # As the core takes them: a parameter of the published method that an older file does not have is ours, not the paper's.
    _, loaded = reloaded(made, suffix, tmp_path, (',"crossings":"midpoint"', ""))
    assert loaded.options == made.options.replace(published=made.options.published.replace(crossings="tone"))


@in_both_files
def test_a_dotted_name_in_a_file_is_no_option(made: gs.Drawing, suffix: str, tmp_path: Path) -> None:
    _, loaded = reloaded(made, suffix, tmp_path, ('"gamma":1.2', '"gamma":1.2,"published.k1":3.0'))
    assert isinstance(loaded.options, gs.RecordedOptions)


# Declared once -------------------------------------------------------------------------------------------------------------------

FRONT_ENDS = ("rust/cli/src", "rust/py/src", "python/graphstipple")
"""What makes flags, fields, help and messages of the declarations, and so has no option by its name."""

STAGES = "python/graphstipple/stages.py"

BY_NAME = {
    ("nodes", "rust/cli/src/command.rs"): "in an example, and among the first options of the help",
    ("nodes", "rust/py/src/stages.rs"): "the nodes of a graph",
    **{
        ("nodes", file): "how many nodes a drawing came to have"
        for file in ("rust/cli/src/drawn.rs", "rust/py/src/drawing.rs", "rust/py/src/within.rs")
    },
    ("nodes", "rust/py/src/session.rs"): "the fewest that a session's photo may have to be read again for",
    **{
        ("threads", file): "how many work, which whoever starts the work has to know"
        for file in (
            "rust/cli/src/lib.rs",
            *(f"rust/py/src/{name}.rs" for name in ("drawing", "photo", "recipe", "session", "stages", "watch")),
            *(f"python/graphstipple/batches/{name}.py" for name in ("api", "command", "engines", "run")),
        )
    },
    **{
        ("nodes", file): "how many nodes a drawing may come to have"
        for file in ("python/graphstipple/_core.pyi", "python/graphstipple/studio/desk.py", "rust/py/src/options.rs")
    },
    ("base", "python/graphstipple/studio/guard.py"): "a word of a header",
    ("order", "python/graphstipple/drawing.py"): "in which a pen draws",
    ("edge", "python/graphstipple/metrics/_similarity.py"): "what is beyond the edge of a picture",
    **{("tolerance", file): "of areas that are moved" for file in ("python/graphstipple/_core.pyi", "rust/py/src/stages.rs")},
    ("threads", "python/graphstipple/studio/desk.py"): "a page may not have more work than there are processors",
    ("backdrop", "python/graphstipple/_draw.py"): "a shorthand beside the subject",
    ("backdrop", "python/graphstipple/studio/desk.py"): "left out of a page, which has no subject",
    ("backdrop", "rust/cli/src/arguments.rs"): "refused without a subject",
    ("extract_inks", "rust/cli/src/arguments.rs"): "known only when the photo has been read",
    ("overprint", "python/graphstipple/drawing.py"): "whether a drawing has it",
    ("fineness", "rust/cli/src/rules.rs"): "what whoever draws for a machine may turn, in a warning",
    ("detail", "rust/cli/src/command.rs"): "a word of the help of --importance",
    ("density", "rust/py/src/stages.rs"): "the density that a node budget gives; an argument of a stage",
    ("density", "python/graphstipple/_core.pyi"): "an argument of a stage",
    ("gamma", "python/graphstipple/_pillow.py"): "what a PNG says of its samples",
    ("gamma", "rust/py/src/photo.rs"): "what a PNG says of its samples",
    ("stippling", "rust/py/src/stages.rs"): "the only option that a stage asks for",
    **{
        (stage, file): "a stage of this name"
        for stage in ("relax", "refine", "split", "lattice")
        for file in ("python/graphstipple/_core.pyi", "rust/py/src/lib.rs", "rust/py/src/stages.rs")
    },
}
"""Names of options that stand in front ends all the same: where, and why."""

EVERYWHERE = {
    "background": "photos and maps are decoded onto it, before there is anything that options could be given to",
    "inks": "those that a drawing has come to have",
    "paper": "the colour of a page, for which the same flag stands",
}


def code(path: Path) -> str:
    """Return a source file without comments, documentation and tests."""
    text = path.read_text(encoding="utf-8")
    if path.suffix == ".rs":
        return re.sub(r"//.*", "", text.partition("#[cfg(test)]")[0])
    tokens = tokenize.generate_tokens(io.StringIO(text).readline)
    return "\n".join(it.string for it in tokens if it.type != tokenize.COMMENT and not it.string.startswith('"""'))


def has_word(text: str, name: str) -> bool:
    """Whether an option's name stands in code, as a word or as a flag; methods that are called are other things."""
    found = re.finditer(rf"(\.\s*)?(?<!\w)({name}|{name.replace('_', '-')})(?!\w)(\s*\()?", text)
    return any(not (match[1] and match[3]) for match in found)


def parameters(path: Path) -> set[str]:
    """Return the names of a module's functions and of their parameters."""
    functions = [node for node in ast.walk(ast.parse(path.read_text(encoding="utf-8"))) if isinstance(node, ast.FunctionDef)]
    return {name for node in functions for name in (node.name, *(it.arg for it in (*node.args.args, *node.args.kwonlyargs)))}


def test_front_ends_know_no_option_by_its_name() -> None:
    listed = subprocess.run(["git", "ls-files", *FRONT_ENDS], cwd=ROOT, capture_output=True, text=True, check=True)
    files = {name: code(ROOT / name) for name in listed.stdout.split() if name.endswith((".rs", ".py", ".pyi"))}
    generated = files.pop("python/graphstipple/_option_fields.py")
    assert len(files) > 20
    names = [*NAMES, *PUBLISHED]
    assert all(has_word(generated, name) for name in names)
    found = {(name, file) for file, text in files.items() for name in names if has_word(text, name)}
    # Stages can be called alone: what shapes one is its parameter, or it bears the option's name.
    found -= {(name, STAGES) for name in parameters(ROOT / STAGES)}
    found -= {(name, file) for name, file in found if name in EVERYWHERE}
    unexpected = sorted(found - set(BY_NAME))
    declared = "rust/core/src/options/declared.rs"
    assert not unexpected, f"front ends take options from {declared}; if these are other things, say so in BY_NAME: {unexpected}"
    assert not set(BY_NAME) - found, "these exceptions are needed no more"


MOST_PLACES = 5
"""Files of the core, besides those of the options themselves, in which one may stand as a field: the stage that uses it, or where
the parameters of a stage are put together and used."""


def test_the_places_of_an_option_add_up() -> None:
    listed = subprocess.run(["git", "ls-files", "rust/core/src"], cwd=ROOT, capture_output=True, text=True, check=True)
    texts = {name: code(ROOT / name) for name in listed.stdout.split() if name.endswith(".rs") and "/options/" not in name}
    assert len(texts) > 50
    found = {}
    for name in [*NAMES, *PUBLISHED]:
        # Words such as `tolerance` and `alpha` are other things too: as a field of options or parameters, or taken out of them.
        read = rf"(options|needs|published|parameters)\)?\.{name}\b"
        taken = rf"\b{name}(: \w+)?, [^;]*\}} = (\*?options|options\.published)"
        found[name] = [file.removeprefix("rust/core/src/") for file, text in texts.items() if re.search(f"{read}|{taken}", text)]
        assert len(found[name]) <= MOST_PLACES, f"{name} stands in {found[name]}"
    assert found["crispness"] == ["labels/inks/refine.rs", "labels/refine.rs"]
    assert found["gamma"] == ["photo/tone.rs"]
    # A limit of bytes or points changes it.
    assert found["tolerance"] == ["outlines/outline.rs", "pipeline/within.rs"]


def test_hard_coded_options_would_be_seen() -> None:
    for line in ('Arg::new("local_contrast")', 'flag("local-contrast")', "options.local_contrast", "local_contrast: f64,"):
        assert has_word(line, "local_contrast"), line
    for line in ("text.split(b)", "splitting", "split_contrast"):
        assert not has_word(line, "split"), line


def test_stages_have_the_defaults_of_options() -> None:
    ours, paper = gs.Options(), gs.Published()
    expected = {**dataclasses.asdict(ours.published), **dataclasses.asdict(ours), "sweeps": ours.refine, "most": ours.split}
    for function in (gs.stages.diffuse, gs.stages.refine, gs.stages.split, gs.stages.outline):
        for name, parameter in inspect.signature(function).parameters.items():
            if name in expected and parameter.default is not parameter.empty:
                assert parameter.default == expected[name], (function.__name__, name)
    lattice = inspect.signature(gs.stages.lattice).parameters
    assert (lattice["density"].default, lattice["kind"].default) == (paper.density, paper.lattice)
