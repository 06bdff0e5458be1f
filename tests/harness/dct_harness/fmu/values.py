"""Values of single variables: what a user may set, and which parameters a run really had."""

from __future__ import annotations

from typing import Any

from ..errors import ConfigError, did_you_mean

Read = list[tuple[Any, Any]]  # variables and their values
KINDS = {"Real": float, "Integer": int, "Boolean": bool, "String": str}


def group_of(variable: Any) -> str:
    """Return the get/set family of a variable: enumerations travel as integers."""
    return "Integer" if variable.type == "Enumeration" else variable.type


def unit_of(variable: Any) -> str:
    """Return the unit of a variable or of its declared type; an empty string if it has none."""
    declared = variable.declaredType
    return variable.unit or (declared.unit if declared else None) or ""


def start_value(component: str, variable: Any, value: Any) -> Any:
    """Return `value` as the FMU takes it: enumerations by item or number, a whole number as real.

    Raises
    ------
    ConfigError
        The type is another one, or the enumeration has no such item.
    """
    if variable.type == "Enumeration" and isinstance(value, str):
        return _number(component, variable, value)
    kind = KINDS[group_of(variable)]
    whole = kind is float and type(value) is int
    if type(value) is not kind and not whole:
        unit = f" [{unit_of(variable)}]" if unit_of(variable) else ""
        what = f"'{variable.name}' is {variable.type}{unit}, got {value!r}"
        hint = ": write the number alone, with a decimal point" if kind is float else ""
        raise ConfigError(f"component '{component}': {what}{hint}", variable.name)
    return value


def items(variable: Any) -> dict[str, int]:
    """Return item name -> number of an enumeration."""
    listed = variable.declaredType.items if variable.declaredType else None
    return {item.name: int(item.value) for item in listed or ()}


def _number(component: str, variable: Any, item: str) -> int:
    known = items(variable)
    if item not in known:
        raise ConfigError(
            f"component '{component}': '{variable.name}' has no item '{item}' "
            f"({', '.join(known)}).{did_you_mean(item, known)}", variable.name,
        )  # fmt: skip
    return known[item]


def read_parameters(slave: Any, variables: list[Any]) -> Read:
    """Return every parameter of an initialised FMU with its value."""
    told = [v for v in variables if v.causality in ("parameter", "calculatedParameter")]
    found: Read = []
    for group in KINDS:
        chosen = [v for v in told if group_of(v) == group]
        values = getattr(slave, f"get{group}")([v.valueReference for v in chosen]) if chosen else []
        found += zip(chosen, values, strict=True)
    return found


def described(read: Read, variables: list[Any]) -> dict[str, dict[str, Any]]:
    """Return value and unit of parameters by name, in the order of the variables.

    Enumerations have their `item` too. Values are in the unit given, which is SI for these FMUs.
    """
    found = {v.name: _described(v, value) for v, value in read}
    return {v.name: found[v.name] for v in variables if v.name in found}


def _described(variable: Any, value: Any) -> dict[str, Any]:
    """Return a value with its unit, and with its item if it is one of an enumeration."""
    unit = unit_of(variable)
    if isinstance(value, bytes):
        value = value.decode("utf-8", "replace")
    named = {number: item for item, number in items(variable).items()}
    item = {"item": named[value]} if value in named else {}
    return {"value": bool(value) if variable.type == "Boolean" else value, "unit": unit, **item}
