"""What is wrong with a model description that can be read: its structure, and its variables' names.

fmpy checks names against the same grammar with a parser for any grammar, at 7 ms each.
"""

from __future__ import annotations

import re
from typing import Any

from fmpy.validation import validate_model_description

# The grammar of FMI 2.0.4, 2.2.9. No two alternatives begin alike, so nothing is tried twice.
QUOTED = r"'(?:[\w!#$%&()*+,\-./:;<>=?@\[\]^{}|~ ]|\\['\"?\\abfnrtv])+'"
PART = rf"(?:[A-Za-z_]\w*|{QUOTED})(?:\[\d+(?:,\d+)*\])?"
WHOLE = rf"{PART}(?:\.{PART})*"
STRUCTURED = re.compile(rf"{WHOLE}|der\({WHOLE}(?:,\d+)?\)", re.ASCII)
UNFIT = re.compile(r"[\r\n\t]")


def faults(description: Any) -> list[str]:
    """Return a sentence for everything that FMI 2.0 does not allow; fmpy's but for names."""
    try:
        structure = validate_model_description(description, validate_model_structure=True)
    except Exception as error:  # fmpy's own, at a structure that it did not expect
        structure = [f"the model structure cannot be checked: {error}"]
    return [*_names(description), *structure]


def _names(description: Any) -> list[str]:
    flat = description.variableNamingConvention == "flat"
    legal = _flat if flat else STRUCTURED.fullmatch
    convention = "flat" if flat else "structured"
    return [
        f'"{v.name}" (line {v.sourceline}) is no variable name of the naming convention '
        f'"{convention}"' for v in description.modelVariables if not legal(v.name)
    ]  # fmt: skip


def _flat(name: str) -> bool:
    return not UNFIT.search(name)
