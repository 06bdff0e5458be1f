"""Which variables may have slopes within a communication step (FMI 2.0.4, 4.2.2)."""

from __future__ import annotations

from typing import Any

from .values import group_of


def interpolates(fmu: Any) -> bool:
    """Return whether an FMU takes input derivatives."""
    return str(fmu.description.coSimulation.canInterpolateInputs).lower() == "true"


def continuous(variable: Any) -> bool:
    """Return whether a variable is a real one that changes continuously."""
    return group_of(variable) == "Real" and variable.variability in (None, "continuous")


def followed(variable: Any) -> bool:
    """Return whether an input may have a derivative; a tunable parameter may not."""
    return continuous(variable) and variable.causality == "input"
