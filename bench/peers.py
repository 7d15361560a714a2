"""The peers, and which of them can be measured on this machine."""

from __future__ import annotations

import importlib
from collections.abc import Sequence

from engines import Engine
from native import AbsentError

# name: module and class. The module's head says how the peer is set up.
PEERS = {
    "coal": ("coal_engine", "CoalEngine"),
    "fcl": ("fcl_engine", "FclEngine"),
    "embree": ("embree_engine", "EmbreeEngine"),
    "parry": ("parry_engine", "ParryEngine"),
}


def find(names: Sequence[str]) -> tuple[list[Engine], dict[str, str]]:
    """The peers of these names that are there; and of the others, why not."""
    there: list[Engine] = []
    absent: dict[str, str] = {}
    for name in names:
        module, engine = PEERS[name]
        try:
            there.append(getattr(importlib.import_module(module), engine)())
        except (ImportError, AbsentError) as error:
            absent[name] = str(error)
    return there, absent
