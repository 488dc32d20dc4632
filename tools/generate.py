"""Writes what is made from the declarations in Rust and from the tree: `python tools/generate.py`, or `make generate`.

- `python/graphstipple/_option_fields.py`: the fields of `Options` and `Published`, with their documentation;
- `docs/options.md`: the page of options, settings, formats and sources of importance;
- `docs/command-line.md`: the help of the command, under its own headings;
- in `ARCHITECTURE.md`, the table of the core's folders with what goes in and comes out, and the tree: every file with the first
  sentence of its documentation.

`tests/test_generated.py` fails when one of them is not what this script writes.
"""

from __future__ import annotations

import ast
import json
import os
import re
import subprocess
import sys
import textwrap
from collections.abc import Callable, Iterable
from importlib.util import module_from_spec, spec_from_file_location
from pathlib import Path
from types import ModuleType
from typing import Any

ROOT = Path(__file__).resolve().parents[1]


def extension() -> ModuleType:
    """Return the extension module, without the package around it, which is not whole before its fields are made."""
    found = [*(ROOT / "python" / "graphstipple").glob("_core*.so"), *(ROOT / "python" / "graphstipple").glob("_core*.pyd")]
    if not found:
        sys.exit("the extension module is not built: make build")
    spec = spec_from_file_location("graphstipple._core", found[0])
    if spec is None or spec.loader is None:
        sys.exit(f"{found[0]} is no extension module")
    module = module_from_spec(spec)
    spec.loader.exec_module(module)
    return module


_core = extension()
WIDTH = 128
"""Of generated Python, in columns."""

DECLARED = "rust/core/src/options/declared.rs"

Property = dict[str, Any]


def kinds(option: Property) -> list[Property]:
    """Return the forms that an option's value can have, without null."""
    return [form for form in option.get("anyOf", [option]) if form.get("type") != "null"]


def annotation(option: Property, in_words: bool = False) -> str:
    """Return the option's type in Python, or as docstrings have it."""
    names = {"number": "float", "integer": "int", "boolean": "bool", "string": "str"}
    parts = []
    for kind in kinds(option):
        words = ", ".join(f'"{word}"' for word in kind.get("enum", []))
        braces = f"{{{words}}}" if in_words else f"Literal[{words}]"
        parts.append(braces if words else names[kind["type"]])
    return " | ".join([*parts, "None"] if "x-absent" in option else parts)


def allowed(option: Property) -> str:
    """Return what the option takes, in words."""
    parts = []
    for kind in kinds(option):
        if "enum" in kind:
            parts.append(", ".join(f"`{word}`" for word in kind["enum"]))
        elif "pattern" in kind:
            parts.append("`white`, `black`, `#rrggbb`, `#rgb`")
        elif kind["type"] == "boolean":
            parts.append("`True`, `False`")
        else:
            low = f"above {number(kind['exclusiveMinimum'])}" if "exclusiveMinimum" in kind else number(kind["minimum"])
            parts.append(f"{low} to {number(kind['maximum'])}")
    unit = f" {option['x-unit']}" if option["x-unit"] else ""
    return " or ".join(parts) + unit


def number(value: float) -> str:
    """Return a number as people write it."""
    return "2^53" if value == 2**53 else f"{value:,.10g}"


def capital(text: str) -> str:
    """Return a text with a capital at its begin."""
    return text[:1].upper() + text[1:]


def python_value(value: object) -> str:
    """Return a value as Python source."""
    return f'"{value}"' if isinstance(value, str) else repr(value)


def docstring(first: str, rest: str, options: dict[str, Property], raises: bool) -> str:
    """Return the docstring of a class of options, without quotes."""
    lines = [first, "", *textwrap.wrap(rest, WIDTH - 4), "", "Parameters", "----------"]
    for name, option in options.items():
        lines.append(f"{name} : {annotation(option, in_words=True).replace(' | None', ', optional').replace(' | ', ' or ')}")
        sentence = f"{option['description']} {capital(allowed(option).replace('`', ''))}."
        if "x-absent" in option:
            sentence += f" None: {option['x-absent']['meaning']}."
        lines += textwrap.wrap(sentence, WIDTH - 8, initial_indent="    ", subsequent_indent="    ")
    if raises:
        lines += ["published : Published", "    The parameters of the published method's graphs and diffusions; by default ours."]
    lines += ["", "Raises", "------", "InvalidInputError", "    If a value has the wrong type or lies outside its range."]
    return "\n".join(lines)


def fields(name: str, doc: str, options: dict[str, Property], default: str) -> str:
    """Return the source of a class of options."""
    body = [f"    {option}: {annotation(it)} = {python_value(it[default])}" for option, it in options.items()]
    text = textwrap.indent(doc, "    ", lambda line: bool(line.strip()))
    head = f'@dataclass(frozen=True, kw_only=True)\nclass {name}:\n    """{text.lstrip()}\n    """\n\n'
    return head + "\n".join(body)


def python_fields() -> str:
    """Return `_option_fields.py`."""
    options = dict(_core.options_schema()["properties"])
    published = options.pop("published")["properties"]
    checked = "Checked when made, by the Rust core; unchangeable afterwards (see `replace`)."
    paper = docstring(
        "The parameters of the published method's graphs and diffusions, by default the paper's.", checked, published, raises=False
    )
    everything = docstring("Everything that shapes a drawing besides the photo and the importance.", checked, options, raises=True)
    ours = "\n".join(f'    "{name}": {python_value(option["default"])},' for name, option in published.items())
    return f'''"""The fields of options, made by `tools/generate.py` from `{DECLARED}`: change them there."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any, Literal


{fields("PublishedFields", paper, published, "x-paper")}


OURS: dict[str, Any] = {{
{ours}
}}
"""The parameters of `Options` by default."""


{fields("OptionFields", everything, options, "default")}
'''


def table(head: Iterable[str], rows: Iterable[Iterable[str]]) -> str:
    """Return a table in Markdown."""
    lines = [list(head), *map(list, rows)]
    lines.insert(1, ["---"] * len(lines[0]))
    return "\n".join("| " + " | ".join(line) + " |" for line in lines)


def options_page() -> str:
    """Return `docs/options.md`."""
    properties = dict(_core.options_schema()["properties"])
    published = properties.pop("published")

    def default(option: Property, key: str = "default") -> str:
        value = option[key]
        return option["x-absent"]["meaning"] if value is None else f"`{value}`" if isinstance(value, (str, bool)) else number(value)

    def row(name: str, option: Property) -> list[str]:
        stages = ", ".join(option["x-stages"])
        return [f"`{name}`", option["description"], allowed(option) + absent_word(option), default(option), stages]

    def absent_word(option: Property) -> str:
        return f", or `None` (on the command line `{option['x-absent']['word']}`)" if "x-absent" in option else ""

    groups = list(dict.fromkeys(option["x-group"] for option in properties.values()))
    parts = []
    for group in groups:
        rows = [(name, option) for name, option in properties.items() if option["x-group"] == group]
        everyday = [row(name, option) for name, option in rows if option["x-everyday"]]
        further = [row(name, option) for name, option in rows if not option["x-everyday"]]
        head = ["Option", "What it does", "Takes", "Default", "Used for"]
        parts.append(f"### {group}\n\n{table(head, everyday + further)}")
        if everyday and further:
            parts[-1] += f"\n\nOn the command line the last {len(further)} are shown by `--help-all` only."
    method = [
        [f"`{name}`", option["description"], allowed(option) + absent_word(option), default(option), default(option, "x-paper")]
        for name, option in published["properties"].items()
    ]
    method_table = table(["Parameter", "What it does", "Takes", "Default", "Paper"], method)
    settings = [
        [f"`{name}`", sentence, default, ", ".join(f"`.{suffix}`" for suffix in takers)]
        for name, sentence, default, takers, *_ in _core.settings()
    ]
    formats = [[f"`.{suffix}`", name, holds, "yes" if is_read else ""] for suffix, name, holds, is_read in _core.formats()]
    sources = [[f"`{form}`" if form.split()[0] != "the" else form, sentence] for form, sentence in _core.sources()]
    return f"""# Options

Made by `tools/generate.py` from the declarations in `{DECLARED}` and its neighbours: change them there.

Names in Python; on the command line `local_contrast` is `--local-contrast`, and so on; `True` is a flag without a value.
`graphstipple --options-schema` prints the same as a JSON schema.

## How a photo is drawn

Fields of `gs.Options`. The last column has the stages that use an option: when it changes, a [session](howto/sessions.md) does
them again and what follows from them, in the order tone, emphasis, importance, first graph, second graph, cells, labels, outlines.
With another `background` it reads the photo anew.

{chr(10).join(part + chr(10) for part in parts)}
### Published method

The parameters of the published method's graphs and diffusions, for research and ablations: fields of `gs.Published`, which is
`gs.Options(published=...)`; on the command line `--published k1=2`, any number of times. `gs.Published()` has the paper's values,
`gs.Options().published` ours; `gs.Options.preset("paper")` and `--preset paper` are the published method as it is.

{method_table}

## Where detail is wanted

The argument `importance` of `gs.draw` and `gs.Session`, `--importance` on the command line. In Python it may also be an image, an
array (height, width), or a callable that makes any of these of the photo's luma.

{table(["Importance", "What it is"], sources)}

## How a drawing is written

Arguments of `drawing.save`; one that a format does not take is left alone there, but `dpi` and `one_bit` are refused.

{table(["Setting", "What it does", "Default", "Formats"], settings)}

`min_dot`, a least radius of dots on paper, is `--min-dot` on the command line and `drawing.with_min_dot(...)` in Python.

## Formats

The suffix says which. Those that `gs.load` reads give the drawing back.

{table(["Suffix", "Name", "Holds", "Read back"], formats)}
"""


HELP_COLUMNS = 88
"""Of the help on the page of the command line: as many as a page shows without scrolling."""

PRINT_HELP = """
import sys
from importlib.util import module_from_spec, spec_from_file_location
spec = spec_from_file_location("graphstipple._core", sys.argv[1])
module = module_from_spec(spec)
spec.loader.exec_module(module)
sys.exit(module.cli(["graphstipple", "--help-all"]))
"""
"""A program that prints the help with the extension module that it is given: Rust writes to the process's own output."""


def help_all() -> str:
    """Return what `graphstipple --help-all` prints."""
    command = [sys.executable, "-c", PRINT_HELP, str(_core.__file__)]
    environment = {**os.environ, "COLUMNS": str(HELP_COLUMNS)}
    return subprocess.run(command, capture_output=True, text=True, check=True, env=environment).stdout


def command_line_page() -> str:
    """Return `docs/command-line.md`."""
    about, _, rest = help_all().strip().partition("\n\n")
    usage, *groups = re.split(r"\n\n(?=\S)", rest)
    sections = []
    for group in groups:
        head, _, lines = group.partition("\n")
        if not lines:
            # Where else to look, which the page says in its own words.
            continue
        fence = "sh" if head == "Examples:" else "text"
        text = "\n".join(line.rstrip() for line in textwrap.dedent(lines).splitlines())
        sections.append(f"## {head.removesuffix(':')}\n\n```{fence}\n{text}\n```\n")
    return f"""# Command line

Made by `tools/generate.py` of what `graphstipple --help-all` prints.

{about}.

```text
{usage.removeprefix("Usage: ")}
```

`graphstipple --help` shows what people turn. [options.md](options.md) has the same options with the stages that use them and the
paper's values, [errors.md](errors.md#on-the-command-line) the exit codes, [shell.md](howto/shell.md) pipes, the manual page and
completions, [studio.md](howto/studio.md) `graphstipple studio`, [batch.md](howto/batch.md) `graphstipple batch`.

{chr(10).join(sections)}"""


ROOMS = ("rust", "python", "benches", "docs", "examples", "tools", "tests")
"""Folders whose files the tree shows."""

WITHOUT_TEXT = (".png", ".jpg", ".json", ".toml", ".lock", ".typed", ".md", ".html", ".css", ".js", ".svg")
"""Suffixes of files that the tree leaves out: data, settings and pages."""


def first_sentence(path: Path) -> str:
    """Return the first sentence of a source file's documentation."""
    text = path.read_text(encoding="utf-8")
    if path.suffix == ".py":
        doc = ast.get_docstring(ast.parse(text)) or ""
    elif path.suffix == ".pyi":
        return "types of the extension module"
    elif path.suffix == ".ipynb":
        doc = "".join(json.loads(text)["cells"][0]["source"]).lstrip("# ")
    else:
        doc = rust_doc(path)
    # "et al." ends no sentence.
    sentence = re.split(r"(?<!et al)\. ", paragraph(doc))[0].rstrip(".")
    return plain(sentence)


def paragraph(doc: str) -> str:
    """Return the first paragraph of a documentation, in one line."""
    return " ".join(doc.strip().split("\n\n")[0].split())


def plain(text: str) -> str:
    """Return a text without the links of documentation."""
    return re.sub(r"\[(`[^`]*`)\](\([^)]*\))?", r"\1", text).replace("``", "`")


def rust_doc(path: Path) -> str:
    """Return the documentation of a module in Rust."""
    lines = []
    for line in path.read_text(encoding="utf-8").splitlines():
        if line.startswith("#![doc = include_str!("):
            return (path.parent / line.split('"')[1]).read_text(encoding="utf-8")
        if not line.startswith("//!"):
            break
        lines.append(line.removeprefix("//!").strip())
    return "\n".join(lines)


CORE = ROOT / "rust" / "core" / "src"


def core_folders() -> list[str]:
    """Return the core's folders in the order of the data: that in which `lib.rs` names them."""
    return re.findall(r"^mod (\w+);", (CORE / "lib.rs").read_text(encoding="utf-8"), re.MULTILINE)


def imported(folder: str) -> set[str]:
    """Return the folders from which a folder's files import, tests aside."""
    found: set[str] = set()
    for path in (CORE / folder).rglob("*.rs"):
        code = path.read_text(encoding="utf-8").split("#[cfg(test)]")[0]
        found |= set(re.findall(r"\bcrate::(\w+)", re.sub(r"//.*", "", code)))
    return found - {folder}


def folders() -> str:
    """Return the table of the core's folders in the order of the data, with what each of their `mod.rs` says of itself."""
    rows = []
    for folder in core_folders():
        said = plain(paragraph(rust_doc(CORE / folder / "mod.rs")))
        found = re.fullmatch(r"(.*?)\. In: (.*?); out: (.*?)\. Source: (.*)", said)
        if not found:
            sys.exit(f"{folder}/mod.rs must begin with what it is. In: ...; out: .... Source: ...")
        imports = [other for other in core_folders() if other in imported(folder)]
        rows.append([f"`{folder}/`", found[2], found[3], ", ".join(f"`{other}`" for other in imports)])
    return table(["Folder", "In", "Out", "Stands on"], rows)


def tree(files: Iterable[str]) -> str:
    """Return the tree of source files, with what each says of itself."""
    lines: list[str] = []
    shown: set[Path] = set()
    paths = [Path(file) for file in files]
    # Folders in the order of the data, as their parent's list of modules has them.
    for path in sorted((p for p in paths if p.parts[0] in ROOMS and p.suffix not in WITHOUT_TEXT), key=order):
        for depth, folder in enumerate([*path.parents][-2::-1]):
            if folder not in shown:
                shown.add(folder)
                lines.append(f"{'  ' * depth}{folder.name}/")
        depth = len(path.parts) - 1
        lines.append(f"{'  ' * depth}{path.name:<{max(1, 30 - 2 * depth)}} {first_sentence(ROOT / path)}".rstrip())
    return "```text\n" + "\n".join(lines) + "\n```"


def order(path: Path) -> tuple[object, ...]:
    """Return what sorts paths: rooms as above, the core's folders in the order of the data, files before folders."""
    keys: list[tuple[int, int, str]] = []
    in_core = core_folders()
    for depth, part in enumerate(path.parts):
        is_file = depth == len(path.parts) - 1
        place = ROOMS.index(part) if depth == 0 else in_core.index(part) if part in in_core and not is_file else 0
        first = part in {"lib.rs", "mod.rs", "__init__.py"}
        keys.append((0 if is_file else 1, -1 if first else place, part))
    return tuple(keys)


def architecture() -> str:
    """Return `ARCHITECTURE.md` with its tree made anew."""
    page = (ROOT / "ARCHITECTURE.md").read_text(encoding="utf-8")
    listed = subprocess.run(["git", "ls-files"], cwd=ROOT, capture_output=True, text=True, check=True).stdout.splitlines()
    present = [file for file in listed if (ROOT / file).exists()]
    for name, text in (("folders", folders()), ("tree", tree(present))):
        begin, end = f"<!-- {name}: made by tools/generate.py -->", f"<!-- end of the {name} -->"
        before, _, rest = page.partition(begin)
        _, _, after = rest.partition(end)
        page = f"{before}{begin}\n\n{text}\n\n{end}{after}"
    return page


GENERATED: dict[str, Callable[[], str]] = {
    "python/graphstipple/_option_fields.py": python_fields,
    "docs/options.md": options_page,
    "docs/command-line.md": command_line_page,
    "ARCHITECTURE.md": architecture,
}
"""Files and what makes their text."""


def main() -> None:
    """Write every generated file that is not as it should be."""
    for name, make in GENERATED.items():
        path, text = ROOT / name, make()
        if not path.exists() or path.read_text(encoding="utf-8") != text:
            path.write_text(text, encoding="utf-8")
            sys.stderr.write(f"{name}: written anew\n")


if __name__ == "__main__":
    main()
