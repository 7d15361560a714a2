"""The commands run in the test's own process."""

from __future__ import annotations

import json
from pathlib import Path
from typing import Any

from typer.testing import CliRunner

from feeler.cli import app


def run(*words: str | Path, code: int = 0) -> Any:
    """Runs the program in this process and checks its exit status."""
    result = CliRunner().invoke(app, [str(word) for word in words])
    assert result.exit_code == code, f"{result.output}\n{result.exception!r}"
    return result


def run_json(*words: str | Path, code: int = 0) -> Any:
    """What `--json` says; everything on stdout is that one document."""
    return json.loads(run(*words, "--json", code=code).stdout)


def error_of(*words: str | Path) -> str:
    """The one line on stderr of a run that ends with 2 and says nothing else."""
    result = run(*words, code=2)
    assert result.stdout == ""
    assert result.stderr.count("\n") == 1 and result.stderr.startswith("feeler: "), result.stderr
    return str(result.stderr)
