"""STEP (ISO 10303-21): B-rep, triangulated on load by OpenCASCADE (cascadio), in a process of its own.

Fineness: no triangle is farther than `chord_tolerance` metres from its surface, and neighbours differ by at most 0.5
rad, so that small holes and bolts stay round. The default is 0.1 mm. Corners are float32 metres in the frame of their
part, with an error of about 1e-7 of the part's size.
"""

from __future__ import annotations

import re
import subprocess
import sys
import tempfile
import time
from pathlib import Path

import numpy as np

from feeler.errors import LoadError
from feeler.io.gltf import read_gltf
from feeler.io.gltf_document import Document
from feeler.io.gltf_nodes import SceneGraph
from feeler.io.limits import machine_memory
from feeler.io.raw import RawMesh, clean_name, portion
from feeler.io.step_attributes import Rows, product_attributes
from feeler.io.step_external import Named, find, referenced_files
from feeler.io.step_names import Assembly, stated_units
from feeler.io.step_parts import Library, ReadFile, Slot, fill
from feeler.io.step_source import count_faces, for_converter, left_out, misplaced
from feeler.io.step_text import one_section, plain_text, split_end, without_comments
from feeler.io.tally import Tally
from feeler.io.text import decoded
from feeler.io.units import Unit, parse_unit
from feeler.io.unread import ifc_schema
from feeler.progress import Progress
from feeler.words import counted

DEFAULT_CHORD_TOLERANCE = 1e-4
"""Metres. A smaller value is finer: the number of triangles grows with its inverse square root."""
FINEST_CHORD_TOLERANCE = 1e-9
"""Metres. OpenCASCADE takes none below 1e-10."""

ANGLE_RAD = 0.5
"""The largest angle between neighbouring triangles: at least 13 around a circle of any size."""

_LOSS = re.compile(r"unresolved|incorrect|undefined|not found|fail", re.IGNORECASE)
_WORKER = Path(__file__).with_name("_step_worker.py")
_NOT_INSTALLED = 3
_EMPTY = re.compile("RWGltf_CafWriter skipped node .* without geometry data")  # reported by the part's name instead
_COLOUR = re.compile(r"\x1b\[[0-9;]*m")
_LINES_KEPT = 5
_NOTES_SHOWN = 10
_POLL_SECONDS = 0.05
_SECONDS_PER_MB = 60.0  # a time-out against hangs, about a hundred times the usual duration
_LEAST_SECONDS = 300.0
_EXPECTED_SECONDS_PER_MB = 0.4  # only for the progress bar


def read_step(
    path: Path, progress: Progress | None = None, *, chord_tolerance: float | None = None, given: Unit | None = None
) -> RawMesh:
    """Read a STEP file: one part for every place of a product in the assembly, with names and paths.

    Parts in other files beside it are read from there. `given` is the unit that the caller will apply instead of the
    stated one; the tolerance holds in that unit.
    """
    text, signed, rest = _text_of(path)
    tolerance = DEFAULT_CHORD_TOLERANCE if chord_tolerance is None else chord_tolerance
    stretch = given.metres / _main_unit(text).metres if given else 1.0
    library = Library(path.parent)

    def read_part(part: Path, chain: tuple[Path, ...]) -> RawMesh:
        inner, *said = _text_of(part)
        found = _read(part, inner, tolerance / stretch, None, library, (*chain, part), read_part)
        found.notes += [note for notes in said for note in notes]
        return found

    raw = _read(path, text, tolerance / stretch, progress, library, (path.resolve(),), read_part)
    raw.notes.insert(0, f"triangulated from B-rep: chord tolerance {tolerance:g} m, angle {ANGLE_RAD:g} rad")
    raw.notes += signed
    raw.doubts += rest
    return raw


def _text_of(path: Path) -> tuple[bytes, list[str], list[str]]:
    """Return the text of a STEP file, in UTF-8, without comments, up to its end, with notes and doubts on what follows.

    Checks that it begins and ends as STEP does, before native code sees it.
    """
    text = decoded(path.read_bytes())
    if not without_comments(text).startswith(b"ISO-10303-21"):
        raise LoadError(f"{path}: a STEP file starts with 'ISO-10303-21;'; this one is something else")
    split = split_end(plain_text(text))
    if split is None:
        raise LoadError(
            f"{path}: the closing 'END-ISO-10303-21;' is missing: the file is truncated; copy or export it again"
        )
    text, rest = split[0], split[1].strip(b"\0\x1a \t\n")
    if schema := ifc_schema(text[: text.find(b"ENDSEC")]):
        raise LoadError(f"{path}: {schema}")  # its header is longer than what tells the format
    if b"\nDATA" not in text and b"DATA;" not in text:
        raise LoadError(f"{path}: the STEP file has no DATA section; export it again")
    if not rest:
        return text, [], []
    if rest.startswith(b"SIGNATURE"):
        return text, ["the file is signed (edition 3 of STEP): the signature was not checked"], []
    what = "another STEP file follows" if rest.startswith(b"ISO-10303-21") else f"a text of {len(rest):,} bytes follows"
    return text, [], [f"{what} after 'END-ISO-10303-21;', and was not read"]


def _main_unit(text: bytes) -> Unit:
    units = stated_units(text)
    return (units[0] if len(units) == 1 else None) or parse_unit("m")


def _read(
    path: Path,
    text: bytes,
    tolerance: float,
    progress: Progress | None,
    library: Library,
    chain: tuple[Path, ...],
    read_part: ReadFile,
) -> RawMesh:
    """Read a file with the files of its parts; `tolerance` in the metres of the file, `chain` ends with this file."""
    if wrong := misplaced(text):
        named = ", ".join(f"#{number}" for number in wrong[:_NOTES_SHOWN]) + (", ..." if wrong[_NOTES_SHOWN:] else "")
        raise LoadError(
            f"{path}: {counted(len(wrong), 'placements mirror or scale a shape')} ({named}), which OpenCASCADE would "
            "put in a wrong place; export the file again with these parts as shapes of their own"
        )
    assembly = Assembly(text)
    slots: list[Slot] = []
    shown: set[int] = set()  # definitions that the converter placed
    made_faces: int | None = None
    stated_faces = count_faces(text)

    def edit(document: Document) -> None:
        nonlocal made_faces
        definitions = assembly.give_names(document.root)
        shown.update(definitions.values())
        slots.extend(_empty_parts(document, definitions))
        _state_attributes(document, definitions, product_attributes(text))
        made_faces = _count_faces(document)

    with tempfile.TemporaryDirectory(prefix="feeler-") as folder:
        source, target = Path(folder) / "source.step", Path(folder) / "converted.glb"
        source.write_bytes(one_section(for_converter(text)))
        said = _convert(path, source, target, tolerance, portion(progress, 0.0, 0.9))
        try:
            raw = read_gltf(target, None, edit=edit)
        except LoadError as error:
            raise LoadError(f"{path}: OpenCASCADE made nothing usable of this STEP file; export it again") from error
    raw.unit, raw.in_metres, raw.up = _main_unit(text), True, "z"
    raw.notes += left_out(text)
    if made_faces is not None and made_faces < stated_faces:
        raw.doubts.append(
            f"{stated_faces - made_faces:,} of the {stated_faces:,} faces in the STEP file have no triangle: they are "
            "damaged, of a kind that OpenCASCADE does not know, or in no part that is placed"
        )
    for line in said:
        # A reference that leads nowhere may have moved a part, or taken a face from it.
        (raw.doubts if _LOSS.search(line) else raw.notes).append(f"OpenCASCADE said: {line}")
    units = stated_units(text)
    if len(units) > 1 or None in units:
        raw.notes.append(
            "the STEP file has parts in several units, each was converted: "
            + ", ".join(u.name if u else "other" for u in units)
        )
    files = referenced_files(text, assembly)
    filled = fill(raw, slots, files, path, chain, library, read_part)
    filled.missing.extend(_not_placed(assembly, files, shown))
    filled.raw.notes += _own_shape(assembly, files, shown - {slot.definition for slot in slots}, path)
    if not len(filled.raw.faces):
        why = _some(filled.missing + filled.empty + filled.raw.notes)
        if filled.missing:
            raise LoadError(
                f"{path}: its parts are in other files, and none was read: {why}; put these files beside it, as it "
                "names them"
            )
        raise LoadError(
            f"{path}: OpenCASCADE found no surface in this STEP file{f' ({why})' if why else ''}; export it with "
            "solids or shells"
        )
    filled.raw.notes += filled.missing + filled.empty
    return filled.raw


def _some(notes: list[str]) -> str:
    return "; ".join(notes[:_NOTES_SHOWN]) + (
        f"; and {len(notes) - _NOTES_SHOWN:,} more" if notes[_NOTES_SHOWN:] else ""
    )


def _not_placed(assembly: Assembly, files: dict[int, list[Named]], shown: set[int]) -> list[str]:
    """Return notes on parts of other files that are in the assembly but not placed by the converter."""
    return [
        f'part "{assembly.name(definition)}" is in the file {named[0].shown}, and was left out: where it is placed '
        "could not be read"
        for definition, named in files.items()
        if definition in assembly.placed and definition not in shown
    ]


def _own_shape(assembly: Assembly, files: dict[int, list[Named]], shaped: set[int], path: Path) -> list[str]:
    """Return notes on parts that refer to another STEP file and also have a shape here: that file is not read."""
    tally = Tally()
    for definition in sorted(shaped & files.keys()):
        places = [find(named, path.parent, path.parent).path for named in files[definition]]
        if any(place is not None and place != path.resolve() for place in places):
            name = assembly.name(definition)
            tally.add("parts name another STEP file and have a shape in this one: this one was taken", name)
    return tally.notes()


def _empty_parts(document: Document, definitions: dict[int, int]) -> list[Slot]:
    """Return the parts without a surface. Each gets an empty mesh, and so a path, like others."""
    nodes, meshes = document.root.get("nodes", []), document.root.setdefault("meshes", [])
    node_of: dict[int, int] = {}  # by mesh
    for at, node in enumerate(nodes):
        if "mesh" not in node and not node.get("children"):
            node_of[len(meshes)] = at
            node["mesh"] = len(meshes)
            meshes.append({"primitives": []})
    return [
        Slot(part.name, part.path, part.world, definitions.get(node_of[part.shape.mesh], 0))
        for part in SceneGraph(document, Tally()).instances
        if part.shape.mesh in node_of
    ]


def _state_attributes(document: Document, definitions: dict[int, int], rows: Rows) -> None:
    """Give the attributes of products to the nodes of their shapes, and take those of the converter."""
    nodes = document.root.get("nodes", [])
    for entry in [*document.root.get("meshes", []), *document.root.get("materials", [])]:
        entry.pop("extras", None)
    for material in document.root.get("materials", []):
        material.pop("name", None)
    todo = [(at, 0) for scene in document.root.get("scenes", []) for at in scene.get("nodes", [])]
    while todo:
        at, above = todo.pop()
        # A node without a product is one of several shapes of the one above.
        definition = definitions.get(at, above)
        nodes[at]["extras"] = rows.get(definition, {})
        todo.extend((child, definition) for child in nodes[at].get("children", []))


def _convert(path: Path, source: Path, target: Path, tolerance: float, progress: Progress | None) -> list[str]:
    """Run the converter on `source`, made from `path`, and wait; return the lines it printed.

    The progress bar and Ctrl-C stay alive.
    """
    megabytes = source.stat().st_size / 2**20
    millimetres = tolerance * 1000.0  # OpenCASCADE works in millimetres inside, whatever the file's unit
    arguments = [str(source), str(target), repr(millimetres), repr(ANGLE_RAD), str(machine_memory())]
    limit = max(_LEAST_SECONDS, _SECONDS_PER_MB * megabytes)
    started = time.monotonic()
    log = target.with_suffix(".log")
    with log.open("wb") as output:
        worker = subprocess.Popen(
            [sys.executable or "python", str(_WORKER), *arguments],
            stdin=subprocess.DEVNULL,
            stdout=output,
            stderr=output,
        )
        try:
            while True:
                try:
                    status = worker.wait(_POLL_SECONDS)
                    break
                except subprocess.TimeoutExpired:
                    spent = time.monotonic() - started
                    if spent > limit:
                        raise LoadError(
                            f"{path}: OpenCASCADE was not done after {limit:.0f} s and was stopped; use a larger "
                            "chord_tolerance, or export the file again"
                        ) from None
                    if progress:
                        progress(
                            spent / (spent + _EXPECTED_SECONDS_PER_MB * megabytes + 1.0), f"triangulating {path.name}"
                        )
        finally:
            if worker.poll() is None:
                worker.kill()
                worker.wait()
    if status == _NOT_INSTALLED:
        raise LoadError(
            f"{path}: STEP files are read through OpenCASCADE, which is not installed; install it with: "
            'pip install "feeler[step]", or export glTF'
        )
    if status or not target.is_file() or not target.stat().st_size:
        how = f"crashed (signal {-status})" if status < 0 else f"failed (status {status})"
        said = "".join(f": {line}" for line in _lines(log)[-2:])
        raise LoadError(
            f"{path}: OpenCASCADE {how} on this STEP file{said}; it is damaged or has no shape: export it again"
        )
    return _lines(log)


def _lines(log: Path) -> list[str]:
    """Return the first few lines that the converter printed, each once, without colours."""
    with log.open("rb") as file:
        text = _COLOUR.sub("", file.read(2**16).decode("utf-8", "replace"))
    lines = [clean_name(line, "").strip("* ")[:200] for line in text.splitlines()]
    unique = list(dict.fromkeys(line for line in lines if line and not _EMPTY.match(line)))
    return unique[:_LINES_KEPT] + ([f"and {len(unique) - _LINES_KEPT} lines more"] if len(unique) > _LINES_KEPT else [])


def _count_faces(document: Document) -> int | None:
    """Return the number of faces of the B-rep with triangles, None if the converter does not report it for all."""
    total = 0
    seen: set[int] = set()
    for mesh in document.root.get("meshes", []):
        for primitive in mesh.get("primitives", []):
            told = primitive.get("extensions", {}).get("TM_brep_faces", {}).get("faceIndices")
            if told is None:
                return None
            if told not in seen:
                seen.add(told)
                total += len(np.unique(document.array(told, 1)))
    return total
