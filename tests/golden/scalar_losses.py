"""Gears that lose power behind rigid shafts, written out a second time for `radau_check.py`.

No signs are tried: what turns the output falls as its acceleration grows, so one acceleration fits.
"""

from __future__ import annotations

from scalar_plants import RigidScalarPlant


class RigidLossyScalarPlant(RigidScalarPlant):
    """`RigidScalarPlant` with J_o omega_o' = sum of what the gears pass on - T_o."""

    def torques(self, y, mode, u):
        """T_d, T_c (2), no T_t, T_o, T_v."""
        if mode[0] == mode[1] == 2:
            return super().torques(y, mode, u)
        return self._parts(y, mode, u)[:5]

    def rate(self, y, mode, u):
        """y' of the rigid plant."""
        rate = super().rate(y, mode, u)
        if not mode[0] == mode[1] == 2:
            rate[2] = self._parts(y, mode, u)[5]
        return rate

    def meshes(self, y, mode, u):
        """i_f T_t of both shafts while the output stands, T_o."""
        _, t_c, _, t_o, _ = self.torques(y, mode, u)
        return [self.p.ratio[i] * t_c[i] for i in range(2)], t_o

    def _parts(self, y, mode, u):
        p, g = self.p, self.p.ratio
        e, d, o, w, th_d, th_o = y
        t_d, t_o = p.k_d * th_d + p.c_d * (e - d), p.k_o * th_o + p.c_o * (o - w)
        t_c = [self.friction(i, mode[i], u[1][i], d - g[i] * o) for i in range(2)]
        turned = list(p.j_c)  # [kg·m²] what T_c has to turn with its shaft, the damper if engaged
        for i in (i for i in range(2) if mode[i] == 2):
            t_c[i], turned[i] = t_d - t_c[1 - i], p.j_c[i] + p.j_d
        accel = self._acceleration(o, [g[i] * t_c[i] for i in range(2)], turned, t_o)
        for i in (i for i in range(2) if mode[i] == 2):
            t_c[i] -= p.j_d * g[i] * accel
        return t_d, t_c, None, t_o, self.load(w, mode, u, t_o), accel

    def _acceleration(self, o, drive, turned, t_o):
        """omega_o' [rad/s²] with the torque `drive` [N·m] that clutches give the output."""
        if self.turns == 0:
            return 0.0
        slope = [self.p.ratio[i] ** 2 * turned[i] for i in range(2)]

        def missing(accel):
            passed = (self.passed_on(i, drive[i] - slope[i] * accel, o) for i in range(2))
            return self.p.j_o * accel + t_o - sum(passed)

        low, high = sorted(drive[i] / slope[i] for i in range(2))  # where a gear is unloaded
        if missing(low) > 0:
            a, b = low - 1.0, low
        elif missing(high) > 0:
            a, b = low, high
        else:
            a, b = high, high + 1.0
        return a - missing(a) * (b - a) / (missing(b) - missing(a))

    def passed_on(self, i, torque, o):
        """Torque of shaft `i` on the output [N·m] of `torque` that its gear is given there."""
        return torque * self.share(i, torque, o)
