"""The harness is type-checked strictly; pyproject.toml lists the modules that are still to come."""

from __future__ import annotations

import subprocess
import sys
from pathlib import Path

PASSES = "Success: no issues found in "


def test_the_harness_has_no_type_error(repo_root: Path, tmp_path: Path) -> None:
    command = [sys.executable, "-m", "mypy", "--cache-dir", str(tmp_path), "dct_harness"]
    done = subprocess.run(
        command, cwd=repo_root / "tests/harness", capture_output=True, text=True, check=False
    )
    assert done.stdout.startswith(PASSES), done.stdout + done.stderr
    assert int(done.stdout.removeprefix(PASSES).split()[0]) > 80
