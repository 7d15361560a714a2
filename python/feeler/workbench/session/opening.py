"""The initial state of a session: the document, the geometry and the record's first line for an opened mock-up."""

from __future__ import annotations

from collections.abc import Iterable
from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

import numpy as np

from feeler.mockup import Mockup, Tool
from feeler.picture.camera import upright_frame
from feeler.scene import Scene
from feeler.workbench.document import motion
from feeler.workbench.document.document import Document, MockupFacts, ToolFacts
from feeler.workbench.document.motion import Floats
from feeler.workbench.engine.geometry import Geometry, absent_parts, pack_scene, scene_bounds
from feeler.workbench.engine.hand import Hands
from feeler.workbench.session.record import digest

_BESIDE_SHARE = 0.06
"""The room between the scene's box and a tool that begins beside it, as a share of the box's diagonal."""


@dataclass(frozen=True)
class Opening:
    """The parts of a session that belong to a mock-up. header: the first line of its record."""

    document: Document
    hands: Hands
    geometry: Geometry
    header: dict[str, Any]


def opening(
    before: Document,
    scene: Scene,
    tool: Tool | None,
    tools: Iterable[Tool],
    *,
    pose: Floats | None,
    mode: str,
    unit: str,
    name: str | None,
    seed: int,
) -> Opening:
    """Makes it. before: the previous document; its record and sound settings stay."""
    mockup = scene.mockup
    known = {tool.name: tool} if tool is not None else {}
    for each in tools:
        known.setdefault(each.name, each)
    with ThreadPoolExecutor(1) as pool:
        # Neither holds the interpreter's lock: opening takes as long as the longer one.
        digested = pool.submit(digest, mockup)
        packed = pack_scene(scene)
        content = digested.result()
    name = name or name_of(mockup)
    start = beside(scene, tool) if pose is None else pose
    hands = Hands(scene, known)
    document = Document(
        mockup=MockupFacts(name, content, _triangles(scene), mockup.part_count),
        tool=None if tool is None else ToolFacts(tool.name, tool.triangle_count),
        tools=hands.names,
        record=before.record,
        project=before.project,
        absent=absent_parts(scene),
        unit=unit,
        mode=mode,
        pose=motion.row(start),
        material=before.material,
    )
    document = replace(document, held_version=hands.version(document))
    return Opening(document, hands, Geometry(scene, content, name, packed), _header(document, mockup, tool, seed))


def name_of(mockup: Mockup) -> str:
    """The name of a mock-up: that of its file, else of its root assembly, else of its source."""
    if mockup.source.files:
        return Path(mockup.source.files[0]).name
    roots = {path.split("/")[0] for path in mockup.part_paths}
    return roots.pop() if len(roots) == 1 and "" not in roots else mockup.source.format


def beside(scene: Scene, tool: Tool | None) -> Floats:
    """Upright, to the right of the scene's box, its lower end at the box's top: free, and in the page's first view.

    The page first looks from the front, the right and above: there, nothing of the scene is before this place. From the
    top, the straight way to a place above the scene is free.
    """
    low, high = scene_bounds(scene)
    bottom, top = (np.zeros(3), np.zeros(3)) if tool is None else tool.bounds
    offset = 0.5 * (low + high - bottom - top)
    right, _, above = (int(np.argmax(axis)) for axis in upright_frame(scene.mockup.source.vertical))
    offset[above] = high[above] - bottom[above]
    offset[right] = high[right] - bottom[right] + _BESIDE_SHARE * float(np.linalg.norm(high - low))
    return motion.shifted(offset)


def _triangles(scene: Scene) -> int:
    """Triangles of the parts in a scene."""
    return int(np.count_nonzero(scene.part_mask[scene.mockup.part_of_face]))


def _header(document: Document, mockup: Mockup, tool: Tool | None, seed: int) -> dict[str, Any]:
    from feeler import __version__

    facts = document.mockup
    assert facts is not None, "of a mock-up that is opened"
    return {
        "feeler": __version__,
        "numpy": np.__version__,
        "seed": seed,
        "mockup": {
            "name": name_of(mockup),
            "hash": facts.hash,
            "triangles": mockup.triangle_count,
            "parts": facts.parts,
            "absent": list(document.absent),
        },
        "tool": None if tool is None else {"name": tool.name, "hash": digest(tool)},
        "options": {"unit": document.unit, "mode": document.mode},
        "pose": list(document.pose),
    }
