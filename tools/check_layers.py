"""Checks who may know of whom: `core <- haptics <- py <- python/feeler`, never back.

    python tools/check_layers.py [ROOT]

A new crate or Python room fails the check until it has its place in the tables below: the tables are the architecture,
and changing them is a decision to make in the open.
"""

from __future__ import annotations

import ast
import re
import sys
from collections.abc import Iterator
from pathlib import Path

if sys.version_info >= (3, 11):
    import tomllib
else:
    import tomli as tomllib

# A crate may depend on crates to its left.
CRATES = ["feeler-shapes", "feeler-lanes", "feeler-core", "feeler-contacts", "feeler-haptics", "feeler-py", "feeler-exact"]

# The core is pure: no Python, clock, files, environment, network, processes, and nothing printed.
CORE_MAY_NOT_DEPEND_ON = {"pyo3", "numpy", "tokio", "log", "tracing"}
CORE_MAY_NOT_MENTION = {
    "pyo3": re.compile(r"\bpyo3\b"),
    **{
        f"std::{module}": re.compile(rf"\bstd::{module}\b|\bstd::\{{[^}}]*\b{module}\b")
        for module in ("time", "fs", "env", "net", "process", "io")
    },
    "printing": re.compile(r"\b(e?print(ln)?|dbg)!"),
    "static mut": re.compile(r"\bstatic\s+mut\b"),
}

# What each room of python/feeler may import from the package. `feeler` alone is the public face.
BASE = {"_core", "calibrate", "errors", "mockup", "progress", "scene"}
ROOMS: dict[str, set[str]] = {
    "_core": set(),
    "errors": set(),
    "progress": {"errors"},
    "mockup": {"_core", "errors"},
    "calibrate": {"_core", "errors"},
    "scene": {"_core", "calibrate", "errors", "mockup"},
    "io": BASE,
    "picture": {*BASE, "io"},
    "samples": BASE,
    "study": {*BASE, "samples"},
    "cli": {*BASE, "io", "picture", "samples", "study", "feeler"},
    "__init__": {"_core", *BASE, "io", "picture", "samples", "study"},
    "__main__": {"cli"},
}
# Beside the package, and never imported by it.
OUTSIDE = {"bench", "tests", "tools", "examples", "docs"}


def crate_violations(root: Path) -> Iterator[str]:
    """Dependencies between the crates, and what the core depends on."""
    for manifest in sorted(root.glob("crates/*/Cargo.toml")):
        where = manifest.relative_to(root).as_posix()
        data = tomllib.loads(manifest.read_text(encoding="utf-8"))
        crate = data["package"]["name"]
        if crate not in CRATES:
            yield f"{where}: crate {crate} has no place in CRATES of tools/check_layers.py"
            continue
        tables = [data, *data.get("target", {}).values()]
        depends = {
            name for table in tables for name in (*table.get("dependencies", {}), *table.get("build-dependencies", {}))
        }
        testing = {name for table in tables for name in table.get("dev-dependencies", {})}
        below = set(CRATES[: CRATES.index(crate)])
        for name in sorted((depends | testing) & set(CRATES) - below):
            yield f"{where}: {crate} may not depend on {name} (order: {' <- '.join(CRATES)})"
        if crate == "feeler-core":
            for name in sorted(depends & CORE_MAY_NOT_DEPEND_ON):
                yield f"{where}: the core is pure and may not depend on {name}"


def core_violations(root: Path) -> Iterator[str]:
    """Words in the core's sources that would make it impure. Comments and strings may say them."""
    for path in sorted(root.glob("crates/feeler-core/src/**/*.rs")):
        code = blank_comments_and_strings(path.read_text(encoding="utf-8"))
        for what, pattern in CORE_MAY_NOT_MENTION.items():
            for match in pattern.finditer(code):
                line = code.count("\n", 0, match.start()) + 1
                yield f"{path.relative_to(root).as_posix()}:{line}: the core is pure: no {what}"


def blank_comments_and_strings(code: str) -> str:
    """The Rust code with comments and string literals emptied; line numbers stay."""
    pattern = re.compile(r'//[^\n]*|/\*.*?\*/|"(?:\\.|[^"\\])*"', re.DOTALL)
    return pattern.sub(lambda match: "\n" * match.group().count("\n"), code)


def python_violations(root: Path) -> Iterator[str]:
    """Imports between the rooms of python/feeler, and out of the package."""
    package = root / "python" / "feeler"
    for path in sorted([*package.rglob("*.py"), *package.rglob("*.pyi")]):
        where = path.relative_to(root).as_posix()
        room = path.relative_to(package).parts[0].split(".")[0]
        if room not in ROOMS:
            yield f"{where}: room {room} has no place in ROOMS of tools/check_layers.py"
            continue
        for line, target in imports(path, package):
            top, _, rest = target.partition(".")
            if top in OUTSIDE:
                yield f"{where}:{line}: the package may not import {target}"
            if top != "feeler":
                continue
            other = rest.split(".")[0] or "feeler"
            if other != room and other not in ROOMS[room]:
                allowed = ", ".join(sorted(ROOMS[room])) or "nothing"
                yield f"{where}:{line}: {room} may not import {target} (of the package it may import: {allowed})"


def imports(path: Path, package: Path) -> Iterator[tuple[int, str]]:
    """(line, dotted name) of every import in the file, also those inside functions."""
    tree = ast.parse(path.read_text(encoding="utf-8"), filename=str(path))
    rooms = {*ROOMS, *(entry.name.split(".")[0] for entry in package.iterdir())}
    for node in ast.walk(tree):
        if isinstance(node, ast.Import):
            for alias in node.names:
                yield node.lineno, alias.name
        elif isinstance(node, ast.ImportFrom):
            module = node.module or ""
            if node.level:
                here = path.relative_to(package.parent).with_suffix("").parts[: -node.level]
                module = ".".join([*here, *([module] if module else [])])
            for alias in node.names:
                # `from feeler import io` names a room, `from feeler import Scene` the public face.
                is_room = module == "feeler" and alias.name in rooms
                yield node.lineno, f"feeler.{alias.name}" if is_room else module


def main() -> int:
    root = Path(sys.argv[1] if len(sys.argv) > 1 else Path(__file__).parent.parent).resolve()
    violations = sorted({*crate_violations(root), *core_violations(root), *python_violations(root)})
    for violation in violations:
        print(violation)
    if violations:
        print(f"check_layers: {len(violations)} violation(s)")
    return 1 if violations else 0


if __name__ == "__main__":
    sys.exit(main())
