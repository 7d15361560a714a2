"""The texts of a dataclass's fields in its docstring at run time, so that `help` shows them.

A string under a field is for readers of the source, and for tools that read it; Python does not keep it. It is read
from the source when the docstring is first asked for, so that importing costs nothing.
"""

from __future__ import annotations

import ast
import dataclasses
import functools
import inspect
import itertools
import textwrap
from collections.abc import Callable, Sequence
from typing import Any, TypeVar

import numpy as np

from feeler.short_reprs import shortly

Class = TypeVar("Class", bound=type[Any])

_WIDTH = 100
_ARRAYS = ("NDArray", "Floats", "Bools", "Ints")
"""In annotations: an array, and the short names for some kinds of them."""


def documented(cls: Class) -> Class:
    """Adds the texts of the fields to the docstring of a dataclass; makes arrays in a frozen one read-only, and its
    repr short. Put it above `@dataclass`."""
    names = " ".join(str(each.type) for each in dataclasses.fields(cls))
    if cls.__dataclass_params__.frozen and any(each in names for each in _ARRAYS):
        fields = [each.name for each in dataclasses.fields(cls)]
        cls.__init__ = _with_read_only(cls.__init__, fields)
        cls.__setstate__ = _with_read_only(getattr(cls, "__setstate__", _set_state), fields)
        shortly(cls)
    cls.__doc__ = _Completed(cls.__doc__ or "")  # type: ignore[assignment]  # a class asks descriptors for it, too
    return cls


def _set_state(self: object, state: dict[str, Any]) -> None:
    """As `pickle` and `copy` do without `__setstate__`."""
    vars(self).update(state)


def _with_read_only(init: Callable[..., None], names: Sequence[str]) -> Callable[..., None]:
    """An `__init__` or `__setstate__` after which arrays cannot be written into: others may hold the same object."""

    @functools.wraps(init)
    def made(self: object, *args: object, **values: object) -> None:
        init(self, *args, **values)
        for name in names:
            value = getattr(self, name, None)
            if isinstance(value, np.ndarray) and value.flags.writeable:
                view = value.view()
                view.flags.writeable = False
                object.__setattr__(self, name, view)

    return made


class _Completed:
    """A docstring, with the texts of the fields from its first use on."""

    def __init__(self, text: str) -> None:
        self._text = text
        self._whole: dict[type[Any], str] = {}

    def __get__(self, _instance: object, owner: type[Any]) -> str:
        if owner not in self._whole:
            self._whole[owner] = _with_fields(owner, self._text)
        return self._whole[owner]


def _with_fields(cls: type[Any], text: str) -> str:
    lines: list[str] = []
    for base in reversed(cls.__mro__):
        if dataclasses.is_dataclass(base):
            for name, said in _texts(base).items():
                first, *rest = textwrap.wrap(f"{name}: {' '.join(said.split())}", _WIDTH)
                lines += [f"    {first}", *(f"        {line}" for line in rest)]
    if not lines:
        return text
    return "\n".join([inspect.cleandoc(text), "", "Fields:", *lines])


def _texts(cls: type[Any]) -> dict[str, str]:
    """The string under each public field that has one; none without the source."""
    try:
        (tree,) = ast.parse(textwrap.dedent(inspect.getsource(cls))).body
    except (OSError, TypeError, SyntaxError, ValueError):
        return {}
    body = tree.body if isinstance(tree, ast.ClassDef) else []
    return {
        field.target.id: text.value.value
        for field, text in itertools.pairwise(body)
        if isinstance(field, ast.AnnAssign)
        and isinstance(field.target, ast.Name)
        and not field.target.id.startswith("_")
        and isinstance(text, ast.Expr)
        and isinstance(text.value, ast.Constant)
        and isinstance(text.value.value, str)
    }
