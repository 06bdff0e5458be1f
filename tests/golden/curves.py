"""Friction that varies with slip, one straight line of its table at a time.

Extended beyond its ends a line is smooth, so a piece of motion on it is as well; the guard tells
where the slip leaves the line, and there the piece is cut.
"""

from __future__ import annotations

import numpy as np


class Line:
    """The line on which the slip of one clutch is; `curve` is (|slip|, factor) or None."""

    def __init__(self, curve):
        self.knots, self.factors = (np.array(c, dtype=float) for c in curve or ([], []))
        self.right = 0  # index of the point to the right of the slip

    @property
    def bends(self):
        """Whether there is a table at all."""
        return len(self.knots) > 0

    def begin(self, slip):
        """Take the line at `slip` [rad/s], at a point of the table that to its right."""
        self.right = int(np.searchsorted(self.knots, slip, side="right"))

    def factor(self, slip):
        """Factor on mu_k [-] on this line at `slip` [rad/s], any shape."""
        if not self.bends:
            return 1.0
        if self.right in (0, len(self.knots)):
            return self.factors[min(self.right, len(self.knots) - 1)] + 0.0 * slip
        (s0, s1), (f0, f1) = (
            a[self.right - 1 : self.right + 1] for a in (self.knots, self.factors)
        )
        return f0 + (f1 - f0) / (s1 - s0) * (slip - s0)

    def bounds(self):
        """Slips [rad/s] at which the line ends; at slip 0 the clutch locks up instead."""
        knots = np.concatenate([[-np.inf], self.knots[self.knots > 0], [np.inf]])
        left = self.right - np.count_nonzero(self.knots == 0)
        return knots[left], knots[left + 1]

    def guard(self, slip):
        """Positive while `slip` [rad/s] is on the line, any shape."""
        low, high = self.bounds()
        return np.minimum(slip - low, high - slip)

    def turn(self, slip):
        """Go over to the line beyond the end that `slip` [rad/s] has reached."""
        low, high = self.bounds()
        self.right += 1 if high - slip < slip - low else -1
