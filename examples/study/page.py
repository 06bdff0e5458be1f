"""Writes docs/pages/study.md, its picture and the rows it is made of, from the shipped study.

    dct-harness sweep examples/study/robustness.toml --jobs 2 --out target/study/robustness
    python examples/study/page.py target/study/robustness    # after a new study
    python examples/study/page.py                            # from the rows that are kept here

The rows kept are those columns that the page needs, in `robustness.parquet`; every figure of the
page is computed from them.
"""

from __future__ import annotations

import json
import string
import sys
from pathlib import Path
from typing import Any

import matplotlib as mpl
import numpy as np
import pyarrow as pa
from dct_harness.kpi.table import number
from dct_harness.report.study_data import Shown, StudyData, pairs
from dct_harness.report.study_numbers import crossing, heat, sensitivity, summary
from matplotlib import colors
from matplotlib import pyplot as plt
from pyarrow import parquet

HERE = Path(__file__).resolve().parent
ROWS, PLAN = HERE / "robustness.parquet", HERE / "robustness.json"
PAGES = HERE.parents[1] / "docs/pages"
PICTURE = "assets/study.png"
SMALL = 0.02  # a total index below it is not told
COLOURS = colors.LinearSegmentedColormap.from_list(
    "limit", ["#1f6fae", "#9cc7e6", "#f7f4ee", "#f3b07a", "#b3450b"])  # fmt: skip
TEMPLATE = HERE / "page.md"


def keep(folder: Path) -> None:
    """Keep what the page needs of a sweep's folder."""
    data = StudyData.read(folder)
    wanted = {"run", "verdict", *(f["name"] for f in data.factors)}
    wanted |= {f"{s.kpi.key}/{s.signal}/{x.estimate}" for s in data.shown for x in s.series}
    rows = [{n: v for n, v in row.items() if n in wanted} for row in data.rows]
    parquet.write_table(pa.Table.from_pylist(rows), ROWS, compression="zstd")
    PLAN.write_text(json.dumps(data.plan, indent=1, ensure_ascii=False) + "\n", encoding="utf-8")


def load() -> StudyData:
    """Return the study that is kept."""
    plan = json.loads(PLAN.read_text(encoding="utf-8"))
    return StudyData(plan, parquet.ParquetFile(ROWS).read().to_pylist(), HERE)


def table(head: list[str], rows: list[list[str]]) -> str:
    """Return a table in Markdown."""
    lines = [head, ["---"] * len(head), *rows]
    return "\n".join(f"| {' | '.join(line)} |" for line in lines)


def shares(data: StudyData) -> str:
    """Return median, 95 % quantile, worst and share within the limit, per method and torque."""
    head, rows = ["method"], dict[str, list[str]]()
    for shown in data.shown:
        head += [
            f"{shown.signal}: median / 95 % / worst [{shown.kpi.unit}]",
            f"≤\u00a0{shown.limit:g}\u00a0%",
        ]
        for s in shown.series:
            told = summary(shown, s)
            spread = " / ".join(number(told[key], 3) for key in ("median", "high", "worst"))
            cells = [spread, f"{_percent(told['share'])}\u00a0%"]
            rows.setdefault(s.label, []).extend(cells)
    return table(head, [[name, *cells] for name, cells in rows.items()])


def _percent(share: float) -> str:
    """Return a share in whole percent; all that is not all is below 100."""
    return "100" if share == 1 else f"{min(100 * share, 99.9):.3g}"


def breaking(data: StudyData, shown: Shown) -> str:
    """Return where the median of each method passes the limit, along each factor."""
    rows = []
    for s in shown.series:
        columns = (data.column(f["name"])[s.rows] for f in data.factors)
        rows.append([s.label, *(crossing(shown, x, s.values) for x in columns)])
    return table(["method", *map(title, data.factors)], rows)


def causes(data: StudyData, shown: Shown) -> str:
    """Return total Sobol indices of each method."""
    head = ["method", *map(title, data.factors)]
    rows = []
    for s in shown.series:
        found = sensitivity(data, s)
        if found is None or found.total is None or found.total_conf is None:
            continue
        cells = [f"{v:.2f} ± {c:.2f}" if v > SMALL else f"< {SMALL:g}"
                 for v, c in zip(found.total, found.total_conf, strict=True)]  # fmt: skip
        rows.append([s.label, *cells])
    return table(head, rows)


def title(factor: dict[str, Any]) -> str:
    """Return what people call a factor."""
    return factor["label"] + (f" [{factor['unit']}]" if factor["unit"] else "")


def picture(data: StudyData, shown: Shown, path: Path) -> None:
    """Draw the heat map of a torque, a panel per method."""
    mpl.use("Agg")
    first, second = pairs(data.plan)[0]
    x, y = data.column(first), data.column(second)
    maps = [heat(x[s.rows], y[s.rows], s.values) for s in shown.series]
    every = np.concatenate([m.medians[np.isfinite(m.medians)] for m in maps])
    limit = shown.limit or float(np.median(every))
    reach = float(np.exp(np.abs(np.log(every / limit)).max()))
    norm = colors.LogNorm(limit / reach, limit * reach)
    figure, axes = plt.subplots(
        1, len(maps), figsize=(12.5, 3.1), sharey=True, layout="constrained"
    )
    for axis, s, found in zip(axes, shown.series, maps, strict=True):
        shades = axis.pcolormesh(found.x, found.y, found.medians, cmap=COLOURS, norm=norm)
        for row, column in np.ndindex(found.medians.shape):
            value = found.medians[row, column]
            middle = [(e[k] + e[k + 1]) / 2 for e, k in ((found.x, column), (found.y, row))]
            if np.isfinite(value):
                axis.text(*middle, number(float(value), 2), ha="center", va="center", fontsize=7)
        axis.set_title(s.label, fontsize=10)
        axis.set_xlabel(title(data.factor(first)), fontsize=8)
        axis.tick_params(labelsize=8)
    axes[0].set_ylabel(title(data.factor(second)), fontsize=8)
    bar = figure.colorbar(
        shades, ax=axes, label=f"median error of {shown.signal} [{shown.kpi.unit}]"
    )
    ticks = [t for t in (0.5, 1, 2, 5, 10, 20, 50, 100) if limit / reach <= t <= limit * reach]
    bar.set_ticks(ticks, labels=[f"{t:g}" for t in ticks])
    bar.minorticks_off()
    bar.ax.tick_params(labelsize=8)
    figure.savefig(path, dpi=110, metadata={"Software": None})
    plt.close(figure)


def page(data: StudyData) -> str:
    """Return the page."""
    shaft = next(s for s in data.shown if s.signal == "driveShaft.torque")
    drawn = "\n".join(f"- {title(f)}: {f['given'][0]:g} to {f['given'][1]:g}" for f in data.factors)
    tables = "\n\n".join(f"{s.signal}:\n\n{breaking(data, s)}" for s in data.shown)
    return string.Template(TEMPLATE.read_text(encoding="utf-8")).substitute(
        runs=len(data.rows), count=len(data.factors), seed=data.plan["seed"], factors=drawn,
        limit=f"{shaft.limit:g}", shares=shares(data), picture=PICTURE, breaking=tables,
        causes=causes(data, shaft),
    )  # fmt: skip


def main() -> None:
    """Write page and picture."""
    if len(sys.argv) > 1:
        keep(Path(sys.argv[1]))
    data = load()
    (PAGES / "study.md").write_text(page(data), encoding="utf-8")
    shaft = next(s for s in data.shown if s.signal == "driveShaft.torque")
    picture(data, shaft, PAGES / PICTURE)


if __name__ == "__main__":
    main()
