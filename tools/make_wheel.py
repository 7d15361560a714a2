"""Builds the wheel that is published, and checks it: `make wheel` runs this in an environment of its own.

    python tools/make_wheel.py [--target TRIPLE] [--out FOLDER]

On Linux zig links: for the glibc of manylinux_2_28, or for another platform (`--target aarch64-apple-darwin`).
Elsewhere the platform's own linker does. The wheel is compressed again (`tools/pack_wheel.py`). auditwheel and
abi3audit judge it, and it has to have the page and to be small. A wheel for this machine is installed and used
(`tools/smoke.py`).
"""

from __future__ import annotations

import argparse
import json
import os
import platform
import re
import shutil
import subprocess
import sys
import zipfile
from pathlib import Path

from pack_wheel import pack

ROOT = Path(__file__).resolve().parent.parent
PAGE = "feeler/workbench/static/"
MAX_BYTES = 4_700_000  # with symbols it is twice that

# The oldest systems served: NumPy's wheels ask for the same.
LIBC = {"gnu": "manylinux_2_28", "musl": "musllinux_1_2"}


def tag_of(target: str) -> str:
    """What the name of a wheel for this Rust target says of the platform, as a pattern."""
    cpu, system = target.split("-")[0], target.split("-", 2)[2]
    if system.startswith("linux"):
        return f"{LIBC[system.split('-')[1]]}_{cpu}"
    if system == "darwin":
        return rf"macosx_\d+_\d+_{'arm64' if cpu == 'aarch64' else cpu}"
    return f"win_{'arm64' if cpu == 'aarch64' else 'amd64'}"


def build(target: str, folder: Path) -> Path:
    """Compiles and packs; the wheel's path."""
    options = ["--release", "--strip", "--target", target, "--out", str(folder)]
    if sys.platform == "linux":
        options.append("--zig")
    if "linux" in target:
        options += ["--compatibility", LIBC[target.split("-")[3]]]
    if os.environ.get("CI"):
        options.append("--locked")
    # PyO3 asks this Python, and zig is a package of it.
    env = {**os.environ, "PYO3_PYTHON": sys.executable, "CARGO_ZIGBUILD_PYTHON_PATH": sys.executable}
    done = subprocess.run([sys.executable, "-m", "maturin", "build", *options], cwd=ROOT, env=env, check=False)
    if done.returncode != 0:
        sys.exit(f"make wheel: maturin ended with exit status {done.returncode}")
    (wheel,) = folder.glob("*.whl")
    return wheel


def complaints(wheel: Path, target: str, page: set[str]) -> list[str]:
    """What is wrong with a wheel's name, size and files. `page`: the files of the page, which it has to have."""
    found = []
    if not re.fullmatch(rf"feeler-[\w.]+-cp310-abi3-{tag_of(target)}\.whl", wheel.name):
        found.append(f"its name should end with cp310-abi3-{tag_of(target)}.whl")
    size = wheel.stat().st_size
    if size > MAX_BYTES:
        found.append(f"{size:,} bytes; at most {MAX_BYTES:,}")
    with zipfile.ZipFile(wheel) as archive:
        inside = {name.removeprefix(PAGE) for name in archive.namelist() if name.startswith(PAGE)}
    if inside != page:
        found.append(f"its page is {sorted(inside)}, not {sorted(page)}")
    if "index.html" not in page:
        found.append("the page is not built: make page")
    return found


def glibc_needed(wheel: Path) -> str:
    """The platform tag that auditwheel finds for a wheel of Linux with glibc."""
    done = subprocess.run(
        [sys.executable, "-m", "auditwheel", "show", "--json", str(wheel)], capture_output=True, text=True, check=False
    )
    if done.returncode != 0:
        sys.exit(f"make wheel: auditwheel: {done.stderr or done.stdout}")
    tag: str = json.loads(done.stdout)["overall_tag"]
    return tag


def no_newer(tag: str, limit: str) -> bool:
    """Whether systems of the platform tag `limit` have all that `tag` asks for: `manylinux_2_17_x86_64`."""
    parts = [re.fullmatch(r"([a-z]+)_(\d+)_(\d+)_(\w+)", name) for name in (tag, limit)]
    if parts[0] is None or parts[1] is None:
        return False
    (libc, *version, cpu), (limit_libc, *limit_version, limit_cpu) = (part.groups() for part in parts if part)
    return (libc, cpu) == (limit_libc, limit_cpu) and [*map(int, version)] <= [*map(int, limit_version)]


def audit(wheel: Path, target: str) -> list[str]:
    """What auditwheel and abi3audit find."""
    found = []
    # Of a wheel for musl, auditwheel would look for the C library on this machine, where it is another one.
    if target.endswith("-linux-gnu"):
        tag = glibc_needed(wheel)
        print(f"auditwheel: {tag}")
        if not no_newer(tag, tag_of(target)):
            found.append(f"it is of {tag}, says auditwheel; it should be of {tag_of(target)} or older")
    if subprocess.run([sys.executable, "-m", "abi3audit", "--strict", "--summary", str(wheel)], check=False).returncode:
        found.append("abi3audit finds more than the stable ABI, see above")
    return found


def rustc(*words: str) -> str:
    """What the compiler says of itself."""
    return subprocess.run(["rustc", *words], capture_output=True, text=True, check=True).stdout.strip()


def runs_here(target: str, host: str) -> bool:
    """Whether this machine can use the wheel."""
    return target == host and (sys.platform != "linux" or platform.libc_ver()[0] == "glibc")


def main() -> None:
    """Build, judge, use, and move to its place."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--target", default="", help="a target of Rust; default: this machine")
    parser.add_argument("--out", type=Path, default=ROOT / "dist")
    arguments = parser.parse_args()
    host = rustc("-vV").split("host: ")[1].split()[0]
    target = arguments.target or host
    if not Path(rustc("--print", "sysroot"), "lib", "rustlib", target).is_dir():
        sys.exit(f"make wheel: needs Rust's library for {target} (rustup target add {target})")

    static = ROOT / "python" / PAGE
    page = {path.relative_to(static).as_posix() for path in static.rglob("*") if path.is_file()}
    # A wheel that is refused stays there, to be looked at.
    folder = ROOT / "target" / "wheel"
    shutil.rmtree(folder, ignore_errors=True)
    wheel = build(target, folder)
    pack(wheel)
    found = [*complaints(wheel, target, page), *audit(wheel, target)]
    if found:
        sys.exit("\n".join(f"make wheel: {wheel.name}: {complaint}" for complaint in found))
    if not runs_here(target, host):
        print(f"make wheel: not run: this machine is {host}")
    elif subprocess.run([sys.executable, ROOT / "tools" / "smoke.py", wheel], check=False).returncode != 0:
        sys.exit(f"make wheel: {wheel.name} does not work, see above")
    arguments.out.mkdir(parents=True, exist_ok=True)
    made = Path(shutil.move(wheel, arguments.out / wheel.name))
    print(f"make wheel: {made.name}, {made.stat().st_size:,} bytes, in {arguments.out}")


if __name__ == "__main__":
    main()
