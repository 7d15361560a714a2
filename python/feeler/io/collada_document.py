"""The document side of COLLADA 1.4 and 1.5: XML, references, numbers and sources.

Our own XML reader on expat. It refuses document type declarations (entity bombs), and drops namespaces of element
names, so that both versions, and files without a namespace, read the same.
"""

from __future__ import annotations

import re
import warnings
import zipfile
import zlib
from collections.abc import Iterator
from pathlib import Path
from urllib.parse import unquote
from xml.parsers import expat

import numpy as np
from numpy.typing import NDArray

from feeler.errors import LoadError
from feeler.io.limits import check_memory

_MAX_RATIO = 250  # deflate packs the XML of meshes about 5 to 40 times, a bomb up to 1032 times
_MAX_LEVELS = 10_000  # elements inside elements; nodes of an assembly nest a dozen levels
_BYTES_PER_ELEMENT = 600  # of Python objects, for an element of the shortest kind
_MICROSOFT = re.compile(r"-?\d\.#(QNAN|SNAN|IND|INF)\d*", re.IGNORECASE)  # not-a-number as their library prints it
_MANIFEST = "manifest.xml"


class Element:
    """One XML element: its name without namespace, attributes, children, text."""

    __slots__ = ("attributes", "children", "line", "tag", "text")

    def __init__(self, tag: str, attributes: dict[str, str], line: int) -> None:
        self.tag = tag
        self.attributes = attributes
        self.children: list[Element] = []
        self.text = ""
        self.line = line

    def all(self, *tags: str) -> list[Element]:
        """Return the children of these names, in order."""
        return [child for child in self.children if child.tag in tags]

    def first(self, tag: str) -> Element | None:
        """Return the first child of that name."""
        return next((child for child in self.children if child.tag == tag), None)

    def walk(self) -> Iterator[Element]:
        """Yield this element and all below it, in the order of the file."""
        stack = [self]
        while stack:
            element = stack.pop()
            yield element
            stack.extend(reversed(element.children))


class Document:
    """One COLLADA file."""

    def __init__(self, path: Path) -> None:
        self.path = path
        data = _unzipped(path) if zipfile.is_zipfile(path) else path.read_bytes()
        check_memory(2 * len(data) + _BYTES_PER_ELEMENT * data.count(b"<"), f"{path}: its XML")
        self.root = self._parse(data)
        if self.root.tag != "COLLADA":
            raise self.fail(f"the outermost element is <{self.root.tag[:40]}>, and not <COLLADA>")
        self._by_id: dict[str, Element] = {}
        for element in self.root.walk():
            if "id" in element.attributes:
                self._by_id.setdefault(element.attributes["id"], element)

    def fail(self, what: str, at: Element | None = None) -> LoadError:
        """Return the error for this file."""
        line = f", line {at.line}" if at else ""
        return LoadError(f"{self.path}{line}: {what}; export the file again")

    def find(self, reference: str | None, *tags: str) -> Element | None:
        """Return the element with one of these names at "#id", or None if it is elsewhere or missing."""
        if not reference:
            return None
        found = self._by_id.get(reference.removeprefix("#"))
        if found is None and reference.startswith("#"):
            found = self._by_id.get(unquote(reference[1:]))
        return found if found is not None and found.tag in tags else None

    def floats(self, element: Element, count: int | None = None) -> NDArray[np.float64]:
        """Return the numbers in an element; raise for other text, or if there are not `count` of them."""
        text = element.text
        if "#" in text:
            text = _MICROSOFT.sub("nan", text)
        values = _numbers(text, np.float64)
        if values is None or (count is not None and len(values) != count):
            wanted = "numbers" if count is None else f"{count} numbers"
            raise self.fail(f"<{element.tag}> should have {wanted}, and has {element.text.strip()[:60]!r}", element)
        return values.astype(np.float64, copy=False)

    def integers(self, element: Element) -> NDArray[np.int64]:
        """Return the whole numbers in an element."""
        values = _numbers(element.text, np.int64)
        if values is None:
            raise self.fail(f"<{element.tag}> has a value that is not a whole number", element)
        return values.astype(np.int64, copy=False)

    def natural(self, element: Element, name: str, default: int | None = None) -> int:
        """Return an attribute as a whole number from 0 on."""
        value = element.attributes.get(name)
        if value is None and default is not None:
            return default
        try:
            number = int(value or "")
        except ValueError:
            number = -1
        if number < 0:
            raise self.fail(f"<{element.tag}> has {name}={str(value)[:20]!r}, and it should be a whole number", element)
        return number

    def points(self, source: Element) -> NDArray[np.float64]:
        """Return the positions (n, 3) of a <source>; positions with two columns get z = 0."""
        technique = source.first("technique_common")
        accessor = technique.first("accessor") if technique else None
        if accessor is None:
            array = source.first("float_array")
            if array is None:
                raise self.fail("a <source> of positions has neither accessor nor array", source)
            values = self.floats(array)
            return values[: len(values) // 3 * 3].reshape(-1, 3)
        array = self.find(accessor.attributes.get("source"), "float_array") or source.first("float_array")
        if array is None:
            raise self.fail("a <source> of positions has no <float_array>", source)
        values = self.floats(array)
        count, stride = self.natural(accessor, "count"), self.natural(accessor, "stride", 1)
        offset = self.natural(accessor, "offset", 0)
        params = accessor.all("param")
        # A param without a name is to be skipped; if none has a name, the first three count.
        columns = [at for at, param in enumerate(params) if param.attributes.get("name")] or list(range(stride))
        columns = columns[:3]
        if len(columns) < 2 or columns[-1] >= stride:
            raise self.fail(f"positions with {len(columns)} columns in a stride of {stride} are not points", accessor)
        if count and offset + stride * (count - 1) + columns[-1] >= len(values):
            raise self.fail(
                f"<accessor> promises {count:,} points of {stride} numbers, and its array has {len(values):,} numbers",
                accessor,
            )
        if not count:
            return np.empty((0, 3))
        rows = np.lib.stride_tricks.as_strided(
            values[offset:], (count, stride), (stride * values.itemsize, values.itemsize), writeable=False
        )
        made = np.zeros((count, 3))
        made[:, : len(columns)] = rows[:, columns]
        return made

    def _parse(self, data: bytes) -> Element:
        parser = expat.ParserCreate(namespace_separator=" ")
        parser.buffer_text = True
        open_now: list[Element] = []
        text: list[list[str]] = []
        roots: list[Element] = []

        def start(tag: str, attributes: dict[str, str]) -> None:
            element = Element(tag.rpartition(" ")[2], attributes, parser.CurrentLineNumber)
            (open_now[-1].children if open_now else roots).append(element)
            open_now.append(element)
            text.append([])
            if len(open_now) > _MAX_LEVELS:
                raise self.fail(f"the XML is nested more than {_MAX_LEVELS:,} levels deep")

        def end(_: str) -> None:
            open_now.pop().text = "".join(text.pop())

        def characters(piece: str) -> None:
            if text:
                text[-1].append(piece)

        def doctype(*_: object) -> None:
            raise LoadError(
                f"{self.path}: the XML declares a document type, which COLLADA has no use for; it was not opened"
            )

        parser.StartElementHandler = start
        parser.EndElementHandler = end
        parser.CharacterDataHandler = characters
        parser.StartDoctypeDeclHandler = doctype
        try:
            parser.Parse(data, True)
        except expat.ExpatError as error:
            raise self.fail(f"the XML is damaged ({error})") from error
        except LoadError:
            raise
        except (ValueError, LookupError) as error:  # of an encoding that expat does not read
            raise LoadError(f"{self.path}: the encoding of its text is not read ({error}); save it as UTF-8") from error
        return roots[0]


def _numbers(text: str, kind: type[np.generic]) -> NDArray[np.generic] | None:
    """Return the numbers in a text, or None for other text."""
    if not text.strip():
        return np.empty(0, dtype=kind)
    with warnings.catch_warnings():
        warnings.simplefilter("error")  # NumPy before 2.3 warns and returns the numbers before the error
        try:
            values: NDArray[np.generic] = np.fromstring(text, dtype=kind, sep=" ")
        except (ValueError, DeprecationWarning, OverflowError):
            return None
    return values


def _unzipped(path: Path) -> bytes:
    """Return the document in a .zae: the one in its manifest, or else its only .dae."""
    try:
        with zipfile.ZipFile(path) as archive:
            names = archive.namelist()
            wanted = [name for name in names if name.lower().endswith(".dae")]
            if _MANIFEST in names:
                text = _member(path, archive, _MANIFEST).decode("utf-8", "replace")
                named = re.search(r"<dae_root[^>]*>\s*(?:\./)?([^<]*?)(?:#[^<]*)?\s*</", text)
                if named and unquote(named[1]) in names:
                    wanted = [unquote(named[1])]
            if not wanted:
                raise LoadError(f"{path}: the archive holds no .dae file; export it again")
            return _member(path, archive, wanted[0])
    except (zipfile.BadZipFile, zlib.error, zipfile.LargeZipFile, EOFError, NotImplementedError, RuntimeError) as error:
        raise LoadError(f"{path}: the archive is damaged, truncated or encrypted ({error}); export it again") from error


def _member(path: Path, archive: zipfile.ZipFile, name: str) -> bytes:
    info = archive.getinfo(name)
    if info.file_size > 64 * 2**20 and info.file_size > _MAX_RATIO * max(info.compress_size, 1):
        raise LoadError(
            f"{path}: {name!r} unpacks from {info.compress_size:,} to {info.file_size:,} bytes: this is a zip "
            "bomb, and it was not opened"
        )
    check_memory(info.file_size, f"{path}: {name!r} unpacked")
    return archive.read(info)
