"""Installs a wheel as a user does, into a new environment with wheels only, and uses it: the same on all platforms.

    python tools/smoke.py dist/feeler-*.whl

No compiler, no Node and nothing of this repository is used; dependencies come from where pip is told to look. The
release workflow runs it on every platform, `make wheel` on the wheel that it made.
"""

from __future__ import annotations

import argparse
import hashlib
import json
import os
import re
import subprocess
import sys
import tempfile
import urllib.request
import venv
from pathlib import Path

# A wrench in the sample gearbox. The files hold float32 and no pair is close to a limit, so that the last bit of a
# platform's sine changes nothing.
AT = "0,0,0.1"
PAIRS = 1013
GOLDEN = "bb7d68f5daf9d33b"


class Installed:
    """An environment with the wheel in it."""

    def __init__(self, wheel: Path, folder: Path) -> None:
        """Makes it and installs the wheel and its dependencies, of which none may be compiled."""
        self.folder = folder
        venv.create(folder / "venv", with_pip=True)
        self.bin = folder / "venv" / ("Scripts" if os.name == "nt" else "bin")
        # Only its own programs: a wheel that needed a compiler or Node would not find one.
        kept = {name: value for name, value in os.environ.items() if not name.startswith(("PYTHON", "VIRTUAL_ENV"))}
        self.env = {**kept, "PATH": str(self.bin), "PYTHONUNBUFFERED": "1", "PYTHONUTF8": "1"}
        self.run("python", "-m", "pip", "install", "--quiet", "--only-binary", ":all:", str(wheel))

    def command(self, program: str, *words: str) -> list[str]:
        """The program of this environment, by its full path."""
        return [str(self.bin / (f"{program}.exe" if os.name == "nt" else program)), *words]

    def run(self, program: str, *words: str, statuses: tuple[int, ...] = (0,)) -> str:
        """Its standard output. Ends the script if the exit status is another."""
        print("smoke:", program, *words, flush=True)
        done = subprocess.run(
            self.command(program, *words), cwd=self.folder, env=self.env, stdout=subprocess.PIPE, encoding="utf-8"
        )
        if done.returncode not in statuses:
            sys.exit(f"smoke: exit status {done.returncode} of `{program} {' '.join(words)}`\n{done.stdout}")
        return done.stdout


def expect(name: str, found: object, wanted: object) -> None:
    """Ends the script if they differ."""
    if found != wanted:
        sys.exit(f"smoke: {name}: found {found!r}, wanted {wanted!r}")


def fingerprint(pairs: list[list[int]]) -> str:
    """Of pairs (tool triangle, mock-up triangle), in no order."""
    return hashlib.sha256("".join(f"{a} {b}\n" for a, b in sorted(pairs)).encode()).hexdigest()[:16]


def use(installed: Installed, version: str) -> None:
    """The commands, one after the other."""
    expect("version", installed.run("feeler", "--version").split()[-1], version)
    installed.run("feeler", "sample", "gearbox", "--out", "gearbox.glb")
    installed.run("feeler", "sample", "wrench", "--out", "wrench.stl")
    installed.run("feeler", "access", "--write-catalogue", "tools.toml")
    words = ("collide", "gearbox.glb", "--tool", "wrench.stl", "--at", AT, "--pairs", "--json")
    pairs = json.loads(installed.run("feeler", *words, statuses=(1,)))["poses"][0]["pair_list"]
    expect("colliding pairs", len(pairs), PAIRS)
    expect("fingerprint of the pairs", fingerprint(pairs), GOLDEN)


def view(installed: Installed) -> None:
    """The workbench answers with the page that is in the package."""
    where = "import feeler.workbench, pathlib; print(pathlib.Path(feeler.workbench.__file__).parent / 'static')"
    static = Path(installed.run("python", "-c", where).strip())
    words = ("view", "sample:engine:10000", "--no-browser")
    print("smoke: feeler", *words, flush=True)
    process = subprocess.Popen(
        installed.command("feeler", *words), cwd=installed.folder, env=installed.env, stdout=subprocess.PIPE, text=True
    )
    try:
        assert process.stdout is not None
        line = process.stdout.readline()
        address = re.match(r"(http://\S+)/#", line)
        if address is None:
            sys.exit(f"smoke: no address from `feeler view`: {line!r}")
        for name in ("", "main.js", "style.css"):
            with urllib.request.urlopen(f"{address[1]}/{name}", timeout=60) as answer:
                page = (static / (name or "index.html")).read_bytes()
                expect(f"what `feeler view` answers to /{name}", answer.read() == page, True)
    finally:
        process.kill()
        process.communicate()


def main() -> None:
    """One wheel, from its installation to its page."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("wheel", type=Path)
    wheel: Path = parser.parse_args().wheel.resolve()
    with tempfile.TemporaryDirectory(ignore_cleanup_errors=True) as folder:
        installed = Installed(wheel, Path(folder))
        use(installed, wheel.name.split("-")[1])
        view(installed)
    print(f"smoke: {wheel.name} works on {sys.platform}, Python {sys.version.split()[0]}")


if __name__ == "__main__":
    main()
