"""What two parts of a mock-up are to each other."""

from enum import IntEnum


class Verdict(IntEnum):
    """What two parts of a mock-up are to each other."""

    CLASH = 0
    """They meet, and one is deeper in the other than contact allows."""
    CONTACT = 1
    """They meet otherwise, or the gap between them is no more than contact allows."""
    CLEARANCE = 2
    """They are nearer than their clearance."""
    CONTAINED = 3
    """One of them, which is closed, holds the other; surfaces may lie on each other."""
    DUPLICATE = 4
    """They have the same triangles: each corner of the one is one of the other, with equal coordinates."""
