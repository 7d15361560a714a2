"""The types of what a project gives: their keys are those that are there."""

from __future__ import annotations

from pathlib import Path

from shapes import box

import feeler
from feeler.types import FindingChange, FindingRow, ProjectDocument
from feeler.workbench.document.keeping import kept_fields


def keys_of(kind: type) -> tuple[set[str], set[str]]:
    """The keys that are always there, and all."""
    required = frozenset[str](getattr(kind, "__required_keys__", ()))
    return {*required}, {*required, *getattr(kind, "__optional_keys__", ())}


def test_rows_and_document_have_the_keys_of_their_types(tmp_path: Path) -> None:
    mockup = feeler.Mockup({"a": box((0, 0, 0), (1, 1, 1)), "b": box((0.5, 0, 0), (1.5, 1, 1))})
    found = feeler.clash(mockup)
    with feeler.open_project(tmp_path / "a.feelproj", mockup) as project:
        project.write_clashes(found)
        found.set_status(found[0].id, "approved", by="me", note="press fit")
        project.write_clashes(found)
        for kind, rows in ((FindingRow, project.findings()), (FindingChange, project.history())):
            required, known = keys_of(kind)
            assert rows
            for row in rows:
                assert required <= row.keys() <= known
        assert project.findings()[0]["approved_verdict"] == project.findings()[0]["verdict"] == "clash"
        assert project.document().keys() <= keys_of(ProjectDocument)[1]
    assert keys_of(ProjectDocument)[1] == {*kept_fields()}, "each field that the workbench keeps"
