"""Where a mesh came from."""

from __future__ import annotations

from dataclasses import dataclass
from typing import cast

from feeler.choices import UpAxis
from feeler.field_docs import documented
from feeler.short_reprs import shortly


@shortly
@documented
@dataclass(frozen=True)
class Source:
    """Where a mesh came from, as reported by its loader.

    up: the axis that points up, "x", "y" or "z"; None if unknown. doubts: those notes that put results in doubt:
    skipped files, an implausible size or inconsistent axes. chord_tolerance: the chordal error, metres; None if
    unknown. rounding: the largest rounding error of a coordinate in the files, metres; 0 for double precision and
    arrays. In text it follows from the digits; numbers of less than six digits count as exact, and
    whole numbers too, unless longer ones all end with zeros and shorter ones do not. In glTF, COLLADA, 3MF and STEP
    it has the rounding of placements, which grows with the distance of a part from the origins of its assemblies.
    """

    files: tuple[str, ...] = ()
    format: str = "arrays"
    """Of the files; "arrays" if there are none."""
    unit: str = "m"
    """Of their numbers: "mm", "m", ..."""
    unit_source: str = "arrays are metres"
    """Why it is that unit."""
    seconds: float = 0.0
    """How long reading took."""
    notes: tuple[str, ...] = ()
    up: str | None = None
    doubts: tuple[str, ...] = ()
    chord_tolerance: float | None = None
    rounding: float = 0.0

    @property
    def vertical(self) -> UpAxis:
        """The axis that is drawn upright: `up`, or z if it is unknown."""
        return cast(UpAxis, self.up or "z")
