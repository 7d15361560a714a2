"""The people on a session: their names and colours, where they point, and who has the tool.

One page, a script or a device has the tool at a time. It keeps the turn while it moves the tool; some seconds after the
last move the tool is free, and whoever moves it next has it. A script may always move it.

Pages send where their person points as often as they like: the newest counts, and `news` collects it for the other
pages at the server's pace.
"""

from __future__ import annotations

import math
import threading
import unicodedata
from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from feeler.errors import WorkbenchError
from feeler.workbench.document.motion import Floats
from feeler.workbench.document.protocol_people import (
    MOST_NAME,
    MOST_SELECTED,
    Here,
    Holder,
    People,
    Person,
    Seen,
    Turn,
    Turning,
)
from feeler.workbench.document.protocol_values import Camera
from feeler.workbench.document.values import LARGEST

SCRIPT = 0
"""Who moves the tool: not a page, whose numbers begin at 1."""

DEVICE = -1
"""The same: a haptic device of the server's machine."""

IDLE_S = 4.0
"""The tool is free so long after the last move of a page or a device."""

SCRIPT_S = 1.0
"""The same after that of a script."""

AWAY_S = 6.0
"""A page that said nothing for so long is away. Pages say something every two seconds while others are there."""

LOOK_S = 1.0
"""How often somebody should look for those who are idle or away."""

_STILL = 5e-4  # metres, and about radians: a device that rests moves less
_NOBODY: Turn = {"kind": None, "person": None, "is_free": True, "asked": []}


@dataclass
class _Page:
    """A page's person. name: the wished one, empty for the default; colour: the least that nobody else has."""

    id: int
    name: str
    colour: int
    heard_at: float
    here: Here | None = None
    is_named: bool = False


@dataclass(frozen=True)
class News:
    """What pages do not know yet. seen: the pages' numbers that show something else."""

    is_about_people: bool
    seen: tuple[int, ...]


class PeopleOf:
    """The people of one session. Thread-safe; nothing here waits."""

    def __init__(
        self,
        clock: Callable[[], float],
        *,
        parts: Callable[[], int] = lambda: 0,
        is_playing: Callable[[], bool] = lambda: False,
    ) -> None:
        """clock: seconds. parts: how many the mock-up has. is_playing: whether the hand moves by itself."""
        self._clock, self._parts, self._is_playing = clock, parts, is_playing
        self._lock = threading.RLock()
        self._pages: dict[int, _Page] = {}
        self._next = 1
        self._holder: int | None = None
        self._moved_at = -math.inf
        self._asked: list[int] = []
        self._device_pose: Floats | None = None
        self._told: tuple[list[Person], Turn] = ([], _NOBODY)
        self._fresh: dict[int, None] = {}
        self._listener: Callable[[], None] = lambda: None

    def on_news(self, listener: Callable[[], None]) -> Callable[[], None]:
        """Calls a function whenever `news` has something: in any thread, and it must not block.

        There is one at a time. Call the result to end that.
        """
        self._listener = listener

        def end() -> None:
            self._listener = lambda: None

        return end

    # ---- pages come and go ----

    def join(self) -> int:
        """A page came; the result is its number."""
        with self._lock:
            now = self._clock()
            for each in self._pages.values():
                each.heard_at = now  # alone, a page says nothing
            taken = {each.colour for each in self._pages.values()}
            colour = next(number for number in range(len(taken) + 1) if number not in taken)
            page = _Page(self._next, self._free_name("", None), colour, now)
            self._next += 1
            self._pages[page.id] = page
        self._listener()
        return page.id

    def leave(self, person: int) -> bool:
        """A page is gone. Whether it had the tool, which is free now."""
        with self._lock:
            self._pages.pop(person, None)
            self._fresh.pop(person, None)
            self._asked = [each for each in self._asked if each != person]
            had_tool = self._holder == person
            if had_tool:
                self._holder = None
        self._listener()
        return had_tool

    def name(self, person: int, name: str) -> None:
        """Sets a name; empty: the default. A name that another person has gets a number. Raises `WorkbenchError`."""
        if len(name) > MOST_NAME:
            raise WorkbenchError(
                f"the name has {len(name):,} characters", "name", f"choose one of at most {MOST_NAME} characters"
            )
        with self._lock:
            page = self._heard(person)
            wished = _plain(name)
            page.name, page.is_named = self._free_name(wished, person), bool(wished)
        self._listener()

    def name_of(self, mover: int, *, is_first: bool = False) -> str:
        """The name of a person, or words for a script or device; is_first: in a sentence."""
        with self._lock:
            page = self._pages.get(mover)
        if page is not None:
            return page.name
        words = {SCRIPT: "a script", DEVICE: "the device"}.get(mover, "somebody who left")
        return words[0].upper() + words[1:] if is_first else words

    def author(self, person: int) -> str:
        """The name that a person chose; empty without one, and for scripts and devices."""
        with self._lock:
            page = self._pages.get(person)
            return page.name if page is not None and page.is_named else ""

    @property
    def count(self) -> int:
        """The number of pages."""
        return len(self._pages)

    # ---- where they are ----

    def here(self, person: int, here: Here) -> None:
        """Where a person points and looks. Raises `WorkbenchError` for what cannot be."""
        _check_here(here, self._parts())
        with self._lock:
            page = self._heard(person)
            is_new = page.here is None or _shown(page.here) != _shown(here)
            page.here = here
            if is_new:
                self._fresh[person] = None
            was_free = self._is_free()
            if here.is_moving and self._holder == person:
                self._moved_at = self._clock()
            is_news = is_new or was_free or self._told[0] != self._people()
        if is_news:
            self._listener()

    def seen(self, person: int) -> Seen | None:
        """What others see of a person; None before the first `here`."""
        with self._lock:
            page = self._pages.get(person)
            if page is None or page.here is None:
                return None
            return Seen(person, page.here.point, page.here.selection, page.here.camera)

    # ---- turns ----

    def may_move(self, mover: int, pose: Floats | None = None) -> bool:
        """Whether somebody may move the tool now: then it has the turn. pose: that a device has, which often rests."""
        with self._lock:
            is_holder = self._holder == mover
            if mover == DEVICE and pose is not None:
                before = self._device_pose
                is_still = before is not None and bool(np.abs(pose - before).max() <= _STILL)
                if is_still:
                    return is_holder
                self._device_pose = pose
            if mover > 0:
                self._heard(mover)
            if mover != SCRIPT and not is_holder and not self._is_free():
                return False
            is_news = not is_holder or self._is_free()
            self._take(mover)
        if is_news:
            self._listener()
        return True

    def could_move(self, mover: int) -> bool:
        """Whether somebody may move the tool now; the turn stays as it is."""
        with self._lock:
            return self._holder == mover or self._is_free()

    def check_move(self, mover: int) -> None:
        """As `may_move`. Raises `WorkbenchError`."""
        if not self.may_move(mover):
            raise self.refusal()

    def refusal(self) -> WorkbenchError:
        """Why the tool cannot be moved, to raise."""
        with self._lock:
            name = self.name_of(SCRIPT if self._holder is None else self._holder, is_first=True)
        return WorkbenchError(f"{name} has the tool", "tool", "ask for it, or wait until it is free")

    def turn(self, person: int, turning: Turning) -> bool:
        """A person's wish about the turn. Whether somebody else has the tool now. Raises `WorkbenchError`."""
        with self._lock:
            self._heard(person)
            before = self._holder
            wish, to = turning.wish, turning.to
            if wish in ("take", "ask") and (self._is_free() or before == person):
                self._take(person)
            elif wish == "take":
                raise self.refusal()
            elif wish == "ask":
                if person not in self._asked:
                    self._asked.append(person)
            elif before != person:
                raise WorkbenchError("you do not have the tool", "tool", "take it, or ask for it")
            elif wish == "give":
                if to is None or to not in self._pages or to == person:
                    raise WorkbenchError("there is no such person", "tool", "give it to somebody who is there")
                self._take(to)
            elif wish == "keep":
                self._asked = []
            else:
                self._holder = None
            has_changed = self._holder != before
        self._listener()
        return has_changed

    # ---- for the server ----

    def news(self) -> News:
        """What changed since the last call."""
        with self._lock:
            now = (self._people(), self._turn())
            is_about_people, self._told = now != self._told, now
            seen, self._fresh = tuple(self._fresh), {}
            return News(is_about_people, seen)

    def people(self, you: int) -> People:
        """All people and the turn, for one of them."""
        with self._lock:
            return People(you, self._people(), self._turn())

    @property
    def look_s(self) -> float | None:
        """After how long somebody should look for news, if none is told; None: there can be none."""
        with self._lock:
            is_waiting = self._holder in (SCRIPT, DEVICE) and not self._is_free()
            return LOOK_S if len(self._pages) > 1 or is_waiting else None

    # ---- with the lock held ----

    def _heard(self, person: int) -> _Page:
        page = self._pages.get(person)
        if page is None:
            raise WorkbenchError("this page is gone", "people", "reload the page")
        page.heard_at = self._clock()
        return page

    def _take(self, mover: int) -> None:
        self._holder, self._moved_at = mover, self._clock()
        self._asked = [each for each in self._asked if each != mover]

    def _is_away(self, page: _Page) -> bool:
        return len(self._pages) > 1 and self._clock() - page.heard_at >= AWAY_S

    def _is_free(self) -> bool:
        if self._holder is None:
            return True
        page = self._pages.get(self._holder)
        if page is None and self._holder > 0:
            return True
        if page is not None and self._is_away(page):
            return True
        idle_s = SCRIPT_S if self._holder == SCRIPT else IDLE_S
        return self._clock() - self._moved_at >= idle_s and not self._is_playing()

    def _people(self) -> list[Person]:
        return [
            {"id": each.id, "name": each.name, "colour": each.colour, "is_away": self._is_away(each)}
            for each in self._pages.values()
        ]

    def _turn(self) -> Turn:
        if self._holder is None:
            return _NOBODY
        kinds: dict[int, Holder] = {SCRIPT: "script", DEVICE: "device"}
        return {
            "kind": kinds.get(self._holder, "page"),
            "person": self._holder if self._holder > 0 else None,
            "is_free": self._is_free(),
            "asked": list(self._asked),
        }

    def _free_name(self, wished: str, person: int | None) -> str:
        """The wished name, or with a number; without one, the first guest's that is free."""
        taken = {each.name.casefold() for each in self._pages.values() if each.id != person}
        number = 1
        while True:
            end = f" {number}" if number > 1 or not wished else ""
            name = (wished or "Guest")[: MOST_NAME - len(end)] + end
            if name.casefold() not in taken:
                return name
            number += 1


_BLANK = frozenset("\u115f\u1160\u2800\u3164\uffa0")  # letters and symbols that show nothing


def _plain(name: str) -> str:
    """Without characters that are not seen, such as those that turn the direction of what follows."""
    seen = "".join(each if unicodedata.category(each)[0] != "C" and each not in _BLANK else " " for each in name)
    return " ".join(seen.split())


def _shown(here: Here) -> tuple[object, ...]:
    return here.point, here.selection, here.camera


def _check_here(here: Here, parts: int) -> None:
    where = "here"
    if len(here.selection) > MOST_SELECTED:
        raise WorkbenchError(f"{len(here.selection):,} parts are selected", where, f"send at most {MOST_SELECTED:,}")
    wrong = next((part for part in here.selection if not 0 <= part < parts), None)
    if wrong is not None:
        raise WorkbenchError(f"there is no part {wrong}", where, "send parts of the mock-up")
    if not _is_near(here.point or (0.0, 0.0, 0.0)):
        raise WorkbenchError("the point is out of all reach", where, "send metres")
    if not _is_camera(here.camera):
        raise WorkbenchError("the camera sees nothing", where, "send the camera of the page")


def _is_near(point: tuple[float, float, float]) -> bool:
    return all(abs(each) <= LARGEST for each in point)


def _is_camera(camera: Camera) -> bool:
    position, target, up = camera["position"], camera["target"], camera["up"]
    if not (_is_near(position) and _is_near(target) and _is_near(up) and 0.01 <= camera["fov_rad"] <= 3.0):
        return False
    ahead = np.subtract(target, position)
    # Beside its own direction, a camera's top is undefined.
    return bool(np.linalg.norm(np.cross(ahead, up)) > 1e-9 * np.linalg.norm(ahead) * np.linalg.norm(up) > 0.0)
