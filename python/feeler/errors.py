"""The exceptions feeler raises.

Every one is a `FeelerError`. Each also derives from the built-in that a caller would expect (`ValueError`,
`FileNotFoundError`, `MemoryError`), so existing handlers keep working. A message names the error, its place and a
remedy.
"""

from __future__ import annotations

from typing import Any


class FeelerError(Exception):
    """Base of all errors feeler raises on purpose."""

    def __reduce__(self) -> tuple[Any, ...]:
        # As for other exceptions. Those that say so themselves also travel from workers whose library for tracebacks
        # makes all others anew without their arguments.
        return (type(self), self.args, vars(self)) if vars(self) else (type(self), self.args)


class MeshError(FeelerError, ValueError):
    """Vertices, faces or parts of a mesh cannot be used (shape, dtype, nothing left to query)."""


class PoseError(FeelerError, ValueError):
    """A pose has the wrong shape or is not a rigid motion."""


class OptionError(FeelerError, ValueError):
    """An option is out of its range: voxel size, hashing level, thread count, a name that does not exist."""


class MechanismError(FeelerError, ValueError):
    """A mechanism cannot take a position: a loop cannot close there, or has a dead point on the way."""


class LimitError(FeelerError, MemoryError):
    """The call would need more memory, or more voxels, than allowed. Raised before anything is allocated."""


class SessionError(FeelerError, RuntimeError):
    """A haptics session cannot do this now: it is not started, or holds no part to release."""


class DeviceError(FeelerError, OSError):
    """A haptic device is missing, does not answer, or is in use."""


class WorkbenchError(FeelerError, RuntimeError):
    """The workbench cannot run a command, a question or a job.

    what: the problem; where: the command and argument; do: the remedy.
    """

    def __init__(self, what: str, where: str = "", do: str = "") -> None:
        self.what, self.where, self.do = what, where, do
        super().__init__((f"{where}: " if where else "") + what + (f"; {do}" if do else ""))

    def __reduce__(self) -> tuple[type[WorkbenchError], tuple[str, str, str], dict[str, object]]:
        return (type(self), (self.what, self.where, self.do), vars(self))  # notes are among these


class ProjectError(FeelerError, OSError):
    """A project file is open in another process, or another process has taken it over."""


class LoadError(FeelerError, ValueError):
    """A file cannot be read as the mesh it claims to be."""


class MissingFileError(LoadError, FileNotFoundError):
    """A file or folder does not exist, or holds no mesh file."""


class WriteError(FeelerError, OSError):
    """A file cannot be written: the folder is missing, not writable, or the disk is full."""
