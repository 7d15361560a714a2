"""The one HTML file with the mock-up inside: what is in it comes out again, and nothing else runs in it.

Run as a program, this writes the golden files; the page's own test reads them too.
"""

from __future__ import annotations

import base64
import gzip
import hashlib
import json
import re
import struct
from html.parser import HTMLParser
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from test_workbench_protocol import DOCUMENT, GOLDEN
from workbench_scene import Bench, stand

import feeler
from feeler.errors import WorkbenchError
from feeler.workbench import files as files_module
from feeler.workbench.engine.geometry import Geometry
from feeler.workbench.files import File
from feeler.workbench.session.page import GRID_BITS, container, packed_piece, page

CAMERA = {"position": (0.0, -2.0, 1.0), "target": (0.0, 0.0, 0.0), "up": (0.0, 0.0, 1.0), "fov_rad": 0.75}
SCRIPT = 'const a = "</script><!--";\r\nlet b = 1;'
FILES = {
    "/main.js": File("text/javascript", SCRIPT.encode()),
    "/style.css": File("text/css", b"body { color: red }"),
}


def quiet(_share: float, _stage: str) -> None:
    pass


def geometry(name: str = "stand", mockup: feeler.Mockup | None = None) -> Geometry:
    mockup = mockup or stand()
    return Geometry(feeler.Scene(mockup), "00ff", name)


def packed(made: Geometry, most_bytes: int = 10**9) -> tuple[bytes, int]:
    return container(DOCUMENT, CAMERA, made.manifest(), made.piece, quiet, most_bytes)  # type: ignore[arg-type]


def unpacked(data: bytes) -> tuple[dict[str, Any], list[tuple[np.ndarray, np.ndarray, np.ndarray]]]:
    """A second reader, as plain as can be."""
    version, size = struct.unpack_from("<II", data)
    assert (version, size % 8) == (1, 0)
    header = json.loads(data[8 : 8 + size])
    kind, (count,), offset = header["arrays"]["pieces"]
    assert (kind, offset) == ("u1", 0)
    at = 8 + size
    end = at + count
    assert end <= len(data) < end + 8

    def numbers(count: int, width: int) -> list[int]:
        nonlocal at
        planes = [data[at + k * count : at + (k + 1) * count] for k in range(width)]
        at += count * width
        return [sum(planes[k][i] << (8 * k) for k in range(width)) for i in range(count)]

    def sums(count: int, width: int) -> list[int]:
        value, found = 0, []
        for folded in numbers(count, width):
            value += -(folded + 1) // 2 if folded % 2 else folded // 2
            found.append(value)
        return found

    pieces = []
    for sizes in header["manifest"]["pieces"]:
        v, t = sizes["vertices"], sizes["triangles"]
        steps = np.array([sums(v, 3) for _ in range(3)]).T
        positions = np.array(header["grid"]["lower"]) + steps * header["grid"]["step"]
        parts = np.array(sums(v, 4))
        below = np.array([numbers(t, 2) for _ in range(3)]).T.ravel()
        corners, named = [], 0
        for each in below.tolist():
            corners.append(named - each)
            named = max(named, corners[-1] + 1)
        pieces.append((positions, parts, np.array(corners).reshape(-1, 3)))
    assert at == end
    return header, pieces


def test_all_triangles_come_back_within_half_a_step() -> None:
    made = geometry()
    data, left_out = packed(made)
    header, pieces = unpacked(data)
    assert left_out == header["left_out"] == 0
    assert header["document"] == json.loads(json.dumps({**DOCUMENT, "loading": None}))
    assert header["camera"]["fov_rad"] == 0.75
    assert header["manifest"] == json.loads(json.dumps(made.manifest()))
    mockup = stand()
    step = header["grid"]["step"]
    assert step == pytest.approx(1.0 / (2**GRID_BITS - 1))
    found = np.concatenate([positions[corners] for positions, _, corners in pieces]) + header["manifest"]["middle"]
    parts = np.concatenate([parts[corners[:, 0]] for _, parts, corners in pieces])
    order = mockup.pack(small=made._small).order
    np.testing.assert_allclose(found, mockup.vertices[mockup.faces[order]], atol=0.51 * step, rtol=0)
    np.testing.assert_array_equal(parts, mockup.part_of_face[order])


@given(st.data())
def test_any_piece_comes_back(data: st.DataObject) -> None:
    vertices = data.draw(st.integers(1, 40))
    triangles = data.draw(st.integers(1, 60))
    random = np.random.default_rng(data.draw(st.integers(0, 2**32)))
    indices = random.integers(0, vertices, (triangles, 3)).astype(np.uint16)
    steps = random.integers(0, 2**GRID_BITS, (vertices, 3))
    parts = random.integers(0, data.draw(st.sampled_from([1, 3, 65_536, 2**29])), vertices)
    positions = (steps * 0.5 - 3.0).astype(np.float32)
    block = packed_piece(positions, parts, indices, np.full(3, -3.0), 0.5)
    used = len(np.unique(indices))
    header = {
        "manifest": {"pieces": [{"vertices": used, "triangles": triangles}]},
        "grid": {"lower": [-3] * 3, "step": 0.5},
        "arrays": {"pieces": ["u1", [len(block)], 0]},
    }
    text = json.dumps(header).encode()
    text += b" " * (-len(text) % 8)
    _, [(found, ids, corners)] = unpacked(struct.pack("<II", 1, len(text)) + text + block)
    np.testing.assert_array_equal(found[corners], positions[indices])
    np.testing.assert_array_equal(ids[corners], parts[indices])


def test_what_has_no_room_is_left_out_smallest_last() -> None:
    made = geometry("engine", feeler.sample("engine", 300_000))
    whole, none = packed(made)
    data, left_out = packed(made, len(whole) // 6)
    header, pieces = unpacked_header(data), made.manifest()["pieces"]
    kept = header["manifest"]["pieces"]
    assert none == 0 < left_out == header["left_out"]
    assert 1 <= len(kept) < len(pieces) and kept == json.loads(json.dumps(pieces[: len(kept)]))
    assert header["manifest"]["triangles"] + left_out == made.manifest()["triangles"]
    assert packed(made, 1)[1] < made.manifest()["triangles"], "one piece always"


def unpacked_header(data: bytes) -> dict[str, Any]:
    header: dict[str, Any] = json.loads(data[8 : 8 + struct.unpack_from("<II", data)[1]])
    return header


class Elements(HTMLParser):
    """(tag, attributes, text) of the elements that have text."""

    def __init__(self, text: str) -> None:
        super().__init__()
        self.all: list[tuple[str, dict[str, str | None], str]] = []
        self.feed(text)

    def handle_starttag(self, tag: str, attrs: list[tuple[str, str | None]]) -> None:
        self.all.append((tag, dict(attrs), ""))

    def handle_data(self, data: str) -> None:
        if self.all:
            tag, attributes, text = self.all[-1]
            self.all[-1] = (tag, attributes, text + data)

    def handle_endtag(self, tag: str) -> None:
        self.all.append((f"/{tag}", {}, ""))

    def of(self, tag: str) -> list[tuple[dict[str, str | None], str]]:
        return [(attributes, text) for name, attributes, text in self.all if name == tag]


def test_the_file_is_a_page_where_only_its_own_script_runs() -> None:
    made = geometry('<img src=x onerror="alert(1)"></title><script>alert(2)</script>')
    data, _ = page(DOCUMENT, None, made.manifest(), made.piece, FILES, quiet)
    text = data.decode()
    found = Elements(text)
    (data_element, carried), (script_element, script) = found.of("script")
    assert data_element == {"type": "application/octet-stream", "id": "feeler-page"}
    assert (
        gzip.decompress(base64.b64decode(carried, validate=True))
        == container(DOCUMENT, None, made.manifest(), made.piece, quiet)[0]
    )
    assert script_element == {"type": "module"} and "src" not in script_element
    assert script == 'const a = "<\\/script><\\!--";\nlet b = 1;'
    assert not found.of("img")
    (policy,) = (each["content"] for each, _ in found.of("meta") if "http-equiv" in each)
    assert policy is not None and policy.startswith("default-src 'none'; ")
    for kind, inline in (("script", script), ("style", found.of("style")[0][1])):
        digest = base64.b64encode(hashlib.sha256(inline.encode()).digest()).decode()
        assert f"{kind}-src 'sha256-{digest}'" in policy
    assert "unsafe" not in policy and "connect" not in policy
    assert not re.search(r"https?://", text)


def test_a_page_that_is_not_built_is_said() -> None:
    made = geometry()
    with pytest.raises(WorkbenchError, match="make build"):
        page(DOCUMENT, None, made.manifest(), made.piece, {}, quiet)


def test_an_engine_of_1_6_million_triangles_has_room_in_5_mb() -> None:
    made = geometry("engine", feeler.sample("engine", 1_600_000))
    data, left_out = page(DOCUMENT, None, made.manifest(), made.piece, FILES, quiet)
    assert left_out == 0
    # The script and the style take a megabyte at the most.
    assert len(data) < 4_000_000


def test_the_job_writes_it_for_download(monkeypatch: pytest.MonkeyPatch, tmp_path: Path) -> None:
    for name in ("index.html", "main.js", "style.css"):
        (tmp_path / name).write_text(name)
    monkeypatch.setattr(files_module.static_files, "__defaults__", (tmp_path,))
    bench = Bench()
    try:
        stages: list[str] = []
        camera = {**CAMERA, "is_parallel": True}
        job = bench.session.job("page", {"camera": camera}, lambda share, stage: stages.append(stage))
        result = job.result(60)
        data = bench.session.export(result["name"])
        assert result == {"name": "mock-up.html", "bytes": len(data), "left_out": 0}
        assert data.startswith(b"<!doctype html>") and "packing" in stages
        with pytest.raises(WorkbenchError, match="position"):
            bench.session.job("page", {"camera": {}}).result(60)
    finally:
        bench.session.close()


def expected_pieces(data: bytes) -> bytes:
    """As the page's reader is to make them: what the server would send."""
    _, pieces = unpacked(data)
    made = b""
    for positions, parts, corners in pieces:
        for array in (positions.astype("<f4"), parts.astype("<u2"), corners.astype("<u2")):
            made += array.tobytes() + bytes(-array.nbytes % 4)
    return made


def golden() -> dict[str, bytes]:
    data = packed(geometry())[0]
    return {"page.bin": data, "page_pieces.bin": expected_pieces(data)}


def test_the_golden_files_are_as_they_were() -> None:
    for name, data in golden().items():
        assert (GOLDEN / name).read_bytes() == data


if __name__ == "__main__":
    for name, data in golden().items():
        (GOLDEN / name).write_bytes(data)
