"""A hand that feels: a tool held by a device, kept out of the mock-up, and the force of that on the hand.

session = feeler.haptics.Session(scene, tool)
session.start(pose)
step = session.step(world_from_device, dt=0.001)
step.force, step.torque, step.world_from_proxy
"""

from feeler.haptics.coupling import Coupling
from feeler.haptics.record import Parted, replay
from feeler.haptics.session import Planes, Session, Start, Step

__all__ = ["Coupling", "Parted", "Planes", "Session", "Start", "Step", "replay"]
