"""Hybrid simulation: clutch modes, located events, rows and the energy balance.

Modes per clutch: open (F_n = 0), slipping with the sign of the slip, engaged. Inside a smooth
piece a slip zero or |T_c| = mu_s F r N is found by root finding (brentq); at every input sample
and event the modes of the clutches at zero slip are enumerated and the consistent set is taken.
Friction that varies with slip is one straight line per piece: where a slip passes a point of its
curve the piece is cut, like at an event.
The brake is a third clutch, between the wheels and the road: engaged, it holds them.
"""

from __future__ import annotations

from itertools import product

import numpy as np
from curves import Line
from propagator import Propagator
from reference_plant import ENGAGED, OPEN, ModeSystem
from scipy.optimize import brentq, minimize_scalar

STATE_NUMBER = {OPEN: 1, 1: 2, -1: 2, ENGAGED: 3}
PARTS = (1, 2, "brake")
LINES = 3  # guards from here on: the slips of both clutches on the lines of their curves
STATE_NAME = {1: "disengaged", 2: "slipping", 3: "engaged"}
ZERO_SLIP = 1e-10  # [rad/s] at rest together; below what two accelerations leave after a step
SLIP_TOL, TORQUE_TOL = 1e-12, 1e-9  # [rad/s], [N·m] round-off of a guard that starts at zero


class Simulation:
    """One run of a plant. Call `run`; then read `rows`, `events`, `energy`."""

    guards = LINES + 2  # clutches, brake and the curves of the clutches

    def __init__(self, plant, scenario, engine_speed, vehicle_speed, stages=None):
        self.plant, self.scenario, self.stages = plant, scenario, stages
        self.x = plant.start(engine_speed, vehicle_speed)
        self.mode, self.systems, self.cache = (OPEN, OPEN, OPEN), {}, {}
        self.rows, self.events, self.piece, self.at_start = [], [], None, True
        self.work = np.zeros(4)  # engine, dampers, clutch friction, load [J]
        self.turnover, self.stored_0 = 0.0, plant.energy(self.x)
        self.lines = [Line(curve) for curve in plant.p.curves]

    def run(self, pieces):
        """Advance over all `pieces`; the first row is at the start."""
        for piece in pieces:
            self.piece = piece
            self._shift(piece.start)
            self._resolve(piece.start, 0.0)
            if self.at_start:
                self.events.clear()
                self._record(piece.start, 0.0)
                self.at_start = False
            self._advance()
            if piece.row:
                self._record(piece.end, piece.duration)
        return self

    def energy(self):
        """Energy balance [J]: work in, stored, the three losses and what does not close."""
        stored = self.plant.energy(self.x) - self.stored_0
        names = ("engine", "dampers", "clutches", "load")
        out = dict(zip(names, map(float, self.work), strict=True)) | {"stored": float(stored)}
        out["turnover"] = float(self.turnover)
        out["residual"] = float(self.work[0] - stored - self.work[1:].sum())
        return out

    def _shift(self, time):
        """Change gears at an input sample: `shifts.py`."""

    # ---- inputs ----

    def _inputs(self, offset):
        """T_e, forces (2), grade and brake at `offset` [s] into the piece, of `offset`'s shape."""
        offset = np.asarray(offset, dtype=float)
        t = self.piece.sample
        time = self.piece.start + offset if t is None else np.full(offset.shape, t)
        u = self.scenario.at(time)
        force = [self.plant.p.force(i, u[..., 1 + i]) for i in range(2)]
        return u[..., 0], force, u[..., 3], u[..., 4]

    def _forcing(self, mode, offset, x):
        """T_e and the friction torques at states `x`, shape (..., 4)."""
        torque, force, *_ = self._inputs(offset)
        v = np.zeros((*np.shape(offset), 6))
        v[..., 0] = torque
        p = self.plant.p
        for i in range(2):
            if mode[i] in (1, -1):
                factor = self.lines[i].factor(mode[i] * (x @ self.plant.slip[i]))
                v[..., 1 + i] = mode[i] * p.mu_k[i] * factor * force[i] * p.r_n[i]
        return v

    def _peak(self, i, offset):
        """Largest torque of clutch `i` when engaged, mu_s F r N, or of the brake [N·m]."""
        p = self.plant.p
        _, force, grade, brake = self._inputs(offset)
        return p.mu_s[i] * force[i] * p.r_n[i] if i < 2 else p.dry_load(brake, grade)

    def _load(self, mode, omega_w, offset):
        """T_v [N·m], the sliding brake included."""
        _, _, grade, brake = self._inputs(offset)
        dry = mode[2] * self.plant.p.dry_load(brake, grade) if mode[2] in (1, -1) else 0.0
        return self.plant.p.load_torque(omega_w, grade) + dry

    def _full_forcing(self, mode, offset):
        v = self._forcing(mode, offset, self.x)
        v[3] = self._load(mode, self.x[self.plant.row_w], offset)
        return v

    def _system(self, mode):
        if mode not in self.systems:
            self.systems[mode] = ModeSystem(self.plant, mode)
        return self.systems[mode]

    def _propagator(self, h):
        key = (self.mode, h)
        if key not in self.cache:
            system = self._system(self.mode)
            made = Propagator(system, h, self.plant.sliding, self.stages)
            if abs(h - self.piece.duration) > 0:  # the rest of a piece after an event: used once
                return made
            self.cache[key] = made
        return self.cache[key]

    # ---- modes ----

    def _resolve(self, time, offset, broken=None, reached=None):
        """Modes valid just after `time`; `broken` may not stick, `reached` has zero slip."""
        slip = self.plant.sliding @ self.x
        middle = 0.5 * (offset + self.piece.duration)  # linear: >= 0 at its ends
        choices = []
        for i in range(3):
            at_zero = self.mode[i] == ENGAGED or i == reached or abs(slip[i]) <= ZERO_SLIP
            if self._peak(i, middle) <= 0:
                choices.append((OPEN,))
            elif (
                i == broken == 2
            ):  # no drop of friction: nothing but the torque shows the direction
                choices.append((self._direction(offset),))
            elif at_zero:
                choices.append((1, -1) if i == broken else (ENGAGED, 1, -1))
            else:
                choices.append((1,) if slip[i] > 0 else (-1,))
        zero = [i for i in range(3) if len(choices[i]) > 1]
        self._change(time, self._pick(choices, zero, offset) if zero else _single(choices))

    def _direction(self, offset):
        """Sign of what moves held wheels."""
        v = self._full_forcing(self.mode, offset)
        return int(np.sign(self._held_torque(self.mode, self.x, v, offset)[2]))

    def _pick(self, choices, zero, offset):
        """Take the consistent set: most clutches stuck; of two, the more loaded one slips."""
        sets = [m for m in product(*choices) if self._consistent(m, zero, offset)]
        if not sets:
            raise RuntimeError(f"no consistent clutch modes in {choices}")
        load = self._loading(tuple(c[0] for c in choices), offset)
        stuck = [sum(load[i] if m[i] == ENGAGED else 0.0 for i in range(3)) for m in sets]
        return min(zip(sets, stuck, strict=True), key=lambda s: (-s[0].count(ENGAGED), s[1]))[0]

    def _loading(self, mode, offset):
        """|T_c| / (mu_s F r N) of every engaged clutch of `mode` and the brake, shape (3)."""
        torque = self._held_torque(mode, self.x, self._full_forcing(mode, offset), offset)
        peak = np.array([self._peak(i, offset) for i in range(3)])
        return np.abs(torque) / np.maximum(peak, 1e-300)

    def _consistent(self, mode, zero, offset):
        system, v = self._system(mode), self._full_forcing(mode, offset)
        torque = self._held_torque(mode, self.x, v, offset)
        slip_dot = self.plant.sliding @ (system.a @ self.x + system.b @ v)
        for i in zero:
            if mode[i] == ENGAGED:
                if abs(torque[i]) > self._peak(i, offset) * (1 + 1e-12):
                    return False
            elif mode[i] * slip_dot[i] <= 0:
                return False
        return not self._over_constrained(mode)

    def _over_constrained(self, mode):
        """Whether engaging `mode` would need a speed jump (rigid tie-up while moving)."""
        stuck = [i for i in range(2) if mode[i] == ENGAGED]
        return bool(np.any(np.abs(self.plant.slip[stuck] @ self.x) > 1e-6))

    def _torques(self, mode, x, v):
        """T_c1, T_c2, T_v, shape (..., 3)."""
        system = self._system(mode)
        return x @ system.gx.T + v @ system.gv.T

    def _held_torque(self, mode, x, v, offset):
        """What friction has to carry [N·m], shape (..., 3): the brake all but the smooth load."""
        torque = self._torques(mode, x, v)
        smooth = self.plant.p.load_torque(x[..., self.plant.row_w], self._inputs(offset)[2])
        torque[..., 2] -= smooth
        return torque

    def _change(self, time, mode):
        for i in range(3):
            if mode[i] != self.mode[i]:
                a, b = STATE_NUMBER[self.mode[i]], STATE_NUMBER[mode[i]]
                event = {"time": float(time), "clutch": PARTS[i], "from": STATE_NAME[a]}
                event |= {"to": STATE_NAME[b], "direction": mode[i] if b == 2 else 0}
                self.events.append(event)
        for i in range(2):
            if mode[i] in (1, -1) and mode[i] != self.mode[i]:
                self.lines[i].begin(abs(self.plant.slip[i] @ self.x))
        self.mode = tuple(mode)
        self._project()

    def _project(self):
        """Remove round-off from the slip of engaged clutches, momentum kept."""
        stuck = [i for i in range(3) if self.mode[i] == ENGAGED]
        if stuck:
            s = self.plant.sliding[stuck]
            impulse = np.linalg.solve((s * self.plant.inv_mass) @ s.T, s @ self.x)
            self.x = self.x - self.plant.inv_mass * (impulse @ s)

    # ---- motion ----

    def _advance(self):
        done, total = 0.0, self.piece.duration
        for _ in range(50):
            prop = self._propagator(total - done)
            v, xs = self._piece_states(prop, done)
            hit = self._first_event(prop, v, xs, done)
            if hit is None:
                self._book(prop, v, xs)
                return
            fraction, clutch = hit
            if fraction > 0:
                part = Propagator(prop.system, fraction * prop.h, self.plant.sliding, self.stages)
                self._book(part, *self._piece_states(part, done))
                done += part.h
            self._event(clutch, done)
            if total - done < 1e-13:
                return
        raise RuntimeError(f"more than 50 events in the step at {self.piece.start}")

    def _event(self, clutch, done):
        if clutch >= LINES:  # a slip at a point of its curve
            i = clutch - LINES
            self.lines[i].turn(self.mode[i] * (self.plant.slip[i] @ self.x))
            return
        engaged = self.mode[clutch] == ENGAGED
        broken, reached = (clutch, None) if engaged else (None, clutch)
        self._resolve(self.piece.start + done, done, broken, reached)

    def _piece_states(self, prop, done):
        offset = done + prop.nodes * prop.h

        def forcing(x):
            v = self._forcing(self.mode, offset, x)
            v[:, 3] = self._load(self.mode, x[:, self.plant.row_w], offset)
            return v

        v = prop.solve_forcing(self.x, forcing)
        return v, prop.sample(self.x, v)

    def _book(self, prop, v, xs):
        """Add the work done over the piece and move to its end."""
        vp = prop.forcing_map @ v
        torque = xs @ prop.system.gx.T + vp @ prop.system.gv.T
        engine = vp[:, 0] * (xs @ self.plant.unit["e"])
        friction = np.sum(torque[:, :2] * (xs @ self.plant.slip.T), axis=1)
        load = vp[:, 3] * (xs @ self.plant.unit["w"])
        power = np.stack([engine, self.plant.damping_power(xs), friction, load])
        self.work += prop.h * power @ prop.weights
        self.turnover += prop.h * (np.abs(engine) + np.abs(load)) @ prop.weights
        self.x = xs[-1]
        self._project()

    # ---- events ----

    def _guard(self, i, xs, v, offset):
        """Positive while clutch `i` keeps its mode; None for an open clutch."""
        if i >= LINES:
            sign = self.mode[i - LINES]
            slip = sign * (xs @ self.plant.slip[i - LINES])
            line = self.lines[i - LINES]
            return line.guard(slip) if line.bends and sign in (1, -1) else None
        if self.mode[i] == OPEN:
            return None
        if self.mode[i] == ENGAGED:
            return self._peak(i, offset) - np.abs(
                self._held_torque(self.mode, xs, v, offset)[..., i]
            )
        return self.mode[i] * (xs @ self.plant.sliding[i])

    def _first_event(self, prop, v, xs, done):
        """Earliest guard crossing as (fraction of the piece, clutch), or None."""
        grid = np.concatenate([[0.0], prop.points])
        states = np.vstack([self.x, xs])
        vp = np.vstack([v[0], prop.forcing_map @ v])
        hits = []
        for i in range(self.guards):
            guard = self._guard(i, states, vp, done + grid * prop.h)
            if guard is None:
                continue
            probe = self._probe(i, prop, v, done)
            bracket = self._bracket(guard, grid, self._tolerance(i), probe)
            if bracket is not None:
                hits.append((bracket, i))
        return min(hits) if hits else None

    def _tolerance(self, i):
        """Round-off of a guard that starts at zero."""
        return TORQUE_TOL if i < LINES and self.mode[i] == ENGAGED else SLIP_TOL

    def _probe(self, i, prop, v, done):
        def guard(c):
            x, vc = prop.at(self.x, v, c), prop.forcing_at(v, c)
            return float(self._guard(i, x, vc, done + c * prop.h))

        return guard

    def _bracket(self, guard, grid, tol, probe):
        below = np.flatnonzero(guard < -tol)
        stop = below[0] if len(below) else len(grid)
        left, mid, right = guard[:-2], guard[1:-1], guard[2:]
        dips = (mid <= left) & (mid <= right) & (mid < left + right - 2 * mid)
        for k in np.flatnonzero(dips[: max(0, stop - 1)]) + 1:
            low = minimize_scalar(
                probe, bounds=(grid[k - 1], grid[k + 1]), method="bounded", options={"xatol": 1e-9}
            )
            if low.fun < -tol:
                return _root(probe, grid[k - 1], low.x)
        if not len(below):
            return None
        return 0.0 if stop == 0 else _root(probe, grid[stop - 1], grid[stop])

    # ---- rows ----

    def _record(self, time, offset):
        """Row at `time`: left limit, with the modes and inputs of the piece that ends there."""
        v = self._full_forcing(self.mode, offset)
        *clutch, load = self._torques(self.mode, self.x, v)
        speeds = self.plant.speeds @ self.x
        torques = (self.plant.damper_row @ self.x, *clutch, self.plant.shaft_row @ self.x, load)
        states = (STATE_NUMBER[self.mode[0]], STATE_NUMBER[self.mode[1]], self.mode[2] == ENGAGED)
        self.rows.append((time, *speeds, *torques, *states))


def _single(choices):
    return tuple(c[0] for c in choices)


def _root(probe, a, b):
    """Root of `probe` in [a, b]; `a` itself where it starts at round-off below zero."""
    return a if probe(a) <= 0 else brentq(probe, a, b, xtol=1e-15, rtol=1e-14)
