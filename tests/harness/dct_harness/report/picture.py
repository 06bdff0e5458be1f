"""A static picture of a run's torques, for a README. Needs the extra `dct-harness[picture]`."""

from __future__ import annotations

from pathlib import Path
from typing import Any

from ..errors import ConfigError
from ..kpi.scopes import STATES
from .downsample import m4
from .runs import View, load

STATE_COLOURS = {"slipping": "#f6e2c4", "engaged": "#d6e6f2"}
LINES = (
    ("plant.", "true", {"color": "#222222", "linewidth": 2.2}),
    ("observer.mapBased.", "map-based", {"color": "#c2570c", "linestyle": "--"}),
    ("observer.", "observer", {"color": "#0072b2"}),
)
PANELS = {
    "clutch1.torque": "$T_{c1}$ [N·m]", "clutch2.torque": "$T_{c2}$ [N·m]",
    "driveShaft.torque": "$T_o$ [N·m]",
}  # fmt: skip
SETTINGS: dict[Any, Any] = {
    "svg.hashsalt": "dct-harness", "svg.fonttype": "path", "font.size": 9,
    "axes.spines.top": False, "axes.spines.right": False,
}  # fmt: skip


def picture(run_dir: str | Path, path: str | Path) -> Path:
    """Draw true, map-based and observed torques of a run into `path` (.svg or .png).

    The same run gives the same bytes.

    Raises
    ------
    ConfigError
        matplotlib is not installed, or the run has no torque to draw.
    """
    try:
        import matplotlib
        from matplotlib.figure import Figure
    except ImportError as error:
        raise ConfigError("the picture needs `pip install dct-harness[picture]`") from error
    view = load([run_dir])[0]
    shown = [t for t in PANELS if any(p + t in view.results for p, _, _ in LINES)]
    if not shown:
        raise ConfigError(f"{run_dir}: no torque to draw")
    path = Path(path)
    path.parent.mkdir(parents=True, exist_ok=True)
    with matplotlib.rc_context(SETTINGS):
        figure = Figure(figsize=(8.4, 1.75 * len(shown) + 0.6), layout="constrained")
        axes = figure.subplots(len(shown), 1, sharex=True, squeeze=False)[:, 0]
        for axis, torque in zip(axes, shown, strict=True):
            _panel(axis, view, torque)
        _finish(figure, axes)
        metadata = {"Date": None} if path.suffix == ".svg" else {"Software": None}
        figure.savefig(path, metadata=metadata, dpi=150, facecolor="white")
    return path


def _panel(axis: Any, view: View, torque: str) -> None:
    for span in view.spans(torque.partition(".")[0]):
        if span["state"] in STATE_COLOURS:
            colour = STATE_COLOURS[span["state"]]
            axis.axvspan(span["x0"], span["x1"], color=colour, linewidth=0, label=span["state"])
    for prefix, label, style in LINES:
        if prefix + torque in view.results:
            values = view.results[prefix + torque]
            index = m4(values)
            axis.plot(view.results.time[index], values[index], label=label,
                      **{"linewidth": 1.2, **style})  # fmt: skip
    axis.set_ylabel(PANELS[torque])
    axis.grid(alpha=0.25)
    axis.margins(x=0)


def _finish(figure: Any, axes: Any) -> None:
    axes[-1].set_xlabel("time [s]")
    entries = dict(zip(*reversed(axes[0].get_legend_handles_labels()), strict=True))
    order = [label for _, label, _ in LINES] + list(STATES.values())
    labels = [label for label in order if label in entries]
    figure.legend([entries[label] for label in labels], labels, loc="outside upper center",
                  ncols=len(labels), frameon=False)  # fmt: skip
    figure.align_ylabels(axes)
