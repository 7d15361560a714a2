"""The build backend of pip and `python -m build`: maturin, with the workbench's page in each package.

Node builds the page from `viewer/`, and git ignores it. maturin packs the page if it is there, so these hooks build it
first where it is missing. A page that is there is packed as it is; `make page` brings it up to date.
"""

from __future__ import annotations

import os
import re
import shutil
import subprocess
import sys
from collections.abc import Mapping
from pathlib import Path
from typing import Any

import maturin
from maturin import (  # hooks that need no page
    get_requires_for_build_editable,
    get_requires_for_build_sdist,
    get_requires_for_build_wheel,
    prepare_metadata_for_build_editable,
    prepare_metadata_for_build_wheel,
)

__all__ = [
    "build_editable",
    "build_sdist",
    "build_wheel",
    "get_requires_for_build_editable",
    "get_requires_for_build_sdist",
    "get_requires_for_build_wheel",
    "prepare_metadata_for_build_editable",
    "prepare_metadata_for_build_wheel",
]

ROOT = Path(__file__).resolve().parent.parent.parent
PAGE = Path("python/feeler/workbench/static/index.html")
SOURCES = Path("viewer/package-lock.json")
OLDEST_NODE = 20  # as in viewer/package.json
WITHOUT = "FEELER_NO_PAGE"

# maturin warns of projects whose backend has another name than its own.
os.environ["MATURIN_NO_MISSING_BUILD_BACKEND_WARNING"] = "1"


class PageMissingError(SystemExit):
    """Ends the build with a sentence instead of a traceback."""


def ensure_page(root: Path, *, required: bool) -> None:
    """Builds the page if it is missing. Without Node the build ends here, or goes on if the user said so.

    `required`: the package must have the page, whatever the user said.
    """
    if (root / PAGE).is_file():
        return
    if not required and os.environ.get(WITHOUT, "") not in ("", "0"):
        print(f"feeler: {WITHOUT} is set: no workbench page, so `feeler view` will not work", file=sys.stderr)
        return
    missing = _what_is_missing(root)
    if missing:
        way_out = f" Or set {WITHOUT}=1 to build without the page; then `feeler view` does not work."
        raise PageMissingError(f"feeler: the workbench page is not built, and {missing}{'' if required else way_out}")
    # By their full paths: on Windows npm is a script that only its path starts.
    npm, node = shutil.which("npm"), shutil.which("node")
    for command in ([npm, "ci", "--no-progress", "--loglevel=error"], [node, "build.mjs"]):
        print(f"feeler: building the workbench page: {' '.join(command)}", file=sys.stderr)
        # What a front end reads on the standard output is the name of the package.
        done = subprocess.run(command, cwd=root / SOURCES.parent, stdout=sys.stderr.fileno(), check=False)
        if done.returncode != 0:
            raise PageMissingError(
                f"feeler: the workbench page could not be built: `{' '.join(command)}` in {SOURCES.parent}/ "
                f"failed with exit status {done.returncode}; its output is above."
            )
    if not (root / PAGE).is_file():
        raise PageMissingError(f"feeler: {SOURCES.parent}/build.mjs ran, but did not make {PAGE.as_posix()}.")


def _what_is_missing(root: Path) -> str | None:
    """What the page cannot be built without, and what to do about it; None if everything is there."""
    if not (root / SOURCES).is_file():
        return f"its sources, {SOURCES.parent}/, are not here. Build from a clone of the repository."
    install = f"Install Node {OLDEST_NODE} or later with npm, and put it on the PATH."
    for name in ("node", "npm"):
        if shutil.which(name) is None:
            return f"{name} was not found. {install}"
    asked = subprocess.run([shutil.which("node"), "--version"], capture_output=True, text=True, check=False)
    version = asked.stdout.strip()
    number = re.match(r"v(\d+)\.", version)
    if number is None or int(number[1]) < OLDEST_NODE:
        return f"Node {version or '(of no version)'} is too old. {install}"
    return None


def build_wheel(
    wheel_directory: str,
    config_settings: Mapping[str, Any] | None = None,
    metadata_directory: str | None = None,
) -> str:
    ensure_page(ROOT, required=False)
    # Users of a wheel have no use for symbols, half of the file. Editable installations keep them, for profilers.
    os.environ.setdefault("MATURIN_STRIP", "true")
    return maturin.build_wheel(wheel_directory, config_settings, metadata_directory)


def build_editable(
    wheel_directory: str,
    config_settings: Mapping[str, Any] | None = None,
    metadata_directory: str | None = None,
) -> str:
    ensure_page(ROOT, required=False)
    return maturin.build_editable(wheel_directory, config_settings, metadata_directory)


def build_sdist(sdist_directory: str, config_settings: Mapping[str, Any] | None = None) -> str:
    """A source package always has the page, so an installation from it needs no Node."""
    ensure_page(ROOT, required=True)
    return maturin.build_sdist(sdist_directory, config_settings)
