"""The files of a Rust crate and their imports, read from the text: no compiler, no build.

An arrow goes from a file to the file that *defines* a name it uses. Re-exports are followed: they only open a room, and
make no arrow of their own. Code for tests (`#[cfg(test)]`, `#[test]`) makes none either. Names without a path in the
text remain unseen: methods, fields, and names built by macros.
"""

from __future__ import annotations

import re
from collections import deque
from collections.abc import Iterator, Sequence
from dataclasses import dataclass, field
from pathlib import Path
from typing import NamedTuple

# --- the text --------------------------------------------------------------------------------------------------------

BLANKED = re.compile(
    r"""//[^\n]*
    | (?P<comment>/\*)
    | \b[bc]?r(?P<fence>\#*)".*?"(?P=fence)
    | "(?:\\.|[^"\\])*"
    | '(?:\\(?:u\{[^}]*\}|x..|.)|[^\\'\n])'
    | '[A-Za-z_]\w*""",
    re.DOTALL | re.VERBOSE,
)
COMMENT_EDGE = re.compile(r"/\*|\*/")
TOKEN = re.compile(r"(?:r#)?[A-Za-z_]\w*|\d\w*|::|->|=>|[!=<>]=|\S")
OPEN, CLOSE = "([{", ")]}"


class Token(NamedTuple):
    text: str
    line: int


def blank(code: str) -> str:
    """The code with comments, strings, characters and lifetimes turned to spaces; all else keeps its place."""
    parts, at = [], 0
    while match := BLANKED.search(code, at):
        end = match.end()
        if match["comment"]:
            depth = 1
            while depth and (edge := COMMENT_EDGE.search(code, end)):
                depth, end = depth + (1 if edge.group() == "/*" else -1), edge.end()
            end = len(code) if depth else end
        parts += [code[at : match.start()], re.sub(r"[^\n]", " ", code[match.start() : end])]
        at = end
    return "".join([*parts, code[at:]])


def tokens(code: str) -> list[Token]:
    """The words and signs of the code, blanked first."""
    found = []
    for number, line in enumerate(blank(code).split("\n"), 1):
        found += [Token(text.removeprefix("r#"), number) for text in TOKEN.findall(line)]
    return found


def is_name(text: str) -> bool:
    return text[0].isalpha() or text[0] == "_"


# --- modules ---------------------------------------------------------------------------------------------------------


@dataclass(eq=False)
class Import:
    """One name of a `use`; `name` is None for a glob."""

    name: str | None
    path: list[str]
    line: int
    is_public: bool = False


# The imports inside the blocks around a place in the code, outermost first.
Blocks = tuple[list[Import], ...]


class Mention(NamedTuple):
    """A path in the code; `is_plain` if it may be no more than a variable or a label."""

    path: list[str]
    line: int
    blocks: Blocks
    is_plain: bool


@dataclass(eq=False)
class Module:
    """A module of a crate; several of them may stand in one file."""

    name: str
    file: Path
    folder: Path
    parent: Module | None = None
    is_test: bool = False
    children: dict[str, Module] = field(default_factory=dict)
    items: dict[str, str] = field(default_factory=dict)
    imports: list[Import] = field(default_factory=list)
    inner_imports: list[tuple[Import, Blocks]] = field(default_factory=list)
    mentions: list[Mention] = field(default_factory=list)

    def root(self) -> Module:
        return self.parent.root() if self.parent else self

    def path(self) -> list[str]:
        return [*self.parent.path(), self.name] if self.parent else ["crate"]

    def is_below(self, other: Module) -> bool:
        return self is other or (self.parent is not None and self.parent.is_below(other))

    def walk(self) -> Iterator[Module]:
        yield self
        for child in self.children.values():
            yield from child.walk()


class Item(NamedTuple):
    """The meaning of a name, and the module that defines it."""

    name: str
    module: Module


# --- reading ---------------------------------------------------------------------------------------------------------

ITEMS = {"fn", "struct", "enum", "union", "trait", "const", "static", "type"}
MODIFIERS = {"unsafe", "async", "default", "auto", "safe"}
# These end at a semicolon, whatever braces come before it.
TO_SEMICOLON = {"const", "static", "type", "use", "let"}
NOT_PATHS = ITEMS - {"union"} | {
    *("as", "async", "await", "break", "continue", "dyn", "else", "extern", "false", "for", "if", "impl", "in", "let"),
    *("loop", "match", "mod", "move", "mut", "pub", "ref", "return", "true", "unsafe", "use", "where", "while"),
}


def is_test_only(attribute: list[str]) -> bool:
    """Whether `#[attribute]` leaves what follows to tests alone."""

    def needs_test(condition: list[str]) -> bool:
        if condition[:1] not in (["all"], ["any"]):
            return condition == ["test"]
        parts: list[list[str]] = [[]]
        depth = 0
        for text in condition[2:-1]:
            depth += (text == "(") - (text == ")")
            if text == "," and depth == 0:
                parts.append([])
            else:
                parts[-1].append(text)
        each = [needs_test(part) for part in parts if part]
        return any(each) if condition[0] == "all" else bool(each) and all(each)

    return attribute == ["test"] or (attribute[:2] == ["cfg", "("] and needs_test(attribute[2:-1]))


class Reader:
    """Reads one file into its module, and the files of its `mod`s into the modules below."""

    def __init__(self, module: Module) -> None:
        self.tokens = tokens(module.file.read_text(encoding="utf-8"))
        self.partner: dict[int, int] = {}
        open_: list[int] = []
        for i, token in enumerate(self.tokens):
            if token.text in OPEN:
                open_.append(i)
            elif token.text in CLOSE and open_:
                self.partner[open_.pop()] = i
        for i in open_:
            self.partner[i] = len(self.tokens)
        self.read_items(0, len(self.tokens), module)

    def text(self, i: int) -> str:
        return self.tokens[i].text if i < len(self.tokens) else ""

    def attributes(self, i: int) -> tuple[int, list[list[str]], bool]:
        """The place past the attributes at `i`, the attributes, and whether a `#![..]` leaves all around to tests."""
        found, all_test = [], False
        while self.text(i) == "#" and self.text(j := i + 1 + (self.text(i + 1) == "!")) == "[":
            attribute = [token.text for token in self.tokens[j + 1 : self.partner[j]]]
            if j > i + 1:
                all_test |= is_test_only(attribute)
            else:
                found.append(attribute)
            i = self.partner[j] + 1
        return i, found, all_test

    def visibility(self, i: int) -> int:
        """Past `pub`, `pub(crate)`, `pub(in path)`: a path there is no use of anything."""
        if self.text(i) != "pub":
            return i
        i += 1
        is_scope = self.text(i + 1) == "in" or (
            self.text(i + 1) in {"crate", "self", "super"} and self.text(i + 2) == ")"
        )
        return self.partner[i] + 1 if self.text(i) == "(" and is_scope else i

    def modifiers(self, i: int) -> int:
        """Past `const unsafe extern "C"` and the like before `fn`, `trait`, `impl`; `const X` and `extern {` stay."""
        while self.text(i) in MODIFIERS or (
            self.text(i) in {"const", "extern"} and self.text(i + 1) in {"fn", "unsafe", "async", "extern"}
        ):
            i += 1
        return i

    def end(self, i: int, kind: str) -> int:
        """Past the item or statement that has its first word at `i`."""
        while i < len(self.tokens):
            text = self.text(i)
            if text == ";":
                return i + 1
            if text in OPEN:
                is_last = text == "{" and kind not in TO_SEMICOLON and self.text(i - 1) != "<"
                i = self.partner[i]
                if is_last:
                    return i + 1
            elif text in CLOSE or (text == "," and not kind):
                return i + (text == ",")
            i += 1
        return i

    def read_items(self, i: int, end: int, module: Module) -> None:
        while i < end:
            i, attributes, all_test = self.attributes(i)
            module.is_test |= all_test
            is_test = any(is_test_only(attribute) for attribute in attributes)
            start, i = i, self.visibility(i)
            is_public = i > start
            i = self.modifiers(i)
            kind, after = self.text(i), min(self.end(i, self.text(i) or "?"), end)
            if kind == "mod" and is_name(self.text(i + 1)):
                self.read_module(i, module, is_test)
            elif is_test:
                pass
            elif kind == "use":
                module.imports += self.read_use(i + 1, after, is_public)
            elif kind == "extern" and self.text(i + 1) == "{":
                self.read_items(i + 2, self.partner[i + 1], module)
            elif kind == "macro_rules":
                name = self.text(i + 2)
                module.items.setdefault(name, "macro")
                if module.parent and ["macro_export"] in [attribute[:1] for attribute in attributes]:
                    module.root().imports.append(Import(name, [*module.path(), name], self.tokens[i].line, True))
                self.read_code(i + 3, after, module)
            else:
                if kind in ITEMS and is_name(self.text(i + 1)):
                    i += 1 + (kind == "static" and self.text(i + 1) == "mut")
                    module.items.setdefault(self.text(i), kind)
                    i += 1
                self.read_code(i, after, module)
            i = max(after, i + 1)

    def read_module(self, i: int, module: Module, is_test: bool) -> None:
        name, is_test = self.text(i + 1), is_test or module.is_test
        folder = module.folder / name
        if self.text(i + 2) == "{":
            child = Module(name, module.file, folder, module, is_test)
            module.children[name] = child
            self.read_items(i + 3, self.partner[i + 2], child)
            return
        for file in (module.folder / f"{name}.rs", folder / "mod.rs"):
            if file.is_file():
                module.children[name] = child = Module(name, file, folder, module, is_test)
                Reader(child)
                return

    def read_use(self, i: int, end: int, is_public: bool = False, path: Sequence[str] = ()) -> list[Import]:
        """The names of a use tree between `i` and its end."""
        found: list[Import] = []
        path, line = list(path), self.tokens[i].line if i < end else 0
        while i < end and self.text(i) not in {";", ","}:
            text = self.text(i)
            if text == "{":
                part, close = i + 1, self.partner[i]
                while part < close:
                    found += self.read_use(part, close, is_public, path)
                    while part < close and self.text(part) != ",":
                        part = self.partner[part] if self.text(part) in OPEN else part + 1
                    part += 1
                return found
            if text == "*":
                return [Import(None, path, line, is_public)]
            if text == "as":
                return [Import(self.text(i + 1), path, line, is_public)]
            if text == "::" and not path:
                return []  # `use ::crate_name` is nothing of this crate.
            if is_name(text) and not (text == "self" and path):
                path.append(text)
            i += 1
        return [Import(path[-1], path, line, is_public)] if path else []

    def read_code(self, i: int, end: int, module: Module) -> None:
        """The paths in the code of an item, with the imports of the blocks around each."""
        blocks: list[tuple[int, list[Import]]] = []
        while i < end:
            while blocks and i >= blocks[-1][0]:
                blocks.pop()
            text, before = self.text(i), self.text(i - 1) if i else ""
            if text == "#":
                past, attributes, _ = self.attributes(i)
                if any(is_test_only(attribute) for attribute in attributes):
                    past = self.modifiers(self.visibility(past))
                    kind = self.text(past)
                    past = min(self.end(past, kind if kind in TO_SEMICOLON | ITEMS else ""), end)
                i = max(past, i + 1)
            elif text == "{":
                blocks.append((self.partner[i], []))
                i += 1
            elif text == "pub":
                i = self.visibility(i)
            elif text == "use" and blocks and before != "+" and self.text(i + 1) != "<":
                after = self.end(i, "use")
                around = tuple(block for _, block in blocks)
                for found in self.read_use(i + 1, after):
                    around[-1].append(found)
                    module.inner_imports.append((found, around))
                i = after
            elif not is_name(text) or text in NOT_PATHS or before in {".", "fn", "::"} or self.is_of_macro(i):
                i += 1
            else:
                path, line = [text], self.tokens[i].line
                while self.text(i + 1) == "::" and i + 2 < end and is_name(self.text(i + 2)):
                    i += 2
                    path.append(self.text(i))
                after_it = self.text(i + 1)
                is_label = after_it == ":" or (after_it == "=" and before in {"<", ","})
                is_plain = is_label or (text[0].islower() and after_it not in {"(", "!", "::"})
                around = tuple(block for _, block in blocks)
                module.mentions.append(Mention(path, line, around, len(path) == 1 and is_plain))
                i += 1

    def is_of_macro(self, i: int) -> bool:
        """`$name` in a macro; `$crate` is a path."""
        return i > 0 and self.text(i - 1) == "$" and self.text(i) != "crate"


# --- a crate ---------------------------------------------------------------------------------------------------------


class Crate:
    """The modules of one crate, and the arrows between its files."""

    def __init__(self, folder: Path, name: str) -> None:
        self.source, self.name = folder / "src", name.replace("-", "_")
        heads = [self.source / "lib.rs", self.source / "main.rs", *sorted(self.source.glob("bin/*.rs"))]
        self.roots = [Module("crate", head, head.parent) for head in heads if head.is_file()]
        for root in self.roots:
            Reader(root)
        self.macros = {
            name: Item(name, module)
            for module in self.modules()
            for name, kind in module.items.items()
            if kind == "macro"
        }

    def modules(self) -> Iterator[Module]:
        for root in self.roots:
            yield from root.walk()

    def files(self) -> set[Path]:
        """The files that are not for tests alone."""
        return {module.file for module in self.modules() if not module.is_test}

    def orphans(self) -> list[Path]:
        """Files that no `mod` names: the compiler does not read them, and neither does this."""
        known = {module.file for module in self.modules()}
        return [file for file in sorted(self.source.rglob("*.rs")) if file not in known]

    # Names are looked for as the compiler does; of a module and a function of one name, what follows tells which it is.

    def resolve(
        self, module: Module, path: Sequence[str], blocks: Blocks = (), seen: frozenset[object] = frozenset()
    ) -> Module | Item | None:
        """The target of a path in a module: a module or an item of this crate, or None for anything else."""
        first, last = path[0], len(path) - 1
        here: Module | Item | None
        if first in {"crate", "self", "super"}:
            here = {"crate": module.root(), "self": module, "super": module.parent}[first]
        else:
            here = self.look_up(module, first, not last, blocks, seen)
            if here is None and first == self.name:
                here = self.roots[0]
        for i, name in enumerate(path[1:], 1):
            if not isinstance(here, Module):
                break
            if name == "super":
                here = here.parent
            elif name != "self":
                # What a macro defines is taken to be where the path leads.
                here = self.look_up(here, name, i == last, (), seen) or Item(name, here)
        return here

    def look_up(
        self, module: Module, name: str, is_last: bool, blocks: Blocks = (), seen: frozenset[object] = frozenset()
    ) -> Module | Item | None:
        """The meaning of a name in a module: a block's imports, then the module's own, then those of globs."""
        if (module, name, is_last) in seen:
            return None
        seen = seen | {(module, name, is_last)}
        own = Item(name, module) if name in module.items else None
        child = module.children.get(name)
        for imports in (*reversed(blocks), module.imports):
            if imports is module.imports and child and not is_last:
                return child
            for found in imports:
                if found.name == name and (target := self.resolve(module, found.path, blocks, seen)):
                    return target
        if own or child:
            return own or child
        for imports in (*reversed(blocks), module.imports):
            for found in imports:
                if found.name is None:
                    base = self.resolve(module, found.path, blocks, seen)
                    if isinstance(base, Module) and (target := self.look_up(base, name, is_last, (), seen)):
                        return target
        return None

    def arrows(self) -> Arrows:
        """From each file to those whose names it uses, with the names and the line of each."""
        found: Arrows = {}
        for module in self.modules():
            if module.is_test:
                continue
            for line, target in sorted(self.uses(module), key=lambda use: use[0]):
                into = target.file if isinstance(target, Module) else target.module.file
                if into != module.file:
                    found.setdefault((module.file, into), {}).setdefault(target.name, line)
        return found

    def uses(self, module: Module) -> Iterator[tuple[int, Module | Item]]:
        """(line, name used) in one module."""
        used_through = {mention.path[0] for mention in module.mentions if len(mention.path) > 1}
        for found, blocks in [*((found, ()) for found in module.imports), *module.inner_imports]:
            target = self.resolve(module, found.path, blocks)
            if target is None:
                continue
            owner = target if isinstance(target, Module) else target.module
            if found.is_public and owner.is_below(module):
                continue  # A door.
            if isinstance(target, Item):
                yield found.line, target
            elif found.name is None:
                # A trait's methods are used without its name.
                yield from ((found.line, Item(name, target)) for name, kind in target.items.items() if kind == "trait")
            elif found.name not in used_through:
                yield found.line, target
        for mention in module.mentions:
            if mention.is_plain:
                continue
            target = self.resolve(module, mention.path, mention.blocks)
            if target is None and len(mention.path) == 1:
                target = self.macros.get(mention.path[0])
            if isinstance(target, Item) or (target and len(mention.path) > 1):
                yield mention.line, target


# (from, to) -> the names that make the arrow, and the line of each.
Arrows = dict[tuple[Path, Path], dict[str, int]]


# --- circles ---------------------------------------------------------------------------------------------------------


def circles(arrows: Arrows) -> list[list[Path]]:
    """The sets of files that all lead to one another, largest first; no set of one."""
    next_of: dict[Path, list[Path]] = {}
    for start, end in arrows:
        next_of.setdefault(start, []).append(end)
    reached = {file: reach(file, next_of) for file in next_of}
    sets = {frozenset(other for other in reached[file] if file in reached.get(other, ())) for file in next_of}
    return sorted((sorted(files) for files in sets if len(files) > 1), key=lambda files: (-len(files), files))


def reach(start: Path, next_of: dict[Path, list[Path]]) -> set[Path]:
    found: set[Path] = set()
    waiting = [start]
    while waiting:
        for file in next_of.get(waiting.pop(), ()):
            if file not in found:
                found.add(file)
                waiting.append(file)
    return found


def shortest_circle(files: Sequence[Path], arrows: Arrows) -> list[Path]:
    """One way round with as few files as there is, the first file not repeated at its end."""
    best: list[Path] = []
    for start in files:
        came_from: dict[Path, Path] = {}
        waiting = deque([start])
        while waiting and start not in came_from:
            here = waiting.popleft()
            for end in sorted(end for begin, end in arrows if begin == here and end in files):
                if end not in came_from:
                    came_from[end] = here
                    waiting.append(end)
        way = [start]
        while came_from[way[-1]] != start:
            way.append(came_from[way[-1]])
        way = [start, *reversed(way[1:])]
        if not best or len(way) < len(best):
            best = way
    return best
