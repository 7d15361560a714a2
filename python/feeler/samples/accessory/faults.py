"""Ten kinds of faults that can be planted in the gearbox."""

from __future__ import annotations

from collections.abc import Callable, Sequence

from ...errors import OptionError
from .assembly import Assembly, Planted

FAULTS: dict[str, Callable[[Assembly], Planted]] = {}
"""By name, what plants a fault."""


def plant(asm: Assembly, names: Sequence[str]) -> list[Planted]:
    """Plants the named faults; returns what is true of them."""
    for name in names:
        if name not in FAULTS:
            raise OptionError(f"no fault is called {name!r}; choose from {', '.join(FAULTS)}")
    return [FAULTS[name](asm) for name in names]
