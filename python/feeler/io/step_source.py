"""What of the text of a STEP file concerns the converter, and what in it is no surface."""

from __future__ import annotations

import re

from feeler.io.step_text import entities
from feeler.io.tally import Tally

_FACE = re.compile(rb"=\s*(?:ADVANCED_FACE|FACE_SURFACE)\s*\(")
_STYLED = re.compile(rb"\b((?:CONTEXT_DEPENDENT_)?(?:OVER_RIDING_)?STYLED_ITEM)(?=\s*\()")
_REFERENCE = re.compile(rb"\b(APPLIED_DOCUMENT_REFERENCE)(?=\s*\()")
_WITH_DOCUMENTS = "PRODUCT_DEFINITION_WITH_ASSOCIATED_DOCUMENTS"
_SETS = ("GEOMETRIC_CURVE_SET", "GEOMETRIC_SET")
_WIREFRAMES = ("EDGE_BASED_WIREFRAME_MODEL", "SHELL_BASED_WIREFRAME_MODEL")
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
    """Return the text (`plain_text`) as OpenCASCADE is to see it: without colours and without other files.

    A mesh in several colours comes in several pieces, of which only the first tells the faces that it is made of. And
    OpenCASCADE would open whatever file a reference names, also outside of the folder.
    """
    text = _REFERENCE.sub(rb"LEFT_OUT_\1", _STYLED.sub(rb"LEFT_OUT_\1", text))
    pieces, at = [], 0
    for entity in entities(text, _WITH_DOCUMENTS):
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
    """Return the number of faces of B-rep in the text."""
    return len(_FACE.findall(text))


def curves_and_points(text: bytes) -> list[str]:
    """Return notes on the curves, points and wireframes in the text: counted by kind, with the names of their sets."""
    tally = Tally()
    keywords: dict[int, str] = {}
    for entity in entities(text, *_SETS, *_WIREFRAMES):
        if entity.keyword in _WIREFRAMES:
            tally.add("wireframe models were left out: only surfaces collide", entity.text(0))
            continue
        if not keywords:
            keywords = {int(m[1]): m[2].decode("ascii") for m in _KEYWORD.finditer(text)}
        kinds = [keywords.get(item, "") for item in entity.all(1)]
        points = sum(kind in _POINTS for kind in kinds)
        curves = len(kinds) - points - sum(kind.endswith(("SURFACE", "PLANE")) for kind in kinds)
        for kind, count in (("points", points), ("curves", curves)):
            if count:
                tally.add(f"{kind} were left out: only surfaces collide", entity.text(0), count)
    return tally.notes()
