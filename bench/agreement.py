"""Compares the answers of all engines. Where they differ, exact arithmetic decides (judge.py).

Judging takes some 0.1 ms a pair, and some peers differ in many pairs: at most `MOST_JUDGED` per cell and peer are
judged, spread evenly over poses and over both sides; the others are counted as unjudged.
"""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import Any

import numpy as np
import numpy.typing as npt
from engines import Engine, Floats, Pairs
from judge import judge
from measure import Findings

import feeler

MOST_JUDGED = 20_000
EXAMPLES_KEPT = 5
SAME_M = 1e-9  # metres
SAME_WAY = 0.01  # of the way

Verdicts = dict[tuple[int, int, int], bool | None]  # of [pose, tool triangle, mock-up triangle]


@dataclass
class Agreement:
    """Pairs two engines agree on, and where they differ, who is right by exact arithmetic."""

    agreed: int = 0
    differing: int = 0
    unjudged: int = 0  # of the differing; all other counts are of judged ones
    feeler_only_true: int = 0  # the peer missed it
    peer_only_false: int = 0  # the peer made it up
    feeler_only_false: int = 0  # feeler made it up
    peer_only_true: int = 0  # feeler missed it
    not_queried: int = 0  # a triangle without area: feeler leaves it out and says so in the load report
    examples: dict[str, list[list[int]]] = field(default_factory=dict)  # [pose, tool triangle, mock-up triangle]

    @property
    def feeler_wrong(self) -> int:
        """Pairs on which feeler breaks its contract; anything but 0 is a bug."""
        return self.feeler_only_false + self.peer_only_true

    def row(self) -> dict[str, Any]:
        """For the record."""
        counts = {name: value for name, value in vars(self).items() if name != "examples"}
        return counts | {"feeler_wrong": self.feeler_wrong, "examples": self.examples}

    def add(self, what: str, place: tuple[int, int, int]) -> None:
        """Count one, and keep the first few."""
        setattr(self, what, getattr(self, what) + 1)
        kept = self.examples.setdefault(what, [])
        if len(kept) < EXAMPLES_KEPT:
            kept.append(list(place))


def compare(
    mockup: feeler.Mockup,
    tool: feeler.Tool,
    poses: Floats,
    ours: Findings,
    theirs: Findings,
    verdicts: Verdicts | None = None,
    most: int = MOST_JUDGED,
) -> Agreement:
    """Compares the pairs of all poses and has the differences judged.

    `verdicts` keeps the judgements: peers tend to err at the same places.
    """
    agreement, verdicts = Agreement(), {} if verdicts is None else verdicts
    ours_only: list[tuple[int, int, int]] = []
    theirs_only: list[tuple[int, int, int]] = []
    for number, (mine, other) in enumerate(zip(ours.pairs, theirs.pairs, strict=True)):
        mine_keys, other_keys = _keys(mine), _keys(other)
        agreement.agreed += len(np.intersect1d(mine_keys, other_keys, assume_unique=True))
        for extra, pairs, keys, rest in (
            (ours_only, mine, mine_keys, other_keys),
            (theirs_only, other, other_keys, mine_keys),
        ):
            extra += [(number, int(i), int(j)) for i, j in pairs[~np.isin(keys, rest)]]
    agreement.differing = len(ours_only) + len(theirs_only)
    for extra, if_true, if_false in (
        (ours_only, "feeler_only_true", "feeler_only_false"),
        (theirs_only, "peer_only_true", "peer_only_false"),
    ):
        chosen = _evenly(extra, max(1, most * len(extra) // max(1, agreement.differing)))
        agreement.unjudged += len(extra) - len(chosen)
        _judge(mockup, tool, poses, chosen, verdicts)
        for place in chosen:
            true = verdicts[place]
            agreement.add("not_queried" if true is None else if_true if true else if_false, place)
    return agreement


def compare_answers(
    mockup: feeler.Mockup, tool: feeler.Tool, poses: Floats, ours: Findings, peer: Engine, theirs: Findings
) -> dict[str, int]:
    """Poses at which both say the same of `is_colliding`; and of the others, who is wrong.

    `ours` has feeler's pairs as well: where it says yes, one true pair proves it; where it says no, the peer has to
    name a true pair.
    """
    counts = {"agreed": 0, "peer_wrong": 0, "feeler_wrong": 0}
    for number, (mine, other) in enumerate(zip(ours.answers, theirs.answers, strict=True)):
        pose = poses[number]
        if mine != bool(len(ours.pairs[number])):
            counts["feeler_wrong"] += 1
        elif mine == other:
            counts["agreed"] += 1
        else:
            named = ours.pairs[number] if mine else peer.pairs(peer.aim("collide", pose)())
            proof = any(judge(mockup, tool, pose, pair[None])[0] for pair in named[:MOST_JUDGED])
            counts["feeler_wrong" if proof != mine else "peer_wrong"] += 1
    return counts


def compare_distances(ours: Findings, theirs: Findings) -> dict[str, int]:
    """Poses at which both say the same distance within `SAME_M`; of the others, who found no nearer pair."""
    mine, other = np.array(ours.values), np.maximum(np.array(theirs.values), 0.0)  # below 0: they meet
    return {
        "agreed": int((np.abs(mine - other) <= SAME_M).sum()),
        "peer_wrong": int((other > mine + SAME_M).sum()),
        "feeler_wrong": int((mine > other + SAME_M).sum()),
    }


def compare_casts(ours: Findings, theirs: Findings) -> dict[str, int]:
    """Motions for which both say the same time of impact within `SAME_WAY`, and those where the peer's is another."""
    mine, other = np.array(ours.values), np.array(theirs.values)
    return {
        "agreed": int((np.abs(mine - other) <= SAME_WAY).sum()),
        "peer_earlier": int((other < mine - SAME_WAY).sum()),
        "peer_later": int((other > mine + SAME_WAY).sum()),
    }


def _keys(pairs: Pairs) -> npt.NDArray[np.uint64]:
    return np.asarray(pairs[:, 0].astype(np.uint64) << np.uint64(32) | pairs[:, 1].astype(np.uint64))


def _evenly(places: list[tuple[int, int, int]], most: int) -> list[tuple[int, int, int]]:
    if len(places) <= most:
        return places
    return [places[i] for i in np.linspace(0, len(places) - 1, most).astype(int)]


def _judge(
    mockup: feeler.Mockup, tool: feeler.Tool, poses: Floats, places: list[tuple[int, int, int]], verdicts: Verdicts
) -> None:
    open_places = [place for place in places if place not in verdicts]
    for number in sorted({place[0] for place in open_places}):
        here = [place for place in open_places if place[0] == number]
        pairs = np.array([place[1:] for place in here], dtype=np.uint32)
        verdicts.update(zip(here, judge(mockup, tool, poses[number], pairs), strict=True))
