"""The sequence as a film: each line as a way from where it began, with the gaps that it had then."""

from __future__ import annotations

import csv
import io

import numpy as np
import pytest
from test_workbench_cards import answered
from workbench_scene import LEFT, PEG, RIGHT, Bench, at, cube

from feeler.workbench.document import motion
from feeler.workbench.report.content import report_of
from feeler.workbench.report.source import of_document


def taken(bench: Bench, part: int, *steps: tuple[float, float, float]) -> None:
    bench.command("grip", parts=[part])
    for step in steps:
        bench.drag(bench.pose @ at(*step), 0.5)
    bench.command("release")


def test_lines_are_ways_from_where_they_began_to_where_the_parts_lie() -> None:
    bench = Bench(None)
    taken(bench, PEG, (0.0, 0.0, 0.2))
    taken(bench, LEFT, (0.0, 0.0, 0.3), (0.0, 0.1, 0.0))
    taken(bench, PEG, (0.1, 0.0, 0.0))
    ways = bench.session.job("film", {}).result(60)["ways"]
    assert [way["parts"] for way in ways] == [[PEG], [LEFT], [PEG]]
    assert [way["id"] for way in ways] == [line["id"] for line in bench.document["sequence"]]
    assert [list(way["starts"]) for way in ways] == [[], [], [str(PEG)]]
    for way, part in ((ways[2], PEG), (ways[1], LEFT)):
        start = motion.matrix(way["starts"].get(str(part), motion.HOME))
        end = np.array(way["poses"][-1]).reshape(4, 4) @ start
        np.testing.assert_allclose(end.ravel(), bench.document["moved"][str(part)], atol=1e-12)
        np.testing.assert_allclose(np.array(way["poses"][0]).reshape(4, 4), np.eye(4), atol=1e-12)
    assert ways[0]["length"] == pytest.approx(0.2, abs=1e-3)
    # The plate, on which the peg stands at the start, is not its neighbour: as in `feeler.removal`.
    first, *rest = ways[0]["gaps"]
    assert first["gap"] is None and rest[-1]["share"] == 1.0
    assert all(gap["part"] != 0 for gap in rest)
    # Then it lies above the plate, farther than gaps are looked for.
    assert all(gap["gap"] is None for gap in ways[2]["gaps"])
    bench.session.close()


def test_a_way_has_one_length_and_turn_wherever_it_is_told() -> None:
    """That of the middle of its parts, with a tool in the hand too: of film, check, table and report."""
    bench = Bench(cube(), pose=at(0.0, 0.0, 0.75), mode="pass")
    bench.command("grip", parts=[PEG])
    bench.wish(at(0.0, 0.3, 1.0, 0.5) @ bench.pose)
    bench.wish(at(0.1, 0.3, 1.0) @ bench.pose)
    bench.command("release")
    (line,) = bench.document["sequence"]
    (film,) = bench.session.job("film", {}).result(60)["ways"]
    card = bench.command("way_check", id=line["id"])["id"]
    assert answered(bench, card).state == "done"
    (checked,) = bench.session.ask("card", {"id": card})["ways"]
    middle = np.array([0.0, 0.28125, 0.0625, 1.0])
    places = np.array(film["poses"]).reshape(-1, 4, 4) @ middle
    long = np.linalg.norm(np.diff(places, axis=0), axis=1).sum()
    assert film["length"] == pytest.approx(long, abs=1e-9) == checked["length"]
    assert film["rotation"] == pytest.approx(0.5, abs=1e-9) == checked["rotation"]
    bench.session.job("export_csv", {}).result(60)
    (row,) = csv.DictReader(io.StringIO(bench.session.export("sequence.csv").decode("utf-8-sig")))
    assert float(row["way (mm)"]) == pytest.approx(1e3 * long, rel=1e-3)
    (step,) = report_of(of_document(bench.session.current, bench.mockup, {})).steps
    assert step.length == pytest.approx(long, abs=1e-9)
    bench.session.close()


def test_a_film_of_nothing_is_empty() -> None:
    bench = Bench(None)
    assert bench.session.job("film", {}).result(60) == {"ways": []}
    bench.session.close()


def test_a_table_says_which_parts_are_not_out() -> None:
    bench = Bench(None)
    taken(bench, PEG, (0.0, 0.0, 0.005))
    taken(bench, LEFT, (0.0, 0.0, 0.3), (-3.0, 0.0, 0.0))
    taken(bench, RIGHT, (0.0, 0.0, 0.3))

    def ends() -> list[str]:
        bench.session.job("export_csv", {}).result(60)
        rows = csv.DictReader(io.StringIO(bench.session.export("sequence.csv").decode("utf-8-sig")))
        return [row["end"] for row in rows]

    assert ends() == ["not out", "out", "not out"]
    taken(bench, PEG, (0.0, 3.0, 0.0))
    bench.command("put_back", parts=[RIGHT])
    assert ends() == ["moved again", "out", "put back", "out"]
    bench.session.close()
