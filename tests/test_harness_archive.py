"""Hostile and damaged archives: each is refused with exit code 3, and nothing is left behind."""

from __future__ import annotations

import stat
import zipfile
from pathlib import Path

import pytest
from dct_harness.errors import FmuInvalidError
from dct_harness.fmu import archive
from harness_fixture.lag_fmu import BINARY, LAG, description, harness, write_fmu
from importer_cases import fmu

XML = "modelDescription.xml"


@pytest.mark.parametrize(("member", "said"), [
    ("../escaped.txt", "'../escaped.txt' leaves the archive"),
    ("resources/../../escaped.txt", "leaves the archive"),
    ("/tmp/escaped.txt", "leaves the archive"),
    ("C:/escaped.txt", "leaves the archive"),
    ("..\\escaped.txt", "leaves the archive"),
    ("binaries\\win64\\Lag.dll", "has a backslash in its name; FMI wants '/'"),
    (XML, "stands twice in the archive"),
    ("resources", "stands where another one is"),
])  # fmt: skip
@pytest.mark.filterwarnings("ignore:Duplicate name")
def test_a_name_that_would_do_harm_is_refused(
    tmp_path: Path, lag_library: Path, member: str, said: str
) -> None:
    path = write_fmu(tmp_path / "F.fmu", lag_library)
    with zipfile.ZipFile(path, "a") as file:
        file.writestr("resources/data.txt", "data")
        file.writestr(member, "text")
    done = harness("check", path, folder=tmp_path)
    assert done.returncode == 3
    assert said in done.stderr
    assert not list(tmp_path.rglob("escaped.txt"))


@pytest.mark.parametrize("kind", [stat.S_IFLNK, stat.S_IFIFO, stat.S_IFBLK])
def test_links_and_devices_are_refused(tmp_path: Path, lag_library: Path, kind: int) -> None:
    path = write_fmu(tmp_path / "F.fmu", lag_library)
    member = zipfile.ZipInfo("resources/link")
    member.external_attr = (kind | 0o777) << 16
    with zipfile.ZipFile(path, "a") as file:
        file.writestr(member, "/etc/passwd")
    done = harness("check", path, folder=tmp_path)
    assert (done.returncode, "is a link or a device" in done.stderr) == (3, True)


def test_a_bomb_is_refused_before_it_is_unpacked(tmp_path: Path, lag_library: Path) -> None:
    path = write_fmu(tmp_path / "F.fmu", lag_library)
    with zipfile.ZipFile(path, "a", zipfile.ZIP_DEFLATED) as file:
        file.writestr("resources/zeros", bytes(archive.SMALL + 1))
    done = harness("check", path, folder=tmp_path)
    assert (done.returncode, "a bomb" in done.stderr) == (3, True)


@pytest.mark.parametrize(("limit", "value", "said"), [
    ("MOST_MEMBERS", 1, "has 2 members, more than 1"),
    ("MOST_BYTES", 100, "bytes, more than 100"),
    ("MOST_XML", 10, "bytes, more than 10"),
])  # fmt: skip
def test_an_archive_that_is_too_big_is_refused(
    tmp_path: Path, lag_library: Path, monkeypatch: pytest.MonkeyPatch,
    limit: str, value: int, said: str,
) -> None:  # fmt: skip
    path = write_fmu(tmp_path / "F.fmu", lag_library)
    monkeypatch.setattr(archive, limit, value)
    with pytest.raises(FmuInvalidError, match=said):
        archive.unpack(path)


def test_a_member_longer_than_its_header_says_is_refused(tmp_path: Path, lag_library: Path) -> None:
    path = write_fmu(tmp_path / "F.fmu", lag_library)
    with zipfile.ZipFile(path, "a") as file:
        file.writestr("resources/data.txt", "x" * 1000)
    text = path.read_bytes()
    path.write_bytes(text.replace((1000).to_bytes(4, "little"), (10).to_bytes(4, "little")))
    done = harness("check", path, folder=tmp_path)
    assert done.returncode == 3, done.stderr


def test_every_cut_of_an_archive_is_refused(tmp_path: Path, lag_library: Path) -> None:
    whole = write_fmu(tmp_path / "F.fmu", lag_library).read_bytes()
    cut = tmp_path / "cut.fmu"
    for length in range(0, len(whole), max(1, len(whole) // 50)):
        cut.write_bytes(whole[:length])
        with pytest.raises(FmuInvalidError):
            archive.unpack(cut)


def _with_description(folder: Path, library: Path, text: bytes | None) -> Path:
    path = folder / "F.fmu"
    with zipfile.ZipFile(path, "w") as file:
        if text is not None:
            file.writestr(XML, text)
        file.write(library, BINARY)
    return path


BOMB = '<!DOCTYPE f [<!ENTITY a "aaaaaaaaaa"><!ENTITY b "&a;&a;&a;&a;&a;&a;&a;&a;&a;&a;">]>'
OUTSIDE = '<!DOCTYPE f [<!ENTITY a SYSTEM "file:///etc/passwd">]>'


@pytest.mark.parametrize("doctype", [BOMB, OUTSIDE], ids=["expanding", "reading a file"])
@pytest.mark.parametrize("encoding", ["utf-8", "utf-16"])
def test_entities_are_refused_in_every_encoding(
    tmp_path: Path, lag_library: Path, doctype: str, encoding: str
) -> None:
    text = description(LAG).replace('<?xml version="1.0"?>', doctype).replace('"Lag"', '"&a;"', 1)
    declared = f'<?xml version="1.0" encoding="{encoding}"?>{text}'.encode(encoding)
    done = harness("check", _with_description(tmp_path, lag_library, declared), folder=tmp_path)
    assert done.returncode == 3
    assert "declares a document type (entities)" in done.stderr


@pytest.mark.parametrize(("text", "said"), [
    (None, "has no modelDescription.xml"),
    (b"", "modelDescription.xml: no element found"),
    (b"<a><b></a>", "modelDescription.xml: mismatched tag"),
    (b"<fmiModelDescription/>", "modelDescription.xml: "),
])  # fmt: skip
def test_a_description_that_is_none_is_refused(
    tmp_path: Path, lag_library: Path, text: bytes | None, said: str
) -> None:
    done = harness("check", _with_description(tmp_path, lag_library, text), folder=tmp_path)
    assert done.returncode == 3
    assert said in done.stderr


@pytest.mark.parametrize("identifier", ["../Lag", "/tmp/Lag", "..\\Lag", "C:Lag", "..", ""])
def test_a_model_identifier_that_is_a_path_is_refused(
    tmp_path: Path, lag_library: Path, identifier: str
) -> None:
    text = description(LAG).replace('modelIdentifier="Lag"', f'modelIdentifier="{identifier}"')
    path = _with_description(tmp_path, lag_library, text.encode())
    done = harness("check", path, folder=tmp_path)
    assert done.returncode == 3
    assert "modelIdentifier" in done.stderr


@pytest.mark.parametrize("part", [0.0005, 0.01, 0.5, 0.9])
def test_a_library_that_is_cut_is_refused_before_it_ends_the_process(
    tmp_path: Path, part: float
) -> None:
    """One of ours, which runs in the harness itself; its segments lie in the file up to the end."""
    path = tmp_path / "F.fmu"
    with zipfile.ZipFile(fmu("DctPlant")) as ours, zipfile.ZipFile(path, "w") as file:
        library = ours.read("binaries/linux64/DctPlant.so")
        file.writestr(XML, ours.read(XML))
        file.writestr("binaries/linux64/DctPlant.so", library[: int(part * len(library))])
    done = harness("check", path, folder=tmp_path)
    assert done.returncode == 3, done.stderr
    assert "the library is cut short by" in done.stderr
