"""Seats of tracks: pairs of parts in contact where a motion begins, followed by the one rule of seats."""

from __future__ import annotations

import math
from collections.abc import Iterable, Sequence

import numpy as np
import numpy.typing as npt

from feeler._core import Chain, Screw, Slide, World
from feeler.choices import TOUCHINGS
from feeler.mechanism.seating import TOUCH_M, Seated, Turn, round_fit, rounds_about, rule_of
from feeler.mechanism.track_motion import SAME, Step, seen_from
from feeler.mockup import Tool
from feeler.part_meshes import PartMeshes
from feeler.scene import Scene

Floats = npt.NDArray[np.float64]
Met = tuple[float, Floats, Floats]
"""A time, a point and a normal, in the frame of the other body at rest."""


class TrackSeat:
    """A pair of parts of two bodies that are in contact at the start."""

    def __init__(self, seat: Seated, tool: Tool, around: Scene, start: Floats) -> None:
        """tool: the part as its seat is followed; around: the other alone."""
        self.seat, self._tool, self._around, self._start = seat, tool, around, start

    def meets(self, step: Step) -> Met | None:
        """Where the pair first goes deeper in a step than at the start, or meets elsewhere."""
        if step.joints:
            way = Chain(step.joints)
            met = self.seat.meets(step.pose, way)
            if met is None or self.seat.meets(way.at(step.pose), Chain(reversed_joints(step.joints))) is None:
                return None  # where it lands in its seat, it is no deeper on the way back
            share, point, normal = met
            return step.begin + share * (step.end - step.begin), point, normal
        if np.abs(step.pose - self._start).max() <= SAME:
            return None  # it jumps back to its seat
        hit = self._around.cast(self._tool, step.pose, step.pose, touching=TOUCHINGS[-1])
        return None if hit is None else (step.begin, hit.point, hit.normal)


def seats_at(
    meshes: PartMeshes, scene: Scene, own: Sequence[int], others: Sequence[int], pose: Floats, turn: Turn | None
) -> list[TrackSeat]:
    """The pairs of a part of one body and one of another that are in contact.

    scene: all parts at rest. pose: of the one body in the frame of the other. turn: the axis about which the one turns
    first, in that frame: facets of pins and holes about it do not count.
    """
    mockup = scene.mockup
    tool, around = Tool.of_parts(mockup, list(own)), scene.only(list(others))
    near = around.clearance(tool, pose, TOUCH_M)
    pairs = set(zip(near.tool_parts.tolist(), near.parts.tolist(), strict=True))
    pairs |= {(int(a), int(b)) for a, b in World(around, []).seated_parts(tool, pose)}
    found = []
    for number, other in sorted(pairs):
        vertices, faces = meshes.mesh(own[number])
        its = meshes.mesh(other)
        fit = None
        if turn is not None:
            mesh = (vertices @ pose[:3, :3].T + pose[:3, 3], faces)
            fit = round_fit(turn, mesh, rounds_about(turn, mesh), its)
            if fit is not None:
                vertices = (fit.moved(mesh[0]) - pose[:3, 3]) @ pose[:3, :3]
        single = scene.only([other])
        kind, rule = rule_of((vertices, faces), fit, its, single, pose)
        found.append(TrackSeat(Seated(number, own[number], other, kind, rule), Tool(vertices, faces), single, pose))
    return found


def reversed_joints(joints: Sequence[Screw | Slide]) -> list[Screw | Slide]:
    """The way back from where a chain ends."""
    found = []
    at = np.eye(4)
    for joint in joints:
        if isinstance(joint, Slide):
            back: Screw | Slide = Slide(-np.array(joint.way))
        else:
            back = Screw(joint.axis, joint.point, -joint.angle, joint.pitch)
        found.append(seen_from(back, at))
        at = at @ Chain([joint]).at(np.eye(4))
    return found


def turn_of(steps: Iterable[Step]) -> Turn | None:
    """The axis of the first step that only turns; None if there is none."""
    taken = list(steps)
    for step in taken:
        if len(step.joints) == 1 and isinstance(step.joints[0], Screw):
            screw = step.joints[0]
            axis = np.array(screw.axis, dtype=np.float64)
            axis, point = axis / math.sqrt(float(axis @ axis)), np.array(screw.point, dtype=np.float64)
            is_alone = all(each.joints and all(_turns(joint, axis, point) for joint in each.joints) for each in taken)
            return Turn(axis, point, is_alone)
    return None


def _turns(joint: Screw | Slide, axis: Floats, point: Floats) -> bool:
    """Whether a joint only turns about an axis."""
    if isinstance(joint, Slide) or joint.pitch != 0.0:
        return False
    off = np.cross(np.array(joint.point) - point, axis)
    return bool(max(np.abs(off).max(), np.abs(np.cross(joint.axis, axis)).max()) <= SAME)
