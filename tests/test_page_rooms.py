"""The rooms of the page's source: `tools/check_page.py` holds on the tree, and catches what it is for."""

from __future__ import annotations

import importlib
import shutil
import subprocess
import sys
from pathlib import Path
from types import ModuleType

import pytest


@pytest.fixture
def check_page(root: Path, monkeypatch: pytest.MonkeyPatch) -> ModuleType:
    monkeypatch.syspath_prepend(root / "tools")
    return importlib.import_module("check_page")


def checked(root: Path, tree: Path) -> subprocess.CompletedProcess[str]:
    command = [sys.executable, str(root / "tools" / "check_page.py"), str(tree)]
    return subprocess.run(command, capture_output=True, text=True, encoding="utf-8", check=False)


def test_rooms_hold(root: Path) -> None:
    found = checked(root, root)
    assert (found.returncode, found.stdout) == (0, "")


# Each: the file that is added to, what is added, and the complaint.
PLANTED = {
    "the connection knows a device": (
        "link/link.ts",
        'import type { Pointer } from "../input/mouse";',
        "link may not import input/mouse (of the page it may import: math)",
    ),
    "the picture knows the connection": (
        "scene/stage.ts",
        'import {\n  Link,\n} from "../link/link";',
        "scene may not import link/link (of the page it may import: link/protocol, math)",
    ),
    "a type by another name": (
        "model/document.ts",
        'export type { Stage } from "../scene/stage";',
        "model may not import scene/stage",
    ),
    "a type in the middle of a line": (
        "math/units.ts",
        'let store: import("../model/store").Store;',
        "math may not import model/store",
    ),
    "a component": ("actions/workbench.ts", 'import { App } from "../ui/app";', "actions may not import ui/app"),
    "an import for its effect": ("feel/sound.ts", 'import "../app/main";', "feel may not import app/main"),
    "a package": ("model/hand.ts", 'import { Vector3 } from "three";', "model may not import three"),
    "a file beside the rooms": ("attic.ts", "export const x = 1;", "no room for it in ROOMS"),
    "a room without a place": ("attic/x.ts", "export const x = 1;", "no room attic in ROOMS"),
    "a circle of types": (
        "model/settings.ts",
        'import type { Store } from "./store";',
        "viewer/src/model/settings.ts: in a circle of 2 files; one way round:",
    ),
}


@pytest.mark.parametrize("name", PLANTED)
def test_the_check_catches(name: str, root: Path, tmp_path: Path) -> None:
    where, text, complaint = PLANTED[name]
    shutil.copytree(root / "viewer" / "src", tmp_path / "viewer" / "src")
    file = tmp_path / "viewer" / "src" / where
    file.parent.mkdir(exist_ok=True)
    with file.open("a", encoding="utf-8") as opened:
        opened.write(text + "\n")
    found = checked(root, tmp_path)
    assert found.returncode == 1
    assert f"viewer/src/{where}" in found.stdout
    assert complaint in found.stdout


def test_a_room_of_the_table_is_there(check_page: ModuleType, tmp_path: Path) -> None:
    (tmp_path / "viewer" / "src" / "low").mkdir(parents=True)
    (tmp_path / "viewer" / "src" / "low" / "a.ts").write_text("export {};\n", encoding="utf-8")
    found = list(check_page.violations(tmp_path, {"low": set(), "high": {"low"}}, {}))
    assert found == ["viewer/src: room high of ROOMS in tools/check_page.py is not there"]


def test_comments_and_strings_are_no_imports(check_page: ModuleType) -> None:
    text = (
        '// import { a } from "./a";\n'
        '/* export * from "./b";\n   import "./c"; */\n'
        'const url = "https://d"; // from "./e"\n'
        'const text = `import "./f"`;\n'
        "import g from './g';\n"
    )
    assert list(check_page.imports(text)) == [(6, "./g")]
