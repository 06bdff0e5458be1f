"""Scenario files: errors with file, line, column; values between rows; results read back."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
from dct_harness import results
from dct_harness.errors import ConfigError
from dct_harness.master import doubts
from dct_harness.system import scenario
from harness_fixture.lag_fmu import run, write_system


@pytest.mark.parametrize(("text", "said"), [
    ("t,u\n0,1\n", ":1: the first column must be 'time' [s], not 't'"),
    ("time;u\n0;1\n", ":1: the first column must be 'time' [s], not 'time;u'; columns are separated"
     " by commas: `dct-harness convert {} scenario.csv` does that, decimal commas too"),
    ("time,u [mm]\n0,1\n", ":1: column 'u [mm]': values are in SI units, and names stand alone: "
     "`dct-harness convert {} scenario.csv` makes them 'u'"),
    ("time,u,u\n0,1,2\n", ":1: column name 'u' is empty or used twice"),
    ("time,,u\n0,1,2\n", ":1: column name '' is empty or used twice"),
    ("time,u\n0,1\n1,one\n", ":3: column 'u': 'one' is not a finite number"),
    ("time,u\n0,1\n1,nan\n", ":3: column 'u': 'nan' is not a finite number"),
    ("time,u\n0,1\n1,inf\n", ":3: column 'u': 'inf' is not a finite number"),
    ("time,u\n0,1\n1,\n", ":3: column 'u': '' is not a finite number"),
    ("time,u\n0,1\n1,2,3\n",
     ":3: has 3 cells, the header has 2; decimals are written with a point"),
    ("time,u\n0,1\n\n1;2\n", ":4: has 1 cells, the header has 2"),
    ("time,u\n0,1\n0.5,1\n\n0.5,2\n", ":5: time 0.5 does not increase (before it: 0.5)"),
    ("time,u\n", ": needs a header and at least one row"),
    ("", ": needs a header and at least one row"),
])  # fmt: skip
def test_error_names_file_line_and_column(tmp_path: Path, text: str, said: str) -> None:
    path = tmp_path / "s.csv"
    path.write_text(text)
    with pytest.raises(ConfigError) as caught:
        scenario.load(path)
    assert str(caught.value) == f"{path}{said.format(path)}"


def test_missing_scenario_is_a_sentence(tmp_path: Path) -> None:
    with pytest.raises(ConfigError, match=r"none\.csv: cannot read the scenario: No such file"):
        scenario.load(tmp_path / "none.csv")


def test_scenario_that_is_no_text_is_a_sentence(tmp_path: Path) -> None:
    path = tmp_path / "s.csv"
    path.write_bytes(b"time,u\n0,\xff\xfe\n")
    with pytest.raises(ConfigError, match=r"s\.csv: is not UTF-8 text; .* 'CSV UTF-8'"):
        scenario.load(path)


def test_a_scenario_that_was_read_is_not_parsed_again_unless_it_changes(tmp_path: Path) -> None:
    path = tmp_path / "s.csv"
    path.write_text("time,u\n0,1\n")
    first, again = scenario.load(path), scenario.load(path)
    assert again is first
    with pytest.raises(ValueError, match="read-only"):
        first.signals["u"][0] = 2.0
    path.write_text("time,u\n0,3\n")
    assert scenario.load(path).signals["u"] == [3.0]


def test_reals_are_interpolated_and_integers_held(tmp_path: Path) -> None:
    path = tmp_path / "s.csv"
    path.write_text("\ufefftime, u \r\n0,1\r\n1,3\r\n", encoding="utf-8", newline="")
    script = scenario.load(path)
    times = np.array([-1.0, 0.0, 0.5, 1.0, 2.0])
    assert script.sample("u", times, hold=False).tolist() == [1, 1, 2, 3, 3]
    assert script.sample("u", times, hold=True).tolist() == [1, 1, 1, 3, 3]


@pytest.mark.parametrize(("rows", "stop", "said"), [
    ("0,2\n1,2\n", "1.0", []), ("0,2\n", "1.0", []),
    ("0,2\n0.5,2\n", "1.0", ["ends at t = 0.5 s: its last values hold from then on"]),
    ("0.25,2\n0.5,2\n", "1.0", ["begins at t = 0.25 s: its first values hold until then",
                                "ends at t = 0.5 s: its last values hold from then on"]),
    ("0,2\n1000,2\n", "1.0", ["goes on to t = 1000 s: are its times in ms? They are read as s"]),
    ("0,2\n30,2\n", "0.1", []),
])  # fmt: skip
def test_a_run_that_leaves_its_scenario_says_so(
    lag_dir: Path, tmp_path: Path, rows: str, stop: str, said: list[str]
) -> None:
    path = write_system(tmp_path, stop, f"time,u\n{rows}")
    done = run(path, lag_dir)
    told = [line for line in done.stderr.splitlines() if " %  step" not in line]
    assert told == [f"scenario s.csv {text}" for text in said]
    log = results.load(tmp_path / "out").run["log"]
    assert [m["message"] for m in log if m["category"] == "scenario"] == told


@pytest.mark.parametrize(("signal", "value", "said"), [
    ("clutch1.position", 3.0, "reaches 3 m, 3000 mm: is it in mm? It is read as m"),
    ("clutch1.position", 0.003, ""), ("clutch1.position", 0.0, ""),
    ("clutch1.pressure", 8.0, "reaches 8 Pa, 8e-05 bar: is it in bar? It is read as Pa"),
    ("clutch1.pressure", 8e5, ""), ("clutch1.pressure", 0.0, ""),
    ("wheel.speed", 3e3, "reaches 3000 rad/s, 2.865e+04 rpm: is it in rpm? It is read as rad/s"),
    ("engine.speed", 700.0, ""),
    ("road.grade", 1.0, ""), ("engine.torque", 3e4, ""), ("nobody.knows", 3e4, ""),
])  # fmt: skip
def test_values_in_the_unit_that_tools_show_are_in_doubt(
    signal: str, value: float, said: str
) -> None:
    script = scenario.Scenario(
        np.array([0.0, 1.0]), {signal: np.array([0.0, value])}, Path("s.csv")
    )
    told = [(0.0, f"scenario s.csv: {signal} {said}")] if said else []
    assert doubts.of(script, [signal], 1.0) == told
    assert doubts.of(script, [], 1.0) == []


def test_results_read_back_bit_for_bit(tmp_path: Path) -> None:
    bits = np.random.default_rng(1).integers(0, 2**64, 4000, dtype=np.uint64)
    numbers = bits.view(np.float64)
    numbers = numbers[np.isfinite(numbers)]
    edges = [0.1, 1 / 3, 5e-324, 1.7976931348623157e308, -0.0, 0.001 * 3]
    table = np.resize(np.concatenate([edges, numbers]), (1000, 4))
    table[:, 0] = np.sort(table[:, 0])  # time does not fall
    results.write(tmp_path, ["time", "plant.a", "plant.b", "plant.c"], table, {"step": 0.1})
    loaded = results.load(tmp_path)
    back = np.column_stack([loaded[n] for n in ("time", "plant.a", "plant.b", "plant.c")])
    assert back.tobytes() == table.tobytes()
    assert loaded.run == {"step": 0.1}


def test_unknown_signal_names_the_nearest(tmp_path: Path) -> None:
    results.write(tmp_path, ["time", "plant.x"], np.zeros((1, 2)), {})
    with pytest.raises(KeyError, match=r"Did you mean 'plant\.x'"):
        results.load(tmp_path)["plant.y"]


def test_damaged_results_are_a_sentence(tmp_path: Path) -> None:
    results.write(tmp_path, ["time", "plant.x"], np.zeros((2, 2)), {})
    path = tmp_path / "results.csv"
    path.write_text(path.read_text() + "0.1,oops\n")
    with pytest.raises(ConfigError, match=r"results\.csv: row 4: 'plant\.x' is 'oops'"):
        results.load(tmp_path)
