"""Uses a wheel for 64-bit ARM Linux on a machine of another kind, emulated: `make arm64-wheel` runs this.

    python tools/smoke_arm64.py dist/feeler-*_aarch64.whl
    python tools/smoke_arm64.py --check

The commands, and what they must answer, are those of `tools/smoke.py`. A Python for ARM is unpacked from the packages
of Debian into `target/arm64-python`, without root and without a change to the system; pip puts the wheel and its
dependencies beside it. Needs qemu-aarch64, and the apt-get of Debian or Ubuntu; `--check` only looks for them.
"""

from __future__ import annotations

import argparse
import os
import shutil
import subprocess
import sys
import tempfile
from pathlib import Path

from smoke import Installed, expect, use, view

ROOT = Path(__file__).resolve().parent.parent
TOOLS = {"qemu-aarch64": "qemu-user", "apt-get": "apt", "dpkg-deb": "dpkg"}
PACKAGES = ("python3", "libstdc++6")  # wheels may ask the system for the library of C++, and NumPy's does
# What a wheel of manylinux_2_28 and those of its dependencies may call themselves.
PLATFORMS = ("manylinux_2_28_aarch64", "manylinux_2_17_aarch64", "manylinux2014_aarch64")


def call(*command: str | Path) -> None:
    """Ends the script if the command fails."""
    done = subprocess.run(command, stdout=subprocess.PIPE, stderr=subprocess.STDOUT, text=True, check=False)
    if done.returncode != 0:
        sys.exit(f"make arm64-wheel: exit status {done.returncode} of `{' '.join(map(str, command))}`\n{done.stdout}")


def python_for_arm(folder: Path) -> Path:
    """The root of a file system with Debian's Python for ARM, and all that it needs but a kernel."""
    system = folder / "system"
    if (system / "usr/bin/python3").is_symlink():
        return system
    shutil.rmtree(folder, ignore_errors=True)
    for name in ("state/lists/partial", "cache/archives/partial", "unpacked"):
        (folder / name).mkdir(parents=True)
    # A list of packages of its own, on which nothing is installed yet.
    (folder / "status").touch()
    options = {
        "Dir::State": folder / "state",
        "Dir::State::status": folder / "status",
        "Dir::Cache": folder / "cache",
        "APT::Architecture": "arm64",
        "APT::Architectures::": "arm64",
        "APT::Sandbox::User": "",
        "Debug::NoLocking": "true",
    }
    apt = ("apt-get", "--quiet=2", *(f"--option={name}={value}" for name, value in options.items()))
    print("smoke: unpacking Debian's Python for arm64 into", folder, flush=True)
    call(*apt, "update")
    call(*apt, "install", "--yes", "--download-only", "--no-install-recommends", *PACKAGES)
    for package in sorted((folder / "cache/archives").glob("*.deb")):
        call("dpkg-deb", "--extract", package, folder / "unpacked")
    for name in ("state", "cache"):
        shutil.rmtree(folder / name)
    # Complete or not there.
    return (folder / "unpacked").rename(system)


class Emulated(Installed):
    """A wheel and its dependencies beside a Python for ARM."""

    def __init__(self, wheel: Path, folder: Path, system: Path) -> None:
        """Installs them, of which none may be compiled."""
        self.folder = folder
        python = (system / "usr/bin/python3").resolve()
        self.emulated = ["qemu-aarch64", "-L", str(system), str(python)]
        kept = {name: value for name, value in os.environ.items() if not name.startswith(("PYTHON", "VIRTUAL_ENV"))}
        self.env = {**kept, "PYTHONPATH": str(folder / "packages"), "PYTHONUNBUFFERED": "1", "PYTHONUTF8": "1"}
        version = python.name.removeprefix("python")
        abis = (f"cp{version.replace('.', '')}", "abi3", "none")
        options = [*(f"--platform={name}" for name in PLATFORMS), *(f"--abi={name}" for name in abis)]
        options += [f"--python-version={version}", "--implementation=cp", "--only-binary=:all:", "--quiet"]
        call(sys.executable, "-m", "pip", "install", *options, "--target", folder / "packages", wheel)

    def command(self, program: str, *words: str) -> list[str]:
        """The program by the emulated Python."""
        return [*self.emulated, *(() if program == "python" else ("-m", program)), *words]


def main() -> None:
    """One wheel, from its installation to its page."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("wheel", type=Path, nargs="?")
    parser.add_argument("--check", action="store_true", help="only look for the programs that this needs")
    arguments = parser.parse_args()
    missing = {tool: package for tool, package in TOOLS.items() if shutil.which(tool) is None}
    if missing:
        sys.exit(f"make arm64-wheel: needs {', '.join(missing)} (Debian: {' '.join(missing.values())})")
    if arguments.check:
        return
    if arguments.wheel is None:
        parser.error("which wheel?")
    wheel: Path = arguments.wheel.resolve()
    if not wheel.is_file() or not wheel.stem.endswith("aarch64") or "manylinux" not in wheel.name:
        sys.exit(f"make arm64-wheel: {wheel} is no wheel for ARM Linux with glibc")
    system = python_for_arm(ROOT / "target" / "arm64-python")
    with tempfile.TemporaryDirectory(ignore_cleanup_errors=True) as folder:
        installed = Emulated(wheel, Path(folder), system)
        machine = "import platform; print(platform.machine())"
        expect("the machine", installed.run("python", "-c", machine).strip(), "aarch64")
        lanes = "import feeler; print(feeler.Scene(feeler.sample('engine', 10_000)).simd)"
        expect("the instruction set", installed.run("python", "-c", lanes).strip(), "neon")
        use(installed, wheel.name.split("-")[1])
        view(installed)
    print(f"smoke: {wheel.name} works on an emulated ARM CPU")


if __name__ == "__main__":
    main()
