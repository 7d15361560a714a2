"""Types for annotations: the words that arguments take, what counts as a pose or as parts, and classes of results.

from feeler.types import PartsLike, PoseLike, Storage

def hit(scene: feeler.Scene, tool: feeler.Tool, pose: PoseLike) -> bool: ...
"""

from __future__ import annotations

from feeler.choices import (
    Chord,
    DefectKind,
    DepthKind,
    DeviceDriver,
    DeviceFault,
    DevicePreset,
    Estimator,
    FastenerKind,
    Fault,
    Geometry,
    GripAxis,
    GroupBy,
    HandGrip,
    JointKindName,
    MaintainFault,
    MechanismSeatKind,
    OpeningShape,
    PenetrationKind,
    PoseKind,
    ProxyMode,
    SampleName,
    SampleToolName,
    SeatKind,
    SettableStatus,
    Severity,
    Simd,
    Status,
    StlUnit,
    Storage,
    TaskVerb,
    Touching,
    UnitName,
    UpAxis,
    VerdictName,
    ViewMode,
    ViewUnit,
)
from feeler.clashes.bcf_notes import Seen as SeenFinding
from feeler.clashes.finding import Exclude
from feeler.clashes.rules import RulesLike, WordsLike
from feeler.clashes.shapes import Shapes
from feeler.clashes.table import Columns, VerdictLike
from feeler.clashes.tracking import Found as FoundDepth
from feeler.figures import CollisionStats, DeviceLimits, SceneMemory
from feeler.haptics.record import Recorder
from feeler.ignored import Ignore
from feeler.interchange.urdf import PackageDirs
from feeler.io.body import Colour, MeshLike
from feeler.io.files import PathLike
from feeler.mechanism.positions import Values
from feeler.mesh_types import (
    ArrayOfInts,
    ArrayOfRows,
    HasBlocks,
    HasMeshes,
    HasPoints,
    HasTransform,
    HasTriangle,
    HasVertices,
    MeshSource,
)
from feeler.mockup import Defect, LoadReport
from feeler.parts import Part, Parts, PartsKey, PartsLike
from feeler.picture.collision import Hits
from feeler.plan.reaching import Hand
from feeler.poses import HasArray, HasMatrix, PoseLike, PosesLike
from feeler.progress import Progress
from feeler.project.rows import FindingChange, FindingRow, ProjectDocument
from feeler.requirements import RequirementsLike
from feeler.source import Source
from feeler.tasks.listed import MaintainParts
from feeler.tasks.reached import TaskTools
from feeler.tasks.times import Element, TimesLike
from feeler.workbench.document.arguments import IndicesLike, VectorLike, VectorsLike
from feeler.workbench.document.protocol import Camera as ViewCamera
from feeler.workbench.document.protocol import CardQuestion, CommandAnswer, GivenWay, Material, MeasureType
from feeler.workbench.document.protocol_findings import FindingStatus, RequirementResult
from feeler.workbench.document.protocol_task import TaskEditKind
from feeler.workbench.document.protocol_values import Vec3

__all__ = [
    "ArrayOfInts",
    "ArrayOfRows",
    "CardQuestion",
    "Chord",
    "CollisionStats",
    "Colour",
    "Columns",
    "CommandAnswer",
    "Defect",
    "DefectKind",
    "DepthKind",
    "DeviceDriver",
    "DeviceFault",
    "DeviceLimits",
    "DevicePreset",
    "Element",
    "Estimator",
    "Exclude",
    "FastenerKind",
    "Fault",
    "FindingChange",
    "FindingRow",
    "FindingStatus",
    "FoundDepth",
    "Geometry",
    "GivenWay",
    "GripAxis",
    "GroupBy",
    "Hand",
    "HandGrip",
    "HasArray",
    "HasBlocks",
    "HasMatrix",
    "HasMeshes",
    "HasPoints",
    "HasTransform",
    "HasTriangle",
    "HasVertices",
    "Hits",
    "Ignore",
    "IndicesLike",
    "JointKindName",
    "LoadReport",
    "MaintainFault",
    "MaintainParts",
    "Material",
    "MeasureType",
    "MechanismSeatKind",
    "MeshLike",
    "MeshSource",
    "OpeningShape",
    "PackageDirs",
    "Part",
    "Parts",
    "PartsKey",
    "PartsLike",
    "PathLike",
    "PenetrationKind",
    "PoseKind",
    "PoseLike",
    "PosesLike",
    "Progress",
    "ProjectDocument",
    "ProxyMode",
    "Recorder",
    "RequirementResult",
    "RequirementsLike",
    "RulesLike",
    "SampleName",
    "SampleToolName",
    "SceneMemory",
    "SeatKind",
    "SeenFinding",
    "SettableStatus",
    "Severity",
    "Shapes",
    "Simd",
    "Source",
    "Status",
    "StlUnit",
    "Storage",
    "TaskEditKind",
    "TaskTools",
    "TaskVerb",
    "TimesLike",
    "Touching",
    "UnitName",
    "UpAxis",
    "Values",
    "Vec3",
    "VectorLike",
    "VectorsLike",
    "VerdictLike",
    "VerdictName",
    "ViewCamera",
    "ViewMode",
    "ViewUnit",
    "WordsLike",
]
