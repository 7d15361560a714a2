"""A picture of a few bodies among faint others: ghosts, which hide nothing."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
import numpy.typing as npt

from feeler.io.body import MeshLike
from feeler.picture import shade
from feeler.picture.camera import Camera, Section
from feeler.picture.renderer import Image, render

_OVER, _BESIDE = 0.10, 0.42
"""How much of a ghost is seen over a body, and over the background."""


class Ghosts:
    """The faint bodies of one view, drawn once for all its pictures."""

    def __init__(
        self, ghosts: Sequence[MeshLike], camera: Camera, size: tuple[int, int], section: Section | None = None
    ) -> None:
        self._camera, self._size, self._section = camera, size, section
        background = shade.encode(shade.halved(shade.background(2 * size[1]).repeat(2, axis=1)))
        self._background: Image = np.broadcast_to(background, (size[1], size[0], 3))
        self._ghosts: Image | None = None
        self._is_ghost: npt.NDArray[np.bool_] | None = None
        if ghosts:
            self._ghosts = render(None, *ghosts, camera=camera, size=size, section=section)
            self._is_ghost = (self._ghosts != self._background).any(axis=2)

    def picture(self, *bodies: MeshLike) -> Image:
        """The bodies among the ghosts."""
        image = render(None, *bodies, camera=self._camera, size=self._size, section=self._section)
        if self._ghosts is None or self._is_ghost is None:
            return image
        is_body = (image != self._background).any(axis=2)
        share = np.where(self._is_ghost, np.where(is_body, _OVER, _BESIDE), 0.0)[..., None]
        return np.asarray(np.round(image * (1.0 - share) + self._ghosts * share), dtype=np.uint8)
