"""The model files of a 3MF package: objects, and notes on shapes that are not triangles."""

from __future__ import annotations

import re
from dataclasses import dataclass, field
from typing import Any

import numpy as np
from numpy.typing import NDArray

from feeler.io.placing import IDENTITY, Matrix
from feeler.io.raw import clean_name, seal_indices
from feeler.io.tally import Tally
from feeler.io.threemf_package import SEPARATOR, EncryptedError, Handler, Package
from feeler.progress import Progress

ObjectKey = tuple[str, str]
"""(key of the model file, object id)"""

_FAMILY = re.compile(r"/3dmanufacturing/([a-z]+)", re.IGNORECASE)
# Extensions with known elements, in any version; an unknown element is treated as one of an unknown extension.
_KNOWN = {
    "core", "production", "material", "trianglesets", "triangleset", "slice", "beamlattice", "booleanoperations",
    "volumetric", "implicit", "displacement", "securecontent",
}  # fmt: skip
# Elements in objects that move no surface. Volume properties are colours and materials, except for its boundary.
_HARMLESS = {
    ("production", "alternatives"), ("trianglesets", "trianglesets"), ("triangleset", "trianglesets"),
    ("triangleset", "triangleset"), ("volumetric", "volumedata"), ("displacement", "vertices"),
    ("displacement", "triangles"),
}  # fmt: skip

_MISSING = "has no triangle and is missing"
LATTICE = "objects have a beam lattice (extension 'beamlattice'): it was left out, as only triangles collide"
LATTICE_SHOWN = "objects are beam lattices: the mesh that the file gives in their place was taken"
BOOLEAN = f"objects are boolean operations on others (extension 'booleanoperations'): each {_MISSING}"
LEVEL_SET = f"objects are level sets (extension 'volumetric'): each {_MISSING}"
SLICES = f"objects are slices alone (extension 'slice'): each {_MISSING}"
ENCRYPTED = "objects are encrypted (extension 'securecontent'): each is missing"
EMPTY = "objects hold no triangle"
BOUNDARY = "objects have a volumetric boundary (extension 'volumetric'): their triangles were taken without it"
DISPLACED = "objects have a displaced surface (extension 'displacement'): their triangles were taken as they are"
COARSE = "objects have their shape in slices (extension 'slice'): the coarse mesh that goes with them was taken"
STAND_IN = "objects are coarse or obfuscated stand-ins (extension 'production'): the full shape was not taken"
STAND_INS = (COARSE, STAND_IN, LATTICE_SHOWN)
"""What was taken is not the shape of the object: collisions and distances are those of the stand-in."""
UNPRINTED = 'items are not to be printed (printable="0"): they were taken like all others'
_OTHER = "elements of objects are of no extension that is read, and were passed over"
_OTHER_UNIT = "model files state another unit than the root model: theirs was not used"


@dataclass
class Use:
    """An item of the build, or a component of an object. `needs`: a required extension that is not read."""

    target: ObjectKey
    matrix: Matrix
    name: str = ""
    needs: str = ""
    attributes: dict[str, str] = field(default_factory=dict)


@dataclass(eq=False)
class Object:
    """A mesh, or components, or neither; `lacks` describes the latter in the words of a `Tally`."""

    name: str
    numbers: list[str] = field(default_factory=list)  # x y z of every vertex while reading
    indices: list[str] = field(default_factory=list)
    vertices: NDArray[np.float64] = field(default_factory=lambda: np.empty((0, 3)))
    faces: NDArray[np.uint32] = field(default_factory=lambda: np.empty((0, 3), dtype=np.uint32))
    uses: list[Use] = field(default_factory=list)
    lacks: dict[str, None] = field(default_factory=dict)
    needs: str = ""
    kind: str = "model"
    attributes: dict[str, str] = field(default_factory=dict)
    is_named: bool = False
    is_sliced: bool = False


class Model:
    """The data read from all model files of one 3MF."""

    def __init__(self, package: Package, tally: Tally) -> None:
        self.package = package
        self.tally = tally
        self.objects: dict[ObjectKey, Object] = {}
        self.items: list[Use] = []
        self.unit = "millimeter"
        self.operands: set[ObjectKey] = set()  # objects that other kinds of shapes are made of
        self.unread: dict[str, None] = {}  # required extensions that are not read
        self.encrypted: set[str] = set()
        self.pending: list[str] = []

    def take(self, key: str) -> None:
        """Ask for a model file."""
        self.pending.append(key)

    def object(self, use: Use, by: str) -> Object:
        """Return the object of a use; raise if it does not exist. `by` names the user in the error."""
        file, number = use.target
        if use.target not in self.objects and file in self.encrypted:
            self.objects[use.target] = Object(f"object {number[:20]}", lacks={ENCRYPTED: None})
        found = self.objects.get(use.target)
        if found is None:
            is_there = self.package.find(file) is not None
            why = f"not defined in {file!r}" if is_there else f"its model file {file!r} is not in the archive"
            raise self.package.fail(f"object {number[:20]!r} is used by {by} and {why}")
        return found


class ModelHandler(Handler):
    """Receives the XML elements of one model file."""

    def __init__(self, model: Model, key: str, is_root: bool) -> None:
        self.model = model
        self.package = model.package
        self.key = key
        self.name = model.package.name(key)
        self.is_root = is_root
        self.object: Object | None = None
        self._use: Use | None = None  # the item or component that is open
        self._metadata: tuple[str, list[str]] | None = None  # the name and text of the one that is open
        self._skipped = 0  # how many elements are open, from the outermost one of an extension on
        self._prefixes: dict[str, str] = {}
        self._required: set[str] = set()
        self._unread: set[str] = set()
        self._core: str | None = None
        self._vertex_tags: set[str] = set()
        self._triangle_tags: set[str] = set()

    def namespace(self, prefix: str | None, uri: str) -> None:
        """Receive the declaration of a namespace."""
        self._prefixes[prefix or ""] = uri
        if _family(uri) == "displacement":
            self._take_meshes_of(uri)

    def start(self, tag: str, attributes: dict[str, str]) -> None:
        """Receive the start of an element."""
        current = self.object
        if self._skipped:
            self._start_skipped(tag, attributes)
        elif tag in self._vertex_tags:
            if current is not None:
                current.numbers += (attributes["x"], attributes["y"], attributes["z"])
                if self._unread:
                    self._check_attributes(attributes)
        elif tag in self._triangle_tags:
            if current is not None:
                current.indices += (attributes["v1"], attributes["v2"], attributes["v3"])
                if self._unread:
                    self._check_attributes(attributes)
        else:
            uri, _, word = tag.rpartition(SEPARATOR)
            if self._core is None:
                self._start_model(uri, word, attributes)
            elif uri == self._core:
                self._start_core(word, attributes)
            elif current is not None or self._use is not None:
                self._start_extension(uri, word, attributes)

    def end(self, tag: str) -> None:
        """Receive the end of an element."""
        if self._skipped:
            self._skipped -= 1
            return
        uri, _, word = tag.rpartition(SEPARATOR)
        if uri != self._core:
            return
        if word == "metadata":
            self._end_metadata()
        elif word in ("item", "component"):
            self._use = None
        elif word == "object" and self.object is not None:
            self._finish(self.object)
            self.object = None

    # --- the pieces ------------------------------------------------------------------------------------------------

    def _start_model(self, uri: str, word: str, attributes: dict[str, str]) -> None:
        if word != "model":
            raise self.package.fail(f"the outermost element of {self.name!r} is <{word[:40]}>, and not <model>")
        self._core = uri
        self._take_meshes_of(uri)
        unit = attributes.get("unit")
        if self.is_root:
            self.model.unit = unit or "millimeter"
        elif unit is not None and unit != self.model.unit:
            self.model.tally.add(_OTHER_UNIT, self.name)
        for prefix in attributes.get("requiredextensions", "").split():
            required = self._prefixes.get(prefix, prefix)
            self._required.add(required)
            if required != uri and _family(required) not in _KNOWN:
                self._unread.add(required)
                self.model.unread[required] = None

    def _take_meshes_of(self, uri: str) -> None:
        lead = uri + SEPARATOR if uri else ""
        self._vertex_tags.add(lead + "vertex")
        self._triangle_tags.add(lead + "triangle")

    def _start_core(self, word: str, attributes: dict[str, str]) -> None:
        current = self.object
        if word == "object":
            self._start_object(attributes)
        elif word == "component" and current is not None:
            self._use = self._made_use(attributes)
            current.uses.append(self._use)
        elif word == "item" and self.is_root:
            self._use = self._made_use(attributes)
            self.model.items.append(self._use)
            if attributes.get("printable", "").strip().lower() in ("0", "false"):
                self.model.tally.add(UNPRINTED, self._use.name)
        elif word == "metadata" and (current is not None or self._use is not None):
            self._metadata = (attributes.get("name", "").rpartition(":")[2], [])
            self.listen(self._metadata[1].append)
        self._check_attributes(attributes)

    def _end_metadata(self) -> None:
        self.listen(None)
        holder = self._use if self._use is not None else self.object
        if self._metadata is not None and holder is not None:
            name, texts = self._metadata
            holder.attributes.setdefault(name, "".join(texts))
        self._metadata = None

    def _start_object(self, attributes: dict[str, str]) -> None:
        number = attributes["id"]
        if (self.key, number) in self.model.objects:
            raise self.package.fail(f"object {number[:20]!r} is defined twice in {self.name!r}")
        name = clean_name(attributes.get("name"), "") or clean_name(attributes.get("partnumber"), "")
        self.object = Object(name or clean_name(f"object {number}", "object"), is_named=bool(name))
        self.model.objects[self.key, number] = self.object
        self.object.attributes.update(_number(attributes))
        self.object.kind = attributes.get("type", "model")
        for key, value in attributes.items():
            uri, _, word = key.rpartition(SEPARATOR)
            family = _family(uri)
            if (family, word) == ("slice", "slicestackid"):
                self.object.is_sliced = True
            elif (family, word) == ("slice", "meshresolution") and value == "lowres":
                self.object.lacks[COARSE] = None
            elif (family, word) == ("production", "modelresolution") and value != "fullres":
                self.object.lacks[STAND_IN] = None

    def _start_extension(self, uri: str, word: str, attributes: dict[str, str]) -> None:
        """Receive the outermost element of an extension in an object or item; its content is skipped."""
        family, current = _family(uri), self.object
        if (family, word) == ("displacement", "displacementmesh") and current is not None:
            current.lacks[DISPLACED] = None
            return  # its vertices and triangles are read like those of a mesh
        self._skipped = 1 if family != "displacement" else 0
        if (family, word) == ("beamlattice", "beamlattice") and current is not None:
            stand_in = attributes.get("representationmesh")
            current.lacks[LATTICE if stand_in is None else LATTICE_SHOWN] = None
            if stand_in is not None:
                current.uses.append(Use((self.key, stand_in), IDENTITY))
            self._add_operand(attributes.get("clippingmesh"))
        elif (family, word) == ("booleanoperations", "booleanshape") and current is not None:
            current.lacks[BOOLEAN] = None
            self._add_operand(attributes.get("objectid"))
        elif (family, word) == ("volumetric", "levelset") and current is not None:
            current.lacks[LEVEL_SET] = None
            self._add_operand(attributes.get("meshid"))
        elif (family, word) not in _HARMLESS:
            if uri in self._required:
                self._need(uri)
            else:
                self.model.tally.add(_OTHER, word)

    def _start_skipped(self, tag: str, attributes: dict[str, str]) -> None:
        self._skipped += 1
        self._add_operand(attributes.get("objectid"))
        uri, _, word = tag.rpartition(SEPARATOR)
        if word == "boundary" and _family(uri) == "volumetric" and self.object is not None:
            self.object.lacks[BOUNDARY] = None

    def _add_operand(self, number: str | None) -> None:
        if number is not None:
            self.model.operands.add((self.key, number))

    def _check_attributes(self, attributes: dict[str, str]) -> None:
        """Mark the open use if an attribute belongs to a required extension that is not read."""
        for key in attributes if self._unread else ():
            uri = key.rpartition(SEPARATOR)[0]
            if uri in self._unread:
                self._need(uri)

    def _need(self, uri: str) -> None:
        self.model.unread[uri] = None
        if self._use is not None:
            self._use.needs = uri
        elif self.object is not None:
            self.object.needs = uri

    def _numbers(self, found: Object, words: list[str], kind: type[float | int]) -> NDArray[Any]:
        """Words as an array; it raises for the first that is no number."""
        try:
            return np.array(words, dtype=np.float64 if kind is float else np.int64)
        except (ValueError, OverflowError):
            wrong = next(word for word in words if not _is(kind, word))
            comma = ": 3MF has decimal points, no commas" if "," in wrong else ""
            what = "a coordinate" if kind is float else "an index"
            said = f"{found.name!r} in {self.name!r} has {wrong[:40]!r} as {what}, which is not a number{comma}"
            raise self.package.fail(said) from None

    def _finish(self, found: Object) -> None:
        found.vertices = self._numbers(found, found.numbers, float).reshape(-1, 3)
        indices = self._numbers(found, found.indices, int).reshape(-1, 3)
        found.faces = seal_indices(indices, len(found.vertices))
        found.numbers, found.indices = [], []
        if not len(found.faces) and not found.uses:
            found.lacks.pop(COARSE, None)
            if found.is_sliced:
                found.lacks[SLICES] = None
            elif not found.lacks and not found.needs:
                found.lacks[EMPTY] = None

    def _made_use(self, attributes: dict[str, str]) -> Use:
        # With the production extension an item or component may name another model file.
        reference = next(
            (
                value
                for key, value in attributes.items()
                if key.endswith(SEPARATOR + "path") and _family(key) == "production"
            ),
            None,
        )
        file = self.key
        if reference:
            key = self.package.find(reference, self.key)
            if key is not None:
                self.model.take(key)
            file = reference if key is None else key
        name = clean_name(attributes.get("partnumber"), "")
        return Use(
            (file, attributes["objectid"]), self._matrix(attributes.get("transform")), name, "", _number(attributes)
        )

    def _matrix(self, text: str | None) -> Matrix:
        """Return the 4 x 4 matrix of a 3MF transform: twelve numbers, for row vectors."""
        if not text:
            return IDENTITY
        matrix = np.eye(4)
        try:
            matrix[:3, :] = np.array(text.split(), dtype=np.float64).reshape(4, 3).T
        except ValueError as error:
            raise self.package.fail(f"the transform {text[:80]!r} is not twelve numbers") from error
        return matrix


def read_models(model: Model, root: str, progress: Progress | None = None) -> None:
    """Read the root model and all model files that it refers to."""
    model.take(root)
    seen: set[str] = set()
    while model.pending:
        key = model.pending.pop()
        if key in seen:
            continue
        seen.add(key)
        try:
            model.package.parse(key, ModelHandler(model, key, key == root), progress)
        except EncryptedError:
            if key == root:
                raise model.package.fail("its root model is encrypted", "export it without secure content") from None
            model.encrypted.add(key)


def _number(attributes: dict[str, str]) -> dict[str, str]:
    number = attributes.get("partnumber", "").strip()
    return {"number": number} if number else {}


def _family(uri: str) -> str:
    """Return the extension of a namespace, without its version: "slice"; "" if it is none of the 3MF consortium."""
    found = _FAMILY.search(uri)
    return found[1].lower() if found else ""


def _is(kind: type[float | int], word: str) -> bool:
    """Whether a word is such a number, as an array holds it."""
    try:
        np.array([word], dtype=np.float64 if kind is float else np.int64)
    except (ValueError, OverflowError):
        return False
    return True
