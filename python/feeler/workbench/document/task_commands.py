"""Edits of tasks: parts that are off already, typed times, and a forced order; and what all tasks use, the table of
times and the catalogue of tools. Undo takes them back; the question of the card is asked again at once."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace
from types import MappingProxyType
from typing import Any

from feeler.errors import LoadError
from feeler.plan.catalogue import parsed_catalogue
from feeler.tasks.times import Times
from feeler.workbench.document.arguments import Arguments
from feeler.workbench.document.document import NO_EDIT, Document, TaskCatalogue, TaskEdits, TaskTimes
from feeler.workbench.document.known import Known

LONGEST_S = 1e6
"""Of a typed time, seconds."""
MOST_EDITS = 1000
MOST_TOML = 90_000
"""Characters of a table of times, or of a catalogue."""
MOST_NAME = 200


def task_edit(document: Document, given: Arguments, known: Known) -> Document:
    """Edits the task of a card, which is planned again.

    "off", "on": the parts are off already, or not. "time": their step takes `seconds`; without, as counted. "before",
    "free": the parts go before those of `later`, or need not.
    """
    number = given.whole("id", 1)
    edits = document.task_edits.get(number, NO_EDIT)
    changed = _EDITS[given.choice("edit", _EDITS)](edits, given, known)
    if max(len(changed.off), len(changed.times), len(changed.before)) > MOST_EDITS:
        raise given.fail("edit", f"a task has at most {MOST_EDITS:,} edits of a kind", "take some back first")
    rest = {card: each for card, each in document.task_edits.items() if card != number}
    if changed != NO_EDIT:
        rest[number] = changed
    return replace(document, task_edits=MappingProxyType(dict(sorted(rest.items()))))


def task_times(document: Document, given: Arguments, known: Known) -> Document:
    """Takes a table of times (TOML, as of `feeler task --times`) for all tasks, which are planned again.

    An empty text takes the examples again.
    """
    toml, name = _file(given, "times")
    if not toml.strip():
        return replace(document, task_times=TaskTimes())
    try:
        table = Times.parse(toml)
    except LoadError as error:
        said = str(error).removeprefix("times: ")
        raise given.fail("toml", f"{name}: {said}", "docs/task.md has the form") from None
    return replace(document, task_times=TaskTimes(name, toml, len(table.elements) - len(table.examples)))


def task_catalogue(document: Document, given: Arguments, known: Known) -> Document:
    """Takes a catalogue of tools (TOML, as of `feeler access --write-catalogue`) for tasks that choose from one.

    They are planned again. An empty text takes the built-in one again.
    """
    toml, name = _file(given, "catalogue")
    if not toml.strip():
        return replace(document, task_catalogue=TaskCatalogue())
    try:
        tools = len(parsed_catalogue(toml, name))
    except LoadError as error:
        raise given.fail("toml", str(error), "docs/access.md has the form") from None
    return replace(document, task_catalogue=TaskCatalogue(name, toml, tools))


def _file(given: Arguments, default: str) -> tuple[str, str]:
    """The text of a file, and its name."""
    toml: Any = given.raw("toml", str)
    if not isinstance(toml, str) or len(toml) > MOST_TOML:
        raise given.fail("toml", "it is no text, or too long", f"send at most {MOST_TOML:,} characters")
    return toml, given.text("name")[:MOST_NAME] if given.has("name") else default


def _off(edits: TaskEdits, given: Arguments, known: Known) -> TaskEdits:
    return replace(edits, off=tuple(sorted({*edits.off, *_paths(given, known)})))


def _on(edits: TaskEdits, given: Arguments, known: Known) -> TaskEdits:
    return replace(edits, off=tuple(sorted({*edits.off} - {*_paths(given, known)})))


def _time(edits: TaskEdits, given: Arguments, known: Known) -> TaskEdits:
    paths = _paths(given, known)
    times = {path: seconds for path, seconds in edits.times if path not in paths}
    if given.has("seconds"):
        times |= dict.fromkeys(paths, given.number("seconds", 0.0, LONGEST_S))
    return replace(edits, times=tuple(sorted(times.items())))


def _before(edits: TaskEdits, given: Arguments, known: Known) -> TaskEdits:
    pairs = _pairs(given, known)
    turned = {(last, first) for first, last in pairs}
    return replace(edits, before=tuple(sorted(({*edits.before} | pairs) - turned)))


def _free(edits: TaskEdits, given: Arguments, known: Known) -> TaskEdits:
    return replace(edits, before=tuple(sorted({*edits.before} - _pairs(given, known))))


_EDITS: dict[str, Callable[[TaskEdits, Arguments, Known], TaskEdits]] = {
    "off": _off,
    "on": _on,
    "time": _time,
    "before": _before,
    "free": _free,
}


def _paths(given: Arguments, known: Known, name: str = "parts") -> list[str]:
    return [known.parts[part].path for part in given.parts(name, known.parts)]


def _pairs(given: Arguments, known: Known) -> set[tuple[str, str]]:
    if not given.has("later"):
        raise given.fail("later", "the parts that go after are not named", "name one at least")
    firsts, lasts = _paths(given, known), _paths(given, known, "later")
    if {*firsts} & {*lasts}:
        raise given.fail("later", "a part cannot go before itself", "name two parts")
    return {(first, last) for first in firsts for last in lasts}
