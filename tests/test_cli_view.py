"""`feeler view` as a program: the address, the page while it loads, files that fail, the end."""

from __future__ import annotations

import contextlib
import json
import os
import signal
import subprocess
import sys
import time
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Any

import pytest
from commands import error_of
from workbench_fake import WAIT_S, Page, bearer, fetch

import feeler
from feeler.cli.projects import Work
from feeler.cli.view import _Opening, ended_by_signals
from feeler.plan.catalogue import built_in_text
from feeler.workbench.document import protocol
from feeler.workbench.session.session import Session

PROGRAM = (
    "import signal, sys\n"
    # Whoever runs the tests in the background may have told all children to ignore the signal.
    "signal.signal(signal.SIGINT, signal.default_int_handler)\n"
    "from pathlib import Path\n"
    "from feeler.workbench.files import static_files\n"
    "static_files.__defaults__ = (Path(sys.argv.pop(1)),)\n"
    "from feeler.cli import main; main()"
)

pytestmark = pytest.mark.skipif(os.name == "nt", reason="signals of POSIX")


@contextmanager
def viewed(folder: Path, *words: str | Path, code: int = 0) -> Iterator[tuple[str, Any]]:
    """The address of a running `feeler view`, which is ended by Ctrl-C, and the list of what it says on stderr."""
    (folder / "index.html").write_text("<!doctype html>")
    command = [sys.executable, "-c", PROGRAM, folder, "view", "--no-browser", "--json", *words]
    with subprocess.Popen([str(word) for word in command], stdout=-1, stderr=-1, text=True) as process:
        said: list[str] = []
        try:
            assert process.stdout is not None
            text = ""
            while not text.endswith("}\n"):
                line = process.stdout.readline()
                assert line, process.communicate()
                text += line
            yield json.loads(text)["url"], said
            process.send_signal(signal.SIGINT)
            out, err = process.communicate(timeout=WAIT_S)
            said.append(err)
            assert (out, process.returncode) == ("", code), err
        finally:
            process.kill()


def document_when(page: Page, is_so: Any) -> dict[str, Any]:
    """The document, once something holds of it."""
    document: dict[str, Any] = {**page.next(protocol.Welcome).document}
    while not is_so(document):
        document.update(page.next(protocol.Patch).fields)
    return document


def test_it_serves_while_it_loads_and_ends_cleanly(tmp_path: Path) -> None:
    with viewed(tmp_path, "sample:engine:20000", "--tool", "sample:wrench", "--record", tmp_path / "a.jsonl") as (
        url,
        said,
    ):
        assert fetch(url, "/")[2] == b"<!doctype html>"
        with Page(url) as page:
            document = document_when(page, lambda document: document["mockup"])
            assert document["loading"] is None and document["tool"]["name"] == "wrench"
            assert document["mockup"]["name"] == "engine"
            manifest = json.loads(fetch(url, "/scene", bearer(url))[2])
            assert manifest["hash"] == document["mockup"]["hash"]
            assert manifest["triangles"] == sum(piece["triangles"] for piece in manifest["pieces"]) > 10_000
            for number, piece in enumerate(manifest["pieces"]):
                assert len(fetch(url, f"/scene/pieces/{number}", bearer(url))[2]) == piece["bytes"]
            page.send(protocol.Command(1, "hide", {"parts": [0]}))
            assert page.next(protocol.Answer).id == 1
            page.send(protocol.Ask(2, "part", {"part": 0}))
            assert page.next(protocol.Answer).id == 2
        with Page(url) as again:
            welcome = again.next(protocol.Welcome)
            assert welcome.document["hidden"] == [0] and welcome.recording
            assert welcome.held is not None and welcome.held["pieces"]
            held = fetch(url, f"/held/{welcome.document['held_version']}", bearer(url))[2]
            assert len(held) == sum(piece["bytes"] for piece in welcome.held["pieces"])
            assert again.next(protocol.State).mode == "stop"
    assert said == [""]
    assert (tmp_path / "a.jsonl").read_text().count("\n") > 1


def test_the_page_is_told_what_is_done_and_how_far_it_is() -> None:
    told: list[dict[str, Any]] = []
    with Session(has_threads=False) as session:
        session.subscribe(told.append)
        opening = _Opening(session, Work(["sample:engine:100000"]))
        opening._open()
    loading = [event["fields"]["loading"] for event in told if "loading" in event.get("fields", {})]
    assert loading.pop() is None, "the last is the mock-up"
    shares = [each["share"] for each in loading]
    assert shares == sorted(shares) and len(set(shares)) >= 12 and shares[-1] == 0.95
    stages = [each["stage"] for each in loading]
    assert stages[0] == "tessellating" and stages[-1] == "packing the picture"
    assert {"cutting triangles", "sorting pieces", "building blocks"} < set(stages) and "done" not in stages


def test_an_empty_hand(tmp_path: Path) -> None:
    with (
        viewed(tmp_path, "sample:differential:10000", "--only", "*", "--show-unit", "in") as (url, _),
        Page(url) as page,
    ):
        document = document_when(page, lambda document: document["mockup"])
        assert (document["tool"], document["unit"]) == (None, "in")


def test_a_file_that_fails_says_why_in_the_page_and_on_stderr(tmp_path: Path) -> None:
    (tmp_path / "bad.stl").write_text("<b>nonsense</b>")
    with viewed(tmp_path, tmp_path / "bad.stl", code=2) as (url, said), Page(url) as page:
        document = document_when(page, lambda document: document["failed"])
        assert "bad.stl" in document["failed"] and document["mockup"] is None
        assert fetch(url, "/scene", bearer(url))[0] == 404
        page.send(protocol.Ask(1, "part", {"part": 0}))
        assert page.next(protocol.Refusal).id == 1
    assert "bad.stl" in said[0] and said[0].count("\n") == 1


@pytest.mark.parametrize(
    ("words", "said"),
    [
        (["none.glb"], "none.glb: there is no such file or folder"),
        (["here.stl", "none.stl"], "none.stl: there is no such file or folder"),
        (["here.stl", "--tool", "none.stl"], "none.stl: there is no such file or folder"),
        (["none.stl", "--project", "new.feelproj"], "none.stl: there is no such file or folder"),
        (["empty"], "the folder holds no mesh file"),
        (["house.ifc"], "house.ifc"),
        (["sample:engin"], "engin"),
        (["sample:engine:x"], "triangles is 'x'"),
        (["sample:engine", "--tool", "sample:wrenhc"], "wrenhc"),
    ],
    ids=" ".join,
)
def test_what_is_not_there_ends_it_before_the_page_opens(
    words: list[str], said: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.chdir(tmp_path)
    Path("empty").mkdir()
    Path("here.stl").write_text("solid a\nendsolid a\n")
    Path("house.ifc").write_text("ISO-10303-21;\nHEADER;\nFILE_SCHEMA(('IFC4'));\n")

    def started(*_: object, **__: object) -> None:
        raise AssertionError("a server was made")

    monkeypatch.setattr("feeler.workbench.net.server.Server.__init__", started)
    assert said in error_of("view", "--no-browser", *words)
    assert not Path("new.feelproj").exists()


def test_ctrl_c_does_not_wait_for_what_loads(tmp_path: Path) -> None:
    with viewed(tmp_path, "sample:engine:1600000") as (url, _):
        assert fetch(url, "/")[0] == 200


def test_options_that_cannot_be(tmp_path: Path) -> None:
    assert "--show-unit" in error_of("view", "--show-unit", "ft")
    assert "--tool-unit is for" in error_of("view", "a.stl", "--tool-unit", "mm")
    assert "--device moves a tool" in error_of("view", "a.stl", "--device", "haply")
    assert "--port is '70000'" in error_of("view", "--port", "70000")
    assert "allow remote access" in error_of("view", "--host", "0.0.0.0")
    assert "needs TLS" in error_of("view", "--host", "box.example", "--allow-remote")
    assert "does not exist" in error_of("view", "--record", tmp_path / "no" / "a.jsonl")
    assert "nonsense" in error_of("view", "--device", "nonsense")
    (tmp_path / "clashes.json").write_text('{"rows": []}')
    assert 'no list "clashes"' in error_of("view", "--findings", tmp_path / "clashes.json")
    (tmp_path / "tools.toml").write_text("version = 1\n\n[[socket]]\nsizes_mm = 13\n")
    assert "[[socket]] 1 in line 3: sizes_mm is 13" in error_of("view", "--catalogue", tmp_path / "tools.toml")
    (tmp_path / "tools.toml").write_text(built_in_text() + "#" * 90_000)
    assert "the workbench takes 90,000 at most" in error_of("view", "--catalogue", tmp_path / "tools.toml")


def test_the_catalogue_is_there_from_the_start_for_all_mockups() -> None:
    with Session(has_threads=False) as session:
        opening = _Opening(session, Work(["sample:differential:10000"]))
        opening.catalogue = ("tools.toml", built_in_text())
        for _ in range(2):
            opening._open()
            assert session.document()["task_catalogue"] == {"name": "tools.toml", "tools": len(feeler.catalogue())}


@pytest.mark.skipif(os.name == "nt", reason="signals")
@pytest.mark.parametrize("name", ["SIGTERM", "SIGHUP"])
def test_signals_that_end_a_program_end_it_as_ctrl_c_does(name: str) -> None:
    number = getattr(signal, name)
    before = signal.getsignal(number)
    ended: list[str] = []
    with pytest.raises(KeyboardInterrupt), ended_by_signals(), contextlib.ExitStack() as ends:
        ends.callback(ended.append, "cleaned")
        os.kill(os.getpid(), number)
        time.sleep(5.0)
    assert ended == ["cleaned"] and signal.getsignal(number) is before
