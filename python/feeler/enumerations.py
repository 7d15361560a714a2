"""Enumerations whose members are words, and the numbers that stand for them in arrays."""

from __future__ import annotations

import sys
from functools import cache

import numpy as np
import numpy.typing as npt

from feeler.arguments import shown
from feeler.errors import OptionError

if sys.version_info >= (3, 11):
    from enum import StrEnum
else:
    from enum import Enum

    class StrEnum(str, Enum):
        """`enum.StrEnum`, which Python 3.10 lacks."""

        def __str__(self) -> str:
            return str(self.value)

        def __format__(self, format_spec: str) -> str:
            return format(str(self.value), format_spec)


class CodedEnum(StrEnum):
    """Words with numbers: `Verdict.CONTACT == "contact"`, its `.code` is 1, and `Verdict(1) is Verdict.CONTACT`."""

    @property
    def code(self) -> int:
        """The number that stands for this word in arrays of codes: its place in the enumeration."""
        return list(type(self)).index(self)

    @classmethod
    def _missing_(cls, value: object) -> CodedEnum:
        """The member with this number. Raises `OptionError` for others."""
        if isinstance(value, (int, np.integer)) and not isinstance(value, bool) and 0 <= value < len(cls):
            return list(cls)[int(value)]
        raise OptionError(f"{shown(value)} is not a valid {cls.__name__}: choose {', '.join(cls)}")

    @classmethod
    def words(cls, codes: npt.NDArray[np.uint8]) -> npt.NDArray[np.str_]:
        """The words that an array of numbers stands for."""
        return _words(cls)[codes]


@cache
def _words(kind: type[CodedEnum]) -> npt.NDArray[np.str_]:
    return np.array([each.value for each in kind])
