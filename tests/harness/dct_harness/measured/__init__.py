"""Measured data as tables: channels with their own time axes, foreign names and units.

file ──> channels ──> map (names, SI units) ──> one time axis ──> table
"""

from __future__ import annotations

from .channels import Channel, in_si, read
from .mapping import Mapping
from .resample import common

__all__ = ["Channel", "Mapping", "common", "in_si", "read"]
