"""A supplier's dual-clutch powertrain for PythonFMU, with units in the names of its variables.

It shares nothing with the rest of this repository: clutches stick by impulses. Each step of
0.2 ms finds the impulse that would stop each slip and cuts it at what the clutch can hold (Moreau's
time stepping with projected Gauss-Seidel); shafts and inertias are implicit Euler.

    inertias: engine, hub, output, wheels; springs: damper (engine-hub), drive shaft (output-wheels)
    input shaft i turns at g_i times the output: no springs inside the gearbox
"""

from __future__ import annotations

import math

from pythonfmu import Fmi2Causality, Fmi2Slave, Fmi2Variability, Integer, Real

STEP = 2e-4  # s, longest internal one
SWEEPS = 30  # of Gauss-Seidel; two clutches converge to rounding in fewer
NEUTRAL = 14  # code of the gear inputs
OPEN, SLIPPING, LOCKED = 0, 1, 2  # codes of the clutch status
RPM, KMPH = math.pi / 30, 1 / 3.6
SPRINGS = ((0, 1), (2, 3))  # the inertias that a spring joins
# Stroke [mm] and force [N] of both clutches.
STROKE = (0.0, 2.0, 4.0, 6.0, 8.0, 10.0)
FORCE = (0.0, 0.0, 760.0, 2400.0, 4900.0, 8600.0)

INPUTS = ("EngTrq_Nm", "BrkTrq_Nm", "RoadGrd_deg", "ClStroke1_mm", "ClStroke2_mm")
GEARS = ("GearOdd", "GearEven")
OUTPUTS = (
    "EngSpd_rpm", "ClHubSpd_rpm", "InShSpd1_rpm", "InShSpd2_rpm", "WhlSpd_rpm", "VehSpd_kmph",
    "DrvShTrq_Nm", "ClTrq1_Nm", "ClTrq2_Nm", "ClFacTmp1_degC", "ClFacTmp2_degC",
)  # fmt: skip
STATES = ("ClSts1", "ClSts2")
PARAMETERS = {
    "EngSpdInit_rpm": 860.0, "EngIner_kgm2": 0.78, "HubIner_kgm2": 0.018, "InShIner1_kgm2": 0.105,
    "InShIner2_kgm2": 0.105, "OutIner_kgm2": 0.06, "WhlVehIner_kgm2": 128.0,
    "DmpStf_Nmprad": 560.0, "DmpDmp_Nmsprad": 1.6, "DrvShStf_Nmprad": 4600.0,
    "DrvShDmp_Nmsprad": 520.0, "VehMass_kg": 1520.0, "WhlRad_mm": 295.0, "AirDrgArea_m2": 0.68,
    "RollRes_pct": 1.25, "ClFric1": 0.27, "ClFric2": 0.21, "ClStick_pct": 115.0,
    "ClLever_mm": 96.0, "OilTmp_degC": 60.0,
    **{f"GearRat{k}": r for k, r in enumerate((17.6, 11.1, 7.4, 5.3, 4.1, 3.3), 1)},
}  # fmt: skip


class Powertrain(Fmi2Slave):
    """The plant: mapped variables are attributes of the same name."""

    author = "a supplier"
    description = "Dual-clutch powertrain with impulse clutches"

    def __init__(self, **kwargs: object) -> None:
        super().__init__(**kwargs)
        self.modelName = "Powertrain"
        for name, value in PARAMETERS.items():
            self._add(Real, name, value, Fmi2Causality.parameter, Fmi2Variability.fixed)
        for name in INPUTS:
            self._add(Real, name, 0.0, Fmi2Causality.input)
        for name, gear in zip(GEARS, (1, 2), strict=True):
            self._add(Integer, name, gear, Fmi2Causality.input, Fmi2Variability.discrete)
        for name in OUTPUTS:
            self._add(Real, name, 0.0, Fmi2Causality.output)
        for name in STATES:
            self._add(Integer, name, OPEN, Fmi2Causality.output, Fmi2Variability.discrete)
        self.speed, self.twist, self.heat = [0.0] * 4, [0.0] * 2, [0.0] * 2
        self.impulse, self.factors = [0.0] * 2, {}

    def _add(self, kind: type, name: str, start: float, causality: Fmi2Causality,
             variability: Fmi2Variability | None = None) -> None:  # fmt: skip
        setattr(self, name, start)
        more = {} if causality == Fmi2Causality.output else {"start": start}
        self.register_variable(kind(name, causality=causality, variability=variability, **more))

    def exit_initialization_mode(self) -> None:
        """Start with engine and hub at the initial engine speed."""
        self.speed[0] = self.speed[1] = self.EngSpdInit_rpm * RPM
        self._show(1.0)

    def do_step(self, current_time: float, step_size: float) -> bool:
        """Advance in equal internal steps."""
        count = math.ceil(step_size / STEP - 1e-9)
        for _ in range(count):
            self._advance(step_size / count)
        self._show(step_size / count)
        return all(map(math.isfinite, self.speed))

    def _ratios(self) -> list[float]:
        gears = (self.GearOdd, self.GearEven)
        return [0.0 if g == NEUTRAL else getattr(self, f"GearRat{g}") for g in gears]

    def _advance(self, h: float) -> None:
        ratios = self._ratios()
        mass, inverse = self._system(h, *ratios)
        k = (self.DmpStf_Nmprad, self.DrvShStf_Nmprad)
        push = [m * v for m, v in zip(mass, self.speed, strict=True)]
        push[0] += h * self.EngTrq_Nm
        push[3] -= h * self._load()
        for spring, (a, b) in enumerate(SPRINGS):
            push[a] -= h * k[spring] * self.twist[spring]
            push[b] += h * k[spring] * self.twist[spring]
        free = [sum(row[j] * push[j] for j in range(4)) for row in inverse]
        self._stick(h, ratios, inverse, free)
        self.speed = free
        for spring, (a, b) in enumerate(SPRINGS):
            self.twist[spring] += h * (free[a] - free[b])

    def _system(self, h: float, *ratios: float) -> tuple[list[float], list[list[float]]]:
        """Return the inertias and the inverse of inertia + h damping + h^2 stiffness."""
        key = (h, *ratios)
        if key not in self.factors:
            shafts = (self.InShIner1_kgm2, self.InShIner2_kgm2)
            output = self.OutIner_kgm2 + sum(j * g * g for j, g in zip(shafts, ratios, strict=True))
            mass = [self.EngIner_kgm2, self.HubIner_kgm2, output, self.WhlVehIner_kgm2]
            matrix = [[mass[i] * (i == j) for j in range(4)] for i in range(4)]
            k, d = (self.DmpStf_Nmprad, self.DrvShStf_Nmprad), (self.DmpDmp_Nmsprad,
                                                                self.DrvShDmp_Nmsprad)  # fmt: skip
            for spring, (a, b) in enumerate(SPRINGS):
                both = h * (d[spring] + h * k[spring])
                for i, j, sign in ((a, a, 1), (b, b, 1), (a, b, -1), (b, a, -1)):
                    matrix[i][j] += sign * both
            self.factors[key] = mass, inverted(matrix)
        return self.factors[key]

    def _load(self) -> float:
        """Return the torque of road, air and brake at the wheels [N.m]."""
        radius, grade = self.WhlRad_mm * 1e-3, math.radians(self.RoadGrd_deg)
        v = radius * self.speed[3]
        rolling = self.RollRes_pct * 1e-2 * math.cos(grade) * math.tanh(v / 0.1)
        weight = self.VehMass_kg * 9.81 * (math.sin(grade) + rolling)
        return radius * (weight + 0.6 * self.AirDrgArea_m2 * v * abs(v)) + (
            self.BrkTrq_Nm * math.tanh(self.speed[3] / 0.1)
        )

    def _capacity(self, clutch: int) -> float:
        """Return the sliding torque of a clutch [N.m]."""
        stroke, friction = ((self.ClStroke1_mm, self.ClFric1), (self.ClStroke2_mm, self.ClFric2))[
            clutch
        ]
        return friction * force(stroke) * self.ClLever_mm * 1e-3

    def _stick(self, h: float, ratios: list[float], inverse: list[list[float]],
               speed: list[float]) -> None:  # fmt: skip
        """Add the clutches' impulses to `speed`: no slip left, or all that the clutch holds."""
        bound = [h * self._capacity(c) for c in range(2)]
        hold = [b * (self.ClStick_pct / 100 if s == LOCKED else 1)
                for b, s in zip(bound, (self.ClSts1, self.ClSts2), strict=True)]  # fmt: skip
        columns = [[row[2] * g - row[1] for row in inverse] for g in ratios]
        self.impulse = [0.0, 0.0]
        for _ in range(SWEEPS):
            worst = 0.0
            for c, g in enumerate(ratios):
                slip = speed[1] - g * speed[2]
                ease = g * columns[c][2] - columns[c][1]
                old = self.impulse[c]
                wanted = old + slip / ease
                new = wanted if abs(wanted) <= hold[c] else math.copysign(bound[c], wanted)
                self.impulse[c] = new
                worst = max(worst, abs(new - old))
                for j in range(4):
                    speed[j] += (new - old) * columns[c][j]
            if worst <= 1e-12:
                break
        for c, g in enumerate(ratios):
            slip = speed[1] - g * speed[2]
            self.heat[c] += abs(self.impulse[c] * slip)
            status = OPEN if bound[c] == 0 else LOCKED if abs(slip) < 1e-6 else SLIPPING
            setattr(self, STATES[c], status)

    def _show(self, h: float) -> None:
        """Set the outputs in the units of their names."""
        engine, hub, output, wheels = self.speed
        ratios = self._ratios()
        self.EngSpd_rpm, self.ClHubSpd_rpm = engine / RPM, hub / RPM
        self.InShSpd1_rpm, self.InShSpd2_rpm = (g * output / RPM for g in ratios)
        self.WhlSpd_rpm = wheels / RPM
        self.VehSpd_kmph = wheels * self.WhlRad_mm * 1e-3 / KMPH
        self.DrvShTrq_Nm = self.DrvShStf_Nmprad * self.twist[1] + self.DrvShDmp_Nmsprad * (
            output - wheels
        )
        self.ClTrq1_Nm, self.ClTrq2_Nm = (i / h for i in self.impulse)
        self.ClFacTmp1_degC, self.ClFacTmp2_degC = (self.OilTmp_degC + q / 3900 for q in self.heat)


def force(stroke: float) -> float:
    """Return the force [N] of a stroke [mm]."""
    for k in range(1, len(STROKE)):
        if stroke <= STROKE[k]:
            share = (stroke - STROKE[k - 1]) / (STROKE[k] - STROKE[k - 1])
            return FORCE[k - 1] + max(share, 0.0) * (FORCE[k] - FORCE[k - 1])
    return FORCE[-1]


def inverted(matrix: list[list[float]]) -> list[list[float]]:
    """Return the inverse of a symmetric positive definite matrix by Gauss-Jordan."""
    n = len(matrix)
    rows = [[*row, *(float(i == j) for j in range(n))] for i, row in enumerate(matrix)]
    for k in range(n):
        pivot = rows[k][k]
        rows[k] = [value / pivot for value in rows[k]]
        for i in range(n):
            if i != k:
                factor = rows[i][k]
                rows[i] = [a - factor * b for a, b in zip(rows[i], rows[k], strict=True)]
    return [row[n:] for row in rows]
