"""Pytest plugin: closed loops and single FMUs as fixtures, artefacts of failing tests.

pytest finds it by itself once dct-harness is installed. Nothing heavy is imported before a
fixture is used, so it costs other test suites nothing.
"""

from __future__ import annotations

import warnings
from collections.abc import Callable, Generator, Iterator
from pathlib import Path
from typing import TYPE_CHECKING, Any

import pytest

from . import artefacts

if TYPE_CHECKING:
    from ..master.stepper import Stepper
    from .loops import Loop

REPORTS = pytest.StashKey[dict[str, Any]]()
PLANT = "DctPlant.fmu"
OPTIONS = {
    "dct_fmu_dir": ("target/fmu", "directory of the FMUs"),
    "dct_plant": (PLANT, "plant FMU of all fixtures, in the FMU directory or a path"),
    "dct_map": ("", "mapping file of that plant, where it has names and units of its own"),
    "dct_observer": ("DctObserver.fmu", "FMU of fixture observer, likewise"),
    "dct_artefacts": ("target/test-artefacts", "where failing tests leave results and reports"),
}


def pytest_addoption(parser: pytest.Parser) -> None:
    """Add `--dct-fmu-dir` and its like; each is an ini option too."""
    group = parser.getgroup("dct-harness")
    for name, (default, text) in OPTIONS.items():
        parser.addini(name, text, default=default)
        group.addoption(f"--{name.replace('_', '-')}", metavar="PATH", help=f"{text} ({default})")


def _given(config: pytest.Config, name: str) -> tuple[Path, str]:
    """Return an option, and where it counts from: the shell's folder, or the root for the ini."""
    told: str | None = config.getoption(f"--{name.replace('_', '-')}")
    return (config.invocation_params.dir, told) if told else (config.rootpath, config.getini(name))


def setting(config: pytest.Config, name: str) -> Path:
    """Return an option of the command line or of the ini file as a path."""
    folder, value = _given(config, name)
    return folder / value


def _fmu(config: pytest.Config, name: str) -> Path:
    """Return an FMU in the FMU directory, or else as a path."""
    beside = setting(config, "dct_fmu_dir") / _given(config, name)[1]
    return beside if beside.is_file() else setting(config, name)


def _swapped(config: pytest.Config) -> dict[str, str]:
    """Return what every closed loop takes in place of its plant, as overrides."""
    if _given(config, "dct_plant")[1] == PLANT:
        return {}
    found = {"plant": str(_fmu(config, "dct_plant"))}
    if _given(config, "dct_map")[1]:
        found["map"] = str(setting(config, "dct_map"))
    return found


def pytest_configure(config: pytest.Config) -> None:
    """Describe the marker."""
    text = "fmu_platform(name, ...): keep this test where FMUs run on that platform, e.g. linux64"
    config.addinivalue_line("markers", text)


def pytest_collection_modifyitems(config: pytest.Config, items: list[pytest.Item]) -> None:
    """Deselect tests that are marked for other platforms."""
    if not any(item.get_closest_marker("fmu_platform") for item in items):
        return
    from fmpy import platform

    def fits(item: pytest.Item) -> bool:
        marker = item.get_closest_marker("fmu_platform")
        return marker is None or platform in marker.args

    gone = [item for item in items if not fits(item)]
    items[:] = [item for item in items if fits(item)]
    config.hook.pytest_deselected(items=gone)


@pytest.hookimpl(wrapper=True)
def pytest_runtest_makereport(item: pytest.Item) -> Generator[None, Any, Any]:
    """Keep the outcome where fixtures see it when they are torn down."""
    report = yield
    item.stash.setdefault(REPORTS, {})[report.when] = report
    return report


def _failed(request: pytest.FixtureRequest) -> bool:
    report = request.node.stash.get(REPORTS, {}).get("call")
    return report is not None and report.failed


@pytest.fixture(scope="session")
def fmu_dir(pytestconfig: pytest.Config) -> Path:
    """Directory of the FMUs."""
    return setting(pytestconfig, "dct_fmu_dir")


def _stepper(pytestconfig: pytest.Config, name: str) -> Iterator[Stepper]:
    from ..fmu import sources
    from ..master.stepper import Stepper
    from ..supplier import mapping

    file = _swapped(pytestconfig).get("map") if name == "plant" else None
    names = mapping.load(Path(file)) if file else None
    path = _fmu(pytestconfig, f"dct_{name}")
    if told := sources.remark([path]):
        warnings.warn(told, stacklevel=1)
    with Stepper(path, name, names) as stepper:
        yield stepper


@pytest.fixture
def plant(pytestconfig: pytest.Config) -> Iterator[Stepper]:
    """Plant FMU alone: set inputs, step, read outputs by name."""
    yield from _stepper(pytestconfig, "plant")


@pytest.fixture
def observer(pytestconfig: pytest.Config) -> Iterator[Stepper]:
    """Observer FMU alone: set inputs, step, read outputs by name."""
    yield from _stepper(pytestconfig, "observer")


@pytest.fixture(scope="session")
def _loops(pytestconfig: pytest.Config, tmp_path_factory: pytest.TempPathFactory) -> Any:
    """Return every loop of the session, so that equal ones run once."""
    from .loops import Loops

    return Loops(setting(pytestconfig, "dct_fmu_dir"), tmp_path_factory.mktemp("dct-loops"))


@pytest.fixture
def _artefacts(request: pytest.FixtureRequest) -> Iterator[artefacts.Artefacts]:
    """Collect what this test made; kept if it fails."""
    kept = artefacts.Artefacts(setting(request.config, "dct_artefacts"), request.node.nodeid)
    yield kept
    if _failed(request):
        kept.save()


@pytest.fixture
def closed_loop(
    pytestconfig: pytest.Config, _loops: Any, _artefacts: artefacts.Artefacts
) -> Callable[..., Loop]:
    """Run a system file: `closed_loop("loop.toml", plant__vehicle__mass=1600.0)`.

    Overrides are `component.variable`, with `__` for dots where they are keywords; `plant=path`
    takes another plant FMU than that of `--dct-plant`, `map=path` its mapping, `scenario=path`
    another scenario. Equal calls run once per session.
    """

    def run(scenario: str | Path, **overrides: Any) -> Loop:
        usual = {} if "plant" in overrides else _swapped(pytestconfig)
        loop = _loops.run(pytestconfig.rootpath / scenario, {**usual, **overrides})
        _artefacts.add(loop)
        return loop

    return run


@pytest.fixture
def assert_tube(_artefacts: artefacts.Artefacts) -> Callable[..., None]:
    """Assert that a run stays near a reference: `assert_tube(run, "reference", tube=0.005)`.

    `run` and `reference` are results of `closed_loop`, result directories or files. `signals` is
    a name or a glob, or a list of them; `abs`, `rel`, `tube`, `nrmse` are those of
    `dct-harness compare`.
    """

    def check(run: Any, reference: Any, signals: str | list[str] = "*", **bounds: float) -> None:
        __tracebackhide__ = True
        from .loops import outside

        said = outside(run, reference, [signals] if isinstance(signals, str) else signals, bounds)
        if said:
            _artefacts.compared(run, reference)
            raise AssertionError(said)

    return check
