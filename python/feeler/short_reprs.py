"""Reprs of results: one line, whatever they hold."""

from __future__ import annotations

import dataclasses
from collections.abc import Iterable, Mapping
from typing import Any, TypeVar

import numpy as np

Class = TypeVar("Class", bound=type[Any])

MOST = 100
"""Characters of a field, about."""
_MOST_NUMBERS = 12
"""Longer arrays are told by their shape."""


def shortly(cls: Class) -> Class:
    """Replaces the repr that `@dataclass` makes by one that is bounded. Put it above `@dataclass`; a class with a repr
    of its own says `repr=False` there."""
    if cls.__dataclass_params__.repr:
        cls.__repr__ = _of_fields  # type: ignore[assignment]
    return cls


def _of_fields(self: Any) -> str:
    names = [each.name for each in dataclasses.fields(self) if each.repr]
    return f"{type(self).__qualname__}({', '.join(f'{name}={short(getattr(self, name))}' for name in names)})"


def short(value: object) -> str:
    """A repr of about 100 characters at most, in one line."""
    if isinstance(value, np.ndarray):
        text = repr(value) if value.size <= _MOST_NUMBERS else "\n"
        return f"<array {value.shape} {value.dtype}>" if "\n" in text else text
    if isinstance(value, (tuple, list)) and type(value).__repr__ in (tuple.__repr__, list.__repr__) and value:
        first, last = ("(", ")" if len(value) > 1 else ",)") if isinstance(value, tuple) else "[]"
        return f"{first}{_listed(map(short, value), len(value))}{last}"
    if isinstance(value, Mapping) and value:
        return f"{{{_listed((f'{short(key)}: {short(each)}' for key, each in value.items()), len(value))}}}"
    text = " ".join(repr(value).split())
    return text if len(text) <= MOST else text[: MOST - 3] + "..."


def _listed(items: Iterable[str], count: int) -> str:
    """The first items, and how many there are."""
    told: list[str] = []
    for item in items:
        if told and sum(map(len, told)) + len(item) > MOST - 20:
            return f"{', '.join(told)}, ... {count:,} in all"
        told.append(item)
    return ", ".join(told)
