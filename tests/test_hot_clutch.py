"""The example of a clutch that fades by its own heat: every joule and newton metre is found."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
from closed_loop_runs import run

CAPACITY, CONDUCTANCE, AMBIENT, START = 600.0, 10.0, 293.15, 350.0  # J/K, W/K, K
THETA = ((293.15, 373.15, 423.15, 523.15), (1.0, 0.98, 0.85, 0.6))  # K, factor
PHI = ((0.0, 10.0, 50.0, 100.0, 200.0), (1.05, 1.0, 0.98, 0.95, 0.9))  # rad/s, factor
TRAPEZOIDS = 1e-4  # of the heat: the rule over steps of 1 ms


@pytest.fixture(scope="module")
def signals(tmp_path_factory: pytest.TempPathFactory) -> dict[str, np.ndarray]:
    """Return the signals of the run, without the component's name."""
    found = run("hot_clutch", (), tmp_path_factory.mktemp("hot")).signals
    return {name.removeprefix("plant."): values for name, values in found.items()}


def test_friction_heats_the_clutch_and_its_surroundings(signals: dict[str, np.ndarray]) -> None:
    temperature, energy = signals["clutch1.temperature"], signals["clutch1.frictionEnergy"]
    assert temperature[0] == START
    lost = CONDUCTANCE * np.trapezoid(temperature - AMBIENT, signals["time"])
    kept = CAPACITY * (temperature[-1] - START)
    assert kept + lost == pytest.approx(energy[-1], rel=TRAPEZOIDS)
    assert np.abs(signals["energy.residual"]).max() < 1e-6


def test_friction_falls_with_heat_and_slip(signals: dict[str, np.ndarray]) -> None:
    time, torque = signals["time"], signals["clutch1.torque"]
    held = (time > 1.0) & (time < 8.0)  # position 5.2 mm: 1520 N
    slip, hot = signals["clutch1.slip"][held], signals["clutch1.temperature"][held]
    expected = 0.26 * 1520.0 * 0.095 * np.interp(hot, *THETA) * np.interp(slip, *PHI)
    assert torque[held] == pytest.approx(expected, rel=1e-9)
    assert torque[held][-1] < 0.9 * torque[held][0]
    assert signals["vehicle.speed"][-1] > 2.0


def test_the_page_tells_how_hot_it_gets_and_what_is_left(
    signals: dict[str, np.ndarray], repo_root: Path
) -> None:
    page = (repo_root / "docs/pages/howto/presets.md").read_text(encoding="utf-8")
    held = signals["clutch1.torque"][(signals["time"] > 1.0) & (signals["time"] < 8.0)]
    temperature = signals["clutch1.temperature"]
    assert f"({temperature[0]:.0f} to {temperature[-1]:.0f} K)" in page
    assert f"a torque that falls by {100.0 * (1.0 - held[-1] / held[0]):.0f} %" in page


def test_what_the_example_says_is_what_it_has(repo_root: Path) -> None:
    text = (repo_root / "examples/closed_loop/hot_clutch.toml").read_text()
    for name, table in (("thermal.temperature", THETA[0]), ("thermal.factor", THETA[1])):
        for k, value in enumerate(table, start=1):
            assert f'"clutch1.{name}[{k}]" = {value}' in text
