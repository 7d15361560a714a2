"""Settings that slicers store beside the model of a 3MF: names, and parts that are holes or modifiers, not bodies.

PrusaSlicer and SuperSlicer write `Slic3r_PE_model.config`, with volumes that are runs of triangles; Bambu Studio and
OrcaSlicer write `model_settings.config`, with a part for every component. Neither is standard, so errors in them do not
reject a file.
"""

from __future__ import annotations

from feeler.errors import LoadError
from feeler.io.raw import clean_name
from feeler.io.threemf_model import Model
from feeler.io.threemf_package import EncryptedError, Handler

_FILES = ("Metadata/model_settings.config", "Metadata/Slic3r_PE_model.config")
_BODIES = ("", "normal_part", "ModelPart")
_KINDS = {
    "negative_part": "holes",
    "NegativeVolume": "holes",
    "modifier_part": "modifiers",
    "ParameterModifier": "modifiers",
    "support_enforcer": "support enforcers",
    "SupportEnforcer": "support enforcers",
    "support_blocker": "support blockers",
    "SupportBlocker": "support blockers",
}
_TAKEN = "are {} to the slicer that wrote the file: they were taken as bodies, like all others"


def apply_settings(model: Model, root: str) -> None:
    """Name objects that have no name, and count parts that are not bodies."""
    for reference in _FILES:
        key = model.package.find(reference)
        if key is None:
            continue
        settings = _Settings()
        try:
            model.package.parse(key, settings)
        except (LoadError, EncryptedError):
            model.tally.add("settings of slicers were not understood: they hold names, and move no vertex", reference)
            continue
        for kind, name in settings.others:
            model.tally.add("parts " + _TAKEN.format(_KINDS.get(kind, "no bodies")), name)
        for number, name in settings.objects.items():
            found = model.objects.get((root, number))
            if found is not None and name and not found.is_named:
                found.name = name
            for use in found.uses if found is not None else ():
                part = settings.parts.get((number, use.target[1]))
                target = model.objects.get(use.target)
                if part and not use.name and target is not None and not target.is_named:
                    use.name = part


class _Settings(Handler):
    """Receives the elements of the settings: <object id>, <part id subtype> or <volume>, <metadata key value>."""

    def __init__(self) -> None:
        self.objects: dict[str, str] = {}
        self.parts: dict[tuple[str, str], str] = {}
        self.others: list[tuple[str, str]] = []  # (kind, name) of parts that are not bodies
        self._object = ""
        self._part: str | None = None
        self._kind = self._label = ""

    def start(self, tag: str, attributes: dict[str, str]) -> None:
        """Receive the start of an element."""
        if tag == "object":
            self._object = attributes.get("id", "")
            self.objects.setdefault(self._object, "")
        elif tag in ("part", "volume"):
            self._part = attributes.get("id", "")
            self._kind, self._label = attributes.get("subtype", ""), ""
        elif tag == "metadata":
            key, value = attributes.get("key"), attributes.get("value", "")
            if key == "name":
                self._take_name(clean_name(value, ""))
            elif key == "volume_type" and self._part is not None:
                self._kind = value
            elif key == "modifier" and value == "1" and self._part is not None:
                self._kind = self._kind or "ParameterModifier"

    def end(self, tag: str) -> None:
        """Receive the end of an element."""
        if tag in ("part", "volume") and self._part is not None:
            if self._part and self._label:
                self.parts[self._object, self._part] = self._label
            if self._kind not in _BODIES:
                self.others.append((self._kind, self._label or f"object {self._object}"))
            self._part = None
        elif tag == "object":
            self._object = ""

    def _take_name(self, name: str) -> None:
        if self._part is not None:
            self._label = name
        elif self._object and name:
            self.objects[self._object] = name
