"""JUnit XML, the form in which every CI server shows single checks of a run."""

from __future__ import annotations

import xml.etree.ElementTree as ElementTree
from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from dataclasses import dataclass
from pathlib import Path

from ..errors import HarnessError
from ..results import write_text

ENDS = "reaches its end"  # the case of a run itself


@dataclass(frozen=True)
class Case:
    """One check: `failure` says what it missed, `error` what prevented it; None for a pass."""

    group: str
    name: str
    failure: str | None = None
    error: str | None = None


@contextmanager
def prevented(path: Path | None, suite: str) -> Iterator[None]:
    """Write what prevents all checks, too: a server would take the file of an earlier job."""
    try:
        yield
    except HarnessError as error:
        if path is not None:
            write(path, suite, [Case("run", ENDS, error=str(error))])
        raise


def write(path: Path, suite: str, cases: Sequence[Case]) -> None:
    """Write a file with one suite; characters that XML cannot hold become question marks."""
    failed = sum(case.failure is not None for case in cases)
    wrong = sum(case.error is not None for case in cases)
    counts = {"tests": str(len(cases)), "failures": str(failed), "errors": str(wrong)}
    root = ElementTree.Element("testsuites", counts)
    parent = ElementTree.SubElement(root, "testsuite", {"name": _clean(suite), **counts})
    for case in cases:
        names = {"classname": _clean(case.group), "name": _clean(case.name)}
        element = ElementTree.SubElement(parent, "testcase", names)
        for kind, what, text in (("failure", "limit", case.failure), ("error", "run", case.error)):
            if text is not None:
                told = {"message": _clean(text), "type": what}
                ElementTree.SubElement(element, kind, told).text = _clean(text)
    ElementTree.indent(root)
    path.parent.mkdir(parents=True, exist_ok=True)
    write_text(path, ElementTree.tostring(root, encoding="unicode", xml_declaration=True) + "\n")


def _clean(text: str) -> str:
    """Return text with every control character that XML 1.0 forbids replaced."""
    return "".join(c if c >= " " or c in "\t\n\r" else "?" for c in text)
