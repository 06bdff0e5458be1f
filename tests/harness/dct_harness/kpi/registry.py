"""Every KPI said once: key, title, unit, formula, source.

`python -m dct_harness.kpi` rewrites KPIS.md beside this file.
"""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path

SETTLED = 0.05  # of the RMS of the torque: the band in which an estimate counts as settled
DWELL = 0.1  # s; how long it must stay there
LATENCY_LONGEST = 0.25  # s; a slower estimate is of no use to a shift of about 1 s
LATENCY_VARIES = 0.02  # of the RMS of the torque; below it a delay leaves no trace
JERK_CUTOFF = 10.0  # Hz, -3 dB of the Gaussian filter; above surge (2-8 Hz), below gear whine


@dataclass(frozen=True)
class Kpi:
    """One row of the registry; `unit` as shown to people.

    Tables show `digits` significant digits between `least` and `most`; beyond them, that a value
    is smaller or larger is all a reader needs. `kpis.json` holds every digit.
    """

    key: str
    title: str
    unit: str
    formula: str
    source: str
    digits: int = 3
    least: float = 0.01
    most: float = 1e6


RMSE = Kpi(
    "estimation.rmse", "RMS error of the estimate", "N·m",
    "sqrt(mean((T̂ − T)²)) over the samples of the scope",
    "paper, section 4.2 compares T̂ with T; RMSE is the usual figure",
)  # fmt: skip
MAX_ABS = Kpi(
    "estimation.maxAbs", "largest error of the estimate", "N·m",
    "max |T̂ − T| over the samples of the scope", "as above",
)  # fmt: skip
PERCENT = Kpi(
    "estimation.percentOfRms", "RMS error in % of the torque (NRMSE)", "%",
    "100 · RMSE of the scope / RMS of T over the whole scenario",
    "one denominator for all scopes: a phase in which the clutch is open stays defined",
)  # fmt: skip
RATIO = Kpi(
    "estimation.ratio", "map-based error / observer error", "1",
    "RMSE of the map-based estimate / RMSE of the observer, same scope",
    "the paper's claim that adaptation beats the map (Figs. 10, 12)",
    most=1000.0,
)  # fmt: skip
LATENCY = Kpi(
    "estimation.latency", "latency of the estimate", "s",
    f"argmin over 0 ≤ τ < {LATENCY_LONGEST:g} s of mean((T̂(t + τ) − T(t))²), refined by a "
    f"parabola; undefined where T varies by less than {100 * LATENCY_VARIES:g} % of its RMS",
    "average square difference function: Jacovitti and Scarano, Discrete time techniques for time "
    "delay estimation, IEEE Trans. Signal Processing 41 (1993) 525-533", 2, 1e-4,
)  # fmt: skip
SETTLING = Kpi(
    "estimation.settling", "settling time of the estimate after an event", "s",
    f"from a change of a clutch state until |T̂ − T| first stays within {100 * SETTLED:g} % of the "
    f"RMS of T for {DWELL:g} s, later changes included: in a handover only the sum of both clutch "
    "torques shows, and an estimate may have to wait for its end; undefined if it does not settle "
    "before the run ends; of the scenario: the longest",
    "settling time of control engineering, 5 % band", 3, 1e-4,
)  # fmt: skip
TRACKING = Kpi(
    "tracking.rms", "RMS torque-tracking error while slipping", "N·m",
    "sqrt(mean((|T_c| − T_request)²)) over samples of the scope in which that clutch slips",
    "the position sets the capacity, the slip its sign (6)(7), so magnitudes are compared",
)  # fmt: skip
FEEDBACK_RATIO = Kpi(
    "tracking.feedbackRatio", "tracking error with / without feedback", "1",
    "tracking.rms with feedback / tracking.rms without, same scenario and nominal friction",
    "what the estimate buys in the closed loop",
)  # fmt: skip
JERK_PEAK = Kpi(
    "shift.jerkPeak", "peak jerk", "m/s³",
    f"max |d/dt a_f|; a_f: vehicle acceleration through a zero-phase Gaussian low-pass, "
    f"−3 dB at {JERK_CUTOFF:g} Hz",
    "shift-quality practice; the filter is defined here because the peak depends on it",
)  # fmt: skip
JERK_RMS = Kpi(
    "shift.jerkRms", "RMS jerk", "m/s³", "sqrt(mean((d/dt a_f)²)), a_f as for the peak", "as above"
)
FRICTION_ENERGY = Kpi(
    "shift.frictionEnergy", "friction energy", "J",
    "∫ T_c (ω_d − ω_c) dt over the scope", "(6)(7): slip power is never negative",
)  # fmt: skip
FRICTION_PEAK = Kpi(
    "shift.frictionPeakPower", "peak friction power", "W", "max T_c (ω_d − ω_c)", "as above"
)
LOCK_UP = Kpi(
    "shift.lockUp", "lock-up time", "s", "first sample after slipping → engaged", "events (6)(7)", 5
)
SHIFT_DURATION = Kpi(
    "shift.duration", "shift duration", "s",
    "from the last sample with one clutch engaged and the other open to the first one with the "
    "roles exchanged",
    "covers torque and inertia phase of up- and downshift alike", 4,
)  # fmt: skip
INERTIA_PHASE = Kpi(
    "shift.inertiaPhase", "inertia phase of a shift", "s",
    "while 5 % < slip_off / (slip_off − slip_on) < 95 %: the engine side goes from one synchronous "
    "speed to the other",
    "Kulkarni, Shim and Zhang, Shift dynamics and control of dual-clutch transmissions, Mechanism "
    "and Machine Theory 42 (2007) 168-182", 4,
)  # fmt: skip
TORQUE_PHASE = Kpi(
    "shift.torquePhase", "torque phase of a shift", "s",
    "shift.duration − shift.inertiaPhase: the clutches hand the torque over at constant ratio",
    "as above", 4,
)  # fmt: skip
TORQUE_HOLE = Kpi(
    "shift.torqueHole", "torque hole of a shift", "N·m",
    "max over the shift of line − T_o,f; T_o,f: drive-shaft torque through the low-pass of the "
    "jerk, line: from its value at the start to that at the end; mirrored where the engine brakes",
    "a dual-clutch gearbox is built to have none; the line forgives the change of ratio",
)  # fmt: skip
FLARE = Kpi(
    "shift.engineFlare", "engine flare of a shift", "rad/s",
    "max over the shift of ω_e − max(ω_c1, ω_c2), at least 0",
    "engine speed above both synchronous speeds: the clutches carry too little", 3,
)  # fmt: skip
DOSE = Kpi(
    "shift.vibrationDose", "vibration dose value", "m/s^1.75",
    "(∫ a_w⁴ dt)^¼; a_w: vehicle acceleration weighted by Wd",
    "ISO 2631-1:1997, 6.3.2 and annex A (horizontal weighting Wd)",
)  # fmt: skip

KPIS = (
    RMSE, MAX_ABS, PERCENT, RATIO, LATENCY, SETTLING, TRACKING, FEEDBACK_RATIO,
    JERK_PEAK, JERK_RMS, DOSE, FRICTION_ENERGY, FRICTION_PEAK, LOCK_UP,
    SHIFT_DURATION, TORQUE_PHASE, INERTIA_PHASE, TORQUE_HOLE, FLARE,
)  # fmt: skip
ERRORS = (RMSE, MAX_ABS, PERCENT, RATIO)  # one table in which both estimates stand side by side
BY_KEY = {kpi.key: kpi for kpi in KPIS}
DOCUMENT = Path(__file__).with_name("KPIS.md")


def markdown() -> str:
    """Return the docs table of all KPIs."""
    head = "# KPIs\n\nGenerated by `python -m dct_harness.kpi`; do not edit.\n\n"
    lines = ["| KPI | what | unit | formula | source |", "|---|---|---|---|---|"]
    for k in KPIS:
        cells = [f"`{k.key}`", k.title, k.unit, k.formula, k.source]
        lines.append("| " + " | ".join(c.replace("|", "\\|") for c in cells) + " |")
    return head + "\n".join(lines) + "\n"
