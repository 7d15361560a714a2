"""Haptics: a device moves a tool, contact keeps the tool out of the mock-up, and the device returns the force.

session = feeler.haptics.Session(scene, tool)
session.start(pose)
step = session.step(world_from_device, dt=0.001)
step.force, step.torque, step.world_from_proxy

session.run(feeler.haptics.open_device("haply"))
session.view().force, session.stats().servo_lateness.p99
session.stop()
"""

from feeler.haptics import devices
from feeler.haptics.coupling import Coupling
from feeler.haptics.devices import open_device
from feeler.haptics.replaying import Parted, replay
from feeler.haptics.running import Distribution, Granted, Statistics, Tick, Trace, View
from feeler.haptics.session import Plane, Planes, Seat, Session, Start, Step

__all__ = [
    "Coupling",
    "Distribution",
    "Granted",
    "Parted",
    "Plane",
    "Planes",
    "Seat",
    "Session",
    "Start",
    "Statistics",
    "Step",
    "Tick",
    "Trace",
    "View",
    "devices",
    "open_device",
    "replay",
]
