"""Which parts `fasteners = true` means: by name, by shape, or both.

A name decides where its last noun does: "hex bolt", "Mutter M8", "DIN 912 M8x30" are fasteners, "nut housing" and
"lead screw" are not. Where the name says nothing, the shape decides, as `feeler.find_fasteners` measures it.
"""

from __future__ import annotations

import re
import unicodedata
from collections.abc import Callable, Sequence

import numpy as np
import numpy.typing as npt

from feeler.mockup import Mockup
from feeler.plan.fastener_names import KINDS, OTHERS, STANDARDS

NOUNS = (
    "washer washers lockwasher springwasher rivet rivets circlip circlips dowel dowels cotter cotters unterlegscheibe "
    "unterlegscheiben federscheibe federring sicherungsscheibe sicherungsring innensechskantschraube senkschraube "
    "linsenschraube gewindestift passschraube blechschraube schrauben muttern niet niete nieten stiftschrauben "
    "splint zylinderstift kegelstift tornillos pernos tuercas arandela arandelas remache rondelle ecrous boulons "
    "rondella dadi viti"
)
"""Fasteners beside those of `fastener_names.KINDS`, as the last noun of a name without accents."""

SIZED = "scheibe scheiben pin pins stift"
"""Nouns that name a fastener only beside the size of a thread, such as "Scheibe M8"."""

QUALIFIERS = "lead ball feed worm power jack acme drive extruder propeller archimedes leit kugel vorschub pressure car"
"""Words before a noun that make it another machine element, such as "lead screw"."""

NEUTRAL = (
    "left right top bottom upper lower front rear back inner outer main copy mirror mirrored instance default part "
    "assy asm zinc plated steel stainless black brass galvanised galvanized verzinkt links rechts oben unten vorne "
    "hinten din iso asme ansi grade class unc unf"
)
"""Words behind a noun that do not change what it names."""

PREPOSITIONS = "for of with on in to at from by fuer fur zu mit von am im pour de du para per di"
"""Words that end what a name says of the part itself."""

MORE_STANDARDS = (
    "125 126 127 137 433 6796 6797 6798 6905 7089 7090 7091 7092 7093 7349 7980 9021 660 661 7337 94 471 472"
)
"""Numbers of DIN and ISO standards for washers, rivets, cotters and circlips."""

_STANDARD = re.compile(r"(?<![a-z])(?:din|iso|en)[ _-]*(?:en[ _-]*)?(?:iso[ _-]*)?(\d{2,5})(?!\d)", re.IGNORECASE)
_AMERICAN = re.compile(r"(?<![a-z])(?:asme|ansi)[ _/-]*(?:asme[ _-]*)?b18(?!\d)", re.IGNORECASE)
_THREAD = re.compile(r"(?<![a-z0-9])m\d+(?:[.,]\d+)?(?: ?x ?\d+(?:[.,]\d+)?)?(?![a-z0-9])", re.IGNORECASE)
_THREAD_AND_LENGTH = re.compile(r"(?<![a-z0-9])m\d+(?:[.,]\d+)? ?x ?\d+", re.IGNORECASE)
_WORD = re.compile(r"[A-Z]?[a-z]+|[A-Z]+(?![a-z])")

_NAMELESS = re.compile(r"(body|solid|shell|part|mesh|shape|compound|object|volume)?[ _#-]*\d*", re.IGNORECASE)
"""What CAD systems call a solid that nobody named: its parent has the name."""

_NOUNS = frozenset([*NOUNS.split(), *" ".join(KINDS.values()).split()])
_SIZED, _QUALIFIERS, _NEUTRAL = frozenset(SIZED.split()), frozenset(QUALIFIERS.split()), frozenset(NEUTRAL.split())
_PREPOSITIONS = frozenset(PREPOSITIONS.split())
_STANDARD_NUMBERS = frozenset([*MORE_STANDARDS.split(), *" ".join(STANDARDS.values()).split()])
_OTHERS = frozenset(OTHERS.split()) - _NOUNS - _SIZED

Shaped = Callable[[], npt.NDArray[np.bool_]]
"""Which parts have the shape of a fastener, `(parts,)`; called only when a rule asks."""


def fastener_mask(paths: Sequence[str], shaped: Shaped | None = None) -> npt.NDArray[np.bool_]:
    """Which parts are fasteners, `(parts,)`; `shaped` decides those whose name says nothing."""
    said = [is_fastener(path) for path in paths]
    mask = np.array([each is True for each in said], dtype=bool)
    if shaped is not None:
        mask |= shaped() & np.array([each is None for each in said], dtype=bool)
    return mask


def shape_of(mockup: Mockup) -> Shaped:
    """The shapes of a mock-up's parts, for `fastener_mask`."""

    def shaped() -> npt.NDArray[np.bool_]:
        from feeler.plan.fasteners import shaped_as_fasteners

        mask = np.zeros(mockup.part_count, dtype=bool)
        mask[shaped_as_fasteners(mockup)] = True
        return mask

    return shaped


def is_fastener(path: str) -> bool | None:
    """Whether a part is called as fasteners are; None where its name does not say.

    A part that nobody named ("Body", "Solid1") has the name of the assembly that it is in.
    """
    folder, _, name = path.rpartition("/")
    if _NAMELESS.fullmatch(name):
        name = folder.rpartition("/")[2]
    plain = "".join(each for each in unicodedata.normalize("NFKD", name) if not unicodedata.combining(each))
    words = [word.lower() for word in _WORD.findall(_THREAD.sub(" ", plain))]
    words = [word for word in words if len(word) > 2 or word in _PREPOSITIONS]
    for place, word in enumerate(words):
        if place and word in _PREPOSITIONS:
            words = words[:place]
            break
    words = [word for word in words if word not in _NEUTRAL]
    last = words[-1] if words else ""
    if last in _OTHERS or (last in _NOUNS and not _QUALIFIERS.isdisjoint(words[:-1])):
        return False
    numbers = [match.group(1) for match in _STANDARD.finditer(plain)]
    if _AMERICAN.search(plain) or not _STANDARD_NUMBERS.isdisjoint(numbers) or last in _NOUNS:
        return True
    if _THREAD.search(plain) and (last in _SIZED or (not last and _THREAD_AND_LENGTH.search(plain))):
        return True
    return None
