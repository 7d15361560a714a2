"""Which pairs of parts a check did not look at, or hid: their earlier findings are not gone."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from feeler.clashes.limits import Hider, Ints, Limits

Floats = npt.NDArray[np.float64]
Mask = npt.NDArray[np.bool_]


@dataclass(frozen=True, eq=False)
class Scope:
    """What a check looked at.

    present: `(parts,)`. skipped: `(classes, classes)`, pairs of classes that no rule asks for. exclude: `(k, 2)` pairs
    of parts that were skipped. reach: `(classes, classes)`, the distance within which a pair was looked for, metres.
    """

    present: Mask
    skipped: Mask
    class_of_part: Ints
    exclude: Ints
    rule_of_classes: npt.NDArray[np.int32]
    hiders: tuple[Hider, ...]
    reach: Floats

    @classmethod
    def of(cls, found: Limits, present: Mask) -> Scope:
        """The scope of a check with these limits."""
        reach = np.maximum(found.clearance, found.contact)
        rows = found.of_classes < 0, found.class_of_part, found.exclude, found.of_classes, found.hiders, reach
        return cls(present.copy(), *rows)

    def leaves_out(self, a: Ints, b: Ints, gaps: Floats) -> Mask:
        """Which findings were not looked for, or hidden: their parts, and their gaps in the earlier check, metres."""
        one, other = self.class_of_part[a], self.class_of_part[b]
        found: Mask = ~(self.present[a] & self.present[b]) | self.skipped[one, other]
        found |= gaps > self.reach[one, other]
        if len(self.exclude):
            count = len(self.present)
            keys = np.sort(self.exclude.astype(np.int64), axis=1) @ np.array([count, 1])
            found |= np.isin(np.minimum(a, b).astype(np.int64) * count + np.maximum(a, b), keys)
        rule = self.rule_of_classes[one, other]
        for hider in self.hiders:
            found |= hider(a, b, rule)
        return found
