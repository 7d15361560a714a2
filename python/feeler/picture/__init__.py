"""Pictures of results: coloured bodies, as GLB or rendered without a display."""

from feeler.picture.bars import bars
from feeler.picture.camera import Camera, Section
from feeler.picture.clearance import clearance_bodies, write_clearance_glb
from feeler.picture.collision import Hits, collision_bodies, write_collision_glb
from feeler.picture.renderer import Inset, render
from feeler.picture.views import render_collision

__all__ = [
    "Camera",
    "Hits",
    "Inset",
    "Section",
    "bars",
    "clearance_bodies",
    "collision_bodies",
    "render",
    "render_collision",
    "write_clearance_glb",
    "write_collision_glb",
]
