"""`dct-harness export-container`: a whole system as one FMU, by the FMU manipulation toolbox."""

from __future__ import annotations

import argparse
import logging
import shutil
import tempfile
from pathlib import Path
from typing import Any

from ..errors import ConfigError, FmuInvalidError
from ..fmu.values import items
from ..master.resolved import Resolved
from ..ssp.ssd_xml import text
from . import selection
from .arguments import Verbs, add_loudness, called, say, say_outdated, verb

EXAMPLES = """export-container examples/closed_loop/torque_tracking_case1.toml
export-container loop.toml --step 0.01 --out target/loop.fmu"""

CODES = "0 written, 2 usage or configuration, 3 FMU invalid"


def add(verbs: Verbs) -> None:
    """Add the verb to the command line."""
    what = "pack a system as one FMU: the scenario's signals are its inputs"
    parser = verb(verbs, "export-container", export, what, EXAMPLES, CODES)
    selection.add_options(parser)
    parser.add_argument("--out", type=called(".fmu"), metavar="FILE",
                        help="file to write (target/NAME.fmu)")  # fmt: skip
    add_loudness(parser, "file and components")


def export(args: argparse.Namespace) -> int:
    """Write the FMU and say where it is."""
    with selection.opened(args) as (model, paths, names, _):
        out = args.out or Path("target") / f"{model.name}.fmu"
        write(Resolved(model, paths, names), out)
        say_outdated(args, paths.values())
    say(args, f"{out}: {', '.join(paths)} in one FMU, {model.coupling}, step {model.step:g} s",
        {"file": str(out), "components": list(paths)})  # fmt: skip
    return 0


def write(system: Resolved, out: Path) -> None:
    """Pack a system.

    Raises
    ------
    ConfigError
        The toolbox is not installed, or the system needs what a container does not have.
    FmuInvalidError
        The toolbox refuses the system.
    """
    try:
        from fmu_manipulation_toolbox.assembly import AssemblyNode
    except ImportError as error:
        raise ConfigError(
            "export-container needs the FMU manipulation toolbox: "
            "pip install 'dct-harness[container]'"
        ) from error
    _check(system)
    logging.getLogger("fmu_manipulation_toolbox").setLevel(logging.CRITICAL)
    node = AssemblyNode(
        f"{_identifier(system.system.name)}.fmu", step_size=system.system.step, auto_link=False,
        auto_input=False, auto_output=False, auto_parameter=False, auto_local=False,
        sequential=system.system.coupling == "gauss-seidel",
    )  # fmt: skip
    _fill(node, system)
    out.parent.mkdir(parents=True, exist_ok=True)
    with tempfile.TemporaryDirectory(prefix="dct-harness-container-") as folder:
        file = Path(folder) / "container.fmu"
        try:
            node.make_fmu(Path(folder), filename=str(file))
        except Exception as error:
            raise FmuInvalidError(f"{system.system.path}: the container: {error}") from error
        shutil.move(file, out)


def _identifier(name: str) -> str:
    """Return a name that may be a modelIdentifier."""
    return "".join(c if c.isalnum() else "_" for c in name)


def _check(system: Resolved) -> None:
    """Refuse what a container cannot do."""
    where = system.system.path
    for name, component in system.system.components.items():
        if component.substeps != 1:
            raise ConfigError(f"{where}: '{name}' has substeps; a container has one step")
    for target in system.sources:
        wire = system.wire(target)
        if wire.change.changes:
            raise ConfigError(
                f"{where}: '{wire.source}' to '{wire.target}' converts a value; a container only "
                "connects: export an .ssp (export-ssp)"
            )
        if system.variable(wire.target).causality == "parameter":
            raise ConfigError(
                f"{where}: the scenario changes the parameter '{wire.target}'; a container has "
                "no such input: export an .ssp (export-ssp)"
            )


def _fill(node: Any, system: Resolved) -> None:
    """Add FMUs, start values, links, inputs and outputs."""
    for name, path in system.paths.items():
        node.add_fmu(_file(name), str(path.resolve()))
        for variable, value in system.values(name).items():
            node.add_start_value(_file(name), variable, _start(system, name, variable, value))
    for target in system.sources:
        wire = system.wire(target)
        giver, _, source = wire.source.partition(".")
        taker, _, name = wire.target.partition(".")
        if giver == "scenario":
            node.add_input(source, _file(taker), name)
        else:
            node.add_link(_file(giver), source, _file(taker), name)
    for component, port in system.raw.items():
        for variable in port.outputs:
            node.add_output(_file(component), variable.name, f"{component}.{variable.name}")


def _file(component: str) -> str:
    """Return a name for a component; the container calls its inner links `<name>.<variable>`.

    It must not be the component's own: outputs of the container are called so.
    """
    return f"{component}_inside.fmu"


def _start(system: Resolved, component: str, name: str, value: Any) -> str:
    """Return a start value as the toolbox reads it."""
    variable = system.raw[component].variables[name]
    known = items(variable)
    return text(known[value] if isinstance(value, str) and value in known else value)
