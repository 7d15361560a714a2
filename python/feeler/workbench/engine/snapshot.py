"""The engine's results at one moment: immutable, for any thread."""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import cast

import numpy as np
import numpy.typing as npt

from feeler._core import Clearance, Collision, Contacts, Distance, Penetration
from feeler.workbench.document.motion import Floats
from feeler.workbench.document.protocol import MOST_CLEARANCES, MOST_HITS, DepthKind, Mode, State
from feeler.workbench.engine.world import NO_HITS, NO_PLANES, NO_ROWS

NOT_DRAWN = np.uint32(2**32 - 1)

NO_FORCE = np.zeros(3)
NO_FORCE.flags.writeable = False

Places = npt.NDArray[np.uint32] | None
"""Mock-up or tool triangle -> packed triangle, `NOT_DRAWN` without one; None: the numbers are the same."""


@dataclass(frozen=True, eq=False)
class Snapshot:
    """The hand and its contacts.

    number: grows. pose: where the engine lets the tool be; wish: the target of the hand. blocked: contact separates the
    two. force, torque: on the hand, N and Nm, world axes, about the tool's centre of area; zero in stop and pass, and
    in doubt. contains: it is wholly inside a part, or contains one. is_current: planes, rows, distance and the way out
    belong to this pose, and not to an earlier one.
    """

    number: int
    time: float
    pose_seq: int
    wish_time: float
    source: str
    mode: str
    pose: Floats
    wish: Floats
    blocked: bool = False
    force: Floats = field(default_factory=lambda: NO_FORCE)
    torque: Floats = field(default_factory=lambda: NO_FORCE)
    hits: Collision = field(default_factory=lambda: NO_HITS)
    planes: Contacts = field(default_factory=lambda: NO_PLANES)
    rows: Clearance = field(default_factory=lambda: NO_ROWS)
    distance: Distance | None = None
    contains: bool = False
    way_out: Penetration | None = None
    stopped_by: int | None = None
    is_current: bool = True
    engine_us: float = 0.0
    rate_hz: float = 0.0
    places: Places = None
    held_places: Places = None

    @property
    def is_free(self) -> bool:
        """Whether there is no collision and no containment."""
        return not self.hits and not self.contains

    @property
    def parts(self) -> list[int]:
        """The touched parts: colliding ones, and those that stop it; sorted."""
        stopped = set() if self.stopped_by is None else {self.stopped_by}
        return sorted(stopped.union(self.hits.parts.tolist()))

    @property
    def depth(self) -> float:
        """The length of the way out, metres; 0 without a collision, and until it is known. See `depth_kind`.

        It is not the gap of a contact plane: for a sheet across the tool that gap is as large as the tool extends
        behind it.
        """
        return 0.0 if self.is_free or self.way_out is None else self.way_out.depth

    @property
    def depth_kind(self) -> DepthKind:
        """As of `feeler.Penetration`."""
        return "exact" if self.is_free or self.way_out is None else self.way_out.kind

    def packed_hits(self) -> tuple[npt.NDArray[np.uint32], npt.NDArray[np.uint32], int]:
        """Colliding packed triangles of mock-up and hand, at most `MOST_HITS` each, and the number of further ones."""
        hits = _packed(self.hits.mockup_triangles, self.places)
        ours = _packed(self.hits.tool_triangles, self.held_places)
        return hits[:MOST_HITS], ours[:MOST_HITS], max(0, len(hits) - MOST_HITS)

    def shares(self) -> Floats:
        """The force on each plane, N, `(k,)`: shared in proportion to the cosine between the two."""
        size = float(np.linalg.norm(self.force))
        if not len(self.planes) or size == 0.0:
            return np.zeros(len(self.planes))
        along = np.maximum(0.0, self.planes.normals @ (self.force / size))
        along[self.planes.gaps > 1e-4] = 0.0  # far beyond the skin: no force
        whole = float((along * along).sum())
        shares: Floats = along * (size / whole) if whole > 0.0 else along
        return shares

    def message(self, now: float | None = None) -> State:
        """The state for pages. now: on the engine's clock, for the age; default: the time of its creation."""
        hits, tool_hits, more = self.packed_hits()
        planes, rows, near = self.planes, self.rows, self.distance
        shown = slice(0, MOST_CLEARANCES)
        return State(
            seq=self.number,
            pose_seq=self.pose_seq,
            engine_us=self.engine_us,
            age_ms=max(0.0, 1e3 * ((self.time if now is None else now) - self.wish_time)),
            rate_hz=self.rate_hz,
            mode=cast(Mode, self.mode),
            is_free=self.is_free,
            blocked=self.blocked,
            force=_triple(self.force),
            torque=_triple(self.torque),
            depth=self.depth,
            depth_kind=self.depth_kind,
            hit_count=len(hits) + more,
            hit_more=more,
            contact_more=planes.omitted,
            distance=None
            if near is None or near.part is None or near.point_on_tool is None or near.point_on_mockup is None
            else {
                "value": near.value,
                "tool_point": _triple(near.point_on_tool),
                "mockup_point": _triple(near.point_on_mockup),
                "part": near.part,
            },
            parts=self.parts,
            pose=self.pose,
            wish=self.wish,
            hits=hits,
            tool_hits=tool_hits,
            planes=np.column_stack([planes.points, planes.normals, planes.gaps, self.shares()]).astype(np.float32),
            plane_parts=planes.parts,
            clearance=np.column_stack([rows.distances, rows.points_on_tool, rows.points_on_mockup])[shown].astype(
                np.float32
            ),
            clearance_parts=rows.parts[shown],
        )


def _packed(triangles: npt.NDArray[np.uint32], places: Places) -> npt.NDArray[np.uint32]:
    there = triangles if places is None else places[triangles]
    return np.sort(there[there != NOT_DRAWN])


def _triple(vector: Floats) -> tuple[float, float, float]:
    x, y, z = vector.tolist()
    return (x, y, z)
