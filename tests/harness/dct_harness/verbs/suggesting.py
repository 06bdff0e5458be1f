"""A command-line parser whose errors suggest the verb, option or choice that was meant."""

from __future__ import annotations

import argparse
import re
from collections.abc import Iterator
from typing import NoReturn

from ..errors import did_you_mean

CHOICE = re.compile(r"invalid choice: '([^']*)' \(choose from (.*)\)", re.DOTALL)
UNKNOWN = re.compile(r"unrecognized arguments:.*?(?<=\s)(--?\w[\w-]*)")


class Parser(argparse.ArgumentParser):
    """As argparse, with a hint at the end of an error instead of all options before it."""

    def error(self, message: str) -> NoReturn:
        """Print the error with the nearest known word, or where all are; exit with code 2."""
        hint = self._hint(message) or f"\n`{self.prog} --help` shows what there is"
        self.exit(2, f"{self.prog}: {message}{hint}\n")

    def _hint(self, message: str) -> str:
        if "did you mean" in message.lower():  # Python 3.14 may do so itself
            return ""
        if choice := CHOICE.search(message):
            return did_you_mean(choice[1], re.findall(r"[\w-]+", choice[2]))
        if unknown := UNKNOWN.search(message):
            return did_you_mean(unknown[1], sorted(set(_options(self))))
        return ""


def _options(parser: argparse.ArgumentParser) -> Iterator[str]:
    """Yield the options of a parser and of its verbs."""
    for action in parser._actions:
        yield from action.option_strings
        if isinstance(action, argparse._SubParsersAction):
            for verb in action.choices.values():
                yield from _options(verb)
