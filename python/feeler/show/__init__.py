"""Files and pictures for people: GLB, STL, and a renderer that needs no display."""

from feeler.show.body import Body, Mark, body_of, with_marks
from feeler.show.camera import Camera, Section
from feeler.show.clearance import clearance_bodies, write_clearance_glb
from feeler.show.collision import collision_bodies, write_collision_glb
from feeler.show.export import write_glb, write_stl
from feeler.show.files import WriteError, check_target
from feeler.show.picture import Inset, render
from feeler.show.views import render_collision

__all__ = [
    "Body",
    "Camera",
    "Inset",
    "Mark",
    "Section",
    "WriteError",
    "body_of",
    "check_target",
    "clearance_bodies",
    "collision_bodies",
    "render",
    "render_collision",
    "with_marks",
    "write_clearance_glb",
    "write_collision_glb",
    "write_glb",
    "write_stl",
]
