"""What is published: the wheel that `make wheel` makes, the smoke test, and the workflow for all platforms."""

from __future__ import annotations

import re
import sys
import zipfile
import zlib
from pathlib import Path
from types import SimpleNamespace
from typing import Any

import pytest
import yaml

if sys.version_info >= (3, 11):
    import tomllib
else:
    import tomli as tomllib

PLATFORMS = {
    f"{system}-{cpu}"
    for system, cpus in {
        "manylinux": ("x86_64", "aarch64"),
        "musllinux": ("x86_64", "aarch64"),
        "macos": ("x86_64", "arm64"),
        "windows": ("x86_64", "arm64"),
    }.items()
    for cpu in cpus
}
# macOS on ARM is the ordinary runner.
ARM_RUNNERS = {"manylinux-aarch64", "musllinux-aarch64", "windows-arm64"}
WHEELS = {"cp310-abi3", "cp314-cp314t", "cp315-abi3.abi3t"}


def workflow(path: Path) -> dict[str, Any]:
    read: dict[str, Any] = yaml.safe_load(path.read_text(encoding="utf-8"))
    return read


@pytest.fixture(scope="module")
def jobs(root: Path) -> dict[str, Any]:
    found: dict[str, Any] = workflow(root / ".github" / "workflows" / "release.yml")["jobs"]
    return found


def needs(jobs: dict[str, Any], name: str) -> set[str]:
    said = jobs[name].get("needs", [])
    return {said} if isinstance(said, str) else {*said}


def uses(job: dict[str, Any], action: str) -> list[int]:
    """The places of the steps that use an action."""
    return [i for i, step in enumerate(job["steps"]) if step.get("uses", "").split("@")[0].lower() == action.lower()]


def test_eight_platforms_are_built_and_used(jobs: dict[str, Any]) -> None:
    built = jobs["wheels"]["strategy"]["matrix"]["include"]
    used = jobs["smoke"]["strategy"]["matrix"]
    assert sorted(row["platform"] for row in built) == sorted(PLATFORMS)
    assert sorted(row["platform"] for row in used["system"]) == sorted(PLATFORMS)
    runners = {row["platform"]: row["runner"] for row in used["system"]}
    for row in built:
        assert runners[row["platform"]] == row["runner"], "built where it can run"
        assert row["runner"].endswith("arm") == (row["platform"] in ARM_RUNNERS)
        assert bool(row.get("manylinux")) == ("linux" in row["platform"])
        assert (row["target"] == "aarch64") == row["platform"].endswith(("aarch64", "arm64"))
        assert ("musl" in row.get("manylinux", "")) == row["platform"].startswith("musl")


def test_three_wheels_serve_every_python(jobs: dict[str, Any]) -> None:
    builds = [step for step in jobs["wheels"]["steps"] if "maturin-action" in step.get("uses", "")]
    assert {step["name"] for step in builds} == {"cp310-abi3", "cp314t", "cp315-abi3.abi3t"}
    for step in builds:
        words = step["with"]["args"].split()
        assert {"--release", "--locked", "--strip"} <= {*words}
        version = step["with"]["args"].split("-i ${{ matrix.interpreter }}")[1].split()[0]
        assert version == {"cp310-abi3": "3.13", "cp314t": "3.14t", "cp315-abi3.abi3t": "3.15"}[step["name"]]
        assert ("pyo3/abi3t-py315" in step["with"]["args"]) == ("abi3t" in step["name"])
    assert {row["tag"] for row in jobs["smoke"]["strategy"]["matrix"]["wheel"]} == WHEELS


def test_the_page_is_built_once_and_before_all_packages(jobs: dict[str, Any]) -> None:
    made = [name for name, job in jobs.items() if any(step.get("run") == "make page" for step in job["steps"])]
    assert made == ["page"]
    for name in ("wheels", "sdist"):
        assert "page" in needs(jobs, name)
        steps = jobs[name]["steps"]
        (fetched, *_) = uses(jobs[name], "actions/download-artifact")
        assert steps[fetched]["with"] == {"name": "page", "path": "python/feeler/workbench/static"}
        build = [
            i for i, step in enumerate(steps) if "maturin" in step.get("uses", "") or "build" in step.get("run", "")
        ]
        assert fetched < min(build)
    kept, _ = uses(jobs["page"], "actions/upload-artifact")
    assert jobs["page"]["steps"][kept]["with"]["path"] == "python/feeler/workbench/static"


def test_every_package_is_used_before_it_is_published(jobs: dict[str, Any]) -> None:
    smoked = {
        name for name, job in jobs.items() if any("tools/smoke.py" in step.get("run", "") for step in job["steps"])
    }
    assert smoked == {"smoke", "sdist"}
    assert "wheels" in needs(jobs, "smoke")
    linux, others = (step for step in jobs["smoke"]["steps"] if "tools/smoke.py" in step.get("run", ""))
    assert (linux["if"], others["if"]) == ("runner.os == 'Linux'", "runner.os != 'Linux'")
    assert needs(jobs, "publish") == jobs.keys() - {"publish"}
    assert not any(job.get("continue-on-error") for job in jobs.values())


def test_the_oldest_python_is_used_too(jobs: dict[str, Any], root: Path) -> None:
    project = tomllib.loads((root / "pyproject.toml").read_text(encoding="utf-8"))["project"]
    oldest = project["requires-python"].removeprefix(">=")
    matrix = jobs["smoke"]["strategy"]["matrix"]
    added = [row for row in matrix["include"] if row["wheel"] == {"tag": "cp310-abi3", "python": oldest}]
    assert len(added) == len(matrix["include"]) and {row["system"]["platform"].split("-")[0] for row in added} == {
        "manylinux",
        "macos",
        "windows",
    }
    assert all(row["system"] in matrix["system"] for row in added)


def test_wheels_are_audited_as_they_are_published(jobs: dict[str, Any]) -> None:
    steps = jobs["pack"]["steps"]
    said = [step.get("run", "") for step in steps]
    packed, audited = (said.index(f"python tools/{name} dist/*.whl") for name in ("pack_wheel.py", "audit_wheels.py"))
    (kept,) = uses(jobs["pack"], "actions/upload-artifact")
    assert packed < audited < kept
    assert {*jobs["pack"]["strategy"]["matrix"]["platform"]} == PLATFORMS


@pytest.mark.parametrize("tool", ["audit_wheels"], indirect=True)
def test_audits_refuse_newer_systems_and_more_than_the_stable_abi(tool: Any, monkeypatch: pytest.MonkeyPatch) -> None:
    asked: list[str] = []
    status = 0

    def run(words: list[str], **_: Any) -> Any:
        asked.append(words[2])
        return SimpleNamespace(returncode=status)

    monkeypatch.setattr(tool.subprocess, "run", run)
    monkeypatch.setattr(tool, "glibc_needed", lambda wheel: "manylinux_2_27_x86_64")
    plain, musl = "feeler-1.0-cp310-abi3-{}.whl", "musllinux_1_2_x86_64"
    assert tool.complaints(Path(plain.format("manylinux_2_28_x86_64"))) == [] and asked == ["abi3audit"]
    assert "needs manylinux_2_27" in tool.complaints(Path(plain.format("manylinux_2_17_x86_64")))[0]
    assert tool.complaints(Path(plain.format(musl))) == [] and len(asked) == 3
    assert tool.complaints(Path(f"feeler-1.0-cp314-cp314t-{musl}.whl")) == [] and len(asked) == 3
    status = 1
    assert "more than the stable ABI" in tool.complaints(Path(plain.format("win_amd64")))[0]
    monkeypatch.setattr(sys, "argv", ["audit_wheels"])
    with pytest.raises(SystemExit, match="at least one"):
        tool.main()


@pytest.mark.parametrize("tool", ["front_page"], indirect=True)
def test_a_package_index_has_no_dead_link(tool: Any, jobs: dict[str, Any], root: Path) -> None:
    readme = (root / "README.md").read_text(encoding="utf-8")
    page = tool.with_addresses(readme, "https://host/who", "abc")
    links = [target for _, _, target in tool.LINK.findall(tool.FENCE.sub("", page))]
    assert len(links) > 20 and all(link.startswith(("https://", "#")) for link in links), links
    assert "![" in page and "](https://host/who/raw/abc/docs/demo.png)" in page
    assert "](https://host/who/tree/abc/examples)" in page and "](https://host/who/blob/abc/docs/clash.md)" in page
    with pytest.raises(SystemExit, match=r"nowhere\.md leads nowhere"):
        tool.with_addresses("[a](nowhere.md)", "https://host/who", "abc")
    project = (root / "pyproject.toml").read_text(encoding="utf-8")
    read, plain = tomllib.loads(tool.with_urls(project, "https://host/who", "abc")), tomllib.loads(project)
    urls = read["project"].pop("urls")
    assert urls["Repository"] == "https://host/who" and all(url.startswith("https://") for url in urls.values())
    assert read == plain
    for name in ("wheels", "sdist"):
        steps = jobs[name]["steps"]
        (fetched,) = (i for i, step in enumerate(steps) if step.get("with", {}).get("name") == "front")
        builds = [
            i for i, step in enumerate(steps) if "maturin" in step.get("uses", "") or "-m build" in str(step.get("run"))
        ]
        assert fetched < min(builds)
    (made,) = (i for i, step in enumerate(jobs["page"]["steps"]) if "front_page.py" in step.get("run", ""))
    kept = [jobs["page"]["steps"][i]["with"] for i in uses(jobs["page"], "actions/upload-artifact") if i > made]
    assert kept == [{"name": "front", "path": "README.md\npyproject.toml\n", "if-no-files-found": "error"}]


def test_only_a_tag_publishes_and_without_a_password(jobs: dict[str, Any], root: Path) -> None:
    publish = jobs["publish"]
    assert publish["if"] == "startsWith(github.ref, 'refs/tags/v')"
    assert publish["environment"] == "pypi"
    assert publish["permissions"] == {"id-token": "write"}
    assert uses(publish, "pypa/gh-action-pypi-publish") == [1]
    text = (root / ".github" / "workflows" / "release.yml").read_text(encoding="utf-8")
    assert "secrets." not in text
    assert workflow(root / ".github" / "workflows" / "release.yml")["permissions"] == {"contents": "read"}


def test_actions_are_pinned_by_version(root: Path) -> None:
    for path in (root / ".github" / "workflows").glob("*.yml"):
        steps = [step for job in workflow(path)["jobs"].values() for step in job["steps"] if "uses" in step]
        assert steps
        for step in steps:
            assert re.fullmatch(r"[\w-]+/[\w-]+@v\d+\.\d+\.\d+", step["uses"]), step["uses"]
        for job in workflow(path)["jobs"].values():
            assert job["timeout-minutes"] <= 90


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
        ("cp310-abi3-manylinux_2_28_x86_64", {"index.html", "main.js"}, 5_000_000, "at most 4,700,000"),
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


@pytest.mark.parametrize("tool", ["pack_wheel"], indirect=True)
def test_a_packed_wheel_has_the_same_files(tool: Any, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """zopfli is not installed beside the tests: zlib stands in for it."""
    stand_in = SimpleNamespace(compress=lambda data, numiterations: zlib.compress(data, 9))
    monkeypatch.setitem(sys.modules, "zopfli", SimpleNamespace(zlib=stand_in))
    monkeypatch.setitem(sys.modules, "zopfli.zlib", stand_in)
    wheel = tmp_path / "feeler-0.1.0-cp310-abi3-win_arm64.whl"
    files = {
        "feeler/_core.pyd": b"code " * 10_000,
        "feeler/py.typed": b"",
        "feeler/größe.txt": b"1",
        "RECORD": b"a,b\n",
    }
    with zipfile.ZipFile(wheel, "w", zipfile.ZIP_DEFLATED, compresslevel=1) as archive:
        for name, data in files.items():
            info = zipfile.ZipInfo(name, (2026, 11, 28, 23, 59, 58))
            info.external_attr = (0o100755 if name.endswith("pyd") else 0o100644) << 16
            archive.writestr(info, data, zipfile.ZIP_DEFLATED)
        before = [(i.filename, i.date_time, i.external_attr, i.CRC) for i in archive.infolist()]
    size = wheel.stat().st_size
    tool.pack(wheel)
    assert wheel.stat().st_size < size and [path.name for path in tmp_path.iterdir()] == [wheel.name]
    with zipfile.ZipFile(wheel) as archive:
        assert archive.testzip() is None
        assert [(i.filename, i.date_time, i.external_attr, i.CRC) for i in archive.infolist()] == before
        assert {name: archive.read(name) for name in archive.namelist()} == files


def test_wheels_are_packed_before_they_are_used(jobs: dict[str, Any]) -> None:
    assert sorted(jobs["pack"]["strategy"]["matrix"]["platform"]) == sorted(PLATFORMS)
    assert "wheels" in needs(jobs, "pack") and "pack" in needs(jobs, "smoke")
    (kept,) = uses(jobs["pack"], "actions/upload-artifact")
    (run,) = (i for i, step in enumerate(jobs["pack"]["steps"]) if "tools/pack_wheel.py" in step.get("run", ""))
    assert run < kept and jobs["pack"]["steps"][kept]["with"]["overwrite"] is True


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


def test_what_everyone_installs_has_wheels_everywhere(root: Path) -> None:
    """pip installs nothing of feeler where one of these has no wheel. CONTRIBUTING.md says how to check another one."""
    project = tomllib.loads((root / "pyproject.toml").read_text(encoding="utf-8"))["project"]
    names = {re.match(r"[\w-]+", requirement).group().lower() for requirement in project["dependencies"]}  # type: ignore[union-attr]
    assert names == {"numpy", "rich", "tomli", "typer", "websockets"}
