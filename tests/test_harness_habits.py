"""What people expect of a command line: hints, completion, a doctor that tells what is there."""

from __future__ import annotations

import subprocess
import zipfile
from pathlib import Path

import pytest
from dct_harness import cli, doctor_verb
from harness_fixture.lag_fmu import harness, write_fmu


@pytest.mark.parametrize(("words", "meant"), [
    (["rnu", "x.toml"], "run"), (["comapre", "a", "b"], "compare"),
    (["run", "x.toml", "--tiemout", "3"], "--timeout"),
    (["compare", "a", "b", "--tueb", "3"], "--tube"),
    (["run", "x.toml", "--format", "parqet"], "parquet"),
])  # fmt: skip
def test_a_slip_of_the_keyboard_gets_a_hint(
    words: list[str], meant: str, capsys: pytest.CaptureFixture[str]
) -> None:
    with pytest.raises(SystemExit) as caught:
        cli.main(words)
    assert caught.value.code == 2
    assert capsys.readouterr().err.endswith(f"Did you mean '{meant}'?\n")


def test_a_word_like_no_other_gets_no_hint(capsys: pytest.CaptureFixture[str]) -> None:
    with pytest.raises(SystemExit):
        cli.main(["xyzzy"])
    assert "Did you mean" not in capsys.readouterr().err


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


def test_doctor_says_what_a_missing_package_would_give(
    monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.setattr(doctor_verb, "OPTIONAL", {"no-such-package": "this and that"})
    assert cli.main(["doctor"]) == 0
    assert "no-such-package: not installed (this and that)\n" in capsys.readouterr().out
