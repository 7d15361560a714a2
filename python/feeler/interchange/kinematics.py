"""Places the links of a robot for given joint values."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np

from feeler.errors import LoadError, OptionError
from feeler.interchange.urdf_file import MOVES, Floats, Joint, Link, turn


def link_poses(
    links: Sequence[Link], joints: Sequence[Joint], values: Mapping[str, Any] | None, where: str
) -> tuple[dict[str, Floats], list[str]]:
    """root_from_link of each link, (4, 4), metres, and notes.

    A joint without a value has its neutral one: 0, or the limit nearest to 0. Mimicking joints follow. Raises
    `OptionError` for unknown names and invalid values, `LoadError` if the joints do not form a tree.
    """
    by_name = _by_name(joints, where)
    notes: list[str] = []
    given = _checked(values, by_name)
    all_values = {name: _value(by_name, name, given, notes, where) for name in by_name}
    return _walk([link.name for link in links], joints, all_values, where), notes


def zero_poses(links: Sequence[Link], joints: Sequence[Joint], where: str) -> dict[str, Floats]:
    """root_from_link of each link, (4, 4), metres, with all joints at 0; those that mimic with a multiplier of 0 stand
    at their offset. Raises `LoadError` if the joints do not form a tree."""
    by_name = _by_name(joints, where)
    for name in by_name:
        _value(by_name, name, {}, [], where)  # mimics of what is not there are refused
    stand = {each.name: each.mimic.offset for each in joints if each.mimic is not None and not each.mimic.multiplier}
    return _walk([link.name for link in links], joints, {**dict.fromkeys(by_name, 0.0), **stand}, where)


def _by_name(joints: Sequence[Joint], where: str) -> dict[str, Joint]:
    by_name = {joint.name: joint for joint in joints}
    if len(by_name) != len(joints):
        raise LoadError(f"{where}: two joints have the same name; rename one")
    return by_name


def _checked(values: Mapping[str, Any] | None, by_name: Mapping[str, Joint]) -> dict[str, float]:
    if values is None:
        return {}
    if not isinstance(values, Mapping):
        raise OptionError(f"joints is {values!r}: a dict of joint names and values (radians, metres) is needed")
    movable = ", ".join(each.name for each in by_name.values() if each.kind in MOVES and each.mimic is None) or "none"
    given = {}
    for name, value in values.items():
        joint = by_name.get(name)
        if joint is None:
            raise OptionError(f"joints: there is no joint {name!r}; those that move are {movable}")
        if joint.mimic is not None:
            raise OptionError(f"joints: {name!r} follows {joint.mimic.joint!r}; give that one instead")
        if joint.kind not in MOVES:
            raise OptionError(f"joints: {name!r} is {joint.kind}; those that take a value are {movable}")
        try:
            number = float(np.asarray(value, dtype=np.float64).item())
        except (TypeError, ValueError):
            raise OptionError(f"joints: {name!r} is {value!r}: one number is needed (radians, metres)") from None
        if not math.isfinite(number):
            raise OptionError(f"joints: {name!r} is {value!r}: a finite number is needed (radians, metres)")
        given[name] = number
    return given


def _value(by_name: Mapping[str, Joint], name: str, given: Mapping[str, float], notes: list[str], where: str) -> float:
    """The value of one joint, also if it mimics others."""
    factor, offset, seen = 1.0, 0.0, {name}
    joint = by_name[name]
    while joint.mimic is not None:
        leader = by_name.get(joint.mimic.joint)
        if leader is None or leader.name in seen:
            what = "is not there" if leader is None else "mimics it in turn"
            raise LoadError(f"{where}: joint {name!r} mimics {joint.mimic.joint!r}, which {what}")
        offset += factor * joint.mimic.offset
        factor *= joint.mimic.multiplier
        joint = leader
        seen.add(leader.name)
    value = given.get(joint.name)
    if value is None:
        value = min(max(0.0, joint.lower), joint.upper)
        if value != 0.0 and joint.name == name:
            notes.append(f"joint {name!r} is at {value:g}, its limit: 0 is beyond it, and no value was given")
    elif not joint.lower <= value <= joint.upper and joint.name == name:
        notes.append(f"joint {name!r} is at {value:g}, beyond its limits {joint.lower:g} to {joint.upper:g}")
    return factor * value + offset


def _walk(links: list[str], joints: Sequence[Joint], values: Mapping[str, float], where: str) -> dict[str, Floats]:
    known = set(links)
    if len(known) != len(links):
        raise LoadError(f"{where}: two links have the same name; rename one")
    children: dict[str, list[Joint]] = {}
    below = set()
    for joint in joints:
        for end in (joint.parent, joint.child):
            if end not in known:
                raise LoadError(f"{where}: joint {joint.name!r} names the link {end!r}, which is not there")
        if joint.child in below:
            raise LoadError(f"{where}: the link {joint.child!r} is the child of two joints; a robot is a tree")
        below.add(joint.child)
        children.setdefault(joint.parent, []).append(joint)
    waiting = [name for name in links if name not in below]
    poses = {name: np.eye(4) for name in waiting}
    while waiting:
        parent = waiting.pop()
        for joint in children.get(parent, []):
            poses[joint.child] = poses[parent] @ _motion(joint, values[joint.name])
            waiting.append(joint.child)
    lost = [name for name in links if name not in poses]
    if lost:
        raise LoadError(f"{where}: the link {lost[0]!r} hangs in a circle of joints; a robot is a tree")
    return poses


def _motion(joint: Joint, value: float) -> Floats:
    """parent_from_child."""
    motion = np.eye(4)
    if joint.kind == "prismatic":
        motion[:3, 3] = joint.axis * value
    elif joint.kind in MOVES:
        motion[:3, :3] = turn(joint.axis, value)
    moved: Floats = joint.parent_from_joint @ motion
    return moved
