"""Prepares the text of a STEP file for the converter, and finds entities without a surface."""

from __future__ import annotations

import re

from feeler.io.step_text import Entity, entities
from feeler.io.tally import Tally
from feeler.io.text import name_text

_FACE = re.compile(rb"=\s*(?:ADVANCED_FACE|FACE_SURFACE)\s*\(")
_STYLED = re.compile(rb"\b((?:CONTEXT_DEPENDENT_)?(?:OVER_RIDING_)?STYLED_ITEM)(?=\s*\()")
_REFERENCE = re.compile(rb"\b(APPLIED_DOCUMENT_REFERENCE)(?=\s*\()")
_WITH_DOCUMENTS = "PRODUCT_DEFINITION_WITH_ASSOCIATED_DOCUMENTS"
_TESSELLATED = ("TESSELLATED_SOLID", "TESSELLATED_SHELL")
_SETS = ("GEOMETRIC_CURVE_SET", "GEOMETRIC_SET")
_WIREFRAMES = ("EDGE_BASED_WIREFRAME_MODEL", "SHELL_BASED_WIREFRAME_MODEL")
_OPERATOR = "CARTESIAN_TRANSFORMATION_OPERATOR_3D"
_PLACED_BY = re.compile(rb"\bREPRESENTATION_RELATIONSHIP_WITH_TRANSFORMATION\s*\(\s*#(\d+)")
_SCALE_SLACK = 1e-9  # of a scale of 1, which exporters compute
_EDITION_3 = re.compile(rb"#\d+\s*=\s*<([^<>;]*)>\s*;")
_KEYWORD = re.compile(rb"#(\d+)\s*=\s*\(?\s*([A-Z0-9_]+)")
_POINTS = (
    "CARTESIAN_POINT",
    "POINT_ON_CURVE",
    "POINT_ON_SURFACE",
    "POINT_REPLICA",
    "DEGENERATE_PCURVE",
    "VERTEX_POINT",
)


def for_converter(text: bytes) -> bytes:
    """Return the text (`plain_text`) for OpenCASCADE: without colours, other files, and copies.

    A mesh in several colours would be split, and only its first piece would list its faces. OpenCASCADE would also open
    any referenced file, even outside the folder.
    """
    text = _REFERENCE.sub(rb"LEFT_OUT_\1", _STYLED.sub(rb"LEFT_OUT_\1", text))
    copies = {entity.number for entity in _tessellated(text)[1]}
    pieces, at = [], 0
    for entity in entities(text, _WITH_DOCUMENTS, *_TESSELLATED):
        if entity.keyword in _TESSELLATED:
            if entity.number in copies:
                keyword = text.index(entity.keyword.encode("ascii"), entity.start)
                pieces += [text[at:keyword], b"LEFT_OUT_"]
                at = keyword
            continue
        whole = text[entity.start : entity.end]
        if whole.endswith(b")") and b"(" in whole[:-1]:
            # The documents are the last argument, a list: without it this is a plain PRODUCT_DEFINITION.
            plain = whole[: whole.rfind(b",", 0, whole.rfind(b"("))] + b")"
            pieces += [
                text[at : entity.start],
                plain.replace(_WITH_DOCUMENTS.encode("ascii"), b"PRODUCT_DEFINITION", 1),
            ]
            at = entity.end
    return b"".join([*pieces, text[at:]])


def count_faces(text: bytes) -> int:
    """Return the number of faces in the text, of B-rep and of triangles."""
    return len(_FACE.findall(text)) + sum(len(entity.all(1)) for entity in _tessellated(text)[0])


def _tessellated(text: bytes) -> tuple[list[Entity], list[Entity]]:
    """Return the solids and shells of triangles (AP242): (independent ones, copies of B-rep).

    OpenCASCADE reads both, so a copied part would appear twice.
    """
    found = list(entities(text, *_TESSELLATED)) if b"TESSELLATED_S" in text else []
    if not any(entity.refers(2) for entity in found):
        return found, []
    keywords = _keywords(text)
    own: list[Entity] = []
    copies: list[Entity] = []
    for entity in found:
        source = keywords.get(entity.refers(2), "")
        (copies if source and source not in _TESSELLATED else own).append(entity)
    return own, copies


def left_out(text: bytes) -> list[str]:
    """Return notes on curves, points, wireframes and copies in the text: counted by kind, with their names."""
    tally = Tally()
    for entity in _tessellated(text)[1]:
        tally.add("meshes of parts that are there as B-rep were left out: the B-rep was taken", entity.text(0))
    for found in _EDITION_3.finditer(text):
        tally.add("references by address (edition 3 of STEP) were not followed", name_text(found[1]))
    keywords: dict[int, str] = {}
    for entity in entities(text, *_SETS, *_WIREFRAMES):
        if entity.keyword in _WIREFRAMES:
            tally.add("wireframe models were left out: only surfaces collide", entity.text(0))
            continue
        if not keywords:
            keywords = _keywords(text)
        kinds = [keywords.get(item, "") for item in entity.all(1)]
        points = sum(kind in _POINTS for kind in kinds)
        curves = len(kinds) - points - sum(kind.endswith(("SURFACE", "PLANE")) for kind in kinds)
        for kind, count in (("points", points), ("curves", curves)):
            if count:
                tally.add(f"{kind} were left out: only surfaces collide", entity.text(0), count)
    return tally.notes()


def misplaced(text: bytes) -> list[int]:
    """Return the placements of shapes that mirror or scale, as entity numbers; OpenCASCADE misplaces these shapes.

    It turns a mirroring into a rotation, and divides by a scale.
    """
    if _OPERATOR.encode("ascii") not in text:
        return []
    directions = {e.number: e.numbers(1) for e in entities(text, "DIRECTION")}
    changing = {e.number for e in entities(text, _OPERATOR) if _mirrors_or_scales(e, directions)}
    if not changing:
        return []
    keywords = _keywords(text)
    shapes = {
        entity.number
        for entity in entities(text, "REPRESENTATION_MAP")
        if keywords.get(entity.refers(1), "").endswith("SHAPE_REPRESENTATION")  # others are drawings and symbols
    }
    used = {e.refers(2) for e in entities(text, "MAPPED_ITEM") if e.refers(1) in shapes}
    used |= {int(found[1]) for found in _PLACED_BY.finditer(text)}
    return sorted(changing & used)


def _mirrors_or_scales(operator: Entity, directions: dict[int, list[float]]) -> bool:
    """Tell whether an operator does so. Its last five arguments are axis 1, axis 2, origin, scale and axis 3."""
    at = len(operator.arguments) - 5
    if at < 0:
        return False
    scale = operator.numbers(at + 3)
    if scale and abs(scale[0] - 1.0) > _SCALE_SLACK:
        return True
    first, second, third = (
        directions.get(operator.refers(place), default)
        for place, default in ((at, [1.0, 0.0, 0.0]), (at + 1, []), (at + 4, [0.0, 0.0, 1.0]))
    )
    if not len(first) == len(second) == len(third) == 3:  # without the second it is that of a right hand
        return False
    (a, b, c), (d, e, f), (g, h, i) = first, second, third
    return a * (e * i - f * h) - b * (d * i - f * g) + c * (d * h - e * g) < 0


def _keywords(text: bytes) -> dict[int, str]:
    """Return the keyword of every entity; of one in several parts the first."""
    return {int(m[1]): m[2].decode("ascii") for m in _KEYWORD.finditer(text)}
