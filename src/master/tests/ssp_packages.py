"""Writes `two.ssp` and `nested.ssp` of the harness's own tests, and scenarios, into a folder."""

from __future__ import annotations

import sys
import zipfile
from pathlib import Path

sys.path.insert(0, "tests")

import test_harness_ssp as two
import test_ssp_nested as nested
from harness_fixture.lag_fmu import compile_library, write_fmu

OUT = Path(sys.argv[1])


def package(
    name: str, variables: tuple[str, ...], types: str, members: dict[str, str], library: Path
) -> None:
    """Write a package around a lag with these variables and type definitions."""
    fmu, typed = write_fmu(OUT / "Lag.fmu", library, variables), OUT / "Typed.fmu"
    with zipfile.ZipFile(fmu) as old, zipfile.ZipFile(typed, "w") as new:
        for member in old.namelist():
            text = old.read(member)
            begin = b"<ModelVariables>"
            new.writestr(member, text.replace(begin, types.encode() + begin))
    with zipfile.ZipFile(OUT / name, "w") as whole:
        for member, text in members.items():
            whole.writestr(member, text)
        whole.write(typed, "resources/Lag.fmu")


def main() -> None:
    """Write everything."""
    library = compile_library(OUT)
    sets = {"resources/all.ssv": two.SSV, "resources/all.ssm": two.SSM}
    package("two.ssp", two.CODED, "", {"SystemStructure.ssd": two.SSD, **sets}, library)
    structure = {"SystemStructure.ssd": nested.SSD}
    package("nested.ssp", nested.VARIABLES, nested.TYPE, structure, library)
    (OUT / "two.csv").write_text("time,push\n0,2\n1,7\n9,2\n", encoding="utf-8")
    (OUT / "nested.csv").write_text("time,push,switch\n0,120,1\n9,180,1\n", encoding="utf-8")


if __name__ == "__main__":
    main()
