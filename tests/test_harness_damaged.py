"""Results that were cut, edited or are something else: a sentence with the place, no traceback."""

from __future__ import annotations

import json
from collections.abc import Callable
from pathlib import Path

import pytest
from dct_harness import cli, results

NAMES = ["time", "plant.engine.speed"]
RUN = {"system": {"name": "x"}, "step": 0.1, "stop": 0.2, "status": "complete"}


def _run(folder: Path) -> Path:
    """Write a result directory of three samples."""
    out = folder / "run"
    out.mkdir()
    (out / "results.csv").write_text(f"{','.join(NAMES)}\n0,90\n0.1,91\n0.2,92\n")
    (out / "run.json").write_text(json.dumps(RUN))
    return out


def _write(name: str, text: str) -> Callable[[Path], None]:
    def change(out: Path) -> None:
        (out / name).write_text(text)

    return change


HEAD = "time,plant.engine.speed\n"


@pytest.mark.parametrize(("change", "said"), [
    (_write("results.csv", ""), "results.csv: needs a header and at least one row"),
    (_write("results.csv", HEAD), "results.csv: holds no sample; make it again"),
    (_write("results.csv", f"{HEAD}0,90\n0.1\n"), "results.csv: row 3 has 1 cells, the header 2"),
    (_write("results.csv", f"{HEAD}0,90\n\n0.1,x\n"),
     "results.csv: row 4: 'plant.engine.speed' is 'x', not a number"),
    (_write("results.csv", f"{HEAD}0,90\n0.1,90\n0.05,90\n"),
     "results.csv: time is 0.05 s after 0.1 s in sample 3; it must not fall"),
    (_write("results.csv", f"{HEAD}nan,90\n"), "time is nan s in sample 1"),
    (_write("run.json", json.dumps(RUN)[:20]), "run.json: is not valid JSON"),
    (_write("run.json", "[]"), "run.json: is no JSON object"),
])  # fmt: skip
@pytest.mark.parametrize("verb", ["report", "compare"])
def test_damaged_results_are_refused(
    verb: str, change: Callable[[Path], None], said: str, tmp_path: Path,
    capsys: pytest.CaptureFixture[str],
) -> None:  # fmt: skip
    out = _run(tmp_path)
    change(out)
    words = {"report": ["--out", str(tmp_path / "page")], "compare": [str(out)]}[verb]
    assert cli.main([verb, str(out), *words]) == 2
    error = capsys.readouterr().err
    assert said in error
    assert error.count("\n") == 1
    assert not (tmp_path / "page").exists()


@pytest.mark.parametrize(("change", "said"), [
    (_write("run.json", "{}"), "run.json: has no 'system'; make it again with `dct-harness run`"),
    (_write("kpis.json", "{"), "kpis.json: is not valid JSON"),
    (_write("kpis.json", "7"), "kpis.json: is no JSON object"),
])  # fmt: skip
def test_a_page_needs_what_a_run_has_written(
    change: Callable[[Path], None], said: str, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    out = _run(tmp_path)
    change(out)
    assert cli.main(["report", str(out), "--out", str(tmp_path / "page")]) == 2
    assert said in capsys.readouterr().err


def test_two_rows_of_one_time_are_an_event(tmp_path: Path) -> None:
    """Other tools write the values before and after an event so."""
    out = _run(tmp_path)
    _write("results.csv", f"{HEAD}0,90\n0.1,90\n0.1,91\n")(out)
    assert results.load(out).time.tolist() == [0.0, 0.1, 0.1]
