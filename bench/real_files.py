"""The folder of real models: its files, the content of packed ones, and the sizes that their sources state.

None of them is in the repository: the models belong to others. Each folder's SOURCE.txt names origin and licence.
"""

from __future__ import annotations

import fnmatch
import lzma
import re
import shutil
import tarfile
from dataclasses import dataclass, field
from pathlib import Path

import numpy as np

import feeler
from feeler.choices import UnitName

MESHES = {".stl", ".obj", ".ply", ".off", ".glb", ".gltf", ".3mf", ".step", ".stp", ".dae"}
TOOL_FOLDERS = ("tools*", "hand*")  # files in these are tools; the rest are mock-ups

# Numbers without a unit are taken as millimetres; a mock-up that is then smaller than this is blown up to one metre.
LEAST_SIZE_M = 0.1


@dataclass
class Model:
    """One file as the folder has it, and the file or files to load for it."""

    name: str  # path inside the folder
    path: Path
    megabytes: float
    is_tool: bool
    unit: UnitName | None = None
    scale: float = 1.0
    # (pattern of a part's path, metres along z) of files that are stages of one machine, each at its own origin
    offsets: list[tuple[str, float]] = field(default_factory=list)

    def files(self, scratch: Path) -> list[Path]:
        """The paths to load; a packed file is unpacked into `scratch`."""
        return _unpack(self.path, scratch / self.name) if self.path.suffix.lower() == ".xz" else [self.path]


@dataclass(frozen=True)
class Known:
    """Facts from a SOURCE.txt that the file itself lacks."""

    unit: UnitName | None = None
    scale: float = 1.0


KNOWN = {
    "axial-compressor-mark1/*": Known(scale=3.0),  # a 0.3 m machine; at three times that a hand tool fits in
    "cylinder2-engine/*": Known(unit="mm"),  # a GLB, but not in metres
    "hand-human/hand_*.obj": Known(unit="m", scale=0.2),
    "hand-human/cgal_fist.off": Known(unit="m", scale=0.1),
}
_STAGE_OFFSETS = re.compile(r"z offsets[^:]*:((?:\s+-?\d+\.\d+)+)\s*mm")


def find(folder: Path) -> tuple[list[Model], list[str]]:
    """All models below a folder, and the files that are none."""
    models, others = [], []
    for path in sorted(path for path in folder.rglob("*") if path.is_file()):
        name = path.relative_to(folder).as_posix()
        is_pack = name.lower().endswith(".tar.xz")
        if not is_pack and Path(name.removesuffix(".xz")).suffix.lower() not in MESHES:
            others.append(name)
            continue
        known = next((facts for pattern, facts in KNOWN.items() if fnmatch.fnmatch(name, pattern)), Known())
        is_tool = any(fnmatch.fnmatch(name.split("/")[0], pattern) for pattern in TOOL_FOLDERS)
        model = Model(name, path, path.stat().st_size / 1e6, is_tool, known.unit, known.scale)
        if is_pack:
            model.offsets = _stage_offsets(path.parent / "SOURCE.txt")
        models.append(model)
    return models, others


def _unpack(path: Path, target: Path) -> list[Path]:
    """The mesh files inside a .tar.xz, or the one that is a .xz."""
    target.mkdir(parents=True, exist_ok=True)
    if path.name.endswith(".tar.xz"):
        found = []
        with tarfile.open(path) as archive:
            for member in archive:
                # By its bare name, so that no archive can write outside of the folder.
                inside = target / Path(member.name).name
                source = archive.extractfile(member) if member.isfile() else None
                if source and inside.suffix.lower() in MESHES:
                    with source, inside.open("wb") as out:
                        shutil.copyfileobj(source, out)
                    found.append(inside)
        return sorted(found)
    inside = target / path.stem
    with lzma.open(path) as source, inside.open("wb") as out:
        shutil.copyfileobj(source, out)
    return [inside]


def _stage_offsets(source: Path) -> list[tuple[str, float]]:
    """Where the stages stand along z, if the SOURCE.txt lists it in millimetres, first stage first."""
    found = _STAGE_OFFSETS.search(source.read_text(encoding="utf-8")) if source.is_file() else None
    numbers = found[1].split() if found else []
    return [(f"*stage-{i}/*", float(number) * 1e-3) for i, number in enumerate(numbers, 1)]


def arrange(model: Model, loaded: feeler.Mockup) -> tuple[feeler.Mockup, float]:
    """The mock-up with its stages in place and at the size wanted, and the factor it was scaled by."""
    scale = model.scale
    size = max(loaded.report.extent)
    if scale == 1.0 and loaded.source.unit_source.startswith("assumed") and size < LEAST_SIZE_M:
        scale = 1.0 / size
    if scale == 1.0 and not model.offsets:
        return loaded, scale
    vertices = loaded.vertices * scale
    for pattern, offset in model.offsets:
        parts = [i for i, path in enumerate(loaded.part_paths) if fnmatch.fnmatch(path, pattern)]
        chosen = np.unique(loaded.faces[np.isin(loaded.part_of_face, parts)])
        vertices[chosen[chosen < len(vertices)], 2] += offset * scale
    moved = feeler.Mockup(
        vertices,
        loaded.faces,
        loaded.part_of_face,
        loaded.part_names,
        part_paths=loaded.part_paths,
        source=loaded.source,
    )
    return moved, scale


def sources(folder: Path) -> list[tuple[str, list[str]]]:
    """For each folder with a SOURCE.txt: its first line, and the lines that name an origin or a licence."""
    origin = re.compile(r"licen[cs]e|github|debian|\b(MIT|BSD|CC-BY)\b", re.IGNORECASE)
    found = []
    for path in sorted(folder.rglob("SOURCE.txt")):
        lines = path.read_text(encoding="utf-8").splitlines()
        kept = [line.strip() for number, line in enumerate(lines) if number == 0 or origin.search(line)]
        found.append((path.parent.relative_to(folder).as_posix(), kept))
    return found
