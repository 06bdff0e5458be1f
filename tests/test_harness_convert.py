"""`dct-harness convert`: formats, foreign names and units, rates; measured data to a scenario."""

from __future__ import annotations

import math
from pathlib import Path

import asammdf
import numpy as np
import pytest
from dct_harness import cli, formats, units
from dct_harness.errors import ConfigError
from dct_harness.measured import Channel, Mapping, common, read
from dct_harness.system import scenario

MAP = """[[signals]]
from = "EngSpd"
to = "engine.speed"
[[signals]]
from = "Gear"
to = "shaft1.gear"
[[signals]]
from = "TqEng"
to = "engine.torque"
unit = "kNm"
[[signals]]
from = "Oil"
to = "oil.temperature"
factor = 0.5
offset = 250.0
"""


def write_mf4(path: Path) -> None:
    """Write channels at three rates, as a measurement has them."""
    fast, slow = np.arange(0, 10.0005, 0.001), np.arange(0, 10.05, 0.1)
    signals = [
        asammdf.Signal(600 + 60 * fast, fast, name="EngSpd", unit="rpm"),
        asammdf.Signal((slow >= 5).astype(np.uint8) + 1, slow, name="Gear"),
        asammdf.Signal(0.1 * np.ones_like(fast), fast, name="TqEng"),
        asammdf.Signal(20 * slow, slow, name="Oil", unit="raw"),
    ]
    with asammdf.MDF() as mdf:
        for signal in signals:
            mdf.append(signal)
        mdf.save(path, overwrite=True)


def test_measurement_becomes_a_scenario(tmp_path: Path, capsys: pytest.CaptureFixture) -> None:
    write_mf4(tmp_path / "drive.mf4")
    (tmp_path / "m.toml").write_text(MAP)
    options = ["--step", "0.01", "--start", "2", "--stop", "8"]
    files = [str(tmp_path / name) for name in ("drive.mf4", "s.csv", "m.toml")]
    assert cli.main(["convert", *files[:2], "--map", files[2], *options]) == 0
    assert capsys.readouterr().out.endswith("4 signals, 601 samples to t = 6 s\n")
    made = scenario.load(tmp_path / "s.csv")
    assert (made.time[0], made.time[-1]) == pytest.approx((0.0, 6.0), abs=1e-12)
    speed = (600 + 60 * (made.time + 2)) * 2 * math.pi / 60
    assert made.signals["engine.speed"] == pytest.approx(speed, rel=1e-12)
    assert made.signals["engine.torque"] == pytest.approx(np.full(601, 100.0), rel=1e-12)
    assert set(made.signals["shaft1.gear"]) == {1.0, 2.0}  # held, not interpolated
    assert made.signals["oil.temperature"] == pytest.approx(0.5 * 20 * (made.time + 2) + 250)


@pytest.mark.parametrize("suffix", [".csv", ".parquet", ".mf4"])
def test_conversion_there_and_back_is_exact(tmp_path: Path, suffix: str) -> None:
    rows = np.random.default_rng(5).normal(size=(50, 3))
    rows[:, 0] = np.arange(50) * 0.001
    table = formats.Table(["time", "plant.a", "plant.b[1]"], rows, {"plant.a": "N.m"})
    formats.write(tmp_path / "a.parquet", table)
    assert cli.main(["convert", str(tmp_path / "a.parquet"), str(tmp_path / f"b{suffix}")]) == 0
    assert cli.main(["convert", str(tmp_path / f"b{suffix}"), str(tmp_path / "c.parquet")]) == 0
    back = formats.read(tmp_path / "c.parquet")
    assert (back.names, back.rows.tobytes()) == (table.names, rows.tobytes())
    assert back.units.get("plant.a", "") == ("" if suffix == ".csv" else "N.m")


def test_german_csv_with_units_and_gaps_is_read(tmp_path: Path) -> None:
    (tmp_path / "m.csv").write_text(
        "Zeit [s];v Fzg [km/h];n\n0,0;36,0;1\n0,5;;2\n1,0;72,0;\n", encoding="utf-8-sig"
    )
    speed, count = read(tmp_path / "m.csv")
    assert (speed.name, speed.unit, speed.time.tolist()) == ("v Fzg", "km/h", [0.0, 1.0])
    assert speed.values.tolist() == [36.0, 72.0]
    assert (count.unit, count.values.tolist()) == ("", [1.0, 2.0])


def test_csv_has_no_place_for_units_so_values_come_to_si(
    tmp_path: Path, capsys: pytest.CaptureFixture
) -> None:
    (tmp_path / "m.csv").write_text(
        "Zeit [ms];clutch1.position [mm];T [degC];x [furlong]\n0;1,5;20;3\n500;2,5;30;4\n"
    )
    files = [str(tmp_path / name) for name in ("m.csv", "s.csv", "m.parquet")]
    assert cli.main(["convert", *files[:2]]) == 0
    assert (
        "values in furlong stay as they are: no such unit is known (x)" in capsys.readouterr().err
    )
    made = scenario.load(tmp_path / "s.csv")
    assert made.time.tolist() == [0.0, 0.5]
    assert made.signals["clutch1.position"].tolist() == [0.0015, 0.0025]
    assert made.signals["T"].tolist() == [293.15, 303.15]
    assert made.signals["x"].tolist() == [3.0, 4.0]
    assert cli.main(["convert", files[0], files[2]]) == 0  # Parquet has, so they stay
    table = formats.read(tmp_path / "m.parquet")
    assert (table.units["clutch1.position"], table.rows[0, 1]) == ("mm", 1.5)


def test_several_rates_need_a_step() -> None:
    fast = Channel("a", np.arange(5.0), np.arange(5.0))
    slow = Channel("b", np.arange(0.0, 5.0, 2.0), np.arange(3.0))
    with pytest.raises(ConfigError, match="'b' is sampled at other times than 'a'; give --step"):
        common([fast, slow], None, None, None)
    assert common([fast, slow], 0.5, None, None).rows[:, 2].tolist() == [k / 4 for k in range(9)]
    late = Channel("c", np.arange(10.0, 12.0), np.zeros(2))
    with pytest.raises(ConfigError, match="share no stretch"):
        common([fast, late], 0.5, None, None)
    with pytest.raises(ConfigError, match="no sample from"):
        common([fast], 0.5, 7.0, 8.0)


@pytest.mark.parametrize(("unit", "value", "si", "result"), [
    ("rpm", 60.0, "rad/s", 2 * math.pi), ("km/h", 36.0, "m/s", 10.0), ("bar", 2.0, "Pa", 2e5),
    ("degC", 20.0, "K", 293.15), ("%", 50.0, "1", 0.5), ("kNm", 0.3, "N.m", 300.0),
    ("mm", 3.0, "m", 0.003), ("deg", 180.0, "rad", math.pi), ("N.m", 7.0, "N.m", 7.0),
    ("U/min", 60.0, "rad/s", 2 * math.pi), ("m/s²", 2.0, "m/s2", 2.0),
])  # fmt: skip
def test_units_come_to_si(unit: str, value: float, si: str, result: float) -> None:
    name, factor, offset = units.to_si(unit)
    assert (name, factor * value + offset) == (si, pytest.approx(result, rel=1e-15))


@pytest.mark.parametrize(("text", "said"), [
    ('[[signals]]\nfrom = "n"\n', "entry 1: needs from and to"),
    ('[[signals]]\nfrom = "n"\nto = "x"\nunits = "rpm"\n', "Did you mean 'unit'?"),
    ('[[signals]]\nfrom = "n"\nto = "x"\nunit = "rmp"\n', "'rmp' is not known"),
    ('[[signals]]\nfrom = "n"\nto = "x"\nfactor = "2"\n', "wrong type"),
    ('[[signals]]\nfrom = "n"\nto = "x"\nunit = "rpm"\nfactor = 2\n', "not both"),
    ('[[signals]]\nfrom = "m"\nto = "x"\n', "no channel 'm'"),
    ('[[signals]]\nfrom = "n"\nto = "x"\n[[signals]]\nfrom = "n"\nto = "x"\n', "mapped twice"),
    ("x = 1\n", "needs [[signals]]"), ("[", "not valid TOML"),
])  # fmt: skip
def test_bad_maps_are_refused(tmp_path: Path, text: str, said: str) -> None:
    (tmp_path / "m.toml").write_text(text)
    channel = Channel("n", np.arange(3.0), np.zeros(3), "rad/s")
    with pytest.raises(ConfigError) as caught:
        Mapping.load(tmp_path / "m.toml").apply([channel])
    assert said in str(caught.value)


@pytest.mark.parametrize(("text", "said"), [
    ("time,a\n0,1\n0,2\n", "time of 'a' goes from"), ("a,b\n0,1\n", "must be the time"),
    ("time [min],a\n0,1\n", "the time is in 'min'; it must be in s or ms"),
    ("time,a\n0,5,1\n", "row 2 has 3 cells, the header 2; decimals are written with a point"),
    ("time,a\n0,x\n", "row 2: 'a' is 'x'"), ("time,a\n0\n", "row 2 has 1 cells"),
    ("time,a\n", "at least one row"),
])  # fmt: skip
def test_bad_measurements_are_refused(tmp_path: Path, text: str, said: str) -> None:
    (tmp_path / "m.csv").write_text(text)
    with pytest.raises(ConfigError) as caught:
        read(tmp_path / "m.csv")
    assert said in str(caught.value)


@pytest.mark.parametrize(("options", "said"), [
    (("--start", "50"), "there is no sample from 50 s on: the channels share 0 s to 1 s"),
    (("--stop", "-1"), "there is no sample up to -1 s: the channels share 0 s to 1 s"),
    (("--step", "1e-300"), "step = 1e-300 s: more than 1e+08 samples; take a longer one"),
])  # fmt: skip
def test_a_part_that_is_not_there_or_never_ends_exits_2(
    options: tuple[str, str], said: str, tmp_path: Path, capsys: pytest.CaptureFixture
) -> None:
    (tmp_path / "a.csv").write_text("time,a\n0,1\n1,1\n")
    assert cli.main(["convert", str(tmp_path / "a.csv"), str(tmp_path / "b.csv"), *options]) == 2
    assert capsys.readouterr().err == f"dct-harness: {said}\n"


def test_nothing_to_convert_exits_2(tmp_path: Path, capsys: pytest.CaptureFixture) -> None:
    (tmp_path / "a.csv").write_text("time,a\n0,1\n")
    assert cli.main(["convert", str(tmp_path / "a.csv"), "b.csv", "--only", "x*"]) == 2
    assert "nothing to convert" in capsys.readouterr().err
