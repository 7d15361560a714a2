"""Parts of a STEP assembly in other files: the file of each product, and its place on disk.

AP214 and AP242 refer to it by APPLIED_DOCUMENT_REFERENCE or by a PROPERTY_DEFINITION of the product's shape, AP203 by
PRODUCT_DEFINITION_WITH_ASSOCIATED_DOCUMENTS; DOCUMENT_PRODUCT_EQUIVALENCE may link product and file.
"""

from __future__ import annotations

import re
from pathlib import Path, PurePosixPath
from typing import NamedTuple
from urllib.parse import unquote

from feeler.io.raw import clean_name
from feeler.io.step_names import Assembly
from feeler.io.step_text import Entity, entities

SUFFIXES = (".step", ".stp", ".p21")
_DOCUMENTS = ("DOCUMENT", "DOCUMENT_FILE")
_REFERENCES = ("APPLIED_DOCUMENT_REFERENCE", "CC_DESIGN_SPECIFICATION_REFERENCE")
_IDENTIFIED = "APPLIED_EXTERNAL_IDENTIFICATION_ASSIGNMENT"
_WITH_DOCUMENTS = "PRODUCT_DEFINITION_WITH_ASSOCIATED_DOCUMENTS"
_ABSOLUTE = re.compile(r"^(?:[A-Za-z][A-Za-z0-9+.-]*:|/)")  # a drive, a scheme or the root


class Named(NamedTuple):
    """A file as a STEP file names it: its possible spellings, the likeliest first."""

    spellings: tuple[str, ...]

    @property
    def shown(self) -> str:
        """The name for messages."""
        return clean_name(self.spellings[0], "?")


class Place(NamedTuple):
    """The place of a named file, or why it is not read."""

    path: Path | None
    why_not: str = ""


def referenced_files(text: bytes, assembly: Assembly) -> dict[int, list[Named]]:
    """Return the files of each PRODUCT_DEFINITION, in the order of the text (`plain_text`)."""
    found: dict[str, list[Entity]] = {}
    keys = (
        *_DOCUMENTS, *_REFERENCES, _IDENTIFIED, _WITH_DOCUMENTS, "EXTERNAL_SOURCE", "DOCUMENT_PRODUCT_EQUIVALENCE",
        "PROPERTY_DEFINITION", "PROPERTY_DEFINITION_REPRESENTATION", "SHAPE_DEFINITION_REPRESENTATION",
        "PRODUCT_DEFINITION_SHAPE",
    )  # fmt: skip
    if not any(key.encode("ascii") in text for key in ("DOCUMENT_FILE", _IDENTIFIED, "EXTERNAL_SOURCE")):
        return {}
    for entity in entities(text, *keys):
        found.setdefault(entity.keyword, []).append(entity)
    named = _named(found)
    files = {e.number: named[e.number] for key in _DOCUMENTS for e in found.get(key, []) if e.number in named}
    by_formation: dict[int, list[int]] = {}
    for definition, formation in assembly.formation_of.items():
        by_formation.setdefault(formation, []).append(definition)
    with_documents = {e.number: e.all(4) for e in found.get(_WITH_DOCUMENTS, [])}
    # A document that represents files: document = formation, whose definition has the files.
    stands_for: dict[int, list[int]] = {}
    for entity in found.get("DOCUMENT_PRODUCT_EQUIVALENCE", []):
        for formation in entity.all(3):
            for definition in by_formation.get(formation, [formation]):
                stands_for.setdefault(entity.refers(2), []).extend(with_documents.get(definition, []))

    result: dict[int, dict[Named, None]] = {}

    def link(definition: int, document: int) -> None:
        for one in (document, *stands_for.get(document, [])):
            if one in files:
                result.setdefault(definition, {})[files[one]] = None

    for key in _REFERENCES:
        for entity in found.get(key, []):
            for item in (i for at in (1, 2) for i in entity.all(at)):
                for definition in [item] if item in assembly.formation_of else by_formation.get(item, []):
                    link(definition, entity.refers(0))
    for definition, documents in with_documents.items():
        for document in documents:
            link(definition, document)
    for document, definition in _by_property(found):
        if document in named:
            result.setdefault(definition, {})[named[document]] = None
    for number, name in named.items():  # a product that is identified as a file itself
        for definition in [number] if number in assembly.formation_of else by_formation.get(number, []):
            result.setdefault(definition, {})[name] = None
    return {definition: list(names) for definition, names in result.items()}


def _named(found: dict[str, list[Entity]]) -> dict[int, Named]:
    """Return the file names of documents, and of everything else with an external identification."""
    spellings: dict[int, list[str]] = {}
    sources = {e.number: e.text(0) for e in found.get("EXTERNAL_SOURCE", [])}
    for entity in found.get(_IDENTIFIED, []):
        source, own = sources.get(entity.refers(2), ""), entity.text(0)
        for item in entity.all(3):
            names = spellings.setdefault(item, [])
            if own and not own.startswith("#"):
                # The source is the folder, or the file again.
                is_folder = source and PurePosixPath(source.replace("\\", "/")).suffix == ""
                names += [f"{source.rstrip('/')}/{own}"] if is_folder and not _ABSOLUTE.match(own) else []
                names.append(own)
            names.append(source)
    for entity in found.get("DOCUMENT_FILE", []):
        names = spellings.setdefault(entity.number, [])
        names += [entity.text(0), entity.text(1)]
    cleaned = {
        number: tuple(dict.fromkeys(n.strip() for n in names if n.strip())) for number, names in spellings.items()
    }
    return {number: Named(tuple(sorted(names, key=_unlikely))) for number, names in cleaned.items() if names}


def _unlikely(name: str) -> bool:
    """Sort names with a STEP extension first: a document may also have a number or title."""
    return not name.lower().endswith(SUFFIXES)


def _by_property(found: dict[str, list[Entity]]) -> list[tuple[int, int]]:
    """Return (document, definition) if a property of the document is the shape of the product, or names it."""
    definition_of_shape = {e.number: e.refers(2) for e in found.get("PRODUCT_DEFINITION_SHAPE", [])}
    definition_of: dict[int, list[int]] = {}  # by its representation
    for entity in found.get("SHAPE_DEFINITION_REPRESENTATION", []):
        definition = definition_of_shape.get(entity.refers(0), 0)
        if definition:
            definition_of.setdefault(entity.refers(1), []).append(definition)
    document_of = {e.number: e.refers(2) for e in found.get("PROPERTY_DEFINITION", [])}
    links = []
    for entity in found.get("PROPERTY_DEFINITION_REPRESENTATION", []):
        document = document_of.get(entity.refers(0), 0)
        links += [(document, definition) for definition in definition_of.get(entity.refers(1), [])]
    return links


def find(named: Named, folder: Path, within: Path) -> Place:
    """Find a file named by a STEP file in `folder`. Files outside `within` are never touched."""
    whys = []
    for spelling in named.spellings:
        place = _find(spelling, folder, within)
        if place.path is not None:
            return place
        whys.append(place.why_not)
    return Place(None, whys[0])


def _find(spelling: str, folder: Path, within: Path) -> Place:
    plain = spelling.replace("\\", "/")
    if _ABSOLUTE.match(plain) or "\0" in plain:
        return Place(None, "which is named by a full path or address and so was not read; copy it beside this file")
    root = within.resolve()
    missing = Place(None, "which was not found beside it")
    for words in dict.fromkeys((plain, unquote(plain))):
        at = folder.resolve()
        parts = [part for part in words.split("/") if part not in ("", ".")]
        for number, part in enumerate(parts):
            if part == "..":
                found: Path | None = at.parent
            else:
                found = _child(at, part, number == len(parts) - 1)
            if found is None:
                break
            try:
                at = found.resolve()  # a link may lead out of the folder
            except (OSError, RuntimeError):  # or in a circle
                break
            if at != root and root not in at.parents:
                return Place(None, "which is outside of the folder of the assembly and so was not read; copy it there")
        else:
            if parts and at.is_file():
                if at.suffix.lower() in SUFFIXES:
                    return Place(at)
                missing = Place(None, "which is not a STEP file and was not read; load it beside the assembly")
    return missing


def _child(folder: Path, name: str, is_file: bool) -> Path | None:
    """Return the entry of that name, in any case, or with another STEP suffix."""
    try:
        entries = sorted(entry.name for entry in folder.iterdir())
    except OSError:
        return None
    if name in entries:
        return folder / name
    wanted = [name.casefold()]
    if is_file:
        stem = name[: -len(Path(name).suffix)] if name.lower().endswith(SUFFIXES) else name
        wanted += [(stem + suffix).casefold() for suffix in SUFFIXES]
    for spelling in wanted:
        for entry in entries:
            if entry.casefold() == spelling:
                return folder / entry
    return None
