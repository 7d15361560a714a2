"""Write `meshopt_v0.gltf` and `meshopt_v1.gltf` with the reference encoder.

Each buffer view has its plain bytes in buffer 0, as the reference's decoder gives them back, beside what is packed: a
test may read either. The files hold a bumpy sheet with float positions through the exponential filter, and triangles; a
strip of the same sheet with 16-bit positions; and that strip 20 times, placed with filtered rotations.

Run: pip install meshoptimizer (needs a C++ compiler), then python testdata/files/make_meshopt.py
"""

from __future__ import annotations

import base64
import ctypes
import json
from pathlib import Path
from typing import Any

import numpy as np
from meshoptimizer import decoder, encoder
from meshoptimizer._loader import lib

SIDE = 24
NAMES = {0: "EXT_meshopt_compression", 1: "KHR_meshopt_compression"}


class Writer:
    """Collects plain and packed bytes, and the views and accessors on them."""

    def __init__(self, version: int) -> None:
        self.name = NAMES[version]
        self.plain = b""
        self.packed = b""
        self.views: list[dict[str, Any]] = []
        self.accessors: list[dict[str, Any]] = []

    def add(self, plain: bytes, packed: bytes, stride: int, count: int, mode: str, filter_name: str = "NONE") -> int:
        """Add a view of bytes that have been packed; return its number."""
        extension = {
            "buffer": 1, "byteOffset": len(self.packed), "byteLength": len(packed), "byteStride": stride,
            "count": count, "mode": mode, "filter": filter_name,
        }  # fmt: skip
        view = {"buffer": 0, "byteOffset": len(self.plain), "byteLength": stride * count}
        if mode == "ATTRIBUTES":
            view["byteStride"] = stride
        self.views.append(view | {"extensions": {self.name: extension}})
        self.plain += plain + b"\0" * (-len(plain) % 4)
        self.packed += packed + b"\0" * (-len(packed) % 4)
        return len(self.views) - 1

    def accessor(self, view: int, component: int, count: int, kind: str, **more: Any) -> int:
        """Add an accessor; return its number."""
        self.accessors.append({"bufferView": view, "componentType": component, "count": count, "type": kind, **more})
        return len(self.accessors) - 1

    def attributes(self, values: np.ndarray, filter_name: str = "NONE") -> int:
        """Pack rows; `values` is what the filter is to be applied to."""
        rows = np.ascontiguousarray(values).view(np.uint8).reshape(len(values), -1)
        stride = rows.shape[1]
        packed = encoder.encode_vertex_buffer(rows.view("<u4"))
        plain = rows
        if filter_name == "EXPONENTIAL":
            plain = decoder.decode_filter_exp(rows.copy().view("<i4").ravel(), rows.size // 4, 4)
        elif filter_name == "QUATERNION":
            plain = decoder.decode_filter_quat(rows.copy(), len(rows), 8)
        return self.add(np.ascontiguousarray(plain).tobytes(), packed, stride, len(rows), "ATTRIBUTES", filter_name)


def filtered(function: str, values: np.ndarray, stride: int, bits: int, *more: int) -> np.ndarray:
    """Return what the encoder of a filter makes of float rows."""
    data = np.ascontiguousarray(values, dtype="<f4")
    made = np.zeros((len(data), stride), dtype=np.uint8)
    getattr(lib, function)(
        made.ctypes.data_as(ctypes.c_void_p), ctypes.c_size_t(len(data)), ctypes.c_size_t(stride), ctypes.c_int(bits),
        data.ctypes.data_as(ctypes.POINTER(ctypes.c_float)), *[ctypes.c_int(m) for m in more],
    )  # fmt: skip
    return made


def write(version: int, path: Path) -> None:
    """Write the file whose attributes are streams of this version."""
    encoder.encode_vertex_version(version)
    encoder.encode_index_version(1)
    u, v = (axis.ravel() for axis in np.meshgrid(np.arange(SIDE), np.arange(SIDE), indexing="ij"))
    points = np.stack([u / 100, v / 100, np.sin(u * 0.7) * np.cos(v * 0.4) / 50], axis=1)
    grid = np.arange(SIDE * SIDE).reshape(SIDE, SIDE)
    lower = np.stack([grid[:-1, :-1], grid[1:, :-1], grid[:-1, 1:]], axis=-1).reshape(-1, 3)
    upper = np.stack([grid[1:, :-1], grid[1:, 1:], grid[:-1, 1:]], axis=-1).reshape(-1, 3)
    faces = np.stack([lower, upper], axis=1).reshape(-1).astype("<u4")
    out = Writer(version)

    exact = filtered("meshopt_encodeFilterExp", points, 12, 15, 0)
    position = out.accessor(out.attributes(exact, "EXPONENTIAL"), 5126, len(points), "VEC3")
    packed = encoder.encode_index_buffer(faces)
    plain = decoder.decode_index_buffer(len(faces), 4, packed).astype("<u4")
    triangles = out.accessor(out.add(plain.tobytes(), packed, 4, len(faces), "TRIANGLES"), 5125, len(faces), "SCALAR")

    whole = np.zeros((len(points), 4), dtype="<i2")
    whole[:, :3] = np.round(points * 32767)
    small = out.accessor(out.attributes(whole), 5122, len(points), "VEC3", normalized=True)
    strip = np.stack([grid[0], grid[1]], axis=1).reshape(-1).astype("<u2")
    packed = encoder.encode_index_sequence(strip.astype("<u4"))
    one_strip = out.accessor(out.add(strip.tobytes(), packed, 2, len(strip), "INDICES"), 5123, len(strip), "SCALAR")

    angles = np.linspace(0, 3, 20)
    turns = np.stack([np.sin(angles / 2), 0 * angles, 0 * angles, np.cos(angles / 2)], axis=1)
    turns = filtered("meshopt_encodeFilterQuat", turns, 8, 12)
    rotation = out.accessor(out.attributes(turns, "QUATERNION"), 5122, len(angles), "VEC4", normalized=True)
    moves = np.stack([angles, 0 * angles, 0 * angles], axis=1).astype("<f4")
    translation = out.accessor(out.attributes(moves), 5126, len(angles), "VEC3")

    spread = {"EXT_mesh_gpu_instancing": {"attributes": {"TRANSLATION": translation, "ROTATION": rotation}}}
    root = {
        "asset": {"version": "2.0"},
        "scene": 0,
        "scenes": [{"nodes": [0, 1, 2]}],
        "nodes": [
            {"mesh": 0, "name": "sheet"}, {"mesh": 1, "name": "strip", "translation": [0, 0, 1]},
            {"mesh": 1, "name": "many", "extensions": spread},
        ],
        "meshes": [
            {"primitives": [{"attributes": {"POSITION": position}, "indices": triangles}]},
            {"primitives": [{"attributes": {"POSITION": small}, "indices": one_strip, "mode": 5}]},
        ],
        "accessors": out.accessors,
        "bufferViews": out.views,
        "buffers": [
            {"byteLength": len(data), "uri": "data:application/octet-stream;base64," + base64.b64encode(data).decode()}
            for data in (out.plain, out.packed)
        ],
        "extensionsUsed": [out.name, "EXT_mesh_gpu_instancing", "KHR_mesh_quantization"],
    }  # fmt: skip
    path.write_text(json.dumps(root, indent=1) + "\n")


if __name__ == "__main__":
    for number in NAMES:
        write(number, Path(__file__).with_name(f"meshopt_v{number}.gltf"))
