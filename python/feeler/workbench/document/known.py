"""Facts that commands need beside the document, and that only the engine or an answer has."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field

from feeler.parts import Parts
from feeler.workbench.document import motion
from feeler.workbench.document.document import Findings, Trip
from feeler.workbench.document.joints import JointStep, MechanismState
from feeler.workbench.document.motion import Row


@dataclass(frozen=True)
class Way:
    """A way of parts, which start where they lie: poses `(4, 4)` of their motion in the world, the first the identity.

    clearance: the smallest distance on it, metres; None if nothing was near, or it is not known.
    """

    parts: tuple[int, ...]
    poses: tuple[Row, ...]
    clearance: float | None


Along = tuple[tuple[int, ...], tuple[Row, ...], tuple[tuple[int, Row], ...]]
"""Parts that move alike, their way as that of a hand, and where those begin that were not at home."""


@dataclass(frozen=True)
class Measured:
    """The result of a measure; see `document.Measure`."""

    type: str
    points: tuple[tuple[float, float, float], ...]
    value: float
    unit: str
    is_exact: bool
    parts: tuple[int, ...] = ()


@dataclass(frozen=True, eq=False)
class Known:
    """The facts that commands need beside the document.

    bounds: `(2, 3)` of the parts in the scene. tools: triangles by name, of the tools made so far. pose: of the hand.
    tool_pose: where a newly taken tool is free. trip: of the parts in the hand, and their smallest clearance on it.
    absent: parts that were excluded when the mock-up was opened. findings: those that a job found. ways: of
    answered cards, by their number. mechanism: one that is opened. joints: the numbers of a position, and the poses of
    its links. joint_steps: moves of joints, each with what moves alike: parts, way, starts. author: the name of who
    gives the command; empty if they chose none.
    """

    parts: Parts
    bounds: motion.Floats
    tools: Mapping[str, int]
    pose: Row = motion.HOME
    tool_pose: Row = motion.HOME
    trip: Trip | None = None
    least_clearance: float | None = None
    absent: frozenset[int] = frozenset()
    measured: Measured | None = None
    findings: Findings | None = None
    ways: Mapping[int, tuple[Way, ...]] = field(default_factory=dict)
    mechanism: MechanismState | None = None
    joints: tuple[Mapping[str, float], tuple[Row, ...]] | None = None
    joint_steps: tuple[tuple[JointStep, list[Along]], ...] = ()
    author: str = ""

    @property
    def there(self) -> tuple[int, ...]:
        """The parts that are in the scene."""
        return tuple(part for part in range(len(self.parts)) if part not in self.absent)
