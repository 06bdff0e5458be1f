"""The drive shaft of the paper: found in data (17)-(18), and simulated (12)-(16)."""

from __future__ import annotations

from .estimates import METHODS, Estimated, Fit, Window, identify
from .reduced import TABLE_1, Reduced, simulate

__all__ = ["METHODS", "TABLE_1", "Estimated", "Fit", "Reduced", "Window", "identify", "simulate"]
