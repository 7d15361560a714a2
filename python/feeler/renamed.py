"""Names of early builds: keywords and attributes that answer with what they are called now.

`Scene.distance` and `Scene.cast` do not know theirs: the look-up would cost a quick query a third of its time.
"""

from __future__ import annotations

import functools
import warnings
from collections.abc import Callable, Mapping
from typing import TYPE_CHECKING, Any, ClassVar, ParamSpec, TypeVar

from feeler.errors import OptionError

P = ParamSpec("P")
R = TypeVar("R")


ALLOW = "pass ignore= for parts, overlap= for metres, and seats=False for what was allow=None"
"""What to pass instead of an old keyword of planning."""


def keywords(
    renamed: Mapping[str, str] | None = None, gone: Mapping[str, str] | None = None
) -> Callable[[Callable[P, R]], Callable[P, R]]:
    """A function that knows its old keywords.

    renamed: old and new name; the value is passed on, with a `DeprecationWarning`. gone: old names, and what to do
    instead, which an `OptionError` says.
    """

    def decorated(function: Callable[P, R]) -> Callable[P, R]:
        @functools.wraps(function)
        def call(*args: P.args, **kwargs: P.kwargs) -> R:
            if kwargs:  # nothing is looked up for a call by position
                for old in kwargs.keys() & known:
                    if old in out:
                        raise OptionError(f"{function.__qualname__}({old}=) is gone: {out[old]}")
                    new = moved[old]
                    if new in kwargs:
                        raise OptionError(f"{function.__qualname__}({old}=) is now {new}=, which is given too")
                    warnings.warn(f"{function.__qualname__}({old}=) is now {new}=", DeprecationWarning, stacklevel=2)
                    kwargs[new] = kwargs.pop(old)
            return function(*args, **kwargs)

        return call

    moved, out = dict(renamed or {}), dict(gone or {})
    known = {*moved, *out}
    return decorated


def old_attribute(held: Any, name: str) -> object:
    """`__getattr__` of a class with old names: those of its `_RENAMED` and `_GONE`, which `OldAttributes` describes."""
    kind = type(held)
    if name in kind._RENAMED:
        new = kind._RENAMED[name]
        warnings.warn(f"{kind.__name__}.{name} is now {kind.__name__}.{new}", DeprecationWarning, stacklevel=2)
        return held._old_value(name) if isinstance(held, OldAttributes) else getattr(held, new)
    gone = getattr(kind, "_GONE", {})
    why = f"; {gone[name]}" if name in gone else ""
    raise AttributeError(f"{kind.__name__!r} object has no attribute {name!r}{why}", name=name, obj=held)


class OldAttributes:
    """A class with attributes that have other names now. A class of the core has the same table and `__getattr__`."""

    _RENAMED: ClassVar[Mapping[str, str]] = {}
    """Old and new name: it answers, with a `DeprecationWarning`."""
    _GONE: ClassVar[Mapping[str, str]] = {}
    """Old names, and what to do instead, which an `AttributeError` says."""

    if not TYPE_CHECKING:  # a type checker refuses old names
        __getattr__ = old_attribute

    def _old_value(self, name: str) -> object:
        """The value that an old attribute had: that of the new one, unless a class says otherwise."""
        return getattr(self, self._RENAMED[name])
