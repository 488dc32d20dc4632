"""How the documentation is built: `make docs` writes it to out/docs, and a warning is an error.

The sources are the Markdown pages of the whole repository, so that their links to one another are the same here and where the
repository is read; the front page is docs/index.md.
"""

from __future__ import annotations

import posixpath
import re
from pathlib import Path
from typing import Any

import graphstipple

ROOT = Path(__file__).resolve().parents[1]

project = "graphstipple"
author = "the authors of graphstipple"
version = release = graphstipple.__version__

extensions = ["myst_parser", "sphinx.ext.autodoc", "sphinx.ext.napoleon"]
include_patterns = ["README.md", "ARCHITECTURE.md", "CONTRIBUTING.md", "SECURITY.md", "CHANGELOG.md", "docs/**.md"]
root_doc = "docs/index"
nitpicky = True

# Headings have the anchors that GitHub gives them.
myst_heading_anchors = 4

# Single backticks in docstrings are code.
default_role = "literal"
autodoc_typehints = "none"
autodoc_member_order = "bysource"
napoleon_google_docstring = False
napoleon_use_param = False
napoleon_use_rtype = False
napoleon_use_ivar = False
python_maximum_signature_line_length = 90
add_module_names = False
python_use_unqualified_type_names = True

html_theme = "furo"
html_title = "graphstipple"
html_static_path = ["static"]
html_css_files = ["site.css"]
html_favicon = html_logo = "images/mark.svg"
html_show_sphinx = False
html_copy_source = False
html_show_copyright = False
# The site's first address leads to the front page.
html_additional_pages = {"index": "front.html"}
templates_path = ["templates"]
pygments_style = "bw"
pygments_dark_style = "monokai"
html_theme_options = {
    f"{scheme}_css_variables": {
        f"color-{part}": colour
        for part in ("brand-primary", "brand-content", "brand-visited", "api-name", "api-pre-name", "api-overall")
    }
    for scheme, colour in (("light", "black"), ("dark", "white"))
}


COLON = "\ue000"
"""Stands for a colon while napoleon reads the docstring of an attribute: it would take what is before one for a type."""


def hide_colons(app: object, what: str, *of: Any) -> None:
    """Hide the colons of attributes from napoleon, which comes next."""
    lines: list[str] = of[-1]
    if what in {"attribute", "property"}:
        lines[:] = [line.replace(":", COLON) for line in lines]


def link_pages(app: object, what: str, *of: Any) -> None:
    """Make links of the pages that docstrings name."""
    lines: list[str] = of[-1]
    shown = (line.replace(COLON, ":") for line in lines)
    lines[:] = [re.sub(r"\bdocs/(\w+)\.md\b", r":doc:`docs/\1.md </docs/\1>`", line) for line in shown]


NOT_CALLED = {"graphstipple.Drawing", "graphstipple.RecordedOptions"}
"""Classes that users get and never make."""


def hide_constructors(app: object, what: str, name: str, *of: Any) -> tuple[str, None] | None:
    """Leave out how a class is made that only the package makes."""
    return ("", None) if name in NOT_CALLED else None


def link_files(app: Any, docname: str, source: list[str]) -> None:
    """Let links to Markdown files that are no pages of the site lead to the files themselves."""

    def target(link: re.Match[str]) -> str:
        page = posixpath.normpath(posixpath.join(posixpath.dirname(docname), link[1]))
        is_file = page not in app.env.found_docs and (ROOT / f"{page}.md").exists()
        return f"](<path:{link[1]}.md>)" if is_file else link[0]

    source[0] = re.sub(r"\]\((?!\w+:)([^()#\s]+)\.md\)", target, source[0])


def setup(app: Any) -> None:
    """Connect what is above."""
    app.connect("autodoc-process-docstring", hide_colons, priority=400)
    app.connect("autodoc-process-docstring", link_pages, priority=600)
    app.connect("autodoc-process-signature", hide_constructors)
    app.connect("source-read", link_files)
