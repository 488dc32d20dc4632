"""The shape of the core: its folders import only from those before them, its files in no circle, and few names are public."""

import re
from collections.abc import Iterator
from graphlib import CycleError, TopologicalSorter
from pathlib import Path

import pytest

RUST = Path(__file__).resolve().parents[1] / "rust"
CORE = RUST / "core" / "src"
LIB = (CORE / "lib.rs").read_text(encoding="utf-8")
FOLDERS = re.findall(r"^mod (\w+);", LIB, re.MULTILINE)


def code_of(path: Path) -> str:
    """Return a file's code without comments and tests."""
    return re.sub(r"//.*", "", path.read_text(encoding="utf-8").split("#[cfg(test)]")[0])


def expanded(tree: str) -> Iterator[str]:
    """Yield every path of a tree such as `a::{b, c::{d, e}}`."""
    head, brace, rest = tree.partition("{")
    if not brace:
        yield tree.strip()
        return
    depth, begin = 0, 0
    inner = rest[: rest.rindex("}")]
    for at, letter in enumerate(inner + ","):
        depth += (letter == "{") - (letter == "}")
        if letter == "," and depth == 0:
            if inner[begin:at].strip():
                for path in expanded(inner[begin:at].strip()):
                    yield head.strip() + path
            begin = at + 1


def imports(path: Path) -> set[str]:
    """Return the paths in the crate that a file imports, from the crate's root on."""
    place = path.relative_to(CORE).with_suffix("").parts
    here = place[:-1] if place[-1] == "mod" else place
    found = set()
    for tree in re.findall(r"^\s*(?:pub(?:\([^)]*\))? )?use ([^;]+);", code_of(path), re.MULTILINE):
        for used in expanded(" ".join(tree.split())):
            parts = used.split(" as ")[0].split("::")
            if parts[0] == "crate":
                found.add("::".join(parts[1:]))
            elif parts[0] == "super":
                ups = next(i for i, part in enumerate(parts) if part != "super")
                found.add("::".join([*here[: len(here) - ups], *parts[ups:]]))
    # Paths that are written out where they are used.
    found |= {used.removeprefix("crate::") for used in re.findall(r"\bcrate::\w+(?:::\w+)+", code_of(path))}
    return found


def file_of(used: str) -> Path | None:
    """Return the file in which a path's name is defined, following what each `mod.rs` hands on."""
    folder, parts = CORE, used.split("::")
    while len(parts) > 1 and (folder / parts[0]).is_dir():
        folder, parts = folder / parts[0], parts[1:]
    for name in (parts[0], *([] if not (folder / "mod.rs").exists() else handed_on(folder).get(parts[0], []))):
        if (folder / f"{name}.rs").exists():
            return folder / f"{name}.rs"
        if (folder / name / "mod.rs").exists():
            return (
                file_of("::".join([*folder.relative_to(CORE).parts, name, parts[0]]))
                if name != parts[0]
                else folder / name / "mod.rs"
            )
    return folder / "mod.rs" if (folder / "mod.rs").exists() else None


def handed_on(folder: Path) -> dict[str, list[str]]:
    """Return, for every name that a `mod.rs` hands on, the module that it has it from."""
    names: dict[str, list[str]] = {}
    for tree in re.findall(r"^\s*pub(?:\([^)]*\))? use ([^;]+);", code_of(folder / "mod.rs"), re.MULTILINE):
        for used in expanded(" ".join(tree.split())):
            module, *_, name = used.split("::")
            names.setdefault(name, []).append(module)
    return names


def test_the_folders_are_those_of_the_crate() -> None:
    assert sorted(FOLDERS) == sorted(path.name for path in CORE.iterdir() if path.is_dir())
    assert FOLDERS[0] == "base"
    assert FOLDERS[-3:] == ["pipeline", "plot", "rules"]


@pytest.mark.parametrize("folder", FOLDERS)
def test_a_folder_imports_only_from_those_before_it(folder: str) -> None:
    before = FOLDERS[: FOLDERS.index(folder)]
    for path in (CORE / folder).rglob("*.rs"):
        used = {name.split("::")[0] for name in imports(path)}
        assert used & set(FOLDERS) <= {folder, *before}, f"{path.relative_to(CORE)} imports upwards: {sorted(used)}"


def test_no_files_import_one_another_in_a_circle() -> None:
    graph: dict[str, set[str]] = {}
    for path in CORE.rglob("*.rs"):
        if path.name in {"lib.rs", "stages.rs", "mod.rs"}:
            # These hand names on; `files/mod.rs` has the table of formats, which stands on all of them.
            continue
        targets = {file_of(used) for used in imports(path)} - {None, path}
        graph[str(path.relative_to(CORE))] = {str(target.relative_to(CORE)) for target in targets if target}
    edges = sum(len(targets) for targets in graph.values())
    assert edges > 150, "the imports were not read"
    try:
        list(TopologicalSorter(graph).static_order())
    except CycleError as error:
        pytest.fail(f"files import one another: {' -> '.join(error.args[1])}")


def test_threads_are_started_in_one_place() -> None:
    sources = [path for crate in ("core", "cli", "py") for path in (RUST / crate / "src").rglob("*.rs")]
    starting = re.compile(r"ThreadPoolBuilder|build_global|rayon::spawn|thread::(?:spawn|Builder|scope)")
    assert [path for path in sources if starting.search(code_of(path))] == [CORE / "base" / "pool.rs"]


def test_few_names_are_public() -> None:
    assert re.findall(r"^pub mod (\w+);", LIB, re.MULTILINE) == ["stages"]
    names = [name for tree in re.findall(r"^pub use ([^;]+);", LIB, re.MULTILINE) for name in expanded(" ".join(tree.split()))]
    assert len(names) <= 16
    wanted = {
        "Options",
        "presets",
        "draw",
        "Session",
        "Drawing",
        "Export",
        "Format",
        "load",
        "Field",
        "Importance",
        "Control",
        "Error",
    }
    assert wanted <= {name.split("::")[-1] for name in names}
