"""A small project with everything that a report shows, made by the commands of the workbench."""

from __future__ import annotations

import time
from pathlib import Path
from typing import Any

import numpy as np
from commands import run
from workbench_scene import FACES, LEFT, PEG, corners, stand

import feeler
from feeler.cli.projects import Work, keep_work
from feeler.io import write_glb
from feeler.project.book import open_or_make
from feeler.workbench.document.document import Document
from feeler.workbench.session.session import Session

WAIT_S = 60.0
BOLD = "<b onclick=alert(1)>bold</b>"


def mockup(names: dict[str, str] | None = None, *, is_raised: bool = False) -> feeler.Mockup:
    """The stand, with a block in its left post. is_raised: the block is elsewhere, and higher."""
    base = stand()
    block = corners((-0.3, -0.2, 0.1), (-0.2, 0.2, 0.3 if is_raised else 0.2))
    paths = [*base.part_paths, "stand/block"]
    paths = [(names or {}).get(path, path) for path in paths]
    return feeler.Mockup(
        np.concatenate([base.vertices, block]),
        np.concatenate([base.faces, FACES + len(base.vertices)]),
        np.concatenate([base.part_of_face, np.full(12, 5)]),
        [path.split("/")[-1] for path in paths],
        part_paths=paths,
    )


def loaded(folder: Path, of: feeler.Mockup) -> feeler.Mockup:
    """The mock-up from the file stand.glb in a folder, whose name its paths begin with."""
    write_glb(folder / "stand.glb", of)
    return feeler.load_mockup(folder / "stand.glb")


def project(folder: Path, of: feeler.Mockup | None = None, text: str = "drawn so") -> Path:
    """A project of the mock-up in a folder, whose names and notes have `text` in them."""
    world = loaded(folder, mockup() if of is None else of)
    book = open_or_make(folder / "stand.feelproj")
    session = Session(project=book, has_threads=False)
    tool = feeler.sample_tool("wrench")
    session.open(world, feeler.Scene(world, threads=1), None, tools=[tool], name="stand.glb")
    keep_work(book, Work([str(folder / "stand.glb")]))
    fill(session, text)
    assert session._saver is not None and session._saver.wait(WAIT_S)
    session.close()
    path = folder / "stand.feelproj"
    run("maintain", path, "--part", "*/peg", "--part", "*/left", "--seconds", "5")
    return path


def fill(session: Session, text: str = "drawn so") -> Document:
    """Findings, requirements, questions and a sequence."""
    session.command("ask", {"question": "removal", "parts": [PEG], "seconds": 5})
    session.command("ask", {"question": "order", "parts": [PEG], "seconds": 5})
    session.command("ask", {"question": "access", "parts": [PEG], "tool": "wrench"})
    end = time.monotonic() + WAIT_S
    while any(card.state in ("waiting", "running") for card in session.current.cards):
        assert time.monotonic() < end
        time.sleep(0.02)
    taken = session.job("clash", {}).result(WAIT_S)
    session.command("findings_take", {"key": taken["key"]})
    found = session.current.findings
    assert found is not None
    marks: dict[str, Any] = {"version": found.table.key, "rows": [0]}
    session.command("finding_mark", {**marks, "status": "reviewed", "note": text})
    for name, a, b, gap in (
        (f"clear {text}", "*left*", "*block*", 0.01),
        ("far", "*peg*", "*left*", 0.01),
        ("none", "*nothing*", "*left*", 0.01),
    ):
        session.command("requirement_add", {"name": name, "a": a, "b": b, "gap": gap})
    results = session.job("verify", {}).result(WAIT_S)
    session.command("requirements_checked", {"results": results})
    session.command("requirement_add", {"name": "later", "a": "*peg*", "b": "*sheet*", "gap": 0.0})
    session.command("way_take", {"id": 1})
    session.command("way_check", {"id": session.current.sequence[0].id})
    while any(card.state in ("waiting", "running") for card in session.current.cards):
        assert time.monotonic() < end
        time.sleep(0.02)
    return session.current


__all__ = ["BOLD", "LEFT", "PEG", "WAIT_S", "fill", "mockup", "project"]
