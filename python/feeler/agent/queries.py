"""Tools that answer at once: the mock-up and its parts, and queries of a tool at a pose, on a path, and of rays."""

from __future__ import annotations

import re
from collections import Counter
from itertools import islice
from typing import Any

import numpy as np

from feeler._core import Containment
from feeler.agent.answers import AT_MOST, ESTIMATE, EXACT, assembly_name, part_name, part_names, point
from feeler.agent.job import Job
from feeler.agent.served import SAMPLE, Served
from feeler.choices import SAMPLE_TOOL_NAMES
from feeler.errors import FeelerError, OptionError
from feeler.mockup import Mockup, Tool
from feeler.scene import PairKind

Given = dict[str, Any]
Answer = dict[str, Any]

MOST_MEASURED = 100_000
"""The most colliding pairs at a pose whose depth is measured: more are a tool that is far inside, and take long."""
MOST_ROWS = 2_000
"""The most rows that are made of one answer, from the offset on; some fifty fit into it."""


def info(served: Served, _given: Given, _job: Job) -> Answer:
    """The mock-up, and the tools."""
    report, there = served.mockup.report, served.scene.part_mask
    return {
        "mockup": list(served.named),
        "format": report.source.format,
        "unit_of_files": report.source.unit,
        "up": report.source.up,
        "parts": int(np.count_nonzero(there)),
        "parts_left_out": int(np.count_nonzero(~there)),
        "triangles": report.triangles,
        "lower_m": point(report.lower),
        "upper_m": point(report.upper),
        "defects": {kind: defect.count for kind, defect in report.defects.items() if defect.count},
        "doubts": [doubt[:300] for doubt in report.source.doubts],
        "tools": [_tool_facts(name, tool) for name, tool in served.tools.items()],
        "sample_tools": [SAMPLE + name for name in SAMPLE_TOOL_NAMES],
    }


def _tool_facts(name: str, tool: Tool) -> Answer:
    lower, upper = tool.bounds
    return {"tool": name, "triangles": tool.triangle_count, "lower_m": point(lower), "upper_m": point(upper)}


def parts(served: Served, given: Given, _job: Job) -> Answer:
    """The parts that match a pattern, or the assemblies at a level."""
    mockup, there = served.mockup, served.scene.part_mask
    pattern, level, offset = given["pattern"], given["level"], given["offset"]
    chosen = np.flatnonzero(there) if pattern is None else served.present("pattern", pattern)
    if level is not None:
        paths = ["/".join(mockup.part_paths[part].split("/")[:level]) for part in chosen.tolist()]
        counts, first = Counter(paths), dict(zip(reversed(paths), reversed(chosen.tolist()), strict=True))
        rows = [
            {"assembly": assembly_name(mockup, first[path], level), "parts": count}
            for path, count in sorted(counts.items())
        ]
        return {"count": len(chosen), "rows": rows[offset : offset + MOST_ROWS]}
    order = chosen.tolist()
    bounds = np.asarray(mockup.part_bounds).reshape(-1, 2, 3)
    size = np.linalg.norm(bounds[:, 1] - bounds[:, 0], axis=1)
    if given["sort"] == "size":
        order.sort(key=lambda part: -size[part])
    return {"count": len(order), "rows": [_part_facts(mockup, part) for part in order[offset : offset + MOST_ROWS]]}


def _part_facts(mockup: Mockup, index: int) -> Answer:
    part = mockup.parts[index]
    return {
        "part": part_name(mockup, index),
        "triangles": part.triangles,
        "lower_m": point(part.lower),
        "upper_m": point(part.upper),
    }


def pose_of(given: Given) -> Any:
    """The pose of the moving body; parts of the mock-up may stay where they are."""
    if given["pose"] is not None:
        return given["pose"]
    if given["part"] is not None:
        return np.eye(4)
    raise OptionError('the tool has no pose: give pose, such as {"at_m": [0.1, 0, 0.2], "rotate_deg": [0, 90, 0]}')


def containment(mockup: Mockup, found: Containment) -> Answer:
    """The parts around the moving body, and inside it."""
    answer: Answer = {}
    for name, which in (("inside", found.containing), ("contains", found.contained), ("undecided", found.unknown)):
        if len(which):
            answer[name] = {"count": len(which), "first": part_names(mockup, which)}
    return answer


def collide(served: Served, given: Given, job: Job) -> Answer:
    """What the moving body hits at a pose, and how deep."""
    pose = pose_of(given)
    scene, tool = served.moving(given)
    mockup = scene.mockup
    batch = scene.collide_batch(tool, pose[None], progress=job.progress)  # a batch can be stopped, and has a limit
    pairs, codes = np.asarray(batch.pairs), np.asarray(batch.kind_codes)
    job.check()
    inside = scene.containment(tool, pose)
    colliding = len(pairs) > 0
    if colliding and given["touching"] == "free":
        colliding = scene.is_colliding(tool, pose, touching="free")
    hit, counts = np.unique(np.asarray(mockup.part_of_face)[pairs[:, 1]], return_counts=True)
    rows: dict[int, Answer] = {
        int(part): {"part": part_name(mockup, int(part)), "pairs": int(count)}
        for part, count in zip(hit, counts, strict=True)
    }
    answer: Answer = {
        "colliding": colliding,
        "free": not colliding and not inside,
        "pairs": len(pairs),
        "pair_kinds": {kind.value: count for kind in PairKind if (count := int(np.count_nonzero(codes == kind.code)))},
        **containment(mockup, inside),
    }
    if (len(pairs) or inside) and given["depth"]:
        if len(pairs) <= MOST_MEASURED:
            job.check()
            answer |= _depths(scene, tool, pose, rows)
        else:
            answer["depth_note"] = f"not measured, for there are more than {MOST_MEASURED:,} pairs"
    order = sorted(rows.values(), key=lambda row: (-row.get("depth_m", 0.0), -row.get("pairs", 0), row["part"]))
    offset = given["offset"]
    return {**answer, "parts": len(order), "rows": order[offset : offset + MOST_ROWS]}


_SEPARATIONS = {"bound": AT_MOST, "estimate": f"{ESTIMATE}: it does not free the body", "exact": EXACT}


def _depths(scene: Any, tool: Tool, pose: Any, rows: dict[int, Answer]) -> Answer:
    """Adds the depth to the row of each part; returns the translation that frees the tool."""
    found = scene.depth(tool, pose)
    for part, depth, error, is_estimate in zip(
        found.parts.tolist(), found.depths.tolist(), found.errors.tolist(), found.is_estimate.tolist(), strict=True
    ):
        row = rows.setdefault(part, {"part": part_name(scene.mockup, part), "pairs": 0})
        if is_estimate:
            row["depth_estimate_m"] = depth
        else:
            row |= {"depth_m": depth, "depth_at_most_m": depth + error}
    way = scene.penetration(tool, pose)
    return {
        "separation": {
            "translation_m": way.translation.tolist(),
            "length_m": way.depth,
            "kind": _SEPARATIONS[way.kind],
        }
    }


def clearance(served: Served, given: Given, job: Job) -> Answer:
    """The parts near the moving body at a pose."""
    pose = pose_of(given)
    scene, tool = served.moving(given)
    mockup = scene.mockup
    least = scene.distance_batch(tool, pose[None], progress=job.progress)
    found = scene.clearance_batch(tool, pose[None], given["within_m"], progress=job.progress)
    job.check()
    nearest = int(least.parts[0])
    offset = given["offset"]
    chosen = slice(offset, offset + MOST_ROWS)
    return {
        "distance_m": float(least.values[0]),
        "nearest": part_name(mockup, nearest) if nearest >= 0 else None,
        **containment(mockup, scene.containment(tool, pose)),
        "within_m": given["within_m"],
        "parts": len(found.parts),
        "rows": [
            {
                "part": part_name(mockup, part),
                "distance_m": distance,
                "point_on_body_m": point(on_tool),
                "point_on_part_m": point(on_part),
            }
            for part, distance, on_tool, on_part in zip(
                found.parts[chosen].tolist(),
                found.distances[chosen].tolist(),
                found.points_on_tool[chosen],
                found.points_on_mockup[chosen],
                strict=True,
            )
        ],
    }


def path(served: Served, given: Given, job: Job) -> Answer:
    """The first impact of each segment of a path."""
    scene, tool = served.moving(given)
    mockup = scene.mockup
    check = scene.check_path(
        tool,
        np.stack(given["poses"]),
        tolerance=given["tolerance_m"],
        touching=given["touching"],
        progress=job.progress,
    )
    job.check()
    segments = check.segments.tolist()
    impacts = zip(
        segments, check.fractions[check.segments].tolist(), check.parts, check.points, check.normals, strict=True
    )
    assert check.containment is not None
    offset = given["offset"]
    slides = "bound: between poses, parts may overlap by tolerance_m at most"
    return {
        "kinds": {"free": slides} if given["touching"] == "free" else {},
        "free": check.is_free,
        "segments": len(check),
        "segments_hit": len(segments),
        "tolerance_m": given["tolerance_m"],
        **containment(mockup, check.containment),
        "rows": [
            {
                "segment": segment,
                "fraction": fraction,
                "part": part_name(mockup, int(part)),
                "point_m": point(where),
                "normal": [round(float(x), 6) + 0.0 for x in normal],
            }
            for segment, fraction, part, where, normal in islice(impacts, offset, offset + MOST_ROWS)
        ],
    }


def rays(served: Served, given: Given, _job: Job) -> Answer:
    """The first hit of each ray."""
    scene = served.standing(given)
    asked = given["rays"]
    try:
        found = scene.rays(
            np.array([ray["from_m"] for ray in asked]),
            np.array([ray["direction"] for ray in asked]),
            within=given["within_m"],
        )
    except FeelerError as error:
        said = re.sub(r"\borigins\[(\d+)\]", r"rays[\1].from_m", str(error))
        raise OptionError(re.sub(r"\bdirections\[(\d+)\]", r"rays[\1].direction", said)) from None
    hits = found.parts >= 0
    offset = given["offset"]
    return {
        "rays": len(asked),
        "hits": int(np.count_nonzero(hits)),
        "rows": [
            {
                "ray": i,
                "hit": bool(hits[i]),
                "part": part_name(scene.mockup, int(found.parts[i])) if hits[i] else None,
                "distance_m": float(found.distances[i]),
                "point_m": point(found.points[i]),
                "normal": [round(float(x), 6) + 0.0 for x in found.normals[i]] if hits[i] else None,
            }
            for i in range(offset, len(asked))
        ],
    }
