"""What every importer is given to run, and fmpy's answer to it.

The communication step is 2^-9 s: a whole number of nanoseconds and of bits, so importers that
count time in integers, sums or differences all make the same steps and must get the same bits.
"""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager
from functools import cache
from pathlib import Path

from fmu_instance import Instance

ROOT = Path(__file__).resolve().parent.parent
FMUS = ROOT / "target" / "fmu"
STEP = 2.0**-9  # s
STEPS = 512  # 1 s: clutch 1 slips, the shaft winds up, the vehicle starts to move
HALF = STEPS // 2  # after it, inputs change

# Start values by model and variable, SI: a launch in first gear with a request of 40 N·m.
STARTS: dict[str, dict[str, float | int | bool]] = {
    "DctPlant": {
        "engine.speed_start": 90.0, "engine.torque": 60.0, "clutch1.position": 0.0062,
        "road.grade": 0.02, "shaft1.gear": 1, "shaft2.gear": 2, "transmission.rigid": False,
    },
    "DctObserver": {
        "engine.torque": 60.0, "engine.speed": 90.0, "clutch1.position": 0.0062,
        "clutch2.speed": 10.0, "wheel.speed": 1.0, "adaptation.enabled": True, "load.method": 1,
    },
    "DctClutchControl": {"clutch1.torqueRequest": 40.0, "feedback.enabled": False},
}  # fmt: skip
# Inputs that change in mid-run.
LATER: dict[str, dict[str, float | int | bool]] = {
    "DctPlant": {"clutch1.position": 0.007, "clutch2.position": 0.004},
    "DctObserver": {"clutch1.position": 0.007, "clutch2.position": 0.004, "wheel.speed": 2.0},
    "DctClutchControl": {
        "clutch1.torqueRequest": 90.0, "clutch2.torqueRequest": 20.0, "feedback.enabled": True,
        "clutch1.friction": 0.25,
    },
}  # fmt: skip
MODELS = tuple(STARTS)


def fmu(model: str) -> Path:
    """Return the FMU of a model as `cargo fmu build` left it."""
    return FMUS / f"{model}.fmu"


@contextmanager
def started(model: str, values: dict[str, float | int | bool]) -> Iterator[Instance]:
    """Give a started instance with start values set; frees it afterwards."""
    with Instance(fmu(model)) as instance:
        for name, value in values.items():
            instance.set(name, value)
        instance.start()
        yield instance


def advance(instance: Instance, first: int, last: int) -> None:
    """Make the steps `first` to `last`, with the inputs of `LATER` from the middle on."""
    for k in range(first, last):
        if k == HALF:
            for name, value in LATER[instance.description.modelName].items():
                instance.set(name, value)
        instance.step(k * STEP, STEP)


@cache
def expected(model: str, steps: int = STEPS) -> dict[str, float]:
    """Return fmpy's outputs of a model alone after so many steps, by name."""
    with started(model, STARTS[model]) as instance:
        advance(instance, 0, steps)
        return instance.outputs()
