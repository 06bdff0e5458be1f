"""Figures of a study for study.js: plotly's data and layout; colours are names like `@method2`."""

from __future__ import annotations

import math
from typing import Any

import numpy as np

from .figures import escape
from .study_data import Json, Series, Shown, StudyData
from .study_numbers import Heat, Sensitivity, bands, curve, heat

COLOURS = ("observer", "map", "method3", "method2", "method4", "method5")
DASHES = ("solid", "dash", "dashdot", "dot", "longdash", "solid")
SYMBOLS = ("circle", "square", "diamond", "triangle-up", "cross", "x")
COLUMNS = 4
PANEL = 210  # px of height
TOP, BARE, BOTTOM = 70, 34, 56  # px above with and without a legend, and below
CELL_TEXT = 9  # px
OFFSET = 0.16  # of a bar's place, between first and total order


def colour(place: int) -> str:
    """Return the colour of a series."""
    return f"@{COLOURS[place % len(COLOURS)]}"


def axis(k: int) -> tuple[str, str]:
    """Return the names of the axes of panel k."""
    return f"x{k + 1 if k else ''}", f"y{k + 1 if k else ''}"


class Panels:
    """A figure of panels in rows and columns, filled one after the other."""

    def __init__(
        self, count: int, columns: int, height: int = PANEL, gap: float = 0.06, top: int = TOP
    ) -> None:
        self.columns = min(columns, max(1, count))
        self.rows = math.ceil(count / self.columns)
        self.data: list[Json] = []
        self.layout: Json = {"height": self.rows * height + top + BOTTOM, "annotations": [],
                             "shapes": [], "margin": {"t": top}}  # fmt: skip
        self._gap = gap
        self._inner = self.rows * height
        self._above = 66 if self.rows > 1 else 0  # px between rows: tick labels, title, heading

    def panel(self, k: int, heading: str, x: Json, y: Json) -> tuple[str, str]:
        """Lay out panel k; returns the names of its axes."""
        row, column = divmod(k, self.columns)
        width = (1 - self._gap * (self.columns - 1)) / self.columns
        gap = self._above / self._inner
        tall = (1 - gap * (self.rows - 1)) / self.rows
        left, top = column * (width + self._gap), 1 - row * (tall + gap)
        names = axis(k)
        across, upright = (f"{n[0]}axis{n[1:]}" for n in names)
        self.layout[across] = {"domain": [left, min(1.0, left + width)], "anchor": names[1], **x}
        self.layout[upright] = {"domain": [max(0.0, top - tall), top], "anchor": names[0], **y}
        if heading:
            self.layout["annotations"].append({
                "text": f"<b>{escape(heading)}</b>", "xref": "paper", "yref": "paper", "x": left,
                "y": top, "xanchor": "left", "yanchor": "bottom", "showarrow": False,
            })  # fmt: skip
        return names

    def line_at(self, names: tuple[str, str], value: float, name: str = "") -> None:
        """Draw a limit across a panel; with a name it stands in the legend."""
        line = {"color": "@bad", "width": 1.2, "dash": "dot"}
        self.layout["shapes"].append({
            "type": "line", "xref": f"{names[0]} domain", "yref": names[1], "x0": 0, "x1": 1,
            "y0": value, "y1": value, "line": line,
        })  # fmt: skip
        if name:
            self.data.append({"type": "scatter", "mode": "lines", "x": [None], "y": [None],
                              "xaxis": names[0], "yaxis": names[1], "name": name, "line": line,
                              "hoverinfo": "skip"})  # fmt: skip

    def figure(self, key: str, caption: str, aria: str) -> Json:
        """Return the figure."""
        return {"id": key, "caption": caption, "aria": aria, "data": self.data,
                "layout": self.layout, "height": self.layout["height"]}  # fmt: skip


def value_title(shown: Shown) -> str:
    """Return the name of a KPI's values with its unit."""
    return f"{shown.signal} [{shown.kpi.unit}]"


def _log(values: np.ndarray) -> Json:
    """Return a logarithmic axis with readable ticks."""
    good = values[np.isfinite(values) & (values > 0)]
    low, high = (math.log10(good.min()), math.log10(good.max())) if good.size else (0.0, 1.0)
    margin = 0.06 * (high - low) + 0.02
    ticks = [m * 10.0**e for e in range(-4, 7) for m in (1, 2, 5)]
    inside = [t for t in ticks if low - margin <= math.log10(t) <= high + margin]
    return {"type": "log", "range": [low - margin, high + margin], "tickvals": inside,
            "ticktext": [f"{t:g}" for t in inside]}  # fmt: skip


def curves(data: StudyData, shown: Shown) -> Json:
    """Return the median of a KPI over each factor, a line per series, all else random."""
    factors = data.factors
    made = {(f["name"], s.place): curve(data.column(f["name"])[s.rows], s.values)
            for f in factors for s in shown.series}  # fmt: skip
    limit = [] if shown.limit is None else [shown.limit]
    every = np.concatenate([*(y for _, y in made.values()), np.array(limit)])
    panels = Panels(len(factors), COLUMNS)
    for k, factor in enumerate(factors):
        first = k % panels.columns == 0
        names = panels.panel(
            k, "", {"title": {"text": escape(_title(factor))}},
            {**_log(every), "title": {"text": value_title(shown) if first else ""},
             "showticklabels": first})  # fmt: skip
        for s in shown.series:
            x, y = made[factor["name"], s.place]
            panels.data.append(_line(s, x, y, names, k == 0))
        if shown.limit is not None and shown.limit > 0:
            limit_name = f"limit {shown.limit:g} {shown.kpi.unit}"
            panels.line_at(names, shown.limit, "" if k else limit_name)
    caption = f"{shown.kpi.title}, {shown.signal}: median over each factor, all others at random"
    return panels.figure(f"curves-{shown.slug}", caption, caption)


def _title(factor: Json) -> str:
    return (factor["label"] or factor["name"]) + (f" [{factor['unit']}]" if factor["unit"] else "")


def _line(s: Series, x: np.ndarray, y: np.ndarray, names: tuple[str, str], legend: bool) -> Json:
    return {
        "type": "scatter", "mode": "lines+markers", "x": x.tolist(), "y": y.tolist(),
        "xaxis": names[0], "yaxis": names[1], "name": escape(s.label), "legendgroup": s.label,
        "showlegend": legend, "hovertemplate": f"{escape(s.label)}: %{{y:.3g}}<extra></extra>",
        "line": {"color": colour(s.place), "width": 1.8, "dash": DASHES[s.place % len(DASHES)]},
        "marker": {"symbol": SYMBOLS[s.place % len(SYMBOLS)], "size": 6,
                   "color": colour(s.place)},
    }  # fmt: skip


def heats(data: StudyData, shown: Shown, pair: tuple[str, str]) -> Json:
    """Return medians over two factors, a map per series; the colour turns at the limit."""
    x, y = (data.column(name) for name in pair)
    made = [heat(x[s.rows], y[s.rows], s.values) for s in shown.series]
    every = np.concatenate([h.medians.ravel() for h in made])
    good = every[np.isfinite(every) & (every > 0)]
    centre = math.log10(shown.limit or float(np.median(good)))
    reach = max(0.05, float(np.abs(np.log10(good) - centre).max()))
    panels = Panels(len(made), 5, 230, 0.03, BARE)
    for k, (s, h) in enumerate(zip(shown.series, made, strict=True)):
        titles = [escape(_title(data.factor(name))) for name in pair]
        first, last = k % panels.columns == 0, k + panels.columns >= len(made)
        names = panels.panel(
            k, s.label, {"title": {"text": titles[0] if last else ""}, "showgrid": False},
            {"title": {"text": titles[1] if first else ""}, "showticklabels": first,
             "showgrid": False})  # fmt: skip
        panels.data.append({**_cells(h), "xaxis": names[0], "yaxis": names[1],
                            "zmin": centre - reach, "zmax": centre + reach, "showscale": k == 0,
                            "colorbar": _scale(shown, centre, reach)})  # fmt: skip
    panels.layout["margin"]["r"] = 84
    caption = f"{shown.kpi.title}, {shown.signal}: median over two factors, all others at random"
    return panels.figure(f"heat-{shown.slug}-{'-'.join(pair)}", caption, caption)


def _cells(h: Heat) -> Json:
    logs = np.where(h.medians > 0, np.log10(np.where(h.medians > 0, h.medians, 1.0)), np.nan)
    text = [["" if not math.isfinite(v) else _short(v) for v in row] for row in h.medians.tolist()]
    return {
        "type": "heatmap", "x": h.x.tolist(), "y": h.y.tolist(), "text": text,
        "z": [[None if not math.isfinite(v) else v for v in row] for row in logs.tolist()],
        "texttemplate": "%{text}", "textfont": {"size": CELL_TEXT}, "xgap": 1, "ygap": 1,
        "colorscale": [[0, "#1f6fae"], [0.35, "#9cc7e6"], [0.5, "#f7f4ee"], [0.65, "#f3b07a"],
                       [1, "#b3450b"]],
        "hovertemplate": "%{text}<extra></extra>", "hoverongaps": False,
    }  # fmt: skip


def _short(value: float) -> str:
    return f"{value:.0f}" if value >= 9.95 else f"{value:.2g}"


def _scale(shown: Shown, centre: float, reach: float) -> Json:
    ticks = [m * 10.0**e for e in range(-4, 7) for m in (1, 2, 5)]
    inside = [t for t in ticks if abs(math.log10(t) - centre) <= reach]
    return {"title": {"text": f"[{shown.kpi.unit}]"}, "tickvals": [math.log10(t) for t in inside],
            "ticktext": [f"{t:g}" for t in inside], "thickness": 14, "outlinewidth": 0}  # fmt: skip


def sensitivities(data: StudyData, shown: Shown, found: list[tuple[Series, Sensitivity]]) -> Json:
    """Return indices of first and total order with their confidence, a panel per series."""
    names = [escape(f["label"] or f["name"]) for f in data.factors][::-1]
    places = np.arange(len(names), dtype=float)
    panels = Panels(len(found), 5, 46 + 30 * len(names), 0.025)
    for k, (s, indices) in enumerate(found):
        first = k % panels.columns == 0
        axes = panels.panel(
            k, s.label, {"range": [-0.08, 1.12], "title": {"text": "share of the variance"},
                         "tickvals": [0, 0.5, 1]},
            {"tickvals": places.tolist(), "ticktext": names, "showticklabels": first,
             "range": [-0.6, len(names) - 0.4], "automargin": True, "zeroline": False})  # fmt: skip
        rows = [("first order: alone", indices.first, indices.first_conf, OFFSET, "circle")]
        if indices.total is not None and indices.total_conf is not None:
            rows.append(("total: with others", indices.total, indices.total_conf, -OFFSET,
                         "diamond-open"))  # fmt: skip
        panels.data += [_dots(row, places, axes, k == 0) for row in rows]
    caption = f"{shown.kpi.title}, {shown.signal}: what its spread comes from (95 % confidence)"
    return panels.figure(f"sensitivity-{shown.slug}", caption, caption)


def _dots(row: tuple[Any, ...], places: np.ndarray, axes: tuple[str, str], legend: bool) -> Json:
    name, values, conf, offset, symbol = row
    shade = "@observer" if offset > 0 else "@map"
    return {
        "type": "scatter", "mode": "markers", "name": name, "legendgroup": name,
        "showlegend": legend, "x": values[::-1].tolist(), "y": (places + offset).tolist(),
        "xaxis": axes[0], "yaxis": axes[1], "hovertemplate": "%{x:.2f}<extra></extra>",
        "marker": {"symbol": symbol, "size": 9, "color": shade, "line": {"width": 1.6,
                                                                         "color": shade}},
        "error_x": {"type": "data", "array": conf[::-1].tolist(), "color": shade, "thickness": 1.4,
                    "width": 3},
    }  # fmt: skip


def courses(data: StudyData, runs: int) -> list[Json]:
    """Return percentile bands: the error of each kept estimate of a torque, else the signal."""
    _, names, values = data.courses(runs)
    if len(values) < 2:
        return []
    by_torque: dict[str, list[tuple[str, np.ndarray]]] = {}
    for k, name in enumerate(names[1:], 1):
        component, _, variable = name.partition(".")
        truth = f"plant.{variable}"
        if component == "plant" and any(n.endswith(f".{variable}") and n != name for n in names):
            by_torque.setdefault(variable, [])
        elif truth in names and component != "plant":
            error = values[:, :, k] - values[:, :, names.index(truth)]
            by_torque.setdefault(f"Error of {variable}", []).append((component, error))
        else:
            by_torque.setdefault(name, []).append((name, values[:, :, k]))
    time = values[0, :, 0]
    made = [(what, lines) for what, lines in by_torque.items() if lines]
    return [_bands(k, what, lines, time, len(values)) for k, (what, lines) in enumerate(made)]


def _bands(
    number: int, what: str, lines: list[tuple[str, np.ndarray]], time: np.ndarray, runs: int
) -> Json:
    """Return bands of a torque, a panel per estimate with one scale."""
    made = [(name, bands(values)) for name, values in lines]
    low = min(float(b[0].min()) for _, b in made)
    high = max(float(b[4].max()) for _, b in made)
    margin = 0.05 * (high - low or 1.0)
    panels = Panels(len(made), 3, 190, 0.04)
    for k, (name, found) in enumerate(made):
        first, last = k % panels.columns == 0, k + panels.columns >= len(made)
        axes = panels.panel(
            k, name, {"title": {"text": "time [s]" if last else ""},
                      "range": [float(time[0]), float(time[-1])]},
            {"range": [low - margin, high + margin], "showticklabels": first,
             "title": {"text": "[N·m]" if first and "torque" in what else ""}})  # fmt: skip
        panels.data += _band_traces(found, time, axes, k == 0)
    caption = f"{what}: percentiles over {runs} runs"
    return panels.figure(f"bands-{number}", caption, caption)


def _band_traces(
    found: np.ndarray, time: np.ndarray, axes: tuple[str, str], legend: bool
) -> list[Json]:
    """Return a wide and a narrow band and the median."""
    common = {"type": "scatter", "mode": "lines", "x": time.tolist(), "xaxis": axes[0],
              "yaxis": axes[1], "hoverinfo": "skip"}  # fmt: skip
    traces: list[Json] = []
    for low, high, name, shade in ((0, 4, "5 to 95 %", "26"), (1, 3, "25 to 75 %", "59")):
        edge = {"width": 0.5, "color": "@observer"}
        traces.append({**common, "y": found[low].tolist(), "line": edge, "showlegend": False})
        traces.append({**common, "y": found[high].tolist(), "line": edge, "fill": "tonexty",
                       "fillcolor": f"@observer{shade}", "name": name, "legendgroup": name,
                       "showlegend": legend})  # fmt: skip
    traces.append({**common, "y": found[2].tolist(), "name": "median", "legendgroup": "median",
                   "showlegend": legend, "line": {"width": 1.6, "color": "@map"}})  # fmt: skip
    return traces
