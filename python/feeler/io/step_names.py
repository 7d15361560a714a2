"""What a STEP file says in its text: units, and the product names that the converter leaves out.

The converter names a node after its occurrence. Where an occurrence has no name it takes its number ("130"), though the
product it places has a name ("Blades"). The text has both.
"""

from __future__ import annotations

import re
from typing import Any

from feeler.io.units import Unit, parse_unit

_STRING = rb"'((?:[^']|'')*)'"
_ANY = rb"(?:'(?:[^']|'')*'|\$)"
_NEXT = rb"\s*,\s*"
_OCCURRENCE = re.compile(
    rb"NEXT_ASSEMBLY_USAGE_OCCURRENCE\s*\(\s*" + _NEXT.join([_STRING, _STRING, _ANY, rb"#(\d+)", rb"#(\d+)"])
)
_DEFINITION = re.compile(rb"#(\d+)\s*=\s*PRODUCT_DEFINITION\s*\(\s*" + _NEXT.join([_ANY, _ANY, rb"#(\d+)"]))
_FORMATION = re.compile(
    rb"#(\d+)\s*=\s*PRODUCT_DEFINITION_FORMATION(?:_WITH_SPECIFIED_SOURCE)?\s*\(\s*"
    + _NEXT.join([_ANY, _ANY, rb"#(\d+)"])
)
_PRODUCT = re.compile(rb"#(\d+)\s*=\s*PRODUCT\s*\(\s*" + _NEXT.join([_STRING, _STRING]))
_CONTEXT = re.compile(rb"GLOBAL_UNIT_ASSIGNED_CONTEXT\s*\(\s*\(([^)]*)\)")
_LENGTH_UNIT = re.compile(rb"#(\d+)\s*=\s*\(([^;]*?\bLENGTH_UNIT\b[^;]*)\)\s*;")
_SI = re.compile(rb"SI_UNIT\s*\(\s*(?:\.(\w+)\.|\$)\s*,\s*\.METRE\.")
_CONVERTED = re.compile(rb"CONVERSION_BASED_UNIT\s*\(\s*" + _STRING)
_PREFIXES = {
    b"KILO": "km", b"DECI": "dm", b"CENTI": "cm", b"MILLI": "mm", b"MICRO": "um", b"NANO": "nm", b"": "m",
}  # fmt: skip


def stated_units(text: bytes) -> list[Unit | None]:
    """Return the length units the shapes of the file are in, each once; None for one that feeler has no name for."""
    entities = {m[1]: m[2] for m in _LENGTH_UNIT.finditer(text)}
    found: list[Unit | None] = []
    for context in _CONTEXT.finditer(text):
        for reference in re.findall(rb"#(\d+)", context[1]):
            if reference in entities:
                unit = _unit_of(entities[reference])
                if unit not in found:
                    found.append(unit)
    return found


def _unit_of(entity: bytes) -> Unit | None:
    try:
        if name := _CONVERTED.search(entity):
            return parse_unit(name[1].decode("ascii", "replace"))
        if prefix := _SI.search(entity):
            return parse_unit(_PREFIXES.get(prefix[1] or b"", "?"))
    except ValueError:
        pass
    return None


class ProductNames:
    """The assembly structure in the text of a STEP file."""

    def __init__(self, text: bytes) -> None:
        products = {m[1]: _decode(m[3] or m[2]) for m in _PRODUCT.finditer(text)}
        formations = {m[1]: m[2] for m in _FORMATION.finditer(text)}
        self._name = {m[1]: products.get(formations.get(m[2], b""), "") for m in _DEFINITION.finditer(text)}
        self._below: dict[bytes, dict[str, tuple[bytes, bool]]] = {}
        placed: set[bytes] = set()
        for number, name, above, below in (m.groups() for m in _OCCURRENCE.finditer(text)):
            label = _decode(name) or _decode(number)
            self._below.setdefault(above, {}).setdefault(label, (below, not name))
            placed.add(below)
        self._roots = {
            self._name[definition]: definition for definition in reversed(self._name) if definition not in placed
        }

    def edit(self, root: dict[str, Any]) -> None:
        """Give the nodes of a converted file the names of their products where they have only a number."""
        nodes = root.get("nodes", [])
        todo: list[tuple[int, bytes | None, bool]] = [
            (at, None, True) for scene in root.get("scenes", []) for at in scene.get("nodes", [])
        ]
        while todo:
            at, above, is_root = todo.pop()
            node = nodes[at]
            label = node.get("name", "")
            here: bytes | None = None
            if is_root:
                here = self._roots.get(label)
            elif above is not None and label in self._below.get(above, {}):
                here, nameless = self._below[above][label]
                if nameless and self._name.get(here):
                    node["name"] = self._name[here]
            todo.extend((child, here, False) for child in node.get("children", []))


def _decode(text: bytes) -> str:
    """Return a STEP string as text: doubled quotes, and the escapes for characters beyond ASCII."""
    plain = text.replace(b"''", b"'").decode("latin-1")
    if "\\" not in plain:
        return plain
    plain = re.sub(
        r"\\X2\\((?:[0-9A-Fa-f]{4})+)\\X0\\", lambda m: bytes.fromhex(m[1]).decode("utf-16-be", "replace"), plain
    )
    plain = re.sub(r"\\X\\([0-9A-Fa-f]{2})", lambda m: chr(int(m[1], 16)), plain)
    plain = re.sub(r"\\S\\(.)", lambda m: chr(ord(m[1]) + 128) if ord(m[1]) < 128 else m[1], plain)
    return plain.replace("\\\\", "\\")
