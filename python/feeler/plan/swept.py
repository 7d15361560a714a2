"""The swept volume of a moving tool, as a closed mesh: docs/swept.md."""

from __future__ import annotations

import time

from feeler import _core
from feeler.arguments import check_number, check_progress, check_threads, check_whole
from feeler.errors import MeshError
from feeler.memory import free_memory
from feeler.mockup import Mockup, Tool
from feeler.poses import PosesLike
from feeler.progress import Progress
from feeler.source import Source

DEFAULT_ERROR = 0.001
"""The most by which the mesh may exceed the swept volume, metres."""


def swept(
    tool: Tool,
    poses: PosesLike,
    error: float = DEFAULT_ERROR,
    *,
    threads: int | None = None,
    progress: Progress | None = None,
    memory_limit: int | None = None,
) -> Mockup:
    """A closed mesh that contains the whole swept volume of a tool and exceeds it by at most `error`.

    - `poses`: `(n, 4, 4)`, world_from_tool, metres; between two of them the tool moves as in `Scene.cast`. A single
      pose gives the tool at that pose, grown.
    - `error`: metres. Half of it makes four times the triangles.
    - `threads`: default all. `progress`: called with the share done (0 to 1) and the stage.
    - `memory_limit`: the most bytes it may take; default: 80 % of the free memory.

    The mesh is in the world's frame, wound outwards, with each edge once in each direction; one part, named after the
    tool. The inside of closed surfaces of the tool is swept, too; of open ones the surface alone. A hollow that the
    tool never enters stays, as an inner surface. The result does not depend on the number of threads.

    Raises `PoseError` for no pose and poses that are not rigid, `OptionError` for an error that is not a positive
    length, and `LimitError` for one that is too small; the message has one that would fit.
    """
    given: object = tool
    if not isinstance(given, Tool):
        raise MeshError(f"swept needs a feeler.Tool, not {type(given).__name__}")
    length = check_number("error", error, "metres, more than 0", above=0.0)
    started = time.perf_counter()
    vertices, faces = _core.swept(
        tool,
        poses,
        length,
        threads=check_threads(threads),
        memory_limit=free_memory() * 4 // 5
        if memory_limit is None
        else check_whole("memory_limit", memory_limit, 0, 2**64 - 1),
        progress=check_progress(progress),
    )
    source = Source(format="swept", seconds=time.perf_counter() - started, chord_tolerance=length)
    return Mockup(vertices, faces, part_names=[f"{tool.name} swept"], source=source)
