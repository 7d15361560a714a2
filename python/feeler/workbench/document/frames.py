"""Encodes messages as frames of the socket and of saved pages, and decodes them strictly.

A message is a frozen dataclass with a `KIND`. One without arrays is JSON text: its fields, and "kind". One with arrays
is binary, little-endian:

    u32 version | u32 header bytes | JSON header, padded with spaces | arrays, each at a multiple of 8

The header has the other fields, "kind", and "arrays": name -> [type, shape, offset from the end of the header]. Every
received frame is checked in full against the dataclass, because any page may send anything: `ProtocolError` says what
is wrong and where.
"""

from __future__ import annotations

import functools
import json
import math
import struct
import types
from collections.abc import Iterable
from dataclasses import dataclass, fields
from typing import Annotated, Any, Literal, Union, cast, get_args, get_origin, get_type_hints, is_typeddict

import numpy as np
import numpy.typing as npt

from feeler.errors import WorkbenchError

VERSION = 1
"""Version of the protocol: pages with another one must reload."""

MOST_DEEP = 32
"""The deepest nesting of lists and objects in values without a schema."""

_DTYPES = {"f8": "<f8", "f4": "<f4", "u4": "<u4", "u2": "<u2", "u1": "|u1"}
_MOST_HEADER_BYTES = 1 << 20
_MOST_WHOLE = 2**53  # the largest whole number of JavaScript without gaps
_PREFIX = struct.Struct("<II")


class ProtocolError(WorkbenchError):
    """A frame is not a message of this protocol."""

    def __init__(self, what: str, where: str = "message", do: str = "reload the page") -> None:
        super().__init__(what, where, do)


@dataclass(frozen=True)
class Array:
    """The format of an array field.

    type: "f8", "f4", "u4", "u2" or "u1". shape: numbers, or names for free lengths; if a name occurs in several arrays
    of a message, their lengths must agree. most: the most rows, if the first length is free.
    """

    type: str
    shape: tuple[int | str, ...]
    most: int | None = None


@dataclass(frozen=True)
class Partial:
    """Marks an object with some of the keys of a `TypedDict`."""

    of: type


@dataclass(frozen=True)
class Open:
    """Marks an object with the keys of a `TypedDict`, and maybe others, which are not checked."""

    of: type


@dataclass(frozen=True)
class _Plan:
    """The fields of a message: JSON ones, and arrays."""

    plain: dict[str, Any]
    arrays: dict[str, Array]


@functools.cache
def _plan(message: Any) -> _Plan:
    hints = get_type_hints(message, include_extras=True)
    plain: dict[str, Any] = {}
    arrays: dict[str, Array] = {}
    for field in fields(message):
        extras = get_args(hints[field.name])[1:] if get_origin(hints[field.name]) is Annotated else ()
        if extras and isinstance(extras[0], Array):
            arrays[field.name] = extras[0]
        else:
            plain[field.name] = hints[field.name]
    return _Plan(plain, arrays)


def tag_of(message: type) -> dict[str, Any]:
    """The keys that identify a message in JSON: "kind", and "type" or "ok" if several share a kind."""
    return {"kind": message.__dict__["KIND"], **message.__dict__.get("TAG", {})}


def pack(message: Any) -> str | bytes:
    """The frame of a message: text, or bytes if it has arrays. Raises `ProtocolError`."""
    cls: Any = type(message)
    plan = _plan(cls)
    header = {**tag_of(cls), **{name: getattr(message, name) for name in plan.plain}}
    if not plan.arrays:
        return dumps(header, cls.__name__)
    places: dict[str, list[Any]] = {}
    blocks: list[bytes] = []
    offset = 0
    lengths: dict[str, int] = {}
    for name, spec in plan.arrays.items():
        array = np.ascontiguousarray(getattr(message, name), dtype=_DTYPES[spec.type])
        _check_shape(array.shape, spec, lengths, f"{cls.__name__}.{name}")
        places[name] = [spec.type, list(array.shape), offset]
        block = array.tobytes()
        block += bytes(-len(block) % 8)
        blocks.append(block)
        offset += len(block)
    text = dumps({**header, "arrays": places}, cls.__name__).encode()
    text += b" " * (-len(text) % 8)
    return b"".join([_PREFIX.pack(VERSION, len(text)), text, *blocks])


def dumps(value: Any, where: str = "message") -> str:
    """Compact JSON; NumPy's numbers and arrays count as Python's. Raises `ProtocolError` for NaN and infinity."""
    try:
        return json.dumps(value, separators=(",", ":"), allow_nan=False, default=_plain)
    except (ValueError, TypeError, RecursionError) as error:
        raise ProtocolError(f"cannot be written as JSON: {error}", where, "report it") from None


def _plain(value: Any) -> Any:
    if isinstance(value, np.generic | np.ndarray):
        return value.tolist()
    raise TypeError(f"{type(value).__name__} has no place in a message")


def unpack(frame: str | bytes, messages: Iterable[type]) -> Any:
    """The message of a frame, one of the given classes. Raises `ProtocolError`, and nothing else."""
    if isinstance(frame, str):
        return _build(_json_object(frame), messages, None)
    if len(frame) < _PREFIX.size:
        raise ProtocolError(f"a binary frame of {len(frame)} bytes is shorter than its prefix of {_PREFIX.size}")
    version, size = _PREFIX.unpack_from(frame)
    if version != VERSION:
        raise ProtocolError(f"a binary frame of version {version}: {VERSION} is expected")
    start = _PREFIX.size + size
    if size > _MOST_HEADER_BYTES or size % 8 or start > len(frame):
        raise ProtocolError(f"a header of {size} bytes in a binary frame of {len(frame)}")
    try:
        text = frame[_PREFIX.size : start].decode()
    except UnicodeDecodeError as error:
        raise ProtocolError(f"the header is not UTF-8: {error.reason} at byte {error.start}") from None
    return _build(_json_object(text), messages, frame[start:])


def version_of(frame: str | bytes) -> int | None:
    """The protocol version in a first message, whatever its other content; None if there is none."""
    try:
        value = _json_object(frame) if isinstance(frame, str) else {}
    except ProtocolError:
        return None
    version = value.get("protocol")
    return version if value.get("kind") == "hello" and type(version) is int else None


def id_of(frame: str | bytes) -> int | None:
    """The id in a frame that is otherwise wrong, so that its error can be matched to the request; None if missing."""
    try:
        value = _json_object(frame) if isinstance(frame, str) else {}
    except ProtocolError:
        return None
    found = value.get("id")
    return found if type(found) is int and abs(found) <= _MOST_WHOLE else None


def _json_object(text: str) -> dict[str, Any]:
    def refuse(word: str) -> float:
        raise ProtocolError(f"{word} is not a JSON number")

    try:
        value = json.loads(text, parse_constant=refuse)
    except (ValueError, RecursionError) as error:
        raise ProtocolError(f"not JSON: {error}") from None
    if not isinstance(value, dict):
        raise ProtocolError(f"a JSON {_name(value)}: an object is needed")
    return value


def _build(value: dict[str, Any], messages: Iterable[type], body: bytes | None) -> Any:
    candidates = [each for each in messages if _has_tag(value, each)]
    if not candidates:
        raise ProtocolError(f"kind is {_short(value.get('kind'))}: no message of this direction is called so")
    (cls,) = candidates
    plan = _plan(cls)
    where = cls.__name__
    expected = {*tag_of(cls), *plan.plain, *(("arrays",) if plan.arrays else ())}
    _check_keys(value, expected, where)
    if bool(plan.arrays) != (body is not None):
        raise ProtocolError(f"a {'text' if body is None else 'binary'} frame", where)
    given = {name: check(value[name], hint, f"{where}.{name}") for name, hint in plan.plain.items()}
    if body is not None:
        given.update(_arrays(value["arrays"], plan.arrays, body, where))
    return cls(**given)


def _has_tag(value: dict[str, Any], message: type) -> bool:
    return all(type(value.get(key)) is type(tag) and value[key] == tag for key, tag in tag_of(message).items())


def _check_keys(value: dict[str, Any], expected: Iterable[str], where: str) -> None:
    missing, unknown = {*expected} - {*value}, {*value} - {*expected}
    if missing:
        raise ProtocolError(f"without {', '.join(sorted(missing))}", where)
    if unknown:
        raise ProtocolError(f"has {_short(', '.join(sorted(unknown)))}, which it may not", where)


def _arrays(places: Any, specs: dict[str, Array], body: bytes, where: str) -> dict[str, npt.NDArray[Any]]:
    if not isinstance(places, dict):
        raise ProtocolError(f"is a JSON {_name(places)}: an object is needed", f"{where}.arrays")
    _check_keys(places, specs, f"{where}.arrays")
    lengths: dict[str, int] = {}
    return {name: _array(places[name], spec, body, lengths, f"{where}.{name}") for name, spec in specs.items()}


def _array(place: Any, spec: Array, body: bytes, lengths: dict[str, int], where: str) -> npt.NDArray[Any]:
    given, shape, offset = check(place, tuple[str, list[int], int], where)
    if given != spec.type:
        raise ProtocolError(f"an array of {_short(given)}: {spec.type} is needed", where)
    _check_shape(tuple(shape), spec, lengths, where)
    dtype = np.dtype(_DTYPES[spec.type])
    count = math.prod(shape)
    if offset < 0 or offset % 8 or offset + count * dtype.itemsize > len(body):
        raise ProtocolError(f"{count} of {spec.type} at byte {offset} of {len(body)}: out of bounds", where)
    array = np.frombuffer(body, dtype, count, offset).reshape(shape) if count else np.zeros(shape, dtype)
    if dtype.kind == "f" and not np.isfinite(array).all():
        raise ProtocolError("has a number that is NaN or infinite", where)
    return array


def _check_shape(shape: tuple[int, ...], spec: Array, lengths: dict[str, int], where: str) -> None:
    is_right = len(shape) == len(spec.shape)
    for length, wanted in zip(shape, spec.shape, strict=False):
        # A name is the length that the first array has there.
        is_right = is_right and length >= 0
        is_right = is_right and length == (lengths.setdefault(wanted, length) if isinstance(wanted, str) else wanted)
    if not is_right:
        raise ProtocolError(f"has shape {_short(list(shape))}: {list(spec.shape)} is needed", where)
    if spec.most is not None and shape[0] > spec.most:
        raise ProtocolError(f"has {shape[0]} rows: at most {spec.most} are allowed", where)


def check(value: Any, hint: Any, where: str) -> Any:
    """A JSON value of the given type, with tuples instead of lists if it has them. Raises `ProtocolError`."""
    origin, args = get_origin(hint), get_args(hint)
    if origin is Annotated:
        mark = args[1]
        inside = get_type_hints(mark.of, include_extras=True)
        given = _object(value, where)
        if isinstance(mark, Partial):
            _check_keys({**inside, **given}, inside, where)
        else:
            _check_keys(given, {**given, **inside}, where)
        return {key: check(each, inside.get(key, Any), f"{where}.{key}") for key, each in given.items()}
    if origin in (Union, types.UnionType):
        if value is None and type(None) in args:
            return None
        (one,) = (each for each in args if each is not type(None))
        return check(value, one, where)
    if origin is Literal:
        if any(type(each) is type(value) and each == value for each in args):
            return value
        raise ProtocolError(f"is {_short(value)}: one of {', '.join(map(str, args))} is needed", where)
    if origin is tuple and args[-1] is not Ellipsis:
        items = _list(value, where)
        if len(items) != len(args):
            raise ProtocolError(f"has {len(items)} items: {len(args)} are needed", where)
        return tuple(check(each, kind, f"{where}[{i}]") for i, (each, kind) in enumerate(zip(items, args, strict=True)))
    if origin in (list, tuple):
        return origin(check(each, args[0], f"{where}[{i}]") for i, each in enumerate(_list(value, where)))
    if origin is dict:
        inside_of = _object(value, where)
        return {_string(key, where): check(each, args[1], f"{where}.{_short(key)}") for key, each in inside_of.items()}
    if is_typeddict(hint):
        inside = get_type_hints(hint, include_extras=True)
        given = _object(value, where)
        # Those that may be absent count as given.
        _check_keys({**dict.fromkeys(hint.__optional_keys__), **given}, inside, where)
        return {key: check(value[key], kind, f"{where}.{key}") for key, kind in inside.items() if key in given}
    return _scalar(value, hint, where)


def _scalar(value: Any, hint: Any, where: str) -> Any:
    if hint is Any:
        _check_plain(value, where, 0)
        return value
    if hint is str and isinstance(value, str):
        return _string(value, where)
    if hint is bool and isinstance(value, bool):
        return value
    if hint is int and type(value) is int:
        return _whole(value, where)
    if hint is float and type(value) in (int, float):
        return float(_whole(value, where)) if type(value) is int else _finite(value, where)
    wanted = {str: "text", bool: "true or false", int: "a whole number", float: "a number"}[hint]
    raise ProtocolError(f"is {_short(value)}: {wanted} is needed", where)


def _check_plain(value: Any, where: str, depth: int) -> None:
    if depth > MOST_DEEP:
        raise ProtocolError(f"is nested more than {MOST_DEEP} deep", where)
    if isinstance(value, dict):
        for key, each in value.items():
            _string(key, where)
            _check_plain(each, where, depth + 1)
    elif isinstance(value, list):
        for each in value:
            _check_plain(each, where, depth + 1)
    elif isinstance(value, str):
        _string(value, where)
    elif type(value) is int:
        _whole(value, where)
    elif isinstance(value, float):
        _finite(value, where)


def _string(value: str, where: str) -> str:
    if not value.isascii():
        try:
            value.encode()
        except UnicodeEncodeError:
            raise ProtocolError("has half of a surrogate pair, which is not text", where) from None
    return value


def _whole(value: int, where: str) -> int:
    if abs(value) > _MOST_WHOLE:
        raise ProtocolError("is a whole number beyond 2^53", where)
    return value


def _finite(value: float, where: str) -> float:
    if not math.isfinite(value):
        raise ProtocolError("is not a finite number", where)
    return value


def _list(value: Any, where: str) -> list[Any]:
    if not isinstance(value, list):
        raise ProtocolError(f"is a JSON {_name(value)}: a list is needed", where)
    return value


def _object(value: Any, where: str) -> dict[str, Any]:
    if not isinstance(value, dict):
        raise ProtocolError(f"is a JSON {_name(value)}: an object is needed", where)
    return cast(dict[str, Any], value)


def _name(value: Any) -> str:
    names = {dict: "object", list: "list", str: "text", bool: "boolean", type(None): "null"}
    return names.get(type(value), "number")


def _short(value: Any) -> str:
    """The value as text, truncated: the wrong part of a message may be huge."""
    if isinstance(value, int) and abs(value) > _MOST_WHOLE:
        return "a huge number"
    if isinstance(value, dict | list) and not (len(value) <= 8 and all(type(each) is int for each in value)):
        return f"a JSON {_name(value)} of {len(value)}"
    text = ascii(value)
    return text if len(text) <= 60 else f"{text[:60]}..."
