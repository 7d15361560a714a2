"""Numbers and counts as text."""

from __future__ import annotations

import math
import re
import unicodedata


def length(metres: float) -> str:
    """A length with a suitable unit."""
    if not math.isfinite(metres):
        return "an unknown length"
    for factor, unit in ((1.0, "m"), (1e3, "mm"), (1e6, "µm"), (1e9, "nm")):
        # Rounded first, so that no length reads "1000 µm".
        shown = float(f"{metres * factor:.4g}")
        if abs(shown) >= 1.0:
            return f"{shown:.6g} {unit}"
    return f"{metres:.4g} m"


_DECIMALS = {"mm": (1e-3, 2), "cm": (1e-2, 3), "m": (1.0, 5), "in": (0.0254, 4)}
"""Metres of each unit of the workbench, and the digits after the point that show a hundredth of a millimetre in it."""


def length_in(metres: float, unit: str) -> str:
    """A length in a unit of the workbench, with the digits that its page shows; a smaller one with two that count."""
    if not math.isfinite(metres):
        return "an unknown length"
    per_unit, decimals = _DECIMALS[unit]
    value = metres / per_unit + 0.0  # no length reads "-0"
    shown = f"{value:.{decimals}f}".rstrip("0").rstrip(".")
    return f"{shown if float(shown) or not value else f'{value:.2g}'} {unit}"


def volume(cubic_metres: float) -> str:
    """A volume with a suitable unit."""
    if not math.isfinite(cubic_metres):
        return "unknown"
    for factor, unit in ((1.0, "m³"), (1e3, "l"), (1e6, "cm³")):
        if cubic_metres * factor >= 1.0:
            return f"{cubic_metres * factor:.4g} {unit}"
    return f"{cubic_metres * 1e9:.4g} mm³"


def plural(number: int, noun: str) -> str:
    """A number with its noun, given in the singular: "1 part", "2 vertices"."""
    return f"{number:,} {noun if number == 1 else _PLURALS.get(noun, noun + 's')}"


def counted(number: int, sentence: str) -> str:
    """A number before a sentence in the plural, which becomes singular for 1: "1 line was ignored".

    Its noun is the first word that ends as a plural; verbs are changed up to the first colon or semicolon.
    """
    if number != 1:
        return f"{number:,} {sentence}"
    clause, rest = re.match(r"([^:;]*)(.*)", sentence, re.DOTALL).groups()  # type: ignore[union-attr]
    words = clause.split(" ")
    noun = next((place for place, word in enumerate(words) if word in _SINGULARS or _PLURAL.fullmatch(word)), None)
    if noun is not None:
        words[noun] = _SINGULARS.get(words[noun], words[noun].removesuffix("s"))
        words[noun + 1 :] = [_VERBS.get(word, word) for word in words[noun + 1 :]]
    return "1 " + " ".join(words) + rest


def printable(text: str) -> str:
    """Text without the control characters of terminals, which names in files may have: they are shown as code."""
    return "".join(each if each in "\n\t" or each.isprintable() or each == "\xa0" else _code(each) for each in text)


def _code(letter: str) -> str:
    """A character as Python writes it, a byte of a name that is not UTF-8 as a byte; other separators and joiners of
    words stay as they are."""
    if "\udc80" <= letter <= "\udcff":
        return f"\\x{ord(letter) - 0xDC00:02x}"
    is_control = unicodedata.category(letter) in ("Cc", "Cs") or letter in _BIDI or ord(letter) & 0xFFFE == 0xFFFE
    return letter.encode("unicode_escape").decode() if is_control else letter


_BIDI = "\u202a\u202b\u202c\u202d\u202e\u2066\u2067\u2068\u2069"
"""Characters that turn the order of the text after them."""


_PLURALS = {
    "vertex": "vertices",
    "mesh": "meshes",
    "geometry": "geometries",
    "index": "indices",
    "box": "boxes",
    "status": "statuses",
}
_SINGULARS = {many: one for one, many in _PLURALS.items()}
_PLURAL = re.compile(r"[a-z]+[a-rt-z]s")
_VERBS = {
    **{
        "were": "was",
        "are": "is",
        "have": "has",
        "their": "its",
        "themselves": "itself",
        "cross": "crosses",
        "touch": "touches",
    },
    **{verb: verb + "s" for verb in ("add", "hold", "make", "mirror", "name", "need", "scale", "state", "take")},
}
