"""What to do when an FMU cannot take a step: fmi2Discard of fmi2DoStep (FMI 2.0.4, 4.2.2).

It is asked first whether it wants the simulation to end (fmi2Terminated).
"""

from __future__ import annotations

from typing import Any

from ..errors import instant

SHORTEST = 1 / 4096  # of the communication step
ROUNDING = 1e-9  # of the communication step


def finish(fmu: Any, t: float, h: float) -> None:
    """Take the rest of a discarded step from `t` to `t + h` [s], in smaller ones.

    An FMU that got part of the way goes on from there; one that did not move tries half the step.
    Inputs stay as they are, or go on with their slopes; afterwards they are as before.

    Raises
    ------
    FmuRuntimeError
        The FMU cannot vary its step, does not tell how far it got, does not get on, or asks to end
        the simulation before `t + h`.
    """
    with fmu.inputs_kept():
        ended = _divide(fmu, t, h)
    if not ended:
        fmu.note_discard(t)


def _divide(fmu: Any, t: float, h: float) -> bool:
    """Take the step in parts, with inputs that go on; returns whether it is the last one."""
    end, at, part = t + h, t, h
    discarded = True
    while end - at > ROUNDING * h:
        if discarded:
            if fmu.terminated():
                _end(fmu, at, end, ROUNDING * h)
                return True
            before = at
            at, part = _after(fmu, at, end, part, ROUNDING * h)
            fmu.advance_inputs(at - before)
            if part < SHORTEST * h:
                fmu.give_up(f"it does not get past t = {instant(at)} s, whatever the step")
        part = min(part, end - at)
        discarded = fmu.attempt(at, part)
        if not discarded:
            at += part
            fmu.advance_inputs(part)
    return False


def _end(fmu: Any, at: float, end: float, rounding: float) -> None:
    """End the simulation where the FMU got to from `at`; its values there are those of `end`.

    After fmi2Terminated, and only then, they are good (FMI 2.0.4, 4.2.4, "stepFailed").
    """
    reached = fmu.reached()
    told = reached is not None and at - rounding <= reached <= end + rounding
    error = fmu.note_end(reached if told else at)
    if not (told and reached >= end - rounding):
        raise error
    fmu.get_outputs()


def _after(fmu: Any, at: float, end: float, part: float, rounding: float) -> tuple[float, float]:
    """Return where the FMU is after a discarded step of `part` from `at`, and the next step.

    An FMU that adds up its steps is elsewhere than their product by `rounding` [s] at most.
    """
    varies = fmu.description.coSimulation.canHandleVariableCommunicationStepSize
    if str(varies).lower() != "true":
        fmu.give_up("it cannot take this step and takes no other one; change system.step")
    reached = fmu.reached()
    if reached is None:
        fmu.give_up("it does not tell how far it got (fmi2GetRealStatus); choose a smaller step")
    if not at - rounding <= reached <= at + part + rounding:
        fmu.give_up(f"it says that it is at t = {instant(reached)} s, outside the step")
    return (reached, end - reached) if reached > at + rounding else (at, part / 2)
