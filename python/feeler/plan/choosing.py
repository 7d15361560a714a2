"""Which tool of a catalogue reaches a fastener: those that fit by drive and size, one after the other."""

from __future__ import annotations

import math
from collections import Counter
from collections.abc import Hashable, Iterator
from dataclasses import dataclass, field, replace
from itertools import groupby

import numpy as np
import numpy.typing as npt

from feeler.mockup import Mockup, Tool
from feeler.part_meshes import PartMeshes
from feeler.plan.blocked import Blocker
from feeler.plan.catalogue import Catalogue, core_of, name_of, shaped, tool_of
from feeler.plan.fasteners import Fastener, Fasteners
from feeler.plan.reach import Reach, TriedTool, worst_first
from feeler.plan.reach_question import ReachQuestion, SeatSearch, shifted
from feeler.plan.swings import turned
from feeler.plan.tool_seat import SeatedTool, ignoring, seated_tool
from feeler.plan.tool_spec import ToolSpec, depths_of
from feeler.scene import Scene

Floats = npt.NDArray[np.float64]
Pieces = tuple[ToolSpec, ...]

SIDES = {"hexagon": 6, "square": 4, "12-point": 12, "torx": 6}
"""Flats of the drives on the outside."""
UPRIGHT = 0.1
"""Faces whose normals are this near to across the axis are flats."""
LIFTED_M = 2e-3
"""More than the lower end of a tool is lifted above a head before it goes sideways, metres."""
OVER_M = 2e-4
"""A fastener that stands out of its head by less is flat, metres."""


@dataclass(frozen=True)
class Chosen:
    """What is asked of all fasteners: the tools, and how they are sought."""

    catalogue: Catalogue
    search: SeatSearch
    swing_deg: float | None
    """The swing that all tools need; None: what each says."""
    hand: tuple[Tool, Floats] | None
    """A hand, and grip_from_hand (4, 4)."""
    made: dict[Pieces, SeatedTool] = field(default_factory=dict, compare=False)
    """Tools that were seated before, with their hands."""

    def seated(self, pieces: Pieces) -> SeatedTool:
        """A tool in the frame of its seat, with the hand at its grip if it is complete."""
        if pieces not in self.made:
            self.made[pieces] = self._seated(pieces)
        return self.made[pieces]

    def _seated(self, pieces: Pieces) -> SeatedTool:
        shape, kind = shaped(pieces), pieces[0].kind
        tool, hand = tool_of(pieces), None
        has_grip = shape.solids[-1][0] == "grip"
        if self.hand is not None and has_grip:
            hand = (self.hand[0], shape.grip @ self.hand[1])
        seated = seated_tool(tool, hand)
        kept = seated.kept if hand is not None or not has_grip else _only_grip(tool)
        plug = None if shape.plug is None else Tool(*shape.plug, name="plug")
        if kind == "open":
            return replace(seated, kept=kept, plug=plug, outward=np.array([1.0, 0.0, 0.0]))
        return replace(seated, kept=kept, is_around=True, plug=plug, core=core_of(pieces))

    def search_of(self, pieces: Pieces) -> SeatSearch:
        """The search for a tool: a chain swings as its handle does."""
        needed = pieces[-1].swing_deg if self.swing_deg is None else self.swing_deg
        return replace(self.search, needed=needed, is_strict=True)


def _only_grip(tool: Tool) -> Tool:
    """Where a hand would be."""
    is_grip = np.asarray(tool.part_of_face) == tool.part_count - 1
    return Tool(tool.vertices, np.asarray(tool.faces)[is_grip], name="grip")


@dataclass(frozen=True)
class HeadShape:
    """What a tool must know of a head beside its size."""

    to_flats: float
    """Degrees about z from its frame to its flats: there a flat faces y. 0 for drives without."""
    over: float
    """How far the fastener stands out of its own head, such as the plug of a sensor, metres."""
    radius: float
    """Its radius there, metres."""


def head_shapes(mockup: Mockup, fasteners: Fasteners) -> list[HeadShape]:
    """Those of fasteners, by their meshes."""
    meshes = PartMeshes(mockup)
    return [_head_shape(meshes, row) for row in fasteners]


def _head_shape(meshes: PartMeshes, row: Fastener) -> HeadShape:
    corners = (meshes.corners(row.part) - row.frame[:3, 3]) @ row.frame[:3, :3]
    points = corners.reshape(-1, 3)
    above = points[points[:, 2] > OVER_M]
    over = float(above[:, 2].max(initial=0.0))
    radius = float(np.hypot(above[:, 0], above[:, 1]).max(initial=0.0))
    return HeadShape(_turn_to_flats(corners, row) if row.drive in SIDES else 0.0, over, radius)


def _turn_to_flats(corners: Floats, row: Fastener) -> float:
    normals = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
    area = np.linalg.norm(normals, axis=1)
    area[area == 0.0] = np.inf
    normals = normals / area[:, None]
    distance = np.abs(np.einsum("ij,ij->i", normals, corners[:, 0]))
    half = 0.5 * row.across_flats if row.across_flats > 0.0 else float(distance.max())
    is_flat = (np.abs(normals[:, 2]) < UPRIGHT) & (np.abs(distance - half) < 0.05 * half) & np.isfinite(area)
    if not is_flat.any():
        return 0.0
    count = SIDES[row.drive]
    around = np.arctan2(normals[is_flat, 1], normals[is_flat, 0])
    phase = float(np.angle((area[is_flat] * np.exp(1j * count * around)).sum())) / count
    return (math.degrees(phase) - 90.0) % (360.0 / count)


def room_of(
    catalogue: Catalogue, fastener: Fastener, approach: float, hand: tuple[Tool, Floats] | None = None
) -> Floats:
    """`(2, 3)`: the corners of a world box of all that `access` can look at for a fastener: each tool that fits, at any
    angle, and on any way in of `approach` metres. Parts beyond it have no influence on the answer.

    `hand`: with grip_from_hand. Only the fastener's own place if no tool fits.
    """
    chosen = Chosen(catalogue, SeatSearch(60.0, 4, approach, 0.0), None, hand)
    head = fastener.length if fastener.kind == "nut" else fastener.head_height
    radius, low, high = 0.0, 0.0, 0.0
    for pieces in catalogue.fitting(fastener.drive, fastener.across_flats, fastener.size, fastener.width):
        tool = chosen.seated(pieces).tool
        deepest = max(depths_of(pieces[0], head))
        radius = max(radius, float(np.hypot(tool.vertices[:, 0], tool.vertices[:, 1]).max()))
        low, high = min(low, tool.bounds[0, 2] - deepest), max(high, tool.bounds[1, 2] + LIFTED_M)
    side, top = radius + approach, high + approach
    corners = np.array([[x, y, z] for x in (-side, side) for y in (-side, side) for z in (low, top)])
    world = corners @ fastener.frame[:3, :3].T + fastener.frame[:3, 3]
    return np.stack([world.min(axis=0), world.max(axis=0)])


def choose(
    scene: Scene, chosen: Chosen, target: int, fastener: Fastener, frame: Floats, shape: HeadShape, turns: float
) -> Reach:
    """The first tool that reaches a fastener; if none does, the one that came nearest."""
    return _Tried(scene, chosen, target, fastener, frame, shape, turns).first()


def quicker(
    scene: Scene, chosen: Chosen, fastener: Fastener, shape: HeadShape, turns: float, enough: int
) -> list[Reach]:
    """The tools that reach a fastener and may be the quickest, alone or because they are in hand.

    These are the first that reaches, with those of the same length, and of longer ones and other kinds those that need
    fewer strokes than all before, up to one that needs `enough` or fewer. If none reaches: what `choose` says, alone.
    The last row has all that were tried.
    """
    tried = _Tried(scene, chosen, 0, fastener, fastener.frame, shape, turns)
    found: list[Reach] = []
    fewest = math.inf
    for _, group in groupby(tried.rows(), key=lambda each: _length(each[0])):
        rows = [row for _, row in group if row.is_reachable and (row.strokes or 0) < fewest]
        found += rows
        fewest = min([fewest, *(row.strokes or 0 for row in rows)])
        if fewest <= enough:
            break
    if found:
        found[-1] = replace(found[-1], tried=tuple(tried.tried))
    return found or [tried.nearest()]


def _length(pieces: Pieces) -> Hashable:
    """Equal for tools of one length: chains with equal extensions, and tools of one kind."""
    if len(pieces) == 1:
        return pieces[0].kind
    return tuple(each.size for each in pieces[1:-1])


@dataclass(eq=False)  # it holds an array
class _Tried:
    """The tools that fit one fastener, one after the other.

    A chain contains its first pieces, so where these collide at every angle, it does too.
    """

    scene: Scene
    chosen: Chosen
    target: int
    fastener: Fastener
    frame: Floats
    shape: HeadShape
    turns: float
    tried: list[TriedTool] = field(default_factory=list)
    """Those that do not reach, so far."""
    best: Reach | None = None
    """Of these the one that came nearest."""

    def __post_init__(self) -> None:
        row = self.fastener
        self.fitting = self.chosen.catalogue.fitting(row.drive, row.across_flats, row.size, row.width)

    def first(self) -> Reach:
        """The first that reaches, or the nearest."""
        return next((row for _, row in self.rows() if row.is_reachable), None) or self.nearest()

    def rows(self) -> Iterator[tuple[Pieces, Reach]]:
        """The answers of those that are not blocked at every angle."""
        row, shape = self.fastener, self.shape
        head = row.length if row.kind == "nut" else row.head_height
        aligned = 360.0 / SIDES[row.drive] if row.drive in SIDES else None
        stems: dict[Pieces, bool] = {}
        for pieces in self.fitting:
            for depth in depths_of(pieces[0], head):
                seat = shifted(self.frame @ turned(shape.to_flats), -depth * self.frame[:3, 2])
                if _is_blocked(self.scene, pieces, depth, shape, seat, row.part, stems, self.tried):
                    continue
                seated = replace(self.chosen.seated(pieces), depth=max(0.0, depth), aligned_deg=aligned)
                question = ReachQuestion(self.scene, seated, self.chosen.search_of(pieces))
                found = question.reach(self.target, seat, row.part)
                found = replace(found, angle_deg=(found.angle_deg + shape.to_flats) % 360.0)
                if found.is_reachable:
                    yield pieces, _stroked(found, pieces[-1].step_deg, self.turns, tuple(self.tried))
                    break
                self.tried.append(TriedTool(name_of(pieces), found.because, found.blockers))
                best = self.best
                if best is None or (found.drawn, found.swing_deg) > (best.drawn, best.swing_deg):
                    self.best = found

    def nearest(self) -> Reach:
        """Once none has reached: the answer of the one that came nearest, without a tool."""
        target, row, frame, tried, best = self.target, self.fastener, self.frame, self.tried, self.best
        if not self.fitting:
            return _without_tool(target, row, frame, _no_fit(self.chosen.catalogue, row))
        counts: Counter[tuple[int, str]] = Counter()
        for each in tried:
            counts.update({(block.part, block.path): block.count for block in each.blockers})
        blockers = tuple(Blocker(part, path, count) for (part, path), count in worst_first(counts))
        many = len(self.fitting)
        of = f"none of the {many} tools that fit reaches it" if many > 1 else "the tool that fits does not reach it"
        if best is None:
            because = f"{of}: {tried[0].tool}: {tried[0].because}"
            return replace(_without_tool(target, row, frame, because), blockers=blockers, tried=tuple(tried))
        because = f"{of}; nearest came {best.tool}: {best.because}"
        return replace(best, tool=None, nearest=best.tool, because=because, blockers=blockers, tried=tuple(tried))


def _is_blocked(
    scene: Scene,
    pieces: Pieces,
    depth: float,
    shape: HeadShape,
    seat: Floats,
    part: int,
    stems: dict[Pieces, bool],
    tried: list[TriedTool],
) -> bool:
    """Whether a tool, or the first pieces of a chain, collides at every angle; each is asked once."""
    for count in range(1, len(pieces) + 1):
        stem = pieces[:count]
        if stem not in stems:
            because, blockers = _stem(scene, stem, depth, shape, seat, part)
            stems[stem] = bool(because)
            if because:
                tried.append(TriedTool(name_of(stem), because, blockers))
        if stems[stem]:
            return True
    return False


def _stem(
    scene: Scene, stem: Pieces, depth: float, shape: HeadShape, seat: Floats, part: int
) -> tuple[str, tuple[Blocker, ...]]:
    """Why pieces collide at every angle, and with what; an empty text if they need not."""
    first = stem[0]
    room = first.length("depth") - depth if first.kind == "socket" else math.inf
    if first.kind in ("socket", "ring") and shape.over > 0.0 and (shape.over > room or shape.radius > 0.5 * first.size):
        return f"the fastener itself stands {1e3 * shape.over:.3g} mm out of its head", ()
    core = core_of(stem)
    if core is None:
        return "", ()
    met = scene.collide(core, seat, ignore=ignoring(core, scene.mockup, part)).parts
    paths = scene.mockup.part_paths
    found = tuple(Blocker(i, paths[i], 1) for i in np.unique(met).tolist())
    return ("it collides at every angle" if found else ""), found


def _stroked(row: Reach, step: float, turns: float, tried: tuple[TriedTool, ...]) -> Reach:
    """With the strokes of a tool that is put on again at multiples of a step."""
    stroke = step * math.floor(row.swing_deg / step + 1e-9) if row.swing_deg < 360.0 else 360.0
    stroke = stroke or row.swing_deg
    return replace(row, stroke_deg=stroke, strokes=strokes_for(turns, stroke), tried=tried)


def strokes_for(turns: float, stroke_deg: float) -> int:
    """Strokes for some turns."""
    return math.ceil(360.0 * turns / stroke_deg - 1e-9)


def _no_fit(catalogue: Catalogue, fastener: Fastener) -> str:
    """Why nothing fits."""
    if not fastener.drive:
        return "no tool fits: the mesh does not show its drive"
    width = fastener.across_flats if fastener.across_flats > 0.0 else fastener.width
    kinds = [row for row in catalogue if fastener.drive in row.fits]
    if not kinds:
        return f"no tool of the catalogue is for a drive of {fastener.drive!r}"
    if width > 0.0 and any(row.size > 0.0 for row in kinds):
        nearest = min((row for row in kinds if row.size > 0.0), key=lambda row: abs(row.size - width))
        across = f"{1e3 * width:.4g} mm across {'its points' if fastener.drive == 'torx' else 'flats'}"
        return f"no tool of the catalogue is for {across}; the nearest is {nearest.name}"
    if width > 0.0 and any(row.widths is not None for row in kinds):
        return f"no tool of the catalogue is for a {fastener.drive} of {1e3 * width:.3g} mm"
    return f"no tool of the catalogue is for a {fastener.drive} on a thread of {1e3 * fastener.size:.3g} mm"


def _without_tool(target: int, fastener: Fastener, frame: Floats, because: str) -> Reach:
    return Reach(
        target=target,
        part=fastener.part,
        path=fastener.path,
        is_reachable=False,
        swing_deg=0.0,
        angle_deg=float("nan"),
        pose=frame,
        way=np.empty((0, 4, 4)),
        looked=0.0,
        drawn=0.0,
        because=because,
        blockers=(),
    )
