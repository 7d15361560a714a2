"""Facts in the text of a STEP file: units, the assembly, and the names that the converter leaves out.

The converter names a node after its occurrence ("bolt-3", "R101"), or by a number if the occurrence has no name
("130"), and drops the product ("bolt", "resistor"). The occurrence distinguishes parts of one product, also in the
next revision; the product says what they are. The text has both, and `place_name` makes the name of a part from them.
"""

from __future__ import annotations

import re
from typing import Any, NamedTuple

from feeler.io.step_text import Entity, entities
from feeler.io.units import Unit, parse_unit

_CONTEXT = re.compile(rb"GLOBAL_UNIT_ASSIGNED_CONTEXT\s*\(\s*\(([^)]*)\)")
_LENGTH_UNIT = re.compile(rb"#(\d+)\s*=\s*\(([^;]*?\bLENGTH_UNIT\b[^;]*)\)\s*;")
_SI = re.compile(rb"SI_UNIT\s*\(\s*(?:\.(\w+)\.|\$)\s*,\s*\.METRE\.")
_CONVERTED = re.compile(rb"CONVERSION_BASED_UNIT\s*\(\s*'((?:[^']|'')*)'")
_PREFIXES = {
    b"KILO": "km", b"DECI": "dm", b"CENTI": "cm", b"MILLI": "mm", b"MICRO": "um", b"NANO": "nm", b"": "m",
}  # fmt: skip
_NO_NAME = re.compile(r"(?:=>)?\[\d+(?::\d+)*\]$")  # where the converter keeps a shape that has no name
# Names that programs give to occurrences for want of one: a bare number, NAUO12.
_NUMBERED = re.compile(r"(?:nauo|next_assembly_usage_occurrence|occurrence|instance)?[\W\d_]*", re.IGNORECASE)
_UUID = re.compile(r"[0-9a-f]{8}(?:-[0-9a-f]{4}){3}-[0-9a-f]{12}", re.IGNORECASE)  # for want of a product's name
DEFINITIONS = ("PRODUCT_DEFINITION", "PRODUCT_DEFINITION_WITH_ASSOCIATED_DOCUMENTS")
FORMATIONS = ("PRODUCT_DEFINITION_FORMATION", "PRODUCT_DEFINITION_FORMATION_WITH_SPECIFIED_SOURCE")


def stated_units(text: bytes) -> list[Unit | None]:
    """Return the length units of the shapes in the file, each once; None for an unknown one."""
    found_entities = {m[1]: m[2] for m in _LENGTH_UNIT.finditer(text)}
    found: list[Unit | None] = []
    for context in _CONTEXT.finditer(text):
        for reference in re.findall(rb"#(\d+)", context[1]):
            if reference in found_entities:
                unit = _unit_of(found_entities[reference])
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


class Occurrence(NamedTuple):
    """One product placed in another."""

    label: str  # the converter's name
    definition: int  # the PRODUCT_DEFINITION entity of the placed product
    name: str = ""  # the name of the place, "" if it has none of its own


def place_name(occurrence: str, product: str) -> str:
    """Return the name of a product at its place: "bolt-3", "R101 (resistor)", or "bolt" for a place without a name."""
    if _NUMBERED.fullmatch(occurrence) or occurrence.casefold() == product.casefold():
        return product
    tells_all = product.casefold() in occurrence.casefold() or _UUID.fullmatch(product)
    return occurrence if tells_all else f"{occurrence} ({product})"


class Assembly:
    """The products in the text of a STEP file, and their placements. Numbers are entity numbers."""

    def __init__(self, text: bytes) -> None:
        """Read it. `text` is as `plain_text` returns it."""
        found: dict[str, list[Entity]] = {}
        for entity in entities(text, "PRODUCT", *FORMATIONS, *DEFINITIONS, "NEXT_ASSEMBLY_USAGE_OCCURRENCE"):
            found.setdefault(entity.keyword, []).append(entity)
        products = {e.number: e.text(1) or e.text(0) for e in found.get("PRODUCT", [])}
        self.product_of = {e.number: e.refers(2) for key in FORMATIONS for e in found.get(key, [])}
        definitions = [e for key in DEFINITIONS for e in found.get(key, [])]
        self.formation_of = {e.number: e.refers(2) for e in sorted(definitions, key=lambda e: e.start)}
        self._names = {
            number: products.get(self.product_of.get(formation, 0), "")
            for number, formation in self.formation_of.items()
        }
        self._below: dict[int, list[Occurrence]] = {}
        self.placed: set[int] = set()
        for entity in found.get("NEXT_ASSEMBLY_USAGE_OCCURRENCE", []):
            above, below = entity.refers(3), entity.refers(4)
            label = entity.text(1) or entity.text(0)
            self._below.setdefault(above, []).append(Occurrence(label, below, entity.text(1)))
            self.placed.add(below)
        self._roots = [Occurrence(name, number) for number, name in self._names.items() if number not in self.placed]

    def name(self, definition: int) -> str:
        """Return the name of the product of that definition, "" if it has none."""
        return self._names.get(definition, "")

    def give_names(self, root: dict[str, Any]) -> dict[int, int]:
        """Name the nodes of a converted file after their places; return the definition of each node."""
        nodes = root.get("nodes", [])
        definitions: dict[int, int] = {}
        todo = [(scene.get("nodes", []), self._roots, "") for scene in root.get("scenes", [])]
        while todo:
            children, known, above = todo.pop()
            for at, place in zip(children, self._matched(children, nodes, known), strict=True):
                node = nodes[at]
                definition = place.definition if place else 0
                if definition:
                    definitions[at] = definition
                if place and self.name(definition):
                    node["name"] = place_name(place.name, self.name(definition))
                elif above and _NO_NAME.match(str(node.get("name", ""))):
                    node["name"] = above  # one of several shapes of a product
                todo.append((node.get("children", []), self._below.get(definition, []), str(node.get("name", ""))))
        return definitions

    def _matched(
        self, children: list[int], nodes: list[dict[str, Any]], known: list[Occurrence]
    ) -> list[Occurrence | None]:
        """Return the occurrence of each node, None if it is not known.

        Nodes and occurrences have the same order, but some of either may lack the other. Therefore labels count first,
        each occurrence once; without a label match, the position counts if there are as many of both.
        """
        free: dict[str, list[int]] = {}
        for place, occurrence in enumerate(known):
            free.setdefault(occurrence.label, []).append(place)
        taken: list[int | None] = []
        for at in children:
            places = free.get(str(nodes[at].get("name", "")), [])
            taken.append(places.pop(0) if places else None)
        if len(children) == len(known):
            left = set(range(len(known))) - {place for place in taken if place is not None}
            taken = [here if here is not None or place not in left else place for place, here in enumerate(taken)]
        return [None if place is None else known[place] for place in taken]
