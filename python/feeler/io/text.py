"""Text meshes as arrays: decodes, finds tokens and lines with NumPy, reads numbers in bulk, reports errors with lines.

A file is cut into chunks of whole lines. Every token in a chunk has a start, an end and a line; a reader selects tokens
and gets them as numbers in one call. This reads about a hundred megabytes a second, keeps the order of the file, and
knows the line of every token.
"""

from __future__ import annotations

import codecs
import re
import warnings
from collections.abc import Iterator
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from feeler.errors import LoadError

CHUNK_BYTES = 16 * 2**20
_HASH, _NEWLINE, _SPACE = 35, 10, 32

# UTF-32 first: its little-endian mark begins with that of UTF-16.
_MARKS = (
    (codecs.BOM_UTF32_LE, "utf-32-le"),
    (codecs.BOM_UTF32_BE, "utf-32-be"),
    (codecs.BOM_UTF8, "utf-8"),
    (codecs.BOM_UTF16_LE, "utf-16-le"),
    (codecs.BOM_UTF16_BE, "utf-16-be"),
)
# How the C library of old Windows compilers writes what is no number: 1.#IND, -1.#IND00, 1.#QNAN, 1.#INF.
_NOT_FINITE = re.compile(rb"(?<![^\s/])([-+]?)1\.#(?:(INF)|IND|[QS]NAN)\d*(?=[\s/])", re.IGNORECASE)
_DECIMAL_COMMA = re.compile(r"[-+]?(?:\d+,?\d*|,\d+)(?:[eE][-+]?\d+)?")
_LINE_SHOWN = 60
_WITHOUT_MARK = 4  # characters at the start that have to be ASCII in UTF-16 where no mark says so


def decoded(data: bytes) -> bytes:
    """Return a text, or the beginning of one, without its byte order mark, as UTF-8, and with `\\n` as line end.

    UTF-16 and UTF-32 are known by their mark, UTF-16 also without one if it begins with ASCII characters. Bytes of any
    other encoding stay as they are: keywords and numbers are ASCII in all of them, and `name_text` reads names.
    """
    for mark, encoding in _MARKS:
        if data.startswith(mark):
            data = data[len(mark) :]
            if encoding != "utf-8":
                data = data.decode(encoding, "replace").encode("utf-8", "replace")
            break
    else:
        if wide := _utf16_without_mark(data):
            data = data.decode(wide, "replace").encode("utf-8", "replace")
    if b"\r" in data:
        # A lone \r ends a line too (old Mac, concatenated files): the next line would be lost as a surplus.
        data = data.replace(b"\r\n", b"\n").replace(b"\r", b"\n")
    return data


def _utf16_without_mark(data: bytes) -> str | None:
    head = data[: 2 * _WITHOUT_MARK]
    if len(head) < 2 * _WITHOUT_MARK:
        return None
    for encoding, letters, zeros in (("utf-16-le", head[::2], head[1::2]), ("utf-16-be", head[1::2], head[::2])):
        if not any(zeros) and all(9 <= letter < 127 for letter in letters):
            return encoding
    return None


def text_of(path: Path) -> str:
    """Return the text of a file in UTF-8, UTF-16 or UTF-32, as editors and PowerShell write it, without its mark.

    Raises `LoadError` for another encoding, with its line, and for a file that cannot be read; `FileNotFoundError`.
    """
    try:
        data = decoded(path.read_bytes())
    except FileNotFoundError:
        raise
    except OSError as error:
        raise LoadError(f"{path} cannot be read: {error.strerror or error}") from None
    return utf8_text(data, path)


def utf8_text(data: bytes, path: Path) -> str:
    """Return `decoded` text. Raises `LoadError`, with the line, if it is in an encoding that does not say so."""
    try:
        return data.decode("utf-8")
    except UnicodeDecodeError as error:
        if b"\0" in data:
            raise LoadError(f"{path} is no text file: give one of text, in UTF-8") from None
        number = data.count(b"\n", 0, error.start)
        line = name_text(data.split(b"\n")[number].strip())[:_LINE_SHOWN]
        raise LoadError(
            f"{path}, line {number + 1}: this is not UTF-8 but an older encoding, such as Windows-1252 ({line!r}): "
            "save the file as UTF-8"
        ) from None


SEPARATOR_LINE = re.compile(r'"?sep=(.)"?[ \t]*(?:\r\n|[\r\n]|\Z)', re.IGNORECASE)
"""The first line with which Excel says what separates columns."""


def numbers_of(text: str, each: int, what: str) -> list[float]:
    """Return the numbers in a text, split by blanks, lines, commas or semicolons.

    each: how many of them one of `what` ("poses") has. It tells decimal commas ("0,5; 1,0") from commas that separate
    ("0.5, 1.0"): with decimal commas, every word is a number, and there are as many as there should be. Raises
    `ValueError` for a word that is no number, and where their number is no multiple of `each`.
    """
    said = SEPARATOR_LINE.match(text)
    words = text[said.end() if said else 0 :].replace(";", " ").split()
    if not ("," in text and len(words) % each == 0 and all(_DECIMAL_COMMA.fullmatch(word) for word in words)):
        words = [word for part in words for word in part.split(",") if word]
    numbers = []
    for word in words:
        try:
            numbers.append(float(word.replace(",", ".")))
        except ValueError:
            raise ValueError(f"{word[:_LINE_SHOWN]!r} is not a number") from None
    if len(numbers) % each:
        raise ValueError(f"{len(numbers)} numbers are not a multiple of {each}, as {what} have")
    return numbers


def name_text(raw: bytes) -> str:
    """Return a name from a file of unknown encoding: UTF-8, or else Windows-1252.

    Different names in bytes stay different.
    """
    for encoding in ("utf-8", "cp1252"):
        try:
            return raw.decode(encoding)
        except UnicodeDecodeError:
            continue
    return raw.decode("latin-1")


def _spelled_out(data: bytes, names: bytes) -> bytes:
    """Return the text with `1.#IND` and the like as `nan` and `inf`, of the same length: else its `#` begins a comment.

    Lines whose first word is one of the letters in `names` stay as they are.
    """
    if b"1.#" not in data:
        return data

    def spelled(found: re.Match[bytes]) -> bytes:
        line = data[data.rfind(b"\n", 0, found.start()) + 1 : found.start()].split()
        if line and line[0].lower() in [bytes([letter]) for letter in names]:
            return found[0]
        return (found[1] + (b"inf" if found[2] else b"nan")).ljust(len(found[0]))

    return _NOT_FINITE.sub(spelled, data)


class Chunk:
    """Some whole lines of a text file, in tokens. Token and line numbers count from 0 within the chunk."""

    def __init__(self, data: bytes, path: Path, first_line: int, comments: bool, names: bytes = b"") -> None:
        self.path = path
        self.first_line = first_line  # counted from 1, as editors do
        data = _spelled_out(data if data.endswith(b"\n") else data + b"\n", names)
        buffer = np.frombuffer(data, dtype=np.uint8)
        ends = np.flatnonzero(buffer == _NEWLINE)
        self._line_starts = np.concatenate(([0], ends[:-1] + 1))
        blank = buffer <= _SPACE
        if comments and b"#" in data:
            marks = np.flatnonzero(buffer == _HASH)
            lines, first = np.unique(np.searchsorted(self._line_starts, marks, side="right") - 1, return_index=True)
            if names:
                named = _begins_with(buffer, blank, self._line_starts[lines], names)
                lines, first = lines[~named], first[~named]
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
        """Return the byte at that offset of each token, as a lower-case letter; beyond the token, the byte there."""
        place = np.minimum(self.starts[tokens] + at, len(self._buffer) - 1)
        letters: NDArray[np.uint8] = self._buffer[place] | np.uint8(0x20)
        return letters

    def words(self, tokens: NDArray[np.int64], width: int = 12) -> NDArray[np.bytes_]:
        """Return those tokens in lower case, cut at `width` bytes."""
        letters = self._letters(self.starts[tokens], self.ends[tokens], width)
        letters[(letters >= ord("A")) & (letters <= ord("Z"))] |= 0x20
        words: NDArray[np.bytes_] = letters.view(f"S{width}").reshape(-1)
        return words

    def line_bytes(self, lines: NDArray[np.int64], skip: int, width: int = 64) -> NDArray[np.bytes_]:
        """Return the bytes of those lines after the first `skip` tokens, cut at `width`."""
        first, count = self.first_token[lines], self.tokens_in_line[lines]
        last = first + count - 1
        starts = np.where(count > skip, self.starts[np.minimum(first + skip, last)], self.ends[last])
        width = max(1, min(width, int((self.ends[last] - starts).max(initial=0))))
        texts: NDArray[np.bytes_] = self._letters(starts, self.ends[last], width).view(f"S{width}").reshape(-1)
        return texts

    def _letters(self, starts: NDArray[np.int64], ends: NDArray[np.int64], width: int) -> NDArray[np.uint8]:
        place = starts[:, None] + np.arange(width)
        inside = place < ends[:, None]
        return np.where(inside, self._buffer[np.minimum(place, len(self._buffer) - 1)], 0).astype(np.uint8)

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
        """Return the text of a line (after its first tokens, comment excluded), as `name_text` reads it."""
        first = int(self.first_token[line])
        count = int(self.tokens_in_line[line])
        if count <= skip_tokens:
            return ""
        start, end = int(self.starts[first + skip_tokens]), int(self.ends[first + count - 1])
        return name_text(self._buffer[start:end].tobytes())

    def floats(self, tokens: NDArray[np.int64]) -> NDArray[np.float64]:
        """Read those tokens as float64 (correctly rounded; nan and inf are numbers here)."""
        return self._numbers(self.starts[tokens], self.ends[tokens], tokens, np.float64)  # type: ignore[return-value]

    def integers(self, tokens: NDArray[np.int64], until_slash: bool = False) -> NDArray[np.int64]:
        """Read those tokens as integers; with `until_slash` only up to the first `/` of each."""
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


def chunks_of(
    data: bytes, path: Path, comments: bool, first_line: int = 1, names: bytes = b""
) -> Iterator[tuple[float, Chunk]]:
    """Cut a text, as `decoded` returns it, into chunks of whole lines; yield (share done before this chunk, chunk).

    With `comments`, a `#` and what follows on its line is left out; not so on lines whose first word is one of the
    letters in `names`.
    """
    at, total = 0, max(len(data), 1)
    while at < len(data):
        end = len(data) if at + CHUNK_BYTES >= len(data) else data.rfind(b"\n", at, at + CHUNK_BYTES) + 1
        if end <= at:  # one line longer than a chunk
            end = data.find(b"\n", at) + 1 or len(data)
        chunk = Chunk(data[at:end], path, first_line, comments, names)
        yield at / total, chunk
        first_line += chunk.line_count
        at = end


def _begins_with(
    buffer: NDArray[np.uint8], blank: NDArray[np.bool_], line_starts: NDArray[np.int64], letters: bytes
) -> NDArray[np.bool_]:
    """Tell which of the lines, none of them empty, have one of the letters, of either case, as their first word."""
    solid = np.flatnonzero(~blank)
    at = solid[np.searchsorted(solid, line_starts)]
    known = np.isin(buffer[at] | np.uint8(0x20), np.frombuffer(letters, dtype=np.uint8))
    result: NDArray[np.bool_] = known & blank[np.minimum(at + 1, len(buffer) - 1)]
    return result


def _ranges(starts: NDArray[np.int64], ends: NDArray[np.int64], size: int) -> NDArray[np.bool_]:
    """Return a mask that is true inside the given half-open ranges, which are sorted and do not overlap."""
    edge = np.zeros(size + 1, dtype=np.int8)
    edge[starts] += 1
    edge[ends] -= 1
    mask: NDArray[np.bool_] = np.cumsum(edge[:-1], dtype=np.int8).view(np.bool_)
    return mask


def _parse(text: bytes, dtype: type[np.generic]) -> NDArray[np.generic] | None:
    """Return the numbers in a text, or None for other text."""
    with warnings.catch_warnings():
        warnings.simplefilter("error")  # NumPy before 2.3 warns and returns the numbers before the error
        try:
            return np.fromstring(text, dtype=dtype, sep=" ")
        except (ValueError, DeprecationWarning):
            return None
