"""How much memory the machine has to give."""

from __future__ import annotations

import math
import os


def free_memory() -> int:
    """Bytes available without swapping, if the system reports them; else no limit."""
    try:
        with open("/proc/meminfo", encoding="ascii") as lines:
            for line in lines:
                if line.startswith("MemAvailable:"):
                    return int(line.split()[1]) * 1024
    except (OSError, ValueError):
        pass
    try:
        return os.sysconf("SC_PHYS_PAGES") * os.sysconf("SC_PAGE_SIZE") // 2
    except (AttributeError, OSError, ValueError):
        return math.floor(2**63)
