"""Nested systems of SSP 2.0: names, connectors passed through, values bound from outside."""

from __future__ import annotations

import io
import math
import zipfile
from pathlib import Path

import numpy as np
import pyssp_standard
import pytest
from dct_harness import results
from harness_fixture.lag_fmu import PARAMETERS, harness, variable, write_fmu
from lxml import etree

BASE = "http://ssp-standard.org/SSP1/SystemStructure"
SSD = f"""<ssd:SystemStructureDescription version="2.0" name="nested"
  xmlns:ssd="{BASE}Description" xmlns:ssc="{BASE}Common" xmlns:ssv="{BASE}ParameterValues">
<ssd:System name="nested">
  <ssd:Connectors>
    <ssd:Connector name="push" kind="input"><ssc:Real unit="rpm"/></ssd:Connector>
    <ssd:Connector name="switch" kind="input"><ssc:Boolean/></ssd:Connector>
    <ssd:Connector name="answer" kind="output"><ssc:Real/></ssd:Connector>
  </ssd:Connectors>
  <ssd:ParameterBindings><ssd:ParameterBinding><ssd:ParameterValues>
    <ssv:ParameterSet version="2.0" name="p"><ssv:Parameters>
      <ssv:Parameter name="box.lag"><ssv:Float64 value="250"/></ssv:Parameter>
      <ssv:Parameter name="box.deep.last.tau"><ssv:Real value="2"/></ssv:Parameter>
    </ssv:Parameters></ssv:ParameterSet>
  </ssd:ParameterValues></ssd:ParameterBinding></ssd:ParameterBindings>
  <ssd:Elements>
    <ssd:System name="box">
      <ssd:Connectors>
        <ssd:Connector name="in" kind="input"><ssc:Real unit="Hz"/></ssd:Connector>
        <ssd:Connector name="switch" kind="input"><ssc:Boolean/></ssd:Connector>
        <ssd:Connector name="out" kind="output"><ssc:Real/></ssd:Connector>
        <ssd:Connector name="lag" kind="parameter"><ssc:Real/></ssd:Connector>
      </ssd:Connectors>
      <ssd:Elements>
        <ssd:Component name="first" source="resources/Lag.fmu"/>
        <ssd:System name="deep">
          <ssd:Connectors>
            <ssd:Connector name="x" kind="input"><ssc:Real/></ssd:Connector>
          </ssd:Connectors>
          <ssd:ParameterBindings><ssd:ParameterBinding><ssd:ParameterValues>
            <ssv:ParameterSet version="2.0" name="q"><ssv:Parameters>
              <ssv:Parameter name="last.tau"><ssv:Real value="77"/></ssv:Parameter>
            </ssv:Parameters></ssv:ParameterSet>
          </ssd:ParameterValues></ssd:ParameterBinding></ssd:ParameterBindings>
          <ssd:Elements><ssd:Component name="last" source="resources/Lag.fmu"/></ssd:Elements>
          <ssd:Connections>
            <ssd:Connection startElement="last" startConnector="u" endConnector="x"/>
          </ssd:Connections>
        </ssd:System>
      </ssd:Elements>
      <ssd:Connections>
        <ssd:Connection startConnector="in" endElement="first" endConnector="u"/>
        <ssd:Connection startConnector="switch" endElement="first" endConnector="b">
          <ssc:BooleanMappingTransformation>
            <ssc:MapEntry source="true" target="false"/><ssc:MapEntry source="0" target="1"/>
          </ssc:BooleanMappingTransformation>
        </ssd:Connection>
        <ssd:Connection startElement="first" startConnector="x" endElement="deep" endConnector="x">
          <ssc:LinearTransformation factor="3"/>
        </ssd:Connection>
        <ssd:Connection startElement="first" startConnector="x" endConnector="out"/>
        <ssd:Connection startConnector="lag" endElement="first" endConnector="tau">
          <ssc:LinearTransformation factor="0.001"/>
        </ssd:Connection>
        <ssd:Connection startElement="first" startConnector="grade" endElement="first"
                        endConnector="n">
          <ssc:EnumerationMappingTransformation>
            <ssc:MapEntry source="off" target="high"/><ssc:MapEntry source="top" target="low"/>
            <ssc:MapEntry source="high" target="high"/>
          </ssc:EnumerationMappingTransformation>
        </ssd:Connection>
      </ssd:Connections>
    </ssd:System>
  </ssd:Elements>
  <ssd:Connections>
    <ssd:Connection startConnector="push" endElement="box" endConnector="in"/>
    <ssd:Connection startConnector="switch" endElement="box" endConnector="switch"/>
    <ssd:Connection startElement="box" startConnector="out" endConnector="answer"/>
  </ssd:Connections>
</ssd:System>
<ssd:Units>
  <ssc:Unit name="rpm"><ssc:BaseUnit s="-1" factor="{1 / 60}"/></ssc:Unit>
  <ssc:Unit name="Hz"><ssc:BaseUnit s="-1"/></ssc:Unit>
</ssd:Units>
<ssd:DefaultExperiment startTime="0" stopTime="1.0"/>
</ssd:SystemStructureDescription>"""
ITEMS = {"off": 0, "low": 2, "high": 4, "top": 8}
LISTED = "".join(f'<Item name="{name}" value="{value}"/>' for name, value in ITEMS.items())
TYPE = ('<TypeDefinitions><SimpleType name="Grade"><Enumeration>' + LISTED
        + "</Enumeration></SimpleType></TypeDefinitions>")  # fmt: skip
STEP = 0.01  # s


def enumeration(name: str, reference: int, causality: str, start: str = "") -> str:
    """Return the XML of a variable of type Grade."""
    return (
        f'<ScalarVariable name="{name}" valueReference="{reference}" causality="{causality}" '
        f'variability="discrete"><Enumeration declaredType="Grade"{start}/></ScalarVariable>'
    )


VARIABLES = (
    variable("u", 0, "input", "0").replace("<Real ", '<Real unit="Hz" '),
    variable("x", 1, "output"), *PARAMETERS,
    variable("b", 0, "input", "0", "Boolean"), variable("c", 1, "output", kind="Boolean"),
    enumeration("n", 0, "input", ' start="2"'), enumeration("grade", 1, "output"),
)  # fmt: skip


@pytest.fixture
def package(tmp_path: Path, lag_library: Path) -> Path:
    """Return nested.ssp; its scenario lies beside it."""
    fmu = write_fmu(tmp_path / "Lag.fmu", lag_library, VARIABLES)
    with zipfile.ZipFile(fmu) as old, zipfile.ZipFile(tmp_path / "Typed.fmu", "w") as new:
        for name in old.namelist():
            text = old.read(name)
            new.writestr(
                name, text.replace(b"<ModelVariables>", TYPE.encode() + b"<ModelVariables>")
            )
    with zipfile.ZipFile(tmp_path / "nested.ssp", "w") as archive:
        archive.writestr("SystemStructure.ssd", SSD)
        archive.write(tmp_path / "Typed.fmu", "resources/Lag.fmu")
    (tmp_path / "s.csv").write_text("time,push,switch\n0,120,1\n9,120,1\n")
    return tmp_path / "nested.ssp"


def test_the_file_is_one_of_ssp_2() -> None:
    path = Path(pyssp_standard.__file__).parent / "resources/ssp2/SystemStructureDescription.xsd"
    schema = etree.XMLSchema(etree.parse(str(path)))
    assert schema.validate(etree.parse(io.BytesIO(SSD.encode()))), schema.error_log


def test_a_nested_system_runs_as_a_flat_one(tmp_path: Path, package: Path) -> None:
    """120 rpm are 2 Hz; 250 ms are 0.25 s; the outer of two values counts; x passes three times."""
    out = tmp_path / "out"
    done = harness("run", package, "--scenario", tmp_path / "s.csv", "--step", str(STEP), "--out",
                   out, folder=tmp_path)  # fmt: skip
    assert done.returncode == 0, done.stderr
    found = results.load(out)
    first = 2 * (1 - np.exp(-found.time / 0.25))
    assert np.abs(found["box/first.x"] - first).max() < 1e-12
    last = [0.0]
    for x in first[1:]:
        last.append(3 * x + (last[-1] - 3 * x) * math.exp(-STEP / 2))
    assert np.abs(found["box/deep/last.x"] - last).max() < 1e-12
    assert set(found["box/first.c"][1:]) == {1.0}  # true became false, and c is not b
    grades = [0.0, 8.0] + [4.0, 8.0] * 49 + [4.0]  # 2 n, n by the table of items
    assert found["box/first.grade"].tolist() == grades
    parameters = found.run["parameters"]
    assert parameters["box/first"]["tau"]["value"] == 0.25
    assert parameters["box/deep/last"]["tau"]["value"] == 2.0


def test_values_are_set_by_the_name_of_the_path(tmp_path: Path, package: Path) -> None:
    done = harness("run", package, "--scenario", tmp_path / "s.csv", "--stop", "0.1", "--out",
                   tmp_path / "out", "--set", "box/deep/last.tau=3.0", folder=tmp_path)  # fmt: skip
    assert done.returncode == 0, done.stderr
    parameters = results.load(tmp_path / "out").run["parameters"]
    assert parameters["box/deep/last"]["tau"]["value"] == 3.0
