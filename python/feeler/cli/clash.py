"""`feeler clash`: which parts of a mock-up overlap, touch, or are too near each other?"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import asdict
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import typer

import feeler
from feeler.arguments import check_word
from feeler.choices import GROUPS_BY, Chord, GroupBy
from feeler.cli.app import FOUND, INTERRUPTED, command, fail
from feeler.cli.findings import mesh_facts
from feeler.cli.inputs import (
    AsJson,
    ChordTolerance,
    MockupFiles,
    MockupUnit,
    Only,
    Threads,
    Up,
    Without,
    indexed,
    read_checked,
)
from feeler.cli.options import given_of
from feeler.cli.projects import Work, files_of, fitted, named_project, open_for_writing, take_mockup
from feeler.cli.values import LENGTH, Or, Word
from feeler.errors import OptionError
from feeler.progress import bar
from feeler.words import plural

if TYPE_CHECKING:
    from feeler.clashes.matching import PartMatch
    from feeler.project.book import Book
    from feeler.project.settings import ClashSettings

_SHOWN_GROUPS = 12
_SHOWN = 20
_ENDINGS = {
    "csv": (".csv",),
    "xlsx": (".xlsx",),
    "html": (".html",),
    "bcf": (".bcf",),
    "glb": (".glb",),
    "save": (".json",),
    "write-rules": (".toml",),
}


@command(
    examples="""
feeler clash engine.step
feeler clash engine.step --clearance 5mm --contact chord --html clashes.html --bcf clashes.bcf
feeler clash engine.step --write-rules clash.toml
feeler clash engine.step --rules clash.toml --previous last.json --save now.json --fail-on new
feeler clash engine.step --project engine.feelproj --fail-on new
feeler clash engine.feelproj
feeler clash now.json --rules other.toml
feeler clash sample:gearbox:100000 --clearance 0 --contact 1mm --fail-on clash,duplicate,contained --json
"""
)
def clash(
    context: typer.Context,
    mockup: MockupFiles,
    clearance: Annotated[float, typer.Option(help="Required distance of parts; 0: only collisions."), LENGTH] = 0.002,
    contact: Annotated[
        float | Chord,
        typer.Option(
            help="How deep parts may overlap and still count as contact; chord: the chordal errors of both (STEP).",
        ),
        Or(LENGTH, "chord"),
    ] = 0.0,
    rules: Annotated[Path | None, typer.Option(help="Limits by pairs of parts, and pairs to hide (TOML).")] = None,
    write_rules: Annotated[
        Path | None,
        typer.Option("--write-rules", help="Write a first file of rules from the findings. It must not exist yet."),
    ] = None,
    previous: Annotated[
        Path | None,
        typer.Option(
            help="Findings of an earlier --save, of this file or another: take over statuses, report resolved ones."
        ),
    ] = None,
    save: Annotated[Path | None, typer.Option(help="Save the findings with their status, for the next check.")] = None,
    project: Annotated[
        Path | None,
        typer.Option(
            metavar="FILE",
            help="A project (.feelproj): take over statuses of its last check, and write the findings into it; made if "
            "it is missing.",
        ),
    ] = None,
    growth: Annotated[
        float | None,
        typer.Option(help="How much deeper an approved finding may get and stay approved. Default: 0.1mm."),
        LENGTH,
    ] = None,
    fail_on: Annotated[
        str | None,
        typer.Option(
            "--fail-on",
            metavar="WORDS",
            help="Exit with 1 if there are such findings: any, or words separated by commas: statuses (new, active, "
            "...), verdicts (clash, contact, clearance, contained, duplicate), severities (critical, major, minor). "
            "Words of one kind are alternatives; all kinds given must match: new,clash,contained.",
        ),
    ] = None,
    volume: Annotated[
        bool, typer.Option("--volume", help="Measure the shared volume of closed parts (needs feeler\\[volume]).")
    ] = False,
    by: Annotated[str, typer.Option(help="How to group findings."), Word(GROUPS_BY)] = "part",
    without: Without = None,
    only: Only = None,
    unit: MockupUnit = None,
    up: Up = None,
    chord_tolerance: ChordTolerance = None,
    threads: Threads = None,
    csv: Annotated[Path | None, typer.Option(help="Write a line for each finding.")] = None,
    xlsx: Annotated[
        Path | None, typer.Option(help="Write a workbook with a row and a picture for each (needs feeler\\[xlsx]).")
    ] = None,
    html: Annotated[
        Path | None, typer.Option(help="Write one page with pictures and filters; it needs no network.")
    ] = None,
    bcf: Annotated[
        Path | None,
        typer.Option(help="Write BCF 3.0: a topic for each group, at most 100, those with decisions first."),
    ] = None,
    glb: Annotated[Path | None, typer.Option(help="Write the mock-up with coloured findings as GLB.")] = None,
    bcf_in: Annotated[
        Path | None, typer.Option("--bcf-in", help="Take over statuses and comments of topics from this BCF file.")
    ] = None,
    as_json: AsJson = False,
) -> None:
    """Finds every pair of parts that overlap, touch, or are too near; classifies them exactly, and measures them.

    To try --rules without another check, pass the findings of --save instead of the mock-up. A project instead of the
    mock-up stands for the mock-up that it names. With a project, --clearance, --contact and --rules that are not given
    are those of its last check, also of one in the page.

    Exit status: 0 fine, 1 findings that match --fail-on, 2 bad input. Ctrl-C keeps the findings so far, marked as
    partial, and ends with 130.
    """
    from feeler import clashes as room
    from feeler.clashes.changes import check_previous
    from feeler.clashes.rules import renamed
    from feeler.cli import outputs
    from feeler.io.xlsx import xlsx_library
    from feeler.project.renaming import Names
    from feeler.project.settings import settings_changes

    named = named_project(mockup, project)
    if named is not None and (previous is not None or _is_saved(mockup)):
        raise OptionError("--project has the findings of its last check: leave out --previous and saved findings")
    targets = {"csv": csv, "xlsx": xlsx, "html": html, "bcf": bcf, "glb": glb, "save": save, "write-rules": write_rules}
    in_place = ["previous"]  # its findings may be saved there
    outputs.check_targets(targets, _ENDINGS, mockup, in_place)
    if xlsx is not None:
        xlsx_library()
    group_by = check_word("--by", by, GROUPS_BY)
    if growth is not None and previous is None and named is None and bcf_in is None:
        raise OptionError("--growth compares with an earlier check: give --previous, --project or --bcf-in, too")
    wanted = _wanted(fail_on)
    given = None if rules is None else room.Rules.read(rules)
    kept = None
    before = None if previous is None else room.load_clashes(previous)
    topics = None if bcf_in is None else room.read_bcf(bcf_in)
    is_interrupted = False
    world: feeler.Mockup | None = None
    book: Book | None = None
    work = Work(files_of(mockup), None, None, unit, up, without, only)
    if named is not None:
        book, work = open_for_writing(context, named, work)
        outputs.check_targets(targets, _ENDINGS, work.sources, in_place)
        before = book.clashes()
        kept = _kept(context, book, clearance, contact, rules)
        clearance, contact = kept.clearance, "chord" if kept.contact is None else kept.contact
    mockup = work.sources
    if _is_saved(mockup):
        _check_saved(context, targets)
        found = room.load_clashes(mockup[0])
        if given is not None:
            found = found.with_rules(given)
    else:
        world = read_checked(mockup, work.unit, work.up, chord_tolerance)
        if book is not None:
            work = fitted(book, work, world)
            take_mockup(book, world, work)
            before = book.clashes()
            if kept is not None and given is None:
                names = Names.of(book.revision(world)) if book.parts() else Names()
                given = renamed(kept.parsed(f"the rules of {named}"), lambda one: names.pattern(one, world.parts))
        if before is not None:
            check_previous(world, before)
        scene = indexed(world, work.without, work.only, threads)
        try:
            with bar("looking for clashes") as progress:
                found = feeler.clash(
                    world,
                    clearance,
                    contact,
                    given,
                    volume=volume,
                    scene=scene,
                    threads=threads,
                    progress=progress,
                )
        except room.ClashInterrupted as stop:
            found, is_interrupted = stop.clashes, True
    if world is not None and (doubt := _chord_doubt(found, world.source.chord_tolerance)):
        outputs.warn(doubt)
    match = None
    if before is not None:
        match = found.diff(before, **_growth(growth)).parts
        if match.is_doubtful:
            outputs.warn(f"{match}; is {previous or named} of this mock-up?")
    changes = None if topics is None else room.apply_bcf(found, topics, **_growth(growth))
    if changes is not None and changes.unknown:
        outputs.warn(f"{len(changes.unknown):,} of {len(topics or ()):,} topics of {bcf_in} are of no finding here")
    if changes is not None and changes.outgrown:
        outputs.warn(f"{plural(len(changes.outgrown), 'finding')} approved in {bcf_in} not taken over: deeper now")
    written = _write(world, found, targets, group_by)
    if book is not None:
        book.write_clashes(found, group_by, () if kept is None else settings_changes(book, kept))
        written["project"] = book.path
    is_found = wanted is not None and wanted(found)
    if as_json:
        facts = {"mockup": None if world is None else mesh_facts(world), "written": written, "failed": is_found}
        if match is not None:
            facts["previous"] = asdict(match)
        if changes is not None:
            facts["bcf"] = {
                "topics": len(topics or ()),
                "statuses": len(changes.statuses),
                "notes": len(changes.notes),
                "unknown": len(changes.unknown),
                "outgrown": len(changes.outgrown),
            }
        outputs.print_json({**room.report(found, by=group_by), **facts})
    else:
        _print(found, group_by, match, written, has_statuses=match is not None or changes is not None)
        if changes is not None:
            taken = f"{plural(len(changes.statuses), 'status')} and {plural(len(changes.notes), 'note')} taken over"
            outputs.say(outputs.console(), f"{bcf_in}: {taken}")
    if is_interrupted:
        fail("interrupted: these are the findings so far")
        raise typer.Exit(INTERRUPTED)
    if is_found:
        raise typer.Exit(FOUND)


def _kept(
    context: typer.Context, book: Book, clearance: float, contact: float | Chord, rules: Path | None
) -> ClashSettings:
    """The settings of the check, which the project keeps: those of its last check where an option is not given."""
    from feeler.io.text import text_of
    from feeler.project.settings import MOST_RULES, ClashSettings, settings_of

    last = settings_of(book) or ClashSettings()
    text = last.rules if rules is None else text_of(rules)
    if len(text) > MOST_RULES:
        raise OptionError(
            f"{rules}: a project keeps at most {MOST_RULES:,} characters of rules, and it has {len(text):,}"
        )
    return ClashSettings(
        clearance if "clearance" in given_of(context) else last.clearance,
        (None if isinstance(contact, str) else contact) if "contact" in given_of(context) else last.contact,
        text,
    )


def _growth(given: float | None) -> dict[str, float]:
    """As an argument of what compares; empty for its default."""
    return {} if given is None else {"growth": given}


def _chord_doubt(found: feeler.Clashes, chord: float | None) -> str | None:
    """A note if small clashes may come from the triangles alone, which are up to `chord` (metres) off the faces."""
    if chord is None:
        return None
    small = (found.verdicts == feeler.Verdict.CLASH) & (found.depths < 2.0 * chord)
    if not small.any():
        return None
    from feeler.cli import outputs

    few = int(small.sum())
    said = "1 clash is" if few == 1 else f"{few:,} clashes are"
    return (
        f"{said} less deep than the chordal errors of both parts ({outputs.length(2.0 * chord)}) and may come from the "
        "triangles alone: pass --contact chord, or a smaller --chord-tolerance"
    )


def _is_saved(files: list[str]) -> bool:
    """Whether the input is a file of findings, not a mock-up: no mock-up format ends in .json."""
    return len(files) == 1 and Path(files[0]).suffix.lower() == ".json"


_CHECKING = ("clearance", "contact", "volume", "without", "only", "unit", "up", "chord_tolerance", "threads")
"""Options of a check, which saved findings do not take."""


def _check_saved(context: typer.Context, targets: dict[str, Path | None]) -> None:
    """Raises `OptionError` for options that need the mock-up."""
    given = [name for name in _CHECKING if name in given_of(context)]
    given += [name for name in ("bcf", "glb") if targets[name] is not None]
    if given:
        options = ", ".join(f"--{name.replace('_', '-')}" for name in given)
        raise OptionError(
            f"{options}: saved findings are not checked again. Pass the mock-up instead of the .json file"
        )


def _wanted(fail_on: str | None) -> Callable[[feeler.Clashes], bool] | None:
    """A test for findings that match --fail-on; None if it was not given."""
    if fail_on is None:
        return None
    from feeler.arguments import near
    from feeler.clashes.tracking import SETTABLE
    from feeler.clashes.verdict import SEVERITIES, Verdict

    kinds: dict[str, list[str]] = {
        "verdict": [each.value for each in Verdict],
        "status": [*SETTABLE],
        "severity": [*SEVERITIES],
    }
    every = ["any", *(word for known in kinds.values() for word in known)]
    asked: dict[str, list[str]] = {}
    given = [word.strip().lower() for word in fail_on.split(",")]
    for word in given:
        kind = next((name for name, known in kinds.items() if word in known), None)
        if kind is None and word != "any":
            raise OptionError(f"--fail-on has {word!r}: {near(word, every)}")
        if kind is not None:
            asked.setdefault(kind, []).append(word)

    def is_found(found: feeler.Clashes) -> bool:
        return any(all(_value(row, kind) in known for kind, known in asked.items()) for row in found)

    return is_found


def _value(row: feeler.Clash, kind: str) -> str:
    return str(getattr(row, kind))


def _write(
    world: feeler.Mockup | None, found: feeler.Clashes, targets: dict[str, Path | None], by: GroupBy
) -> dict[str, str]:
    """Writes the requested files; returns their names by kind."""
    from feeler import clashes as room
    from feeler.clashes.as_bcf import left_out
    from feeler.cli.outputs import warn

    topics = 0
    written = {}
    for kind, target in targets.items():
        if target is None:
            continue
        with bar(f"writing {target}") as progress:
            if kind == "csv":
                room.write_csv(target, found, by=by)
            elif kind == "xlsx":
                room.write_xlsx(target, found, world, by=by, progress=progress)
            elif kind == "html":
                room.write_html(target, found, world, by=by, progress=progress)
            elif kind == "bcf":
                assert world is not None  # _check_saved
                topics = room.write_bcf(target, found, world, by=by, progress=progress)
            elif kind == "glb":
                assert world is not None
                room.write_clash_glb(target, found, world)
            elif kind == "save":
                found.save(target)
            else:
                room.write_rules(target, found)
        written[kind] = str(target)
    if "bcf" in written and (short := left_out(found, by, topics)):
        warn(f"{written['bcf']} {short}")
    return written


def _print(
    found: feeler.Clashes, by: GroupBy, match: PartMatch | None, written: dict[str, str], *, has_statuses: bool
) -> None:
    from feeler.clashes.advice import advice
    from feeler.clashes.as_json import statuses
    from feeler.clashes.words import extent, hidden, sentence, shared
    from feeler.cli import outputs
    from feeler.words import volume

    out = outputs.console()
    if found.is_partial:
        outputs.print_finding(out, "interrupted: these are the findings so far")
    counts = [(len(found.where(verdict=each)), each.value) for each in feeler.Verdict]
    said = ", ".join(f"{number:,} {name}" for number, name in counts if number)
    seconds = sum(value for _, value in found.facts.seconds)
    took = f" ({outputs.duration(seconds)})" if seconds else ""  # saved findings took none
    outputs.say(out, f"{plural(len(found), 'finding')} among {plural(found.facts.parts, 'part')}{took}")
    if said:
        outputs.say(out, f"  {said}")
    total = shared(found)
    if total:
        outputs.say(out, f"  shared volume: {total}")
    if found.hidden:
        outputs.say(out, f"  hidden: {hidden(found)}")
    if match is not None:
        outputs.say(out, "  " + ", ".join(f"{number:,} {name}" for name, number in statuses(found).items()))
        if not match.is_plain:
            outputs.say(out, f"  {match}")
    for each in advice(found):
        outputs.say(out, f"  {each}")
    out.print()
    groups = found.groups(by)
    if groups:
        outputs.print_table(
            out,
            f"Groups by {by}",
            [(by, "left"), ("findings", "right"), ("the worst", "left")],
            [(group.name, f"{len(group):,}", sentence(group.worst)) for group in groups[:_SHOWN_GROUPS]],
            more=len(groups) - _SHOWN_GROUPS,
        )
        rows: list[Any] = [
            (
                *(row.verdict, extent(row), *([volume(row.volume)] if total else []), row.path_a, row.path_b),
                *([row.rule] if len(found.rule_names) > 1 else []),
                *([row.status] if has_statuses else []),
            )
            for row in found[:_SHOWN]
        ]
        outputs.print_table(
            out,
            "Findings, the worst first",
            [
                *(("verdict", "left"), ("depth or gap", "right")),
                *([("shared volume", "right")] if total else []),
                *(("part", "left"), ("other part", "left")),
                *([("rule", "left")] if len(found.rule_names) > 1 else []),
                *([("status", "left")] if has_statuses else []),
            ],
            rows,
            more=len(found) - _SHOWN,
        )
    for kind, target in written.items():
        outputs.say(out, f"{kind} written to {target}")
