"""Builds the peers that have no Python binding, each once, into target/bench, and loads them.

A peer that cannot be built here is absent, with the reason; the benchmark goes on without it.
"""

from __future__ import annotations

import contextlib
import ctypes
import os
import shutil
import subprocess
import sys
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

import numpy as np
import numpy.typing as npt

HERE = Path(__file__).resolve().parent
BUILT = Path(os.environ.get("CARGO_TARGET_DIR") or HERE.parent / "target") / "bench"
PATIENCE = 900  # seconds

Corners = npt.NDArray[np.float64]
Faces = npt.NDArray[np.uint32]


class AbsentError(Exception):
    """A peer that cannot be measured on this machine; the message says why."""


def compile_cpp(source: Path, libraries: Sequence[str]) -> ctypes.CDLL:
    """The shared library made of one C++ file, for this very CPU; compiled only if the file is newer."""
    library = BUILT / f"{source.stem}.so"
    if not _is_newer(library, [source]):
        compiler = os.environ.get("CXX") or shutil.which("g++") or shutil.which("c++")
        if compiler is None:
            raise AbsentError("no C++ compiler (g++) found to build it with")
        flags = ["-std=c++17", "-O3", "-march=native", "-shared", "-fPIC"]
        wanted = [f"-l{name}" for name in libraries]
        _run(source.name, [compiler, *flags, str(source), "-o", f"{library}.new", *wanted])
        Path(f"{library}.new").replace(library)
    return _load(library)


def build_crate(folder: Path) -> ctypes.CDLL:
    """The shared library made of a Rust crate, with its lock file, for this very CPU."""
    names = {"darwin": "lib{}.dylib", "win32": "{}.dll"}
    crate = f"{folder.name}_engine"
    library = BUILT / folder.name / "release" / names.get(sys.platform, "lib{}.so").format(crate)
    if not _is_newer(library, [*folder.glob("src/*.rs"), *folder.glob("Cargo.*")]):
        cargo = shutil.which("cargo")
        if cargo is None:
            raise AbsentError("cargo not found to build it with")
        manifest = ["--manifest-path", str(folder / "Cargo.toml"), "--target-dir", str(BUILT / folder.name)]
        command = [cargo, "build", "--release", "--locked", "--quiet", *manifest]
        _run(folder.name, command, RUSTFLAGS="-C target-cpu=native")
        library.touch()  # cargo leaves it as it is where only a comment changed
    return _load(library)


def declare(library: ctypes.CDLL, functions: Mapping[str, tuple[Any, Sequence[Any]]]) -> None:
    """Tell ctypes what each function gives and takes."""
    for name, (result, arguments) in functions.items():
        function = getattr(library, name)
        function.restype, function.argtypes = result, list(arguments)


def mesh(vertices: npt.ArrayLike, faces: npt.ArrayLike) -> tuple[Corners, Faces]:
    """Arrays as a C interface takes them."""
    return np.ascontiguousarray(vertices, dtype=np.float64), np.ascontiguousarray(faces, dtype=np.uint32)


def _is_newer(made: Path, sources: Sequence[Path]) -> bool:
    with contextlib.suppress(OSError):
        return made.stat().st_mtime >= max(source.stat().st_mtime for source in sources)
    return False


def _run(what: str, command: list[str], **environment: str) -> None:
    BUILT.mkdir(parents=True, exist_ok=True)
    print(f"building {what} for this machine, once", file=sys.stderr, flush=True)
    try:
        done = subprocess.run(
            command,
            env={**os.environ, **environment},
            capture_output=True,
            text=True,
            errors="replace",
            timeout=PATIENCE,
            check=False,
        )
    except (OSError, subprocess.TimeoutExpired) as error:
        raise AbsentError(f"{what} could not be built: {error}") from error
    if done.returncode:
        lines = [line.strip() for line in done.stderr.splitlines() if line.strip()]
        reasons = [line for line in lines if "error" in line] or lines or ["no message"]
        raise AbsentError(f"{what} could not be built: {reasons[0].replace(str(HERE.parent) + os.sep, '')}")


def _load(library: Path) -> ctypes.CDLL:
    try:
        return ctypes.CDLL(str(library))
    except OSError as error:
        raise AbsentError(f"{library.name} cannot be loaded: {error}") from error
