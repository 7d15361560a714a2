"""The archive of a 3MF file: finds its members and reads their XML, with sizes checked before anything is opened."""

from __future__ import annotations

import posixpath
import zipfile
from collections.abc import Callable
from functools import partial
from pathlib import Path
from urllib.parse import unquote
from xml.parsers import expat

from feeler.errors import LoadError
from feeler.io.limits import check_memory
from feeler.progress import Progress

SEPARATOR = " "
"""Separates namespace and name in the tags and attributes of handlers; no namespace has a blank."""

_DEFAULT_MODEL = "3D/3dmodel.model"
_RELATIONS = "_rels/.rels"
_MAX_RATIO = 250  # deflate packs the XML of meshes about 5 to 40 times, a bomb up to 1032 times
_SMALL = 64 * 2**20  # below this a high ratio does no harm
_READ_BYTES = 2**20
_ENCRYPTED = b"%3McF"  # start of a member that the secure content extension has encrypted


class EncryptedError(Exception):
    """A member is encrypted by the secure content extension."""


class Handler:
    """Receives the elements of one XML file."""

    listen: Callable[[Callable[[str], None] | None], None] = staticmethod(lambda to: None)
    """Sends the text in elements somewhere from now on, or nowhere: there are blanks between a million vertices."""

    def namespace(self, prefix: str | None, uri: str) -> None:
        """Receive the declaration of a namespace; it comes before the element that holds it."""

    def start(self, tag: str, attributes: dict[str, str]) -> None:
        """Receive the start of an element."""

    def end(self, tag: str) -> None:
        """Receive the end of an element."""


class Package:
    """The members of one 3MF archive. A member's key is its name in lower case, without a slash before it."""

    def __init__(self, path: Path, archive: zipfile.ZipFile) -> None:
        self.path = path
        self._archive = archive
        self._members = {info.filename.lower().lstrip("/"): info for info in archive.infolist()}
        self._total = sum(info.file_size for key, info in self._members.items() if key.endswith(".model"))
        self._done = 0

    def fail(self, what: str, remedy: str = "export the file again") -> LoadError:
        """Return the error for this file."""
        return LoadError(f"{self.path}: {what}; {remedy}")

    def find(self, reference: str, beside: str = "") -> str | None:
        """Return the key of the member at a path, from the root or else relative to the member `beside`, or None."""
        for text in (reference, unquote(reference)):
            word = text.replace("\\", "/").lower()
            for folder in ("", posixpath.dirname(beside)):
                key = posixpath.normpath(posixpath.join(folder, word.lstrip("/")))
                if key in self._members:
                    return key
        return None

    def name(self, key: str) -> str:
        """Return the name of a member as written in the archive."""
        return self._members[key].filename

    def root_model(self) -> str:
        """Return the key of the root model: from the relations, else at its usual place."""
        relations = _Relations()
        if _RELATIONS in self._members:
            self.parse(_RELATIONS, relations)
        for target in (*relations.targets, _DEFAULT_MODEL):
            key = self.find(target)
            if key is not None:
                return key
        models = sorted(key for key in self._members if key.endswith(".model"))
        if models:
            return models[0]
        raise self.fail("not a 3MF file: the archive contains no 3D model")

    def parse(self, key: str, handler: Handler, progress: Progress | None = None) -> None:
        """Read the XML of a member, block by block; raise `EncryptedError` if it is encrypted."""
        info = self._members[key]
        self._check_size(info)
        parser = expat.ParserCreate(namespace_separator=SEPARATOR)
        parser.buffer_text = True
        parser.StartNamespaceDeclHandler = handler.namespace
        parser.StartElementHandler = handler.start
        parser.EndElementHandler = handler.end
        handler.listen = partial(setattr, parser, "CharacterDataHandler")
        parser.StartDoctypeDeclHandler = _refuse_doctype
        name = info.filename
        is_first = True
        try:
            with self._archive.open(info) as file:
                while block := file.read(_READ_BYTES):
                    if is_first and block.startswith(_ENCRYPTED):
                        raise EncryptedError(name)
                    is_first = False
                    parser.Parse(block)
                    self._done += len(block)
                    if progress:
                        progress(0.9 * min(self._done / max(self._total, 1), 1.0), f"reading {self.path.name}")
            parser.Parse(b"", True)
        except (expat.ExpatError, _DoctypeError) as error:
            raise self.fail(f"the XML of {name!r} is damaged ({error})") from error
        except KeyError as error:
            line = parser.CurrentLineNumber
            raise self.fail(f"{name!r}, line {line}: the attribute {error} is missing") from error

    def _check_size(self, info: zipfile.ZipInfo) -> None:
        """Refuse a member that unpacks to an implausible size."""
        if info.file_size > _SMALL and info.file_size > _MAX_RATIO * max(info.compress_size, 1):
            raise self.fail(
                f"{info.filename!r} unpacks from {info.compress_size:,} to {info.file_size:,} bytes: this is a zip "
                "bomb, and it was not opened"
            )
        check_memory(info.file_size, f"{self.path}: {info.filename!r} unpacked")


class _Relations(Handler):
    """Receives the relations of the package: which member is the root model."""

    def __init__(self) -> None:
        self.targets: list[str] = []

    def start(self, tag: str, attributes: dict[str, str]) -> None:
        """Receive a relation."""
        if attributes.get("Type", "").endswith("/3dmodel"):
            self.targets.append(attributes.get("Target", ""))


class _DoctypeError(Exception):
    """The XML declares a document type, which 3MF forbids and which can hold an entity bomb."""


def _refuse_doctype(*_: object) -> None:
    raise _DoctypeError("it declares a document type, which 3MF forbids")
