"""The cells of a study on disk: each is written when it is done, so that an interrupted study can continue."""

from __future__ import annotations

import hashlib
import json
import math
import os
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np

from ..errors import OptionError

Cell = dict[str, Any]


class Cells:
    """The finished cells in a folder, by name and settings."""

    def __init__(self, folder: Path, resume: bool) -> None:
        self.folder = folder
        self.resume = resume
        try:
            (folder / "cells").mkdir(parents=True, exist_ok=True)
        except OSError as error:
            raise OptionError(
                f"cannot make the folder {folder}: {error.strerror or error}; choose another --out"
            ) from None

    def get(self, name: str, settings: dict[str, Any], measure: Callable[[], Cell]) -> Cell:
        """The cell of that name: from the folder if it was measured with the same settings, else measured now."""
        words = json.dumps(settings, sort_keys=True).encode()
        path = self.folder / "cells" / f"{name}-{hashlib.sha256(words).hexdigest()[:12]}.json"
        if self.resume:
            kept = _read(path)
            if kept is not None:
                return kept
        cell: Cell = plain({"name": name, "settings": settings, **measure()})
        write_text(path, json.dumps(cell, allow_nan=False))
        return cell


def write_text(path: Path, text: str) -> None:
    """Writes a file completely or not at all."""
    part = path.with_name(path.name + ".part")
    try:
        part.write_text(text, encoding="utf-8")
        os.replace(part, path)
    except OSError as error:
        raise OptionError(f"cannot write {path}: {error.strerror or error}; choose another --out") from None


def plain(value: Any) -> Any:
    """The same in JSON types; numbers that JSON lacks become null."""
    if isinstance(value, dict):
        return {str(key): plain(item) for key, item in value.items()}
    if isinstance(value, list | tuple):
        return [plain(item) for item in value]
    if isinstance(value, np.ndarray):
        return plain(value.tolist())
    if isinstance(value, np.generic):
        value = value.item()
    if isinstance(value, float) and not math.isfinite(value):
        return None
    return value


def _read(path: Path) -> Cell | None:
    try:
        cell = json.loads(path.read_text(encoding="utf-8"))
    except (OSError, ValueError):
        return None
    return cell if isinstance(cell, dict) else None
