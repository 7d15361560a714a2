"""What the tests of loading share."""

from __future__ import annotations

import json
import struct
from pathlib import Path
from typing import Any

import numpy as np
import numpy.typing as npt

from feeler import Mockup


def save(folder: Path, name: str, content: bytes | str) -> Path:
    path = folder / name
    path.write_bytes(content.encode() if isinstance(content, str) else content)
    return path


def soup(mockup: Mockup) -> np.ndarray:
    """The corners of every triangle, (m, 3, 3), metres."""
    return mockup.vertices[mockup.faces]


def notes(mockup: Mockup) -> str:
    return "\n".join(mockup.report.source.notes)


CORNERS = np.array([[0, 0, 0], [1, 0, 0], [0, 1, 0], [0, 0, 1]], dtype="<f4")
TETRAHEDRON = np.array([[0, 2, 1], [0, 1, 3], [1, 2, 3], [0, 3, 2]])


def instances(
    path: Path,
    nodes: list[dict[str, Any]],
    extras: object = None,
    materials: object = None,
    mesh: tuple[npt.ArrayLike, npt.ArrayLike] = (CORNERS, TETRAHEDRON),
) -> Path:
    """A GLB file with a mesh at every node. extras: of the mesh. materials: the mesh has the first one."""
    points, faces = np.asarray(mesh[0], "<f4"), np.asarray(mesh[1], "<u4")
    data = points.tobytes() + faces.tobytes()
    primitive = {"attributes": {"POSITION": 0}, "indices": 1, **({} if materials is None else {"material": 0})}
    document: dict[str, Any] = {
        "asset": {"version": "2.0"},
        "buffers": [{"byteLength": len(data)}],
        "bufferViews": [
            {"buffer": 0, "byteLength": points.nbytes},
            {"buffer": 0, "byteOffset": points.nbytes, "byteLength": faces.nbytes},
        ],
        "accessors": [
            {"bufferView": 0, "componentType": 5126, "count": len(points), "type": "VEC3"},
            {"bufferView": 1, "componentType": 5125, "count": faces.size, "type": "SCALAR"},
        ],
        "meshes": [{"primitives": [primitive], **({} if extras is None else {"extras": extras})}],
        "nodes": [{"mesh": 0, **node} for node in nodes],
        "scenes": [{"nodes": list(range(len(nodes)))}],
        **({} if materials is None else {"materials": materials}),
    }
    text = json.dumps(document).encode()
    text += b" " * (-len(text) % 4)
    chunks = struct.pack("<II", len(text), 0x4E4F534A) + text + struct.pack("<II", len(data), 0x004E4942) + data
    return save(path.parent, path.name, b"glTF" + struct.pack("<II", 2, 12 + len(chunks)) + chunks)
