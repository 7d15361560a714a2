"""The table of times in the workbench, what is seen of a fastener, and what edits ask again."""

from __future__ import annotations

import base64
import struct
import zlib
from pathlib import Path
from typing import Any

import numpy as np
import numpy.typing as npt
import pytest
from shapes import box, mockup_of
from test_task import bolt
from test_workbench_cards import answered
from test_workbench_tasks import LID, asked, bench_of, mockup, order, steps
from workbench_scene import Bench

import feeler
from feeler.errors import WorkbenchError
from feeler.project.book import open_or_make
from feeler.tasks.replanning import Memory
from feeler.tasks.times import WholePath, idle_patterns
from feeler.workbench.session import task_answers
from feeler.workbench.session.session import Session
from feeler.workbench.session.task_sight import SIZE, seen_at


def hooded() -> feeler.Mockup:
    """A bolt in a closed box."""
    return mockup_of({"left": bolt(0.03), "hood": box((-0.05, -0.05, -0.05), (0.05, 0.05, 0.05))})


def planned_steps(bench: Bench, number: int) -> list[dict[str, Any]]:
    """Those of a card, once its plan is there."""
    answered(bench, number)
    return steps(bench, number)


def pixels_of(png: bytes) -> npt.NDArray[np.uint8]:
    """`(height, width, 3)` of a PNG as `write_png` writes it: one chunk, each row a difference to the one above."""
    width, height = struct.unpack_from(">II", png, 16)
    at = png.index(b"IDAT")
    (count,) = struct.unpack_from(">I", png, at - 4)
    rows = np.frombuffer(zlib.decompress(png[at + 4 : at + 4 + count]), np.uint8).reshape(height, -1)[:, 1:]
    return np.cumsum(rows, axis=0, dtype=np.uint8).reshape(height, width, 3)


TABLE = '[elements]\nstroke = [2.0, 0.5]\nget = 1.0\n[typed]\nlid = 90.0\n"li*" = 1.0\n'


@pytest.fixture(scope="module")
def world() -> feeler.Mockup:
    return mockup()


def test_a_table_of_times_plans_all_tasks_again(world: feeler.Mockup) -> None:
    bench = bench_of(world)
    number = asked(bench)
    before = planned_steps(bench, number)
    bench.command("task_times", toml=TABLE, name="ours.toml")
    after = planned_steps(bench, number)
    assert bench.document["task_times"] == {"name": "ours.toml", "given": 2}
    assert [step["seconds"] for step in after if step["part"] == LID] == [90.0]
    assert after[1]["seconds"] == pytest.approx(before[1]["seconds"] + 0.8 * before[1]["strokes"] - 7.0)
    assert "get" not in " ".join(bench.session.ask("card", {"id": number})["task"]["notes"])
    # A time that was typed in the page counts for its path alone, before the table.
    bench.command("task_edit", id=number, edit="time", parts="lid", seconds=5.0)
    assert [step["seconds"] for step in planned_steps(bench, number) if step["part"] == LID] == [5.0]
    bench.command("undo")
    bench.command("undo")
    assert planned_steps(bench, number) == before and bench.document["task_times"] == {"name": "", "given": 0}
    bench.command("redo")
    bench.command("task_times", toml=" ")
    assert planned_steps(bench, number) == before


@pytest.mark.parametrize(
    ("toml", "says"),
    [
        ("[elements]\nfly = 1.0\n", "elements has 'fly': an element is one of"),
        ("[elements", "ours.toml: not valid TOML"),
        ("x" * 90_001, "it is no text, or too long"),
    ],
)
def test_wrong_tables_say_why(world: feeler.Mockup, toml: str, says: str) -> None:
    bench = Bench(mockup=world)
    with pytest.raises(WorkbenchError, match=says):
        bench.command("task_times", toml=toml, name="ours.toml")
    assert bench.document["task_times"] == {"name": "", "given": 0}


def test_the_project_keeps_the_table(world: feeler.Mockup, tmp_path: Path) -> None:
    path = tmp_path / "bolted.feelerproj"
    book = open_or_make(path)
    session = Session(project=book)
    session.open(world, feeler.Scene(world), None)
    session.command("task_times", {"toml": TABLE, "name": "ours.toml"})
    session.close()
    again = Session(project=open_or_make(path))
    again.open(world, feeler.Scene(world), None)
    assert again.current.task_times.toml == TABLE and again.current.task_times.given == 2
    again.close()


def test_whole_paths_match_nothing_else() -> None:
    assert idle_patterns(feeler.Times(typed={"bolt": 1.0}), ["a/bolt"]) == ()
    assert idle_patterns(feeler.Times(typed={WholePath("bolt"): 1.0}), ["a/bolt"]) != ()
    assert idle_patterns(feeler.Times(typed={WholePath("b[1]"): 1.0}), ["b[1]"]) == ()


def test_times_are_parsed_as_they_are_written() -> None:
    table = feeler.Times({"get": [2.0, 1.0]}, pitches_mm={"*x": 1.5}, typed={"y": 3.0})
    assert feeler.Times.parse(table.to_toml()).typed == table.typed
    assert feeler.Times.parse("version = 1\n" + table.to_toml()).typed == table.typed
    with pytest.raises(feeler.LoadError, match="times is of version 2, and this feeler reads 1"):
        feeler.Times.parse("version = 2\n" + table.to_toml())
    with pytest.raises(feeler.LoadError, match=r"times: \[other\] is unknown"):
        feeler.Times.parse("[other]")


def test_what_is_seen_is_a_picture_and_a_share(world: feeler.Mockup) -> None:
    bench = bench_of(world)
    number = asked(bench)
    first = order(bench, number)[1]
    seen = bench.session.ask("task_sight", {"id": number, "step": 1}) or {}
    assert first in ("left", "right") and seen["share"] > 0.9 and seen["hidden_by"] == []
    data = base64.b64decode(seen["picture"])
    assert data.startswith(b"\x89PNG") and tuple(seen["size"]) == SIZE
    assert bench.session.ask("task_sight", {"id": number, "step": 0}) is None  # no fastener
    with pytest.raises(WorkbenchError, match="there is no step 9"):
        bench.session.ask("task_sight", {"id": number, "step": 9})


def test_what_hides_a_head_is_named(world: feeler.Mockup) -> None:
    low = mockup_of({"left": bolt(0.03), "lid": box((-0.5, -0.5, 0.012), (0.5, 0.5, 0.016))})
    under, free = seen_at(feeler.Scene(low), 0), seen_at(feeler.Scene(low).without([1]), 0)
    assert under is not None and free is not None
    assert under["share"] < 0.85 < 0.9 < free["share"] and free["hidden_by"] == []

    pixels = pixels_of(base64.b64decode(free["picture"])).astype(int)
    assert (pixels[..., 2] > pixels[..., 0] + 25).sum() > 300  # the head
    assert seen_at(feeler.Scene(world), LID) is None
    # From above, all of it is behind the lid.
    lidded = seen_at(feeler.Scene(hooded()), 0)
    assert lidded is not None and lidded["share"] == 0.0 and lidded["hidden_by"] == [1]


def test_edits_ask_tools_nothing_again(world: feeler.Mockup, monkeypatch: pytest.MonkeyPatch) -> None:
    bench, asks = bench_of(world), []
    number = asked(bench)
    planned = task_answers.planned

    def counted(memory: Memory, *args: object, **options: object) -> feeler.Task:
        asks.append(memory)
        return planned(memory, *args, **options)  # type: ignore[arg-type]

    monkeypatch.setattr(task_answers, "planned", counted)
    bench.command("task_edit", id=number, edit="time", parts="left", seconds=5.0)
    answered(bench, number)
    bench.command("task_edit", id=number, edit="time", parts="left", seconds=6.0)
    answered(bench, number)
    assert asks[0] is asks[1]
    bench.command("card_remove", id=number)
    again = asked(bench)
    answered(bench, again)
    assert asks[-1] is not asks[0]
