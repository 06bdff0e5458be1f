"""The driveline as scalar equations (1)-(11), written out a second time for `radau_check.py`."""

from __future__ import annotations

import numpy as np

OUTPUT = 5  # after clutches, brake and synchronisers


class ScalarPlant:
    """(1)-(11) as scalar equations; y = speeds (e d c1 c2 o w) and twists (d t1 t2 o).

    `turns` is the sign of omega_o that gears with losses were found to have, 0 while they are
    jammed, None where omega_o itself tells.
    """

    turns, output = None, 4  # where omega_o is in y

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
            p.k_t[i] * th + p.c_t[i] * self.twist_rate(i, c, o)
            for i, (th, c) in enumerate(((th_1, c1), (th_2, c2)))
        ]
        t_o = p.k_o * th_o + p.c_o * (o - w)
        t_c = [self.friction(i, mode[i], n[i], d - (c1, c2)[i]) for i in range(2)]
        stuck = [i for i in range(2) if mode[i] == 2]
        reaction = {i: self.reaction(i, t_t[i]) for i in stuck}
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
        driving = sum(self.passed_on(i, t_t[i], o) for i in range(2))
        return [
            (u[0] - t_d) / p.j_e,
            (t_d - t_c[0] - t_c[1]) / p.j_d,
            (t_c[0] - self.reaction(0, t_t[0])) / p.j_c[0],
            (t_c[1] - self.reaction(1, t_t[1])) / p.j_c[1],
            0.0 if self.turns == 0 else (driving - t_o) / p.j_o,
            (t_o - t_v) / p.j_v,
            *(e - d, self.twist_rate(0, c1, o), self.twist_rate(1, c2, o), o - w),
        ]

    def twist_rate(self, i, c, o):
        """Rate of the twist of transfer shaft `i`."""
        return c / self.p.i_t[i] - self.p.i_f[i] * o

    def reaction(self, i, t_t):
        """Torque of transfer shaft `i` on its input shaft."""
        return t_t / self.p.i_t[i]

    def passed_on(self, i, t_t, o):
        """Torque of shaft `i` on the output, turning at `o` [rad/s], less what its gear loses."""
        return self.p.i_f[i] * t_t * self.share(i, t_t, o)

    def share(self, i, torque, o):
        """What the gear of shaft `i` passes on of `torque`, eta or 1 / eta."""
        eta = self.p.eta[i]
        return eta if torque * (self.turns or o) > 0 else 1 / eta

    def turn(self, direction, y):
        """The output goes on in `direction` (0: it jams, None: gears are out); returns y."""
        self.turns = direction
        if direction == 0:
            y = np.array(y)
            y[self.output] = 0.0
        return y

    def meshes(self, y, mode, u):
        """i_f T_t of both shafts, T_o."""
        _, _, t_t, t_o, _ = self.torques(y, mode, u)
        return [self.p.i_f[i] * t_t[i] for i in range(2)], t_o

    def output_guard(self, y, mode, u):
        """Positive while the output turns on, or stays jammed."""
        if self.turns:
            return self.turns * y[self.output]
        torque, t_o = self.meshes(y, mode, u)
        eta = self.p.eta
        weak, strong = (
            sum(pick(torque[i] * eta[i], torque[i] / eta[i]) for i in range(2)) - t_o
            for pick in (min, max)
        )
        return min(-weak, strong)  # driven forward by `weak` or backward by `strong`, it gives way

    def guard(self, y, mode, u, i):
        """Positive while clutch `i`, the brake (2) or the output (5) keeps its mode."""
        if i == OUTPUT:
            return self.output_guard(y, mode, u)
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

    output = 2

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


class GearedScalarPlant(ScalarPlant):
    """`ScalarPlant` whose gears go out, are synchronised and come in.

    A shaft without a gear has i_t = 0. `rub` is the sign of a synchroniser that works, else 0, and
    `wanted` the gear that it leads to.
    """

    def __init__(self, params, scenario, gears):
        self.vehicle, self.gears = params, gears
        self.gear, self.wanted, self.rub = list(gears[0][1]), [0, 0], [0, 0]
        super().__init__(params.in_gears(self.gear), scenario)

    def sample(self, time, y, pressed):
        """Change gears as sampled at `time`; returns y without the twists that are let go."""
        preselected = [gears for start, gears in self.gears if start <= time + 1e-9][-1]
        y = np.array(y)
        for i in range(2):
            if pressed[i] and self.rub[i]:
                self.rub[i], self.wanted[i] = 0, 0
            elif not pressed[i] and preselected[i] != (self.wanted[i] or self.gear[i]):
                self.gear[i], self.wanted[i], y[7 + i] = 0, preselected[i], 0.0
                self.rub[i] = int(np.sign(self.apart(i, y))) if preselected[i] else 0
        self.p = self.vehicle.in_gears(self.gear)
        return y

    def synchronised(self, i):
        """The gear of shaft `i` comes in."""
        self.gear[i], self.wanted[i], self.rub[i] = self.wanted[i], 0, 0
        self.p = self.vehicle.in_gears(self.gear)

    def ratio_to_come(self, i):
        """Total ratio of the gear that shaft `i` is synchronised to."""
        return self.vehicle.gear_ratio(i, self.wanted[i]) * self.vehicle.i_f[i]

    def apart(self, i, y):
        """Speed of shaft `i` above that of its gear."""
        return y[2 + i] - self.ratio_to_come(i) * y[4]

    def twist_rate(self, i, c, o):
        """Rate of the twist of transfer shaft `i`; a gear that is out twists nothing."""
        return super().twist_rate(i, c, o) if self.p.i_t[i] else 0.0

    def reaction(self, i, t_t):
        """Torque on the input shaft, of its gear or of its synchroniser."""
        if self.rub[i]:
            return self.rub[i] * self.vehicle.t_s[i]
        return super().reaction(i, t_t) if self.p.i_t[i] else 0.0

    def passed_on(self, i, t_t, o):
        """Torque of shaft `i` on the output, of its gear or of its synchroniser."""
        if self.rub[i]:
            return self.rub[i] * self.vehicle.t_s[i] * self.ratio_to_come(i)
        return super().passed_on(i, t_t, o)

    def guard(self, y, mode, u, i):
        """Positive while clutch, brake, synchroniser `i - 3` or output keeps its mode."""
        if i in (3, 4):
            return self.rub[i - 3] * self.apart(i - 3, y)
        return super().guard(y, mode, u, i)
