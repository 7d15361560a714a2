"""The user's own catalogue of tools in the workbench: plans use it, undo and projects keep it, agents have theirs."""

from __future__ import annotations

import math
from pathlib import Path

import pytest
from test_workbench_cards import answered
from test_workbench_tasks import LEFT, bench_of, mockup, steps
from workbench_scene import Bench

import feeler
from feeler.agent.job import Job
from feeler.agent.served import Served
from feeler.agent.tools import TOOLS, call
from feeler.errors import WorkbenchError
from feeler.project.book import open_or_make
from feeler.workbench.session.session import Session

OWN = """version = 1
[[open]]
name = "ours"
sizes_mm = [13]
width_mm = 28
thick_mm = 5
length_mm = 150
shaft_mm = 10
"""


@pytest.fixture(scope="module")
def world() -> feeler.Mockup:
    return mockup()


def tools_of(bench: Bench, number: int) -> set[str]:
    """The tools of a card's plan, once it is there."""
    answered(bench, number)
    return {step["tool"] for step in steps(bench, number) if step["verb"] == "undo"}


def test_plans_choose_from_the_own_catalogue(world: feeler.Mockup) -> None:
    bench = bench_of(world)
    number, free = (
        int(bench.command("ask", question="task", parts=LEFT, **more)["id"]) for more in ({}, {"tools": []})
    )
    usual = tools_of(bench, number)
    tools_of(bench, free)
    bench.command("task_catalogue", toml=OWN, name="tools.toml")
    assert bench.document["task_catalogue"] == {"name": "tools.toml", "tools": 1}
    # A plan without tools is not made again.
    assert [card["state"] for card in bench.document["cards"]][1] == "done"
    assert tools_of(bench, number) == {"ours 13"} != usual
    undo = next(k for k, step in enumerate(steps(bench, number)) if step["verb"] == "undo")
    ghost = bench.session.ask("task_tool", {"id": number, "step": undo}) or {}
    assert max(map(abs, (*ghost["manifest"]["lower"], *ghost["manifest"]["upper"]))) > 0.12  # its handle
    bench.command("undo")
    assert bench.document["task_catalogue"] == {"name": "", "tools": 0}
    assert tools_of(bench, number) == usual
    bench.command("redo")
    assert tools_of(bench, number) == {"ours 13"}
    bench.command("task_catalogue", toml=" ")
    assert tools_of(bench, number) == usual


@pytest.mark.parametrize(
    ("toml", "says"),
    [
        (OWN.replace("= 5", "= -5"), r"tools\.toml, \[\[open\]\] 1 in line 2: thick_mm is -5"),
        (
            OWN + OWN[12:].replace("28", "13"),
            r"tools\.toml, \[\[open\]\] 2 in line 9: ours 13: width_mm leaves no wall",
        ),
        (OWN + "[[open]", r"tools\.toml: not valid TOML: .*line 9"),
        ("#", r"tools\.toml: version is None"),
        ("x" * 90_001, "it is no text, or too long"),
    ],
)
def test_wrong_catalogues_say_where(world: feeler.Mockup, toml: str, says: str) -> None:
    bench = Bench(mockup=world)
    with pytest.raises(WorkbenchError, match=says):
        bench.command("task_catalogue", toml=toml, name="tools.toml")
    assert bench.document["task_catalogue"] == {"name": "", "tools": 0}


def test_no_line_is_named_where_headers_are_not_clear(tmp_path: Path) -> None:
    own = tmp_path / "own.toml"
    own.write_text('note = """\n[[open]]\n"""\n' + OWN.replace("= 5", "= -5"))
    with pytest.raises(feeler.LoadError, match="'note' is unknown"):
        feeler.catalogue(own)
    own.write_text(OWN.replace('"ours"', '"""ours\n[[open]]\n"""').replace("= 5", "= -5"))
    with pytest.raises(feeler.LoadError, match=r"\[\[open\]\] 1: thick_mm"):
        feeler.catalogue(own)


def test_the_project_keeps_the_catalogue(world: feeler.Mockup, tmp_path: Path) -> None:
    path = tmp_path / "bolted.feelproj"
    session = Session(project=open_or_make(path))
    session.open(world, feeler.Scene(world), None)
    session.command("task_catalogue", {"toml": OWN, "name": "tools.toml"})
    session.close()
    again = Session(project=open_or_make(path))
    again.open(world, feeler.Scene(world), None)
    kept = again.current.task_catalogue
    again.close()
    assert (kept.name, kept.toml, kept.tools) == ("tools.toml", OWN, 1)


def test_agents_choose_from_the_own_catalogue(world: feeler.Mockup, tmp_path: Path) -> None:
    own = tmp_path / "tools.toml"
    own.write_text(OWN)
    served = Served(feeler.Scene(world), catalogue=feeler.catalogue(own))
    rows = call(TOOLS["task"], served, {"parts": ["left"], "tool": "catalogue"}, Job()).content["rows"]
    assert {row["tool"] for row in rows if row["verb"] == "undo"} == {"ours 13"}
    assert all(math.isfinite(row["seconds"]) for row in rows)
