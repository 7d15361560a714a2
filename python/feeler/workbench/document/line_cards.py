"""Commands of cards about lines of the sequence: does the way hold, and how short can it be."""

from __future__ import annotations

from dataclasses import replace
from types import MappingProxyType

from feeler.errors import WorkbenchError
from feeler.workbench.document import motion
from feeler.workbench.document.arguments import Arguments, replaced
from feeler.workbench.document.cards import MOST_CARDS, given_ways, line_setting
from feeler.workbench.document.document import Card, Document, Removal, is_stale, line_world
from feeler.workbench.document.known import Known, Way
from feeler.workbench.document.line_facts import with_checked_lines
from feeler.workbench.document.protocol import LineQuestion


def way_check(document: Document, given: Arguments, _known: Known) -> Document:
    """Asks whether the way of a line of the sequence holds: at every pose, and between them."""
    return _asked(document, given, "way")


def way_shorten(document: Document, given: Arguments, _known: Known) -> Document:
    """Asks for a shorter way of a line of the sequence, of straight legs, with the same begin and end."""
    return _asked(document, given, "shorten")


def way_keep(document: Document, given: Arguments, known: Known) -> Document:
    """Puts the shorter way of a card into the sequence: in place of the line's, or after it as another line.

    `ways`, of `line`: instead of the card's, as a record has them.
    """
    is_added = given.has("is_added") and given.flag("is_added")
    card: Card | None = None
    if given.has("ways"):
        ways = given_ways(given, known)
        at = given.place_of(document.sequence, "line")
    else:
        card = document.cards[given.place_of(document.cards)]
        ways = known.ways.get(card.id, ())
        if card.question != "shorten" or not card.is_good or not ways:
            raise given.fail("id", "this card has no shorter way", "ask for one first")
        if is_stale(document, card):
            raise given.fail("id", "its way, or what is around it, is another one now", "ask again, or undo that")
        at = next(at for at, line in enumerate(document.sequence) if line.id == card.line)
    (way,) = ways if len(ways) == 1 else (None,)
    line = document.sequence[at]
    if way is None or set(way.parts) != set(line.parts):
        raise given.fail("ways", "this is not one way of the parts of that line", "send one way of these parts")
    new = _with_way(line, way)
    if is_added:
        new = replace(new, id=document.next_id, name=f"{line.name}, shorter")
        document = document.with_id(sequence=(*document.sequence[: at + 1], new, *document.sequence[at + 1 :]))
        at += 1
    else:
        document = replace(document, sequence=replaced(document.sequence, at, new))
    if card is None:
        return document
    # Its answer is about the line as it is now. Undo makes it stale.
    kept = replace(
        card,
        question="way",
        title=_title("way", new),
        sentence=card.sentence.replace("The way can be", "The way was made", 1),
        line=new.id,
        way=new.way_key,
        world=line_world(document, at),
    )
    others = [each for each in document.cards if each.id == card.id or (each.line, each.question) != (new.id, "way")]
    cards = tuple(kept if each.id == card.id else each for each in others)
    return with_checked_lines(replace(document, cards=cards))


def _asked(document: Document, given: Arguments, question: LineQuestion) -> Document:
    at = given.place_of(document.sequence)
    line = document.sequence[at]
    # The newer answer replaces the older one.
    others = tuple(card for card in document.cards if (card.line, card.question) != (line.id, question))
    if len(others) >= MOST_CARDS:
        raise WorkbenchError(f"there are {MOST_CARDS} cards already", given.command, "remove some first")
    card = Card(
        id=document.next_card,
        question=question,
        parts=line.parts,
        without=(),
        options=MappingProxyType({}),
        title=_title(question, line),
        setting=line_setting(at),
        world=line_world(document, at),
        line=line.id,
        way=line.way_key,
    )
    return replace(document, cards=(*others, card), next_card=card.id + 1)


def _title(question: LineQuestion, line: Removal) -> str:
    return f"Does the way of {line.name} hold?" if question == "way" else f"Is there a shorter way of {line.name}?"


def _with_way(line: Removal, way: Way) -> Removal:
    """A line on another way with the same end, to the last digit: the parts lie where they lay."""
    first = motion.matrix(line.way[0])
    between = tuple(motion.row(motion.matrix(pose) @ first) for pose in way.poses[1:-1])
    return replace(line, way=(line.way[0], *between, line.way[-1]), least_clearance=way.clearance, touched=())
