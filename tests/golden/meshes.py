"""Gears that lose power: which way each is loaded, which way the output turns, and when it jams.

A shaft whose gear has an efficiency eta drives the output by i_f T_t eta^s, s = sgn(T_t omega_o).
T_t passes zero with a bend; at omega_o = 0 the output stands while the torque on it would move it
backward if it turned forward, and forward if it turned backward.
"""

from __future__ import annotations

import numpy as np
from hybrid import STATE_NAME, TORQUE_TOL, ZERO_SLIP
from shifts import ShiftingSimulation

MESH = ShiftingSimulation.guards  # guards of both loads and of the output follow
JAM = MESH + 2
NUMBER = {None: 1, 1: 2, -1: 2, 0: 3}


class LossySimulation(ShiftingSimulation):
    """`ShiftingSimulation` with the efficiencies of `Params`; the compliant plant."""

    guards = MESH + 3

    def __init__(self, params, *args):
        self.load, self.turns = [0, 0], None  # turns: sgn omega_o, 0 jammed, None: no loss
        super().__init__(params, *args)

    # ---- loads and direction ----

    def _resolve(self, time, offset, broken=None, reached=None):
        self._mesh(time)
        super()._resolve(time, offset, broken, reached)

    def _mesh(self, time, stands=False):
        """Take the loads and the direction that the state has."""
        lossy = [eta < 1 for eta in self.plant.p.eta]
        for i in range(2):
            torque = self._shaft_torque(i, self.x)
            if not lossy[i] or abs(torque) > TORQUE_TOL or self.load[i] == 0:
                self.load[i] = (1 if torque >= 0 else -1) if lossy[i] else 0
        self._turn(time, self._direction_of_output(stands) if any(lossy) else None)

    def _turn(self, time, turns):
        if turns != self.turns:
            a, b = NUMBER[self.turns], NUMBER[turns]
            event = {"time": float(time), "clutch": "output", "from": STATE_NAME[a]}
            self.events.append(event | {"to": STATE_NAME[b], "direction": turns if b == 2 else 0})
        self.turns = turns
        if turns == 0:
            self.x = self.x - self.plant.unit["o"] * self._output_speed(self.x)
        power = tuple(load * (turns or 0) for load in self.load)
        if power != self.plant.power or (turns == 0) != self.plant.jammed:
            self._connect()

    def _connect(self):
        power = tuple(load * (self.turns or 0) for load in self.load)
        super()._connect(power=power, jammed=self.turns == 0)

    def _direction_of_output(self, stands):
        speed = self._output_speed(self.x)
        if not stands and self.turns != 0 and abs(speed) > ZERO_SLIP:
            return int(np.sign(speed))
        forward, backward = self._urges(self.x, self._shaft_torques(self.x))
        return 1 if forward > 0 else -1 if backward < 0 else 0

    def _output_speed(self, x):
        return x @ self.plant.unit["o"]

    def _shaft_torque(self, i, x):
        twist, rate, k, c = self.plant.springs[1 + i]
        return x @ (k * twist + c * rate)

    def _shaft_torques(self, x, v=None):
        """i_f T_t of both shafts [N·m]; of compliant ones the state tells them."""
        return [self.plant.p.i_f[i] * self._shaft_torque(i, x) for i in range(2)]

    def _urges(self, x, torques):
        """Torque on the output [N·m] if it turned forward, and if it turned backward."""
        rest = -(x @ self.plant.shaft_row)
        for i in range(2):
            rest = rest + self.rub[i] * self._ratio(i) * self.vehicle.t_s[i]
        both = [rest, rest]
        for i in range(2):
            torque, eta = torques[i], self.plant.p.eta[i]
            both[0] = both[0] + np.minimum(torque * eta, torque / eta)
            both[1] = both[1] + np.maximum(torque * eta, torque / eta)
        return both

    # ---- events ----

    def _guard(self, i, xs, v, offset):
        if i < MESH:
            return super()._guard(i, xs, v, offset)
        if i < JAM:
            load = self.load[i - MESH] * abs(self.turns or 0)
            return load * self._shaft_torques(xs, v)[i - MESH] if load else None
        if self.turns is None:
            return None
        if self.turns:
            return self.turns * self._output_speed(xs)
        forward, backward = self._urges(xs, self._shaft_torques(xs, v))
        return np.minimum(-forward, backward)

    def _tolerance(self, i):
        speed = i == JAM and self.turns != 0
        return super()._tolerance(i) if i < MESH or speed else TORQUE_TOL

    def _event(self, clutch, done):
        if clutch < MESH:
            super()._event(clutch, done)
            return
        time = self.piece.start + done
        if clutch < JAM:
            self.load[clutch - MESH] *= -1
            self._turn(time, self.turns)
        elif self.turns:
            self._mesh(time, stands=True)
        else:
            forward, backward = self._urges(self.x, self._shaft_torques(self.x))
            self._turn(time, 1 if forward + backward > 0 else -1)
        super()._resolve(time, done)
