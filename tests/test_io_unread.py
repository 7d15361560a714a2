"""Files that feeler does not read are called by their names, with what to export instead."""

from __future__ import annotations

import zipfile
from pathlib import Path

import pytest

import feeler

IFC = b"ISO-10303-21;\nHEADER;\nFILE_DESCRIPTION((''),'2;1');\nFILE_SCHEMA(('IFC4X3'));\nENDSEC;\n"
IFC_END = b"DATA;\n#1=IFCPROJECT('a');\nENDSEC;\nEND-ISO-10303-21;\n"


@pytest.mark.parametrize(
    ("name", "content", "said"),
    [
        ("wall.ifc", IFC, r"it is IFC \(IFC4X3\).*IfcConvert"),
        ("wall.stp", IFC, r"it is IFC \(IFC4X3\)"),
        ("long.stp", IFC.replace(b"(''),", b"('" + b"x" * 6000 + b"'),") + IFC_END, r"it is IFC \(IFC4X3\)"),
        ("old.ifc", b"nothing that tells", r"it is IFC, which"),
        ("wall.ifcxml", b"<?xml version='1.0'?>\n<ifcXML/>", r"it is IFC, which"),
        ("part.CATPart", b"V5_CFV2\0\0\0", r"it is CATIA V5, which feeler does not read; export STEP"),
        ("part.stp", b"V5_CFV2\0\0\0", r"it is CATIA V5"),
        ("part.sldprt", b"\xd0\xcf\x11\xe0\xa1\xb1\x1a\xe1\0", r"SolidWorks"),
        ("part.x_t", b"**ABCDEFGHIJKLMNOPQRSTUVWXYZ****", r"Parasolid"),
        ("part.jt", b"Version 9.5 JT  DM 6.4", r"it is JT"),
        ("a.usda", b"#usda 1.0\n", r"it is USD,.*glTF"),
        ("a.fbx", b"Kaydara FBX Binary  \0", r"it is FBX,.*glTF"),
        ("a.igs", b" " * 72 + b"S      1\n", r"it is IGES,.*STEP"),
        ("arm.urdf", b"<?xml version='1.0'?>\n<robot name='arm'></robot>", r"it is URDF.*feeler\.from_urdf"),
        ("notes.txt", b"dear all", r"neither the extension nor the content"),
    ],
)
def test_a_file_is_called_by_its_name(name: str, content: bytes, said: str, tmp_path: Path) -> None:
    path = tmp_path / name
    path.write_bytes(content)
    with pytest.raises(feeler.LoadError, match=said):
        feeler.load_mockup(path)


@pytest.mark.parametrize(
    ("name", "inside", "said"),
    [
        ("a.usdz", "scene.usdc", r"it is USDZ, which feeler does not read; export glTF or STEP"),
        ("a.zip", "scene.usdc", r"it is USDZ"),
        ("a.3dxml", "PRODUCT.3dxml", r"it is 3DXML"),
        ("a.FCStd", "GuiDocument.xml", r"it is FreeCAD"),
        ("a.3mf", "readme.txt", r"no 3D model"),
        ("a.3mf", "word/document.xml", r"no 3D model"),
        ("a.FCStd.zip", "Document.xml", r"it is FreeCAD"),
        ("wall.zip", "wall.ifc", r"it is IFC in an archive.*unpack it"),
        ("part.stpz", "Part.stp", r"it is a ZIP archive, which feeler does not read; unpack it, and load 'part\.stp'"),
        ("part.step", "sub/part.step", r"unpack it, and load 'sub/part\.step'"),
    ],
)
def test_an_archive_is_called_by_what_is_in_it(name: str, inside: str, said: str, tmp_path: Path) -> None:
    path = tmp_path / name
    with zipfile.ZipFile(path, "w") as archive:
        archive.writestr(inside, "x")
    with pytest.raises(feeler.LoadError, match=said):
        feeler.load_mockup(path)
