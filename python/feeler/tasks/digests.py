"""Digests of what answers depend on."""

from __future__ import annotations

import hashlib
import pickle
from collections.abc import Mapping, Sequence
from dataclasses import fields, is_dataclass
from typing import Any

import numpy as np

from feeler.mockup import Tool
from feeler.plan.fasteners import Fastener


def digest_of(value: Any) -> str:
    """The same text for the same shapes and options."""
    return short(_content(value))


def facts_of(row: Fastener | None) -> list[Any]:
    """What questions know of a fastener."""
    if row is None:
        return []
    return [row.kind, row.drive, *_sizes_of(row), row.frame.tolist()]


def _sizes_of(row: Fastener) -> list[float]:
    return [row.size, row.across_flats, row.width, row.length, row.head_height]


def short(data: bytes) -> str:
    """The digest of bytes, 24 letters."""
    return hashlib.blake2b(data, digest_size=12).hexdigest()


def _content(value: Any) -> bytes:
    if isinstance(value, Tool):
        return _content([value.name, value.vertices, value.faces, value.part_of_face])
    if isinstance(value, np.ndarray):
        return repr((value.shape, value.dtype.str)).encode() + np.ascontiguousarray(value).tobytes()
    if isinstance(value, Mapping):
        return b"{" + b",".join(_content(each) for item in value.items() for each in item) + b"}"
    if isinstance(value, Sequence) and not isinstance(value, (str, bytes)):
        return b"[" + b",".join(_content(each) for each in value) + b"]"
    if value is None or isinstance(value, (str, int, float, bool)):
        return repr(value).encode()
    if is_dataclass(value):
        each = b",".join(_content(getattr(value, field.name)) for field in fields(value))
        return type(value).__qualname__.encode() + b"(" + each + b")"
    return pickle.dumps(value, protocol=4)
