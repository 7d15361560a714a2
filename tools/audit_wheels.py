"""What auditwheel and abi3audit find in finished wheels: that an old enough glibc is all that they need, and that the
wheel for every Python uses the stable ABI alone.

    python tools/audit_wheels.py dist/*.whl

The release workflow runs it after the wheels are compressed. Both programs read wheels of any machine. auditwheel would
compare those for musl with the C library of this one; abi3audit does not know `abi3t`.
"""

from __future__ import annotations

import subprocess
import sys
from pathlib import Path

from make_wheel import glibc_needed, no_newer


def complaints(wheel: Path) -> list[str]:
    """What is wrong with a wheel."""
    found = []
    *_, abi, platforms = wheel.stem.split("-")
    for tag in platforms.split("."):
        if tag.startswith("manylinux_"):
            needed = glibc_needed(wheel)
            print(f"{wheel.name}: {needed}")
            if not no_newer(needed, tag):
                found.append(f"{wheel.name}: needs {needed}, says auditwheel")
    if abi == "abi3":
        done = subprocess.run([sys.executable, "-m", "abi3audit", "--strict", "--summary", str(wheel)], check=False)
        if done.returncode != 0:
            found.append(f"{wheel.name}: abi3audit finds more than the stable ABI")
    return found


def main() -> None:
    """Judge the wheels of the command line."""
    wheels = [Path(word) for word in sys.argv[1:]]
    found = [said for wheel in wheels for said in complaints(wheel)]
    if found or not wheels:
        sys.exit("\n".join(found) or "audit_wheels: name at least one wheel")


if __name__ == "__main__":
    main()
