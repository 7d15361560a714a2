"""The documentation as a site: its pages, their order, its links. `make docs` builds it; that is not repeated here."""

from __future__ import annotations

import dataclasses
import importlib
import re
from pathlib import Path
from types import ModuleType
from typing import Any

import pytest
import yaml

import feeler


@pytest.fixture
def site(root: Path, monkeypatch: pytest.MonkeyPatch) -> ModuleType:
    monkeypatch.syspath_prepend(str(root / "tools"))
    import docs_site

    return docs_site


@pytest.fixture(scope="module")
def config(root: Path) -> dict[str, Any]:
    """Plain YAML, without the tags of Python that only mkdocs would understand."""
    read: dict[str, Any] = yaml.safe_load((root / "mkdocs.yml").read_text(encoding="utf-8"))
    return read


def pages_of(nav: Any) -> list[str]:
    """The pages of a navigation, in their order."""
    if isinstance(nav, str):
        return [nav]
    return [page for entry in (nav if isinstance(nav, list) else nav.values()) for page in pages_of(entry)]


def test_the_navigation_names_every_page_once(
    site: ModuleType, config: dict[str, Any], root: Path, tmp_path: Path
) -> None:
    site.prepare(tmp_path / "docs", None)
    made = [path.relative_to(tmp_path / "docs").as_posix() for path in (tmp_path / "docs").rglob("*.md")]
    assert sorted(pages_of(config["nav"])) == sorted(made)
    assert {path.name for path in root.glob("docs/*.md")} <= {*made}
    assert [*map(str, (entry for part in config["nav"] for entry in part))] == [
        "Start",
        "Guides",
        "Reference",
        "How it is kept exact",
    ]
    assert (root / config["docs_dir"], root / config["site_dir"]) == (site.PAGES, site.SITE)
    for picture in root.glob("docs/**/*.png"):
        assert (tmp_path / "docs" / picture.relative_to(root / "docs")).is_file()


# The public modules beside `feeler` itself, and the folders of which each module is one.
MODULES = ("clashes", "haptics", "samples", "compat.trimesh", "compat.mujoco")


def public_names(module: ModuleType) -> set[str]:
    """The names of `__all__`; of a module without one, what it defines itself."""
    given = getattr(module, "__all__", None)
    if given is not None:
        return {*given}
    own = {name: each for name, each in vars(module).items() if getattr(each, "__module__", "") == module.__name__}
    return {name for name in own if not name.startswith("_")}


def test_every_public_name_is_in_the_reference_once(site: ModuleType, root: Path) -> None:
    names = [name for _, page in site.REFERENCE.values() for name in page]
    assert len(names) == len({*names})
    of_feeler = {name for name in names if "." not in name}
    assert of_feeler == {*feeler.__all__} - {"haptics"}
    for inner in MODULES:
        module = importlib.import_module(f"feeler.{inner}")
        # What `feeler` has itself is told there.
        expected = {name for name in public_names(module) if getattr(module, name) is not getattr(feeler, name, None)}
        assert {name.removeprefix(f"{inner}.") for name in names if name.startswith(f"{inner}.")} == expected, inner
    files = {path.stem for path in (root / "python" / "feeler" / "compat").glob("*.py")}
    assert {f"compat.{name}" for name in files - {"__init__", "meshes"}} <= {*MODULES}
    for name in names:
        thing: Any = feeler
        for part in name.split("."):
            thing = getattr(thing, part)
        assert thing.__doc__, name


def test_fields_without_a_line_of_their_own_are_shown(config: dict[str, Any]) -> None:
    (strings,) = (plugin["mkdocstrings"] for plugin in config["plugins"] if isinstance(plugin, dict))
    assert strings["handlers"]["python"]["options"]["show_if_no_docstring"] is True
    assert {"is_found", "steps"} <= {field.name for field in dataclasses.fields(feeler.RemovalOrder)}


def test_a_page_that_is_not_in_the_navigation_ends_the_build(site: ModuleType, root: Path, tmp_path: Path) -> None:
    site.prepare(tmp_path / "docs", None)
    config = (root / "mkdocs.yml").read_text(encoding="utf-8")
    assert site.not_in_the_navigation(tmp_path / "docs", config) == []
    (tmp_path / "docs" / "new.md").write_text("# New")
    assert site.not_in_the_navigation(tmp_path / "docs", config) == ["new.md"]
    without = config.replace("      - Clearance: clearance.md\n", "      - Casts again: cast.md\n")
    assert site.not_in_the_navigation(tmp_path / "docs", without) == ["cast.md", "clearance.md", "new.md"]


def test_the_reference_compiles_nothing(config: dict[str, Any], root: Path) -> None:
    (strings,) = (plugin["mkdocstrings"] for plugin in config["plugins"] if isinstance(plugin, dict))
    python = strings["handlers"]["python"]
    assert python["options"]["allow_inspection"] is False
    assert [(root / path / "feeler" / "_core.pyi").is_file() for path in python["paths"]] == [True]
    assert "make docs" not in (root / ".ci" / "run").read_text(encoding="utf-8")
    recipe = re.search(r"^docs: (.*)$", (root / "Makefile").read_text(encoding="utf-8"), re.MULTILINE)
    assert recipe is not None and "BUILT" not in recipe[1] and " build" not in recipe[1].split("##")[0]


@pytest.mark.parametrize(
    ("source", "link", "expected"),
    [
        ("README.md", "[a](docs/clash.md)", "[a](clash.md)"),
        ("README.md", "![a](docs/demo.png)", "![a](demo.png)"),
        ("README.md", "[a](docs/clash.md#rules)", "[a](clash.md#rules)"),
        ("README.md", "[a](ARCHITECTURE.md)", "[a](architecture.md)"),
        ("README.md", "[MIT](LICENSE-MIT)", "[MIT](https://host/who/blob/HEAD/LICENSE-MIT)"),
        ("README.md", "[examples](examples)", "[examples](https://host/who/tree/HEAD/examples)"),
        ("docs/clash.md", "[a](../bench/README.md#clash)", "[a](benchmarks.md#clash)"),
        ("docs/clash.md", "[a](../examples/part_out.py)", "[a](https://host/who/blob/HEAD/examples/part_out.py)"),
        ("docs/clash.md", "[a](parts.md), [b](#here)", "[a](parts.md), [b](#here)"),
        ("docs/clash.md", "![a [b] c](workbench/engine.jpg)", "![a [b] c](workbench/engine.jpg)"),
        ("docs/clash.md", "[a](https://example.org/x)", "[a](https://example.org/x)"),
        ("docs/clash.md", "```python\nx[0](../examples)\n```\n", "```python\nx[0](../examples)\n```\n"),
    ],
)
def test_links_lead_to_the_site_or_the_repository(source: str, link: str, expected: str, site: ModuleType) -> None:
    assert site.rewritten(link, source, "https://host/who") == expected


def test_without_a_repository_a_link_out_of_the_site_is_text(site: ModuleType, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.delenv("GITHUB_REPOSITORY", raising=False)
    assert site.repository() is None
    assert site.rewritten("see [this](../examples/part_out.py)", "docs/clash.md", None) == "see this"
    monkeypatch.setenv("GITHUB_REPOSITORY", "who/what")
    monkeypatch.setenv("GITHUB_SERVER_URL", "https://host")
    assert site.repository() == "https://host/who/what"


def test_a_link_to_nothing_ends_the_build(site: ModuleType) -> None:
    with pytest.raises(SystemExit, match=r"docs/clash\.md: nowhere\.md leads nowhere"):
        site.rewritten("[a](nowhere.md)", "docs/clash.md", None)


def test_dead_links_of_a_site_are_found(site: ModuleType, tmp_path: Path) -> None:
    (tmp_path / "guide").mkdir()
    (tmp_path / "style.css").write_text("")
    (tmp_path / "guide" / "index.html").write_text('<h2 id="top">a</h2><img src="../none.png"><a href="..#start">b</a>')
    (tmp_path / "index.html").write_text(
        '<h1 id="start">a</h1><link href="style.css"><a href="guide/#top">b</a><a href="guide/#no">c</a>'
        '<a href="#start">d</a><a href="#end">e</a><a href="gone/">f</a><a href="https://example.org/">g</a>'
    )
    (tmp_path / "404.html").write_text('<a href="/elsewhere/">a</a>')
    assert sorted(site.dead_links(tmp_path)) == [
        "guide/index.html: ../none.png",
        "index.html: #end",
        "index.html: gone/",
        "index.html: guide/#no",
    ]


def test_lists_stand_apart_from_their_paragraph(site: ModuleType, root: Path) -> None:
    """GitHub takes a list directly below a line of text for one, Python's Markdown does not."""
    glued = re.compile(r"^(?! *(?:[-*]|\d+\.) |\||#| )\S.*\n(?:[-*]|\d+\.) ", re.MULTILINE)
    pages = [root / name for name in site.TAKEN_IN] + [*root.glob("docs/*.md")]
    found = [
        f"{page.name}: {match[0].splitlines()[0]}"
        for page in pages
        for match in glued.finditer(site.FENCE.sub("", page.read_text(encoding="utf-8")))
    ]
    assert found == []


def test_a_workflow_publishes_it(root: Path) -> None:
    jobs = yaml.safe_load((root / ".github" / "workflows" / "docs.yml").read_text(encoding="utf-8"))["jobs"]
    assert [step["run"] for step in jobs["build"]["steps"] if "run" in step] == ["make docs"]
    (kept,) = (step for step in jobs["build"]["steps"] if "upload-pages-artifact" in step.get("uses", ""))
    assert kept["with"]["path"] == "target/site"
    assert jobs["publish"]["needs"] == "build"
    assert jobs["publish"]["permissions"] == {"pages": "write", "id-token": "write"}
