"""A run as the report sees it: results, KPIs, labels, clutch states, partner run."""

from __future__ import annotations

import itertools
import re
from collections import Counter
from collections.abc import Sequence
from dataclasses import dataclass, replace
from functools import cached_property
from pathlib import Path
from typing import Any

import numpy as np

from .. import kpi
from ..errors import ConfigError
from ..kpi import limits, tracking
from ..kpi.estimation import OBSERVER
from ..kpi.scopes import STATES, clutch_state
from ..results import AGAIN, RUN_JSON, Results
from ..results import load as load_results

NEEDED = ("system", "step", "stop", "status")  # of run.json, by the page
PAPER_FIGURES = {
    f"{system}_case{case}": figures
    for case, figures in ((1, ("10", "11")), (2, ("12", "13"))) for system in ("paper", "methods")
}  # fmt: skip


@dataclass(frozen=True)
class View:
    """One run; `slug` is unique on the page and safe as an HTML id; `earlier` to overlay.

    `folder`: its directory, where the page has several runs of one title.
    """

    results: Results
    kpis: dict[str, Any]
    slug: str
    earlier: View | None = None
    folder: str = ""

    @property
    def run(self) -> dict[str, Any]:
        """Content of `run.json`."""
        return self.results.run

    @property
    def name(self) -> str:
        """Name of the system, the same for runs that differ by an override."""
        return self.run.get("system", {}).get("name", self.slug)

    @cached_property
    def feedback(self) -> bool | None:
        """Whether the control used the estimates; None without a control."""
        return tracking.feedback(self.results)

    @property
    def title(self) -> str:
        """Title of the system, with the feedback where there is a control."""
        words = {True: ", with feedback", False: ", without feedback", None: ""}
        return self.base + words[self.feedback] + f" ({self.folder})" * bool(self.folder)

    @property
    def base(self) -> str:
        """Title of the system."""
        title: str = self.run.get("system", {}).get("title", self.name)
        return title

    @property
    def method(self) -> str | None:
        """Method of the observer; None without one, or with one that is not ours."""
        given = self.run.get("parameters", {}).get(OBSERVER, {}).get("observer.method", {})
        method: str | None = given.get("item")
        return method

    @property
    def truth(self) -> str:
        """What the legend calls `plant.*`: a run without a plant has it from a measurement."""
        fmus = self.run.get("fmus", {"plant": {}})
        return "true (plant)" if "plant" in fmus else "measured"

    @property
    def paper_figures(self) -> tuple[str, str] | None:
        """Numbers of the paper's torque and friction figures that this run redoes."""
        return PAPER_FIGURES.get(self.name)

    def spans(self, clutch: str) -> list[dict[str, Any]]:
        """Return stretches of one clutch state: x0, x1 [s], state; empty if not known."""
        state = clutch_state(self.results, clutch)
        if state is None or not len(state):
            return []
        time = self.results.time
        starts = np.concatenate([[0], np.flatnonzero(np.diff(state)) + 1])
        ends = np.concatenate([starts[1:], [len(state) - 1]])
        return [
            {"x0": float(time[a]), "x1": float(time[b]), "state": STATES[int(state[a])]}
            for a, b in zip(starts, ends, strict=True) if int(state[a]) in STATES
        ]  # fmt: skip

    def changes(self, clutch: str) -> list[tuple[int, str]]:
        """Return sample and sentence of each change of a clutch state."""
        spans = self.spans(clutch)
        found = []
        for before, after in itertools.pairwise(spans):
            k = int(np.searchsorted(self.results.time, after["x0"]))
            found.append((k, f"{clutch}: {before['state']} → {after['state']}"))
        return found


@dataclass(frozen=True)
class Pair:
    """The same torque-tracking system with and without feedback."""

    closed: View
    opened: View

    @cached_property
    def rows(self) -> list[dict[str, Any]]:
        """KPIs that need both runs."""
        return kpi.compare_feedback(self.closed.kpis, self.opened.kpis)

    @cached_property
    def limits(self) -> list[dict[str, Any]]:
        """Limits on those KPIs."""
        return limits.judge(self.closed.run, self.rows) if self.rows else []


def load(run_dirs: Sequence[str | Path]) -> list[View]:
    """Load result directories in the given order and compute their KPIs.

    Runs whose titles are equal have their directory in it.
    """
    views: list[View] = []
    for directory in run_dirs:
        results = load_results(directory)
        _check(Path(directory) / RUN_JSON, results.run)
        base = re.sub(r"[^a-z0-9]+", "-", Path(directory).name.lower()).strip("-") or "run"
        views.append(View(results, kpi.compute(results, results.run), f"{len(views) + 1}-{base}"))
    titles = Counter(view.title for view in views)
    names = [Path(directory).name for directory in run_dirs]
    shown = names if len(set(names)) == len(names) else map(str, run_dirs)
    return [
        replace(view, folder=folder) if titles[view.title] > 1 else view
        for view, folder in zip(views, shown, strict=True)
    ]


def _check(path: Path, run: dict[str, Any]) -> None:
    missing = [key for key in NEEDED if key not in run]
    if missing:
        raise ConfigError(f"{path}: has no '{missing[0]}'; {AGAIN}")


def pairs(views: list[View]) -> list[Pair]:
    """Return each run with feedback beside the run of the same system without."""
    opened = {v.name: v for v in views if v.feedback is False}
    return [Pair(v, opened[v.name]) for v in views if v.feedback and v.name in opened]


def tags(views: list[View], paired: list[Pair]) -> dict[str, str]:
    """Return slug -> verdict of each run; limits of a pair count for the run with feedback."""
    found = {v.slug: v.kpis["verdict"] for v in views}
    for pair in paired:
        if found[pair.opened.slug] == "not judged":
            found[pair.opened.slug] = "reference"
        if pair.limits and found[pair.closed.slug] != "fail":
            passed = all(limit["pass"] for limit in pair.limits)
            found[pair.closed.slug] = "pass" if passed else "fail"
    return found


def overall(views: list[View], paired: list[Pair]) -> tuple[str, list[tuple[View, dict[str, Any]]]]:
    """Return the verdict over all runs, and every limit with the run it judges."""
    judged = [(v, limit) for v in views for limit in v.kpis["limits"]]
    judged += [(p.closed, limit) for p in paired for limit in p.limits]
    verdicts = [v.kpis["verdict"] for v in views]
    if "fail" in verdicts or any(not limit["pass"] for _, limit in judged):
        return "fail", judged
    return ("pass" if judged else "not judged"), judged
