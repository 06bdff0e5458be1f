"""Parameter sets and the smoke experiment inside every FMU (FMI-LS-REF), which fmpy repeats."""

from __future__ import annotations

import csv
import io
import re
import zipfile
from pathlib import Path
from typing import Any

import fmpy
import numpy as np
import pytest
import xmlschema
from dct_harness.system import parameters
from fmpy import read_model_description, simulate_fmu
from fmu_instance import Instance
from importer_cases import MODELS, ROOT, fmu
from lxml import etree
from PIL import Image

FOLDER = "extra/org.fmi-standard.fmi-ls-ref/"
LS = "{http://fmi-standard.org/fmi-ls-manifest}fmi-ls-"
SSV = "application/x-ssp-parameter-set"
EXPERIMENTS = "application/x-ma-hs-experiments"
ROLES = re.compile("parameter|result|other|experiment/smoke-test")  # of those of the standard
VEHICLES = {"paper", "wet6", "dry7"}
SETS = {"DctPlant": VEHICLES | {"wet6_fade", "dry7_fade"}, "DctObserver": VEHICLES,
        "DctClutchControl": {"paper", "dry7"}}  # fmt: skip
COMPONENTS = {"DctPlant": "plant", "DctObserver": "observer", "DctClutchControl": "control"}
every_model = pytest.mark.parametrize("model", MODELS)


def _files(model: str) -> dict[str, bytes]:
    with zipfile.ZipFile(fmu(model)) as archive:
        names = [name for name in archive.namelist() if name.startswith(FOLDER)]
        return {name.removeprefix(FOLDER): archive.read(name) for name in names}


def _manifest(model: str) -> dict[str, Any]:
    """Return the manifest's entries by file."""
    root = etree.fromstring(_files(model)["fmi-ls-manifest.xml"])
    assert root.tag == "fmiReferences"
    assert root.get(LS + "name") == "org.fmi-standard.fmi-ls-ref"
    assert root.get(LS + "version") == "1.0.0-alpha.1"
    assert root.get(LS + "description")
    return {related.get("source"): related for related in root.iter("Related")}


def _table(text: bytes) -> dict[str, np.ndarray]:
    rows = list(csv.reader(io.StringIO(text.decode())))
    values = np.array([[float(cell) for cell in row] for row in rows[1:]])
    return dict(zip(rows[0], values.T, strict=True))


def _experiment(model: str) -> tuple[Any, dict[str, bytes]]:
    """Return the one experiment and the files it names, by the names of their elements."""
    files = _files(model)
    (experiment,) = etree.fromstring(files["smoke.exp"]).iter("Experiment")
    return experiment, {part.tag: files[part.get("source")] for part in experiment}


def _values(text: bytes, tmp_path: Path) -> dict[str, Any]:
    path = tmp_path / "set.ssv"
    path.write_bytes(text)
    return parameters.read(path)


@every_model
def test_the_manifest_lists_every_file_with_its_role(model: str) -> None:
    listed = _manifest(model)
    assert set(listed) == set(_files(model)) - {"fmi-ls-manifest.xml"}
    assert all(ROLES.fullmatch(related.get("role")) for related in listed.values())
    assert all(related.get("description") for related in listed.values())
    assert listed["smoke.exp"].get("type") == EXPERIMENTS
    with zipfile.ZipFile(fmu(model)) as archive:
        guide = archive.read("documentation/fmi-ls-ref.txt").decode()
    assert all(f"\n{name} (" in guide for name in listed)


@every_model
def test_parameter_sets_are_those_of_the_examples(model: str, tmp_path: Path) -> None:
    files, listed = _files(model), _manifest(model)
    names = {name.removesuffix(".ssv") for name, one in listed.items() if one.get("type") == SSV}
    assert names == SETS[model] | {"smoke"}
    folder = ROOT / "examples/closed_loop/parameters"
    for name in SETS[model]:
        assert listed[f"{name}.ssv"].get("role") == "parameter"
        example = folder / f"{name}_{COMPONENTS[model]}.ssv"
        assert files[f"{name}.ssv"] == example.read_bytes()
    variables = {v.name for v in read_model_description(str(fmu(model))).modelVariables}
    assert set(_values(files["smoke.ssv"], tmp_path)) <= variables


@every_model
def test_the_smoke_experiment_gives_the_reference_results_bit_for_bit(
    model: str, tmp_path: Path
) -> None:
    experiment, files = _experiment(model)
    inputs, wanted = _table(files["Stimuli"]), _table(files["References"])
    step, stop = float(experiment.get("stepSize")), float(experiment.get("stopTime"))
    every = round((wanted["time"][1] - wanted["time"][0]) / step)
    found: dict[str, list[float]] = {name: [] for name in wanted if name != "time"}
    with Instance(fmu(model)) as instance:
        _set(instance, _values(files["Parameters"], tmp_path), inputs, 0)
        instance.start()
        for index in range(round(stop / step) + 1):
            if index % every == 0:
                outputs = instance.outputs()
                for name, values in found.items():
                    values.append(float(outputs[name]))
            if index * step < stop - step / 2:
                _set(instance, {}, inputs, index)
                instance.step(index * step, step)
    assert len(wanted["time"]) == round(stop / step) // every + 1
    differ = [name for name in found if np.any(np.array(found[name]) != wanted[name])]
    assert differ == []


def _set(
    instance: Instance, values: dict[str, Any], inputs: dict[str, np.ndarray], row: int
) -> None:
    for name, value in values.items():
        instance.set(name, value)
    for name, column in inputs.items():
        if name != "time":
            real = instance.variables[name].type == "Real"
            instance.set(name, column[row] if real else int(column[row]))


@every_model
def test_an_importer_that_reads_the_files_gets_the_reference_results(
    model: str, tmp_path: Path
) -> None:
    """As `fmpy simulate` would: its own reading, interpolation and stepping."""
    experiment, files = _experiment(model)
    wanted = _table(files["References"])
    path = tmp_path / "in.csv"
    path.write_bytes(files["Stimuli"])
    result = simulate_fmu(
        str(fmu(model)), input=np.genfromtxt(path, delimiter=",", names=True, deletechars=""),
        start_values=_values(files["Parameters"], tmp_path), output=list(wanted)[1:],
        stop_time=float(experiment.get("stopTime")), step_size=float(experiment.get("stepSize")),
        output_interval=float(experiment.get("stepSize")),
    )  # fmt: skip
    rows = np.searchsorted(result["time"], wanted["time"])
    found = {name: np.asarray(result[name][rows], dtype=float) for name in wanted}
    # Times and steps are multiples of 1/128 s, so nobody rounds them.
    assert [name for name in wanted if np.any(found[name] != wanted[name])] == []


@every_model
def test_something_happens_in_the_experiment(model: str) -> None:
    wanted = _table(_experiment(model)[1]["References"])
    moving = {"DctPlant": "vehicle.speed", "DctObserver": "clutch1.torque",
              "DctClutchControl": "clutch1.position"}  # fmt: skip
    values = wanted[moving[model]]
    assert values[0] == 0
    assert values.max() > {"DctPlant": 1.0, "DctObserver": 20.0, "DctClutchControl": 2e-3}[model]


@every_model
def test_the_picture_is_small_and_drawn(model: str) -> None:
    with zipfile.ZipFile(fmu(model)) as archive:
        data = archive.read("model.png")
    with Image.open(io.BytesIO(data)) as picture:
        assert (picture.format, picture.size, picture.mode) == ("PNG", (96, 96), "RGBA")
        assert len(picture.getcolors(96 * 96) or []) > 8
    assert len(data) < 8192


@every_model
def test_terminals_are_valid_by_the_schema_of_fmi_3(model: str) -> None:
    schema = Path(fmpy.__file__).parent / "schema/fmi3/fmi3TerminalsAndIcons.xsd"
    with zipfile.ZipFile(fmu(model)) as archive:
        text = archive.read("terminalsAndIcons/terminalsAndIcons.xml").decode()
    xmlschema.XMLSchema(schema).validate(text)
