"""Steps in time: who does what when. Steps that look at other parts are independent, and can be done at once."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass


@dataclass(frozen=True)
class Job:
    """A step without its place in time."""

    tool: str
    seconds: float
    """Without the change of the tool."""
    after: tuple[int, ...]
    """Steps that have to be done before, by number."""


@dataclass(frozen=True)
class Slot:
    """When a step is done, and by whom."""

    person: int
    start: float
    end: float
    is_changed: bool
    """Whether the person takes another tool for it."""
    waits_for: int | None
    """The step that ends when it starts, of the same person or one that has to be done before."""


def scheduled(jobs: Sequence[Job], get_seconds: float, people: int) -> list[Slot]:
    """The quickest of the plans for one person and more, up to `people`. One person keeps the order of the steps."""
    plans = [_alone(jobs, get_seconds), *(_shared(jobs, get_seconds, count) for count in range(2, people + 1))]
    return min(plans, key=lambda plan: round(max((slot.end for slot in plan), default=0.0), 9))


def critical(slots: Sequence[Slot]) -> list[int]:
    """The chain of steps that decides when all are done, in order."""
    if not slots:
        return []
    number: int | None = max(range(len(slots)), key=lambda n: (slots[n].end, -n))
    chain = []
    while number is not None:
        chain.append(number)
        number = slots[number].waits_for
    return chain[::-1]


def _alone(jobs: Sequence[Job], get_seconds: float) -> list[Slot]:
    slots: list[Slot] = []
    now, tool = 0.0, ""
    for number, job in enumerate(jobs):
        is_changed = bool(job.tool) and job.tool != tool
        end = now + job.seconds + get_seconds * is_changed
        slots.append(Slot(0, now, end, is_changed, number - 1 if number else None))
        now, tool = end, job.tool or tool
    return slots


def _shared(jobs: Sequence[Job], get_seconds: float, people: int) -> list[Slot]:
    """A list schedule: whoever is free takes the ready step with the longest chain behind it."""
    tails = _tails(jobs)
    free, tools, last = [0.0] * people, [""] * people, [-1] * people
    slots: dict[int, Slot] = {}
    while len(slots) < len(jobs):
        ready = [n for n, job in enumerate(jobs) if n not in slots and all(each in slots for each in job.after)]
        options = []
        for number in ready:
            done = max((slots[each].end for each in jobs[number].after), default=0.0)
            for person in range(people):
                start = max(done, free[person])
                change = bool(jobs[number].tool) and jobs[number].tool != tools[person]
                options.append((start, -tails[number], change, number, person))
        start, _, is_changed, number, person = min(options)
        job = jobs[number]
        end = start + job.seconds + get_seconds * is_changed
        before = [each for each in (*job.after, last[person]) if each >= 0 and slots[each].end == start]
        slots[number] = Slot(person, start, end, is_changed, before[0] if before else None)
        free[person], last[person] = end, number
        tools[person] = job.tool or tools[person]
    return [slots[n] for n in range(len(jobs))]


def _tails(jobs: Sequence[Job]) -> list[float]:
    """Of each step the seconds of the longest chain that begins with it."""
    tails = [job.seconds for job in jobs]
    for number in range(len(jobs) - 1, -1, -1):
        for before in jobs[number].after:
            tails[before] = max(tails[before], jobs[before].seconds + tails[number])
    return tails
