"""Which tool of a catalogue reaches a fastener: those that fit by drive and size, one after the other."""

from __future__ import annotations

import math
from collections import Counter
from dataclasses import dataclass, field, replace

import numpy as np
import numpy.typing as npt

from feeler.mockup import Mockup, Tool
from feeler.part_meshes import PartMeshes
from feeler.plan.blocked import Blocker
from feeler.plan.catalogue import Catalogue, name_of, shaped, tool_of
from feeler.plan.fasteners import Fastener, Fasteners
from feeler.plan.reach import Reach, TriedTool, worst_first
from feeler.plan.reach_question import ReachQuestion, SeatSearch, shifted
from feeler.plan.swings import turned
from feeler.plan.tool_seat import SeatedTool, seated_tool
from feeler.plan.tool_spec import ToolSpec, depth_of
from feeler.scene import Scene

Floats = npt.NDArray[np.float64]
Pieces = tuple[ToolSpec, ...]

SIDES = {"hexagon": 6, "square": 4, "12-point": 12}
"""Flats of the drives on the outside."""
UPRIGHT = 0.1
"""Faces whose normals are this near to across the axis are flats."""


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
            return replace(seated, kept=kept, outward=np.array([1.0, 0.0, 0.0]))
        return replace(seated, kept=kept, is_around=True, plug=plug)

    def search_of(self, pieces: Pieces) -> SeatSearch:
        """The search for a tool: a chain swings as its handle does."""
        needed = pieces[-1].swing_deg if self.swing_deg is None else self.swing_deg
        return replace(self.search, needed=needed, is_strict=True)


def _only_grip(tool: Tool) -> Tool:
    """Where a hand would be."""
    is_grip = np.asarray(tool.part_of_face) == tool.part_count - 1
    return Tool(tool.vertices, np.asarray(tool.faces)[is_grip], name="grip")


def turns_to_flats(mockup: Mockup, fasteners: Fasteners) -> list[float]:
    """Degrees about z from each frame to the flats of its head: there a flat faces y. 0 for other drives."""
    meshes = PartMeshes(mockup)
    return [_turn_to_flats(meshes, row) if row.drive in SIDES else 0.0 for row in fasteners]


def _turn_to_flats(meshes: PartMeshes, row: Fastener) -> float:
    corners = (meshes.corners(row.part) - row.frame[:3, 3]) @ row.frame[:3, :3]
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


def choose(
    scene: Scene, chosen: Chosen, target: int, fastener: Fastener, frame: Floats, turn: float, turns: float
) -> Reach:
    """The first tool that reaches a fastener; if none does, the one that came nearest.

    A chain contains its first pieces, so where these collide at every angle, it does too.
    """
    fitting = chosen.catalogue.fitting(fastener.drive, fastener.across_flats, fastener.size)
    if not fitting:
        return _without_tool(target, fastener, frame, _no_fit(chosen.catalogue, fastener))
    head = fastener.length if fastener.kind == "nut" else fastener.head_height
    tried: list[TriedTool] = []
    stems: dict[Pieces, bool] = {}
    best: Reach | None = None
    for pieces in fitting:
        lift = depth_of(pieces[0], head)
        seat = shifted(frame @ turned(turn), -lift * frame[:3, 2])
        search = chosen.search_of(pieces)
        if _is_blocked(scene, chosen, pieces, search, seat, fastener.part, stems, tried):
            continue
        aligned = 360.0 / SIDES[fastener.drive] if fastener.drive in SIDES else None
        seated = replace(chosen.seated(pieces), depth=max(0.0, lift), aligned_deg=aligned)
        row = ReachQuestion(scene, seated, search).reach(target, seat, fastener.part)
        row = replace(row, angle_deg=(row.angle_deg + turn) % 360.0)
        if row.is_reachable:
            return _stroked(row, pieces[-1].step_deg, turns, tuple(tried))
        tried.append(TriedTool(name_of(pieces), row.because, row.blockers))
        if best is None or (row.drawn, row.swing_deg) > (best.drawn, best.swing_deg):
            best = row
    counts: Counter[tuple[int, str]] = Counter()
    for each in tried:
        counts.update({(block.part, block.path): block.count for block in each.blockers})
    blockers = tuple(Blocker(part, path, count) for (part, path), count in worst_first(counts))
    many = len(fitting)
    of = f"none of the {many} tools that fit reaches it" if many > 1 else "the tool that fits does not reach it"
    if best is None:
        because = f"{of}: {tried[0].tool}: {tried[0].because}"
        return replace(_without_tool(target, fastener, frame, because), blockers=blockers, tried=tuple(tried))
    because = f"{of}; nearest came {best.tool}: {best.because}"
    return replace(best, because=because, blockers=blockers, tried=tuple(tried))


def _is_blocked(
    scene: Scene,
    chosen: Chosen,
    pieces: Pieces,
    search: SeatSearch,
    seat: Floats,
    part: int,
    stems: dict[Pieces, bool],
    tried: list[TriedTool],
) -> bool:
    """Whether the first pieces of a chain have no free seat; each is asked once."""
    for count in range(1, len(pieces)):
        stem = pieces[:count]
        if stem not in stems:
            blockers = ReachQuestion(scene, chosen.seated(stem), search).blockers_at(seat, part)
            stems[stem] = blockers is not None
            if blockers is not None:
                tried.append(TriedTool(name_of(stem), "it collides at every angle", blockers))
        if stems[stem]:
            return True
    return False


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
    width = fastener.across_flats
    kinds = [row for row in catalogue if fastener.drive in row.fits]
    if not kinds:
        return f"no tool of the catalogue is for a drive of {fastener.drive!r}"
    if width > 0.0 and any(row.size > 0.0 for row in kinds):
        nearest = min((row for row in kinds if row.size > 0.0), key=lambda row: abs(row.size - width))
        return f"no tool of the catalogue is for {1e3 * width:.4g} mm across flats; the nearest is {nearest.name}"
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
