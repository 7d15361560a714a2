"""KHR_draco_mesh_compression, through the package DracoPy (`pip install feeler[gltf]`)."""

from __future__ import annotations

import importlib
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from feeler.io.gltf_document import Document
from feeler.io.raw import seal_indices

DRACO = "KHR_draco_mesh_compression"


@dataclass(eq=False)
class Unpacked:
    """One primitive decoded by Draco: triangles, whatever its mode, and attributes by number."""

    faces: NDArray[np.uint32]
    count: int
    numbers: dict[str, Any]  # attribute name -> Draco's unique id
    mesh: Any

    def attribute(self, document: Document, name: str, width: int, where: str) -> NDArray[Any]:
        """Return an attribute as (count, width)."""
        try:
            values = np.asarray(self.mesh.get_attribute_by_unique_id(self.numbers[name])["data"])
        except (KeyError, TypeError, ValueError, IndexError):
            raise document.fail(f"{where}: the attribute {name} is not in the Draco data") from None
        if values.shape != (self.count, width):
            raise document.fail(f"{where}: the attribute {name} is {values.shape} in the Draco data")
        return values

    def as_attributes(self, document: Document, where: str) -> dict[str, Any]:
        """Return joints and weights, for `gltf_deform.influences`."""
        return {
            name: self.attribute(document, name, 4, where)
            for name in self.numbers
            if name.startswith(("JOINTS_", "WEIGHTS_"))
        }


def unpack(document: Document, primitive: dict[str, Any], where: str) -> Unpacked:
    """Decode the extension of a primitive; raise if it is damaged or DracoPy is not installed."""
    try:
        draco: Any = importlib.import_module("DracoPy")
    except ImportError:
        raise document.fail(
            "the geometry is compressed with Draco: install the decoder with: pip install feeler[gltf] (or export it "
            "uncompressed, for example with: gltf-transform copy in.glb out.glb)",
            damaged=False,
        ) from None
    extension = primitive["extensions"][DRACO]
    if not isinstance(extension, dict) or not isinstance(extension.get("attributes"), dict):
        raise document.fail(f"{where}: the extension for Draco has no attributes")
    data = document.view_bytes(extension.get("bufferView"))
    try:
        mesh = draco.decode(bytes(data))
        corners = np.asarray(mesh.faces, dtype=np.int64).reshape(-1, 3)
        count = len(mesh.points)
    except Exception as error:  # the package has no common class for its errors
        raise document.fail(f"{where}: the Draco data is damaged ({str(error)[:100]})") from error
    promised = document.count(primitive["attributes"].get("POSITION"))
    if count > promised:
        # The memory for the whole file was checked against the accessor's counts.
        raise document.fail(f"{where}: the Draco data has {count:,} vertices, and the accessor {promised:,}")
    return Unpacked(seal_indices(corners, count), count, extension["attributes"], mesh)
