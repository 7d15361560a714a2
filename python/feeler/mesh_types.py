"""The types of the meshes that `Mockup` and `Tool` take: arrays, and objects of other libraries by their attributes."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any, Protocol, TypeAlias

import numpy as np
import numpy.typing as npt

from feeler.poses import HasArray


class HasVertices(Protocol):
    """A mesh of trimesh or Open3D, a mock-up, a tool, or another object with `.vertices` and `.faces`."""

    @property
    def vertices(self) -> object:
        """`(n, 3)`."""
        ...


class HasTransform(Protocol):
    """A geometry or scene of trimesh, such as `trimesh.load` returns."""

    @property
    def apply_transform(self) -> object:
        """A method of all of them."""
        ...


class HasPoints(Protocol):
    """A data set of PyVista."""

    @property
    def points(self) -> object:
        """`(n, 3)`."""
        ...


class HasBlocks(Protocol):
    """A `MultiBlock` of PyVista."""

    @property
    def n_blocks(self) -> object:
        """The number of blocks."""
        ...


class HasTriangle(Protocol):
    """A tensor mesh of Open3D."""

    @property
    def triangle(self) -> object:
        """Its triangles."""
        ...


class HasMeshes(Protocol):
    """A model of Open3D."""

    @property
    def meshes(self) -> object:
        """Its meshes."""
        ...


# Each alias says that it is one: else mypy may take it for a variable, in circles of imports, and check nothing.
# Without npt.ArrayLike, which takes text and numbers.
_Array: TypeAlias = npt.NDArray[Any] | HasArray
ArrayOfRows: TypeAlias = _Array | Sequence[Sequence[float | np.number[Any]] | _Array]
"""Rows of three numbers: an array, or a list of rows."""
ArrayOfInts: TypeAlias = _Array | Sequence[int | np.integer[Any]]
"""A whole number for each triangle: an array, or a list."""

_Mesh: TypeAlias = HasVertices | HasTransform | HasPoints | HasBlocks | HasTriangle | HasMeshes
_Nested: TypeAlias = list[Any] | tuple[Any, ...] | Mapping[Any, Any]  # not Sequence: text is one, of text
MeshSource: TypeAlias = _Mesh | Sequence[_Mesh | _Nested] | Mapping[Any, _Mesh | _Nested]
"""A mesh or scene of trimesh, PyVista or Open3D, an object with `.vertices` and `.faces`, or a list or dict of them, of
pairs (vertices, faces), or of such lists and dicts."""
