"""What the tests of loading share."""

from __future__ import annotations

from pathlib import Path

import numpy as np

from feeler import Mockup


def save(folder: Path, name: str, content: bytes | str) -> Path:
    path = folder / name
    path.write_bytes(content.encode() if isinstance(content, str) else content)
    return path


def soup(mockup: Mockup) -> np.ndarray:
    """The corners of every triangle, (m, 3, 3), metres."""
    return mockup.vertices[mockup.faces]


def notes(mockup: Mockup) -> str:
    return "\n".join(mockup.report.source.notes)
