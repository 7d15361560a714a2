"""Reads the animation of a GLB film back."""

from __future__ import annotations

import json
import struct
from collections.abc import Mapping
from pathlib import Path
from typing import Any

import numpy as np
import numpy.typing as npt

Floats = npt.NDArray[np.float64]
Track = tuple[Floats, Floats]


def animations(path: Path) -> dict[str, Track]:
    """By the name of a node: times `(k,)`, seconds, and places `(k, 3)`, metres."""
    data = path.read_bytes()
    (count,) = struct.unpack_from("<I", data, 12)
    document, body = json.loads(data[20 : 20 + count]), data[28 + count :]
    (film,) = document["animations"]
    found = {}
    for channel in film["channels"]:
        if channel["target"]["path"] == "translation":
            sampler = film["samplers"][channel["sampler"]]
            name = document["nodes"][channel["target"]["node"]]["name"]
            found[name] = (_read(document, body, sampler["input"])[:, 0], _read(document, body, sampler["output"]))
    return found


def moved_nodes(film: Mapping[str, Track]) -> list[str]:
    """The nodes that are not always at one place."""
    return [name for name, (_, places) in film.items() if np.ptp(places, axis=0).max() > 1e-6]


def _read(document: Any, body: bytes, number: int) -> Floats:
    accessor = document["accessors"][number]
    view = document["bufferViews"][accessor["bufferView"]]
    width = {"SCALAR": 1, "VEC3": 3, "VEC4": 4}[accessor["type"]]
    start = view.get("byteOffset", 0) + accessor.get("byteOffset", 0)
    values = np.frombuffer(body, np.float32, accessor["count"] * width, start)
    return values.reshape(-1, width).astype(np.float64)
