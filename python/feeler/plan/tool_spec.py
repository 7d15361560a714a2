"""What a catalogue says of one tool, or one piece of a chain of them."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

from feeler.arguments import check_word
from feeler.field_docs import documented

PLAY = 2e-4
"""How far a tool stays off the face that a head bears on, metres."""
ROOM = 2e-3
"""Along flats that are taller than an open spanner by this, it is tried at both ends, too, metres."""
OUTSIDE, INSIDE = (0.98, 1.02), (0.98, 1.03)
"""Widths across flats that a tool fits, relative to its own: of heads, and of recesses. Meshes are rarely exact."""
HEAD_SHARE = 0.4
"""Height of a head whose mesh does not show it, in widths across flats; about that of ISO 4014."""
DEEP_SHARE = 0.5
"""How far a tool enters a recess, in widths of its blade."""


@dataclass(frozen=True)
class ToolKind:
    """What a kind of tool needs to know, and what it can do unless a catalogue says otherwise."""

    lengths: tuple[str, ...]
    """Lengths of its shape."""
    fits: tuple[str, ...] = ()
    swing_deg: float = 60.0
    step_deg: float = 60.0
    has_drive: bool = False
    """Whether it has a square drive, and so is a piece of a chain."""
    says: str = ""
    """For people."""


TOOL_KINDS: Mapping[str, ToolKind] = {
    "socket": ToolKind(("outer", "body", "length", "depth"), ("hexagon",), has_drive=True),
    "bit": ToolKind(("blade", "reach", "body", "length"), ("hexagon socket",), has_drive=True),
    "extension": ToolKind(("bar", "end", "end_length"), has_drive=True),
    "ratchet": ToolKind(("head", "height", "length", "width", "thick", "grip"), (), 15.0, 5.0, True),
    "driver": ToolKind(("shaft", "reach", "handle", "grip"), (), 60.0, 1.0, True),
    "ring": ToolKind(("outer", "thick", "length", "width", "rise"), ("hexagon", "12-point"), 30.0, 30.0),
    "open": ToolKind(("width", "thick", "length", "shaft"), ("hexagon", "square")),
    "hex_key": ToolKind(("short", "long"), ("hexagon socket",)),
    "screwdriver": ToolKind(("blade", "reach", "handle", "grip"), ("slot",), 60.0, 1.0),
    "pliers": ToolKind(("width", "thick", "jaw", "length"), ("wings", "hand"), 30.0, 1.0),
}
HEADS = ("socket", "bit")
"""Kinds that a chain begins with, at the fastener."""
HANDLES = ("ratchet", "driver")
"""Kinds that it ends with."""
INNER = ("bit", "hex_key", "screwdriver")
"""Kinds that enter a recess."""


@documented
@dataclass(frozen=True)
class ToolSpec:
    """One tool of a `Catalogue`, or one piece of a chain. Metres and degrees."""

    kind: str
    """"socket", "bit", "extension", "ratchet", "driver", "ring", "open", "hex_key", "screwdriver" or "pliers"."""
    name: str
    """Its own in the catalogue, such as "socket 10"."""
    size: float
    """Width across flats, or across the points of an external Torx, that it is for; of an extension its length; 0 for
    tools chosen by `widths` or thread, and handles."""
    fits: tuple[str, ...]
    """Drives of fasteners that it fits, as `Fastener.drive`."""
    threads: tuple[float, float] | None
    """Diameters of threads that it is for, where the mesh shows no width."""
    drive: float
    """Width of its square drive (ISO 1173); 0 without one."""
    swing_deg: float
    """The swing that it needs to be of use."""
    step_deg: float
    """It is put on again at multiples of this angle: a ratchet's teeth, the flats of a hexagon."""
    lengths: tuple[tuple[str, float], ...]
    """Lengths of its shape, by name."""
    widths: tuple[float, float] | None = None
    """Widths of recesses that it enters without much play, as `Fastener.width`."""

    def length(self, name: str) -> float:
        """One of `lengths`, metres. Raises `OptionError` for a name that its kind does not have."""
        known = dict(self.lengths)
        return known[check_word("name", name, known)]


def suits(spec: ToolSpec, drive: str, width: float, thread: float) -> bool:
    """Whether a tool fits a fastener by drive and size: `Fastener.width`, and the diameter of its thread.

    The thread decides only if the width is not known (NaN), or if the tool says no widths. A size that is not known
    fits none but tools for all.
    """
    if drive not in spec.fits:
        return False
    if spec.widths is not None and width > 0.0:
        return spec.widths[0] <= width <= spec.widths[1]
    if spec.threads is not None:
        return spec.threads[0] <= thread <= spec.threads[1]
    if spec.size == 0.0:
        return spec.widths is None
    low, high = INSIDE if spec.kind in INNER else OUTSIDE
    return low * spec.size <= width <= high * spec.size


def depths_of(spec: ToolSpec, head: float) -> list[float]:
    """How far below the top of a head (its height, NaN: unknown) the lower end of a tool is when it is on, metres.

    An open spanner has several places along tall flats.
    """
    if spec.kind in INNER:
        blade = spec.size or spec.length("blade")
        return [min(DEEP_SHARE * blade, 0.8 * head if head > 0.0 else float("inf"))]
    known = head if head > 0.0 else HEAD_SHARE * spec.size
    if spec.kind == "open":
        thick = spec.length("thick")
        lowest, middle = known - PLAY, 0.5 * (known + thick)
        return [middle, thick, lowest] if known > thick + ROOM else [min(lowest, middle)]
    if spec.kind == "pliers":
        return [known]
    return [min(known - PLAY, spec.length("depth")) if spec.kind == "socket" else known - PLAY]
