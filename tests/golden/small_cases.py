"""The small cases: one clutch behaviour each, 1-4 s, parameters of the preset `paper`."""

from __future__ import annotations

from golden_cases import Case, mm
from scenarios import Scenario


def _scenario(torque, clutch1=((0, 0),), clutch2=((0, 0),), grade=((0, 0),), brake=((0, 0),)):
    """Scenario from knots (t [s], value): torques [N·m], positions [mm], grade [rad]."""
    return Scenario.from_signals(
        {
            "engine.torque": torque,
            "clutch1.position": mm(*clutch1),
            "clutch2.position": mm(*clutch2),
            "road.grade": grade,
            "brake.torque": brake,
        }
    )


TIE_UP = _scenario(
    [(0, 5), (1.4, 5), (1.6, 60), (2.4, 60)],
    [(0, 9), (2.4, 9)],
    [(0, 0), (0.2, 2.2), (0.4, 9), (1.7, 9), (1.9, 0), (2.4, 0)],
    [(0, 0.02), (2.4, 0.02)],
)
BREAK_AWAY = _scenario([(0, 110), (2, 110)], [(0, 8), (0.3, 8), (0.6, 4.4), (0.9, 4.4), (1.2, 7)])
OVERRUN = _scenario([(0, -20), (2, -20)], clutch2=[(0, 0), (0.2, 2.2), (0.8, 7), (2, 7)])
REVERSAL = _scenario([(0, 150), (0.5, 150), (0.6, 20), (2, 20)], [(0, 4.2), (1, 4.2), (1.4, 8)])
THROUGH_ZERO = _scenario(  # clutch 2 lets go at once; the wound damper throws slip 1 across zero
    [(0, 75), (0.25, 75), (0.4, 20), (1.5, 20)],
    [(0, 3.4), (0.6, 3.4), (1.2, 8)],
    [(0, 6.5), (0.2, 6.5), (0.2005, 0), (1.5, 0)],
)
COAST = _scenario([(0, 0), (3, 0)], grade=[(0, 0.06), (3, 0.06)])
HILL = _scenario(
    [(0, 0), (0.6, 5), (1, 60), (3.5, 60)],
    [(0, 0), (0.5, 1.8), (1.4, 6.5), (3.5, 6.5)],
    grade=[(0, 0.1), (3.5, 0.1)],
)
HOLD = (
    _scenario(  # the brake lets the vehicle roll back, stops it, holds it and hands it to clutch 1
        [(0, 5), (1.4, 5), (1.8, 70), (4, 70)],
        [(0, 0), (1.2, 1.8), (2.2, 6.5), (4, 6.5)],
        grade=[(0, 0.1), (4, 0.1)],
        brake=[
            (0, 600),
            (0.4, 600),
            (0.6, 300),
            (0.8, 300),
            (0.9, 1200),
            (1.6, 1200),
            (2.2, 0),
            (4, 0),
        ],
    )
)
STOP = _scenario(  # braked to a stop; dry rolling resistance alone holds until the road tilts
    [(0, 0), (3, 0)],
    grade=[(0, 0.008), (2.2, 0.008), (2.8, -0.02), (3, -0.02)],
    brake=[(0, 0), (0.1, 0), (0.4, 900), (1.4, 900), (1.8, 0), (3, 0)],
)
BOTH = _scenario(
    [(0, 10), (0.6, 90), (2.5, 90)],
    [(0, 0), (0.2, 2), (0.9, 6), (2.5, 6.4)],
    [(0, 0), (0.2, 2.2), (0.8, 5), (1.4, 5), (1.7, 1), (2.5, 0)],
)
LAUNCH = _scenario([(0, 20), (0.4, 70), (2, 70)], [(0, 0), (0.1, 2), (0.5, 6.4), (2, 6.4)])

TIP_OUT = (
    _scenario(  # launch on both clutches, then the vehicle drives the engine, then it pulls again
        [(0, 10), (0.6, 90), (1.8, 90), (1.9, -50), (2.4, -50), (2.5, 60), (2.8, 60)],
        [(0, 0), (0.2, 2), (0.9, 6), (1.6, 6.4), (1.8, 8), (2.8, 8)],
        [(0, 0), (0.2, 2.2), (0.8, 5), (1.2, 5), (1.5, 1), (2.8, 0)],
    )
)
SHIFTS = _scenario(  # 1-2-3; reverse is preselected while driving, and its clutch pressed too early
    [(0, 60), (0.5, 60), (1.2, 45), (2, 30), (2.8, 20)],
    [(0, 9), (0.35, 9), (0.6, 4.5), (0.75, 0), (1.2, 0), (1.35, 3.4), (1.7, 6.4), (2, 9), (2.8, 9)],
    [
        *((0, 0), (0.32, 0), (0.45, 3.6), (0.9, 6.6), (1.15, 9), (1.3, 9), (1.55, 3.5)),
        *((1.7, 0), (1.95, 0), (1.955, 3.2), (2.05, 3.2), (2.06, 0), (2.8, 0)),
    ],
)
UPSHIFT = _scenario(  # gear 1 drives, gear 2 is synchronised, the clutches hand over under torque
    [(0, 60), (0.5, 60), (0.7, -20), (1.1, -20), (1.3, 60), (1.5, 60)],
    [(0, 9), (0.3, 9), (0.45, 5), (0.65, 2.2), (0.7, 0), (1.5, 0)],
    [(0, 0), (0.3, 0), (0.35, 2.2), (0.62, 5.2), (0.8, 8), (1.2, 9), (1.5, 9)],
)
REVERSE = _scenario(
    [(0, 20), (0.4, 70), (1.6, 70), (1.8, 0), (2.6, 0)],
    clutch2=[(0, 0), (0.1, 2.2), (0.7, 6.4), (1.2, 9), (1.6, 9), (1.8, 0), (2.6, 0)],
    brake=[(0, 0), (1.9, 0), (2.1, 500), (2.6, 500)],
)
GEARBOX = {"odd_gears": (3.0, 1.35, 0.78), "even_gears": (2.4, 1.25, 0.8), "i_r": (0.0, 2.6)}
LOSSES = {
    **{"odd_eta": (0.96, 0.97, 0.98, 1.0), "even_eta": (0.965, 0.975, 0.985, 1.0)},
    "eta_r": (1.0, 0.95),
}
ROLL_BACK = {"odd_eta": (0.9, 1.0, 1.0, 1.0), "even_eta": (0.95, 1.0, 1.0, 1.0)}
_LAUNCH = {"stop": 2.0, "engine_speed": 110.0, "scenario_file": "launch"}
RISING = ((0.0, 5.0, 20.0, 60.0, 150.0), (0.9, 0.95, 1.0, 1.0, 0.8))  # wet, then it fades
FALLING = ((0.0, 4.0, 15.0, 40.0, 160.0), (1.12, 1.0, 0.95, 0.97, 0.75))  # Stribeck, then it fades
_FADE = {
    **{"stop": 2.5, "engine_speed": 95.0, "scenario_file": "launch_both"},
    "params": {"curves": (RISING, FALLING)},
}
THETA = {"temperature": (300.0, 400.0, 500.0, 600.0), "factor": (1.0, 0.9, 0.7, 0.5)}
HOT = (  # linings so light that one launch takes a third of their friction
    {"capacity": 60.0, "conductance": 20.0, "ambient": 300.0, "start": 350.0, **THETA},
    {"capacity": 40.0, "conductance": 5.0, "ambient": 300.0, "start": 300.0, **THETA},
)
_HOT = {
    **{"stop": 3.2, "engine_speed": 95.0, "scenario_file": "launch_both"},
    "params": {"curves": (RISING, FALLING), "heat": HOT},
}


def _rigid(name, scenario, *start):
    """A case with rigid transfer shafts, on the inputs of the compliant one."""
    return Case(
        *(f"{name}_rigid", scenario, *start),
        **{"rigid": True, "row_every": 5e-3, "scenario_file": name},
        about=f"{name} with rigid transfer shafts",
    )


SMALL_CASES = (
    Case("tie_up", TIE_UP, 2.4, 9.0, 0.15, about="both clutches close at low speed, stop, reopen"),
    Case("tie_up_rigid", TIE_UP, 2.4, 9.0, 0.15, rigid=True, about="tie-up of the rigid plant"),
    Case("break_away", BREAK_AWAY, 2.0, 240.0, 4.0, about="force drops: break-away and re-lock"),
    _rigid("break_away", BREAK_AWAY, 2.0, 240.0, 4.0),
    Case("overrun", OVERRUN, 2.0, 150.0, 5.0, about="clutch 2 closes below speed: torque < 0"),
    _rigid("overrun", OVERRUN, 2.0, 150.0, 5.0),
    Case("slip_reversal", REVERSAL, 2.0, 220.0, 4.0, about="lock, slip the other way, re-lock"),
    Case(
        *("slip_through_zero", THROUGH_ZERO, 1.5, 236.0, 4.0),
        about="slip crosses zero without sticking",
    ),
    Case(
        *("slip_returns_h10", THROUGH_ZERO, 1.5, 234.0, 4.0),
        **{"h": 1e-2, "row_every": 1e-2, "scenario_file": "slip_through_zero"},
        about="held 10 ms: slip crosses zero and returns within one step",
    ),
    Case("coast_grade", COAST, 3.0, 80.0, 0.8, about="open coast through zero speed, uphill"),
    _rigid("coast_grade", COAST, 3.0, 80.0, 0.8),
    Case("hill_start", HILL, 3.5, 130.0, 0.0, about="roll-back on 10 %, then launch"),
    _rigid("hill_start", HILL, 3.5, 130.0, 0.0),
    Case("hill_hold", HOLD, 4.0, 130.0, 0.0, about="hill start from the brake, with a roll-back"),
    _rigid("hill_hold", HOLD, 4.0, 130.0, 0.0),
    Case(
        *("stop_and_hold", STOP, 3.0, 90.0, 1.5),
        **{"params": {"v_eps": 0.0}, "about": "brake to a stop; dry rolling resistance holds"},
    ),
    Case(
        *("gearbox", SHIFTS, 2.8, 180.0, 3.0),
        gears=((0, (1, 0)), (0.1, (1, 2)), (0.9, (3, 2)), (1.9, (3, -1))),
        params=GEARBOX,
        about="1-2-3, synchronised; reverse preselected, its clutch pressed too early",
    ),
    Case(
        *("reverse", REVERSE, 2.6, 110.0, 0.0),
        gears=((0, (1, -1)), (1.0, (0, -1)), (2.0, (1, -1)), (2.3, (3, 2))),
        params=GEARBOX,
        about="launch in reverse; gear 1, then 3 and 2 at once while rolling backwards",
    ),
    Case(
        *("gearbox_losses", SHIFTS, 2.8, 180.0, 3.0),
        gears=((0, (1, 0)), (0.1, (1, 2)), (0.9, (3, 2)), (1.9, (3, -1))),
        **{"params": GEARBOX | LOSSES, "row_every": 5e-3},
        scenario_file="gearbox",
        about="1-2-3 with gears that lose power, driving and driven",
    ),
    Case(
        *("upshift_losses", UPSHIFT, 1.5, 180.0, 3.0),
        gears=((0, (1, 0)), (0.1, (1, 2)), (0.8, (3, 2))),
        **{"params": GEARBOX | LOSSES, "row_every": 2e-3},
        about="gear 2 is synchronised, the clutches hand over, gear 3 follows; gears lose power",
    ),
    Case(
        *("reverse_losses", REVERSE, 2.6, 110.0, 0.0),
        gears=((0, (1, -1)), (1.0, (0, -1)), (2.0, (1, -1)), (2.3, (3, 2))),
        **{"params": GEARBOX | LOSSES, "row_every": 5e-3},
        scenario_file="reverse",
        about="launch in reverse with gears that lose power",
    ),
    Case(
        *("hill_losses", HILL, 3.5, 130.0, 0.0),
        **{"params": ROLL_BACK, "row_every": 5e-3},
        scenario_file="hill_start",
        about="roll-back on 10 %, a stop in jammed gears, then launch; gears lose 10 and 5 %",
    ),
    Case(
        *("gears_rigid", BOTH, 2.5, 120.0, 0.0),
        **{"gears": ((0, (3, -1)),), "params": GEARBOX, "rigid": True, "row_every": 5e-3},
        scenario_file="launch_both",
        about="rigid plant in gear 3, reverse on the other clutch: they pull against each other",
    ),
    Case(
        *("losses_rigid", TIP_OUT, 2.8, 120.0, 0.0),
        **{"params": ROLL_BACK, "rigid": True, "row_every": 5e-3},
        about="rigid plant, gears lose 10 and 5 %: launch on both clutches, tip-out and tip-in",
    ),
    Case(
        *("hill_rigid_losses", HILL, 3.5, 130.0, 0.0),
        **{"params": ROLL_BACK, "rigid": True, "row_every": 5e-3},
        scenario_file="hill_start",
        about="hill_losses with rigid shafts: a roll-back that stops in jammed gears",
    ),
    Case("launch_both", BOTH, 2.5, 120.0, 0.0, about="launch on both clutches"),
    _rigid("launch_both", BOTH, 2.5, 120.0, 0.0),
    Case("launch_h10", LAUNCH, **_LAUNCH, h=1e-2, row_every=1e-2, about="launch, held 10 ms"),
    Case("launch_h1", LAUNCH, **_LAUNCH, about="launch, held 1 ms"),
    Case("launch_h01", LAUNCH, **_LAUNCH, h=1e-4, about="launch, held 0.1 ms"),
    *(
        Case(
            *(f"launch_rigid_{name}", LAUNCH),
            **_LAUNCH | {"h": h, "row_every": 1e-2, "rigid": True},
            about=f"launch, rigid plant, held {h * 1e3:g} ms",
        )
        for name, h in (("h10", 1e-2), ("h1", 1e-3), ("h01", 1e-4))
    ),
    Case("launch_continuous", LAUNCH, **_LAUNCH, h=None, about="launch, knots as they are"),
    Case("fade_h10", BOTH, **_FADE, h=1e-2, row_every=1e-2, about="friction over slip, held 10 ms"),
    Case("fade_h1", BOTH, **_FADE, about="friction over slip, held 1 ms"),
    Case("fade_h01", BOTH, **_FADE, h=1e-4, about="friction over slip, held 0.1 ms"),
    Case("fade_rigid", BOTH, **_FADE, rigid=True, about="friction over slip, rigid plant"),
    Case("hot_h10", BOTH, **_HOT, h=1e-2, row_every=1e-2, about="fade by heat, held 10 ms"),
    Case("hot_h1", BOTH, **_HOT, row_every=1e-2, about="fade by heat and slip, held 1 ms"),
    Case("hot_h01", BOTH, **_HOT, h=1e-4, row_every=1e-2, about="fade by heat, held 0.1 ms"),
    Case(
        *("stribeck", BREAK_AWAY, 2.0, 240.0, 4.0),
        **{"scenario_file": "break_away", "params": {"curves": (FALLING, None)}},
        about="friction falls with slip: break-away and re-lock",
    ),
    *(
        Case(
            *(name, BREAK_AWAY, 1.0004, 240.0, 4.0),
            **{"h": 3e-3, "row_every": 3e-3, "scenario_file": "break_away", "rigid": rigid},
            about=f"held 3 ms, the last step is 1.4 ms{', rigid plant' * rigid}",
        )
        for name, rigid in (("last_step", False), ("last_step_rigid", True))
    ),
)
