"""The drive shaft of a run: identified in its launch (Fig. 3), simulated with and without damping.

Everything comes from the run's own signals and the plant's parameters; a plant under other names,
or a run whose gears change, has no such section.
"""

from __future__ import annotations

from typing import Any

import numpy as np

from .. import shaft
from ..errors import ConfigError
from . import figures, launch
from .runs import View

NOISE = (0.1, 2.0)  # rad/s on both speeds, N·m on T_o
SEED = 1
NEEDED = ("plant.clutch1.torque", "plant.clutch2.torque", "plant.clutch2.speed",
          "plant.wheel.speed", "plant.load.torque", "plant.driveShaft.torque")  # fmt: skip

Json = dict[str, Any]


def section(view: View) -> Json | None:
    """Return figures, what both models miss [% of RMS T_o], and fits with and without noise."""
    model = _model(view)
    if model is None:
        return None
    clean, noisy = (_data(view, model.ratios[1], noise) for noise in ((0.0, 0.0), NOISE))
    try:
        fits = [_fits(view, data) for data in (clean, noisy)]
    except ConfigError:
        return None
    truth = view.results["plant.driveShaft.torque"]
    found = {"observer": _torque(view, model), "map": _torque(view, model.undamped())}
    scale = np.sqrt(np.mean(truth**2))
    missed = {role: 100 * np.sqrt(np.mean((t - truth) ** 2)) / scale for role, t in found.items()}
    return {"view": view, "figure": _figure(view, truth, found), "missed": missed, "noise": NOISE,
            "fits": list(zip(*fits, strict=True)), "model": model,
            "launch": launch.figure(view, clean, noisy, fits[1])}  # fmt: skip


def _model(view: View) -> shaft.Reduced | None:
    """Return the model with the plant's parameters, for gears that stay."""
    plant = view.run.get("parameters", {}).get("plant", {})
    names = [f"scenario.shaft{i}.gear" for i in (1, 2)]
    if any(n not in view.results for n in (*NEEDED, *names)):
        return None
    gears = [view.results[n] for n in names]
    if any(np.ptp(gear) for gear in gears):
        return None
    try:
        ratios = [
            plant[f"shaft{i}.finalDriveRatio"]["value"]
            * plant[f"shaft{i}.gearRatio[{(int(gear[0]) + 1) // 2}]"]["value"]
            for i, gear in zip((1, 2), gears, strict=True)
        ]
        wanted = ("clutch1.inertia", "clutch2.inertia", "output.inertia", "vehicle.wheelInertia",
                 "driveShaft.stiffness", "driveShaft.damping")  # fmt: skip
        one, two, output, wheel, stiffness, damping = (plant[n]["value"] for n in wanted)
    except KeyError:
        return None
    if not all(ratios):
        return None
    return shaft.Reduced((one, two), output, wheel, tuple(ratios), stiffness, damping)


def _torque(view: View, model: shaft.Reduced) -> np.ndarray:
    r, (_, g2) = view.results, model.ratios
    clutches = np.column_stack([r[f"plant.clutch{i}.torque"] for i in (1, 2)])
    x2 = r["plant.clutch2.speed"][0] / g2 - r["plant.wheel.speed"][0]
    start = (float(x2), float(r["plant.driveShaft.torque"][0]))
    return shaft.simulate(model, view.run["step"], clutches, r["plant.load.torque"], start)


def _data(view: View, ratio: float, noise: tuple[float, float]) -> launch.Data:
    r, white = view.results, np.random.default_rng(SEED)
    speed, wheel, torque = (
        r[name] + size * white.standard_normal(len(r.time))
        for name, size in (("plant.clutch2.speed", noise[0]), ("plant.wheel.speed", noise[0]),
                           ("plant.driveShaft.torque", noise[1]))
    )  # fmt: skip
    return launch.Data(speed / ratio - wheel, torque)


def _fits(view: View, data: launch.Data) -> list[shaft.Fit]:
    time, window = view.results.time, shaft.Window()
    return [shaft.identify(time, *data, window, method) for method in shaft.METHODS]


def _figure(view: View, truth: np.ndarray, found: dict[str, np.ndarray]) -> Json | None:
    names = {"map": "without damping", "observer": "control-oriented (12)-(16)"}
    lines = [figures.trace(view, truth, "truth", "plant")]
    lines += [figures.trace(view, found[role], role, name) for role, name in names.items()]
    errors = [figures.trace(view, found[r] - truth, r, n) for r, n in names.items()]
    panels: list[Json] = [
        {"title": figures.TORQUE_TITLES["driveShaft.torque"], "traces": lines, "weight": 1.4},
        {"title": "error [N·m]", "traces": errors},
    ]
    caption = "Drive-shaft torque: plant, control-oriented model, model without damping"
    return figures.panelled("shaft", view, panels, caption, f"{caption}; {view.title}")
