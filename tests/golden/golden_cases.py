"""The cases: the paper's scenario (Fig. 9) and the small ones, with their start values."""

from __future__ import annotations

from dataclasses import dataclass, field

from hybrid import Simulation
from meshes import LossySimulation
from reference_plant import Params, Plant
from rigid_meshes import RigidLossySimulation
from scenarios import Scenario, continuous_pieces, held_pieces
from shifts import ShiftingSimulation
from thermal import HeatedSimulation

LONGEST = 1e-3  # [s] longest smooth piece; see README.md for the error this leaves


@dataclass(frozen=True)
class Case:
    """One run: scenario, start values and how the inputs are applied.

    `h` [s] is the communication step of the held inputs, None for the knots as they are. `gears`
    are knots (t [s], (odd, even)) of what is preselected from then on.
    """

    name: str
    scenario: Scenario
    stop: float
    engine_speed: float = 0.0
    vehicle_speed: float = 0.0
    h: float | None = 1e-3
    row_every: float = 1e-3
    rigid: bool = False
    about: str = ""
    scenario_file: str = ""
    params: dict = field(default_factory=dict)
    gears: tuple = ((0.0, (1, 2)),)

    def pieces(self, params, longest=LONGEST):
        """Smooth pieces of the run, an iterator of `Piece`, and how many there are."""
        if self.h is not None:
            return held_pieces(self.stop, self.h, self.row_every, longest)
        kinks = self.scenario.kinks(params, self.stop)
        return continuous_pieces(self.stop, 1e-3, self.row_every, longest, kinks)

    def simulation(self, stages=None):
        """A simulation at its start."""
        params = Params(rigid=self.rigid, **self.params)
        run = self.scenario, self.engine_speed, self.vehicle_speed, stages
        if params.lossy:
            kind = RigidLossySimulation if self.rigid else LossySimulation
            return kind(params, self.gears, *run)
        if len(self.gears) > 1:
            return ShiftingSimulation(params, self.gears, *run)
        kind = Simulation if params.heat is None else HeatedSimulation
        return kind(Plant(params.in_gears(self.gears[0][1])), *run)


def mm(*knots):
    """Knots (t [s], position [mm]) as (t [s], position [m])."""
    return [(t, round(x * 1e-3, 9)) for t, x in knots]


PAPER = Scenario.from_signals(
    {
        "engine.torque": [
            *((0, 0), (1, 0), (1.6, 60), (4, 60), (4.3, 66), (9.3, 66), (9.5, -10), (10.1, -10)),
            *((10.6, 62), (13, 62), (13.4, 28), (16, 28), (16.3, 120), (17.65, 120), (17.95, 30)),
            *((18.8, 26), (21.8, 20), (22.1, -50), (23.8, -50), (24.2, 50), (26, 50)),
            *((26.4, -20), (28.4, -20), (28.8, 0), (30, 0)),
        ],
        "clutch1.position": mm(
            *((0, 0), (0.8, 1.8), (1, 2.2), (1.8, 6.2), (2.6, 6.2), (3.2, 9), (8.6, 9)),
            *((8.9, 6.6), (9.3, 5), (9.55, 1.5), (9.7, 0), (16.6, 0), (17, 2), (17.5, 2.5)),
            *((17.75, 3.4), (18, 6), (18.6, 9), (28.2, 9), (28.6, 4), (28.8, 1), (29, 0), (30, 0)),
        ),
        "clutch2.position": mm(
            *((0, 0), (8.2, 0), (8.6, 2.2), (8.9, 3), (9.4, 7), (10.6, 7), (11.1, 9), (15.7, 9)),
            *((16.1, 5.8), (17.4, 5.6), (17.75, 3.6), (18, 1), (18.1, 0), (30, 0)),
        ),
        "road.grade": [
            *((0, 0), (2, 0), (4, 0.05), (19.5, 0.05), (21.5, -0.04), (24, -0.04)),
            *((25, 0), (30, 0)),
        ],
    }
)

PAPER_START = {"stop": 30.0, "engine_speed": 90.0, "row_every": 1e-2}
PAPER_CASES = [
    Case(
        "paper_compliant",
        PAPER,
        **PAPER_START,
        scenario_file="paper",
        about="Fig. 9, inputs held 1 ms",
    ),
    Case(
        "paper_rigid",
        PAPER,
        **PAPER_START,
        scenario_file="paper",
        rigid=True,
        about="Fig. 9, rigid, held 1 ms",
    ),
    Case(
        "paper_continuous",
        PAPER,
        **PAPER_START,
        scenario_file="paper",
        h=None,
        about="Fig. 9, knots as they are",
    ),
]
