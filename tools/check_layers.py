"""Checks the layers: crates in the order of `CRATES`, Python above them, rooms as in their tables, never back.

    python tools/check_layers.py [ROOT]              the check
    python tools/check_layers.py --graph [NAME]      which file imports which, and the circles: of a crate, bench, ...

A new crate or a new room, of Rust or Python, fails the check until it has its place in the tables below: the tables are
the architecture, and changing them is a decision to make in the open.
"""

from __future__ import annotations

import argparse
import ast
import re
import sys
from collections.abc import Collection, Iterator, Mapping
from pathlib import Path

from python_modules import Sources, import_nodes
from rust_modules import Arrows, Crate, blank, circles, shortest_circle

if sys.version_info >= (3, 11):
    import tomllib
else:
    import tomli as tomllib

# A crate may depend on crates to its left.
CRATES = [
    "feeler-lanes",
    "feeler-shapes",
    "feeler-core",
    "feeler-contacts",
    "feeler-world",
    "feeler-plan",
    "feeler-haptics",
    "feeler-devices",
    "feeler-saved",
    "feeler-py",
    "feeler-exact",
]
# These two serve tests: shapes to test with, and the judge. Other crates may depend on them for tests alone.
FOR_TESTS = {"feeler-shapes", "feeler-exact"}

# No Python, clock, files, environment, network, processes, and nothing printed: the caller passes these in.
PURE = {"feeler-lanes", "feeler-core", "feeler-contacts", "feeler-world", "feeler-plan", "feeler-haptics"}
PURE_MAY_NOT_DEPEND_ON = {"pyo3", "numpy", "tokio", "log", "tracing"}
PURE_MAY_NOT_MENTION = {
    "pyo3": re.compile(r"\bpyo3\b"),
    **{
        f"std::{module}": re.compile(rf"\bstd::{module}\b|\bstd::\{{[^}}]*\b{module}\b")
        for module in ("time", "fs", "env", "net", "process", "io")
    },
    "printing": re.compile(r"\b(e?print(ln)?|dbg)!"),
    "static mut": re.compile(r"\bstatic\s+mut\b"),
}

# The only crates whose sources (not their tests) may say `unsafe`.
MAY_BE_UNSAFE = {"feeler-lanes", "feeler-devices", "feeler-saved", "feeler-py", "feeler-capi"}

# What each room of a crate (a folder or file of its src/) may import from the rooms of the same crate. `lib.rs` is the
# public face: it may import every room, and none may import it. Code for tests may import anything.
INDEX_BASE = {"constants", "error", "progress", "geometry", "mesh", "tool", "saved"}
QUERY_BASE = {*INDEX_BASE, "index", "scratch_pool"}
CONTACTS_BASE = {"constants", "surface", "context", "containers", "contact_plane"}
HAPTICS_BASE = {"constants", "error"}
DEVICES_BASE = {"constants", "clip", "exchange", "figures", "machine", "numbers"}
RUST_ROOMS: dict[str, dict[str, set[str]]] = {
    "feeler-core": {
        "constants": set(),
        "error": set(),
        "scratch_pool": set(),
        "progress": {"error"},
        "geometry": {"constants", "error"},
        # A scene as arrays of bytes.
        "saved": {"error"},
        "mesh": {"constants", "error", "geometry", "saved"},
        "tool": {"constants", "error", "geometry", "mesh"},
        # The index knows of no query, and no query of the scene; a cast begins with whether the tool is free.
        "index": INDEX_BASE,
        "collide": QUERY_BASE,
        "distance": QUERY_BASE,
        "cast": {*QUERY_BASE, "collide", "setters"},
        # The mock-up against itself.
        "clash": {*QUERY_BASE, "collide", "setters"},
        "sizing": {*INDEX_BASE, "index", "setters"},
        # What is looked at: rays, sections, and pieces for drawing.
        "rays": {*QUERY_BASE, "distance"},
        "section": {*INDEX_BASE, "index"},
        "chunks": INDEX_BASE,
        # Poses as other crates have them, and the setters of options, for all.
        "interop": {"error", "geometry"},
        "setters": set(),
        "scene": {*QUERY_BASE, "collide", "distance", "cast", "rays", "section", "sizing"},
        "stoppable": {*QUERY_BASE, "collide", "distance", "scene"},
        # Many bodies that move, each against each.
        "bodies": {*QUERY_BASE, "collide", "scene"},
    },
    "feeler-contacts": {
        "constants": set(),
        "surface": set(),
        "containers": set(),
        "contact_plane": {"constants"},
        "context": {"constants", "surface"},
        # From where surfaces meet, over what they are there, to how deep they are in each other.
        "contour": CONTACTS_BASE,
        "patch": {*CONTACTS_BASE, "contour"},
        "depth": {*CONTACTS_BASE, "contour", "patch"},
        "proximity": CONTACTS_BASE,
        "identity": CONTACTS_BASE,
        "copies": CONTACTS_BASE,
        "query": {*CONTACTS_BASE, "contour", "patch", "depth", "proximity", "identity", "copies", "footing"},
        "containment": CONTACTS_BASE,
        "escape": {*CONTACTS_BASE, "query", "containment"},
        "footing": {*CONTACTS_BASE, "proximity"},
        # Depth of two bodies by points, without contact planes; `containment` finds the parts around a tool.
        "point_depth": {"constants", "containment"},
        "solver": {*CONTACTS_BASE, "query", "escape", "footing", "containment", "point_depth"},
        "tracker": {*CONTACTS_BASE, "solver"},
        "convex_depth": set(),
        "body_depth": {"convex_depth", "escape", "solver"},
        # The mock-up against itself: the verdict on each pair of parts, and its depth.
        "clash": {*CONTACTS_BASE, "query", "escape", "solver", "point_depth"},
    },
    "feeler-world": {
        "constants": set(),
        "error": set(),
        # The bodies around the tool.
        "environment": {"error"},
        # Queries of all of them at once.
        "ask": {"constants", "error", "environment"},
        # Flat faces, bores, fillets.
        "surfaces": {"constants"},
        # Whether a point is in a solid.
        "solid": {"constants", "error"},
        # What meets at the start, and what may meet until it parts.
        "seats": {"constants", "error", "surfaces", "solid"},
        # The tool among the bodies, with its seats.
        "surroundings": {"constants", "error", "environment", "seats"},
        # How much deeper what is shallow gets.
        "deeper": {"constants", "error", "seats", "surroundings"},
        # Parts without holes.
        "sunk": {"constants", "error", "environment", "seats", "solid", "surroundings"},
        # Motions as far as they are free.
        "walk": {"constants", "error", "environment", "ask", "seats", "surroundings"},
        # A tool that contact stops.
        "stop": {"constants", "error", "environment", "seats", "surroundings", "walk"},
        # Parts gripped, and parts put down.
        "world": {"error", "environment", "surroundings"},
    },
    "feeler-plan": {
        "constants": set(),
        "error": set(),
        # Who stopped the tool.
        "blocked": {"constants"},
        "random": set(),
        "eigen": set(),
        "linear_program": {"random"},  # in its tests
        "removal": {"constants", "eigen", "error", "linear_program", "random", "blocked"},
        # The volume of a motion.
        "swept": {"constants"},
    },
    "feeler-haptics": {
        "constants": set(),
        "error": set(),
        # What one side hands to the other, and the pose that it allows.
        "smooth_surface": HAPTICS_BASE,
        "shading": {*HAPTICS_BASE, "smooth_surface"},
        "shading_budget": HAPTICS_BASE,
        "constraint_set": {*HAPTICS_BASE, "shading"},
        "proxy": {*HAPTICS_BASE, "coupling", "constraint_set"},
        "saturation": HAPTICS_BASE,
        # A mapping bounds its wrenches as the force loop does.
        "device": {*HAPTICS_BASE, "saturation"},
        "coupling": {*HAPTICS_BASE, "device"},
        "stability": {*HAPTICS_BASE, "coupling", "device"},
        "passivity": HAPTICS_BASE,
        "velocity": HAPTICS_BASE,
        # All of them, once a tick.
        "force": {*HAPTICS_BASE, "saturation", "device", "coupling", "passivity", "shading", "shading_budget"},
        # Beside the force of contact, within its bounds.
        "guide": {*HAPTICS_BASE, "saturation", "coupling", "force"},
        "servo": {*HAPTICS_BASE, "device", "coupling", "force", "velocity", "constraint_set", "shading"},
        "session": {
            *HAPTICS_BASE,
            *("device", "coupling", "servo", "constraint_set", "proxy"),
        },
        # The same with threads, whose clock is passed in.
        "clock": set(),
        "statistics": HAPTICS_BASE,
        "runner": {
            *HAPTICS_BASE,
            *("device", "coupling", "stability", "force", "guide", "servo", "constraint_set", "session", "clock"),
            *("saturation", "statistics"),
        },
        # What tests, examples and measurements of the other crates ask of the engine; hidden from users.
        "internals": {"constraint_set", "device", "force", "proxy", "servo", "shading", "velocity"},
    },
    "feeler-devices": {
        "constants": set(),
        "machine": {"constants"},
        "clip": {"constants"},
        "exchange": {"constants", "clip"},
        "figures": {"constants", "clip"},
        "numbers": set(),
        # All unsafe code of the crate.
        "vendor_library": {"constants"},
        # No driver knows of another.
        "spacemouse": {"constants", "clip", "numbers"},
        "haply": DEVICES_BASE,
        "dhd": {*DEVICES_BASE, "vendor_library"},
        "openhaptics": {*DEVICES_BASE, "vendor_library"},
        "open": {"spacemouse", "haply", "dhd", "openhaptics"},
    },
}

# Files of one crate, or of Python, do not import each other in a circle. Two may, with the reason here; three never.
TWO_FILE_CIRCLES: dict[tuple[str, str], str] = {
    (
        "bench/removal/ompl_planner.py",
        "bench/removal/planners.py",
    ): "a planner of another library, imported by name where the library is installed",
    (
        "crates/feeler-contacts/src/point_depth/body.rs",
        "crates/feeler-contacts/src/point_depth/border.rs",
    ): "a body keeps its border, found from its triangles when it is first needed",
    (
        "crates/feeler-core/src/index/blocks/collide.rs",
        "crates/feeler-core/src/index/blocks/scan.rs",
    ): "one descent: scan.rs has its last steps, on the same working memory",
    (
        "crates/feeler-core/src/index/blocks/nearest.rs",
        "crates/feeler-core/src/index/blocks/nearest_leaf.rs",
    ): "one search: nearest_leaf.rs has its last steps, on the same working memory",
    (
        "crates/feeler-core/src/mesh/mockup.rs",
        "crates/feeler-core/src/mesh/moved.rs",
    ): "a mock-up with moved parts is a mock-up, and keeps the one that it is made of",
    (
        "crates/feeler-core/src/tool/moving_tool.rs",
        "crates/feeler-core/src/tool/surface_links.rs",
    ): "a tool keeps its links, and the ways between its surfaces are a tool themselves",
    (
        "crates/feeler-py/src/contacts.rs",
        "crates/feeler-py/src/scene.rs",
    ): "a Scene gives Contacts, and a ContactTracker takes a Scene",
}

# Imports by name, when they are needed, of rooms that know the importing one: (file, name), with the reason.
LATE_IMPORTS: dict[tuple[str, str], str] = {
    (
        "python/feeler/mockup.py",
        "feeler.interchange",
    ): "a Mockup takes meshes of other libraries; their converter registers itself, and few need it",
}

# What each room of python/feeler may import from the package. `feeler` alone is the public face.
BASE = {
    "_core",
    "arguments",
    "atomic",
    "calibrate",
    "choices",
    "depths",
    "errors",
    "field_docs",
    "memory",
    "mesh_types",
    "mockup",
    "part_meshes",
    "poses",
    "rows",
    "progress",
    "renamed",
    "scene",
    "short_reprs",
    "source",
    "travel",
    "words",
}
ROOMS: dict[str, set[str]] = {
    "_core": {"_core_bodies", "_core_motion", "_core_results", "choices", "figures", "parts", "poses"},
    "_core_bodies": {"choices", "poses"},  # a share of the stub
    "_core_motion": set(),  # another
    "_core_results": {"_core_motion", "choices", "figures", "rows"},  # another
    "errors": set(),
    "progress": {"errors"},
    "words": set(),
    "choices": set(),
    "figures": {"field_docs"},
    # Tables of columns as sequences.
    "rows": {"field_docs"},
    "mesh_types": {"poses"},
    # Reprs of dataclasses, and the texts of fields in their docstrings.
    "short_reprs": set(),
    "field_docs": {"short_reprs"},
    "renamed": {"errors"},
    # What users annotate with: it only imports.
    "types": {
        *(*BASE, "clashes", "figures", "haptics", "ignored", "interchange", "io", "mechanism", "parts", "picture"),
        *("plan", "project", "requirements", "tasks", "workbench"),
    },
    "enumerations": {"arguments", "errors"},
    "arguments": {"errors", "progress"},
    # Files that are written whole or not at all.
    "atomic": {"arguments", "errors"},
    "travel": {"_core", "errors"},
    "poses": {"arguments", "errors"},
    # Material, layer and the like, by part.
    "attributes": {"arguments", "errors"},
    "parts": {"arguments", "attributes", "errors", "field_docs"},
    "memory": set(),
    # The files of saved scenes, which mock-ups and scenes can be in.
    "saved": {"_core", "arguments", "attributes", "errors", "memory", "source"},
    "source": {"choices", "field_docs", "short_reprs"},
    "mockup": {
        *("_core", "arguments", "attributes", "choices", "errors", "parts", "poses", "saved", "source", "travel"),
        *("field_docs", "mesh_types", "part_meshes", "words"),
    },
    "part_meshes": {"_core"},
    "ignored": {"_core", "arguments", "errors", "mockup", "parts", "travel", "words"},
    # Tasks on executors.
    "spreading": {"errors", "stopping"},
    "stopping": set(),
    "batches": {"_core", "arguments", "errors", "poses", "progress", "spreading"},
    "calibrate": {"_core", "errors"},
    "depths": {"_core", "field_docs", "rows", "words"},
    "scene_pickles": {"errors", "travel"},
    "scene": {
        *("_core", "arguments", "atomic", "batches", "calibrate", "choices", "depths", "enumerations", "errors"),
        *(
            "figures",
            "ignored",
            "memory",
            "mockup",
            "parts",
            "poses",
            "progress",
            "renamed",
            "saved",
            "scene_pickles",
            "spreading",
            "travel",
        ),
    },
    "io": {*BASE, "attributes", "saved"},
    "interchange": {*BASE, "io"},
    # Interfaces of other libraries.
    "compat": {*BASE, "_core"},
    "haptics": {*BASE, "figures"},
    "picture": {*BASE, "io"},
    # The package of `feeler.clash`, which is a function.
    # Its rules ask `plan` which parts are fasteners.
    "clashes": {*BASE, "enumerations", "ignored", "io", "parts", "picture", "plan", "spreading", "stopping"},
    # One file with what is known, asked and decided; it knows no workbench.
    "project": {*BASE, "clashes", "parts"},
    # Removal, order, access, swept volumes.
    "plan": {*BASE, "ignored", "io", "parts", "picture", "spreading", "stopping"},
    # Joints, positions, and what moving links meet; URDF and glTF are read elsewhere.
    "mechanism": {*BASE, "enumerations", "ignored", "interchange", "io", "parts"},
    "samples": BASE,
    # `io` for its CSV.
    "study": {*BASE, "io", "samples"},
    # `feeler` for its version alone.
    "workbench": {
        *(*BASE, "clashes", "haptics", "ignored", "io", "mechanism", "parts", "picture", "plan", "project"),
        *("requirements", "samples", "tasks", "feeler"),
    },
    # What holds a part, and how it is taken out.
    # It recognises renamed parts as `clashes` does.
    "tasks": {*BASE, "clashes", "io", "parts", "plan", "spreading", "stopping"},
    # Clearances that must hold.
    "requirements": {*BASE, "clashes", "io"},
    # The mock-up for agents: a server of the Model Context Protocol.
    "agent": {*BASE, "clashes", "io", "picture", "plan", "samples", "tasks"},
    "cli": {
        *(
            *BASE,
            "agent",
            "clashes",
            "haptics",
            "io",
            "mechanism",
            "picture",
            "plan",
            "project",
            "requirements",
            "samples",
        ),
        *("saved", "study", "tasks", "workbench", "feeler"),
    },
    "__init__": {
        *("_core", "ignored", *BASE, "clashes", "haptics", "interchange", "io", "mechanism"),
        *(
            "picture",
            "plan",
            "parts",
            "project",
            "requirements",
            "rows",
            "samples",
            "spreading",
            "study",
            "tasks",
            "types",
            "workbench",
        ),
    },
    "__main__": {"cli"},
}
# The inner rooms of a package, and those that each may import. All may import through its `__init__.py`.
INNER_ROOMS: dict[str, dict[str, set[str]]] = {
    "workbench": {
        # The page's own files.
        "files": set(),
        # Values and pure functions.
        "document": set(),
        # What the hand holds and meets; knows of no page.
        "engine": {"document"},
        # One report of a document: rows, pictures and files.
        "report": {"document", "engine"},
        # Document, engine, jobs and record together; knows of no socket.
        "session": {"document", "engine", "files", "report"},
        # Knows the session through a protocol of its own.
        "net": {"document", "files"},
        # `feeler.view`.
        "scripting": {"document", "engine", "session", "net", "view_commands"},
        # Its commands, as methods.
        "view_commands": {"document", "session"},
    },
}
# Folders of Python without circles, of imports inside functions and for type checkers neither.
PYTHON_FOLDERS = ("python", "bench", "tools", "examples")

# Beside the package, and never imported by it.
OUTSIDE = {"bench", "tests", "tools", "examples", "docs"}


def crate_violations(root: Path) -> Iterator[str]:
    """Dependencies between the crates, and those of the pure ones."""
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
        for name in sorted(depends & FOR_TESTS if crate not in FOR_TESTS else ()):
            yield f"{where}: {crate} may depend on {name} for tests alone"
        if crate in PURE:
            for name in sorted(depends & PURE_MAY_NOT_DEPEND_ON):
                yield f"{where}: {crate} is pure and may not depend on {name}"


def pin_violations(root: Path) -> Iterator[str]:
    """The crates share hidden modules, which may change with every version: they are pinned to each other exactly."""
    manifest = root / "Cargo.toml"
    if manifest.is_file():
        workspace = tomllib.loads(manifest.read_text(encoding="utf-8"))["workspace"]
        exactly = f"={workspace['package']['version']}"
        for name in CRATES:
            pin = workspace.get("dependencies", {}).get(name)
            if pin is not None and pin.get("version") != exactly:
                yield f'Cargo.toml: {name} must be of version "{exactly}", the one that it is tested with'
    for path in sorted(root.glob("crates/*/Cargo.toml")):
        where = path.relative_to(root).as_posix()
        data = tomllib.loads(path.read_text(encoding="utf-8"))
        for table in (data, *data.get("target", {}).values()):
            for kind in ("dependencies", "build-dependencies", "dev-dependencies"):
                for name, wanted in table.get(kind, {}).items():
                    is_pinned = isinstance(wanted, dict) and wanted.get("workspace") is True
                    if name in CRATES and name not in FOR_TESTS and not is_pinned:
                        yield f"{where}: {name} must be `{name}.workspace = true`, so that its version is pinned"


def source_violations(root: Path) -> Iterator[str]:
    """Words that would make a pure crate impure, and `unsafe`. Comments and strings may say them."""
    for name, folder in crate_folders(root).items():
        forbidden = {f"{name} is pure: no {what}": word for what, word in PURE_MAY_NOT_MENTION.items() if name in PURE}
        if name not in MAY_BE_UNSAFE:
            forbidden[f"no unsafe code but in {', '.join(sorted(MAY_BE_UNSAFE))}"] = re.compile(r"\bunsafe\b")
        for path in sorted(folder.glob("src/**/*.rs")):
            code = blank(path.read_text(encoding="utf-8"))
            for complaint, pattern in forbidden.items():
                for match in pattern.finditer(code):
                    line = code.count("\n", 0, match.start()) + 1
                    yield f"{path.relative_to(root).as_posix()}:{line}: {complaint}"


def crate_folders(root: Path) -> dict[str, Path]:
    manifests = sorted(root.glob("crates/*/Cargo.toml"))
    return {tomllib.loads(m.read_text(encoding="utf-8"))["package"]["name"]: m.parent for m in manifests}


def module_violations(
    root: Path,
    rooms: Mapping[str, Mapping[str, Collection[str]]] = RUST_ROOMS,
    two_file_circles: Mapping[tuple[str, str], str] = TWO_FILE_CIRCLES,
) -> Iterator[str]:
    """Imports between the rooms of a crate, and circles of its files."""
    arrows: Arrows = {}
    for name, folder in crate_folders(root).items():
        crate = Crate(folder, name)
        for path in crate.orphans():
            yield f"{path.relative_to(root).as_posix()}: no `mod` names this file, so it is not compiled"
        own = crate.arrows()
        arrows |= own
        if name in rooms:
            yield from room_violations(root, crate, own, rooms[name])
    yield from circle_violations(root, arrows, written_in(".rs", two_file_circles))


def room_violations(root: Path, crate: Crate, arrows: Arrows, rooms: Mapping[str, Collection[str]]) -> Iterator[str]:
    """Rooms and their imports that are not in the crate's table."""

    def room(path: Path) -> str:
        return path.relative_to(crate.source).parts[0].removesuffix(".rs")

    present = {room(path): path for path in sorted(crate.files(), reverse=True)}
    for name in sorted({*present} - {*rooms, "lib", "main"}):
        where = present[name].relative_to(root).as_posix()
        yield f"{where}: room {name} has no place in RUST_ROOMS of tools/check_layers.py"
    for name in sorted({*rooms} - {*present}):
        where = crate.source.relative_to(root).as_posix()
        yield f"{where}: room {name} of RUST_ROOMS in tools/check_layers.py is not there"
    for (path, into), names in sorted(arrows.items()):
        own, other = room(path), room(into)
        if own == other or own not in rooms or other in rooms[own]:
            continue
        allowed = ", ".join(sorted(rooms[own])) or "nothing"
        for name, line in names.items():
            where = f"{path.relative_to(root).as_posix()}:{line}"
            yield f"{where}: {own} may not import {name} of {other} (of its crate it may import: {allowed})"


def circle_violations(root: Path, arrows: Arrows, two_file_circles: Mapping[tuple[str, str], str]) -> Iterator[str]:
    """Circles of more than two files, those of two without a reason, and reasons without a circle."""
    reasons = {frozenset(pair): reason for pair, reason in two_file_circles.items()}
    for files in circles(arrows):
        names = [path.relative_to(root).as_posix() for path in files]
        way = "".join(f"\n    {step}" for step in steps(root, shortest_circle(files, arrows), arrows))
        if len(files) > 2:
            others = ", ".join(names[1:])
            yield f"{names[0]}: in a circle of {len(files)} files, with {others}; the shortest way round:{way}"
        elif not reasons.get(frozenset(names)):
            yield f"{names[0]}: imports {names[1]} and back, with no reason in TWO_FILE_CIRCLES:{way}"
    for first, second in two_file_circles:
        if not {(root / first, root / second), (root / second, root / first)} <= arrows.keys():
            yield f"{first}: in no circle with {second} any more: take the two out of TWO_FILE_CIRCLES"


def steps(root: Path, way: list[Path], arrows: Arrows) -> Iterator[str]:
    """Each arrow of a circle, with the names that make it."""
    for path, into in zip(way, [*way[1:], way[0]], strict=True):
        names = arrows[path, into]
        where = f"{path.relative_to(root).as_posix()}:{min(names.values())}"
        yield f"{where} -> {into.relative_to(root).as_posix()}: {', '.join(names)}"


def graph(root: Path, wanted: str | None) -> Iterator[str]:
    """The arrows and the circles of one crate or folder, or of all, to work with."""
    bases = {name: folder / "src" for name, folder in crate_folders(root).items()}
    bases |= {name: root / name for name in PYTHON_FOLDERS}
    for name, base in bases.items():
        if wanted not in {None, name}:
            continue
        arrows = Sources(base).arrows() if name in PYTHON_FOLDERS else Crate(base.parent, name).arrows()
        for (path, into), names in sorted(arrows.items()):
            places = [file.relative_to(base).as_posix() for file in (path, into)]
            yield f"{name}: {places[0]} -> {places[1]}: {', '.join(names)}"
        for files in circles(arrows):
            places = [file.relative_to(base).as_posix() for file in files]
            yield f"{name}: a circle of {len(files)} files: {' '.join(places)}"
            yield from (f"    {step}" for step in steps(root, shortest_circle(files, arrows), arrows))


def python_circles(root: Path, two_file_circles: Mapping[tuple[str, str], str] = TWO_FILE_CIRCLES) -> Iterator[str]:
    """Circles of Python files."""
    arrows: Arrows = {}
    for name in PYTHON_FOLDERS:
        arrows |= Sources(root / name).arrows()
    yield from circle_violations(root, arrows, written_in(".py", two_file_circles))


def written_in(suffix: str, circles_of_two: Mapping[tuple[str, str], str]) -> dict[tuple[str, str], str]:
    return {pair: reason for pair, reason in circles_of_two.items() if pair[0].endswith(suffix)}


def inner_violations(
    root: Path, inner_rooms: Mapping[str, Mapping[str, Collection[str]]] = INNER_ROOMS
) -> Iterator[str]:
    """Imports between the rooms of a room of python/feeler."""
    sources = Sources(root / "python")
    for outer, rooms in inner_rooms.items():
        folder = root / "python" / "feeler" / outer

        def room(path: Path, folder: Path = folder) -> str:
            return path.relative_to(folder).parts[0].split(".")[0]

        files = [path for path in sources.files() if path.is_relative_to(folder) and path != folder / "__init__.py"]
        for path in files:
            if room(path) not in rooms:
                where = path.relative_to(root).as_posix()
                yield f"{where}: room {room(path)} has no place in INNER_ROOMS of tools/check_layers.py"
        for name in sorted({*rooms} - {room(path) for path in files}):
            where = folder.relative_to(root).as_posix()
            yield f"{where}: room {name} of INNER_ROOMS in tools/check_layers.py is not there"
        for (path, into), names in sorted(sources.arrows(files).items()):
            if not into.is_relative_to(folder):
                continue
            own, other = room(path), room(into)
            if own != other and own in rooms and other not in rooms[own]:
                allowed = ", ".join(sorted(rooms[own])) or "nothing"
                for name, line in names.items():
                    where = f"{path.relative_to(root).as_posix()}:{line}"
                    yield f"{where}: {own} may not import {name} of {other} (of {outer} it may import: {allowed})"


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
            if (where, target) in LATE_IMPORTS:
                continue
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
    rooms = {*ROOMS, *(entry.name.split(".")[0] for entry in package.iterdir())}
    for node in import_nodes(path):
        if isinstance(node, ast.Import):
            for alias in node.names:
                yield node.lineno, alias.name
        else:
            module = node.module or ""
            if node.level:
                here = path.relative_to(package.parent).with_suffix("").parts[: -node.level]
                module = ".".join([*here, *([module] if module else [])])
            for alias in node.names:
                # `from feeler import io` names a room, `from feeler import Scene` the public face.
                is_room = module == "feeler" and alias.name in rooms
                yield node.lineno, f"feeler.{alias.name}" if is_room else module


def main() -> int:
    parser = argparse.ArgumentParser(description="Checks who may know of whom.")
    parser.add_argument("root", nargs="?", type=Path, default=Path(__file__).parent.parent, help="default: this tree")
    parser.add_argument("--graph", nargs="?", const="", metavar="NAME", help="print who imports whom, and the circles")
    arguments = parser.parse_args()
    root = arguments.root.resolve()
    if arguments.graph is not None:
        known = [*crate_folders(root), *PYTHON_FOLDERS]
        if arguments.graph and arguments.graph not in known:
            parser.error(f"no crate {arguments.graph}: there are {', '.join(known)}")
        print("\n".join(graph(root, arguments.graph or None)))
        return 0
    violations = sorted(
        {
            *crate_violations(root),
            *pin_violations(root),
            *source_violations(root),
            *module_violations(root),
            *python_violations(root),
            *inner_violations(root),
            *python_circles(root),
        }
    )
    for violation in violations:
        print(violation)
    if violations:
        print(f"check_layers: {len(violations)} violation(s)")
    return 1 if violations else 0


if __name__ == "__main__":
    sys.exit(main())
