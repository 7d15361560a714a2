"""Writers of small mesh files for the loader's tests: each returns bytes, and no test is in here."""

from __future__ import annotations

import io
import json
import struct
import zipfile
from typing import Any

import numpy as np
import numpy.typing as npt

# A tetrahedron: four corners, four triangles, nothing in it equal to anything else.
CORNERS = np.array([[0.0, 0.0, 0.0], [10.0, 0.0, 0.0], [0.0, 20.0, 0.0], [0.0, 0.0, 30.0]])
FACES = np.array([[0, 2, 1], [0, 1, 3], [1, 2, 3], [2, 0, 3]])
SOUP = CORNERS[FACES]


def stl_binary(soup: npt.NDArray[Any] = SOUP, header: bytes = b"made by a test") -> bytes:
    records = np.zeros(len(soup), dtype=[("normal", "<f4", 3), ("corners", "<f4", (3, 3)), ("spare", "<u2")])
    records["corners"] = soup
    return header.ljust(80, b"\0") + struct.pack("<I", len(soup)) + records.tobytes()


def stl_text(solids: dict[str, npt.NDArray[Any]] | None = None) -> str:
    lines = []
    for name, soup in (solids or {"tet": SOUP}).items():
        lines.append(f"solid {name}".rstrip())
        for triangle in soup:
            lines += ["  facet normal 0 0 1", "    outer loop"]
            lines += ["      vertex " + " ".join(repr(float(v)) for v in corner) for corner in triangle]
            lines += ["    endloop", "  endfacet"]
        lines.append(f"endsolid {name}".rstrip())
    return "\n".join(lines) + "\n"


def obj_text() -> str:
    """Two objects, one of them with two groups; slashes, a relative index, a quad, a line and a point."""
    return "\n".join(
        [
            "# comment", "mtllib none.mtl", "o frame", *(f"v {x} {y} {z} # c" for x, y, z in CORNERS.tolist()),
            "vn 0 0 1", "vt 0 0", "g left side", "f 1/1/1 3/1/1 2/1/1", "f 1//1 2//1 4//1", "g right", "usemtl red",
            "f -3 -2 -1", "l 1 2", "p 1", "o plate", "g", "v 0 0 5", "v 1 0 5", "v 1 1 5", "v 0 1 5", "f 5 6 7 8", "",
        ]
    )  # fmt: skip


def off_text() -> str:
    rows = [f"{x} {y} {z}" for x, y, z in CORNERS.tolist()]
    return "\n".join(["OFF", "# comment", "4 4 6", "", *rows, *(f"3 {a} {b} {c} 255 0 0" for a, b, c in FACES), ""])


def ply(encoding: str, faces: list[list[int]] | None = None, extra_face_values: bool = False) -> bytes:
    """A PLY file with a property before x, a normal after z, and lists of what length the faces have."""
    rows = FACES.tolist() if faces is None else faces
    head = f"ply\nformat {encoding} 1.0\ncomment test\nelement vertex {len(CORNERS)}\nproperty uchar red\n"
    head += "property float x\nproperty float y\nproperty float z\nproperty double nx\n"
    head += f"element face {len(rows)}\n" + ("property list uchar float texcoord\n" if extra_face_values else "")
    head += "property list uchar int vertex_indices\nend_header\n"
    order = {"ascii": "", "binary_little_endian": "<", "binary_big_endian": ">"}[encoding]
    if not order:
        text = "".join(f"7 {x} {y} {z} 0.5\n" for x, y, z in CORNERS.tolist())
        prefix = "2 0.5 0.5 " if extra_face_values else ""
        return (head + text + "".join(f"{prefix}{len(r)} {' '.join(map(str, r))}\n" for r in rows)).encode()
    body = b"".join(struct.pack(order + "B3fd", 7, *corner, 0.5) for corner in CORNERS.tolist())
    for row in rows:
        body += struct.pack(order + "B2f", 2, 0.5, 0.5) if extra_face_values else b""
        body += struct.pack(f"{order}B{len(row)}i", len(row), *row)
    return head.encode() + body


class Gltf:
    """Builds a glTF document piece by piece."""

    def __init__(self) -> None:
        self.root: dict[str, Any] = {
            "asset": {"version": "2.0"}, "scene": 0, "scenes": [{"nodes": []}], "nodes": [], "meshes": [],
            "accessors": [], "bufferViews": [], "buffers": [{"byteLength": 0}],
        }  # fmt: skip
        self.blob = b""

    def view(self, data: bytes, stride: int | None = None) -> int:
        self.blob += b"\0" * (-len(self.blob) % 4)
        view: dict[str, Any] = {"buffer": 0, "byteOffset": len(self.blob), "byteLength": len(data)}
        if stride:
            view["byteStride"] = stride
        self.root["bufferViews"].append(view)
        self.blob += data
        self.root["buffers"][0]["byteLength"] = len(self.blob)
        return len(self.root["bufferViews"]) - 1

    def accessor(self, values: npt.NDArray[Any], kind: str, **more: Any) -> int:
        code = {"f4": 5126, "u1": 5121, "u2": 5123, "u4": 5125, "i2": 5122}[values.dtype.str[1:]]
        accessor = {
            "bufferView": self.view(values.tobytes()),
            "componentType": code,
            "count": len(values),
            "type": kind,
        }
        self.root["accessors"].append({**accessor, **more})
        return len(self.root["accessors"]) - 1

    def mesh(
        self,
        corners: npt.NDArray[Any] = CORNERS,
        indices: npt.NDArray[Any] | None = FACES,
        name: str | None = None,
        mode: int | None = None,
    ) -> int:
        primitive: dict[str, Any] = {"attributes": {"POSITION": self.accessor(corners.astype("<f4"), "VEC3")}}
        if indices is not None:
            primitive["indices"] = self.accessor(indices.astype("<u4").ravel(), "SCALAR")
        if mode is not None:
            primitive["mode"] = mode
        self.root["meshes"].append({"primitives": [primitive]} | ({"name": name} if name else {}))
        return len(self.root["meshes"]) - 1

    def node(self, is_root: bool = True, **node: Any) -> int:
        self.root["nodes"].append(node)
        if is_root:
            self.root["scenes"][0]["nodes"].append(len(self.root["nodes"]) - 1)
        return len(self.root["nodes"]) - 1

    def glb(self) -> bytes:
        text = json.dumps(self.root).encode()
        text += b" " * (-len(text) % 4)
        blob = self.blob + b"\0" * (-len(self.blob) % 4)
        chunks = struct.pack("<II", len(text), 0x4E4F534A) + text + struct.pack("<II", len(blob), 0x004E4942) + blob
        return b"glTF" + struct.pack("<II", 2, 12 + len(chunks)) + chunks

    def gltf(self, uri: str) -> bytes:
        self.root["buffers"][0]["uri"] = uri
        return json.dumps(self.root).encode()


CORE = 'xmlns="http://schemas.microsoft.com/3dmanufacturing/core/2015/02"'


def threemf_mesh(number: int, name: str = "") -> str:
    label = f' name="{name}"' if name else ""
    vertices = "".join(f'<vertex x="{x}" y="{y}" z="{z}"/>' for x, y, z in CORNERS.tolist())
    triangles = "".join(f'<triangle v1="{a}" v2="{b}" v3="{c}"/>' for a, b, c in FACES.tolist())
    mesh = f"<mesh><vertices>{vertices}</vertices><triangles>{triangles}</triangles></mesh>"
    return f'<object id="{number}" type="model"{label}>{mesh}</object>'


def threemf_components(number: int, name: str, uses: list[tuple[int, str]]) -> str:
    inner = "".join(f'<component objectid="{u}"' + (f' transform="{t}"' if t else "") + "/>" for u, t in uses)
    return f'<object id="{number}" name="{name}"><components>{inner}</components></object>'


def threemf(resources: str, items: str, unit: str = "inch", prolog: str = "") -> bytes:
    model = (
        f'<?xml version="1.0"?>{prolog}<model unit="{unit}" {CORE}><resources>{resources}</resources>'
        f"<build>{items}</build></model>"
    )
    return zipped({"3D/3dmodel.model": model.encode()})


def zipped(members: dict[str, bytes]) -> bytes:
    out = io.BytesIO()
    with zipfile.ZipFile(out, "w", zipfile.ZIP_DEFLATED) as archive:
        for name, data in members.items():
            archive.writestr(name, data)
    return out.getvalue()
