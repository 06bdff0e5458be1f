"""System files: what is refused, with file, key and remedy; limits of their own."""

from __future__ import annotations

from pathlib import Path

import pytest
from dct_harness import system
from dct_harness.errors import ConfigError
from harness_fixture.lag_fmu import write_system

LIMIT = '[[kpis]]\nkpi = "{}"\nsignal = "clutch1.torque"\n{}\n'


@pytest.mark.parametrize(("old", "new", "said"), [
    ("step = 0.001", "step = 0", "system.step: 0 is less than or equal to the minimum of 0."),
    ("step = 0.001", "steps = 0.001", "('steps' was unexpected). Did you mean 'step'?"),
    ("step = 0.001\n", "", "system: 'step' is a required property."),
    ("stop = 1.0", "stop = 'long'", "system.stop: 'long' is not of type 'number'."),
    ('fmu = "Lag.fmu"', 'fum = "Lag.fmu"', "('fum' was unexpected). Did you mean 'fmu'?"),
    ("components.plant", "components.scenario", "components: 'scenario' does not match"),
    ("[system]", "[system", "is not valid TOML: "),
])  # fmt: skip
def test_what_the_schema_forbids_names_key_and_remedy(
    tmp_path: Path, old: str, new: str, said: str
) -> None:
    path = write_system(tmp_path)
    path.write_text(path.read_text().replace(old, new))
    with pytest.raises(ConfigError) as caught:
        system.load(path)
    assert str(caught.value).startswith(f"{path}: ")
    assert said in str(caught.value)


@pytest.mark.parametrize(("option", "said"), [
    ("plant.tau", "write component.variable=value"),
    ("tau=1", "write component.variable=value"),
    ("plnt.tau=1", "has no component 'plnt'. Did you mean 'plant'?"),
])  # fmt: skip
def test_override_that_names_nothing_is_refused(tmp_path: Path, option: str, said: str) -> None:
    loaded = system.load(write_system(tmp_path))
    with pytest.raises(ConfigError) as caught:
        loaded.override(option)
    assert said in str(caught.value)


@pytest.mark.parametrize(("text", "value"), [
    ("1.5", 1.5), ("2", 2), ("true", True), ('"grade"', "grade"), ("grade", "grade"),
    ("a.b", "a.b"),
])  # fmt: skip
def test_override_reads_values_as_toml_or_text(tmp_path: Path, text: str, value: object) -> None:
    loaded = system.load(write_system(tmp_path))
    loaded.override(f"plant.x={text}")
    found = loaded.components["plant"].parameters["x"]
    assert (found, type(found)) == (value, type(value))


@pytest.mark.parametrize(("kpi", "bound", "said"), [
    ("estimation.rmes", "max = 1", "kpis: no KPI 'estimation.rmes'. Did you mean"),
    ("estimation.rmse", "", "kpis.0: "),
    ("estimation.rmse", "min = 1\nmax = 2", "kpis.0: "),
    ("estimation.rmse", "max = '1'", "kpis.0.max: '1' is not of type 'number'."),
])  # fmt: skip
def test_limit_that_says_nothing_is_refused(
    tmp_path: Path, kpi: str, bound: str, said: str
) -> None:
    path = write_system(tmp_path)
    path.write_text(path.read_text() + LIMIT.format(kpi, bound))
    with pytest.raises(ConfigError) as caught:
        system.load(path)
    assert said in str(caught.value)


def test_shipped_systems_are_valid_and_judged(repo_root: Path) -> None:
    for path in sorted((repo_root / "examples/closed_loop").glob("*.toml")):
        loaded = system.load(path)
        assert loaded.name == path.stem
        assert loaded.scenario.is_file()
        assert loaded.kpis
