"""Report of runs: one self-contained HTML page, and a static picture.

The page holds plotly.js, its data and its style; it asks the network for nothing.
"""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path
from typing import Any

import jinja2
from markupsafe import Markup
from plotly.offline import get_plotlyjs

from .. import __version__, results
from ..kpi import KPIS, typography
from . import (
    benefit,
    calibration,
    cells,
    diagram,
    downsample,
    earlier,
    figures,
    friction_map,
    methods,
    runs,
    shaft_model,
    study_page,
)
from .picture import picture
from .runs import View

__all__ = ["picture", "write", "write_study", "write_views"]

PAGE = "index.html"
SINGLE = (figures.torques, figures.friction, figures.track)  # what one observer shows


def write(run_dirs: Sequence[str | Path], out_dir: str | Path, title: str) -> Path:
    """Write `index.html` about result directories.

    Parameters
    ----------
    run_dirs
        Directories with `results.csv` and `run.json`; any subset of runs will do. Runs of one
        system with and without feedback are compared.
    out_dir
        Made when it does not exist.
    title
        Heading of the page.

    Returns
    -------
    Path
        The page.

    Raises
    ------
    ConfigError
        A directory holds no complete run.
    """
    return write_views(runs.load(run_dirs), out_dir, title)


def write_views(views: list[View], out_dir: str | Path, title: str) -> Path:
    """Write the page about loaded runs; see `write`."""
    page = Path(out_dir) / PAGE
    page.parent.mkdir(parents=True, exist_ok=True)
    results.write_text(page, _environment().get_template("page.html.j2").render(
        _context(views, title)
    ))  # fmt: skip
    return page


def write_study(folder: str | Path, out_dir: str | Path, title: str = "") -> Path:
    """Write the page about a study that `dct-harness sweep` has made; see `write`."""
    page = Path(out_dir) / PAGE
    page.parent.mkdir(parents=True, exist_ok=True)
    template = _environment().get_template(study_page.TEMPLATE)
    told = study_page.context(Path(folder), title)
    results.write_text(page, template.render(**told, version=__version__))
    return page


def _environment() -> jinja2.Environment:
    loader = jinja2.PackageLoader(__package__, "page")
    environment = jinja2.Environment(
        loader=loader, autoescape=True, undefined=jinja2.StrictUndefined,
        trim_blocks=True, lstrip_blocks=True,
    )  # fmt: skip

    def raw(name: str) -> Markup:
        return Markup(loader.get_source(environment, name)[0])

    environment.filters.update(minus=typography.minus, unit=typography.unit)
    environment.globals.update(raw=raw, plotly=lambda: Markup(get_plotlyjs()))
    return environment


def _context(views: list[View], title: str) -> dict[str, Any]:
    """Return all that the template shows."""
    pairs = runs.pairs(views)
    paired = {id(v) for pair in pairs for v in (pair.closed, pair.opened)}
    alone = [v for v in views if id(v) not in paired]
    verdict, judged = runs.overall(views, pairs)
    sections = [_section(v, alone[:k]) for k, v in enumerate(alone)]
    compared = [_compared(pair) for pair in pairs]
    energy = figures.energy(views)
    drawn = [f for s in sections for f in s["figures"]]
    shown = next(filter(None, map(shaft_model.section, views)), None)
    drawn += [shown["figure"], shown["launch"]] if shown else []
    drawn += [c["figure"] for c in compared if c["figure"]] + ([energy] if energy else [])
    largest = max(views, key=lambda v: diagram.size(v.run))
    return {
        "title": title, "views": views, "verdict": verdict, "sections": sections,
        "compared": compared, "bought": benefit.overview(pairs), "shaft": shown,
        "energy": energy, "figures": drawn, "cells": cells,
        "limits": cells.limit_rows(judged), "tags": runs.tags(views, pairs),
        "diagram": diagram.layout(largest.run), "diagram_of": largest,
        "phases": _phases(views), "methods": any(v.method for v in views),
        "tracked": any(map(cells.tracking, views)), "kpis": KPIS,
        "parameters": cells.parameters(views), "effective": cells.effective(views),
        "identities": cells.identities(views),
        "earlier": [found for view in views if (found := earlier.changes(view))],
        "bins": downsample.BINS, "version": __version__,
    }  # fmt: skip


def _compared(pair: runs.Pair) -> dict[str, Any]:
    """Return a pair with its figure."""
    return {"pair": pair, "figure": figures.of_pair(pair)}


def _phases(views: list[View]) -> list[dict[str, Any]]:
    """Return the phases of the first run that has any, for the zoom menu."""
    return next((v.kpis["phases"] for v in views if v.kpis["phases"]), [])


def _section(view: View, earlier: list[View]) -> dict[str, Any]:
    """Return a run with its figures; a driveline already shown is referred to."""
    twin = next((e for e in earlier if _same_plant(view, e)), None)
    makers = (figures.track,) if methods.several(view) else SINGLE
    made = methods.drawn(view) if methods.several(view) else []
    made += [figure for make in makers if (figure := make(view)) is not None]
    made += calibration.drawn(view) + friction_map.drawn(view)
    if twin is None and (first := figures.driveline(view)) is not None:
        made.insert(0, first)
    side = methods.table(view) if methods.several(view) else None
    return {"view": view, "figures": made, "twin": twin, "methods": side}


def _same_plant(a: View, b: View) -> bool:
    """Return whether the plants of two runs did exactly the same."""
    names = [n for n in a.results.signals if n.startswith(("plant.", "scenario.", "control."))]
    if names != [n for n in b.results.signals if n.startswith(("plant.", "scenario.", "control."))]:
        return False
    return all(
        a.results[n].shape == b.results[n].shape and (a.results[n] == b.results[n]).all()
        for n in names
    )
