"""`feeler sample`: built-in mock-ups and tools to try feeler on."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated, Any

import typer

import feeler
from feeler.arguments import check_word
from feeler.choices import FAULT_NAMES
from feeler.cli.app import command
from feeler.cli.inputs import AsJson, faults_of
from feeler.cli.options import given_of
from feeler.cli.values import COUNT, SEED
from feeler.errors import OptionError
from feeler.progress import bar


@command(
    examples="""
feeler sample
feeler sample engine --triangles 1600000 --out engine.glb
feeler sample gearbox --out gearbox.glb --truth gearbox.json
feeler sample gearbox --fault pipe_clash,blocked_bolt --out faulty.glb
feeler sample wrench --fine --out wrench.stl
"""
)
def sample(
    context: typer.Context,
    *,
    name: Annotated[
        str | None, typer.Argument(metavar="[NAME]", help="Mock-up or tool; without it all names are listed.")
    ] = None,
    triangles: Annotated[int, typer.Option(help="Size of a mock-up; the gearbox has 40000 or more."), COUNT] = 100_000,
    seed: Annotated[int, typer.Option(help="Another seed, another arrangement of the same mock-up."), SEED] = 0,
    fine: Annotated[bool, typer.Option("--fine", help="A tool of about 50 thousand triangles.")] = False,
    fault: Annotated[
        list[str] | None,
        typer.Option(
            metavar="NAME,...",
            help=f"Plant faults in the gearbox: {', '.join(FAULT_NAMES)}. In other commands: "
            "sample:gearbox:TRIANGLES:SEED:NAME,...",
        ),
    ] = None,
    truth: Annotated[
        Path | None, typer.Option(help="Write the known facts of the gearbox: fits, removal order, tools (JSON).")
    ] = None,
    out: Annotated[
        Path | None, typer.Option(help="Write it: .glb keeps parts and colours, .stl is one mesh in millimetres.")
    ] = None,
    as_json: AsJson = False,
) -> None:
    """Makes a built-in mock-up or tool, the same on every machine."""
    from feeler.atomic import atomic_file
    from feeler.cli import outputs
    from feeler.samples import sample_names, sample_tool_names

    told = given_of(context)
    mockups, tools = sample_names(), sample_tool_names()
    given = [f"--{option}" for option in ("triangles", "seed", "fine", "fault", "truth", "out") if option in told]
    if name is None:
        if given:
            raise OptionError(f"{given[0]} is of a sample: give its name, such as gearbox, too")
        if as_json:
            outputs.print_json({"mockups": list(mockups), "tools": list(tools)})
        else:
            outputs.print_facts(outputs.console(), [("mock-ups", ", ".join(mockups)), ("tools", ", ".join(tools))])
        return
    if name not in mockups and name not in tools:
        raise OptionError(f"no sample is called {name!r}; mock-ups: {', '.join(mockups)}; tools: {', '.join(tools)}")
    faults = faults_of(fault or [], "--fault")
    if out is not None:
        outputs.check_mesh_target(out)
    mesh: Any
    if name in tools:
        if faults or truth is not None:
            raise OptionError("--fault and --truth are for the gearbox")
        if "triangles" in told or "seed" in told:
            raise OptionError("--triangles and --seed are for mock-ups; a tool takes --fine")
        mesh = feeler.sample_tool(check_word("name", name, tools), fine=fine)
    else:
        if fine:
            raise OptionError("--fine is for tools; a mock-up takes --triangles")
        sample_name = check_word("name", name, mockups)
        with bar(f"making {name}") as progress:
            mesh = feeler.sample(sample_name, triangles, seed=seed, faults=faults, progress=progress)
        if truth is not None:
            known = feeler.sample_truth(sample_name, triangles, seed=seed, faults=faults)
            with atomic_file(truth, ".json") as file:
                file.write((known.to_json() + "\n").encode())
    size = None
    if out is not None:
        with bar(f"writing {out}"):
            size = outputs.write_mesh(out, mesh)
    report = mesh.report
    if as_json:
        outputs.print_json(
            {"sample": name, "out": None if out is None else str(out), "bytes": size, **report.to_dict()}
        )
        return
    facts = [
        ("sample", name),
        ("triangles", f"{report.triangles:,}"),
        ("parts", f"{report.parts:,}"),
        ("extent", outputs.extent(report.lower, report.upper)),
    ]
    if out is not None and size is not None:
        facts.append(("written", f"{out} ({outputs.size(size)})"))
    outputs.print_facts(outputs.console(), facts)
