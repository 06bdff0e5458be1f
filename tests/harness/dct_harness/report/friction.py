"""The coefficients of Figs. 11 and 13 from recorded signals.

T_c = (μ f) r N θ (21)-(24), so μ f = T_c / (r N θ). The observer records its adapted μ f and the
torque it makes of it, hence r N = T̂_c / (μ f θ) is known without asking the FMU.
"""

from __future__ import annotations

import numpy as np

from ..kpi.scopes import clutch_state
from ..results import Results

LEAST_TORQUE = 1.0  # N·m; below it the quotient for r N is noise


def coefficients(results: Results, clutch: str) -> dict[str, np.ndarray]:
    """Return `observer` (adapted), `map` (nominal), `truth`, each [N/m], shape (n,).

    NaN below the touch point, where no friction acts. What cannot be derived is left out.
    """
    adapted = f"observer.{clutch}.muF"
    position = position_of(results, clutch)
    if adapted not in results or position is None:
        return {}
    theta = results[position]
    by_map = f"observer.mapBased.{clutch}.torque"
    pressed = theta > 0
    if by_map in results:
        pressed &= results[by_map] != 0
    found = {"observer": np.where(pressed, results[adapted], np.nan)}
    radius = _radius(results, clutch, theta)
    if radius is None:
        return found
    stroke = np.where(pressed, theta * radius, np.nan)
    if by_map in results:
        found["map"] = np.abs(results[by_map]) / stroke
    truth = f"plant.{clutch}.torque"
    if truth in results:
        found["truth"] = _transmitting(results, clutch, results[truth] / stroke)
    return found


def position_of(results: Results, clutch: str) -> str | None:
    """Return the signal that holds the position of a clutch, scripted or controlled."""
    names = (f"scenario.{clutch}.position", f"control.{clutch}.position")
    return next((name for name in names if name in results), None)


def _radius(results: Results, clutch: str, theta: np.ndarray) -> float | None:
    """Return r_c N [m] as the median of T̂_c / (μ f θ)."""
    torque = f"observer.{clutch}.torque"
    if torque not in results:
        return None
    load = results[f"observer.{clutch}.muF"] * theta
    sound = (np.abs(results[torque]) > LEAST_TORQUE) & (load != 0)
    if not sound.any():
        return None
    return float(np.median(np.abs(results[torque][sound] / load[sound])))


def _transmitting(results: Results, clutch: str, values: np.ndarray) -> np.ndarray:
    """Blank the truth while the clutch is open."""
    state = clutch_state(results, clutch)
    return values if state is None else np.where(state == 1, np.nan, values)
