"""`dct-harness completion`: the script that lets a shell complete verbs, options and files."""

from __future__ import annotations

import argparse

from .arguments import Verbs, verb

SHELLS = ("bash", "zsh", "tcsh")
EXAMPLES = """completion bash > ~/.local/share/bash-completion/completions/dct-harness
completion zsh > ~/.zfunc/_dct-harness"""

CODES = "0 printed, 2 no such shell"


def add(verbs: Verbs) -> None:
    """Add the verb to the command line."""
    text = "print a completion script for a shell"
    parser = verb(verbs, "completion", completion, text, EXAMPLES, CODES)
    parser.add_argument("shell", choices=SHELLS, help="whose script to print")


def completion(args: argparse.Namespace) -> int:
    """Print the script; returns 0."""
    import shtab

    from ..cli import parser

    print(shtab.complete(_with_files(parser(), shtab.FILE), args.shell))
    return 0


def _with_files(parser: argparse.ArgumentParser, files: object) -> argparse.ArgumentParser:
    """Mark every argument that is a path, so that the shell completes file names there."""
    for action in parser._actions:
        if getattr(action.type, "__name__", "") == "Path":
            vars(action)["complete"] = files
        if isinstance(action, argparse._SubParsersAction):
            for verb in action.choices.values():
                _with_files(verb, files)
    return parser
