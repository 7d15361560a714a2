"""The swept volume of a moving tool, as a closed mesh: docs/swept.md."""

from __future__ import annotations

import math
import time

import numpy as np
import numpy.typing as npt

from feeler import _core
from feeler.errors import MeshError, OptionError
from feeler.mockup import Mockup, Source, Tool
from feeler.progress import Progress
from feeler.scene import free_memory

DEFAULT_ERROR = 0.001
"""The most by which the mesh may exceed the swept volume, metres."""
_MOST_THREADS = 1024


def swept(
    tool: Tool,
    poses: npt.ArrayLike,
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
    number: object = error
    if isinstance(number, bool) or not isinstance(number, (int, float, np.floating, np.integer)):
        raise OptionError(f"error is {error!r}: give metres, more than 0")
    started = time.perf_counter()
    vertices, faces = _core.swept(
        tool,
        poses,
        _float(error),
        threads=None if threads is None else _whole("threads", threads, 1, _MOST_THREADS),
        memory_limit=free_memory() * 4 // 5
        if memory_limit is None
        else _whole("memory_limit", memory_limit, 0, 2**64 - 1),
        progress=_checked(progress),
    )
    source = Source(format="swept", seconds=time.perf_counter() - started, chord_tolerance=float(error))
    return Mockup(vertices, faces, part_names=[f"{tool.name} swept"], source=source)


def _float(error: float) -> float:
    try:
        return float(error)
    except OverflowError:
        return math.inf  # the core refuses it


def _whole(what: str, value: object, least: int, most: int) -> int:
    is_whole = isinstance(value, (int, np.integer)) and not isinstance(value, bool)
    if not is_whole or not least <= value <= most:  # type: ignore[operator]
        raise OptionError(f"{what} is {value!r}: choose a whole number from {least} to {most}, or None")
    return int(value)  # type: ignore[call-overload, no-any-return]


def _checked(progress: Progress | None) -> Progress | None:
    if progress is not None and not callable(progress):
        raise OptionError(f"progress is {progress!r}: a function (share done, stage) or None is needed")
    return progress
