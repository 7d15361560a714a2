"""The build backend: every package has the workbench's page, or the build ends with a sentence that says why not."""

from __future__ import annotations

import importlib
import json
import os
import subprocess
import sys
import tarfile
from pathlib import Path
from types import ModuleType

import pytest

if sys.version_info >= (3, 11):
    import tomllib
else:
    import tomli as tomllib

HOOKS = {
    f"{hook}{kind}"
    for kind in ("wheel", "editable")
    for hook in ("build_", "get_requires_for_build_", "prepare_metadata_for_build_")
} | {"build_sdist", "get_requires_for_build_sdist"}

POSIX = pytest.mark.skipif(os.name == "nt", reason="the programs are shell scripts")


@pytest.fixture
def backend(root: Path, monkeypatch: pytest.MonkeyPatch) -> ModuleType:
    """As a front end imports it: what pyproject.toml names, from where it says."""
    monkeypatch.setattr(os, "environ", os.environ.copy())  # the backend sets options of maturin for its process
    os.environ.pop("FEELER_NO_PAGE", None)
    system = tomllib.loads((root / "pyproject.toml").read_text(encoding="utf-8"))["build-system"]
    for path in system["backend-path"]:
        monkeypatch.syspath_prepend(str(root / path))
    sys.modules.pop(system["build-backend"], None)
    return importlib.import_module(system["build-backend"])


@pytest.fixture
def clone(tmp_path: Path) -> Path:
    """A clone as git leaves it: the page's sources, no page."""
    folder = tmp_path / "clone"
    (folder / "viewer").mkdir(parents=True)
    (folder / "viewer" / "package-lock.json").write_text("{}")
    return folder


def programs(folder: Path, monkeypatch: pytest.MonkeyPatch, **scripts: str) -> None:
    """Only these programs are on the PATH. Each writes its call into `calls`."""
    bin = folder / "bin"
    bin.mkdir()
    for name, script in scripts.items():
        (bin / name).write_text(f'#!/bin/sh\necho "{name} $*" >>{folder}/calls\n{script}\n')
        (bin / name).chmod(0o755)
    monkeypatch.setenv("PATH", str(bin))


def calls(folder: Path) -> list[str]:
    path = folder / "calls"
    return path.read_text().splitlines() if path.exists() else []


NODE = """case "$1" in --version) echo v22.1.0 ;;
*) /bin/mkdir -p ../python/feeler/workbench/static && echo page >../python/feeler/workbench/static/index.html ;; esac"""


def test_the_backend_has_all_hooks(backend: ModuleType) -> None:
    assert set(backend.__all__) == HOOKS
    assert all(callable(getattr(backend, hook)) for hook in HOOKS)


def test_node_is_as_new_as_the_page_needs(backend: ModuleType, root: Path) -> None:
    package = json.loads((root / "viewer" / "package.json").read_text(encoding="utf-8"))
    assert package["engines"]["node"] == f">={backend.OLDEST_NODE}"


@POSIX
def test_a_page_that_is_there_is_taken(
    backend: ModuleType, clone: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    programs(tmp_path, monkeypatch, npm="exit 1", node="exit 1")
    (clone / backend.PAGE).parent.mkdir(parents=True)
    (clone / backend.PAGE).write_text("mine")
    for required in (False, True):
        backend.ensure_page(clone, required=required)
    assert calls(tmp_path) == []
    assert (clone / backend.PAGE).read_text() == "mine"


@POSIX
@pytest.mark.parametrize("required", [False, True])
def test_node_builds_a_page_that_is_missing(
    required: bool,
    backend: ModuleType,
    clone: Path,
    tmp_path: Path,
    monkeypatch: pytest.MonkeyPatch,
    capfd: pytest.CaptureFixture[str],
) -> None:
    programs(tmp_path, monkeypatch, npm="echo from npm", node=NODE)
    backend.ensure_page(clone, required=required)
    assert (clone / backend.PAGE).read_text() == "page\n"
    assert calls(tmp_path) == ["node --version", "npm ci --no-progress --loglevel=error", "node build.mjs"]
    out, err = capfd.readouterr()
    assert out == "" and "from npm" in err, "pip reads the standard output"


@POSIX
@pytest.mark.parametrize(
    ("scripts", "said"),
    [
        ({}, "node was not found. Install Node 20 or later with npm"),
        ({"node": NODE}, "npm was not found. Install Node 20"),
        ({"node": "echo v18.19.0", "npm": "exit 0"}, "Node v18.19.0 is too old. Install Node 20"),
        ({"node": "exit 1", "npm": "exit 0"}, "Node (of no version) is too old."),
        ({"node": NODE, "npm": "exit 7"}, "--loglevel=error` in viewer/ failed with exit status 7"),
        ({"node": "echo v20.0.0", "npm": "exit 0"}, "build.mjs ran, but did not make python/feeler/workbench/static"),
    ],
)
def test_without_a_page_the_build_ends_with_a_reason(
    scripts: dict[str, str],
    said: str,
    backend: ModuleType,
    clone: Path,
    tmp_path: Path,
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    programs(tmp_path, monkeypatch, **scripts)
    with pytest.raises(backend.PageMissingError) as caught:
        backend.ensure_page(clone, required=False)
    message = str(caught.value).replace(f"{tmp_path}/bin/", "")
    assert message.startswith("feeler: ") and said in message
    assert ("set FEELER_NO_PAGE=1 to build without the page" in message) == ("Install" in message)


@POSIX
def test_a_package_without_its_page_and_without_its_sources(
    backend: ModuleType, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    programs(tmp_path, monkeypatch, node=NODE, npm="exit 0")
    with pytest.raises(backend.PageMissingError, match=r"its sources, viewer/, are not here\. Build from a clone"):
        backend.ensure_page(tmp_path, required=True)
    assert calls(tmp_path) == []


@POSIX
def test_a_wheel_without_the_page_is_asked_for(
    backend: ModuleType,
    clone: Path,
    tmp_path: Path,
    monkeypatch: pytest.MonkeyPatch,
    capsys: pytest.CaptureFixture[str],
) -> None:
    programs(tmp_path, monkeypatch)
    monkeypatch.setattr(backend, "ROOT", clone)
    built, stripped = [], []
    for hook in ("build_wheel", "build_editable", "build_sdist"):

        def build(*given: object, hook: str = hook) -> str:
            built.append((hook, *given))
            stripped.append(os.environ.get("MATURIN_STRIP"))
            return "name"

        monkeypatch.setattr(backend.maturin, hook, build)
    monkeypatch.setenv("FEELER_NO_PAGE", "1")
    assert backend.build_editable("out") == "name"
    assert backend.build_wheel("out", {"a": "b"}, "metadata") == "name"
    assert stripped == [None, "true"], "an editable installation keeps its symbols"
    assert "FEELER_NO_PAGE is set: no workbench page, so" in capsys.readouterr().err
    with pytest.raises(backend.PageMissingError, match="node was not found") as caught:
        backend.build_sdist("out")
    assert "FEELER_NO_PAGE" not in str(caught.value), "a source package always has the page"
    monkeypatch.setenv("FEELER_NO_PAGE", "0")
    for hook in (backend.build_wheel, backend.build_editable):
        with pytest.raises(backend.PageMissingError):
            hook("out")
    assert built == [("build_editable", "out", None, None), ("build_wheel", "out", {"a": "b"}, "metadata")]


def test_an_sdist_has_the_page_and_the_backend(root: Path, tmp_path: Path) -> None:
    static = root / "python" / "feeler" / "workbench" / "static"
    if not (static / "index.html").is_file():
        pytest.skip("no page is built here: make page")
    code = "import sys, feeler_build; print(feeler_build.build_sdist(sys.argv[1]))"
    path = os.pathsep.join([str(Path(sys.executable).parent), os.environ["PATH"]])  # where maturin is
    made = subprocess.run(
        [sys.executable, "-c", code, tmp_path],
        cwd=root,
        env={**os.environ, "PATH": path, "PYTHONPATH": str(root / "tools" / "build_backend")},
        capture_output=True,
        text=True,
        check=False,
    )
    assert made.returncode == 0, made.stderr
    assert "Warning" not in made.stderr
    with tarfile.open(tmp_path / made.stdout.splitlines()[-1]) as archive:
        names = {name.split("/", 1)[1] for name in archive.getnames()}
        (page,) = (member for member in archive.getmembers() if member.name.endswith("/static/index.html"))
        packed = archive.extractfile(page)
        assert packed is not None and packed.read() == (static / "index.html").read_bytes()
    wanted = {path.relative_to(root).as_posix() for path in static.rglob("*") if path.is_file()}
    wanted |= {"pyproject.toml", "Cargo.lock", "README.md", "tools/build_backend/feeler_build.py"}
    assert wanted <= names
    assert not [name for name in names if name.endswith((".so", ".pyd")) or "node_modules" in name]
