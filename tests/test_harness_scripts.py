"""The scripts in examples/ that repeat numbers of the plant agree with it."""

from __future__ import annotations

import importlib.util
import shutil
import xml.etree.ElementTree as ElementTree
from pathlib import Path
from types import ModuleType

import pytest

SCENARIOS = Path("examples/closed_loop/scenarios")


def script(path: Path) -> ModuleType:
    """Return a Python file as a module."""
    spec = importlib.util.spec_from_file_location("make_scenarios", path)
    module = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(module)
    return module


@pytest.fixture(scope="module")
def starts(repo_root: Path) -> dict[str, float]:
    """Start values of the plant's reals by name, SI."""
    root = ElementTree.parse(repo_root / "modelDescription/DctPlant.xml").getroot()
    return {v.get("name"): float(v[0].get("start")) for v in root.iter("ScalarVariable")
            if v[0].tag == "Real" and v[0].get("start") is not None}  # fmt: skip


@pytest.mark.parametrize("k", [0, 1])
def test_maps_friction_and_radius_of_the_scripts_are_the_plants(
    repo_root: Path, starts: dict[str, float], k: int
) -> None:
    made, clutch = script(repo_root / SCENARIOS / "make_scenarios.py"), f"clutch{k + 1}"
    points = made.knots(made.MAPS[k])
    size = sum(name.startswith(f"{clutch}.map.position[") for name in starts)
    assert points.shape == (size, 2)
    for point, (millimetres, force) in enumerate(points.tolist(), 1):
        position = starts[f"{clutch}.map.position[{point}]"]
        assert position == pytest.approx(millimetres / 1000, rel=1e-15, abs=0)
        assert starts[f"{clutch}.map.force[{point}]"] == force
    assert starts[f"{clutch}.kineticFriction"] == made.KINETIC_FRICTION[k]
    assert starts[f"{clutch}.effectiveRadius"] == made.EFFECTIVE_RADIUS


def test_the_scenarios_are_what_their_script_writes(repo_root: Path, tmp_path: Path) -> None:
    source = repo_root / SCENARIOS
    shutil.copy(source / "make_scenarios.py", tmp_path)
    script(tmp_path / "make_scenarios.py").main()
    for name in ("positions.csv", "torque_tracking.csv"):
        hint = f"{name} is out of date; run python {SCENARIOS}/make_scenarios.py"
        assert (tmp_path / name).read_bytes() == (source / name).read_bytes(), hint
