"""What users of `feeler` meet: names, types, errors, and what an import loads."""

from __future__ import annotations

import ast
import importlib
import inspect
import os
import pkgutil
import re
import subprocess
import sys
import typing
from collections.abc import Iterator
from dataclasses import is_dataclass
from enum import Enum
from pathlib import Path

import pytest
from test_docs import PAGES, blocks_of

import feeler
from feeler import _core, choices
from feeler import figures as figures_module

ROOT = Path(__file__).resolve().parents[1]
sys.path.insert(0, str(ROOT / "tools"))
import docstrings  # noqa: E402

TYPED = ROOT / "tests" / "typed"


def scripts_of_pages(folder: Path) -> Iterator[Path]:
    """The blocks of Python of each page of the documentation, as one script, with the page's lines."""
    for name in PAGES:
        lines: list[str] = []
        for block in blocks_of(name):
            if block.language == "python":
                lines += [""] * (block.line - 1 - len(lines)) + block.text.splitlines()
        if lines:
            script = folder / f"page_{re.sub(r'[^a-z]', '_', name.lower())}.py"
            script.write_text("\n".join(lines) + "\n", encoding="utf-8")
            yield script


def old_names() -> list[tuple[str, type, str, str]]:
    """Each public class with attributes that have other names now, such an attribute, and its name now."""
    classes = {name: value for name, value in public_members().items() if inspect.isclass(value)}
    tables = [(name, kind, getattr(kind, "_RENAMED", {})) for name, kind in classes.items()]
    return [(name, kind, old, new) for name, kind, table in tables for old, new in table.items()]


@pytest.fixture(scope="module")
def told(tmp_path_factory: pytest.TempPathFactory) -> dict[str, list[tuple[int, str]]]:
    """What mypy says of the scripts, as strict as it is: by file, lines and errors.

    Scripts of typos are checked without the others: aliases are to hold whatever is imported first.
    """
    command = [
        sys.executable,
        "-m",
        "mypy",
        "--strict",
        "--follow-imports=silent",
        "--config-file=",
        "--no-error-summary",
    ]
    env = {**os.environ, "MYPYPATH": str(ROOT / "python")}
    folder = tmp_path_factory.mktemp("scripts")
    names = folder / "old_names.py"
    lines = [f"def f{n}(x: {name}) -> object: return x.{old}" for n, (name, _, old, _) in enumerate(old_names())]
    names.write_text("\n".join(["import feeler", *lines]) + "\n", encoding="utf-8")
    wrong, right = [TYPED / "typos.py", names], [TYPED / "user.py", *scripts_of_pages(folder)]
    files = [*wrong, *right]
    out = ""
    for some in (wrong, right):
        out += subprocess.run(
            [*command, *map(str, some)], capture_output=True, text=True, check=False, env=env, cwd=ROOT
        ).stdout
    rows = re.findall(r"^(\S+?):(\d+): error: (.*)$", out, re.MULTILINE)
    found: dict[str, list[tuple[int, str]]] = {file.name: [] for file in files}
    for file, line, error in rows:
        found[Path(file).name].append((int(line), error))
    return found


def test_a_users_script_has_types(told: dict[str, list[tuple[int, str]]]) -> None:
    assert told["user.py"] == []


def test_scripts_of_the_documentation_have_types(told: dict[str, list[tuple[int, str]]]) -> None:
    pages = {name: errors for name, errors in told.items() if name.startswith("page_")}
    assert len(pages) > 20 and {name: errors for name, errors in pages.items() if errors} == {}


def test_typos_are_seen(told: dict[str, list[tuple[int, str]]]) -> None:
    lines = (TYPED / "typos.py").read_text().splitlines()
    wrong = {number for number, line in enumerate(lines, start=1) if line.endswith("# wrong")}
    assert {line for line, _ in told["typos.py"]} == wrong and len(wrong) > 10


def test_old_names_are_errors_to_a_type_checker(told: dict[str, list[tuple[int, str]]]) -> None:
    names = old_names()
    assert {line for line, _ in told["old_names.py"]} == set(range(2, len(names) + 2)) and len(names) > 30


def test_old_names_answer_in_one_way() -> None:
    """By `__getattr__`, which warns; so they are not among the names of a class, and need no docstring."""
    for name, kind, old, new in old_names():
        assert old not in dir(kind), f"{name}.{old}"
        assert new in {*dir(kind), *getattr(kind, "__dataclass_fields__", ())}, f"{name}.{new}"


def test_the_names_are_where_the_table_says() -> None:
    """Three lists that are one: the imports for type checkers, `__all__`, and where names are imported from."""
    tree = ast.parse((ROOT / "python" / "feeler" / "__init__.py").read_text())
    checked = next(node for node in tree.body if isinstance(node, ast.If))
    imported = {
        (alias.name, node.module)
        for node in checked.body
        if isinstance(node, ast.ImportFrom)
        for alias in node.names
        if node.module != "feeler"
    }
    table = {(name, home) for home, names in feeler._HOMES.items() for name in names}  # type: ignore[attr-defined]
    assert imported == table
    assert sorted([*(name for name, _ in table), "haptics"]) == sorted(feeler.__all__)
    for name, home in table:
        assert getattr(feeler, name) is getattr(importlib.import_module(home), name)
    assert set(feeler.__all__) <= set(dir(feeler))
    for room in feeler._ROOMS:  # type: ignore[attr-defined]
        assert getattr(feeler, room).__name__ == f"feeler.{room}"
    with pytest.raises(AttributeError, match="no attribute 'no_such_thing'"):
        _ = feeler.no_such_thing  # type: ignore[attr-defined]


INSIDE = {
    "Cancelled",  # of a call of feeler mcp
    "DamagedError",  # of a stream in a file: told as a LoadError
    "EncryptedError",
    "Ended",  # of feeler mcp, by a signal
    "Interrupted",  # of tasks on an executor: told as that of the call
    "JobCancelledError",
    "ProtocolError",
    "StoppedError",  # of a planner: told as the interruption of the call
    "TaskStopped",
}
"""Exceptions that never reach a caller of a public function."""


def test_errors_that_are_raised_can_be_imported() -> None:
    names = set()
    for module in pkgutil.walk_packages(feeler.__path__, "feeler."):
        if module.name.endswith("__main__"):
            continue
        for name, value in vars(importlib.import_module(module.name)).items():
            is_own = isinstance(value, type) and value.__module__.startswith("feeler.")
            if is_own and issubclass(value, BaseException) and not name.startswith("_"):
                names.add(name)
    assert names - INSIDE <= set(feeler.__all__), names - INSIDE - set(feeler.__all__)
    assert names >= INSIDE


SPACES = ("feeler.clashes", "feeler.io", "feeler.picture", "feeler.samples")


def public_members() -> dict[str, object]:
    """What a user can ask for help on: functions and classes, their methods and properties, by name."""
    found: dict[str, object] = {}
    for space in (feeler, feeler.haptics, *map(importlib.import_module, SPACES)):
        for name in space.__all__:
            value = getattr(space, name)
            if inspect.ismodule(value) or (inspect.isclass(value) and issubclass(value, BaseException)):
                continue
            found[f"{space.__name__}.{name}"] = value
            if inspect.isclass(value):
                members = {member: inspect.getattr_static(value, member) for member in dir(value)}
                for member, each in members.items():
                    is_member = callable(each) or inspect.isdatadescriptor(each) or inspect.ismethoddescriptor(each)
                    if not member.startswith("_") and is_member and not isinstance(each, Enum):
                        found[f"{space.__name__}.{name}.{member}"] = getattr(value, member)
    return found


def test_every_public_member_has_a_docstring() -> None:
    members = public_members()
    assert len(members) > 300
    assert [name for name, value in members.items() if not inspect.getdoc(value)] == []


def test_docstrings_of_the_core_are_those_of_its_stubs() -> None:
    """`python tools/docstrings.py` writes them into the Rust sources."""
    docs = docstrings.docstrings([stub.read_text() for stub in docstrings.STUBS])
    assert len(docs) > 200
    other = {}
    for (owner, name), doc in docs.items():
        of = getattr(_core, owner) if owner else _core
        told = inspect.getdoc(of if not name else getattr(of, name))
        if name not in ("__new__", "__len__", "__getitem__", "__iter__") and told != doc:
            other[owner, name] = (told, doc)
    assert other == {}


def _annotations(member: object) -> dict[str, object]:
    return getattr(getattr(member, "fget", member), "__annotations__", {})


def test_columns_of_words_say_what_their_elements_are() -> None:
    """NumPy's strings, which equal the members of an enumeration but have no `.code`."""
    members = public_members()
    stubs = [ast.parse(stub.read_text()) for stub in docstrings.STUBS]
    words = {
        f"feeler.{kind.name}.{each.name}"
        for stub in stubs
        for kind in ast.walk(stub)
        if isinstance(kind, ast.ClassDef)
        for each in kind.body
        if isinstance(each, ast.FunctionDef) and each.returns and "np.str_" in ast.unparse(each.returns)
    }
    words |= {name for name, each in members.items() if "np.str_" in str(_annotations(each))}
    told = {name: inspect.getdoc(members[name]) or "" for name in words}
    assert len(words) > 6 and {name: doc for name, doc in told.items() if "`numpy.str_`" not in doc} == {}


UNTYPED = {
    "feeler.View.findings_take.saved": "JSON",
    "feeler.clashes.report.return": "JSON",
    "feeler.Clashes.to_pandas.return": "pandas need not be installed",
}
"""Public signatures with `Any`, and why no type is known. All `to_dict` and `to_dicts` return JSON."""


def test_public_signatures_have_types() -> None:
    found = {
        f"{name}.{argument}"
        for name, member in public_members().items()
        if callable(getattr(member, "fget", member)) and not isinstance(member, type)
        for argument, kind in _annotations(member).items()
        if re.search(r"\bAny\b", re.sub(r"NDArray\[Any\]", "", str(kind)))
    }
    found = {name for name in found if not re.search(r"\.to_dicts?\.return$", name)}
    assert {name.replace("feeler.clashes.Clashes", "feeler.Clashes") for name in found} == set(UNTYPED)


def named_classes(kind: object) -> Iterator[type]:
    """The classes in an annotation."""
    if inspect.isclass(kind):
        yield kind
    for inside in typing.get_args(kind):
        yield from named_classes(inside)


def test_classes_of_public_signatures_can_be_imported() -> None:
    """A user annotates with what functions take and return, and with the fields of results."""
    rooms = [feeler, feeler.haptics, feeler.types, *map(importlib.import_module, (*SPACES, "feeler.haptics.devices"))]
    public = {id(value) for room in rooms for name, value in vars(room).items() if not name.startswith("_")}
    public |= {id(getattr(room, name)) for room in rooms for name in getattr(room, "__all__", ())}
    # Queries take the core's tool, from which the public one derives.
    public |= {id(_core.Tool), id(_core.Mockup)}
    members = public_members()
    asked = {name: getattr(member, "fget", None) or getattr(member, "func", member) for name, member in members.items()}
    missing = {
        f"{kind.__module__}.{kind.__qualname__} of {name}"
        for name, member in asked.items()
        if inspect.isfunction(member) or inspect.ismethod(member) or is_dataclass(member)
        for hint in typing.get_type_hints(member).values()
        for kind in named_classes(hint)
        if kind.__module__.startswith("feeler.") and id(kind) not in public
    }
    assert missing == set()


def test_types_and_words_are_all_exported() -> None:
    """`feeler.types` has every word type, and the figures of results."""
    words = {name for name, value in vars(choices).items() if typing.get_origin(value) is typing.Literal}
    figures = {name for name, value in vars(figures_module).items() if is_dataclass(value)}
    assert words | figures <= set(feeler.types.__all__) and len(words) > 20 and len(figures) == 3
    assert feeler.samples.FAULTS.keys() == set(choices.FAULT_NAMES)
    assert feeler.samples.sample_names() == choices.SAMPLE_NAMES
    assert feeler.samples.sample_tool_names() == choices.SAMPLE_TOOL_NAMES
    assert typing.get_args(choices.UnitName) == feeler.io.KNOWN_UNITS
    assert [each.value for each in feeler.Verdict] == list(typing.get_args(choices.VerdictName))
    corner = feeler.Mockup([[0.0, 0, 0], [1, 0, 0], [0, 1, 0]], [[0, 1, 2]])
    assert tuple(corner.defects) == choices.DEFECT_KINDS


def modules_after(code: str) -> set[str]:
    script = f"import sys\n{code}\nprint(*[name for name in sys.modules if name.startswith('feeler')])"
    return set(
        subprocess.run([sys.executable, "-c", script], capture_output=True, text=True, check=True).stdout.split()
    )


def test_an_import_loads_only_what_is_asked_for() -> None:
    assert modules_after("import feeler") == {"feeler"}
    query = "import feeler; feeler.Scene, feeler.Mockup, feeler.Tool"
    values = {
        "arguments",
        "atomic",
        "attributes",
        "calibrate",
        "choices",
        "depths",
        "enumerations",
        "errors",
        "field_docs",
        "figures",
        "ignored",
        "part_meshes",
        "parts",
        "poses",
        "progress",
        "renamed",
        "short_reprs",
        "rows",
        "scene_pickles",
        "words",
        "memory",
        "mesh_types",
        "saved",
        "source",
    }
    wanted = {"_core", "mockup", "scene", *values}
    assert modules_after(query) == {"feeler", "feeler.travel", *(f"feeler.{name}" for name in wanted)}
    assert "feeler.haptics.session" in modules_after("import feeler; feeler.haptics.Session")
