"""Pages in Markdown: every block of Python and every `feeler` command runs, in order; every link leads somewhere.

A page is one program. Its blocks of Python share their names, and a line `print(...)  # -> text` prints that text.
Commands are in blocks of `sh`. Pages use the files that README.md makes under "Command line". A block that cannot run
here has a comment before it, `<!-- not run: REASON -->`, and its place in NOT_RUN.
"""

from __future__ import annotations

import contextlib
import importlib.util
import io
import json
import os
import re
import shlex
import shutil
import subprocess
import sys
from pathlib import Path
from types import ModuleType
from typing import Any, NamedTuple

import pytest
from test_cli_view import document_when, viewed
from typer.testing import CliRunner
from workbench_fake import Page

import feeler
from feeler.cli import app

if sys.version_info >= (3, 11):
    import tomllib
else:
    import tomli as tomllib

ROOT = Path(__file__).resolve().parent.parent
_TOP = [ROOT / "README.md", ROOT / "CONTRIBUTING.md", ROOT / "ARCHITECTURE.md", ROOT / "bench" / "README.md"]
PAGES = {path.relative_to(ROOT).as_posix(): path for path in [*_TOP, *sorted(ROOT.glob("docs/*.md"))]}
LINKED = [*PAGES.values(), ROOT / "CHANGELOG.md", *ROOT.glob("crates/*/*.md")]

SLOW = ["README.md"]

# Page and reason of each block that is not run.
NOT_RUN = [("docs/devices.md", "a Haply device")]

BLOCK = re.compile(r"^(?:<!-- not run: (?P<reason>.+?) -->\n)?```(?P<language>\S*)\n(?P<text>.*?)^```", re.M | re.S)


class Block(NamedTuple):
    language: str
    text: str
    line: int  # of its first line in the page
    reason: str | None  # why it is not run


def blocks_of(page: str) -> list[Block]:
    text = PAGES[page].read_text(encoding="utf-8")
    return [
        Block(match["language"], match["text"], text.count("\n", 0, match.start("text")) + 1, match["reason"])
        for match in BLOCK.finditer(text)
    ]


@pytest.fixture(scope="session")
def sample_files(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """The files that all pages may name, made by the commands of the README."""
    folder = tmp_path_factory.mktemp("sample_files")
    commands = [line for block in blocks_of("README.md") for line in block.text.splitlines() if "feeler sample" in line]
    with pytest.MonkeyPatch.context() as patch:
        patch.chdir(folder)
        for command in commands:
            run_command(shlex.split(command, comments=True), folder)
    assert {path.name for path in folder.iterdir()} >= {"gearbox.glb", "wrench.stl", "hand.stl"}
    return folder


def run_command(words: list[str], folder: Path) -> None:
    """One line of a block of `sh`. Exit status 1 is an answer ("it collides"), 2 is bad input."""
    if os.name == "nt" and words[1] in ("view", "replay"):  # a signal of POSIX ends the one, the other needs its record
        return
    if words[:2] == ["feeler", "view"]:
        with viewed(folder, *words[2:]) as (url, _), Page(url) as page:
            document_when(page, lambda document: document["mockup"])
    elif words[:2] == ["feeler", "mcp"]:  # it takes the streams of its process
        command = [sys.executable, "-m", *words]
        ended = subprocess.run(command, stdin=subprocess.DEVNULL, capture_output=True, text=True, check=False)
        assert (ended.returncode, ended.stdout) == (0, ""), ended.stderr
    elif words[0] == "feeler":
        result = CliRunner().invoke(app, words[1:])
        assert result.exit_code in (0, 1), f"{shlex.join(words)}\n{result.output}\n{result.exception!r}"
    elif words[0] == "make":
        makefile = (ROOT / "Makefile").read_text(encoding="utf-8")
        targets = [word for word in words[1:] if "=" not in word]
        assert all(re.search(rf"^{target}:", makefile, re.M) for target in targets), f"no such target: {words}"
    elif words[0].endswith("python"):
        assert (ROOT / words[1]).is_file(), f"no such script: {words[1]}"
    elif words[0] == ".":
        assert words[1].startswith(".venv/"), "make builds .venv"
    elif words[:2] == ["pip", "install"]:
        extras = re.findall(r"\[(\w+)\]", words[2])
        known = tomllib.loads((ROOT / "pyproject.toml").read_text(encoding="utf-8"))["project"]["optional-dependencies"]
        assert set(extras) <= set(known), f"no such extra: {words[2]}"
    else:
        raise AssertionError(f"the tests do not know the command {words[0]}")


def run_python(page: str, block: Block, names: dict[str, Any]) -> None:
    """Runs a block among the names of those before it, and compares what it prints with its comments."""
    printed = io.StringIO()
    code = compile("\n" * (block.line - 1) + block.text, PAGES[page], "exec")
    with contextlib.redirect_stdout(printed):
        exec(code, names)
    lines = printed.getvalue().splitlines()
    expected = re.findall(r"^ *print\(.*\) +# -> (.*)$", block.text, re.M)
    if len(expected) == block.text.count("print("):
        assert lines == expected
    rest = iter(lines)
    missing = [text for text in expected if text not in rest]
    assert not missing, f"not printed, or not in this order: {missing}; printed: {lines}"


@pytest.mark.parametrize("page", [pytest.param(page, marks=pytest.mark.slow if page in SLOW else ()) for page in PAGES])
def test_a_page_runs(page: str, sample_files: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    for path in sample_files.iterdir():
        shutil.copy(path, tmp_path)
    monkeypatch.chdir(tmp_path)
    monkeypatch.setenv("FEELER_CACHE_DIR", str(tmp_path / "cache"))
    names: dict[str, Any] = {"__name__": "page"}
    for block in blocks_of(page):
        if block.reason:
            continue
        if block.language == "python":
            run_python(page, block, names)
        elif block.language == "json":
            json.loads(block.text)
        elif block.language == "toml":
            tomllib.loads(block.text)
        elif block.language == "sh":
            for line in block.text.splitlines():
                words = shlex.split(line, comments=True)
                if words:
                    run_command(words, tmp_path)
        else:
            assert block.language == "text", (
                f"line {block.line}: {block.language!r} is not python, sh, json, toml or text"
            )


def test_blocks_that_do_not_run_are_known() -> None:
    found = [(page, block.reason) for page in PAGES for block in blocks_of(page) if block.reason]
    assert found == NOT_RUN


@pytest.mark.parametrize("page", PAGES)
def test_commands_are_in_blocks_of_sh(page: str) -> None:
    """An indented command would not be run."""
    outside = BLOCK.sub("", PAGES[page].read_text(encoding="utf-8"))
    assert re.findall(r"^ {4,}(?:feeler|make|pip|python) .*$", outside, re.M) == []
    assert re.findall(r"^(?:```|<!-- not run:).*$", outside, re.M) == []


def test_the_quick_start_is_short() -> None:
    first = next(block for block in blocks_of("README.md") if block.language == "python")
    assert len(first.text.splitlines()) <= 12, "the README begins with eight lines that run"


# --- links ----------------------------------------------------------------------------------------------------------


def anchors(page: Path) -> set[str]:
    """The anchors of a page's headings, as GitHub names them."""
    text = BLOCK.sub("", page.read_text(encoding="utf-8"))
    headings = re.findall(r"^#+ (.*)$", text, re.M)
    plain = [re.sub(r"\[(.*?)\]\(.*?\)", r"\1", heading).replace("`", "").lower() for heading in headings]
    return {re.sub(r"[^\w\- ]", "", heading).strip().replace(" ", "-") for heading in plain}


def test_links_lead_somewhere() -> None:
    broken = []
    for page in LINKED:
        text = BLOCK.sub("", page.read_text(encoding="utf-8"))
        for link in re.findall(r"\]\(([^)\s]+)\)", text):
            target, _, anchor = link.partition("#")
            if "://" in target or target.startswith("mailto:"):
                continue
            there = page if not target else page.parent / target
            if not there.exists() or (anchor and there.suffix == ".md" and anchor not in anchors(there)):
                broken.append(f"{page.relative_to(ROOT)}: {link}")
    assert broken == []


def test_every_page_is_linked_from_the_readme() -> None:
    readme = PAGES["README.md"].read_text(encoding="utf-8")
    assert [page for page in PAGES if page.startswith("docs/") and f"({page}" not in readme] == []


def _named(name: str) -> Any:
    """What `feeler.NAME` is, its modules imported; None if there is no such name."""
    thing: Any = feeler
    path = "feeler"
    for part in name.split("."):
        path += f".{part}"
        if not hasattr(thing, part) and isinstance(thing, ModuleType) and importlib.util.find_spec(path):
            importlib.import_module(path)
        thing = getattr(thing, part, None)
    return thing


def test_every_public_name_of_a_page_exists() -> None:
    """`feeler.NAME` in the text of a page, too: not only in blocks, which run."""
    missing = []
    for page, path in PAGES.items():
        for name in re.findall(r"`feeler\.([A-Za-z_][\w.]*)", path.read_text(encoding="utf-8")):
            if _named(name.rstrip(".")) is None:
                missing.append(f"{page}: feeler.{name}")
    assert missing == []
