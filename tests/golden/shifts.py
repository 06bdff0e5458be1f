"""Gears that change during a run: out at once, synchronised by a Coulomb torque, then in.

A preselected gear is looked at when an input is sampled. A shaft whose clutch opens or is open then
(F_n = 0) takes it: cut from the output, the synchroniser rubs with +-T_s at the input shaft until
omega_ci = g_i omega_o. A clutch that is pressed meanwhile makes the synchroniser let go.
"""

from __future__ import annotations

import numpy as np
from hybrid import STATE_NAME, ZERO_SLIP, Simulation
from reference_plant import Plant

PART = Simulation.guards  # those of the synchronisers follow


class ShiftingSimulation(Simulation):
    """`Simulation` with gears: `gears` knots (t [s], (odd, even)), the first one at the start."""

    guards = PART + 2

    def __init__(self, params, gears, *start):
        self.vehicle, self.gears = params, gears
        self.gear, self.rub, self.lost = list(gears[0][1]), [0, 0], 0.0
        super().__init__(Plant(params.in_gears(self.gear)), *start)

    def energy(self):
        """Energy balance [J] with what synchronisers cost."""
        out = super().energy() | {"synchronisers": float(self.lost)}
        out["residual"] -= float(self.lost)
        return out

    # ---- gears ----

    def _shift(self, time):
        if self.piece.sample not in (None, time):
            return
        wanted = [gear for start, gear in self.gears if start <= time + 1e-9][-1]
        for i in range(2):
            if self._peak(i, 0.5 * self.piece.duration) > 0:
                if self.rub[i]:
                    self.gear[i] = 0
                    self._rub(time, i, 0)
            elif wanted[i] != self.gear[i]:
                self._take_out(time, i, wanted[i])

    def _take_out(self, time, i, gear):
        twist, _, k, _ = self.plant.springs[1 + i]
        self.lost += 0.5 * k * (self.x @ twist) ** 2
        self.x = self.x - twist * (self.x @ twist)
        self.gear[i] = gear
        left = self._left(i, self.x) if gear else 0.0
        self._rub(time, i, 0 if abs(left) <= ZERO_SLIP else int(np.sign(left)))

    def _left(self, i, x):
        """Speed difference that is left, omega_c - g omega_o [rad/s]."""
        unit = self.plant.unit
        return x @ unit[f"c{i + 1}"] - self._ratio(i) * (x @ unit["o"])

    def _ratio(self, i):
        return self.vehicle.gear_ratio(i, self.gear[i]) * self.vehicle.i_f[i]

    def _rub(self, time, i, sign):
        """Change the sign of a synchroniser, 0: it does nothing; connect what is in."""
        if sign != self.rub[i]:
            names = [STATE_NAME[2 if value else 1] for value in (self.rub[i], sign)]
            event = {"time": float(time), "clutch": f"synchroniser {i + 1}", "from": names[0]}
            self.events.append(event | {"to": names[1], "direction": sign})
        self.rub[i] = sign
        self._connect()

    def _connect(self, **meshes):
        """Build the plant of the gears that are in or are synchronised."""
        rubbing = tuple(self._ratio(j) if self.rub[j] else 0.0 for j in range(2))
        gears = [0 if self.rub[j] else self.gear[j] for j in range(2)]
        self.plant = Plant(self.vehicle.in_gears(gears), rubbing, **meshes)
        self.systems, self.cache = {}, {}

    # ---- motion ----

    def _forcing(self, mode, offset, x):
        v = super()._forcing(mode, offset, x)
        v[..., 4:] = [self.rub[i] * self.vehicle.t_s[i] for i in range(2)]
        return v

    def _book(self, prop, v, xs):
        for i in range(2):
            if self.rub[i]:
                power = self.rub[i] * self.vehicle.t_s[i] * self._left(i, xs)
                self.lost += prop.h * power @ prop.weights
        super()._book(prop, v, xs)

    # ---- events ----

    def _guard(self, i, xs, v, offset):
        if i < PART:
            return super()._guard(i, xs, v, offset)
        shaft = i - PART
        return self.rub[shaft] * self._left(shaft, xs) if self.rub[shaft] else None

    def _event(self, clutch, done):
        if clutch < PART:
            super()._event(clutch, done)
        else:
            self._rub(self.piece.start + done, clutch - PART, 0)
            self._resolve(self.piece.start + done, done)
