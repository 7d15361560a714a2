"""A user's script with typos: each line that is marked must be an error to a type checker."""

import numpy as np

import feeler

scene = feeler.Scene(feeler.load_mockup("engine.step"))
tool = feeler.load_tool("wrench.stl")

feeler.no_such_thing(1)  # wrong
feeler.colide(scene)  # wrong
feeler.AcessInterrupted  # wrong
scene.colide(tool, np.eye(4))  # wrong
scene.collide(tool)  # wrong
scene.collide(tool, np.eye(4), ignored=None)  # wrong
scene.cast(tool, np.eye(4), np.eye(4), touching="freely")  # wrong
scene.cast(tool, np.eye(4), np.eye(4)).fraction  # wrong
found = feeler.removal(scene, "*pump*", second=3)  # wrong
found.leg  # wrong
found.clearance.upper()  # wrong
feeler.clash(scene, clearance="2 mm")  # wrong
feeler.haptics.Session(scene, tool).stepp(np.eye(4))  # wrong
number: str = scene.is_colliding(tool, np.eye(4))  # wrong
