"""Inputs of the commands: mock-ups, tools and poses, from files, samples and options."""

from __future__ import annotations

import contextlib
import json
import os
from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path
from typing import Annotated, Any, Literal

import numpy as np
import numpy.typing as npt
import typer

import feeler
from feeler.arguments import check_word
from feeler.choices import FAULT_NAMES, SAMPLE_NAMES, SAMPLE_TOOL_NAMES, Fault, SampleName, SampleToolName
from feeler.cli.options import Needs
from feeler.cli.outputs import warn
from feeler.cli.values import (
    LENGTH,
    POSITION,
    POSITIVE_LENGTH,
    SHARE_SAVED,
    STORAGE,
    THREADS,
    TOUCHING,
    TURN,
    UNIT,
    UP,
)
from feeler.errors import LoadError, MissingFileError, OptionError, PoseError
from feeler.io.axes import parse_axis
from feeler.io.text import decoded, name_text, numbers_of, text_of
from feeler.io.units import parse_name
from feeler.poses import not_rigid, one_pose, rotation_xyz
from feeler.progress import Progress, bar

Triple = tuple[float, float, float]
Poses = npt.NDArray[np.float64]

# Options that several commands share, with one help text each.
MockupFiles = Annotated[
    list[str],
    typer.Argument(
        metavar="MOCKUP",
        help="Files or folders (several are one mock-up), a saved scene, or sample:NAME[:TRIANGLES[:SEED[:FAULTS]]].",
    ),
]
MockupFilesOrNone = Annotated[
    list[str] | None,
    typer.Argument(
        metavar="MOCKUP",
        help="Files or folders (several are one mock-up), a saved scene, or sample:NAME[:TRIANGLES[:SEED[:FAULTS]]].",
    ),
]
"""For commands that also start a file to edit, which needs none."""
MockupFilesOrSample = Annotated[
    list[str] | None,
    typer.Argument(
        metavar="[MOCKUP]...",
        help="Files or folders (several are one mock-up), a saved scene, or sample:NAME[:TRIANGLES[:SEED[:FAULTS]]] "
        "(sample:engine).",
    ),
]
ToolFile = Annotated[str | None, typer.Option(metavar="FILE", help="A file, or sample:NAME or sample:NAME:fine.")]
PartOption = Annotated[
    list[str] | None,
    typer.Option(
        metavar="PATTERN",
        help="Use these parts of the mock-up as the tool, in its frame; they leave the mock-up. A path with all below "
        "it, a name, or a pattern such as '*pump*'. Several are allowed, here and below.",
    ),
]
Without = Annotated[list[str] | None, typer.Option(metavar="PATTERN", help="Leave out these parts of the mock-up.")]
Only = Annotated[
    list[str] | None, typer.Option(metavar="PATTERN", help="Leave out all parts of the mock-up but these.")
]
Touching = Annotated[
    Literal["counts", "free"], typer.Option(help="Whether touching and sliding count as collision; free: no."), TOUCHING
]
PoseFile = Annotated[
    Path | None,
    typer.Option(
        help="world_from_tool, metres: a 4 by 4 matrix row by row as JSON, text or .npy. Checks of collision and "
        "clearance also take several, (n, 4, 4), one by one.",
    ),
]
At = Annotated[
    Triple | None,
    typer.Option(help="Position of the origin of the tool or hand; plain numbers: metres."),
    POSITION,
]
Rotate = Annotated[
    Triple | None,
    typer.Option(help="Angles about the mock-up's x, then y, then z axis (fixed axes); plain numbers: degrees."),
    TURN,
]
MockupUnit = Annotated[
    str | None,
    typer.Option(
        help="Unit of the mock-up's numbers; overrides its files: mm (default if they do not say), cm, m, in, ..."
    ),
    UNIT,
]
ToolUnit = Annotated[str | None, typer.Option(help="Unit of the tool's or hand's numbers; overrides its file."), UNIT]
SnapPose = Annotated[
    bool, typer.Option("--snap-pose", help="Replace poses that rounding made non-rigid by the nearest rigid ones.")
]
Up = Annotated[
    str | None,
    typer.Option(help="The up axis: files with a known other up axis are turned to it."),
    UP,
]
ChordTolerance = Annotated[
    float | None,
    typer.Option("--chord-tolerance", help="STEP: how far triangles may be from their surface. Default: 0.1mm."),
    POSITIVE_LENGTH,
]
VoxelSize = Annotated[
    float | None,
    typer.Option(help="Size of a voxel; of a piece for --storage blocks. Default: predicted."),
    POSITIVE_LENGTH,
]
Storage = Annotated[str, typer.Option(help="The index."), STORAGE]
Hashing = Annotated[
    float,
    typer.Option(help="For --storage hashed: share of memory saved, 0 to 0.99."),
    SHARE_SAVED,
    Needs("--storage hashed"),
]
Context = Annotated[
    float | None,
    typer.Option(help="In --glb, only the parts listed and those nearer to the tool than this."),
    LENGTH,
    Needs("--glb"),
]
Threads = Annotated[int | None, typer.Option(help="Default: all cores."), THREADS]
BuildThreads = Annotated[int | None, typer.Option(help="For the build; default: all cores."), THREADS]
AsJson = Annotated[bool, typer.Option("--json", help="One JSON document on stdout.")]

_SAMPLE = "sample:"
_DEFAULT_TRIANGLES = 100_000


@dataclass(frozen=True)
class Choice:
    """The parts of the mock-up that move, stay and are left out."""

    part: list[str] | None
    without: list[str] | None
    only: list[str] | None

    def scene_of(self, scene: feeler.Scene) -> feeler.Scene:
        """The scene with the parts that stay."""
        chosen = scene
        for option, parts, select in (
            ("--only", self.only, feeler.Scene.only),
            ("--without", self.without, feeler.Scene.without),
            ("--part", self.part, feeler.Scene.without),
        ):
            if parts:
                with _named(option):
                    chosen = select(chosen, parts)
        if not chosen.part_mask.any():
            raise OptionError("no part of the mock-up is left: let --part, --only and --without leave at least one")
        chosen.build_seconds = scene.build_seconds  # the index is that scene's
        return chosen


def read_checked(
    mockup: list[str], unit: str | None, up: str | None, chord_tolerance: float | None = None
) -> feeler.Mockup:
    """The mock-up of a check. Prints doubts about it to stderr, a line each."""
    world = read_mockup(mockup, unit, up, chord_tolerance=chord_tolerance)
    warn_of_doubts(world)
    return world


def needed(mockup: list[str] | None) -> list[str]:
    """The files of a mock-up. Raises `OptionError` if there are none."""
    if not mockup:
        raise OptionError("there is no mock-up: give its files, or sample:gearbox")
    return mockup


def indexed(
    world: feeler.Mockup, without: list[str] | None, only: list[str] | None, threads: int | None
) -> feeler.Scene:
    """The scene of a check, with the parts that stay."""
    with bar("indexing") as progress:
        scene = feeler.Scene(world, threads=threads, progress=progress)
    return Choice(None, without, only).scene_of(scene) if without or only else scene


@contextlib.contextmanager
def _named(option: str) -> Iterator[None]:
    """Puts the option in front of errors about its parts."""
    try:
        yield
    except OptionError as error:
        raise OptionError(f"{option}: {error} (feeler info --parts lists all)") from None


def read_both(
    mockup: list[str],
    unit: str | None,
    tool: str | None,
    tool_unit: str | None,
    up: str | None,
    part: list[str] | None = None,
    hand: str | None = None,
) -> tuple[feeler.Mockup, feeler.Tool]:
    """Mock-up and tool; the tool may be parts of the mock-up. hand: what else is in the tool's unit.

    Prints doubts about them to stderr, a line each.
    """
    check_moving(tool, tool_unit, part, hand)
    world = read_mockup(mockup, unit, up)
    if tool is None:
        with _named("--part"):
            probe = feeler.Tool.of_parts(world, part)
    else:
        probe = read_tool(tool, tool_unit, up)
    doubts = [f"mock-up: {doubt}" for doubt in world.source.doubts]
    doubts += [f"tool: {doubt}" for doubt in probe.source.doubts if tool is not None]
    ours, theirs = world.source.up, probe.source.up
    if ours and theirs and ours != theirs:
        doubts.append(
            f"the mock-up has {ours} up and the tool {theirs}; to turn the tool the same way, pass --up {ours}"
        )
    for doubt in doubts:
        warn(doubt)
    return world, probe


_FAR = 10.0
"""If mock-up and tool are this many sizes apart, poses are probably not in metres."""


def warn_of_far_poses(world: feeler.Mockup, probe: feeler.Tool, poses: Poses) -> None:
    """Warns on stderr if poses are far from the mock-up: the first may be its own place, which is 0 in any unit."""
    lower, upper = world.bounds
    middle, reach = probe.bounds.mean(axis=0), 0.5 * float(np.linalg.norm(probe.bounds[1] - probe.bounds[0]))
    places = poses[:, :3, :3] @ middle + poses[:, :3, 3]
    gaps = np.linalg.norm(np.maximum(0.0, np.maximum(lower - places, places - upper)), axis=1) - reach
    size = float(np.linalg.norm(upper - lower))
    far = gaps[gaps > _FAR * (size + 2.0 * reach)]
    if not len(far):
        return
    if len(far) == len(gaps):
        warn(f"the tool is at least {far.min():.3g} m from a mock-up of {size:.2g} m: poses are in metres")
    else:
        warn(
            f"in {len(far):,} of {len(gaps):,} poses the tool is up to {far.max():.3g} m from a mock-up of {size:.2g} "
            "m: poses are in metres"
        )


def check_moving(tool: str | None, tool_unit: str | None, part: list[str] | None, hand: str | None = None) -> None:
    """Checks that exactly one moving body is given."""
    if (tool is None) == (not part):
        said = (
            "--tool and --part are both given: one of them moves; leave the other out"
            if part
            else ("nothing moves: give --tool FILE, or --part PATTERN for parts of the mock-up")
        )
        raise OptionError(said)
    if tool is None and tool_unit is not None:
        raise OptionError("--tool-unit is for --tool FILE: parts of the mock-up are in its unit, --unit")
    if tool is not None:
        check_unit("--tool-unit", tool_unit, *filter(None, (tool, hand)))


def check_unit(option: str, unit: str | None, *sources: str) -> None:
    """Checks that no unit is given for samples alone. Raises `OptionError`."""
    if unit is not None and sources and all(source.startswith(_SAMPLE) for source in sources):
        raise OptionError(f"{option} is for files: {sources[0]} is made in metres")


@contextlib.contextmanager
def telling(label: str, also: Progress | None = None) -> Iterator[Progress]:
    """`bar(label)` for the terminal, and a second receiver of the same progress."""
    with bar(label) as show:

        def report(fraction: float, stage: str = "") -> None:
            show(fraction, stage)
            if also is not None:
                also(fraction, stage or label)

        yield report


def warn_of_doubts(mesh: feeler.Mockup | feeler.Tool, what: str = "mock-up") -> None:
    """What puts answers about a mesh in doubt, on stderr, a line each."""
    for doubt in mesh.source.doubts:
        warn(f"{what}: {doubt}")


def check_sources(mockup: list[str], tool: str | None) -> None:
    """Checks, without reading them, that the files are there, and that samples have names that there are."""
    from feeler.io.load import check_files

    if any(source.startswith(_SAMPLE) for source in mockup):
        _sample_of(mockup)
    else:
        check_files(mockup)
    if tool is not None and tool.startswith(_SAMPLE):
        _sample_tool_of(tool)
    elif tool is not None:
        check_files(tool)


def read_mockup(
    sources: list[str],
    unit: str | None = None,
    up: str | None = None,
    *,
    chord_tolerance: float | None = None,
    also: Progress | None = None,
) -> feeler.Mockup:
    """A mock-up from files or folders (several are one mock-up), or from `sample:NAME[:TRIANGLES[:SEED[:FAULTS]]]`,
    whose faults are names with commas between them; an empty word is the default.

    also: a second receiver of the progress.
    """
    if any(source.startswith(_SAMPLE) for source in sources):
        sample, count, seed, faults = _sample_of(sources)
        check_unit("--unit", unit, sources[0])
        if chord_tolerance is not None:
            raise OptionError(f"--chord-tolerance is for STEP files: {sources[0]} is made of triangles")
        with telling(f"making {sample}", also) as progress:
            mockup = feeler.sample(sample, count, seed=seed, faults=faults, progress=progress)
        axis, wanted = mockup.source.up, parse_axis(up)
        if axis and wanted not in (None, axis):
            raise OptionError(f"--up: {wanted} is not the axis of {sources[0]}, which has {axis} up")
        return mockup
    with telling("loading mock-up", also) as progress:
        given = sources if len(sources) > 1 else sources[0]
        mockup = feeler.load_mockup(
            given, parse_name(unit), up=parse_axis(up), chord_tolerance=chord_tolerance, progress=progress
        )
    if mockup._saved and (absent := mockup._saved.core.absent_parts):
        shown = ", ".join(mockup.part_paths[part] for part in absent[:3]) + (", ..." if len(absent) > 3 else "")
        warn(f"the scene was saved without {len(absent):,} of its parts, which are there again: {shown}")
    return mockup


def _sample_of(sources: list[str]) -> tuple[SampleName, int, int, list[Fault]]:
    """The name, the triangles, the seed and the faults of the one sample that is given."""
    if len(sources) > 1:
        raise OptionError(f"{', '.join(sources)}: a sample cannot be combined with other input")
    name, triangles, seed, faults = _sample_words(sources[0], ("", str(_DEFAULT_TRIANGLES), "0", ""))
    count, arrangement = _whole(triangles, "triangles", sources[0]), _whole(seed, "seed", sources[0])
    return check_word("the sample", name, SAMPLE_NAMES), count, arrangement, faults_of([faults], "the fault")


def faults_of(words: list[str], what: str) -> list[Fault]:
    """The faults that words name, with commas between them. Raises `OptionError` for unknown ones."""
    return [check_word(what, name.strip(), FAULT_NAMES) for word in words for name in word.split(",") if name.strip()]


def read_tool(source: str, unit: str | None = None, up: str | None = None) -> feeler.Tool:
    """A tool from a file, or from `sample:NAME` or `sample:NAME:fine`."""
    if source.startswith(_SAMPLE):
        name, is_fine = _sample_tool_of(source)
        return feeler.sample_tool(name, fine=is_fine)
    with bar("loading tool") as progress:
        return feeler.load_tool(source, parse_name(unit), up=parse_axis(up), progress=progress)


def _sample_tool_of(source: str) -> tuple[SampleToolName, bool]:
    name, fine = _sample_words(source, ("", ""))
    if fine not in ("", "fine"):
        raise OptionError(f"{source}: expected sample:NAME or sample:NAME:fine")
    return check_word("the sample tool", name, SAMPLE_TOOL_NAMES), fine == "fine"


def poses_of_options(
    pose: Path | None, at: Triple | None, rotate: Triple | None, snap: bool = False, has_place: bool = False
) -> Poses:
    """The poses, (n, 4, 4), of --pose, or of --at and --rotate; with `snap` the nearest rigid ones.

    has_place: the moving body has a place in the mock-up, which is the default.
    """
    if pose is not None:
        if at is not None or rotate is not None:
            raise OptionError("--pose and --at/--rotate exclude each other: give one of them")
        return read_poses(pose, snap)
    if at is None and rotate is None and not has_place:
        raise OptionError("the tool has no pose: give --pose FILE, or --at X,Y,Z (and --rotate RX,RY,RZ)")
    matrix = np.eye(4)
    matrix[:3, 3] = at if at is not None else 0.0
    if rotate is not None:
        matrix[:3, :3] = rotation_xyz(*rotate)
    return matrix[None]


def read_poses(path: Path, snap: bool = False) -> Poses:
    """Poses world_from_tool, metres, (n, 4, 4), from a file; with `snap` the nearest rigid ones.

    `.npy`: (4, 4) or (n, 4, 4). `.json`: such an array as lists, alone or under "world_from_tool", "pose" or "poses".
    Anything else: 16 numbers a pose, row by row, split by blanks, commas, semicolons or lines, with decimal points or
    commas; `#` begins a comment.
    Raises `MissingFileError`, `PoseError`.
    """
    if not os.path.isfile(path):  # Path.is_file raises for names that are too long
        what = "is a folder" if os.path.isdir(path) else "does not exist"
        raise MissingFileError(f"pose file {path} {what}: give a .json, .npy or text file")
    try:
        if path.suffix.lower() == ".npy":
            values = np.load(path, allow_pickle=False)
        elif path.suffix.lower() == ".json":
            values = _from_json(json.loads(text_of(path)))
        else:
            values = _from_text(name_text(decoded(path.read_bytes())))
        poses = np.asarray(values, dtype=np.float64)
    except LoadError as error:
        raise PoseError(f"pose file {error}") from None
    except (ValueError, TypeError, EOFError, RecursionError) as error:
        raise PoseError(f"pose file {path} cannot be read: {error}; {_EXPECTED}") from None
    except OSError as error:
        raise PoseError(f"pose file {path} cannot be read: {error.strerror or error}") from None
    if poses.shape == (4, 4):
        poses = poses[None]
    if poses.ndim != 3 or poses.shape[1:] != (4, 4):
        raise PoseError(f"pose file {path} holds an array of shape {poses.shape}; {_EXPECTED}")
    if len(poses) == 0:
        raise PoseError(f"pose file {path} holds no pose; {_EXPECTED}")
    with _of_pose_file(path):
        if snap:
            return feeler.nearest_rigid(poses)
        _check_rigid(poses, "poses[{}]: " if len(poses) > 1 else "")
    return poses


def read_path(path: Path, snap: bool = False) -> Poses | list[Poses | feeler.Screw]:
    """A path as `Scene.check_path` takes it: as `read_poses`, or the legs of a way, screws among them, from JSON.

    Raises the errors of `read_poses`.
    """
    legs = None
    if path.suffix.lower() == ".json" and os.path.isfile(path):
        try:
            document = json.loads(text_of(path))
            legs = document.get("legs") if isinstance(document, dict) else None
            if legs is not None:
                from feeler.plan.legs import path_of_json

                with _of_pose_file(path):
                    way = path_of_json(legs)
        except LoadError as error:
            raise PoseError(f"pose file {error}") from None
        except (ValueError, TypeError, RecursionError) as error:
            raise PoseError(f"pose file {path} cannot be read: {error}; {_EXPECTED}") from None
    if legs is None:
        return read_poses(path, snap)
    with _of_pose_file(path):
        if snap:
            return [feeler.nearest_rigid(each) if isinstance(each, np.ndarray) else each for each in way]
        for number, each in enumerate(way[1:]):
            if isinstance(each, np.ndarray):
                _check_rigid(one_pose(each)[None], f"legs[{number}]: ")
    return way


def _check_rigid(poses: Poses, which: str) -> None:
    """Checks the poses as queries do, and in their words. which: before these, with the index. Raises `PoseError`."""
    bad = not_rigid(poses)
    if bad is None:
        return
    try:
        feeler.Slide((0.0, 0.0, 1.0)).at(poses[bad], 0.0)
    except PoseError as error:
        raise PoseError(f"{which.format(bad)}{error}") from None


@contextlib.contextmanager
def _of_pose_file(path: Path) -> Iterator[None]:
    """Adds the name of the file to errors about its content."""
    try:
        yield
    except (PoseError, OptionError) as error:
        raise PoseError(f"pose file {path}: {error}") from None


_EXPECTED = "a pose is 4 by 4 numbers, world_from_tool, metres, row by row; several are (n, 4, 4)"


def _from_json(document: Any) -> Any:
    if isinstance(document, dict):
        for key in ("world_from_tool", "pose", "poses"):
            if key in document:
                return document[key]
        raise ValueError('no "world_from_tool", "pose" or "poses" in it')
    return document


def _from_text(text: str) -> npt.NDArray[np.float64]:
    plain = "\n".join(line.partition("#")[0] for line in text.splitlines())
    return np.array(numbers_of(plain, 16, "poses")).reshape(-1, 4, 4)


def _sample_words(source: str, defaults: tuple[str, ...]) -> list[str]:
    words = source[len(_SAMPLE) :].split(":")
    if not words[0] or len(words) > len(defaults):
        raise OptionError(
            f"{source}: expected sample:NAME[:TRIANGLES[:SEED[:FAULTS]]] for a mock-up, sample:NAME[:fine] for a tool"
        )
    words += [""] * (len(defaults) - len(words))
    return [word or default for word, default in zip(words, defaults, strict=True)]


def _whole(text: str, what: str, source: str) -> int:
    try:
        return int(text.replace("_", ""))
    except ValueError:
        raise OptionError(f"{source}: {what} is {text!r}; give a whole number") from None
