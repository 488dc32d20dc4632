"""Writes the tables of docs/performance.md anew, each by the command above it: `python benches/document.py`.

In the document, `<!-- run: COMMAND -->` and `<!-- end -->` stand around what COMMAND printed. With words as arguments, only
tables are made anew whose commands contain one of them. It takes some minutes; the other work on the machine shows.
"""

from __future__ import annotations

import re
import shlex
import subprocess
import sys
from pathlib import Path

ROOT = Path(__file__).resolve().parents[1]
DOCUMENT = ROOT / "docs" / "performance.md"
TABLE = re.compile(r"<!-- run: (?P<command>.+?) -->\n.*?<!-- end -->", re.DOTALL)


def main() -> None:
    """Make the tables."""
    words = sys.argv[1:]
    for command in [match["command"] for match in TABLE.finditer(DOCUMENT.read_text("utf-8"))]:
        if words and not any(word in command for word in words):
            continue
        print(command, file=sys.stderr, flush=True)
        program, *arguments = shlex.split(command)
        whole = [sys.executable if program == "python" else program, *arguments]
        done = subprocess.run(whole, cwd=ROOT, stdout=subprocess.PIPE, text=True, check=True)
        put(command, done.stdout.strip("\n"))


def put(command: str, table: str) -> None:
    """Put a table under its command; the document is written at once, so that what is done stays if the next one fails."""
    text = DOCUMENT.read_text("utf-8")
    made = f"<!-- run: {command} -->\n```text\n{table}\n```\n<!-- end -->"
    DOCUMENT.write_text(TABLE.sub(lambda old: made if old["command"] == command else old[0], text), "utf-8")


if __name__ == "__main__":
    main()
