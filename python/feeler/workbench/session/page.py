"""One HTML file to send: the page with the mock-up inside. It works offline, and is read-only.

The file has the page's style, its script, and in a `<script type="application/octet-stream" id="feeler-page">` the
base64 of a gzip of one frame of the link (`frames.py`), the message `SavedPage`.

Its pieces are filtered, because gzip then makes them a fifth as large (an engine of 200 thousand triangles: 265 kB
instead of 1.28 MB): each is planes of bytes, the lowest bytes of all numbers first, then the next. Of v vertices, in
the order in which the triangles first use them, and t triangles:

    3 times (x, y, z)  3 planes of v   difference to the vertex before, zigzag: position = lower + number * step
    1 time (part)      4 planes of v   difference to the vertex before, zigzag
    3 times (corners)  2 planes of t   how far a corner is below the first vertex that no corner before it named

where zigzag encodes 0, -1, 1, -2, 2 as 0, 1, 2, 3, 4, and 0 precedes the first vertex.
`viewer/src/link/offline-file.ts` turns them back into pieces as the server sends them.
"""

from __future__ import annotations

import base64
import gzip
import hashlib
import html
from collections.abc import Callable, Iterable, Mapping
from typing import Any

import numpy as np
import numpy.typing as npt

from feeler.errors import WorkbenchError
from feeler.progress import Progress
from feeler.workbench.document.frames import pack
from feeler.workbench.document.protocol import Camera, DocumentFields, Manifest, ManifestPiece, SavedPage
from feeler.workbench.files import File

GRID_BITS = 18
"""Positions are in whole steps of the longest side over 2^18: 11 micrometres of a mock-up of 3 m."""

MOST_BYTES = 25_000_000
"""Limit of the packed geometry. Beyond it the smallest parts are left out, and the page says so."""

Ints = npt.NDArray[np.int64]


def page(
    document: DocumentFields,
    camera: Camera | None,
    manifest: Manifest,
    piece: Callable[[int], bytes],
    files: Mapping[str, File],
    progress: Progress,
    most_bytes: int = MOST_BYTES,
    findings: bytes = b"",
) -> tuple[bytes, int]:
    """The file, and the number of triangles left out. piece: the bytes of a piece, by its number.

    files: the page's own, `static_files()`. findings: the frame of their rows. Raises `WorkbenchError` if its script is
    missing.
    """
    packed, left_out = container(document, camera, manifest, piece, progress, most_bytes, findings)
    progress(0.9, "writing")
    return _document(manifest["name"], files, gzip.compress(packed, 9, mtime=0)), left_out


def container(
    document: DocumentFields,
    camera: Camera | None,
    manifest: Manifest,
    piece: Callable[[int], bytes],
    progress: Progress,
    most_bytes: int = MOST_BYTES,
    findings: bytes = b"",
) -> tuple[bytes, int]:
    """The frame before compression, and the number of triangles left out."""
    # From the pieces' own boxes: triangles that are not drawn have no place on the grid.
    lower = np.min([each["lower"] for each in manifest["pieces"]], axis=0)
    upper = np.max([each["upper"] for each in manifest["pieces"]], axis=0)
    step = float(max((upper - lower).max(), 1e-9)) / (2**GRID_BITS - 1)
    lower = lower - np.asarray(manifest["middle"])  # positions in pieces are from the middle
    blocks: list[bytes] = []
    inside: list[ManifestPiece] = []
    size = 0
    for number, sizes in enumerate(manifest["pieces"]):
        progress(0.9 * number / len(manifest["pieces"]), "packing")
        block = packed_piece(*_arrays(piece(number), sizes, manifest["part_bytes"]), lower, step)
        # The limit applies to gzip's output, which is not known yet: about a third.
        size += len(block) // 3
        if size > most_bytes and inside:
            break
        blocks.append(block)
        inside.append(sizes)
    triangles = sum(each["triangles"] for each in inside)
    left_out = manifest["triangles"] - triangles
    vertices = sum(each["vertices"] for each in inside)
    saved = SavedPage(
        document={**document, "loading": None},
        camera=camera,
        manifest={**manifest, "triangles": triangles, "vertices": vertices, "pieces": inside},
        left_out=left_out,
        grid={"lower": (float(lower[0]), float(lower[1]), float(lower[2])), "step": step},
        findings=np.frombuffer(findings, np.uint8),
        pieces=np.frombuffer(b"".join(blocks), np.uint8),
    )
    frame = pack(saved)
    assert isinstance(frame, bytes)
    return frame, left_out


def packed_piece(
    positions: npt.NDArray[np.float32],
    parts: npt.NDArray[Any],
    indices: npt.NDArray[np.uint16],
    lower: npt.NDArray[np.float64],
    step: float,
) -> bytes:
    """The planes of a piece."""
    corners = indices.astype(np.int64).ravel()
    used, first = np.unique(corners, return_index=True)
    order = used[np.argsort(first)]
    place = np.zeros(len(positions), np.int64)
    place[order] = np.arange(len(order))
    corners = place[corners]
    # The first unused vertex; a corner is that one, or one before it.
    next_new = np.concatenate([[0], np.maximum.accumulate(corners)[:-1] + 1])
    below = (next_new - corners).reshape(-1, 3)
    steps = np.rint((positions[order] - lower) / step).astype(np.int64)
    columns = [_planes(_zigzag(steps[:, axis]), 3) for axis in range(3)]
    columns.append(_planes(_zigzag(parts[order].astype(np.int64)), 4))
    columns += [_planes(below[:, corner], 2) for corner in range(3)]
    return b"".join(columns)


def _arrays(
    data: bytes, sizes: ManifestPiece, part_bytes: int
) -> tuple[npt.NDArray[np.float32], npt.NDArray[Any], npt.NDArray[np.uint16]]:
    vertices, triangles = sizes["vertices"], sizes["triangles"]
    parts_at = 12 * vertices
    indices_at = parts_at + -(-part_bytes * vertices // 4) * 4
    return (
        np.frombuffer(data, "<f4", 3 * vertices).reshape(-1, 3),
        np.frombuffer(data, f"<u{part_bytes}", vertices, parts_at),
        np.frombuffer(data, "<u2", 3 * triangles, indices_at).reshape(-1, 3),
    )


def _zigzag(values: Ints) -> Ints:
    differences = np.diff(values, prepend=0)
    return (differences << 1) ^ (differences >> 63)


def _planes(values: Ints, count: int) -> bytes:
    return b"".join(((values >> (8 * i)) & 0xFF).astype(np.uint8).tobytes() for i in range(count))


def _document(name: str, files: Mapping[str, File], compressed: bytes) -> bytes:
    for needed in ("/main.js", "/style.css"):
        if needed not in files:
            raise WorkbenchError(f"the page has no {needed[1:]}", "page", "run `make build` again")
    # A closing tag inside a text of the script would end the script.
    script = _lines(files["/main.js"]).replace("</script", "<\\/script").replace("<!--", "<\\!--")
    style = _lines(files["/style.css"]).replace("</style", "<\\/style")
    policy = "; ".join(
        [
            "default-src 'none'",
            f"script-src {_allowed([script])}",
            f"style-src {_allowed([style])}",
            "img-src blob: data:",
            "base-uri 'none'",
            "form-action 'none'",
        ]
    )
    return f"""<!doctype html>
<html lang="en">
<head>
<meta charset="utf-8">
<meta http-equiv="Content-Security-Policy" content="{html.escape(policy)}">
<meta name="viewport" content="width=device-width, initial-scale=1">
<meta name="color-scheme" content="dark light">
<title>{html.escape(name)}</title>
<style>{style}</style>
</head>
<body>
<div id="app"></div>
<noscript>This page needs JavaScript and WebGL 2.</noscript>
<script type="application/octet-stream" id="feeler-page">{base64.b64encode(compressed).decode("ascii")}</script>
<script type="module">{script}</script>
</body>
</html>
""".encode("utf-8", "replace")


def _lines(file: File) -> str:
    """The text with normalised line ends, as browsers read it, or the digests would differ."""
    return file.data.decode().replace("\r\n", "\n").replace("\r", "\n")


def _allowed(texts: Iterable[str]) -> str:
    """Source expressions for inline text, so that nothing else inline runs: the file also contains names of a
    mock-up."""
    digests = (hashlib.sha256(text.encode()).digest() for text in texts)
    return " ".join(f"'sha256-{base64.b64encode(digest).decode('ascii')}'" for digest in digests)
