"""Which system a verb works on: the options that say so, and what they choose."""

from __future__ import annotations

import argparse
import sys
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

from ..errors import ConfigError, did_you_mean
from ..ssp import calibration, ssp
from ..supplier import mapping
from ..system import parameters, system
from .arguments import seconds

Chosen = tuple[system.System, dict[str, Path], mapping.Mapping | None, ssp.Package | None]


def add_options(parser: argparse.ArgumentParser) -> None:
    """Add the system file and what may differ from it."""
    parser.add_argument("system", type=Path, help="system file (.toml or .ssp)")
    parser.add_argument("--step", type=seconds, metavar="SECONDS",
                        help="communication step (that of the file)")  # fmt: skip
    along = "inputs with slopes, where the FMU can interpolate"
    parser.add_argument("--interpolate", action="store_true", help=along)
    parser.add_argument("--stop", type=seconds, metavar="SECONDS",
                        help="end of the run (that of the file)")  # fmt: skip
    parser.add_argument("--scenario", type=Path, metavar="FILE",
                        help="scenario CSV instead of the file's: time [s], signals in SI units"
                        )  # fmt: skip
    parser.add_argument("--plant", type=Path, metavar="FMU",
                        help="FMU to use as component 'plant'")  # fmt: skip
    names = "mapping file (.toml): names, units, codings of that plant"
    parser.add_argument("--map", type=Path, metavar="FILE", help=names)
    parser.add_argument("--fmu-dir", type=Path, default=Path("target/fmu"), metavar="FOLDER",
                        help="where FMUs are (%(default)s)")  # fmt: skip
    parser.add_argument("--parameters", nargs=2, action="append", default=[],
                        metavar=("COMPONENT", "FILE"),
                        help="values of a component from a parameter file (.ssv)")  # fmt: skip
    learnt = ("calibration.ssv of an earlier run, or its folder: observer and control start with "
              "what it had learnt")  # fmt: skip
    parser.add_argument("--calibration", type=Path, metavar="FILE", help=learnt)
    parser.add_argument("--set", action="append", default=[], metavar="COMPONENT.VARIABLE=VALUE",
                        help="a parameter or start value in SI units, or an input held at it; "
                        "may be given more than once")  # fmt: skip


def choose(args: argparse.Namespace) -> Chosen:
    """Return the system, where its FMUs are, the mapping, and the opened .ssp that holds them."""
    model, paths, package = _model(args)
    if args.plant:
        if "plant" not in paths:
            raise ConfigError(f"--plant: {args.system} has no component 'plant'")
        paths["plant"] = args.plant
    model.interpolate |= args.interpolate
    names = _mapping(args, model)
    for component, file in args.parameters:
        _preset(model, component, Path(file))
    if args.calibration is not None:
        calibration.apply(model, args.calibration, paths)
    for text in args.set:
        model.override(text)
    return model, paths, names, package


@contextmanager
def opened(args: argparse.Namespace) -> Iterator[Chosen]:
    """Give what `choose` returns; afterwards the temporary folder of an opened .ssp is gone."""
    chosen = choose(args)
    try:
        yield chosen
    finally:
        if chosen[-1] is not None:
            chosen[-1].folder.cleanup()


def _model(args: argparse.Namespace) -> tuple[system.System, dict[str, Path], ssp.Package | None]:
    """Return the system, where its FMUs are, and the opened .ssp that holds them."""
    if args.system.suffix.lower() == ".ssp":
        package = ssp.Package(args.system)
        model = package.system(args.scenario, args.step, args.stop)
        free = package.release(model)
        if free and not _silent(args):
            print(
                f"the scenario has no column for {', '.join(free)}: start values", file=sys.stderr
            )
        return model, dict(package.paths), package
    model = system.load(args.system)
    model.scenario = args.scenario or model.scenario
    model.step, model.stop = args.step or model.step, args.stop or model.stop
    return model, {n: args.fmu_dir / c.fmu for n, c in model.components.items()}, None


def _mapping(args: argparse.Namespace, model: system.System) -> mapping.Mapping | None:
    """Return the mapping of the command line, its values put into the system."""
    if args.map is None:
        return None
    if "plant" not in model.components:
        raise ConfigError(f"--map: {args.system} has no component 'plant'")
    names = mapping.load(args.map)
    names.apply(model)
    return names


def _preset(model: system.System, component: str, file: Path) -> None:
    """Put the values of a parameter file above those of the system."""
    if component not in model.components:
        hint = did_you_mean(component, model.components)
        known = ", ".join(model.components)
        what = f"{model.path} has no component '{component}' ({known}).{hint}"
        raise ConfigError(f"--parameters: {what}")
    found = parameters.read(file)
    model.components[component].parameters.update(found)
    model.overridden.update((component, name) for name in found)


def _silent(args: argparse.Namespace) -> bool:
    return bool(getattr(args, "quiet", False) or getattr(args, "json", False))
