"""Directed graphs of signals: parts that depend on themselves, and an order of all parts."""

from __future__ import annotations

from collections.abc import Iterator, Mapping

Edges = Mapping[str, set[str]]


def parts(edges: Edges) -> list[list[str]]:
    """Return the strongly connected parts, sources first, each sorted (Tarjan, 1972)."""
    return _Tarjan(edges).parts()


def loops(edges: Edges) -> list[list[str]]:
    """Return the parts whose members depend on themselves."""
    return sorted(p for p in parts(edges) if len(p) > 1 or p[0] in edges.get(p[0], ()))


def levels(edges: Edges) -> list[list[list[str]]]:
    """Return parts that need only parts of earlier levels, level by level."""
    ordered = parts(edges)
    rank = {node: k for k, part in enumerate(ordered) for node in part}
    depth = [0] * len(ordered)
    for k, part in enumerate(ordered):
        for after in {rank[n] for node in part for n in edges.get(node, ())} - {k}:
            depth[after] = max(depth[after], depth[k] + 1)
    found: list[list[list[str]]] = [[] for _ in range(max(depth, default=-1) + 1)]
    for part, level in zip(ordered, depth, strict=True):
        found[level].append(part)
    return found


class _Tarjan:
    """Without recursion: a chain of signals may be longer than Python's stack."""

    def __init__(self, edges: Edges) -> None:
        self._edges = edges
        self._index: dict[str, int] = {}
        self._low: dict[str, int] = {}
        self._open: dict[str, None] = {}  # ordered: the nodes of no part yet
        self._found: list[list[str]] = []

    def parts(self) -> list[list[str]]:
        """Return the parts, sources first."""
        for node in sorted(self._edges):
            if node not in self._index:
                self._visit(node)
        return self._found[::-1]

    def _visit(self, root: str) -> None:
        path = [(root, self._enter(root))]
        while path:
            node, following = path[-1]
            after = next(following, None)
            if after is None:
                path.pop()
                self._leave(node)
                if path:
                    self._low[path[-1][0]] = min(self._low[path[-1][0]], self._low[node])
            elif after not in self._index:
                path.append((after, self._enter(after)))
            elif after in self._open:
                self._low[node] = min(self._low[node], self._index[after])

    def _enter(self, node: str) -> Iterator[str]:
        self._index[node] = self._low[node] = len(self._index)
        self._open[node] = None
        return iter(sorted(self._edges.get(node, ())))

    def _leave(self, node: str) -> None:
        """Close the part that a node is the first of."""
        if self._low[node] != self._index[node]:
            return
        part: list[str] = []
        while not part or part[-1] != node:
            part.append(self._open.popitem()[0])
        self._found.append(sorted(part))
