"""What our drawings are compared with: other methods after their papers, and programs where they are installed.

A family of methods a file. `METHODS` has all of them, in the order of the report.
"""

from graphstipple_eval.baselines import (
    capacity,
    halftone,
    linde_buzo_gray,
    multi_class,
    priority,
    programs,
    weighted_voronoi,
)
from graphstipple_eval.method import Method

__all__ = ["METHODS"]

METHODS: tuple[Method, ...] = (
    *halftone.METHODS,
    *priority.METHODS,
    *weighted_voronoi.METHODS,
    *linde_buzo_gray.METHODS,
    *multi_class.METHODS,
    *capacity.METHODS,
    *programs.METHODS,
)
"""Every method, in the order of the report."""
