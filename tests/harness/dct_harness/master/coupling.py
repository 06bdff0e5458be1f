"""How components are coupled: which signals arrive one step late, which loops are algebraic."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

from ..graph import loops

ORDERS = ("gauss-seidel", "jacobi")


def delayed(order: list[str], sources: dict[str, str], coupling: str) -> list[dict[str, str]]:
    """Return the connections whose value is one communication step old, as from and to.

    Gauss-Seidel: those from a component that is stepped later. Jacobi: all between components.
    """
    rank = {name: k for k, name in enumerate(order)}
    found = []
    for target, source in sources.items():
        giver, taker = source.partition(".")[0], target.partition(".")[0]
        late = giver in rank and (coupling == "jacobi" or rank[giver] >= rank[taker])
        if late:
            found.append({"from": source, "to": target})
    return found


def algebraic_loops(fmus: Mapping[str, Any], sources: dict[str, str]) -> list[list[str]]:
    """Return the loops of signals that depend on themselves at one instant, each sorted.

    Only connected signals are looked at, however many variables the FMUs have.
    """
    edges: dict[str, set[str]] = {}
    for target, source in sources.items():
        edges.setdefault(source, set()).add(target)
    for name, fmu in fmus.items():
        taken = {target.partition(".")[2] for target in sources if target.startswith(f"{name}.")}
        for output, inputs in fmu.feedthrough().items():
            if f"{name}.{output}" in edges:
                for variable in taken & inputs:
                    edges.setdefault(f"{name}.{variable}", set()).add(f"{name}.{output}")
    return loops(edges)


def ranges(fmus: dict[str, Any]) -> dict[str, tuple[float, float]]:
    """Return output -> declared (min, max), for outputs that declare one."""
    found = {}
    for name, fmu in fmus.items():
        for v in fmu.outputs:
            kind = v.declaredType
            low, high = (getattr(v, side, None) or (getattr(kind, side, None) if kind else None)
                         for side in ("min", "max"))  # fmt: skip
            if v.type in ("Real", "Integer") and (low or high):
                found[f"{name}.{v.name}"] = (
                    float(low) if low else float("-inf"), float(high) if high else float("inf"),
                )  # fmt: skip
    return found
