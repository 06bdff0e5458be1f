"""Write the golden CSV, events and energy files of this directory. `--help` shows the options."""

from __future__ import annotations

import argparse
import csv
import json
from pathlib import Path

import numpy as np
from golden_cases import PAPER_CASES
from small_cases import SMALL_CASES
from tqdm import tqdm

CASES = (*PAPER_CASES, *SMALL_CASES)
HERE = Path(__file__).parent
FMI_NAMES = {
    "v_eps": ["vehicle.rollingResistanceSpeed"],
    "odd_gears": [f"shaft1.gearRatio[{k}]" for k in range(1, 5)],
    "even_gears": [f"shaft2.gearRatio[{k}]" for k in range(1, 5)],
    "i_r": ["shaft1.reverseRatio", "shaft2.reverseRatio"],
    "odd_eta": [f"shaft1.gearEfficiency[{k}]" for k in range(1, 5)],
    "even_eta": [f"shaft2.gearEfficiency[{k}]" for k in range(1, 5)],
    "eta_r": ["shaft1.reverseEfficiency", "shaft2.reverseEfficiency"],
    "t_s": ["shaft1.synchroniserTorque", "shaft2.synchroniserTorque"],
}
HEADER = (
    *("time", "engine.speed", "damper.speed", "clutch1.speed", "clutch2.speed", "output.speed"),
    *("wheel.speed", "damper.torque", "clutch1.torque", "clutch2.torque", "driveShaft.torque"),
    *("load.torque", "clutch1.state", "clutch2.state", "wheel.held"),
    *("clutch1.temperature", "clutch2.temperature"),
)
STATES = slice(12, 15)  # columns of integers


def run_case(case, longest=None, stages=None):
    """Run one `Case`; returns its finished `Simulation`."""
    simulation = case.simulation(stages)
    options = {} if longest is None else {"longest": longest}
    pieces = case.pieces(simulation.plant.p, **options)
    total = round(case.stop / min(case.h or 1e-3, longest or 1e-3))
    return simulation.run(tqdm(pieces, desc=case.name, total=total, mininterval=2))


def format_row(row):
    """Text fields of one row: time and values with 14 digits, states as integers."""
    fields = [f"{float(x):.14g}" for x in row]
    fields[STATES] = [str(int(x)) for x in row[STATES]]
    return fields


def write_rows(path, rows, brakes):
    """Write a golden CSV, columns of `HEADER`: those of rows, wheel.held only if braked or hot."""
    count = len(rows[0]) - (not brakes and len(rows[0]) == STATES.stop)
    with path.open("w", newline="") as file:
        out = csv.writer(file, lineterminator="\n")
        out.writerow(HEADER[:count])
        out.writerows(format_row(row)[:count] for row in rows)


def write_json(path, value):
    """Write `value` as indented JSON."""
    path.write_text(json.dumps(value, indent=1) + "\n")


def curve_json(curves):
    """FMI parameters of the friction curves of both clutches."""
    return {
        f"clutch{i + 1}.frictionCurve.{name}[{k + 1}]": value
        for i, curve in enumerate(curves)
        for name, values in zip(("slip", "factor"), curve or (), strict=False)
        for k, value in enumerate(values)
    }


def heat_json(heat):
    """FMI parameters of the thermal nodes of both clutches."""
    out = {}
    for i, node in enumerate(heat):
        clutch = f"clutch{i + 1}"
        out[f"{clutch}.temperature_start"] = node["start"]
        for name in ("capacity", "conductance", "ambient"):
            out[f"{clutch}.thermal.{name}"] = node[name]
        for name in ("temperature", "factor"):
            points = enumerate(node[name], start=1)
            out |= {f"{clutch}.thermal.{name}[{k}]": value for k, value in points}
    return out


def in_order(events):
    """Events by time; at one instant clutches, brake, synchronisers, output."""
    parts = (1, 2, "brake", "synchroniser 1", "synchroniser 2", "output")
    return sorted(events, key=lambda event: (event["time"], parts.index(event["clutch"])))


def case_json(case, params):
    """What a run needs beside its scenario, and the FMI parameters that leave the preset."""
    changed = {"transmission.rigid": True} if case.rigid else {}
    special = {"curves": curve_json, "heat": heat_json}
    for name, value in case.params.items():
        if name in special:
            changed |= special[name](value)
        else:
            changed |= zip(FMI_NAMES.get(name, ()), np.atleast_1d(value).tolist(), strict=False)
    odd, even = case.gears[0][1]
    shifts = [{"time": t, "shaft1": a, "shaft2": b} for t, (a, b) in case.gears[1:]]
    return {
        "about": case.about,
        "preset": "paper",
        "parameters": changed,
        "start": {
            "engine.speed_start": case.engine_speed,
            "vehicle.speed_start": case.vehicle_speed,
        },
        "gears": {"shaft1.gear": odd, "shaft2.gear": even},
        **({"shifts": shifts} if shifts else {}),
        "ratios": {f"shaft{i + 1}": params.ratio[i] for i in range(2)},
        "stop": case.stop,
        "inputs": "continuous" if case.h is None else "held",
        "h": case.h,
        "row_every": case.row_every,
        "scenario": f"{case.scenario_file or case.name}.scenario.csv",
    }


def write_case(case, out):
    """Run one case and write its five files into `out`."""
    simulation = run_case(case)
    write_rows(out / f"{case.name}.csv", simulation.rows, case.scenario.brakes)
    write_json(out / f"{case.name}.events.json", in_order(simulation.events))
    write_json(out / f"{case.name}.energy.json", simulation.energy())
    write_json(out / f"{case.name}.json", case_json(case, case.simulation().plant.p))
    case.scenario.write(out / f"{case.scenario_file or case.name}.scenario.csv")
    return simulation


def main():
    """Command line."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("case", nargs="*", help="case names; all of them when none is given")
    parser.add_argument("--out", type=Path, default=HERE, help="directory to write into")
    parser.add_argument("--list", action="store_true", help="list the cases and stop")
    args = parser.parse_args()
    known = {case.name: case for case in CASES}
    if args.list:
        print("\n".join(f"{case.name:24} {case.about}" for case in CASES))
        return
    if unknown := set(args.case) - set(known):
        parser.error(f"no such case: {', '.join(sorted(unknown))}")
    args.out.mkdir(parents=True, exist_ok=True)
    for name in args.case or known:
        simulation = write_case(known[name], args.out)
        balance = simulation.energy()
        print(f"{name}: {len(simulation.events)} events, energy residual", end=" ")
        print(f"{balance['residual'] / balance['turnover']:.1e} of the turnover")


if __name__ == "__main__":
    main()
