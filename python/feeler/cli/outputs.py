"""Output of the commands: tables for people, JSON for machines."""

from __future__ import annotations

import contextlib
import json
import sys
from collections.abc import Collection, Iterable, Mapping, Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np
import numpy.typing as npt

from feeler import words
from feeler.cli.options import named_files
from feeler.errors import OptionError
from feeler.words import printable

if TYPE_CHECKING:
    from rich.console import Console

_PIPE_WIDTH = 140  # columns, if the output is not a terminal


def console() -> Console:
    """The console for results, on stdout."""
    from rich.console import Console

    return Console(width=None if sys.stdout.isatty() else _PIPE_WIDTH, highlight=False)


def print_json(document: dict[str, Any]) -> None:
    """One JSON document on stdout; numbers that JSON lacks (NaN, infinity) become null."""
    print(json.dumps(_plain(document), indent=2, allow_nan=False))


def print_table(
    out: Console, title: str, columns: Sequence[tuple[str, str]], rows: Iterable[Sequence[str]], *, more: int = 0
) -> None:
    """A table. columns: (heading, "left" or "right"); more: the number of omitted rows, printed below."""
    from rich.box import SIMPLE_HEAD
    from rich.table import Table
    from rich.text import Text

    table = Table(title=title, title_justify="left", title_style="bold", box=SIMPLE_HEAD, pad_edge=False)
    for heading, justify in columns:
        table.add_column(heading, justify="right" if justify == "right" else "left", overflow="fold")
    for row in rows:
        table.add_row(
            *(Text(printable(cell)) for cell in row)
        )  # Text, so that a name such as "[1]" is not taken for markup
    out.print(table)
    if more > 0:
        out.print(f"... and {more:,} more (--json lists all)")


def print_facts(out: Console, facts: Iterable[tuple[str, str]]) -> None:
    """Name and value, line by line."""
    from rich.table import Table
    from rich.text import Text

    grid = Table.grid(padding=(0, 2))
    grid.add_column(style="cyan", no_wrap=True)
    grid.add_column(overflow="fold")
    for name, value in facts:
        grid.add_row(Text(printable(name)), Text(printable(value)))
    out.print(grid)


def say(out: Console, text: str) -> None:
    """A line that is never wrapped, so that it can be copied into a shell."""
    out.print(printable(text), soft_wrap=True, markup=False, highlight=False)


def print_finding(out: Console, text: str) -> None:
    """A finding in red, not wrapped."""
    from rich.text import Text

    out.print(Text(printable(text[:1].upper() + text[1:]), style="bold red"), soft_wrap=True)


def check_targets(
    targets: Mapping[str, Path | None],
    endings: Mapping[str, Sequence[str]],
    inputs: Iterable[str | Path | None] = (),
    in_place: Collection[str] = (),
) -> None:
    """Checks that each output has one of its endings, can be written, and is none of the inputs or other outputs.

    Options `write-...` start files for people to edit, so their files must not exist yet. Any file that another option
    names is an input, but for those of options `in_place`, which may be written anew. inputs: more of them, or folders
    whose files are all read. Raises `OptionError`, `WriteError`.
    """
    from feeler.errors import WriteError
    from feeler.io import check_target

    read = [Path(each) for each in inputs if each is not None]
    read += [path for option, path in named_files() if option not in targets and option not in in_place]
    taken: dict[Path, str] = {}

    for option, target in targets.items():
        if target is None:
            continue
        if target.suffix.lower() not in endings[option]:
            raise OptionError(f"--{option} {target}: the name must end in {' or '.join(endings[option])}")
        try:
            check_target(target)
        except WriteError as error:
            raise WriteError(f"--{option}: {error}") from None
        if any(_is_in(target, each) for each in read):
            raise OptionError(f"--{option} {target}: it is read by this command; give another name")
        if option.startswith("write-") and target.exists():
            raise OptionError(
                f"--{option} {target}: the file exists, and edits in it would be lost; give another name, or delete it"
            )
        first = taken.setdefault(target.resolve(), option)
        if first != option:
            raise OptionError(f"--{first} and --{option} both write {target}: give each a name of its own")


_MESHES = (".glb", ".stl")
"""Ends of outputs that a folder of a mock-up would be read with."""


def _is_in(target: Path, source: Path) -> bool:
    """Whether an output would take the place of an input."""
    with contextlib.suppress(OSError, ValueError):
        if not target.exists() or not source.exists():
            return False
        if source.is_dir():
            return target.suffix.lower() in _MESHES and target.resolve().is_relative_to(source.resolve())
        return target.samefile(source)
    return False


def check_mesh_target(out: Path, inputs: Iterable[str | Path | None] = ()) -> None:
    """Checks that a mesh can be written there, and that it is none of the inputs."""
    check_targets({"out": out}, {"out": _MESHES}, inputs)


def write_mesh(out: Path, mesh: Any) -> int:
    """Writes GLB or STL, by the name; returns the size in bytes."""
    from feeler.io import write_glb, write_stl

    return write_glb(out, mesh) if out.suffix.lower() == ".glb" else write_stl(out, mesh)


def warn(message: str) -> None:
    """One line to stderr for a problem that does not end the program."""
    print(f"feeler: warning: {printable(' '.join(message.split()))}", file=sys.stderr)


def length(metres: float) -> str:
    """Metres in the unit that reads best."""
    return words.length(metres) if np.isfinite(metres) else str(metres)


def duration(seconds: float) -> str:
    """Seconds in the unit that reads best."""
    if seconds >= 1:
        return f"{seconds:.2f} s"
    if seconds >= 1e-3:
        return f"{seconds * 1e3:.3g} ms"
    return f"{seconds * 1e6:.3g} µs"


def size(count: float) -> str:
    """Bytes in the unit that reads best."""
    for factor, unit in ((1e9, "GB"), (1e6, "MB"), (1e3, "kB")):
        if count >= factor:
            return f"{count / factor:.3g} {unit}"
    return f"{count:.0f} bytes"


def extent(lower: Sequence[float], upper: Sequence[float]) -> str:
    """The sides of a box."""
    return " × ".join(length(high - low) for low, high in zip(lower, upper, strict=True))


def times(seconds: npt.NDArray[np.float64]) -> dict[str, float]:
    """Statistics of query times, for JSON."""
    if not len(seconds):
        return {"queries": 0}
    p50, p95, p99 = np.percentile(seconds, [50, 95, 99])
    return {
        "queries": len(seconds),
        "queries_per_s": len(seconds) / float(seconds.sum()),
        "median_us": float(p50) * 1e6,
        "p95_us": float(p95) * 1e6,
        "p99_us": float(p99) * 1e6,
        "worst_us": float(seconds.max()) * 1e6,
    }


def _plain(value: Any) -> Any:
    if isinstance(value, dict):
        return {str(key): _plain(item) for key, item in value.items()}
    if isinstance(value, list | tuple):
        return [_plain(item) for item in value]
    if isinstance(value, np.ndarray):
        return _plain(value.tolist())
    if isinstance(value, np.generic):
        value = value.item()
    if isinstance(value, float) and not np.isfinite(value):
        return None
    return value
