"""Checks all files that git knows or would add for common defects.

    python tools/check_files.py [ROOT]

Sources over 800 lines, files too big for a clone, `unsafe` without a SAFETY comment, left-over markers, two constants
of one name in a Rust crate, and anything that ties the repository to one machine: the address of a package registry, an
absolute path of a user's disk.
"""

from __future__ import annotations

import re
import subprocess
import sys
from collections.abc import Iterator
from pathlib import Path

from rust_modules import Token, tokens

SOURCES = {".rs", ".py", ".pyi", ".ts", ".js", ".sh", ".h", ".c", ".cpp"}
MAX_LINES = 800
MAX_BYTES = 2_000_000

# Written with brackets so that this file does not find itself.
LEFT_OVER = re.compile(r"\b(TOD[O]|FIXM[E]|XX[X])\b|\b(todo|unimplemented)!")
MACHINE = {
    "the address of a package registry": re.compile(
        r"https?://[\w.-]*(pypi|pythonhosted|npmjs|static\.crates|index\.crates)[\w.-]*", re.IGNORECASE
    ),
    "the choice of a package registry": re.compile(r"--(extra-)?index-ur[l]\b|--find-link[s]\b|replace-wit[h]\b"),
    "an absolute path of one machine": re.compile(r"(?<![\w./~}-])/(work|root|home/\w+|Users/\w+)/"),
}
UNSAFE = re.compile(r"\bunsafe\s*(\{|impl\b)")

# What may stand before `const`: the end of an item or attribute, or a visibility. Not `<`: that is a parameter.
BEFORE_CONST = {"", ";", "{", "}", "]", "pub", ")"}
FOR_TESTS = (["cfg", "(", "test"], ["[", "test", "]"])


def files(root: Path) -> list[Path]:
    """Tracked files and new ones that are not ignored; without git, everything outside hidden and build folders."""
    git = subprocess.run(
        ["git", "ls-files", "-z", "--cached", "--others", "--exclude-standard"],
        cwd=root,
        capture_output=True,
        text=True,
        check=False,
    )
    if git.returncode == 0:
        found = [root / name for name in git.stdout.split("\0") if name]
    else:
        skipped = {"target", "build", "dist", "node_modules", "__pycache__"}
        found = [
            path
            for path in root.rglob("*")
            if not any(part in skipped or part.startswith(".") for part in path.relative_to(root).parts)
        ]
    return sorted(path for path in found if path.is_file())


def violations(path: Path) -> Iterator[tuple[int, str]]:
    """(line, complaint) of everything wrong with one file; line 0 is the file as a whole."""
    data = path.read_bytes()
    if len(data) > MAX_BYTES:
        yield 0, f"{len(data)} bytes: more than {MAX_BYTES}, too big for a clone"
        return
    if b"\0" in data[:8192] or path.suffix == ".lock":
        return
    lines = data.decode("utf-8", errors="replace").splitlines()
    is_written = bool(lines) and lines[0].startswith("// Written by tools/")  # by a program, from shorter files
    if path.suffix in SOURCES and len(lines) > MAX_LINES and not is_written:
        yield 0, f"{len(lines)} lines: more than {MAX_LINES}, it is two ideas"
    for number, line in enumerate(lines, 1):
        if path.suffix in SOURCES and LEFT_OVER.search(line):
            yield number, "left over: finish it, or open an issue"
        for what, pattern in MACHINE.items():
            if pattern.search(line):
                yield number, f"names {what}"
        if path.suffix == ".rs" and UNSAFE.search(line.split("//")[0]) and not has_safety_comment(lines, number - 1):
            yield number, "unsafe without `// SAFETY:` just above"


def has_safety_comment(lines: list[str], index: int) -> bool:
    """Whether the line itself, or the comments and attributes right above its statement, say why it is sound."""
    if "SAFETY:" in lines[index]:
        return True
    for line in reversed(lines[max(0, index - 12) : index]):
        text = line.strip()
        if "SAFETY:" in text:
            return True
        # Go on up through comments, attributes and the first lines of the same statement.
        if not text or (text.endswith((";", "{", "}")) and not text.startswith("//")):
            return False
    return False


def names_given_twice(root: Path, paths: list[Path]) -> Iterator[tuple[Path, int, str]]:
    """(file, line, complaint) of every constant whose name another one of the same crate's src/ has already."""
    first: dict[tuple[str, str], str] = {}
    for path in paths:
        match path.relative_to(root).parts:
            case ("crates", crate, "src", *inside) if path.suffix == ".rs":
                if {"tests", "tests.rs"} & {*inside}:
                    continue
            case _:
                continue
        for name in constants(tokens(path.read_text(encoding="utf-8", errors="replace"))):
            where = f"{path.relative_to(root).as_posix()}:{name.line}"
            other = first.setdefault((crate, name.text), where)
            if other != where:
                yield path, name.line, f"constant {name.text} has the name of the one in {other}"


def constants(code: list[Token]) -> Iterator[Token]:
    """The names of a file's constants, those inside functions too; not those of a type or trait, nor of tests."""
    blocks: list[str] = []  # what each block around the place is: "type", "tests" or "code"
    header: list[str] = []  # the words since the last block or statement
    depth = 0
    for i, token in enumerate(code):
        if token.text == "{":
            if any(header[j : j + 3] in FOR_TESTS for j in range(len(header))):
                blocks.append("tests")
            else:
                blocks.append("type" if {"impl", "trait"} & {*header} and "fn" not in header else "code")
        elif token.text == "}" and blocks:
            blocks.pop()
        elif token.text == "const" and "tests" not in blocks and blocks[-1:] != ["type"]:
            before = code[i - 1].text if i else ""
            match code[i + 1 : i + 3]:
                case [name, Token(text=":")] if name.text != "_" and before in BEFORE_CONST:
                    yield name
        depth += (token.text in "([") - (token.text in ")]")
        header = [] if token.text in "{}" or (token.text == ";" and not depth) else [*header, token.text]


def main() -> int:
    root = Path(sys.argv[1] if len(sys.argv) > 1 else Path(__file__).parent.parent).resolve()
    count = 0
    paths = files(root)
    found = ((path, line, complaint) for path in paths for line, complaint in violations(path))
    for path, line, complaint in (*found, *names_given_twice(root, paths)):
        print(f"{path.relative_to(root).as_posix()}{f':{line}' if line else ''}: {complaint}")
        count += 1
    if count:
        print(f"check_files: {count} violation(s)")
    return 1 if count else 0


if __name__ == "__main__":
    sys.exit(main())
