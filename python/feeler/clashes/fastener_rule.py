"""Finds the parts that `fasteners = true` means, by name and by shape.

The last noun of the name decides: "hex bolt", "Mutter M8" and "DIN 912 M8x30" are fasteners, "nut housing" and "lead
screw" are not. In French, Italian and Spanish it is the first, with a size or known words behind: "Vis CHC M6",
"Rondelle plate". If the name does not tell, the shape decides, as in `feeler.find_fasteners`.
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

MOVING = (
    "mere sans bille billes trapezoidale archimede senza ricircolo sfere trapezia manovra sin bolas potencia arquimedes"
)
"""Words behind such a noun that make it a machine element, such as "vis sans fin"."""

QUALIFIERS = "lead ball feed worm power jack acme drive extruder propeller archimedes leit kugel vorschub pressure car"
"""Words before a noun that make it another machine element, such as "lead screw"."""

NEUTRAL = (
    "left right top bottom upper lower front rear back inner outer main copy mirror mirrored instance default part "
    "assy asm zinc plated steel stainless black brass galvanised galvanized verzinkt links rechts oben unten vorne "
    "hinten din iso asme ansi grade class unc unf"
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

_FACING = re.compile(r"(?<![a-z])vis[ _-]*a[ _-]*vis(?![a-z])", re.IGNORECASE)
"""French for "face to face"."""

_NAMELESS = re.compile(r"(body|solid|shell|part|mesh|shape|compound|object|volume)?[ _#-]*\d*", re.IGNORECASE)
"""Default names of CAD systems for solids: the parent has the meaningful name."""

_NOUNS = frozenset([*NOUNS.split(), *" ".join(KINDS.values()).split()])
_SIZED, _QUALIFIERS, _NEUTRAL = frozenset(SIZED.split()), frozenset(QUALIFIERS.split()), frozenset(NEUTRAL.split())
_FIRST, _DESCRIBING, _MOVING = frozenset(FIRST.split()), frozenset(DESCRIBING.split()), frozenset(MOVING.split())
_PREPOSITIONS = frozenset(PREPOSITIONS.split())
_STANDARD_NUMBERS = frozenset([*MORE_STANDARDS.split(), *" ".join(STANDARDS.values()).split()])
_OTHERS = frozenset(OTHERS.split()) - _NOUNS - _SIZED

Shaped = Callable[[], npt.NDArray[np.bool_]]
"""Returns which parts have the shape of a fastener, `(parts,)`. Called only if a rule needs it."""


def fastener_mask(paths: Sequence[str], shaped: Shaped | None = None) -> npt.NDArray[np.bool_]:
    """Which parts are fasteners, `(parts,)`. `shaped` decides parts whose name does not tell."""
    said = [is_fastener(path) for path in paths]
    mask = np.array([each is True for each in said], dtype=bool)
    if shaped is not None:
        mask |= shaped() & np.array([each is None for each in said], dtype=bool)
    return mask


def shape_of(mockup: Mockup) -> Shaped:
    """A function for `fastener_mask` that examines the shapes of the parts."""

    def shaped() -> npt.NDArray[np.bool_]:
        from feeler.plan.fasteners import shaped_as_fasteners

        mask = np.zeros(mockup.part_count, dtype=bool)
        mask[shaped_as_fasteners(mockup)] = True
        return mask

    return shaped


def is_fastener(path: str) -> bool | None:
    """Whether the name is that of a fastener; None if it does not tell.

    A part with a default name ("Body", "Solid1") takes the name of its assembly.
    """
    folder, _, name = path.rpartition("/")
    if _NAMELESS.fullmatch(name):
        name = folder.rpartition("/")[2]
    plain = "".join(each for each in unicodedata.normalize("NFKD", name) if not unicodedata.combining(each))
    words = [word.lower() for word in _WORD.findall(_THREAD.sub(" ", _FACING.sub(" ", plain)))]
    if words and words[0] in _FIRST and not _MOVING.isdisjoint(words):
        return False
    words = [word for word in words if len(word) > 2 or word in _PREPOSITIONS]
    for place, word in enumerate(words):
        if place and word in _PREPOSITIONS:
            words = words[:place]
            break
    words = [word for word in words if word not in _NEUTRAL]
    last = words[-1] if words else ""
    if words and words[0] in _FIRST and (last in _DESCRIBING or (last not in _OTHERS and _is_described(plain, words))):
        return True
    if last in _OTHERS or (last in _NOUNS and not _QUALIFIERS.isdisjoint(words[:-1])):
        return False
    numbers = [match.group(1) for match in _STANDARD.finditer(plain)]
    if _AMERICAN.search(plain) or not _STANDARD_NUMBERS.isdisjoint(numbers) or last in _NOUNS:
        return True
    if _THREAD.search(plain) and (last in _SIZED or (not last and _THREAD_AND_LENGTH.search(plain))):
        return True
    return None


def _is_described(plain: str, words: Sequence[str]) -> bool:
    """Whether a size, or words that describe a fastener, follow its noun."""
    return _THREAD.search(plain) is not None or not _DESCRIBING.isdisjoint(words[1:])
