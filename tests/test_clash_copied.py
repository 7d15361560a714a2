"""An approval never goes to a copy of an assembly while the original is there."""

from __future__ import annotations

import random
from collections.abc import Callable
from dataclasses import dataclass, replace

import numpy as np
import pytest
from shapes import Mesh, box
from test_clash_matching import checked, cylinder, named, shifted

import feeler
from feeler.clashes.matching import matched
from feeler.clashes.shapes import shapes_of

PLATE = box((-1, -0.5, -0.05), (1, 0.5, 0.05))
BOLTS: tuple[Mesh, ...] = (
    cylinder(24, (0, 0, -0.15), 0.03, 0.3),
    cylinder(16, (0, 0, -0.1), 0.05, 0.2),
    box((-0.03, -0.035, -0.125), (0.03, 0.035, 0.125)),
)
LONGER = cylinder(24, (0, 0, -0.2), 0.03, 0.4)
COPY = (0.0, 7.3, 0.0)


@dataclass(frozen=True)
class Part:
    """A part of a random assembly. who: its sub-assembly and number in the first revision. copy: the number of the
    copy, 0 for the original."""

    who: tuple[int, int]
    path: tuple[str, ...]
    mesh: Mesh
    at: tuple[float, ...]
    copy: int = 0

    def moved(self, by: tuple[float, ...]) -> Part:
        return replace(self, at=tuple(np.add(self.at, by).tolist()))

    def step(self, place: int, name: str) -> Part:
        return replace(self, path=tuple(name if step == self.path[place] else step for step in self.path))


def mockup(parts: list[Part]) -> feeler.Mockup:
    return named([("/".join(part.path), shifted(part.mesh, part.at)) for part in parts])


def assembly(rng: random.Random) -> list[Part]:
    """One to three plates with bolts through them, of unique or equal names, perhaps beside a frame."""
    parts = []
    kinds, count = rng.randint(1, 3), rng.randint(4, 9)
    for sub in range(rng.randint(1, 3)):
        parts.append(Part((sub, 0), ("root", f"sub{sub}", "plate"), PLATE, (3.0 * sub, 0.0, 0.0)))
        for i in range(count):
            name = rng.choice(["bolt", f"bolt_{i}"])
            at = (3.0 * sub - 0.9 + 1.8 * i / count + rng.uniform(-0.01, 0.01), rng.uniform(-0.4, 0.4), 0.0)
            parts.append(Part((sub, i + 1), ("root", f"sub{sub}", name), BOLTS[rng.randrange(kinds)], at))
    if rng.random() < 0.3:
        beams = [box((0, 0, 0), (0.1, 0.1, 1 + 0.1 * i)) for i in range(12)]
        parts += [Part((-1, i), ("root", "frame", f"beam_{i}"), beam, (-5.0 - i, 0, 0)) for i, beam in enumerate(beams)]
    return parts


def renamed(parts: list[Part], rng: random.Random) -> list[Part]:
    how = rng.randrange(5)
    if how == 0:
        return [part.step(0, "v2") for part in parts]
    if how == 1:
        return [replace(part, path=("root", "level", *part.path[1:])) for part in parts]
    if how == 2:
        return [replace(part, path=(*part.path[:-1], part.path[-1] + "_A")) for part in parts]
    if how == 3:
        return [part.step(-2, "other") if part.who[0] == 0 else part for part in parts]
    return rng.sample(parts, len(parts))


def less(parts: list[Part], rng: random.Random) -> list[Part]:
    """One or two bolts of the first sub-assembly are gone, or one is longer."""
    bolts = [part for part in parts if part.who[0] == 0 and part.who[1]]
    if rng.random() < 0.3:
        longer = rng.choice(bolts)
        return [replace(part, mesh=LONGER) if part is longer else part for part in parts]
    gone = rng.sample(bolts, rng.randint(1, 2))
    return [part for part in parts if part not in gone]


def copied(parts: list[Part], number: int, name: str, rng: random.Random) -> list[Part]:
    copies = [
        replace(part.moved((0.0, 7.3 * number, 0.0)), copy=number).step(-2, part.path[-2] + name)
        for part in parts
        if part.who[0] == 0 and not part.copy
    ]
    return copies + parts if rng.random() < 0.5 else parts + copies


@pytest.mark.parametrize("start", range(0, 200, 50))
def test_no_copy_takes_what_is_of_the_original(start: int) -> None:
    """Copies, deletions, shifts and other names at random. Where paths or places tell the copy, nothing is lost."""
    for seed in range(start, start + 50):
        rng = random.Random(seed)
        before = assembly(rng)
        now = before
        is_shifted = rng.random() < 0.5
        for number in range(1, rng.randint(1, 2) + 1):
            now = copied(now, number, rng.choice(["", f"_copy{number}"]), rng)
        now = [part for part in now if part.copy] + less([part for part in now if not part.copy], rng)
        if rng.random() < 0.5:
            now.sort(key=lambda part: part.copy)
        for _ in range(rng.randint(0, 2)):
            now = renamed(now, rng)
        if is_shifted:
            by = tuple(rng.uniform(-5, 5) for _ in range(3))
            now = [part.moved(by) for part in now]
        match = matched(shapes_of(mockup(before)), shapes_of(mockup(now)))
        paths = [{part.path for part in now if bool(part.copy) == is_copy} for is_copy in (False, True)]
        is_told = not is_shifted or not paths[0] & paths[1]
        here = {part.who for part in now if not part.copy and part.mesh is not LONGER}
        plates = {part.who[0]: int(match.new_of_old[n]) for n, part in enumerate(before) if not part.who[1]}
        for n, part in enumerate(before):
            new = int(match.new_of_old[n])
            pair = new, plates.get(part.who[0], new)
            if part.who[0] < 0 or min(pair) < 0:
                assert not is_told or min(pair) >= 0 or part.who not in here, (seed, part.path)
                continue
            assert not (now[pair[0]].copy and now[pair[1]].copy), (seed, part.path, now[new].path)
            if part.who in here and not now[pair[1]].copy and not now[new].copy:
                assert now[new].who == part.who, (seed, part.path, now[new].path)


# --- one plate, five bolts --------------------------------------------------------------------------------------------

PLACES = (-0.8, -0.5, -0.1, 0.3, 0.75)


def sub(name: str = "sub", at: tuple[float, ...] = (0, 0, 0), first: int = 0, *, is_equal: bool = False) -> list[Part]:
    """The sub-assembly from its bolt `first` on."""
    plate = Part((0, 0), ("root", name, "plate"), PLATE, at)
    bolts = [
        Part((0, i + 1), ("root", name, "bolt" if is_equal else f"bolt_{i}"), BOLTS[0], (x, 0.1 * i, 0))
        for i, x in enumerate(PLACES)
    ]
    return [plate, *(bolt.moved(at) for bolt in bolts[first:])]


def suffixed(parts: list[Part]) -> list[Part]:
    return [replace(part, path=(*part.path[:-1], part.path[-1] + "_A")) for part in parts]


def below(*steps: str) -> Callable[[list[Part]], list[Part]]:
    return lambda parts: [replace(part, path=(*steps, *part.path[1:])) for part in parts]


def as_before(parts: list[Part]) -> list[Part]:
    return parts


NAMES = {"same": as_before, "suffix": suffixed, "root": below("v2"), "level": below("root", "level")}


@pytest.mark.parametrize("is_equal", [False, True])
@pytest.mark.parametrize("by", [(0.0, 0.0, 0.0), (1.1, 0.0, 0.0)])
@pytest.mark.parametrize("name", NAMES)
def test_approvals_stay_with_the_original(name: str, by: tuple[float, ...], is_equal: bool) -> None:
    """The copy is whole, and a bolt of the original is gone or longer."""
    before = checked(mockup(sub(is_equal=is_equal)))
    for row in before:
        before.set_status(row.id, "approved", note="original")
    copy = sub("sub_copy", tuple(np.add(COPY, by)), is_equal=is_equal)
    plate, bolt, *others = sub(at=by, is_equal=is_equal)
    for original in ([plate, *others], [plate, replace(bolt, mesh=LONGER), *others]):
        for parts in (original + copy, copy + original):
            now = checked(mockup(NAMES[name](parts)))
            now.diff(before, growth=1.0)
            for row in now:
                if "sub_copy" in row.path_a:
                    assert (row.status, row.note) == ("new", "")
            kept = [row for row in now if row.note]
            assert len(kept) >= 4 and {row.status for row in kept} == {"approved"}


@pytest.mark.parametrize("gone", [0, 1, 4])
def test_what_nothing_tells_apart_gets_nothing(gone: int) -> None:
    """The whole is shifted, and the copy has the same names: either may be the original."""
    before = checked(mockup(sub()))
    for row in before:
        before.set_status(row.id, "approved")
    parts = below("v2")([*sub(at=(1.1, 0, 0), first=gone), *sub(at=(1.1, 7.3, 0))])
    now = checked(mockup(parts))
    change = now.diff(before)
    assert {row.status for row in now} == {"new"}
    assert change.parts.ambiguous == 6 and change.parts.is_doubtful
    assert "6 match two copies equally well, and so neither" in str(change.parts)


def test_new_bolts_of_a_pattern_are_no_copy() -> None:
    """The plate is there once, so it says which bolts are the old ones."""
    before = shapes_of(mockup(sub(is_equal=True)))
    moved = below("v2")(sub(at=(0.36, 0, 0), first=2, is_equal=True))
    beside = [part.moved((0, 0.15, 0)) for part in moved[1:]]
    found = matched(before, shapes_of(mockup([*beside, *moved]))).new_of_old
    assert found.tolist() == [3, -1, -1, 4, 5, 6]


def test_names_that_are_exchanged_in_place_move_nothing() -> None:
    one, other = sub("left"), sub("right", (3, 0, 0))
    before = shapes_of(mockup(one + other))
    now = shapes_of(mockup(sub("right", first=1) + sub("left", (3, 0, 0))))
    assert matched(before, now).new_of_old.tolist() == [0, -1, *range(1, 11)]


def test_a_copy_of_one_sub_assembly_is_none_of_the_whole() -> None:
    """Names say nothing, and the other sub-assembly is there once."""
    before = sub("left") + sub("right", (3, 0, 0))
    shift = (0.3, 0.7, -2.0)
    now = [*sub("left", COPY), *sub("left", first=1), *sub("right", (3, 0, 0))]
    for has_unique in (False, True):
        # A bolt of a shape of its own is in the copy alone.
        old, new = [list(parts) for parts in (before, now)]
        if has_unique:
            old[1], new[1] = replace(old[1], mesh=LONGER), replace(new[1], mesh=LONGER)
        moved = below("v2")([part.moved(shift) for part in new])
        found = matched(shapes_of(mockup(old)), shapes_of(mockup(moved)))
        assert found.new_of_old[[0, *range(2, 12)]].tolist() == [6, *range(7, 17)] and not found.is_ambiguous.any()
