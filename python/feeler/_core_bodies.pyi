# Bodies that move, each against each: a share of the stub of `feeler._core`, which imports it.

from collections.abc import Mapping, Sequence
from typing import final

import numpy as np
import numpy.typing as npt
from typing_extensions import Self

from feeler.choices import DefectKind
from feeler.poses import PoseLike

@final
class Shape:
    def __new__(
        cls,
        vertices: npt.NDArray[np.float64],
        faces: npt.NDArray[np.uint32],
        memory_limit: int,
    ) -> Self:
        """Vertices `(n, 3)` in metres, faces `(m, 3)`. Solid, so that what lies in it meets it, if it is closed and
        convex."""
    def is_of(self, vertices: npt.NDArray[np.float64], faces: npt.NDArray[np.uint32]) -> bool:
        """Whether it is of these arrays, to the last bit."""
    @property
    def is_solid(self) -> bool:
        """Whether what lies in it meets it."""
    @property
    def defects(self) -> Mapping[DefectKind, tuple[int, Sequence[int]]]:
        """Kind of defect -> count and first ids."""
    @property
    def triangle_count(self) -> int:
        """Triangles given, defective ones included."""

@final
class Bodies:
    def __new__(cls, threads: int | None, memory_limit: int) -> Self:
        """`threads`: how many answer a question; None: as many as there are CPUs. `memory_limit`: the most bytes of an
        answer."""
    def copy(self) -> Bodies:
        """The same bodies in a set of its own."""
    def add(self, shape: Shape, world_from_body: PoseLike) -> int:
        """The number of a new body; numbers of removed ones are used again."""
    def remove(self, body: int) -> None:
        """Removes a body."""
    def set_pose(self, body: int, world_from_body: PoseLike) -> None:
        """Moves a body."""
    def is_meeting(self, *, one: int | None = None, others: Bodies | None = None) -> bool:
        """Whether any bodies meet: each with each, one with each other, or each with those of another set."""
    def meeting(self, *, one: int | None = None, others: Bodies | None = None) -> npt.NDArray[np.uint32]:
        """`(k, 2)`: the pairs of bodies that meet, sorted."""
    def contacts(
        self, *, one: int | None = None, others: Bodies | None = None
    ) -> tuple[npt.NDArray[np.uint32], npt.NDArray[np.uint32], npt.NDArray[np.uint8], npt.NDArray[np.float64]]:
        """Every pair of triangles that meets: bodies `(k, 2)`, triangles `(k, 2)`, the numbers of the kinds `(k,)`,
        points `(k, 3)`.

        The kind is 255 where one body is in the other.
        """
    def closest(
        self, within: float, *, one: int | None = None, others: Bodies | None = None
    ) -> tuple[tuple[int, int], tuple[int, int], float, npt.NDArray[np.float64]] | None:
        """The closest bodies, triangles, distance (metres) and points `(2, 3)`; None if no surfaces are within
        `within`."""
    def deepest(self, *, one: int | None = None, others: Bodies | None = None) -> tuple[tuple[int, int], float] | None:
        """The two bodies that meet, one of them solid, and are deepest in each other, and how deep, metres; None if
        there are none."""
    def depth(self, first: int, second: int, *, others: Bodies | None = None) -> npt.NDArray[np.float64]:
        """The shortest translation found that parts the second of two bodies from the first: `(3,)`, metres, world."""
