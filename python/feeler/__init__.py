"""Exact collision detection of a moving tool against large digital mock-ups. SI units everywhere."""

from importlib.metadata import version as _version

from feeler.errors import (
    FeelerError,
    LimitError,
    LoadError,
    MeshError,
    MissingFileError,
    OptionError,
    PoseError,
)
from feeler.mockup import Mockup, Tool
from feeler.scene import Batch, Collision, PairKind, Scene, optimal_voxel_size

__version__ = _version("feeler")

__all__ = [
    "Batch",
    "Collision",
    "FeelerError",
    "LimitError",
    "LoadError",
    "MeshError",
    "MissingFileError",
    "Mockup",
    "OptionError",
    "PairKind",
    "PoseError",
    "Scene",
    "Tool",
    "optimal_voxel_size",
]
