"""Mechanisms from URDF: links that fixed joints hold together become one, and joints move into the world."""

from __future__ import annotations

import os
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import replace
from pathlib import Path

import numpy as np
import numpy.typing as npt

from feeler.arguments import check_kind, check_path, check_word
from feeler.choices import GEOMETRIES
from feeler.choices import Geometry as GeometryKind
from feeler.errors import FeelerError, LoadError, PoseError
from feeler.interchange.kinematics import zero_poses
from feeler.interchange.urdf import placed_robot
from feeler.interchange.urdf_file import MOVES, Link, read_urdf
from feeler.interchange.urdf_file import Joint as Hinge
from feeler.io.raw import PathBook
from feeler.mechanism.coupling import JointCoupling
from feeler.mechanism.joint import Joint, JointKind
from feeler.mockup import Mockup
from feeler.parts import PartsLike
from feeler.poses import PoseLike, nearest_rigid, one_pose

Floats = npt.NDArray[np.float64]
PathLike = str | os.PathLike[str]

_KINDS = {
    "revolute": JointKind.REVOLUTE,
    "continuous": JointKind.REVOLUTE,
    "prismatic": JointKind.PRISMATIC,
}


def read_robot(
    path: PathLike,
    geometry: GeometryKind,
    package_dirs: Iterable[PathLike] | Mapping[str, PathLike],
    chord_tolerance: float,
    around: Mockup | None,
    world_from_base: PoseLike | None,
) -> tuple[Mockup, list[Joint], list[JointCoupling]]:
    """See `Mechanism.from_urdf`."""
    check_word("geometry", geometry, GEOMETRIES)
    file = check_path("path", path)
    base = np.eye(4) if world_from_base is None else _rigid(world_from_base)
    if around is not None:
        check_kind("around", around, Mockup)
    links, hinges = read_urdf(file)
    for each in hinges:
        if each.kind in ("floating", "planar"):
            raise LoadError(
                f"{file}: joint {each.name!r} is {each.kind}, which is no motion along one axis: write it as fixed, or "
                "as prismatic and revolute joints, one after the other"
            )
    poses = {name: base @ pose for name, pose in zero_poses(links, hinges, str(file)).items()}
    hinges = [replace(each, kind="fixed", mimic=None) if _stands(each) else each for each in hinges]
    body_of = _bodies(links, hinges)
    with_parts = {body_of[each.name] for each in links if (each.collision if geometry == "collision" else each.visual)}
    bare = {name for name in body_of.values() if name not in with_parts}
    robot = placed_robot(file, links, poses, (), geometry, package_dirs, chord_tolerance, bare)
    mockup = robot.mockup if around is None else _joined(robot.mockup, around)
    own: dict[str, list[str]] = {}
    for link in links:
        if robot.parts[link.name]:
            own.setdefault(body_of[link.name], []).append(link.name)
    children: dict[str, PartsLike] = {
        body: _called(mockup, names, [part for name in names for part in robot.parts[name]])
        for body, names in own.items()
    }
    below = {each.child for each in hinges}
    roots = {body_of[each.name] for each in links if each.name not in below}
    names = _names(hinges, file)
    joints = [_joint(each, poses, body_of, children, roots, names) for each in hinges if each.kind in MOVES]
    if not joints:
        raise LoadError(f"{file}: no joint moves; load it with feeler.from_urdf")
    couplings = [
        JointCoupling(names[each.name], names[each.mimic.joint], each.mimic.multiplier, each.mimic.offset)
        for each in hinges
        if each.mimic is not None and each.kind in MOVES and _leads(hinges, each.mimic.joint, each.name, file)
    ]
    return mockup, joints, couplings


def _rigid(world_from_base: PoseLike) -> npt.NDArray[np.float64]:
    """Where the base stands. Raises `PoseError` for scales and mirrors: joints would turn otherwise."""
    try:
        return nearest_rigid(one_pose(world_from_base, "world_from_base"))
    except PoseError as error:
        raise PoseError(str(error).replace("the pose", "world_from_base", 1)) from None


def _stands(hinge: Hinge) -> bool:
    return hinge.mimic is not None and hinge.mimic.multiplier == 0.0


def _leads(hinges: Sequence[Hinge], leader: str, name: str, file: Path) -> bool:
    kind = next(each.kind for each in hinges if each.name == leader)
    if kind not in MOVES:
        raise LoadError(f"{file}: joint {name!r} mimics {leader!r}, which is {kind} and does not move: make it fixed")
    return True


def _bodies(links: Sequence[Link], hinges: Sequence[Hinge]) -> dict[str, str]:
    """Each link, and the first of the links that it is fixed to."""
    above = {each.child: each.parent for each in hinges if each.kind not in MOVES}
    found = {}
    for link in links:
        name = link.name
        while name in above:
            name = above[name]
        found[link.name] = name
    return found


def _called(mockup: Mockup, names: Sequence[str], parts: Sequence[int]) -> PartsLike:
    """Parts by the names of their links where these name nothing else, otherwise by number."""
    try:
        found = mockup.parts.select(list(names)).tolist()
    except FeelerError:
        found = []
    return tuple(names) if found == sorted(parts) else tuple(parts)


def _names(hinges: Sequence[Hinge], file: Path) -> dict[str, str]:
    """Names of joints as mechanisms have them: without `.` and `=`."""
    found = {each.name: each.name.replace(".", "_").replace("=", "_") for each in hinges}
    if len(set(found.values())) != len(found):
        raise LoadError(f"{file}: two joints have the same name once '.' and '=' are written as '_'; rename one")
    return found


def _joint(
    hinge: Hinge,
    poses: Mapping[str, Floats],
    body_of: Mapping[str, str],
    children: Mapping[str, PartsLike],
    roots: set[str],
    names: Mapping[str, str],
) -> Joint:
    frame = poses[hinge.parent] @ hinge.parent_from_joint
    x, y, z = (frame[:3, :3] @ hinge.axis).tolist()
    px, py, pz = frame[:3, 3].tolist()
    above = body_of[hinge.parent]
    limits = (hinge.lower, hinge.upper) if np.isfinite([hinge.lower, hinge.upper]).all() else None
    return Joint(
        names[hinge.name],
        _KINDS[hinge.kind],
        None if above in roots else children[above],
        children[body_of[hinge.child]],
        (x, y, z),
        (px, py, pz),
        limits,
    )


def _joined(robot: Mockup, around: Mockup) -> Mockup:
    """A robot among the parts of another mock-up; the robot's come first."""
    book = PathBook()
    paths = [book.claim_path(path) for path in (*robot.part_paths, *around.part_paths)]
    joined = Mockup(
        np.concatenate([robot.vertices, around.vertices]),
        np.concatenate([robot.faces.astype(np.int64), around.faces.astype(np.int64) + len(robot.vertices)]),
        np.concatenate([robot.part_of_face.astype(np.int64), around.part_of_face.astype(np.int64) + robot.part_count]),
        [*robot.part_names, *around.part_names],
        part_paths=paths,
        part_attributes=[*robot.part_attributes, *around.part_attributes],
        source=robot.source,
    )
    if around.part_colours is not None:
        own = np.full((robot.part_count, 3), np.nan) if robot.part_colours is None else robot.part_colours
        joined.part_colours = np.concatenate([own, around.part_colours])
    return joined
