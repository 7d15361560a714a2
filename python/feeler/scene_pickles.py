"""Pickles of scenes. One with moved parts has its mock-up as modelled, and how its parts were moved."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import numpy as np
import numpy.typing as npt

from feeler.errors import OptionError
from feeler.travel import reduced

OWN = ("part_names", "part_paths", "part_colours", "_part_attributes", "source")
"""What may be set of a mock-up after its parts were moved."""
_Moves = tuple[list[int], npt.NDArray[np.float64], dict[str, Any]]


def reduced_scene(scene: Any) -> tuple[Any, ...]:
    """The result of `Scene.__reduce__`."""
    options = {"voxel_size": scene.voxel_size, "storage": scene.storage, "hashing": scene.hashing, **scene._given}
    attributes = {name: value for name, value in vars(scene).items() if name not in ("build_seconds", "_given")}
    mask, mockup = scene.part_mask, scene.mockup
    present = None if mask.all() else mask
    if mockup._modelled is None or mockup._moves is None:
        return (*reduced("Scene", (type(scene), mockup, options, present)), attributes)
    own = {name: vars(mockup)[name] for name in OWN if name in vars(mockup)}
    moves = (*mockup._moves, own)
    return (*reduced("Scene", (type(scene), mockup._modelled, options, present, moves)), attributes)


def restored_scene(
    make: Callable[..., Any],
    mockup: Any,
    options: dict[str, Any],
    mask: npt.NDArray[np.bool_] | None,
    moves: _Moves | None = None,
) -> Any:
    """The scene of a state, made by `Scene.__new__`; on a CPU without its instruction set with the best there is."""
    try:
        scene = make(mockup, **options)
    except OptionError:
        if options["simd"] is None:
            raise
        scene = make(mockup, **{**options, "simd": None})
    if moves is not None:
        places, poses, own = moves
        scene = scene._with_poses(np.array(places), np.asarray(poses))
        vars(scene.mockup).update(own)
    return scene if mask is None else scene.only(mask)
