"""Numbers and counts as text."""

from __future__ import annotations

import pytest

from feeler.words import counted, length, plural


@pytest.mark.parametrize(
    ("metres", "said"),
    [(0.0, "0 m"), (0.0025, "2.5 mm"), (0.99996, "1 m"), (-3e-6, "-3 µm"), (float("nan"), "an unknown length")],
)
def test_lengths_have_a_suitable_unit(metres: float, said: str) -> None:
    assert length(metres) == said


def test_nouns_follow_their_number() -> None:
    assert [plural(n, "part") for n in (0, 1, 2, 1000)] == ["0 parts", "1 part", "2 parts", "1,000 parts"]
    assert plural(2, "vertex") == "2 vertices" and plural(1, "vertex") == "1 vertex"


@pytest.mark.parametrize(
    ("many", "one"),
    [
        ("lines that are not STL were ignored", "1 line that is not STL was ignored"),
        ("vertices have a weight w other than 1", "1 vertex has a weight w other than 1"),
        ("hidden nodes were left out: they are lights", "1 hidden node was left out: they are lights"),
        ("polygons cross themselves: their triangles overlap", "1 polygon crosses itself: their triangles overlap"),
        ("rows of 'edges' were skipped", "1 row of 'edges' was skipped"),
        ("free-form curves (curv) were skipped", "1 free-form curve (curv) was skipped"),
        (
            "parts name another file and have a shape in this one",
            "1 part names another file and has a shape in this one",
        ),
        ("glass panes were left out", "1 glass pane was left out"),
    ],
)
def test_sentences_follow_their_number(many: str, one: str) -> None:
    assert counted(1, many) == one
    assert counted(2, many) == f"2 {many}" and counted(0, many) == f"0 {many}"
