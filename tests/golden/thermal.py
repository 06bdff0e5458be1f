"""Clutches that get hot: C T' = P - G (T - T_a), and friction times theta(T).

Over a piece T is the polynomial through the collocation nodes that meets its equation, found
together with the friction power. The table of theta is not cut at its points: its bends are of the
size of d theta/dT times what a piece heats, some 1e-5 of the torque, in the one piece that passes.
"""

from __future__ import annotations

import numpy as np
from hybrid import Simulation
from propagator import lobatto

ROUNDS = 12  # each adds some four digits


def integration(count):
    """Integrals from 0 to every node of the polynomials that are 1 at one node, square."""
    nodes = lobatto(count)
    powers = np.vander(nodes, increasing=True)
    orders = np.arange(1, count + 1)
    return (powers * nodes[:, None] / orders) @ np.linalg.inv(powers)


class HeatedSimulation(Simulation):
    """`Simulation` with one thermal node per clutch, `Params.heat`."""

    def __init__(self, plant, *args):
        self.heat = plant.p.heat
        self.temperature = np.array([node["start"] for node in self.heat])
        self.along = self.temperature
        super().__init__(plant, *args)

    def _theta(self, i, temperature):
        node = self.heat[i]
        return np.interp(temperature, node["temperature"], node["factor"])

    def _peak(self, i, offset):
        fade = self._theta(i, self.temperature[i]) if i < 2 else 1.0
        return fade * super()._peak(i, offset)

    def _forcing(self, mode, offset, x):
        v = super()._forcing(mode, offset, x)
        if np.ndim(offset):
            self.along = self._warm(offset, v[:, 1:3] * (x @ self.plant.slip.T))
        temperature = self.along if np.ndim(offset) else self.temperature
        for i in range(2):
            v[..., 1 + i] *= self._theta(i, temperature[..., i])
        return v

    def _warm(self, offset, power):
        """Temperatures at the nodes, shape (s, 2), with a friction power at theta = 1."""
        h, integral = offset[-1] - offset[0], integration(len(offset))
        found = np.tile(self.temperature, (len(offset), 1))
        for _ in range(ROUNDS):
            for i, node in enumerate(self.heat):
                heating = power[:, i] * self._theta(i, found[:, i])
                heating = heating - node["conductance"] * (found[:, i] - node["ambient"])
                found[:, i] = self.temperature[i] + h / node["capacity"] * (integral @ heating)
        return found

    def _book(self, prop, v, xs):
        self.temperature = self.along[-1]
        super()._book(prop, v, xs)

    def _record(self, time, offset):
        super()._record(time, offset)
        self.rows[-1] = (*self.rows[-1], *self.temperature)
