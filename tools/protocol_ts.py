"""Writes viewer/src/protocol.ts from python/feeler/workbench/document/protocol.py: what the page knows of the messages.

    python tools/protocol_ts.py              write it
    python tools/protocol_ts.py --check      fail if what is written differs

Reads the source, not the module: it runs without NumPy, and the docstrings of fields are there.
"""

from __future__ import annotations

import argparse
import ast
import sys
from collections.abc import Iterator
from pathlib import Path

ROOT = Path(__file__).parent.parent
PROTOCOL = ROOT / "python" / "feeler" / "workbench" / "document" / "protocol.py"
FRAMES = ROOT / "python" / "feeler" / "workbench" / "document" / "frames.py"
WRITTEN = ROOT / "viewer" / "src" / "protocol.ts"

HEAD = """\
// Written by tools/protocol_ts.py from python/feeler/workbench/document/protocol.py: change it there.
// SI: metres, newtons, radians; poses are world_from_tool, row by row. `frames.ts` packs and unpacks what is binary.
"""
SIMPLE = {"int": "number", "float": "number", "str": "string", "bool": "boolean", "None": "null", "Any": "unknown"}
ARRAYS = {"F8": "Float64Array", "F4": "Float32Array", "U4": "Uint32Array"}


class ShapeError(Exception):
    """Something in protocol.py that this tool has no TypeScript for."""


def document(source: str, frames: str) -> str:
    """The whole of protocol.ts."""
    blocks = [HEAD]
    arrays: list[str] = []
    for node, doc in documented(ast.parse(frames).body):
        if isinstance(node, ast.Assign) and target(node) == "VERSION":
            blocks.append(constant("PROTOCOL_VERSION", node.value, doc))
    for node, doc in documented(ast.parse(source).body):
        if isinstance(node, ast.Assign) and not target(node).startswith("_") and target(node) not in ARRAYS:
            blocks += assignment(target(node), node.value, doc)
        elif isinstance(node, ast.ClassDef):
            text, packed = interface(node)
            blocks.append(text)
            arrays += packed
    blocks.append(
        "/** Where the arrays of a binary message are: type, shape (a text is a free length) and the most rows. */\n"
        "export const ARRAYS = {\n" + "".join(arrays) + "} as const;\n"
    )
    return "\n".join(blocks)


def documented(body: list[ast.stmt]) -> Iterator[tuple[ast.stmt, str]]:
    """Each statement, and the text that stands alone under it."""
    for node, after in zip(body, [*body[1:], None], strict=True):
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
        new = {"Event": "ServerEvent"}.get(name, name)  # Event is a type of the browser
        yield f"{comment(doc, '')}export type {new} = {union(value)};\n"


def constant(name: str, value: ast.expr, doc: str) -> str:
    return f"{comment(doc, '')}export const {name} = {ast.unparse(value).replace('_', '')};\n"


def interface(node: ast.ClassDef) -> tuple[str, list[str]]:
    """An object or a message, and its line in the table of arrays."""
    lines = [comment(ast.get_docstring(node) or "", ""), f"export interface {node.name} {{\n"]
    packed: list[str] = []
    kind = ""
    for each, doc in documented(node.body):
        if not isinstance(each, ast.AnnAssign) or not isinstance(each.target, ast.Name):
            continue
        name = each.target.id
        if name == "KIND":
            kind = ast.literal_eval(each.value or ast.Constant(None))
            lines.append(f'  kind: "{kind}";\n')
        elif name == "TAG":
            for key, value in ast.literal_eval(each.value or ast.Constant(None)).items():
                lines.append(f"  {key}: {str(value).lower() if isinstance(value, bool) else quoted(value)};\n")
        else:
            lines.append(f"{comment(doc, '  ')}  {name}: {of(each.annotation)};\n")
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
            return SIMPLE.get(name, name)
        case ast.BinOp(op=ast.BitOr()):
            return union(node)
        case ast.Subscript(value=ast.Name(id="Literal"), slice=values):
            return " | ".join(quoted(value) for value in ast.literal_eval(listed(values)))
        case ast.Subscript(value=ast.Name(id="Annotated"), slice=ast.Tuple(elts=[inside, mark])):
            match mark:
                case ast.Call(func=ast.Name(id="Partial"), args=[ast.Name(id=name)]):
                    return f"Partial<{name}>"
            return of(inside)
        case ast.Subscript(value=ast.Name(id="list"), slice=inside):
            item = of(inside)
            return f"({item})[]" if " " in item and "<" not in item else f"{item}[]"
        case ast.Subscript(value=ast.Name(id="tuple"), slice=ast.Tuple(elts=items)):
            return f"[{', '.join(of(each) for each in items)}]"
        case ast.Subscript(value=ast.Name(id="dict"), slice=ast.Tuple(elts=[_, inside])):
            return f"Record<string, {of(inside)}>"
    raise ShapeError(f"line {node.lineno}: {ast.unparse(node)} has no TypeScript here")


def union(node: ast.expr) -> str:
    """Alternatives; of the message types `Event` has another name in the browser."""
    match node:
        case ast.BinOp(left=left, op=ast.BitOr(), right=right):
            return f"{union(left)} | {union(right)}"
        case ast.Name(id="Event"):
            return "ServerEvent"
    return of(node)


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
    """What is between the brackets of a type, as a tuple always."""
    return node if isinstance(node, ast.Tuple) else ast.Tuple(elts=[node], ctx=ast.Load())


def quoted(value: object) -> str:
    return '"' + str(value) + '"'


def comment(doc: str, indent: str) -> str:
    lines = [line.strip() for line in doc.strip().splitlines()]
    if not lines:
        return ""
    if len(lines) == 1:
        return f"{indent}/** {lines[0]} */\n"
    return "".join([f"{indent}/**\n", *(f"{indent} * {line}".rstrip() + "\n" for line in lines), f"{indent} */\n"])


def main() -> int:
    parser = argparse.ArgumentParser(description="Writes viewer/src/protocol.ts from protocol.py.")
    parser.add_argument("--check", action="store_true", help="write nothing; fail if it differs")
    is_check = parser.parse_args().check
    text = document(PROTOCOL.read_text(encoding="utf-8"), FRAMES.read_text(encoding="utf-8"))
    if not is_check:
        WRITTEN.write_text(text, encoding="utf-8", newline="\n")
        return 0
    there = WRITTEN.read_text(encoding="utf-8") if WRITTEN.is_file() else ""
    if there == text:
        return 0
    print("viewer/src/protocol.ts is not what protocol.py says: run python tools/protocol_ts.py")
    return 1


if __name__ == "__main__":
    sys.exit(main())
