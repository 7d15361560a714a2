"""Decoder of meshopt streams: EXT_meshopt_compression and KHR_meshopt_compression of glTF.

Written after the appendices A and B of KHR_meshopt_compression. No package with wheels for every platform decodes these
streams. Attributes are decoded in two passes: the first finds each group of 16 values, because its length depends on
its content; the second unpacks all groups of a kind at once.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import Any, TypeAlias

import numpy as np
from numpy.typing import NDArray

_GROUP = 16  # values packed together
_ATTRIBUTE_HEADER, _TRIANGLE_HEADER, _INDEX_HEADER = 0xA0, 0xE0, 0xD0
_TRIANGLE_TAIL, _INDEX_TAIL = 16, 4
_WRAP = 0xFFFFFFFF
_NEVER = -1  # initial content of the queues of the triangle decoder

# Bits per value, by control mode and header bits; version 0 has one mode.
_BITS_V0 = (0, 2, 4, 8)
_BITS_V1 = ((0, 1, 2, 4), (1, 2, 4, 8))
_ALL_ZERO, _LITERAL = 2, 3  # the other control modes

# How many values of a byte are the sentinel (all bits set), which stands for a whole byte after the group.
_SENTINELS = {
    bits: bytes(sum((byte >> at) % 2**bits == 2**bits - 1 for at in range(0, 8, bits)) for byte in range(256))
    for bits in (1, 2, 4)
}

Bytes: TypeAlias = NDArray[np.uint8]


class DamagedError(Exception):
    """The stream does not match its parameters."""


def decode(data: memoryview, count: int, stride: int, mode: str, filter_name: str = "NONE") -> memoryview:
    """Decode the `count * stride` bytes of a stream of this mode and filter."""
    decoders: dict[str, Callable[[bytes, int, int], Bytes]] = {
        "ATTRIBUTES": _attributes, "TRIANGLES": _triangles, "INDICES": _indices,
    }  # fmt: skip
    filters: dict[str, Callable[[Bytes], Bytes] | None] = {
        "NONE": None, "OCTAHEDRAL": _octahedral, "QUATERNION": _quaternion, "EXPONENTIAL": _exponential,
    }  # fmt: skip
    if mode not in decoders or filter_name not in filters:
        raise DamagedError(f"mode {mode[:20]!r} with filter {filter_name[:20]!r} is not known for geometry")
    if mode == "ATTRIBUTES":
        if stride % 4 or not 4 <= stride <= 256:
            raise DamagedError(f"elements of {stride} bytes: they have 4, 8 ... 256")
    elif stride not in (2, 4):
        raise DamagedError(f"indices of {stride} bytes: they have 2 or 4")
    values = decoders[mode](bytes(data), count, stride)
    change = filters[filter_name]
    if change is not None and count:
        if filter_name != "EXPONENTIAL" and stride not in ((8,) if filter_name == "QUATERNION" else (4, 8)):
            raise DamagedError(f"the filter {filter_name} does not go with elements of {stride} bytes")
        values = change(values)
    return memoryview(np.ascontiguousarray(values).tobytes())


# --- attributes ----------------------------------------------------------------------------------------------------


def _attributes(data: bytes, count: int, stride: int) -> Bytes:
    """Return elements (count, stride)."""
    version = _version(data, _ATTRIBUTE_HEADER)
    tail = stride + (stride // 4 if version else 0)
    end = len(data) - max(tail, 24 if version else 32)
    if end < 1:
        raise DamagedError("the stream ends before its tail")
    padded = -(-count // _GROUP) * _GROUP
    block_most = min((8192 // stride) & ~15, 256)
    # A block has at least two bits for each byte of an element, or with version 1 one byte for four of them.
    blocks = -(-count // block_most)
    if blocks * (stride // 4) > len(data):
        raise DamagedError(f"{len(data):,} bytes are too few for {count:,} elements")
    deltas = np.zeros(stride * padded, dtype=np.uint8)
    found = _find_groups(data, end, count, stride, padded, block_most, version, deltas)
    if found.end != end:
        raise DamagedError("the stream is longer than its elements")
    source = np.frombuffer(data, dtype=np.uint8)
    for bits, (places, offsets) in found.groups.items():
        if places:
            rows = np.array(places)[:, None] + np.arange(_GROUP)
            deltas[rows] = _unpacked(source, np.array(offsets), bits)
    first = source[len(data) - tail :][:stride]
    channels = source[len(data) - stride // 4 :] if version else np.zeros(stride // 4, dtype=np.uint8)
    values = np.empty((count, stride), dtype=np.uint8)
    table = deltas.reshape(stride, padded)[:, :count]
    for at in range(0, stride, 4):
        values[:, at : at + 4] = _undelta(table[at : at + 4], first[at : at + 4], int(channels[at // 4]))
    return values


class _Found:
    """Find the groups: by bits per value, (places in the deltas, offsets in the stream)."""

    def __init__(self) -> None:
        self.groups: dict[int, tuple[list[int], list[int]]] = {bits: ([], []) for bits in (1, 2, 4, 8)}
        self.end = 0


def _find_groups(
    data: bytes, end: int, count: int, stride: int, padded: int, block_most: int, version: int, deltas: Bytes
) -> _Found:
    found = _Found()
    at = 1
    for start in range(0, count, block_most):
        size = min(block_most, count - start)
        groups = -(-size // _GROUP)
        control = data[at : at + stride // 4] if version else b""
        at += len(control)
        for column in range(stride):
            mode = (control[column // 4] >> (2 * (column % 4))) & 3 if version and at <= end else 0
            place = column * padded + start
            if at > end:
                raise DamagedError("the stream ends inside its elements")
            if version and mode == _ALL_ZERO:
                continue
            if version and mode == _LITERAL:
                if at + size > end:
                    raise DamagedError("the stream ends inside its elements")
                deltas[place : place + size] = np.frombuffer(data, np.uint8, size, at)
                at += size
                continue
            table = _BITS_V1[mode] if version else _BITS_V0
            header, at = at, at + (groups + 3) // 4
            for group in range(groups):
                if at > end:
                    raise DamagedError("the stream ends inside its elements")
                bits = table[(data[header + group // 4] >> (2 * (group % 4))) & 3]
                if not bits:
                    continue
                places, offsets = found.groups[bits]
                places.append(place + _GROUP * group)
                offsets.append(at)
                packed = 2 * bits
                at += packed + (sum(data[at : at + packed].translate(_SENTINELS[bits])) if bits < 8 else 0)
    found.end = at
    return found


def _unpacked(source: Bytes, offsets: NDArray[np.int64], bits: int) -> Bytes:
    """Return the values (g, 16) of the groups at these offsets."""
    packed: Bytes = source[offsets[:, None] + np.arange(2 * bits)]
    if bits == 8:
        return packed
    shifts = np.arange(0, 8, bits, dtype=np.uint8)
    if bits > 1:
        shifts = shifts[::-1]  # the first value is in the high bits, but with one bit in the low
    values: Bytes = ((packed[:, :, None] >> shifts) & ((1 << bits) - 1)).reshape(len(offsets), _GROUP).astype(np.uint8)
    whole = values == (1 << bits) - 1
    rank = np.cumsum(whole, axis=1)
    at = (offsets[:, None] + 2 * bits + rank - 1)[whole]
    if at.size and int(at.max()) >= len(source):
        raise DamagedError("the stream ends inside its elements")
    values[whole] = source[at]
    return values


def _undelta(deltas: Bytes, first: Bytes, channel: int) -> Bytes:
    """Return the four bytes (n, 4) of a channel from its deltas (4, n) and the element before the first."""
    mode, turn = channel & 15, channel >> 4
    if mode > 2 or (mode < 2 and turn):
        raise DamagedError(f"the channel mode {channel} is not known")
    if mode < 2:
        kind = np.dtype("<u1" if mode == 0 else "<u2")
        steps = np.ascontiguousarray(deltas.T).view(kind)
        one = kind.type(1)
        steps = (steps >> one) ^ (~(steps & one) + one)  # the sign is in the lowest bit
        total = np.cumsum(steps, axis=0, dtype=kind) + np.ascontiguousarray(first).view(kind)
        return _bytes_of(total.astype(kind))
    words = np.ascontiguousarray(deltas.T).view("<u4")[:, 0]
    if turn:
        words = (words << np.uint32(turn)) | (words >> np.uint32(32 - turn))
    mixed = np.bitwise_xor.accumulate(words) if len(words) else words
    whole = (mixed ^ np.ascontiguousarray(first).view("<u4")[0]).astype("<u4")
    return _bytes_of(whole[:, None])


# --- indices -------------------------------------------------------------------------------------------------------


class _Reader:
    """Reads numbers of seven bits per byte."""

    def __init__(self, data: bytes, at: int, end: int) -> None:
        self.data, self.at, self.end = data, at, end

    def byte(self) -> int:
        if self.at >= self.end:
            raise DamagedError("the stream ends inside its indices")
        self.at += 1
        return self.data[self.at - 1]

    def number(self) -> int:
        value = 0
        for shift in range(0, 35, 7):
            byte = self.byte()
            value |= (byte & 127) << shift
            if byte < 128:
                break
        return value & _WRAP

    def near(self, last: int) -> int:
        """Return an index written as its signed distance from `last`."""
        value = self.number()
        return (last + ((value >> 1) ^ -(value & 1))) & _WRAP


def _indices(data: bytes, count: int, stride: int) -> Bytes:
    _version(data, _INDEX_HEADER)
    reader = _Reader(data, 1, len(data) - _INDEX_TAIL)
    if count > len(data):
        raise DamagedError(f"{len(data):,} bytes are too few for {count:,} indices")
    last = [0, 0]
    made = []
    for _ in range(count):
        value = reader.number()
        which, value = value & 1, value >> 1
        last[which] = (last[which] + ((value >> 1) ^ -(value & 1))) & _WRAP
        made.append(last[which])
    if reader.at != reader.end:
        raise DamagedError("the stream is longer than its indices")
    return _as_bytes(made, stride)


def _triangles(data: bytes, count: int, stride: int) -> Bytes:
    version = _version(data, _TRIANGLE_HEADER)
    if count % 3 or 1 + count // 3 + _TRIANGLE_TAIL > len(data):
        raise DamagedError(f"{len(data):,} bytes cannot be {count:,} corners of triangles")
    codes = data[1 : 1 + count // 3]
    table = data[len(data) - _TRIANGLE_TAIL :]
    reader = _Reader(data, 1 + count // 3, len(data) - _TRIANGLE_TAIL)
    edges = [(_NEVER, _NEVER)] * 16  # the last 16 that were pushed, in a ring
    corners = [_NEVER] * 16
    edge_at = corner_at = 0
    upcoming = last = 0
    beside_last = version >= 1  # codes 13 and 14 mean the neighbours of `last`
    made: list[int] = []
    for code in codes:
        high, low = code >> 4, code & 15
        if high < 15:
            a, b = edges[(edge_at - 1 - high) & 15]
            is_new = True
            if low == 0:
                c = upcoming
                upcoming = (upcoming + 1) & _WRAP
            elif low == 15:
                last = c = reader.near(last)
            elif beside_last and low >= 13:
                last = c = (last + (-1 if low == 13 else 1)) & _WRAP
            else:
                c, is_new = corners[(corner_at - 1 - low) & 15], False
            if is_new:
                corners[corner_at & 15] = c
                corner_at += 1
        else:
            explicit = low >= 14
            pair = reader.byte() if explicit else table[low]
            second, third = pair >> 4, pair & 15
            if explicit and pair == 0:
                upcoming = 0
            if low == 15:
                a = _NEVER
            else:
                a = upcoming
                upcoming = (upcoming + 1) & _WRAP
            if second == 0:
                b = upcoming
                upcoming = (upcoming + 1) & _WRAP
            else:
                b = corners[(corner_at - second) & 15]
            if third == 0:
                c = upcoming
                upcoming = (upcoming + 1) & _WRAP
            else:
                c = corners[(corner_at - third) & 15]
            if low == 15:
                last = a = reader.near(last)
            if explicit and second == 15:
                last = b = reader.near(last)
            if explicit and third == 15:
                last = c = reader.near(last)
            for index, is_new in ((a, True), (b, second in (0, 15)), (c, third in (0, 15))):
                if is_new:
                    corners[corner_at & 15] = index
                    corner_at += 1
            edges[edge_at & 15] = (b, a)
            edge_at += 1
        edges[edge_at & 15] = (c, b)
        edges[(edge_at + 1) & 15] = (a, c)
        edge_at += 2
        made += (a, b, c)
    if reader.at != reader.end:
        raise DamagedError("the stream is longer than its triangles")
    if made and min(made) == _NEVER:
        raise DamagedError("a triangle refers to an edge or corner before the first")
    return _as_bytes(made, stride)


def _as_bytes(indices: list[int], stride: int) -> Bytes:
    wide = np.array(indices, dtype="<u4")
    return _bytes_of(wide.astype("<u2") if stride == 2 else wide)


def _bytes_of(values: NDArray[Any]) -> Bytes:
    """Return values (n, k) as their bytes (n, k * size)."""
    made: Bytes = np.ascontiguousarray(values).view(np.uint8)
    return made


def _version(data: bytes, header: int) -> int:
    if not data or data[0] & 0xF0 != header or data[0] & 15 > 1:
        raise DamagedError(f"the stream starts with {data[:1].hex() or 'nothing'}, and not with {header | 1:x}")
    return data[0] & 15


# --- filters -------------------------------------------------------------------------------------------------------


def _octahedral(values: Bytes) -> Bytes:
    kind = np.dtype("<i1" if values.shape[1] == 4 else "<i2")
    packed = np.ascontiguousarray(values).view(kind)
    most = np.float32(np.iinfo(kind).max)
    with np.errstate(all="ignore"):
        one = packed[:, 2].astype(np.float32)
        x, y = packed[:, 0] / one, packed[:, 1] / one
        z = 1 - np.abs(x) - np.abs(y)
        fold = np.minimum(z, 0)
        x, y = x - np.copysign(fold, x), y - np.copysign(fold, y)
        unit = np.stack([x, y, z], axis=1) / np.sqrt(x * x + y * y + z * z)[:, None]
        made = packed.copy()
        made[:, :3] = _rounded(unit * most)
    return _bytes_of(made)


def _quaternion(values: Bytes) -> Bytes:
    packed = np.ascontiguousarray(values).view("<i2")
    with np.errstate(all="ignore"):
        one = (packed[:, 3] | 3).astype(np.float32)
        three = packed[:, :3] / one[:, None] * np.float32(0.5**0.5)
        fourth = np.sqrt(np.maximum(0, 1 - (three * three).sum(axis=1)))
        made = np.empty_like(packed)
        rows, largest = np.arange(len(packed)), packed[:, 3] & 3
        for step, part in enumerate((fourth, three[:, 0], three[:, 1], three[:, 2])):
            made[rows, (largest + step) % 4] = _rounded(part * np.float32(32767))
    return _bytes_of(made)


def _exponential(values: Bytes) -> Bytes:
    packed = np.ascontiguousarray(values).view("<i4")
    mantissa = (packed << 8) >> 8
    with np.errstate(all="ignore"):
        made = np.ldexp(mantissa.astype(np.float32), packed >> 24).astype("<f4")
    return _bytes_of(made)


def _rounded(values: NDArray[np.float32]) -> NDArray[np.int64]:
    """Return the nearest whole numbers, halves away from zero."""
    whole: NDArray[np.int64] = np.trunc(np.nan_to_num(values) + np.copysign(np.float32(0.5), values)).astype(np.int64)
    return whole
