"""A section of the bench: clash, feel, removal or workbench, each in its folder, with a record and a page.

A section gives its experiments (run.py), their goals (goals.py) and their tables (tables.py). Here are the options that
all share, the origin of a result, the scorecard, the files of a run, and the page.
"""

from __future__ import annotations

import argparse
import json
import sys
import traceback
from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any, Generic, TypeVar

import command_line
import host
import pages
from command_line import listed, one_of
from host import ROOT

RECORDS = ROOT / "bench" / "records"

Result = dict[str, Any]
Size = TypeVar("Size")


@dataclass(frozen=True)
class Goal:
    """One line of a scorecard. is_timed: a clock decides it, so that no run fails by it."""

    experiment: str
    goal: str
    wanted: str
    found: str
    is_met: bool
    is_timed: bool = False


def scorecard(judges: Mapping[str, Callable[[Result], Iterator[Goal]]], found: Mapping[str, Result]) -> list[Goal]:
    """The goals of the experiments that ran; one that stopped with an error misses its only goal."""
    goals: list[Goal] = []
    for name, result in found.items():
        if "failed" in result:
            goals.append(Goal(name, "it runs", "no error", last_line(result), False))
        else:
            goals += judges[name](result)
    return goals


def scorecard_table(heads: Sequence[str], texts: int, goals: Sequence[Goal]) -> str:
    """Every goal; missed ones bold."""
    lines = [
        [goal.experiment.replace("_", " "), goal.goal, goal.wanted, pages.bold(goal.found, goal.is_met)]
        for goal in goals
    ]
    return pages.markdown(heads, texts, lines, "Bold: missed.")


def judged(goals: Sequence[Goal]) -> int:
    """The goals on the terminal; the exit status: 1 if one is missed that no clock decides."""
    for goal in goals:
        word = "met   " if goal.is_met else "missed"
        print(f"{word}  {goal.experiment}: {goal.goal}: {goal.found} (wanted: {goal.wanted})")
    return int(any(not goal.is_met and not goal.is_timed for goal in goals))


def by_experiment(makers: Mapping[str, Callable[[Result], str]], result: Result) -> dict[str, str]:
    """The tables of the experiments that a result has, by name."""
    return {name: make(result[name]) for name, make in makers.items() if name in result}


def measured_each(
    ways: Mapping[str, Callable[[], Result]],
    options: argparse.Namespace,
    versions: Mapping[str, str],
    absent: Mapping[str, str],
) -> Result:
    """The results of the chosen experiments by name, each with its origin."""
    for name, reason in absent.items():
        print(f"{name} is left out: {reason}", file=sys.stderr)
    return {name: measured(ways[name], options, versions, absent) for name in options.only}


def attempted(subject: str, ways: Mapping[str, Callable[[], Result | None]]) -> dict[str, Result]:
    """The results of experiments by name; an error is a result, too, and does not stop the others."""
    found: dict[str, Result] = {}
    for name, way in ways.items():
        print(f"{subject}: {name}", file=sys.stderr)
        try:
            result = way()
        except Exception:
            result = {"failed": traceback.format_exc()}
            print(result["failed"], file=sys.stderr)
        if result is not None:
            found[name] = result
    return found


def last_line(result: Result) -> str:
    """The error that stopped an experiment."""
    return str(result["failed"]).splitlines()[-1]


def measured(
    way: Callable[[], Result],
    options: argparse.Namespace,
    versions: Mapping[str, str] | None = None,
    absent: Mapping[str, str] | None = None,
) -> Result:
    """The results of a way, and their origin. versions: of peers, by name; absent: peers left out, and why."""
    before = host.load_average()
    found = way()
    return {
        "when": host.now(),
        **host.commit(),
        "args": [word for word in options.given if word not in (str(options.out), "--record", "--add")],
        "is_quick": options.quick,
        "machine": host.machine(),
        "versions": host.versions(dict(versions or {})),
        "load_average": before,
        "load_average_after": host.load_average(),
        "absent": dict(absent or {}),
        **found,
    }


def busy(result: Mapping[str, Any]) -> list[str]:
    """How busy the machine was, where it says."""
    loads = [result["load_average"], result["load_average_after"]]
    return [] if None in loads else [f"load average {loads[0][0]:.1f} before and {loads[1][0]:.1f} after"]


@dataclass(frozen=True)
class Form(Generic[Size]):
    """A size in the long form of a run, and in the short one (`--quick`)."""

    long: Size
    quick: Size

    def __str__(self) -> str:
        words = [",".join(map(str, size)) if isinstance(size, list) else f"{size}" for size in (self.long, self.quick)]
        return f"{words[0]}; quick: {words[1]}"

    def of(self, options: argparse.Namespace) -> Size:
        """The one of a run."""
        return self.quick if options.quick else self.long


@dataclass(frozen=True)
class Section:
    """The programs of a section: `main` is its run.py, `figures` its figures.py.

    subjects: the key of the result that has a dict of experiments for each subject, such as a mock-up. A result without
    it has experiments by name, each with its own origin; its record keeps those that a run leaves out.
    plots: draws into a folder, for the page into docs/`pictures`.
    """

    name: str
    page: str
    experiments: Sequence[str]
    tables: Callable[[Result], dict[str, str]]
    scorecard: Callable[[Result], list[Goal]]
    subjects: str = ""
    plots: Callable[[Result, Path], Sequence[Path]] | None = None
    pictures: str = ""

    @property
    def record(self) -> Path:
        """The file that keeps the results which the page shows."""
        return RECORDS / f"{self.name}.json"

    def parser(self, about: str | None, quick: str) -> argparse.ArgumentParser:
        """A parser with the options that all sections have; an option's default may be a `Form`."""
        parser = command_line.parser(about or "")
        out = ROOT / "target" / self.name
        parser.add_argument("out", nargs="?", type=Path, default=out, help=f"folder of the results (target/{out.name})")
        parser.add_argument("--quick", action="store_true", help=quick)
        only = listed(one_of("experiment", self.experiments))
        parser.add_argument("--only", type=only, help=", ".join(self.experiments))
        if self.subjects:
            parser.add_argument("--add", action="store_true", help=f"keep other {self.subjects} and experiments")
        parser.add_argument("--record", action="store_true", help=f"also write bench/records/{self.name}.json")
        return parser

    def options(self, parser: argparse.ArgumentParser, given: Sequence[str]) -> argparse.Namespace:
        """The command line, with the defaults of its form; `given` has its words."""
        options = parser.parse_args(given)
        for name, value in vars(options).items():
            if isinstance(value, Form):
                setattr(options, name, value.of(options))
        options.only = options.only or list(self.experiments)
        options.given = list(given)
        return options

    def main(
        self,
        parse: Callable[[Sequence[str]], argparse.Namespace],
        run: Callable[[argparse.Namespace], Result],
        arguments: Sequence[str] | None = None,
    ) -> int:
        """Run, write NAME.json and tables.md, record on request, judge; the exit status."""
        options = parse(sys.argv[1:] if arguments is None else arguments)
        result = run(options)
        data = options.out / f"{self.name}.json"
        if self.subjects and options.add and data.is_file():
            result = self._added(json.loads(data.read_text(encoding="utf-8")), result)
        options.out.mkdir(parents=True, exist_ok=True)
        data.write_text(json.dumps(result, indent=1) + "\n", encoding="utf-8")
        tables = options.out / "tables.md"
        made = {name.replace("_", " ").capitalize(): each for name, each in self.tables(result).items()}
        sections = [f"\n## {head}\n\n{table}\n" for head, table in made.items()]
        tables.write_text(f"# {self.name.capitalize()}\n{''.join(sections)}", encoding="utf-8")
        paths = [data, tables, *(self.plots(result, options.out) if self.plots else ())]
        if options.record:
            is_kept = not self.subjects and self.record.is_file()
            before = json.loads(self.record.read_text(encoding="utf-8")) if is_kept else {}
            whole = json.dumps({**before, **result}, separators=(",", ":"))
            self.record.write_text(whole + "\n", encoding="utf-8")
            paths.append(self.record)
        for path in paths:
            print(f"Written: {path}")
        return judged(self.scorecard(result))

    def _added(self, old: Result, new: Result) -> Result:
        """The new result with the old one's other subjects and experiments; with the arguments of all runs."""
        subjects = {name: dict(found) for name, found in old[self.subjects].items()}
        for subject, found in new[self.subjects].items():
            subjects.setdefault(subject, {}).update(found)
        args = [*old["args"], "and", *new["args"]]
        return {**new, self.subjects: subjects, "args": args, "is_quick": new["is_quick"] or old["is_quick"]}

    def origin(self, result: Mapping[str, Any], *more: str) -> str:
        """When, where and by which command a result was found; `more`: what else it depends on."""
        command = " ".join([f"python bench/{self.name}/run.py", *result["args"]])
        changed = " with changes" if result["dirty"] else ""
        short = "; a short run" if result["is_quick"] else ""
        about = [f"`{command}`", result["when"][:10], f"commit {str(result['commit'])[:7]}{changed}"]
        return f"{', '.join([*about, result['machine']['cpu'], *more])}{short}."

    def filled(self, text: str, result: Result) -> str:
        """The page with its blocks made anew from a record. Raises `pages.PageError`."""
        made = dict.fromkeys(self.experiments, "Not measured yet.") | self.tables(result)
        return pages.filled(text, self.name, made)

    def figures(self) -> int:
        """Fill the page from the record, or compare; the exit status."""
        parser = argparse.ArgumentParser(
            description=f"Fills the blocks `<!-- {self.name}: TABLE -->` of docs/{self.page} from the record, "
            f"bench/records/{self.name}.json; the tables are those of bench/{self.name}/tables.py."
        )
        parser.add_argument("--check", action="store_true", help="write nothing; 1 if the page is out of date")
        parser.add_argument("--record", type=Path, default=self.record, help="the record; default: of bench/records")
        parser.add_argument("--page", type=Path, default=ROOT / "docs" / self.page, help=f"the page (docs/{self.page})")
        options = parser.parse_args()
        remedy = f"run bench/{self.name}/run.py --record first"
        for path, what in ((options.record, remedy), (options.page, "write it first")):
            if not path.is_file():
                print(f"{path} is not there: {what}", file=sys.stderr)
                return 2
        result = json.loads(options.record.read_text(encoding="utf-8"))
        before = options.page.read_text(encoding="utf-8")
        try:
            after = self.filled(before, result)
        except pages.PageError as error:
            print(error, file=sys.stderr)
            return 2
        if options.check:
            return int(before != after)
        options.page.write_text(after, encoding="utf-8")
        plots = self.plots(result, options.page.parent / self.pictures) if self.plots else ()
        for path in (options.page, *plots):
            print(f"Written: {path}")
        return 0
