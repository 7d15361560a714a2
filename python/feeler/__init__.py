"""Exact collision detection of a moving tool against large digital mock-ups. SI units everywhere."""

from importlib.metadata import version as _version
from typing import TYPE_CHECKING as _TYPE_CHECKING
from typing import Any as _Any

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
    Screw,
    SectionOutline,
)
from feeler.clashes import Clash, Clashes, Verdict, clash, load_clashes
from feeler.depths import Depths
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
    WorkbenchError,
)
from feeler.ignored import IgnoredPairs
from feeler.interchange import from_open3d, from_pyvista, from_trimesh, from_urdf
from feeler.io import load_mockup, load_tool
from feeler.mockup import Mockup, Tool
from feeler.plan.blocked import Blocker
from feeler.plan.fasteners import Fastener, Fasteners, find_fasteners
from feeler.plan.insertion import insertion
from feeler.plan.legs import RemovalLeg
from feeler.plan.order import RemovalOrder, RemovalStep, removal_order
from feeler.plan.reaching import Access, Reach, access
from feeler.plan.removal import Certificate, Removal, RemovalBlocker, removal
from feeler.plan.swept import swept
from feeler.poses import nearest_rigid
from feeler.samples import sample, sample_path, sample_poses, sample_tool, sample_truth
from feeler.scene import ContactTracker, PairKind, Scene, optimal_voxel_size

if _TYPE_CHECKING:
    from feeler.workbench.scripting import View, view

__version__ = _version("feeler")

__all__ = [
    "Access",
    "Batch",
    "Blocker",
    "Cast",
    "Certificate",
    "Clash",
    "Clashes",
    "Clearance",
    "ClearanceBatch",
    "Collision",
    "ContactPlane",
    "ContactTracker",
    "Contacts",
    "Containment",
    "Depths",
    "DeviceError",
    "Distance",
    "DistanceBatch",
    "Fastener",
    "Fasteners",
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
    "Reach",
    "Removal",
    "RemovalBlocker",
    "RemovalLeg",
    "RemovalOrder",
    "RemovalStep",
    "Scene",
    "Screw",
    "SectionOutline",
    "SessionError",
    "Tool",
    "Verdict",
    "View",
    "WorkbenchError",
    "access",
    "clash",
    "find_fasteners",
    "from_open3d",
    "from_pyvista",
    "from_trimesh",
    "from_urdf",
    "haptics",
    "insertion",
    "load_clashes",
    "load_mockup",
    "load_tool",
    "nearest_rigid",
    "optimal_voxel_size",
    "removal",
    "removal_order",
    "sample",
    "sample_path",
    "sample_poses",
    "sample_tool",
    "sample_truth",
    "swept",
    "view",
]


def __getattr__(name: str) -> _Any:
    # The workbench is imported when it is asked for: scripts without a picture pay nothing for it.
    if name in ("View", "view"):
        from feeler.workbench import scripting

        return getattr(scripting, name)
    raise AttributeError(f"module 'feeler' has no attribute {name!r}")
