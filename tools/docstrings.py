"""Writes the docstrings of python/feeler/_core*.pyi into crates/feeler-py/src, where `help()` finds them.

    python tools/docstrings.py              write them
    python tools/docstrings.py --check      fail if the written text differs

The stubs are the source. In Rust a docstring is the `///` lines above a `#[pyclass]`, a `#[pyfunction]`, a function of
`#[pymethods]`, or a field of a class that shows its fields (`get_all`).
"""

from __future__ import annotations

import argparse
import ast
import inspect
import re
import sys
from collections.abc import Iterator
from pathlib import Path

ROOT = Path(__file__).parent.parent
STUBS = [
    ROOT / "python" / "feeler" / name
    for name in ("_core.pyi", "_core_bodies.pyi", "_core_motion.pyi", "_core_results.pyi")
]
RUST = ROOT / "crates" / "feeler-py" / "src"

ITEM = re.compile(r"^(?:pub(?:\(crate\))? )?(fn|struct) (?:r#)?(\w+)")
FIELD = re.compile(r"^(?:pub )?(\w+): ")
NAMED = re.compile(r'name = "(\w+)"|#\[getter\((?:r#)?(\w+)\)\]')


def docstrings(stubs: list[str]) -> dict[tuple[str, str], str]:
    """By class ("" for none) and name; ("Cast", "") is the class itself."""
    found: dict[tuple[str, str], str] = {}
    for stub in stubs:
        for node in ast.parse(stub).body:
            if isinstance(node, ast.FunctionDef):
                found["", node.name] = ast.get_docstring(node) or ""
            if isinstance(node, ast.ClassDef):
                found[node.name, ""] = ast.get_docstring(node) or ""
                for member in node.body:
                    if isinstance(member, ast.FunctionDef) and (doc := ast.get_docstring(member)):
                        found[node.name, member.name] = doc
    return {key: inspect.cleandoc(doc) for key, doc in found.items() if doc}


def written(rust: str, docs: dict[tuple[str, str], str]) -> str:
    """A Rust file with the docstrings of the stubs."""
    lines = rust.split("\n")
    out: list[str] = []
    for start, end, kind, owner in blocks(lines):
        block = lines[start:end]
        out += with_docs(block, kind, owner, docs) if kind else block
    return "\n".join(out)


def blocks(lines: list[str]) -> Iterator[tuple[int, int, str, str]]:
    """Runs of lines: of no concern (no kind), and items that Python sees with their attributes; kind and class."""
    at = 0
    while at < len(lines):
        if not lines[at].startswith(("///", "#[")):
            yield at, at + 1, "", ""
            at += 1
            continue
        start = at
        while lines[at].startswith(("///", "#[", " ", ")")):
            at += 1
        head = "\n".join(lines[start:at])
        kind = next((kind for kind in ("pyclass", "pyfunction", "pymethods") if f"#[{kind}" in head), "")
        owner = re.match(r"(?:pub )?(?:impl|struct) (\w+)", lines[at])
        has_body = kind == "pymethods" or "get_all" in head
        end = next(i for i in range(at, len(lines)) if lines[i] == "}") + 1 if has_body else at + 1
        yield start, end, kind, owner[1] if owner and kind else ""
        at = end


def with_docs(block: list[str], kind: str, owner: str, docs: dict[tuple[str, str], str]) -> list[str]:
    """An item, or a block of items, with its docstrings."""
    if kind in ("pyclass", "pyfunction"):
        body = next(i for i, line in enumerate(block) if not line.startswith(("///", "#[", " ", ")")))
        item = ITEM.match(block[body])
        key = (owner, "") if kind == "pyclass" else ("", item[2] if item else "")
        head = documented(block[:body], docs.get(key), "")
        inner = block[body:]
        return head + (members(inner, owner, docs, FIELD) if len(inner) > 1 else inner)
    return members(block, owner, docs, ITEM)


def members(lines: list[str], owner: str, docs: dict[tuple[str, str], str], pattern: re.Pattern[str]) -> list[str]:
    """The lines with docstrings before each member: at four spaces, after its attributes."""
    out: list[str] = []
    head: list[str] = []
    for line in lines:
        inner = line[4:] if line.startswith("    ") and not line.startswith("     ") else None
        goes_on = bool(head) and not closed(head) and line.startswith("     ")
        if goes_on or (inner is not None and inner.startswith(("///", "#["))):
            head.append(line)
        else:
            found = pattern.match(inner) if inner is not None else None
            if found:
                out += documented(head, docs.get((owner, named(head, found[found.lastindex or 1]))), "    ")
            else:
                out += head
            head = []
            out.append(line)
    return out + head


def closed(head: list[str]) -> bool:
    """Whether the last attribute ends."""
    text = "\n".join(line for line in head if not line.lstrip().startswith("///"))
    return text.count("[") == text.count("]")


def named(head: list[str], name: str) -> str:
    """Its name in Python."""
    if any("#[new]" in line for line in head):
        return "__new__"
    other = NAMED.search("\n".join(head))
    return (other[1] or other[2]) if other else name


def documented(head: list[str], doc: str | None, indent: str) -> list[str]:
    """Attributes with a docstring instead of theirs; as they are where the stubs have none."""
    if doc is None:
        return head
    lines = [f"{indent}/// {line}".rstrip() for line in doc.split("\n")]
    return lines + [line for line in head if not line.startswith(f"{indent}///")]


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--check", action="store_true")
    check = parser.parse_args().check
    docs = docstrings([stub.read_text() for stub in STUBS])
    other = []
    for path in sorted(RUST.glob("*.rs")):
        before = path.read_text()
        after = written(before, docs)
        if after != before:
            other.append(str(path.relative_to(ROOT)))
            if not check:
                path.write_text(after)
    if check and other:
        print("docstrings differ from python/feeler/_core*.pyi; run python tools/docstrings.py:", *other, sep="\n  ")
        sys.exit(1)


if __name__ == "__main__":
    main()
