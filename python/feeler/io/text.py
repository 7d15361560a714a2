"""Text meshes as arrays: tokens and lines found with NumPy, numbers read in bulk, errors told with their line.

A file is cut into chunks of whole lines. In a chunk every token has a start, an end and a line; a reader picks the
tokens it wants and gets them as numbers in one call. This reads about a hundred megabytes a second, keeps the order of
the file, and knows the line of every token.
"""

from __future__ import annotations

import warnings
from collections.abc import Iterator
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from feeler.errors import LoadError

CHUNK_BYTES = 16 * 2**20
_HASH, _NEWLINE, _SPACE = 35, 10, 32


class Chunk:
    """Some whole lines of a text file, in tokens. Token and line numbers count from 0 within the chunk."""

    def __init__(self, data: bytes, path: Path, first_line: int, comments: bool) -> None:
        self.path = path
        self.first_line = first_line  # counted from 1, as editors do
        buffer = np.frombuffer(data if data.endswith(b"\n") else data + b"\n", dtype=np.uint8)
        ends = np.flatnonzero(buffer == _NEWLINE)
        self._line_starts = np.concatenate(([0], ends[:-1] + 1))
        blank = buffer <= _SPACE
        if comments and b"#" in data:
            marks = np.flatnonzero(buffer == _HASH)
            lines, first = np.unique(np.searchsorted(self._line_starts, marks, side="right") - 1, return_index=True)
            blank |= _ranges(marks[first], ends[lines], len(buffer))
        solid = ~blank
        solid[1:] &= blank[:-1]
        self.starts: NDArray[np.int64] = np.flatnonzero(solid)
        solid = ~blank[:-1] & blank[1:]
        self.ends: NDArray[np.int64] = np.flatnonzero(solid) + 1
        self._buffer = buffer
        self._blank = blank
        self.line_count = len(ends)
        self.first_token: NDArray[np.int64] = np.searchsorted(self.starts, self._line_starts)
        self.tokens_in_line: NDArray[np.int64] = np.diff(self.first_token, append=len(self.starts))

    def token_line(self, tokens: NDArray[np.int64]) -> NDArray[np.int64]:
        """Return the line each token is on, within the chunk."""
        line: NDArray[np.int64] = np.searchsorted(self._line_starts, self.starts[tokens], side="right") - 1
        return line

    def letter(self, tokens: NDArray[np.int64], at: int = 0) -> NDArray[np.uint8]:
        """Return the byte at that offset of each token, as a lower-case letter; beyond the token: what is there."""
        place = np.minimum(self.starts[tokens] + at, len(self._buffer) - 1)
        letters: NDArray[np.uint8] = self._buffer[place] | np.uint8(0x20)
        return letters

    def length(self, tokens: NDArray[np.int64]) -> NDArray[np.int64]:
        """Return the length of each token in bytes."""
        return self.ends[tokens] - self.starts[tokens]

    def line_tokens(self, lines: NDArray[np.int64], skip: int, count: NDArray[np.int64] | int) -> NDArray[np.int64]:
        """Return the tokens of those lines, after the first `skip`, `count` of each line, in order."""
        counts = np.broadcast_to(count, lines.shape)
        offsets = np.arange(int(counts.sum())) - np.repeat(np.cumsum(counts) - counts, counts)
        tokens: NDArray[np.int64] = np.repeat(self.first_token[lines] + skip, counts) + offsets
        return tokens

    def line_text(self, line: int, skip_tokens: int = 0) -> str:
        """Return the text of a line (after its first tokens, comment excluded)."""
        first = int(self.first_token[line])
        count = int(self.tokens_in_line[line])
        if count <= skip_tokens:
            return ""
        start, end = int(self.starts[first + skip_tokens]), int(self.ends[first + count - 1])
        return self._buffer[start:end].tobytes().decode("utf-8", "replace")

    def floats(self, tokens: NDArray[np.int64]) -> NDArray[np.float64]:
        """Read those tokens as float64 (correctly rounded; nan and inf are numbers here)."""
        return self._numbers(self.starts[tokens], self.ends[tokens], tokens, np.float64)  # type: ignore[return-value]

    def integers(self, tokens: NDArray[np.int64], until_slash: bool = False) -> NDArray[np.int64]:
        """Read those tokens as integers; with `until_slash` only what stands before the first `/` of each."""
        ends = self.ends[tokens]
        if until_slash:
            slashes = np.flatnonzero(self._buffer == 47)
            if len(slashes):
                after = np.searchsorted(slashes, self.starts[tokens])
                nearest = slashes[np.minimum(after, len(slashes) - 1)]
                ends = np.where((after < len(slashes)) & (nearest < ends), nearest, ends)
        return self._numbers(self.starts[tokens], ends, tokens, np.int64)  # type: ignore[return-value]

    def fail(self, line: int, what: str) -> LoadError:
        """Return the error for a line of this chunk."""
        return LoadError(f"{self.path}, line {self.first_line + line}: {what}")

    def _numbers(
        self, starts: NDArray[np.int64], ends: NDArray[np.int64], tokens: NDArray[np.int64], dtype: type[np.generic]
    ) -> NDArray[np.generic]:
        if len(starts) == 0:
            return np.empty(0, dtype=dtype)
        # Keep each token and the one byte behind it, which becomes the space between two numbers.
        text = np.where(self._blank, _SPACE, self._buffer).astype(np.uint8)
        text[ends] = _SPACE
        values = _parse(text[_ranges(starts, ends + 1, len(text))].tobytes(), dtype)
        if values is None or len(values) != len(starts):
            self._raise_bad_token(starts, ends, tokens, dtype)
        assert values is not None
        return values

    def _raise_bad_token(
        self, starts: NDArray[np.int64], ends: NDArray[np.int64], tokens: NDArray[np.int64], dtype: type[np.generic]
    ) -> None:
        kind = "an integer" if dtype is np.int64 else "a number"
        for token, start, end in zip(tokens.tolist(), starts.tolist(), ends.tolist(), strict=True):
            text = self._buffer[start:end].tobytes()
            value = _parse(text, dtype)
            if value is None or len(value) != 1:
                line = int(self.token_line(np.array([token]))[0])
                shown = text[:40].decode("utf-8", "replace")
                raise self.fail(line, f"{shown!r} is not {kind}; correct the line or export the file again")
        raise LoadError(f"{self.path}: numbers near line {self.first_line} run together; export the file again")


def chunks_of(data: bytes, path: Path, comments: bool, first_line: int = 1) -> Iterator[tuple[float, Chunk]]:
    """Cut a text into chunks of whole lines; yield (share of the text done before this chunk, chunk)."""
    if b"\n" not in data[:CHUNK_BYTES] and b"\r" in data[:CHUNK_BYTES]:
        data = data.replace(b"\r", b"\n")  # line ends of the old Mac
    at, total = 0, max(len(data), 1)
    while at < len(data):
        end = len(data) if at + CHUNK_BYTES >= len(data) else data.rfind(b"\n", at, at + CHUNK_BYTES) + 1
        if end <= at:  # one line longer than a chunk
            end = data.find(b"\n", at) + 1 or len(data)
        chunk = Chunk(data[at:end], path, first_line, comments)
        yield at / total, chunk
        first_line += chunk.line_count
        at = end


def _ranges(starts: NDArray[np.int64], ends: NDArray[np.int64], size: int) -> NDArray[np.bool_]:
    """Return a mask that is true inside the given half-open ranges, which are sorted and do not overlap."""
    edge = np.zeros(size + 1, dtype=np.int8)
    edge[starts] += 1
    edge[ends] -= 1
    mask: NDArray[np.bool_] = np.cumsum(edge[:-1], dtype=np.int8).view(np.bool_)
    return mask


def _parse(text: bytes, dtype: type[np.generic]) -> NDArray[np.generic] | None:
    """Return the numbers in a text, or None if something in it is no number."""
    with warnings.catch_warnings():
        warnings.simplefilter("error")  # NumPy before 2.3 warns and returns what came before
        try:
            return np.fromstring(text, dtype=dtype, sep=" ")
        except (ValueError, DeprecationWarning):
            return None
