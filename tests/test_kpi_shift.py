"""Latency, settling, vibration dose and the parts of a shift against closed forms."""

from __future__ import annotations

import math

import numpy as np
import pytest
from dct_harness import kpi
from dct_harness.kpi import filters, registry, timing
from dct_harness.results import Results
from test_kpi import ROUNDING, STEP, TIME, results, sine, states, value

SAME = 1e-9  # relative: costs that differ by less say nothing of a shift


@pytest.mark.parametrize("late", [0.0, 0.001, 0.0075, 0.05])
def test_latency_is_the_delay_of_a_delayed_sine(late: float) -> None:
    truth = sine(40.0)
    run = results(plant__clutch1__torque=truth,
                  observer__clutch1__torque=40 * np.sin(2 * np.pi * (TIME - late)))  # fmt: skip
    found = value(kpi.compute(run, {}), "estimation.latency", signal="clutch1.torque")
    assert found == pytest.approx(late, abs=STEP / 100)  # the parabola refines one step


@pytest.mark.parametrize("truth", [np.full_like(TIME, 40.0), np.zeros_like(TIME)])
def test_constant_torque_tells_no_latency(truth: np.ndarray) -> None:
    run = results(plant__clutch1__torque=truth, observer__clutch1__torque=truth + 1)
    assert value(kpi.compute(run, {}), "estimation.latency") is None


@pytest.mark.parametrize("seed", range(60))
def test_the_search_by_spectra_finds_what_all_shifts_one_by_one_do(seed: int) -> None:
    draw = np.random.default_rng(seed)
    count, late, longest = draw.integers(300, 3000), draw.integers(0, 260), 250
    truth = draw.normal(size=count).cumsum() * 10.0 ** draw.uniform(-3, 3)
    delayed = np.concatenate([np.full(min(late, count), truth[0]), truth])[:count]
    noisy = delayed + draw.normal(size=count) * 10.0 ** draw.uniform(-12, 2)
    estimate = (delayed, noisy, np.zeros(count), np.round(delayed))[seed % 4]
    mask = draw.random(count) < (1.0, 0.4)[seed % 2]
    mask[0] = True
    index = np.flatnonzero(mask)
    index = index[index < count - longest]
    costs = [np.mean(np.square(estimate[index + k] - truth[index])) for k in range(longest + 1)]
    near = timing.nearest(truth, estimate, index, longest)
    assert np.argmin(costs) in near
    assert len(near) <= longest // 10 or np.ptp(costs) < SAME * max(costs)
    if len(index) == count - longest:
        assert (
            timing.nearest(truth, estimate, slice(0, len(index)), longest).tolist() == near.tolist()
        )
    best = int(np.argmin(costs))
    found = timing.latency(timing.Truth(truth), estimate, mask, STEP)
    if best in (0, longest):
        assert found == (None if best else 0.0)
    else:
        assert abs(found / STEP - best) <= 0.5


def test_latency_beyond_the_search_is_undefined() -> None:
    run = results(plant__clutch1__torque=sine(40.0, 0.2),
                  observer__clutch1__torque=40 * np.sin(0.4 * np.pi * (TIME - 0.6)))  # fmt: skip
    assert value(kpi.compute(run, {}), "estimation.latency") is None


def settled(decay: float, *, until: float = 10.0) -> dict:
    """Return KPIs of an error that jumps to 20 % at 2 s and decays at a rate [1/s]."""
    gone = np.where(TIME >= 2.0, 20 * np.exp(-decay * (TIME - 2.0)), 0.0)
    truth = np.full_like(TIME, 100.0)
    run = results(plant__clutch1__torque=truth, observer__clutch1__torque=truth + gone,
                  plant__clutch1__state=states((0.0, 1), (2.0, 2), (until, 3)))  # fmt: skip
    return kpi.compute(run, {})


def test_settling_of_an_exponential_is_its_logarithm() -> None:
    expected = math.log(20 / (100 * registry.SETTLED)) / 3.0
    found = value(settled(3.0), "estimation.settling", "event/1 clutch1 slipping")
    assert found == pytest.approx(expected, abs=STEP)
    assert value(settled(3.0), "estimation.settling") == found


def test_an_estimate_may_settle_after_the_next_event_only() -> None:
    """Both times end at the same moment, so the first one is the longer by their distance."""
    found = settled(0.4, until=4.0)
    times = [value(found, "estimation.settling", f"event/{name}")
             for name in ("1 clutch1 slipping", "2 clutch1 engaged")]  # fmt: skip
    assert times[0] == pytest.approx(math.log(20 / (100 * registry.SETTLED)) / 0.4, abs=STEP)
    assert times[1] == pytest.approx(times[0] - 2.0, abs=STEP)
    assert value(found, "estimation.settling") == times[0]


def test_an_estimate_that_never_settles_is_undefined() -> None:
    found = settled(0.1)
    assert value(found, "estimation.settling", "event/1 clutch1 slipping") is None
    assert value(found, "estimation.settling") is None
    spoken = kpi.table.shown({"kpi": "estimation.settling", "value": None})
    assert spoken == kpi.table.UNDEFINED


# ISO 2631-1:1997, table 3: Wd in thousandths at one-third octaves [Hz].
TABLE_3 = {0.5: 853, 0.8: 992, 1.0: 1011, 2.0: 890, 4.0: 512, 8.0: 253, 16.0: 125}


@pytest.mark.parametrize(("frequency", "thousandths"), TABLE_3.items())
def test_weighting_is_that_of_the_standard(frequency: float, thousandths: int) -> None:
    found = abs(filters.weighting_d(np.array([frequency]))[0])
    assert found == pytest.approx(thousandths / 1000, rel=0.02)  # exact frequencies are 10^(k/10)


def test_vibration_dose_of_a_sine_is_its_fourth_power_mean() -> None:
    frequency, amplitude = 4.0, 2.0
    run = results(plant__vehicle__acceleration=sine(amplitude, frequency))
    weighted = amplitude * abs(filters.weighting_d(np.array([frequency]))[0])
    expected = weighted * (3 / 8 * TIME[-1]) ** 0.25  # mean of sin^4 is 3/8
    assert value(kpi.compute(run, {}), "shift.vibrationDose") == pytest.approx(expected, rel=5e-3)


@pytest.mark.parametrize("count", [500, 1000, 3000])
def test_the_weighting_of_a_short_run_is_that_of_the_start_of_a_long_one(count: int) -> None:
    time = np.arange(20000) * 1e-3
    values = np.exp(-time) * np.sin(2.6 * np.pi * time) + 0.5 * np.sin(3.0 * time)
    long, short = (filters.weight_d(v, 1e-3) for v in (values, values[:count]))
    # What the sampled band limit rings ahead of the cut at the end of the short one.
    assert short == pytest.approx(long[:count], abs=2e-5 * np.abs(long).max())


def test_settling_is_found_among_stretches_that_are_too_short() -> None:
    near = np.array([1, 1, 0, 1, 0, 0, 1, 1, 1, 0, 1, 1, 1, 1, 1], dtype=bool)
    time = np.arange(len(near)) * registry.DWELL / 3
    settled = timing.Settled(time, near)
    assert [settled.after(k) for k in (0, 6, 10, 11, 12)] == [
        time[10], time[10] - time[6], 0.0, 0.0, None]  # fmt: skip


def test_dose_grows_with_time_to_the_quarter() -> None:
    def dose(count: int) -> float:
        values = 2.0 * np.sin(8 * np.pi * TIME[:count])
        run = Results({"time": TIME[:count], "plant.vehicle.acceleration": values}, {})
        return value(kpi.compute(run, {}), "shift.vibrationDose")

    assert dose(10001) / dose(5001) == pytest.approx(2**0.25, rel=5e-3)


def upshift(**more: np.ndarray) -> dict:
    """Return KPIs of a shift from 3 s to 6 s whose engine slows down from 4 s to 6 s."""
    from_speed, to_speed = 300.0, 200.0
    engine = np.interp(TIME, [4.0, 6.0], [from_speed, to_speed])
    run = results(
        plant__clutch1__state=states((0.0, 3), (4.0, 2), (5.0, 1)),
        plant__clutch2__state=states((0.0, 1), (3.0, 2), (6.0, 3)),
        plant__clutch1__slip=engine - from_speed, plant__clutch2__slip=engine - to_speed,
        plant__clutch1__speed=np.full_like(TIME, from_speed),
        plant__clutch2__speed=np.full_like(TIME, to_speed),
        **{"plant__engine__speed": engine, **more},
    )  # fmt: skip
    return kpi.compute(run, {})


def test_shift_splits_into_torque_and_inertia_phase() -> None:
    found = upshift()
    total = value(found, "shift.duration", "shift 1", signal="clutch1 → clutch2")
    assert total == pytest.approx(3.0 + STEP, abs=ROUNDING)
    inertia = value(found, "shift.inertiaPhase", "shift 1")
    assert inertia == pytest.approx(0.9 * 2.0, abs=2 * STEP)  # 5 % to 95 % of 2 s
    torque = value(found, "shift.torquePhase", "shift 1")
    assert torque + inertia == pytest.approx(total, abs=ROUNDING)


@pytest.mark.parametrize("sign", [1.0, -1.0])
def test_torque_hole_is_measured_from_the_line(sign: float) -> None:
    line = np.interp(TIME, [3.0, 6.0], [500.0, 300.0])
    dip = 120.0 * np.exp(-(((TIME - 4.5) / 0.3) ** 2))  # slow against the low-pass
    found = upshift(plant__driveShaft__torque=sign * (line - dip))
    assert value(found, "shift.torqueHole", "shift 1") == pytest.approx(120.0, rel=1e-2)
    full = upshift(plant__driveShaft__torque=sign * line)
    assert value(full, "shift.torqueHole", "shift 1") < 1.0


def test_engine_flare_is_what_exceeds_both_synchronous_speeds() -> None:
    assert value(upshift(), "shift.engineFlare", "shift 1") == 0.0
    engine = np.full_like(TIME, 290.0) + 25.0 * np.exp(-(((TIME - 4.0) / 0.1) ** 2))
    found = upshift(plant__engine__speed=engine)
    assert value(found, "shift.engineFlare", "shift 1") == pytest.approx(15.0, rel=ROUNDING)


def test_a_shift_without_slip_or_torque_still_has_its_duration() -> None:
    run = results(plant__clutch1__state=states((0.0, 3), (4.0, 1)),
                  plant__clutch2__state=states((0.0, 1), (5.0, 3)))  # fmt: skip
    keys = {r["kpi"] for r in kpi.compute(run, {})["rows"] if r["scope"] == "shift 1"}
    assert keys == {"shift.duration"}
