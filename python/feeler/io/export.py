"""GLB and binary STL writers.

Our own, because a mock-up of 4,000 parts must be written in about a second: the only object per part is its JSON.

Precision: GLB and STL store float32. Positions within 8 m of the origin are rounded by at most 0.24 micrometres. A GLB
part that extends farther is stored around its own centre, so that the rounding depends on its size and not on its
place. Axes do not change (glTF calls y "up"; a mock-up has no such convention), the unit is metres.
"""

from __future__ import annotations

import json
import os
import struct
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
import numpy.typing as npt

from feeler.arguments import check_array, check_kind, check_list, check_whole, check_word
from feeler.atomic import atomic_file
from feeler.choices import STL_UNITS, StlUnit
from feeler.errors import MeshError, OptionError
from feeler.io.body import Body, FloatArray, MeshLike, body_of
from feeler.io.gltf_document import OWN_GENERATOR
from feeler.poses import quaternion

# Beyond this distance from the origin a part gets an origin of its own; float32 is spaced 0.5 micrometres below 8 m.
OWN_ORIGIN_BEYOND_M = 8.0
_UINT16_VERTICES = 65_535  # 65535 itself is reserved by glTF as the strip restart
_STL_PER_METRE: dict[StlUnit, float] = {"m": 1.0, "cm": 100.0, "mm": 1000.0, "in": 1.0 / 0.0254, "inch": 1.0 / 0.0254}


def write_glb(path: str | os.PathLike[str], *meshes: MeshLike, colours: npt.ArrayLike | None = None) -> int:
    """Writes mock-ups, tools or bodies as one binary glTF 2.0 file; returns its size in bytes.

    One node and one mesh per part, named after the part, nested as in the part paths ("a/b/c"); a part with several
    colours has one primitive per colour. A part without triangles keeps its node, without a mesh. Attributes of parts
    are the `extras` of nodes, and `material` names the materials, too. colours: as for `body_of`, used for meshes that
    are not a `Body`. Raises `WriteError`, `MeshError`, `OptionError`.
    """
    bodies = [body_of(mesh, colours=colours) for mesh in meshes]
    if not bodies:
        raise MeshError("nothing to write: pass at least one mock-up, tool or body")
    document = _Document()
    for body in bodies:
        document.add(body)
    chunks = document.chunks()
    size = sum(len(chunk) for chunk in chunks)
    if size >= 2**32:
        raise MeshError(f"{path}: the file would have {size} bytes; GLB ends at 4 GiB. Write fewer parts")
    with atomic_file(path, ".glb") as file:
        for chunk in chunks:
            file.write(chunk)
    return size


@dataclass(frozen=True, eq=False)
class Motion:
    """The motion of a part. times: `(k,)` seconds, ascending; poses: `(k, 4, 4)` world_from_part, the identity at
    home; both are kept as arrays."""

    part: int
    times: FloatArray
    poses: FloatArray

    def __post_init__(self) -> None:
        check_whole("part", self.part, 0)
        times = check_array("times", self.times, (None,))
        if (np.diff(times) < 0.0).any():
            raise OptionError("times do not ascend: give seconds, (k,), in order")
        object.__setattr__(self, "times", times)
        object.__setattr__(self, "poses", check_array("poses", self.poses, (len(times), 4, 4)))


def animated_glb(mesh: MeshLike, motions: Sequence[Motion], *, colours: npt.ArrayLike | None = None) -> bytes:
    """A binary glTF 2.0 file of a mock-up, tool or body whose parts move; `part` of a motion is one of the mesh's.

    As `write_glb`; between two poses a part moves straight, and turns the shorter way. Times are stored as float32.
    Raises `MeshError`, and `OptionError` for parts that are not there, for motions without times, and for times that
    are negative, beyond float32, or equal there.
    """
    body = body_of(mesh, colours=colours)
    document = _Document()
    document.add(body)
    for each in check_list("motions", motions, "a list of feeler.io.Motion"):
        motion = check_kind("motions", each, Motion, "feeler.io.Motion objects")
        check_whole("part", motion.part, 0, len(body.paths) - 1)
        document.animate(motion)
    chunks = document.chunks()
    if sum(len(chunk) for chunk in chunks) >= 2**32:
        raise MeshError("the animation would have more than 4 GiB, where GLB ends: show fewer parts")
    return b"".join(chunks)


def write_stl(path: str | os.PathLike[str], mesh: MeshLike, *, unit: StlUnit = "mm") -> int:
    """Writes a binary STL, all parts in one; returns its size in bytes.

    STL stores no unit; `unit` is the unit of the written numbers. Other programs, and `feeler.load_mockup`, expect
    millimetres. Raises `WriteError`, `OptionError`.
    """
    check_word("unit", unit, STL_UNITS)
    body = body_of(mesh)
    record = np.dtype([("normal", "<f4", 3), ("corners", "<f4", (3, 3)), ("attribute", "<u2")])
    triangles = np.zeros(len(body.faces), dtype=record)
    corners = body.vertices[body.faces]
    normals = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
    lengths = np.sqrt(np.einsum("ij,ij->i", normals, normals))
    triangles["normal"] = normals / np.where(lengths > 0, lengths, 1.0)[:, None]
    triangles["corners"] = corners * _STL_PER_METRE[unit]
    header = f"feeler binary STL, unit {unit}".encode().ljust(80)
    with atomic_file(path, ".stl") as file:
        file.write(header + struct.pack("<I", len(triangles)))
        file.write(_bytes(triangles))
    return 84 + triangles.nbytes


def _moments(times: FloatArray) -> npt.NDArray[np.float32]:
    """Times as glTF keeps them, of which each is later than the one before and none is negative."""
    if not len(times):
        raise OptionError("a motion has no times: give one pose or more")
    if times[0] < 0.0:
        raise OptionError(f"times begin at {times[0]:g} s: glTF has no negative times, count them from 0 on")
    if times[-1] > np.finfo(np.float32).max:
        raise OptionError(f"times reach {times[-1]:g} s, which float32 cannot hold: count them from 0 on")
    kept = times.astype(np.float32)
    same = np.flatnonzero(np.diff(kept) <= 0.0)
    if len(same):
        first, second = times[same[0]], times[same[0] + 1]
        raise OptionError(
            f"the times {first!s} and {second!s} s are equal in float32, as which glTF keeps them: count them from 0 "
            "on, each later than the one before"
        )
    return kept


class _Document:
    """A glTF document under construction: JSON lists and the three blocks of the binary chunk."""

    def __init__(self) -> None:
        self.nodes: list[dict[str, Any]] = []
        self.roots: list[int] = []
        self.meshes: list[dict[str, Any]] = []
        self.accessors: list[dict[str, Any]] = []
        self.materials: dict[tuple[tuple[float, ...], str], int] = {}
        self.animation: dict[str, list[dict[str, Any]]] = {"samplers": [], "channels": []}
        # The node of each part, and where its mesh has its origin.
        self.part_nodes: list[tuple[int, FloatArray]] = []
        # Buffer views: positions, 32-bit indices, 16-bit indices, motions; each start is aligned as written.
        self.blocks: list[list[bytes | memoryview]] = [[], [], [], []]
        self.sizes = [0, 0, 0, 0]

    def add(self, body: Body) -> None:
        """Adds the parts of a body under nodes that follow their paths."""
        order, starts = _group(body.part_of_face, body.colour_of_face, len(body.paths), len(body.palette))
        positions, first_vertex, local = _split_vertices(body, order)
        local16 = local.astype(np.uint16)
        # Runs of equal (part, colour) along the ordered triangles.
        runs: list[list[tuple[int, int, int]]] = [[] for _ in body.paths]
        for part, colour, begin, end in starts:
            runs[part].append((colour, begin, end))

        lower, upper = _bounds_of_parts(positions, first_vertex)
        origins = np.zeros_like(lower)
        far = np.maximum(np.abs(lower), np.abs(upper)).max(axis=1, initial=0.0) > OWN_ORIGIN_BEYOND_M
        origins[far] = (lower[far] + upper[far]) / 2
        if far.any():
            positions = positions - np.repeat(origins, np.diff(first_vertex), axis=0)
        single = positions.astype(np.float32)
        # glTF requires the bounds of the stored, rounded numbers; rounding keeps order.
        low32 = (lower - origins).astype(np.float32).tolist()
        high32 = (upper - origins).astype(np.float32).tolist()
        position_base = self._append(0, _bytes(single))
        folders: dict[str, int] = {}
        for part, path in enumerate(body.paths):
            node: dict[str, Any] = {"name": path.rpartition("/")[2]}
            own = {} if body.attributes is None else body.attributes[part]
            if own:
                node["extras"] = dict(own)
            self.part_nodes.append((len(self.nodes), origins[part]))
            self._attach(node, path.rpartition("/")[0], folders)
            if not runs[part]:
                continue
            begin, end = int(first_vertex[part]), int(first_vertex[part + 1])
            position = self._accessor(0, position_base + 12 * begin, 5126, end - begin, "VEC3")
            self.accessors[position].update(min=low32[part], max=high32[part])
            if far[part]:
                node["translation"] = origins[part].tolist()
            wide = end - begin > _UINT16_VERTICES
            primitives = []
            for colour, start, stop in runs[part]:
                block, kind, source = (1, 5125, local) if wide else (2, 5123, local16)
                offset = self._append(block, _bytes(source[start:stop]))
                indices = self._accessor(block, offset, kind, 3 * (stop - start), "SCALAR")
                primitives.append(
                    {
                        "attributes": {"POSITION": position},
                        "indices": indices,
                        "material": self._material(body.palette[colour], own.get("material", "")),
                    }
                )
            node["mesh"] = len(self.meshes)
            self.meshes.append({"name": node["name"], "primitives": primitives})

    def animate(self, motion: Motion) -> None:
        """Moves a part's node, with its children if there are any."""
        node, origin = self.part_nodes[motion.part]
        times = _moments(motion.times)
        turns = np.array([quaternion(pose[:3, :3]) for pose in motion.poses])
        for i in range(1, len(turns)):
            # Both signs are the same rotation; the nearer one is the shorter way.
            if turns[i] @ turns[i - 1] < 0:
                turns[i] = -turns[i]
        shifts = motion.poses[:, :3, :3] @ origin + motion.poses[:, :3, 3]
        moments = self._accessor(3, self._append(3, _bytes(times)), 5126, len(times), "SCALAR")
        self.accessors[moments].update(min=[float(times.min())], max=[float(times.max())])
        for path, values, kind in (("translation", shifts, "VEC3"), ("rotation", turns, "VEC4")):
            offset = self._append(3, _bytes(values.astype(np.float32)))
            output = self._accessor(3, offset, 5126, len(values), kind)
            target = {"node": node, "path": path}
            self.animation["channels"].append({"sampler": len(self.animation["samplers"]), "target": target})
            self.animation["samplers"].append({"input": moments, "output": output, "interpolation": "LINEAR"})

    def chunks(self) -> list[bytes | memoryview]:
        """The file, in pieces to write in order."""
        views: list[dict[str, int]] = []
        targets = {0: {"target": 34962}, 1: {"target": 34963}, 2: {"target": 34963}, 3: {}}
        binary: list[bytes | memoryview] = []
        view_of_block: dict[int, int] = {}
        offset = 0
        for block in (0, 1, 3, 2):
            if not self.sizes[block]:
                continue
            view_of_block[block] = len(views)
            views.append({"buffer": 0, "byteOffset": offset, "byteLength": self.sizes[block], **targets[block]})
            binary += self.blocks[block]
            offset += self.sizes[block]
        for accessor in self.accessors:
            accessor["bufferView"] = view_of_block[accessor["bufferView"]]
        document: dict[str, Any] = {
            "asset": {"version": "2.0", "generator": OWN_GENERATOR},
            "scene": 0,
            "scenes": [{"nodes": self.roots}],
            "nodes": self.nodes,
        }
        if self.meshes:
            document.update(
                meshes=self.meshes,
                accessors=self.accessors,
                bufferViews=views,
                buffers=[{"byteLength": offset}],
                materials=[_material_json(*each) for each in self.materials],
            )
        if self.animation["channels"]:
            document["animations"] = [self.animation]
        # Lone surrogates in names, which no reader takes, become question marks.
        text = json.dumps(document, separators=(",", ":"), ensure_ascii=False).encode("utf-8", "replace")
        text += b" " * (-len(text) % 4)
        padding = b"\0" * (-offset % 4)
        total = 12 + 8 + len(text) + ((8 + offset + len(padding)) if offset else 0)
        head = struct.pack("<4sII", b"glTF", 2, min(total, 2**32 - 1)) + struct.pack("<I4s", len(text), b"JSON") + text
        if not offset:
            return [head]
        return [head, struct.pack("<I4s", min(offset + len(padding), 2**32 - 1), b"BIN\0"), *binary, padding]

    def _append(self, block: int, data: memoryview) -> int:
        offset = self.sizes[block]
        if len(data):
            self.blocks[block].append(data)
            self.sizes[block] += len(data)
        return offset

    def _accessor(self, block: int, offset: int, component: int, count: int, kind: str) -> int:
        entry = {"bufferView": block, "byteOffset": offset, "componentType": component, "count": count, "type": kind}
        self.accessors.append(entry)
        return len(self.accessors) - 1

    def _material(self, colour: FloatArray, name: str) -> int:
        """The material of a colour, called as the part's attribute "material"; parts share it."""
        return self.materials.setdefault((tuple(colour.tolist()), name), len(self.materials))

    def _attach(self, node: dict[str, Any], folder: str, folders: dict[str, int]) -> None:
        """Appends a node to the node of its folder, which is created if missing."""
        index = len(self.nodes)
        self.nodes.append(node)
        while folder:
            known = folders.get(folder)
            if known is not None:
                self.nodes[known]["children"].append(index)
                return
            parent = len(self.nodes)
            self.nodes.append({"name": folder.rpartition("/")[2], "children": [index]})
            folders[folder] = parent
            index, folder = parent, folder.rpartition("/")[0]
        self.roots.append(index)


def _group(
    part_of_face: npt.NDArray[Any], colour_of_face: npt.NDArray[Any], parts: int, colours: int
) -> tuple[npt.NDArray[np.int64], list[tuple[int, int, int, int]]]:
    """Triangle order by (part, colour), stable, and its runs (part, colour, begin, end)."""
    key = part_of_face.astype(np.int64) * colours + colour_of_face
    if parts * colours < 2**16:  # NumPy sorts 16-bit integers by radix, many times faster
        order = np.argsort(key.astype(np.uint16), kind="stable")
    else:
        order = np.argsort(key, kind="stable")
    ordered = key[order]
    edges = np.flatnonzero(np.diff(ordered)) + 1
    begins = np.concatenate([[0], edges]).astype(np.int64) if len(key) else np.zeros(0, dtype=np.int64)
    ends = np.append(edges, len(key)) if len(key) else begins
    runs = [
        (int(k) // colours, int(k) % colours, int(b), int(e))
        for k, b, e in zip(ordered[begins], begins, ends, strict=True)
    ]
    return order, runs


def _split_vertices(
    body: Body, order: npt.NDArray[np.int64]
) -> tuple[FloatArray, npt.NDArray[np.int64], npt.NDArray[np.uint32]]:
    """Vertices part by part, the first vertex of each part, and the ordered triangles' indices within their part."""
    faces = body.faces[order].astype(np.int64)
    part = body.part_of_face[order].astype(np.int64)
    count = len(body.paths)
    owner = np.full(len(body.vertices), -1, dtype=np.int64)
    owner[faces] = part[:, None]
    if np.array_equal(owner[faces], np.broadcast_to(part[:, None], faces.shape)):
        # Usual: no vertex is shared between parts.
        used = np.flatnonzero(owner >= 0)
        owner_used = owner[used]
        rank = np.argsort(owner_used.astype(np.uint16) if count < 2**16 else owner_used, kind="stable")
        vertex = used[rank]
        sizes = np.bincount(owner_used, minlength=count)
        new_index = np.zeros(len(body.vertices), dtype=np.int64)
        new_index[vertex] = np.arange(len(vertex))
        flat = new_index[faces]
    else:
        keys, inverse = np.unique(part[:, None] * len(body.vertices) + faces, return_inverse=True)
        vertex = keys % len(body.vertices)
        sizes = np.bincount(keys // len(body.vertices), minlength=count)
        flat = np.asarray(inverse).reshape(faces.shape)
    first = np.concatenate([[0], np.cumsum(sizes)]).astype(np.int64)
    local = np.ascontiguousarray((flat - first[part][:, None]).astype(np.uint32))
    return body.vertices[vertex], first, local


def _bounds_of_parts(positions: FloatArray, first: npt.NDArray[np.int64]) -> tuple[FloatArray, FloatArray]:
    """Lower and upper corner of each part, (parts, 3); zeros for a part without vertices."""
    lower = np.zeros((len(first) - 1, 3))
    upper = np.zeros((len(first) - 1, 3))
    filled = np.flatnonzero(np.diff(first) > 0)
    if len(filled):
        lower[filled] = np.minimum.reduceat(positions, first[:-1][filled], axis=0)
        upper[filled] = np.maximum.reduceat(positions, first[:-1][filled], axis=0)
    return lower, upper


def _bytes(array: npt.NDArray[Any]) -> memoryview:
    """The bytes of an array, without a copy where it is contiguous."""
    return memoryview(np.ascontiguousarray(array).reshape(-1).view(np.uint8).data)


def _material_json(colour: Sequence[float], name: str) -> dict[str, Any]:
    # glTF wants linear light; colours are given as sRGB, as people read them.
    linear = [round(c / 12.92 if c <= 0.04045 else ((c + 0.055) / 1.055) ** 2.4, 6) for c in colour]
    return {
        **({"name": name} if name else {}),
        "pbrMetallicRoughness": {
            "baseColorFactor": [*linear, 1.0],
            "metallicFactor": 0.1,
            "roughnessFactor": 0.6,
        },
        "doubleSided": True,
    }
