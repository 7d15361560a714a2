"""Detects the format of a file: by its first bytes if they are unambiguous, else by its extension."""

from __future__ import annotations

import re
import stat
from pathlib import Path

from feeler.errors import LoadError, MissingFileError
from feeler.io.step_text import without_comments
from feeler.io.text import decoded
from feeler.io.unread import unread
from feeler.saved import MAGIC

HEAD_BYTES = 4096

EXTENSIONS: dict[str, str] = {
    ".stl": "STL",
    ".obj": "OBJ",
    ".ply": "PLY",
    ".off": "OFF",
    ".glb": "glTF",
    ".gltf": "glTF",
    ".3mf": "3MF",
    ".step": "STEP",
    ".stp": "STEP",
    ".p21": "STEP",
    ".dae": "COLLADA",
    ".zae": "COLLADA",
}

COMPANIONS = frozenset({".bin", ".mtl", ".png", ".jpg", ".jpeg", ".ktx2", ".webp"})
"""Files that accompany meshes: not listed in notes when a folder is loaded."""

_PACKED = {
    b"\x1f\x8b": "gzip",
    b"\xfd7zXZ\0": "xz",
    b"BZh": "bzip2",
    b"(\xb5/\xfd": "zstd",
    b"7z\xbc\xaf\x27\x1c": "7-Zip",
    b"Rar!": "RAR",
    b"Draco": "Draco",
}
_PLY = re.compile(rb"ply[ \t]*\n")
# The number of vertices may follow at once, as in the files of ModelNet.
_OFF = re.compile(rb"(?:#[^\n]*\n\s*)*(?:ST|[CN4n])*OFF(?=\s|\d+\s+\d+\s)")
_SOLID = re.compile(rb"solid\b", re.I)
_STL = re.compile(rb"\bfacet\s+normal\b|\bend\s*solid", re.I)
_FACET = re.compile(rb"\bfacet\s+normal\s.*\bvertex\s", re.I | re.S)
_OBJ = re.compile(rb"^[ \t]*(v[ \t]+[-+.\d]|f[ \t]+-?\d|(mtllib|usemtl|o|g|vn|vt)[ \t]+\S)", re.MULTILINE)


def known_formats() -> str:
    """Return the formats and extensions, for messages."""
    return ", ".join(EXTENSIONS)


def identify(path: Path) -> tuple[str, list[str]]:
    """Return (format, notes) of a regular file that is not empty; raise `LoadError` for anything else."""
    try:
        status = path.stat()
    except (FileNotFoundError, NotADirectoryError):
        raise MissingFileError(f"{path}: there is no such file or folder; check the path") from None
    except (OSError, ValueError) as error:
        raise LoadError(f"{str(path)!r}: cannot be opened ({error})") from error
    if not stat.S_ISREG(status.st_mode):
        raise LoadError(f"{path}: this is not a regular file (a device or pipe); copy it to a file first")
    if not status.st_size:
        raise LoadError(f"{path}: the file is empty (0 bytes); export it again")
    try:
        with path.open("rb") as file:
            head = file.read(HEAD_BYTES)
    except OSError as error:
        raise LoadError(f"{path}: cannot be read ({error.strerror}); check its permissions") from error
    for magic, name in _PACKED.items():
        if head.startswith(magic):
            raise LoadError(f"{path}: the file is compressed ({name}); unpack it first")
    if head.startswith(MAGIC):
        raise LoadError(
            f"{path}: a saved scene is a whole mock-up and cannot be joined with other files; give it alone"
        )
    named = EXTENSIONS.get(path.suffix.lower())
    text = decoded(head).lstrip()
    if other := unread(path, head, text):
        raise LoadError(f"{path}: {other}")
    found = _by_content(head, text, status.st_size) or (None if named else _weak(text))
    if found == "3MF" and named == "COLLADA":
        found = "COLLADA"  # in an archive, as 3MF always is
    if found and found != named:
        kind = f"is named {path.suffix}" if path.suffix else "has no extension"
        return found, [f"{path.name} {kind}, but its content is {found}: read as {found}"]
    if named is None:
        raise LoadError(
            f"{path}: neither the extension nor the content is a format feeler reads "
            f"({known_formats()}; saved scenes: .feeler)"
        )
    if named == "STL" and text[:5].lower() != b"solid" and _weak(text) == "OBJ":
        return "OBJ", [f"{path.name} is named {path.suffix}, but its content is OBJ: read as OBJ"]
    return named, []


def _by_content(head: bytes, text: bytes, size: int) -> str | None:
    """Return the format that the first bytes prove, as bytes or as text; or None."""
    if head.startswith(b"glTF"):
        return "glTF"
    if _PLY.match(text):
        return "PLY"
    if head.startswith(b"PK\x03\x04"):
        return "3MF"
    if without_comments(text).startswith(b"ISO-10303-21"):
        return "STEP"
    if _OFF.match(text):
        return "OFF"
    if text.startswith(b"{") and b'"' in text:
        return "glTF"
    if text.startswith(b"<") and b"<COLLADA" in text:
        return "COLLADA"
    if is_binary_stl(head, size):
        return "STL"
    if _SOLID.match(text) and _STL.search(text):
        return "STL"
    return None


def is_binary_stl(head: bytes, size: int) -> bool:
    """Tell whether the count in the header of a binary STL fits the size of the file."""
    return size >= 84 and 84 + 50 * int.from_bytes(head[80:84], "little") == size


def _weak(text: bytes) -> str | None:
    """Return a guess for a file with an unknown extension."""
    if b"\0" in text:
        return None
    if _OBJ.search(text):
        return "OBJ"
    return "STL" if _FACET.search(text) else None
