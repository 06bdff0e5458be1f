"""The control-oriented model (12)-(16), and the conventional one without damping (Figs. 4, 5).

    x3' = k x2 + c x2',   x2' = −b x3 + g1/(g2 J) T_c1 + T_c2/J + T_v/J_v,   J = J_ct2,eq of (13)

x1 does not act on x2 and x3, so it is left out: what the figures compare is the drive-shaft torque.
"""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np


@dataclass(frozen=True)
class Reduced:
    """Inertias [kg·m²], total ratios g1, g2, stiffness [N·m/rad], damping [N·m·s/rad]."""

    clutch_inertia: tuple[float, float]
    output_inertia: float
    wheel_inertia: float
    ratios: tuple[float, float]
    stiffness: float
    damping: float

    @property
    def gearbox(self) -> float:
        """J_ct2,eq of (13)."""
        (j1, j2), (g1, g2) = self.clutch_inertia, self.ratios
        return g2 * j2 + g1**2 / g2 * j1 + self.output_inertia / g2

    def undamped(self) -> Reduced:
        """Return the conventional model: c_o,eq = 0."""
        return replace(self, damping=0.0)


TABLE_1 = Reduced((0.1, 0.1), 0.04, 134.6, (18.0, 11.52), 4887.0, 567.0)


def simulate(
    model: Reduced, step: float, clutches: np.ndarray, load: np.ndarray, start: tuple[float, float]
) -> np.ndarray:
    """Return x3 = T_o [N·m], shape (n,), exactly for torques that are linear between samples.

    Parameters
    ----------
    step
        Sampling step [s].
    clutches
        T_c1, T_c2 [N·m], shape (n, 2).
    load
        T_v [N·m], shape (n,).
    start
        x2 [rad/s] and x3 [N·m] of the first sample.
    """
    (g1, g2), j = model.ratios, model.gearbox
    b = 1 / (g2 * j) + 1 / model.wheel_inertia
    k, c = model.stiffness, model.damping
    a = np.array([[0.0, -b], [k, -c * b]])
    driven = clutches @ np.array([g1 / (g2 * j), 1 / j]) + load / model.wheel_inertia
    whole, ends = _discrete(a, np.array([1.0, c]), step)
    x = np.array(start, dtype=float)
    found = np.empty(len(driven))
    for n, (now, then) in enumerate(zip(driven, np.append(driven[1:], driven[-1]), strict=True)):
        found[n] = x[1]
        x = whole @ x + ends[0] * now + ends[1] * then
    return found


def _discrete(a: np.ndarray, b: np.ndarray, step: float) -> tuple[np.ndarray, np.ndarray]:
    """Return Φ and the weights of an input at both ends of a step, by a series of exp(A h)."""
    power, whole, mean, late = np.eye(2), np.zeros((2, 2)), np.zeros((2, 2)), np.zeros((2, 2))
    for n in range(20):
        whole += power  # Σ (A h)ⁿ/n!
        mean += power / (n + 1)  # Σ (A h)ⁿ/(n+1)!
        late += power / ((n + 1) * (n + 2))  # Σ (A h)ⁿ/(n+2)!
        power = power @ a * (step / (n + 1))
    return whole, np.array([step * (mean - late) @ b, step * late @ b])
