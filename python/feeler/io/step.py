"""STEP (ISO 10303-21): B-rep, triangulated on load by OpenCASCADE (cascadio), in a process of its own.

How fine: a triangle is nowhere farther than `chord_tolerance` metres from its surface, and neighbours turn by at most
0.5 rad, so that small holes and bolts stay round. The default is 0.1 mm. Corners come as float32 metres in the frame of
their part, so they are right to about 1e-7 of the part's size.
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
from feeler.io.limits import machine_memory
from feeler.io.raw import Progress, RawMesh, clean_name, portion
from feeler.io.step_names import ProductNames, stated_units
from feeler.io.units import Unit, parse_unit

DEFAULT_CHORD_TOLERANCE = 1e-4
"""Metres. Less is finer: the number of triangles of a round surface grows with its inverse square root."""

ANGLE_RAD = 0.5
"""The most neighbouring triangles turn against each other: at least 13 around a circle, however small."""

_WORKER = Path(__file__).with_name("_step_worker.py")
_NOT_INSTALLED = 3
_FACE = re.compile(rb"=\s*(?:ADVANCED_FACE|FACE_SURFACE)\s*\(")
_COLOUR = re.compile(r"\x1b\[[0-9;]*m")
_LINES_KEPT = 5
_POLL_SECONDS = 0.05
_SECONDS_PER_MB = 60.0  # a time-out against hangs, about a hundred times what conversion takes
_LEAST_SECONDS = 300.0
_EXPECTED_SECONDS_PER_MB = 0.4  # only for the progress bar


def read_step(
    path: Path, progress: Progress = None, *, chord_tolerance: float | None = None, given: Unit | None = None
) -> RawMesh:
    """Read a STEP file: one part for every occurrence of a product in the assembly, with names and paths.

    `given` is the unit that the caller will scale to in place of the stated one, so that the tolerance holds after it.
    """
    text = path.read_bytes()
    _check_frame(path, text)
    names = ProductNames(text)
    stated_faces = len(_FACE.findall(text))
    units = stated_units(text)
    megabytes = len(text) / 2**20
    del text
    unit = (units[0] if len(units) == 1 else None) or parse_unit("m")
    tolerance = DEFAULT_CHORD_TOLERANCE if chord_tolerance is None else chord_tolerance
    stretch = given.metres / unit.metres if given else 1.0
    with tempfile.TemporaryDirectory(prefix="feeler-") as folder:
        target = Path(folder) / "converted.glb"
        said = _convert(path, target, tolerance / stretch, megabytes, portion(progress, 0.0, 0.9))
        made_faces = 0

        def edit(document: Document) -> None:
            nonlocal made_faces
            names.edit(document.root)
            made_faces = _count_faces(document)

        try:
            raw = read_gltf(target, None, edit=edit)
        except LoadError as error:
            raise LoadError(f"{path}: OpenCASCADE made nothing usable of this STEP file; export it again") from error
    if not len(raw.faces):
        raise LoadError(f"{path}: OpenCASCADE found no surface in this STEP file; export it with solids or shells")
    raw.notes.append(f"triangulated from B-rep: chord tolerance {tolerance:g} m, angle {ANGLE_RAD:g} rad")
    if made_faces < stated_faces:
        raw.notes.append(
            f"{stated_faces - made_faces:,} of the {stated_faces:,} faces in the STEP file have no triangle: they are "
            "damaged, of a kind that OpenCASCADE does not know, or in no part that is placed"
        )
    raw.notes += [f"OpenCASCADE said: {line}" for line in said]
    if len(units) > 1 or None in units:
        raw.notes.append(
            "the STEP file has parts in several units, each was converted: "
            + ", ".join(u.name if u else "other" for u in units)
        )
    raw.unit = unit
    raw.in_metres = True
    return raw


def _check_frame(path: Path, text: bytes) -> None:
    """Check that the file starts and ends as STEP does, before native code sees it."""
    if not text[:1024].lstrip(b"\xef\xbb\xbf \t\r\n").startswith(b"ISO-10303-21"):
        raise LoadError(f"{path}: a STEP file starts with 'ISO-10303-21;'; this one is something else")
    if b"END-ISO-10303-21" not in text[-4096:]:
        raise LoadError(
            f"{path}: the closing 'END-ISO-10303-21;' is missing: the file is truncated; copy or export it again"
        )
    if b"\nDATA" not in text and b"DATA;" not in text:
        raise LoadError(f"{path}: the STEP file has no DATA section; export it again")


def _convert(path: Path, target: Path, tolerance: float, megabytes: float, progress: Progress) -> list[str]:
    """Run the converter and wait, keeping the progress bar and Ctrl-C alive; return the lines it printed."""
    millimetres = tolerance * 1000.0  # OpenCASCADE works in millimetres inside, whatever the file says
    arguments = [str(path), str(target), repr(millimetres), repr(ANGLE_RAD), str(machine_memory())]
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
        raise LoadError(f"{path}: STEP files need the package cascadio; install it with: pip install cascadio")
    if status or not target.is_file() or not target.stat().st_size:
        how = f"crashed (signal {-status})" if status < 0 else f"failed (status {status})"
        said = "".join(f": {line}" for line in _lines(log)[-2:])
        raise LoadError(
            f"{path}: OpenCASCADE {how} on this STEP file{said}; it is damaged or has no shape: export it again"
        )
    return _lines(log)


def _lines(log: Path) -> list[str]:
    """Return what the converter printed, each line once, without colours, the first few."""
    with log.open("rb") as file:
        text = _COLOUR.sub("", file.read(2**16).decode("utf-8", "replace"))
    lines = [clean_name(line, "").strip("* ")[:200] for line in text.splitlines()]
    unique = list(dict.fromkeys(line for line in lines if line))
    return unique[:_LINES_KEPT] + ([f"and {len(unique) - _LINES_KEPT} lines more"] if len(unique) > _LINES_KEPT else [])


def _count_faces(document: Document) -> int:
    """Return how many faces of the B-rep have triangles, from the extension in which the converter tells."""
    total = 0
    seen: set[int] = set()
    for mesh in document.root.get("meshes", []):
        for primitive in mesh.get("primitives", []):
            told = primitive.get("extensions", {}).get("TM_brep_faces", {}).get("faceIndices")
            if told is not None and told not in seen:
                seen.add(told)
                total += len(np.unique(document.array(told, 1)))
    return total
