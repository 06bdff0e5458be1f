"""Every documented exit code of `dct-harness`, each from a process of its own."""

from __future__ import annotations

import errno
import json
import zipfile
from pathlib import Path

import fmpy
import pytest
from dct_harness import cli
from harness_fixture.lag_fmu import harness, run, write_fmu, write_system


def test_complete_run_exits_0_and_prints_table_and_verdict(lag_dir: Path, tmp_path: Path) -> None:
    done = run(write_system(tmp_path), lag_dir)
    assert done.returncode == 0, done.stderr
    assert done.stdout.endswith(
        f"verdict: not judged\n\n{tmp_path / 'out'}: 1001 samples to t = 1 s\n"
    )
    assert [line[:5] for line in done.stderr.splitlines()] == [f"{k:3d} %" for k in
                                                               range(10, 101, 10)]  # fmt: skip


def test_quiet_run_prints_nothing_and_json_only_json(lag_dir: Path, tmp_path: Path) -> None:
    system = write_system(tmp_path)
    quiet = run(system, lag_dir, "--quiet")
    assert (quiet.returncode, quiet.stdout, quiet.stderr) == (0, "", "")
    told = run(system, lag_dir, "--json")
    assert told.stderr == ""
    printed = json.loads(told.stdout)
    assert printed["run"]["samples"] == 1001
    assert printed["kpis"] == json.loads((tmp_path / "out/kpis.json").read_text())


def test_missed_limit_exits_1(lag_dir: Path, tmp_path: Path) -> None:
    system = write_system(tmp_path)
    limit = 'kpi = "shift.jerkPeak"\nsignal = "vehicle.acceleration"\nmax = 10\n'
    system.write_text(system.read_text() + f"[[kpis]]\n{limit}")
    done = run(system, lag_dir)  # the lag has no acceleration, so the limit is not met
    assert done.returncode == 1, done.stderr
    assert "verdict: fail" in done.stdout


def test_report_exits_as_its_runs_do(lag_dir: Path, tmp_path: Path) -> None:
    system, page = write_system(tmp_path), tmp_path / "page/index.html"
    verdicts = []
    for options in ((), ("--set", "plant.failAt=0.5")):
        run(system, lag_dir, *options)
        done = harness("report", tmp_path / "out", "--out", page.parent, folder=tmp_path)
        verdicts.append((done.returncode, done.stdout))
        assert page.is_file()
    said = [f"report: {page}\nverdict: {verdict}\n" for verdict in ("not judged", "fail")]
    assert verdicts == [(0, said[0]), (1, said[1])]


def test_json_of_a_failed_run_has_no_kpis(lag_dir: Path, tmp_path: Path) -> None:
    done = run(write_system(tmp_path), lag_dir, "--json", "--set", "plant.failAt=0.5")
    printed = json.loads(done.stdout)
    assert (done.returncode, printed["run"]["samples"], printed["kpis"]) == (4, 501, None)


def test_unknown_parameter_exits_2_with_a_hint(lag_dir: Path, tmp_path: Path) -> None:
    done = run(write_system(tmp_path), lag_dir, "--set", "plant.tua=2.0")
    assert done.returncode == 2
    assert "Did you mean 'tau'?" in done.stderr


@pytest.mark.parametrize("seconds", ["0", "-1", "nan", "soon"])
def test_time_limit_that_is_none_exits_2(tmp_path: Path, seconds: str) -> None:
    done = run(write_system(tmp_path), tmp_path, f"--timeout={seconds}")
    assert done.returncode == 2
    assert "is not a time greater than 0 s" in done.stderr


def test_missing_fmu_exits_2(tmp_path: Path) -> None:
    done = run(write_system(tmp_path), tmp_path)
    assert done.returncode == 2
    assert "Lag.fmu: cannot read the FMU" in done.stderr


def test_file_that_is_no_fmu_exits_3(tmp_path: Path) -> None:
    (tmp_path / "Lag.fmu").write_text("not a ZIP archive")
    done = run(write_system(tmp_path), tmp_path)
    assert done.returncode == 3
    assert "is not an FMU" in done.stderr


@pytest.mark.parametrize(("version", "other"), [("3.0", "fmi3"), ("1.0", "fmi1")])
def test_an_fmu_of_another_standard_says_which(
    tmp_path: Path, lag_library: Path, version: str, other: str
) -> None:
    path = write_fmu(tmp_path / "Lag.fmu", lag_library)
    with zipfile.ZipFile(path) as archive:
        files = {name: archive.read(name) for name in archive.namelist()}
    text = files["modelDescription.xml"].decode()
    stated = text.replace('fmiVersion="2.0"', f'fmiVersion="{version}"')
    files["modelDescription.xml"] = stated.encode()
    with zipfile.ZipFile(tmp_path / f"{other}.fmu", "w") as archive:
        for name, content in files.items():
            archive.writestr(name, content)
    done = harness("check", tmp_path / f"{other}.fmu", folder=tmp_path)
    assert done.returncode == 3
    assert f"{other}.fmu: is FMI {version}; FMI 2.0 co-simulation is what runs here" in done.stderr


def test_an_fmu_that_was_cut_short_says_so(tmp_path: Path, lag_library: Path) -> None:
    path = write_fmu(tmp_path / "Lag.fmu", lag_library)
    path.write_bytes(path.read_bytes()[:-100])
    done = harness("check", path, folder=tmp_path)
    assert done.returncode == 3
    assert "is not an FMU (its end is missing: copy it again)" in done.stderr


@pytest.mark.parametrize(("platforms", "said"), [
    (("win64", "darwin64"), "it is for darwin64, win64"), ((), "it has none: ask who built it"),
])  # fmt: skip
def test_an_fmu_of_another_platform_says_which(
    tmp_path: Path, lag_library: Path, platforms: tuple[str, ...], said: str
) -> None:
    path = write_fmu(tmp_path / "Lag.fmu", lag_library)
    with zipfile.ZipFile(path) as archive:
        text = archive.read("modelDescription.xml")
    with zipfile.ZipFile(path, "w") as archive:
        archive.writestr("modelDescription.xml", text)
        for platform in platforms:
            suffix = {"win64": "dll", "darwin64": "dylib"}[platform]
            archive.writestr(f"binaries/{platform}/Lag.{suffix}", "")
    done = harness("check", path, folder=tmp_path)
    assert done.returncode == 6
    assert f"has no binary for {fmpy.platform}; {said}" in done.stderr


def test_archive_member_that_leaves_the_archive_exits_3(tmp_path: Path, lag_library: Path) -> None:
    path = write_fmu(tmp_path / "Lag.fmu", lag_library)
    with zipfile.ZipFile(path, "a") as archive:
        archive.writestr("../escaped.txt", "outside")
    done = harness("check", path, folder=tmp_path)
    assert done.returncode == 3
    assert "'../escaped.txt' leaves the archive" in done.stderr


def test_library_that_does_not_load_exits_3(tmp_path: Path) -> None:
    broken = tmp_path / "Lag.so"
    broken.write_bytes(b"\x7fELF no more than this")
    done = harness("check", write_fmu(tmp_path / "Lag.fmu", broken), folder=tmp_path)
    assert done.returncode == 3
    assert "the library does not load" in done.stderr


def test_failing_fmu_exits_4(lag_dir: Path, tmp_path: Path) -> None:
    assert run(write_system(tmp_path), lag_dir, "--set", "plant.failAt=0.0").returncode == 4


@pytest.mark.parametrize("verb", ["check", "doctor"])
def test_fmu_of_another_platform_exits_6(tmp_path: Path, lag_library: Path, verb: str) -> None:
    path = write_fmu(tmp_path / "Lag.fmu", lag_library, member="binaries/win64/Lag.dll")
    done = harness(verb, path, folder=tmp_path)
    assert done.returncode == 6
    assert "no binary for linux64" in done.stdout + done.stderr


BRAKES = """time,engine.torque,road.grade,brake.torque,shaft1.gear,shaft2.gear,clutch1.pressure,\
clutch2.pressure,clutch1.position,clutch2.position
0,0,0,0,1,2,0,0,0,0
0.5,0,0,0,1,2,0,0,0,0
0.5625,0,0,-1,1,2,0,0,0,0
"""


@pytest.mark.parametrize("engine", ["fmpy", "native"])
@pytest.mark.parametrize(("option", "code", "said"), [
    (("--set", "plant.vehicle.mass=-5"), 2, "'plant.vehicle.mass' = -5 is refused: fmi2SetReal "
     "returned fmi2Discard\n  logStatusDiscard: fmi2SetReal: vehicle.mass = -5 is below 1e-9"),
    (("--scenario", "b.csv", "--step", "0.0625"), 4,
     "plant: fmi2SetReal at t = 0.5625 s returned fmi2Discard\n"
     "  logStatusDiscard: fmi2SetReal: brake.torque = -1 is below 0"),
])  # fmt: skip
def test_our_fmus_say_why_they_refuse(
    repo_root: Path, tmp_path: Path, engine: str, option: tuple[str, ...], code: int, said: str
) -> None:
    (tmp_path / "b.csv").write_text(BRAKES)
    case = repo_root / "examples/closed_loop/paper_case1.toml"
    done = harness("run", case, "--fmu-dir", repo_root / "target/fmu", "--engine", engine,
                   "--out", tmp_path / "out", *option, folder=tmp_path)  # fmt: skip
    assert done.returncode == code
    assert said in done.stderr


def test_what_an_fmu_computes_cannot_be_set(repo_root: Path, tmp_path: Path) -> None:
    case = repo_root / "examples/closed_loop/paper_case1.toml"
    done = harness("run", case, "--fmu-dir", repo_root / "target/fmu", "--out", tmp_path / "out",
                   "--set", "plant.engine.speed=100", folder=tmp_path)  # fmt: skip
    assert done.returncode == 2
    assert "computes 'engine.speed' itself" in done.stderr
    assert "Did you mean 'engine.speed_start'?" in done.stderr


def test_a_result_directory_that_cannot_be_is_refused_before_the_run(
    lag_dir: Path, tmp_path: Path
) -> None:
    system = write_system(tmp_path)
    out = system / "inside"
    done = harness("run", system, "--fmu-dir", lag_dir, "--out", out, folder=tmp_path)
    assert done.returncode == 2
    assert done.stderr == f"dct-harness: --out {out}: {system} is a file, not a folder; " \
                          "name another folder\n"  # fmt: skip


def test_a_file_in_place_of_results_is_called_one(tmp_path: Path) -> None:
    system = write_system(tmp_path)
    done = harness("report", system, "--out", tmp_path / "page", folder=tmp_path)
    assert done.returncode == 2
    assert f"{system}: it is a file, not a directory of results" in done.stderr


def test_a_page_that_cannot_be_written_exits_2(lag_dir: Path, tmp_path: Path) -> None:
    run(write_system(tmp_path), lag_dir)
    page = tmp_path / "out/run.json/page"
    done = harness("report", tmp_path / "out", "--out", page, folder=tmp_path)
    assert done.returncode == 2
    assert done.stderr == f"dct-harness: {page}: Not a directory\n"


def test_a_name_with_a_slip_gets_the_one_beside_it(tmp_path: Path) -> None:
    system = write_system(tmp_path)
    done = harness("run", system.with_name("sytem.toml"), folder=tmp_path)
    assert done.returncode == 2
    assert f"Did you mean '{system.name}'?" in done.stderr


def test_a_full_disk_exits_2_and_the_file_is_named(
    lag_dir: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch,
    capsys: pytest.CaptureFixture[str],
) -> None:  # fmt: skip
    def full(*_: object) -> None:
        raise OSError(errno.ENOSPC, "No space left on device")

    run(write_system(tmp_path), lag_dir)
    monkeypatch.setattr("dct_harness.formats.write", full)
    target = tmp_path / "copy.csv"
    assert cli.main(["convert", str(tmp_path / "out"), str(target)]) == 2
    assert capsys.readouterr().err == f"dct-harness: {target}: No space left on device\n"
