"""`cargo fmu ssp` and the terminals: what connects the FMUs in tools that know SSP or terminals."""

from __future__ import annotations

import subprocess
import zipfile
from collections.abc import Iterable
from pathlib import Path

import fmpy
import pytest
from fmpy.ssp.simulation import simulate_ssp
from fmpy.ssp.ssd import Connection, System, read_ssd
from importer_cases import CONNECTIONS, FMUS, MODELS, ROOT, fmu
from lxml import etree

NAMES = {"DctPlant": "plant", "DctObserver": "observer", "DctClutchControl": "control"}
# What the control reads beside that, for its torque feedback.
FEEDBACK = {
    *(("plant", name) for name in ("engine.speed", "clutch1.speed", "clutch2.speed")),
    *(("observer", name) for name in ("clutch1.torque", "clutch2.torque", "driveShaft.torque")),
    ("observer", "status.valid"),
}
TERMINALS = "terminalsAndIcons/terminalsAndIcons.xml"
SCHEMA = Path(fmpy.__file__).parent / "schema/fmi3/fmi3TerminalsAndIcons.xsd"


@pytest.fixture(scope="module")
def archive() -> Path:
    """Return `DctClosedLoop.ssp`, written anew."""
    done = subprocess.run(["cargo", "fmu", "ssp"], cwd=ROOT, capture_output=True, text=True,
                          check=False)  # fmt: skip
    assert done.returncode == 0, done.stderr
    assert done.stdout.split() == [str(FMUS / "DctClosedLoop.ssp")]
    return FMUS / "DctClosedLoop.ssp"


@pytest.fixture(scope="module")
def system(archive: Path) -> System:
    """Return its system; fmpy validates it against the schemas of SSP 1.0."""
    return read_ssd(str(archive), validate=True).system


def _ends(connections: Iterable[Connection]) -> set[tuple[str | None, str, str, str]]:
    return {(c.startElement, c.startConnector, c.endElement, c.endConnector) for c in connections}


def test_it_holds_the_fmus_as_they_are(archive: Path) -> None:
    with zipfile.ZipFile(archive) as ssp:
        assert sorted(ssp.namelist()) == sorted(
            ["SystemStructure.ssd", *(f"resources/{model}.fmu" for model in MODELS)]
        )
        for model in MODELS:
            assert ssp.read(f"resources/{model}.fmu") == fmu(model).read_bytes()


def test_outputs_are_connected_to_the_inputs_of_their_names(system: System) -> None:
    inner = {(s, n, t, n) for s, n, t, _ in _ends(system.connections) if s is not None}
    loop = {(NAMES[s], name, NAMES[t], name) for s, t, name in CONNECTIONS}
    assert inner == loop | {(s, name, "control", name) for s, name in FEEDBACK}


def test_every_input_has_exactly_one_source(system: System) -> None:
    ends = [(c.endElement, c.endConnector) for c in system.connections]
    inputs = {(e.name, c.name) for e in system.elements for c in e.connectors if c.kind == "input"}
    assert len(ends) == len(set(ends))
    assert set(ends) == inputs
    outside = {c.startConnector for c in system.connections if c.startElement is None}
    assert {connector.name for connector in system.connectors} == outside


def test_fmpy_runs_it(archive: Path) -> None:
    launch = {"engine.torque": 60.0, "shaft1.gear": 1, "clutch1.torqueRequest": 50.0}
    result = simulate_ssp(str(archive), stop_time=2.0, step_size=0.01,
                          input={name: lambda _, value=value: value
                                 for name, value in launch.items()})  # fmt: skip
    last = result[-1]
    assert last["time"] == pytest.approx(2.0, abs=0.011)  # fmpy keeps the last row but one
    assert last["plant.vehicle.speed"] > 0.5
    assert last["observer.clutch1.torque"] == pytest.approx(last["plant.clutch1.torque"], rel=0.5)
    assert last["plant.clutch1.torque"] > 10.0


def _terminals(model: str) -> dict[str, etree._Element]:
    with zipfile.ZipFile(fmu(model)) as archive:
        root = etree.fromstring(archive.read(TERMINALS))
    schema = etree.XMLSchema(etree.parse(str(SCHEMA)))
    assert schema.validate(root), schema.error_log
    return {terminal.get("name"): terminal for terminal in root.iter("Terminal")}


def _members(terminal: etree._Element) -> set[str]:
    return {member.get("memberName") for member in terminal}


@pytest.mark.parametrize("model", MODELS)
def test_terminals_are_valid_and_their_variables_exist(model: str) -> None:
    names = {v.name: v for v in fmpy.read_model_description(str(fmu(model))).modelVariables}
    members = [member for terminal in _terminals(model).values() for member in terminal]
    assert members
    for member in members:
        assert names[member.get("variableName")].causality in {"input", "output"}


@pytest.mark.parametrize(("name", "source", "target"), [
    ("sensors", "DctPlant", "DctObserver"),
    ("friction", "DctObserver", "DctClutchControl"),
])  # fmt: skip
def test_a_bus_of_outputs_meets_the_same_inputs(name: str, source: str, target: str) -> None:
    one, other = _terminals(source)[name], _terminals(target)[name]
    assert _members(one) == _members(other) == {n for s, t, n in CONNECTIONS
                                                if (s, t) == (source, target)}  # fmt: skip
    assert one.get("terminalKind") == other.get("terminalKind")
    assert {one.get("matchingRule"), other.get("matchingRule")} == {"bus"}


@pytest.mark.parametrize("name", ["driver", "actuators"])
def test_plant_and_observer_read_the_same_bus(name: str) -> None:
    assert _members(_terminals("DctPlant")[name]) == _members(_terminals("DctObserver")[name])
