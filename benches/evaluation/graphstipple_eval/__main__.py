"""``python -m graphstipple_eval`` is the command ``graphstipple-eval``."""

import sys

from graphstipple_eval.cli import main

if __name__ == "__main__":  # the worker processes import this module too
    sys.exit(main())
