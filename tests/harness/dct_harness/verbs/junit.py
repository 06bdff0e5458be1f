"""JUnit XML, the form in which every CI server shows single checks of a run."""

from __future__ import annotations

import xml.etree.ElementTree as ElementTree
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path

from ..results import write_text


@dataclass(frozen=True)
class Case:
    """One check; `failure` says what it missed, None for a pass."""

    group: str
    name: str
    failure: str | None = None


def write(path: Path, suite: str, cases: Sequence[Case]) -> None:
    """Write a file with one suite; characters that XML cannot hold become question marks."""
    failed = sum(case.failure is not None for case in cases)
    counts = {"tests": str(len(cases)), "failures": str(failed), "errors": "0"}
    root = ElementTree.Element("testsuites", counts)
    parent = ElementTree.SubElement(root, "testsuite", {"name": _clean(suite), **counts})
    for case in cases:
        names = {"classname": _clean(case.group), "name": _clean(case.name), "time": "0"}
        element = ElementTree.SubElement(parent, "testcase", names)
        if case.failure is not None:
            message = {"message": _clean(case.failure), "type": "limit"}
            ElementTree.SubElement(element, "failure", message).text = _clean(case.failure)
    ElementTree.indent(root)
    path.parent.mkdir(parents=True, exist_ok=True)
    write_text(path, ElementTree.tostring(root, encoding="unicode", xml_declaration=True) + "\n")


def _clean(text: str) -> str:
    """Return text with every control character that XML 1.0 forbids replaced."""
    return "".join(c if c >= " " or c in "\t\n\r" else "?" for c in text)
