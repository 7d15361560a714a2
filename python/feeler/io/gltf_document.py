"""The container of glTF 2.0: JSON, buffers and accessors, with every offset checked against the available bytes."""

from __future__ import annotations

import base64
import binascii
import json
import re
from pathlib import Path
from typing import Any
from urllib.parse import unquote

import numpy as np
from numpy.typing import NDArray

from feeler.errors import LoadError
from feeler.io import meshopt
from feeler.io.cache import note_read
from feeler.io.limits import check_memory
from feeler.io.text import decoded, utf8_text

OWN_GENERATOR = "feeler"
"""`asset.generator` of the files that feeler writes."""

_GLB_MAGIC, _JSON_CHUNK, _BIN_CHUNK = b"glTF", 0x4E4F534A, 0x004E4942
_COMPONENTS: dict[int, np.dtype[Any]] = {
    5120: np.dtype("<i1"),
    5121: np.dtype("<u1"),
    5122: np.dtype("<i2"),
    5123: np.dtype("<u2"),
    5125: np.dtype("<u4"),
    5126: np.dtype("<f4"),
}
_WIDTHS = {"SCALAR": 1, "VEC2": 2, "VEC3": 3, "VEC4": 4, "MAT4": 16}
_SCHEME = re.compile(r"^[A-Za-z][A-Za-z0-9+.-]*:")
_MESHOPT = ("EXT_meshopt_compression", "KHR_meshopt_compression")
UNDERSTOOD = {
    "EXT_mesh_gpu_instancing",
    "KHR_draco_mesh_compression",
    "KHR_mesh_quantization",
    "KHR_node_visibility",
    *_MESHOPT,
    # Appearance, sounds and metadata only: they do not move a vertex.
    "KHR_lights_punctual", "KHR_texture_transform", "KHR_texture_basisu", "EXT_texture_webp", "EXT_texture_avif",
    "KHR_xmp_json_ld", "KHR_animation_pointer", "MSFT_texture_dds", "KHR_node_selectability", "KHR_node_hoverability",
    "EXT_lights_image_based", "EXT_lights_ies", "EXT_mesh_features", "EXT_instance_features",
    "EXT_structural_metadata", "CESIUM_primitive_outline", "KHR_audio_emitter",
}  # fmt: skip
_LOOKS = ("KHR_materials_", "EXT_materials_", "ADOBE_materials_", "MSFT_packing_")


class Document:
    """One glTF file: its JSON, and accessors as arrays. `array` reads one on demand."""

    def __init__(self, path: Path) -> None:
        self.path = path
        data = path.read_bytes()
        self._binary: memoryview | None = None
        self.doubts: list[str] = []
        text = self._split_glb(data) if data[:4] == _GLB_MAGIC else data
        # Memory of its Python objects: a list or object about 100 bytes, any other value about 64.
        values = 100 * (text.count(b"[") + text.count(b"{")) + 64 * text.count(b",")
        check_memory(2 * len(text) + values, f"{path}: its JSON")
        if text is data and not decoded(data).lstrip().startswith(b"{"):
            raise self.fail("this is neither a GLB file nor the JSON of glTF")
        readable = utf8_text(decoded(text), path)
        try:
            root = json.loads(readable)
        except RecursionError:
            raise self.fail("the JSON is nested too deeply to be a glTF file") from None
        except ValueError as error:
            raise self.fail(f"the JSON is damaged ({error})") from error
        if not isinstance(root, dict) or not isinstance(root.get("asset"), dict):
            raise self.fail("the JSON has no 'asset': this is not a glTF file")
        self.root: dict[str, Any] = root
        version = str(root["asset"].get("version"))
        if not version.startswith("2"):
            raise self.fail(f"this is glTF {version[:10]}, and only glTF 2 is read; convert it", damaged=False)
        needed = root["asset"].get("minVersion", "2.0")
        if needed != "2.0":
            raise self.fail(f"it needs a reader of glTF {needed!s:.10}; 2.0 is read: convert it", damaged=False)
        self.required = self._check_extensions()
        self._buffers: dict[int, memoryview] = {}
        self._unpacked: dict[int, memoryview] = {}

    def fail(self, what: str, damaged: bool = True) -> LoadError:
        """Return the error for this file."""
        return LoadError(f"{self.path}: {what}" + ("; export the file again" if damaged else ""))

    def item(self, collection: str, index: object) -> dict[str, Any]:
        """Return `root[collection][index]`, or raise if it does not exist."""
        items = self.root.get(collection, [])
        if (
            not isinstance(index, int)
            or isinstance(index, bool)
            or not isinstance(items, list)
            or not 0 <= index < len(items)
        ):
            count = len(items) if isinstance(items, list) else 0
            raise self.fail(f"{collection}[{str(index)[:20]}] is referenced, but there are {count}")
        found = items[index]
        if not isinstance(found, dict):
            raise self.fail(f"{collection}[{index}] is not an object")
        return found

    def count(self, index: object) -> int:
        """Return the number of elements of an accessor, after a check that its buffer view is large enough."""
        accessor = self.item("accessors", index)
        count = self._natural(accessor, "count", f"accessors[{index}]")
        if "bufferView" in accessor:
            length = self._natural(self.item("bufferViews", accessor["bufferView"]), "byteLength", "a buffer view")
            if count > length:
                raise self.fail(f"accessors[{index}] has {count:,} elements and its buffer view {length:,} bytes")
        return count

    def array(self, index: object, width: int, *, normalise: bool = False) -> NDArray[Any]:
        """Return accessor `index` as (count, width), or (count,) for width 1; its own type, normalised ones float32.

        `normalise`: integers are, even if the accessor does not say so.
        """
        accessor = self.item("accessors", index)
        where = f"accessors[{index}]"
        dtype = _COMPONENTS.get(accessor.get("componentType", -1))
        if dtype is None or _WIDTHS.get(str(accessor.get("type"))) != width:
            raise self.fail(
                f"{where} has componentType {str(accessor.get('componentType'))[:20]} and type "
                f"{str(accessor.get('type'))[:20]}, which does not fit its use"
            )
        count = self._natural(accessor, "count", where)
        if "bufferView" in accessor:
            view, stride = self._view(accessor["bufferView"])
            values = self._strided(view, stride, accessor, where, dtype, count, width)
        elif "sparse" in accessor:
            check_memory(count * dtype.itemsize * width, f"{self.path}: {where}")
            values = np.zeros((count, width), dtype=dtype)
        else:
            raise self.fail(
                f"{where} has no data (no bufferView): the geometry is missing or in a compressed extension"
            )
        if "sparse" in accessor:
            values = self._with_sparse(values, accessor["sparse"], where)
        if (normalise or accessor.get("normalized") is True) and dtype.kind in "iu":
            values = np.maximum(values / np.float32(np.iinfo(dtype).max), np.float32(-1.0)).astype(np.float32)
        return values[:, 0] if width == 1 else values

    def numbers(self, value: Any, where: str, count: int | None = None) -> list[float]:
        """Return a list of numbers from the JSON, as float; raise for other values, or another length."""
        good = isinstance(value, list) and all(type(v) in (int, float) for v in value)
        if not good or (count is not None and len(value) != count):
            raise self.fail(f"{where} should be {'numbers' if count is None else f'{count} numbers'}")
        return [float(v) for v in value]

    def view_bytes(self, index: object) -> memoryview:
        """Return the bytes of a buffer view."""
        return self._view(index)[0]

    # --- the pieces ------------------------------------------------------------------------------------------------

    def _split_glb(self, data: bytes) -> bytes:
        if len(data) < 20:
            raise self.fail("the file ends inside its header: it is truncated")
        version, length = (int.from_bytes(data[at : at + 4], "little") for at in (4, 8))
        if version != 2:
            raise self.fail(f"this is GLB version {version}, and only version 2 is read; convert it", damaged=False)
        if length > len(data):
            raise self.fail(f"the header promises {length:,} bytes, the file has {len(data):,}: it is truncated")
        if data[length:].strip(b"\0 \t\r\n"):
            self.doubts.append(f"{len(data) - length:,} bytes follow the end that the GLB states, and were not read")
        text: bytes | None = None
        at = 12
        while at + 8 <= length:
            size, kind = int.from_bytes(data[at : at + 4], "little"), int.from_bytes(data[at + 4 : at + 8], "little")
            if at + 8 + size > length:
                raise self.fail(f"a chunk at byte {at:,} runs over the end of the file: it is truncated")
            if kind == _JSON_CHUNK and text is None:
                text = data[at + 8 : at + 8 + size]
            elif kind == _BIN_CHUNK and self._binary is None:
                self._binary = memoryview(data)[at + 8 : at + 8 + size]
            at += 8 + size
        if text is None:
            raise self.fail("there is no JSON chunk")
        return text.rstrip(b"\0")  # some exporters fill up with these instead of blanks

    def _check_extensions(self) -> frozenset[str]:
        """Return the extensions that the file requires; refuse those that feeler does not read."""
        required = self.root.get("extensionsRequired", [])
        names = [str(name) for name in required] if isinstance(required, list) else []
        for name in names:
            if name not in UNDERSTOOD and not name.startswith(_LOOKS):
                raise self.fail(f"it requires the extension {name[:60]!r}, which is not read; export without it", False)
        return frozenset(names)

    def _natural(self, item: dict[str, Any], key: str, where: str, default: int | None = None) -> int:
        value = item.get(key, default)
        if not isinstance(value, int) or isinstance(value, bool) or value < 0:
            raise self.fail(f"{where}.{key} is {str(value)[:40]}, and should be a whole number")
        return value

    def _view(self, index: object) -> tuple[memoryview, int]:
        """Return (bytes, stride or 0) of a buffer view."""
        view = self.item("bufferViews", index)
        where = f"bufferViews[{index}]"
        stride = self._natural(view, "byteStride", where, 0)
        packed = self._packed(view, where)
        if packed is not None:
            at = int(str(index))
            if at not in self._unpacked:
                self._unpacked[at] = self._unpack(packed, where)
            return self._unpacked[at], stride
        return self._slice(view, where), stride

    def _slice(self, item: dict[str, Any], where: str) -> memoryview:
        """Return the bytes of the buffer of a buffer view, or of the extension that replaces it."""
        buffer = self._buffer(self._natural(item, "buffer", where))
        offset, length = self._natural(item, "byteOffset", where, 0), self._natural(item, "byteLength", where)
        if offset + length > len(buffer):
            raise self.fail(f"{where} ends at byte {offset + length:,} of a buffer of {len(buffer):,}")
        return buffer[offset : offset + length]

    def _packed(self, view: dict[str, Any], where: str) -> dict[str, Any] | None:
        """Return the extension that packs a view with meshopt, or None if the file has its plain bytes."""
        extensions = view.get("extensions")
        if not isinstance(extensions, dict):
            return None
        name = next((name for name in _MESHOPT if name in extensions), None)
        if name is None:
            return None
        found = extensions[name]
        if not isinstance(found, dict):
            raise self.fail(f"{where}.extensions.{name} is not an object")
        if self.required.isdisjoint(_MESHOPT) and self._has_bytes(self._natural(view, "buffer", where)):
            return None
        return found

    def _has_bytes(self, index: int) -> bool:
        """Tell whether a buffer is in the file or beside it. A placeholder for packed data has no bytes."""
        try:
            self._buffer(index)
        except LoadError:
            return False
        return True

    def _unpack(self, packed: dict[str, Any], where: str) -> memoryview:
        where += " (meshopt)"
        count, stride = self._natural(packed, "count", where), self._natural(packed, "byteStride", where)
        check_memory(8 * count * stride, f"{self.path}: {where}")
        data = self._slice(packed, where)
        try:
            return meshopt.decode(data, count, stride, str(packed.get("mode")), str(packed.get("filter", "NONE")))
        except meshopt.DamagedError as error:
            raise self.fail(f"{where}: {error}") from error

    def _strided(
        self,
        view: memoryview,
        stride: int,
        item: dict[str, Any],
        where: str,
        dtype: np.dtype[Any],
        count: int,
        width: int,
    ) -> NDArray[Any]:
        offset = self._natural(item, "byteOffset", where, 0)
        element = dtype.itemsize * width
        stride = stride or element
        if stride < element:
            raise self.fail(f"{where} has elements of {element} bytes in a stride of {stride}")
        if count and offset + stride * (count - 1) + element > len(view):
            raise self.fail(
                f"{where} needs {offset + stride * (count - 1) + element:,} bytes and its buffer view has {len(view):,}"
            )
        if not count:
            return np.empty((0, width), dtype=dtype)
        values: NDArray[Any] = np.ndarray((count, width), dtype, view, offset, (stride, dtype.itemsize))
        return values

    def _with_sparse(self, values: NDArray[Any], sparse: Any, where: str) -> NDArray[Any]:
        where += ".sparse"
        if not isinstance(sparse, dict) or not all(isinstance(sparse.get(key), dict) for key in ("indices", "values")):
            raise self.fail(f"{where} has no indices or no values")
        count = self._natural(sparse, "count", where)
        index_type = _COMPONENTS.get(sparse["indices"].get("componentType", -1))
        if index_type is None or index_type.kind != "u":
            raise self.fail(f"{where}.indices has no unsigned componentType")
        view, stride = self._view(sparse["indices"].get("bufferView"))
        at = self._strided(view, stride, sparse["indices"], where + ".indices", index_type, count, 1)[:, 0]
        view, stride = self._view(sparse["values"].get("bufferView"))
        new = self._strided(view, stride, sparse["values"], where + ".values", values.dtype, count, values.shape[1])
        if count and int(at.max()) >= len(values):
            raise self.fail(f"{where}.indices names element {int(at.max()):,} of {len(values):,}")
        values = values.copy()
        values[at] = new
        return values

    def _buffer(self, index: int) -> memoryview:
        if index not in self._buffers:
            buffer = self.item("buffers", index)
            length = self._natural(buffer, "byteLength", f"buffers[{index}]")
            data = self._buffer_bytes(index, buffer)
            if len(data) < length:
                raise self.fail(f"buffers[{index}] should have {length:,} bytes and has {len(data):,}: it is truncated")
            self._buffers[index] = data[:length]
        return self._buffers[index]

    def _buffer_bytes(self, index: int, buffer: dict[str, Any]) -> memoryview:
        uri = buffer.get("uri")
        if uri is None:
            if index or self._binary is None:
                raise self.fail(f"buffers[{index}] has no uri and no binary chunk")
            return self._binary
        if not isinstance(uri, str):
            raise self.fail(f"buffers[{index}].uri is not text")
        if uri.startswith("data:"):
            head, comma, payload = uri.partition(",")
            if not comma or not head.endswith(";base64"):
                raise self.fail(f"buffers[{index}] is a data URI that is not base64")
            try:
                return memoryview(base64.b64decode(payload, validate=True))
            except (binascii.Error, ValueError) as error:
                raise self.fail(f"buffers[{index}] is damaged base64 ({error})") from error
        return memoryview(self._beside(uri).read_bytes())

    def _beside(self, uri: str) -> Path:
        """Return the file of a relative URI; refuse files outside the folder of the glTF file, and the network."""
        name = unquote(uri)
        if _SCHEME.match(uri) or name.startswith(("/", "\\")) or "\0" in name:
            raise self.fail(
                f"the buffer {uri[:80]!r} is not a file beside it, and nothing else is opened", damaged=False
            )
        folder = self.path.parent.resolve()
        target = (folder / name).resolve()
        if folder not in target.parents:
            raise self.fail(f"the buffer {uri[:80]!r} lies outside its folder, and is not opened", damaged=False)
        if not target.is_file():
            raise self.fail(f"the buffer {uri[:80]!r} is missing; put the file beside it", damaged=False)
        check_memory(target.stat().st_size, str(target))
        note_read(target)
        return target
