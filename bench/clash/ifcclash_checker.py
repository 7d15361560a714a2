"""ifcclash, through an IFC file: each part a proxy element with a triangulated face set, in metres, in place.

It runs in all three modes, without tolerance. A pair reported by `intersection`, or by `collision` without touching, is
a clash with the depth from `intersection`, if there is one. A pair reported by `collision` with touching, or by
`clearance` at a distance of 0, is a contact. A pair reported by `clearance` has that gap. Triangles and trees are kept
between modes.
"""

from __future__ import annotations

import logging
import tempfile
import time
from importlib.metadata import version
from pathlib import Path
from typing import Any

import ifcopenshell
import ifcopenshell.guid
from ifcclash.ifcclash import Clasher, ClashSettings

import feeler

from .checkers import CLEARANCE_M, Answer, Pairs, Whole, ordered, part_meshes

INTERSECTION = {"mode": "intersection", "tolerance": 0.0, "check_all": True}
COLLISION = {"mode": "collision", "allow_touching": False}
TOUCHING = {"mode": "collision", "allow_touching": True}
CLEARANCE = {"mode": "clearance", "clearance": CLEARANCE_M, "check_all": True}


class IfcclashChecker:
    """`ifcclash.Clasher` with its own settings."""

    name = "ifcclash"
    version = version("ifcclash")

    def pair(self, mockup: feeler.Mockup) -> Answer:
        """Of a mock-up of two parts."""
        with _Checked(mockup) as checked:
            deep = checked.ask(INTERSECTION)
            if deep or checked.ask(COLLISION):
                return Answer("clash", max(deep.values()) if deep else None)
            near = checked.ask(CLEARANCE)
            gap = min(near.values(), default=None)
            if gap == 0.0 or checked.ask(TOUCHING):
                return Answer("contact", 0.0)
            return Answer("none") if gap is None else Answer("clearance", gap)

    def whole(self, mockup: feeler.Mockup, repeats: int) -> Whole:
        """Of all pairs of parts. The file is there before the clock starts; its tree is made once."""
        seconds: dict[str, float] = {}
        pairs: dict[str, Pairs] = {}
        with _Checked(mockup) as checked:
            for query, mode in (("verdicts", TOUCHING), ("clearance", CLEARANCE), ("depths", INTERSECTION)):
                times = []
                for _ in range(repeats):
                    pairs[query] = set(checked.ask(mode))
                    times.append(checked.asked_s)
                seconds[query] = min(times)
            return Whole({"index": checked.indexed_s, **seconds}, pairs)


class _Checked:
    """A mock-up as an IFC file, and what ifcclash keeps of it."""

    def __init__(self, mockup: feeler.Mockup) -> None:
        self._folder = tempfile.TemporaryDirectory()
        path = Path(self._folder.name) / "mockup.ifc"
        write_ifc(path, mockup)
        self._source = {"file": str(path)}
        settings = ClashSettings()
        settings.logger = logging.getLogger("ifcclash")
        self._clasher = Clasher(settings)
        self._put_in = self._clasher.add_collision_objects
        self._clasher.add_collision_objects = self._keep
        self._elements: list[Any] = []
        self._group: dict[str, Any] = {}
        self._began = 0.0
        self.indexed_s = 0.0
        self.asked_s = 0.0

    def __enter__(self) -> _Checked:
        return self

    def __exit__(self, *_: object) -> None:
        self._folder.cleanup()

    def ask(self, mode: dict[str, Any]) -> dict[tuple[int, int], float]:
        """The pairs that a mode reports, and their distances, metres."""
        asked = {"name": "all", "a": [dict(self._source)], **mode}
        self._clasher.clash_sets = [asked]
        self._clasher.clash()
        self.asked_s = time.perf_counter() - self._began
        return {
            ordered(int(each["a_name"]), int(each["b_name"])): float(each["distance"])
            for each in asked["clashes"].values()
        }

    def _keep(self, name: str, model: Any, source: dict[str, Any]) -> None:
        """ifcclash's own way of filling its tree the first time; then the same elements again."""
        tree = self._clasher.tree
        if self._elements:
            for element in self._elements:
                tree.add_element(element)
            self._clasher.groups[name]["elements"].update(self._group)
        else:
            begun = time.perf_counter()
            self._clasher.tree = _Listening(tree, self._elements)
            self._put_in(name, model, source)
            self._clasher.tree = tree
            self._group = dict(self._clasher.groups[name]["elements"])
            self.indexed_s = time.perf_counter() - begun
        self._began = time.perf_counter()


class _Listening:
    """A tree that notes the shapes put into it."""

    def __init__(self, tree: Any, elements: list[Any]) -> None:
        self._tree, self._elements = tree, elements

    def add_element(self, element: Any) -> None:
        self._elements.append(element)
        self._tree.add_element(element)


def write_ifc(path: Path, mockup: feeler.Mockup) -> None:
    """The mock-up as IFC4: an element for each part, called by its number."""
    file = ifcopenshell.file(schema="IFC4")
    make = file.create_entity
    origin = make("IfcAxis2Placement3D", Location=make("IfcCartesianPoint", (0.0, 0.0, 0.0)))
    context = make(
        "IfcGeometricRepresentationContext",
        ContextType="Model",
        CoordinateSpaceDimension=3,
        Precision=1e-12,
        WorldCoordinateSystem=origin,
    )
    units = make("IfcUnitAssignment", Units=[make("IfcSIUnit", UnitType="LENGTHUNIT", Name="METRE")])
    make(
        "IfcProject",
        GlobalId=ifcopenshell.guid.new(),
        Name="mock-up",
        RepresentationContexts=[context],
        UnitsInContext=units,
    )
    place = make("IfcLocalPlacement", RelativePlacement=origin)
    for part, (vertices, faces) in enumerate(part_meshes(mockup)):
        points = make("IfcCartesianPointList3D", CoordList=vertices.tolist())
        surface = make("IfcTriangulatedFaceSet", Coordinates=points, CoordIndex=(faces + 1).tolist())
        body = make(
            "IfcShapeRepresentation",
            ContextOfItems=context,
            RepresentationIdentifier="Body",
            RepresentationType="Tessellation",
            Items=[surface],
        )
        make(
            "IfcBuildingElementProxy",
            GlobalId=ifcopenshell.guid.new(),
            Name=str(part),
            ObjectPlacement=place,
            Representation=make("IfcProductDefinitionShape", Representations=[body]),
        )
    file.write(str(path))
