"""What counts as a number and as a list in JSON."""

from __future__ import annotations

from typing import Any

LARGEST = 1e9
"""Of lengths and other numbers, metres."""


def is_number(value: Any) -> bool:
    """Whether it is a finite number within the range of lengths."""
    return isinstance(value, (int, float)) and not isinstance(value, bool) and abs(value) <= LARGEST


def is_sequence(value: Any) -> bool:
    """Whether it is a list."""
    return isinstance(value, (list, tuple))
