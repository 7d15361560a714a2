"""Motion of animated nodes: worlds at a time, and between two times a chain of slides and screws.

Between two keys of LINEAR and STEP channels a node slides at a constant rate and turns about a fixed axis through its
origin at a constant rate, so nodes above each other are a `Chain`. Cubic splines are cut until they leave such a motion
by less than a given length.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import NamedTuple

import numpy as np
import numpy.typing as npt

from feeler._core import Screw, Slide
from feeler.errors import LoadError, MechanismError
from feeler.io.gltf_animation import Node, Sampler
from feeler.poses import nearest_rigid

Floats = npt.NDArray[np.float64]

SAME = 1e-9
"""Poses that differ by more are not the same: metres, and shares of one."""
_STILL = 1e-12  # radians or metres: rounding
_LEAST_QUATERNION = 1e-9
_UNEVEN = 1e-6  # a share: the scales above a node that turns differ by less


class Piece(NamedTuple):
    """A motion between two times: the joints of a chain in the world, and how far points leave it at most, metres."""

    joints: tuple[Screw | Slide, ...]
    error: float


class Step(NamedTuple):
    """A motion of one body against another between two times, in the frame of the other at rest. Without joints the one
    jumps to the pose."""

    begin: float
    end: float
    pose: Floats
    joints: tuple[Screw | Slide, ...]
    error: float
    """How far points leave it at most, metres."""


class Moves:
    """The nodes of an animation that move. base: mockup_from_file, `(4, 4)`."""

    def __init__(self, nodes: dict[int, Node], base: Floats, where: str) -> None:
        self.nodes, self.base = nodes, base
        self._rest = self.worlds(None)
        self._undone = {index: np.linalg.inv(world) for index, world in self._rest.items()}
        for node in nodes.values():
            above = self._frame(node, self._rest)[:3, :3]
            sizes = np.linalg.svd(above, compute_uv=False)
            if node.turns is not None and sizes[0] - sizes[-1] > _UNEVEN * sizes[0]:
                raise LoadError(
                    f"{where}: {node.name!r} turns below a scale that differs by axis, which shears it: export the "
                    "parts with their scale applied"
                )
            if not (np.isfinite(sizes).all() and np.abs(node.size).min() > 0.0):
                raise LoadError(f"{where}: {node.name!r} moves and has a scale of zero: export it with another one")

    def above(self, index: int) -> list[int]:
        """The nodes that move one, itself included, the topmost first."""
        found = []
        while index >= 0:
            found.append(index)
            index = self.nodes[index].above
        return found[::-1]

    def times(self, chosen: Sequence[int]) -> Floats:
        """The times of all keys of some nodes, seconds, ascending."""
        tracks = [track for n in chosen for track in (self.nodes[n].moves, self.nodes[n].turns) if track is not None]
        return np.unique(np.concatenate([track.times for track in tracks])) if tracks else np.empty(0)

    def worlds(
        self, time: float | None, needed: Sequence[int] | None = None, still: Sequence[int] = ()
    ) -> dict[int, Floats]:
        """mockup_from_node, `(4, 4)`, at a time; at rest for None. needed: nodes from the topmost ones down, None: all;
        still: those that are held at rest."""
        found: dict[int, Floats] = {}
        for index in self.nodes if needed is None else needed:
            node = self.nodes[index]
            found[index] = self._frame(node, found) @ _local(node, None if index in still else time)
        return found

    def poses(self, time: float, needed: Sequence[int] | None = None, still: Sequence[int] = ()) -> dict[int, Floats]:
        """The rigid motion `(4, 4)` of each node from where it is at rest, in the world; see `worlds`."""
        worlds = self.worlds(time, needed, still)
        return {n: np.asarray(nearest_rigid(worlds[n] @ self._undone[n]), dtype=np.float64) for n in worlds}

    def rest_origin(self, index: int) -> Floats:
        """The origin of a node at rest, world."""
        return self._rest[index][:3, 3]

    def piece(self, way: Sequence[int], still: Sequence[int], begin: float, end: float, reach: float) -> Piece:
        """The motion of the last of a way of nodes between two times without a key between them.

        way: from the topmost node down. still: its first nodes, held at rest. reach: how far points that hang on the
        last node are from its origin, metres.
        """
        worlds = self.worlds(begin, way, still)
        chain = [index for index in way if index not in still]
        joints: list[Screw | Slide] = []
        slides, errors = [], []
        for index in chain:
            node = self.nodes[index]
            frame = self._frame(node, worlds)
            linear = frame[:3, :3]
            size = float(np.linalg.norm(linear, 2))
            move = at(node.moves, begin, node.move)
            slide = linear @ (_before(node.moves, end, move) - move)
            if float(np.linalg.norm(slide)) > _STILL:
                joints.append(Slide(slide))
            turn = at(node.turns, begin, node.turn)
            vector, angle = _turn_between(turn, _before(node.turns, end, turn))
            if angle > _STILL:
                axis = linear @ vector
                sign = math.copysign(1.0, float(np.linalg.det(linear)))
                joints.append(Screw(sign * axis, frame[:3, :3] @ move + frame[:3, 3], angle))
            off_move, off_turn = _off_line(node.moves, begin, end), _off_turn(node.turns, begin, end, angle)
            slides.append(float(np.linalg.norm(slide)) + size * off_move)
            errors.append((size * off_move, off_turn))
        far, total = reach, 0.0
        for place in range(len(chain) - 1, -1, -1):
            total += errors[place][0] + errors[place][1] * far
            if place:
                apart = worlds[chain[place]][:3, 3] - worlds[chain[place - 1]][:3, 3]
                far += float(np.linalg.norm(apart)) + slides[place]
        return Piece(tuple(joints), total)

    def _frame(self, node: Node, worlds: dict[int, Floats]) -> Floats:
        """mockup_from_parent of a node."""
        return (self.base if node.above < 0 else worlds[node.above]) @ node.above_from_parent


def _local(node: Node, time: float | None) -> Floats:
    move, turn = (
        (node.move, node.turn)
        if time is None
        else (
            at(node.moves, time, node.move),
            at(node.turns, time, node.turn),
        )
    )
    local = np.eye(4)
    local[:3, :3] = turn_of(turn) * node.size
    local[:3, 3] = move
    return local


def _turn_between(one: Floats, other: Floats) -> tuple[Floats, float]:
    """The axis, unit, and the angle from 0 to a whole turn of the even turn between two unit quaternions."""
    vector = one[3] * other[:3] - other[3] * one[:3] - np.cross(other[:3], one[:3])
    length = float(np.linalg.norm(vector))
    if length == 0.0:
        return np.array([0.0, 0.0, 1.0]), 0.0
    return vector / length, 2.0 * math.atan2(length, float(one @ other))


def turn_of(q: Floats) -> Floats:
    """The rotation `(3, 3)` of a unit quaternion (x, y, z, w)."""
    x, y, z, w = q / np.linalg.norm(q)
    return np.array(
        [
            [1 - 2 * (y * y + z * z), 2 * (x * y - z * w), 2 * (x * z + y * w)],
            [2 * (x * y + z * w), 1 - 2 * (x * x + z * z), 2 * (y * z - x * w)],
            [2 * (x * z - y * w), 2 * (y * z + x * w), 1 - 2 * (x * x + y * y)],
        ]
    )


def at(track: Sampler | None, time: float, rest: Floats) -> Floats:
    """The value of a track at a time, as glTF says: held before the first key and after the last one."""
    if track is None:
        return rest
    k = int(np.searchsorted(track.times, time, side="right")) - 1
    if k < 0 or k + 1 >= len(track.times) or track.kind == "STEP":
        return _unit(track.values[min(max(k, 0), len(track.times) - 1)])
    span = float(track.times[k + 1] - track.times[k])
    share = (time - float(track.times[k])) / span
    if track.kind == "CUBICSPLINE":
        return _unit(_hermite(track, k, share))
    one, other = track.values[k], track.values[k + 1]
    if track.values.shape[1] == 3:
        return np.asarray(one + share * (other - one), dtype=np.float64)
    angle = math.atan2(float(np.linalg.norm(other - (one @ other) * one)), float(one @ other))
    if angle < 1e-9:
        return _unit(one + share * (other - one))
    mixed = (math.sin((1.0 - share) * angle) * one + math.sin(share * angle) * other) / math.sin(angle)
    return _unit(mixed)


def _before(track: Sampler | None, time: float, held: Floats) -> Floats:
    """The value just before a time; held: that at the key before."""
    return held if track is None or track.kind == "STEP" else at(track, time, held)


def _unit(value: Floats) -> Floats:
    if len(value) == 3:
        return np.asarray(value, dtype=np.float64)
    length = float(np.linalg.norm(value))
    if length < _LEAST_QUATERNION:
        raise MechanismError(
            "a spline of rotations passes through the quaternion 0, which turns nothing: add keys to the animation"
        )
    return np.asarray(value / length, dtype=np.float64)


def _hermite(track: Sampler, k: int, share: float) -> Floats:
    span = float(track.times[k + 1] - track.times[k])
    s2, s3 = share * share, share**3
    return np.asarray(
        (2 * s3 - 3 * s2 + 1) * track.values[k]
        + span * (s3 - 2 * s2 + share) * track.out[k]
        + (3 * s2 - 2 * s3) * track.values[k + 1]
        + span * (s3 - s2) * track.into[k + 1],
        dtype=np.float64,
    )


def _spline(track: Sampler | None, begin: float, end: float) -> tuple[float, float, float] | None:
    """Of the spline between two times: its largest speed, its largest second derivative, and its least length less
    half the way; None where there is none."""
    if track is None or track.kind != "CUBICSPLINE":
        return None
    k = int(np.searchsorted(track.times, begin, side="right")) - 1
    if k < 0 or k + 1 >= len(track.times):
        return None
    span = float(track.times[k + 1] - track.times[k])
    p, q = track.values[k], track.values[k + 1]
    m, n = span * track.out[k], span * track.into[k + 1]
    # The second derivative is linear, so its largest length is at an end; the first changes by at most its integral.
    ends = [(each - float(track.times[k])) / span for each in (begin, end)]
    second = max(
        float(np.linalg.norm((12 * s - 6) * (p - q) + (6 * s - 4) * m + (6 * s - 2) * n)) / span**2 for s in ends
    )
    s = 0.5 * (ends[0] + ends[1])
    first = float(np.linalg.norm((6 * s * s - 6 * s) * (p - q) + (3 * s * s - 4 * s + 1) * m + (3 * s * s - 2 * s) * n))
    half = 0.5 * (end - begin)
    fastest = first / span + second * half
    return fastest, second, float(np.linalg.norm(_hermite(track, k, s))) - fastest * half


def _off_line(track: Sampler | None, begin: float, end: float) -> float:
    """How far a track of positions leaves the straight motion between two times, at most."""
    found = _spline(track, begin, end)
    return 0.0 if found is None else found[1] * (end - begin) ** 2 / 8.0


def _off_turn(track: Sampler | None, begin: float, end: float, angle: float) -> float:
    """How far a track of rotations leaves the even turn by `angle` between two times, radians, at most.

    The unit quaternion is `q / |q|`, whose second derivative is at most `2 D2 / m + 5 D1^2 / m^2` with the bounds of
    `_spline`; that of the even turn is `(angle / 2)^2` over the squared time. Two motions with the same ends are apart
    by at most an eighth of the sum of these times the squared time.
    """
    found = _spline(track, begin, end)
    if found is None:
        return 0.0
    fastest, second, least = found
    if least <= 0.0:
        return math.pi
    time = end - begin
    bent = (2.0 * second / least + 5.0 * (fastest / least) ** 2) * time**2 + (0.5 * angle) ** 2
    return min(math.pi, 4.0 * math.asin(min(1.0, bent / 16.0)))


def seen_from(joint: Screw | Slide, back: Floats) -> Screw | Slide:
    """A joint as seen from another frame."""
    if isinstance(joint, Slide):
        return Slide(back[:3, :3] @ np.array(joint.way))
    point = back[:3, :3] @ np.array(joint.point) + back[:3, 3]
    return Screw(back[:3, :3] @ np.array(joint.axis), point, joint.angle, joint.pitch)
