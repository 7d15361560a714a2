"""Tools in a project: their triangles, so that a project can go on without the files of its tools."""

from __future__ import annotations

import json

import numpy as np

from feeler.errors import FeelerError, LoadError
from feeler.mockup import Tool
from feeler.project.store import Change, Row, put

MOST_BYTES = 64 << 20
"""Larger tools are named only."""
_MOST_PARTS = 100_000


def tool_change(tool: Tool, content: str) -> Change | None:
    """The row of a tool; None if it is too large. content: its hash."""
    arrays = (
        np.ascontiguousarray(tool.vertices, "<f8"),
        np.ascontiguousarray(tool.faces, "<i8"),
        np.ascontiguousarray(tool.part_of_face, "<u4"),
    )
    data = b"".join(array.tobytes() for array in arrays)
    if len(data) > MOST_BYTES or len(tool.part_paths) > _MOST_PARTS:
        return None
    facts = {
        "name": tool.name,
        "hash": content,
        "vertices": len(arrays[0]),
        "triangles": len(arrays[1]),
        "part_names": tool.part_names,
        "part_paths": tool.part_paths,
    }
    return put("tools", json.dumps(tool.name)[1:-1], 0, json.dumps(facts), data)


def tool_of(row: Row, where: str) -> Tool:
    """The tool of a row. Raises `LoadError` for anything else."""
    try:
        facts = json.loads(row.value)
        names, paths = facts["part_names"], facts["part_paths"]
        vertices, triangles, data = facts["vertices"], facts["triangles"], row.data or b""
        if (
            not isinstance(facts["name"], str)
            or not all(type(each) is int and 0 < each <= MOST_BYTES for each in (vertices, triangles))
            or len(data) != 24 * vertices + 28 * triangles
            or not all(isinstance(each, list) and 0 < len(each) <= _MOST_PARTS for each in (names, paths))
            or not all(isinstance(each, str) for each in (*names, *paths))
        ):
            raise ValueError("its sizes do not fit")
        points = np.frombuffer(data, "<f8", 3 * vertices).reshape(-1, 3)
        faces = np.frombuffer(data, "<i8", 3 * triangles, 24 * vertices).reshape(-1, 3)
        part_of_face = np.frombuffer(data, "<u4", triangles, 24 * vertices + 24 * triangles)
        return Tool(points, faces, facts["name"], part_of_face, names, part_paths=paths)
    except (ValueError, TypeError, KeyError, RecursionError, FeelerError) as error:
        raise LoadError(f"{where} is damaged: its tool is not as written ({error!s:.80}); use a copy") from None
