"""The page's files: a table of names made once, so that no path of a request is ever looked up on the disk."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path

from feeler.errors import WorkbenchError

STATIC = Path(__file__).parent / "static"
"""The built page, included in the wheel."""

# Our own table, because the system's one can be changed by other programs.
TYPES = {
    ".html": "text/html; charset=utf-8",
    ".js": "text/javascript; charset=utf-8",
    ".css": "text/css; charset=utf-8",
    ".json": "application/json",
    ".svg": "image/svg+xml",
    ".png": "image/png",
    ".csv": "text/csv; charset=utf-8",
    ".txt": "text/plain; charset=utf-8",
    ".glb": "model/gltf-binary",
}
ANY = "application/octet-stream"


@dataclass(frozen=True)
class File:
    """The file of a name."""

    type: str
    data: bytes


def type_of(name: str) -> str:
    """The media type by the suffix of a name."""
    return TYPES.get(Path(name).suffix.lower(), ANY)


def static_files(folder: Path = STATIC) -> dict[str, File]:
    """Path of a URL -> file, for all files of a folder, and "/" for its index.html.

    Raises `WorkbenchError` if the page is not built.
    """
    names = sorted(path for path in folder.rglob("*") if path.is_file()) if folder.is_dir() else []
    files = {f"/{path.relative_to(folder).as_posix()}": File(type_of(path.name), path.read_bytes()) for path in names}
    if "/index.html" not in files:
        raise WorkbenchError("the page is not built", str(folder), "run `make build`, or install feeler from its wheel")
    return {**files, "/": files["/index.html"]}
