"""KPIs against closed-form signals; every expected number is computed from its formula."""

from __future__ import annotations

import json
import math
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from dct_harness import kpi
from dct_harness.errors import ConfigError
from dct_harness.kpi import limits, registry, scopes
from dct_harness.results import Results

STEP = 0.001  # s
TIME = np.arange(10001) * STEP
ROUNDING = 1e-9  # sums over 1e4 samples, each rounded to 1e-16
SAMPLED = 2e-3  # relative: mean over samples that include both ends of the period
TORQUES = ("clutch1.torque", "clutch2.torque", "driveShaft.torque")


def results(**signals: np.ndarray) -> Results:
    """Return a run of 10 s; `__` in a name stands for a dot."""
    named = {name.replace("__", "."): values for name, values in signals.items()}
    return Results({"time": TIME, **named}, {})


def value(found: dict[str, Any], key: str, scope: str = "scenario", **which: str) -> Any:
    """Return the one value of a KPI in a scope."""
    rows = [r for r in found["rows"] if r["kpi"] == key and r["scope"] == scope]
    rows = [r for r in rows if all(r[k] == v for k, v in which.items())]
    assert len(rows) == 1, rows
    return rows[0]["value"]


def sine(amplitude: float, frequency: float = 1.0) -> np.ndarray:
    """Return a sine over TIME with whole periods."""
    return amplitude * np.sin(2 * np.pi * frequency * TIME)


def test_sine_error_has_its_closed_form_rms_maximum_and_percentage() -> None:
    truth = np.full_like(TIME, 50.0)
    run = results(plant__driveShaft__torque=truth,
                  observer__driveShaft__torque=truth + sine(3.0),
                  observer__mapBased__driveShaft__torque=truth + 12.0)  # fmt: skip
    found = kpi.compute(run, {})
    own = {"signal": "driveShaft.torque", "estimate": "observer"}
    assert value(found, "estimation.rmse", **own) == pytest.approx(3 / math.sqrt(2), rel=SAMPLED)
    assert value(found, "estimation.maxAbs", **own) == pytest.approx(3.0, rel=ROUNDING)
    percent = 100 * 3 / math.sqrt(2) / 50
    assert value(found, "estimation.percentOfRms", **own) == pytest.approx(percent, rel=SAMPLED)
    ratio = 12 / (3 / math.sqrt(2))
    assert value(found, "estimation.ratio") == pytest.approx(ratio, rel=SAMPLED)


def test_further_observers_count_by_their_own_name() -> None:
    truth = sine(50.0)
    late = round(0.02 / STEP)
    run = results(plant__driveShaft__torque=truth, observer__driveShaft__torque=truth + 4.0,
                  observer__mapBased__driveShaft__torque=truth + 12.0,
                  kalman__driveShaft__torque=np.roll(truth, late),
                  control__clutch1__position=truth)  # fmt: skip
    found = kpi.compute(run, {})
    assert {r["estimate"] for r in found["rows"]} == {"observer", "mapBased", "kalman", ""}
    error = 2 * 50 * math.sin(math.pi * late * STEP) / math.sqrt(2)
    own = {"signal": "driveShaft.torque", "estimate": "kalman"}
    assert value(found, "estimation.rmse", **own) == pytest.approx(error, rel=SAMPLED)
    assert value(found, "estimation.latency", **own) == pytest.approx(late * STEP, abs=STEP / 10)
    assert value(found, "estimation.ratio", **own) == pytest.approx(12 / error, rel=SAMPLED)
    assert value(found, "estimation.ratio", estimate="") == pytest.approx(3.0, rel=ROUNDING)
    text = kpi.format_table(found)
    line = next(line for line in text.splitlines() if line.startswith("kalman"))
    assert line.split()[2] == f"{error:.2f}"
    assert "kalman" not in kpi.format_table(kpi.compute(results(
        plant__driveShaft__torque=truth, observer__driveShaft__torque=truth), {}))  # fmt: skip


@pytest.mark.parametrize("seed", range(5))
def test_perfect_estimate_is_zero_percent(seed: int) -> None:
    noise = np.random.default_rng(seed)
    truth = {torque: noise.normal(0, 100, len(TIME)) for torque in TORQUES}
    signals = {f"{prefix}.{torque}": values for torque, values in truth.items()
               for prefix in ("plant", "observer", "observer.mapBased")}  # fmt: skip
    found = kpi.compute(Results({"time": TIME, **signals}, {}), {})
    errors = [r["value"] for r in found["rows"] if r["kpi"] != "estimation.ratio"
              and r["kpi"].startswith("estimation.")]  # fmt: skip
    assert len(errors) == 3 * (2 * 3 + 1)  # both estimates, and the latency of one
    assert set(errors) == {0.0}
    assert value(found, "estimation.ratio", signal="clutch1.torque") is None


def test_scaling_everything_leaves_percentages_and_ratios() -> None:
    noise = np.random.default_rng(7)
    base = {f"{p}clutch1.torque": noise.normal(0, 50, len(TIME))
            for p in ("plant.", "observer.", "observer.mapBased.")}  # fmt: skip
    small = kpi.compute(Results({"time": TIME, **base}, {}), {})
    large = kpi.compute(Results({"time": TIME, **{k: 8 * v for k, v in base.items()}}, {}), {})
    for key, factor in (("rmse", 8), ("maxAbs", 8), ("percentOfRms", 1)):
        pick = ("estimation." + key, "scenario")
        a, b = (value(x, *pick, estimate="observer") for x in (small, large))
        assert b == pytest.approx(factor * a, rel=ROUNDING)


def phased(tmp_path: Path, text: str) -> dict[str, Any]:
    """Return a run.json whose scenario has these phases beside it."""
    (tmp_path / "phases.csv").write_text(text)
    return {"system": {"name": "x", "scenario": str(tmp_path / "s.csv")}, "step": STEP}


def test_phases_split_the_error_and_share_one_denominator(tmp_path: Path) -> None:
    truth = np.full_like(TIME, 20.0)
    run = results(plant__clutch1__torque=truth,
                  observer__clutch1__torque=truth + np.where(TIME < 4.0, 1.0, 3.0))  # fmt: skip
    found = kpi.compute(run, phased(tmp_path, "start,end,phase\n0,4,a\n4,10,b\n"))
    for scope, error in (("phase/a", 1.0), ("phase/b", 3.0)):
        assert value(found, "estimation.rmse", scope) == pytest.approx(error, rel=ROUNDING)
        percent = value(found, "estimation.percentOfRms", scope)
        assert percent == pytest.approx(100 * error / 20, rel=ROUNDING)


@pytest.mark.parametrize(("text", "said"), [
    ("start,end,phase\n0,1,a\n1,2,a\n", "'a' stands twice"),
    ("start,end,phase\n2,1,a\n", "must end after it starts"),
    ("start,end,phase\n0,soon,a\n", ":2: needs numbers"),
    ("from,to\n0,1\n", ":2: needs numbers"),
])  # fmt: skip
def test_bad_phases_are_refused(tmp_path: Path, text: str, said: str) -> None:
    with pytest.raises(ConfigError, match=said):
        kpi.compute(results(), phased(tmp_path, text))


def test_phases_survive_a_move_of_the_result_directory(tmp_path: Path) -> None:
    (tmp_path / "kpis.json").write_text(
        json.dumps({"phases": [{"name": "a", "start": 0.0, "end": 4.0}]})
    )
    moved = Results({"time": TIME}, {}, tmp_path)
    gone = {"system": {"scenario": "/gone/s.csv"}}
    assert scopes.load_phases(moved, gone) == [scopes.Phase("a", 0.0, 4.0)]


def states(*spans: tuple[float, int]) -> np.ndarray:
    """Return a clutch state that holds each code from its time on."""
    starts, codes = zip(*spans, strict=True)
    return np.array(codes)[np.searchsorted(starts, TIME, side="right") - 1].astype(float)


def test_tracking_counts_only_slipping_samples_and_compares_magnitudes() -> None:
    state = states((0.0, 1), (2.0, 2), (4.0, 3), (6.0, 2), (8.0, 1))
    sign = np.where(TIME < 5.0, 1.0, -1.0)
    torque = np.where(state == 2, sign * 45.0, 999.0)
    run = results(plant__clutch1__torque=torque, plant__clutch1__state=state,
                  scenario__clutch1__torqueRequest=np.full_like(TIME, 40.0))  # fmt: skip
    found = kpi.compute(run, {})
    assert value(found, "tracking.rms", signal="clutch1") == pytest.approx(5.0, rel=ROUNDING)


def test_feedback_ratio_divides_the_two_runs_and_meets_its_limit() -> None:
    def tracked(error: float) -> dict[str, Any]:
        signals = {"time": TIME}
        for clutch in ("clutch1", "clutch2"):
            signals[f"scenario.{clutch}.torqueRequest"] = np.full_like(TIME, 40.0)
            signals[f"plant.{clutch}.torque"] = np.full_like(TIME, 40.0 + error)
            signals[f"plant.{clutch}.state"] = np.full_like(TIME, 2.0)
        return kpi.compute(Results(signals, {}), {})

    pair = kpi.compare_feedback(tracked(2.0), tracked(-8.0))
    assert {r["signal"] for r in pair} == {"clutch1", "clutch2", "clutches"}
    assert all(r["value"] == pytest.approx(0.25, rel=ROUNDING) for r in pair)
    limit = {"kpi": "tracking.feedbackRatio", "signal": "clutches", "max": 0.5}
    run = {"system": {"kpis": [limit]}}
    assert [j["pass"] for j in limits.judge(run, pair)] == [True]
    worse = kpi.compare_feedback(tracked(5.0), tracked(8.0))
    assert [j["pass"] for j in limits.judge(run, worse)] == [False]


def test_drive_shaft_slips_while_any_clutch_does() -> None:
    run = results(plant__clutch1__state=states((0.0, 1), (2.0, 2), (5.0, 3)),
                  plant__clutch2__state=states((0.0, 1), (8.0, 2)))  # fmt: skip
    masks = scopes.state_masks(run, "driveShaft.torque")
    starts = {scope: float(TIME[mask][0]) for scope, mask in masks.items()}
    assert starts == {"state/disengaged": 0.0, "state/slipping": 2.0, "state/engaged": 5.0}
    assert sum(int(mask.sum()) for mask in masks.values()) == len(TIME)


def test_jerk_of_a_sine_is_damped_by_the_gaussian() -> None:
    frequency = 4.0
    omega = 2 * math.pi * frequency
    run = results(plant__vehicle__acceleration=sine(2.0, frequency))
    sigma = math.sqrt(math.log(2)) / (2 * math.pi * registry.JERK_CUTOFF)
    amplitude = 2.0 * omega * math.exp(-((omega * sigma) ** 2) / 2)
    found = kpi.compute(run, {})
    edge = 5e-3  # relative: held ends and the central difference, (omega h)^2 / 6 = 1e-4
    assert value(found, "shift.jerkPeak") == pytest.approx(amplitude, rel=edge)
    assert value(found, "shift.jerkRms") == pytest.approx(amplitude / math.sqrt(2), rel=edge)


def test_jerk_falls_back_to_speed() -> None:
    run = results(plant__vehicle__speed=0.5 * TIME**2)  # acceleration t, jerk 1
    inner = kpi.shift.jerk(run)[100:-100]
    assert inner == pytest.approx(np.ones_like(inner), rel=1e-6)


def test_friction_energy_of_a_ramp_is_its_integral(tmp_path: Path) -> None:
    run = results(plant__clutch2__torque=np.full_like(TIME, 30.0),
                  plant__clutch2__slip=10.0 - TIME)  # fmt: skip
    found = kpi.compute(run, phased(tmp_path, "start,end,phase\n0,4,a\n4,10,b\n"))
    energy = "shift.frictionEnergy"
    assert value(found, energy, signal="clutch2") == pytest.approx(30 * 50, rel=ROUNDING)
    assert value(found, energy, "phase/a") == pytest.approx(30 * (40 - 8), rel=ROUNDING)
    parts = value(found, energy, "phase/a") + value(found, energy, "phase/b")
    assert parts == pytest.approx(value(found, energy), rel=ROUNDING)
    assert value(found, "shift.frictionPeakPower", signal="clutch2") == 300.0


def test_shift_lasts_from_one_drive_to_the_other() -> None:
    run = results(plant__clutch1__state=states((0.0, 1), (1.0, 2), (2.0, 3), (5.5, 2), (6.0, 1)),
                  plant__clutch2__state=states((0.0, 1), (5.0, 2), (6.5, 3)))  # fmt: skip
    found = kpi.compute(run, {})
    assert value(found, "shift.lockUp", "lock-up 1", signal="clutch1") == 2.0
    duration = value(found, "shift.duration", "shift 1", signal="clutch1 → clutch2")
    assert duration == pytest.approx(6.5 - 5.0 + STEP, abs=ROUNDING)


def test_a_limit_on_a_signal_that_no_kpi_is_of_gets_a_hint() -> None:
    key = registry.FEEDBACK_RATIO.key
    rows = [{"kpi": key, "signal": f"clutch{k}.torque"} for k in (1, 2)]
    wrong = [{"kpi": key, "signal": "clutch3.torque"}, {"kpi": key, "signal": "clutch1.torque"}]
    (told,) = limits.of_nothing(wrong, rows)
    assert told.startswith(
        f"{key} is not computed of 'clutch3.torque' here, but of clutch1.torque,"
    )
    assert "Did you mean 'clutch" in told
    assert limits.of_nothing(wrong, []) == []


def test_limits_of_the_system_give_the_verdict() -> None:
    truth = np.full_like(TIME, 100.0)
    factors = {"plant": 1.0, "observer": 1.02, "observer.mapBased": 1.5}
    signals = {f"{p}.{t}": truth * f for t in TORQUES for p, f in factors.items()}
    percent = {"kpi": "estimation.percentOfRms", "estimate": "observer", "max": 3}
    ratio = {"kpi": "estimation.ratio", "min": 4}
    kpis = [{**limit, "signal": torque} for limit in (percent, ratio) for torque in TORQUES]
    run = {"system": {"kpis": kpis}}
    loaded = Results({"time": TIME, **signals}, run)
    found = kpi.compute(loaded, run)
    assert len(found["limits"]) == 6
    assert found["verdict"] == "pass"
    assert kpi.compute(loaded, {**run, "status": "partial"})["verdict"] == "fail"
    assert kpi.compute(loaded, {"system": {}})["verdict"] == "not judged"
    elsewhere = {**percent, "signal": TORQUES[0], "scope": "phase/none"}  # no value, no pass
    assert kpi.compute(loaded, {"system": {"kpis": [elsewhere]}})["verdict"] == "fail"
    signals["observer.driveShaft.torque"] = truth * 1.04  # 4 % against 3 %
    assert kpi.compute(Results({"time": TIME, **signals}, run), run)["verdict"] == "fail"
    del signals["observer.driveShaft.torque"]
    assert kpi.compute(Results({"time": TIME, **signals}, run), run)["verdict"] == "fail"


@pytest.mark.parametrize(("figure", "digits", "text"), [
    (12.345, 3, "12.3"), (0.012345, 3, "0.0123"), (9.996, 3, "10.0"), (1234.5, 3, "1234"),
    (None, 3, "–"), (0.0, 3, "0"), (-3.14159, 3, "-3.14"), (1.5e-4, 3, "0.000150"),
])  # fmt: skip
def test_numbers_read_well(figure: float | None, digits: int, text: str) -> None:
    assert kpi.table.number(figure, digits) == text


@pytest.mark.parametrize(("key", "figure", "text"), [
    ("estimation.rmse", 4e-10, "<0.01"), ("estimation.ratio", 1.6e5, ">1000"),
    ("estimation.rmse", 0.0, "0"), ("estimation.ratio", 999.4, "999"),
])  # fmt: skip
def test_what_no_reader_needs_is_not_spelled_out(key: str, figure: float, text: str) -> None:
    assert kpi.table.shown({"kpi": key, "value": figure}) == text


def test_table_is_aligned_and_json_is_strict() -> None:
    truth = sine(50.0)
    run = results(plant__clutch1__torque=truth, observer__clutch1__torque=truth * 1.1,
                  observer__mapBased__clutch1__torque=truth * 0.5)  # fmt: skip
    found = kpi.compute(run, {})
    json.dumps(found, allow_nan=False)
    told, head, rule, row = kpi.format_table(found).splitlines()[:4]
    assert "RMSE, max [N·m]" in told
    assert len(head) == len(rule) == len(row)
    assert row.split()[:2] == ["T_c1", "scenario"]
    assert row.split()[-1] == "5.00"


def test_docs_table_is_fresh() -> None:
    fresh = registry.DOCUMENT.read_text(encoding="utf-8") == registry.markdown()
    assert fresh, "run `python -m dct_harness.kpi`"


def test_paper_phases_cover_the_manoeuvre_without_gaps(repo_root: Path) -> None:
    phases = scopes.read_phases(repo_root / "examples/closed_loop/scenarios/phases.csv")
    assert [p.end for p in phases[:-1]] == [p.start for p in phases[1:]]
    assert (phases[0].start, phases[-1].end) == (1.0, 30.0)


def test_a_limit_without_a_value_says_what_that_means() -> None:
    judged = {"kpi": "estimation.ratio", "signal": "clutch1.torque", "estimate": "", "unit": "1",
              "scope": "scenario", "relation": ">=", "limit": 4.0, "pass": False}  # fmt: skip
    for value, told in ((None, True), (3.0, False)):
        kpis = {"rows": [], "limits": [{**judged, "value": value}], "verdict": "fail"}
        assert ("–: not defined in this run" in kpi.format_table(kpis)) == told
