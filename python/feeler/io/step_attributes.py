"""Attributes of products in the text of a STEP file: properties, materials, layers, and facts of the product itself.

The converter drops them. Properties belong to the definition of a product (PRODUCT_DEFINITION), to its shape, or to the
product; layers to representations of the shape and to the solids in them.
"""

from __future__ import annotations

import re
from collections.abc import Iterable, Iterator
from typing import Any

from feeler.io.step_names import DEFINITIONS, FORMATIONS
from feeler.io.step_text import Entity, entities, string_text

Rows = dict[int, dict[str, str]]
"""Attributes by the number of the definition of a product."""

_PROPERTIES = ("PROPERTY_DEFINITION", "PROPERTY_DEFINITION_REPRESENTATION", "REPRESENTATION", "MATERIAL_DESIGNATION")
_VALUES = (
    *("DESCRIPTIVE_REPRESENTATION_ITEM", "VALUE_REPRESENTATION_ITEM", "INTEGER_REPRESENTATION_ITEM"),
    *("REAL_REPRESENTATION_ITEM", "MEASURE_REPRESENTATION_ITEM"),
)
_GENERAL = ("GENERAL_PROPERTY", "GENERAL_PROPERTY_ASSOCIATION")
_LAYER = "PRESENTATION_LAYER_ASSIGNMENT"
_SHAPES = (
    *("SHAPE_REPRESENTATION", "ADVANCED_BREP_SHAPE_REPRESENTATION", "FACETED_BREP_SHAPE_REPRESENTATION"),
    *("MANIFOLD_SURFACE_SHAPE_REPRESENTATION", "TESSELLATED_SHAPE_REPRESENTATION"),
)
_MEASURE = re.compile(
    rb"#(\d+)\s*=\s*\((?=[^;]*\bMEASURE_REPRESENTATION_ITEM\b)"
    rb"(?=[^;]*\bMEASURE_WITH_UNIT\s*\(\s*\w+\s*\(\s*([^\s)]+))"
    rb"(?=[^;]*\bREPRESENTATION_ITEM\s*\(\s*'((?:[^']|'')*)')"
)
_CHECKS = "validation property"  # volumes and centres to check a translation by
_EMPTY_REVISIONS = ("", "any", "none", "not_specified", "1")


def product_attributes(text: bytes) -> Rows:
    """The attributes of each product. `text` is as `plain_text` returns it. Names and values are as in the file."""
    known = _Products(text)
    rows: Rows = {}

    def add(definitions: Iterable[int], name: str, value: str) -> None:
        for definition in definitions:
            if name and value:
                row = rows.setdefault(definition, {})
                if row.setdefault(name, value) != value:
                    row[name] = f"{row[name]}, {value}"

    if b"MATERIAL_DESIGNATION" in text or b"PROPERTY_DEFINITION_REPRESENTATION" in text:
        for name, value, target in _stated_properties(text):
            add(known.of(target), name, value)
    if _LAYER.encode("ascii") in text:
        for name, item in _layers(text):
            add(known.of_shape(text, item), "layer", name)
    for product, definitions in known.definitions_of.items():
        entity = known.products.get(product)
        if entity is None:
            continue
        number, name, description = (entity.text(at).strip() for at in range(3))
        add(definitions, "number", number if name and number != name else "")
        add(definitions, "description", description if description not in (number, name) else "")
        for definition in definitions:
            revision = known.revisions.get(definition, "")
            add([definition], "revision", revision if revision.casefold() not in _EMPTY_REVISIONS else "")
    return rows


class _Products:
    """Which entities lead to which product."""

    def __init__(self, text: bytes) -> None:
        found: dict[str, list[Entity]] = {}
        for entity in entities(text, "PRODUCT", *FORMATIONS, *DEFINITIONS, "PRODUCT_DEFINITION_SHAPE"):
            found.setdefault(entity.keyword, []).append(entity)
        self.products = {each.number: each for each in found.get("PRODUCT", [])}
        formations = {each.number: each for key in FORMATIONS for each in found.get(key, [])}
        self.revisions: dict[int, str] = {}
        self.definitions_of: dict[int, list[int]] = {}
        self._definitions: dict[int, list[int]] = {}
        for each in (each for key in DEFINITIONS for each in found.get(key, [])):
            formation = formations.get(each.refers(2))
            self._definitions[each.number] = [each.number]
            if formation is not None:
                self.revisions[each.number] = formation.text(0).strip()
                self.definitions_of.setdefault(formation.refers(2), []).append(each.number)
                self._definitions.setdefault(formation.number, []).append(each.number)
        self._shapes = {each.number: each.refers(2) for each in found.get("PRODUCT_DEFINITION_SHAPE", [])}
        self._items: dict[int, list[int]] | None = None

    def of(self, entity: int) -> list[int]:
        """The definitions that an entity is or leads to; none if it is something else."""
        entity = self._shapes.get(entity, entity)
        return self._definitions.get(entity) or self.definitions_of.get(entity, [])

    def of_shape(self, text: bytes, item: int) -> list[int]:
        """The definitions whose shape is, or has, a solid or representation."""
        if self._items is None:
            self._items = self._shape_items(text)
        return self._items.get(item, [])

    def _shape_items(self, text: bytes) -> dict[int, list[int]]:
        inside: dict[int, list[int]] = {}
        linked: dict[int, set[int]] = {}
        owners: dict[int, list[int]] = {}
        for each in entities(text, *_SHAPES, "SHAPE_REPRESENTATION_RELATIONSHIP", "SHAPE_DEFINITION_REPRESENTATION"):
            if each.keyword == "SHAPE_REPRESENTATION_RELATIONSHIP":
                one, other = each.refers(2), each.refers(3)
                linked.setdefault(one, set()).add(other)
                linked.setdefault(other, set()).add(one)
            elif each.keyword == "SHAPE_DEFINITION_REPRESENTATION":
                owners.setdefault(each.refers(1), []).extend(self.of(each.refers(0)))
            else:
                inside[each.number] = each.all(1)
        found: dict[int, list[int]] = {}
        for shape, definitions in owners.items():
            for representation in (shape, *sorted(linked.get(shape, ()))):
                for item in (representation, *inside.get(representation, ())):
                    found.setdefault(item, []).extend(each for each in definitions if each not in found.get(item, ()))
        return found


def _stated_properties(text: bytes) -> Iterator[tuple[str, str, int]]:
    """Each property as (name, value, the entity that has it)."""
    found: dict[str, dict[int, Entity]] = {}
    for entity in entities(text, *_PROPERTIES, *_VALUES, *_GENERAL):
        found.setdefault(entity.keyword, {})[entity.number] = entity
    for each in found.get("MATERIAL_DESIGNATION", {}).values():
        for target in each.all(1):
            yield "material", each.text(0).strip(), target
    properties = found.get("PROPERTY_DEFINITION", {})
    if not properties:
        return
    general = found.get("GENERAL_PROPERTY", {})
    names: dict[int, str] = {}
    for each in found.get("GENERAL_PROPERTY_ASSOCIATION", {}).values():
        names[each.refers(3)] = general[each.refers(2)].text(1).strip() if each.refers(2) in general else ""
    representations = found.get("REPRESENTATION", {})
    values = _values(text, found)
    for each in found.get("PROPERTY_DEFINITION_REPRESENTATION", {}).values():
        stated, representation = properties.get(each.refers(0)), representations.get(each.refers(1))
        if stated is None or representation is None or _CHECKS in stated.text(0).casefold():
            continue
        title = representation.text(0).strip()
        for item in representation.all(1):
            name, value = values.get(item, ("", ""))
            if "material name" in (title.casefold(), stated.text(1).strip().casefold()) and item in values:
                is_label = name.casefold() in ("", "material", "material name", "name")
                yield "material", value if is_label and value else name, stated.refers(2)
            else:
                label = name or names.get(stated.number, "") or title or stated.text(0).strip()
                yield label, value, stated.refers(2)


def _values(text: bytes, found: dict[str, dict[int, Entity]]) -> dict[int, tuple[str, str]]:
    """The name and value of each item of a representation."""
    values: dict[int, tuple[str, str]] = {}
    for keyword in _VALUES:
        for number, each in found.get(keyword, {}).items():
            value: Any = each.text(1).strip()
            if not value and each.numbers(1):
                value = f"{each.numbers(1)[0]:.15g}"
            values[number] = (each.text(0).strip(), value)
    for match in _MEASURE.finditer(text):
        try:
            value = f"{float(match[2]):.15g}"
        except ValueError:
            continue
        values[int(match[1])] = (string_text(match[3]).strip(), value)
    return values


def _layers(text: bytes) -> Iterator[tuple[str, int]]:
    """Each layer's name with an item in it; of a styled item the one that it styles."""
    styled = {each.number: each.refers(2) for each in entities(text, "STYLED_ITEM")}
    for each in entities(text, _LAYER):
        name = each.text(0).strip()
        for item in each.all(2):
            yield name, styled.get(item, item)
