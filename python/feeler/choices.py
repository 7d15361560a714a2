"""The words that arguments take, as types: a type checker refuses others, and so does `check_word` at run time."""

from __future__ import annotations

from typing import Literal, get_args

Storage = Literal["blocks", "dense", "hashed"]
Estimator = Literal["calibrated", "area", "diagonal", "side"]
Simd = Literal["avx512", "avx2", "neon", "portable"]
PenetrationKind = Literal["bound", "estimate", "exact"]
Touching = Literal["counts", "free"]

DefectKind = Literal["index_out_of_range", "non_finite", "too_large", "zero_area", "duplicate"]

UpAxis = Literal["x", "y", "z"]
UnitName = Literal["m", "mm", "cm", "dm", "um", "nm", "km", "in", "ft", "yd", "mil"]
"""The short names of length units. At run time long ones ("metres", "inch") hold too, and case does not matter."""
StlUnit = Literal["m", "cm", "mm", "in", "inch"]
Geometry = Literal["collision", "visual"]

Severity = Literal["critical", "major", "minor"]
Status = Literal["new", "active", "reviewed", "approved", "resolved"]
SettableStatus = Literal["new", "active", "reviewed", "approved"]
VerdictName = Literal["clash", "contact", "clearance", "contained", "duplicate"]
DepthKind = Literal["measured", "estimate"]
GroupBy = Literal["part", "rule", "cluster"]
Chord = Literal["chord"]

FastenerKind = Literal["bolt", "screw", "nut", "stud"]
JointKindName = Literal["revolute", "prismatic", "screw", "cylindrical", "fixed"]
OpeningShape = Literal["ball", "cylinder", "box"]
TaskVerb = Literal["undo", "disconnect", "take out"]
MaintainFault = Literal["slower", "blocked", "unreachable", "hidden", "failed"]

GripAxis = Literal["x", "y", "z", "-x", "-y", "-z"]

PoseKind = Literal["nominal", "near", "deep"]
SampleName = Literal["carcass", "differential", "turbine", "externals", "engine", "tay", "gearbox"]
SampleToolName = Literal["torque", "wrench", "square", "hand"]
Fault = Literal[
    "pipe_clash", "too_near", "blocked_bolt", "no_way_out", "missing_hole",
    "duplicate", "inside", "floating", "mirrored", "wrong_unit",
]  # fmt: skip

ViewUnit = Literal["mm", "cm", "m", "in"]
ViewMode = Literal["stop", "glide", "pass"]

ProxyMode = Literal["free", "contact", "bound", "doubt"]
SeatKind = Literal["touching", "fit", "sunk"]
MechanismSeatKind = Literal["touching", "fit", "sunk", "round"]
DevicePreset = Literal["desktop_3dof", "desktop_6dof", "large_6dof"]
DeviceDriver = Literal["spacemouse", "haply", "dhd", "openhaptics"]
HandGrip = Literal["firm", "loose"]
DeviceFault = Literal["nan", "nonsense", "lost", "silent", "jump", "slow"]

STORAGES: tuple[Storage, ...] = get_args(Storage)
ESTIMATORS: tuple[Estimator, ...] = get_args(Estimator)
SIMDS: tuple[Simd, ...] = get_args(Simd)
TOUCHINGS: tuple[Touching, ...] = get_args(Touching)
STL_UNITS: tuple[StlUnit, ...] = get_args(StlUnit)
GEOMETRIES: tuple[Geometry, ...] = get_args(Geometry)
SEVERITIES: tuple[Severity, ...] = get_args(Severity)
STATUSES: tuple[Status, ...] = get_args(Status)
SETTABLE_STATUSES: tuple[SettableStatus, ...] = get_args(SettableStatus)
DEFECT_KINDS: tuple[DefectKind, ...] = get_args(DefectKind)
DEPTH_KINDS: tuple[DepthKind, ...] = get_args(DepthKind)
GROUPS_BY: tuple[GroupBy, ...] = get_args(GroupBy)
FASTENER_KINDS: tuple[FastenerKind, ...] = get_args(FastenerKind)
OPENING_SHAPES: tuple[OpeningShape, ...] = get_args(OpeningShape)
MAINTAIN_FAULTS: tuple[MaintainFault, ...] = get_args(MaintainFault)
GRIP_AXES: tuple[GripAxis, ...] = get_args(GripAxis)
POSE_KINDS: tuple[PoseKind, ...] = get_args(PoseKind)
SAMPLE_NAMES: tuple[SampleName, ...] = get_args(SampleName)
SAMPLE_TOOL_NAMES: tuple[SampleToolName, ...] = get_args(SampleToolName)
FAULT_NAMES: tuple[Fault, ...] = get_args(Fault)
VIEW_UNITS: tuple[ViewUnit, ...] = get_args(ViewUnit)
VIEW_MODES: tuple[ViewMode, ...] = get_args(ViewMode)
DEVICE_PRESETS: tuple[DevicePreset, ...] = get_args(DevicePreset)
DEVICE_DRIVERS: tuple[DeviceDriver, ...] = get_args(DeviceDriver)
HAND_GRIPS: tuple[HandGrip, ...] = get_args(HandGrip)
DEVICE_FAULTS: tuple[DeviceFault, ...] = get_args(DeviceFault)
