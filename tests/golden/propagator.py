"""Exponential collocation: one smooth piece of the plant, exact but for the load's polynomial.

Over a piece of duration h the forcing v(t) = [T_e, T_c1, T_c2, T_v, T_s1, T_s2] is a polynomial
through `STAGES` Chebyshev-Lobatto nodes. For that forcing the state is exact,

    x(c h) = exp(A c h) x0 + sum_j Psi_j(c) v(c_j h),

whatever the stiffness of A. T_v depends on x through omega_w, and friction that varies with slip
through the slips; both are found by fixed-point iteration (for T_v the contraction is
h |dT_v/domega_w| / J_v < 3e-3 at h = 1 ms).
"""

from __future__ import annotations

import math
from itertools import pairwise

import numpy as np
from scipy.linalg import expm

STAGES = 6
PANELS = (0.0, 1 / 64, 1 / 16, 1 / 4, 1.0)  # graded: the fastest mode dies within 0.1 ms
GAUSS = 6


def lobatto(stages):
    """Chebyshev-Lobatto nodes on [0, 1], shape (stages)."""
    return 0.5 * (1 - np.cos(np.pi * np.arange(stages) / (stages - 1)))


def graded_gauss():
    """Gauss points and weights on the graded panels of [0, 1], two arrays of one shape."""
    z, w = np.polynomial.legendre.leggauss(GAUSS)
    edges = pairwise(PANELS)
    pairs = [(a + (b - a) * (z + 1) / 2, w * (b - a) / 2) for a, b in edges]
    return np.concatenate([p for p, _ in pairs]), np.concatenate([w for _, w in pairs])


class Propagator:
    """Matrices of one mode system and one duration `h`.

    Attributes
    ----------
    watched : ndarray, shape (3, n), rows that read what the forcing depends on
    points : ndarray, shape (P), where x is sampled, fractions of h, the last one is 1
    weights : ndarray, shape (P), quadrature weights on `points` (0 at the end point)
    """

    def __init__(self, system, h, watched, stages=None):
        self.system, self.h, self.watched = system, h, watched
        self.nodes = lobatto(stages or STAGES)
        gauss, weights = graded_gauss()
        self.points, self.weights = np.append(gauss, 1.0), np.append(weights, 0.0)
        self.to_coefficients = np.linalg.inv(np.vander(self.nodes, increasing=True))
        self.forcing_map = np.vander(self.points, len(self.nodes), increasing=True)
        self.forcing_map = self.forcing_map @ self.to_coefficients
        self.generator = self._generator()
        phi, psi = self.maps(np.concatenate([self.points, self.nodes[1:]]))
        count = len(self.points)
        self.phi, self.psi = phi[:count], psi[:count]
        self.phi_n, self.psi_n = phi[count:], psi[count:]

    def _generator(self):
        # z = [x, v, v', ..., v^(s-1)] / scaled time: monomial t^j has j-th derivative j!.
        n, s = self.system.a.shape[0], len(self.nodes)
        k = self.system.b.shape[1]
        m = np.zeros((n + k * s, n + k * s))
        m[:n, :n], m[:n, n : n + k] = self.system.a * self.h, self.system.b * self.h
        m[n : n + k * (s - 1), n + k :] = np.eye(k * (s - 1))
        return m

    def maps(self, fractions):
        """Maps from x0 and nodal forcing to x at `fractions` of h: (P, n, n) and (P, n, k s)."""
        n, s = self.system.a.shape[0], len(self.nodes)
        full = expm(np.asarray(fractions)[:, None, None] * self.generator)
        factor = np.array([math.factorial(j) for j in range(s)])[:, None] * self.to_coefficients
        k = self.system.b.shape[1]
        psi = full[:, :n, n:].reshape(len(fractions), n, s, k)
        psi = np.einsum("pnji,jk->pnki", psi, factor)
        return full[:, :n, :n], psi.reshape(len(fractions), n, k * s)

    def solve_forcing(self, x0, forcing):
        """Nodal forcing that is consistent with the motion, shape (s, k).

        Parameters
        ----------
        forcing : callable, nodal states, shape (s, n) -> nodal forcing, shape (s, k) [N·m]
        """
        x = np.tile(x0, (len(self.nodes), 1))
        free = self.phi_n @ x0
        for _ in range(40):
            v = forcing(x)
            new = free + self.psi_n @ v.ravel()
            change = np.max(np.abs((new - x[1:]) @ self.watched.T))
            x[1:] = new
            if change <= 4e-15 * max(1.0, np.max(np.abs(x0))):
                return v
        raise RuntimeError("the forcing does not settle; take a shorter piece")

    def sample(self, x0, v):
        """States at `points`, shape (P, n)."""
        return self.phi @ x0 + self.psi @ v.ravel()

    def at(self, x0, v, fraction):
        """State at one `fraction` of h, shape (n)."""
        phi, psi = self.maps([fraction])
        return phi[0] @ x0 + psi[0] @ v.ravel()

    def forcing_at(self, v, fraction):
        """Forcing at `fraction` of h, shape (k)."""
        powers = np.vander([fraction], len(self.nodes), increasing=True)
        return (powers @ self.to_coefficients @ v)[0]
