"""How components are coupled: which signals arrive one step late, which loops are algebraic."""

from __future__ import annotations

from typing import Any

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


def feedthrough(description: Any) -> dict[str, set[str]]:
    """Return output -> inputs that it depends on at the same instant.

    An output without stated dependencies may depend on every input (FMI 2.0.4, 2.2.8).
    """
    inputs = {v.name for v in description.modelVariables if v.causality == "input"}
    found = {}
    for unknown in description.outputs:
        named = unknown.dependencies
        direct = inputs if named is None else inputs & {v.name for v in named}
        found[unknown.variable.name] = set(direct)
    return found


def algebraic_loops(fmus: dict[str, Any], sources: dict[str, str]) -> list[list[str]]:
    """Return the loops of signals that depend on themselves at one instant, each sorted."""
    edges: dict[str, set[str]] = {}
    for target, source in sources.items():
        edges.setdefault(source, set()).add(target)
    for name, fmu in fmus.items():
        for output, inputs in fmu.feedthrough().items():
            for variable in inputs:
                edges.setdefault(f"{name}.{variable}", set()).add(f"{name}.{output}")
    return sorted(sorted(part) for part in _cycles(edges))


def _cycles(edges: dict[str, set[str]]) -> list[set[str]]:
    """Return the strongly connected parts with more than one node."""
    reached = {node: _reach(node, edges) for node in edges}
    found: list[set[str]] = []
    for node, after in reached.items():
        part = {other for other in after if node in reached.get(other, ())}
        if node in after and part not in found:
            found.append(part)
    return found


def _reach(start: str, edges: dict[str, set[str]]) -> set[str]:
    """Return every node that can be reached from a node in one step or more."""
    seen: set[str] = set()
    ends = [start]
    while ends:
        for node in edges.get(ends.pop(), ()):
            if node not in seen:
                seen.add(node)
                ends.append(node)
    return seen


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
