"""Files of joints that `feeler move --write-mechanism` starts: found from surfaces, or to fill in."""

from __future__ import annotations

import math
import re
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np

import feeler
from feeler.errors import OptionError
from feeler.mechanism.finding import JointError
from feeler.progress import bar
from feeler.words import plural

_STARTED = """# A mechanism of feeler. Lengths are metres, in the world, where the parts are modelled.
# Write joints here; feeler info --parts lists the parts. Limits say their unit: limits_deg, limits_rad or limits_m.

[[joint]]
name = "hinge"
kind = "revolute"          # or prismatic, screw (pitch_m), cylindrical, fixed
# parent = "*frame*"       # without one: the frame, all that no joint moves
child = {child}
axis = [0.0, 0.0, 1.0]
point_m = {point}
limits_deg = [0.0, 90.0]
"""
_CANDIDATES = 3


def write(path: Path, world: feeler.Mockup, children: list[str], parents: list[str]) -> dict[str, Any]:
    """Writes a file, and prints what is in it to stderr; returns it for --json."""
    from rich.console import Console

    from feeler.cli import outputs

    out = Console(stderr=True, highlight=False)
    if not children:
        _template(path, world)
        outputs.say(out, f"a mechanism to fill in was written to {path}")
        return {"joints": []}
    joints = _found(world, children, parents)
    feeler.Mechanism(world, joints).save(path)
    for joint in joints:
        outputs.say(out, f"{joint.name}: {joint.kind}, {joint.because}")
    outputs.say(out, f"{plural(len(joints), 'joint')} written to {path}; add limits, or ask how far they move")
    return {"joints": [_facts(joint) for joint in joints]}


def _facts(joint: feeler.Joint) -> dict[str, Any]:
    return {
        "name": joint.name,
        "kind": str(joint.kind),
        "axis": list(joint.axis),
        "point": list(joint.point),
        "pitch": joint.pitch,
        "because": joint.because,
    }


def _found(world: feeler.Mockup, children: list[str], parents: list[str]) -> list[feeler.Joint]:
    if len(parents) not in (0, 1, len(children)):
        raise OptionError(
            f"there are {len(children)} --child and {len(parents)} --parent: give one parent for each, or one for all"
        )
    moving = [_selected(world, "--child", each) for each in children]
    everything = set(range(world.part_count))
    frame = sorted(everything.difference(*moving))
    joints: list[feeler.Joint] = []
    names: set[str] = set()
    for number, text in enumerate(children):
        above = parents[number if len(parents) > 1 else 0] if parents else None
        parts = frame if above is None else sorted(_selected(world, "--parent", above) - moving[number])
        if not parts:
            raise OptionError(f"--child {text!r} leaves no part to move on: give a narrower one, or a --parent")
        name = _name(text, names)
        names.add(name)
        with bar(f"finding the joint of {text}"):
            try:
                found = feeler.find_joint(world, text, parts, name=name)
            except JointError as error:
                raise JointError(f"--child {text!r}: {error}{_candidates(error)}", error.candidates) from None
        joints.append(replace(found, child=text, parent=above))
    return joints


def _selected(world: feeler.Mockup, option: str, text: str) -> set[int]:
    try:
        return {int(part) for part in world.parts.select(text)}
    except OptionError as error:
        raise OptionError(f"{option}: {error} (feeler info --parts lists all)") from None


def _candidates(error: JointError) -> str:
    rows = [
        f"{each.kind} about or along {_numbers(each.axis)} through {_numbers(each.point)} m"
        for each in error.candidates[:_CANDIDATES]
    ]
    more = len(error.candidates) - len(rows)
    return f"; free are: {'; '.join(rows)}{f'; and {more} more' if more > 0 else ''}" if rows else ""


def _numbers(values: tuple[float, float, float]) -> str:
    return f"({', '.join(f'{round(value, 6) + 0.0:g}' for value in values)})"


def _name(text: str, taken: set[str]) -> str:
    """A name of a joint after its pattern."""
    word = re.sub(r"[^A-Za-z0-9_-]+", "_", text.rstrip("/*").rpartition("/")[2]).strip("_") or "joint"
    name, number = word, 2
    while name in taken:
        name, number = f"{word}_{number}", number + 1
    return name


def _template(path: Path, world: feeler.Mockup) -> None:
    from feeler.atomic import atomic_file
    from feeler.io.toml import quoted

    part = world.parts[0]
    point = [float(value) for value in np.asarray(part.lower)]
    text = _STARTED.format(child=quoted(part.path), point=point if math.isfinite(sum(point)) else [0.0, 0.0, 0.0])
    with atomic_file(path, ".toml") as file:
        file.write(text.encode())
