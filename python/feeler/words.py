"""Numbers as text."""

from __future__ import annotations

import math


def length(metres: float) -> str:
    """A length with a suitable unit."""
    if not math.isfinite(metres):
        return "an unknown length"
    for factor, unit in ((1.0, "m"), (1e3, "mm"), (1e6, "µm"), (1e9, "nm")):
        # Rounded first, so that no length reads "1000 µm".
        shown = float(f"{metres * factor:.4g}")
        if abs(shown) >= 1.0:
            return f"{shown:.6g} {unit}"
    return f"{metres:.4g} m"
