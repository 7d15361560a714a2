"""Writes python/feeler/workbench/view_commands.py: the page's commands as methods of `feeler.View`.

    python tools/view_commands.py              write it
    python tools/view_commands.py --check      fail if what is written differs

Names, arguments and texts are those of the table in python/feeler/workbench/document/commands.py.
"""

from __future__ import annotations

import argparse
import ast
import sys
import textwrap
from collections.abc import Iterator
from pathlib import Path

sys.path.insert(0, str(Path(__file__).parent))
from protocol_ts import WORKBENCH, Tables, source

WRITTEN = WORKBENCH / "view_commands.py"
HEAD = '''"""The page's commands as methods.

Written by tools/view_commands.py from document/commands.py: change it there.
"""

from __future__ import annotations

from typing import Any

from feeler.parts import PartsLike
from feeler.poses import PoseLike
from feeler.workbench.document.arguments import (
    IndicesLike,
    VectorLike,
    VectorsLike,
    plain_numbers,
    plain_parts,
    plain_pose,
)
from feeler.workbench.document.protocol import {names}
from feeler.workbench.session.session import Session


class ViewCommands:
    """The commands of the page; see `View`. Each raises `WorkbenchError` for arguments that cannot be."""

    session: Session

    def command(self, name: str, /, **args: object) -> CommandAnswer:
        """Runs a command of the page by its name, such as `view.command("hide", parts="*screw*")`.

        The answer has the `id` of what was added, the `pose` of the hand, `undo_depth` and `redo_depth`. Raises
        `WorkbenchError`.
        """
        return self.session.command(name, args)

    def _command(self, name: str, /, **args: object) -> CommandAnswer:
        """Without the arguments that are not given."""
        return self.command(name, **{{key: value for key, value in args.items() if value is not None}})
'''
WIDTH = 112  # of docstrings, without their indentation
STEPS = {"undo": "Undoes the last command.", "redo": "Does again what was undone."}
_TYPES = {
    "Selection": "PartsLike",
    "Vec3": "VectorLike",
    "list[Vec3]": "VectorsLike",
    "list[int]": "IndicesLike",
    "Pose": "Pose | PoseLike",
}
_PLAIN = {"Selection": "plain_parts", "Pose": "plain_pose"} | dict.fromkeys(
    ("Vec3", "list[Vec3]", "list[int]"), "plain_numbers"
)
BUILTIN = {"int", "float", "str", "bool", "None", "list", "tuple", "dict", "Any"}


def written(text_of_commands: str) -> str:
    """The whole of view_commands.py."""
    methods: list[str] = []
    names = {"CommandAnswer"}
    tables = Tables(ast.parse(text_of_commands).body)
    for name, row, text in tables.rows("COMMANDS", is_whole=True):
        arguments = sorted(tables.arguments(row), key=lambda argument: argument[2])
        for _, kind, _ in arguments:
            if ast.unparse(kind) in _type(kind).split(" | ") or _type(kind) == ast.unparse(kind):
                names |= {node.id for node in ast.walk(kind) if isinstance(node, ast.Name)} - BUILTIN
        methods.append("\n".join(_method(name, arguments, text or STEPS[name])))
    listed = ", ".join(sorted(names))
    return "\n".join([HEAD.format(names=f"({listed})" if len(listed) > 50 else listed), *methods])


def _method(name: str, arguments: list[tuple[str, ast.expr, bool]], text: str) -> Iterator[str]:
    given = [f"{each}: {_type(kind)}{' | None = None' if may_lack else ''}" for each, kind, may_lack in arguments]
    sent = "".join(f", {each}={_sent(each, kind)}" for each, kind, _ in arguments)
    send = "_command" if any(may_lack for _, _, may_lack in arguments) else "command"
    yield f"    def {name}(self{''.join(f', {each}' for each in given)}) -> CommandAnswer:"
    first, *more = text.replace("null", "None").split("\n\n")
    paragraphs = [first, *(textwrap.fill(each, WIDTH) for each in more)]
    yield textwrap.indent('"""' + "\n\n".join(paragraphs) + ("\n" if more else "") + '"""', "        ")
    yield f'        return self.{send}("{name}"{sent})'
    yield ""


def _type(kind: ast.expr) -> str:
    """The type of an argument for a script, which may give parts and vectors as all of feeler takes them."""
    name = ast.unparse(kind)
    return _TYPES.get(name, name)


def _sent(name: str, kind: ast.expr) -> str:
    plain = _PLAIN.get(ast.unparse(kind))
    return name if plain is None else f"{plain}({name})"


def main() -> int:
    parser = argparse.ArgumentParser(description="Writes python/feeler/workbench/view_commands.py.")
    parser.add_argument("--check", action="store_true", help="write nothing; fail if it differs")
    is_check = parser.parse_args().check
    text = formatted(written(source("document/commands")))
    if not is_check:
        WRITTEN.write_text(text, encoding="utf-8", newline="\n")
        return 0
    if WRITTEN.is_file() and WRITTEN.read_text(encoding="utf-8") == text:
        return 0
    print("view_commands.py is not what document/commands.py says: run python tools/view_commands.py")
    return 1


def formatted(text: str) -> str:
    """As ruff lays it out."""
    import subprocess

    ruff = [sys.executable, "-m", "ruff", "format", "-q", "--stdin-filename", str(WRITTEN), "-"]
    return subprocess.run(ruff, input=text, capture_output=True, text=True, check=True).stdout


if __name__ == "__main__":
    sys.exit(main())
