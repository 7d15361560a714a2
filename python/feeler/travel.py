"""Pickles: how mock-ups, tools, scenes and results reach other processes and files.

An object is pickled as its arrays and names, with the number of this format. NumPy pickles the arrays, so protocol 5
can pass them out of band. A scene includes its mock-up and options and rebuilds its index; a result does not include
the mock-up.
"""

from __future__ import annotations

from collections.abc import Callable
from functools import cache
from importlib.metadata import version
from typing import Any

import numpy as np

from feeler import _core
from feeler.errors import LoadError

FORMAT = 1
"""The version of the format. It changes when old and new versions cannot read each other's pickles."""

State = tuple[Any, ...]


def reduced(kind: str, state: State) -> tuple[Callable[..., object], State]:
    """The result of `__reduce__` for a `kind` of object that consists of `state`."""
    return restore, (FORMAT, _version(), kind, state)


def restore(written_in: int, written_by: str, kind: str, state: State) -> object:
    """The object from its state. Raises `LoadError` if the format differs or no object has such a state."""
    if written_in != FORMAT:
        raise LoadError(
            f"this {kind} was pickled by feeler {written_by} in format {written_in}, but this is feeler {_version()}, "
            f"which reads format {FORMAT}: use one version of feeler on both sides, or send the arrays instead"
        )
    state = _tidy(state)
    if state and isinstance(state[0], type):
        return state[0]._restore(*state[1:])  # type: ignore[attr-defined]  # one of ours, or derived from it
    return _core.restore(kind, state)


def _tidy(state: State) -> State:
    """Arrays as the core reads them; arrays from out-of-band pickles can have any memory layout."""

    def tidy(value: Any) -> Any:
        if isinstance(value, tuple):
            return tuple(tidy(each) for each in value)
        if isinstance(value, np.ndarray):
            return np.require(value, value.dtype.newbyteorder("="), ["C_CONTIGUOUS", "ALIGNED"])
        return value

    return tuple(tidy(value) for value in state)


@cache
def _version() -> str:
    return version("feeler")
