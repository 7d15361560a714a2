"""Exact collision detection of a moving tool against large digital mock-ups. SI units everywhere."""

from importlib.metadata import version as _version

from feeler import haptics
from feeler._core import (
    Batch,
    Cast,
    Clearance,
    ClearanceBatch,
    Collision,
    ContactPlane,
    Contacts,
    Containment,
    Distance,
    DistanceBatch,
    Packed,
    PackedPiece,
    PathCheck,
    Penetration,
    Rays,
    SectionOutline,
)
from feeler.errors import (
    DeviceError,
    FeelerError,
    LimitError,
    LoadError,
    MeshError,
    MissingFileError,
    OptionError,
    PoseError,
    SessionError,
)
from feeler.ignored import IgnoredPairs
from feeler.interchange import from_open3d, from_pyvista, from_trimesh, from_urdf
from feeler.io import load_mockup, load_tool
from feeler.mockup import Mockup, Tool
from feeler.poses import nearest_rigid
from feeler.samples import sample, sample_path, sample_poses, sample_tool
from feeler.scene import ContactTracker, PairKind, Scene, optimal_voxel_size

__version__ = _version("feeler")

__all__ = [
    "Batch",
    "Cast",
    "Clearance",
    "ClearanceBatch",
    "Collision",
    "ContactPlane",
    "ContactTracker",
    "Contacts",
    "Containment",
    "DeviceError",
    "Distance",
    "DistanceBatch",
    "FeelerError",
    "IgnoredPairs",
    "LimitError",
    "LoadError",
    "MeshError",
    "MissingFileError",
    "Mockup",
    "OptionError",
    "Packed",
    "PackedPiece",
    "PairKind",
    "PathCheck",
    "Penetration",
    "PoseError",
    "Rays",
    "Scene",
    "SectionOutline",
    "SessionError",
    "Tool",
    "from_open3d",
    "from_pyvista",
    "from_trimesh",
    "from_urdf",
    "haptics",
    "load_mockup",
    "load_tool",
    "nearest_rigid",
    "optimal_voxel_size",
    "sample",
    "sample_path",
    "sample_poses",
    "sample_tool",
]
