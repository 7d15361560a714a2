"""Reads URDF: links with their geometry, joints with their limits. Nothing is placed or loaded here."""

from __future__ import annotations

import math
from dataclasses import dataclass
from pathlib import Path
from xml.etree import ElementTree
from xml.parsers import expat

import numpy as np
import numpy.typing as npt

from feeler.errors import LoadError, MissingFileError

Floats = npt.NDArray[np.float64]
Element = ElementTree.Element

SIZES = {"box": ("size", 3), "cylinder": ("radius length", 2), "sphere": ("radius", 1), "capsule": ("radius length", 2)}
"""Shapes: the attributes of their sizes, and the number of values of each."""


MOST_BYTES = 64 * 2**20
"""Larger files are refused: robots have some hundred links."""


@dataclass(frozen=True, eq=False)
class Geometry:
    """One `<collision>` or `<visual>`: a shape of `sizes`, metres, or a mesh file."""

    name: str | None
    link_from_geometry: Floats  # (4, 4), metres
    kind: str  # "box", "cylinder", "sphere", "capsule" or "mesh"
    sizes: tuple[float, ...] = ()
    filename: str = ""
    scale: tuple[float, float, float] = (1.0, 1.0, 1.0)


@dataclass(frozen=True)
class Link:
    """A rigid body."""

    name: str
    collision: list[Geometry]
    visual: list[Geometry]


@dataclass(frozen=True)
class Mimic:
    """A joint that follows another: its value is `multiplier` times the other's, plus `offset`."""

    joint: str
    multiplier: float
    offset: float


@dataclass(frozen=True, eq=False)
class Joint:
    """The connection of a link to its parent. `lower`, `upper`: radians or metres, infinite without limits."""

    name: str
    kind: str
    parent: str
    child: str
    parent_from_joint: Floats  # (4, 4), metres
    axis: Floats  # (3,), unit
    lower: float
    upper: float
    mimic: Mimic | None


TURNS = ("revolute", "continuous")
MOVES = (*TURNS, "prismatic")
KINDS = (*MOVES, "fixed", "floating", "planar")


def read_urdf(file: Path) -> tuple[list[Link], list[Joint]]:
    """The links and joints, in the file's order. Raises `LoadError`, with the link or joint, for an invalid URDF."""
    root = _root(file)
    links = []
    for i, element in enumerate(root.findall("link")):
        name = _name(element, f"{file}: link {i}")
        where = f"{file}: link {name!r}"
        links.append(Link(name, *([_geometry(e, where) for e in element.findall(k)] for k in ("collision", "visual"))))
    joints = [_joint(element, f"{file}: joint {i}", file) for i, element in enumerate(root.findall("joint"))]
    if not links:
        raise LoadError(f"{file}: the robot has no link")
    return links, joints


def _root(file: Path) -> Element:
    if not file.is_file():
        what = "is a folder" if file.is_dir() else "does not exist"
        raise MissingFileError(f"{file} {what}: give a URDF file")
    if file.stat().st_size > MOST_BYTES:
        raise LoadError(f"{file}: it has more than {MOST_BYTES >> 20} MiB, too many for a URDF; keep meshes in files")
    builder = ElementTree.TreeBuilder()

    def start(tag: str, attributes: dict[str, str]) -> None:
        if tag.startswith("xacro:") or any("${" in value or "$(" in value for value in attributes.values()):
            raise LoadError(f"{file}: this is xacro, which makes URDF; run it first: xacro {file.name} > robot.urdf")
        builder.start(tag, attributes)

    def doctype(*_: object) -> None:
        # Declares entities: a few lines could exceed all memory, or refer to other files.
        raise LoadError(f"{file}: it declares a document type, which URDF does not need; remove it")

    parser = expat.ParserCreate()
    parser.StartElementHandler = start
    parser.EndElementHandler = builder.end
    parser.StartDoctypeDeclHandler = doctype
    try:
        parser.Parse(file.read_bytes(), True)
    except expat.ExpatError as error:
        raise LoadError(f"{file}: the XML cannot be read ({error}); export it again") from None
    except OSError as error:
        raise LoadError(f"{file}: cannot be read ({error.strerror or error})") from error
    root = builder.close()
    if root.tag != "robot":
        raise LoadError(f"{file}: this is not URDF: it begins with <{root.tag[:40]}> and not with <robot>")
    return root


def _geometry(element: Element, where: str) -> Geometry:
    shape = element.find("geometry")
    if shape is None or not len(shape):
        raise LoadError(f"{where}: a <{element.tag}> has no <geometry> with a shape in it")
    shape = shape[0]
    name, placed = element.get("name"), _origin(element.find("origin"), where)
    if shape.tag == "mesh":
        filename = shape.get("filename", "").strip()
        if not filename:
            raise LoadError(f"{where}: a mesh has no filename")
        scale = _numbers(shape.get("scale", "1 1 1"), (1, 3), f"{where}: the scale of {filename!r}")
        if 0.0 in scale:
            raise LoadError(f"{where}: the scale of {filename!r} is {scale}: three numbers, none 0, are needed")
        x, y, z = scale * 3 if len(scale) == 1 else scale
        return Geometry(name, placed, "mesh", filename=filename, scale=(x, y, z))
    if shape.tag not in SIZES:
        raise LoadError(f"{where}: it has a <{shape.tag}>: {', '.join(SIZES)} and mesh are known")
    attributes, count = SIZES[shape.tag]
    text = " ".join(shape.get(attribute, "") for attribute in attributes.split())
    sizes = _numbers(text, (count,), f"{where}: {attributes.replace(' ', ' and ')} of its {shape.tag}")
    if min(sizes) <= 0:
        raise LoadError(f"{where}: its {shape.tag} has the sizes {sizes}: {count} positive lengths are needed")
    return Geometry(name, placed, shape.tag, sizes)


def _joint(element: Element, where: str, file: Path) -> Joint:
    name = _name(element, where)
    where = f"{file}: joint {name!r}"
    kind = element.get("type", "")
    if kind not in KINDS:
        raise LoadError(f"{where} is of type {kind!r}: {', '.join(KINDS)} are known")
    ends = [None if end is None else end.get("link") for end in (element.find("parent"), element.find("child"))]
    parent, child = ends
    if parent is None or child is None:
        raise LoadError(f"{where} does not name the links that it is between (<parent link=.../>, <child link=.../>)")
    axis_element, limit = element.find("axis"), element.find("limit")
    text = "1 0 0" if axis_element is None else axis_element.get("xyz", "1 0 0")
    axis = np.array(_numbers(text, (3,), f"{where}: its axis"))
    length = float(np.linalg.norm(axis))
    if kind in MOVES and not (0 < length < math.inf):
        raise LoadError(f"{where}: its axis is {text!r}: three numbers, not all 0, are needed")
    lower, upper = -math.inf, math.inf
    if limit is not None and kind in MOVES and kind != "continuous":
        # Missing limits read as 0; both 0, as exporters write for none, would lock the joint.
        low, high = (_numbers(limit.get(end, "0"), (1,), f"{where}: its limit")[0] for end in ("lower", "upper"))
        if low != high:
            lower, upper = min(low, high), max(low, high)
    return Joint(
        name,
        kind,
        parent,
        child,
        _origin(element.find("origin"), where),
        axis / length if length > 0 else axis,
        lower,
        upper,
        _mimic(element.find("mimic"), where),
    )


def _mimic(element: Element | None, where: str) -> Mimic | None:
    if element is None:
        return None
    multiplier = _numbers(element.get("multiplier", "1"), (1,), f"{where}: the multiplier of its mimic")[0]
    offset = _numbers(element.get("offset", "0"), (1,), f"{where}: the offset of its mimic")[0]
    return Mimic(element.get("joint", ""), multiplier, offset)


def _name(element: Element, where: str) -> str:
    name = element.get("name")
    if not name:
        raise LoadError(f"{where} of the file has no name")
    return name


def _origin(element: Element | None, where: str) -> Floats:
    """Rotated about fixed x, then y, then z, and translated."""
    matrix = np.eye(4)
    if element is None:
        return matrix
    roll, pitch, yaw = _numbers(element.get("rpy", "0 0 0"), (3,), f"{where}: rpy of an origin")
    matrix[:3, 3] = _numbers(element.get("xyz", "0 0 0"), (3,), f"{where}: xyz of an origin")
    for axis, angle in (((1, 0, 0), roll), ((0, 1, 0), pitch), ((0, 0, 1), yaw)):
        matrix[:3, :3] = turn(np.array(axis, dtype=np.float64), angle) @ matrix[:3, :3]
    return matrix


def turn(axis: Floats, angle: float) -> Floats:
    """The rotation about a unit axis, (3, 3), by radians; Rodrigues' formula."""
    x, y, z = axis
    cross = np.array([[0, -z, y], [z, 0, -x], [-y, x, 0]])
    turned: Floats = np.eye(3) + math.sin(angle) * cross + (1 - math.cos(angle)) * (cross @ cross)
    return turned


def _numbers(text: str, counts: tuple[int, ...], what: str) -> tuple[float, ...]:
    try:
        numbers = tuple(float(word) for word in text.replace(",", " ").split())
    except ValueError:
        numbers = ()
    if len(numbers) not in counts or not all(math.isfinite(number) for number in numbers):
        raise LoadError(f"{what} is {text!r}: {' or '.join(str(n) for n in counts)} finite numbers are needed")
    return numbers
