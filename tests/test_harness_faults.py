"""Faults of a model description as `dct-harness check` finds them, of however many variables."""

from __future__ import annotations

import gc
import weakref
from pathlib import Path
from types import SimpleNamespace
from typing import Any
from weakref import WeakValueDictionary

import pytest
from dct_harness import cli
from dct_harness.fmu import archive
from dct_harness.fmu.archive import described
from dct_harness.fmu.faults import faults
from fmpy.model_description import ModelDescription
from fmpy.validation import validate_model_description
from harness_fixture.lag_fmu import LAG, variable, write_fmu
from importer_cases import MODELS, fmu

LEGAL = ("x", "_", "motor.n", "a1.b_2", "shaft[1].gear[2,3]", "der(x)", "der(a.b[1],2)", "der",
         "der.x", "a[007]", "'not a word'", "'a.b'.c[1]", r"'\\'", "x" * 200)  # fmt: skip
ILLEGAL = ("1a", "", "a b", "a..b", ".a", "a.", "a[]", "a[1", "a[i]", "a[1,]", "a-b", "der()",
           "der(x", "der(der(x))", "der(x,y)", "''", "'a", "a'b'", "größe", "x²", "a[٣]",
           "a\n")  # fmt: skip


def _with(names: tuple[str, ...], convention: str) -> Any:
    variables = [SimpleNamespace(name=name, sourceline=k) for k, name in enumerate(names)]
    return SimpleNamespace(variableNamingConvention=convention, modelVariables=variables)


def _refused(names: tuple[str, ...], convention: str = "structured") -> list[str]:
    """Return the names in which there is a fault, of a description without a structure."""
    return [name for name in names if any(
        "naming convention" in text for text in faults(_with((name,), convention)))]  # fmt: skip


def test_names_are_held_to_the_grammar_of_fmi() -> None:
    assert _refused((*LEGAL, *ILLEGAL)) == list(ILLEGAL)


def test_the_grammar_is_the_one_that_fmpy_parses() -> None:
    names = (*LEGAL, *ILLEGAL)
    given = ModelDescription(fmiVersion="1.0", variableNamingConvention="structured")
    given.modelVariables = _with(names, "structured").modelVariables
    for v in given.modelVariables:
        v.type, v.variability = "Real", "continuous"
    told = validate_model_description(given, validate_variable_names=True)
    lines = {line for line in range(len(names)) if any(f"(line {line})" in t for t in told)}
    assert {names.index(name) for name in ILLEGAL} == lines


def test_flat_names_may_be_anything_on_one_line() -> None:
    assert _refused(("1 + größe", "a\tb", "a\nb", "a\rb"), "flat") == ["a\tb", "a\nb", "a\rb"]


def test_a_long_name_is_read_once() -> None:
    assert _refused(("a[1]." * 100_000 + "!", "'" + "\\\\" * 100_000)) != []


@pytest.mark.parametrize("model", MODELS)
def test_our_fmus_have_no_faults(model: str) -> None:
    assert faults(described(fmu(model))) == []


def test_check_names_what_is_wrong(
    tmp_path: Path, lag_library: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    more = variable("a&#9;b", 7, "local")
    path = write_fmu(tmp_path / "F.fmu", lag_library, (*LAG, more))
    assert cli.main(["check", str(path)]) == 3
    name, structure = capsys.readouterr().err.splitlines()
    assert name == '"a\tb" (line 1) is no variable name of the naming convention "flat"'
    assert structure.startswith("ModelStructure/InitialUnknowns does not contain the expected")


def test_a_description_in_use_is_read_once(
    tmp_path: Path, lag_library: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    read: list[object] = []
    monkeypatch.setattr(archive, "_in_use", WeakValueDictionary())
    original = archive.read_model_description
    monkeypatch.setattr(archive, "read_model_description",
                        lambda file: read.append(file) or original(file))  # fmt: skip
    path = write_fmu(tmp_path / "F.fmu", lag_library)
    cli.main(["check", str(path), "--quiet"])
    assert len(read) == 1
    first = described(path)
    assert described(path) is first
    write_fmu(path, lag_library, LAG[:-1])
    assert len(described(path).modelVariables) == len(first.modelVariables) - 1
    kept = weakref.ref(first)
    del first
    gc.collect()
    assert kept() is None
