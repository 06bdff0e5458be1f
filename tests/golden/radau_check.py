"""A second, independent solution: scalar equations (1)-(11) integrated by Radau with events.

Shares with the reference the parameters, the scenario and the ORDER of the modes of clutches,
brake, synchronisers and gears that jam; every equation is written out again (`scalar_plants.py`,
`scalar_losses.py`, `scalar_heat.py`), gears change by a second look at what is preselected, and
every event is located again by `solve_ivp`.
"""

from __future__ import annotations

from itertools import pairwise

import numpy as np
from hybrid import PARTS
from reference_plant import Params
from scalar_heat import HeatedScalarPlant
from scalar_losses import RigidLossyScalarPlant
from scalar_plants import OUTPUT, GearedScalarPlant, RigidScalarPlant, ScalarPlant
from scipy.integrate import solve_ivp

SIGN_OF = {"disengaged": 0, "engaged": 2}
AT_ONCE = 1e-6  # [N·m] beyond its peak: a clutch that breaks away where the other one locks
ORDER = (*PARTS, "synchroniser 1", "synchroniser 2", "output")


def scalar_plant(case):
    """The scalar equations of a case."""
    params = Params(rigid=case.rigid, **case.params)
    if case.rigid:
        kind = RigidLossyScalarPlant if params.lossy else RigidScalarPlant
        return kind(params.in_gears(case.gears[0][1]), case.scenario)
    if len(case.gears) > 1:
        return GearedScalarPlant(params, case.scenario, case.gears)
    kind = ScalarPlant if params.heat is None else HeatedScalarPlant
    return kind(params.in_gears(case.gears[0][1]), case.scenario)


class RadauRun:
    """Integrates a case with the mode order of its events; fills `rows`, `times`."""

    def __init__(self, case, events, initial, rtol=1e-11, atol=1e-12):
        self.case, self.plant = case, scalar_plant(case)
        *initial, self.plant.turns = initial
        self.pending = [event for event in events if event["clutch"] in ORDER]
        self.mode = list(initial)
        self.tolerances = {"rtol": rtol, "atol": atol, "method": "Radau"}
        omega = case.vehicle_speed / self.plant.p.r_w
        self.y = np.array(self.plant.start(case.engine_speed, omega))
        self.rows, self.times = [], []

    def run(self, stop=None):
        """Advance over the pieces of the case up to `stop` [s]."""
        for piece in self._merged(stop or self.case.stop):
            self._advance(piece)
        return self

    def _merged(self, stop):
        # Held inputs restart each step; continuous ones only where they bend.
        if self.case.h is not None:
            pieces = self.case.pieces(self.plant.p, longest=self.case.h)
            return [(p.start, p.end, p.sample) for p in pieces if p.end <= stop + 1e-9]
        kinks = [t for t in self.case.scenario.kinks(self.plant.p, stop) if t < stop]
        edges = np.unique(np.concatenate([[0.0], np.round(kinks, 13), np.arange(stop + 1e-9)]))
        edges = np.append(edges[edges < stop - 1e-9], stop)
        return [(a, b, None) for a, b in pairwise(edges)]

    def _advance(self, piece):
        t, end, sample = piece
        self._sample(t if sample is None else sample)
        while self.pending and self.pending[0]["time"] <= t + 1e-9:
            self._apply(self.pending.pop(0), None)
        while t < end:
            due = [e for e in self.pending if e["time"] < end - 1e-9]
            t = self._integrate(t, end, sample, due[0] if due else None)
            if due:
                self._apply(self.pending.pop(0), t)
                self._take_in(due[0]["time"])

    def _sample(self, time):
        """Change gears."""
        if isinstance(self.plant, GearedScalarPlant):
            pressed = [force > 0 for force in self.plant.inputs(time)[1]]
            self.y = self.plant.sample(time, self.y, pressed)

    def _take_in(self, time):
        """Let the output turn in a gear that came in at `time`: nothing to locate."""
        following = self.pending[0] if self.pending else {"clutch": None}
        if following["clutch"] == "output" and following["time"] == time:
            self._apply(self.pending.pop(0), None)

    def _apply(self, event, found):
        part = ORDER.index(event["clutch"])
        if part == OUTPUT:
            turns = {"disengaged": None, "engaged": 0}.get(event["to"], event["direction"])
            self.y = self.plant.turn(turns, self.y)
        elif part < len(PARTS):
            self.mode[part] = SIGN_OF.get(event["to"], event["direction"])
        elif found is not None:
            self.plant.synchronised(part - len(PARTS))
        if found is not None:
            self.times.append((event["time"], found))

    def _integrate(self, t, end, sample, due):
        def u(time):
            return self.plant.inputs(time if sample is None else sample)

        def crossing(time, y):
            return self.plant.guard(y, self.mode, u(time), ORDER.index(due["clutch"]))

        if due and crossing(t, self.y) < -AT_ONCE:
            return t
        crossing.terminal, crossing.direction = True, -1
        grid = self._row_times(t, end)
        sol = solve_ivp(
            *(lambda time, y: self.plant.rate(y, self.mode, u(time)), (t, end), self.y),
            **self.tolerances,
            t_eval=np.unique(np.append(grid, end)),
            events=[crossing] if due else None,
        )
        last = sol.t_events[0][0] if due else end
        keep = grid[grid <= last]
        for time, y in zip(keep, np.asarray(sol.y).T, strict=False):
            self._record(time, y, u(time))
        self.y = sol.y_events[0][0] if due else sol.y[:, -1]
        return last

    def _row_times(self, t, end):
        first = int(np.floor(t / self.case.row_every + 1e-6)) + 1
        last = int(np.floor(end / self.case.row_every + 1e-9))
        grid = np.minimum(np.arange(first, last + 1) * self.case.row_every, end)
        return np.unique(np.append(grid, end)) if end > self.case.stop - 1e-9 else grid

    def _record(self, time, y, u):
        t_d, t_c, _, t_o, t_v = self.plant.torques(y, self.mode, u)
        self.rows.append((time, *self.plant.speeds(y), t_d, *t_c, t_o, t_v))
