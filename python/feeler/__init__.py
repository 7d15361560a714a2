"""Exact collision detection of a moving tool against large digital mock-ups. SI units everywhere."""

import typing as _typing

if _typing.TYPE_CHECKING:
    from feeler import clashes as clashes
    from feeler import errors as errors
    from feeler import haptics as haptics
    from feeler import io as io
    from feeler import picture as picture
    from feeler import samples as samples
    from feeler import types as types
    from feeler._core import (
        Batch,
        Cast,
        Chain,
        Clearance,
        ClearanceAlong,
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
        Slide,
    )
    from feeler.clashes import (
        Clash,
        Clashes,
        ClashInterrupted,
        VariantsError,
        VariantsInterrupted,
        Verdict,
        clash,
        clash_variants,
        load_clashes,
    )
    from feeler.depths import Depth, Depths
    from feeler.errors import (
        DeviceError,
        FeelerError,
        LimitError,
        LoadError,
        MechanismError,
        MeshError,
        MissingFileError,
        OptionError,
        PoseError,
        ProjectError,
        SessionError,
        WorkbenchError,
        WriteError,
    )
    from feeler.ignored import IgnoredPairs
    from feeler.interchange import from_open3d, from_pyvista, from_trimesh, from_urdf
    from feeler.io import load_mockup, load_tool
    from feeler.mechanism import (
        Joint,
        JointCoupling,
        JointKind,
        Mechanism,
        MechanismClashes,
        MechanismClearance,
        MechanismContact,
        MechanismSeat,
        Range,
        Tracks,
        load_tracks,
    )
    from feeler.mechanism.finding import JointError, find_joint
    from feeler.mockup import Defect, LoadReport, Mockup, Tool
    from feeler.parts import Part, Parts
    from feeler.plan.blocked import Blocker
    from feeler.plan.catalogue import Catalogue, catalogue
    from feeler.plan.fasteners import Fastener, Fasteners, find_fasteners
    from feeler.plan.insertion import insertion
    from feeler.plan.legs import RemovalLeg
    from feeler.plan.opening import Opening, OpeningFit, OpeningLimit, opening, opening_limits
    from feeler.plan.order import RemovalOrder, RemovalOrderInterrupted, RemovalStep, removal_order
    from feeler.plan.reach import Access, AccessInterrupted, Reach, TriedTool
    from feeler.plan.reaching import access
    from feeler.plan.removal import Certificate, Removal, RemovalBlocker, RemovalInterrupted, removal
    from feeler.plan.removals import PartsRemoval, Removals, RemovalsInterrupted, removals
    from feeler.plan.sight import Seen, Sight, eyes_in, sight
    from feeler.plan.swept import swept
    from feeler.plan.tool_spec import ToolSpec
    from feeler.poses import nearest_rigid
    from feeler.project import PartChanges, Project, open_project
    from feeler.requirements import Requirement, Verified, read_requirements, verify
    from feeler.rows import RayHit
    from feeler.samples import sample, sample_path, sample_poses, sample_tool, sample_truth
    from feeler.scene import ContactTracker, PairKind, Scene, open_scene, optimal_voxel_size
    from feeler.source import Source
    from feeler.spreading import WorkerLost
    from feeler.tasks.answer import Task, TaskInterrupted
    from feeler.tasks.held_rows import Hold, Holds
    from feeler.tasks.holding import holds
    from feeler.tasks.night_rows import MaintainRow
    from feeler.tasks.nightly import maintain
    from feeler.tasks.planning import task
    from feeler.tasks.run import Maintenance, MaintenanceInterrupted, load_maintenance
    from feeler.tasks.snapshots import MaintainChange
    from feeler.tasks.steps import TaskBlocker, TaskStep
    from feeler.tasks.times import Times
    from feeler.workbench.scripting import View, view

    __version__: str

__all__ = [
    "Access",
    "AccessInterrupted",
    "Batch",
    "Blocker",
    "Cast",
    "Catalogue",
    "Certificate",
    "Chain",
    "Clash",
    "ClashInterrupted",
    "Clashes",
    "Clearance",
    "ClearanceAlong",
    "ClearanceBatch",
    "Collision",
    "ContactPlane",
    "ContactTracker",
    "Contacts",
    "Containment",
    "Defect",
    "Depth",
    "Depths",
    "DeviceError",
    "Distance",
    "DistanceBatch",
    "Fastener",
    "Fasteners",
    "FeelerError",
    "Hold",
    "Holds",
    "IgnoredPairs",
    "Joint",
    "JointCoupling",
    "JointError",
    "JointKind",
    "LimitError",
    "LoadError",
    "LoadReport",
    "MaintainChange",
    "MaintainRow",
    "Maintenance",
    "MaintenanceInterrupted",
    "Mechanism",
    "MechanismClashes",
    "MechanismClearance",
    "MechanismContact",
    "MechanismError",
    "MechanismSeat",
    "MeshError",
    "MissingFileError",
    "Mockup",
    "Opening",
    "OpeningFit",
    "OpeningLimit",
    "OptionError",
    "Packed",
    "PackedPiece",
    "PairKind",
    "Part",
    "PartChanges",
    "Parts",
    "PartsRemoval",
    "PathCheck",
    "Penetration",
    "PoseError",
    "Project",
    "ProjectError",
    "Range",
    "RayHit",
    "Rays",
    "Reach",
    "Removal",
    "RemovalBlocker",
    "RemovalInterrupted",
    "RemovalLeg",
    "RemovalOrder",
    "RemovalOrderInterrupted",
    "RemovalStep",
    "Removals",
    "RemovalsInterrupted",
    "Requirement",
    "Scene",
    "Screw",
    "SectionOutline",
    "Seen",
    "SessionError",
    "Sight",
    "Slide",
    "Source",
    "Task",
    "TaskBlocker",
    "TaskInterrupted",
    "TaskStep",
    "Times",
    "Tool",
    "ToolSpec",
    "Tracks",
    "TriedTool",
    "VariantsError",
    "VariantsInterrupted",
    "Verdict",
    "Verified",
    "View",
    "WorkbenchError",
    "WorkerLost",
    "WriteError",
    "access",
    "catalogue",
    "clash",
    "clash_variants",
    "eyes_in",
    "find_fasteners",
    "find_joint",
    "from_open3d",
    "from_pyvista",
    "from_trimesh",
    "from_urdf",
    "haptics",
    "holds",
    "insertion",
    "load_clashes",
    "load_maintenance",
    "load_mockup",
    "load_tool",
    "load_tracks",
    "maintain",
    "nearest_rigid",
    "open_project",
    "open_scene",
    "opening",
    "opening_limits",
    "optimal_voxel_size",
    "read_requirements",
    "removal",
    "removal_order",
    "removals",
    "sample",
    "sample_path",
    "sample_poses",
    "sample_tool",
    "sample_truth",
    "sight",
    "swept",
    "task",
    "verify",
    "view",
]

# The module of each name. Modules are imported at the first access, so that a script that only casts pays neither for
# clash reports nor for haptics. Type checkers read the imports above and reject all other names.
_HOMES = {
    "feeler._core": (
        "Batch",
        "Cast",
        "Chain",
        "Clearance",
        "ClearanceAlong",
        "ClearanceBatch",
        "Collision",
        "ContactPlane",
        "Contacts",
        "Containment",
        "Distance",
        "DistanceBatch",
        "Packed",
        "PackedPiece",
        "PathCheck",
        "Penetration",
        "Rays",
        "Screw",
        "SectionOutline",
        "Slide",
    ),
    "feeler.clashes": (
        "Clash",
        "ClashInterrupted",
        "Clashes",
        "VariantsError",
        "VariantsInterrupted",
        "Verdict",
        "clash",
        "clash_variants",
        "load_clashes",
    ),
    "feeler.depths": ("Depth", "Depths"),
    "feeler.errors": (
        "DeviceError",
        "FeelerError",
        "LimitError",
        "LoadError",
        "MechanismError",
        "MeshError",
        "MissingFileError",
        "OptionError",
        "PoseError",
        "ProjectError",
        "SessionError",
        "WorkbenchError",
        "WriteError",
    ),
    "feeler.ignored": ("IgnoredPairs",),
    "feeler.interchange": (
        "from_open3d",
        "from_pyvista",
        "from_trimesh",
        "from_urdf",
    ),
    "feeler.io": (
        "load_mockup",
        "load_tool",
    ),
    "feeler.mechanism": (
        "JointCoupling",
        "Joint",
        "JointKind",
        "Mechanism",
        "MechanismClashes",
        "MechanismClearance",
        "MechanismContact",
        "MechanismSeat",
        "Range",
        "Tracks",
        "load_tracks",
    ),
    "feeler.mechanism.finding": ("JointError", "find_joint"),
    "feeler.mockup": (
        "Defect",
        "LoadReport",
        "Mockup",
        "Tool",
    ),
    "feeler.parts": (
        "Part",
        "Parts",
    ),
    "feeler.plan.blocked": ("Blocker",),
    "feeler.plan.catalogue": (
        "Catalogue",
        "catalogue",
    ),
    "feeler.plan.fasteners": (
        "Fastener",
        "Fasteners",
        "find_fasteners",
    ),
    "feeler.plan.insertion": ("insertion",),
    "feeler.plan.legs": ("RemovalLeg",),
    "feeler.plan.opening": (
        "Opening",
        "OpeningFit",
        "OpeningLimit",
        "opening",
        "opening_limits",
    ),
    "feeler.plan.order": (
        "RemovalOrder",
        "RemovalOrderInterrupted",
        "RemovalStep",
        "removal_order",
    ),
    "feeler.plan.reach": (
        "Access",
        "AccessInterrupted",
        "Reach",
        "TriedTool",
    ),
    "feeler.plan.reaching": ("access",),
    "feeler.plan.removal": (
        "Certificate",
        "Removal",
        "RemovalBlocker",
        "RemovalInterrupted",
        "removal",
    ),
    "feeler.plan.removals": (
        "PartsRemoval",
        "Removals",
        "RemovalsInterrupted",
        "removals",
    ),
    "feeler.plan.sight": (
        "Seen",
        "Sight",
        "eyes_in",
        "sight",
    ),
    "feeler.plan.swept": ("swept",),
    "feeler.plan.tool_spec": ("ToolSpec",),
    "feeler.poses": ("nearest_rigid",),
    "feeler.project": (
        "PartChanges",
        "Project",
        "open_project",
    ),
    "feeler.requirements": (
        "Requirement",
        "Verified",
        "read_requirements",
        "verify",
    ),
    "feeler.rows": ("RayHit",),
    "feeler.samples": (
        "sample",
        "sample_path",
        "sample_poses",
        "sample_tool",
        "sample_truth",
    ),
    "feeler.scene": (
        "ContactTracker",
        "PairKind",
        "Scene",
        "open_scene",
        "optimal_voxel_size",
    ),
    "feeler.source": ("Source",),
    "feeler.spreading": ("WorkerLost",),
    "feeler.tasks.held_rows": (
        "Hold",
        "Holds",
    ),
    "feeler.tasks.holding": ("holds",),
    "feeler.tasks.answer": ("Task", "TaskInterrupted"),
    "feeler.tasks.nightly": ("maintain",),
    "feeler.tasks.planning": ("task",),
    "feeler.tasks.night_rows": ("MaintainRow",),
    "feeler.tasks.run": (
        "Maintenance",
        "MaintenanceInterrupted",
        "load_maintenance",
    ),
    "feeler.tasks.snapshots": ("MaintainChange",),
    "feeler.tasks.steps": (
        "TaskBlocker",
        "TaskStep",
    ),
    "feeler.tasks.times": ("Times",),
    "feeler.workbench.scripting": (
        "View",
        "view",
    ),
}

_ROOMS = ("clashes", "errors", "haptics", "io", "picture", "samples", "types")

if not _typing.TYPE_CHECKING:

    def __getattr__(name):
        """Imports the module of a name at its first use."""
        from importlib import import_module

        if name == "__version__":
            from importlib.metadata import version

            value = version("feeler")
        elif name in _ROOMS:
            return import_module(f"feeler.{name}")
        else:
            home = next((home for home, names in _HOMES.items() if name in names), None)
            if home is None:
                raise AttributeError(f"module 'feeler' has no attribute {name!r}")
            value = getattr(import_module(home), name)
        globals()[name] = value
        return value

    def __dir__():
        return sorted({*globals(), *__all__, *_ROOMS})
