"""A haptic device that moves the hand of a session: its force comes from a servo loop of its own, its pose is a wish.

The device runs by `feeler.haptics`, against the same scene, whatever the pages and the engine do; a thread here passes
on where it wants the tool. A device that stops moves nothing any more, and the pages are told why.
"""

from __future__ import annotations

import threading
from typing import Protocol

import numpy as np
import numpy.typing as npt

from feeler.haptics import Coupling, Session, View
from feeler.haptics.devices import Device
from feeler.mockup import Tool
from feeler.scene import Scene

LOOK_S = 0.004
"""Between two looks at the device: as often as the engine answers."""


class Moved(Protocol):
    """What a device moves: the session of a workbench."""

    def wish(self, pose: npt.NDArray[np.float64], seq: int, source: str, /) -> None:
        """Where the hand wants to be."""

    def tell(self, event: dict[str, str], /) -> None:
        """An event for the pages."""


class DeviceHand:
    """Moves a session's hand by a device, from now until `close()`."""

    def __init__(self, moved: Moved, scene: Scene, tool: Tool, device: Device, start: npt.ArrayLike) -> None:
        """start: world_from_tool where the device takes the tool, `(4, 4)`. Raises `DeviceError`, `SessionError`."""
        self._moved = moved
        self._name = device.name
        self._haptics = Session(scene, tool, coupling=Coupling.for_device(device))
        self._haptics.start(start)
        self._haptics.run(device)
        self._ends = threading.Event()
        self._thread = threading.Thread(target=self._follow, name="feeler device", daemon=True)
        self._thread.start()

    def close(self) -> None:
        """Lets go of the force first, then of the hand. A second time does nothing."""
        if not self._ends.is_set():
            self._ends.set()
            self._haptics.stop()
        if self._thread is not threading.current_thread():
            self._thread.join()

    def _follow(self) -> None:
        last = 0
        while not self._ends.wait(LOOK_S):
            if not self._haptics.is_running:
                why = "; ".join(self._haptics.troubles) or "it ended"
                self._moved.tell({"type": "notice", "level": "error", "text": f"{self._name} stopped: {why}"})
                return
            view: View = self._haptics.view()
            if view.number > last:
                last = view.number
                self._moved.wish(view.world_from_device, last, "device")
