"""The FMU files: the same bytes from any build, 34 functions, nothing but system libraries."""

from __future__ import annotations

import os
import re
import subprocess
import zipfile
from pathlib import Path

import pytest
from fmpy.fmi2 import FMU2Slave
from importer_cases import FMUS, MODELS, ROOT, fmu

FUNCTIONS = sorted(name for name in dir(FMU2Slave) if name.startswith("fmi2"))
LIBRARY = "binaries/linux64/{}.so"
SYSTEM = re.compile(r"lib(c|m|gcc_s|dl|pthread|rt)\.so\.\d+|ld-linux-x86-64\.so\.2")
FIRST_ZIP_DATE = (1980, 1, 1, 0, 0, 0)

every_model = pytest.mark.parametrize("model", MODELS)


def _tool(*words: str | Path, **environment: str) -> subprocess.CompletedProcess:
    """Run a command at the project's root."""
    return subprocess.run(words, cwd=ROOT, env={**os.environ, **environment}, check=False,
                          capture_output=True, text=True)  # fmt: skip


@pytest.fixture(scope="module")
def library(tmp_path_factory: pytest.TempPathFactory) -> dict[str, Path]:
    """Return the unpacked library of each model."""
    folder = tmp_path_factory.mktemp("libraries")
    for model in MODELS:
        with zipfile.ZipFile(fmu(model)) as archive:
            archive.extract(LIBRARY.format(model), folder)
    return {model: folder / LIBRARY.format(model) for model in MODELS}


def test_two_builds_into_two_folders_give_the_same_bytes(tmp_path: Path) -> None:
    """One goes on from what is built, the other compiles everything anew elsewhere."""
    warm, cold = tmp_path / "warm", tmp_path / "cold"
    done = _tool("cargo", "fmu", "build", "--out", warm)
    assert done.returncode == 0, done.stderr
    builder, elsewhere = _builder(), str(tmp_path / "target")
    done = _tool(builder, "build", "--out", cold, CARGO_TARGET_DIR=elsewhere)
    assert done.returncode == 0, done.stderr
    assert Path(elsewhere, "release").is_dir()
    for model in MODELS:
        name = f"{model}.fmu"
        assert (warm / name).read_bytes() == (cold / name).read_bytes(), name
        assert (warm / name).read_bytes() == fmu(model).read_bytes(), "cargo fmu build"


def _builder() -> Path:
    """Return the program behind `cargo fmu`, which was just built."""
    target = Path(os.environ.get("CARGO_TARGET_DIR", ROOT / "target"))
    return target / "debug" / "cargo-fmu"


# What a library needs that the compiler of this machine, and not zig, has linked.
OF_THIS_MACHINE = re.compile(r"warning .*\.so needs (glibc 2\.\d+|libgcc_s\.so\.1)[:,]")


def test_cargo_fmu_check_finds_nothing_but_what_the_machine_asks() -> None:
    done = _tool("cargo", "fmu", "check", *(fmu(model) for model in MODELS))
    assert done.returncode == 0, done.stdout + done.stderr
    found = [line for line in done.stdout.splitlines() if not OF_THIS_MACHINE.search(line)]
    assert len(found) == len(MODELS)
    assert all(": valid, " in line for line in found)


def test_cargo_fmu_check_says_3_when_it_finds_something(tmp_path: Path) -> None:
    changed = tmp_path / "changed.fmu"
    with zipfile.ZipFile(fmu("DctPlant")) as archive, zipfile.ZipFile(changed, "w") as copy:
        for name in archive.namelist():
            copy.writestr(name, archive.read(name).replace(b'start="0.745"', b'start="0.746"'))
    done = _tool("cargo", "fmu", "check", changed)
    assert done.returncode == 3, done.stderr
    assert "engine.inertia" in done.stdout + done.stderr


@every_model
def test_the_archive_holds_what_is_committed_and_no_date(model: str) -> None:
    with zipfile.ZipFile(fmu(model)) as archive:
        members = archive.infolist()
        description = archive.read("modelDescription.xml")
    assert description == (ROOT / "modelDescription" / f"{model}.xml").read_bytes()
    assert [m.filename for m in members] == sorted(m.filename for m in members)
    assert {m.compress_type for m in members} == {zipfile.ZIP_DEFLATED}
    assert {m.date_time for m in members} == {FIRST_ZIP_DATE}


@every_model
def test_exactly_the_34_functions_are_exported(library: dict[str, Path], model: str) -> None:
    assert len(FUNCTIONS) == 34
    listed = _tool("nm", "-D", "--defined-only", library[model]).stdout.split()
    assert sorted(listed[2::3]) == FUNCTIONS
    assert set(listed[1::3]) == {"T"}


@every_model
def test_only_system_libraries_are_needed_and_nothing_is_undefined(
    library: dict[str, Path], model: str
) -> None:
    """`ldd -r` resolves every symbol, as a program without Python's libraries has to."""
    dynamic = _tool("readelf", "-d", library[model]).stdout
    needed = re.findall(r"\(NEEDED\).*\[(.*)\]", dynamic)
    assert needed
    assert [name for name in needed if not SYSTEM.fullmatch(name)] == []
    resolved = _tool("ldd", "-r", library[model])
    assert "undefined" not in resolved.stdout + resolved.stderr
    assert "not found" not in resolved.stdout


@every_model
def test_the_library_names_no_folder_of_this_machine(library: dict[str, Path], model: str) -> None:
    data = library[model].read_bytes()
    for folder in (ROOT, Path.home(), FMUS):
        assert bytes(folder) + b"/" not in data, folder
