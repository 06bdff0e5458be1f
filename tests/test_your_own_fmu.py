"""examples/your_own_fmu: built as its README says, and compared with the solution on paper."""

from __future__ import annotations

import re
import subprocess
import zipfile
from pathlib import Path

import numpy as np
import pytest
from fmpy import read_model_description, simulate_fmu
from fmpy.validation import validate_fmu

ROOT = Path(__file__).resolve().parent.parent
README = (ROOT / "examples/your_own_fmu/README.md").read_text(encoding="utf-8")

POWER, ROOM, START = 1500.0, 280.0, 300.0  # W, K, K
CAPACITY, CONDUCTANCE = 3e4, 6.0  # J/K, W/K
PARAMETERS = {
    "body.heatCapacity": CAPACITY, "wall.conductance": CONDUCTANCE,
    "body.temperature_start": START, "heater.power": POWER, "room.temperature": ROOM,
}  # fmt: skip
ROUNDING = 1e-12  # relative: a few hundred steps of some 1e-16 each


@pytest.fixture(scope="module")
def oven(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Return `Oven.fmu`, built by the command of the README."""
    (command,) = re.findall(r"^    (cargo run .*)$", README, re.MULTILINE)
    folder = tmp_path_factory.mktemp("oven")
    done = subprocess.run([*command.split(), "--", folder], cwd=ROOT, capture_output=True,
                          text=True, check=False)  # fmt: skip
    assert done.returncode == 0, done.stderr
    assert "Oven.fmu: valid, 5 start values compared" in done.stdout
    return folder / "Oven.fmu"


def test_the_model_is_as_short_as_the_readme_says() -> None:
    (lines,) = re.findall(r"^(\d+) lines:$", README, re.MULTILINE)
    code = (ROOT / "examples/your_own_fmu/lib.rs").read_text(encoding="utf-8")
    assert len([line for line in code.splitlines() if line.strip()]) == int(lines) == 40


def test_validators_find_nothing(oven: Path) -> None:
    assert validate_fmu(str(oven)) == []


@pytest.mark.parametrize("step", [1.0, 60.0, 1800.0])
def test_the_oven_heats_as_on_paper(oven: Path, step: float) -> None:
    result = simulate_fmu(str(oven), stop_time=3600.0, output_interval=step,
                          start_values=PARAMETERS)  # fmt: skip
    end = ROOM + POWER / CONDUCTANCE
    decay = np.exp(-result["time"] * CONDUCTANCE / CAPACITY)
    temperature = end + (START - end) * decay
    assert len(result) == round(3600.0 / step) + 1
    np.testing.assert_allclose(result["body.temperature"], temperature, rtol=ROUNDING)
    loss = CONDUCTANCE * (temperature - ROOM)
    np.testing.assert_allclose(result["wall.heatFlow"], loss, rtol=ROUNDING * end / (START - ROOM))


def test_heat_is_kept_or_lost_through_the_wall(oven: Path) -> None:
    """Energy balance by a quadrature of the outputs: no formula of the model is repeated."""
    result = simulate_fmu(str(oven), stop_time=3600.0, output_interval=1.0,
                          start_values=PARAMETERS)  # fmt: skip
    lost = np.trapezoid(result["wall.heatFlow"], result["time"])
    kept = CAPACITY * (result["body.temperature"][-1] - result["body.temperature"][0])
    assert kept + lost == pytest.approx(POWER * 3600.0, rel=1e-6)  # trapezoids of 1 s of 5000 s


def test_the_description_shows_what_the_readme_explains(oven: Path) -> None:
    description = read_model_description(str(oven))
    names = {variable.name for variable in description.modelVariables}
    assert {"body.temperature", "wall.heatFlow", "heater.power"} <= names
    feeds = {u.variable.name: [d.name for d in u.dependencies] for u in description.outputs}
    assert feeds == {"body.temperature": [], "wall.heatFlow": ["room.temperature"]}
    (kelvin,) = (unit for unit in description.unitDefinitions if unit.name == "K")
    assert [(shown.name, shown.offset) for shown in kelvin.displayUnits] == [("degC", -273.15)]


def test_the_archive_has_description_page_and_library(oven: Path) -> None:
    with zipfile.ZipFile(oven) as archive:
        names = set(archive.namelist())
        page = archive.read("documentation/index.html").decode()
    assert {"modelDescription.xml", "documentation/index.html"} <= names
    assert any(name.startswith("binaries/") for name in names)
    assert "A heated body that loses heat to the room" in page
