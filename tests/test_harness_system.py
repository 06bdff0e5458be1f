"""System files: what is refused, with file, line, column and remedy; limits of their own."""

from __future__ import annotations

import subprocess
import sys
import zipfile
from pathlib import Path

import pytest
from dct_harness import cli
from dct_harness.errors import ConfigError, did_you_mean
from dct_harness.system import parameters, scenario, system
from harness_fixture.lag_fmu import run, write_system

LIMIT = '[[kpis]]\nkpi = "{}"\nsignal = "clutch1.torque"\n{}\n'


@pytest.mark.parametrize(("old", "new", "said"), [
    ("step = 0.001", "step = 0", "3:1: system.step: 0 is less than or equal to the minimum of 0. "
     "It is: communication step [s]."),
    ("step = 0.001", "steps = 0.001", "3:1: system: Additional properties are not allowed "
     "('steps' was unexpected). Did you mean 'step'?"),
    ("step = 0.001", "step = 0.001\nzz = 1", "4:1: system: Additional properties are not allowed "
     "('zz' was unexpected). Known here: name, title, step, coupling, interpolate, stop, "
     "scenario."),
    ("step = 0.001\n", "", "1:1: system: 'step' is a required property. "
     "Add step = … (communication step [s])."),
    ("stop = 1.0", "stop = 'long'", "4:1: system.stop: 'long' is not of type 'number'. "
     "It is: end of the run [s]."),
    ("stop = 1.0", "stop = 1.0\ncoupling = 'gauss-siedel'",
     "5:1: system.coupling: 'gauss-siedel' is not one of ['gauss-seidel', 'jacobi']. "
     "Did you mean 'gauss-seidel'?"),
    ('fmu = "Lag.fmu"', 'fum = "Lag.fmu"', "('fum' was unexpected). Did you mean 'fmu'?"),
    ("components.plant", "components.scenario", "6:1: components: 'scenario' does not match"),
    ('name = "lag"', 'name = "../lag"', "2:1: system.name: '../lag' does not match"),
    ('name = "lag"', 'name = ".."', "2:1: system.name: '..' does not match"),
    ("[system]", "[system", "1:8: is not valid TOML: Expected ']' at the end of a table"),
])  # fmt: skip
def test_what_the_schema_forbids_names_place_key_and_remedy(
    tmp_path: Path, old: str, new: str, said: str
) -> None:
    path = write_system(tmp_path)
    path.write_text(path.read_text().replace(old, new))
    with pytest.raises(ConfigError) as caught:
        system.load(path)
    assert str(caught.value).startswith(f"{path}:")
    assert said in str(caught.value)


@pytest.mark.parametrize("text", ["x = " + "[" * 5000, "x = " + "9" * 5000, "x = '\udcff'"])
def test_what_no_parser_takes_is_a_sentence(tmp_path: Path, text: str) -> None:
    path = tmp_path / "system.toml"
    path.write_bytes(text.encode("utf-8", "surrogateescape"))
    with pytest.raises(ConfigError, match="is not valid TOML"):
        system.load(path)


def test_a_byte_order_mark_of_windows_is_passed_over(tmp_path: Path) -> None:
    path = write_system(tmp_path)
    path.write_bytes(b"\xef\xbb\xbf" + path.read_bytes())
    assert system.load(path).step == 0.001


@pytest.mark.parametrize(("member", "said"), [
    ("modelDescription.xml", "; this is an FMU, which a system file names as components.NAME.fmu"),
    ("SystemStructure.ssd", "; an .ssp must be called so"),
    ("readme.txt", ""),
])  # fmt: skip
def test_an_archive_in_place_of_a_system_file_is_told(
    tmp_path: Path, member: str, said: str
) -> None:
    path = tmp_path / "loop.toml"
    with zipfile.ZipFile(path, "w", zipfile.ZIP_DEFLATED) as archive:
        archive.writestr(member, "x" * 1000)
    with pytest.raises(ConfigError) as caught:
        system.load(path)
    assert str(caught.value).endswith(f": the system file is a text in UTF-8{said}")


def test_of_a_folder_the_file_in_it_is_named(tmp_path: Path) -> None:
    path = write_system(tmp_path)
    for name, found in (("system file", system.load), ("scenario", scenario.load),
                        ("parameter file", parameters.read)):  # fmt: skip
        with pytest.raises(ConfigError) as caught:
            found(tmp_path)
        inside = {"system file": path, "scenario": tmp_path / "s.csv"}.get(name)
        such = f", such as {inside}" if inside else ""
        assert str(caught.value) == f"{tmp_path}: is a folder: name the {name} itself{such}"


def test_parameters_turned_round_are_told_with_the_components(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    path = write_system(tmp_path)
    assert cli.main(["run", str(path), "--parameters", "x.ssv", "plant"]) == 2
    told = f"--parameters: {path} has no component 'x.ssv' (plant)."
    assert told in capsys.readouterr().err


@pytest.mark.parametrize(("option", "said"), [
    ("step = nan", "step = nan s"), ("step = inf", "step = inf s"),
    ("stop = nan", "stop = nan s"), ("stop = inf", "stop = inf s"),
    ("step = 1e-300", "step = 1e-300 s and stop = 1 s"), ("stop = 1e300", "at most 1e+08 steps"),
])  # fmt: skip
def test_times_without_sense_or_end_are_refused(
    tmp_path: Path, lag_dir: Path, option: str, said: str
) -> None:
    path = write_system(tmp_path)
    lines = (line for line in path.read_text().splitlines() if line[:6] != option[:6])
    path.write_text("\n".join(lines).replace("[system]", f"[system]\n{option}"))
    done = run(path, lag_dir)
    assert done.returncode == 2, done.stderr
    assert said in done.stderr
    assert done.stderr.count("\n") == 1


WIRE = '[[connections]]\nfrom = "{}"\nto = "{}"\n'


@pytest.mark.parametrize(("more", "said"), [
    (WIRE.format("scenario.u", "plant.v"), ":10:1: connections: no 'plant.v'. Did you mean"),
    (WIRE.format("scenario.v", "plant.u"), ":9:1: connections: no 'scenario.v'. Did you mean"),
    (2 * WIRE.format("scenario.u", "plant.u"), ":13:1: connections: 'plant.u' has two sources "
     "(the other one: {}:10:1); keep one"),
    ("parameters.tua = 2.0\n", ":8:12: component 'plant': {folder}/Lag.fmu has no 'tua'. Did you"),
    ("[components.plant.parameters]\ntau = true", ":9:1: component 'plant': 'tau' is Real, got"),
    ("parameters = [{tau = 1.0}, {tau = 'a'}]", ":8:29: component 'plant': 'tau' is Real, got 'a'"),
    ("[components.other]\nfmu = 'None.fmu'", ":9:1: {folder}/None.fmu: cannot read the FMU: No "
     "such file or directory (--fmu-dir says where FMUs are)"),
    (LIMIT.format("estimation.rmes", "max = 1"), ":9:1: kpis: no KPI 'estimation.rmes'. Did you"),
    (LIMIT.format("estimation.rmse", "max = 1\nestimate = 'plnt'"),
     ":12:1: kpis: no estimate 'plnt' (observer, mapBased, plant). Did you mean 'plant'?"),
])  # fmt: skip
def test_a_name_that_nothing_has_is_told_with_its_line(
    tmp_path: Path, lag_dir: Path, more: str, said: str
) -> None:
    path = write_system(tmp_path)
    path.write_text(path.read_text() + more)
    done = run(path, lag_dir)
    assert done.returncode == 2, done.stderr
    assert f"dct-harness: {path}{said.format(path, folder=lag_dir)}" in done.stderr


def test_a_value_of_the_command_line_has_no_line_of_the_file(tmp_path: Path, lag_dir: Path) -> None:
    path = write_system(tmp_path)
    path.write_text(path.read_text() + "parameters.tau = 2.0\n")
    done = run(path, lag_dir, "--set", "plant.tau=soon")
    said = "dct-harness: component 'plant': 'tau' is Real, got 'soon'"
    assert done.stderr == f"{said}: write the number alone, with a decimal point\n"


@pytest.mark.parametrize(("schema", "folder", "count"), [
    ("system", "closed_loop", 5), ("mapping", "supplier_plant", 2),
])  # fmt: skip
def test_published_schemas_accept_the_shipped_files(
    repo_root: Path, schema: str, folder: str, count: int
) -> None:
    """By a checker of its own, which also checks that the schema is one."""
    path = repo_root / f"tests/harness/dct_harness/schema/{schema}.schema.json"
    files = sorted((repo_root / "examples" / folder).glob("*.toml"))
    assert len(files) >= count
    tool = [sys.executable, "-m", "check_jsonschema"]
    for command in (["--check-metaschema", path], ["--schemafile", path, *files]):
        done = subprocess.run([*tool, *command], capture_output=True, text=True, check=False)
        assert done.returncode == 0, done.stdout + done.stderr


@pytest.mark.parametrize(("option", "said"), [
    ("plant.tau", "write component.variable=value"),
    ("tau=1", "write component.variable=value"),
    ("vehicle.mass=1", "(plant). Write COMPONENT.vehicle.mass, with one of these before it."),
    ("plnt.tau=1", "has no component 'plnt' (plant). Did you mean 'plant'?"),
])  # fmt: skip
def test_override_that_names_nothing_is_refused(tmp_path: Path, option: str, said: str) -> None:
    loaded = system.load(write_system(tmp_path))
    with pytest.raises(ConfigError) as caught:
        loaded.override(option)
    assert said in str(caught.value)


@pytest.mark.parametrize(("text", "value"), [
    ("1.5", 1.5), ("2", 2), ("true", True), ('"grade"', "grade"), ("grade", "grade"),
    ("a.b", "a.b"),
])  # fmt: skip
def test_override_reads_values_as_toml_or_text(tmp_path: Path, text: str, value: object) -> None:
    loaded = system.load(write_system(tmp_path))
    loaded.override(f"plant.x={text}")
    found = loaded.components["plant"].parameters["x"]
    assert (found, type(found)) == (value, type(value))


@pytest.mark.parametrize(("kpi", "bound", "said"), [
    ("estimation.rmes", "max = 1", "kpis: no KPI 'estimation.rmes'. Did you mean"),
    ("estimation.rmse", "", "8:1: kpis.0: needs exactly one of min, max."),
    ("estimation.rmse", "min = 1\nmax = 2", "8:1: kpis.0: needs exactly one of min, max."),
    ("estimation.rmse", "max = '1'", "11:1: kpis.0.max: '1' is not of type 'number'. It is: "
     "in the KPI's unit."),
])  # fmt: skip
def test_limit_that_says_nothing_is_refused(
    tmp_path: Path, kpi: str, bound: str, said: str
) -> None:
    path = write_system(tmp_path)
    path.write_text(path.read_text() + LIMIT.format(kpi, bound))
    with pytest.raises(ConfigError) as caught:
        system.load(path)
    assert said in str(caught.value)


def test_shipped_systems_are_valid_and_judged(repo_root: Path) -> None:
    for path in sorted((repo_root / "examples/closed_loop").glob("*.toml")):
        loaded = system.load(path)
        assert loaded.name == path.stem
        assert loaded.scenario.is_file()
        assert loaded.kpis


@pytest.mark.parametrize(("name", "hint"), [
    ("shaft1.gearRatio", "shaft1.gearRatio[1]"),
    ("shaft1.gearRatio[9]", "shaft1.gearRatio[2]"),  # which of them is as good as another
    ("zone.temperature", "zone[1].temperature"),
    ("shaft1.inertias", "shaft1.inertia"),
])  # fmt: skip
def test_a_name_without_its_number_is_taken_for_the_first_of_a_list(name: str, hint: str) -> None:
    known = ("shaft1.inertia", "shaft1.gearRatio[1]", "shaft1.gearRatio[2]", "zone[1].pressure",
             "zone[1].temperature")  # fmt: skip
    assert did_you_mean(name, known) == f" Did you mean '{hint}'?"
