"""Gears of rigid shafts that lose power: loads, direction and clutch modes found together.

A rigid shaft passes on what its clutch gives it less what turns it, g (T_c - J_c g d(omega_o)/dt),
so its sign jumps with the torques of the clutches. All signs are tried at every instant at which
something may change; one choice is consistent.
"""

from __future__ import annotations

from copy import deepcopy
from itertools import product

import numpy as np
from hybrid import TORQUE_TOL, ZERO_SLIP
from meshes import JAM, MESH, LossySimulation
from shifts import ShiftingSimulation


class RigidLossySimulation(LossySimulation):
    """`LossySimulation` of the rigid plant: gears 1 to 8 that are in all the time."""

    # ---- torques ----

    def _shaft_torques(self, x, v=None):
        """i_f T_t of both shafts [N·m], from what the clutches carry."""
        torque, rate = self._torques(self.mode, x, v), self._output_rate(x, v)
        return [self.plant.mesh_torque(i, torque[..., i], rate) for i in range(2)]

    def _output_rate(self, x, v):
        system = self._system(self.mode)
        return (x @ system.a.T + v @ system.b.T) @ self.plant.unit["o"]

    def _book(self, prop, v, xs):
        vp = prop.forcing_map @ v
        torque = self._torques(self.mode, xs, vp)[..., :2]
        rate, speed = self._output_rate(xs, vp), self._output_speed(xs)
        lost = prop.h * self.plant.rigid_mesh_power(torque, rate, speed) @ prop.weights
        super()._book(prop, v, xs)
        self.work[1] += lost

    # ---- modes ----

    def _resolve(self, time, offset, broken=None, reached=None, forced=None):
        """Modes just after `time`; `forced`: (turns, load 1, load 2), None where any may be."""
        standing = self.turns == 0 or abs(self._output_speed(self.x)) <= ZERO_SLIP
        start, count = (self.mode, self.x, self.lines, self.turns), len(self.events)
        for turns, *load in self._choices(standing, forced or (None,) * 3):
            self.mode, self.x, self.lines, self.turns = deepcopy(start)
            del self.events[count:]
            self.load = load
            self._turn(time, turns)
            try:
                ShiftingSimulation._resolve(self, time, offset, broken, reached)
            except RuntimeError:
                continue
            if self._holds(offset, standing, forced):
                return
        raise RuntimeError(f"no consistent loads at {time}")

    def _choices(self, standing, forced):
        here = (1, -1) if standing else (int(np.sign(self._output_speed(self.x))),)
        lossy = [eta < 1 for eta in self.plant.p.eta]
        loads = list(product(*((1, -1) if some else (0,) for some in lossy)))
        choices = [(turns, *load) for turns in here for load in loads]
        choices = [(0, 0, 0), *choices] if standing else choices
        fits = [c for c in choices if all(f in (None, x) for f, x in zip(forced, c, strict=True))]
        return sorted(fits, key=lambda c: c != (self.turns, *self.load))

    def _holds(self, offset, standing, forced):
        v = self._full_forcing(self.mode, offset)
        torque = self._shaft_torques(self.x, v)
        if self.turns == 0:
            forward, backward = self._urges(self.x, torque)
            return forward <= TORQUE_TOL and backward >= -TORQUE_TOL
        leaves = self.turns * self._output_rate(self.x, v)
        if standing and leaves < (-TORQUE_TOL if forced else TORQUE_TOL):
            return False
        return all(self.load[i] * torque[i] >= -TORQUE_TOL for i in range(2))

    # ---- events ----

    def _event(self, clutch, done):
        time = self.piece.start + done
        if clutch < MESH:
            ShiftingSimulation._event(self, clutch, done)
        elif clutch < JAM:
            forced = [self.turns, None, None]
            forced[1 + clutch - MESH] = -self.load[clutch - MESH]
            self._resolve(time, done, forced=forced)
        elif self.turns:
            self._turn(time, 0)
            self._resolve(time, done)
        else:
            v = self._full_forcing(self.mode, done)
            forward, backward = self._urges(self.x, self._shaft_torques(self.x, v))
            self._resolve(time, done, forced=(1 if forward + backward > 0 else -1, None, None))
