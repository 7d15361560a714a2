"""Finds the parts that `fasteners = true` means, by name and by shape.

The last noun of the name decides: "hex bolt", "Mutter M8" and "DIN 912 M8x30" are fasteners, "nut housing" and "lead
screw" are not. In French, Italian and Spanish it is the first, with a size or known words behind: "Vis CHC M6",
"Rondelle plate". If the name does not tell, as in "bolt-on bracket" and "Flansch DIN 933", the shape decides, as in
`feeler.find_fasteners`. Parts too large for a fastener are none, whatever their name.
"""

from __future__ import annotations

import re
from collections.abc import Callable, Sequence

import numpy as np
import numpy.typing as npt

from feeler.mockup import Mockup
from feeler.plan.fastener_names import ENDINGS, GENERIC, KINDS, OTHERS, PLACES, STANDARDS, telling_name, without_accents

NOUNS = (
    "washer washers lockwasher springwasher rivet rivets circlip circlips dowel dowels cotter cotters unterlegscheibe "
    "unterlegscheiben federscheibe federring sicherungsscheibe sicherungsring innensechskantschraube senkschraube "
    "linsenschraube gewindestift passschraube blechschraube schrauben muttern niet niete nieten stiftschrauben "
    "splint zylinderstift kegelstift tornillos pernos tuercas arandela arandelas remache rondelle ecrous boulons "
    "rondella dadi viti"
)
"""Nouns for fasteners in addition to `fastener_names.KINDS`, without accents."""

SIZED = "scheibe scheiben pin pins stift"
"""Nouns that name a fastener only beside the size of a thread, such as "Scheibe M8"."""

FIRST = (
    "vis vite viti tornillo tornillos tuerca tuercas arandela arandelas remache remaches rondelle rondelles rondella "
    "ecrou ecrous boulon boulons bullone bulloni dado dadi"
)
"""Nouns for fasteners in languages in which they come first, without accents."""

DESCRIBING = (
    "tete tetes chc fhc btr cbhc hexagonale hexagonal hexagonaux pans creux fraisee bombee cylindrique autoforeuse "
    "autotaraudeuse inox acier zingue zinguee plate plates eventail frein ressort papillon borgne epaulee grower testa "
    "tcei tspei tbei tcce esagonale esagonali svasata cilindrica bombata zincato zincata autofilettante piana piane "
    "elastica dentellata autobloccante cieco flangiato cabeza allen avellanado avellanada hexagonales autorroscante "
    "autoblocante inoxidable plana planas mariposa ciega"
)
"""Words behind such a noun that describe a fastener."""

HEADS = "head hex hexagon hexagonal sechskant innensechskant zylinderkopf senkkopf linsenkopf socket cap form type"
"""Words beside the number of a standard that leave the part to it."""

KEEPERS_BEFORE = (
    "abdeckung halter halterung deckel platte blech gehaeuse gehause kappe haube buchse huelse hulse rahmen"
)
"""German words before a noun that name the part: "Abdeckung Schraube" is a cover."""

ENDINGS_OF_STANDARD = "scheibe scheiben stift stifte niet niete nieten bolzen splint"
"""How German nouns end, in addition to `fastener_names.ENDINGS`, that are fasteners beside the number of a standard."""

MOVING = (
    "mere sans bille billes trapezoidale archimede senza ricircolo sfere trapezia manovra sin bolas potencia arquimedes"
)
"""Words behind such a noun that make it a machine element, such as "vis sans fin"."""

QUALIFIERS = (
    "lead ball feed worm power jack acme drive extruder propeller archimedes leit kugel vorschub pressure car dish "
    "parts bottle wall"
)
"""Words before a noun that make it another thing, such as "lead screw" and "dish washer"."""

NEUTRAL = (
    "left right top bottom upper lower front rear back inner outer main copy mirror mirrored instance default part "
    "assy asm zinc plated steel stainless black brass galvanised galvanized verzinkt links rechts oben unten vorne "
    "hinten din iso asme ansi grade class style normal unc unf"
)
"""Words after a noun that do not change its meaning."""

PREPOSITIONS = "for of with on in to at from by fuer fur zu mit von am im pour de du para per di"
"""Words after which a name no longer describes the part itself."""

MORE_STANDARDS = (
    "125 126 127 137 433 6796 6797 6798 6905 7089 7090 7091 7092 7093 7349 7980 9021 660 661 7337 94 471 472"
)
"""Numbers of DIN and ISO standards for washers, rivets, cotters and circlips."""

_STANDARD = re.compile(r"(?<![a-z])(?:din|iso|en)[ _-]*(?:en[ _-]*)?(?:iso[ _-]*)?(\d{2,5})(?!\d)", re.IGNORECASE)
_AMERICAN = re.compile(r"(?<![a-z])(?:asme|ansi)[ _/-]*(?:asme[ _-]*)?b18(?!\d)", re.IGNORECASE)
_THREAD = re.compile(r"(?<![a-z0-9])m\d+(?:[.,]\d+)?(?: ?x ?\d+(?:[.,]\d+)?)?(?![a-z0-9])", re.IGNORECASE)
_THREAD_AND_LENGTH = re.compile(r"(?<![a-z0-9])m\d+(?:[.,]\d+)? ?x ?\d+", re.IGNORECASE)
_WORD = re.compile(r"[A-Z]?[a-z]+|[A-Z]+(?![a-z])")
_BRACKETS = re.compile(r"\([^()]*\)|\[[^][]*\]")
_PHRASES = re.compile(r"\s-+\s|[,;](?!\d)")

_FACING = re.compile(r"(?<![a-z])vis[ _-]*a[ _-]*vis(?![a-z])", re.IGNORECASE)
"""French for "face to face"."""

_NOUNS = frozenset([*NOUNS.split(), *" ".join(KINDS.values()).split()])
_SIZED, _QUALIFIERS = frozenset(SIZED.split()), frozenset(QUALIFIERS.split())
_NEUTRAL = frozenset([*NEUTRAL.split(), *GENERIC.split()])
_FIRST, _DESCRIBING, _MOVING = frozenset(FIRST.split()), frozenset(DESCRIBING.split()), frozenset(MOVING.split())
_PREPOSITIONS, _PLACES = frozenset(PREPOSITIONS.split()), frozenset(PLACES.split())
_HEADS, _KEEPERS_BEFORE = frozenset(HEADS.split()), frozenset(KEEPERS_BEFORE.split())
_ENDINGS = (*ENDINGS, *ENDINGS_OF_STANDARD.split())
_STANDARD_NUMBERS = frozenset([*MORE_STANDARDS.split(), *" ".join(STANDARDS.values()).split()])
_OTHERS = frozenset(OTHERS.split()) - _NOUNS - _SIZED

Shaped = Callable[[], npt.NDArray[np.bool_]]
"""Returns which parts have the shape of a fastener, and which are small enough for one, `(2, parts)`. Called only if a
rule needs it."""


def fastener_mask(paths: Sequence[str], shaped: Shaped | None = None) -> npt.NDArray[np.bool_]:
    """Which parts are fasteners, `(parts,)`. `shaped` refuses large ones, and decides where the name does not tell."""
    said = [is_fastener(path) for path in paths]
    mask = np.array([each is True for each in said], dtype=bool)
    if shaped is not None:
        is_shaped, is_small = shaped()
        mask = (mask & is_small) | (is_shaped & np.array([each is None for each in said], dtype=bool))
    return mask


def shape_of(mockup: Mockup) -> Shaped:
    """A function for `fastener_mask` that examines the shapes of the parts."""

    def shaped() -> npt.NDArray[np.bool_]:
        from feeler.plan.fasteners import shaped_as_fasteners, sized_as_fasteners

        mask = np.zeros(mockup.part_count, dtype=bool)
        mask[shaped_as_fasteners(mockup)] = True
        return np.stack([mask, sized_as_fasteners(mockup)])

    return shaped


def is_fastener(path: str) -> bool | None:
    """Whether the name is that of a fastener; None if it does not tell.

    A part with a default name ("Body", "Solid1", "Cylinder.001") takes the name of its assembly.
    """
    name = without_accents(telling_name(path))
    plain = _FACING.sub(" ", name)
    # What follows in brackets or behind a dash describes: "Bracket (bolt)" is a bracket, "Cover - screw" a cover.
    phrases = [*_PHRASES.split(_BRACKETS.sub(" ", plain)), plain]
    text = next((phrase for phrase in phrases if _said(phrase) != []), "")
    words = _said(text)
    if words is None:
        return None
    if words and words[0] in _FIRST and not _MOVING.isdisjoint(words):
        return False
    last = words[-1] if words else ""
    has_standard = _has_standard(plain)
    if words and words[0] in _FIRST:
        is_described = has_standard or _THREAD.search(plain) or not _DESCRIBING.isdisjoint(words[1:])
        if last in _DESCRIBING or (last not in _OTHERS and is_described):
            return True
    if last in _OTHERS or (last in _NOUNS and not _QUALIFIERS.isdisjoint(words[:-1])):
        return False
    if last in _NOUNS:
        is_behind = last in _FIRST and any(word not in _PLACES for word in words[: words.index(last)])
        return None if is_behind or not _KEEPERS_BEFORE.isdisjoint(words[:-1]) else True
    if has_standard and _is_of_standard(text, last):
        return True
    if _THREAD.search(plain) and (last in _SIZED or (not last and _THREAD_AND_LENGTH.search(plain))):
        return True
    return None


def _said(phrase: str) -> list[str] | None:
    """The words that say what a part is; None if they end in one as in "bolt-on", which may describe another part."""
    words = [word.lower() for word in _WORD.findall(_THREAD.sub(" ", phrase))]
    words = [word for word in words if len(word) > 2 or word in _PREPOSITIONS]
    for place, word in enumerate(words):
        if place and word in _PREPOSITIONS:
            if word in ("on", "in") and words[place - 1] in _NOUNS:
                return None
            words = words[:place]
            break
    return [word for word in words if word not in _NEUTRAL]


def _has_standard(plain: str) -> bool:
    """Whether a name has the number of a standard for fasteners."""
    numbers = [match.group(1) for match in _STANDARD.finditer(plain)]
    return _AMERICAN.search(plain) is not None or not _STANDARD_NUMBERS.isdisjoint(numbers)


def _is_of_standard(text: str, last: str) -> bool:
    """Whether the standard in a name is that of the part: it has no other noun, or a fastener's before the standard."""
    if not last or last in _SIZED or last in _HEADS or last in _DESCRIBING or last.endswith(_ENDINGS):
        return True
    match = _STANDARD.search(text) or _AMERICAN.search(text)
    before = (_said(text[: match.start()]) if match else None) or [""]
    return before[-1] in _NOUNS or before[-1].endswith(_ENDINGS)
