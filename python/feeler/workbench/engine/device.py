"""A haptic device that moves the hand of a session: a servo loop makes its force, and its pose is the wish.

`feeler.haptics` runs the device against the scene on the pages, with the content of the hand, independently of the
pages and the engine. A thread here passes on the device's pose, tells where the way is that guides the hand, and
restarts the run when parts are gripped, taken out or put down, or the hand is placed elsewhere. When a device stops,
the hand stays, and the pages get the reason.
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
from feeler.workbench.engine.guide import Guide
from feeler.workbench.engine.world import World

LOOK_S = 0.004
"""Interval between samples of the device: the engine's own."""


class Moved(Protocol):
    """The session of a workbench, as a device needs it."""

    def wish(self, pose: npt.NDArray[np.float64], seq: int, source: str, /) -> object:
        """Sets the target of the hand."""

    def tell(self, event: dict[str, str], /) -> None:
        """Sends an event to the pages."""

    def hand_key(self) -> object:
        """A key that changes whenever the hand, or the world around it, changes."""

    def guide_now(self) -> Guide | None:
        """The way that guides the hand."""

    def hand_now(self) -> tuple[object, World, Tool | None, npt.NDArray[np.float64]]:
        """The key, the world, the content of the hand (None: nothing), and its pose, `world_from_tool`."""


class DeviceHand:
    """Moves a session's hand by a device, until `close()`."""

    def __init__(self, moved: Moved, device: Device) -> None:
        """Raises `DeviceError`, `SessionError`."""
        self._moved, self._device = moved, device
        self._lock = threading.Lock()  # held while a run starts; close() waits for it
        self._ends = threading.Event()
        self._haptics: Session | None = None
        self._key: object = None
        self._begin()
        self._thread = threading.Thread(target=self._follow, name="feeler device", daemon=True)
        self._thread.start()

    @property
    def haptics(self) -> Session | None:
        """The running session; None if the hand is empty."""
        return self._haptics

    def close(self) -> None:
        """Releases first the force, then the hand. A second call does nothing."""
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
        """Starts, or restarts, with the content of the hand at its pose."""
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
        last, count, is_guided = 0, 0, False
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
                if view.number > last:
                    is_guided = self._guide(haptics, view, is_guided)
            except FeelerError as error:
                self._tell_stopped(str(error))
                return
            if view.number > last:
                last, count = view.number, count + 1
                self._moved.wish(view.world_from_device, count, "device")

    def _guide(self, haptics: Session, view: View, is_guided: bool) -> bool:
        """Tells the servo where the nearest place of the way is, or once that nothing guides. Only with news of the
        device: in silence it draws no more."""
        guide = self._moved.guide_now()
        held = None if guide is None or view.mode == "doubt" else guide.held(view.world_from_device)
        if held is not None:
            haptics.guide(*held)
        elif is_guided:
            haptics.guide(None)
        return held is not None

    def _tell_stopped(self, why: str) -> None:
        if self._ends.is_set():
            return
        self._moved.tell({"type": "notice", "level": "error", "text": f"{self._device.name} stopped: {why}"})
