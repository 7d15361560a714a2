"""Writes viewer/src/link/protocol.ts, and openings.ts beside it: the types of the messages for the page.

The messages and the objects in them are those of protocol.py, answers.py and openings.py in
python/feeler/workbench/document; the names, arguments and answers of commands, questions and jobs are the tables of
commands.py there and of session/asking.py.

    python tools/protocol_ts.py              write it
    python tools/protocol_ts.py --check      fail if the written text differs

It reads the source instead of importing the module, so it runs without NumPy and sees the docstrings of fields.
"""

from __future__ import annotations

import argparse
import ast
import re
import sys
from collections.abc import Iterator
from pathlib import Path

ROOT = Path(__file__).parent.parent
WORKBENCH = ROOT / "python" / "feeler" / "workbench"
WRITTEN = ROOT / "viewer" / "src" / "link" / "protocol.ts"
OPENINGS = WRITTEN.with_name("openings.ts")

HEAD = """\
// Written by tools/protocol_ts.py from python/feeler/workbench (protocol.py, commands.py, asking.py): change it there.
// SI: metres, newtons, radians; poses are world_from_tool, row by row. `frames.ts` packs and unpacks binary data.
"""
RENAMED = {"Event": "ServerEvent", "DocumentFields": "Document"}
"""Types with another name in the page: `Event` is a type of the browser."""
SIMPLE = {"int": "number", "float": "number", "str": "string", "bool": "boolean", "None": "null", "Any": "unknown"}
LINE = 120
Object = dict[str, "str | Object"]
"""The fields of a type without a name."""
ARRAYS = {"F8": "Float64Array", "F4": "Float32Array", "U4": "Uint32Array", "U1": "Uint8Array"}


SHARES = {
    "document/protocol": (
        *("document/protocol_values", "document/protocol_people"),
        *("document/protocol_findings", "document/protocol_joints", "document/protocol_task", "document/answers"),
    ),
    "document/commands": tuple(
        f"document/{name}"
        for name in (
            "finding_commands",
            "requirement_commands",
            "cards",
            "line_cards",
            "guide_commands",
            "joint_commands",
            "task_commands",
        )
    ),
    "session/asking": ("session/finding_jobs", "session/report_jobs", "session/requirement_jobs"),
}
"""Modules that hold a part of another one's messages or tables."""


TABLES = """\
/** What is sent of a command: its name and its arguments. */
export type CommandRequest = { [Name in keyof Commands]: Request<Name, Commands[Name]> }[keyof Commands];

type Request<Name, Args> =
  Record<string, never> extends Args ? readonly [name: Name, args?: Args] : readonly [name: Name, args: Args];
"""


class ShapeError(Exception):
    """Something in the sources that this tool has no TypeScript for."""


def document(protocol: str, frames: str, commands: str, asking: str, openings: str = "") -> str:
    """The whole of protocol.ts. openings: the source of openings.ts."""
    blocks: list[str] = []
    arrays: list[str] = messages(openings)[1]
    for node, doc in documented(ast.parse(frames).body):
        if isinstance(node, ast.Assign) and target(node) == "VERSION":
            blocks.append(constant("PROTOCOL_VERSION", node.value, doc))
    texts, packed = messages(protocol)
    blocks += texts
    arrays += packed
    tables = Tables(ast.parse(commands).body, ast.parse(asking).body)
    blocks += [
        tables.interface("Commands", "COMMANDS", "The arguments of commands.", has_answers=False),
        tables.interface("Questions", "ASKS", "The arguments of questions, and their answers.", has_answers=True),
        tables.interface("Jobs", "JOBS", "The arguments of jobs, and their results.", has_answers=True),
        TABLES,
    ]
    blocks.append(
        "/** Where the arrays of a binary message are: type, shape (a text is a free length) and the most rows. */\n"
        "export const ARRAYS = {\n" + "".join(arrays) + "} as const;\n"
    )
    text = "\n".join(blocks)
    return "\n".join([HEAD, *imported(openings, text), text])


def imported(openings: str, text: str) -> list[str]:
    """The import of what a text uses of openings.ts."""
    named = {
        (target(node) if isinstance(node, ast.Assign) else node.name): isinstance(node, ast.Assign)
        and isinstance(node.value, ast.Constant)
        for node in ast.parse(openings).body
        if isinstance(node, ast.Assign | ast.ClassDef)
    }
    used = sorted((name for name in named if re.search(rf"\b{name}\b", text) and name not in ARRAYS), key=str.lower)
    listed = ", ".join(name if named[name] else f"type {name}" for name in used)
    return [f'import {{ {listed} }} from "./openings";\n'] if used else []


def messages(source: str) -> tuple[list[str], list[str]]:
    """The constants, types and messages of a source, and the lines of their arrays."""
    blocks: list[str] = []
    arrays: list[str] = []
    for node, doc in documented(ast.parse(source).body):
        if isinstance(node, ast.Assign) and not target(node).startswith("_") and target(node) not in ARRAYS:
            blocks += assignment(target(node), node.value, doc)
        elif isinstance(node, ast.ClassDef):
            text, packed = interface(node)
            blocks.append(text)
            arrays += packed
    return blocks, arrays


class Tables:
    """The tables of commands, questions and jobs: calls such as `Command(hide, {"parts": Selection})` by name."""

    def __init__(self, *bodies: list[ast.stmt]) -> None:
        self._functions = {node.name: node for body in bodies for node in body if isinstance(node, ast.FunctionDef)}
        self._values = {
            node.target.id if isinstance(node, ast.AnnAssign) else target(node): node.value
            for body in bodies
            for node in body
            if isinstance(node, ast.Assign)
            or (isinstance(node, ast.AnnAssign) and isinstance(node.target, ast.Name) and node.value)
        }

    def interface(self, name: str, table: str, doc: str, *, has_answers: bool) -> str:
        lines = [comment(doc, ""), f"export interface {name} {{\n"]
        for key, row, text in self.rows(table):
            args: Object = {f"{each}?" if may_lack else each: of(kind) for each, kind, may_lack in self.arguments(row)}
            if has_answers:
                args = {"args": args, "answer": self._answer(row)}
            lines.append(f"{comment(text, '  ')}{member(key, args)}")
        return "".join([*lines, "}\n"])

    def rows(self, table: str, *, is_whole: bool = False) -> Iterator[tuple[str, ast.expr, str]]:
        """The rows of a table: name, what makes the row, and the text of its function, or its first paragraph."""
        for key, row in self._dict(self._values[table]):
            text = self._doc(row)
            yield key, row, text if is_whole else text.split("\n\n")[0]
        if table == "COMMANDS":
            # Without arguments, and in no table: they choose between documents.
            for name in ast.literal_eval(self._values["STEPS"]):
                yield name, ast.Tuple(elts=[]), ""

    def _dict(self, node: ast.expr | None) -> list[tuple[str, ast.expr]]:
        """The items of a dict, those of others that are unpacked in it too."""
        match node:
            case ast.Name(id=name):
                return self._dict(self._values[name])
            case ast.Dict(keys=keys, values=values):
                found: list[tuple[str, ast.expr]] = []
                for key, value in zip(keys, values, strict=True):
                    found += self._dict(value) if key is None else [(ast.literal_eval(key), value)]
                return found
        raise ShapeError(f"{ast.unparse(node) if node else 'nothing'} is no table")

    def arguments(self, row: ast.expr) -> Iterator[tuple[str, ast.expr, bool]]:
        """The arguments of a row: name, type, and whether it may be absent."""
        match row:
            case ast.Call(func=ast.Name(id="Command" | "Question" | "Work"), args=[_, shape]):
                for name, kind in self._dict(shape):
                    match kind:
                        case ast.Call(func=ast.Name(id="Maybe"), args=[inside]):
                            yield name, inside, True
                        case _:
                            yield name, kind, False

    def _answer(self, row: ast.expr) -> str:
        """The type that the function of a row returns, or that in the row's maker."""
        match row:
            case ast.Call(func=ast.Name(id=maker)) if maker in self._functions:
                match self._functions[maker].returns:
                    case ast.Subscript(slice=answer):
                        return of(answer)
            case ast.Call(args=[ast.Name(id=work), *_]):
                returns = self._functions[work].returns
                if returns is not None:
                    return of(returns)
        raise ShapeError(f"line {row.lineno}: {ast.unparse(row)} does not name its answer")

    def _doc(self, row: ast.expr) -> str:
        match row:
            case ast.Call(args=[ast.Name(id=work) | ast.Attribute(attr=work), *_]):
                return ast.get_docstring(self._functions[work]) or ""
        return ""


def member(name: str, kind: str | Object, indent: str = "  ") -> str:
    """A field, laid out as Biome does: on one line where that is not too long."""
    if kind == {}:
        kind = "Record<string, never>"
    if isinstance(kind, str):
        return f"{indent}readonly {name}: {kind};\n"
    inside = [member(each, of_it, indent + "  ") for each, of_it in kind.items()]
    short = " ".join(line.strip() for line in inside).removesuffix(";")
    line = f"{indent}readonly {name}: {{ {short} }};\n"
    is_short = len(line) <= LINE + 1 and all(each.count("\n") == 1 for each in inside)
    return line if is_short else "".join([f"{indent}readonly {name}: {{\n", *inside, f"{indent}}};\n"])


def documented(body: list[ast.stmt]) -> Iterator[tuple[ast.stmt, str]]:
    """Each statement, and the text that stands alone under it."""
    for node, after in zip(body, [*body, None][1:], strict=True):
        match after:
            case ast.Expr(value=ast.Constant(value=str(text))):
                yield node, text
            case _:
                yield node, ""


def target(node: ast.Assign) -> str:
    match node.targets:
        case [ast.Name(id=name)]:
            return name
        case _:
            raise ShapeError(f"line {node.lineno}: one name on the left is needed")


def assignment(name: str, value: ast.expr, doc: str) -> Iterator[str]:
    """A constant, or a type with another name; tuples and lists of names are Python's own business."""
    if isinstance(value, ast.Constant):
        yield constant(name, value, doc)
    elif isinstance(value, ast.Subscript | ast.BinOp):
        yield f"{comment(doc, '')}export type {RENAMED.get(name, name)} = {of(value)};\n"


def constant(name: str, value: ast.expr, doc: str) -> str:
    return f"{comment(doc, '')}export const {name} = {ast.unparse(value).replace('_', '')};\n"


def interface(node: ast.ClassDef) -> tuple[str, list[str]]:
    """An object or a message, and its line in the table of arrays."""
    bases = [base.id for base in node.bases if isinstance(base, ast.Name) and base.id != "TypedDict"]
    heir = f" extends {', '.join(bases)}" if bases else ""
    lines = [
        comment(ast.get_docstring(node) or "", ""),
        f"export interface {RENAMED.get(node.name, node.name)}{heir} {{\n",
    ]
    # With total=False the fields may be absent.
    mark = "?" if any(each.arg == "total" and not ast.literal_eval(each.value) for each in node.keywords) else ""
    packed: list[str] = []
    kind = ""
    for each, doc in documented(node.body):
        if not isinstance(each, ast.AnnAssign) or not isinstance(each.target, ast.Name):
            continue
        name = each.target.id
        if name == "KIND":
            kind = ast.literal_eval(each.value or ast.Constant(None))
            lines.append(f'  readonly kind: "{kind}";\n')
        elif name == "TAG":
            for key, value in ast.literal_eval(each.value or ast.Constant(None)).items():
                lines.append(f"  readonly {key}: {str(value).lower() if isinstance(value, bool) else quoted(value)};\n")
        else:
            lines.append(f"{comment(doc, '  ')}  readonly {name}{mark}: {of(each.annotation)};\n")
            if spec := array_spec(each.annotation):
                packed.append(f"    {name}: {spec},\n")
    table = [f"  {kind}: {{\n", *packed, "  },\n"] if packed else []
    return "".join([*lines, "}\n"]), ["".join(table)]


def of(node: ast.expr) -> str:
    """A Python type as TypeScript says it."""
    match node:
        case ast.Constant(value=None):
            return "null"
        case ast.Name(id=name) if name in ARRAYS:
            return ARRAYS[name]
        case ast.Name(id=name):
            return SIMPLE.get(name, RENAMED.get(name, name))
        case ast.BinOp(left=left, op=ast.BitOr(), right=right):
            return f"{of(left)} | {of(right)}"
        case ast.Subscript(value=ast.Name(id="Literal"), slice=values):
            return " | ".join(literal(value) for value in ast.literal_eval(listed(values)))
        case ast.Subscript(value=ast.Name(id="Annotated"), slice=ast.Tuple(elts=[inside, mark])):
            match mark:
                case ast.Call(func=ast.Name(id="Partial"), args=[ast.Name() as whole]):
                    return f"Partial<{of(whole)}>"
                case ast.Call(func=ast.Name(id="Open"), args=[ast.Name() as least]):
                    return of(least)
            return of(inside)
        case ast.Subscript(value=ast.Name(id="list"), slice=inside):
            item = of(inside)
            is_whole = " " not in item or "<" in item or item.startswith("[")
            return f"readonly {item}[]" if is_whole else f"readonly ({item})[]"
        case ast.Subscript(value=ast.Name(id="tuple"), slice=ast.Tuple(elts=items)):
            return f"[{', '.join(of(each) for each in items)}]"
        case ast.Subscript(value=ast.Name(id="dict"), slice=ast.Tuple(elts=[_, inside])):
            return f"Readonly<Record<string, {of(inside)}>>"
    raise ShapeError(f"line {node.lineno}: {ast.unparse(node)} has no TypeScript here")


def array_spec(node: ast.expr) -> str | None:
    match node:
        case ast.Subscript(
            value=ast.Name(id="Annotated"),
            slice=ast.Tuple(elts=[_, ast.Call(func=ast.Name(id="Array"), args=[type_, shape, *most])]),
        ):
            sizes = [each if isinstance(each, int) else quoted(each) for each in ast.literal_eval(shape)]
            limit = ast.unparse(most[0]) if most else "null"
            return f"[{quoted(ast.literal_eval(type_))}, [{', '.join(map(str, sizes))}], {limit}]"
    return None


def listed(node: ast.expr) -> ast.expr:
    """The types between the brackets of a type, always as a tuple."""
    return node if isinstance(node, ast.Tuple) else ast.Tuple(elts=[node], ctx=ast.Load())


def literal(value: object) -> str:
    return quoted(value) if isinstance(value, str) else str(value)


def quoted(value: object) -> str:
    return '"' + str(value) + '"'


def comment(doc: str, indent: str) -> str:
    lines = [line.strip() for line in doc.strip().splitlines()]
    if not lines:
        return ""
    if len(lines) == 1:
        return f"{indent}/** {lines[0]} */\n"
    return "".join([f"{indent}/**\n", *(f"{indent} * {line}".rstrip() + "\n" for line in lines), f"{indent} */\n"])


def source(name: str) -> str:
    """A module of the workbench, after those that hold a part of it."""
    return "\n".join((WORKBENCH / f"{each}.py").read_text(encoding="utf-8") for each in (*SHARES.get(name, ()), name))


def main() -> int:
    parser = argparse.ArgumentParser(description="Writes viewer/src/link/protocol.ts and openings.ts.")
    parser.add_argument("--check", action="store_true", help="write nothing; fail if it differs")
    is_check = parser.parse_args().check
    openings = source("document/openings")
    names = ("document/protocol", "document/frames", "document/commands", "session/asking")
    texts = {
        WRITTEN: document(*map(source, names), openings),
        OPENINGS: "\n".join([HEAD, *messages(openings)[0]]),
    }
    if not is_check:
        for path, text in texts.items():
            path.write_text(text, encoding="utf-8", newline="\n")
        return 0
    stale = [path for path, text in texts.items() if not path.is_file() or path.read_text(encoding="utf-8") != text]
    for path in stale:
        where = path.relative_to(ROOT).as_posix()
        print(f"{where} is not what python/feeler/workbench says: run python tools/protocol_ts.py")
    return int(bool(stale))


if __name__ == "__main__":
    sys.exit(main())
