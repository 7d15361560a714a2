"""A shape seen along an axis: its bodies, which are walls at one distance from the axis, and its recesses."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np
import numpy.typing as npt

from feeler.plan.fastener_drive import Recess, Walls, recess_of

Floats = npt.NDArray[np.float64]
Ints = npt.NDArray[np.int64]

WALL_SLOPE = 0.17
"""Sine of the largest angle between a wall and the axis: 10 degrees; flanks of threads and chamfers lean more."""
SAME_RADIUS = 0.012
"""Walls whose distances differ by less than this share of the shape's radius are one body, because of rounded
coordinates and drafts."""
DIRECTION_DEG = 3.0
"""Directions of walls that differ by less are one: those of a hexagon are 60 degrees apart."""
LEAST_DIRECTION = 0.4
"""The least side of a hexagon, as a share of the mean one."""
LEAST_BODY = 0.02
"""Bodies with a smaller share of the walls are details."""
LEAST_GROUP = 0.002
"""Walls at one distance with a smaller share of all walls are ignored."""
LEAST_SYMMETRIC = 0.8
"""The least share of the walls in bodies about the axis: a shape with more other walls is not a fastener."""
SHANK_SLENDER = 0.7
"""The least length of a shank, in diameters."""
CORNERS = {4: (1.3, 1.45), 6: (1.0, 1.2), 12: (1.12, 1.19)}
"""Radius of the corners, relative to that of the sides: a square, a hexagon, and two hexagons turned by 30 degrees. A
cylinder with twelve facets has 1.035; walls of slots are longer."""
PRISMS = {4: "square", 6: "hexagon", 12: "12-point"}
"""Drives with the tool on the outside."""
TOP_SHARE = 0.25
"""How far a head's top may rise above its walls, as a share of their height, because of chamfers and domes; the sleeves
of pipe unions rise more."""
HEAD_HEIGHTS = (0.12, 1.5)
"""Height of a head, relative to its width across flats: 0.4 in the standards; standoffs are longer."""
HEADLESS_RECESS = 0.72
"""The greatest corner radius of a set screw's recess, relative to its radius: walls of tools and bushes are thinner."""
HEADLESS_FLATS = 0.3
"""The height of flats around a rod from which on it is a bar and no set screw, relative to its length."""
MOST_HEAD = 1.35
"""The greatest height of a round head with a recess, relative to its shank's diameter."""
MOST_HEAD_WIDTH = 3.0
"""The greatest diameter of such a head, relative to its shank's."""
SLOT_TO_HEAD = 0.25
"""The greatest width of a slot, relative to its head's diameter: 0.15 in the standards; slots of couplings are
wider."""
THREAD_TO_FLATS = (0.3, 0.88)
"""Thread diameter, relative to the width across flats: 0.5 to 0.67 in the standards, up to 0.8 for flanged heads."""
HEAD_TO_SHANK = (1.4, 2.4)
"""Diameter of a round head, relative to its shank's: 1.5 for socket heads, 2 for pan heads."""
BORE_TO_FLATS = (0.3, 0.68)
"""A nut's bore, relative to its width across flats: at most 0.67 in the standards."""
SHOULDER_SOCKET = 0.57
"""The greatest width of a shoulder screw's hexagon socket, relative to its shoulder: 0.5 in ISO 7379, 0.62 and more of
the thread in cap screws."""
THREAD_TO_SHOULDER = (0.55, 0.95)
"""Radius of its thread, relative to its shoulder: 0.75 to 0.83 in ISO 7379."""
THREAD_LENGTH = 1.0
"""The least length of that thread, in diameters: dog points are shorter."""
INWARD = 0.02
"""Share of a normal towards the axis, from which a surface faces it: flanks of flat threads have 0.05."""
THREAD_DEPTH = 1.4
"""The greatest radius of an internal thread, relative to its least: 1.3 for M1.6."""
SECTOR_DEG, LEAST_TURNS = 20.0, 3
"""In a sector to both sides of a place, the flanks of a thread face one end and the other in turn so often at least:
chamfers of a bore do so once."""
FLAT_SOCKETS = ("square socket", "hexagon socket", "12-point socket")
"""Recesses with a width across flats."""


@dataclass(frozen=True)
class Body:
    """Walls at one distance from the axis."""

    radius: float
    is_inside: bool
    directions: int
    sides: int
    """4, 6 or 12 for a square, a hexagon, or two hexagons turned by 30 degrees; 0: round."""
    low: float
    high: float
    share: float
    """Share of the area of all walls."""

    @property
    def height(self) -> float:
        """Along the axis."""
        return self.high - self.low

    def flipped(self) -> Body:
        """Seen from the other end."""
        return replace(self, low=-self.high, high=-self.low)


@dataclass(frozen=True, eq=False)
class View:
    """A shape along one axis."""

    bodies: list[Body]
    z: Floats
    """Of the corners of the triangles, along the axis, from the middle."""
    r: Floats
    across: Floats
    """(n, 2): the same corners across the axis."""
    recesses: tuple[Recess | None, Recess | None]
    """At the upper and at the lower end."""
    walls: Walls
    """All of them."""
    threads: list[Body]
    """The internal thread, if its flanks are drawn, as a helix or as rings, with its least radius."""

    @property
    def low(self) -> float:
        """The height of the lower end."""
        return float(self.z.min())

    @property
    def high(self) -> float:
        """The height of the upper end."""
        return float(self.z.max())

    def flipped(self) -> View:
        """Seen from the other end."""
        bodies = [b.flipped() for b in self.bodies]
        threads = [b.flipped() for b in self.threads]
        return View(bodies, -self.z, self.r, self.across, self.recesses[::-1], self.walls.flipped(), threads)

    def outer_above(self, height: float) -> Body | None:
        """The outer walls above a height as one body; None if they are not at one distance around the axis.

        Bodies of the view join walls at one distance wherever they are along the axis.
        """
        walls = self.walls
        chosen = np.flatnonzero((walls.distance > 0.0) & (walls.corners[:, :, 2].min(axis=1) >= height))
        distance = walls.distance[chosen]
        if not len(chosen) or np.ptp(distance) > SAME_RADIUS * float(self.r.max()):
            return None
        corners, across, area = walls.corners[chosen], walls.across[chosen], walls.area[chosen]
        angle = np.degrees(np.arctan2(across[:, 1], across[:, 0]))
        farthest = np.hypot(corners[..., 0], corners[..., 1]).max(axis=1)
        return _body(distance, angle, area, corners[..., 2], farthest, float(walls.area.sum()))

    def outer(self) -> list[Body]:
        """The bodies whose walls face away from the axis."""
        return [b for b in self.bodies if not b.is_inside]

    def inner(self) -> list[Body]:
        """The bodies whose walls face the axis."""
        return [b for b in self.bodies if b.is_inside]

    def is_hollow(self) -> bool:
        """Whether a bore goes right through."""
        inner, full = self.inner(), self.high - self.low
        is_open = [
            any(b.low < self.low + 0.1 * full for b in inner),
            any(b.high > self.high - 0.1 * full for b in inner),
        ]
        return all(is_open) and sum(b.height for b in inner) > 0.7 * full


@dataclass(frozen=True)
class Found:
    """The values for `Looks`, along the view's axis."""

    kind: str
    size: float
    flats: float
    length: float
    head: float
    ring: float
    because: str
    drive: str = ""
    is_two_sided: bool = False
    is_strong: bool = True
    top: float | None = None
    """None: the upper end."""
    is_known_by_name: bool = False
    width: float = np.nan
    """Of a drive without flats, as `Fastener.width`."""


def view_along(corners: Floats, area: Floats, normals: Floats, centre: Floats, axis: Floats) -> View | None:
    """The shape along an axis; None if it is not symmetric about it."""
    frame = frame_of(axis)
    points, turned = (corners - centre) @ frame.T, normals @ frame.T
    r = np.hypot(points[..., 0], points[..., 1])
    z = points[..., 2]
    rest = points.reshape(-1, 3)
    wall = np.abs(turned[:, 2]) < WALL_SLOPE
    total = float(area[wall].sum())
    if not total > 0.02 * float(area.sum()):
        return None
    across = turned[wall, :2] / np.linalg.norm(turned[wall, :2], axis=1)[:, None]
    distance = np.einsum("ij,ij->i", across, points[wall].mean(axis=1)[:, :2])
    walls = Walls(points[wall], across, distance, area[wall])
    recesses = (
        recess_of(walls, float(z.min()), float(z.max())),
        recess_of(walls.flipped(), -float(z.max()), -float(z.min())),
    )
    angle = np.degrees(np.arctan2(across[:, 1], across[:, 0]))
    farthest = r[wall].max(axis=1)
    gap = SAME_RADIUS * float(r.max())
    order = np.argsort(distance)
    groups = np.split(order, np.flatnonzero(np.diff(distance[order]) > gap) + 1)
    weights, heights = area[wall], z[wall]
    is_cut = np.zeros(len(weights), dtype=bool)
    for recess in recesses:
        if recess is not None:
            is_cut[recess.walls] = True
    whole = float(weights[~is_cut].sum())
    bodies, share = [], 0.0
    for group in groups:
        if weights[group].sum() < LEAST_GROUP * total:
            continue
        body = _body(distance[group], angle[group], weights[group], heights[group], farthest[group], whole or total)
        if body is not None:
            bodies.append(body)
            share += float(weights[group][~is_cut[group]].sum()) / (whole or total)
    if share < LEAST_SYMMETRIC and not is_winged(rest[:, :2], r.reshape(-1)):
        return None
    kept = [body for body in bodies if body.share >= LEAST_BODY]
    return View(kept, rest[:, 2], r.reshape(-1), rest[:, :2], recesses, walls, _threads(points, area, turned))


def _threads(points: Floats, area: Floats, normals: Floats) -> list[Body]:
    """The internal thread of a shape along z, if its flanks are drawn: slopes that face the axis, and one end and the
    other in turn."""
    middle = points[..., :2].mean(axis=1)
    out = np.maximum(np.hypot(middle[:, 0], middle[:, 1]), 1e-300)
    is_flank = (normals[:, :2] * middle).sum(axis=1) < -INWARD * out
    is_flank &= np.abs(normals[:, 2]) >= WALL_SLOPE
    if not is_flank.any():
        return []
    r = np.hypot(points[..., 0], points[..., 1])
    least = float(r[is_flank].min())
    is_flank &= r.max(axis=1) <= THREAD_DEPTH * least  # no chamfer, and no cone of a drill
    weight, z = area[is_flank], points[is_flank][..., 2]
    if not len(weight):
        return []
    turn = np.arctan2(middle[is_flank, 1], middle[is_flank, 0])
    near = np.cos(turn - turn[np.argmax(weight)]) > np.cos(np.radians(SECTOR_DEG))
    facing = np.sign(normals[is_flank, 2][near][np.argsort(z[near].mean(axis=1))])
    if (np.diff(facing) != 0).sum() < LEAST_TURNS or abs(weight @ np.exp(1j * turn)) > 0.1 * weight.sum():
        return []
    count = len(np.unique(np.round(np.degrees(turn) / DIRECTION_DEG)))
    return [Body(least, True, count, 0, float(z.min()), float(z.max()), 0.0)]


def frame_of(axis: Floats) -> Floats:
    """(3, 3): two rows across an axis, and one along it."""
    x = np.cross(axis, np.eye(3)[int(np.argmin(np.abs(axis)))])
    x /= np.linalg.norm(x)
    return np.stack([x, np.cross(axis, x), axis])


def _body(
    distance: Floats, angle: Floats, weight: Floats, heights: Floats, farthest: Floats, total: float
) -> Body | None:
    """Walls at about one distance, if they surround the axis evenly."""
    sides = np.round(angle / DIRECTION_DEG).astype(np.int64)
    # Directions of a hexagon may fall on both sides of a step's border: neighbours count as one.
    order = np.argsort(angle)
    new = np.flatnonzero(np.diff(angle[order]) > DIRECTION_DEG) + 1
    runs = np.split(order, new)
    if len(runs) > 1 and angle[runs[0][0]] + 360.0 - angle[runs[-1][-1]] <= DIRECTION_DEG:
        runs[0] = np.concatenate([runs.pop(), runs[0]])
    areas = np.array([weight[run].sum() for run in runs])
    turn = np.radians(angle)
    lean = abs(complex((weight * np.cos(turn)).sum(), (weight * np.sin(turn)).sum())) / weight.sum()
    if lean > 0.1:
        return None
    # A fine cylinder is one run all around.
    count = len(np.unique(sides)) if len(runs) < 3 else len(runs)
    middle = float(np.average(distance, weights=weight))
    out = float(farthest.max()) / max(abs(middle), 1e-300)
    prism = 0
    if len(runs) in CORNERS and areas.min() > LEAST_DIRECTION * areas.mean():
        low, high = CORNERS[len(runs)]
        phase = complex((weight * np.cos(len(runs) * turn)).sum(), (weight * np.sin(len(runs) * turn)).sum())
        prism = len(runs) if abs(phase) > 0.97 * weight.sum() and low <= out <= high else 0
    if count < 5 and prism != 4:
        return None
    share = float(weight.sum()) / total
    return Body(abs(middle), middle < 0, count, prism, float(heights.min()), float(heights.max()), share)


def wing_tip(across: Floats, r: Floats) -> Floats:
    """The direction (2,) of the farthest corners to both sides: of the middle of both wings, not of a corner of one."""
    far = across[r > 0.85 * float(r.max())]
    turn = 0.5 * np.angle(np.sum((far[:, 0] + 1j * far[:, 1]) ** 2))
    return np.array([np.cos(turn), np.sin(turn)])


def wings_of(across: Floats, r: Floats) -> tuple[float, float] | None:
    """Radius of the hub, and of its two wings; None without wings."""
    reach, tip = float(r.max()), wing_tip(across, r)
    along, beside = np.abs(across @ tip), np.abs(across @ np.array([-tip[1], tip[0]]))
    thick = float(beside[r > 0.85 * reach].max())
    sides = across @ tip
    hub = float(beside.max())
    if not (hub < 0.62 * reach and thick < 0.3 * hub and float(sides.min()) < -0.95 * reach):
        return None
    wing = along > 1.1 * hub
    return (hub, reach) if float(beside[wing].max()) < 0.6 * hub else None


def crossbar_of(across: Floats, r: Floats) -> tuple[float, float, float] | None:
    """Radius of a head, and half the length and thickness of the bar across it; None without a bar."""
    reach, tip = float(r.max()), wing_tip(across, r)
    along, beside = across @ tip, np.abs(across @ np.array([-tip[1], tip[0]]))
    hub, thick = float(beside.max()), float(beside[r > 0.85 * reach].max())
    is_both = float(along.min()) < -0.95 * reach and float(along.max()) > 0.95 * reach
    if not (is_both and hub < 0.62 * reach and 0.3 * hub <= thick <= 0.95 * hub):
        return None
    beyond = beside[np.abs(along) > 1.05 * hub]
    return (hub, reach, thick) if float(beyond.max()) < 1.05 * thick else None


def is_winged(across: Floats, r: Floats) -> bool:
    """Whether a shape has wings or a bar across its axis."""
    return wings_of(across, r) is not None or crossbar_of(across, r) is not None


def shank_of(view: View, under: float, wide: float) -> tuple[float, float] | None:
    """Radius and length of the shape below a head that ends at `under` and has walls at `wide` from the axis."""
    length = under - view.low
    below = view.r[view.z < under - 0.35 * length]
    if not len(below) or length <= 0:
        return None
    radius = float(below.max())
    if length < SHANK_SLENDER * 2.0 * radius or not radius < wide:
        return None
    return radius, length


def bearing_of(view: View, radius: float, wide: float) -> float:
    """The height at which a head of radius `wide` bears on the joint: the end of all that is wider than the shank."""
    head = view.z[view.r > radius + 0.35 * (wide - radius)]
    return float(head.min())


def thread_of(view: View, radius: float, recess: Recess) -> float:
    """The radius of the thread below a shoulder of `radius`; `radius` if there is none.

    A hexagon socket that is narrow for the shank shows a shoulder; else a thinner end is the thread's core.
    """
    if recess.drive != "hexagon socket" or recess.width > SHOULDER_SOCKET * 2.0 * radius:
        return radius
    low, high = THREAD_TO_SHOULDER[0] * radius, THREAD_TO_SHOULDER[1] * radius
    found = [b for b in view.outer() if low <= b.radius <= high and b.height >= THREAD_LENGTH * 2.0 * b.radius]
    thread = min(found, key=lambda b: b.low, default=None)
    if thread is None or thread.low > view.low + 0.2 * (view.high - view.low):
        return radius
    return float(view.r[view.z < 0.5 * (thread.low + thread.high)].max())


def article(thing: str) -> str:
    """A thing with its article."""
    return f"a {thing}"


def mm(metres: float) -> str:
    """A length as text, in millimetres."""
    return f"{1e3 * metres:.3g} mm"
