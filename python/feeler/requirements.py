"""Clearances that must hold: named requirements on pairs of parts, and whether a mock-up keeps them.

version = 1

[[requirement]]
name = "fuel pipe to exhaust"
a = "*fuel_pipe*"                 # a pattern of paths, a path with all below it, or several
b = ["*exhaust*", "re:.*/hot_[0-9]+"]
gap = 0.02                        # metres: the least distance
"""

from __future__ import annotations

import math
import os
from collections.abc import Iterable, Mapping
from dataclasses import dataclass, fields
from typing import TYPE_CHECKING, Any, Literal, TypeAlias

import numpy as np

from feeler.arguments import (
    check_kind,
    check_length,
    check_list,
    check_path,
    check_progress,
    check_text,
    check_threads,
    near,
    shown,
)
from feeler.clashes import Clash, Rule, Rules, Verdict, clash
from feeler.clashes.finding import least_contact
from feeler.clashes.limits import sides
from feeler.clashes.retried import ROUNDOFFS
from feeler.clashes.rules import WordsLike
from feeler.errors import LoadError, MeshError, OptionError
from feeler.field_docs import documented
from feeler.io.toml import check_version, toml_of
from feeler.mockup import Mockup
from feeler.progress import Progress
from feeler.scene import Scene
from feeler.words import plural

Words = tuple[str, ...]


@documented
@dataclass(frozen=True)
class Requirement:
    """Some parts stay at least `gap` metres away from others.

    a, b: patterns as `Parts.select` takes them, or `re:` and a regular expression for whole paths; one, or several. The
    order of the two sides does not matter, and a part is not compared with itself. gap: metres; 0: they may touch, but
    not overlap. optional: patterns may match nothing.
    """

    name: str
    """Unique among the requirements."""
    a: Words
    b: Words
    gap: float
    optional: bool = False

    if TYPE_CHECKING:  # it takes more than its fields become

        def __init__(self, name: str, a: WordsLike, b: WordsLike, gap: float, optional: bool = False) -> None: ...

    def __post_init__(self) -> None:
        check_text("the name of a requirement", self.name)
        if not self.name.strip():
            raise OptionError("a requirement has no name: give one")
        # A rule has the same patterns, and its own checks name what is wrong.
        try:
            rule = Rule(self.name, self.a, self.b, optional=self.optional)
        except OptionError as error:
            raise OptionError(str(error).replace("rule ", "requirement ", 1)) from None
        for side, words in (("a", rule.a), ("b", rule.b)):
            if not words:
                raise OptionError(f"requirement {self.name!r}: {side} is empty: give a pattern, or several")
        object.__setattr__(self, "a", rule.a)
        object.__setattr__(self, "b", rule.b)
        check_length(f"requirement {self.name!r}: gap", self.gap)


@documented
@dataclass(frozen=True)
class Verified:
    """Whether a requirement holds.

    status: "holds", "violated", or "unknown" if the scene is without all parts of `a` or of `b`: nothing was compared.
    pairs: how many pairs of parts violate it; the other fields are of the worst of them, and None if it holds. gap:
    their distance, metres, 0 if they touch or overlap. depth: how deep they overlap, metres, at least; 0 if they do
    not. point_a, point_b: where, world.
    """

    requirement: Requirement
    status: Literal["holds", "violated", "unknown"]
    pairs: int = 0
    gap: float | None = None
    depth: float | None = None
    path_a: str | None = None
    """The part of `a` at the least distance; None without one."""
    path_b: str | None = None
    """The same of `b`."""
    point_a: tuple[float, float, float] | None = None
    point_b: tuple[float, float, float] | None = None
    out: tuple[str, ...] = ()
    """The parts that the scene is without, if the status is "unknown": paths."""

    def __bool__(self) -> bool:
        return self.status == "holds"

    @property
    def trouble(self) -> str | None:
        """Why the status is "unknown", in words."""
        if not self.out:
            return None
        more = f" and {plural(len(self.out) - 1, 'other part')} are" if len(self.out) > 1 else " is"
        return f"{self.out[0]}{more} not in the scene"

    def to_dict(self) -> dict[str, Any]:
        """Plain Python values, for JSON."""
        given = {each.name: getattr(self, each.name) for each in fields(self) if each.name != "requirement"}
        asked = {each.name: getattr(self.requirement, each.name) for each in fields(self.requirement)}
        return {
            "name": asked["name"],
            "a": list(asked["a"]),
            "b": list(asked["b"]),
            "required_gap": asked["gap"],
            **{name: list(value) if isinstance(value, tuple) else value for name, value in given.items()},
            "trouble": self.trouble,
        }


RequirementsLike: TypeAlias = Iterable[Requirement] | Mapping[str, object] | str | os.PathLike[str]
"""Requirements, a dict of the form of their TOML file, or the path of such a file."""


def read_requirements(path: str | os.PathLike[str]) -> tuple[Requirement, ...]:
    """The requirements of a TOML file. Raises `MissingFileError`, and `LoadError` if the file is invalid."""
    file = check_path("path", path)
    try:
        return _parsed(toml_of(file, "docs/requirements.md has the form"), str(file))
    except OptionError as error:
        raise LoadError(str(error)) from None


def verify(
    scene: Scene | Mockup,
    requirements: RequirementsLike,
    *,
    threads: int | None = None,
    progress: Progress | None = None,
) -> tuple[Verified, ...]:
    """Whether each requirement holds in a scene, in their order. Parts that the scene is without do not count; one of
    which no parts are left to compare is "unknown", unless it is optional.

    Distances are exact. A requirement still holds where only rounding makes the gap too small: 32 units in the last
    place of the largest coordinate, and four times the rounding of the files (`mockup.source.rounding`). Parts that
    overlap, or of which one is inside the other, violate every requirement. threads: default all. progress: called with
    the share done (0 to 1) and the stage. Raises `OptionError` for invalid requirements, and patterns that match no
    part; `MissingFileError` and `LoadError` for their file.
    """
    given: object = scene
    if not isinstance(given, (Scene, Mockup)):
        raise MeshError(f"verify needs a feeler.Scene or feeler.Mockup, not {type(given).__name__}")
    check_progress(progress)
    check_threads(threads)
    asked = _requirements(requirements)
    if isinstance(scene, Mockup):
        scene = Scene(scene, threads=threads)
    found = []
    for number, each in enumerate(asked):
        if progress is not None:
            progress(number / len(asked), each.name)
        found.append(_verified(scene, each, threads))
    if progress is not None:
        progress(1.0, "done")
    return tuple(found)


def _verified(scene: Scene, asked: Requirement, threads: int | None) -> Verified:
    rule = Rule(asked.name, asked.a, asked.b, clearance=asked.gap, optional=asked.optional)
    rules = Rules((rule,), others=False, where=f"requirement {asked.name!r}")
    try:
        out = _out(scene, rule, rules.where)
        if out and not asked.optional:
            return Verified(asked, "unknown", out=out)
        found = clash(scene.mockup, asked.gap, 0.0, rules, scene=scene, threads=threads)
    except OptionError as error:
        raise OptionError(str(error).replace(f", rule {asked.name!r}", "")) from None
    least = asked.gap - _rounding(scene.mockup)
    wrong = [each for each in found if _is_wrong(each, least)]
    if not wrong:
        return Verified(asked, "holds")
    worst = min(wrong, key=_order)
    depth = 0.0 if worst.verdict in (Verdict.CLEARANCE, Verdict.CONTACT) else _finite(worst.depth)
    return Verified(
        asked,
        "violated",
        len(wrong),
        _finite(worst.gap),
        depth,
        worst.path_a,
        worst.path_b,
        worst.point_a,
        worst.point_b,
    )


def _out(scene: Scene, rule: Rule, where: str) -> tuple[str, ...]:
    """The parts of a requirement that a scene is without, if it has no two of them to compare."""
    paths, present = scene.mockup.part_paths, scene.part_mask
    both = sides(rule, scene.mockup.parts, paths, where)
    there = [side & present for side in both]
    if all(side.any() for side in there) and (there[0] | there[1]).sum() > 1:
        return ()
    # Of "*" and a part that is out, that part is why.
    empty = [side for side, left in zip(both, there, strict=True) if not left.any()] or list(both)
    gone = np.logical_or.reduce(empty) & ~present
    return tuple(paths[part] for part in np.flatnonzero(gone))


def _is_wrong(each: Clash, gap: float) -> bool:
    if each.verdict in (Verdict.CLEARANCE, Verdict.CONTACT):
        return each.gap < gap
    return True


def _rounding(mockup: Mockup) -> float:
    """How much less than they were drawn gaps may be by the rounding of coordinates, metres: as for contacts."""
    corners = np.abs(mockup.part_bounds[np.isfinite(mockup.part_bounds)])
    return least_contact(mockup) + ROUNDOFFS * float(np.spacing(corners.max(initial=0.0)))


def _order(each: Clash) -> tuple[float, ...]:
    """The deepest overlap first, then the smallest gap."""
    is_apart = each.verdict in (Verdict.CLEARANCE, Verdict.CONTACT)
    return (float(is_apart), 0.0 if is_apart else -_finite(each.depth), _finite(each.gap), each.a, each.b)


def _finite(value: float) -> float:
    return value if math.isfinite(value) else 0.0


def _requirements(given: RequirementsLike) -> tuple[Requirement, ...]:
    if isinstance(given, (str, os.PathLike)):
        return read_requirements(given)
    if isinstance(given, Mapping):
        return _parsed(given, "requirements")
    wanted = "a list of feeler.Requirement, a dict, or the path of a file"
    every = check_list("requirements", given, wanted)
    found = tuple(check_kind("requirements", each, Requirement, wanted) for each in every)
    _check_names(found, "requirements")
    return found


def _parsed(data: Mapping[str, object], where: str) -> tuple[Requirement, ...]:
    _check_keys(data, ("version", "requirement"), where)
    check_version(data, where, OptionError)
    tables = data.get("requirement", [])
    if not isinstance(tables, list) or not all(isinstance(each, Mapping) for each in tables):
        raise OptionError(f"{where}: requirement is not a list of tables: write [[requirement]] above each")
    found = tuple(_made(each, f"{where}, requirement {number}") for number, each in enumerate(tables, 1))
    if not found:
        raise OptionError(f"{where} has no requirement: write [[requirement]] with name, a, b and gap")
    _check_names(found, where)
    return found


def _made(table: Mapping[str, Any], where: str) -> Requirement:
    known = [each.name for each in fields(Requirement)]
    _check_keys(table, known, where)
    for name in ("name", "a", "b", "gap"):
        if name not in table:
            raise OptionError(f"{where}: it has no {name}")
    if not isinstance(table.get("optional", False), bool):
        raise OptionError(f"{where}: optional is {shown(table['optional'])}: give true or false")
    try:
        return Requirement(**table)
    except OptionError as error:
        raise OptionError(f"{where}, {error}") from None


def _check_keys(table: Mapping[str, object], known: Iterable[str], where: str) -> None:
    for key in table:
        if key not in known:
            raise OptionError(f"{where}: there is no {shown(key)}: {near(str(key), [*known])}")


def _check_names(found: tuple[Requirement, ...], where: str) -> None:
    names = [each.name for each in found]
    for name in names:
        if names.count(name) > 1:
            raise OptionError(f"{where}: two requirements are called {name!r}: give each a name of its own")
