"""Systems in SSP files: connections, transformations, units, parameter sets, what is refused."""

from __future__ import annotations

import zipfile
from collections.abc import Callable
from pathlib import Path
from subprocess import CompletedProcess

import numpy as np
import pytest
from dct_harness import results
from harness_fixture.lag_fmu import LAG, harness, variable, write_fmu

SSD = """<?xml version="1.0"?>
<ssd:SystemStructureDescription version="1.0" name="two"
  xmlns:ssd="http://ssp-standard.org/SSP1/SystemStructureDescription"
  xmlns:ssc="http://ssp-standard.org/SSP1/SystemStructureCommon"
  xmlns:ssv="http://ssp-standard.org/SSP1/SystemStructureParameterValues"
  xmlns:ssm="http://ssp-standard.org/SSP1/SystemStructureParameterMapping">
<ssd:System name="two">
  <ssd:Connectors><ssd:Connector name="push" kind="input"/></ssd:Connectors>
  <ssd:Elements>
    <ssd:Component name="first" source="resources/Lag.fmu">
      <ssd:ParameterBindings><ssd:ParameterBinding><ssd:ParameterValues>
        <ssv:ParameterSet version="1.0" name="p"><ssv:Parameters>
          <ssv:Parameter name="tau"><ssv:Real value="0.5"/></ssv:Parameter>
        </ssv:Parameters></ssv:ParameterSet>
      </ssd:ParameterValues></ssd:ParameterBinding></ssd:ParameterBindings>
    </ssd:Component>
    <ssd:Component name="second" source="resources/Lag.fmu"/>
  </ssd:Elements>
  <ssd:Connections>
    <ssd:Connection startConnector="push" endElement="first" endConnector="u"/>
    <ssd:Connection startElement="first" startConnector="x" endElement="second" endConnector="u">
      <ssc:LinearTransformation factor="-2" offset="1"/>
    </ssd:Connection>
    <ssd:Connection startElement="second" startConnector="m" endElement="second" endConnector="n">
      <ssc:IntegerMappingTransformation>
        <ssc:MapEntry source="0" target="4"/><ssc:MapEntry source="8" target="4"/>
      </ssc:IntegerMappingTransformation>
    </ssd:Connection>
    <ssd:Connection startElement="second" startConnector="x" endConnector="out"/>
  </ssd:Connections>
  <ssd:ParameterBindings><ssd:ParameterBinding source="resources/all.ssv">
    <ssd:ParameterMapping source="resources/all.ssm"/>
  </ssd:ParameterBinding></ssd:ParameterBindings>
</ssd:System>
<ssd:DefaultExperiment startTime="0" stopTime="1.0"/>
</ssd:SystemStructureDescription>"""
SSV = """<ssv:ParameterSet version="1.0" name="all"
  xmlns:ssv="http://ssp-standard.org/SSP1/SystemStructureParameterValues"><ssv:Parameters>
  <ssv:Parameter name="lag in ms"><ssv:Real value="250"/></ssv:Parameter>
</ssv:Parameters></ssv:ParameterSet>"""
SSM = """<ssm:ParameterMapping version="1.0"
  xmlns:ssm="http://ssp-standard.org/SSP1/SystemStructureParameterMapping"
  xmlns:ssc="http://ssp-standard.org/SSP1/SystemStructureCommon">
  <ssm:MappingEntry source="lag in ms" target="second.tau">
    <ssc:LinearTransformation factor="0.001"/>
  </ssm:MappingEntry>
</ssm:ParameterMapping>"""
CODED = (
    *LAG,
    variable("n", 0, "input", "0", "Integer"),
    variable("m", 1, "output", kind="Integer"),
)


@pytest.fixture
def package(tmp_path: Path, lag_library: Path) -> Callable[..., Path]:
    """Return a function that writes a.ssp with texts replaced, and the scenario."""
    fmu = write_fmu(tmp_path / "Lag.fmu", lag_library, CODED)
    (tmp_path / "s.csv").write_text("time,push\n0,2\n9,2\n")

    def write(old: str = "", new: str = "") -> Path:
        assert old in SSD + SSV + SSM
        with zipfile.ZipFile(tmp_path / "a.ssp", "w") as archive:
            for name, text in (("SystemStructure.ssd", SSD), ("resources/all.ssv", SSV),
                               ("resources/all.ssm", SSM)):  # fmt: skip
                archive.writestr(name, text.replace(old, new) if old else text)
            archive.write(fmu, "resources/Lag.fmu")
        return tmp_path / "a.ssp"

    return write


def _run(path: Path, *options: str | Path) -> CompletedProcess[str]:
    folder = path.parent
    command = ("run", path, "--scenario", folder / "s.csv", "--out", folder / "out", *options)
    return harness(*command, folder=folder)


def test_connections_transformations_and_parameter_sets(package: Callable[..., Path]) -> None:
    done = _run(package(), "--step", "0.01")
    assert done.returncode == 0, done.stderr
    found = results.load(package().parent / "out")
    time = found.time
    assert (len(time), time[-1]) == (101, 1.0)
    first = 2 * (1 - np.exp(-time / 0.5))
    assert np.max(np.abs(found["first.x"] - first)) < 1e-12
    second = [0.0]
    for x in first[1:]:
        feed = 1 - 2 * x
        second.append(feed + (second[-1] - feed) * np.exp(-0.01 / 0.25))
    assert np.max(np.abs(found["second.x"] - second)) < 1e-12
    assert set(found["second.m"][1:]) == {8}  # 4 from the table, doubled
    assert found.run["parameters"]["second"]["tau"]["value"] == 0.25


@pytest.mark.parametrize(("old", "new", "said"), [
    ('source="resources/Lag.fmu"', 'source="resources/Log.fmu"', "has no file 'resources/Log.fmu'"),
    ('source="resources/Lag.fmu"', 'source="../../Lag.fmu"', "has no file '../../Lag.fmu' inside"),
    ('source="resources/all.ssv"', 'source="resources/none.ssv"', "has no 'resources/none.ssv'"),
    ('<ssd:Component name="second"', '<ssd:SignalDictionaryReference name="second"',
     "SignalDictionaryReference 'second' is not supported"),
    ('name="second" source', 'name="zweite" source', "no 'second.u'"),
    ('startElement="first" startConnector="x"', 'startElement="first" startConnector="y"',
     "no 'first.y'"),
    ('target="second.tau"', 'target="second.tua"', "no 'second.tua'. Did you mean 'tau'?"),
    ('target="second.tau"', 'target="third.tau"', "parameter 'third.tau': no such component"),
    ('source="lag in ms"', 'source="lag"', "mapping: no parameter 'lag'"),
    ('endElement="second" endConnector="u"', 'endElement="first" endConnector="u"',
     "'first.u' has two sources"),
    (' stopTime="1.0"', ' stopTime="soon"', "'stopTime': 'soon' is no number"),
    ('version="1.0" name="two"', 'version="3.0" name="two"', "is of SSP version '3.0'; known are"),
    ('name="second" source', 'name="a.b" source', "an element is called 'a.b'"),
    ('name="second" source', 'name="first" source', "two elements are called 'first'"),
    ('name="second" source', 'name="second" type="application/x-ssp-package" source',
     "'second' is of type application/x-ssp-package; only FMUs can run"),
    ('value="250"', 'value="long"', "'second.tau': 'long' is no number and no known item"),
    ('target="4"/>', 'target="four"/>', "'second.n': 'four' is no number and no known item"),
    (' stopTime="1.0"', "", "says no stopTime; give --stop SECONDS"),
    ('factor="-2"', 'factor="two"', "'factor': 'two' is no number"),
    ("<ssd:DefaultExperiment", '<ssd:Units><ssc:Unit name="rpm"><ssc:BaseUnit rad="one"/>'
     "</ssc:Unit></ssd:Units><ssd:DefaultExperiment", "'rad': 'one' is no whole number"),
    ("</ssd:SystemStructureDescription>", '<ssd:Annotations><ssc:Annotation type="dct-harness">'
     '<Run step="soon"/></ssc:Annotation></ssd:Annotations></ssd:SystemStructureDescription>',
     "'step': 'soon' is no number"),
    ('<?xml version="1.0"?>', '<!DOCTYPE a [<!ENTITY b "c">]>', "declares a document type"),
])  # fmt: skip
def test_what_cannot_run_is_refused(
    package: Callable[..., Path], old: str, new: str, said: str
) -> None:
    done = _run(package(old, new))
    assert done.returncode in (2, 3), done.stderr
    assert said in done.stderr
    assert "Traceback" not in done.stderr


def test_a_system_with_inputs_needs_a_scenario(package: Callable[..., Path]) -> None:
    path = package()
    done = harness("run", path, folder=path.parent)
    assert done.returncode == 2
    assert "has inputs of its own; give --scenario FILE.csv" in done.stderr


def test_an_input_without_a_column_keeps_its_start_value_and_is_told(
    package: Callable[..., Path],
) -> None:
    done = _run(package('startConnector="push"', 'startConnector="pull"'))
    assert done.returncode == 0, done.stderr
    assert "the scenario has no column for first.u: start values" in done.stderr
    assert not results.load(package().parent / "out")["first.x"].any()  # u starts at 0


def test_a_code_without_a_row_ends_the_run(package: Callable[..., Path]) -> None:
    done = _run(package('source="8" target="4"', 'source="7" target="4"'))
    assert done.returncode == 4
    assert "second.n: 8 is in no row of its mapping" in done.stderr


def test_a_file_that_is_no_ssp_is_refused(tmp_path: Path) -> None:
    (tmp_path / "a.ssp").write_text("text")
    done = harness("run", tmp_path / "a.ssp", folder=tmp_path)
    assert done.returncode == 3
    assert "a.ssp: is not an SSP file (not a ZIP archive)" in done.stderr
