"""The content of the hand, and the world around it, for a document: made on demand, and cached for undo."""

from __future__ import annotations

from collections import OrderedDict
from collections.abc import Callable
from typing import TypeVar

import numpy as np

from feeler.arguments import check_word
from feeler.choices import SAMPLE_TOOL_NAMES
from feeler.errors import WorkbenchError
from feeler.mockup import Tool
from feeler.samples import sample_tool, sample_tool_names
from feeler.scene import Scene
from feeler.workbench.document import motion
from feeler.workbench.document.document import Document
from feeler.workbench.document.document import World as WorldKey
from feeler.workbench.document.motion import Row
from feeler.workbench.engine.geometry import HeldGeometry
from feeler.workbench.engine.parts import PartTools
from feeler.workbench.engine.world import World

_KEPT = 16


HeldKey = tuple[str | None, tuple[tuple[int, Row], ...]]
Key = TypeVar("Key")
Made = TypeVar("Made")


def held_key(document: Document) -> HeldKey:
    """A key of the hand's content: the tool's name, and the gripped parts with their places."""
    return (document.tool.name if document.tool else None, tuple(document.gripped.items()))


class Hands:
    """Tools, worlds and the hand's geometry for pages, for documents of one scene."""

    def __init__(self, scene: Scene, tools: dict[str, Tool]) -> None:
        """tools: available ones; built-in ones are available too, unless their name is taken, and are made on
        demand."""
        self.scene, self._tools, self._given = scene, dict(tools), dict(tools)
        self.names = (*tools, *(name for name in sample_tool_names() if name not in tools))
        self.meshes = PartTools(scene.mockup)
        self._held: OrderedDict[HeldKey, Tool] = OrderedDict()
        self._worlds: OrderedDict[WorldKey, World] = OrderedDict()
        self._geometries: OrderedDict[int, HeldGeometry] = OrderedDict()
        self._versions: dict[HeldKey, int] = {}
        self._keys: dict[int, HeldKey] = {}

    def tool(self, name: str) -> Tool:
        """The tool of a name in `names`."""
        if name not in self._tools:
            self._tools[name] = sample_tool(check_word("name", name, SAMPLE_TOOL_NAMES))
        return self._tools[name]

    def built_in(self) -> frozenset[str]:
        """The names of available tools that are the built-in ones, coarse or fine.

        May take seconds, as it makes fine tools to compare with: not for what a picture waits for.
        """
        given = self._given.copy()
        return frozenset(name for name in sample_tool_names() if name not in given or _is_sample(given[name]))

    def add(self, tool: Tool) -> None:
        """Makes a tool available by its name."""
        self._tools[tool.name] = self._given[tool.name] = tool
        self.names = (tool.name, *(name for name in self.names if name != tool.name))

    def counts(self) -> dict[str, int]:
        """Triangles of all tools by name; 0 for those not taken yet."""
        return {name: self._tools[name].triangle_count if name in self._tools else 0 for name in self.names}

    def version(self, document: Document) -> int:
        """The version of the hand's content, the same for the same content; 0: it is empty."""
        key = held_key(document)
        if key == (None, ()):
            return 0
        version = self._versions.setdefault(key, max(self._versions.values(), default=0) + 1)
        self._keys[version] = key
        return version

    def begin(self, document: Document) -> None:
        """Goes on with the version of a saved document; the earlier ones are forgotten."""
        self._versions, self._keys, key = {}, {}, held_key(document)
        if key != (None, ()) and document.held_version > 0:
            self._versions[key] = document.held_version

    def held(self, document: Document) -> Tool | None:
        """The content of the hand; None if it is empty."""
        key = held_key(document)
        return None if key == (None, ()) else self._tool(key)

    def world(self, document: Document) -> World:
        """The world around the hand. As for questions, parts that are out are not in it, wherever they were laid."""
        moved, gone = document.world
        gone = (*gone, *(part for part, _ in moved if part in document.out))
        moved = tuple((part, at) for part, at in moved if part not in document.out)
        state = document.mechanism
        number = None if state is None or document.on_joint is None else state.number(document.on_joint)
        if state is not None and number is not None:
            # What follows the hand is not where it was.
            gone = tuple(sorted({*gone, *state.followers(number)}))
            moved = tuple((part, at) for part, at in moved if part not in gone)
        return _kept(self._worlds, (moved, gone), lambda: World(self.scene, self.meshes, dict(moved), gone))

    def geometry(self, version: int) -> HeldGeometry:
        """The geometry of the hand's content, for pages. Raises `WorkbenchError` for a version that never existed."""
        if version not in self._keys:
            raise WorkbenchError(f"there is no version {version} of the hand's content", "held", "reload the page")
        return _kept(self._geometries, version, lambda: HeldGeometry(self._tool(self._keys[version]), version))

    def _tool(self, key: HeldKey) -> Tool:
        name, gripped = key
        if not gripped and name is not None:
            return self.tool(name)
        return _kept(self._held, key, lambda: self.assembled(name, gripped))

    def assembled(self, name: str | None, gripped: tuple[tuple[int, Row], ...]) -> Tool:
        """A tool, if it is named, and parts at their places in the hand, as one."""
        items: dict[str, Tool | tuple[Tool, motion.Floats]] = {}
        if name is not None:
            items[name] = self.tool(name)
        for part, place in gripped:
            path = self.scene.mockup.part_paths[part]
            # Paths need not be unique, and a part may have the tool's name.
            label = path if path not in items else f"{path} ({part})"
            items[label] = (self.meshes.of(part)[0], motion.matrix(place))
        return Tool.assembly(items, name or "parts")


def _is_sample(tool: Tool) -> bool:
    """Whether this is the built-in tool of its name, coarse or fine."""
    if tool.name not in sample_tool_names():
        return False
    name = check_word("name", tool.name, SAMPLE_TOOL_NAMES)
    made = (sample_tool(name, fine=is_fine) for is_fine in (False, True))
    return any(
        each.triangle_count == tool.triangle_count and np.array_equal(each.vertices, tool.vertices) for each in made
    )


def _kept(cache: OrderedDict[Key, Made], key: Key, make: Callable[[], Made]) -> Made:
    """The value of a key, made if it is not cached; drops the oldest."""
    if key not in cache:
        cache[key] = make()
        if len(cache) > _KEPT:
            cache.popitem(last=False)
    cache.move_to_end(key)
    return cache[key]
