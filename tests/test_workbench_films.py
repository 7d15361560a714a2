"""The sequence as a film: each line as a way from where it began, with the gaps that it had then."""

from __future__ import annotations

import csv
import io

import numpy as np
import pytest
from workbench_scene import LEFT, PEG, RIGHT, Bench, at

from feeler.workbench.document import motion


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
