"""The messages by which a page sends files and opens another mock-up; `protocol.py` has the others and the encoding."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Annotated, ClassVar, Literal, TypedDict

import numpy as np
import numpy.typing as npt

from feeler.workbench.document.frames import Array

FilePurpose = Literal["open", "job"]
U1 = npt.NDArray[np.uint8]

MOST_PIECE_BYTES = 524_288
"""Bytes of a file in one message."""


class Opens(TypedDict):
    """What a page may open in place of the present mock-up."""

    formats: list[str]
    """Suffixes of files, such as ".stl"."""
    companions: list[str]
    """Suffixes of files that others of them need."""
    samples: list[str]
    most_bytes: int
    """Of all files together."""
    most_files: int


class FileToSend(TypedDict):
    """A file of the user's machine."""

    name: str
    """Without folders."""
    bytes: int


@dataclass(frozen=True)
class SendFiles:
    """Announces files: to open in place of the mock-up, or one for a job. Answered by a reply with their number,
    "files"."""

    KIND: ClassVar[str] = "send_files"
    id: int
    purpose: FilePurpose
    files: list[FileToSend]


@dataclass(frozen=True, eq=False)
class FilePiece:
    """The next bytes of an announced file. Answered by a reply, for which the page waits before the next one."""

    KIND: ClassVar[str] = "file_piece"
    id: int
    files: int
    file: int
    """Index in `SendFiles.files`."""
    data: Annotated[U1, Array("u1", ("bytes",), MOST_PIECE_BYTES)]


@dataclass(frozen=True)
class OpenMockup:
    """Opens another mock-up: files that were sent, or a sample; or the present one with other options.

    Answered at once; the document then shows the progress.
    """

    KIND: ClassVar[str] = "open_mockup"
    id: int
    files: int | None
    sample: str | None
    unit: str | None
    """Of the files; null: as they say."""


OpeningRequest = SendFiles | FilePiece | OpenMockup
