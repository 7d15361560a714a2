"""What is published: the wheel that `make wheel` makes, and the smoke test."""

from __future__ import annotations

import re
import zipfile
from pathlib import Path
from typing import Any

import pytest


@pytest.fixture
def tool(request: pytest.FixtureRequest, root: Path, monkeypatch: pytest.MonkeyPatch) -> Any:
    monkeypatch.syspath_prepend(str(root / "tools"))
    return __import__(request.param)


@pytest.mark.parametrize("tool", ["make_wheel"], indirect=True)
def test_a_target_has_its_platform_tag(tool: Any) -> None:
    for target, tag in {
        "x86_64-unknown-linux-gnu": "manylinux_2_28_x86_64",
        "aarch64-unknown-linux-gnu": "manylinux_2_28_aarch64",
        "aarch64-unknown-linux-musl": "musllinux_1_2_aarch64",
        "aarch64-apple-darwin": "macosx_11_0_arm64",
        "x86_64-apple-darwin": "macosx_10_12_x86_64",
        "x86_64-pc-windows-msvc": "win_amd64",
        "aarch64-pc-windows-msvc": "win_arm64",
    }.items():
        assert re.fullmatch(tool.tag_of(target), tag), target


@pytest.mark.parametrize("tool", ["make_wheel"], indirect=True)
def test_the_oldest_system_served(tool: Any) -> None:
    limit = "manylinux_2_28_x86_64"
    assert tool.no_newer("manylinux_2_17_x86_64", limit) and tool.no_newer(limit, limit)
    for tag in ("manylinux_2_34_x86_64", "manylinux_3_1_x86_64", "manylinux_2_28_aarch64", "linux_x86_64"):
        assert not tool.no_newer(tag, limit), tag
    assert not tool.no_newer("musllinux_1_1_x86_64", limit)


@pytest.mark.parametrize("tool", ["make_wheel"], indirect=True)
@pytest.mark.parametrize(
    ("name", "files", "filling", "said"),
    [
        ("cp310-abi3-manylinux_2_28_x86_64", {"index.html", "main.js"}, 0, None),
        ("cp311-abi3-manylinux_2_28_x86_64", {"index.html", "main.js"}, 0, "its name should end with cp310-abi3-"),
        ("cp310-abi3-linux_x86_64", {"index.html", "main.js"}, 0, "its name should end with"),
        ("cp310-abi3-manylinux_2_28_x86_64", {"index.html"}, 0, r"its page is \['index.html'\], not"),
        ("cp310-abi3-manylinux_2_28_x86_64", {"index.html", "main.js"}, 5_000_000, "at most 5,000,000"),
    ],
)
def test_a_wheel_that_is_not_whole_is_refused(
    tool: Any, name: str, files: set[str], filling: int, said: str | None, tmp_path: Path
) -> None:
    wheel = tmp_path / f"feeler-0.1.0-{name}.whl"
    with zipfile.ZipFile(wheel, "w") as archive:
        for file in files:
            archive.writestr(tool.PAGE + file, "")
        archive.writestr("feeler/_core.abi3.so", bytes(filling))
    found = tool.complaints(wheel, "x86_64-unknown-linux-gnu", {"index.html", "main.js"})
    assert len(found) == (said is not None), found
    assert said is None or re.search(said, found[0])


@pytest.mark.parametrize("tool", ["make_wheel"], indirect=True)
def test_a_wheel_without_any_page_is_refused(tool: Any, tmp_path: Path) -> None:
    wheel = tmp_path / "feeler-0.1.0-cp310-abi3-win_arm64.whl"
    with zipfile.ZipFile(wheel, "w") as archive:
        archive.writestr("feeler/__init__.py", "")
    assert tool.complaints(wheel, "aarch64-pc-windows-msvc", set()) == ["the page is not built: make page"]


@pytest.mark.parametrize("tool", ["smoke"], indirect=True)
def test_the_smoke_test_knows_the_answer(tool: Any, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """Its fingerprint is that of the pairs that this tree finds, and of no others."""
    import feeler
    from feeler.io import write_glb, write_stl

    monkeypatch.chdir(tmp_path)
    write_glb("gearbox.glb", feeler.sample("gearbox", triangles=100_000))
    write_stl("wrench.stl", feeler.sample_tool("wrench"))
    scene = feeler.Scene(feeler.load_mockup("gearbox.glb"))
    pose = [[1, 0, 0, 0], [0, 1, 0, 0], [0, 0, 1, 0], [0, 0, 0, 1]]
    for row, number in zip(pose, tool.AT.split(","), strict=False):
        row[3] = float(number)
    hit = scene.collide(feeler.load_tool("wrench.stl", unit="mm"), pose)
    pairs = hit.pairs.tolist()
    assert (len(pairs), tool.fingerprint(pairs)) == (tool.PAIRS, tool.GOLDEN)
    assert tool.fingerprint(pairs[::-1]) == tool.GOLDEN, "in no order"
    assert tool.fingerprint([*pairs[:-1], [pairs[-1][0], pairs[-1][1] + 1]]) != tool.GOLDEN
    # Nothing within a hair of a limit: the last bit of a platform's sine may not decide.
    assert hit.stats.exact_tests == 0
