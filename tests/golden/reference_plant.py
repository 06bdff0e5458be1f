"""Dual-clutch driveline (1)-(11) as matrices, one set per clutch-mode combination.

An independent reference: written from the paper's equations, not from any other code here.
With `x` the state and `v = [T_e, T_c1, T_c2, T_v, T_s1, T_s2]` the torques, the plant is

    x' = A0 x + B0 v

and an engaged clutch replaces its column of `v` by the constraint torque that keeps
d/dt (omega_d - omega_ci) = 0. Both clutches engaged is the 2x2 case of the same formula.

Compliant state (10): omega_e omega_d omega_c1 omega_c2 omega_o omega_w [rad/s] and the twists
th_d th_t1 th_t2 th_o [rad]. Rigid state (6): omega_e omega_d omega_o omega_w th_d th_o.
"""

from __future__ import annotations

from dataclasses import dataclass, field, replace

import numpy as np

OPEN, ENGAGED = 0, 2  # a slipping clutch is its sign, +1 or -1
PAPER_MAPS_MM = (
    ((0, 2, 3, 4, 5, 6, 7, 8, 9, 10), (0, 0, 250, 700, 1350, 2200, 3300, 4700, 6400, 8500)),
    ((0, 2.2, 3, 4, 5, 6, 7, 8, 9, 10), (0, 0, 220, 680, 1330, 2200, 3350, 4800, 6600, 8800)),
)


@dataclass(frozen=True)
class Params:
    """Parameters of the plant, SI; the values are the preset `paper`."""

    rigid: bool = False
    j_e: float = 0.745
    j_d: float = 0.0165
    j_c: tuple = (0.1, 0.1)
    j_o: float = 0.04
    j_v: float = 134.6
    k_d: float = 600.0
    c_d: float = 1.5
    k_t: tuple = (3e4, 3e4)
    c_t: tuple = (20.0, 20.0)
    k_o: float = 4887.0
    c_o: float = 567.0
    i_t: tuple = (3.0, 2.4)
    i_f: tuple = (6.0, 4.8)
    odd_gears: tuple = (3.0,)  # i_t of gears 1, 3, 5, 7
    even_gears: tuple = (2.4,)  # i_t of gears 2, 4, 6, 8
    i_r: tuple = (0.0, 0.0)  # i_t of reverse, gear -1
    odd_eta: tuple = (1.0, 1.0, 1.0, 1.0)  # efficiencies of gears 1, 3, 5, 7
    even_eta: tuple = (1.0, 1.0, 1.0, 1.0)  # of gears 2, 4, 6, 8
    eta_r: tuple = (1.0, 1.0)
    eta: tuple = (1.0, 1.0)  # of the gears that are in
    t_s: tuple = (100.0, 100.0)  # [N·m] synchronisers, at the input shafts
    r_n: tuple = (0.095, 0.095)
    mu_k: tuple = (0.26, 0.22)
    mu_s: tuple = (0.30, 0.25)
    mass: float = 1500.0
    r_w: float = 0.30
    rho: float = 1.20
    area: float = 2.2
    c_drag: float = 0.32
    c_rr: float = 0.013
    g: float = 9.81
    v_eps: float = 0.05  # 0: rolling resistance is dry friction
    maps_mm: tuple = field(default=PAPER_MAPS_MM)
    heat: tuple | None = None  # per clutch a thermal node, see thermal.py
    curves: tuple = (None, None)  # per clutch (|slip| [rad/s], factor on mu_k), or no table

    @property
    def ratio(self):
        """Total ratios g_i = i_ti i_fi [-], shape (2)."""
        return tuple(a * b for a, b in zip(self.i_t, self.i_f, strict=True))

    def gear_ratio(self, i, gear):
        """i_t of a gear on shaft `i` [-]: 0 in neutral, below 0 in reverse (gear -1)."""
        if gear == -1:
            return -self.i_r[i]
        return (self.odd_gears, self.even_gears)[i][(gear - i - 1) // 2] if gear else 0.0

    def gear_efficiency(self, i, gear):
        """Efficiency of a gear on shaft `i` [-]; 1 in neutral."""
        if gear == -1:
            return self.eta_r[i]
        return (self.odd_eta, self.even_eta)[i][(gear - i - 1) // 2] if gear else 1.0

    def in_gears(self, gears):
        """The same vehicle with other gears in, shape (2)."""
        ratios = tuple(self.gear_ratio(i, gears[i]) for i in range(2))
        return replace(self, i_t=ratios, eta=tuple(map(self.gear_efficiency, (0, 1), gears)))

    @property
    def lossy(self):
        """Whether some gear loses power."""
        return min(*self.odd_eta, *self.even_eta, *self.eta_r) < 1.0

    def force(self, i, position):
        """Normal force of clutch `i` [N] at `position` [m], piecewise linear, constant outside."""
        stroke, force = self.maps_mm[i]
        return np.interp(np.asarray(position) * 1e3, stroke, force)

    def kinetic(self, i, slip):
        """Friction coefficient of clutch `i` slipping at |slip| [rad/s]."""
        curve = self.curves[i]
        return self.mu_k[i] * (1.0 if curve is None else np.interp(slip, *curve))

    def load_torque(self, omega_w, grade):
        """Smooth part of the load torque T_v [N·m], (11), positive against forward motion."""
        v = self.r_w * omega_w
        weight = self.mass * self.g
        roll = 0.0
        if self.v_eps > 0:
            roll = weight * np.cos(grade) * self.c_rr * np.tanh(v / self.v_eps)
        drag = 0.5 * self.rho * self.area * self.c_drag * v * np.abs(v)
        return self.r_w * (weight * np.sin(grade) + drag + roll)

    def dry_load(self, brake, grade):
        """Dry friction at the wheels [N·m]: the brake, and rolling resistance where v_eps is 0."""
        roll = self.mass * self.g * np.cos(grade) * self.c_rr * self.r_w
        return brake + (0.0 if self.v_eps > 0 else roll)


class Plant:
    """The open plant: `a0`, `b0` and the rows that read torques, slips and speeds from `x`.

    Attributes
    ----------
    a0, b0 : ndarray, shapes (n, n) and (n, 6); synchronisers act with the ratios `rubbing`
    mass_matrix : ndarray, shape (n), the inertia of each speed state, 0 for twists
    springs : list of (row of the twist, row of the rate, stiffness, damping)
    slip : ndarray, shape (2, n), omega_d - omega_ci
    sliding : ndarray, shape (3, n), the slips and, for the brake, omega_w
    speeds : ndarray, shape (6, n), the six FMI speeds

    `power` is the direction of the power in each shaft's gear: 1 towards the output, -1 from it, 0
    where it is not counted. `jammed`: the output stands.
    """

    def __init__(self, p: Params, rubbing=(0.0, 0.0), power=(0, 0), jammed=False):
        self.p, self.power, self.jammed = p, power, jammed
        if p.rigid and 0 in p.i_t:
            raise ValueError("the rigid reference has no neutral")
        names = ["e", "d", "o", "w"] if p.rigid else ["e", "d", "c1", "c2", "o", "w"]
        twists = ["th_d", "th_o"] if p.rigid else ["th_d", "th_t1", "th_t2", "th_o"]
        self.n = len(names) + len(twists)
        unit = dict(zip(names + twists, np.eye(self.n), strict=True))
        if p.rigid:
            unit |= {f"c{i + 1}": p.ratio[i] * unit["o"] for i in range(2)}
        self.unit, self.twists = unit, twists
        self.synchronised = np.array([unit[f"c{i + 1}"] - rubbing[i] * unit["o"] for i in range(2)])
        self.rubs = [g != 0 for g in rubbing]
        self.speeds = np.array([unit[k] for k in ("e", "d", "c1", "c2", "o", "w")])
        self.slip = np.array([unit["d"] - unit["c1"], unit["d"] - unit["c2"]])
        self.sliding = np.vstack([self.slip, unit["w"]])
        self.mass_matrix = self._masses(names)
        self.springs = self._springs()
        self.row_w = int(np.argmax(unit["w"]))
        self._assemble()

    def _masses(self, names):
        p = self.p
        j_out = p.j_o + sum(p.ratio[i] ** 2 * p.j_c[i] for i in range(2))
        inertia = {"e": p.j_e, "d": p.j_d, "c1": p.j_c[0], "c2": p.j_c[1], "w": p.j_v}
        inertia["o"] = j_out if p.rigid else p.j_o
        return np.array([inertia[k] for k in names] + [0.0] * len(self.twists))

    def _springs(self):
        p, u = self.p, self.unit
        out = [(u["th_d"], u["e"] - u["d"], p.k_d, p.c_d)]
        if not p.rigid:
            for i in range(2):
                cut = np.zeros(self.n)
                rate = u[f"c{i + 1}"] / p.i_t[i] - p.i_f[i] * u["o"] if p.i_t[i] else cut
                out.append((u[f"th_t{i + 1}"], rate, p.k_t[i], p.c_t[i]))
        return [*out, (u["th_o"], u["o"] - u["w"], p.k_o, p.c_o)]

    def _assemble(self):
        # A spring acts on each inertia through the transpose of its own rate row (virtual work).
        moving = self.mass_matrix > 0
        inv = np.where(moving, 1 / np.where(moving, self._effective_mass(), 1.0), 0.0)
        inv = np.where(self.unit["o"] > 0, 0.0, inv) if self.jammed else inv
        self.inv_mass = inv
        self.a0 = np.zeros((self.n, self.n))
        for (twist, rate, k, c), lost in zip(self.springs, self._losses(), strict=True):
            self.a0 += np.outer(twist, rate) - np.outer(inv * (rate + lost), k * twist + c * rate)
        acts = [self.unit["e"], *(self._clutch_action(i) for i in range(2)), -self.unit["w"]]
        acts += [-self.rubs[i] * self.synchronised[i] for i in range(2)]
        self.b0 = inv[:, None] * np.column_stack(acts)
        (td, rd, kd, cd), (to, ro, ko, co) = self.springs[0], self.springs[-1]
        self.damper_row = kd * td + cd * rd
        self.shaft_row = ko * to + co * ro

    def _share_lost(self, i):
        """What the gear of shaft `i` does not pass on, 1 - eta^s."""
        return 1 - self.p.eta[i] ** self.power[i]

    def _effective_mass(self):
        """Inertias; a lossy gear of a rigid shaft passes on less of what turns the shaft."""
        mass = self.mass_matrix.copy()
        if self.p.rigid:
            parts = [self._share_lost(i) * self.p.ratio[i] ** 2 * self.p.j_c[i] for i in range(2)]
            mass -= sum(parts) * self.unit["o"]
        return mass

    def _clutch_action(self, i):
        """What a clutch torque acts on: damper and shaft or, if rigid, the output behind it."""
        lost = self._share_lost(i) * self.p.ratio[i] * self.unit["o"] if self.p.rigid else 0.0
        return -self.slip[i] - lost

    def _losses(self):
        """What is missing of every spring's action on the inertias, per unit of its torque."""
        none = np.zeros(self.n)
        if self.p.rigid:
            return [none] * len(self.springs)
        missing = [self._share_lost(i) for i in range(2)]
        return [none, *(self.p.i_f[i] * missing[i] * self.unit["o"] for i in range(2)), none]

    def mesh_torque(self, i, clutch_torque, output_rate):
        """i_f T_t of shaft `i` of the rigid plant [N·m], its clutch's torque less what turns it."""
        g = self.p.ratio[i]
        return g * (clutch_torque - self.p.j_c[i] * g * output_rate)

    def rigid_mesh_power(self, torques, output_rate, output_speed):
        """Power lost in the gears of the rigid plant [W]; `torques`: T_c1, T_c2, shape (..., 2)."""
        parts = (
            self._share_lost(i) * self.mesh_torque(i, torques[..., i], output_rate)
            for i in range(2)
        )
        return sum(parts) * output_speed

    def energy(self, x):
        """Stored energy [J], kinetic and elastic, of `x` with shape (..., n)."""
        x = np.asarray(x)
        kinetic = 0.5 * np.sum(self.mass_matrix * x**2, axis=-1)
        return kinetic + sum(0.5 * k * (x @ twist) ** 2 for twist, _, k, _ in self.springs)

    def damping_power(self, x):
        """Power lost in dampers and gears [W] for `x` with shape (..., n)."""
        power = sum(c * (x @ rate) ** 2 for _, rate, _, c in self.springs)
        for (twist, rate, k, c), lost in zip(self.springs, self._losses(), strict=True):
            power = power + (x @ (k * twist + c * rate)) * (x @ lost)
        return power

    def start(self, engine_speed, vehicle_speed):
        """Start state: omega_d = omega_e, omega_o = omega_w = V / r_w, twists 0."""
        omega = vehicle_speed / self.p.r_w
        values = {"e": engine_speed, "d": engine_speed, "o": omega, "w": omega}
        if not self.p.rigid:
            values |= {f"c{i + 1}": self.p.ratio[i] * omega for i in range(2)}
        return sum(value * self.unit[name] for name, value in values.items())


class ModeSystem:
    """The plant with one mode for each clutch and the brake: x' = a x + b v.

    T_c1, T_c2 and T_v are gx x + gv v; `v` carries T_e, the friction torque of slipping clutches,
    T_v and the torques of synchronisers; what it carries for an engaged clutch or for wheels that
    are held does not act.
    """

    def __init__(self, plant: Plant, mode):
        stuck = [i for i in range(3) if mode[i] == ENGAGED]
        self.mode = tuple(mode)
        self.gx, self.gv = np.zeros((3, plant.n)), np.zeros((3, 6))
        free = plant.b0.copy()
        for i in range(3):
            if mode[i] == ENGAGED:
                free[:, 1 + i] = 0.0
            else:
                self.gv[i, 1 + i] = 1.0
        if stuck:
            s = plant.sliding[stuck]
            gain = -np.linalg.inv(s @ plant.b0[:, [1 + i for i in stuck]])
            self.gx[stuck], self.gv[stuck] = gain @ s @ plant.a0, gain @ s @ free
        held = plant.b0[:, 1:4]
        self.a = plant.a0 + held @ self.gx
        self.b = np.where(np.isin(np.arange(6), (0, 4, 5)), plant.b0, 0.0) + held @ self.gv
