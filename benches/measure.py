"""What the gates are made of: the C programs, the libraries, and numbers measured on them."""

from __future__ import annotations

import os
import re
import shutil
import subprocess
import xml.etree.ElementTree as ElementTree
import zipfile
from dataclasses import dataclass
from functools import cached_property
from pathlib import Path

import fmpy
import numpy as np

ROOT = Path(__file__).resolve().parent.parent
WORK = ROOT / "target" / "bench"
SCENARIO = ROOT / "examples" / "closed_loop" / "scenarios" / "positions.csv"

# One exchange of the plant: five inputs, five outputs.
SET = ("engine.torque", "clutch1.position", "clutch2.position", "road.grade", "brake.torque")
GET = ("engine.speed", "clutch1.speed", "clutch2.speed", "wheel.speed", "driveShaft.torque")
# Parameters set at the start; the last one is moved where parameters have to be new.
START = {"engine.speed_start": 90.0, "driveShaft.stiffness": 4887.0}

# Parameter of the plant that does without transfer shafts, as one of the peers does.
RIGID = "transmission.rigid"

# Steps of the driver's own peers and of the empty model: inputs 0..4, outputs 5..9.
PLAIN = "0,1,2,3,4;5,6,7,8,9;"
DRIVER = ("driver/main.c", "driver/importer.c", "driver/heap.c")


def results(quick: bool) -> Path:
    """Return the folder for results; a quick run leaves those of a whole one alone."""
    folder = WORK / "quick" if quick else WORK
    folder.mkdir(parents=True, exist_ok=True)
    return folder


def run(*words: object) -> str:
    """Run a program and return what it prints.

    Raises
    ------
    SystemExit
        With the program's own words, when it fails.
    """
    line = [str(word) for word in words]
    done = subprocess.run(line, cwd=ROOT, capture_output=True, text=True, check=False)
    if done.returncode:
        raise SystemExit(f"{' '.join(line)}\n{done.stdout}{done.stderr}")
    return done.stdout + done.stderr


def compile_c(output: str, sources: tuple[str, ...], *flags: str) -> Path:
    """Compile C sources of `benches` against the FMI headers that fmpy brings."""
    headers = Path(fmpy.__file__).parent / "c-code"
    path = WORK / output
    files = [ROOT / "benches" / source for source in sources]
    run("cc", "-std=gnu11", "-O2", "-Wall", f"-I{headers}", *flags, *files, "-ldl", "-lm",
        "-o", path)  # fmt: skip
    return path


def peer(name: str) -> str:
    """Build a peer in C and return its words for the driver."""
    sources = ("peers/shell.c", f"peers/{name}.c")
    library = compile_c(f"peer_{name}.so", sources, "-shared", "-fPIC")
    return f"{library};peer;{PLAIN}"


def empty() -> str:
    """Words for the driver: our shell around no model."""
    guid = run("cargo", "run", "--quiet", "--release", "--package", "bench-empty").strip()
    return f"{ROOT / 'target' / 'release' / 'libbench_empty.so'};{guid};{PLAIN}"


def plant() -> tuple[str, str, Path]:
    """Unpack `DctPlant.fmu`; return its words for the driver, those of a rigid one, its library."""
    with zipfile.ZipFile(ROOT / "target" / "fmu" / "DctPlant.fmu") as archive:
        description = ElementTree.fromstring(archive.read("modelDescription.xml"))
        library = Path(archive.extract("binaries/linux64/DctPlant.so", WORK))
    variables = description.findall("ModelVariables/ScalarVariable")
    reference = {v.get("name"): v.get("valueReference") for v in variables}
    ports = [",".join(reference[name] for name in names) for names in (SET, GET)]
    start = ",".join(f"{reference[name]}={value}" for name, value in START.items())
    words = f"{library};{description.get('guid')};{ports[0]};{ports[1]};{start}"
    return words, f"{words};{reference[RIGID]}", library


def small_library() -> Path:
    """Unpack the library that `cargo fmu build --small` made.

    Raises
    ------
    SystemExit
        When it did not, with the command.
    """
    fmu = ROOT / "target" / "small" / "DctPlant.fmu"
    if not fmu.exists():
        build = f"cargo fmu build --small DctPlant --out {fmu.parent.relative_to(ROOT)}"
        raise SystemExit(f"{fmu} is missing; to build it: {build}")
    with zipfile.ZipFile(fmu) as archive:
        return Path(archive.extract("binaries/linux64/DctPlant.so", WORK / "small"))


def write_inputs(h: float, stop: float) -> Path:
    """Sample the paper's scenario at the start of every step of `h` up to `stop` [s]."""
    table = np.genfromtxt(SCENARIO, delimiter=",", names=True, deletechars="")
    time = h * np.arange(round(stop / h))
    columns = [np.interp(time, table["time"], table[name]) for name in SET]
    path = WORK / f"inputs_{h:g}.bin"
    np.ascontiguousarray(np.transpose(columns)).tofile(path)
    return path


@dataclass
class Bench:
    """The libraries under measurement, over the first `stop` seconds of the scenario."""

    stop: float
    rounds: int

    def __post_init__(self) -> None:
        WORK.mkdir(parents=True, exist_ok=True)
        self.driver = compile_c("driver", DRIVER, "-rdynamic")
        self.plant, self.rigid, self.library = plant()
        self.empty, self.empty_c = empty(), peer("empty")
        self.rk4, self.rk4_rigid = peer("rk4_compliant"), peer("rk4_rigid")

    def inputs(self, h: float) -> Path:
        """Return the inputs of a run in steps of `h` [s]."""
        return write_inputs(h, self.stop)

    def cpu_times(self, h: float, *libraries: str) -> np.ndarray:
        """Return the CPU time of one exchange [ns], shape (rounds, libraries)."""
        text = run(self.driver, "time", self.rounds, h, self.inputs(h), *libraries)
        return np.loadtxt(text.splitlines(), ndmin=2)

    def least_times(self, h: float, *libraries: str) -> np.ndarray:
        """Return the least time of every exchange [ns], shape (libraries, steps)."""
        text = run(self.driver, "steps", self.rounds, h, self.inputs(h), *libraries)
        return np.loadtxt(text.splitlines(), ndmin=2)

    def instructions(self, h: float, library: str) -> float:
        """Return the instructions of one exchange, counted by callgrind over the run."""
        if not shutil.which("valgrind"):
            raise SystemExit("valgrind is missing; to install it: sudo apt-get install valgrind")
        text = run("valgrind", "--tool=callgrind", "--toggle-collect=run_exchanges",
                   f"--callgrind-out-file={os.devnull}",
                   self.driver, "count", h, self.inputs(h), library)  # fmt: skip
        (collected,) = re.findall(r"Collected : (\d+)", text)
        return int(collected) / round(self.stop / h)

    def last_outputs(self, library: str) -> np.ndarray:
        """Return the outputs at the end of a run at 1 ms, shape (5)."""
        return np.array(
            run(self.driver, "count", 1e-3, self.inputs(1e-3), library).split(), dtype=float
        )

    @cached_property
    def heap(self) -> dict[str, int]:
        """Heap calls and bytes of the plant."""
        text = run(self.driver, "heap", 1e-3, self.inputs(1e-3), self.plant)
        return {name: int(value) for name, value in map(str.split, text.splitlines())}

    @cached_property
    def starts(self) -> np.ndarray:
        """CPU time of instantiate + initialise [ns]: known and new parameters, shape (2)."""
        text = run(self.driver, "start", self.rounds, 256, self.plant)
        return np.median(np.loadtxt(text.splitlines(), ndmin=2), axis=0)
