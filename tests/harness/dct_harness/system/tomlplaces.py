"""Line and column of every key of a TOML text that a parser has already found valid."""

from __future__ import annotations

import re
from collections.abc import Iterator
from dataclasses import dataclass, field

Path = tuple[str | int, ...]  # keys from the top; a number is an index into an array

BLANK = re.compile(r"(?:\s|#[^\n]*)*")
BARE = re.compile(r"[A-Za-z0-9_-]+")
DATE_TIME = re.compile(r"\d{4}-\d\d-\d\d \d\d:\d\d[^\s,\]}#]*")
PLAIN = re.compile(r"[^\s,\]}#]+")
ESCAPES = {"b": "\b", "t": "\t", "n": "\n", "f": "\f", "r": "\r"}
ESCAPE = re.compile(r"\\(?:u([0-9A-Fa-f]{4})|U([0-9A-Fa-f]{8})|(.))")
STRINGS = (
    re.compile(r'"""(?:\\.|[^\\])*?"""(?:"{0,2}(?!"))', re.DOTALL),
    re.compile(r"'''.*?'''(?:'{0,2}(?!'))", re.DOTALL),
    re.compile(r'"(?:\\.|[^"\\])*"'),
    re.compile(r"'[^']*'"),
)


@dataclass
class Places:
    """Where keys stand in a text; an unknown key has the place of what it would stand in."""

    text: str = ""
    _starts: dict[Path, int] = field(default_factory=dict)

    def find(self, *keys: str | int) -> tuple[int, int] | None:
        """Return line and column, from 1, of a key or of the nearest one above; else None."""
        for length in range(len(keys), 0, -1):
            start = self._starts.get(keys[:length])
            if start is not None:
                line = self.text.count("\n", 0, start) + 1
                return line, start - (self.text.rfind("\n", 0, start) + 1) + 1
        return None

    def __contains__(self, keys: object) -> bool:
        return keys in self._starts

    def __iter__(self) -> Iterator[Path]:
        return iter(self._starts)


def places(text: str) -> Places:
    """Return the places of all keys of a valid TOML text."""
    return Places(text, _Scanner(text).scan())


class _Scanner:
    """Walks a valid text once; it need not tell what is wrong."""

    def __init__(self, text: str) -> None:
        self.text, self.at = text, 0
        self.found: dict[Path, int] = {}
        self.last: dict[Path, int] = {}  # array of tables -> index of its newest one

    def scan(self) -> dict[Path, int]:
        table: Path = ()
        self._blank()
        while self.at < len(self.text):
            if self.text[self.at] == "[":
                table = self._header()
            else:
                self._pair(table)
            self._blank()
        return self.found

    def _blank(self) -> None:
        self._take(BLANK)

    def _take(self, pattern: re.Pattern[str]) -> str:
        match = pattern.match(self.text, self.at)
        found = match[0] if match else ""
        self.at += len(found)
        return found

    def _header(self) -> Path:
        """Read `[a.b]` or `[[a.b]]`; returns the table that follows."""
        many = self.text.startswith("[[", self.at)
        start = self.at
        self.at += 2 if many else 1
        keys = self._keys()
        self._blank()
        self.at += 2 if many else 1
        table: Path = ()
        for key, _ in keys[:-1] if many else keys:
            table = self._inside((*table, key))
            self.found.setdefault(table, start)
        if many:
            table = (*table, keys[-1][0])
            self.found.setdefault(table, start)
            self.last[table] = self.last.get(table, -1) + 1
            table = self._inside(table)
            self.found[table] = start
        return table

    def _inside(self, table: Path) -> Path:
        """Return a table, or the newest one of an array of tables."""
        return (*table, self.last[table]) if table in self.last else table

    def _keys(self) -> list[tuple[str, int]]:
        """Read a dotted key; returns its parts and where each begins."""
        found = []
        while True:
            self._blank()
            start = self.at
            found.append((self._key(), start))
            self._blank()
            if not self.text.startswith(".", self.at):
                return found
            self.at += 1

    def _key(self) -> str:
        quote = self.text[self.at]
        if quote not in "\"'":
            return self._take(BARE)
        text = self._take(STRINGS[2 if quote == '"' else 3])[1:-1]
        return ESCAPE.sub(_unescaped, text) if quote == '"' else text

    def _pair(self, table: Path) -> None:
        for key, start in self._keys():
            table = (*table, key)
            self.found.setdefault(table, start)
        self.at += 1  # the equals sign
        self._value(table)

    def _value(self, path: Path) -> None:
        self._blank()
        opening = self.text[self.at]
        if opening == "[":
            self._array(path)
        elif opening == "{":
            self._inline_table(path)
        elif not any(self._take(pattern) for pattern in STRINGS):
            _ = self._take(DATE_TIME) or self._take(PLAIN)

    def _array(self, path: Path) -> None:
        self.at += 1
        index = 0
        while self._more("]"):
            self.found[(*path, index)] = self.at
            self._value((*path, index))
            index += 1

    def _inline_table(self, path: Path) -> None:
        self.at += 1
        while self._more("}"):
            self._pair(path)

    def _more(self, end: str) -> bool:
        """Step over blanks and a comma; returns whether another element follows."""
        self._blank()
        if self.text[self.at] == ",":
            self.at += 1
            self._blank()
        if self.text[self.at] != end:
            return True
        self.at += 1
        return False


def _unescaped(match: re.Match[str]) -> str:
    short, long, letter = match.groups()
    return ESCAPES.get(letter, letter) if letter else chr(int(short or long, 16))
