"""Loading bad files: each gets a typed error that says what and where, or loads with its defects counted.

Nothing may crash, hang, run out of memory, or raise anything but a `FeelerError`.
"""

from __future__ import annotations

import bz2
import gzip
import importlib.util
import lzma
import os
import struct
import subprocess
import sys
import tracemalloc
import zipfile
from pathlib import Path

import numpy as np
import pytest
from test_io_builders import (
    CORE,
    SOUP,
    Gltf,
    obj_text,
    off_text,
    ply,
    stl_binary,
    stl_text,
    threemf,
    threemf_components,
    threemf_mesh,
    zipped,
)

from feeler import FeelerError, LimitError, LoadError, MeshError, MissingFileError, OptionError
from feeler.io import load, load_mockup, load_tool, step

needs_step = pytest.mark.skipif(importlib.util.find_spec("cascadio") is None, reason="cascadio is not installed")
STEP_TEXT = (Path(__file__).parent.parent / "testdata" / "meshes" / "assembly.step").read_bytes()


def save(folder: Path, name: str, content: bytes | str) -> Path:
    path = folder / name
    path.write_bytes(content.encode() if isinstance(content, str) else content)
    return path


def refuse(path: Path, *words: str, error: type[FeelerError] = LoadError) -> None:
    """Check that the file is refused with an error that names it and says these words."""
    with pytest.raises(error) as caught:
        load_mockup(path)
    message = str(caught.value)
    assert path.name in message
    # The folder has the test's name in its own, and would say the words for the message.
    said = message.replace(str(path), "")
    for word in words:
        assert word in said, message


def simple_glb() -> Gltf:
    g = Gltf()
    g.node(mesh=g.mesh(), name="part")
    return g


GOOD: dict[str, bytes] = {
    "binary.stl": stl_binary(),
    "text.stl": stl_text().encode(),
    "m.obj": obj_text().encode(),
    "m.off": off_text().encode(),
    "text.ply": ply("ascii"),
    "little.ply": ply("binary_little_endian"),
    "mixed.ply": ply("binary_big_endian", [[0, 1, 2, 3], [0, 1, 2]]),
    "m.glb": simple_glb().glb(),
    "m.3mf": threemf(threemf_mesh(1) + threemf_components(2, "c", [(1, "")]), '<item objectid="2"/>'),
}


# --- paths -------------------------------------------------------------------------------------------------------


def test_missing_file(tmp_path):
    refuse(tmp_path / "no.stl", "no such file", error=MissingFileError)
    with pytest.raises(FileNotFoundError):
        load_tool(tmp_path / "no.stl")
    refuse(save(tmp_path, "a.stl", stl_binary()) / "below.stl", "no such file", error=MissingFileError)


def test_missing_file_in_a_list(tmp_path):
    with pytest.raises(MissingFileError, match=r"no\.stl"):
        load_mockup([save(tmp_path, "a.stl", stl_binary()), tmp_path / "no.stl"])


def test_folder_without_meshes(tmp_path):
    save(tmp_path, "readme.txt", "hello")
    refuse(tmp_path, "no mesh file", ".stl", error=MissingFileError)


def test_no_file_at_all():
    with pytest.raises(MissingFileError, match="no file was given"):
        load_mockup([])


@pytest.mark.parametrize("path", [None, 5, b"a.stl", "", "a\0.stl", ["a.stl", 5], [b"x"]])
def test_not_a_path(path):
    with pytest.raises(OptionError):
        load_mockup(path)


def test_name_too_long(tmp_path):
    with pytest.raises(LoadError):
        load_mockup(tmp_path / ("x" * 5000 + ".stl"))


@pytest.mark.parametrize(
    "name", ["a.stl", "a.obj", "a.ply", "a.off", "a.glb", "a.gltf", "a.3mf", "a.step", "a.dae", "a"]
)
def test_empty_file(tmp_path, name):
    refuse(save(tmp_path, name, b""), "empty")


@pytest.mark.skipif(not hasattr(os, "mkfifo"), reason="no pipes here")
def test_pipe_does_not_hang(tmp_path):
    os.mkfifo(tmp_path / "a.stl")
    refuse(tmp_path / "a.stl", "not a regular file")
    with pytest.raises(LoadError):
        load_mockup("/dev/zero")


def test_links_that_lead_nowhere(tmp_path):
    (tmp_path / "a.stl").symlink_to(tmp_path / "gone.stl")
    refuse(tmp_path / "a.stl", error=MissingFileError)
    (tmp_path / "loop").symlink_to(tmp_path)
    save(tmp_path, "b.stl", stl_binary())
    (tmp_path / "a.stl").unlink()
    assert load_mockup(tmp_path).triangle_count == 4  # the loop is not followed
    (tmp_path / "c.stl").symlink_to(tmp_path / "c.stl")
    with pytest.raises(LoadError):
        load_mockup(tmp_path / "c.stl")


@pytest.mark.skipif(not hasattr(os, "geteuid") or os.geteuid() == 0, reason="root may read anything")
def test_no_permission(tmp_path):
    path = save(tmp_path, "a.stl", stl_binary())
    path.chmod(0)
    refuse(path)


def test_unknown_kind_of_file(tmp_path):
    refuse(save(tmp_path, "a.xyz", b"1 2 3\n"), "neither the extension nor the content", ".step")
    with pytest.raises(LoadError, match="neither the extension"):
        load_mockup([save(tmp_path, "a.stl", stl_binary()), save(tmp_path, "notes.txt", b"hello")])


@pytest.mark.parametrize("pack", [gzip.compress, lzma.compress, bz2.compress, lambda d: b"\x28\xb5\x2f\xfd" + d])
def test_compressed_files(tmp_path, pack):
    refuse(save(tmp_path, "a.stl", pack(stl_binary())), "compressed", "unpack")


def test_a_progress_callable_that_raises_is_heard(tmp_path):
    class StopError(OSError):
        pass

    def stop(fraction: float, stage: str) -> None:
        raise StopError

    for name, content in GOOD.items():
        with pytest.raises(StopError):
            load_mockup(save(tmp_path, name, content), progress=stop)


# --- no triangles -------------------------------------------------------------------------------------------------


@pytest.mark.parametrize(
    ("name", "content"),
    [
        ("a.stl", stl_binary(SOUP[:0])),
        ("a.stl", "solid Empty\nendsolid Empty"),
        ("a.obj", "# nothing\n"),
        ("a.obj", "v 0 0 0\nv 1 0 0\nl 1 2\n"),
        ("a.off", "OFF\n0 0 0\n"),
        ("a.off", "OFF\n3 0 0\n0 0 0\n1 0 0\n0 1 0\n"),
        ("a.ply", "ply\nformat ascii 1.0\nelement vertex 0\nproperty float x\nelement face 0\nend_header\n"),
        ("a.ply", "ply\nformat ascii 1.0\nend_header\n"),
        ("a.gltf", '{"asset": {"version": "2.0"}}'),
        ("a.gltf", '{"asset": {"version": "2.0"}, "nodes": [{"name": "x"}], "scenes": [{"nodes": [0]}]}'),
    ],
)
def test_no_triangle(tmp_path, name, content):
    refuse(save(tmp_path, name, content), "no triangle")


def test_several_files_without_a_triangle(tmp_path):
    for name in ("a.stl", "b.stl"):
        save(tmp_path, name, stl_binary(SOUP[:0]))
    with pytest.raises(LoadError, match="none holds a triangle"):
        load_mockup(tmp_path)


def test_only_triangles_that_cannot_be_queried(tmp_path):
    path = save(tmp_path, "a.stl", stl_binary(np.zeros((2, 3, 3))))
    refuse(path, error=MeshError)
    with pytest.raises(MeshError, match=r"a\.stl"):
        load_tool(path)


# --- truncated, damaged, garbage ------------------------------------------------------------------------------------


@pytest.mark.parametrize("name", GOOD)
def test_truncated_anywhere(tmp_path, name):
    content = GOOD[name]
    for length in sorted({*range(1, len(content), max(1, len(content) // 60)), len(content) - 1}):
        path = save(tmp_path, name, content[:length])
        try:
            mockup = load_mockup(path)
        except FeelerError as error:
            assert name in str(error)
        else:
            # Only text can lose its tail without a trace, and binary padding at the end.
            assert name in ("m.obj", "m.off", "text.ply", "text.stl", "m.glb")
            assert mockup.triangle_count <= 5


@pytest.mark.parametrize(
    ("name", "length", "words"),
    [
        ("binary.stl", 150, ("promises 4 triangles", "truncated")),
        ("text.stl", 300, ("line", "truncated")),
        ("m.off", 70, ("promises 4 vertices and 4 polygons",)),
        ("text.ply", 290, ()),
        ("little.ply", 300, ("truncated",)),
        ("m.glb", 500, ("promises", "truncated")),
        ("m.3mf", 300, ("damaged",)),
    ],
)
def test_truncated_says_so(tmp_path, name, length, words):
    refuse(save(tmp_path, name, GOOD[name][:length]), *words)


def test_text_stl_cut_between_two_triangles_is_noted(tmp_path):
    text = stl_text()
    mockup = load_mockup(save(tmp_path, "a.stl", text[: text.index("endsolid")]))
    assert mockup.triangle_count == 4
    assert any("no 'endsolid'" in note and "truncated" in note for note in mockup.report.source.notes)
    refuse(save(tmp_path, "b.stl", text[: text.index("endsolid") + 4]), "endsolid", "truncated")
    refuse(save(tmp_path, "c.stl", text[: text.rindex("endfacet")]), "endsolid", "truncated")


@pytest.mark.parametrize("name", GOOD)
def test_flipped_bytes(tmp_path, name, rng):
    for _ in range(150):
        content = bytearray(GOOD[name])
        for _ in range(rng.integers(1, 4)):
            content[rng.integers(len(content))] = rng.integers(256)
        path = save(tmp_path, name, bytes(content))
        try:
            load_mockup(path)
        except FeelerError as error:
            assert name in str(error)


@pytest.mark.parametrize(
    "name", ["a.stl", "a.obj", "a.ply", "a.off", "a.glb", "a.gltf", "a.3mf", "a.step", "a.stp", "a.dae"]
)
def test_binary_garbage(tmp_path, name, rng):
    for size in (1, 10, 83, 84, 1000, 50_000):
        refuse(save(tmp_path, name, rng.integers(0, 256, size, dtype=np.uint8).tobytes()))


@pytest.mark.parametrize(
    "magic", [b"glTF", b"ply\n", b"OFF\n", b"PK\x03\x04", b"solid x\nfacet normal", b'{"', b"v 0 0 0\nf"]
)
def test_garbage_behind_good_magic(tmp_path, magic, rng):
    for size in (0, 3, 100, 5000):
        refuse(save(tmp_path, "a.obj", magic + rng.integers(0, 256, size, dtype=np.uint8).tobytes()))


def test_line_of_a_wrong_number_is_named(tmp_path):
    refuse(save(tmp_path, "a.obj", "v 0 0 0\nv 1 0 0\nv 0 1,5 0\nf 1 2 3\n"), "line 3", "1,5")
    refuse(save(tmp_path, "a.obj", "v 0 0 0\nv 1 0\n"), "line 2", "three numbers")
    refuse(save(tmp_path, "a.obj", "v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 c\n"), "line 4", "'c'")
    refuse(save(tmp_path, "a.obj", "v 0 0 0\nv 1.0.5 0 0\nv 0 1 0\nf 1 2 3\n"), "line 2", "1.0.5")
    refuse(save(tmp_path, "a.stl", stl_text().replace("30.0", "30.0x", 1)), "line", "30.0x")
    refuse(
        save(tmp_path, "a.stl", stl_text().replace("endfacet", "endfaucet", 1).replace("outer", "vertex 1 1 1 #", 1)),
        "line 3",
    )
    refuse(save(tmp_path, "a.off", off_text().replace("20.0", "twenty", 1)), "line 7", "twenty")
    refuse(save(tmp_path, "a.ply", ply("ascii").replace(b"20.0", b"twenty", 1)), "line 15", "twenty")


def test_one_very_long_line(tmp_path):
    refuse(save(tmp_path, "a.obj", b"v " + b"1 " * 3_000_000))
    refuse(save(tmp_path, "a.stl", b"solid " + b"facet normal " * 500_000))


# --- headers that promise too much ----------------------------------------------------------------------------------


def huge_ply(encoding: str, count: int) -> str:
    return (
        f"ply\nformat {encoding} 1.0\nelement vertex {count}\nproperty float x\nproperty float y\nproperty float z\n"
        "element face 1\nproperty list uchar int vertex_indices\nend_header\n0 0 0\n1 0 0\n0 1 0\n3 0 1 2\n"
    )


@pytest.mark.parametrize(
    ("name", "content"),
    [
        ("a.off", "OFF\n353535235358 6 0\n0 0 0\n"),
        ("a.off", "OFF\n3 353535235358 0\n0 0 0\n1 0 0\n0 1 0\n3 0 1 2\n"),
        ("a.off", "OFF\n-3 1 0\n0 0 0\n"),
        ("a.ply", huge_ply("ascii", 353_535_235_358)),
        ("a.ply", huge_ply("binary_little_endian", 353_535_235_358)),
        ("a.ply", huge_ply("ascii", 10**30)),
        ("a.ply", huge_ply("ascii", -5)),
        ("a.stl", b"\0" * 80 + b"\xfe\xff\xff\xff" + b"\0" * 500),
    ],
)
def test_counts_are_checked_before_memory_is_taken(tmp_path, name, content):
    path = save(tmp_path, name, content)
    tracemalloc.start()
    refuse(path)
    peak = tracemalloc.get_traced_memory()[1]
    tracemalloc.stop()
    assert peak < 20 * 2**20


def test_ply_list_that_promises_too_much(tmp_path):
    head = b"ply\nformat binary_little_endian 1.0\nelement vertex 3\n"
    head += b"property float x\nproperty float y\nproperty float z\n"
    head += b"element face 1\nproperty list uint int vertex_indices\nend_header\n"
    refuse(save(tmp_path, "a.ply", head + b"\0" * 36 + struct.pack("<I3i", 2**32 - 1, 0, 1, 2)), "face")
    refuse(
        save(tmp_path, "b.ply", head.replace(b"list uint", b"list int") + b"\0" * 36 + struct.pack("<i3i", -3, 0, 1, 2))
    )


def test_ply_with_a_billion_empty_rows(tmp_path):
    body = ply("ascii").replace(b"element face", b"element nothing 999999999999\nelement face")
    assert load_mockup(save(tmp_path, "a.ply", body)).triangle_count == 4


@pytest.mark.parametrize(
    "header",
    ["ply\n", "ply\nend_header\n", "ply\nformat ascii 1.0\nelement vertex\nend_header\n",
     "ply\nformat ascii 1.0\nproperty float x\nend_header\n", "ply\nformat morse 1.0\nend_header\n",
     "ply\nformat ascii 1.0\nelement vertex 1\nproperty quark x\nend_header\n1\n",
     "ply\nformat ascii 1.0\nelement vertex 1\nproperty float x\nend_header\n1\n",
     "ply\nformat ascii 1.0\nelement face 1\nproperty float x\nend_header\n1\n"],
)  # fmt: skip
def test_bad_ply_header(tmp_path, header):
    refuse(save(tmp_path, "a.ply", header))


def test_off_variants_that_are_not_read(tmp_path):
    refuse(save(tmp_path, "a.off", "OFF BINARY\n1 1 1\n"), "binary OFF")
    refuse(save(tmp_path, "a.off", "4OFF\n1 1 1\n"), "dimensions")
    refuse(save(tmp_path, "a.off", "OFF\n"), "missing")
    refuse(save(tmp_path, "a.off", "OFF\n3 1 0\n0 0 0\n1 0 0\n0 1 0\n9 0 1 2\n"), "line 6", "9 corners")


# --- glTF --------------------------------------------------------------------------------------------------------


def test_gltf_cycle(tmp_path):
    g = simple_glb()
    g.node(name="a", children=[2])
    g.node(is_root=False, name="b", children=[1])
    refuse(save(tmp_path, "a.glb", g.glb()), "cycle")
    g.root["nodes"][2]["children"] = [2]
    refuse(save(tmp_path, "a.glb", g.glb()), "cycle")
    del g.root["scenes"], g.root["nodes"][0]
    g.root["nodes"] = [{"children": [1]}, {"children": [0]}]
    refuse(save(tmp_path, "a.glb", g.glb()), "cycle")


def test_gltf_node_with_two_parents(tmp_path):
    """A doubling at each of 40 levels would be a million million parts."""
    g = simple_glb()
    g.root["nodes"] = [{"children": [i + 1, i + 1]} for i in range(40)] + [{"mesh": 0}]
    refuse(save(tmp_path, "a.glb", g.glb()), "reached twice")


def test_gltf_deep_chain(tmp_path):
    g = simple_glb()
    g.root["nodes"] = [{"children": [i + 1], "name": "n" * 50} for i in range(100_000)] + [{"mesh": 0}]
    refuse(save(tmp_path, "a.glb", g.glb()), "levels deep")


def test_gltf_many_instances_of_much(tmp_path):
    """Small file, astronomic mock-up: counted before it is made."""
    g = Gltf()
    mesh = g.mesh(np.zeros((200_000, 3)), np.arange(200_001) % 200_000)
    g.root["nodes"] = [{"mesh": mesh}] * 50_000
    g.root["scenes"][0]["nodes"] = list(range(50_000))
    refuse(save(tmp_path, "a.glb", g.glb()), error=LimitError)


def test_gltf_sparse_accessor_without_data_that_promises_much(tmp_path):
    g = simple_glb()
    tail = {"count": 1, "indices": {"bufferView": 1, "componentType": 5125}, "values": {"bufferView": 0}}
    g.root["accessors"][0] = {"componentType": 5126, "type": "VEC3", "count": 10**12, "sparse": tail}
    g.root["accessors"][1]["count"] = 10**13
    with pytest.raises((LoadError, LimitError)):
        load_mockup(save(tmp_path, "a.glb", g.glb()))


@pytest.mark.parametrize(
    ("where", "change", "words"),
    [
        (("accessors", 0), {"count": 5}, ("accessors[0]", "buffer view")),
        (("accessors", 0), {"count": -1}, ("count",)),
        (("accessors", 0), {"count": 4.5}, ("count",)),
        (("accessors", 0), {"count": True}, ("count",)),
        (("accessors", 0), {"byteOffset": -4}, ("byteOffset",)),
        (("accessors", 0), {"byteOffset": 10**20}, ("buffer view",)),
        (("accessors", 0), {"type": "MAT4"}, ("type",)),
        (("accessors", 0), {"componentType": 9}, ("componentType",)),
        (("accessors", 0), {"bufferView": 99}, ("bufferViews[99]",)),
        (("accessors", 0), {"bufferView": -1}, ("bufferViews[-1]",)),
        (("accessors", 1), {"componentType": 5126}, ()),
        (("accessors", 1), {"count": 10**15}, ()),
        (("bufferViews", 0), {"byteLength": 10**12}, ("bufferViews[0]",)),
        (("bufferViews", 0), {"byteOffset": 10**12}, ("bufferViews[0]",)),
        (("bufferViews", 0), {"byteStride": 4}, ("stride",)),
        (("bufferViews", 0), {"byteStride": 10**9}, ()),
        (("bufferViews", 0), {"buffer": 7}, ("buffers[7]",)),
        (("buffers", 0), {"byteLength": 10**12}, ("truncated",)),
        (("buffers", 0), {"byteLength": "x"}, ()),
        (("meshes", 0), {"primitives": [5]}, ()),
        (("meshes", 0), {"primitives": [{"attributes": {}}]}, ()),
        (("nodes", 0), {"mesh": 17}, ("meshes[17]",)),
        (("nodes", 0), {"mesh": -1}, ("meshes[-1]",)),
        (("nodes", 0), {"mesh": "0"}, ()),
        (("nodes", 0), {"children": [55]}, ("nodes[55]",)),
        (("nodes", 0), {"children": [[]]}, ()),
        (("nodes", 0), {"matrix": [1, 2, 3]}, ("16 numbers",)),
        (("nodes", 0), {"matrix": [1] * 16}, ("affine",)),
        (("nodes", 0), {"rotation": ["a"] * 4}, ("4 numbers",)),
        (("nodes", 0), {"translation": [10**400, 0, 0]}, ()),
        (("scenes", 0), {"nodes": [12]}, ("nodes[12]",)),
        (("scenes", 0), {"nodes": ["x"]}, ()),
        (("asset",), {"version": "1.0"}, ("glTF 2",)),
        (("asset",), {"minVersion": "2.1"}, ("a reader of glTF 2.1",)),
        ((), {"extensionsRequired": ["ACME_warp"]}, ("ACME_warp",)),
        ((), {"nodes": {"a": 1}}, ()),
        ((), {"nodes": [5], "scenes": []}, ()),
        ((), {"scene": 4}, ("scenes[4]",)),
        ((), {"accessors": 5}, ()),
        ((), {"asset": None}, ("asset",)),
    ],
)
def test_damaged_gltf(tmp_path, where, change, words):
    g = simple_glb()
    target = g.root
    for key in where:
        target = target[key]
    target.update(change)
    refuse(save(tmp_path, "a.glb", g.glb()), *words)


@pytest.mark.parametrize(
    ("text", "line"), [("OFF\n4 x 0\n0 0 0\n1 0 0\n", 2), ("OFF\n\nx 4 0\n0 0 0\n", 3), ("OFF\n4\n", 2)]
)
def test_counts_of_off_that_are_missing(tmp_path, text, line):
    refuse(save(tmp_path, "a.off", text), f"line {line}: the numbers of vertices and polygons")


def test_gltf_geometry_packed_without_a_fallback(tmp_path):
    g = simple_glb()
    g.root["meshes"][0]["primitives"][0]["extensions"] = {"KHR_draco_mesh_compression": {"bufferView": 0}}
    assert load_mockup(save(tmp_path, "a.glb", g.glb())).triangle_count == 4  # the plain copy is there
    del g.root["accessors"][0]["bufferView"]
    refuse(save(tmp_path, "a.glb", g.glb()), "Draco")
    g = simple_glb()
    g.root["bufferViews"][0]["extensions"] = {"EXT_meshopt_compression": {}}
    assert load_mockup(save(tmp_path, "a.glb", g.glb())).triangle_count == 4
    g.root["extensionsRequired"] = ["EXT_meshopt_compression"]
    refuse(save(tmp_path, "a.glb", g.glb()), "meshopt")


@pytest.mark.parametrize(
    "uri",
    ["http://example.com/a.bin", "https://example.com/a.bin", "file:///etc/passwd",
     "//server/share/a.bin", "/etc/passwd",
     "../secret.bin", "..%2Fsecret.bin", "sub/../../secret.bin", "C:\\a.bin", "\\\\server\\a.bin", "link/secret.bin",
     "a%00.bin", ".", "", 5, "missing.bin", "data:application/octet-stream;base64,%%%", "data:text/plain,hello",
     "data:application/octet-stream;base64,AAAA"],
)  # fmt: skip
def test_gltf_buffers_elsewhere_are_refused(tmp_path, uri):
    g = simple_glb()
    folder = tmp_path / "inner"
    folder.mkdir()
    save(tmp_path, "secret.bin", g.blob)
    (folder / "link").symlink_to(tmp_path)
    refuse(save(folder, "a.gltf", g.gltf(uri)), "buffer")


def test_gltf_buffer_file_too_short(tmp_path):
    g = simple_glb()
    save(tmp_path, "a.bin", g.blob[:-10])
    refuse(save(tmp_path, "a.gltf", g.gltf("a.bin")), "truncated")


@pytest.mark.parametrize(
    "text",
    [
        "{" + '"a":[' * 200_000,
        "[" * 100_000,
        '{"asset": {"version": "2.0"}, "nodes": ' + "[" * 100_000,
        '{"asset": {"version": "2.0"}, "nodes": [' + "9" * 10_000 + "]}",
        '{"asset": {"version": "2.0"}, "x": "\udcff"}',
        '{"a" 5}',
        "{}",
        "[]",
    ],
)
def test_json_bombs_and_damage(tmp_path, text):
    refuse(save(tmp_path, "a.gltf", text.encode("utf-8", "surrogateescape")))


def test_glb_containers(tmp_path):
    good = simple_glb().glb()
    refuse(save(tmp_path, "a.glb", b"glTF"), "truncated")
    refuse(save(tmp_path, "a.glb", b"glTF" + struct.pack("<I", 1) + good[8:]), "version 1")
    refuse(save(tmp_path, "a.glb", good[:8] + struct.pack("<I", 2**32 - 1) + good[12:]), "truncated")
    refuse(save(tmp_path, "a.glb", good[:12] + struct.pack("<I", 2**32 - 1) + good[16:]), "chunk")
    refuse(save(tmp_path, "a.glb", good[:16] + b"ABCD" + good[20:]), "JSON chunk")
    assert load_mockup(save(tmp_path, "a.glb", good + bytes(9))).report.source.doubts == ()
    (said,) = load_mockup(save(tmp_path, "a.glb", good + good)).report.source.doubts
    assert f"{len(good):,} bytes follow the end that the GLB states" in said


def test_gltf_transform_that_is_not_finite_keeps_its_triangles(tmp_path):
    g = simple_glb()
    g.node(mesh=0, name="far", translation=[float("inf"), 0, 0])
    mockup = load_mockup(save(tmp_path, "a.glb", g.glb()))
    assert mockup.triangle_count == 8 and mockup.report.defects["non_finite"].count == 4


# --- 3MF ---------------------------------------------------------------------------------------------------------

ITEM = '<item objectid="1"/>'


@pytest.mark.parametrize(
    ("resources", "items", "words"),
    [
        (threemf_mesh(1), "", ("no item",)),
        (threemf_mesh(1), '<item objectid="9"/>', ("not defined",)),
        (threemf_mesh(1), "<item/>", ("objectid", "missing")),
        (threemf_mesh(1) * 2, ITEM, ("twice",)),
        (threemf_mesh(1).replace('v1="0"', 'v1="a"'), ITEM, ("not a number",)),
        (threemf_mesh(1).replace('v1="0"', 'v1="9999999999999999999999"'), ITEM, ("number",)),
        (threemf_mesh(1).replace('x="10.0"', 'x="ten"'), ITEM, ("'ten' as a coordinate", "not a number")),
        (threemf_mesh(1).replace('x="10.0"', 'x="10,0"'), ITEM, ("'10,0' as a coordinate", "decimal points")),
        (threemf_mesh(1).replace('x="10.0"', ""), ITEM, ("'x'", "missing")),
        (threemf_mesh(1), '<item objectid="1" transform="1 2 3"/>', ("twelve numbers",)),
        (threemf_components(1, "a", [(1, "")]), ITEM, ("cycle",)),
        (threemf_components(1, "a", [(2, "")]) + threemf_components(2, "b", [(1, "")]), ITEM, ("cycle",)),
        (threemf_mesh(1), ITEM + "<oops>", ("damaged",)),
        ("<object id='1'><mesh><vertices/><triangles/></mesh></object>", ITEM, ("no triangle",)),
    ],
)
def test_damaged_3mf(tmp_path, resources, items, words):
    refuse(save(tmp_path, "a.3mf", threemf(resources, items)), *words)


def test_3mf_doubling_at_every_level(tmp_path):
    levels = "".join(threemf_components(i, "x", [(i - 1, ""), (i - 1, "")]) for i in range(2, 60))
    refuse(save(tmp_path, "a.3mf", threemf(threemf_mesh(1) + levels, '<item objectid="59"/>')), error=LimitError)


def test_3mf_deep_chain(tmp_path):
    levels = "".join(threemf_components(i, "x", [(i - 1, "")]) for i in range(2, 5000))
    refuse(save(tmp_path, "a.3mf", threemf(threemf_mesh(1) + levels, '<item objectid="4999"/>')), "levels deep")


def test_3mf_unknown_unit(tmp_path):
    refuse(save(tmp_path, "a.3mf", threemf(threemf_mesh(1), ITEM, unit="furlong")), "furlong")


def test_3mf_index_out_of_range_is_kept(tmp_path):
    content = threemf(threemf_mesh(1).replace('v1="0"', 'v1="-1"', 1) + threemf_mesh(2), ITEM + '<item objectid="2"/>')
    mockup = load_mockup(save(tmp_path, "a.3mf", content))
    assert mockup.triangle_count == 8 and mockup.report.defects["index_out_of_range"].first == (0,)


def test_zip_that_is_no_3mf(tmp_path):
    refuse(save(tmp_path, "a.3mf", zipped({"hello.txt": b"hello"})), "not a 3MF file")
    refuse(save(tmp_path, "a.stl", zipped({"part.stl": stl_binary()})), "ZIP archive")


def test_zip_bomb_is_not_opened(tmp_path):
    bomb = zipped({"3D/3dmodel.model": b" " * (80 * 2**20)})
    tracemalloc.start()
    refuse(save(tmp_path, "a.3mf", bomb), "zip bomb")
    assert tracemalloc.get_traced_memory()[1] < 20 * 2**20
    tracemalloc.stop()
    model = f"<model {CORE}/>".encode()
    refuse(save(tmp_path, "b.3mf", zipped({"_rels/.rels": b" " * (80 * 2**20), "3D/3dmodel.model": model})), "zip bomb")


def test_zip_that_lies_about_its_size(tmp_path):
    content = bytearray(zipped({"3D/3dmodel.model": b" " * 10_000_000}))
    directory = content.rindex(b"PK\x01\x02")
    content[directory + 24 : directory + 28] = struct.pack("<I", 100)
    refuse(save(tmp_path, "a.3mf", bytes(content)))


def test_entity_bomb(tmp_path):
    bomb = '<!DOCTYPE m [<!ENTITY a "aaaaaaaaaa"><!ENTITY b "&a;&a;&a;&a;&a;"><!ENTITY c "&b;&b;&b;&b;">]>'
    refuse(save(tmp_path, "a.3mf", threemf(threemf_mesh(1, "&c;"), ITEM, prolog=bomb)), "document type")


def test_encrypted_zip(tmp_path):
    content = bytearray(threemf(threemf_mesh(1), ITEM))
    directory = content.rindex(b"PK\x01\x02")
    content[6] |= 1
    content[directory + 8] |= 1
    refuse(save(tmp_path, "a.3mf", bytes(content)), "encrypted")
    assert zipfile.is_zipfile(tmp_path / "a.3mf")


# --- STEP and COLLADA ---------------------------------------------------------------------------------------------


@pytest.mark.parametrize(
    ("content", "words"),
    [
        (b"this is no STEP file", ("ISO-10303-21",)),
        (STEP_TEXT[:5000], ("truncated",)),
        (STEP_TEXT.replace(b"\nDATA;", b"\n"), ("DATA",)),
    ],
)
def test_step_files_that_never_reach_the_converter(tmp_path, monkeypatch, content, words):
    monkeypatch.setattr(step, "_WORKER", tmp_path / "must not run.py")
    refuse(save(tmp_path, "a.step", content), *words)


@needs_step
@pytest.mark.parametrize(
    "content",
    [
        b"ISO-10303-21;\nHEADER;\nENDSEC;\nDATA;\nENDSEC;\nEND-ISO-10303-21;\n",
        b"ISO-10303-21;\nDATA;\n" + bytes(range(256)) * 20 + b"\nEND-ISO-10303-21;\n",
        STEP_TEXT.replace(b"MANIFOLD_SOLID_BREP", b"SOMETHING_ELSE"),
    ],
)
def test_step_files_that_the_converter_gets_nothing_from(tmp_path, content):
    refuse(save(tmp_path, "a.step", content), "OpenCASCADE")


@needs_step
@pytest.mark.parametrize(
    ("old", "new", "words"),
    [
        (b"= PLANE(", b"= PLAIN(", ("1 of the 9 faces",)),
        (
            b"CYLINDRICAL_SURFACE('',#",
            b"CYLINDRICAL_SURFACE('',#77",
            ("1 of the 9 faces", "OpenCASCADE said", "Unresolved"),
        ),
    ],
)
def test_step_faces_that_the_converter_leaves_out_are_noted(tmp_path, old, new, words):
    mockup = load_mockup(save(tmp_path, "a.step", STEP_TEXT.replace(old, new, 1)))
    for word in words:
        assert any(word in note for note in mockup.report.source.notes)


@pytest.mark.parametrize(
    ("worker", "words"),
    [
        ("import os; os.abort()", ("crashed",)),
        ("import ctypes; ctypes.string_at(0)", ("crashed",)),
        ("import sys; print('bad entity #5', file=sys.stderr); sys.exit(1)", ("failed (status 1)", "bad entity #5")),
        ("import sys; sys.exit(3)", ("pip install",)),
        ("import sys; open(sys.argv[2], 'wb').write(b'junk')", ("nothing usable",)),
        ("import sys; open(sys.argv[2], 'wb')", ("failed",)),
    ],
)
@pytest.mark.skipif(sys.platform == "win32", reason="signals are named differently there")
def test_step_converter_that_misbehaves(tmp_path, monkeypatch, worker, words):
    monkeypatch.setattr(step, "_WORKER", save(tmp_path, "worker.py", worker))
    refuse(save(tmp_path, "a.step", STEP_TEXT), *words)


def test_errors_of_the_step_converter_are_words_without_its_places(tmp_path, monkeypatch, testdata):
    """OpenCASCADE throws for a tolerance that it does not take; its binding makes that a Python error."""
    pytest.importorskip("cascadio")
    monkeypatch.setattr(load, "FINEST_CHORD_TOLERANCE", 1e-15)
    with pytest.raises(LoadError, match="failed") as error:
        load_mockup(testdata / "meshes" / "assembly.step", chord_tolerance=1e-12)
    assert "invalid parameter value" in str(error.value)
    assert "File" not in str(error.value) and "Error" not in str(error.value)


def test_step_converter_that_does_not_end(tmp_path, monkeypatch):
    monkeypatch.setattr(step, "_WORKER", save(tmp_path, "worker.py", "import time; time.sleep(3600)"))
    monkeypatch.setattr(step, "_LEAST_SECONDS", 0.1)
    monkeypatch.setattr(step, "_SECONDS_PER_MB", 0.1)
    started = watch_workers(monkeypatch)
    refuse(save(tmp_path, "a.step", STEP_TEXT), "not done after", "chord_tolerance")
    assert started[0].poll() is not None, "it is stopped"


def watch_workers(monkeypatch) -> list[subprocess.Popen[bytes]]:
    """The converter's processes, as they are started."""
    started = []
    popen = step.subprocess.Popen
    monkeypatch.setattr(step.subprocess, "Popen", lambda *a, **k: started.append(popen(*a, **k)) or started[-1])
    return started


def test_step_worker_is_stopped_when_the_caller_stops(tmp_path, monkeypatch):
    monkeypatch.setattr(step, "_WORKER", save(tmp_path, "worker.py", "import time; time.sleep(3600)"))
    started = watch_workers(monkeypatch)

    def stop(fraction: float, stage: str) -> None:
        if "triangulating" in stage:
            raise KeyboardInterrupt

    with pytest.raises(KeyboardInterrupt):
        load_mockup(save(tmp_path, "a.step", STEP_TEXT), progress=stop)
    assert started[0].poll() is not None


@pytest.mark.parametrize(
    "content", [b"<COLLADA", b"<?xml version='1.0'?><COLLADA/>", b"<!DOCTYPE x><COLLADA></COLLADA>", b"<x/>"]
)
def test_damaged_collada(tmp_path, content):
    refuse(save(tmp_path, "a.dae", content))


# --- coordinates ---------------------------------------------------------------------------------------------------


@pytest.mark.parametrize("value", ["1e400", "-inf", "nan", "1e308", "1e-320"])
def test_extreme_coordinates_are_kept(tmp_path, value):
    text = f"v 0 0 0\nv 1 0 0\nv 0 1 0\nv {value} 1 1\nf 1 2 3\nf 1 2 4\n"
    mockup = load_mockup(save(tmp_path, "a.obj", text), unit="km")
    assert mockup.triangle_count == 2 and len(mockup.faces) == 2


def test_everything_again_from_a_folder_with_one_bad_file(tmp_path):
    for name, content in GOOD.items():
        save(tmp_path, name, content)
    good = load_mockup(tmp_path)
    assert good.triangle_count > 30
    save(tmp_path, "bad.ply", b"ply\n")
    mockup = load_mockup(tmp_path)
    assert np.array_equal(mockup.faces, good.faces) and mockup.part_paths == good.part_paths
    assert any("bad.ply: the PLY header has no 'end_header'" in note for note in mockup.report.source.notes)
    with pytest.raises(LoadError, match=r"bad\.ply"):
        load_mockup([tmp_path, tmp_path / "bad.ply"])


# --- real bad files, where there are some ----------------------------------------------------------------------------


@pytest.mark.parametrize(
    ("name", "words"),
    [
        ("assimp_OutOfMemory.off", ("353,535,235,358",)),
        ("assimp_invalid.off", ("line 7",)),
        ("trimesh_empty.obj", ("no triangle",)),
        ("trimesh_empty.ply", ("no triangle",)),
        ("trimesh_empty.stl", ("no triangle",)),
    ],
)
def test_real_bad_file(models, name, words):
    path = models / "degenerate" / name
    if not path.is_file():
        pytest.skip("not in this folder of models")
    refuse(path, *words)


@pytest.mark.parametrize(
    "data", [bytes(range(256)) * 4, b"glTE" + bytes(60), b"\xff\xfe\x00\x01", b"[1, 2]", b"text\n"]
)
def test_what_is_no_gltf_is_told_so(tmp_path: Path, data: bytes) -> None:
    """Not that it should be text: GLB is none."""
    refuse(save(tmp_path, "a.glb", data), "neither a GLB file nor the JSON of glTF; export the file again")
