"""Units: factor, offset and exponents, against numbers worked out by hand."""

from __future__ import annotations

import math
from pathlib import Path

import pytest
from dct_harness import results
from dct_harness.units import KNOWN, Unit, conversion, declared, find
from fmpy import read_model_description
from fmpy.model_description import BaseUnit, ModelDescription, ScalarVariable, SimpleType
from fmpy.model_description import Unit as FmiUnit
from harness_fixture.lag_fmu import LAG, run, variable, write_fmu, write_system
from importer_cases import FMUS


@pytest.mark.parametrize(("unit", "value", "si", "in_si"), [
    ("rpm", 60.0, "rad/s", 2 * math.pi),
    ("1/min", 30.0, "rad/s", math.pi),
    ("mm", 9.0, "m", 0.009),
    ("bar", 12.0, "Pa", 1.2e6),
    ("km/h", 36.0, "m/s", 10.0),
    ("degC", 20.0, "K", 293.15),
    ("degC", -273.15, "K", 0.0),
    ("%", 5.0, "1", 0.05),
    ("kN.m", 0.25, "N.m", 250.0),
    ("deg", 180.0, "rad", math.pi),
    ("kW", 1.5, "W", 1500.0),
    ("N/mm", 2.0, "N/m", 2000.0),
])  # fmt: skip
def test_values_become_si_and_come_back(unit: str, value: float, si: str, in_si: float) -> None:
    a, b = conversion(KNOWN[unit], KNOWN[si])
    assert a * value + b == pytest.approx(in_si, rel=1e-14, abs=1e-12)
    a, b = conversion(KNOWN[si], KNOWN[unit])
    assert a * in_si + b == pytest.approx(value, rel=1e-14, abs=1e-12)


@pytest.mark.parametrize("name", ["DctPlant", "DctObserver", "DctClutchControl"])
def test_units_of_our_own_signals_are_known(name: str) -> None:
    """By their names alone, as a file of results tells them, and what tools show."""
    described = read_model_description(str(FMUS / f"{name}.fmu"))
    ours = {unit.name: unit for unit in described.unitDefinitions}
    signals = [v for v in described.modelVariables if v.causality in {"input", "output"} and v.unit]
    assert signals
    for signal in signals:
        named, (stated, base) = find(signal.unit), declared(described, signal)
        assert named is not None, stated
        assert conversion(named, base) == (1.0, 0.0)
        for shown in ours[signal.unit].displayUnits:
            assert find(shown.name) is not None, shown.name


@pytest.mark.parametrize(("source", "target", "said"), [
    ("mm", "Pa", "'mm' (m) cannot become 'Pa' (kg m-1 s-2)"),
    ("rpm", "m/s", "'rpm' (s-1 rad) cannot become 'm/s' (m s-1)"),
    ("%", "rad", "'%' (1) cannot become 'rad' (rad)"),
])  # fmt: skip
def test_quantities_do_not_mix(source: str, target: str, said: str) -> None:
    with pytest.raises(ValueError, match="cannot become") as caught:
        conversion(KNOWN[source], KNOWN[target])
    assert str(caught.value) == said


def _described(name: str, base: BaseUnit | None, **more: object) -> tuple[str, Unit | None]:
    description = ModelDescription(unitDefinitions=[FmiUnit(name=name, baseUnit=base)])
    return declared(description, ScalarVariable(name="v", valueReference=0, **more))


def test_the_fmus_own_base_unit_counts_before_the_name() -> None:
    base = BaseUnit(K=1, factor="0.5555555555555556", offset="255.3722222222222")
    name, unit = _described("degF", base, unit="degF")
    assert name == "degF"
    assert unit.factor * 212 + unit.offset == pytest.approx(373.15)
    assert _described("mm", BaseUnit(m=1, factor=2e-3), unit="mm")[1].factor == 2e-3


def test_a_name_without_base_unit_is_looked_up() -> None:
    assert _described("rpm", None, unit="rpm")[1] == KNOWN["rpm"]
    assert _described("furlong", None, unit="furlong") == ("furlong", None)
    assert _described("rpm", None) == ("", None)


def test_a_unit_of_the_type_counts_and_a_difference_has_no_offset() -> None:
    kind = SimpleType(name="T", unit="degC", relativeQuantity=True)
    _, unit = _described("degC", BaseUnit(K=1, offset=273.15), declaredType=kind)
    assert (unit.factor, unit.offset) == (1.0, 0.0)


GIVER = variable("x", 1, "output").replace("<Real/>", '<Real unit="{}"/>')
TAKER = variable("v", 0, "input", "0").replace("<Real ", '<Real unit="{}" ')
LINK = '[components.taker]\nfmu = "Taker.fmu"\n[[connections]]\nfrom = "plant.x"\nto = "taker.v"\n'


def _connected(folder: Path, library: Path, units: tuple[str, str], more: str = "") -> Path:
    """Write a system whose plant gives its output in one unit to a component that takes another."""
    giver = [GIVER.format(units[0]) if 'name="x"' in text else text for text in LAG]
    write_fmu(folder / "Lag.fmu", library, tuple(giver))
    taker = (
        TAKER.format(units[1]),
        variable("y", 1, "output"),
        variable("tau", 2, "parameter", "1"),
    )
    write_fmu(folder / "Taker.fmu", library, taker)
    path = write_system(folder, "0.01")
    path.write_text(path.read_text() + LINK + more)
    return path


@pytest.mark.parametrize(("units", "more", "factor", "offset"), [
    (("rpm", "rad/s"), "", math.pi / 30, 0.0),
    (("degC", "K"), "", 1.0, 273.15),
    (("rad/s", "rad/s"), "", 1.0, 0.0),
    (("furlong", "m"), "", 1.0, 0.0),  # not known: as it is
    (("mm", "Pa"), "factor = 4.0\noffset = 1\n", 4.0, 1.0),
    (("mm", "m"), "factor = 1.0\n", 1.0, 0.0),  # the entry counts, not the units
])  # fmt: skip
def test_a_connection_converts_declared_units(
    tmp_path: Path, lag_library: Path, units: tuple[str, str], more: str, factor: float,
    offset: float,
) -> None:  # fmt: skip
    done = run(_connected(tmp_path, lag_library, units, more), tmp_path)
    assert done.returncode == 0, done.stderr
    found = results.load(tmp_path / "out")
    y = [0.0]
    for x in found["plant.x"][1:]:
        feed = factor * x + offset
        y.append(feed + (y[-1] - feed) * math.exp(-0.001))
    assert found["taker.y"] == pytest.approx(y, abs=1e-12)
    told = next(w for w in found.run["wiring"] if w["to"] == "taker.v")
    if (factor, offset) != (1.0, 0.0):
        assert (told["factor"], told["offset"]) == pytest.approx((factor, offset))


def test_a_connection_between_quantities_is_refused(tmp_path: Path, lag_library: Path) -> None:
    done = run(_connected(tmp_path, lag_library, ("mm", "Pa")), tmp_path)
    assert done.returncode == 2
    assert (
        ":11:1: 'plant.x' to 'taker.v': 'mm' (m) cannot become 'Pa' (kg m-1 s-2); connect "
        "another output, or say factor = … in a [[connections]] entry"
    ) in done.stderr


def test_a_factor_is_for_real_inputs(tmp_path: Path, lag_library: Path) -> None:
    write_fmu(tmp_path / "Lag.fmu", lag_library, (*LAG, variable("n", 0, "input", "0", "Integer")))
    path = write_system(tmp_path, "0.01", "time,u,n\n0,2,3\n")
    wire = '[[connections]]\nfrom = "scenario.n"\nto = "plant.n"\nfactor = 2\n'
    path.write_text(path.read_text() + wire)
    done = run(path, tmp_path)
    assert done.returncode == 2
    assert "'plant.n' is Integer; factor and offset are for real inputs" in done.stderr
