"""The imports between Python files, for `check_layers`: of the package and of bench/."""

from __future__ import annotations

import ast
from collections.abc import Collection, Iterator
from functools import cache
from pathlib import Path

from rust_modules import Arrows

Import = ast.Import | ast.ImportFrom


def import_nodes(path: Path) -> tuple[Import, ...]:
    """The imports of a file, those inside functions and those of `import_module("...")` too."""
    state = path.stat()
    return _import_nodes(path, state.st_mtime_ns, state.st_size)


@cache  # the checks ask several times, and for each name of a door
def _import_nodes(path: Path, *_: int) -> tuple[Import, ...]:
    tree = ast.parse(path.read_text(encoding="utf-8"), filename=str(path))
    found = (node if isinstance(node, Import) else late_import(node) for node in ast.walk(tree))
    return tuple(node for node in found if node is not None)


def late_import(node: ast.AST) -> ast.Import | None:
    """The import that a call of `import_module` with a literal is."""
    if not isinstance(node, ast.Call) or len(node.args) != 1 or not isinstance(node.args[0], ast.Constant):
        return None
    called, name = node.func, node.args[0].value
    said = called.attr if isinstance(called, ast.Attribute) else called.id if isinstance(called, ast.Name) else ""
    if said not in ("import_module", "__import__") or not isinstance(name, str):
        return None
    return ast.Import([ast.alias(name)], lineno=node.lineno, col_offset=node.col_offset)


class Sources:
    """The files below one folder that Python looks in.

    root: the folder on the path, e.g. python/.
    """

    def __init__(self, root: Path) -> None:
        self.root = root
        self._nodes: dict[Path, tuple[Import, ...]] = {}
        self._is_file = cache(Path.is_file)

    def files(self) -> list[Path]:
        stubs = [path for path in self.root.rglob("*.pyi") if not path.with_suffix(".py").exists()]
        return sorted([*self.root.rglob("*.py"), *stubs])

    def arrows(self, files: Collection[Path] | None = None) -> Arrows:
        """From each file to those whose names it imports, with the names and the line of each.

        Imports inside functions, by `import_module` and for type checkers count as well: they are knowledge too. What a
        package's `__init__.py` takes from below itself does not: it is a door, and imports through it lead to the file
        behind.
        """
        found: Arrows = {}
        for path in self.files() if files is None else files:
            for line, into, name in self.imports(path):
                is_door = path.stem == "__init__" and into.is_relative_to(path.parent)
                if into != path and not is_door:
                    found.setdefault((path, into), {}).setdefault(name, line)
        return found

    def imports(self, path: Path) -> Iterator[tuple[int, Path, str]]:
        """(line, file, name) of each import in the file that leads to another one here."""
        for node in self._imports(path):
            if isinstance(node, ast.Import):
                for alias in node.names:
                    file = self._module(path, alias.name.split("."))
                    if file is not None:
                        yield node.lineno, file, alias.name
            else:
                for alias in node.names:
                    file = self._defining(path, node, alias.name)
                    if file is not None:
                        yield node.lineno, file, alias.name

    def _defining(self, path: Path, node: ast.ImportFrom, name: str) -> Path | None:
        """The file that defines `name` of a `from ... import name`: behind doors, as far as they lead."""
        if node.level:
            names = list(path.relative_to(self.root).parts[: -node.level])
        else:
            names = []
        names += node.module.split(".") if node.module else []
        module = self._module(path, names) if names else None
        inner = self._module(path, [*names, name])
        if inner is not None:
            return inner
        if module is None or module.stem != "__init__" or module == path:
            return module
        for passing in self._imports(module):
            if isinstance(passing, ast.ImportFrom):
                for alias in passing.names:
                    if (alias.asname or alias.name) == name:
                        return self._defining(module, passing, alias.name) or module
        return module

    def _module(self, path: Path, names: list[str]) -> Path | None:
        """The file of a dotted name: as Python looks, and for a script beside it."""
        for start in (self.root, path.parent):
            base = start.joinpath(*names)
            for file in (base / "__init__.py", base.with_suffix(".py"), base.with_suffix(".pyi")):
                if self._is_file(file):
                    return file
        return None

    def _imports(self, path: Path) -> tuple[Import, ...]:
        if path not in self._nodes:
            self._nodes[path] = import_nodes(path)
        return self._nodes[path]
