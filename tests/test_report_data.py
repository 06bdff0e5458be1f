"""What the report shows, without a browser; and synthetic runs for its tests.

`write_run` takes the plant's truth from tests/golden and adds made-up estimates, so that the
report can be tested without FMUs.
"""

from __future__ import annotations

import csv
import importlib.util
import itertools
import json
import re
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from dct_harness import report, results
from dct_harness.errors import ConfigError
from dct_harness.report import (
    benefit,
    calibration,
    cells,
    diagram,
    downsample,
    friction,
    methods,
    runs,
)
from dct_harness.results import Results
from dct_harness.system import system

ROOT = Path(__file__).resolve().parent.parent
SCENARIOS = ROOT / "examples" / "closed_loop" / "scenarios"
NOMINAL = {"paper_case1": (0.4, 0.1), "paper_case2": (0.1, 0.4)}
RATIOS = (18.0, 11.52)
TORQUES = ("clutch1.torque", "clutch2.torque", "driveShaft.torque")
HOSTILE = "<script>alert('x')</script> & <b>\"bold\"</b>"


def _scripts() -> Any:
    """Return make_scenarios.py as a module: positions and capacity of the paper's scenario."""
    spec = importlib.util.spec_from_file_location("scripts", SCENARIOS / "make_scenarios.py")
    module = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(module)
    return module


def golden(step: float) -> dict[str, np.ndarray]:
    """Return the golden truth of the paper's scenario as plant signals on a grid [s]."""
    with (ROOT / "tests/golden/paper_compliant.csv").open(newline="") as file:
        names, *rows = list(csv.reader(file))
    table = np.array(rows, dtype=float)
    time = np.arange(round(table[-1, 0] / step) + 1) * step
    held = np.searchsorted(table[:, 0], time + 1e-9, side="right") - 1
    plant = {f"plant.{n}": table[held, k] if n.endswith(".state")
             else np.interp(time, table[:, 0], table[:, k])
             for k, n in enumerate(names) if k}  # fmt: skip
    return {"time": time, **plant}


def estimates(signals: dict[str, np.ndarray], nominal: tuple[float, float]) -> None:
    """Add map-based torques of the nominal friction and an observer that learns in 0.3 s."""
    scripts, time = _scripts(), signals["time"]
    observed, by_map = np.zeros_like(time), np.zeros_like(time)
    for k, clutch in enumerate(("clutch1", "clutch2")):
        theta = scripts.at(scripts.POSITIONS_MM[k], time) / 1000
        mapped = scripts.capacity(k, time) * nominal[k] / scripts.KINETIC_FRICTION[k]
        truth = signals[f"plant.{clutch}.torque"]
        active = np.cumsum(truth != 0) * (time[1] - time[0])
        learnt = truth + (mapped - truth) * np.exp(-active / 0.3) * (truth != 0)
        stroke = np.where(theta > 0, theta * scripts.EFFECTIVE_RADIUS, 1.0)
        signals[f"scenario.{clutch}.position"] = theta
        signals[f"observer.{clutch}.torque"] = learnt
        signals[f"observer.mapBased.{clutch}.torque"] = mapped
        signals[f"observer.{clutch}.muF"] = learnt / stroke
        observed, by_map = observed + RATIOS[k] * learnt, by_map + RATIOS[k] * mapped
    shaft = signals["plant.driveShaft.torque"]
    signals["observer.driveShaft.torque"] = shaft + 0.02 * (observed - shaft)
    signals["observer.mapBased.driveShaft.torque"] = by_map


def tracked(signals: dict[str, np.ndarray], error: float) -> None:
    """Add requests, from which the plant's slipping torque is `error` (relative) away."""
    for clutch in ("clutch1", "clutch2"):
        truth = np.abs(signals[f"plant.{clutch}.torque"])
        signals[f"scenario.{clutch}.torqueRequest"] = truth / (1 + error)
        signals[f"control.{clutch}.position"] = signals.pop(f"scenario.{clutch}.position")


def beside(signals: dict[str, np.ndarray]) -> None:
    """Add observers with the error of the first times a factor; one that keeps the map's."""
    for name, factor in (("kalman", 0.5), ("mine", 2.0), ("nonAdaptive", None)):
        for torque in TORQUES:
            truth, own = signals[f"plant.{torque}"], signals[f"observer.{torque}"]
            told = signals[f"observer.mapBased.{torque}"] if factor is None else (
                truth + factor * (own - truth))  # fmt: skip
            signals[f"{name}.{torque}"] = told
        for clutch in ("clutch1", "clutch2"):
            signals[f"{name}.{clutch}.muF"] = signals[f"observer.{clutch}.muF"]


def limits_of(name: str) -> list[dict[str, Any]]:
    """Return the limits of a system in examples/, none for another name."""
    path = SCENARIOS.parent / f"{name}.toml"
    return system.load(path).kpis if path.is_file() else []


def inertia(value: float) -> dict[str, Any]:
    """Return a moment of inertia as `run.json` records it."""
    return {"value": value, "unit": "kg.m2"}


def run_json(name: str, title: str, step: float, control: bool | None) -> dict[str, Any]:
    """Return what `dct-harness run` would record."""
    models = {"plant": "DctPlant", "observer": "DctObserver"}
    if control is not None:
        models["control"] = "DctClutchControl"
    parts = {c: {"fmu": f"{m}.fmu", "parameters": {}} for c, m in models.items()}
    parts["plant"]["parameters"]["engine.speed_start"] = 90.0
    wiring = [("scenario.engine.torque", "plant"), ("scenario.road.grade", "plant"),
              ("plant.engine.speed", "observer"), ("plant.wheel.speed", "observer"),
              ("scenario.engine.torque", "observer")]  # fmt: skip
    if control is None:
        wiring += [("scenario.clutch1.position", c) for c in ("plant", "observer")]
    else:
        parts["control"]["parameters"]["feedback.enabled"] = control
        wiring += [("scenario.clutch1.torqueRequest", "control"),
                   ("observer.clutch1.muF", "control"), ("control.clutch1.position", "plant"),
                   ("control.clutch1.position", "observer")]  # fmt: skip
    told = {
        "plant": {"engine.inertia": inertia(0.78), "damper.inertia": inertia(0.02)},
        "observer": {"observer.method": {"value": 1, "unit": "", "item": "paper"},
                     "engine.inertia": inertia(0.98), "damper.inertia": inertia(0.02)},
        "nonAdaptive": {"adaptation.enabled": {"value": False, "unit": ""}},
    }  # fmt: skip
    return {
        "parameters": told,
        "system": {"name": name, "title": title, "step": step, "stop": 30.0,
                   "scenario": str(SCENARIOS / "positions.csv"), "components": parts,
                   "kpis": limits_of(name)},
        "step": step, "stop": 30.0, "status": "complete", "error": None,
        "fmus": {c: {"path": f"{m}.fmu", "modelName": m, "guid": f"{{{m}}}", "sha256": "0" * 64,
                     "generationTool": "fmu-build"} for c, m in models.items()},
        "wiring": [{"from": s, "to": f"{c}.{s.partition('.')[2]}"} for s, c in wiring],
        "signals": {"observer.clutch1.muF": {"unit": "N/m", "type": "Real"}},
        "events": [], "log": [{"component": "plant", "time": 2.5, "category": "events",
                               "status": "OK", "message": "clutch1 locked & <held>"}],
        "wall_time": dict.fromkeys(models, 0.1), "environment": {"python": "3"},
    }  # fmt: skip


def write_run(out: Path, name: str, title: str, step: float = 0.01, **options: Any) -> Path:
    """Write a synthetic run; options `control` (feedback on or off), `drop` (signals), and which
    signals to add: `methods`, `learning`.
    """
    control = options.get("control")
    signals = golden(step)
    estimates(signals, NOMINAL.get(name, (0.4, 0.1)))
    if control is not None:
        tracked(signals, 0.05 if control else 0.4)
    if options.get("methods"):
        beside(signals)
    if options.get("learning"):
        learning(signals)
    signals["plant.energy.residual"] = 1e-4 * np.sin(signals["time"])
    kept = {n: v for n, v in signals.items() if not n.endswith(options.get("drop", ()))}
    run = run_json(name, title, step, control)
    results.write(out, list(kept), np.column_stack(list(kept.values())), run)
    return out


def write_all(out: Path, step: float = 0.01) -> list[Path]:
    """Write both friction cases, and torque tracking with and without feedback."""
    made = [write_run(out / f"paper_case{k}", f"paper_case{k}",
                      f"Fig. 9 positions, friction case {k}", step) for k in (1, 2)]  # fmt: skip
    for control in (True, False):
        folder = out / f"tracking_{'on' if control else 'off'}"
        made.append(write_run(folder, "torque_tracking_case1", "Torque tracking, friction case 1",
                              step, control=control))  # fmt: skip
    return made


@pytest.mark.parametrize("seed", range(4))
def test_downsampling_keeps_every_peak(seed: int) -> None:
    noise = np.random.default_rng(seed).normal(size=30001)
    index = downsample.m4(noise, 100)
    assert len(index) <= 400
    edges = np.linspace(0, len(noise), 101).astype(int)
    for a, b in itertools.pairwise(edges):
        kept = noise[index[(index >= a) & (index < b)]]
        assert (kept.min(), kept.max()) == (noise[a:b].min(), noise[a:b].max())
        assert (kept[0], kept[-1]) == (noise[a], noise[b - 1])


def test_downsampling_keeps_gaps_and_the_ends_of_flat_stretches() -> None:
    values = np.concatenate([np.zeros(500), np.full(500, np.nan), np.ones(500)])
    assert downsample.m4(values, 10).tolist() == [0, 499, 500, 999, 1000, 1499]


def test_short_signals_are_kept_whole() -> None:
    assert downsample.m4(np.array([3.0, 1.0, 2.0])).tolist() == [0, 1, 2]


def test_true_friction_coefficient_is_recovered() -> None:
    theta = np.linspace(0.001, 0.009, 50)
    mu_f, radius = 1.5e5, 0.095
    signals = {
        "time": np.arange(50.0), "scenario.clutch1.position": theta,
        "observer.clutch1.muF": np.full(50, 2e5),
        "observer.clutch1.torque": 2e5 * theta * radius,
        "observer.mapBased.clutch1.torque": 3e5 * theta * radius,
        "plant.clutch1.torque": mu_f * theta * radius,
    }  # fmt: skip
    found = friction.coefficients(Results(signals, {}), "clutch1")
    for role, expected in (("truth", mu_f), ("map", 3e5), ("observer", 2e5)):
        assert found[role] == pytest.approx(np.full(50, expected), rel=1e-12)


def test_arrow_against_the_stepping_order_is_one_step_late() -> None:
    drawn = diagram.layout(run_json("x", "x", 0.001, True))
    delays = {e["signals"][0]["from"].partition(".")[0] + ">"
              + e["signals"][0]["to"].partition(".")[0]: e["signals"][0]["delay"]
              for e in drawn["edges"]}  # fmt: skip
    late = {name for name, delay in delays.items() if delay != "none"}
    assert late == {"control>plant", "control>observer"}
    assert delays["control>plant"] == "one step (1 ms)"
    assert sum(e["delayed"] for e in drawn["edges"]) == 2
    units = {s["from"]: s["unit"] for e in drawn["edges"] for s in e["signals"]}
    assert units["observer.clutch1.muF"] == "N/m"


def test_the_diagram_shows_what_the_run_recorded_of_its_coupling() -> None:
    run = run_json("x", "x", 0.001, True)
    loop = ["control.clutch1.position", "observer.clutch1.muF"]
    late = {"from": "plant.engine.speed", "to": "observer.engine.speed"}
    run["coupling"] = {"order": "jacobi", "loops": [loop], "delayed": [late]}
    drawn = diagram.layout(run)
    assert (drawn["order"], drawn["loops"]) == ("jacobi", [loop])
    found = [s for e in drawn["edges"] for s in e["signals"] if s["delay"] != "none"]
    assert [{"from": s["from"], "to": s["to"]} for s in found] == [late]


def test_components_that_are_alike_share_a_box() -> None:
    run = run_json("x", "x", 0.001, None)
    for name in ("kalman", "energy"):
        run["system"]["components"][name] = {"fmu": "DctObserver.fmu", "parameters": {}}
        run["fmus"][name] = {**run["fmus"]["observer"], "sha256": "1" * 64}
        run["wiring"] += [{"from": w["from"], "to": w["to"].replace("observer.", f"{name}.")}
                          for w in run["wiring"] if w["to"].startswith("observer.")]  # fmt: skip
    run["fmus"]["observer"]["sha256"] = "1" * 64
    boxes = [" ".join(box["names"]) for box in diagram.layout(run)["boxes"]]
    assert boxes == ["scenario", "plant", "observer, kalman, energy"]
    assert all(e["signals"][0]["to"].startswith(("plant.", "observer."))
               for e in diagram.layout(run)["edges"])  # fmt: skip


def test_runs_with_and_without_feedback_are_paired(tmp_path: Path) -> None:
    views = runs.load(write_all(tmp_path))
    (pair,) = runs.pairs(views)
    assert (pair.closed.feedback, pair.opened.feedback) == (True, False)
    ratio = next(r["value"] for r in pair.rows if r["signal"] == "clutches")
    assert ratio == pytest.approx((0.05 / 1.05) / (0.4 / 1.4), rel=1e-9)
    assert [limit["pass"] for limit in pair.limits] == [True]


def test_verdict_counts_the_limits_of_runs_and_of_pairs(tmp_path: Path) -> None:
    views = runs.load(write_all(tmp_path, step=0.001))
    verdict, judged = runs.overall(views, runs.pairs(views))
    assert len(judged) == 6 + 6 + 1
    assert verdict == ("pass" if all(limit["pass"] for _, limit in judged) else "fail")
    assert judged[-1][1]["kpi"] == "tracking.feedbackRatio"
    assert judged[-1][1]["pass"]


def test_matrix_has_a_row_per_scope_and_marks_where_the_map_wins(tmp_path: Path) -> None:
    (view,) = runs.load([write_run(tmp_path / "a", "paper_case1", "A")])
    table = cells.matrix(view)
    labels = [row["scope"] for row in table["rows"]]
    assert labels[0] == "whole scenario"
    assert {"launch", "upshift", "slipping", "engaged"} <= set(labels)
    assert all(len(row["cells"]) == 15 for row in table["rows"])


@pytest.mark.parametrize("drop", [
    (".state",), (".muF",), ("clutch2.torque",), (".position",), ("energy.residual",),
    (".speed",), ("mapBased.driveShaft.torque",),
])  # fmt: skip
def test_page_does_without_optional_signals(tmp_path: Path, drop: tuple[str, ...]) -> None:
    run = write_run(tmp_path / "run", "supplier", "Supplier plant", drop=drop)
    page = report.write([run], tmp_path / "report", "Swap").read_text(encoding="utf-8")
    assert "No limits are set" in page
    assert "Supplier plant" in page


def test_names_are_escaped(tmp_path: Path) -> None:
    run = write_run(tmp_path / "run", "x", HOSTILE)
    page = report.write([run], tmp_path / "report", HOSTILE).read_text(encoding="utf-8")
    assert "<script>alert" not in page
    assert '<b>"bold' not in page
    assert "clutch1 locked &amp; &lt;held&gt;" in page


def test_same_runs_give_the_same_bytes(tmp_path: Path) -> None:
    run = write_run(tmp_path / "run", "paper_case1", "Case 1")
    first = report.write([run], tmp_path / "a", "T").read_bytes()
    assert report.write([run], tmp_path / "b", "T").read_bytes() == first
    pictures = [report.picture(run, tmp_path / f"{k}.svg").read_bytes() for k in "ab"]
    assert pictures[0] == pictures[1]


def test_page_of_full_runs_stays_small(tmp_path: Path) -> None:
    made = write_all(tmp_path, step=0.001)
    page = report.write(made, tmp_path / "report", "T")
    assert page.stat().st_size < 12e6
    assert json.loads((made[0] / "run.json").read_text())["step"] == 0.001


def test_no_run_is_a_sentence(tmp_path: Path) -> None:
    with pytest.raises(ConfigError, match=r"no results\.csv"):
        report.write([tmp_path], tmp_path / "report", "T")


def test_a_pair_of_runs_says_what_the_estimates_buy(tmp_path: Path) -> None:
    """Ratios are those of the KPIs, and one above 1 is marked."""
    views = runs.load(write_all(tmp_path))
    (pair,) = runs.pairs(views)
    rows = {(r["title"], r["of"]): r for r in benefit.rows(pair)}
    tracking = rows["RMS torque-tracking error while slipping", "both clutches"]
    (found,) = (r for r in pair.rows if r["signal"] == "clutches")
    assert float(tracking["ratio"]) == pytest.approx(found["value"], rel=0.05)
    assert tracking["worse"] is (found["value"] > 1)
    assert ("friction energy", "clutch 1") in rows
    table = benefit.overview([pair, pair])
    assert [h["title"] for h in table["heads"]] == ["Torque tracking, friction case 1"] * 2
    line = next(x for x in table["lines"] if x["title"] == tracking["title"]
                and x["of"] == "both clutches")  # fmt: skip
    assert line["cells"] == [tracking, tracking]


def learning(signals: dict[str, np.ndarray]) -> None:
    """Add an inertia error that is learnt in 2 s, and an anchor, whose deviation is 0."""
    fading = np.exp(-signals["time"] / 2)
    signals["observer.calibration.inertiaError"] = -0.2 * (1 - fading)
    signals["observer.calibration.inertiaErrorDeviation"] = 0.3 * fading + 0.004
    signals["observer.calibration.dampingError"] = 0 * fading
    signals["observer.calibration.dampingErrorDeviation"] = 0 * fading


def test_what_is_learnt_is_drawn_with_its_band_and_what_there_is_to_learn(tmp_path: Path) -> None:
    (view,) = runs.load([write_run(tmp_path / "run", "x", "A", learning=True)])
    (figure,) = calibration.drawn(view)
    (panel,) = figure["panels"]
    assert panel["title"] == "δ [%]"
    assert panel["heading"] == (
        "engine-side inertia δ: −20.00 ± 0.40 % at the end, ± 30 at first"
    )  # fmt: skip
    assert [t["role"] for t in panel["traces"]] == ["band", "band", "truth", "observer"]
    assert calibration.injected(view, "observer", "inertiaError") == pytest.approx(-0.2)
    assert calibration.injected(view, "observer", "torqueScale") is None


def test_a_torque_that_is_misread_is_what_there_is_to_learn(tmp_path: Path) -> None:
    """Read 5 % and 2 N.m too high: divided by 1.05, after 2 N.m are taken away."""
    (view,) = runs.load([write_run(tmp_path / "run", "x", "A", learning=True)])
    entry = {"from": "scenario.engine.torque", "to": "observer.engine.torque"}
    view.run["system"]["connections"] = [{**entry, "factor": 1.05, "offset": 2.0}]
    alpha, beta = (calibration.injected(view, "observer", f"torque{k}") for k in ("Scale", "Bias"))
    assert (1 + alpha) * (1.05 * 80.0 + 2.0) + beta == pytest.approx(80.0)


def test_everything_that_the_observer_learns_has_a_panel() -> None:
    text = (ROOT / "modelDescription/DctObserver.xml").read_text(encoding="utf-8")
    learnt = set(re.findall(r'name="calibration\.(\w+)Deviation"', text))
    assert learnt == {key for key, *_ in calibration.LEARNT}


@pytest.mark.parametrize(("deviation", "places"), [(0.4, 2), (12.0, 0), (0.016, 3), (0.0, 0)])
def test_two_digits_of_a_deviation_are_shown(deviation: float, places: int) -> None:
    assert calibration.decimals(deviation) == places


def test_methods_stand_side_by_side(tmp_path: Path) -> None:
    """Errors are half and twice the observer's, so its figures are the ones in the middle."""
    (view,) = runs.load([write_run(tmp_path / "run", "paper_case1", "A", methods=True)])
    table = methods.table(view)
    by_name = {row["name"]: row["cells"] for row in table["rows"]}
    assert list(by_name) == ["paper", "kalman", "mine", "non-adaptive", "map-based"]
    first = {name: float(row[0]["text"]) for name, row in by_name.items()}
    assert first["kalman"] == pytest.approx(first["paper"] / 2, rel=0.01)
    assert first["mine"] == pytest.approx(first["paper"] * 2, rel=0.01)
    assert [c["best"] for c in by_name["kalman"]] == [True, True, True, False] * 3
    torque, error, coefficient = methods.drawn(view)
    named = [t["name"] for t in torque["panels"][2]["traces"] if t["role"] != "event"]
    assert named == ["true (plant)", "map-based", "non-adaptive", "paper", "kalman", "mine"]
    assert [t["name"] for t in error["panels"][0]["traces"]] == ["paper", "kalman", "mine"]
    assert "three methods" in error["caption"]
    roles = [t["role"] for t in coefficient["panels"][0]["traces"]]
    assert roles == ["truth", "map", "observer", "method4", "method2"]
