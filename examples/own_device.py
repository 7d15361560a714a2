"""Your own device in some thirty lines: a handle on a rail that reports its height and takes a force.

Here a program moves the handle down onto a plate; your `read` and `write` would talk to a motor controller.
"""

import time

import numpy as np

import feeler
from feeler import haptics


class Rail(haptics.devices.Own):
    """A handle that moves up and down. What is not known of it is left out of `info`, and bounds nothing."""

    info = haptics.devices.Info("rail", force_n=10.0, stiffness_n_per_m=500.0, rate_hz=1000.0)

    def __init__(self) -> None:
        self.height_m = 0.0
        self.force_n = 0.0

    def read(self) -> np.ndarray:
        self.height_m = max(self.height_m - 20e-6, -0.013)
        return np.array([0.0, 0.0, self.height_m])

    def write(self, force: np.ndarray, torque: np.ndarray) -> None:
        self.force_n = force[2]


def box(low: list[float], high: list[float]) -> tuple[np.ndarray, np.ndarray]:
    corners = np.array([[(high if i >> a & 1 else low)[a] for a in range(3)] for i in range(8)])
    quads = [[0, 2, 3, 1], [4, 5, 7, 6], [0, 1, 5, 4], [2, 6, 7, 3], [0, 4, 6, 2], [1, 3, 7, 5]]
    return corners, np.array([[q[0], q[i], q[i + 1]] for q in quads for i in (1, 2)])


plate = feeler.Scene(feeler.Mockup(*box([-0.2, -0.2, -0.02], [0.2, 0.2, 0.0])))
tool = feeler.Tool(*box([-0.03, -0.03, -0.03], [0.03, 0.03, 0.03]))
above = np.eye(4)
above[2, 3] = 0.031  # 1 mm above the plate

rail = Rail()
session = haptics.Session(plate, tool, coupling=haptics.Coupling.for_device(rail))
session.start(above)
session.run(rail)
stiffness = session.granted().coupling.stiffness_n_per_m
felt = 0.0
while abs(rail.force_n - felt) > 1e-9 or felt == 0.0:  # until the handle rests on the plate, 12 mm deep
    felt = rail.force_n
    time.sleep(0.3)
    session.view()  # raises SessionError where the device failed
session.stop()
print(f"{stiffness:.0f} N/m granted; 12 mm into the plate the hand feels {felt:.2f} N")
print(f"after the run it has let go: {rail.force_n} N")
