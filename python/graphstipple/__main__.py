"""``python -m graphstipple``: the command line."""

import sys

from graphstipple._cli import main

sys.exit(main())
