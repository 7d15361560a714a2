"""The command line. `main` is the entry point of the `feeler` program; each command has a file of its own."""

from feeler.cli.app import app, main  # noqa: I001

# Each registers itself with `app`; --help lists them in this order.
from feeler.cli import demo, info, index, collide, clearance, path, move, clash, verify, remove  # noqa: F401
from feeler.cli import access, sight, opening, task, maintain, swept, feel, view, report, mcp  # noqa: F401
from feeler.cli import replay, sample, bench, study  # noqa: F401

__all__ = ["app", "main"]
