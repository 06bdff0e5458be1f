"""What an FMU holds beside its library: licences, bill of materials, dependencies, its date."""

from __future__ import annotations

import json
import os
import re
import subprocess
import zipfile
from pathlib import Path
from typing import Any

import pytest
from cyclonedx.schema import SchemaVersion
from cyclonedx.validation.json import JsonStrictValidator
from fmpy import read_model_description
from importer_cases import MODELS, ROOT, fmu

PACKAGES = {"DctPlant": "dct-plant", "DctObserver": "dct-observer",
            "DctClutchControl": "dct-clutch-control"}  # fmt: skip
BOM = "extra/org.cyclonedx/bom.cdx.json"
EPOCH, DATE = "1700000000", "2023-11-14T22:13:20Z"

every_model = pytest.mark.parametrize("model", MODELS)


def _members(model: str) -> dict[str, bytes]:
    with zipfile.ZipFile(fmu(model)) as archive:
        return {name: archive.read(name) for name in archive.namelist()}


def _linked(model: str) -> set[str]:
    """Return what cargo says it links, as `<name>-<version>`."""
    command = ["cargo", "tree", "--locked", "-e", "normal", "--prefix", "none", "-p",
               PACKAGES[model]]  # fmt: skip
    done = subprocess.run(command, cwd=ROOT, capture_output=True, text=True, check=True)
    return {"-".join(line.split()[:2]).replace("-v", "-") for line in done.stdout.splitlines()}


@every_model
def test_every_linked_package_has_its_licence_text(model: str) -> None:
    members, linked = _members(model), _linked(model)
    assert len(linked) > 8
    texts = {name.split("/")[2] for name in members if name.count("/") == 3}
    assert texts >= linked | {"rust-std"}
    index = members["documentation/licenses/license.txt"].decode()
    assert {package for package in linked if f"\n{package}: " not in index} == set()
    assert "no licence stated" not in index


@every_model
def test_the_bill_of_materials_is_valid_and_complete(model: str) -> None:
    text = _members(model)[BOM].decode()
    assert JsonStrictValidator(SchemaVersion.V1_5).validate_str(text) is None
    bom = json.loads(text)
    listed = {f"{c['name']}-{c['version']}" for c in bom["components"]}
    assert {name for name in listed if not name.startswith("rust-std-")} == _linked(model)
    assert {c["name"] for c in bom["components"] if "licenses" not in c} == set()
    assert "timestamp" not in bom["metadata"]


@every_model
def test_its_graph_reaches_every_package(model: str) -> None:
    bom = json.loads(_members(model)[BOM])
    edges = {entry["ref"]: entry["dependsOn"] for entry in bom["dependencies"]}
    reached, ends = set(), ["fmu"]
    while ends:
        node = ends.pop()
        reached.add(node)
        ends += [n for n in edges.get(node, []) if n not in reached]
    assert reached == {"fmu", *(c["bom-ref"] for c in bom["components"])}


@every_model
def test_hashes_are_those_of_the_lock_file(model: str) -> None:
    lock = (ROOT / "Cargo.lock").read_text(encoding="utf-8")
    hashed = [c for c in json.loads(_members(model)[BOM])["components"] if "hashes" in c]
    assert len(hashed) > 4
    for component in hashed:
        entry = f'name = "{component["name"]}"\nversion = "{component["version"]}"\n'
        (rest,) = lock.split(entry)[1:]
        assert f'checksum = "{component["hashes"][0]["content"]}"' in rest.split("[[")[0]


@every_model
def test_external_dependencies_are_what_readelf_finds(model: str, tmp_path: Path) -> None:
    members = _members(model)
    library = tmp_path / f"{model}.so"
    library.write_bytes(members[f"binaries/linux64/{model}.so"])
    read = subprocess.run(["readelf", "-dV", library], capture_output=True, text=True, check=True)
    needed = re.findall(r"\(NEEDED\).*\[(.*)\]", read.stdout)
    newest = max(tuple(map(int, v.split("."))) for v in re.findall(r"GLIBC_([\d.]+)", read.stdout))
    wanted = f"{', '.join(sorted(needed))}; glibc {'.'.join(map(str, newest))} or newer"
    assert f"\nlinux64: {wanted}\n" in members["documentation/externalDependencies.txt"].decode()


@every_model
def test_the_description_states_version_licence_and_tool(model: str) -> None:
    description = read_model_description(str(fmu(model)))
    assert description.version == "0.1.0"
    assert description.license == "MIT OR Apache-2.0"
    assert re.fullmatch(r"fmu-build \d+\.\d+\.\d+", description.generationTool)


def _build(out: Path, **environment: str) -> Any:
    command = ["cargo", "fmu", "build", "DctClutchControl", "--out", str(out)]
    return subprocess.run(command, cwd=ROOT, env={**os.environ, **environment},
                          capture_output=True, text=True, check=False)  # fmt: skip


def test_source_date_epoch_is_the_date_of_the_build(tmp_path: Path) -> None:
    done = _build(tmp_path, SOURCE_DATE_EPOCH=EPOCH)
    assert done.returncode == 0, done.stderr
    dated = tmp_path / "DctClutchControl.fmu"
    assert read_model_description(str(dated)).generationDateAndTime == DATE
    with zipfile.ZipFile(dated) as archive:
        assert json.loads(archive.read(BOM))["metadata"]["timestamp"] == DATE
    assert read_model_description(str(fmu("DctClutchControl"))).generationDateAndTime is None


def test_an_epoch_that_is_no_number_is_refused(tmp_path: Path) -> None:
    done = _build(tmp_path, SOURCE_DATE_EPOCH="yesterday")
    assert done.returncode == 1
    assert "SOURCE_DATE_EPOCH = yesterday is no number of seconds" in done.stderr
