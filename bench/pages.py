"""Shared parts of the bench's sections: goals, Markdown tables, and pages with tables made from a record.

A section (bench/feel, bench/workbench, bench/clash) keeps its record in bench/records. Its page has blocks between
`<!-- SECTION: NAME -->` and `<!-- end of SECTION: NAME -->`, which are not edited by hand.
"""

from __future__ import annotations

import argparse
import json
import re
import sys
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import host

Result = dict[str, Any]


class PageError(ValueError):
    """A page or record that cannot be used."""


@dataclass(frozen=True)
class Goal:
    """One line of a scorecard. is_timed: a clock decides it, so that no run fails by it."""

    experiment: str
    goal: str
    wanted: str
    found: str
    is_met: bool
    is_timed: bool = False


def judged(goals: Sequence[Goal]) -> int:
    """The goals on the terminal; the exit status: 1 if one is missed that no clock decides."""
    for goal in goals:
        word = "met   " if goal.is_met else "missed"
        print(f"{word}  {goal.experiment}: {goal.goal}: {goal.found} (wanted: {goal.wanted})")
    return int(any(not goal.is_met and not goal.is_timed for goal in goals))


def bold(text: str, is_met: bool) -> str:
    """Makes missed goals stand out."""
    return text if is_met else f"**{text}**"


def markdown(heads: Sequence[str], texts: int, lines: Sequence[Sequence[str]], note: str = "") -> str:
    """A table: the first columns are text, the others numbers."""
    rule = "|---" * texts + "|---:" * (len(heads) - texts) + "|"
    rows = [f"| {' | '.join(line)} |" for line in (heads, *lines)]
    return "\n".join([rows[0], rule, *rows[1:], *(["", note] if note else [])])


def origin(program: str, result: Mapping[str, Any], *more: str) -> str:
    """When, where and by which command a result was found; `more`: what else it depends on."""
    command = " ".join([f"python {program}", *result["args"]])
    changed = " with changes" if result["dirty"] else ""
    short = "; a short run" if result["is_quick"] else ""
    about = [f"`{command}`", result["when"][:10], f"commit {str(result['commit'])[:7]}{changed}"]
    return f"{', '.join([*about, result['machine']['cpu'], *more])}{short}."


def busy(result: Mapping[str, Any]) -> list[str]:
    """How busy the machine was, where it says."""
    loads = [result["load_average"], result["load_average_after"]]
    return [] if None in loads else [f"load average {loads[0][0]:.1f} before and {loads[1][0]:.1f} after"]


def written(result: Result, folder: Path, name: str, page: str) -> list[Path]:
    """NAME.json with all that was found, and tables.md."""
    folder.mkdir(parents=True, exist_ok=True)
    data, tables = folder / f"{name}.json", folder / "tables.md"
    data.write_text(json.dumps(result, indent=1) + "\n", encoding="utf-8")
    tables.write_text(page, encoding="utf-8")
    return [data, tables]


def measured(
    way: Callable[[], Result],
    options: argparse.Namespace,
    given: Sequence[str],
    peers: Mapping[str, str],
    absent: Result,
) -> Result:
    """The results of an experiment, and their origin. peers: versions by name; absent: peers left out, and why."""
    before = host.load_average()
    found = way()
    return {
        "when": host.now(),
        **host.commit(),
        "args": [word for word in given if word not in (str(options.out), "--record")],
        "is_quick": options.quick,
        "machine": host.machine(),
        "versions": host.versions(dict(peers)),
        "load_average": before,
        "load_average_after": host.load_average(),
        "absent": absent,
        **found,
    }


def ended(
    result: Result, options: argparse.Namespace, name: str, page: str, record: Path, goals: Sequence[Goal]
) -> int:
    """Writes the results of a run, on request into the record; judges them: the exit status."""
    for path in written(result, options.out, name, page):
        print(f"Written: {path}")
    if options.record:
        before = json.loads(record.read_text(encoding="utf-8")) if record.is_file() else {}
        recorded({**before, **result}, record)
        print(f"Written: {record}")
    return judged(goals)


def recorded(result: Result, path: Path) -> None:
    """A record: as small as JSON goes."""
    path.write_text(json.dumps(result, separators=(",", ":")) + "\n", encoding="utf-8")


def filled(text: str, section: str, made: Mapping[str, str]) -> str:
    """The page with the blocks of a section made anew; without any it stays as it is. Raises `PageError`."""
    block = re.compile(
        rf"<!-- {section}: (?P<name>[a-z_]+) -->\n.*?<!-- end of {section}: (?P=name) -->", flags=re.DOTALL
    )

    def anew(found: re.Match[str]) -> str:
        name = found["name"]
        if name not in made:
            raise PageError(f"the page asks for the table {name!r}; the record has {', '.join(made)}")
        return f"<!-- {section}: {name} -->\n{made[name]}\n<!-- end of {section}: {name} -->"

    if len(re.findall(rf"<!-- (?:end of )?{section}: ", text)) != 2 * len(block.findall(text)):
        begin, end = f"<!-- {section}: NAME -->", f"<!-- end of {section}: NAME -->"
        raise PageError(f"a block of the page has no end, or no beginning: each `{begin}` needs `{end}`")
    return block.sub(anew, text)


def program(
    about: str | None,
    section: str,
    page: Path,
    remedy: str,
    fill: Callable[[str, Result], str],
    beside: Callable[[Result, Path], Sequence[Path]] | None = None,
) -> int:
    """A section's figures.py: fill its page from its record, or compare; the exit status.

    remedy: the command that makes the record. beside: writes what else the page shows, and says where.
    """
    record = host.ROOT / "bench" / "records" / f"{section}.json"
    parser = argparse.ArgumentParser(description=about, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--check", action="store_true", help="write nothing; 1 if the page is out of date")
    parser.add_argument("--record", type=Path, default=record, help=f"the record (bench/records/{section}.json)")
    parser.add_argument("--page", type=Path, default=page, help=f"the page (docs/{page.name})")
    options = parser.parse_args()
    for path, what in ((options.record, f"run {remedy} first"), (options.page, "write it first")):
        if not path.is_file():
            print(f"{path} is not there: {what}", file=sys.stderr)
            return 2
    result = json.loads(options.record.read_text(encoding="utf-8"))
    before = options.page.read_text(encoding="utf-8")
    try:
        after = fill(before, result)
    except PageError as error:
        print(error, file=sys.stderr)
        return 2
    if options.check:
        return int(before != after)
    options.page.write_text(after, encoding="utf-8")
    print(f"Written: {options.page}")
    for path in beside(result, options.page) if beside is not None else ():
        print(f"Written: {path}")
    return 0
