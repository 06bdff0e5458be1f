"""Regression compare of two runs, signal by signal, within tolerances.

A sample b(t) of the run passes when it lies in the band around the reference a:

    min a(τ) − tol ≤ b(t) ≤ max a(τ) + tol   for |τ − t| ≤ tube,   tol = abs + rel · max |a|

The time tube forgives an event that moves by a few steps, as in csv-compare of the Modelica
Association. `nrmse` bounds RMS(b − a) / RMS(a) as well. Integers and booleans are held between
samples and know no `rel`; reals are interpolated.
"""

from __future__ import annotations

from .outcome import Outcome, compare
from .tolerances import Tolerance, Tolerances

__all__ = ["Outcome", "Tolerance", "Tolerances", "compare"]
