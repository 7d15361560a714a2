"""The mechanism of a document, as it is asked: of the scene as it stands, without parts that are out or loose."""

from __future__ import annotations

import tempfile
from collections.abc import Callable, Mapping
from dataclasses import replace
from pathlib import Path
from types import MappingProxyType

import numpy as np

from feeler.errors import FeelerError, WorkbenchError
from feeler.mechanism import files
from feeler.mechanism.joint import JointKind
from feeler.mechanism.mechanism import Mechanism
from feeler.mechanism.positions import Positions, Values
from feeler.progress import Progress
from feeler.scene import Scene
from feeler.workbench.document import motion
from feeler.workbench.document.document import Document, World
from feeler.workbench.document.joints import JointLink, JointNumber, MechanismState, Point, loose
from feeler.workbench.document.motion import HOME, Row
from feeler.workbench.engine.standing import Standing

FILE = "mechanism.toml"
MOST_JOINTS = 200
"""More than a page shows."""
STEP_RAD, STEP_M = np.radians(4.0), 0.05
"""Between two poses of the way of a turn, and of a slide, in the sequence."""


def read_text(text: str, name: str) -> files.Drawn:
    """What the text of a TOML file. Raises `WorkbenchError`, naming the line."""
    with tempfile.TemporaryDirectory(prefix="feeler-mechanism-") as folder:
        path = Path(folder) / FILE
        path.write_text(text, encoding="utf-8", newline="\n")
        try:
            return files.read(path)
        except FeelerError as error:
            raise WorkbenchError(str(error).replace(str(path), name), "mechanism", "see docs/mechanisms.md") from None


def text_of(mechanism: Mechanism) -> str:
    """A mechanism as the text of a TOML file."""
    with tempfile.TemporaryDirectory(prefix="feeler-mechanism-") as folder:
        path = Path(folder) / FILE
        mechanism.save(path)
        return path.read_text(encoding="utf-8")


def state_of(positions: Positions, text: str, name: str, values: Mapping[str, float] | None = None) -> MechanismState:
    """The mechanism of a document, at a position; where it is modelled, as far as limits allow."""
    if len(positions.joints) > MOST_JOINTS:
        raise WorkbenchError(
            f"{name} has {len(positions.joints)} joints, and the page shows {MOST_JOINTS}",
            "mechanism",
            "leave some out",
        )
    links = positions.links.links
    numbers = []
    group = {root: min(roots) for roots, _ in positions.groups for root in roots}
    for link in links:
        joint = link.joint
        for place, (number, turns) in enumerate(zip(joint.names, joint.turns, strict=True)):
            numbers.append(
                JointNumber(
                    number,
                    "turn" if turns else "slide",
                    link.number,
                    positions.driven[number].root,
                    group.get(positions.driven[number].root, positions.driven[number].root),
                    _point(joint.axis),
                    _point(joint.point),
                    joint.pitch if joint.kind is JointKind.SCREW and place == 0 else 0.0,
                    positions.limits(number),
                )
            )
    position = positions.position(values)
    poses = positions.links.poses(position)
    return MechanismState(
        name,
        text,
        tuple(numbers),
        tuple(
            JointLink(link.joint.name, link.above, link.parts, motion.row(poses[link.number]) or HOME) for link in links
        ),
        MappingProxyType(position),
    )


class Heard(Positions):
    """Positions of which each one is heard, so that a long question can be given up."""

    heard: Callable[[], None] = staticmethod(lambda: None)

    def position(self, values: Values | None = None, start: Values | None = None) -> dict[str, float]:
        """As there."""
        self.heard()
        return super().position(values, start)


class Standings:
    """Makes the mechanism of a document, asked of the scene as it stands; the last one is kept. For one thread at a
    time."""

    def __init__(self, scene: Scene) -> None:
        self._scene, self._standing = scene, Standing(scene)
        self._texts: dict[str, files.Drawn] = {}
        self._whole: tuple[str, Positions] | None = None
        self._kept: tuple[object, Heard] | None = None

    def read(self, text: str, name: str) -> files.Drawn:
        """As `read_text`; the last one is kept."""
        if text not in self._texts:
            self._texts = {text: read_text(text, name)}
        return self._texts[text]

    def whole(self, text: str, name: str) -> Positions:
        """The mechanism with all its parts, where they are modelled. Raises `WorkbenchError`."""
        if self._whole is None or self._whole[0] != text:
            drawn = self.read(text, name)
            try:
                made = Positions(
                    self._scene.mockup, drawn.joints, drawn.couplings, drawn.loops, self._scene, drawn.ignore
                )
            except FeelerError as error:
                raise WorkbenchError(f"{name}: {error}", "mechanism", "see docs/mechanisms.md") from None
            self._whole = (text, made)
        return self._whole[1]

    def asked(self, document: Document, progress: Progress | None = None) -> Heard:
        """The mechanism as it is asked. Raises `WorkbenchError` if nothing of it is there."""
        key = asked_key(document)
        if self._kept is None or self._kept[0] != key:
            self._kept = (key, self._made(document, progress))
        return self._kept[1]

    def _made(self, document: Document, progress: Progress | None) -> Heard:
        state = document.mechanism
        if state is None:
            raise WorkbenchError("there is no mechanism", "mechanism", "open one")
        joints, couplings, loops, ignore = self.read(state.text, state.name)
        away = _away(document) | _absent(self._scene)
        base = replace(document, moved=MappingProxyType(rest(document)))
        scene = self._standing.scene(base, progress=progress)
        left = {link.name: [part for part in link.parts if part not in away] for link in state.links}
        above = {link.name: state.links[link.above].name if link.above >= 0 else None for link in state.links}
        # What hangs on a link without parts has nothing to move against.
        gone: set[str] = set()
        for name in left:
            here: str | None = name
            while here is not None:
                if not left[here]:
                    gone.add(name)
                here = above[here]
        kept = [
            replace(joint, child=tuple(left[joint.name]), parent=_parts(left, above[joint.name]))
            for joint in joints
            if joint.name not in gone
        ]
        if not kept:
            raise WorkbenchError("all parts of the mechanism are out", "mechanism", "put one back")
        names = {name for joint in kept for name in joint.names}
        followed = [each for each in couplings if {each.joint, each.of} <= names]
        return Heard(scene.mockup, kept, followed, loops if not gone else [], scene, ignore)


def rest(document: Document) -> dict[int, Row]:
    """Where parts lie that do not go with the links, as far as they are not where they were loaded."""
    state = document.mechanism
    own = frozenset(part for link in state.links for part in link.parts) if state is not None else frozenset()
    away = _away(document)
    return {part: at for part, at in document.moved.items() if part not in own or part in away}


def asked_key(document: Document) -> object:
    """What the mechanism of a document depends on, and not on its position."""
    state = document.mechanism
    base = replace(document, moved=MappingProxyType(rest(document)))
    away = tuple(sorted(_away(document)))
    world: World = base.world
    return (None if state is None else state.text, world, document.out, away)


def given_values(positions: Positions, values: Mapping[str, float], but: str | None = None) -> dict[str, float]:
    """The numbers that give a position: of couplings the first, of loops one; without those that go with `but`."""
    found: dict[str, float] = {}
    taken = {positions.driven[but].root} if but is not None and but in positions.driven else set()
    for group, _ in positions.groups:
        taken |= group if taken & group else set(sorted(group)[1:])
    for name in positions.names:
        root = positions.driven[name].root
        if root not in taken:
            taken.add(root)
            found[root] = values.get(root, 0.0)
    return found


def _away(document: Document) -> frozenset[int]:
    state = document.mechanism
    if state is None:
        return frozenset()
    return loose(state, document.moved, frozenset((*document.out, *document.gripped)))


def _absent(scene: Scene) -> frozenset[int]:
    return frozenset(np.flatnonzero(~scene.part_mask).tolist())


def _parts(left: Mapping[str, list[int]], link: str | None) -> tuple[int, ...] | None:
    return None if link is None else tuple(left[link])


def _point(given: tuple[float, float, float]) -> Point:
    x, y, z = given
    return (float(x), float(y), float(z))
