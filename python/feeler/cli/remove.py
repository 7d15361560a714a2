"""`feeler remove`: can a part be taken out, and by which path?"""

from __future__ import annotations

import dataclasses
import math
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import numpy as np
import numpy.typing as npt
import typer

import feeler
from feeler.cli.app import FOUND, INTERRUPTED, command, fail
from feeler.cli.findings import mesh_facts, scene_facts
from feeler.cli.inputs import (
    AsJson,
    At,
    Choice,
    MockupFiles,
    MockupUnit,
    Only,
    PoseFile,
    Rotate,
    SnapPose,
    ToolUnit,
    Triple,
    Up,
    Without,
    check_unit,
    poses_of_options,
    read_mockup,
    read_poses,
    read_tool,
    warn_of_doubts,
)
from feeler.cli.options import Needs
from feeler.cli.values import DIRECTION, LENGTH, SECONDS, SEED, THREADS, Whole
from feeler.cli.workers import Dask, Workers, executor_of
from feeler.errors import MeshError, OptionError
from feeler.progress import bar
from feeler.words import plural

if TYPE_CHECKING:
    from concurrent.futures import Executor

_SHOWN = 20
_SHOWN_BLOCKERS = 3
_ENDINGS = {"csv": (".csv",), "way": (".npy", ".json"), "glb": (".glb",)}


@command(
    examples="""
feeler remove engine.step --part "*fuel pump*"
feeler remove engine.step --part "*fuel pump*" --hand sample:hand --at 0.8,0.1,0.3 --clearance 0.002 --glb way.glb
feeler remove engine.step --part "*bolt*" --each --csv bolts.csv
feeler remove engine.feeler --part "*pump*" --each --workers 8 --rounds 20
feeler remove engine.step --part "*pump*" --order --keep "*casing*" --seconds 120 --json
feeler remove engine.feeler --part "*pump*" --order --rounds 50 --seconds 3600 --workers 8
feeler remove sample:gearbox --part gearbox/bracket/left_mount/retainer --order
feeler remove engine.step --part "*fuel pump*" --insert --from bench.json --glb in.glb
feeler remove engine.step --part "*pump*" --way out.npy && feeler path engine.step --part "*pump*" --poses out.npy
"""
)
def remove(
    mockup: MockupFiles,
    *,
    part: Annotated[
        list[str] | None,
        typer.Option(
            metavar="PATTERN",
            help="The parts to take out: a path with all below it, a name, or a pattern such as '*pump*'. All matches "
            "come out together, as one.",
        ),
    ] = None,
    each: Annotated[bool, typer.Option("--each", help="Each of the parts separately, with all others in place.")] = (
        False
    ),
    order: Annotated[
        bool, typer.Option("--order", help="Also find the parts to remove first, and the path of each.")
    ] = False,
    keep: Annotated[
        list[str] | None,
        typer.Option(metavar="PATTERN", help="With --order: parts that must stay (repeat for more)."),
        Needs("--order"),
    ] = None,
    insert: Annotated[
        bool, typer.Option("--insert", help="Find the path into its place instead, from outside or --from FILE.")
    ] = False,
    from_: Annotated[
        Path | None,
        typer.Option("--from", help="With --insert: the start, as a motion from its place, a 4 by 4 matrix."),
        Needs("--insert"),
    ] = None,
    goal: Annotated[
        Path | None,
        typer.Option(help="With --insert: the goal, as a motion from its place; a file as for --from."),
        Needs("--insert"),
    ] = None,
    hand: Annotated[
        str | None,
        typer.Option(
            metavar="FILE", help="A hand that grips it: a file, or sample:NAME, placed by --at, --rotate or --pose."
        ),
    ] = None,
    hand_unit: Annotated[ToolUnit, Needs("--hand")] = None,
    at: Annotated[At, Needs("--hand")] = None,
    rotate: Annotated[Rotate, Needs("--hand")] = None,
    pose: Annotated[PoseFile, Needs("--hand")] = None,
    ignore: Annotated[
        list[str] | None,
        typer.Option(metavar="PATTERN", help="Neighbours that it may touch and cross on its path (repeat for more)."),
    ] = None,
    overlap: Annotated[float, typer.Option(help="How deep each pair may overlap on the way."), LENGTH] = 0.0,
    seats: Annotated[
        bool,
        typer.Option(
            help="Let pairs that are in contact at the start stay so until they separate, no deeper than there."
        ),
    ] = True,
    direction: Annotated[
        list[Triple] | None, typer.Option(help="Try this direction first (repeat for more)."), DIRECTION
    ] = None,
    clearance: Annotated[
        float, typer.Option(help="Distance to keep from all parts that it is not seated on."), LENGTH
    ] = 0.0,
    seconds: Annotated[float, typer.Option(help="Time for a part; with --order, in total."), SECONDS] = 30.0,
    seed: Annotated[int, typer.Option(help="Seed of the random search; the same seed finds the same path."), SEED] = 0,
    snap_pose: Annotated[SnapPose, Needs("--pose", "--from", "--goal")] = False,
    without: Without = None,
    only: Only = None,
    unit: MockupUnit = None,
    up: Up = None,
    threads: Annotated[
        int | None, typer.Option(help="Default: all cores. The path does not depend on it."), THREADS
    ] = None,
    rounds: Annotated[
        int | None,
        typer.Option(help="The most rounds of the search: equal work, so equal answers on every machine."),
        Whole(0, 2**32 - 1),
    ] = None,
    workers: Annotated[Workers, Needs("--each", "--order")] = None,
    dask: Annotated[Dask, Needs("--each", "--order")] = None,
    allow: Annotated[str | None, typer.Option(hidden=True)] = None,  # of early builds
    csv: Annotated[Path | None, typer.Option(help="Write a line for each part, or step.")] = None,
    way: Annotated[
        Path | None, typer.Option(help="Write the path's poses, (n, 4, 4), as .npy or .json, for path and swept.")
    ] = None,
    glb: Annotated[
        Path | None, typer.Option(help="Write a film as GLB: moving parts in blue, blockers in red.")
    ] = None,
    as_json: AsJson = False,
) -> None:
    """Finds a path for parts out of a mock-up, or into it: straight if possible, else around the neighbours.

    Every path is verified as by `feeler path`. If none was found, feeler lists the blocking parts. That is no proof
    that there is none, unless feeler says which parts hold it. Exit status: 0 all come out, 1 some do not, 2 bad input.
    Ctrl-C keeps the results so far, and ends with 130.
    """
    if allow is not None:
        raise OptionError("--allow is gone: give --ignore PATTERN, --overlap METRES, or --no-seats")
    targets = {"csv": csv, "way": way, "glb": glb}
    _check(targets, mockup, part, each, order, hand)
    ends = _ends(insert, {"--from": from_, "--goal": goal}, each or order, snap_pose)
    assert part is not None
    if rounds is not None and insert:
        raise OptionError("--rounds is for removals, without --insert")
    options: dict[str, Any] = {
        "ignore": ignore,
        "overlap": overlap,
        "seats": seats,
        "directions": np.array(direction) if direction else None,
        "clearance": clearance,
        "seconds": seconds,
        "seed": seed,
        "threads": threads,
    }
    if rounds is not None:
        options["rounds"] = rounds
    if hand is not None:
        check_unit("--hand-unit", hand_unit, hand)
    held = None if hand is None else read_tool(hand, hand_unit, up)
    start = poses_of_options(pose, at, rotate, snap_pose, has_place=True)
    if len(start) > 1:
        raise OptionError(f"--pose {pose} has {len(start)} poses: the grip of the hand is one")
    world = read_mockup(mockup, unit, up)
    warn_of_doubts(world)
    with bar("indexing") as progress:
        scene = feeler.Scene(world, threads=threads, progress=progress)
    scene = Choice(None, without, only).scene_of(scene) if without or only else scene
    asked = _Asked(scene, held, start[0], keep, options, ends)
    chosen = world.parts.select(part)
    if each:
        answers, is_interrupted = _each(asked, chosen.tolist(), workers, dask)
    else:
        answers, is_interrupted = _one(asked, chosen, order, workers, dask)
    written = _write(asked, answers, targets)
    is_found = all(answer.found for answer in answers) and not is_interrupted
    if as_json:
        from feeler.cli import outputs

        outputs.print_json(
            {
                "found": is_found,
                "parts": [answer.facts(world) for answer in answers],
                "clearance_m": clearance,
                "seed": seed,
                "mockup": mesh_facts(world),
                "scene": scene_facts(scene),
                "written": written,
            }
        )
    else:
        _print(world, answers, written, ends_out=ends is None)
    if is_interrupted:
        fail("interrupted: these are the results so far")
        raise typer.Exit(INTERRUPTED)
    if not is_found:
        raise typer.Exit(FOUND)


@dataclass(frozen=True)
class _Answer:
    """The request and its steps; one step unless an order was requested."""

    parts: tuple[int, ...]
    found: bool
    steps: tuple[feeler.RemovalStep, ...]
    error: str = ""
    """Why nothing could be tried."""
    stuck: tuple[int, ...] = ()
    """Of an order that was not found: the last parts that could not leave."""
    blocked_by: tuple[feeler.RemovalBlocker, ...] = ()
    """What stood in the way of those."""

    @property
    def last(self) -> feeler.Removal:
        return self.steps[-1].removal

    def facts(self, mockup: feeler.Mockup) -> dict[str, Any]:
        """The answer as JSON values."""
        steps = [_step_facts(mockup, step) for step in self.steps]
        facts: dict[str, Any] = {"found": self.found, "error": self.error or None, "steps": steps}
        if self.stuck:
            facts["stuck"] = [{"part": part, "path": mockup.part_paths[part]} for part in self.stuck]
            facts["blocked_by"] = _blocker_facts(mockup, self.blocked_by)
        return facts


@dataclass(frozen=True, eq=False)
class _Asked:
    """The arguments that all parts share."""

    scene: feeler.Scene
    hand: feeler.Tool | None
    start: npt.NDArray[np.float64]
    keep: list[str] | None
    options: dict[str, Any]
    ends: dict[str, Any] | None
    """For a path in: its start and goal; None for a path out."""

    def answer(self, parts: npt.NDArray[np.uint32], order: bool, executor: Executor | None = None) -> _Answer:
        """One question."""
        mockup = self.scene.mockup
        name = mockup.part_paths[int(parts[0])] if len(parts) == 1 else plural(len(parts), "part")
        gone = tuple(parts.tolist())
        grip: dict[str, Any] = {"tool": self.hand, "start": None if self.hand is None else self.start}
        with bar(f"{'taking out' if self.ends is None else 'bringing in'} {name}") as progress:
            if self.ends is not None:
                hand: dict[str, Any] = {"tool": self.hand, "grip": grip["start"]}
                found_in = feeler.insertion(self.scene, parts, **self.ends, **hand, **self.options, progress=progress)
                return _Answer(gone, found_in.is_found, (feeler.RemovalStep(gone, found_in),))
            if order:
                found = feeler.removal_order(
                    self.scene,
                    parts,
                    **grip,
                    **self.options,
                    progress=progress,
                    keep=self.keep,
                    executor=executor,
                )
                return _of_order(gone, found)
            one = feeler.removal(self.scene, parts, **grip, **self.options, progress=progress)
        return _of_removal(gone, one)


def _of_removal(parts: tuple[int, ...], found: feeler.Removal, error: str = "") -> _Answer:
    return _Answer(parts, found.is_found, (feeler.RemovalStep(parts, found),), error)


def _of_order(parts: tuple[int, ...], found: feeler.RemovalOrder) -> _Answer:
    return _Answer(parts, found.is_found, found.steps, stuck=found.stuck, blocked_by=found.blocked_by)


def _blocker_facts(mockup: feeler.Mockup, blockers: tuple[feeler.RemovalBlocker, ...]) -> list[dict[str, Any]]:
    return [{"part": each.part, "path": mockup.part_paths[each.part], "count": each.count} for each in blockers]


def _one(
    asked: _Asked, parts: npt.NDArray[np.uint32], order: bool, workers: int | None, dask: str | None
) -> tuple[list[_Answer], bool]:
    """All parts together, until Ctrl-C; and whether that came."""
    from feeler.plan.order import RemovalOrderInterrupted
    from feeler.plan.removal import RemovalInterrupted, not_tried

    gone = tuple(parts.tolist())
    try:
        with executor_of(workers, dask) as executor:
            return [asked.answer(parts, order, executor)], False
    except RemovalInterrupted as stop:
        return [_of_removal(gone, stop.removal)], True
    except RemovalOrderInterrupted as stop:
        steps = stop.order.steps or (feeler.RemovalStep(gone, not_tried(asked.options["seed"])),)
        return [_Answer(gone, False, steps)], True


def _each(asked: _Asked, parts: list[int], workers: int | None, dask: str | None) -> tuple[list[_Answer], bool]:
    """Every part separately, until Ctrl-C; and whether that came."""
    from feeler.plan.removal import not_tried
    from feeler.plan.removals import RemovalsInterrupted

    if workers is not None or dask is not None:
        try:
            with bar(f"taking out {plural(len(parts), 'part')}") as progress, executor_of(workers, dask) as executor:
                entries = [[part] for part in parts]
                rows = feeler.removals(asked.scene, entries, **asked.options, progress=progress, executor=executor)
        except RemovalsInterrupted as stop:
            rows = stop.removals
            if not len(rows):
                raise KeyboardInterrupt from None
        return [_of_removal(row.parts, row.removal, row.error) for row in rows], rows.is_partial
    answers: list[_Answer] = []
    try:
        with bar(f"taking out {plural(len(parts), 'part')}") as progress:
            for number, part in enumerate(parts):
                progress(number / len(parts), asked.scene.mockup.part_paths[part])
                try:
                    answers.append(asked.answer(np.array([part], np.uint32), order=False))
                except MeshError as error:  # nothing of this part can be queried
                    nothing = not_tried(asked.options["seed"], is_out_of_time=False)
                    answers.append(_of_removal((part,), nothing, str(error)))
    except KeyboardInterrupt:
        if not answers:
            raise
        return answers, True
    return answers, False


def _check(
    targets: dict[str, Path | None],
    inputs: list[str],
    part: list[str] | None,
    each: bool,
    order: bool,
    hand: str | None,
) -> None:
    from feeler.cli import outputs

    outputs.check_targets(targets, _ENDINGS, inputs)
    if not part:
        raise OptionError("no part to take out: give --part PATTERN (feeler info --parts lists all)")
    if each and (order or targets["way"] is not None or targets["glb"] is not None or hand is not None):
        raise OptionError("--each is for single parts: leave out --order, --hand, --way and --glb")


def _ends(insert: bool, files: dict[str, Path | None], is_other: bool, snap: bool) -> dict[str, Any] | None:
    """Start and goal of a path in, as `feeler.insertion` takes them."""
    given = {option: file for option, file in files.items() if file is not None}
    if not insert:
        return None
    if is_other:
        raise OptionError("--insert is for one path: leave out --each and --order")
    poses: dict[str, Any] = {}
    for option, file in given.items():
        read = read_poses(file, snap)
        if len(read) > 1:
            raise OptionError(f"{option} {file} has {len(read)} poses: one is needed")
        poses["start" if option == "--from" else "goal"] = read[0]
    return poses


def _write(asked: _Asked, answers: list[_Answer], targets: dict[str, Path | None]) -> dict[str, str]:
    from feeler.atomic import atomic_file

    mockup = asked.scene.mockup
    written = {}
    for kind, target in targets.items():
        last = answers[0].last
        if target is None or (kind == "way" and not last.is_found):
            continue
        with bar(f"writing {target}"):
            if kind == "csv":
                with atomic_file(target) as file:
                    file.write(_csv(mockup, answers))
            elif kind == "way":
                with atomic_file(target) as file:
                    file.write(_way(target, last))
            else:
                from feeler.plan.as_glb import write_removal_glb

                write_removal_glb(target, mockup, answers[0].steps, asked.hand, asked.start)
        written[kind] = str(target)
    return written


def _way(target: Path, removal: feeler.Removal) -> bytes:
    if target.suffix.lower() == ".json":
        import json

        legs = [leg.to_dict() | {"says": str(leg)} for leg in removal.legs]
        return json.dumps({"legs": legs, "poses": removal.poses.tolist()}).encode()
    import io

    out = io.BytesIO()
    np.save(out, removal.poses)
    return out.getvalue()


def _step_facts(mockup: feeler.Mockup, step: feeler.RemovalStep) -> dict[str, Any]:
    one = step.removal
    facts: dict[str, Any] = {
        "parts": [{"part": part, "path": mockup.part_paths[part]} for part in step.parts],
        "found": one.is_found,
        "free": one.is_found,
        "blocked_by": _blocker_facts(mockup, one.blocked_by),
        "held_by": [{"part": part.index, "path": part.path} for part in one.held_by],
        "play_m": one.play,
        "certificate": dataclasses.asdict(one.certificate),
        "seconds": one.seconds,
    }
    if one.is_found:
        facts |= {
            "path_length_m": one.path_length,
            "rotation_rad": one.rotation,
            "clearance_m": one.clearance,
            "legs": [leg.to_dict() | {"says": str(leg)} for leg in one.legs],
            "poses": one.poses,
        }
    return facts


_SAID_LEGS = 5
"""Longer paths are not described leg by leg."""

_COLUMNS = (
    *("part", "path", "step", "found", "free", "way", "poses", "path_length_m", "rotation_deg", "clearance_m"),
    *("blocked_by", "seconds", "error"),
)


def _csv(mockup: feeler.Mockup, answers: list[_Answer]) -> bytes:
    from feeler.io.csv_table import Cell, csv_table

    rows: list[list[Cell]] = []
    for answer in answers:
        for number, step in enumerate(answer.steps, start=1):
            one = step.removal
            measured: tuple[float | None, ...] = (
                (len(one.poses), one.path_length, math.degrees(one.rotation), one.clearance)
                if one.is_found
                else (None, None, None, None)
            )
            blockers = "; ".join(mockup.part_paths[each.part] for each in one.blocked_by)
            for part in step.parts:
                rows.append(
                    [
                        *(part, mockup.part_paths[part], number, int(one.is_found), int(one.is_found), _kind(one)),
                        *(*measured, blockers, float(f"{one.seconds:.4g}"), answer.error),
                    ]
                )
    return csv_table(_COLUMNS, rows)


def _kind(one: feeler.Removal) -> str:
    """The kind of path."""
    if not one.is_found:
        return ""
    return "straight" if len(one.poses) == 2 and one.rotation == 0.0 else "bent"


def _said(one: feeler.Removal) -> str:
    """The path in words."""
    legs = [str(leg) for leg in one.legs]
    if len(legs) > _SAID_LEGS:
        return f"by {len(legs)} legs, the last of them: {legs[-1]}"
    return ", then ".join(legs) if legs else "it is out already"


def _print(mockup: feeler.Mockup, answers: list[_Answer], written: dict[str, str], ends_out: bool) -> None:
    from feeler.cli import outputs

    out = outputs.console()
    steps = [(answer, number, step) for answer in answers for number, step in enumerate(answer.steps, start=1)]
    has_order = any(len(answer.steps) > 1 for answer in answers)
    came = sum(answer.found for answer in answers)
    whole = len(answers) > 1
    if whole:
        outputs.say(out, f"{came:,} of {plural(len(answers), 'part')} come out")
    elif answers[0].found:
        before = len(answers[0].steps) - 1
        after = f" after {plural(before, 'other step')}" if before else ""
        goes = "It comes out" if ends_out else "It goes in"
        out.print(f"[bold green]{goes}[/bold green]{after}: {_said(answers[0].last)}")
    elif answers[0].last.held_by:
        names = ", ".join(part.path for part in answers[0].last.held_by[:_SHOWN_BLOCKERS])
        more = len(answers[0].last.held_by) - _SHOWN_BLOCKERS
        names += f" and {plural(more, 'other part')}" if more > 0 else ""
        play = outputs.length(answers[0].last.play)
        outputs.print_finding(out, f"it is held by {names}: no point of it can move farther than {play}")
    else:
        what = "order" if answers[0].stuck else "path"
        outputs.print_finding(out, f"no {what} was found; that is no proof that there is none")
        if answers[0].stuck:
            outputs.print_finding(out, _stuck_text(mockup, answers[0]))
    out.print()
    outputs.print_table(
        out,
        "Steps" if has_order else "Ways out" if ends_out else "Ways in",
        [
            *([("step", "right")] if has_order else []),
            *(("part", "left"), ("way", "left"), ("length", "right"), ("turned", "right")),
            *(("clearance", "right"), ("blocked by", "left"), ("took", "right")),
        ],
        [
            (*([str(number)] if has_order else []), *_row(mockup, step, answer.error))
            for answer, number, step in steps[: _SHOWN if not whole else 2 * _SHOWN]
        ],
        more=len(steps) - (_SHOWN if not whole else 2 * _SHOWN),
    )
    for answer in [answer for answer in answers if answer.error][:_SHOWN]:
        outputs.print_finding(out, f"not tried: {answer.error}")
    if not whole and not answers[0].found and not answers[0].last.held_by:
        blocked = answers[0].blocked_by or answers[0].last.blocked_by
        outputs.print_table(
            out,
            "What blocked it",
            [("part", "left"), ("attempts stopped", "right")],
            [(mockup.part_paths[each.part], f"{each.count:,}") for each in blocked[:_SHOWN]],
            more=len(blocked) - _SHOWN,
        )
    for kind, target in written.items():
        outputs.say(out, f"{kind} written to {target}")


def _stuck_text(mockup: feeler.Mockup, answer: _Answer) -> str:
    """The parts at which the search for an order ended."""
    names = ", ".join(mockup.part_paths[part] for part in answer.stuck[:_SHOWN_BLOCKERS])
    more = len(answer.stuck) - _SHOWN_BLOCKERS
    names += f" and {plural(more, 'other part')}" if more > 0 else ""
    do = "does" if len(answer.stuck) == 1 else "do"
    return f"the search ended at {names}, which {do} not come out"


def _row(mockup: feeler.Mockup, step: feeler.RemovalStep, error: str) -> tuple[str, ...]:
    from feeler.cli import outputs

    one = step.removal
    first = mockup.part_paths[step.parts[0]]
    name = first if len(step.parts) == 1 else f"{first} and {len(step.parts) - 1:,} more"
    took = outputs.duration(one.seconds)
    if one.is_found:
        if math.isnan(one.clearance):
            clear = "not measured"
        else:
            clear = outputs.length(one.clearance) if math.isfinite(one.clearance) else "nothing near"
        return (
            name,
            _kind(one),
            outputs.length(one.path_length),
            f"{math.degrees(one.rotation):.3g}°",
            clear,
            "",
            took,
        )
    names = [mockup.part_paths[each.part].rpartition("/")[2] for each in one.blocked_by]
    more = f", {len(names) - _SHOWN_BLOCKERS:,} more" if len(names) > _SHOWN_BLOCKERS else ""
    return (
        name,
        "cannot be tried" if error else "not found",
        "",
        "",
        "",
        ", ".join(names[:_SHOWN_BLOCKERS]) + more,
        took,
    )
