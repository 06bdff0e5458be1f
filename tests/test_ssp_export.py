"""`dct-harness export-ssp`: nothing is lost, the schemas are met, other tools read it."""

from __future__ import annotations

import io
import json
import subprocess
import sys
import zipfile
from pathlib import Path

import fmpy
import numpy as np
import pyssp_standard
import pytest
from closed_loop_runs import FMUS, ROOT, SYSTEMS
from dct_harness import results
from dct_harness.ssp import ssp
from fmpy.ssp.simulation import simulate_ssp
from fmpy.ssp.ssd import read_ssd
from harness_fixture.lag_fmu import LAG, harness, variable, write_fmu
from lxml import etree
from pyssp_standard.ssp import SSP

STOP = "2"  # s
ROUNDING = 1e-11  # relative to a signal's largest value; measured 5e-13
SCHEMAS = {
    "SSP 1.0": Path(fmpy.__file__).parent / "ssp/schema",
    "SSP 2.0": Path(pyssp_standard.__file__).parent / "resources/ssp2",
}
CASES = ("torque_tracking_case1", "friction_fade_case2", "launch_wet6", "paper_case1")
SUPPLIER = ROOT / "examples/supplier_plant"


def export(folder: Path, system: Path, *options: str | Path) -> Path:
    """Export a system; returns the file."""
    out = folder / f"{system.stem}.ssp"
    done = harness("export-ssp", system, "--fmu-dir", FMUS, "--out", out, *options, folder=folder)
    assert done.returncode == 0, done.stderr
    assert done.stdout.endswith(f"runs with `dct-harness run {out}`\n")
    return out


def both(folder: Path, system: Path, file: Path, *options: str | Path) -> list[results.Results]:
    """Return the results of a system file and of its export."""
    found = []
    more = (("a", system, ("--fmu-dir", FMUS, *options)), ("b", file, ()))
    for name, source, given in more:
        out = folder / name
        done = harness("run", source, "--stop", STOP, "-q", "--out", out, *given, folder=folder)
        assert done.returncode in (0, 1), done.stderr
        found.append(results.load(out))
    return found


@pytest.fixture(scope="module")
def files(tmp_path_factory: pytest.TempPathFactory) -> dict[str, Path]:
    """The shipped systems, exported."""
    folder = tmp_path_factory.mktemp("export")
    return {case: export(folder, SYSTEMS / f"{case}.toml") for case in CASES}


@pytest.mark.parametrize("case", CASES)
def test_the_file_gives_the_same_bits_and_the_same_verdict(
    tmp_path: Path, files: dict[str, Path], case: str
) -> None:
    """With parameter files, a column that changes a parameter, integers and booleans."""
    first, second = both(tmp_path, SYSTEMS / f"{case}.toml", files[case])
    assert (tmp_path / "a/results.csv").read_bytes() == (tmp_path / "b/results.csv").read_bytes()
    for key in ("step", "parameters", "signals", "coupling"):
        assert first.run[key] == second.run[key], key
    assert first.run["system"]["kpis"] == second.run["system"]["kpis"]
    judged = [json.loads((tmp_path / n / "kpis.json").read_text())["limits"] for n in "ab"]
    assert judged[0] == judged[1]
    assert len(judged[0]) >= {"paper_case1": 6, "launch_wet6": 1}.get(case, 0)
    package = ssp.Package(files[case])
    try:
        assert package.system(None, None, None).stop == (6.0 if "wet6" in case else 30.0)
    finally:
        package.folder.cleanup()


@pytest.mark.parametrize("standard", SCHEMAS)
@pytest.mark.parametrize("case", CASES)
def test_every_file_meets_its_schema(files: dict[str, Path], standard: str, case: str) -> None:
    kinds = {"ssd": "Description", "ssv": "ParameterValues"}
    with zipfile.ZipFile(files[case]) as archive:
        checked = [n for n in archive.namelist() if n[-3:] in kinds]
        for name in checked:
            path = SCHEMAS[standard] / f"SystemStructure{kinds[name[-3:]]}.xsd"
            schema = etree.XMLSchema(etree.parse(str(path)))
            assert schema.validate(etree.parse(io.BytesIO(archive.read(name)))), schema.error_log
    assert len(checked) >= 2


def test_pyssp_standard_reads_it_and_finds_it_compliant(files: dict[str, Path]) -> None:
    with (
        SSP(files["torque_tracking_case1"], mode="r") as archive,
        archive.system_structure as found,
    ):
        found.__check_compliance__()
        assert [e.name for e in found.system.elements] == ["plant", "observer", "control"]
        assert len(found.connections()) == 35


def test_the_same_system_gives_the_same_bytes(tmp_path: Path, files: dict[str, Path]) -> None:
    again = export(tmp_path, SYSTEMS / "paper_case1.toml")
    assert again.read_bytes() == files["paper_case1"].read_bytes()


LAUNCH = {"engine.torque": 50.0, "brake.torque": 0.0, "road.grade": 0.0, "clutch1.position": 0.005,
          "clutch1.pressure": 0.0, "clutch2.position": 0.0, "clutch2.pressure": 0.0,
          "shaft1.gear": 1, "shaft2.gear": 2}  # fmt: skip
PAIR = """[system]
name = "pair"
step = 0.01
stop = 1.0
scenario = "s.csv"
[components.plant]
fmu = "DctPlant.fmu"
parameters = {{ {} }}
[components.observer]
fmu = "DctObserver.fmu"
parameters = {{ {} }}
"""


def pair(folder: Path, scenario: dict[str, float], values: dict[str, float]) -> Path:
    """Write a launch of plant and observer, its inputs from a scenario or as start values."""
    (folder / "s.csv").write_text(
        ",".join(["time", "none", *scenario]) + "\n"
        + ",".join(map(str, [0, 0, *scenario.values()])) + "\n"
    )  # fmt: skip
    inside = ", ".join(f'"{name}" = {value}' for name, value in values.items())
    (folder / "pair.toml").write_text(PAIR.format(inside, inside))
    return folder / "pair.toml"


def test_fmpy_runs_it(tmp_path: Path) -> None:
    """The plant's rows are the same bits; fmpy reads no parameter sets of components.

    An input reaches a component one step late there, and is 0 over the first step. The clutch
    closes when the gear is in.
    """
    system = pair(tmp_path, LAUNCH, {})
    times = (0.0, 0.01, 0.21, 0.22)
    rows = [[t, 0, *(value * (t > 0) * (t > 0.215 or name != "clutch1.position")
                     for name, value in LAUNCH.items())] for t in times]  # fmt: skip
    head = (tmp_path / "s.csv").read_text().splitlines()[0]
    (tmp_path / "s.csv").write_text("\n".join([head, *(",".join(map(str, r)) for r in rows), ""]))
    file = export(tmp_path, system)
    assert read_ssd(str(file), validate=True).system.name == "pair"
    ours = both(tmp_path, system, file)[1]
    signals = {name: lambda _, value=value: value for name, value in LAUNCH.items()}
    signals["clutch1.position"] = lambda t: LAUNCH["clutch1.position"] if t > 0.205 else 0.0
    theirs = simulate_ssp(str(file), stop_time=1.0, step_size=0.01, input=signals)
    for name in ("plant.vehicle.speed", "plant.clutch1.torque"):
        assert theirs[name].tolist() == ours[name][1 : len(theirs) + 1].tolist()
    assert theirs["plant.vehicle.speed"][-1] > 0.5


ECOS = """import sys
from ecospy import EcosLib, EcosSimulation
EcosLib.set_log_level("warn")
with EcosSimulation(step_size=0.01, ssp_path=sys.argv[1]) as simulation:
    simulation.init(parameter_set="pair")
    simulation.step(100)
    print(*(repr(simulation.get_real(n)) for n in sys.argv[2:]))
    simulation.terminate()
"""


def test_ecos_runs_it(tmp_path: Path) -> None:
    """Values and connections of components; ecos knows no inputs of the system."""
    system = pair(tmp_path, {}, LAUNCH)
    file = export(tmp_path, system)
    names = ("plant.vehicle.speed", "plant.clutch1.torque", "observer.clutch1.torque")
    command = [sys.executable, "-c", ECOS, file, *(n.replace(".", "::", 1) for n in names)]
    done = subprocess.run(command, capture_output=True, text=True, check=False)
    assert done.returncode == 0, done.stderr
    ours = both(tmp_path, system, file)[1]
    found = [float(text) for text in done.stdout.split()[-3:]]
    wanted = [float(ours[n][100]) for n in names]
    assert found[:2] == wanted[:2]
    assert found[2] == pytest.approx(wanted[2], rel=0.05)  # its order of coupling is another one
    assert wanted[0] > 0.5


@pytest.mark.parametrize(("name", "fmu"), [("antrieb", "Antrieb.fmu"),
                                           ("powertrain", "Powertrain.fmu")])  # fmt: skip
def test_a_mapped_plant_keeps_its_own_variables(tmp_path: Path, name: str, fmu: str) -> None:
    """Factors, offsets, units, codings and derived speeds become transformations.

    A derived speed is one multiplication there and two here: the last bit may differ.
    """
    command = [sys.executable, SUPPLIER / "build.py", tmp_path]
    subprocess.run(command, check=True, capture_output=True)
    swap = ("--plant", tmp_path / fmu, "--map", SUPPLIER / f"{name}.toml")
    system = SYSTEMS / "paper_case1.toml"
    first, second = both(tmp_path, system, export(tmp_path, system, *swap), *swap)
    observed = [n for n in first.signals if n.startswith(("observer.", "scenario."))]
    assert len(observed) > 20
    for signal in observed:
        size = np.abs(first[signal]).max()
        assert np.abs(first[signal] - second[signal]).max() <= ROUNDING * size, signal


TABLES = """
[inputs]
"engine.torque" = { variable = "u", unit = "kN.m", factor = 2, offset = 1 }
"shaft1.gear" = { variable = "n", table = { 0 = 14, 1 = 5, 3 = 7 } }
[outputs]
"vehicle.speed" = { variable = "x", unit = "km/h", factor = -1, offset = 2 }
"wheel.speed" = { derive = "vehicle.speed", radius = 0.25 }
[extra]
"m" = { variable = "m", table = { 0 = 0, 1 = [10, 28], 2 = 14 } }
[parameters]
"engine.inertia" = { variable = "tau", unit = "kg.m2" }
"""
TAKER = (
    variable("wheel.speed", 0, "input", "0"), *LAG[1:],
    variable("m", 0, "input", "1", "Integer"), variable("k", 1, "output", kind="Integer"),
)  # fmt: skip


def test_codings_factors_and_parameters_of_a_mapping(tmp_path: Path, lag_library: Path) -> None:
    coded = (*LAG, variable("n", 0, "input", "0", "Integer"),
             variable("m", 1, "output", kind="Integer"))  # fmt: skip
    write_fmu(tmp_path / "Lag.fmu", lag_library, coded)
    write_fmu(tmp_path / "Taker.fmu", lag_library, TAKER)
    (tmp_path / "m.toml").write_text(TABLES)
    (tmp_path / "s.csv").write_text("time,engine.torque,shaft1.gear\n0,200,1\n0.5,900,3\n9,0,3\n")
    (tmp_path / "s.toml").write_text(
        '[system]\nname = "lag"\nstep = 0.01\nstop = 1.0\nscenario = "s.csv"\n'
        '[components.plant]\nfmu = "Lag.fmu"\nparameters = { "engine.inertia" = 0.5 }\n'
        '[components.taker]\nfmu = "Taker.fmu"\nsubsteps = 2\n'
    )
    options = ("--map", tmp_path / "m.toml", "--fmu-dir", tmp_path)
    file = export(tmp_path, tmp_path / "s.toml", *options)
    first, second = both(tmp_path, tmp_path / "s.toml", file, *options)
    for signal in ("taker.x", "taker.k"):
        assert first[signal].tolist() == second[signal].tolist(), signal
    assert len(set(first["taker.k"])) == 3
    assert abs(first["taker.x"]).max() > 1
    assert second.run["system"]["components"]["taker"]["substeps"] == 2


def test_what_ssp_cannot_say_is_refused(tmp_path: Path, lag_library: Path) -> None:
    write_fmu(tmp_path / "Lag.fmu", lag_library)
    write_fmu(tmp_path / "Taker.fmu", lag_library, (variable("damper.speed", 0, "input", "0"),))
    (tmp_path / "m.toml").write_text(
        '[inputs]\n"engine.torque" = { variable = "u", unit = "N.m" }\n[outputs]\n'
        '"engine.speed" = { variable = "x", unit = "rpm" }\n'
        '"damper.speed" = { difference = ["engine.speed", "engine.speed"] }\n'
    )
    (tmp_path / "s.csv").write_text("time,engine.torque\n0,200\n")
    (tmp_path / "s.toml").write_text(
        '[system]\nname = "lag"\nstep = 0.01\nstop = 1.0\nscenario = "s.csv"\n'
        '[components.plant]\nfmu = "Lag.fmu"\n[components.taker]\nfmu = "Taker.fmu"\n'
    )
    done = harness("export-ssp", tmp_path / "s.toml", "--fmu-dir", tmp_path, "--map",
                   tmp_path / "m.toml", folder=tmp_path)  # fmt: skip
    assert done.returncode == 2, done.stderr
    assert "outputs.damper.speed: a difference of two outputs has no counterpart" in done.stderr
    assert not list(tmp_path.rglob("*.ssp"))
