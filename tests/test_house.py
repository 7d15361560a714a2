"""The house itself: versions agree, `make help` is complete, the checks catch what they are for."""

from __future__ import annotations

import importlib
import importlib.metadata
import os
import platform
import re
import shutil
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


def test_crates_can_be_published(root: Path, tmp_path: Path) -> None:
    """The packages hold sources, README and licences, no test that cannot run. `make package` compiles them, too."""
    published = re.search(r"^PUBLISHED := (.*)$", (root / "Makefile").read_text(encoding="utf-8"), re.MULTILINE)
    assert published is not None
    manifests = [tomllib.loads(path.read_text(encoding="utf-8")) for path in root.glob("crates/*/Cargo.toml")]
    packages = {data["package"]["name"]: data["package"] for data in manifests}
    assert {name for name, package in packages.items() if package.get("publish", True)} == set(published[1].split())

    crates = [word for name in published[1].split() for word in ("-p", name)]
    options = ("--allow-dirty", "--no-verify", "--offline", "--target-dir", str(tmp_path))
    made = run("cargo", "package", *options, *crates, cwd=root)
    assert made.returncode == 0, made.stderr
    for name in published[1].split():
        (path,) = tmp_path.glob(f"package/{name}-*.crate")
        with tarfile.open(path) as archive:
            files = {member.name.split("/", 1)[1]: member for member in archive.getmembers()}
            assert {"src/lib.rs", "README.md", "LICENSE-MIT", "LICENSE-APACHE"} <= files.keys()
            assert not any(file.startswith("tests/") for file in files)
            licence = archive.extractfile(files["LICENSE-MIT"])
            assert licence is not None and licence.read() == (root / "LICENSE-MIT").read_bytes()
        assert packages[name]["readme"] == "README.md"
        assert "```rust" in (root / "crates" / name / "README.md").read_text(encoding="utf-8")


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
    made = [re.sub(r" -\S+", "", line) for line in commands if line.startswith("make ")]
    assert made == ["make lint", "make test"]


@pytest.mark.parametrize("own", ["", "wheel", "docs"])
def test_lock_pins_every_dependency(own: str, root: Path) -> None:
    """The groups `wheel` and `docs` have lock files of their own, so that few install them."""
    lock = (root / f"requirements{own and '-'}{own}.lock").read_text(encoding="utf-8")
    pinned = set(re.findall(r"^([a-z0-9-]+)==[\w.]+", lock, re.MULTILINE))
    data = tomllib.loads((root / "pyproject.toml").read_text(encoding="utf-8"))
    groups = data["dependency-groups"]
    if own:
        wanted = groups[own]
    else:
        wanted = [
            *data["project"]["dependencies"],
            *(name for extra in data["project"]["optional-dependencies"].values() for name in extra),
            *(name for group in groups.keys() - {"wheel", "docs"} for name in groups[group]),
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
    "the core is unsafe": ("crates/feeler-core/src/lib.rs", "\nunsafe fn poke() {}\n", "no unsafe code"),
    "the core's errors know the scene": (
        "crates/feeler-core/src/error.rs",
        "\nuse crate::scene::Scene;\n",
        "error may not import Scene of scene",
    ),
    "the core takes its shapes from the tests": (
        "crates/feeler-core/Cargo.toml",
        '\n[target."cfg(unix)".dependencies]\nfeeler-shapes = "0.1"\n',
        "may depend on feeler-shapes for tests alone",
    ),
    "the core is tested by its judge": (
        "crates/feeler-core/Cargo.toml",
        '\n[target."cfg(unix)".dev-dependencies]\nfeeler-exact = "0.1"\n',
        "may not depend on feeler-exact",
    ),
    "the core depends on the binding": (
        "crates/feeler-core/Cargo.toml",
        '\n[target."cfg(windows)".dependencies]\nfeeler-py = "0.1"\n',
        "may not depend on feeler-py",
    ),
    "a crate takes any version of the core": (
        "crates/feeler-plan/Cargo.toml",
        '\n[target."cfg(unix)".dependencies]\nfeeler-core = { path = "../feeler-core", version = "0.1.0" }\n',
        "feeler-core must be `feeler-core.workspace = true`",
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
    "the document imports the engine": (
        "python/feeler/workbench/document/history.py",
        "\ndef late():\n    from ..engine import trip\n",
        "document may not import trip of engine",
    ),
    "the session imports the server": (
        "python/feeler/workbench/session/events.py",
        "\nfrom feeler.workbench.net.server import Server\n",
        "session may not import Server of net",
    ),
    "a room of the workbench without a place": (
        "python/feeler/workbench/attic.py",
        "x = 1\n",
        "room attic has no place in INNER_ROOMS",
    ),
    "two files of Python in a circle": (
        "python/feeler/clashes/changes.py",
        "\ndef late():\n    from feeler.clashes.result import Clashes\n",
        "imports python/feeler/clashes/result.py and back",
    ),
}


COMMENTED = "crates/feeler-core/src/constants.rs"


def copy_of_sources(root: Path, target: Path) -> Path:
    for name in ("crates", "python"):
        shutil.copytree(
            root / name, target / name, ignore=shutil.ignore_patterns("__pycache__", "*.so", "*.pyd", "target")
        )
    return target


def test_layers_hold(root: Path) -> None:
    checked = run(sys.executable, "tools/check_layers.py", cwd=root)
    assert checked.returncode == 0, checked.stdout


@pytest.fixture(scope="module")
def complaints(root: Path, tmp_path_factory: pytest.TempPathFactory) -> list[str]:
    """What the check says of the sources with all that is planted."""
    copy = copy_of_sources(root, tmp_path_factory.mktemp("planted"))
    spoken = '\n// pyo3 and std::time stay out; println! too.\nconst WHY: &str = "no std::fs here";\n'
    for where, text in [*((where, text) for where, text, _ in PLANTED.values()), (COMMENTED, spoken)]:
        with (copy / where).open("a", encoding="utf-8") as file:
            file.write(text)
    checked = run(sys.executable, root / "tools" / "check_layers.py", copy, cwd=copy)
    assert checked.returncode == 1
    return checked.stdout.splitlines()


@pytest.mark.parametrize("name", PLANTED)
def test_layering_check_catches(name: str, complaints: list[str]) -> None:
    where, _, complaint = PLANTED[name]
    assert [line for line in complaints if line.startswith(where) and complaint in line], complaints


def test_a_pin_that_is_no_pin_is_caught(layers: ModuleType, root: Path, tmp_path: Path) -> None:
    manifest = (root / "Cargo.toml").read_text(encoding="utf-8")
    (tmp_path / "Cargo.toml").write_text(manifest, encoding="utf-8")
    assert list(layers.pin_violations(tmp_path)) == []
    loose = manifest.replace('feeler-world", version = "=', 'feeler-world", version = "')
    (tmp_path / "Cargo.toml").write_text(loose, encoding="utf-8")
    (found,) = layers.pin_violations(tmp_path)
    assert found.startswith("Cargo.toml: feeler-world must be of version")


def test_layering_check_lets_comments_speak(complaints: list[str]) -> None:
    assert not [line for line in complaints if line.startswith(COMMENTED)]


def crate_at(root: Path, files: dict[str, str], name: str = "feeler-core") -> Path:
    """A crate of these files of src/; its `lib.rs` names those beside it where it is not given."""
    crate = root / "crates" / name
    rooms = sorted({file.split("/")[0].removesuffix(".rs") for file in files})
    head = {"lib.rs": "".join(f"mod {room};\n" for room in rooms)}
    for file, text in {**head, **files}.items():
        path = crate / "src" / file
        path.parent.mkdir(parents=True, exist_ok=True)
        path.write_text(text, encoding="utf-8")
    (crate / "Cargo.toml").write_text(f'[package]\nname = "{name}"\n', encoding="utf-8")
    return crate


@pytest.fixture
def layers(root: Path, monkeypatch: pytest.MonkeyPatch) -> ModuleType:
    monkeypatch.syspath_prepend(root / "tools")
    return importlib.import_module("check_layers")


# Each: the files, and the arrows between them with the names that make each.
B = "pub struct One; pub(crate) fn two() {} pub const THREE: [u8; 1] = [{ 3 }]; pub enum Four { A }"
DOOR = {"room/mod.rs": "mod leaf;\npub use leaf::Leaf;\n", "room/leaf.rs": "pub struct Leaf;\n"}
READ = {
    "a use tree": (
        {
            "a.rs": "use crate::{b::{self, One, deep::{Five as Cinq}}, c::Six};\nfn f() { b::two(); }\n",
            "b.rs": f"pub mod deep {{ pub struct Five; }}\n{B}",
            "c.rs": "pub union Six { a: u8 }",
        },
        {"a b": {"One", "Five", "two"}, "a c": {"Six"}},
    ),
    "a use of several lines": (
        {"a.rs": "use crate::b::{\n    One, // first\n    THREE,\n    /* then */ Four as Quatre,\n};\n", "b.rs": B},
        {"a b": {"One", "THREE", "Four"}},
    ),
    "every kind of item": (
        {
            "a.rs": "use crate::b::*;\nfn f() { A; B; C; D; E; F; G; H!(); I; J; }\n",
            "b.rs": """
                pub(crate) const unsafe extern "C" fn A<const N: usize>(x: [u8; N]) where [u8; N]: Sized, { fn b() {} }
                pub struct B<T>(pub(in crate::b) T);
                pub enum C { X { y: u8 } }
                pub unsafe trait D { fn inner(&self) { } }
                pub const E: C = C::X { y: 1 };
                pub static mut F: u8 = { 2 };
                pub type G = [u8; 4];
                macro_rules! H { () => { struct Inner; } }
                pub(crate) use H;
                pub union I { x: u8 }
                extern "C" { pub fn J(); }""",
        },
        {"a b": set("ABCDEFGHIJ")},
    ),
    "a path in the code": (
        {
            "a/mod.rs": "mod x;\nstruct Own;\nimpl crate::b::Four { fn f(x: u8) -> u8 { x } }\n",
            "a/x.rs": "fn f(_: &super::Own) -> [u8; 1] { super::super::b::two(); crate::b::THREE }\n",
            "b.rs": B,
        },
        {"a/mod b": {"Four"}, "a/x a/mod": {"Own"}, "a/x b": {"two", "THREE"}},
    ),
    "a module by another name": (
        {"a.rs": "use crate::b as other;\nfn f() { other::two(); other::Four::A; }\n", "b.rs": B},
        {"a b": {"two", "Four"}},
    ),
    "a module of which nothing is used": ({"a.rs": "use crate::b;\n", "b.rs": B}, {"a b": {"b"}}),
    "a use in a function": (
        {
            "a.rs": "fn f() { use crate::b::two; two(); { use crate::c; c::g(); } c::h(); }\n",
            "b.rs": B,
            "c.rs": "pub fn g() {} pub fn h() {}",
        },
        {"a b": {"two"}, "a c": {"g"}},
    ),
    "a door": (
        {**DOOR, "lib.rs": "mod a;\nmod room;\npub use room::Leaf;\n", "a.rs": "use crate::{room::Leaf as L, Leaf};\n"},
        {"a room/leaf": {"Leaf"}},
    ),
    "a door that uses what it shows": (
        {**DOOR, "room/mod.rs": "mod leaf;\npub use leaf::Leaf;\nfn f(_: Leaf) {}\n"},
        {"room/mod room/leaf": {"Leaf"}},
    ),
    "a door and words that only look like what it shows": (
        {
            "room/mod.rs": "mod leaf;\npub use leaf::go;\nfn f(s: S, go: u8) -> S { let x = go; s.go(); S { go } }\n",
            "room/leaf.rs": "pub fn go() {}\n",
        },
        {},
    ),
    "a door with its own name for it": (
        {**DOOR, "room/mod.rs": "mod leaf;\npub use leaf::Leaf as Blade;\n", "a.rs": "use crate::room::Blade;\n"},
        {"a room/leaf": {"Leaf"}},
    ),
    "a door to another room": (
        {**DOOR, "a.rs": "pub(crate) use crate::room::Leaf;", "c.rs": "use crate::a::Leaf;"},
        {"a room/leaf": {"Leaf"}, "c room/leaf": {"Leaf"}},
    ),
    "a module and a function of one name": (
        {
            "room/mod.rs": "pub mod search;\nmod other;\npub use other::search;\n",
            "room/search.rs": "pub struct Found;\n",
            "room/other.rs": "pub fn search() {}\n",
            "a.rs": "use crate::room::search;\nfn f() { search(); }\n",
            "b.rs": "use crate::room::search::Found;\n",
        },
        {"a room/other": {"search"}, "b room/search": {"Found"}},
    ),
    "a glob": (
        {
            **DOOR,
            "a.rs": "use crate::room::*;\nuse crate::b::*;\nfn f(_: Leaf) { two() }\n",
            "b.rs": f"{B} pub trait T {{}}",
        },
        {"a room/leaf": {"Leaf"}, "a b": {"two", "T"}},
    ),
    "a macro": (
        {
            "a.rs": "fn f() { shown!(); crate::shown!(); hidden!(); }\n",
            "b.rs": """use crate::c;
                #[macro_export]
                macro_rules! shown { ($c:path) => { $crate::c::g(); $c::h() } }
                fn f() { c::g() }""",
            "c.rs": "pub fn g() {}\npub fn h() {}\nmacro_rules! hidden { () => {} }\n",
        },
        {"a b": {"shown"}, "a c": {"hidden"}, "b c": {"g"}},
    ),
    "code for tests": (
        {
            "a.rs": """#[cfg(test)] use crate::b::One;
                #[cfg(all(test, unix))] fn g() -> crate::b::Four { crate::b::two() }
                #[test] fn h() { crate::b::two() }
                struct S { #[cfg(test)] x: crate::b::One, y: crate::c::Six }
                impl S { #[cfg(test)] const fn f<A, B>() { crate::b::two(); } fn k() { #[cfg(test)] crate::b::two(); } }
                fn l(y: bool) { #[cfg(test)] let x = if y { 1 } else { crate::b::two() }; crate::c::Nine; }
                #[cfg(test)] mod more;
                #[cfg(test)] mod tests { use super::*; use crate::b::THREE; fn f() { crate::b::two() } }
                #[cfg(not(test))] use crate::c::Seven;
                #[cfg(any(test, unix))] use crate::c::Eight;
            """,
            "a/more.rs": "mod below;\nuse crate::b::One;\n",
            "a/more/below.rs": "use crate::b::One;\n",
            "b.rs": f"#![cfg(test)]\nuse crate::c::Six;\n{B}",
            "c.rs": "pub struct Six; pub struct Seven; pub struct Eight; pub struct Nine;",
        },
        {"a c": {"Six", "Seven", "Eight", "Nine"}},
    ),
    "comments and strings": (
        {
            "a.rs": """//! See [`crate::b::One`].
                /* crate::b::two /* crate::b::two() */ crate::b::two() */
                pub(in crate::a) const C: (char, char, &'static str) = ('"', '\\'', "\\" crate::b::two()");
                fn f<'a>(x: &'a str) { g(r#"x" crate::b::two() "y"#, b'"', "// "); crate::b::One; }
            """,
            "b.rs": B,
        },
        {"a b": {"One"}},
    ),
    "what is not of the crate": (
        {
            "lib.rs": "mod a;\nmod b;\nuse ::b::One;\nfn f() { ::b::two() }\n",
            "a.rs": "use std::fmt;\nuse rayon::{prelude::*, b as x};\nfn f() { x::two(); fmt::b(); b::two(); }\n",
            "b.rs": B,
        },
        {},
    ),
}


@pytest.mark.parametrize("name", READ)
def test_arrows_lead_to_who_defines_a_name(name: str, layers: ModuleType, tmp_path: Path) -> None:
    files, expected = READ[name]
    crate = layers.Crate(crate_at(tmp_path, files), "feeler-core")
    assert crate.orphans() == []

    def short(path: Path) -> str:
        return path.relative_to(crate.source).as_posix().removesuffix(".rs")

    found = {f"{short(start)} {short(end)}": {*names} for (start, end), names in crate.arrows().items()}
    assert found == expected


def test_an_arrow_knows_its_line(layers: ModuleType, tmp_path: Path) -> None:
    files = {"a.rs": "use std::fmt;\n/*\n*/ use crate::b::{\n    One,\n    THREE,\n};\n", "b.rs": B}
    (names,) = layers.Crate(crate_at(tmp_path, files), "feeler-core").arrows().values()
    assert names == {"One": 4, "THREE": 5}


# Low may import nothing, high may import low.
TWO_ROOMS = {"feeler-core": {"low": set(), "high": {"low"}}}
CLEAN = {
    "low/mod.rs": "mod a;\nmod b;\nmod c;\npub use a::A;\n",
    "low/a.rs": "use super::b::B;\npub struct A;\n",
    "low/b.rs": "use super::c::C;\npub struct B;\n",
    "low/c.rs": "pub struct C;\n#[cfg(test)]\nmod tests { use crate::{high::High, low::A}; }\n",
    "high.rs": "use crate::low::A;\npub struct High;\n",
}
BACK = {"low/b.rs": "use super::{a::A, c::C};\npub struct B;\n"}
CIRCLE = ("crates/feeler-core/src/low/a.rs", "crates/feeler-core/src/low/b.rs")
AMISS = {
    "a room imports one above it": (
        {"low/c.rs": "pub struct C;\nuse crate::high::High;\n", "high.rs": "pub struct High;\n"},
        {},
        ["low/c.rs:2: low may not import High of high (of its crate it may import: nothing)"],
    ),
    "a room imports the public face": (
        {"lib.rs": "mod high;\nmod low;\npub fn face() {}\n", "high.rs": "fn f() { crate::face() }\n"},
        {},
        ["high.rs:1: high may not import face of lib (of its crate it may import: low)"],
    ),
    "a room without a place": (
        {"attic.rs": "use crate::low::A;\n"},
        {},
        ["attic.rs: room attic has no place in RUST_ROOMS"],
    ),
    "a place without a room": (
        {"lib.rs": "mod low;\n", "high.rs": None},
        {},
        [": room high of RUST_ROOMS in tools/check_layers.py is not there"],
    ),
    "a file that nothing names": ({"low/d.rs": "use crate::high::High;\n"}, {}, ["low/d.rs: no `mod` names this file"]),
    "a circle of three files": (
        {"low/c.rs": "use crate::low::A;\npub struct C;\n"},
        {},
        [
            "low/a.rs: in a circle of 3 files, with crates/feeler-core/src/low/b.rs, crates/feeler-core/src/low/c.rs; "
            "the shortest way round:\n"
            "    crates/feeler-core/src/low/a.rs:1 -> crates/feeler-core/src/low/b.rs: B\n"
            "    crates/feeler-core/src/low/b.rs:1 -> crates/feeler-core/src/low/c.rs: C\n"
            "    crates/feeler-core/src/low/c.rs:1 -> crates/feeler-core/src/low/a.rs: A"
        ],
    ),
    "a circle of three files by pairs": (
        {**BACK, "low/c.rs": "use super::b::B;\npub struct C;\n"},
        {CIRCLE: "they share a secret"},
        ["low/a.rs: in a circle of 3 files, with"],
    ),
    "a circle with a shorter one in it": (
        {"low/c.rs": "use super::{a::A, b::B};\npub struct C;\n"},
        {},
        [
            "low/a.rs: in a circle of 3 files, with crates/feeler-core/src/low/b.rs, crates/feeler-core/src/low/c.rs; "
            "the shortest way round:\n"
            "    crates/feeler-core/src/low/b.rs:1 -> crates/feeler-core/src/low/c.rs: C\n"
            "    crates/feeler-core/src/low/c.rs:1 -> crates/feeler-core/src/low/b.rs: B"
        ],
    ),
    "a circle of two files": (BACK, {}, ["low/a.rs: imports crates/feeler-core/src/low/b.rs and back, with no reason"]),
    "a circle of two files with an empty reason": (
        BACK,
        {CIRCLE: ""},
        ["low/a.rs: imports crates/feeler-core/src/low/b.rs"],
    ),
    "a reason without a circle": (
        {},
        {CIRCLE: "they share a secret"},
        ["low/a.rs: in no circle with crates/feeler-core/src/low/b.rs any more"],
    ),
    "nothing": ({}, {}, []),
    "no more than a circle with a reason": (BACK, {CIRCLE: "they share a secret"}, []),
    "no more than a circle with a reason, named the other way round": (BACK, {CIRCLE[::-1]: "they share a secret"}, []),
}


@pytest.mark.parametrize("name", AMISS)
def test_rooms_and_circles(name: str, layers: ModuleType, tmp_path: Path) -> None:
    changed, reasons, complaints = AMISS[name]
    files = {file: text for file, text in {**CLEAN, **changed}.items() if text is not None}
    crate_at(tmp_path, files)
    found = list(layers.module_violations(tmp_path, TWO_ROOMS, reasons))
    assert len(found) == len(complaints), found
    for violation, complaint in zip(sorted(found), complaints, strict=True):
        at = "" if complaint.startswith(":") else "/"
        assert violation.startswith(f"crates/feeler-core/src{at}{complaint}")


KNOT = {
    "a/__init__.py": "from a.low import thing\nfrom a.top import use\nversion = 1\n",
    "a/low.py": "thing = 1\n",
    "a/top.py": "from a import thing, version\n\ndef use():\n    from . import low\n",
    "script.py": "import beside\n",
    "scripts/one.py": "import other\n",
    "scripts/other.py": "",
    "beside.py": "from a import use\n",
}
PYTHON_CIRCLES = {
    "none through a door": ({}, []),
    "at the head of a file": (
        {"a/low.py": "from a.top import use\nthing = 1\n"},
        [
            "bench/a/low.py: imports bench/a/top.py and back, with no reason in TWO_FILE_CIRCLES:\n"
            "    bench/a/low.py:1 -> bench/a/top.py: use\n"
            "    bench/a/top.py:1 -> bench/a/low.py: thing, low"
        ],
    ),
    "inside a function": (
        {"a/low.py": "def late():\n    from .top import use\n"},
        ["bench/a/low.py: imports bench/a/top"],
    ),
    "by a name": (
        {"a/low.py": "import importlib\ndef late():\n    return importlib.import_module('a.top').use\n"},
        ["bench/a/low.py: imports bench/a/top.py and back"],
    ),
    "by a name from afar": (
        {"a/low.py": "from importlib import import_module\nuse = import_module('a.top').use\n"},
        ["bench/a/low.py: imports bench/a/top.py and back"],
    ),
    "by a name that nobody knows": ({"a/low.py": "def late(name):\n    return import_module(name)\n"}, []),
    "for type checkers": (
        {"a/low.py": "from typing import TYPE_CHECKING\nif TYPE_CHECKING:\n    import a.top\n"},
        ["bench/a/low.py: imports bench/a/top"],
    ),
    "through a door": ({"a/low.py": "from a import use\n"}, ["bench/a/low.py: imports bench/a/top.py and back"]),
    "of scripts in a folder": (
        {"scripts/other.py": "from one import x\n"},
        ["bench/scripts/one.py: imports bench/scripts/other.py and back"],
    ),
    "of four, by scripts": (
        {"a/low.py": "import script\n"},
        ["bench/a/low.py: in a circle of 4 files, with bench/a/top.py, bench/beside.py, bench/script.py"],
    ),
}


@pytest.mark.parametrize("name", PYTHON_CIRCLES)
def test_circles_of_python(name: str, layers: ModuleType, tmp_path: Path) -> None:
    changed, complaints = PYTHON_CIRCLES[name]
    for file, text in {**KNOT, **changed}.items():
        path = tmp_path / "bench" / file
        path.parent.mkdir(parents=True, exist_ok=True)
        path.write_text(text, encoding="utf-8")
    found = list(layers.python_circles(tmp_path, {}))
    assert len(found) == len(complaints), found
    for violation, complaint in zip(found, complaints, strict=True):
        assert violation.startswith(complaint)
    if name == "inside a function":
        reasons = {("bench/a/top.py", "bench/a/low.py"): "they share a secret"}
        assert not list(layers.python_circles(tmp_path, reasons))


def test_unsafe_has_its_crates(layers: ModuleType, tmp_path: Path) -> None:
    text = "// unsafe\n#![deny(unsafe_code)]\nfn f() { unsafe { g() } }\n"
    for name in layers.CRATES:
        (crate_at(tmp_path, {"lib.rs": text}, name) / "tests").mkdir()
        (tmp_path / "crates" / name / "tests" / "t.rs").write_text(text, encoding="utf-8")
    expected = {f"crates/{name}/src/lib.rs:3" for name in {*layers.CRATES} - layers.MAY_BE_UNSAFE}
    found = [violation.split(": ") for violation in layers.source_violations(tmp_path)]
    assert {where for where, _ in found} == expected
    assert {complaint for _, complaint in found} == {
        "no unsafe code but in feeler-capi, feeler-devices, feeler-lanes, feeler-py, feeler-saved"
    }


@pytest.mark.parametrize(
    "crate", ["feeler-lanes", "feeler-core", "feeler-contacts", "feeler-world", "feeler-plan", "feeler-haptics"]
)
def test_pure_crates_read_no_clock(crate: str, layers: ModuleType, tmp_path: Path) -> None:
    crate_at(tmp_path, {"lib.rs": "const Q: char = '\"';\nuse std::time::Instant;\n"}, crate)
    crate_at(tmp_path, {"lib.rs": "use std::time::Instant;\n"}, "feeler-py")
    assert list(layers.source_violations(tmp_path)) == [f"crates/{crate}/src/lib.rs:2: {crate} is pure: no std::time"]


def test_graph_lists_arrows_and_circles(root: Path, tmp_path: Path) -> None:
    crate_at(tmp_path, {**CLEAN, **BACK})
    crate_at(tmp_path, CLEAN, "feeler-py")
    printed = run(sys.executable, root / "tools/check_layers.py", tmp_path, "--graph", "feeler-core", cwd=tmp_path)
    assert printed.returncode == 0, printed.stderr
    assert "feeler-core: high.rs -> low/a.rs: A\n" in printed.stdout
    assert "feeler-core: a circle of 2 files: low/a.rs low/b.rs\n" in printed.stdout
    assert "feeler-py" not in printed.stdout


# --- the file check -------------------------------------------------------------------------------------------------

STUMBLES = {
    "a long file": ("long.py", "x = 1\n" * 801, "801 lines"),
    "a left-over": ("a.py", "# TO" + "DO: finish\n", "left over"),
    "a left-over macro": ("a.rs", "fn f() { to" + "do!() }\n", "left over"),
    "unsafe without a reason": ("a.rs", "fn f() {\n    let x = unsafe { g() };\n}\n", "a.rs:2: unsafe without"),
    "a registry": ("notes.md", "see https" + "://pypi.example.org/simple\n", "package registry"),
    "somebody's disk": ("notes.md", "look in /ho" + "me/anna/models\n", "absolute path"),
    "two constants of one name": (
        "crates/hull/src/a.rs",
        "const ON: f64 = 1e-9;\nfn f() {\n    const ON: u32 = 1;\n}\n",
        "crates/hull/src/a.rs:3: constant ON has the name of the one in crates/hull/src/a.rs:1",
    ),
}


def test_files_are_clean(root: Path) -> None:
    checked = run(sys.executable, "tools/check_files.py", cwd=root)
    assert checked.returncode == 0, checked.stdout


@pytest.mark.parametrize("name", STUMBLES)
def test_file_check_catches(name: str, root: Path, tmp_path: Path) -> None:
    where, text, complaint = STUMBLES[name]
    (tmp_path / where).parent.mkdir(parents=True, exist_ok=True)
    (tmp_path / where).write_text(text, encoding="utf-8")
    checked = run(sys.executable, root / "tools" / "check_files.py", tmp_path, cwd=tmp_path)
    assert checked.returncode == 1
    assert complaint in checked.stdout


def test_a_constant_has_its_name_alone_in_its_crate(root: Path, tmp_path: Path) -> None:
    """Across files and visibilities; not where it belongs to a type, to tests, to another crate, or is a parameter."""
    sources = {
        "hull/src/constants.rs": "/// Said once.\npub(crate) const ON: f64 = 1e-9;\n",
        "hull/src/a.rs": """
struct Lane<const ON: usize>;
impl<const ON: usize> Lane<
    ON,
> {
    const ON: usize = ON;
    const fn on() -> usize { const INNER: usize = 1; INNER }
}
impl Wide for [f64; 8] { const ON: bool = true; }
trait Wide { const ON: bool; }
// const ON: u8 = 0;
const _: () = ();
const _: () = ();
#[cfg(test)]
mod tests { const ON: u8 = 2; }
fn f(on: *const ON) { let text = "; const ON: u8 = 3;"; }
#[rustfmt::skip]
pub const INNER: u8 = 4;
""",
        "hull/src/tests.rs": "const ON: u8 = 5;\n",
        "hull/src/tests/deep.rs": "const ON: u8 = 6;\n",
        "hull/tests/out.rs": "const ON: u8 = 7;\n",
        "deck/src/lib.rs": "const ON: u8 = 8;\n",
        "deck/src/impl_of.rs": "fn on(x: impl Fn(u8)) { const ON: u8 = 9; }\n",
    }
    for where, text in sources.items():
        path = tmp_path / "crates" / where
        path.parent.mkdir(parents=True, exist_ok=True)
        path.write_text(text, encoding="utf-8")
    checked = run(sys.executable, root / "tools" / "check_files.py", tmp_path, cwd=tmp_path)
    found = [line.split(" ")[0] for line in checked.stdout.splitlines()]
    assert found == ["crates/deck/src/lib.rs:1:", "crates/hull/src/a.rs:18:", "check_files:"], checked.stdout


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


def test_each_test_file_is_in_one_share(root: Path) -> None:
    makefile = (root / "Makefile").read_text()
    files = [
        file for pattern in re.findall(r"tests/test_\[[a-z-]+\]\*\.py", makefile) for file in sorted(root.glob(pattern))
    ]
    assert sorted(files) == sorted((root / "tests").glob("test_*.py"))
