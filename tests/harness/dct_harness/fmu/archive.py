"""FMU archives of any origin, opened safely: nothing lands outside, nothing grows without end."""

from __future__ import annotations

import hashlib
import io
import re
import shutil
import stat
import tempfile
import zipfile
import zlib
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path, PurePosixPath
from typing import Any
from weakref import WeakValueDictionary
from xml.parsers import expat

from fmpy import read_model_description

from ..errors import ConfigError, FmuInvalidError, unreadable

MOST_MEMBERS = 20_000
MOST_BYTES = 2 << 30  # unpacked
MOST_XML = 256 << 20
MOST_RATIO = 200  # unpacked / packed; DEFLATE reaches 1032 on zeros, libraries about 3
SMALL = 16 << 20  # bytes; below this the ratio does not matter
CHUNK = 1 << 20
DESCRIPTION = "modelDescription.xml"
VERSION = re.compile(rb"<fmiModelDescription\b[^>]*?\bfmiVersion\s*=\s*[\"']([^\"']*)")
UNUSED = ("documentation/", "sources/")  # no library reads them

# Descriptions that somebody has, by their text: reading one of 300,000 variables takes 10 s.
_in_use: WeakValueDictionary[bytes, Any] = WeakValueDictionary()


@contextmanager
def opened(path: Path) -> Iterator[zipfile.ZipFile]:
    """Open an archive whose members have been checked.

    Raises
    ------
    ConfigError
        The file cannot be read.
    FmuInvalidError
        It is no ZIP archive, it is damaged, or a member would do harm.
    """
    try:
        with zipfile.ZipFile(path) as archive:
            _check(path, archive.infolist())
            yield archive
    except OSError as error:
        raise ConfigError(unreadable(path, _kind(path), error, ".fmu")) from error
    except zipfile.BadZipFile as error:
        damage = "" if "not a zip" in str(error) else f": {error}"
        cut = not damage and _begins(path)
        why = "its end is missing: copy it again" if cut else f"not a ZIP archive{damage}"
        raise FmuInvalidError(f"{path}: is not an {_kind(path)} ({why})") from error
    except (zlib.error, EOFError, NotImplementedError, RuntimeError) as error:
        raise FmuInvalidError(f"{path}: the archive cannot be unpacked: {error}") from error


def _begins(path: Path) -> bool:
    """Return whether a file begins as a ZIP archive does."""
    with path.open("rb") as file:
        return file.read(4) == b"PK\x03\x04"


def _kind(path: Path) -> str:
    return "SSP file" if path.suffix.lower() == ".ssp" else "FMU"


def unpack(path: Path) -> Path:
    """Unpack what a run needs of an FMU into a new temporary directory; returns it."""
    with opened(path) as archive:
        directory = Path(tempfile.mkdtemp(prefix="dct-harness-"))
        try:
            extract(path, archive, directory, UNUSED)
        except BaseException:
            shutil.rmtree(directory, ignore_errors=True)
            raise
    return directory


def described(path: Path) -> Any:
    """Return the model description of an FMU that is not unpacked."""
    with opened(path) as archive:
        try:
            text = archive.read(DESCRIPTION)
        except KeyError as error:
            raise FmuInvalidError(f"{path}: has no {DESCRIPTION}") from error
    return parsed(path, text)


def parsed(path: Path, text: bytes) -> Any:
    """Return a model description; the text may not define entities or refer to other files.

    `path` is named in errors. Who reads the same text meanwhile gets the same description: nobody
    may write to it.
    """
    digest = hashlib.sha256(text).digest()
    description = _in_use.get(digest)
    if description is None:
        description = _in_use[digest] = _read(path, text)
    return description


def _read(path: Path, text: bytes) -> Any:
    refuse_doctype(path, text, DESCRIPTION)
    stated = VERSION.search(text)
    if stated and stated[1] != b"2.0":
        version = stated[1].decode("ascii", "replace")
        raise FmuInvalidError(f"{path}: is FMI {version}; FMI 2.0 co-simulation is what runs here")
    alone = io.BytesIO()
    with zipfile.ZipFile(alone, "w") as archive:
        archive.writestr(DESCRIPTION, text)
    try:
        description = read_model_description(alone)
    except Exception as error:
        raise FmuInvalidError(f"{path}: {DESCRIPTION}: {error}") from error
    if description.fmiVersion != "2.0" or description.coSimulation is None:
        raise FmuInvalidError(f"{path}: is not an FMI 2.0 co-simulation FMU")
    identifier = description.coSimulation.modelIdentifier or ""
    if not identifier or set(identifier) & set("/\\:\0") or identifier in (".", ".."):
        raise FmuInvalidError(f"{path}: modelIdentifier '{identifier}' is a path")
    return description


def refuse_doctype(path: Path, text: bytes, name: str) -> None:
    """Refuse a document type: entities expand without end or read other files."""

    def refuse(*_: Any) -> None:
        raise FmuInvalidError(f"{path}: {name}: declares a document type (entities)")

    parser = expat.ParserCreate()
    parser.StartDoctypeDeclHandler = refuse
    try:
        parser.Parse(text, True)
    except expat.ExpatError as error:
        raise FmuInvalidError(f"{path}: {name}: {error}") from error


def _check(path: Path, members: list[zipfile.ZipInfo]) -> None:
    if len(members) > MOST_MEMBERS:
        raise FmuInvalidError(f"{path}: has {len(members)} members, more than {MOST_MEMBERS}")
    total = sum(m.file_size for m in members)
    if total > MOST_BYTES:
        raise FmuInvalidError(f"{path}: unpacks to {total} bytes, more than {MOST_BYTES}")
    seen: set[str] = set()
    for member in members:
        fault = _fault(member) or (member.filename in seen and "stands twice in the archive")
        if fault:
            raise FmuInvalidError(f"{path}: archive member '{_shown(member)}' {fault}")
        seen.add(member.filename)


def _shown(member: zipfile.ZipInfo) -> str:
    """Return a name as it stands in the archive, without control characters."""
    return member.orig_filename.encode("unicode_escape").decode().replace("\\\\", "\\")


def _fault(member: zipfile.ZipInfo) -> str:
    """Return what is wrong with a member; empty if nothing."""
    name = member.orig_filename
    parts = PurePosixPath(name.replace("\\", "/"))
    if parts.is_absolute() or ".." in parts.parts or ":" in name:
        return "leaves the archive"
    if "\\" in name:
        return "has a backslash in its name; FMI wants '/'"
    if "\0" in name:
        return "has a zero byte in its name"
    kind = stat.S_IFMT(member.external_attr >> 16)
    if kind not in (0, stat.S_IFREG, stat.S_IFDIR):
        return "is a link or a device"
    if member.flag_bits & 1:
        return "is encrypted"
    if parts.name == DESCRIPTION and member.file_size > MOST_XML:
        return f"has {member.file_size} bytes, more than {MOST_XML}"
    if member.file_size > SMALL and member.file_size > MOST_RATIO * member.compress_size:
        return f"is packed more than {MOST_RATIO} times smaller: a bomb"
    return ""


def extract(
    path: Path, archive: zipfile.ZipFile, directory: Path, without: tuple[str, ...] = ()
) -> None:
    """Write all members but those in some folders; no more bytes than their headers told."""
    for member in archive.infolist():
        if member.filename.startswith(without):
            continue
        target = directory / member.filename
        try:
            if member.is_dir():
                target.mkdir(parents=True, exist_ok=True)
                continue
            target.parent.mkdir(parents=True, exist_ok=True)
            with archive.open(member) as source, target.open("xb") as file:
                _copy(source, file, member.file_size)
        except (FileExistsError, NotADirectoryError, IsADirectoryError) as error:
            raise FmuInvalidError(
                f"{path}: archive member '{_shown(member)}' stands where another one is"
            ) from error


def _copy(source: Any, file: Any, size: int) -> None:
    left = size
    while chunk := source.read(CHUNK):
        left -= len(chunk)
        if left < 0:
            raise zipfile.BadZipFile("a member is longer than its header says")
        file.write(chunk)
