"""What people expect of a command line: hints, completion, a doctor that tells what is there."""

from __future__ import annotations

import json
import shlex
import subprocess
import zipfile
from pathlib import Path

import pytest
from dct_harness import cli
from dct_harness.verbs import doctor as doctor_verb
from dct_harness.verbs import progress
from harness_fixture.lag_fmu import HARNESS, harness, write_fmu, write_system


@pytest.mark.parametrize(("words", "meant"), [
    (["rnu", "x.toml"], "run"), (["comapre", "a", "b"], "compare"),
    (["run", "x.toml", "--tiemout", "3"], "--timeout"),
    (["compare", "a", "b", "--tueb", "3"], "--tube"),
    (["run", "x.toml", "--format", "parqet"], "parquet"),
    (["run", "x.toml", "--fmus", "target/fmu"], "--fmu-dir' or '--fmu-log"),
])  # fmt: skip
def test_a_slip_of_the_keyboard_gets_a_hint(
    words: list[str], meant: str, capsys: pytest.CaptureFixture[str]
) -> None:
    with pytest.raises(SystemExit) as caught:
        cli.main(words)
    assert caught.value.code == 2
    assert capsys.readouterr().err.endswith(f"Did you mean '{meant}'?\n")


def test_a_verb_refuses_options_itself(capsys: pytest.CaptureFixture[str]) -> None:
    with pytest.raises(SystemExit):
        cli.main(["run", "x.toml", "--runs", "3"])  # an option of sweep
    said = capsys.readouterr().err
    assert said.startswith("dct-harness run: unrecognized arguments: --runs 3")


def test_a_word_like_no_other_gets_no_hint(capsys: pytest.CaptureFixture[str]) -> None:
    with pytest.raises(SystemExit):
        cli.main(["xyzzy"])
    said = capsys.readouterr().err
    assert "Did you mean" not in said
    assert said.endswith("\n`dct-harness --help` shows what there is\n")
    assert said.count("\n") == 2  # the mistake is not behind a page of options


@pytest.mark.parametrize("text", ["1ms", "0,001"])
def test_a_number_with_a_unit_or_a_comma_is_told_how_to_write(
    text: str, capsys: pytest.CaptureFixture[str]
) -> None:
    with pytest.raises(SystemExit):
        cli.main(["run", "x.toml", "--step", text])
    said = capsys.readouterr().err
    assert f"--step: '{text}' is not a time greater than 0 s: write the number alone" in said


def test_bash_completes_verbs_options_and_choices(tmp_path: Path) -> None:
    script = tmp_path / "completion"
    done = harness("completion", "bash", folder=tmp_path)
    script.write_text(done.stdout)
    asked = """source "$0"; name=$(complete -p dct-harness | sed 's/.*-F \\([^ ]*\\).*/\\1/')
    ask() { COMP_WORDS=("$@"); COMP_CWORD=$(($# - 1)); COMPREPLY=(); $name
            echo "${COMPREPLY[@]}"; }
    ask dct-harness comp; ask dct-harness run --ti; ask dct-harness run --format p"""
    told = subprocess.run(
        ["bash", "-c", asked, script], capture_output=True, text=True, check=True, cwd=tmp_path
    )
    assert [line.split() for line in told.stdout.splitlines()] == [
        ["compare", "completion"], ["--timeout"], ["parquet"],
    ]  # fmt: skip


@pytest.mark.parametrize("shell", ["zsh", "tcsh"])
def test_other_shells_get_a_script_with_every_verb(
    shell: str, capsys: pytest.CaptureFixture[str]
) -> None:
    assert cli.main(["completion", shell]) == 0
    script = capsys.readouterr().out
    assert all(verb in script for verb in ("run", "compare", "convert", "doctor"))


def test_doctor_tells_the_platforms_of_an_fmu_and_optional_packages(
    tmp_path: Path, lag_library: Path
) -> None:
    path = write_fmu(tmp_path / "Lag.fmu", lag_library)
    with zipfile.ZipFile(path, "a") as archive:
        archive.writestr("binaries/win64/Lag.dll", "")
    said = harness("doctor", path, folder=tmp_path).stdout
    assert f"{path}: binaries for linux64, win64\n" in said
    assert "pyarrow: " in said


def _words(verb: str, folder: Path) -> list[str]:
    """Return words with which a verb has something to say; run in the order of SPOKEN."""
    run, loop = str(folder / "run"), str(folder / "s.toml")
    own = ["--fmu-dir", str(folder)]
    return {
        "run": ["run", loop, *own, "--out", run],
        "compare": ["compare", run, run],
        "report": ["report", run, "--out", str(folder / "report")],
        "convert": ["convert", run, str(folder / "run.parquet")],
        "check": ["check", str(folder / "Lag.fmu")],
        "doctor": ["doctor", str(folder / "Lag.fmu")],
        "export-ssp": ["export-ssp", loop, *own, "--out", str(folder / "loop.ssp")],
        "sweep": ["sweep", loop, *own, "--runs", "2", "--vary", "plant.tau=uniform(1,2)", "--out",
                  str(folder / "sweep")],
    }[verb]  # fmt: skip


SPOKEN = ("run", "compare", "report", "convert", "check", "doctor", "export-ssp", "sweep")


def test_verbs_speak_json_or_not_at_all(
    tmp_path: Path, lag_library: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    write_fmu(tmp_path / "Lag.fmu", lag_library)
    write_system(tmp_path)
    for verb in SPOKEN:
        words = _words(verb, tmp_path)
        code = cli.main([*words, "--json"])
        said = capsys.readouterr()
        assert json.loads(said.out, parse_constant=pytest.fail), verb
        assert said.out.count("\n") == 1, verb
        assert cli.main([*words, "--quiet"]) == code
        assert capsys.readouterr().out == "", verb
        assert cli.main(words) == code
        assert capsys.readouterr().out != "", verb


def test_every_verb_shows_an_example_and_exit_codes_and_most_know_quiet(
    capsys: pytest.CaptureFixture[str],
) -> None:
    silent = set()
    for module in cli.VERBS:
        name = module.__name__.rpartition(".")[2].removesuffix("_verb").replace("_", "-")
        with pytest.raises(SystemExit):
            cli.main([name, "--help"])
        said = capsys.readouterr().out
        assert f"examples:\n  dct-harness {name}" in said
        assert "\nexit codes:\n  " in said
        if "--quiet" not in said:
            silent.add(name)
    assert silent == {"completion"}


def test_every_argument_is_explained() -> None:
    verbs = next(a for a in cli.parser()._actions if a.dest == "verb").choices
    silent = [f"{verb} {a.dest}" for verb, parser in verbs.items()
              for a in parser._actions if not a.help]  # fmt: skip
    assert silent == []


def test_a_reader_that_closes_the_pipe_ends_the_verb_quietly(tmp_path: Path) -> None:
    command = f"{shlex.join([*HARNESS, 'completion', 'bash'])} | true; echo ${{PIPESTATUS[0]}}"
    done = subprocess.run(
        ["bash", "-c", command], capture_output=True, text=True, check=True, cwd=tmp_path
    )
    assert done.stdout == f"{cli.CLOSED_PIPE}\n"
    assert done.stderr == ""


def test_lines_tell_the_time_left(capsys: pytest.CaptureFixture[str]) -> None:
    with progress.choose(quiet=False, unit="run") as shown:
        for k in range(1, 21):
            shown.update(k, 20)
    lines = capsys.readouterr().err.splitlines()
    assert lines[0] == " 10 %  run 2 of 20, 0 s left"
    assert lines[-1] == "100 %  run 20 of 20"
    assert len(lines) == 10


def test_doctor_says_what_a_missing_package_would_give(
    monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.setattr(doctor_verb, "OPTIONAL", {"no-such-package": "this and that"})
    assert cli.main(["doctor"]) == 0
    assert "no-such-package: not installed (this and that)\n" in capsys.readouterr().out
