"""The page carries the licences of the packages that are in it, in each copy that is made of it."""

from __future__ import annotations

import json
from pathlib import Path

import pytest

import feeler
from feeler.workbench.files import static_files
from feeler.workbench.session.session import Session

PACKAGES = ("three", "preact", "@preact/signals", "@preact/signals-core")


def notice(root: Path, package: str) -> str:
    """The licence of a package, as it came with it."""
    path = root / "viewer" / "node_modules" / package / "LICENSE"
    if not path.is_file():
        pytest.skip("the page's packages are not installed: make page")
    return path.read_text(encoding="utf-8").strip()


def test_the_packages_are_those_the_page_is_made_of(root: Path) -> None:
    facts = json.loads((root / "viewer" / "package.json").read_text(encoding="utf-8"))
    # The last comes with @preact/signals.
    assert set(facts["dependencies"]) == {*PACKAGES} - {"@preact/signals-core"}


@pytest.mark.parametrize("package", PACKAGES)
def test_its_licence_is_in_the_wheel_the_script_and_the_file_to_send(root: Path, package: str) -> None:
    text = notice(root, package)
    version = json.loads((root / "viewer" / "node_modules" / package / "package.json").read_text(encoding="utf-8"))
    files = static_files()
    listed, script = (files[name].data.decode("utf-8") for name in ("/THIRD_PARTY.txt", "/main.js"))
    assert f"{package} {version['version']}, {version['license']}\n\n{text}" in listed
    assert text in script
    mockup = feeler.sample("carcass", 10_000)
    with Session(has_threads=False) as session:
        session.open(mockup, feeler.Scene(mockup), None)
        result = session.job("page", {}).result(60)
        assert text in session.export(result["name"]).decode("utf-8")
