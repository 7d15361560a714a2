"""`feeler move`: how far do joints move, and how near do parts come on the way?"""

from __future__ import annotations

import math
from pathlib import Path
from typing import Annotated, Any, Literal

import typer

import feeler
from feeler.cli.app import FOUND, command
from feeler.cli.findings import mesh_facts
from feeler.cli.inputs import AsJson, MockupUnit, Threads, Up, indexed, read_checked, warn_of_doubts
from feeler.cli.options import Ends, Needs
from feeler.cli.values import ANGLE, ANY_LENGTH, LENGTH, POSITIVE_LENGTH
from feeler.errors import OptionError
from feeler.progress import bar
from feeler.words import plural

Files = Annotated[
    list[str],
    typer.Argument(
        metavar="MOCKUP",
        help="Files or folders (several are one mock-up), a saved scene, or sample:NAME[:TRIANGLES[:SEED[:FAULTS]]]. "
        "A robot (URDF) brings its joints; the other files stand around it.",
    ),
]

_First = tuple[dict[str, float], "feeler.MechanismContact"]
"""The given numbers of a position, and what meets there."""


_OF_A_RANGE = Needs("--joint", "--animation")


@command(
    examples="""
feeler move engine.step --mechanism cowl.toml
feeler move engine.step --mechanism cowl.toml --joint hinge=0:110 --require 3mm
feeler move engine.step --mechanism cowl.toml --joint hinge=0:1.9rad --csv gaps.csv --glb worst.glb --json
feeler move engine.step --write-mechanism cowl.toml --child '*cowl*' --parent '*frame*'
feeler move arm.urdf cell.step --joint shoulder=-30:60 --joint elbow=15 --film arm.glb
feeler move press.glb --animation close --require 2mm
"""
)
def move(
    mockup: Files,
    *,
    mechanism: Annotated[Path | None, typer.Option(help="Joints of the parts that move (TOML).")] = None,
    joint: Annotated[
        list[str] | None,
        typer.Option(
            metavar="NAME=FROM:TO",
            help="Move a joint over a range, or keep it at NAME=VALUE. Angles are degrees (110, 110deg, 1.9rad), "
            "slides are lengths. Default: how far each joint moves freely.",
        ),
    ] = None,
    animation: Annotated[
        str | None, typer.Option(metavar="NAME", help="Move the parts of a glTF file by its animation, or its number.")
    ] = None,
    require: Annotated[
        float | None, typer.Option(help="The gap that must hold at all positions."), LENGTH, _OF_A_RANGE
    ] = None,
    error: Annotated[
        float, typer.Option(help="How near the bounds of the gap come."), POSITIVE_LENGTH, _OF_A_RANGE
    ] = 1e-4,
    geometry: Annotated[
        Literal["collision", "visual"] | None, typer.Option(help="Which geometry of a robot. Default: collision.")
    ] = None,
    package_dir: Annotated[
        list[Path] | None, typer.Option(help="A folder with packages that a robot's meshes are in.")
    ] = None,
    write_mechanism: Annotated[
        Path | None,
        typer.Option(
            help="Write a new file of joints, and end: those of --child, or one to fill in. It must not exist yet."
        ),
        Ends("--child", "--parent", "--unit", "--up", "--json"),
    ] = None,
    child: Annotated[
        list[str] | None,
        typer.Option(metavar="PATTERN", help="Find the joint of these parts from their surfaces. Several are allowed."),
        Needs("--write-mechanism"),
    ] = None,
    parent: Annotated[
        list[str] | None,
        typer.Option(
            metavar="PATTERN",
            help="The parts that a --child moves on: one for each, or one for all. Default: all that do not move.",
        ),
        Needs("--child"),
    ] = None,
    csv: Annotated[
        Path | None, typer.Option(help="Write the gap over the range of one joint (CSV)."), _OF_A_RANGE
    ] = None,
    glb: Annotated[
        Path | None,
        typer.Option(help="Write the worst position, with both parts and their closest points (GLB)."),
        _OF_A_RANGE,
    ] = None,
    film: Annotated[
        Path | None, typer.Option(help="Write the motion of one joint as an animation (GLB)."), Needs("--joint")
    ] = None,
    unit: MockupUnit = None,
    up: Up = None,
    threads: Threads = None,
    as_json: AsJson = False,
) -> None:
    """Moves parts by their joints, and bounds the least gap over all positions.

    Without --joint: the free range of each joint, and what it meets first.
    Exit status: 0 the lower bound of the gap is more than 0, and at least --require; 1 it is not, 2 bad input.
    """
    from feeler.cli import outputs

    targets = {"csv": csv, "glb": glb, "film": film, "write-mechanism": write_mechanism}
    endings = {"csv": (".csv",), "glb": (".glb",), "film": (".glb",), "write-mechanism": (".toml",)}
    outputs.check_targets(targets, endings, mockup)
    robots = [name for name in mockup if name.lower().endswith(".urdf")]
    given = {"--mechanism": mechanism, "--write-mechanism": write_mechanism, "--animation": animation}
    ways = [name for name, value in given.items() if value is not None] + robots
    if not ways:
        raise OptionError(
            "nothing says what moves: give --mechanism with a file of joints, --write-mechanism to start one, "
            "--animation of a glTF file, or a robot (.urdf)"
        )
    if len(ways) > 1:
        raise OptionError(f"{' and '.join(ways)} both say what moves: give one")
    if not robots and (geometry is not None or package_dir):
        raise OptionError("--geometry and --package-dir are of a robot: give a .urdf file")
    if animation is not None:
        if joint or film:
            raise OptionError("--joint and --film are of joints, and an animation has its own motion: leave them out")
        _over_time(mockup, animation, unit, up, require, error, csv, glb, as_json)
        return
    if write_mechanism is not None:
        from feeler.cli.move_start import write

        world = read_checked(mockup, unit, up)
        said = write(write_mechanism, world, child or [], parent or [])
        if as_json:
            outputs.print_json({"mockup": mesh_facts(world), **said, "written": {"mechanism": str(write_mechanism)}})
        return
    if robots:
        moved = _robot(robots[0], [name for name in mockup if name != robots[0]], unit, up, geometry, package_dir)
        world = moved.mockup
    else:
        assert mechanism is not None
        world = read_checked(mockup, unit, up)
        moved = feeler.Mechanism.load(mechanism, world, indexed(world, None, None, threads))
    if joint:
        ranges = _asked(moved, joint)
        _check_one(ranges, csv, film)
        with bar("bounding the gap"):
            found = moved.clearance(ranges, error=error)
        from feeler.cli.move_glb import write_film, write_worst

        written = {}
        if glb is not None:
            written["glb"] = write_worst(glb, moved.scene(found.worst).mockup, found)
        if film is not None:
            written["film"] = write_film(film, moved, ranges, found)
        if csv is not None:
            name = next(name for name, value in ranges.items() if isinstance(value, tuple))
            written["csv"] = _write_csv(csv, f"{name}_{'rad' if _turns(moved)[name] else 'm'}", found)
        _tell(moved, found, require, written, world, as_json, _first(moved, ranges, found))
        return
    rows, failed = [], []
    with bar("moving") as progress:
        for number, name in enumerate(moved.names):
            progress(number / len(moved.names), name)
            try:
                rows.append(moved.range(name))
            except feeler.MechanismError as error:
                failed.append(f"{name}: {error}")
    if as_json:
        facts = {"ranges": [each.to_dict() for each in rows], "failed": failed}
        outputs.print_json({"mockup": mesh_facts(world), **facts})
    else:
        for each in rows:
            _print_range(moved, each)
    if failed:
        raise feeler.MechanismError("; ".join(failed))


def _robot(
    robot: str,
    others: list[str],
    unit: str | None,
    up: str | None,
    geometry: Literal["collision", "visual"] | None,
    package_dir: list[Path] | None,
) -> feeler.Mechanism:
    around = read_checked(others, unit, up) if others else None
    with bar("loading robot"):
        moved = feeler.Mechanism.from_urdf(
            robot, geometry=geometry or "collision", package_dirs=package_dir or (), around=around
        )
    warn_of_doubts(moved.mockup)
    return moved


def _turns(moved: feeler.Mechanism) -> dict[str, bool]:
    return {name: turns for each in moved.joints for name, turns in zip(each.names, each.turns, strict=True)}


def _asked(moved: feeler.Mechanism, given: list[str]) -> dict[str, float | tuple[float, float]]:
    """The numbers and ranges of --joint: radians and metres."""
    turns = _turns(moved)
    found: dict[str, float | tuple[float, float]] = {}
    for text in given:
        name, sign, value = text.partition("=")
        if not sign or name not in turns:
            raise OptionError(f"--joint {text!r}: give NAME=FROM:TO, such as hinge=0:110; joints: {', '.join(turns)}")
        if name in found:
            raise OptionError(f"--joint gives {name!r} twice: give it once")
        kind = ANGLE if turns[name] else ANY_LENGTH
        try:
            numbers = [float(kind.read(each)) for each in value.split(":")]
        except ValueError as wrong:
            raise OptionError(f"--joint {text!r}: {wrong}") from None
        numbers = [math.radians(each) if turns[name] else each for each in numbers]
        if len(numbers) > 2:
            raise OptionError(f"--joint {text!r}: give NAME=FROM:TO, or NAME=VALUE")
        found[name] = numbers[0] if len(numbers) == 1 else (numbers[0], numbers[1])
    return found


def _check_one(ranges: dict[str, float | tuple[float, float]], csv: Path | None, film: Path | None) -> None:
    moving = [name for name, value in ranges.items() if isinstance(value, tuple)]
    for option, target in (("--csv", csv), ("--film", film)):
        if target is not None and len(moving) > 1:
            raise OptionError(f"{option} shows one joint that moves, and {', '.join(moving)} do: keep all but one")
        if target is not None and not moving:
            raise OptionError(f"{option} shows one joint that moves, and none does: give a range, such as NAME=FROM:TO")


def _first(
    moved: feeler.Mechanism, ranges: dict[str, float | tuple[float, float]], found: feeler.MechanismClearance
) -> _First | None:
    """Where the one joint that moves first meets something."""
    moving = [name for name, value in ranges.items() if isinstance(value, tuple)]
    met = moved.clash(ranges).contacts[:1] if len(moving) == 1 and found.upper == 0.0 else ()
    if not met:
        return None
    return {name: met[0].value if isinstance(value, tuple) else value for name, value in ranges.items()}, met[0]


def _write_csv(path: Path, column: str, found: feeler.MechanismClearance) -> str:
    from feeler.atomic import atomic_file
    from feeler.io.csv_table import csv_table

    with atomic_file(path, ".csv") as file:
        file.write(csv_table([column, "gap_m", "lower_m"], found.curve.tolist()))
    return str(path)


def _over_time(
    mockup: list[str],
    animation: str,
    unit: str | None,
    up: str | None,
    require: float | None,
    error: float,
    csv: Path | None,
    glb: Path | None,
    as_json: bool,
) -> None:
    """The motion of a glTF file."""
    from feeler.cli.move_glb import write_worst
    from feeler.io.axes import parse_axis

    if len(mockup) != 1 or unit is not None:
        raise OptionError("an animation is of one glTF file, which is in metres: give it alone, without --unit")
    which = int(animation) if animation.isdecimal() else animation
    with bar("loading") as progress:
        tracks = feeler.load_tracks(mockup[0], which, up=parse_axis(up), progress=progress)
    warn_of_doubts(tracks.mockup)
    with bar("bounding the gap"):
        found = tracks.clearance(error)
    written = {}
    if glb is not None:
        written["glb"] = write_worst(glb, tracks.scene(found.worst["time"]).mockup, found)
    if csv is not None:
        written["csv"] = _write_csv(csv, "time_s", found)
    met = tracks.clash().contacts[:1] if found.upper == 0.0 else ()
    first = ({"time": met[0].value}, met[0]) if met else None
    _tell(None, found, require, written, tracks.mockup, as_json, first)


def _tell(
    moved: feeler.Mechanism | None,
    found: feeler.MechanismClearance,
    require: float | None,
    written: dict[str, str],
    world: feeler.Mockup,
    as_json: bool,
    first: _First | None,
) -> None:
    """Prints a clearance, and ends with its exit status. moved: None for an animation. first: where parts meet first,
    if they do."""
    from feeler.cli import outputs

    holds = found.lower > 0.0 and found.lower >= (require or 0.0)
    is_open = found.upper > 0.0 and found.upper >= (require or 0.0)
    if as_json:
        facts = {"holds": holds, "require_m": require, **found.to_dict(), "written": written}
        facts["first"] = first[1].to_dict() if first else None
        outputs.print_json({"mockup": mesh_facts(world), **facts})
    else:
        out = outputs.console()
        said = "holds" if holds else "not proven to hold" if is_open else "does not hold"
        outputs.say(out, f"{said}: {_gap(found)}")
        if not holds and is_open and found.is_certified:
            outputs.say(out, "  give a smaller --error")
        if first:
            at, met = first
            outputs.say(out, f"they first meet at {_position(moved, at)}: {met.path} and {met.other_path}")
        elif found.path:
            outputs.say(out, f"worst at {_position(moved, found.worst)}: {found.path} to {found.other_path}")
        for jam in found.jams:
            outputs.say(out, f"  {jam.path} jams in {jam.other_path}")
        if found.undecided and found.is_certified:
            outputs.say(out, f"undecided at {100 * found.undecided:.3g} % of the positions")
        _print_seats(out, found.seats, "as modelled" if moved else "at the start")
        for kind, target in written.items():
            outputs.say(out, f"{kind} written to {target}")
    if not holds:
        raise typer.Exit(FOUND)


def _gap(found: feeler.MechanismClearance) -> str:
    from feeler.cli.outputs import length

    if found.upper == 0.0:
        return "parts meet"
    is_near = math.isfinite(found.upper)
    if not found.is_certified and found.lower == 0.0:
        why = "near a dead point of a loop" if len(found.curve) else "of parts in contact that several joints move"
        most = f"the least gap is at most {length(found.upper)}" if is_near else "nothing is near where it was tried"
        return f"{most}; no lower bound is proven {why}"
    if not is_near:
        return "nothing is near"
    bounds = f"the least gap is {length(found.lower)} to {length(found.upper)}"
    return bounds if found.is_certified else f"{bounds}; parts in contact are followed in small steps of the loop"


def _value(moved: feeler.Mechanism | None, name: str, value: float) -> str:
    from feeler.cli.outputs import length

    if moved is None:
        return f"{value:.6g} s"
    return f"{math.degrees(value):.6g} degrees" if _turns(moved)[name] else length(value)


def _position(moved: feeler.Mechanism | None, values: dict[str, float]) -> str:
    return ", ".join(f"{name} = {_value(moved, name, value)}" for name, value in values.items())


def _print_range(moved: feeler.Mechanism, found: feeler.Range) -> None:
    from feeler.cli import outputs

    out = outputs.console()
    ends = f"{_value(moved, found.joint, found.lower)} to {_value(moved, found.joint, found.upper)}"
    outputs.say(out, f"{found.joint}: free from {ends}")
    for where, met in (("below", found.below), ("above", found.above)):
        if met is not None:
            outputs.say(out, f"  {where}: {met.path} meets {met.other_path}")
    if found.ended:
        outputs.say(out, f"  {found.ended}")
    _print_seats(out, found.seats)


def _print_seats(out: Any, seats: tuple[feeler.MechanismSeat, ...], where: str = "as modelled") -> None:
    from feeler.cli import outputs

    if seats:
        first = f"{seats[0].path} and {seats[0].other_path}"
        count = plural(len(seats), "pair")
        outputs.say(out, f"  {count} of parts in contact {where}: {first}{', ...' if seats[1:] else ''}")
