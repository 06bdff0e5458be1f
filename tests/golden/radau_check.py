"""A second, independent solution: scalar equations (1)-(11) integrated by Radau with events.

Shares with the reference the parameters, the scenario and the ORDER of the clutch modes; every
equation is written out again and every event is located again by `solve_ivp`.
"""

from __future__ import annotations

from itertools import pairwise

import numpy as np
from hybrid import PARTS
from scipy.integrate import solve_ivp

SIGN_OF = {"disengaged": 0, "engaged": 2}


class ScalarPlant:
    """(1)-(11) as scalar equations; y = speeds (e d c1 c2 o w) and twists (d t1 t2 o)."""

    def __init__(self, params, scenario):
        self.p, self.scenario = params, scenario

    def inputs(self, t):
        """T_e, capacities at mu = 1 (2), grade and dry friction at the wheels."""
        te, x1, x2, grade, brake = self.scenario.at(t)
        n = [self.p.force(i, x) * self.p.r_n[i] for i, x in enumerate((x1, x2))]
        return te, n, grade, self.p.dry_load(brake, grade)

    def friction(self, i, mode, n, slip):
        """T_c of clutch `i` where it slips; `n` is its capacity at mu = 1."""
        return mode * self.p.kinetic(i, abs(slip)) * n if abs(mode) == 1 else 0.0

    def load(self, w, mode, u, t_o):
        """T_v; of wheels that are held, all that comes in."""
        if mode[2] == 2:
            return t_o
        return self.p.load_torque(w, u[2]) + (mode[2] * u[3] if mode[2] else 0.0)

    def start(self, engine_speed, omega):
        """Start values of y; `omega` is the speed of output and wheel [rad/s]."""
        shafts = [g * omega for g in self.p.ratio]
        return [engine_speed, engine_speed, *shafts, omega, omega] + [0.0] * 4

    def speeds(self, y):
        """The six speeds of a golden row."""
        return tuple(y[:6])

    def torques(self, y, mode, u):
        """T_d, T_c (2), T_t (2), T_o, T_v."""
        p, n = self.p, u[1]
        e, d, c1, c2, o, w, th_d, th_1, th_2, th_o = y
        t_d = p.k_d * th_d + p.c_d * (e - d)
        t_t = [
            p.k_t[i] * th + p.c_t[i] * (c / p.i_t[i] - p.i_f[i] * o)
            for i, (th, c) in enumerate(((th_1, c1), (th_2, c2)))
        ]
        t_o = p.k_o * th_o + p.c_o * (o - w)
        t_c = [self.friction(i, mode[i], n[i], d - (c1, c2)[i]) for i in range(2)]
        stuck = [i for i in range(2) if mode[i] == 2]
        reaction = {i: t_t[i] / p.i_t[i] for i in stuck}
        inertia = p.j_d + sum(p.j_c[i] for i in stuck)
        accel = (t_d - sum(t_c) - sum(reaction.values())) / inertia
        for i in stuck:
            t_c[i] = p.j_c[i] * accel + reaction[i]
        return t_d, t_c, t_t, t_o, self.load(w, mode, u, t_o)

    def rate(self, y, mode, u):
        """y' of the compliant plant."""
        p = self.p
        t_d, t_c, t_t, t_o, t_v = self.torques(y, mode, u)
        e, d, c1, c2, o, w = y[:6]
        return [
            (u[0] - t_d) / p.j_e,
            (t_d - t_c[0] - t_c[1]) / p.j_d,
            (t_c[0] - t_t[0] / p.i_t[0]) / p.j_c[0],
            (t_c[1] - t_t[1] / p.i_t[1]) / p.j_c[1],
            (sum(self.passed_on(i, t_t[i], o) for i in range(2)) - t_o) / p.j_o,
            (t_o - t_v) / p.j_v,
            *(e - d, c1 / p.i_t[0] - p.i_f[0] * o, c2 / p.i_t[1] - p.i_f[1] * o, o - w),
        ]

    def passed_on(self, i, t_t, o):
        """Torque of shaft `i` on the output, turning at `o` [rad/s], less what its gear loses."""
        eta = self.p.eta[i]
        return self.p.i_f[i] * t_t * (eta if t_t * o > 0 else 1 / eta)

    def guard(self, y, mode, u, i):
        """Positive while clutch `i` keeps its mode."""
        if mode[i] == 0:
            return 1.0
        if i == 2:
            return self.wheel_guard(y, mode, u)
        if mode[i] == 2:
            return self.p.mu_s[i] * u[1][i] - abs(self.torques(y, mode, u)[1][i])
        return mode[i] * (y[1] - self.speeds(y)[2 + i])

    def wheel_guard(self, y, mode, u):
        """Positive while the brake keeps its mode."""
        w = self.speeds(y)[5]
        if mode[2] == 2:
            return u[3] - abs(self.torques(y, mode, u)[3] - self.p.load_torque(w, u[2]))
        return mode[2] * w


class RigidScalarPlant(ScalarPlant):
    """The rigid variant, omega_ci = g_i omega_o; y = speeds (e d o w) and twists (d o)."""

    def start(self, engine_speed, omega):
        """Start values of y."""
        return [engine_speed, engine_speed, omega, omega, 0.0, 0.0]

    def speeds(self, y):
        """The six speeds of a golden row."""
        return y[0], y[1], self.p.ratio[0] * y[2], self.p.ratio[1] * y[2], y[2], y[3]

    def torques(self, y, mode, u):
        """T_d, T_c (2), no T_t, T_o, T_v."""
        p, n = self.p, u[1]
        e, d, o, w, th_d, th_o = y
        t_d, t_o = p.k_d * th_d + p.c_d * (e - d), p.k_o * th_o + p.c_o * (o - w)
        g = p.ratio
        t_c = [self.friction(i, mode[i], n[i], d - g[i] * o) for i in range(2)]
        if mode[0] == mode[1] == 2:  # both at rest: T_c1 + T_c2 = T_d, g1 T_c1 + g2 T_c2 = T_o
            t_c[0] = (t_o - g[1] * t_d) / (g[0] - g[1])
            t_c[1] = t_d - t_c[0]
        elif 2 in mode[:2]:
            i = mode.index(2)
            rest = t_c[1 - i]
            drive = g[i] * (t_d - rest) + g[1 - i] * rest - t_o
            accel = drive / (self.j_out() + g[i] ** 2 * p.j_d)
            t_c[i] = t_d - rest - p.j_d * g[i] * accel
        return t_d, t_c, None, t_o, self.load(w, mode, u, t_o)

    def j_out(self):
        """Inertia seen at the output shaft, J_o + g1^2 J_ct1 + g2^2 J_ct2 [kg·m²]."""
        p = self.p
        return p.j_o + p.ratio[0] ** 2 * p.j_c[0] + p.ratio[1] ** 2 * p.j_c[1]

    def rate(self, y, mode, u):
        """y' of the rigid plant."""
        p, g = self.p, self.p.ratio
        t_d, t_c, _, t_o, t_v = self.torques(y, mode, u)
        return [
            (u[0] - t_d) / p.j_e,
            (t_d - t_c[0] - t_c[1]) / p.j_d,
            (g[0] * t_c[0] + g[1] * t_c[1] - t_o) / self.j_out(),
            (t_o - t_v) / p.j_v,
            *(y[0] - y[1], y[2] - y[3]),
        ]


class RadauRun:
    """Integrates a case with the mode order of its events; fills `rows`, `times`."""

    def __init__(self, case, events, initial, rtol=1e-11, atol=1e-12):
        plant = RigidScalarPlant if case.rigid else ScalarPlant
        self.case, self.plant = case, plant(case.simulation().plant.p, case.scenario)
        self.pending = [event for event in events if event["clutch"] in PARTS]
        self.mode = list(initial)
        self.tolerances = {"rtol": rtol, "atol": atol, "method": "Radau"}
        omega = case.vehicle_speed / self.plant.p.r_w
        self.y = np.array(self.plant.start(case.engine_speed, omega))
        self.rows, self.times = [], []

    def run(self, stop=None):
        """Advance over the pieces of the case up to `stop` [s]."""
        for piece in self._merged(stop or self.case.stop):
            self._advance(piece)
        return self

    def _merged(self, stop):
        # Held inputs restart each step; continuous ones only where they bend.
        if self.case.h is not None:
            pieces = self.case.pieces(self.plant.p, longest=self.case.h)
            return [(p.start, p.end, p.sample) for p in pieces if p.end <= stop + 1e-9]
        kinks = [t for t in self.case.scenario.kinks(self.plant.p, stop) if t < stop]
        edges = np.unique(np.concatenate([[0.0], np.round(kinks, 13), np.arange(stop + 1e-9)]))
        edges = np.append(edges[edges < stop - 1e-9], stop)
        return [(a, b, None) for a, b in pairwise(edges)]

    def _advance(self, piece):
        t, end, sample = piece
        while self.pending and self.pending[0]["time"] <= t + 1e-9:
            self._apply(self.pending.pop(0), None)
        while t < end:
            due = [e for e in self.pending if e["time"] < end - 1e-9]
            t = self._integrate(t, end, sample, due[0] if due else None)
            if due:
                self._apply(self.pending.pop(0), t)

    def _apply(self, event, found):
        self.mode[PARTS.index(event["clutch"])] = SIGN_OF.get(event["to"], event["direction"])
        if found is not None:
            self.times.append((event["time"], found))

    def _integrate(self, t, end, sample, due):
        def u(time):
            return self.plant.inputs(time if sample is None else sample)

        def crossing(time, y):
            return self.plant.guard(y, self.mode, u(time), PARTS.index(due["clutch"]))

        crossing.terminal, crossing.direction = True, -1
        grid = self._row_times(t, end)
        sol = solve_ivp(
            *(lambda time, y: self.plant.rate(y, self.mode, u(time)), (t, end), self.y),
            **self.tolerances,
            t_eval=np.unique(np.append(grid, end)),
            events=[crossing] if due else None,
        )
        last = sol.t_events[0][0] if due else end
        keep = grid[grid <= last]
        for time, y in zip(keep, np.asarray(sol.y).T, strict=False):
            self._record(time, y, u(time))
        self.y = sol.y_events[0][0] if due else sol.y[:, -1]
        return last

    def _row_times(self, t, end):
        first = int(np.floor(t / self.case.row_every + 1e-6)) + 1
        last = int(np.floor(end / self.case.row_every + 1e-9))
        grid = np.minimum(np.arange(first, last + 1) * self.case.row_every, end)
        return np.unique(np.append(grid, end)) if end > self.case.stop - 1e-9 else grid

    def _record(self, time, y, u):
        t_d, t_c, _, t_o, t_v = self.plant.torques(y, self.mode, u)
        self.rows.append((time, *self.plant.speeds(y), t_d, *t_c, t_o, t_v))
