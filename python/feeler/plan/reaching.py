"""`access`: can a tool reach fasteners, and how far can it swing there?"""

from __future__ import annotations

import os
from collections.abc import Sequence
from concurrent.futures import Executor, ThreadPoolExecutor
from dataclasses import replace
from typing import Any

import numpy as np
import numpy.typing as npt

from feeler.arguments import check_kind, check_number, check_progress, check_threads, check_whole, numbers_of, shown
from feeler.choices import GripAxis
from feeler.errors import MeshError, OptionError, PoseError
from feeler.mockup import Tool
from feeler.plan.catalogue import Catalogue, catalogue
from feeler.plan.choosing import Chosen, HeadShape, choose, head_shapes, quicker, strokes_for
from feeler.plan.fasteners import Fastener, Fasteners
from feeler.plan.reach import Access as Access
from feeler.plan.reach import AccessInterrupted as AccessInterrupted
from feeler.plan.reach import Reach as Reach
from feeler.plan.reach import TriedTool as TriedTool
from feeler.plan.reach_question import ReachQuestion, SeatSearch, shifted
from feeler.plan.sight import sight
from feeler.plan.tool_seat import SeatedTool, seated_tool
from feeler.poses import PoseLike, PosesLike, nearest_rigid, one_pose, placed, pose_stack
from feeler.progress import Progress
from feeler.renamed import keywords
from feeler.scene import Scene
from feeler.spreading import Interrupted, check_executor, spread

Floats = npt.NDArray[np.float64]
Hand = Tool | tuple[Tool, PoseLike]

LEAST_ANGLES, MOST_ANGLES = 4, 3600
"""Seats around the axis."""
ANGLES, APPROACH_M = 72, 0.1
"""Steps around the axis, and the length of a way in, metres, unless told otherwise."""
SWING_DEG = 60.0
"""The swing that a tool needs unless told otherwise."""
MOST_TURNS = 1e6
"""Of a fastener."""
FARTHEST_M = 1000.0
"""The longest way in, and the largest lift, metres: no wrench comes from farther away, and casts over distances at
which coordinates round by millimetres take for ever."""
NEAR_M = 0.02
"""The largest distance between the origin of a bare frame and its fastener, metres."""
UNDER_M = 1e-4
"""How far below that origin the search begins, so that the head comes first, metres."""
_POINT = np.array([[0.0, 0.0, 0.0], [1e-6, 0.0, 0.0], [0.0, 1e-6, 0.0]])  # a tool as small as a point, metres


@keywords({"swing": "swing_deg"})
def access(
    scene: Scene,
    tool: Tool | Catalogue | str | os.PathLike[str],
    targets: Fasteners | PoseLike | PosesLike,
    swing_deg: float | None = None,
    angles: int = ANGLES,
    hand: Hand | None = None,
    approach: float = APPROACH_M,
    *,
    grip: GripAxis | PoseLike | None = None,
    lift: float | npt.ArrayLike = 0.0,
    clearance: float = 0.0,
    eyes: npt.ArrayLike | None = None,
    turns: float | npt.ArrayLike = 1.0,
    threads: int | None = None,
    executor: Executor | None = None,
    progress: Progress | None = None,
) -> Access:
    """Whether the tool reaches each target, and how far it can swing there, about the target's z axis.

    The tool's frame is laid on the target's: origin on origin, z along z, turned about z by any angle. Every free swing
    of at least a thousandth of a degree is found, and none is reported larger than it is. Then a way in is searched
    over `approach` metres: straight along z, or else sideways, across z. `access` never claims that there is no way:
    each answer says how far it searched (`looked`) and how far the tool came out (`drawn`).

    - `tool`: a tool, or a `Catalogue`, of which the first tool is taken that fits by drive and size and reaches: kinds
      in its order, of chains the shortest extension first. `Reach.tried` says why those before do not reach.
      "built-in" and "catalogue" are the built-in one, other texts are paths of TOML files.
    - `targets`: `Fasteners`, or frames `(n, 4, 4)`, world_from_target, metres, z out of the joint. The tool may touch
      the fastener at the seat, while swinging, and on a straight way; not when it is pulled off sideways, so that a
      ring does not pass through the head. The fastener of a bare frame is the part nearest to its origin, up to 20 mm
      away. A catalogue needs `Fasteners`.
    - `swing_deg`: the required degrees, above 0 up to 360; default: 60, or what each tool of the catalogue needs.
    - `angles`: even steps around z that are tried first, and counted in `blockers`. Free swings do not depend on it. A
      catalogue's tools have steps of their own: of their swings all that are large enough are found.
    - `hand`: a tool in the tool's frame that moves with it, or `(hand, tool_from_hand)`; with a catalogue in the frame
      of the grip, whose z points along it and away from the fastener, as `Catalogue.hand`.
    - `grip`: the target's frame in the tool's: `tool_from_target` `(4, 4)`, or the tool's axis that points out of the
      joint, about its origin: "y" for `sample_tool("wrench")`, whose jaw turns about y. Not with a catalogue.
    - `lift`: metres by which the tool sits above the target's origin, one or one per target; negative: below. Not with
      a catalogue, whose tools sit on the bearing face or in the recess.
    - `clearance`: metres that the hand keeps from all parts but the fastener, as for gloves; without a hand, the grip
      of a catalogue's tool, or all of `tool`.
    - `eyes`: points `(k, 3)`, world, metres: `Reach.seen` is then the share of the head that the best of them sees, as
      in `sight`.
    - `turns`: of the fastener, one number or one for each target, for `Reach.strokes`.
    - `threads`: default: all.
    - `executor`: where the targets are worked on, as in `removals`; the answer depends on neither.

    Raises `OptionError` if there is no target, a number is out of range, or fasteners are of another mock-up,
    `PoseError` for frames that are not rigid, `MeshError` if the tool is not one, and `AccessInterrupted`, a
    `KeyboardInterrupt`, with the answers found before Ctrl-C.
    """
    if not isinstance(scene, Scene):
        raise MeshError(f"access needs a feeler.Scene, not {type(scene).__name__}")
    needed = None
    if swing_deg is not None:
        needed = check_number("swing_deg", swing_deg, "degrees, above 0 up to 360", above=0.0, most=360.0)
    way = check_number("approach", approach, "metres, above 0 up to 1,000", above=0.0, most=FARTHEST_M)
    steps = check_whole("angles", angles, LEAST_ANGLES, MOST_ANGLES)
    gap = check_number("clearance", clearance, "metres, 0 to 1", least=0.0, most=1.0)
    workers = check_threads(threads) or os.cpu_count() or 1
    check_progress(progress)
    search = SeatSearch(SWING_DEG if needed is None else needed, steps, way, gap)
    asked: _Asked
    if isinstance(tool, (str, os.PathLike)):
        tool = catalogue(tool)
    if isinstance(tool, Catalogue):
        asked = _chosen(tool, targets, needed, search, hand, grip, lift)
    else:
        asked = (seated_tool(tool, hand, grip), search)
    frames, parts = _targets(scene, targets)
    frames = _lifted(frames, lift)
    wanted = _turns(turns, len(frames))
    bolts: Sequence[Fastener | None] = targets if isinstance(targets, Fasteners) else [None] * len(frames)
    shapes: Sequence[HeadShape | None] = [None] * len(frames)
    if isinstance(tool, Catalogue) and isinstance(targets, Fasteners):
        shapes = head_shapes(scene.mockup, targets)
    columns = zip(frames, parts, bolts, shapes, wanted, strict=True)
    targeted: list[_Targeted] = [(i, *each) for i, each in enumerate(columns)]
    points = targets if isinstance(targets, Fasteners) else frames[:, :3, 3]
    seen = [float("nan")] * len(frames)
    if eyes is not None:
        seen = [row.share for row in sight(scene, points, eyes)]

    def heard(done: int, stage: str) -> None:
        if progress is not None:
            progress(done / len(targeted), stage or "reaching targets")

    def told(rows: list[Reach]) -> list[Reach]:
        return rows if eyes is None else [replace(row, seen=seen[row.target]) for row in rows]

    is_alone = executor is not None or min(workers, len(targeted)) == 1
    own = None if is_alone else ThreadPoolExecutor(workers, thread_name_prefix="feeler-access")
    pool = check_executor(executor) or own
    try:
        return Access(told(spread(_reach, scene, asked, targeted, pool, heard)))
    except Interrupted as interrupted:
        rows = told([row for _, row in sorted(interrupted.results.items())])
        raise AccessInterrupted(Access(rows, is_partial=len(rows) < len(targeted))) from None
    finally:
        if own is not None:
            own.shutdown(wait=True, cancel_futures=True)


_Asked = Chosen | tuple[SeatedTool, SeatSearch]
_Targeted = tuple[int, Floats, int | None, Fastener | None, HeadShape | None, float]


def _reach(scene: Scene, asked: _Asked, targeted: _Targeted) -> Reach:
    """The task of one target."""
    target, frame, part, fastener, shape, turns = targeted
    if isinstance(asked, Chosen):
        assert fastener is not None and shape is not None
        return choose(scene, asked, target, fastener, frame, shape, turns)
    row = ReachQuestion(scene, *asked).reach(target, frame, part)
    if not row.is_reachable:
        return replace(row, tool=None, nearest=row.tool)
    return replace(row, stroke_deg=row.swing_deg, strokes=strokes_for(turns, row.swing_deg))


def quickest(scene: Scene, tools: Catalogue, fastener: Fastener, turns: float, enough: int) -> list[Reach]:
    """The tools of a catalogue that may be the quickest at a fastener, as `choosing.quicker`; searched as `access`."""
    chosen = Chosen(tools, SeatSearch(SWING_DEG, ANGLES, APPROACH_M, 0.0), None, None)
    shape = head_shapes(scene.mockup, Fasteners([fastener]))[0]
    return quicker(scene, chosen, fastener, shape, turns, enough)


def _chosen(
    tools: Catalogue,
    targets: object,
    needed: float | None,
    search: SeatSearch,
    hand: Hand | None,
    grip: object,
    lift: Any,
) -> Chosen:
    """The arguments of a catalogue."""
    if not isinstance(targets, Fasteners):
        raise OptionError("a catalogue chooses by drive and size: give feeler.Fasteners as targets, not frames")
    if grip is not None or not (isinstance(lift, (int, float)) and not isinstance(lift, bool) and lift == 0.0):
        raise OptionError("a catalogue's tools know their seat: leave out grip and lift")
    held = None
    if hand is not None:
        pair = hand if isinstance(hand, tuple) and len(hand) == 2 else (hand, np.eye(4))
        what = "a feeler.Tool in the frame of the grip, or (hand, grip_from_hand)"
        held = (check_kind("hand", pair[0], Tool, what), one_pose(pair[1], "hand"))
        placed(np.zeros((1, 3)), held[1], "the hand")
    return Chosen(tools, search, needed, held)


def _turns(turns: float | npt.ArrayLike, count: int) -> list[float]:
    numbers = numbers_of(turns)
    if numbers.shape not in ((), (count,)) or not ((numbers > 0.0) & (numbers <= MOST_TURNS)).all():
        raise OptionError(
            f"turns is {shown(turns)}: give numbers above 0 up to 1,000,000, one or one for each of {count} targets"
        )
    return [float(each) for each in np.broadcast_to(numbers, count)]


def _targets(scene: Scene, targets: Fasteners | PoseLike | PosesLike) -> tuple[Floats, list[int | None]]:
    """Frames (n, 4, 4), and their fasteners."""
    mockup = scene.mockup
    if isinstance(targets, Fasteners):
        if not len(targets):
            raise OptionError("there are no targets: no fastener is among these; give frames (n, 4, 4) instead")
        for row in targets:
            if not (row.part < mockup.part_count and mockup.part_paths[row.part] == row.path):
                raise OptionError(f"fastener {row.path!r} is of another mock-up: find those of the scene's")
        return targets.frames, [row.part for row in targets]
    if isinstance(targets, str):
        raise PoseError(
            f"targets is {shown(targets)}: give feeler.find_fasteners(mockup, {shown(targets)}), or frames (n, 4, 4)"
        )
    given: object = targets
    if isinstance(given, (Sequence, np.ndarray)) and (given.size == 0 if isinstance(given, np.ndarray) else not given):
        raise OptionError("there are no targets: give feeler.Fasteners or frames (n, 4, 4)")
    frames = pose_stack(targets, "targets")
    for i, frame in enumerate(frames):
        placed(np.zeros((1, 3)), frame, f"target {i}")
    frames = nearest_rigid(frames)
    point = Tool(_POINT, [[0, 1, 2]])
    parts: list[int | None] = []
    for frame in frames:
        under = shifted(frame, -UNDER_M * frame[:3, 2])
        parts.append(scene.distance(point, under, within=NEAR_M).part)
    return frames, parts


def _lifted(frames: Floats, lift: float | npt.ArrayLike) -> Floats:
    heights = numbers_of(lift)
    if heights.shape not in ((), (len(frames),)) or not (np.abs(heights) <= FARTHEST_M).all():
        raise OptionError(
            f"lift is {shown(lift)}: give metres, -1,000 to 1,000, one number or one for each of {len(frames)} targets"
        )
    lifted = frames.copy()
    lifted[:, :3, 3] += np.broadcast_to(heights, len(frames))[:, None] * frames[:, :3, 2]
    return np.asarray(lifted)
