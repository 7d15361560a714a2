"""Mechanisms: links that move by joints, and what is asked of them."""

from __future__ import annotations

import os
from collections.abc import Iterable, Mapping

import numpy as np
import numpy.typing as npt

from feeler._core import Screw
from feeler.arguments import check_kind, check_list, check_number, check_path
from feeler.choices import Geometry
from feeler.errors import LoadError, OptionError
from feeler.io import DEFAULT_CHORD_TOLERANCE
from feeler.mechanism import files
from feeler.mechanism.answers import MechanismClashes, MechanismClearance, Range
from feeler.mechanism.clashing import clashes_of
from feeler.mechanism.coupling import JointCoupling
from feeler.mechanism.gaps import clearance_of
from feeler.mechanism.joint import Joint
from feeler.mechanism.positions import Positions, Values
from feeler.mechanism.ranging import range_of
from feeler.mechanism.robot import read_robot
from feeler.mockup import Mockup
from feeler.parts import PartsLike
from feeler.poses import PoseLike
from feeler.scene import Scene
from feeler.words import plural

Floats = npt.NDArray[np.float64]


class Mechanism:
    """Parts of a mock-up that move by joints. See docs/mechanisms.md.

    joints: a tree of links; children move with their parents. couplings: gears, racks and mimic joints. loops: joints
    between two links that are already in the tree; they close loops, and joints that are not given follow. scene: of
    the mock-up, to ask in place of one of its own. ignore: pairs of parts, each as `Parts.select` takes them, that no
    question looks at, such as `[("pin*", "bracket")]`: a pin that has play in its hole is always near.
    Raises `OptionError` for joints that contradict each other, circles, and parts in two links.
    """

    def __init__(
        self,
        mockup: Mockup,
        joints: Iterable[Joint],
        couplings: Iterable[JointCoupling] = (),
        loops: Iterable[Joint] = (),
        scene: Scene | None = None,
        ignore: Iterable[tuple[PartsLike, PartsLike]] = (),
    ) -> None:
        self._ignore = tuple(check_list("ignore", ignore, "pairs of parts"))
        self._positions = Positions(mockup, joints, couplings, loops, scene, self._ignore)

    def __repr__(self) -> str:
        return f"Mechanism({plural(len(self.joints), 'joint')}: {', '.join(joint.name for joint in self.joints)})"

    @classmethod
    def load(cls, path: str | os.PathLike[str], mockup: Mockup, scene: Scene | None = None) -> Mechanism:
        """A mechanism of a TOML file. Raises `LoadError` for files that say something else, naming the line."""
        where = check_path("path", path)
        check_kind("mockup", mockup, Mockup)
        drawn = files.read(where, mockup)
        try:
            return cls(mockup, drawn.joints, drawn.couplings, drawn.loops, scene, drawn.ignore)
        except OptionError as error:
            raise LoadError(f"{where}: {error}") from None

    @classmethod
    def from_urdf(
        cls,
        path: str | os.PathLike[str],
        *,
        geometry: Geometry = "collision",
        package_dirs: Iterable[str | os.PathLike[str]] | Mapping[str, str | os.PathLike[str]] = (),
        chord_tolerance: float = DEFAULT_CHORD_TOLERANCE,
        around: Mockup | None = None,
        world_from_base: PoseLike | None = None,
        ignore: Iterable[tuple[PartsLike, PartsLike]] = (),
    ) -> Mechanism:
        """A robot, with all joints at 0: as `feeler.from_urdf`, whose parts and options it has, and its joints.

        around: a mock-up that the robot stands in; its parts are in the frame. world_from_base: where the root link
        stands, `(4, 4)`; None: in the origin. ignore: as of the class.

        Revolute, continuous and prismatic joints keep names, limits and axes; axes are in the world. Links that fixed
        joints hold together are one link, and the root is the frame. Joints that mimic others are couplings. A link
        without geometry that moves is a part without triangles. Limits that are both 0 are none.

        Raises `LoadError` for planar and floating joints and files that are no URDF, `MissingFileError` for meshes that
        are not there, `OptionError` for the options.
        """
        mockup, joints, couplings = read_robot(path, geometry, package_dirs, chord_tolerance, around, world_from_base)
        try:
            return cls(mockup, joints, couplings, ignore=ignore)
        except OptionError as error:
            raise LoadError(f"{os.fspath(path)}: {error}") from None

    def save(self, path: str | os.PathLike[str]) -> None:
        """Writes a TOML file that `load` reads. Raises `WriteError`."""
        drawn = files.Drawn(self.joints, self.couplings, self.loops, self.ignore)
        files.write(check_path("path", path), self.mockup, drawn)

    @property
    def mockup(self) -> Mockup:
        """The mock-up whose parts move."""
        return self._positions.mockup

    @property
    def joints(self) -> tuple[Joint, ...]:
        """The joints of the tree."""
        return self._positions.joints

    @property
    def couplings(self) -> tuple[JointCoupling, ...]:
        """What couples them."""
        return self._positions.couplings

    @property
    def loops(self) -> tuple[Joint, ...]:
        """The joints that close loops."""
        return self._positions.loops

    @property
    def ignore(self) -> tuple[tuple[PartsLike, PartsLike], ...]:
        """The pairs of parts that no question looks at, as they were given."""
        return self._ignore

    @property
    def names(self) -> tuple[str, ...]:
        """The names of the numbers of a position, in the order of the joints."""
        return self._positions.names

    def limits(self, name: str) -> tuple[float, float] | None:
        """The limits of a number, those of the numbers coupled with it included; None for none."""
        return self._positions.limits(name)

    def position(self, values: Values | None = None, start: Values | None = None) -> dict[str, float]:
        """All numbers of a position, radians and metres. Those not given follow from couplings and loops, or are
        0, or the limit nearest to it.

        start: where loops are followed from, a position of this mechanism; None: where the parts are modelled.
        Raises `OptionError` outside of limits, `MechanismError` where a loop cannot close or has a dead point.
        """
        return self._positions.position(values, start)

    def poses(self, values: Values | None = None, start: Values | None = None) -> dict[str, Floats]:
        """The pose `(4, 4)` of each moved link, by the name of its joint; the identity is where it is modelled."""
        return self._positions.poses(values, start)

    def chain(self, joint: str, start: Values, end: Values) -> list[Screw | Floats]:
        """The motion of the link of a joint from one position to another, as `Scene.check_path` takes it: a pose, and
        a `Screw` or a pose to slide to.

        Raises `OptionError` if more than one joint moves it, for then its motion is no screw.
        """
        return self._positions.chain(joint, start, end)

    def scene(self, values: Values | None = None, start: Values | None = None) -> Scene:
        """A scene with the parts at a position; parts keep their numbers and names. The last one is kept."""
        return self._positions.scene(values, start)

    def range(self, joint: str, at: Values | None = None) -> Range:
        """How far a joint moves freely both ways, and what it meets first, with the other joints at `at`.

        Parts of joints, couplings and loops that are in contact where they are modelled are seats, as in `removal`, and
        others that only touch there: they may go no deeper. All others are exact. Joints of loops are followed in small
        steps (`is_certified` is false).
        """
        return range_of(self._positions, joint, at)

    def clearance(
        self, values: Mapping[str, float | tuple[float, float]], error: float = 1e-4, most: int = 1_000_000
    ) -> MechanismClearance:
        """Bounds of the least gap over a range of positions, certified, and the worst position.

        values: a number, or the least and greatest, of each joint; without any range, it is of that one position.
        error: the gap of the two bounds at which it ends, metres. most: of several joints, it ends after about
        this many boxes of positions, of which each pair of links takes some at least; what is left then is undecided.
        Pairs of a joint that are in contact where they are modelled are seats,
        and have no gap; where one goes deeper, both bounds are 0, and `jams` names it. Links that do not move against
        each other count too, where they stand; of those that stand as they are modelled, parts that are in contact are
        seats.
        """
        error = check_number("error", error, "metres, more than 0", above=0.0)
        return clearance_of(self._positions, values, error, most)

    def clash(self, values: Mapping[str, float | tuple[float, float]]) -> MechanismClashes:
        """The pairs of parts that clash at some position of one joint and all that follows it, with the first position
        of each from the least value on. Seats clash where they go deeper than where they are modelled. Links that do
        not move against each other are asked once, unless they stand as they are modelled.

        Raises `MechanismError` for a range that passes a dead point of a loop; so does `clearance`.
        """
        return clashes_of(self._positions, values)
