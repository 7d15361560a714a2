"""Collisions summarised by part."""

from __future__ import annotations

from typing import Any

import numpy as np

import feeler

_SHOWN_PARTS = 5


def kind_counts(kinds: Any) -> dict[str, int]:
    """The number of pairs of each kind."""
    values = np.asarray(kinds)
    return {kind.value: int(np.count_nonzero(values == kind.code)) for kind in feeler.PairKind}


def part_findings(mockup: feeler.Mockup, tool: feeler.Tool, pairs: Any, kinds: Any) -> list[dict[str, Any]]:
    """One entry per part that is hit, most pairs first; with the colliding parts of the tool.

    pairs: (k, 2) (tool triangle, mock-up triangle); kinds: (k,).
    """
    pairs, kinds = np.asarray(pairs).reshape(-1, 2).astype(np.int64), np.asarray(kinds)
    part = np.asarray(mockup.part_of_face)[pairs[:, 1]].astype(np.int64)
    order = np.argsort(part, kind="stable")
    pairs, kinds, part = pairs[order], kinds[order], part[order]
    begins = np.flatnonzero(np.diff(part, prepend=-1))
    found = []
    for begin, end in zip(begins, [*begins[1:], len(part)], strict=True):
        index = int(part[begin])
        here = pairs[begin:end]
        found.append(
            {
                "part": index,
                "path": mockup.part_paths[index],
                "name": mockup.part_names[index],
                "pairs": int(end - begin),
                "mockup_triangles": len(np.unique(here[:, 1])),
                "tool_triangles": len(np.unique(here[:, 0])),
                "tool_parts": [tool.part_paths[i] for i in np.unique(np.asarray(tool.part_of_face)[here[:, 0]])],
                "kinds": kind_counts(kinds[begin:end]),
            }
        )
    return sorted(found, key=lambda entry: (-entry["pairs"], entry["part"]))


def part_names(mockup: feeler.Mockup, parts: Any) -> list[dict[str, Any]]:
    """Parts by index, path and name."""
    return [{"part": int(i), "path": mockup.part_paths[i], "name": mockup.part_names[i]} for i in parts]


def containment_facts(mockup: feeler.Mockup, found: feeler.Containment) -> dict[str, Any]:
    """Containment as JSON values."""
    return {
        "containing": part_names(mockup, found.containing),
        "contained": part_names(mockup, found.contained),
        "unknown": part_names(mockup, found.unknown),
    }


def containment_lines(facts: dict[str, Any]) -> list[str]:
    """Containment in words; without undecided parts."""
    lines = []
    if facts["containing"]:
        lines.append(f"the tool is inside {_named(facts['containing'])}")
    if facts["contained"]:
        lines.append(f"inside the tool: {_named(facts['contained'])}")
    return lines


def unknown_lines(facts: dict[str, Any]) -> list[str]:
    """Undecided parts in words."""
    if not facts["unknown"]:
        return []
    return [f"containment not known, because these parts are open: {_named(facts['unknown'])}"]


def _named(parts: list[dict[str, Any]]) -> str:
    shown = ", ".join(part["path"] for part in parts[:_SHOWN_PARTS])
    return shown + (f" and {len(parts) - _SHOWN_PARTS:,} more" if len(parts) > _SHOWN_PARTS else "")


def mesh_facts(mesh: feeler.Mockup | feeler.Tool) -> dict[str, Any]:
    """The load report as JSON values."""
    facts: dict[str, Any] = mesh.report.to_dict()
    if isinstance(mesh, feeler.Tool):
        facts["name"] = mesh.name
    return facts


def scene_facts(scene: feeler.Scene) -> dict[str, Any]:
    """Cell size, build time and memory."""
    memory = dict(scene.memory())
    return {
        "storage": scene.storage,
        "voxel_size_m": scene.voxel_size,
        "build_s": scene.build_seconds,
        "memory_bytes": memory,
        "bytes_per_triangle": memory["total"] / max(scene.mockup.triangle_count, 1),
    }
