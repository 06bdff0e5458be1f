"""What comparing each signal of two runs comes to."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from ..errors import instant
from ..results import Results
from .envelope import bounds
from .tolerances import Tolerance, Tolerances

MEND = ("make the reference again, or leave the signal out: `ignore = true` in a file for "
        "--tolerances")  # fmt: skip
END = 1e-9  # relative: ends that differ by rounding are the same


@dataclass(frozen=True)
class Outcome:
    """One signal; `worst` is how often it takes its allowance (≤ 1 passes).

    `time` [s], `reference` and `value` are those of the worst sample, in the signal's unit.
    """

    name: str
    passed: bool
    reason: str
    worst: float
    time: float | None = None
    reference: float | None = None
    value: float | None = None
    nrmse: float | None = None
    unit: str = ""


def compare(reference: Results, run: Results, tolerances: Tolerances) -> list[Outcome]:
    """Return an outcome for the time axis and for each signal of the reference.

    Signals that only the run has are no fault: a regression is what used to be there.
    """
    outcomes = [_ends(reference, run)]
    for name in reference.signals:
        allowed = tolerances.of(name)
        if name != "time" and not allowed.ignore:
            outcomes.append(_signal(name, reference, run, allowed))
    return outcomes


def _ends(reference: Results, run: Results) -> Outcome:
    """Compare from when to when the runs go."""
    ours, theirs = ((r.time[0], r.time[-1]) for r in (run, reference))
    near = all(abs(a - b) <= END * max(1.0, abs(b)) for a, b in zip(ours, theirs, strict=True))
    text = f"runs from {ours[0]:g} s to {ours[1]:g} s, reference {theirs[0]:g} s to {theirs[1]:g} s"
    return Outcome("time", near, "" if near else text, 0.0 if near else np.inf, unit="s")


def _signal(name: str, reference: Results, run: Results, allowed: Tolerance) -> Outcome:
    unit = reference.run.get("signals", {}).get(name, {}).get("unit", "")
    if name not in run:
        return Outcome(name, False, "is missing in the run", np.inf, unit=unit)
    kind = reference.run.get("signals", {}).get(name, {}).get("type", "Real")
    bad = _no_number(name, reference, unit, "the reference", MEND) or _no_number(
        name, run, unit, "the run", "no tolerance allows that"
    )
    if bad:
        return bad
    inside = (run.time >= reference.time[0]) & (run.time <= reference.time[-1] * (1 + END))
    if not inside.any():
        return Outcome(name, False, "shares no time with the reference", np.inf, unit=unit)
    t, b, a = run.time[inside], run[name][inside], reference[name]
    held = kind != "Real"
    low, high = bounds(reference.time, a, t, allowed.tube, held)
    outside = np.maximum(np.maximum(low - b, b - high), 0.0)
    band = allowed.abs + (0.0 if held else allowed.rel * float(np.abs(a).max()))
    k = int(np.argmax(outside))
    nearest, _ = bounds(reference.time, a, t, 0.0, held)
    nrmse = _ratio(_rms(b - nearest), _rms(nearest))
    share = max(_ratio(float(outside[k]), band),
                0.0 if allowed.nrmse is None else _ratio(nrmse, allowed.nrmse))  # fmt: skip
    return Outcome(
        name, share <= 1, _reason(float(outside[k]), band, nrmse, allowed), share,
        float(t[k]), float(nearest[k]), float(b[k]), nrmse, unit,
    )  # fmt: skip


def _no_number(name: str, told: Results, unit: str, where: str, remedy: str) -> Outcome | None:
    """Return the outcome of a signal that is infinite or NaN somewhere; None of all others."""
    bad = np.flatnonzero(~np.isfinite(told[name]))
    if not bad.size:
        return None
    time, value = float(told.time[bad[0]]), float(told[name][bad[0]])
    reason = f"is {value:g} in {where} at t = {instant(time)} s: {remedy}"
    return Outcome(name, False, reason, np.inf, time, unit=unit)


def _reason(outside: float, band: float, nrmse: float, allowed: Tolerance) -> str:
    """Return what is exceeded, by how much; an empty string for a pass."""
    found = []
    if not outside <= band:
        tube = f" within ±{allowed.tube:g} s" if allowed.tube else ""
        found.append(f"differs by {outside:.6g}, allowed {band:.6g}{tube}")
    if allowed.nrmse is not None and not nrmse <= allowed.nrmse:
        found.append(f"NRMSE {nrmse:.4g}, allowed {allowed.nrmse:g}")
    return "; ".join(found)


def _rms(values: np.ndarray) -> float:
    return float(np.sqrt(np.mean(np.square(values))))


def _ratio(part: float, whole: float) -> float:
    """Return part / whole; nothing of nothing is 0."""
    if part == 0:
        return 0.0
    return part / whole if whole > 0 else np.inf
