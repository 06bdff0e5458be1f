"""`cargo fmu check` on FMUs that nobody vouches for: exit code 3 and a sentence, and nothing else.

The same for the harness: `test_harness_archive.py`.
"""

from __future__ import annotations

import os
import subprocess
import zipfile
from pathlib import Path

import pytest
from importer_cases import ROOT, fmu

XML = "modelDescription.xml"
LIBRARY = "binaries/linux64/DctPlant.so"
INVALID = 3  # exit code
TIMEOUT = 600  # s, for a check that takes one
LINK = 0o120777 << 16
UNITS = "<UnitDefinitions>"


@pytest.fixture(scope="module")
def checker() -> Path:
    """Return the program behind `cargo fmu`."""
    build = ["cargo", "build", "--quiet", "-p", "fmu-build"]
    subprocess.run(build, cwd=ROOT, check=True)
    return Path(os.environ.get("CARGO_TARGET_DIR", ROOT / "target")) / "debug" / "cargo-fmu"


def _members() -> dict[str, bytes]:
    with zipfile.ZipFile(fmu("DctPlant")) as archive:
        return {name: archive.read(name) for name in (XML, LIBRARY)}


def _written(path: Path, members: dict[str, bytes], *more: tuple[str, bytes]) -> Path:
    with zipfile.ZipFile(path, "w", zipfile.ZIP_DEFLATED) as archive:
        for name, content in (*members.items(), *more):
            archive.writestr(name, content)
    return path


def _refused(checker: Path, path: Path) -> str:
    """Check an FMU; returns what it said, in whose own folder nothing may be left."""
    folder = path.parent / "tmp"
    folder.mkdir()
    done = subprocess.run([checker, "check", path], capture_output=True, text=True, check=False,
                          env={**os.environ, "TMPDIR": str(folder)}, timeout=TIMEOUT)  # fmt: skip
    assert done.returncode == INVALID, done.stdout + done.stderr
    assert not list(folder.iterdir())
    assert not list(path.parent.parent.rglob("escaped"))
    return done.stdout


@pytest.mark.parametrize(("member", "said"), [
    ("../escaped", "outside its folder"), ("resources/../../escaped", "outside its folder"),
    ("/tmp/escaped", "outside its folder"), ("..\\escaped", "outside its folder"),
    ("C:/escaped", "outside its folder"), ("resources/" + "d/" * 3000, "File name too long"),
    ("resources/" + "n" * 300, "File name too long"), (XML + "/x", "File exists"),
    ("MODELDESCRIPTION.XML", "there twice"),
])  # fmt: skip
def test_members_that_do_not_fit_are_refused(
    checker: Path, tmp_path: Path, member: str, said: str
) -> None:
    path = _written(tmp_path / "F.fmu", _members(), (member, b"text"))
    assert said in _refused(checker, path)


def test_a_library_that_is_a_link_is_refused(checker: Path, tmp_path: Path) -> None:
    path, link = tmp_path / "F.fmu", zipfile.ZipInfo(LIBRARY)
    link.external_attr = LINK
    with zipfile.ZipFile(path, "w") as archive:
        archive.writestr(XML, _members()[XML])
        archive.writestr(link, "/etc/passwd")
    assert "is a symbolic link" in _refused(checker, path)


def test_a_bomb_is_refused_before_it_is_unpacked(checker: Path, tmp_path: Path) -> None:
    path = _written(tmp_path / "F.fmu", _members(), ("resources/zeros", bytes(17 << 20)))
    assert "a bomb" in _refused(checker, path)


@pytest.mark.parametrize(("place", "text", "said"), [
    (b"<?xml", b"\xff\xfe<?xml", "not in UTF-8, line 1"),
    (UNITS.encode(), b"<!--\xff-->" + UNITS.encode(), "not in UTF-8, line"),
    (b'description="', b'description="\0', "U+0000"),
    (b'valueReference="1"', b'valueReference="-1"', "cannot be read"),
    (b'valueReference="1"', b'valueReference="99999999999"', "cannot be read"),
    (b'modelName="DctPlant"', b'modelName="&file;"', "cannot be read"),
    (b"</fmiModelDescription>", b"", "cannot be read"),
    (b'modelIdentifier="DctPlant"', b'modelIdentifier="../../DctPlant"', "no C identifier"),
])  # fmt: skip
def test_descriptions_that_are_none_are_refused(
    checker: Path, tmp_path: Path, place: bytes, text: bytes, said: str
) -> None:
    members = _members()
    assert place in members[XML]
    members[XML] = members[XML].replace(place, text, 1)
    assert said in _refused(checker, _written(tmp_path / "F.fmu", members))


@pytest.mark.parametrize(("member", "content", "said"), [
    (XML, None, "modelDescription.xml is missing"), (XML, b"", "cannot be read"),
    (XML, b"<a>" * 300_000, "cannot be read"), (LIBRARY, None, "is missing"),
    (LIBRARY, b"", "no dynamic library"), (LIBRARY, b"\x7fELF" + bytes(5000), "no dynamic library"),
])  # fmt: skip
def test_members_that_are_missing_or_none_are_refused(
    checker: Path, tmp_path: Path, member: str, content: bytes | None, said: str
) -> None:
    members = _members()
    if content is None:
        del members[member]
    else:
        members[member] = content
    assert said in _refused(checker, _written(tmp_path / "F.fmu", members))


@pytest.mark.parametrize("length", [0, 1, 10, 1000, 100_000])
def test_archives_that_are_cut_are_refused(checker: Path, tmp_path: Path, length: int) -> None:
    path = tmp_path / "F.fmu"
    path.write_bytes(fmu("DctPlant").read_bytes()[:length])
    assert _refused(checker, path)


def test_a_library_that_is_cut_is_refused(checker: Path, tmp_path: Path) -> None:
    members = _members()
    for part in (2, 10, 1000):
        members[LIBRARY] = members[LIBRARY][: len(members[LIBRARY]) // part]
        (tmp_path / str(part)).mkdir()
        path = _written(tmp_path / str(part) / "F.fmu", members)
        assert "no dynamic library, or damaged" in _refused(checker, path)
