"""Fig. 3: the launch that the drive shaft is identified in, with what was found."""

from __future__ import annotations

from typing import Any, NamedTuple

import numpy as np

from .. import shaft
from .downsample import pack
from .runs import View

HEIGHT = 560  # px
MILLI = 1e3  # rad to mrad

Json = dict[str, Any]


class Data(NamedTuple):
    """What an identification reads: θ' [rad/s] and T_o [N·m], shape (n,) each."""

    rate: np.ndarray
    torque: np.ndarray


def figure(view: View, clean: Data, noisy: Data, fits: list[shaft.Fit]) -> Json:
    """Return T_o, θ' and θ over the window of `fits`, which were found in `noisy`."""
    time = view.results.time
    rows = (time >= fits[0].start) & (time <= fits[0].end)
    at = time[rows]
    found = {fit.method: fit for fit in fits}
    names = {
        "iv": ("observer", "k θ + c θ' by instrumental variables"),
        "paper": ("map", "by (18) as printed"),
    }

    def line(values: np.ndarray, role: str, name: str) -> Json:
        return {"role": role, "name": name, "x": pack(at), "y": pack(values)}

    def both(values: tuple[np.ndarray, np.ndarray]) -> list[Json]:
        return [
            line(values[0], "frozen", "measured, with noise"),
            line(values[1], "truth", "plant"),
        ]

    torques = both((noisy.torque[rows], clean.torque[rows]))
    rates = (noisy.rate[rows], clean.rate[rows])
    twists = [_twist(data.rate, time) for data in (noisy, clean)]
    angles = (twists[0][rows] * MILLI, twists[1][rows] * MILLI)
    torques += [line(_torque(clean, twists[1], found[m])[rows], *names[m]) for m in names]
    caption = "What the drive shaft is identified in: the launch, measured with noise"
    return {
        "id": f"launch-{view.slug}", "phases": [], "columns": 1, "caption": caption,
        "panels": [
            {"title": "T<sub>o</sub> drive shaft [N·m]", "traces": torques, "weight": 1.4},
            {"title": "θ' = x<sub>2</sub> [rad/s]", "traces": both(rates)},
            {"title": "θ [mrad]", "traces": both(angles)},
        ],
        "aria": f"{caption}; {view.title}", "height": HEIGHT, "across": "time [s]",
        "range": [float(at[0]), float(at[-1])],
    }  # fmt: skip


def _twist(rate: np.ndarray, time: np.ndarray) -> np.ndarray:
    """Return θ [rad], shape (n,): the integral of θ' by trapezes."""
    return np.concatenate([[0.0], np.cumsum(np.diff(time) * (rate[1:] + rate[:-1]) / 2)])


def _torque(clean: Data, twist: np.ndarray, fit: shaft.Fit) -> np.ndarray:
    """Return k θ + c θ' [N·m]: what the numbers that were found make of the true twist."""
    return fit.stiffness.value * twist + fit.damping.value * clean.rate
