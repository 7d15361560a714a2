"""The house itself: versions agree, `make help` is complete, the checks catch what they are for, the README works."""

from __future__ import annotations

import importlib.metadata
import os
import platform
import re
import shutil
import subprocess
import sys
from pathlib import Path

import pytest

if sys.version_info >= (3, 11):
    import tomllib
else:
    import tomli as tomllib


def run(*command: str | Path, cwd: Path, env: dict[str, str] | None = None) -> subprocess.CompletedProcess[str]:
    return subprocess.run(
        [str(part) for part in command],
        cwd=cwd,
        env={**os.environ, **(env or {})},
        stdin=subprocess.DEVNULL,
        capture_output=True,
        text=True,
        encoding="utf-8",
        check=False,
    )


def project(root: Path) -> dict[str, object]:
    table: dict[str, object] = tomllib.loads((root / "pyproject.toml").read_text(encoding="utf-8"))["project"]
    return table


def test_one_version_everywhere(root: Path) -> None:
    import feeler

    version = project(root)["version"]
    cargo = tomllib.loads((root / "Cargo.toml").read_text(encoding="utf-8"))
    assert cargo["workspace"]["package"]["version"] == version
    assert importlib.metadata.version("feeler") == version
    assert feeler.__version__ == version
    assert f"## [{version}]" in (root / "CHANGELOG.md").read_text(encoding="utf-8")


def test_the_wheel_serves_every_python_from_3_10_on() -> None:
    wheel = importlib.metadata.distribution("feeler").read_text("WHEEL")
    assert wheel is not None
    assert "Tag: cp310-abi3-" in wheel


def tuning(root: Path) -> str:
    """What pyproject.toml has maturin tell cargo, as `cargo --config` takes it."""
    (config,) = tomllib.loads((root / "pyproject.toml").read_text(encoding="utf-8"))["tool"]["maturin"]["config"]
    assert isinstance(config, str)
    return config


def test_a_wheel_asks_of_the_cpu_what_any_wheel_does(root: Path, tmp_path: Path) -> None:
    """The tuning names a CPU for the order of its instructions, and takes all that it has away again."""
    (flags,) = (target["rustflags"] for target in tomllib.loads(tuning(root))["target"].values())
    command = ("rustc", "--print", "cfg", "--target", "x86_64-unknown-linux-gnu")
    plain, named = run(*command, cwd=tmp_path), run(*command, *flags, cwd=tmp_path)
    assert plain.returncode == named.returncode == 0, plain.stderr + named.stderr
    assert 'target_feature="sse2"' in plain.stdout
    # No warning of a name that the compiler does not know either.
    assert (named.stdout, named.stderr) == (plain.stdout, plain.stderr)
    assert 'target_feature="avx512f"' in run(*command, flags[0], cwd=tmp_path).stdout


def test_only_maturin_tunes_for_a_cpu(root: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """What cargo does in this tree by itself is what it does anywhere; the tuning is one that it understands."""
    for name in ("RUSTFLAGS", "CARGO_ENCODED_RUSTFLAGS"):
        monkeypatch.delenv(name, raising=False)
    (tmp_path / "src").mkdir()
    (tmp_path / "src" / "lib.rs").write_text("")
    (tmp_path / "Cargo.toml").write_text('[package]\nname = "probe"\nedition = "2021"\n[workspace]\n')

    def flags(*words: str, where: Path = root) -> str:
        shutil.rmtree(tmp_path / "target", ignore_errors=True)  # cargo does not say how it made what is there
        paths = ("--manifest-path", str(tmp_path / "Cargo.toml"), "--target-dir", str(tmp_path / "target"))
        done = run("cargo", "check", "--verbose", "--offline", *paths, *words, cwd=where)
        assert done.returncode == 0, done.stderr
        assert "rustc --crate-name probe" in done.stderr
        return done.stderr

    for where in (root, *(root / "crates").iterdir()):
        assert "target-cpu" not in flags(where=where) and "target-feature" not in flags(where=where)
    if sys.platform == "linux" and platform.machine() == "x86_64":
        assert "-Ctarget-cpu=znver4" in flags("--config", tuning(root))


def test_make_help_lists_every_target(root: Path) -> None:
    if shutil.which("make") is None:
        pytest.skip("no make on the PATH")
    makefile = (root / "Makefile").read_text(encoding="utf-8")
    targets = set(re.findall(r"^([a-z][a-z-]*):(?!=)", makefile, re.MULTILINE))
    listed = run("make", "--no-print-directory", "help", cwd=root)
    assert listed.returncode == 0, listed.stderr
    assert targets == set(re.findall(r"^  make ([a-z-]+) ", listed.stdout, re.MULTILINE))
    assert {"setup", "build", "demo", "test", "lint", "format", "bench", "wheel", "clean"} <= targets
    phony = {name for line in re.findall(r"^\.PHONY: (.*)$", makefile, re.MULTILINE) for name in line.split()}
    assert targets <= phony, "a file of that name would switch the target off"


def test_ci_calls_the_targets_people_call(root: Path) -> None:
    script = (root / ".ci" / "run").read_text(encoding="utf-8")
    commands = [line for line in script.splitlines() if line and not line.startswith("#")]
    assert commands[0] == "set -euo pipefail"
    assert [line for line in commands if line.startswith("make ")] == ["make lint", "make test"]


def test_lock_pins_every_dependency(root: Path) -> None:
    lock = (root / "requirements.lock").read_text(encoding="utf-8")
    pinned = set(re.findall(r"^([a-z0-9-]+)==[\w.]+", lock, re.MULTILINE))
    data = tomllib.loads((root / "pyproject.toml").read_text(encoding="utf-8"))
    wanted = [
        *data["project"]["dependencies"],
        *(name for extra in data["project"]["optional-dependencies"].values() for name in extra),
        *(name for group in data["dependency-groups"].values() for name in group),
    ]
    names = {re.match(r"[\w-]+", requirement).group().lower() for requirement in wanted}
    assert names <= pinned, "run `make lock`"
    assert "://" not in lock
    assert all("==" in line for line in lock.splitlines() if line and not line.startswith(("#", " ")))


# --- the layering check ---------------------------------------------------------------------------------------------

PLANTED = {
    "the core prints": ("crates/feeler-core/src/lib.rs", '\nfn shout() { println!("hi"); }\n', "no printing"),
    "the core reads a clock": ("crates/feeler-core/src/lib.rs", "\nuse std::{fmt, time::Instant};\n", "no std::time"),
    "the core opens a file": ("crates/feeler-core/src/lib.rs", "\nuse std::fs::File;\n", "no std::fs"),
    "the core knows Python": ("crates/feeler-core/src/lib.rs", "\nuse pyo3::prelude::*;\n", "no pyo3"),
    "the core depends on the binding": (
        "crates/feeler-core/Cargo.toml",
        '\n[target."cfg(unix)".dependencies]\nfeeler-py = "0.1"\n',
        "may not depend on feeler-py",
    ),
    "io imports samples": (
        "python/feeler/io/__init__.py",
        "\ndef late():\n    from ..samples import sample\n",
        "io may not import feeler.samples",
    ),
    "io imports the command line": (
        "python/feeler/io/__init__.py",
        "\nfrom feeler import cli\n",
        "io may not import feeler.cli",
    ),
    "samples import io": (
        "python/feeler/samples/__init__.py",
        "\nimport feeler.io\n",
        "samples may not import feeler.io",
    ),
    "the package imports the benchmark": (
        "python/feeler/cli/__init__.py",
        "\nimport bench.run\n",
        "may not import bench.run",
    ),
    "a room without a place": ("python/feeler/attic.py", "x = 1\n", "room attic has no place"),
}


def copy_of_sources(root: Path, target: Path) -> Path:
    for name in ("crates", "python"):
        shutil.copytree(
            root / name, target / name, ignore=shutil.ignore_patterns("__pycache__", "*.so", "*.pyd", "target")
        )
    return target


def test_layers_hold(root: Path) -> None:
    checked = run(sys.executable, "tools/check_layers.py", cwd=root)
    assert checked.returncode == 0, checked.stdout


@pytest.mark.parametrize("name", PLANTED)
def test_layering_check_catches(name: str, root: Path, tmp_path: Path) -> None:
    where, text, complaint = PLANTED[name]
    copy = copy_of_sources(root, tmp_path)
    with (copy / where).open("a", encoding="utf-8") as file:
        file.write(text)
    checked = run(sys.executable, root / "tools" / "check_layers.py", copy, cwd=copy)
    assert checked.returncode == 1
    assert where in checked.stdout
    assert complaint in checked.stdout


def test_layering_check_lets_comments_speak(root: Path, tmp_path: Path) -> None:
    copy = copy_of_sources(root, tmp_path)
    with (copy / "crates/feeler-core/src/lib.rs").open("a", encoding="utf-8") as file:
        file.write('\n// pyo3 and std::time stay out; println! too.\nconst WHY: &str = "no std::fs here";\n')
    checked = run(sys.executable, root / "tools" / "check_layers.py", copy, cwd=copy)
    assert checked.returncode == 0, checked.stdout


# --- the file check -------------------------------------------------------------------------------------------------

STUMBLES = {
    "a long file": ("long.py", "x = 1\n" * 801, "801 lines"),
    "a left-over": ("a.py", "# TO" + "DO: finish\n", "left over"),
    "a left-over macro": ("a.rs", "fn f() { to" + "do!() }\n", "left over"),
    "unsafe without a reason": ("a.rs", "fn f() {\n    let x = unsafe { g() };\n}\n", "a.rs:2: unsafe without"),
    "a registry": ("notes.md", "see https" + "://pypi.example.org/simple\n", "package registry"),
    "somebody's disk": ("notes.md", "look in /ho" + "me/anna/models\n", "absolute path"),
}


def test_files_are_clean(root: Path) -> None:
    checked = run(sys.executable, "tools/check_files.py", cwd=root)
    assert checked.returncode == 0, checked.stdout


@pytest.mark.parametrize("name", STUMBLES)
def test_file_check_catches(name: str, root: Path, tmp_path: Path) -> None:
    where, text, complaint = STUMBLES[name]
    (tmp_path / where).write_text(text, encoding="utf-8")
    checked = run(sys.executable, root / "tools" / "check_files.py", tmp_path, cwd=tmp_path)
    assert checked.returncode == 1
    assert complaint in checked.stdout


def test_file_check_accepts_a_reason(root: Path, tmp_path: Path) -> None:
    code = """fn f() {
    // SAFETY: g has no preconditions,
    // says its documentation.
    let x =
        unsafe { g() };
}
"""
    (tmp_path / "a.rs").write_text(code, encoding="utf-8")
    checked = run(sys.executable, root / "tools" / "check_files.py", tmp_path, cwd=tmp_path)
    assert checked.returncode == 0, checked.stdout


# --- the README -----------------------------------------------------------------------------------------------------


def test_readme_quick_start_runs(root: Path, tmp_path: Path) -> None:
    readme = (root / "README.md").read_text(encoding="utf-8")
    block = re.search(r"^```python\n(.*?)^```", readme, re.MULTILINE | re.DOTALL)
    assert block is not None, "the README has no quick start in Python"
    assert block.group(1).count("\n") <= 25, "a quick start is about 20 lines"
    script = tmp_path / "quick_start.py"
    script.write_text(block.group(1), encoding="utf-8")
    done = run(sys.executable, "-W", "error", script, cwd=tmp_path, env={"PYTHONIOENCODING": "utf-8"})
    assert done.returncode == 0, done.stderr


def test_readme_links_lead_somewhere(root: Path) -> None:
    broken = []
    for page in [*root.glob("*.md"), *root.glob("docs/**/*.md")]:
        text = re.sub(r"^```.*?^```", "", page.read_text(encoding="utf-8"), flags=re.MULTILINE | re.DOTALL)
        for link in re.findall(r"\]\(([^)\s]+)\)", text):
            target = link.split("#")[0]
            if (
                target
                and "://" not in target
                and not target.startswith("mailto:")
                and not (page.parent / target).exists()
            ):
                broken.append(f"{page.relative_to(root)}: {link}")
    assert not broken
