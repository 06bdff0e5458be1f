"""A command-line parser whose errors suggest the verb, option or choice that was meant."""

from __future__ import annotations

import argparse
import re
from collections.abc import Iterable
from difflib import SequenceMatcher, get_close_matches
from typing import Any, NoReturn

from ..errors import did_you_mean

CHOICE = re.compile(r"invalid choice: '([^']*)' \(choose from (.*)\)", re.DOTALL)
UNKNOWN = re.compile(r"unrecognized arguments:.*?(?<=\s)(--?\w[\w-]*)")


class Parser(argparse.ArgumentParser):
    """As argparse, with a hint at the end of an error instead of all options before it."""

    def parse_args(self, args: Any = None, namespace: Any = None) -> Any:
        """As argparse; but the verb refuses its unknown options, and so suggests its own."""
        found, left = self.parse_known_args(args, namespace)
        if left:
            verb = _verbs(self).get(getattr(found, "verb", None), self)
            verb.error(f"unrecognized arguments: {' '.join(left)}")
        return found

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
            return _nearest(unknown[1], self._option_string_actions)
        return ""


def _nearest(word: str, options: Iterable[str]) -> str:
    """Return `` Did you mean 'x' or 'y'?``, all that are as close as the closest, or nothing."""
    alike = {o: SequenceMatcher(None, o, word).ratio() for o in options}
    close = get_close_matches(word, alike, n=1)
    nearest = sorted(o for o in alike if close and alike[o] == alike[close[0]])
    words = "' or '".join(nearest)
    return f" Did you mean '{words}'?" if nearest else ""


def _verbs(parser: argparse.ArgumentParser) -> dict[Any, Any]:
    """Return the parsers of verbs by name."""
    actions = (a for a in parser._actions if isinstance(a, argparse._SubParsersAction))
    return {name: verb for action in actions for name, verb in action.choices.items()}
