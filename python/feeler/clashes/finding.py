"""`feeler.clash`: every pair of parts of a mock-up that meets, holds another, or is too near."""

from __future__ import annotations

import time
from collections.abc import Callable, Iterable, Mapping
from dataclasses import replace
from typing import Any

import numpy as np
import numpy.typing as npt

from feeler import _core
from feeler.clashes.fastener_rule import shape_of
from feeler.clashes.openness import open_holders
from feeler.clashes.rules import Limits, Rules, check_length, limits
from feeler.clashes.shapes import PartShapes
from feeler.clashes.table import SHAPES, Clashes, Columns, Facts
from feeler.errors import MeshError, OptionError
from feeler.mockup import Mockup
from feeler.parts import PartsLike
from feeler.scene import Scene

Progress = Callable[[float, str], object]
RulesLike = Rules | Mapping[str, Any] | str | Any
Exclude = Iterable[tuple[PartsLike, PartsLike]] | npt.NDArray[np.integer[Any]]

_STAGES = ("finding parts that meet", "measuring clearances", "measuring depths")
_INDEXED, _FOUND = 0.2, 0.9  # shares of the progress: until the index is there, until the pairs are


class ClashInterrupted(KeyboardInterrupt):
    """Ctrl-C, with what was found until then: `.clashes`, whose `is_partial` says whether anything may be missing."""

    def __init__(self, clashes: Clashes) -> None:
        self.clashes = clashes
        super().__init__(f"interrupted: {clashes!r}")

    def __reduce__(self) -> tuple[type[ClashInterrupted], tuple[Clashes]]:
        return (type(self), (self.clashes,))


def clash(
    mockup: Mockup,
    clearance: float = 0.002,
    contact: float | str = 0.0,
    rules: RulesLike | None = None,
    exclude: Exclude | None = None,
    volume: bool = False,
    scene: Scene | None = None,
    threads: int | None = None,
    progress: Progress | None = None,
) -> Clashes:
    """Every pair of parts that meets, is one in the other, or is nearer than `clearance`; the worst first.

    - `clearance`: metres. 0 asks for what meets alone.
    - `contact`: metres by which parts that meet may be in each other and still only touch, and up to which parts that
      are apart count as in contact. `"chord"`: the chordal errors of both parts, which are known of STEP files.
    - `rules`: a TOML file, `feeler.clashes.Rules`, or a dict of the same form; they give some parts other limits, and
      hide pairs, which `.hidden` counts. The limits given here are for pairs that no rule names.
    - `exclude`: pairs of parts that are not checked, each part as `Parts.select` takes it: `[("*bolt*", "*nut*")]`; or
      `(k, 2)` indices.
    - `volume`: measure what two closed parts share; needs manifold3d, `pip install "feeler[volume]"`.
    - `scene`: one of this mock-up, whose index is used; parts that are not in it are not asked. Default: one is made.
    - `threads`: default all. `progress`: called with the share done (0 to 1) and the stage.

    The same rows on any number of threads. Verdicts are exact: docs/clash.md. Raises `OptionError` for limits, rules
    and names that cannot be, `MissingFileError` and `LoadError` for the file of rules, and `ClashInterrupted`, a
    `KeyboardInterrupt` that holds what was found, at Ctrl-C.
    """
    given: object = mockup
    if not isinstance(given, Mockup):
        raise MeshError(f"clash needs a feeler.Mockup, not {type(given).__name__}")
    near = check_length("clearance", clearance)
    touch = contact if contact == "chord" else check_length("contact", contact, ', or "chord"')
    if scene is not None and scene.mockup is not mockup:
        raise OptionError("scene is of another mock-up: give a scene of this one, or none")
    if volume:
        from feeler.clashes.volumes import solids_library

        solids_library()
    found = _limits(mockup, near, touch, rules, exclude)
    started = time.perf_counter()
    if scene is None:
        scene = Scene(mockup, threads=threads, progress=_share(progress, 0.0, _INDEXED))
    indexed = time.perf_counter()
    answer = _core.clash(
        scene,
        found.clearance,
        found.contact,
        class_of_part=found.class_of_part,
        exclude=found.exclude,
        threads=threads,
        progress=_staged(progress, _INDEXED, _FOUND if volume else 1.0),
    )
    seconds = {"index": indexed - started, **answer.seconds}
    columns, hidden = _columns(answer, found)
    is_partial = bool(answer.is_partial)
    if volume and not is_partial:
        columns, seconds["volumes"], is_partial = _with_volumes(mockup, columns, _share(progress, _FOUND, 1.0))
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
        open_parts=tuple(mockup.part_paths[part] for part in rims),
    )
    clashes = Clashes(
        columns, mockup.part_paths, found.names, facts=facts, is_partial=is_partial, shapes=PartShapes(mockup)
    )
    if is_partial:
        raise ClashInterrupted(clashes)
    if progress is not None:
        try:
            progress(1.0, "done")
        except KeyboardInterrupt:
            raise ClashInterrupted(clashes) from None
    return clashes


def _limits(
    mockup: Mockup, clearance: float, contact: float | str, rules: RulesLike | None, exclude: Exclude | None
) -> Limits:
    from feeler.clashes.rules_file import rules_from

    pairs = _pairs(mockup, exclude)
    chord = mockup.source.chord_tolerance
    return limits(
        rules_from(rules), mockup.parts, mockup.part_paths, clearance, contact, chord, pairs, shape_of(mockup)
    )


def _pairs(mockup: Mockup, exclude: Exclude | None) -> npt.NDArray[np.uint32]:
    """What is excluded as pairs of parts, in whatever order: `(k, 2)`."""
    if exclude is None:
        return np.empty((0, 2), dtype=np.uint32)
    from feeler.ignored import pairs_of_parts

    return pairs_of_parts(mockup, mockup, exclude, "exclude", ("mock-up", "mock-up"))


def _columns(answer: Any, found: Limits) -> tuple[Columns, tuple[tuple[str, int], ...]]:
    """The core's rows under their rules, the worst first, without those that are hidden; and how many each hides."""
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
    return columns.rows(columns.order()), hidden


def _with_volumes(mockup: Mockup, columns: Columns, progress: Progress | None) -> tuple[Columns, float, bool]:
    """With volumes; the seconds that they took; and whether Ctrl-C came in between, so that some are missing."""
    from feeler.clashes.volumes import shared_volumes

    started = time.perf_counter()
    volumes, is_partial = columns.volume, False
    try:
        volumes = shared_volumes(mockup, columns.a, columns.b, columns.verdict, columns.is_open, progress)
    except KeyboardInterrupt:
        is_partial = True
    return replace(columns, volume=volumes), time.perf_counter() - started, is_partial


def _staged(progress: Progress | None, begin: float, end: float) -> Progress | None:
    """The core's progress, each of whose stages goes from 0 to 1, as a share of the whole."""
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
    """Progress as a share of the whole."""
    if progress is None:
        return None
    whole = progress
    return lambda fraction, stage: whole(begin + (end - begin) * fraction, stage)
