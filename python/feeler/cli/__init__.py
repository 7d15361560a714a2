"""The command line. `main` is the entry point of the `feeler` program; each command has a file of its own."""

from feeler.cli.app import app, main

__all__ = ["app", "main"]
