"""A haptic device that moves the hand of a session: its force comes from a servo loop of its own, its pose is a wish.

The device runs by `feeler.haptics`, against the scene that the pages show, with what the hand holds; whatever the pages
and the engine do meanwhile. A thread here passes on where it wants the tool, and begins anew where parts were gripped,
taken out or put down, or the hand was placed elsewhere. A device that stops moves nothing any more, and the pages are
told why.
"""

from __future__ import annotations

import threading
from typing import Protocol

import numpy as np
import numpy.typing as npt

from feeler.errors import FeelerError
from feeler.haptics import Coupling, Session, View
from feeler.haptics.devices import Device
from feeler.mockup import Tool
from feeler.workbench.engine.world import World

LOOK_S = 0.004
"""Between two looks at the device: as often as the engine answers."""


class Moved(Protocol):
    """What a device moves: the session of a workbench."""

    def wish(self, pose: npt.NDArray[np.float64], seq: int, source: str, /) -> None:
        """Where the hand wants to be."""

    def tell(self, event: dict[str, str], /) -> None:
        """An event for the pages."""

    def hand_key(self) -> object:
        """Another one whenever the hand, or the world around it, is another."""

    def hand_now(self) -> tuple[object, World, Tool | None, npt.NDArray[np.float64]]:
        """The key, the world, what the hand holds (None: nothing), and where it is, `world_from_tool`."""


class DeviceHand:
    """Moves a session's hand by a device, from now until `close()`."""

    def __init__(self, moved: Moved, device: Device) -> None:
        """Raises `DeviceError`, `SessionError`."""
        self._moved, self._device = moved, device
        self._lock = threading.Lock()  # of beginnings, which close() waits for
        self._ends = threading.Event()
        self._haptics: Session | None = None
        self._key: object = None
        self._begin()
        self._thread = threading.Thread(target=self._follow, name="feeler device", daemon=True)
        self._thread.start()

    @property
    def haptics(self) -> Session | None:
        """The session that runs now; None where the hand holds nothing."""
        return self._haptics

    def close(self) -> None:
        """Lets go of the force first, then of the hand. A second time does nothing."""
        self._ends.set()
        with self._lock:
            self._let_go()
        if self._thread is not threading.current_thread():
            self._thread.join()

    def _let_go(self) -> None:
        haptics, self._haptics = self._haptics, None
        if haptics is not None:
            haptics.stop()

    def _begin(self) -> None:
        """Begins, or begins anew, with what the hand holds where it is."""
        with self._lock:
            self._let_go()
            self._key, world, tool, pose = self._moved.hand_now()
            if tool is None or self._ends.is_set():
                return
            coupling = Coupling.for_device(self._device)
            haptics = Session(world.in_place, tool, coupling=coupling, put_down=world.put_down)
            haptics.start(pose)
            haptics.run(self._device)
            self._haptics = haptics

    def _follow(self) -> None:
        last, count = 0, 0
        while not self._ends.wait(LOOK_S):
            try:
                if self._moved.hand_key() != self._key:
                    self._begin()
                    last = 0
                haptics = self._haptics
                if haptics is None:
                    continue
                if not haptics.is_running:
                    self._tell_stopped("; ".join(haptics.troubles) or "it ended")
                    return
                view: View = haptics.view()
            except FeelerError as error:
                self._tell_stopped(str(error))
                return
            if view.number > last:
                last, count = view.number, count + 1
                self._moved.wish(view.world_from_device, count, "device")

    def _tell_stopped(self, why: str) -> None:
        if self._ends.is_set():
            return
        self._moved.tell({"type": "notice", "level": "error", "text": f"{self._device.name} stopped: {why}"})
