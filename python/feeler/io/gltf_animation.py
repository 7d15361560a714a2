"""Animations of glTF: translations and rotations of nodes over time, and the nodes above them."""

from __future__ import annotations

import math
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
import numpy.typing as npt

from feeler.arguments import check_whole
from feeler.errors import OptionError
from feeler.io.gltf_document import Document
from feeler.io.gltf_nodes import SceneGraph
from feeler.io.placing import IDENTITY, multiply
from feeler.io.tally import Tally

Floats = npt.NDArray[np.float64]

_WIDTHS = {"translation": 3, "rotation": 4, "scale": 3}
_KINDS = ("LINEAR", "STEP", "CUBICSPLINE")
_SAME = 1e-6  # of scales that are written at every key and do not change
_NO_MOVE, _NO_TURN, _NO_SIZE = (0.0, 0.0, 0.0), (0.0, 0.0, 0.0, 1.0), (1.0, 1.0, 1.0)


@dataclass(frozen=True, eq=False)
class Sampler:
    """Values over time.

    times: `(k,)` seconds, ascending. values: `(k, 3)` metres, or `(k, 4)` unit quaternions (x, y, z, w), each on the
    shorter way from the one before. kind: "LINEAR", "STEP" or "CUBICSPLINE". into, out: `(k, width)`, tangents of the
    latter, per second; empty for the others.
    """

    times: Floats
    values: Floats
    kind: str
    into: Floats
    out: Floats


@dataclass(frozen=True, eq=False)
class Node:
    """A node that moves. above: the next node above it that moves, -1 for none; above_from_here: what stands between
    that (or the world of the file) and this node's parent, `(4, 4)`; move, turn, size: where it is at rest."""

    index: int
    name: str
    above: int
    above_from_parent: Floats
    move: Floats
    turn: Floats
    size: Floats
    moves: Sampler | None
    turns: Sampler | None


@dataclass(frozen=True, eq=False)
class Animation:
    """An animation. nodes: those that move, by number, those above first. mover: of each node of the file that hangs on
    one of them the nearest."""

    name: str
    names: tuple[str, ...]
    nodes: dict[int, Node]
    mover: dict[int, int]


def read_animation(path: Path, which: str | int | None) -> Animation:
    """An animation by name or number; None: the only one. Raises `OptionError`, `LoadError`."""
    document = Document(path)
    graph = SceneGraph(document, Tally())
    names = _names(document, path)
    number = _chosen(names, which, path)
    entry = document.item("animations", number)
    where = f"animation {names[number]!r}"
    samplers: dict[int, dict[str, Sampler]] = {}
    channels = entry.get("channels", [])
    for place, channel in enumerate(channels if isinstance(channels, list) else []):
        _add_channel(document, entry, channel, f"{where}, channel {place}", samplers)
    samplers = {node: own for node, own in samplers.items() if node in graph.worlds and own}
    if not samplers:
        raise document.fail(f"{where} moves no node of the scene", damaged=False)
    nodes, mover = _tree(document, samplers, graph)
    _check_skins(document, mover, graph, where)
    return Animation(names[number], tuple(names), nodes, mover)


def _names(document: Document, path: Path) -> list[str]:
    entries = document.root.get("animations", [])
    if not isinstance(entries, list) or not entries:
        raise document.fail("there is no animation in it; export it with its animations", damaged=False)
    return [str(document.item("animations", i).get("name", f"animation {i}")) for i in range(len(entries))]


def _chosen(names: list[str], which: str | int | None, path: Path) -> int:
    if which is None:
        if len(names) == 1:
            return 0
        raise OptionError(f"{path} has {len(names)} animations: give animation= one of {', '.join(map(repr, names))}")
    if isinstance(which, str):
        if which not in names:
            raise OptionError(f"{path} has no animation {which!r}: there are {', '.join(map(repr, names))}")
        return names.index(which)
    return check_whole("animation", which, 0, len(names) - 1, other=", or the name of one")


def _add_channel(
    document: Document, entry: dict[str, Any], channel: Any, where: str, found: dict[int, dict[str, Sampler]]
) -> None:
    if not isinstance(channel, dict) or not isinstance(channel.get("target"), dict):
        raise document.fail(f"{where} has no target")
    target = channel["target"]
    what = target.get("path")
    if what == "pointer":
        extensions = target.get("extensions")
        pointed = extensions.get("KHR_animation_pointer") if isinstance(extensions, dict) else None
        text = str(pointed.get("pointer", "")) if isinstance(pointed, dict) else ""
        if text.startswith("/nodes/"):
            raise document.fail(
                f"{where} moves {text[:60]!r} by a pointer, which is not read; export plain channels", False
            )
        return  # colours, lights and cameras
    node = target.get("node")
    if node is None:
        return  # by the standard, such channels are ignored
    name = str(document.item("nodes", node).get("name", f"node {node}"))
    if what == "weights":
        raise document.fail(f"{where} changes the shape of {name!r} by weights: only rigid motion is read", False)
    if what not in _WIDTHS:
        raise document.fail(f"{where} has the path {str(what)[:40]!r}: translation and rotation are read")
    samplers = entry.get("samplers")
    index = channel.get("sampler")
    if (
        not isinstance(samplers, list)
        or not isinstance(index, int)
        or not 0 <= index < len(samplers)
        or not isinstance(samplers[index], dict)
    ):
        raise document.fail(f"{where} names sampler {str(index)[:20]}, which is not there")
    sampler = _sampler(document, samplers[index], what, where)
    if what == "scale":
        rest = np.array(document.item("nodes", node).get("scale", _NO_SIZE), dtype=np.float64)
        largest = float(np.abs(sampler.values - rest).max()) + float(np.abs(sampler.out).max(initial=0.0))
        if largest > _SAME * max(1.0, float(np.abs(rest).max())):
            raise document.fail(f"{where} scales {name!r}: parts keep their size; export without scale", False)
        return
    if "matrix" in document.item("nodes", node):
        raise document.fail(f"{where} moves {name!r}, which is placed by a matrix: the standard forbids it")
    if what in found.setdefault(node, {}):
        raise document.fail(f"{where} gives the {what} of {name!r} a second time")
    found[node][what] = sampler


def _sampler(document: Document, item: dict[str, Any], what: str, where: str) -> Sampler:
    kind = item.get("interpolation", "LINEAR")
    if kind not in _KINDS:
        raise document.fail(f"{where} has the interpolation {str(kind)[:40]!r}: {', '.join(_KINDS)} are known")
    times = document.array(item.get("input"), 1).astype(np.float64)
    values = document.array(item.get("output"), _WIDTHS[what], normalise=True).astype(np.float64)
    if not len(times) or not np.isfinite(times).all() or (np.diff(times) <= 0.0).any():
        raise document.fail(f"{where} has times that do not ascend, or none")
    if len(values) != len(times) * (3 if kind == "CUBICSPLINE" else 1):
        raise document.fail(f"{where} has {len(times):,} times and {len(values):,} values")
    if not np.isfinite(values).all():
        raise document.fail(f"{where} has values that are no numbers")
    into = out = np.empty((0, values.shape[1]))
    if kind == "CUBICSPLINE":
        into, values, out = values[0::3], values[1::3], values[2::3]
    if what == "rotation":
        lengths = np.linalg.norm(values, axis=1)
        if (lengths < 0.5).any():
            raise document.fail(f"{where} has a rotation of length zero")
        if kind != "CUBICSPLINE":
            values = values / lengths[:, None]
            flips = np.cumprod(np.where((values[1:] * values[:-1]).sum(axis=1) < 0.0, -1.0, 1.0))
            values = values * np.concatenate([[1.0], flips])[:, None]
    return Sampler(times, values, kind, into, out)


def _tree(
    document: Document, samplers: dict[int, dict[str, Sampler]], graph: SceneGraph
) -> tuple[dict[int, Node], dict[int, int]]:
    parent = {}
    for index in graph.worlds:
        children = document.item("nodes", index).get("children")
        for child in children if isinstance(children, list) else []:
            parent[child] = index
    nodes: dict[int, Node] = {}
    mover: dict[int, int] = {}
    for index in graph.worlds:  # parents come first
        above = mover.get(parent.get(index, -1), -1)
        if index not in samplers:
            if above >= 0:
                mover[index] = above
            continue
        entry = document.item("nodes", index)
        stands = graph.worlds[parent[index]] if index in parent else IDENTITY
        if above >= 0:
            stands = multiply(_inverse(graph.worlds[above], document, above), stands)
        rest = [
            np.array(document.numbers(entry.get(key, list(default)), f"nodes[{index}].{key}", len(default)))
            for key, default in (("translation", _NO_MOVE), ("rotation", _NO_TURN), ("scale", _NO_SIZE))
        ]
        turn = rest[1] / math.sqrt(float(rest[1] @ rest[1]))
        own = samplers[index]
        name = str(entry.get("name", f"node {index}"))
        nodes[index] = Node(
            index, name, above, stands, rest[0], turn, rest[2], own.get("translation"), own.get("rotation")
        )
        mover[index] = index
    return nodes, mover


def _inverse(matrix: Floats, document: Document, index: int) -> Floats:
    try:
        return np.asarray(np.linalg.inv(matrix), dtype=np.float64)
    except np.linalg.LinAlgError:
        raise document.fail(f"nodes[{index}] moves and has a scale of zero", damaged=False) from None


def _check_skins(document: Document, mover: dict[int, int], graph: SceneGraph, where: str) -> None:
    for instance in graph.instances:
        if instance.shape.skin is None:
            continue
        joints = document.item("skins", instance.shape.skin).get("joints", [])
        if any(joint in mover for joint in joints if isinstance(joint, int)):
            raise document.fail(f"{where} bends {instance.name!r} by its skin: only rigid motion is read", False)
