"""`dct-harness doctor`: which FMUs load here, and what those that do not are missing."""

from __future__ import annotations

import re
import subprocess
from pathlib import Path

from dct_harness.fmu import loader
from harness_fixture.lag_fmu import compile_library, harness, write_fmu


def test_missing_shared_libraries_are_named(tmp_path: Path) -> None:
    needed = []
    for name in ("libsolver.so.3", "libthermal.so.1"):
        needed.append(tmp_path / name)
        command = [
            "gcc",
            "-shared",
            "-o",
            needed[-1],
            f"-Wl,-soname,{name}",
            "-x",
            "c",
            "/dev/null",
        ]
        subprocess.run(command, check=True)
    library = compile_library(tmp_path, Path("-Wl,--no-as-needed"), *needed)
    for path in needed:
        path.unlink()
    done = harness("doctor", write_fmu(tmp_path / "Lag.fmu", library), folder=tmp_path)
    assert done.returncode == 3
    said = "the library does not load: libsolver.so.3, libthermal.so.1 not found on this machine"
    assert f"Lag.fmu: {said}\n" in done.stdout


def test_newer_glibc_is_named_with_the_present_one(tmp_path: Path, lag_library: Path) -> None:
    newer = tmp_path / "Lag.so"
    code, count = re.subn(rb"\0GLIBC_2\.\d\d\0", b"\0GLIBC_9.99\0", lag_library.read_bytes())
    assert count, "the fixture asks for no versioned symbol of glibc 2.10 to 2.99"
    newer.write_bytes(code)
    done = harness("doctor", write_fmu(tmp_path / "Lag.fmu", newer), folder=tmp_path)
    assert done.returncode == 3
    assert f"it needs glibc 9.99, this machine has {loader.glibc_present()}\n" in done.stdout


def test_working_fmu_is_still_found_after_a_broken_one(tmp_path: Path, lag_library: Path) -> None:
    broken = tmp_path / "broken.so"
    broken.write_bytes(b"\x7fELF no more than this")
    write_fmu(tmp_path / "Broken.fmu", broken)
    write_fmu(tmp_path / "Lag.fmu", lag_library)
    done = harness("doctor", "Broken.fmu", "Lag.fmu", folder=tmp_path)
    assert done.returncode == 3
    assert "Broken.fmu: the library does not load: " in done.stdout
    needed = loader.glibc_needed(lag_library)
    assert f"Lag.fmu: loads, needs glibc {needed} or newer\n" in done.stdout


def test_versions_are_printed_and_compared_as_numbers(tmp_path: Path) -> None:
    library = tmp_path / "x.so"
    library.write_bytes(b"\0GLIBC_2.2.5\0GLIBC_2.17\0GLIBC_2.4\0libc.so.6\0")
    assert loader.glibc_needed(library) == "2.17"
    library.write_bytes(b"static")
    assert loader.glibc_needed(library) is None
    done = harness("doctor", folder=tmp_path)
    assert done.returncode == 0
    assert re.search(r"^fmpy: \d+\.\d+\.\d+$", done.stdout, re.MULTILINE)
