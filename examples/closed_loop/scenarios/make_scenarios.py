"""Write positions.csv, torque_tracking.csv and friction_fade.csv (the paper's Fig. 9, scripted).

Run `python make_scenarios.py`; it needs numpy only. The knots below are the one source of all.
"""

from __future__ import annotations

from pathlib import Path

import numpy as np

ENGINE_TORQUE = """(0,0)(1,0)(1.6,60)(4,60)(4.3,66)(9.3,66)(9.5,-10)(10.1,-10)(10.6,62)(13,62)
(13.4,28)(16,28)(16.3,120)(17.65,120)(17.95,30)(18.8,26)(21.8,20)(22.1,-50)(23.8,-50)(24.2,50)
(26,50)(26.4,-20)(28.4,-20)(28.8,0)(30,0)"""  # s, N.m
POSITIONS_MM = (
    """(0,0)(.8,1.8)(1,2.2)(1.8,6.2)(2.6,6.2)(3.2,9)(8.6,9)(8.9,6.6)(9.3,5)(9.55,1.5)(9.7,0)
    (16.6,0)(17,2)(17.5,2.5)(17.75,3.4)(18,6)(18.6,9)(28.2,9)(28.6,4)(28.8,1)(29,0)(30,0)""",
    """(0,0)(8.2,0)(8.6,2.2)(8.9,3)(9.4,7)(10.6,7)(11.1,9)(15.7,9)(16.1,5.8)(17.4,5.6)
    (17.75,3.6)(18,1)(18.1,0)(30,0)""",
)  # s, mm; clutch 1 and 2
ROAD_GRADE = "(0,0)(2,0)(4,.05)(19.5,.05)(21.5,-.04)(24,-.04)(25,0)(30,0)"  # s, rad
# Preset `paper`: force-position map (mm, N), kinetic friction, effective radius r_c N [m].
MAPS = (
    "(0,0)(2,0)(3,250)(4,700)(5,1350)(6,2200)(7,3300)(8,4700)(9,6400)(10,8500)",
    "(0,0)(2.2,0)(3,220)(4,680)(5,1330)(6,2200)(7,3350)(8,4800)(9,6600)(10,8800)",
)
KINETIC_FRICTION = (0.26, 0.22)
EFFECTIVE_RADIUS = 0.095
# Linings that fade while they slip, and recover: clutch 1 in the launch, clutch 2 in both shifts.
FADING = (
    "(0,.26)(1.2,.26)(2.2,.2)(4,.2)(8,.26)(30,.26)",
    "(0,.22)(8.9,.22)(9.8,.15)(10.6,.15)(14,.22)(16.3,.22)(17.4,.16)(18.5,.16)(24,.22)(30,.22)",
)  # s, mu_k
SAMPLE = 0.01  # s; the capacity bends with the map between the position's knots

Signal = tuple[str, np.ndarray]


def knots(text: str) -> np.ndarray:
    """Parse `(t,v)(t,v)...` into shape (n, 2)."""
    pairs = text.replace("\n", "").replace(" ", "").strip("()").split(")(")
    return np.array([[float(cell) for cell in pair.split(",")] for pair in pairs])


def at(text: str, x: np.ndarray) -> np.ndarray:
    """Evaluate a polyline at `x`, constant outside."""
    table = knots(text)
    return np.interp(x, table[:, 0], table[:, 1])


def capacity(clutch: int, time: np.ndarray) -> np.ndarray:
    """Torque capacity mu_k F_map(theta) r_c N [N.m] of the scripted position; 0 when open."""
    force = at(MAPS[clutch], at(POSITIONS_MM[clutch], time))
    return KINETIC_FRICTION[clutch] * force * EFFECTIVE_RADIUS


def write(name: str, time: np.ndarray, clutch_signals: list[Signal]) -> None:
    """Write one scenario: the shared signals and those of the clutches."""
    signals = [
        ("time", time),
        ("engine.torque", at(ENGINE_TORQUE, time)),
        ("road.grade", at(ROAD_GRADE, time)),
        ("brake.torque", np.zeros_like(time)),
        ("shaft1.gear", np.full_like(time, 1)),
        ("shaft2.gear", np.full_like(time, 2)),
        ("clutch1.pressure", np.zeros_like(time)),
        ("clutch2.pressure", np.zeros_like(time)),
        *clutch_signals,
    ]
    lines = [",".join(name for name, _ in signals)]
    lines += [
        ",".join(f"{v:.10g}" for v in row) for row in zip(*(v for _, v in signals), strict=True)
    ]
    (Path(__file__).parent / name).write_text("\n".join(lines) + "\n", newline="\n")


def main() -> None:
    """Write both scenarios."""
    polylines = (ENGINE_TORQUE, ROAD_GRADE, *POSITIONS_MM)
    bends = np.unique(np.concatenate([knots(text)[:, 0] for text in polylines]))
    positions = [(f"clutch{k + 1}.position", at(POSITIONS_MM[k], bends) / 1000) for k in (0, 1)]
    write("positions.csv", bends, positions)
    grid = np.arange(round(bends[-1] / SAMPLE) + 1) * SAMPLE
    fine = np.unique(np.round(np.concatenate([bends, grid]), 9))
    requests = [(f"clutch{k + 1}.torqueRequest", capacity(k, fine)) for k in (0, 1)]
    write("torque_tracking.csv", fine, requests)
    faded = [(f"clutch{k + 1}.kineticFriction", at(FADING[k], fine)) for k in (0, 1)]
    write("friction_fade.csv", fine, requests + faded)


if __name__ == "__main__":
    main()
