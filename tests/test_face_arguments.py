"""Every public callable with arguments of the wrong kind: it answers, or raises an error of feeler."""

from __future__ import annotations

import importlib
import inspect
import os
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from shapes import box
from workbench_scene import Bench, cube

import feeler
from feeler import clashes, haptics, io, picture, samples
from feeler.haptics import devices
from feeler.io.export import Motion, animated_glb
from feeler.workbench.scripting import View

SPACES = ("feeler", "feeler.haptics", "feeler.haptics.devices", "feeler.clashes", "feeler.io", "feeler.picture")
SPACES = (*SPACES, "feeler.samples")


class NoPath(os.PathLike):  # type: ignore[type-arg]
    """A path that gives no text."""

    def __fspath__(self) -> Any:
        return 3


BAD: list[object] = [
    None, "x", b"x", float("nan"), float("inf"), -1, 10**400, object(), [], np.zeros(3), "\ud800", 2**63, True, {},
    np.array(3), len, feeler.Mockup, [np.zeros((3, 3)), 1, 2], NoPath(),
]  # fmt: skip
MADE_BY_FEELER = {
    feeler.Access, feeler.Batch, feeler.Blocker, feeler.Cast, feeler.Certificate, feeler.Clash, feeler.Clashes,
    feeler.Clearance, feeler.ClearanceAlong, feeler.ClearanceBatch,
    feeler.Collision, feeler.ContactPlane, feeler.Contacts, feeler.Containment, feeler.Depth,
    feeler.Depths, feeler.Distance, feeler.DistanceBatch, feeler.Fastener, feeler.Packed, feeler.PackedPiece,
    feeler.JointKind, feeler.MechanismClashes, feeler.MechanismClearance, feeler.MechanismContact,
    feeler.ToolSpec, feeler.TriedTool, feeler.Opening, feeler.OpeningFit, feeler.OpeningLimit,
    feeler.Hold, feeler.Task, feeler.TaskStep, feeler.TaskBlocker, feeler.MechanismSeat, feeler.Seen, feeler.Range,
    feeler.Maintenance, feeler.MaintainRow, feeler.MaintainChange,
    feeler.PairKind, feeler.PathCheck, feeler.Penetration, feeler.RayHit, feeler.Rays, feeler.Reach, feeler.Removal,
    feeler.PartsRemoval, feeler.Removals, feeler.PartChanges, feeler.Project,
    feeler.RemovalBlocker, feeler.RemovalLeg, feeler.RemovalOrder, feeler.RemovalStep, feeler.SectionOutline,
    feeler.Verdict, feeler.Verified,
    feeler.View, haptics.Distribution, haptics.Granted, haptics.Parted, haptics.Plane, haptics.Planes, haptics.Seat,
    haptics.Start, haptics.Statistics, haptics.Step, haptics.Tick, haptics.Trace, haptics.View, devices.Device,
    devices.Opened,
    clashes.BcfChanges, clashes.Comment, clashes.Topic,
    clashes.Changes, clashes.Group, clashes.Facts, clashes.PartMatch, feeler.Defect, feeler.LoadReport, feeler.Part,
    feeler.Parts, feeler.Source, samples.Body, samples.Fastener, samples.Fault, samples.Fit, samples.Joint,
    samples.Keeper, samples.Leg, samples.Stay, samples.Step, samples.Truth, io.MeshLike, picture.Hits,
}  # fmt: skip
"""Classes of results: users get their objects and do not make them. Their methods are swept."""
URDF = '<robot name="r"><link name="l"><collision><geometry><box size="1 1 1"/></geometry></collision></link></robot>'
ARM = URDF.replace(
    "</robot>",
    '<link name="m"><collision><geometry><box size="1 1 1"/></geometry></collision></link>'
    '<joint name="j" type="continuous"><parent link="l"/><child link="m"/><origin xyz="3 0 0"/></joint></robot>',
)

SLIDE = feeler.Joint("slide", feeler.JointKind.PRISMATIC, None, "far")

Call = tuple[Callable[..., object], dict[str, Any]]


class World:
    """A small mock-up of three parts, a tool above them, and answers about both; files in the present folder."""

    def __init__(self) -> None:
        boxes = [box((0, 0, 0), (1, 1, 0.1)), box((0, 0, 0.05), (0.2, 0.2, 0.3)), box((2, 2, 2), (3, 3, 3))]
        vertices = np.concatenate([each[0] for each in boxes])
        faces = np.concatenate([np.asarray(each[1]) + 8 * i for i, each in enumerate(boxes)])
        self.mockup = feeler.Mockup(vertices, faces, np.repeat([0, 1, 2], 12), ["plate", "post", "far"])
        self.tool = feeler.Tool(*box((0, 0, 0), (0.3, 0.3, 0.3)), name="cube")
        self.scene = feeler.Scene(self.mockup)
        self.pose = np.eye(4)
        self.away = np.eye(4)
        self.away[2, 3] = 1.0
        self.collision = self.scene.collide(self.tool, self.pose)
        self.clearance = self.scene.clearance(self.tool, self.pose, 1.0)
        self.clashes = feeler.clash(self.mockup)
        self.body = io.body_of(self.mockup)
        self.camera = picture.Camera((3.0, 3.0, 3.0), (0.0, 0.0, 0.0))
        self.fastener = feeler.Fastener(0, "plate", "bolt", np.eye(4), 0.008, 0.013, 0.02, 0.005, 1.0, "")
        self.session = haptics.Session(self.scene, self.tool)
        self.session.start(self.away)
        self.device = devices.Simulated()
        self.mouse = devices.Mouse(np.eye(4))
        io.write_stl("mesh.stl", self.mockup)
        self.scene.save("scene.feeler")
        Path("robot.urdf").write_text(URDF)
        Path("arm.urdf").write_text(ARM)
        Path("rules.toml").write_text("version = 1\n")
        self.clashes.save("clashes.json")
        self.project = feeler.open_project("project.feelproj", self.mockup)
        Path("requirements.toml").write_text('[[requirement]]\nname = "one"\na = "post"\nb = "far"\ngap = 0.1\n')
        limit = '[[limit]]\nname = "fist"\nshape = "ball"\ndiameter_mm = 90\n'
        Path("limits.toml").write_text("version = 1\n" + limit)
        clashes.write_bcf("topics.bcf", self.clashes, self.mockup)
        self.truth = feeler.sample_truth("gearbox", 75_000)
        self.task = feeler.task(self.scene, [1], seconds=5.0)
        feeler.Times().save("times.toml")
        self.night = feeler.maintain(self.scene, [1], seconds=5.0)
        self.night.save("last.json")
        haptics_record(self)

    def mechanism(self) -> feeler.Mechanism:
        """A box that slides."""
        return feeler.Mechanism(self.mockup, [SLIDE])

    def tracks(self) -> feeler.Tracks:
        """The post, which moves up."""
        poses = np.tile(np.eye(4), (2, 1, 1))
        poses[1, 2, 3] = 0.1
        Path("film.glb").write_bytes(animated_glb(self.mockup, [Motion(1, np.arange(2.0), poses)]))
        return feeler.load_tracks("film.glb")

    def saved_mechanism(self) -> feeler.Mechanism:
        """The same, written to a file."""
        made = self.mechanism()
        made.save("mechanism.toml")
        return made


def haptics_record(world: World) -> None:
    with world.session.record("session.npz"):
        world.session.start(world.away)
        world.session.step(world.away)


def query(name: str, **more: Any) -> Callable[[World], Call]:
    return lambda w: (getattr(w.scene, name), {"tool": w.tool, "world_from_tool": w.pose, **more})


def batch(name: str, **more: Any) -> Callable[[World], Call]:
    return lambda w: (getattr(w.scene, name), {"tool": w.tool, "poses": [w.pose, w.away], **more})


def plan(function: Callable[..., object], **more: Any) -> Callable[[World], Call]:
    return lambda w: (function, {"scene": w.scene, "parts": "far", "seconds": 5.0, **more})


def written(function: Callable[..., object], name: str, *, has_mockup: bool = True) -> Callable[[World], Call]:
    more = (lambda w: {"mockup": w.mockup}) if has_mockup else (lambda w: {})
    return lambda w: (function, {"path": name, "clashes": w.clashes, **more(w)})


def guided() -> feeler.Mockup:
    """A bar between four walls."""
    bar = box((0, 0, -1), (1, 1, 3))
    walls = [box(low, high) for low, high in (((-1, 0, 0), (0, 1, 2)), ((1, 0, 0), (2, 1, 2)))]
    walls += [box(low, high) for low, high in (((0, -1, 0), (1, 0, 2)), ((0, 1, 0), (1, 2, 2)))]
    faces = np.concatenate([np.asarray(each[1]) + 8 * i for i, each in enumerate([bar, *walls])])
    return feeler.Mockup(np.concatenate([each[0] for each in [bar, *walls]]), faces, np.repeat(np.arange(5), 12))


def drawn(function: Callable[..., object], answer: str, **more: Any) -> Callable[[World], Call]:
    return lambda w: (
        function,
        {"mockup": w.mockup, "tool": w.tool, "world_from_tool": w.pose, answer: getattr(w, answer), **more},
    )


GOOD: dict[str, Callable[[World], Call]] = {
    "feeler.ContactTracker": lambda w: (feeler.ContactTracker, {"scene": w.scene, "tool": w.tool}),
    "feeler.ContactTracker.contacts": lambda w: (
        feeler.ContactTracker(w.scene, w.tool).contacts,
        {"world_from_tool": w.pose},
    ),
    "feeler.Clashes.diff": lambda w: (w.clashes.diff, {"previous": w.clashes}),
    "feeler.Clashes.groups": lambda w: (w.clashes.groups, {"by": "cluster", "reach": 1.0}),
    "feeler.Clashes.save": lambda w: (w.clashes.save, {"path": "out.json"}),
    "feeler.Clashes.set_status": lambda w: (w.clashes.set_status, {"clash": w.clashes[0].id, "status": "approved"}),
    "feeler.Clashes.where": lambda w: (w.clashes.where, {}),
    "feeler.Clashes.with_rules": lambda w: (w.clashes.with_rules, {"rules": {}}),
    "feeler.Joint": lambda w: (
        feeler.Joint,
        {"name": "hinge", "kind": "revolute", "parent": None, "child": "post", "axis": (0, 0, 1), "point": (0, 0, 0)},
    ),
    "feeler.Joint.pose": lambda w: (
        feeler.Joint("hinge", feeler.JointKind.REVOLUTE, None, "post").pose,
        {"values": 0.5},
    ),
    "feeler.JointCoupling": lambda w: (
        feeler.JointCoupling,
        {"joint": "rack", "of": "pinion", "ratio": 0.1, "offset": 0.0},
    ),
    "feeler.Mechanism": lambda w: (
        feeler.Mechanism,
        {"mockup": w.mockup, "joints": [SLIDE], "couplings": [], "loops": [], "scene": w.scene, "ignore": []},
    ),
    "feeler.Mechanism.load": lambda w: (
        w.saved_mechanism().load,
        {"path": "mechanism.toml", "mockup": w.mockup, "scene": w.scene},
    ),
    "feeler.Mechanism.from_urdf": lambda w: (
        feeler.Mechanism.from_urdf,
        {
            "path": "arm.urdf",
            "geometry": "collision",
            "package_dirs": [],
            "chord_tolerance": 1e-4,
            "around": w.mockup,
            "world_from_base": w.pose,
            "ignore": [],
        },
    ),
    "feeler.Mechanism.save": lambda w: (w.mechanism().save, {"path": "mechanism.toml"}),
    "feeler.Mechanism.limits": lambda w: (w.mechanism().limits, {"name": "slide"}),
    "feeler.Mechanism.position": lambda w: (w.mechanism().position, {"values": {"slide": 0.1}, "start": None}),
    "feeler.Mechanism.poses": lambda w: (w.mechanism().poses, {"values": {"slide": 0.1}, "start": None}),
    "feeler.Mechanism.chain": lambda w: (
        w.mechanism().chain,
        {"joint": "slide", "start": {"slide": 0.1}, "end": {"slide": 0.2}},
    ),
    "feeler.Mechanism.scene": lambda w: (w.mechanism().scene, {"values": {"slide": 0.1}, "start": None}),
    "feeler.Mechanism.range": lambda w: (w.mechanism().range, {"joint": "slide", "at": {"slide": 0.1}}),
    "feeler.Mechanism.clearance": lambda w: (
        w.mechanism().clearance,
        {"values": {"slide": (0.0, 0.1)}, "error": 0.01, "most": 10},
    ),
    "feeler.Mechanism.clash": lambda w: (w.mechanism().clash, {"values": {"slide": (0.0, 0.1)}}),
    "feeler.Tracks.poses": lambda w: (w.tracks().poses, {"time": 0.5}),
    "feeler.Tracks.scene": lambda w: (w.tracks().scene, {"time": 0.5}),
    "feeler.Tracks.chain": lambda w: (w.tracks().chain, {"parts": "*post", "error": 0.1}),
    "feeler.Tracks.clearance": lambda w: (
        w.tracks().clearance,
        {"error": 0.01, "start": 0.0, "end": 1.0, "ignore_touching": True},
    ),
    "feeler.Tracks.clash": lambda w: (
        w.tracks().clash,
        {"error": 0.01, "start": 0.0, "end": 1.0, "ignore_touching": True},
    ),
    "feeler.load_tracks": lambda w: (
        feeler.load_tracks,
        {"path": "film.glb" if w.tracks() else "", "animation": None, "up": None, "progress": None},
    ),
    "feeler.Fasteners": lambda w: (feeler.Fasteners, {"rows": [w.fastener]}),
    "feeler.Fasteners.where": lambda w: (feeler.Fasteners([w.fastener]).where, {"pattern": "*"}),
    "feeler.IgnoredPairs": lambda w: (feeler.IgnoredPairs, {"tool": w.tool, "mockup": w.mockup, "pairs": [(0, 0)]}),
    "feeler.Mockup": lambda w: (feeler.Mockup, {"vertices": w.mockup.vertices, "faces": w.mockup.faces}),
    "feeler.Mockup.pack": lambda w: (w.mockup.pack, {}),
    "feeler.Parts.find": lambda w: (w.mockup.parts.find, {"path": "plate"}),
    "feeler.Parts.search": lambda w: (w.mockup.parts.search, {"query": "plate"}),
    "feeler.Parts.select": lambda w: (w.mockup.parts.select, {"parts": "plate"}),
    "feeler.Scene": lambda w: (feeler.Scene, {"mockup": w.mockup}),
    "feeler.Scene.cast": lambda w: (w.scene.cast, {"tool": w.tool, "start": w.away, "end": w.pose}),
    "feeler.Scene.check_path": batch("check_path"),
    "feeler.Scene.clearance_along": lambda w: (
        w.scene.clearance_along,
        {"tool": w.tool, "pose": w.away, "way": w.pose, "error": 1e-3},
    ),
    "feeler.Scene.clearance": query("clearance"),
    "feeler.Scene.clearance_batch": batch("clearance_batch"),
    "feeler.Scene.collide": query("collide"),
    "feeler.Scene.collide_batch": batch("collide_batch"),
    "feeler.Scene.contacts": query("contacts"),
    "feeler.Scene.containment": query("containment"),
    "feeler.Scene.depth": query("depth"),
    "feeler.Scene.distance": query("distance"),
    "feeler.Scene.distance_batch": batch("distance_batch"),
    "feeler.Scene.is_colliding": query("is_colliding"),
    "feeler.Scene.is_free": query("is_free"),
    "feeler.Scene.nearest": query("nearest", k=2),
    "feeler.Scene.only": lambda w: (w.scene.only, {"parts": "plate"}),
    "feeler.Scene.penetration": query("penetration"),
    "feeler.Scene.rays": lambda w: (w.scene.rays, {"origins": [[0, 0, 9.0]], "directions": [[0, 0, -1.0]]}),
    "feeler.Scene.section": lambda w: (w.scene.section, {"point": [0.5, 0.5, 0.05], "normal": [0, 0, 1.0]}),
    "feeler.Scene.moved": lambda w: (w.scene.moved, {"poses": {}}),
    "feeler.Scene.without": lambda w: (w.scene.without, {"parts": "far"}),
    "feeler.Slide": lambda w: (feeler.Slide, {"way": [0, 0, 1]}),
    "feeler.Slide.at": lambda w: (feeler.Slide([0, 0, 1]).at, {"pose": w.pose}),
    "feeler.Chain": lambda w: (feeler.Chain, {"joints": [feeler.Slide([0, 0, 1])]}),
    "feeler.Chain.at": lambda w: (feeler.Chain([feeler.Slide([0, 0, 1])]).at, {"pose": w.pose}),
    "feeler.Chain.relative_to": lambda w: (feeler.Chain([]).relative_to, {"other": feeler.Chain([])}),
    "feeler.Screw": lambda w: (feeler.Screw, {"axis": [0, 0, 1], "point": [0, 0, 0], "angle": 1.0}),
    "feeler.Screw.at": lambda w: (feeler.Screw([0, 0, 1], [0, 0, 0], 1.0).at, {"pose": w.pose}),
    "feeler.Tool": lambda w: (feeler.Tool, {"vertices": w.tool.vertices, "faces": w.tool.faces}),
    "feeler.Tool.assembly": lambda w: (feeler.Tool.assembly, {"items": {"cube": (w.tool, w.pose)}}),
    "feeler.Tool.of_parts": lambda w: (feeler.Tool.of_parts, {"mockup": w.mockup}),
    "feeler.Tool.pack": lambda w: (w.tool.pack, {}),
    "feeler.access": lambda w: (
        feeler.access,
        {"scene": w.scene, "tool": w.tool, "targets": w.away[None], "angles": 4, "approach": 0.01},
    ),
    "feeler.opening": lambda w: (feeler.opening, {"scene": w.scene, "at": [5.0, 5.0, 5.0], "axis": [0.0, 0.0, 1.0]}),
    "feeler.opening_limits": lambda w: (feeler.opening_limits, {"path": "limits.toml"}),
    "feeler.catalogue": lambda w: (feeler.catalogue, {}),
    "feeler.Catalogue": lambda w: (feeler.Catalogue, {"rows": []}),
    "feeler.Catalogue.where": lambda w: (feeler.catalogue().where, {"names": "ring"}),
    "feeler.Catalogue.tool": lambda w: (feeler.catalogue().tool, {"name": "ring 10"}),
    "feeler.ToolSpec.length": lambda w: (feeler.catalogue()[0].length, {"name": "blade"}),
    "feeler.Catalogue.pieces": lambda w: (feeler.catalogue().pieces, {"name": "ring 10"}),
    "feeler.Catalogue.fitting": lambda w: (
        feeler.catalogue().fitting,
        {"drive": "hexagon", "across_flats": 0.01, "thread": 0.006},
    ),
    "feeler.Scene.save": lambda w: (w.scene.save, {"path": "out.feeler"}),
    "feeler.clash": lambda w: (feeler.clash, {"mockup": w.mockup}),
    "feeler.clash_variants": lambda w: (feeler.clash_variants, {"variants": [w.mockup]}),
    "feeler.find_fasteners": lambda w: (feeler.find_fasteners, {"mockup": w.mockup}),
    "feeler.sight": lambda w: (feeler.sight, {"scene": w.scene, "targets": [0], "eyes": [[5.0, 5.0, 5.0]]}),
    "feeler.eyes_in": lambda w: (feeler.eyes_in, {"lower": [0, 0, 0], "upper": [1, 1, 1]}),
    "feeler.Sight": lambda w: (feeler.Sight, {"rows": []}),
    "feeler.maintain": lambda w: (feeler.maintain, {"scene": w.scene, "parts": [1], "seconds": 5.0}),
    "feeler.load_maintenance": lambda w: (feeler.load_maintenance, {"path": "last.json"}),
    "feeler.Maintenance.failing": lambda w: (w.night.failing, {"word": "slower"}),
    "feeler.Maintenance.save": lambda w: (w.night.save, {"path": "night.json"}),
    "feeler.Maintenance.to_html": lambda w: (w.night.to_html, {"path": "night.html"}),
    "feeler.Maintenance.to_xlsx": lambda w: (w.night.to_xlsx, {"path": "night.xlsx"}),
    "feeler.holds": lambda w: (feeler.holds, {"mockup": w.mockup}),
    "feeler.Holds": lambda w: (feeler.Holds, {"rows": []}),
    "feeler.Holds.of": lambda w: (feeler.Holds([]).of, {"fastener": 0}),
    "feeler.Holds.holding": lambda w: (feeler.Holds([]).holding, {"part": 0}),
    "feeler.task": lambda w: (feeler.task, {"scene": w.scene, "parts": [0], "seconds": 5.0}),
    "feeler.Task.to_glb": lambda w: (w.task.to_glb, {"path": "task.glb", "mockup": w.mockup}),
    "feeler.Task.to_html": lambda w: (w.task.to_html, {"path": "task.html"}),
    "feeler.Task.to_xlsx": lambda w: (w.task.to_xlsx, {"path": "task.xlsx"}),
    "feeler.Times": lambda w: (feeler.Times, {}),
    "feeler.Times.load": lambda w: (feeler.Times.load, {"path": "times.toml"}),
    "feeler.Times.parse": lambda w: (feeler.Times.parse, {"text": "[elements]"}),
    "feeler.Times.save": lambda w: (feeler.Times().save, {"path": "times.toml"}),
    "feeler.find_joint": lambda w: (feeler.find_joint, {"mockup": guided(), "child": 0, "parent": [1, 2, 3, 4]}),
    "feeler.from_open3d": lambda w: (feeler.from_open3d, {"mesh": None}),
    "feeler.from_pyvista": lambda w: (feeler.from_pyvista, {"mesh": None}),
    "feeler.from_trimesh": lambda w: (feeler.from_trimesh, {"mesh": w.mockup}),
    "feeler.from_urdf": lambda w: (feeler.from_urdf, {"path": "robot.urdf"}),
    "feeler.insertion": plan(feeler.insertion),
    "feeler.Requirement": lambda w: (feeler.Requirement, {"name": "one", "a": "*", "b": "*", "gap": 0.1}),
    "feeler.read_requirements": lambda w: (feeler.read_requirements, {"path": "requirements.toml"}),
    "feeler.verify": lambda w: (
        feeler.verify,
        {"scene": w.scene, "requirements": [feeler.Requirement("one", "post", "far", 0.1)]},
    ),
    "feeler.load_clashes": lambda w: (feeler.load_clashes, {"path": "clashes.json"}),
    "feeler.load_mockup": lambda w: (feeler.load_mockup, {"path": "mesh.stl"}),
    "feeler.load_tool": lambda w: (feeler.load_tool, {"path": "mesh.stl"}),
    "feeler.nearest_rigid": lambda w: (feeler.nearest_rigid, {"pose": w.pose}),
    "feeler.Project.changes": lambda w: (w.project.changes, {"mockup": w.mockup}),
    "feeler.Project.history": lambda w: (w.project.history, {"finding": "x"}),
    "feeler.Project.save_copy": lambda w: (w.project.save_copy, {"path": "copy.feelproj"}),
    "feeler.Project.write_clashes": lambda w: (w.project.write_clashes, {"clashes": w.clashes}),
    "feeler.open_project": lambda w: (feeler.open_project, {"path": "project.feelproj", "read_only": True}),
    "feeler.open_scene": lambda w: (feeler.open_scene, {"path": "scene.feeler"}),
    "feeler.optimal_voxel_size": lambda w: (feeler.optimal_voxel_size, {"mockup": w.mockup, "tool": w.tool}),
    "feeler.removal": plan(feeler.removal),
    "feeler.removal_order": plan(feeler.removal_order),
    "feeler.removals": lambda w: (feeler.removals, {"scene": w.scene, "parts": ["far"], "seconds": 5.0}),
    "feeler.sample": lambda w: (feeler.sample, {"name": "differential", "triangles": 10_000}),
    "feeler.sample_path": lambda w: (feeler.sample_path, {"scene": w.scene, "tool": w.tool, "n": 2}),
    "feeler.sample_poses": lambda w: (
        feeler.sample_poses,
        {"scene": w.scene, "tool": w.tool, "kind": "near", "n": 1},
    ),
    "feeler.sample_tool": lambda w: (feeler.sample_tool, {"name": "wrench"}),
    "feeler.sample_truth": lambda w: (feeler.sample_truth, {"name": "gearbox", "triangles": 75_000}),
    "feeler.swept": lambda w: (feeler.swept, {"tool": w.tool, "poses": [w.pose, w.away], "error": 0.05}),
    "feeler.samples.Truth.fit": lambda w: (w.truth.fit, {"a": w.truth.fits[0].a, "b": w.truth.fits[0].b}),
    "feeler.samples.Truth.holds": lambda w: (w.truth.holds, {"path": w.truth.fits[0].a}),
    "feeler.samples.Truth.needed": lambda w: (w.truth.needed, {"step": w.truth.steps[0]}),
    "feeler.samples.Truth.way": lambda w: (w.truth.way, {"path": w.truth.fits[0].a}),
    "feeler.haptics.Coupling": lambda w: (haptics.Coupling, {}),
    "feeler.haptics.Coupling.for_device": lambda w: (haptics.Coupling.for_device, {"device": w.device}),
    "feeler.haptics.Session": lambda w: (haptics.Session, {"scene": w.scene, "tool": w.tool}),
    "feeler.haptics.Session.grip": lambda w: (started(w).grip, {"parts": "far"}),
    "feeler.haptics.Session.guide": lambda w: (guide_while_running(w), {"world_from_tool": w.away}),
    "feeler.haptics.Session.record": lambda w: (started(w).record, {"path": "record.npz"}),
    "feeler.haptics.Session.release": lambda w: (gripping(w).release, {}),
    "feeler.haptics.Session.run": lambda w: (run_and_stop(w), {"device": w.device, "realtime": False}),
    "feeler.haptics.Session.set_scene": lambda w: (started(w).set_scene, {"scene": w.scene}),
    "feeler.haptics.Session.start": lambda w: (started(w).start, {"world_from_tool": w.away}),
    "feeler.haptics.Session.step": lambda w: (started(w).step, {"world_from_tool": w.away}),
    "feeler.haptics.open_device": lambda w: (haptics.open_device, {"name": "nothing"}),
    "feeler.haptics.replay": lambda w: (haptics.replay, {"path": "session.npz"}),
    "feeler.haptics.devices.Info": lambda w: (devices.Info, {"name": "own"}),
    "feeler.haptics.devices.Mouse": lambda w: (devices.Mouse, {"pose": w.pose}),
    "feeler.haptics.devices.Mouse.set_buttons": lambda w: (w.mouse.set_buttons, {"buttons": 1}),
    "feeler.haptics.devices.Mouse.set_target": lambda w: (w.mouse.set_target, {"pose": w.pose}),
    "feeler.haptics.devices.Simulated": lambda w: (
        devices.Simulated,
        {"hand": ([0.0, 1.0], [w.pose, w.away]), "fault": ("nan", 0.0, 0.0, 1.0)},
    ),
    "feeler.clashes.Exclusion": lambda w: (clashes.Exclusion, {"name": "seals", "a": "*"}),
    "feeler.clashes.Rule": lambda w: (clashes.Rule, {"name": "all"}),
    "feeler.clashes.Rules": lambda w: (clashes.Rules, {"rules": (clashes.Rule("all"),)}),
    "feeler.clashes.Rules.read": lambda w: (clashes.Rules.read, {"path": "rules.toml"}),
    "feeler.clashes.Rules.parse": lambda w: (clashes.Rules.parse, {"text": "version = 1"}),
    "feeler.clashes.apply_bcf": lambda w: (clashes.apply_bcf, {"clashes": w.clashes, "topics": []}),
    "feeler.clashes.read_bcf": lambda w: (clashes.read_bcf, {"path": "topics.bcf"}),
    "feeler.clashes.report": lambda w: (clashes.report, {"clashes": w.clashes}),
    "feeler.clashes.write_bcf": written(clashes.write_bcf, "out.bcf"),
    "feeler.clashes.write_clash_glb": written(clashes.write_clash_glb, "out.glb"),
    "feeler.clashes.write_csv": written(clashes.write_csv, "out.csv", has_mockup=False),
    "feeler.clashes.write_html": written(clashes.write_html, "out.html"),
    "feeler.clashes.write_rules": written(clashes.write_rules, "out.toml", has_mockup=False),
    "feeler.clashes.write_xlsx": written(clashes.write_xlsx, "out.xlsx"),
    "feeler.io.Body": lambda w: (io.Body, vars(w.body)),
    "feeler.io.Mark": lambda w: (io.Mark, {"faces": np.array([0]), "colour": (1.0, 0.0, 0.0)}),
    "feeler.io.body_of": lambda w: (io.body_of, {"mesh": w.mockup}),
    "feeler.io.check_target": lambda w: (io.check_target, {"path": "out.glb"}),
    "feeler.io.csv_table": lambda w: (io.csv_table, {"heading": ["a"], "rows": [[1]]}),
    "feeler.io.Motion": lambda w: (io.Motion, {"part": 0, "times": np.arange(2.0), "poses": np.stack([np.eye(4)] * 2)}),
    "feeler.io.animated_glb": lambda w: (io.animated_glb, {"mesh": w.mockup, "motions": []}),
    "feeler.io.with_marks": lambda w: (
        io.with_marks,
        {"body": w.body, "marks": [io.Mark(np.array([0]), (1.0, 0.0, 0.0))]},
    ),
    "feeler.io.write_glb": lambda w: (io.write_glb, {"path": "out.glb", "meshes": w.mockup}),
    "feeler.io.write_stl": lambda w: (io.write_stl, {"path": "out.stl", "mesh": w.mockup}),
    "feeler.picture.Camera": lambda w: (picture.Camera, {"eye": (3.0, 3.0, 3.0), "target": (0.0, 0.0, 0.0)}),
    "feeler.picture.Camera.framing": lambda w: (picture.Camera.framing, {"points": w.mockup.vertices}),
    "feeler.picture.Camera.shares": lambda w: (w.camera.shares, {"points": w.mockup.vertices, "size": (64, 48)}),
    "feeler.picture.Inset": lambda w: (picture.Inset, {"camera": w.camera}),
    "feeler.picture.Section": lambda w: (picture.Section, {"point": (0.0, 0.0, 0.0), "normal": (0.0, 0.0, 1.0)}),
    "feeler.picture.bars": lambda w: (
        picture.bars,
        {"start": np.zeros((1, 3)), "end": np.ones((1, 3)), "thickness": 0.1, "paths": ["a"]},
    ),
    "feeler.picture.clearance_bodies": drawn(picture.clearance_bodies, "clearance"),
    "feeler.picture.collision_bodies": drawn(picture.collision_bodies, "collision"),
    "feeler.picture.render": lambda w: (picture.render, {"path": "out.png", "meshes": w.mockup, "size": (64, 48)}),
    "feeler.picture.render_collision": drawn(picture.render_collision, "collision", path="out.png", size=(64, 48)),
    "feeler.picture.write_clearance_glb": drawn(picture.write_clearance_glb, "clearance", path="out.glb"),
    "feeler.picture.write_collision_glb": drawn(picture.write_collision_glb, "collision", path="out.glb"),
}
"""A good call of each public callable that takes arguments: the callable, and its arguments."""

OTHERWISE = {
    "feeler.view": "opens a server: tested with the workbench",
    "feeler.haptics.devices.Own.write": "of the user's device",
    "feeler.View.command": "arguments by name",
    "feeler.Tracks": "made by load_tracks",
}
"""Public callables that this sweep leaves out, and why."""


def started(world: World) -> haptics.Session:
    if world.session._recorder is not None:
        world.session._recorder.close()
    world.session.set_scene(world.scene)  # with all parts in their places
    world.session.start(world.away)
    return world.session


def gripping(world: World) -> haptics.Session:
    session = started(world)
    session.grip("far")
    return session


def run_and_stop(world: World) -> Callable[..., object]:
    session = haptics.Session(world.scene, world.tool)
    session.start(world.away)

    def run(*args: Any, **kwargs: Any) -> object:
        try:
            return session.run(*args, **kwargs)
        finally:
            session.stop()

    run.__signature__ = inspect.signature(session.run)  # type: ignore[attr-defined]
    return run


def guide_while_running(world: World) -> Callable[..., object]:
    session = haptics.Session(world.scene, world.tool)
    session.start(world.away)

    def guide(*args: Any, **kwargs: Any) -> object:
        session.run(devices.Simulated(), realtime=False)
        try:
            return session.guide(*args, **kwargs)
        finally:
            session.stop()

    guide.__signature__ = inspect.signature(session.guide)  # type: ignore[attr-defined]
    return guide


def public_callables() -> dict[str, object]:
    """Functions, constructors and methods of the public modules that take arguments, by name."""
    found: dict[str, object] = {}
    for space in map(importlib.import_module, SPACES):
        own = [name for name, value in vars(space).items() if getattr(value, "__module__", "") == space.__name__]
        for name in getattr(space, "__all__", own):
            value = getattr(space, name)
            is_call = inspect.isfunction(value) or (inspect.isclass(value) and not issubclass(value, BaseException))
            if name.startswith("_") or not is_call:
                continue
            if any(value is each for each in found.values()):
                continue  # of several modules
            found[f"{space.__name__}.{name}"] = value
            for member in dir(value) if inspect.isclass(value) else ():
                each = getattr(value, member)
                is_own = any(member in vars(base) for base in value.__mro__ if base.__module__.startswith("feeler"))
                if is_own and not member.startswith("_") and callable(each):
                    found[f"{space.__name__}.{name}.{member}"] = each
    return {name: value for name, value in found.items() if value not in MADE_BY_FEELER and takes_arguments(value)}


def takes_arguments(value: object) -> bool:
    return any(name != "self" for name in inspect.signature(value).parameters)  # type: ignore[arg-type]


@pytest.fixture(scope="module")
def world(tmp_path_factory: pytest.TempPathFactory) -> Iterator[World]:
    with pytest.MonkeyPatch.context() as patch:
        patch.chdir(tmp_path_factory.mktemp("sweep"))
        yield World()


def test_every_public_callable_is_swept() -> None:
    views = {name for name in public_callables() if name.startswith("feeler.View.")}
    assert set(public_callables()) - set(OTHERWISE) - views == set(GOOD)
    assert set(OTHERWISE) <= set(public_callables()) and len(views) > 20


def called(call: Call, **other: object) -> None:
    function, arguments = call
    arguments = {**arguments, **other}
    signature = inspect.signature(function)
    rest = [name for name, each in signature.parameters.items() if each.kind is each.VAR_POSITIONAL]
    more = [arguments.pop(name) for name in rest if name in arguments]
    before = [arguments.pop(name) for name in list(signature.parameters) if rest and name == "path"]
    function(*before, *more, **arguments)


def swept(make: Callable[[], Call]) -> list[str]:
    """Arguments and values with errors that are not feeler's."""
    wrong = []
    for name, parameter in inspect.signature(make()[0]).parameters.items():
        if parameter.kind is parameter.VAR_KEYWORD:
            continue
        for value in BAD:
            try:
                called(make(), **{name: value})
            except feeler.FeelerError:
                pass
            except Exception as error:
                wrong.append(f"{name}={value!r:.40}: {type(error).__name__}: {error!s:.80}")
    return wrong


@pytest.mark.parametrize("name", list(GOOD))
def test_bad_arguments_are_refused_by_errors_of_feeler(name: str, world: World) -> None:
    if name == "feeler.clashes.write_xlsx":
        pytest.importorskip("xlsxwriter")
    if name not in ("feeler.from_open3d", "feeler.from_pyvista", "feeler.haptics.open_device"):
        called(GOOD[name](world))  # the good call is one
    assert swept(lambda: GOOD[name](world)) == []


VIEW_ARGUMENTS: dict[str, object] = {
    "a": "*post*",
    "b": "*",
    "gap": 0.01,
    "key": "none",
    "lower": (-1.0, -1.0, -1.0),
    "upper": (1.0, 1.0, 1.0),
    "results": [],
    "rows": [0],
    "version": "00ff",
    "camera": {"pose": np.eye(4).ravel().tolist(), "distance": 1.0, "fov_deg": 40.0, "is_ortho": False},
    "edit": "off",
    "findings": [],
    "hit": np.eye(4),
    "id": 1,
    "index": 0,
    "is_on": True,
    "is_touching_hidden": True,
    "material": None,
    "mode": "stop",
    "name": "one",
    "normal": (0.0, 0.0, 1.0),
    "offset": 0.0,
    "parts": "sheet",
    "pose": np.eye(4).ravel().tolist(),
    "question": "removal",
    "share": 0.0,
    "status": "approved",
    "text": "[[joint]]",
    "toml": "[elements]",
    "type": "distance",
    "unit": "mm",
    "value": 0.5,
    "watcher": print,
}
"""An argument of each name for the commands that need it; the command itself may be impossible."""


@pytest.fixture(scope="module")
def view() -> Iterator[View]:
    class Nobody:
        url = "http://127.0.0.1"

        def close(self) -> None: ...

    bench = Bench(cube())
    with View(bench.session, Nobody()) as opened:
        yield opened


@pytest.mark.parametrize("name", sorted(name for name in public_callables() if name.startswith("feeler.View.")))
def test_bad_arguments_of_a_view_are_refused_too(name: str, view: View, tmp_path: Path) -> None:
    if name in OTHERWISE:
        return
    method = getattr(view, name.removeprefix("feeler.View."))
    needed = [each.name for each in inspect.signature(method).parameters.values() if each.default is each.empty]
    arguments = {each: VIEW_ARGUMENTS[each] for each in needed}
    assert swept(lambda: (method, arguments)) == []


def masked(values: Any) -> Any:
    """The same numbers, of which the first is masked."""
    numbers = np.asarray(values)
    mask = np.zeros(numbers.shape, dtype=bool)
    mask.flat[0] = True
    return np.ma.masked_array(numbers, mask)


def pair() -> feeler.Scene:
    """Of two parts."""
    return feeler.Scene(feeler.Mockup({name: (np.array(TRIANGLE), np.array([[0, 1, 2]])) for name in "ab"}))


MASKED = {
    "vertices": lambda s, t: feeler.Mockup(masked(TRIANGLE), [[0, 1, 2]]),
    "faces": lambda s, t: feeler.Tool(TRIANGLE, masked([[0, 1, 2]])),
    "a pose": lambda s, t: s.is_colliding(t, masked(np.eye(4))),
    "whole numbers as a pose": lambda s, t: s.is_colliding(t, masked(np.eye(4, dtype=int))),
    "poses": lambda s, t: s.collide_batch(t, masked(np.eye(4)[None])),
    "a list of poses": lambda s, t: s.collide_batch(t, [masked(np.eye(4))]),
    "a pose to repair": lambda s, t: feeler.nearest_rigid(masked(np.eye(4))),
    "origins": lambda s, t: s.rays(masked([[0.0, 0, 9]]), [[0, 0, -1.0]]),
    "parts": lambda s, t: s.only(masked([True])),
    "meshes by name": lambda s, t: feeler.Mockup({"a": (masked(TRIANGLE), [[0, 1, 2]])}),
    "colours": lambda s, t: setattr(s.mockup, "part_colours", masked(np.zeros((1, 3)))),
    "a section": lambda s, t: s.section(masked([0.0, 0, 1]), [0, 0, 1]),
    "a way": lambda s, t: feeler.Slide(masked([0.0, 0, 1])),
    "an axis": lambda s, t: feeler.Screw(masked([0.0, 0, 1]), [0, 0, 0], 1.0),
    "a point of an axis": lambda s, t: feeler.Screw([0, 0, 1], masked([0.0, 0, 1]), 1.0),
    "directions": lambda s, t: feeler.removal(pair(), "a", directions=masked([[0.0, 0, 1]])),
    "pairs to ignore": lambda s, t: s.distance(t, np.eye(4), ignore=masked([[0, 0]])),
}
TRIANGLE = [[0.0, 0, 0], [1, 0, 0], [0, 1, 0]]


DATES: Any = np.array(["2020-01-01"], "M8[D]")
NOT_NUMBERS: dict[str, Callable[[feeler.Scene], object]] = {
    "text as a way": lambda s: feeler.Slide(["0", "0", "1"]),
    "truths as an axis": lambda s: feeler.Screw([True, False, False], [0, 0, 0], 1.0),
    "a truth as an angle": lambda s: feeler.Screw([0, 0, 1], [0, 0, 0], True),
    "a truth of NumPy as an angle": lambda s: feeler.Screw([0, 0, 1], [0, 0, 0], np.True_),
    "a truth of NumPy as a distance": lambda s: feeler.clash(s.mockup, clearance=np.True_),
    "a truth as a lift": lambda s: feeler.access(s, feeler.sample_tool("wrench"), np.eye(4), lift=True),
    "dates as turns": lambda s: feeler.access(s, feeler.sample_tool("wrench"), np.eye(4), turns=DATES),
    "a truth as a pitch": lambda s: feeler.Screw([0, 0, 1], [0, 0, 0], 1.0, False),
    "text as directions": lambda s: feeler.removal(s, "a", directions=[["0", "0", "1"]]),
    "truths as directions": lambda s: feeler.removal(s, "a", directions=[[True, False, False]]),
}


@pytest.mark.parametrize("what", list(NOT_NUMBERS))
def test_text_and_truths_are_no_numbers_of_motions(what: str) -> None:
    scene = pair()
    with pytest.raises(feeler.OptionError, match=r"give three numbers|give (a )?(number|metres)|real numbers"):
        NOT_NUMBERS[what](scene)


@pytest.mark.parametrize("what", list(MASKED))
def test_masked_entries_are_no_numbers(what: str) -> None:
    scene, tool = feeler.Scene(feeler.Mockup(TRIANGLE, [[0, 1, 2]])), feeler.Tool(TRIANGLE, [[0, 1, 2]])
    with pytest.raises(feeler.FeelerError, match=r"masked entries: leave them out, or fill them"):
        MASKED[what](scene, tool)
    assert scene.is_colliding(tool, np.ma.masked_array(np.eye(4))), "nothing is masked"
