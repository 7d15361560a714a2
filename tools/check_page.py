"""Checks the imports in the page's source, `viewer/src`, including types, because readers have to follow them too.

    python tools/check_page.py [ROOT]

The rooms are the folders of `viewer/src`. A new one fails the check until it has its row in the table below, and files
beside the rooms are refused. No circle of imports is allowed, not even one of two files.
"""

from __future__ import annotations

import argparse
import os
import re
import sys
from collections.abc import Collection, Iterator, Mapping
from pathlib import Path

from rust_modules import Arrows, circles, shortest_circle

# What each room may import from the others: a whole room, or one file of it.
ROOMS: dict[str, set[str]] = {
    # The connection: messages, their frames and order, the geometry on its way, or the file that is there instead.
    "link": {"math"},
    # Vectors, poses, lengths as people type them.
    "math": {"link/protocol"},
    # The picture.
    "scene": {"math", "link/protocol"},
    # What is known, and what follows from it without a picture.
    "model": {"math", "link"},
    # What commands do: the workbench and the table of commands.
    "actions": {"math", "link", "model", "scene"},
    # Sound and rumble as numbers.
    "feel": {"math", "link/protocol"},
    # Devices.
    "input": {"math", "link/protocol", "model", "scene", "actions", "feel"},
    # Components.
    "ui": {"math", "link/protocol", "model", "actions", "feel"},
    # All of it joined, and the frame loop.
    "app": {"math", "link", "scene", "model", "actions", "feel", "input", "ui"},
}
# Which rooms may import which packages.
PACKAGES: dict[str, set[str]] = {
    "three": {"scene", "input"},
    "preact": {"ui", "app"},
    "@preact/signals": {"model", "ui", "app"},
}

# Strings, which are kept, and templates and comments, which import nothing.
WORDS = re.compile(
    r"""(?P<kept>"(?:\\.|[^"\\\n])*"|'(?:\\.|[^'\\\n])*')|`(?:\\.|[^`\\])*`|//[^\n]*|/\*.*?\*/""", re.DOTALL
)
IMPORT = re.compile(r"""\b(?:from|import)\s*\(?\s*(["'])(?P<path>[^"'\n]+)\1""")


def imports(text: str) -> Iterator[tuple[int, str]]:
    """(line, path) of every import and re-export, of values, types and files."""
    code = WORDS.sub(lambda found: found["kept"] or re.sub(r"[^\n]", " ", found[0]), text)
    for found in IMPORT.finditer(code):
        yield code.count("\n", 0, found.start("path")) + 1, found["path"]


def resolved(path: Path, wanted: str) -> Path | None:
    """The source that a file means by a relative path; None: it is no source."""
    base = Path(os.path.normpath(path.parent / wanted))
    candidates = [base.with_name(base.name + suffix) for suffix in (".ts", ".tsx")] + [base]
    return next((each for each in candidates if each.suffix in {".ts", ".tsx"} and each.is_file()), None)


def violations(
    root: Path, rooms: Mapping[str, Collection[str]] = ROOMS, packages: Mapping[str, Collection[str]] = PACKAGES
) -> Iterator[str]:
    """Imports that the tables do not allow, files and rooms without a place, and circles."""
    source = root / "viewer" / "src"
    arrows: Arrows = {}
    present = set()
    for path in sorted([*source.rglob("*.ts"), *source.rglob("*.tsx")]):
        where = path.relative_to(root).as_posix()
        room = room_of(source, path)
        present.add(room)
        if room not in rooms:
            yield f"{where}: no room {room or 'for it'} in ROOMS of tools/check_page.py"
            continue
        for line, wanted in imports(path.read_text(encoding="utf-8")):
            if not wanted.startswith("."):
                package = "/".join(wanted.split("/")[: 2 if wanted.startswith("@") else 1])
                if room not in packages.get(package, ()):
                    yield f"{where}:{line}: {room} may not import {package} (see PACKAGES of tools/check_page.py)"
                continue
            into = resolved(path, wanted)
            if into is None:
                continue
            name = into.relative_to(source).with_suffix("").as_posix()
            arrows.setdefault((path, into), {}).setdefault(name, line)
            if room_of(source, into) not in {room, *rooms[room]} and name not in rooms[room]:
                allowed = ", ".join(sorted(rooms[room])) or "nothing"
                yield f"{where}:{line}: {room} may not import {name} (of the page it may import: {allowed})"
    for room in sorted({*rooms} - present):
        yield f"viewer/src: room {room} of ROOMS in tools/check_page.py is not there"
    yield from circle_violations(root, arrows)


def room_of(source: Path, path: Path) -> str:
    """The folder of `viewer/src` that a file is in; empty for one beside the rooms."""
    parts = path.relative_to(source).parts
    return parts[0] if len(parts) > 1 else ""


def circle_violations(root: Path, arrows: Arrows) -> Iterator[str]:
    for files in circles(arrows):
        way = shortest_circle(files, arrows)
        steps = [
            f"\n    {path.relative_to(root).as_posix()}:{min(arrows[path, into].values())} -> {into.name}"
            for path, into in zip(way, [*way[1:], way[0]], strict=True)
        ]
        first = files[0].relative_to(root).as_posix()
        yield f"{first}: in a circle of {len(files)} files; one way round:{''.join(steps)}"


def main() -> int:
    parser = argparse.ArgumentParser(description="Checks who may import whom in viewer/src.")
    parser.add_argument("root", nargs="?", type=Path, default=Path(__file__).parent.parent, help="default: this tree")
    found = sorted(violations(parser.parse_args().root.resolve()))
    for violation in found:
        print(violation)
    if found:
        print(f"check_page: {len(found)} violation(s)")
    return 1 if found else 0


if __name__ == "__main__":
    sys.exit(main())
