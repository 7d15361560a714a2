"""Commands of cards: questions about parts, which a job answers while the hand goes on.

A card is put by a question and stays with its answer until it is removed. Undo does not touch cards, except that parts
taken out along a way of a card come back.
"""

from __future__ import annotations

import operator
from collections.abc import Callable
from dataclasses import replace
from itertools import takewhile
from types import MappingProxyType
from typing import Any, get_args

import numpy as np

from feeler.choices import GRIP_AXES
from feeler.errors import WorkbenchError
from feeler.words import plural
from feeler.workbench.document import motion
from feeler.workbench.document.answers import CardAnswer
from feeler.workbench.document.arguments import Arguments, replaced, without
from feeler.workbench.document.document import NO_EDIT, Card, Document, Removal, TaskEdits, line_world
from feeler.workbench.document.known import Known, Way
from feeler.workbench.document.line_facts import with_checked_lines
from feeler.workbench.document.protocol import CardQuestion, GivenWay, Pose, Selection
from feeler.workbench.document.values import is_sequence

QUESTIONS: tuple[CardQuestion, ...] = get_args(CardQuestion)
MOST_CARDS = 100
LONGEST_S = 3600.0
MOST_PEOPLE = 20
_NOT_OF = {
    "access": ("clearance", "seconds", "people"),
    "catalogue": ("tool", "grip", "seconds", "people"),
    "task": ("tool", "grip", "swing_deg", "clearance", "catalogue"),
}
"""Options that a question does not have; others have none of the tools. "catalogue": of access, with one."""
_MOST_POSES = 20_000
_GRID_M = 2.0**-10


def ask(document: Document, given: Arguments, known: Known) -> Document:
    """Asks about parts: do they come out, what has to go first, is a fastener reached, what room do they need.

    `without`: parts that are taken for gone. `tool`, `tools`: names of opened tools. Of `tools`, the answer has the one
    that swings farthest; of a task, an empty list leaves their reach unchecked. `catalogue`: take the first tool of the
    catalogue that reaches. `grip`: as of `feeler.access`. `swing_deg`: the least swing of a tool that counts, degrees.
    `clearance`: metres to keep. `people`: how many do the task. `seconds`: the time limit of the answer.
    """
    if len(document.cards) >= MOST_CARDS:
        raise WorkbenchError(f"there are {MOST_CARDS} cards already", given.command, "remove some first")
    question = given.choice("question", QUESTIONS)
    left_out = tuple(given.parts("without", known.parts)) if given.has("without") else ()
    gone = {*known.absent, *document.out, *document.gripped, *left_out}
    named = given.parts("parts", known.parts) if given.has("parts") else ()
    parts = tuple(part for part in named if part not in gone)
    if named and not parts:
        raise given.fail("parts", "none of these parts is in the mock-up now", "put them back, or name others")
    if not named and question != "access":
        raise given.fail("parts", "no part is named", "name one at least")
    if len(parts) >= len(known.parts) - len(gone) and question != "access":
        raise given.fail("parts", "these are all parts of the mock-up", "leave one at least where it is")
    options = _options(document, given, known, question)
    card = Card(
        id=document.next_card,
        question=question,
        parts=parts,
        without=left_out,
        options=MappingProxyType(options),
        title=_title(question, parts, options, known),
        setting=_setting(document, left_out, known),
        world=document.world,
    )
    return replace(document, cards=(*document.cards, card), next_card=card.id + 1)


def task_parts(answer: CardAnswer) -> list[int]:
    """The parts that the task of an answer names; -1 among them if its steps are not those of its ways."""
    task = answer.get("task")
    if task is None:
        return []
    named = [step["part"] for step in task["steps"]]
    named += [part for each in task["blocked"] for part in (each["part"], *each["blockers"]) if part is not None]
    before = [number for step in task["steps"] for number in step["after"]]
    is_whole = len(named) >= len(answer["ways"]) == len(task["steps"])
    return named if is_whole and all(0 <= each < len(answer["ways"]) for each in before) else [*named, -1]


def tasks_of(document: Document) -> list[Card]:
    """The cards that ask how parts are taken out."""
    return [card for card in document.cards if card.question == "task"]


def tasks_again(document: Document, known: Callable[[], Known]) -> Document:
    """The document with the questions of tasks asked again whose edits changed, as by undo; and those of access whose
    catalogue did."""
    waiting = []
    for card in document.cards:
        edits = _edits_of(document, card)
        if card.edits != edits:
            here = known()
            gone = {*here.absent, *document.out, *document.gripped}
            if not card.parts or any(part not in gone for part in card.parts):
                card = replace(_waiting(document, card, here), edits=edits)
        waiting.append(card)
    return document if all(map(operator.is_, waiting, document.cards)) else replace(document, cards=tuple(waiting))


def _edits_of(document: Document, card: Card) -> TaskEdits:
    """What the answer of a card has to be about."""
    catalogue = document.task_catalogue.digest
    if card.question == "task":
        return replace(
            document.task_edits.get(card.id, NO_EDIT),
            table=document.task_times.digest,
            catalogue="" if "tools" in card.options else catalogue,
        )
    return replace(NO_EDIT, catalogue=catalogue) if "catalogue" in card.options else card.edits


def card_again(document: Document, given: Arguments, known: Known) -> Document:
    """Asks the question of a card again, of the mock-up as it is now."""
    at = given.place_of(document.cards)
    card = document.cards[at]
    if card.state in ("waiting", "running"):
        raise given.fail("id", "this question is not answered yet", "wait for the answer, or cancel it")
    gone = {*known.absent, *document.out, *document.gripped}
    if card.line is not None:
        gone = set()
    if card.parts and not any(part not in gone for part in card.parts):
        raise given.fail("id", "none of its parts is in the mock-up now", "put them back")
    asked = _waiting(document, card, known)
    if card.line is not None:
        asked = _line_again(document, asked, given)
    return replace(document, cards=replaced(document.cards, at, asked))


def _waiting(document: Document, card: Card, known: Known) -> Card:
    return replace(
        card,
        state="waiting",
        share=0.0,
        stage="",
        sentence="",
        is_good=None,
        setting=_setting(document, card.without, known),
        world=document.world,
        is_earlier=False,
        clearances=(),
    )


def _line_again(document: Document, card: Card, given: Arguments) -> Card:
    at = next((at for at, line in enumerate(document.sequence) if line.id == card.line), None)
    if at is None:
        raise given.fail("id", "this removal is not in the sequence any more", "undo that, or remove the card")
    line = document.sequence[at]
    return replace(card, parts=line.parts, setting=line_setting(at), way=line.way_key, world=line_world(document, at))


def card_cancel(document: Document, given: Arguments, _known: Known) -> Document:
    """Gives up a question that is not answered yet."""
    at = given.place_of(document.cards)
    card = document.cards[at]
    if card.state not in ("waiting", "running"):
        was = "cancelled" if card.state == "cancelled" else "answered"
        raise given.fail("id", f"this question is {was} already", "remove the card instead")
    cancelled = replace(card, state="cancelled", sentence="Cancelled.", share=0.0, stage="")
    return replace(document, cards=replaced(document.cards, at, cancelled))


def card_remove(document: Document, given: Arguments, _known: Known) -> Document:
    """Removes a card, with its answer, and the guide along its way."""
    at = given.place_of(document.cards)
    guiding = document.guiding
    if guiding is not None and guiding.card == document.cards[at].id:
        guiding = None
    return replace(document, cards=without(document.cards, at), guiding=guiding)


def way_take(document: Document, given: Arguments, known: Known) -> Document:
    """Takes parts out along the ways of a card, and adds them to the sequence.

    `steps`: how many of its ways that were not taken yet, all by default. `ways`: these instead of the card's, as a
    record has them.
    """
    ways = given_ways(given, known) if given.has("ways") else ()
    if not ways:
        card = document.cards[given.place_of(document.cards)]
        ways = known.ways.get(card.id, ()) if card.line is None else ()
        if not ways:
            raise given.fail("id", "this card has no way", "ask how the parts come out")
        ways = _ways_left(document, card, ways, given, known)
    if given.has("steps"):
        ways = ways[: given.whole("steps", 1, len(ways))]
    for way in ways:
        document = _taken(document, way, given, known)
    return replace(document, pose=known.pose)


def _ways_left(
    document: Document, card: Card, ways: tuple[Way, ...], given: Arguments, known: Known
) -> tuple[Way, ...]:
    """The ways that were not taken yet. Raises `WorkbenchError` if anything else was moved since it was asked, or parts
    that were left out for the question are there."""
    taken = [way for way in ways if all(part in document.out for part in way.parts)]
    there = [part for part in card.without if part not in document.out and part not in known.absent]
    if there:
        raise given.fail(
            "id",
            f"this was asked without {named(tuple(there), known)}",
            "take that out first, and ask again",
        )
    moved, gripped = card.world
    expected = {**dict(moved), **{part: document.moved.get(part) for way in taken for part in way.parts}}
    if taken == [*ways]:
        raise given.fail("id", "these parts are out already", "put them back, or ask again")
    if dict(document.moved) != expected or tuple(document.gripped) != gripped or taken != [*ways[: len(taken)]]:
        raise given.fail("id", "parts were moved since this was asked", "ask again, or undo that")
    return ways[len(taken) :]


def _taken(document: Document, way: Way, given: Arguments, known: Known) -> Document:
    gone = [part for part in way.parts if part in document.gripped or part in document.out or part in known.absent]
    if gone:
        path = known.parts[gone[0]].path
        raise WorkbenchError(f"{path} is not in its place any more", given.command, "put it back, or ask again")
    boxes = {part: np.array([known.parts[part].lower, known.parts[part].upper]) for part in way.parts}
    starts = {part: motion.matrix(document.moved.get(part, motion.HOME)) for part in way.parts}
    around = np.concatenate(
        [motion.corners(box) @ starts[part][:3, :3].T + starts[part][:3, 3] for part, box in boxes.items()]
    )
    hand = motion.shifted(np.round((around.min(axis=0) + around.max(axis=0)) / 2 / _GRID_M) * _GRID_M)
    last = motion.matrix(way.poses[-1])
    placed = {part: motion.row(last @ start) for part, start in starts.items()}
    line = Removal(
        id=document.next_id,
        name=named(way.parts, known),
        parts=way.parts,
        way=tuple(motion.row(motion.matrix(pose) @ hand) for pose in way.poses),
        least_clearance=way.clearance,
        touched=(),
        tool=None,
        starts=tuple((part, document.moved[part]) for part in way.parts if part in document.moved),
        out=way.parts,
    )
    return document.with_id(
        moved=MappingProxyType(dict(sorted({**document.moved, **placed}.items()))),
        out=tuple(sorted({*document.out, *way.parts})),
        sequence=(*document.sequence, line),
    )


def _options(document: Document, given: Arguments, known: Known, question: str) -> dict[str, Any]:
    found: dict[str, Any] = {}
    is_chosen = question == "access" and given.has("catalogue") and given.flag("catalogue")
    others = ("tool", "tools", "grip", "swing_deg", "people", "catalogue")
    for each in _NOT_OF.get("catalogue" if is_chosen else question, others):
        if given.has(each):
            raise given.fail(each, f"this question has no {each}", "leave it out")
    if given.has("clearance"):
        found["clearance"] = given.number("clearance", 0.0, 1e3)
    if given.has("seconds"):
        found["seconds"] = given.number("seconds", 0.1, LONGEST_S)
    if question == "task":
        if given.has("tools"):
            # An empty list: their reach is not checked.
            found["tools"] = _tools(given, known) if len(given.raw("tools", list[str])) else []
        if given.has("people"):
            found["people"] = given.whole("people", 1, MOST_PEOPLE)
    if question != "access":
        return found
    if is_chosen:
        found["catalogue"] = True
    if given.has("tools"):
        found["tools"] = _tools(given, known)
    elif not is_chosen:
        name = given.choice("tool", known.tools) if given.has("tool") else document.tool and document.tool.name
        if name is None:
            raise given.fail("tool", "the hand holds no tool", f"name one: {', '.join(list(known.tools)[:8])}")
        found["tool"] = name
    if given.has("grip"):
        found["grip"] = given.choice("grip", GRIP_AXES)
    if given.has("swing_deg"):
        found["swing_deg"] = given.number("swing_deg", 1e-3, 360.0)
    return found


def _tools(given: Arguments, known: Known) -> list[str]:
    """The tools to try, in the order in which they are preferred."""
    if given.has("tool"):
        raise given.fail("tools", "there is a tool beside them", "leave one of the two out")
    names: Any = given.raw("tools", list[str])
    if not is_sequence(names) or not names or not all(isinstance(name, str) for name in names):
        raise given.fail("tools", "this is not a list of tools", "send the names of some")
    for name in names:
        if name not in known.tools:
            raise given.fail("tools", f"there is no {name!r}", f"there are: {', '.join(list(known.tools)[:8])}")
    return list(dict.fromkeys(names))


def given_ways(given: Arguments, known: Known) -> tuple[Way, ...]:
    """The argument "ways"."""
    ways: Any = given.raw("ways", list[GivenWay])
    if not is_sequence(ways) or not ways:
        raise given.fail("ways", "this is not a list of ways", "send parts and poses")
    found = []
    for each in ways:
        inner = Arguments(
            f"{given.command}, ways", each, {"parts": Selection, "poses": list[Pose], "clearance": float | None}
        )
        poses: Any = inner.raw("poses", list[Pose])
        if not is_sequence(poses) or not 1 <= len(poses) <= _MOST_POSES:
            raise inner.fail("poses", "this is not a list of poses", f"send 1 to {_MOST_POSES} of 16 numbers")
        rows = tuple(motion.row(motion.checked(pose, f"{given.command}, poses")) for pose in poses)
        clearance = inner.number("clearance", 0.0) if inner.has("clearance") else None
        found.append(Way(inner.parts("parts", known.parts), rows, clearance))
    return tuple(found)


def _title(question: str, parts: tuple[int, ...], options: dict[str, Any], known: Known) -> str:
    group = _group(parts, known)
    what, is_one = group or named(parts, known), len(parts) == 1 or group != ""
    if question == "access" and ("tools" in options or "catalogue" in options):
        return f"Which tool reaches {what or 'which fasteners'}?"
    if question == "access":
        return f"Does the {options['tool']} reach {what or 'all fasteners'}?"
    if question == "task":
        return f"How {'is' if is_one else 'are'} {what} taken out?"
    if question == "order":
        return f"What has to go before {what} {'comes' if is_one else 'come'} out?"
    return f"Can {what} come out?" if question == "removal" else f"What room does {what} need to come out?"


def _group(parts: tuple[int, ...], known: Known) -> str:
    """The name of the group of the tree that these parts are; empty: they are one part, or no whole group."""
    if len(parts) < 2:
        return ""
    paths = [known.parts[part].path for part in parts]
    first, last = (each.split("/")[:-1] for each in (min(paths), max(paths)))
    folders = [one for one, _ in takewhile(lambda pair: pair[0] == pair[1], zip(first, last, strict=False))]
    if not folders or {each.index for each in known.parts.find("/".join(folders))} - known.absent != {*parts}:
        return ""
    return folders[-1]


def named(parts: tuple[int, ...], known: Known) -> str:
    """The name of the only part, or of the first and how many more; empty for none."""
    names = [known.parts[part].name for part in parts[:1]]
    return "".join(names) + (f" and {len(parts) - 1} more" if len(parts) > 1 else "")


def _setting(document: Document, left_out: tuple[int, ...], known: Known) -> str:
    """Which mock-up the question is about: what is out of it, or elsewhere."""
    elsewhere = [part for part in document.moved if part not in document.out]
    told = [f"{plural(len(document.out), 'part')} out"] if document.out else []
    told += [f"{plural(len(elsewhere), 'part')} moved"] if elsewhere else []
    told += [f"{plural(len(document.gripped), 'part')} in hand left out"] if document.gripped else []
    told += [f"without {named(left_out, known)}"] if left_out else []
    return ", ".join(told) if told else "as loaded"


def line_setting(at: int) -> str:
    """The same for a line of the sequence at a place."""
    return f"after {plural(at, 'step')} of the sequence" if at else "before the first step of the sequence"


def told(document: Document, number: int, **changes: Any) -> Document:
    """The document with changes of a card; unchanged if the card is gone."""
    cards = tuple(replace(card, **changes) if card.id == number else card for card in document.cards)
    return with_checked_lines(replace(document, cards=cards))
