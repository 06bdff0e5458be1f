"""What inputs do within a communication step: they go on with a slope, where an FMU can follow.

An input of an FMU with canInterpolateInputs has its source's value at the beginning of the step and
a first derivative (fmi2SetRealInputDerivatives):

    the scenario                                  towards its value at the end of the step
    an FMU that was stepped before in this step   from its old output to its new one
    another FMU                                   its fmi2GetRealOutputDerivatives; none: it holds

Integers, booleans and discrete reals hold. FMUs without canInterpolateInputs are fed as ever.
"""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np

from ..fmu.slopes import continuous, followed, interpolates
from .initial import Member


class Interpolation:
    """Slopes of all signals of a run; one `begin` per step, `feed` and `after` per component."""

    def __init__(self, members: Mapping[str, Member], world: np.ndarray, scripted: int) -> None:
        """The first `scripted` signals of `world` are the scenario's, then come outputs."""
        self._world, self._scripted = world, scripted
        self._start, self._slopes = np.zeros((2, len(world)))
        self._h = 1.0
        self._own: dict[int, slice] = {}  # by id of the FMU: its outputs
        self._moving = np.ones(len(world))
        first = scripted
        for member in members.values():
            outputs = member.fmu.outputs
            self._own[id(member.fmu)] = slice(first, first + len(outputs))
            self._moving[first : first + len(outputs)] = [continuous(v) for v in outputs]
            first += len(outputs)
        followers = [m for m in members.values() if interpolates(m.fmu)]
        read = {int(k) for m in followers for k in m.where}
        self._givers = [m.fmu for m in members.values()
                        if read & set(range(*self._own[id(m.fmu)].indices(first)))
                        and int(m.fmu.description.coSimulation.maxOutputDerivativeOrder or 0) > 0
                        ]  # fmt: skip
        self._buffers: dict[int, np.ndarray] = {}
        self._held: dict[int, list[int]] = {}  # inputs without a slope
        for member in followers:
            self._buffers[id(member.fmu)] = slopes = np.zeros(len(member.fmu.inputs))
            self._held[id(member.fmu)] = [k for k, v in enumerate(member.fmu.inputs)
                                          if not followed(v)]  # fmt: skip
            member.fmu.bind_slopes(slopes)

    def begin(self, now: np.ndarray, then: np.ndarray, h: float) -> None:
        """Start a step of `h` [s] over which the scenario goes from `now` to `then`."""
        self._h = h
        self._start[:] = self._world
        self._slopes[:] = 0.0
        self._slopes[: self._scripted] = (then - now) / h
        for fmu in self._givers:
            self._slopes[self._own[id(fmu)]] = fmu.get_slopes()
        self._slopes *= self._moving

    def feed(self, member: Member) -> None:
        """Set the input buffers of a component."""
        slopes = self._buffers.get(id(member.fmu))
        world = self._world if slopes is None else self._start
        world.take(member.where, out=member.values, mode="clip")
        if member.convert.needed:
            member.convert(member.values)
        if slopes is not None:
            self._slopes.take(member.where, out=slopes, mode="clip")
            member.convert.slopes(slopes)
            slopes[self._held[id(member.fmu)]] = 0.0

    def after(self, member: Member) -> None:
        """Let later components of this step see where the outputs of this one have gone."""
        own = self._own[id(member.fmu)]
        gone = self._world[own] - self._start[own]
        self._slopes[own] = gone * self._moving[own] / self._h
