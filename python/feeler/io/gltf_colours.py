"""The materials of a glTF file's parts: their names, and their base colours as sRGB.

An error in a material moves no surface: the file is read, and the part has no colour.
"""

from __future__ import annotations

import math
from collections.abc import Iterator
from typing import Any, TypeAlias

from feeler.io.gltf_document import Document
from feeler.io.raw import clean_name

Colour: TypeAlias = tuple[float, float, float]

NO_COLOUR: Colour = (math.nan, math.nan, math.nan)

_DIGITS = 4  # the accuracy of a colour that was written in linear light with six digits


def mesh_colour(document: Document, mesh: int) -> Colour:
    """The colour of a mesh, 0 to 1; with several primitives, that of the one with the most corners; else `NO_COLOUR`.

    A material with a texture gives no colour, because its base colour is only a factor of the texture; nor does one
    without `baseColorFactor`.
    """
    primitives = document.item("meshes", mesh).get("primitives")
    if not isinstance(primitives, list) or not primitives:
        return NO_COLOUR
    most = max(primitives, key=lambda primitive: _corners(document, primitive))
    pbr = _entry(_entry(document.root, "materials", most.get("material")), "pbrMetallicRoughness")
    factor = pbr.get("baseColorFactor")
    if "baseColorTexture" in pbr or not isinstance(factor, list) or len(factor) not in (3, 4):
        return NO_COLOUR
    if not all(type(level) in (int, float) and 0 <= level <= 1 for level in factor):
        return NO_COLOUR
    red, green, blue = (_encoded(level) for level in factor[:3])
    return red, green, blue


def material_names(document: Document, mesh: dict[str, Any]) -> Iterator[str]:
    """The names of the materials of a mesh, of its primitives in their order."""
    primitives = mesh.get("primitives")
    for primitive in primitives if isinstance(primitives, list) else ():
        name = _entry(document.root, "materials", primitive.get("material")).get("name")
        if isinstance(name, str):
            yield clean_name(name, "")


def _corners(document: Document, primitive: dict[str, Any]) -> int:
    """The number of triangles; primitives of points and lines have none."""
    if primitive.get("mode", 4) not in (4, 5, 6):
        return -1
    return document.count(primitive.get("indices", primitive["attributes"].get("POSITION")))


def _entry(holder: dict[str, Any], key: str, index: object = None) -> dict[str, Any]:
    """`holder[key]`, or its element `[index]` if that is a list; empty if it is missing or not an object."""
    found = holder.get(key)
    if isinstance(found, list):
        found = found[index] if type(index) is int and 0 <= index < len(found) else None
    return found if isinstance(found, dict) else {}


def _encoded(level: float) -> float:
    """A level of linear light as sRGB."""
    return round(12.92 * level if level <= 0.0031308 else 1.055 * level ** (1 / 2.4) - 0.055, _DIGITS)
