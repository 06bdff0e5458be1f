"""Clutches that get hot, written out a second time for `radau_check.py`: two more entries of y."""

from __future__ import annotations

import numpy as np
from scalar_plants import ScalarPlant


class HeatedScalarPlant(ScalarPlant):
    """`ScalarPlant` with C T' = P - G (T - T_a) per clutch; mu_k and mu_s fade by theta(T)."""

    def start(self, engine_speed, omega):
        """Start values of y, temperatures [K] last."""
        return super().start(engine_speed, omega) + [node["start"] for node in self.p.heat]

    def torques(self, y, mode, u):
        """T_d, T_c (2), T_t (2), T_o, T_v."""
        return super().torques(y[:10], mode, self._faded(y, u))

    def rate(self, y, mode, u):
        """y' of the compliant plant and its temperatures."""
        t_c = self.torques(y, mode, u)[1]
        heating = []
        for i, node in enumerate(self.p.heat):
            power = 0.0 if mode[i] == 2 else t_c[i] * (y[1] - y[2 + i])
            cooling = node["conductance"] * (y[10 + i] - node["ambient"])
            heating.append((power - cooling) / node["capacity"])
        return super().rate(y, mode, u) + heating

    def guard(self, y, mode, u, i):
        """Positive while clutch `i` keeps its mode."""
        if i < 2 and mode[i] == 2:
            peak = self.p.mu_s[i] * self._faded(y, u)[1][i]
            return peak - abs(self.torques(y, mode, u)[1][i])
        return super().guard(y, mode, u, i)

    def _faded(self, y, u):
        """The inputs with the capacities that the temperatures leave."""
        theta = [
            np.interp(y[10 + i], node["temperature"], node["factor"])
            for i, node in enumerate(self.p.heat)
        ]
        return u[0], [n * factor for n, factor in zip(u[1], theta, strict=True)], *u[2:]
