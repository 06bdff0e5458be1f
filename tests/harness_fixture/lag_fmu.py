"""Builds the C fixture as an FMU, with a model description of chosen variables, and runs it."""

from __future__ import annotations

import os
import re
import subprocess
import sys
import zipfile
from pathlib import Path

import fmpy

HERE = Path(__file__).parent
BINARY = "binaries/linux64/Lag.so"
HARNESS = [sys.executable, "-m", "dct_harness.cli"]
SLOW = "LAG_IS_SLOW"  # of the environment: the file that is there once a step takes its time
LIMIT = "1000"  # s, of `run_out_of_time`
OUT_OF_TIME = f"""
import os, sys, threading
from dct_harness.cli import main
from dct_harness.master import watch

class Event(threading.Event):
    def wait(self, timeout=None):
        if timeout != {LIMIT}:
            return super().wait(timeout)
        while not (os.path.exists(os.environ["{SLOW}"]) or super().wait(0.01)):
            pass
        return self.is_set()

watch.threading.Event = Event
sys.exit(main())
"""


def variable(
    name: str, reference: int, causality: str, start: str | None = None, kind: str = "Real"
) -> str:
    """Return the XML of one variable; parameters are fixed, integers and booleans discrete."""
    value = "" if start is None else f' start="{start}"'
    slow = "" if kind == "Real" else ' variability="discrete"'
    how = ' variability="fixed"' if causality == "parameter" else slow
    return (f'<ScalarVariable name="{name}" valueReference="{reference}" causality="{causality}"'
            f"{how}><{kind}{value}/></ScalarVariable>")  # fmt: skip


PARAMETERS = tuple(
    variable(name, k, "parameter", start)
    for k, (name, start) in enumerate((("tau", "1"), ("failAt", "1e9"), ("nanAt", "1e9"),
                                       ("delay", "0")), 2)
)  # fmt: skip
LAG = (variable("u", 0, "input", "0"), variable("x", 1, "output"), *PARAMETERS)


VARIES = 'canHandleVariableCommunicationStepSize="true"'


def description(variables: tuple[str, ...], can: str = VARIES) -> str:
    """Return a modelDescription.xml of the lag that shows these variables and capabilities."""
    outputs = [k for k, text in enumerate(variables, 1) if 'causality="output"' in text]
    unknowns = "".join(f'<Unknown index="{k}"/>' for k in outputs)
    units = sorted(set(re.findall(r' unit="([^"]+)"', "".join(variables))))
    defined = "".join(f'<Unit name="{unit}"/>' for unit in units)
    unit_definitions = f"<UnitDefinitions>{defined}</UnitDefinitions>" if units else ""
    structure = f"<Outputs>{unknowns}</Outputs>" if outputs else ""
    return (
        '<?xml version="1.0"?><fmiModelDescription fmiVersion="2.0" modelName="Lag" guid="{lag}">'
        f'<CoSimulation modelIdentifier="Lag" {can}/>'
        f"{unit_definitions}<ModelVariables>{''.join(variables)}</ModelVariables>"
        f"<ModelStructure>{structure}</ModelStructure></fmiModelDescription>"
    )


def compile_library(out: Path, *needs: Path) -> Path:
    """Compile the fixture against the FMI headers of fmpy and the shared libraries `needs`."""
    return _compiled(out, *sorted(HERE.glob("*.c")), *needs)


def write_hostile(folder: Path) -> Path:
    """Write the fixture that misbehaves as its parameter `mode` says; returns the folder."""
    library = _compiled(folder, HERE / "hostile/hostile.c", HERE / "unsupported.c")
    mode = variable("mode", 0, "parameter", "0", "Integer")
    write_fmu(folder / "Lag.fmu", library, (*LAG, mode))
    return folder


def _compiled(out: Path, *inputs: Path) -> Path:
    headers = Path(fmpy.__file__).parent / "c-code"
    library = out / "Lag.so"
    command = ["gcc", "-shared", "-fPIC", f"-I{headers}", *inputs, "-o", library, "-lm"]
    subprocess.run(command, check=True)
    return library


def write_fmu(
    path: Path, library: Path, variables: tuple[str, ...] = LAG, member: str = BINARY,
    can: str = VARIES,
) -> Path:  # fmt: skip
    """Write an FMU with the library as archive member `member`."""
    with zipfile.ZipFile(path, "w") as archive:
        archive.writestr("modelDescription.xml", description(variables, can))
        archive.write(library, member)
    return path


def write_system(folder: Path, stop: str = "1.0", scenario: str = "time,u\n0,2\n10,2\n") -> Path:
    """Write a system file with the lag as plant, and its scenario."""
    (folder / "s.csv").write_text(scenario, newline="")
    (folder / "s.toml").write_text(
        f'[system]\nname = "lag"\nstep = 0.001\nstop = {stop}\nscenario = "s.csv"\n'
        '[components.plant]\nfmu = "Lag.fmu"\n'
    )
    return folder / "s.toml"


def environment(folder: Path) -> dict[str, str]:
    """Return an environment in which temporary directories are made in `tmp` of a folder."""
    (folder / "tmp").mkdir(exist_ok=True)
    return {**os.environ, "TMPDIR": str(folder / "tmp")}


def run_command(system: Path, fmus: Path, *options: str | Path) -> list[str | Path]:
    """Return the command that runs a system into `out` beside it."""
    return [*HARNESS, "run", system, "--fmu-dir", fmus, "--out", system.parent / "out", *options]


def harness(*arguments: str | Path, folder: Path) -> subprocess.CompletedProcess[str]:
    """Run the command line in `folder`; nothing may be left in its `tmp`."""
    done = subprocess.run(
        [*HARNESS, *arguments], capture_output=True, text=True, check=False,
        env=environment(folder), cwd=folder,
    )  # fmt: skip
    assert list((folder / "tmp").iterdir()) == []
    return done


def run(system: Path, fmus: Path, *options: str | Path) -> subprocess.CompletedProcess[str]:
    """Run a system into `out` beside it, in a process of its own."""
    command = run_command(system, fmus, *options)[len(HARNESS) :]
    return harness(*command, folder=system.parent)


def run_out_of_time(
    system: Path, fmus: Path, *options: str | Path
) -> subprocess.CompletedProcess[str]:
    """Run a system whose time limit is over as soon as a step takes its time, not by the clock.

    How fast the machine is changes nothing: processes have started, some rows are made.
    """
    command = run_command(system, fmus, "--timeout", LIMIT, *options)[len(HARNESS) :]
    folder = system.parent
    return subprocess.run(
        [sys.executable, "-c", OUT_OF_TIME, *command], capture_output=True, text=True, check=False,
        env={**environment(folder), SLOW: str(folder / "slow")}, cwd=folder,
    )  # fmt: skip
