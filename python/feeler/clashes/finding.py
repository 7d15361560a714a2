"""`feeler.clash`: all pairs of parts that overlap, touch, contain each other or are too near."""

from __future__ import annotations

import itertools
import time
from collections.abc import Iterable
from dataclasses import replace
from typing import Any, TypeAlias

import numpy as np
import numpy.typing as npt

from feeler import _core
from feeler.arguments import check_flag, check_length, check_progress, check_threads
from feeler.choices import Chord
from feeler.clashes.fastener_rule import shape_of
from feeler.clashes.limits import CONTACT_ROUNDINGS, Limits, limits, only_with, without_groups
from feeler.clashes.openness import open_holders
from feeler.clashes.result import Clashes
from feeler.clashes.rules import RulesLike, is_chord, rules_from
from feeler.clashes.scope import Scope
from feeler.clashes.shapes import PartShapes
from feeler.clashes.table import SHAPES, Columns, Facts
from feeler.clashes.tracking import part_keys
from feeler.clashes.verdict import OVERLAPS
from feeler.clashes.words import named
from feeler.errors import MeshError, OptionError
from feeler.ignored import Group, groups_of_parts, listed, pairs_of_parts
from feeler.mockup import Mockup
from feeler.parts import PartsLike
from feeler.progress import Progress
from feeler.renamed import keywords
from feeler.scene import Scene

Exclude: TypeAlias = Iterable[tuple[PartsLike, PartsLike]] | npt.NDArray[np.integer[Any]]

_STAGES = ("finding colliding parts", "measuring clearances", "measuring depths")
_LARGEST_M = 1e40
"""Largest coordinate of a check. Beyond 1e47 m depths overflow: they need products of several lengths."""
MANY_PAIRS = 10_000
"""Two patterns of `ignore` with more combinations are skipped by classes of parts; others are listed, pair by pair."""
_FLUSH_UNITS = 32.0
"""Units in the last place of the largest coordinate that flush faces may be apart; the least `contact` of the core."""
_INDEXED, _FOUND = 0.2, 0.9  # share of the progress when the index, and when the pairs are done


class ClashInterrupted(KeyboardInterrupt):
    """Ctrl-C. `.clashes` has the findings so far; its `is_partial` says whether some may be missing."""

    def __init__(self, clashes: Clashes) -> None:
        self.clashes = clashes
        super().__init__(f"interrupted: {clashes!r}")

    def __reduce__(self) -> tuple[type[ClashInterrupted], tuple[Clashes]]:
        return (type(self), (self.clashes,))


@keywords({"exclude": "ignore"})
def clash(
    mockup: Mockup,
    clearance: float = 0.002,
    contact: float | Chord = 0.0,
    rules: RulesLike | None = None,
    ignore: Exclude | None = None,
    volume: bool = False,
    scene: Scene | None = None,
    threads: int | None = None,
    progress: Progress | None = None,
    parts: PartsLike | None = None,
) -> Clashes:
    """All pairs of parts that overlap, touch, contain each other, or are within `clearance` of each other; worst first.

    - `clearance`: metres. 0 finds only parts that collide.
    - `contact`: metres. Parts count as in contact up to this depth, and up to this gap; at least 32 units in the last
      place of the largest coordinate, and four times the rounding of the files (`mockup.source.rounding`). `"chord"`:
      the chordal errors of both parts, which are known for STEP files.
    - `rules`: a TOML file, `feeler.clashes.Rules`, or a dict of the same form. Rules give pairs other limits, or hide
      them (`.hidden` counts these). `clearance` and `contact` hold for pairs that no rule names.
    - `ignore`: pairs of parts to skip, each part as `Parts.select` takes it: `[("*bolt*", "*nut*")]`; or `(k, 2)`
      indices. Skipped pairs are not counted.
    - `volume`: also measure the shared volume of closed parts. Needs manifold3d, `pip install "feeler[volume]"`.
    - `scene`: a scene of this mock-up, to reuse its index; only its parts are checked. Default: a new one.
    - `parts`: only pairs with at least one of these parts. Default: all pairs.
    - `threads`: default all. `progress`: called with the share done (0 to 1) and the stage.

    The result does not depend on the number of threads. docs/clash.md explains verdicts and depths. Memory: the index;
    trees for depths, 130 bytes a triangle, of at most 2^22 triangles or two of the largest part; 165 bytes a finding;
    up to 80 MB for rules. Raises `OptionError` for invalid limits, rules and names, `MeshError` for coordinates beyond
    1e40 m, `MissingFileError` and `LoadError` for the file of rules, and at Ctrl-C `ClashInterrupted`, a
    `KeyboardInterrupt` that holds the findings so far. Before there can be findings, Ctrl-C is a `KeyboardInterrupt`.
    """
    given: object = mockup
    if not isinstance(given, Mockup):
        raise MeshError(f"clash needs a feeler.Mockup, not {type(given).__name__}")
    _check_size(mockup)
    if not isinstance(scene, (Scene, type(None))):
        raise OptionError(f"scene is {scene!r}: give a feeler.Scene of the mock-up, or leave it out")
    check_progress(progress)
    near, touch = checked_limits(clearance, contact, volume)
    check_threads(threads)
    if scene is not None and scene.mockup is not mockup:
        raise OptionError("scene is of another mock-up: give a scene of this mock-up, or leave it out")
    found = _limits(mockup, near, touch, rules, ignore)
    if parts is not None:
        chosen = np.zeros(mockup.part_count, dtype=bool)
        chosen[mockup.parts.select(parts)] = True
        found = only_with(found, chosen)
    started = time.perf_counter()
    if scene is None:
        scene = Scene(mockup, threads=threads, progress=_share(progress, 0.0, _INDEXED))
    indexed = time.perf_counter()
    answer = _core.clash(
        scene,
        found.clearance,
        found.contact,
        class_of_part=found.class_of_part,
        copies_within=least_contact(mockup),
        exclude=found.exclude,
        threads=threads,
        progress=_staged(progress, _INDEXED, _FOUND if volume else 1.0),
    )
    seconds = {"index": indexed - started, **answer.seconds}
    columns, hidden = _columns(mockup, answer, found)
    is_partial = bool(answer.is_partial)
    notes: list[str] = []
    if volume and not is_partial:
        columns, seconds["volumes"], is_partial, notes = _with_volumes(mockup, columns, _share(progress, _FOUND, 1.0))
    present = scene.part_mask
    rims = [] if is_partial else open_holders(mockup, answer.a, answer.b, answer.is_open, present)
    facts = Facts(
        clearance=near,
        contact=touch,
        parts=mockup.part_count,
        triangles=mockup.triangle_count,
        files=mockup.source.files,
        seconds=tuple(seconds.items()),
        counts=tuple(answer.counts.items()),
        hidden=hidden,
        present=int(np.count_nonzero(present)),
        rules=found.asked,
        least_contact=least_contact(mockup),
        open_parts=tuple(mockup.part_paths[part] for part in rims),
        notes=tuple(notes),
        names=_names(mockup),
    )
    clashes = Clashes(
        columns,
        mockup.part_paths,
        found.names,
        facts=facts,
        is_partial=is_partial,
        shapes=PartShapes(mockup),
        scope=Scope.of(found, present),
    )
    if is_partial:
        raise ClashInterrupted(clashes)
    if progress is not None:
        try:
            progress(1.0, "done")
        except KeyboardInterrupt:
            raise ClashInterrupted(clashes) from None
    return clashes


def _check_size(mockup: Mockup) -> None:
    """Raises `MeshError` for coordinates beyond `_LARGEST_M`. Parts without queried triangles have infinite bounds."""
    largest = np.abs(mockup.part_bounds).reshape(mockup.part_count, -1).max(axis=1, initial=0.0)
    is_large = np.isfinite(largest) & (largest > _LARGEST_M)
    if is_large.any():
        part = int(np.argmax(is_large))
        raise MeshError(
            f"part {mockup.part_paths[part]!r} has coordinates of {largest[part]:.3g} m, and a clash check takes up to "
            f"{_LARGEST_M:g} m: check the unit"
        )


def checked_limits(clearance: float, contact: float | Chord, volume: bool) -> tuple[float, float | Chord]:
    """The arguments of these names. Raises `OptionError`, also for volumes without the library that finds them."""
    check_flag("volume", volume)
    near = check_length("clearance", clearance)
    touch: float | Chord = "chord" if is_chord(contact) else check_length("contact", contact, ', or "chord"')
    if volume:
        from feeler.clashes.volumes import solids_library

        solids_library()
    return near, touch


def _limits(
    mockup: Mockup, clearance: float, contact: float | Chord, rules: RulesLike | None, exclude: Exclude | None
) -> Limits:
    wide, pairs = _skipped(mockup, exclude)
    found = limits(
        rules_from(rules),
        mockup.parts,
        mockup.part_paths,
        clearance,
        contact,
        mockup.source.chord_tolerance,
        pairs,
        shape_of(mockup),
        least_contact(mockup),
    )
    if not wide:
        return found
    return without_groups(found, wide) or replace(
        found, exclude=np.concatenate([pairs, listed(wide, mockup.part_count)])
    )


def _names(mockup: Mockup) -> tuple[tuple[str, str], ...]:
    """Key and name of each part whose name is not the last step of its path."""
    pairs = zip(mockup.part_names, mockup.part_paths, strict=True)
    other = [part for part, (name, path) in enumerate(pairs) if name != path.rpartition("/")[2]]
    keys = part_keys(mockup.part_paths) if other else []
    return tuple((keys[part], mockup.part_names[part]) for part in other)


def least_contact(mockup: Mockup) -> float:
    """The least `contact`, metres: how far apart the rounding of the file's coordinates may put faces that are
    flush, or copies of one surface."""
    return CONTACT_ROUNDINGS * mockup.source.rounding


def _skipped(mockup: Mockup, exclude: Exclude | None) -> tuple[list[Group], npt.NDArray[np.uint32]]:
    """The pairs of parts to skip, in either order: two groups of many combinations, and other pairs, `(k, 2)`."""
    if exclude is None:
        return [], np.empty((0, 2), dtype=np.uint32)
    whose = ("mock-up", "mock-up")
    if isinstance(exclude, np.ndarray):
        return [], pairs_of_parts(mockup, mockup, exclude, "ignore", whose)
    groups = groups_of_parts(mockup, mockup, exclude, "ignore", whose)
    wide = [len(ours) * len(theirs) > MANY_PAIRS for ours, theirs in groups]
    few = listed(itertools.compress(groups, (not each for each in wide)), mockup.part_count)
    return list(itertools.compress(groups, wide)), few


def _columns(mockup: Mockup, answer: Any, found: Limits) -> tuple[Columns, tuple[tuple[str, int], ...]]:
    """The visible findings with their rules, the worst first; and how many findings each rule hides."""
    a, b = np.asarray(answer.a), np.asarray(answer.b)
    rule = found.rule_of(a, b)
    hidden_by = found.hidden_by(a, b)
    asked = np.flatnonzero((rule >= 0) & (hidden_by < 0))
    hidden = tuple((name, int(np.count_nonzero(hidden_by == i))) for i, name in enumerate(found.hiding))
    given = {name: np.asarray(getattr(answer, name))[asked] for name in SHAPES if hasattr(answer, name)}
    given["rule"] = rule[asked].astype(np.uint32)
    given["severity"] = found.severities[given["rule"]]
    given["volume"] = np.full(len(asked), np.nan)
    columns = Columns(**{name: np.array(given[name], dtype=kind) for name, (kind, _) in SHAPES.items()})
    return columns.rows(columns.order(part_keys(mockup.part_paths), found.names)), hidden


def _with_volumes(
    mockup: Mockup, columns: Columns, progress: Progress | None
) -> tuple[Columns, float, bool, list[str]]:
    """The columns with volumes, the seconds taken, whether Ctrl-C stopped it, so that some are missing, and notes."""
    from feeler.clashes.volumes import shared_volumes

    started = time.perf_counter()
    without: list[int] = []
    volumes, is_partial = columns.volume, False
    try:
        does_share = np.isin(columns.verdict, [each.code for each in OVERLAPS]) | (columns.depth > _flush(mockup))
        volumes, without = shared_volumes(mockup, columns.a, columns.b, does_share, columns.is_open, progress)
    except KeyboardInterrupt:
        is_partial = True
    notes = [
        f"no shared volume is measured of {named([mockup.part_paths[part] for part in without])}: the triangles do not "
        "meet at the seams, or cross each other. Export again as solid, or repair the mesh"
    ]
    return replace(columns, volume=volumes), time.perf_counter() - started, is_partial, notes if without else []


def _flush(mockup: Mockup) -> float:
    """The largest depth of flush faces that rounding explains, metres. Up to it no shared volume is measured."""
    largest = float(np.abs(mockup.bounds).max(initial=0.0, where=np.isfinite(mockup.bounds)))
    return max(least_contact(mockup), _FLUSH_UNITS * float(np.spacing(largest)))


def _staged(progress: Progress | None, begin: float, end: float) -> Progress | None:
    """Converts the core's progress, 0 to 1 in each stage, to a share of the whole."""
    if progress is None:
        return None
    whole, width = progress, (end - begin) / len(_STAGES)
    last = begin

    def report(fraction: float, stage: str) -> None:
        nonlocal last
        if stage in _STAGES:
            last = begin + width * (_STAGES.index(stage) + fraction)
        whole(last, stage)

    return report


def _share(progress: Progress | None, begin: float, end: float) -> Progress | None:
    """Converts progress from 0 to 1 to a share of the whole, from `begin` to `end`."""
    if progress is None:
        return None
    whole = progress
    return lambda fraction, stage: whole(begin + (end - begin) * fraction, stage)
