"""The harness on a C fixture FMU: closed form, short last step, failures, exit codes."""

from __future__ import annotations

import subprocess
import sys
import tempfile
import zipfile
from pathlib import Path

import fmpy
import numpy as np
import pytest
from dct_harness import master, results

SOURCES = sorted((Path(__file__).parent / "harness_fixture").glob("*.c"))
ROUNDING = 1e-12  # a thousand exact steps, each rounded once


def _variable(name: str, reference: int, causality: str, start: str | None) -> str:
    value = "" if start is None else f' start="{start}"'
    fixed = ' variability="fixed"' if causality == "parameter" else ""
    return (f'<ScalarVariable name="{name}" valueReference="{reference}" causality="{causality}"'
            f"{fixed}><Real{value}/></ScalarVariable>")  # fmt: skip


DESCRIPTION = (
    '<?xml version="1.0"?><fmiModelDescription fmiVersion="2.0" modelName="Lag" guid="{lag}">'
    '<CoSimulation modelIdentifier="Lag" canHandleVariableCommunicationStepSize="true"/>'
    "<ModelVariables>"
    + _variable("u", 0, "input", "0") + _variable("x", 1, "output", None)
    + _variable("tau", 2, "parameter", "1") + _variable("failAt", 3, "parameter", "1e9")
    + _variable("nanAt", 4, "parameter", "1e9")
    + '</ModelVariables><ModelStructure><Outputs><Unknown index="2"/></Outputs>'
    "</ModelStructure></fmiModelDescription>"
)  # fmt: skip


@pytest.fixture(scope="session")
def lag_dir(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Directory with `Lag.fmu`, compiled against the FMI headers of the fmpy package."""
    out = tmp_path_factory.mktemp("lag")
    headers = Path(fmpy.__file__).parent / "c-code"
    library = out / "Lag.so"
    subprocess.run(
        ["gcc", "-shared", "-fPIC", f"-I{headers}", *SOURCES, "-o", library, "-lm"], check=True
    )
    with zipfile.ZipFile(out / "Lag.fmu", "w") as archive:
        archive.writestr("modelDescription.xml", DESCRIPTION)
        archive.write(library, "binaries/linux64/Lag.so")
    return out


def _run(fmus: Path, tmp: Path, *options: str, stop: str = "1.0") -> subprocess.CompletedProcess:
    (tmp / "s.csv").write_text("time,u\n0,2\n10,2\n")
    (tmp / "s.toml").write_text(
        f'[system]\nname = "lag"\nstep = 0.001\nstop = {stop}\nscenario = "s.csv"\n'
        '[components.plant]\nfmu = "Lag.fmu"\n'
    )
    command = [sys.executable, "-m", "dct_harness.cli", "run", tmp / "s.toml", "--fmu-dir", fmus]
    command += ["--out", tmp / "out", *options]
    return subprocess.run(command, capture_output=True, text=True, check=False)


@pytest.mark.parametrize(("option", "said"), [
    ("plant.failAt=0.5", "plant: fmi2DoStep at t = 0.5"), ("plant.nanAt=0.5", "plant.x is nan"),
])  # fmt: skip
def test_failure_exits_4_and_keeps_the_rows(
    lag_dir: Path, tmp_path: Path, option: str, said: str
) -> None:
    done = _run(lag_dir, tmp_path, "--set", option)
    assert done.returncode == 4, done.stderr
    assert said in done.stderr
    kept = results.load(tmp_path / "out")
    assert kept.run["status"] == "partial"
    exact = 2 * (1 - np.exp(-kept.time))
    assert len(kept.time) == 501
    assert np.max(np.abs(kept["plant.x"] - exact)) < ROUNDING
    assert not list(Path(tempfile.gettempdir()).glob("dct-harness-*"))


def test_unknown_parameter_exits_2_with_a_hint(lag_dir: Path, tmp_path: Path) -> None:
    done = _run(lag_dir, tmp_path, "--set", "plant.tua=2.0")
    assert done.returncode == 2
    assert "Did you mean 'tau'?" in done.stderr


def test_last_step_is_shortened_and_times_do_not_accumulate() -> None:
    assert master.communication_points(0.1, 0.35).tolist() == [0.0, 0.1, 0.2, 0.1 * 3, 0.35]
    assert len(master.communication_points(0.001, 30.0)) == 30001
