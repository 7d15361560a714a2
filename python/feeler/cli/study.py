"""`feeler study ...`: repeats the paper's experiments on the samples or on your own files."""

from __future__ import annotations

import hashlib
from pathlib import Path
from typing import Annotated, Any

import typer

import feeler
from feeler.arguments import check_word
from feeler.choices import STORAGES
from feeler.cli.app import Commands, app, command
from feeler.cli.inputs import Hashing, read_mockup, read_tool
from feeler.cli.values import COUNT, POSES, SEED, UNIT, Number, Whole, Word
from feeler.errors import MissingFileError, OptionError
from feeler.mockup import Mockup, Tool
from feeler.progress import bar
from feeler.samples import sample_names, sample_tool_names
from feeler.study import Plan, Subject, study_filters, study_hashing, study_piece_size, study_scaling, study_voxel_size

study = typer.Typer(
    cls=Commands,
    no_args_is_help=True,
    rich_markup_mode="rich",
    help="Repeats the paper's experiments: voxel size, hashing, scaling, filters. Each writes tables, plots, a page.",
)
app.add_typer(study, name="study")

_STATIC_SIZES = (100_000, 200_000, 400_000, 800_000, 1_600_000, 3_200_000, 6_400_000)

Mockups = Annotated[
    str,
    typer.Option(
        "--mockups", metavar="LIST", help="Split by commas: names of samples, all, or files (several with + are one)."
    ),
]
Tools = Annotated[
    str,
    typer.Option(
        "--tools", metavar="LIST", help="Split by commas: torque, wrench, square, hand (and :fine), all, or files."
    ),
]
Triangles = Annotated[int, typer.Option(help="Size of sample mock-ups."), COUNT]
Poses = Annotated[int, typer.Option(help="Work positions for each pair of mock-up and tool."), POSES]
Rounds = Annotated[int, typer.Option(help="Repetitions of each measurement."), Whole(1, 1_000_000)]
Seed = Annotated[int, typer.Option(help="Another seed, other poses."), SEED]
Out = Annotated[
    Path, typer.Option(metavar="FOLDER", help="Folder for the results; a sub-folder is made for each study.")
]
Resume = Annotated[bool, typer.Option("--resume/--anew", help="Continue with the folder's results, or start anew.")]
Unit = Annotated[str | None, typer.Option(help="Unit of files that do not state one."), UNIT]
Memory = Annotated[
    float,
    typer.Option(help="GB that the largest index may take; finer sizes are skipped."),
    Number(least=0.001, most=1e6),
]
Json = Annotated[bool, typer.Option("--json", help="One JSON document on stdout.")]
Quick = Annotated[bool, typer.Option("--quick", help="A small form, in seconds; its numbers mean little.")]

_OUT = Path("feeler-study")


@command(
    parent=study,
    name="voxel-size",
    examples="""
feeler study voxel-size
feeler study voxel-size --mockups engine,carcass --tools wrench --triangles 400000
feeler study voxel-size --mockups plant.glb --tools gripper.stl --unit mm
""",
)
def voxel_size(
    mockups: Mockups = "all",
    tools: Tools = "all",
    triangles: Triangles = 200_000,
    poses: Poses = 40,
    rounds: Rounds = 15,
    sizes: Annotated[int, typer.Option(help="Voxel sizes to measure for each pair."), Whole(4, 1000)] = 13,
    storage: Annotated[str, typer.Option(help="The index."), Word(("dense", "hashed"))] = "dense",
    hashing: Hashing = 0.0,
    seed: Seed = 0,
    out: Out = _OUT,
    resume: Resume = True,
    unit: Unit = None,
    memory: Memory = 2.0,
    quick: Quick = False,
    as_json: Json = False,
) -> None:
    """Time by voxel size (the paper's Figure 7 and Table 2): the measured optimum and that of each estimator."""
    kind = check_word("--storage", storage, STORAGES)
    plan = _plan("voxel-size", mockups, tools, triangles, poses, rounds, seed, out, resume, unit, memory, quick)
    plan.sizes = 5 if quick else sizes
    _run("voxel-size", plan, as_json, lambda: study_voxel_size(plan, kind, hashing))


@command(
    parent=study,
    examples="feeler study hashing\nfeeler study hashing --mockups engine --tools hand --triangles 1600000",
)
def hashing(
    mockups: Mockups = "carcass,engine",
    tools: Tools = "wrench,hand",
    triangles: Triangles = 200_000,
    poses: Poses = 10,
    rounds: Rounds = 15,
    seed: Seed = 0,
    out: Out = _OUT,
    resume: Resume = True,
    unit: Unit = None,
    memory: Memory = 2.0,
    quick: Quick = False,
    as_json: Json = False,
) -> None:
    """Memory and time by hashing level, 0 to 95 % (Figures 4, 5, 11): dense, hashed and blocks side by side."""
    plan = _plan("hashing", mockups, tools, triangles, poses, rounds, seed, out, resume, unit, memory, quick)
    _run("hashing", plan, as_json, lambda: study_hashing(plan))


@command(parent=study, examples="feeler study scaling\nfeeler study scaling --most 1600000")
def scaling(
    mockups: Mockups = "engine",
    tools: Tools = "wrench,hand",
    triangles: Annotated[int, typer.Option(help="Size of the sample mock-up for tools that grow."), COUNT] = 400_000,
    most: Annotated[int, typer.Option(help="The largest sample mock-up."), COUNT] = 6_400_000,
    poses: Poses = 10,
    rounds: Rounds = 15,
    seed: Seed = 0,
    out: Out = _OUT,
    resume: Resume = True,
    memory: Memory = 3.0,
    quick: Quick = False,
    as_json: Json = False,
) -> None:
    """Time by the mock-up's size, 100 thousand to 6.4 million triangles, and by the tool's (Figures 9 and 10)."""
    plan = _plan("scaling", mockups, tools, triangles, poses, rounds, seed, out, resume, None, memory, quick)
    counts = [count for count in ((20_000, 40_000) if quick else _STATIC_SIZES) if count <= most]
    names = [subject.name for subject in plan.mockups]
    growing = [_mockup(name, count, seed, None) for name in names for count in counts]
    fine = [_tool(f"{name}{kind}", None) for kind in ("", ":fine") for name in sample_tool_names()]
    fixed = [_mockup(name, 20_000 if quick else triangles, seed, None) for name in names]
    by_mockup = [(mockup, tool) for tool in plan.tools for mockup in growing]
    by_tool = [(mockup, tool) for mockup in fixed for tool in (fine[:2] if quick else fine)]
    _run("scaling", plan, as_json, lambda: study_scaling(plan, by_mockup, by_tool))


@command(parent=study, examples="feeler study filters\nfeeler study filters --mockups engine --tools all")
def filters(
    mockups: Mockups = "all",
    tools: Tools = "wrench,hand",
    triangles: Triangles = 200_000,
    poses: Poses = 10,
    rounds: Rounds = 15,
    seed: Seed = 0,
    out: Out = _OUT,
    resume: Resume = True,
    unit: Unit = None,
    memory: Memory = 2.0,
    quick: Quick = False,
    as_json: Json = False,
) -> None:
    """The effect of each filter before the triangle test; the paper reports half the time, together."""
    plan = _plan("filters", mockups, tools, triangles, poses, rounds, seed, out, resume, unit, memory, quick)
    _run("filters", plan, as_json, lambda: study_filters(plan))


@command(parent=study, name="piece-size", examples="feeler study piece-size --mockups engine --tools wrench")
def piece_size(
    mockups: Mockups = "all",
    tools: Tools = "all",
    triangles: Triangles = 200_000,
    poses: Poses = 10,
    rounds: Rounds = 15,
    sizes: Annotated[int, typer.Option(help="Piece sizes to measure for each pair."), Whole(2, 1000)] = 11,
    seed: Seed = 0,
    out: Out = _OUT,
    resume: Resume = True,
    unit: Unit = None,
    quick: Quick = False,
    as_json: Json = False,
) -> None:
    """Not in the paper: the effect of the piece size of blocks, the counterpart of the voxel size."""
    plan = _plan("piece-size", mockups, tools, triangles, poses, rounds, seed, out, resume, unit, 2.0, quick)
    plan.sizes = 3 if quick else sizes
    _run("piece-size", plan, as_json, lambda: study_piece_size(plan))


def _plan(
    name: str,
    mockups: str,
    tools: str,
    triangles: int,
    poses: int,
    rounds: int,
    seed: int,
    out: Path,
    resume: bool,
    unit: str | None,
    memory: float,
    quick: bool,
) -> Plan:
    if quick:
        triangles, poses, rounds = 20_000, min(poses, 3), min(rounds, 2)
    plan = Plan(
        folder=out / name,
        mockups=[_mockup(word, triangles, seed, unit) for word in _words(mockups, "--mockups", sample_names())],
        tools=[_tool(word, unit) for word in _words(tools, "--tools", sample_tool_names())],
        poses=poses,
        rounds=rounds,
        seed=seed,
        resume=resume,
        memory_limit=int(memory * 1e9),
    )
    if quick:
        plan.mockups, plan.tools = plan.mockups[:2], plan.tools[:2]
    return plan


def _words(text: str, option: str, every: tuple[str, ...]) -> list[str]:
    words = [word.strip() for word in text.split(",") if word.strip()]
    if words == ["all"]:
        return list(every)
    if not words:
        raise OptionError(f"{option} is empty: name at least one, or all")
    return list(dict.fromkeys(words))


def _mockup(word: str, triangles: int, seed: int, unit: str | None) -> Subject[Mockup]:
    if word in sample_names():
        return Subject(word, f"sample:{word}:{triangles:09}:0", lambda: feeler.sample(word, triangles))
    paths = word.split("+")
    return Subject(_short_name(paths[0]), _file_key(paths, unit), lambda: read_mockup(paths, unit))


def _tool(word: str, unit: str | None) -> Subject[Tool]:
    name, _, fine = word.partition(":")
    if name in sample_tool_names() and fine in ("", "fine"):
        return Subject(word.replace(":", "-"), f"sample:{word}", lambda: feeler.sample_tool(name, fine=bool(fine)))
    return Subject(_short_name(word), _file_key([word], unit), lambda: read_tool(word, unit))


def _short_name(path: str) -> str:
    """A file's name as a part of other files' names."""
    return "".join(c if c.isalnum() or c in "-_" else "-" for c in Path(path).stem)[:40] or "file"


def _file_key(paths: list[str], unit: str | None) -> str:
    """A key for files, and for states of one file."""
    stamps = []
    for path in paths:
        if path.startswith("sample:"):
            stamps.append(path)
            continue
        try:
            status = Path(path).stat()
        except OSError:
            raise MissingFileError(f"{path} does not exist: give a file, or one of the samples' names") from None
        stamps.append(f"{Path(path).resolve()}:{status.st_size}:{status.st_mtime_ns}")
    return hashlib.sha256(f"{unit}|{'|'.join(stamps)}".encode()).hexdigest()[:16]


def _run(name: str, plan: Plan, as_json: bool, work: Any) -> None:
    from feeler.cli import outputs
    from feeler.study.tables import sections_of

    with bar(f"study of {name}") as progress:
        plan.progress = progress
        results = work()
    if as_json:
        outputs.print_json({**results, "rows": [_slim(row) for row in results["rows"]], "folder": str(plan.folder)})
        return
    out = outputs.console()
    for section in sections_of(results):
        for paragraph in section.text:
            out.print(paragraph, markup=False)
        if section.rows:
            columns = [(heading, "left" if i < section.words else "right") for i, heading in enumerate(section.heading)]
            outputs.print_table(out, section.title, columns, section.rows)
    outputs.say(out, f"Page: {plan.folder / 'index.html'}")


def _slim(value: Any) -> Any:
    """Without the samples, which are in the CSV."""
    if isinstance(value, dict):
        return {key: _slim(item) for key, item in value.items() if key not in ("samples_s", "samples")}
    return [_slim(item) for item in value] if isinstance(value, list) else value
