"""The sample mock-ups: six in the roles of the paper's Table 1, and a gearbox with known facts."""

from __future__ import annotations

import zlib
from collections.abc import Callable, Iterable
from typing import Final

import numpy as np

from feeler.arguments import check_progress, check_word
from feeler.choices import Fault, SampleName
from feeler.progress import Progress

from ..errors import OptionError
from ..mockup import Mockup
from ..source import Source
from . import accessory
from . import core_engine as core
from .carcass import add_carcass
from .core_engine import Amount
from .externals import Dresser
from .gearbox import add_differential
from .layout import Surface
from .mesh import MeshParts
from .nacelle import add_fan, add_nacelle
from .plan import Plan

GEARBOX: Final = "gearbox"
LEAST_TRIANGLES = 10_000
MOST_TRIANGLES = 100_000_000
# For small mock-ups the vertex grid would limit the tessellation.
MOST_BY_NAME = {"differential": 20_000_000, "gearbox": 4_000_000}


def sample(
    name: SampleName,
    triangles: int = 1_600_000,
    seed: int = 0,
    *,
    faults: Iterable[Fault] = (),
    progress: Progress | None = None,
) -> Mockup:
    """A built-in mock-up: CAD-like, made of hundreds to thousands of named parts.

    `name`, after the paper's Table 1: "carcass" (nested engine casings, flanges, bolts, panels), "differential" (bevel
    and spur gears, bearings, housing; 0.8 m), "turbine" (bladed disks, shafts, casings), "externals" (pipes, clamps,
    harness, boxes, gearbox), "engine" (an aero-engine's core, dressed; 3 m) or "tay" (a turbofan in its nacelle; 4 m).
    Also "gearbox": an engine's accessory gearbox on its bracket, 0.45 m, modelled like real ones: every fit is named,
    no other parts touch, and `feeler.sample_truth` has the expected results.
    `triangles`: the size, from 10 thousand to 100 million ("differential", which has few parts: 20 million; "gearbox":
    from about 40 thousand to 4 million); the result is within 10 % (mostly 1 %) of it, never above. The number of parts
    grows with its square root, except for the gearbox. `seed`: another arrangement of pipes, cables, boxes; for the
    gearbox other teeth and places. `faults`: to plant in the gearbox, names of `feeler.samples.FAULTS`; the parts that
    they add come on top of `triangles`, and all others stay the same.
    `progress(fraction, stage)` is called from time to time.

    Metres, right-handed, the engine's axis along z, front at z = 0, gearbox towards -y. The sample "gearbox" stands
    alone: its shafts along z, the front case towards -z, and y up, as in `source.up`. Parts are closed shells facing
    outwards; a part may have several shells, and parts may overlap a little where real ones are welded or pressed
    together. The same arguments give the same bytes. Every coordinate is exact in single precision, so STL and GLB keep
    it. Time is about linear: 1.6 million triangles take a second or two, 10 million a few.

    Raises OptionError for an unknown name, a size out of range or a negative seed, LimitError for a size that the named
    mock-up cannot be tessellated to.
    """
    check_progress(progress)
    names = _names(faults)  # once: an iterator has no second time
    part = progress and (lambda share, stage: progress(0.75 * share, stage))
    parts = _sample_parts(name, triangles, seed, names, part)
    if progress:
        progress(0.75, "checking triangles")
    mockup = Mockup(
        parts.vertices,
        parts.faces,
        parts.part_of_face,
        parts.part_names,
        part_paths=parts.part_paths,
        source=Source(
            format="sample",
            unit_source="samples are metres",
            notes=(f"{name}, seed {seed}" + _planted(names),),
            up="y" if name == GEARBOX else None,
        ),
    )
    mockup.part_colours = parts.colours
    if progress:
        progress(1.0, "done")
    return mockup


def _planted(faults: tuple[str, ...]) -> str:
    return f", with the fault{'s' * (len(faults) > 1)} {', '.join(faults)}" if faults else ""


def sample_names() -> tuple[SampleName, ...]:
    """The names that `sample` knows."""
    return (*_MAKERS, GEARBOX)


def sample_truth(
    name: SampleName, triangles: int = 1_600_000, seed: int = 0, *, faults: Iterable[Fault] = ()
) -> accessory.Truth:
    """The known facts of the sample "gearbox" with the same arguments: fits, removal paths, what holds what, tools,
    joints, masses, faults.

    `.to_json()` gives them as JSON. Other samples have none: their parts overlap by chance.

    Raises OptionError as `sample` does.
    """
    check_word("name", name, sample_names())
    if name != GEARBOX:
        raise OptionError(f"the sample {name!r} has no truth; the one that has it is {GEARBOX!r}")
    wanted, number = _checked(name, triangles, seed)
    return accessory.gearbox_truth(wanted, number, _names(faults))


def sample_parts(
    name: SampleName,
    triangles: int = 1_600_000,
    seed: int = 0,
    *,
    faults: Iterable[Fault] = (),
    progress: Progress | None = None,
) -> MeshParts:
    """The result of `sample` as plain arrays; see there."""
    return _sample_parts(name, triangles, seed, _names(faults), progress)


def _sample_parts(
    name: SampleName, triangles: int, seed: int, names: tuple[str, ...], progress: Progress | None
) -> MeshParts:
    wanted, number = _checked(name, triangles, seed)
    if name == GEARBOX:
        return accessory.gearbox_parts(wanted, number, names, progress)
    if names:
        raise OptionError(f"the sample {name!r} has no faults to plant; the one that has them is {GEARBOX!r}")
    make, reference = _MAKERS[name]
    richness = (wanted / reference) ** 0.5
    for _ in range(24):
        words = [number & 0xFFFFFFFF, number >> 32, zlib.crc32(name.encode())]
        plan = Plan(name, np.random.Generator(np.random.PCG64(np.random.SeedSequence(words))))
        make(plan, Amount(richness))
        if plan.least_count() <= 0.97 * wanted:
            return plan.build(wanted, progress)
        richness *= 0.85  # too many parts for so few triangles
    raise OptionError(f"{name} cannot be made of only {wanted} triangles; ask for more")


def _checked(name: str, triangles: object, seed: object) -> tuple[int, int]:
    check_word("name", name, sample_names())
    wanted = _whole(triangles, "triangles")
    most = MOST_BY_NAME.get(name, MOST_TRIANGLES)
    if wanted > most or (wanted < LEAST_TRIANGLES and name != GEARBOX):  # the gearbox has its own minimum
        least = "about 40000" if name == GEARBOX else LEAST_TRIANGLES
        raise OptionError(f"triangles is {triangles}; the sample {name!r} has from {least} to {most}")
    number = _whole(seed, "seed")
    if number < 0:
        raise OptionError(f"seed is {seed}; give a whole number from 0")
    return wanted, number


def _whole(value: object, name: str) -> int:
    if isinstance(value, (float, np.floating)) and np.isfinite(value) and value == np.floor(value):
        return int(value)
    if isinstance(value, bool) or not isinstance(value, (int, np.integer)):
        raise OptionError(f"{name} is {value!r}; give a whole number")
    return int(value)


def _carcass(plan: Plan, amount: Amount) -> None:
    core.add_casings(plan, amount)
    core.add_frames(plan, amount)
    add_carcass(plan, amount)


def _turbine(plan: Plan, amount: Amount) -> None:
    core.add_turbines(plan, amount, extra_stages=2)
    core.add_shafts(plan, amount)
    core.add_exhaust(plan, amount)
    for row in core.OUTER[6:]:
        core.add_outer(plan, amount, row)


def _dress(plan: Plan, amount: Amount, surface: Surface, z_range: tuple[float, float], gearbox_z: float) -> None:
    dresser = Dresser(plan, surface, "externals", z_range, amount.rich, not amount.tiny)
    dresser.gearbox(gearbox_z, amount.many(9, 2, 14, 0.4))
    dresser.boxes(amount.many(9, 1, 24, 0.6))
    dresser.valves(amount.many(10, 1, 40))
    dresser.pipes(amount.many(110, 3, 500, 0.85))
    dresser.harness(amount.many(32, 1, 160))
    dresser.bosses(amount.many(70, 3, 400))
    dresser.rails(amount.many(6, 2, 10, 0.3))
    dresser.rivets(amount.many(1200, 240, 6000))


def _externals(plan: Plan, amount: Amount) -> None:
    _dress(plan, amount, core.outer_surface(), (0.1, 2.8), 0.9)


def _engine(plan: Plan, amount: Amount) -> None:
    core.add_casings(plan, amount)
    core.add_frames(plan, amount)
    core.add_compressors(plan, amount)
    core.add_combustor(plan, amount)
    core.add_turbines(plan, amount)
    core.add_shafts(plan, amount)
    core.add_exhaust(plan, amount)
    _dress(plan, amount, core.outer_surface(), (0.1, 2.8), 0.9)


def _tay(plan: Plan, amount: Amount) -> None:
    _engine(plan, amount)
    add_fan(plan, amount)
    add_nacelle(plan, amount)


# how each is made, and the triangle count at which its richness is 1: the engine then has about 4,300 parts at 1.6
# million triangles
_MAKERS: dict[SampleName, tuple[Callable[[Plan, Amount], None], float]] = {
    "carcass": (_carcass, 0.5e6),
    "differential": (add_differential, 0.3e6),
    "turbine": (_turbine, 0.8e6),
    "externals": (_externals, 0.7e6),
    "engine": (_engine, 5.2e6),
    "tay": (_tay, 6.5e6),
}


def _names(faults: object) -> tuple[str, ...]:
    """The names of faults, each once, in the order of `FAULTS`: unknown ones last.

    Raises `OptionError` for anything but texts.
    """
    if isinstance(faults, Iterable) and not isinstance(faults, (str, bytes)) and getattr(faults, "ndim", 1) == 1:
        names = list(faults)
        if all(isinstance(name, str) for name in names):
            known = list(accessory.FAULTS)
            order = [*known, *sorted({*map(str, names)} - {*known})]
            return tuple(name for name in order if name in names)
    raise OptionError(f"faults is {faults!r}: give a list of names, of {', '.join(accessory.FAULTS)}")
