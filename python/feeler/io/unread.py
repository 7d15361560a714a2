"""Formats that feeler does not read, by file name: the kind of file, and the export to use instead."""

from __future__ import annotations

import re
import zipfile
from pathlib import Path

from feeler.io.raw import clean_name
from feeler.io.step_text import without_comments

CAD = "export STEP (AP214 or AP242) or glTF from the program that made it"
_IFC = re.compile(rb"FILE_SCHEMA\s*\(\s*\(\s*'(IFC[^']*)'", re.I)

_STARTS: tuple[tuple[bytes, str, str], ...] = (
    (b"#usda", "USD", "export glTF or STEP"),
    (b"PXR-USDC", "USD", "export glTF or STEP"),
    (b"Kaydara FBX Binary", "FBX", "export glTF"),
    (b"; FBX", "FBX", "export glTF"),
    (b"BLENDER", "Blender", "export glTF from Blender"),
    (b"#VRML", "VRML", "export glTF or STL"),
    (b"AC10", "DWG", "export STEP or STL"),
    (b"V5_CFV2", "CATIA V5", CAD),
    (b"**ABCDEFGHIJKLMNOPQRSTUVWXYZ", "Parasolid text (x_t)", CAD),
    (b"PS\x00\x00", "Parasolid binary (x_b)", CAD),
    (b"DBRep_DrawableShape", "OpenCASCADE BREP", "export STEP"),
    (b"CASCADE Topology", "OpenCASCADE BREP", "export STEP"),
    (b"\xd0\xcf\x11\xe0\xa1\xb1\x1a\xe1", "SolidWorks, Inventor or another OLE document", CAD),
    (b"%PDF", "PDF", CAD),
)
_INSIDE: tuple[tuple[str, str, str], ...] = (
    (".usdc", "USDZ", "export glTF or STEP"),
    (".usda", "USDZ", "export glTF or STEP"),
    (".usd", "USDZ", "export glTF or STEP"),
    (".3drep", "3DXML", CAD),
    (".3dxml", "3DXML", CAD),
    ("/guidocument.xml", "FreeCAD (FCStd)", "export STEP or glTF from FreeCAD"),
    ("/document.xml", "FreeCAD (FCStd)", "export STEP or glTF from FreeCAD"),
    ("/doc.kml", "KMZ", "unpack it, and load the COLLADA file in it"),
    (".ifc", "IFC in an archive", "unpack it, and export STEP, glTF or OBJ, for example with IfcConvert"),
)
# What feeler reads, but not in an archive.
_PACKED_HERE = (".step", ".stp", ".p21", ".stl", ".obj", ".ply", ".off", ".glb", ".gltf", ".3mf")
_ENDINGS: dict[str, tuple[str, str]] = {
    ".ifc": ("IFC", "export STEP, glTF or OBJ, for example with IfcConvert"),
    ".ifcxml": ("IFC", "export STEP, glTF or OBJ, for example with IfcConvert"),
    ".ifczip": ("IFC", "export STEP, glTF or OBJ, for example with IfcConvert"),
    ".usdz": ("USDZ", "export glTF or STEP"),
    ".usd": ("USD", "export glTF or STEP"),
    ".3dxml": ("3DXML", CAD),
    ".fcstd": ("FreeCAD (FCStd)", "export STEP or glTF from FreeCAD"),
    ".jt": ("JT", CAD),
    ".catpart": ("CATIA V5", CAD),
    ".catproduct": ("CATIA V5", CAD),
    ".sldprt": ("SolidWorks", CAD),
    ".sldasm": ("SolidWorks", CAD),
    ".ipt": ("Inventor", CAD),
    ".iam": ("Inventor", CAD),
    ".prt": ("NX or Creo", CAD),
    ".asm": ("Creo or Solid Edge", CAD),
    ".x_t": ("Parasolid text (x_t)", CAD),
    ".x_b": ("Parasolid binary (x_b)", CAD),
    ".sat": ("ACIS", CAD),
    ".igs": ("IGES", "export STEP"),
    ".iges": ("IGES", "export STEP"),
    ".brep": ("OpenCASCADE BREP", "export STEP"),
    ".fbx": ("FBX", "export glTF"),
    ".blend": ("Blender", "export glTF from Blender"),
    ".3ds": ("3DS", "export glTF"),
    ".max": ("3ds Max", "export glTF"),
    ".dxf": ("DXF", "export STEP or STL"),
    ".dwg": ("DWG", "export STEP or STL"),
    ".wrl": ("VRML", "export glTF or STL"),
    ".x3d": ("X3D", "export glTF or STL"),
    ".3dm": ("Rhino", "export STEP or glTF"),
    ".skp": ("SketchUp", "export glTF"),
}
_MOST_NAMES = 10_000


def ifc_schema(text: bytes) -> str | None:
    """The message for a text in the form of STEP whose schema is IFC; None for any other."""
    found = _IFC.search(text)
    if found is None:
        return None
    return f"it is IFC ({found[1].decode('ascii', 'replace')}), which feeler does not read; {_ENDINGS['.ifc'][1]}"


def unread(path: Path, head: bytes, text: bytes) -> str | None:
    """The kind of a file that feeler does not read, with advice; None if it is not recognised."""
    if schema := ifc_schema(text):
        return schema
    if b"<robot" in text:
        return (
            "it is URDF, a robot with joints; load it with feeler.from_urdf(path, joints), "
            "or feeler.Mechanism.from_urdf(path) to move it"
        )
    start = next(((name, advice) for magic, name, advice in _STARTS if head.startswith(magic)), None)
    start = start or (_in_archive(path) if head.startswith(b"PK\x03\x04") else None)
    if start is None and not without_comments(text).startswith(b"ISO-10303-21"):
        start = _ENDINGS.get(path.suffix.lower())
    return f"it is {start[0]}, which feeler does not read; {start[1]}" if start else None


def _in_archive(path: Path) -> tuple[str, str] | None:
    try:
        with zipfile.ZipFile(path) as archive:
            # With a slash in front, so that an ending may ask for a whole name at the top.
            names = ["/" + name.lower() for name in archive.namelist()[:_MOST_NAMES]]
    except (zipfile.BadZipFile, OSError, ValueError, NotImplementedError):
        return None
    if any(name.endswith((".model", ".dae")) for name in names):
        return None
    for ending, kind, advice in _INSIDE:
        if any(name == ending if ending.startswith("/") else name.endswith(ending) for name in names):
            return kind, advice
    packed = next((name for name in names if name.endswith(_PACKED_HERE)), None)
    return None if packed is None else ("a ZIP archive", f"unpack it, and load {clean_name(packed[1:], 'the file')!r}")
