"""The FMU manipulation toolbox checks each FMU, packs all three into one, and that one runs."""

from __future__ import annotations

import subprocess
import sys
import zipfile
from pathlib import Path

import fmpy
import numpy as np
import pytest
from fmu_manipulation_toolbox.assembly import AssemblyNode
from importer_cases import (
    CONNECTIONS,
    FMUS,
    HALF,
    LOOP_STARTS,
    LOOP_STEPS,
    MODELS,
    STARTS,
    STEP,
    expected,
    fmu,
    of_states_only,
)

Starts = dict[str, dict[str, float | int | bool]]


def _check(path: Path) -> subprocess.CompletedProcess:
    tool = Path(sys.executable).with_name("fmutool")
    command = [tool, "-input", path, "-check"]
    return subprocess.run(command, capture_output=True, text=True, check=False)


@pytest.mark.parametrize("model", MODELS)
def test_it_finds_no_fault(model: str) -> None:
    done = _check(fmu(model))
    assert done.returncode == 0, done.stdout + done.stderr


def test_it_would_find_a_fault(tmp_path: Path) -> None:
    broken = tmp_path / "broken.fmu"
    with zipfile.ZipFile(fmu("DctPlant")) as archive, zipfile.ZipFile(broken, "w") as copy:
        for name in archive.namelist():
            data = archive.read(name)
            if name == "modelDescription.xml":
                data = data.replace(b'causality="output"', b'causality="input"', 1)
            copy.writestr(name, data)
    assert _check(broken).returncode != 0


def _container(
    path: Path, starts: Starts, outputs: dict[str, list[str]], step: float, loop: bool
) -> Path:
    """Pack the three FMUs into one whose outputs are called `<model>.<variable>`."""
    node = AssemblyNode("dct.fmu", step_size=step, auto_link=False, auto_input=False,
                        auto_output=False)  # fmt: skip
    for model in MODELS:
        node.add_fmu(f"{model}.fmu")
        for name, value in starts[model].items():
            node.add_start_value(f"{model}.fmu", name, str(value).lower())
        for name in outputs[model]:
            node.add_output(f"{model}.fmu", name, f"{model}.{name}")
    for source, target, name in CONNECTIONS if loop else ():
        node.add_link(f"{source}.fmu", name, f"{target}.fmu", name)
    node.make_fmu(FMUS, filename=str(path))
    return path


def _last_row(path: Path, steps: int, step: float) -> np.void:
    result = fmpy.simulate_fmu(str(path), stop_time=steps * step, output_interval=step)
    assert len(result) == steps + 1
    return result[-1]


def _assert_equal(row: np.void, wanted: Starts) -> None:
    found = {m: {n: row[f"{m}.{n}"] for n in values} for m, values in wanted.items()}
    assert found == wanted


def test_packed_side_by_side_they_give_what_fmpy_gives(tmp_path: Path) -> None:
    wanted = {model: expected(model, HALF) for model in MODELS}
    outputs = {model: list(values) for model, values in wanted.items()}
    path = _container(tmp_path / "alone.fmu", STARTS, outputs, STEP, loop=False)
    _assert_equal(_last_row(path, HALF, STEP), wanted)


@pytest.mark.parametrize("step", LOOP_STEPS)
def test_packed_and_coupled_they_give_what_a_jacobi_master_gives(
    step: float, tmp_path: Path
) -> None:
    wanted = {model: of_states_only(model, step) for model in MODELS}
    outputs = {model: list(values) for model, values in wanted.items()}
    path = _container(tmp_path / "loop.fmu", LOOP_STARTS, outputs, step, loop=True)
    _assert_equal(_last_row(path, round(1.0 / step), step), wanted)
