"""Depth of the same contact at ever finer tessellation: feeler beside Coal and FCL; the cost of `contacts`; and the
results of `penetration`.

    python bench/contacts.py                      print the tables
    python bench/contacts.py --write              and put them into docs/contacts-figures.md, between its markers
    python bench/contacts.py --quick              small meshes, a small engine

Four contacts of known depth: a box, a ball and a rod pressed into a plate, and a gear tooth wedged in its slot. Both
sides are cut into more and more triangles; the surfaces stay the same (the ball and the rod touch with a corner that is
in all their meshes). feeler: the planes of `scene.contacts`. Coal and FCL: all contacts of the two meshes; the table
has the largest `penetration_depth` that each reports.
"""

from __future__ import annotations

import argparse
import platform
import sys
import time
from collections.abc import Callable, Iterator
from dataclasses import dataclass
from importlib.util import find_spec
from pathlib import Path
from typing import Any

import numpy as np
import numpy.typing as npt
from host import machine

import feeler

ROOT = Path(__file__).resolve().parents[1]
PAGE = ROOT / "docs" / "contacts-figures.md"
DEPTHS = ("<!-- depths: bench/contacts.py -->", "<!-- end of depths -->")
TIMES = ("<!-- times: bench/contacts.py -->", "<!-- end of times -->")
WAYS = ("<!-- ways: bench/contacts.py -->", "<!-- end of ways -->")

Floats = npt.NDArray[np.float64]
Faces = npt.NDArray[np.int64]
Mesh = tuple[Floats, Faces]

DEPTH = 0.0015  # metres
MARGIN = 0.002
MOST_CONTACTS = 1_000_000


@dataclass(frozen=True)
class Contact:
    """A mock-up, a tool, the pose, and how deep the tool is: the depths of all its planes, deepest first, metres."""

    mockup: Mesh
    tool: Mesh
    pose: Floats
    depths: tuple[float, ...]


def sheet(n: int, m: int, at: Callable[[Floats, Floats], tuple[Any, Any, Any]]) -> Mesh:
    """`n` by `m` cells of two triangles each, spanned by a function of two parameters in [0, 1]."""
    s, t = np.meshgrid(np.arange(n + 1) / n, np.arange(m + 1) / m, indexing="ij")
    vertices = np.stack([np.broadcast_to(x, s.shape).ravel() for x in at(s, t)], axis=1).astype(float)
    a = (np.arange(n)[:, None] * (m + 1) + np.arange(m)).ravel()
    b, c, d = a + m + 1, a + m + 2, a + 1
    return vertices, np.concatenate([np.stack([a, b, c], 1), np.stack([a, c, d], 1)])


def joined(*meshes: Mesh) -> Mesh:
    """One mesh of several, without triangles that have two corners in one place."""
    starts = np.cumsum([0, *(len(v) for v, _ in meshes)])
    vertices = np.concatenate([v for v, _ in meshes])
    faces = np.concatenate([f + start for (_, f), start in zip(meshes, starts, strict=False)])
    p = vertices[faces]
    equal = [(p[:, i] == p[:, (i + 1) % 3]).all(1) for i in range(3)]
    return vertices, faces[~(equal[0] | equal[1] | equal[2])]


def box(size: tuple[float, float, float], middle: tuple[float, float, float], cells: int) -> Mesh:
    """A closed box, each side cut into `cells` by `cells`."""

    def side(axis: int, sense: int) -> Mesh:
        def at(s: Floats, t: Floats) -> tuple[Any, Any, Any]:
            place: list[Any] = [0, 0, 0]
            u, v = (s, t) if sense > 0 else (t, s)
            for k, x in ((axis, sense), ((axis + 1) % 3, 2 * u - 1), ((axis + 2) % 3, 2 * v - 1)):
                place[k] = middle[k] + 0.5 * size[k] * x
            return place[0], place[1], place[2]

        return sheet(cells, cells, at)

    return joined(*(side(axis, sense) for axis in range(3) for sense in (1, -1)))


def ball(radius: float, bands: int) -> Mesh:
    """A closed ball with a corner at its lowest point."""

    def at(s: Floats, t: Floats) -> tuple[Any, Any, Any]:
        around, up = 2 * np.pi * np.where(s == 1, 0, s), np.pi * t
        out = np.where((t == 0) | (t == 1), 0.0, np.sin(up))
        return radius * out * np.cos(around), radius * out * np.sin(around), -radius * np.cos(up)

    return joined(sheet(2 * bands, bands, at))


def rod(radius: float, length: float, sides: int, rings: int) -> Mesh:
    """A closed cylinder along x with an edge at its lowest line."""

    def around(s: Floats) -> tuple[Any, Any]:
        angle = 2 * np.pi * np.where(s == 1, 0, s)
        return radius * np.sin(angle), -radius * np.cos(angle)

    wall = sheet(sides, rings, lambda s, t: ((t - 0.5) * length, *around(s)))
    caps = [
        sheet(sides, 1, lambda s, t, x=x: (np.full(s.shape, x), *(c * (1 - t if x > 0 else t) for c in around(s))))  # type: ignore[misc]
        for x in (0.5 * length, -0.5 * length)
    ]
    return joined(wall, *caps)


def ridge(line: list[tuple[float, float]], far: float, half: float, n: int, m: int) -> Mesh:
    """A closed body between a polyline (x, z) and the height `far`: its pieces cut into `n`, the length into `m`."""
    xs, zs = np.array(line, dtype=float).T
    pieces = len(line) - 1
    stations = np.arange(pieces * n + 1) / n
    x, z = np.interp(stations, np.arange(pieces + 1), xs), np.interp(stations, np.arange(pieces + 1), zs)

    def on(s: Floats) -> tuple[Floats, Floats]:
        i = np.rint(s * pieces * n).astype(int)
        return x[i], z[i]

    def height(z: Floats, t: Floats) -> Floats:
        return np.where(t == 1, z, np.where(t == 0, far, far + t * (z - far)))

    def y(t: Floats) -> Floats:
        return (2 * t - 1) * half

    count, first, last = pieces * n, (x[0], z[0]), (x[-1], z[-1])
    made = joined(
        sheet(count, m, lambda s, t: (on(s)[0], y(t), on(s)[1])),
        sheet(m, count, lambda t, s: (on(s)[0], y(t), far)),
        sheet(count, n, lambda s, t: (on(s)[0], -half, height(on(s)[1], t))),
        sheet(n, count, lambda t, s: (on(s)[0], half, height(on(s)[1], t))),
        sheet(m, n, lambda s, t: (last[0], y(s), height(np.full(s.shape, last[1]), t))),
        sheet(n, m, lambda t, s: (first[0], y(s), height(np.full(s.shape, first[1]), t))),
    )
    return made if line[0][1] > far else (made[0], made[1][:, [0, 2, 1]])


def shifted(x: float, y: float, z: float) -> Floats:
    """A pose without rotation."""
    pose = np.eye(4)
    pose[:3, 3] = x, y, z
    return pose


def box_in_plate(cells: int) -> Contact:
    """A box pressed into a plate."""
    plate, tool = box((0.1, 0.1, 0.02), (0, 0, -0.01), cells), box((0.03, 0.02, 0.04), (0, 0, 0.02), cells)
    return Contact(plate, tool, shifted(0.003, 0.002, -DEPTH), (DEPTH,))


def ball_in_plate(cells: int) -> Contact:
    """A ball pressed into a plate."""
    plate, tool = box((0.1, 0.1, 0.02), (0, 0, -0.01), cells), ball(0.02, max(4, 2 * cells))
    return Contact(plate, tool, shifted(0.003, 0.002, 0.02 - DEPTH), (DEPTH,))


def rod_in_plate(cells: int) -> Contact:
    """A lying rod pressed into a plate."""
    plate, tool = box((0.1, 0.1, 0.02), (0, 0, -0.01), cells), rod(0.01, 0.06, max(8, 4 * cells), cells)
    return Contact(plate, tool, shifted(0.003, 0.002, 0.01 - DEPTH), (DEPTH,))


def tooth_in_slot(cells: int) -> Contact:
    """A gear tooth with flanks of 20 degrees, pressed down and aside in its slot: both flanks hold."""
    sine, cosine = np.sin(np.radians(20)), np.cos(np.radians(20))
    slope = sine / cosine
    foot, rim = 0.002, 0.002 + 0.01 * slope
    slot = [(-0.02, 0.0), (-rim, 0.0), (-foot, -0.01), (foot, -0.01), (rim, 0.0), (0.02, 0.0)]
    tip, top = foot + 0.001 * slope, rim + 0.001 * slope
    tooth = [(-top, 0.001), (-tip, -0.009), (tip, -0.009), (top, 0.001)]
    down, aside = 0.0006, 0.0001
    depths = (down * sine + aside * cosine, down * sine - aside * cosine)
    n = max(1, cells // 2)
    return Contact(
        ridge(slot, -0.02, 0.03, n, 2 * n), ridge(tooth, 0.02, 0.01, n, 2 * n), shifted(aside, 0, -down), depths
    )


CASES: dict[str, Callable[[int], Contact]] = {
    "box in a plate": box_in_plate,
    "ball in a plate": ball_in_plate,
    "rod in a plate": rod_in_plate,
    "tooth in its slot": tooth_in_slot,
}
CELLS = (1, 4, 16, 45, 90)


def turned(contact: Contact) -> Contact:
    """The same contact, turned as a whole."""
    x, y, z, w = 0.2, -0.35, 0.5, 0.766
    x, y, z, w = np.array([x, y, z, w]) / np.sqrt(x * x + y * y + z * z + w * w)
    frame = np.eye(4)
    frame[:3, :3] = [
        [1 - 2 * (y * y + z * z), 2 * (x * y - z * w), 2 * (x * z + y * w)],
        [2 * (x * y + z * w), 1 - 2 * (x * x + z * z), 2 * (y * z - x * w)],
        [2 * (x * z - y * w), 2 * (y * z + x * w), 1 - 2 * (x * x + y * y)],
    ]
    vertices, faces = contact.mockup
    return Contact((vertices @ frame[:3, :3].T, faces), contact.tool, frame @ contact.pose, contact.depths)


def by_feeler(contact: Contact) -> list[float]:
    """Depths of the planes that are deep, deepest first."""
    scene, tool = feeler.Scene(feeler.Mockup(*contact.mockup)), feeler.Tool(*contact.tool)
    gaps = scene.contacts(tool, contact.pose, within=MARGIN).gaps
    return [float(-gap) for gap in gaps if gap < 0]


def by_coal(contact: Contact) -> list[float]:
    """The depths of all contacts, deepest first."""
    import coal
    from coal_engine import model

    request, result = coal.CollisionRequest(), coal.CollisionResult()
    request.num_max_contacts, request.enable_contact = MOST_CONTACTS, True
    place = coal.Transform3s(contact.pose[:3, :3], contact.pose[:3, 3])
    coal.collide(model(*contact.tool), place, model(*contact.mockup), coal.Transform3s.Identity(), request, result)
    return sorted((abs(float(c.penetration_depth)) for c in result.getContacts()), reverse=True)


def by_fcl(contact: Contact) -> list[float]:
    """The depths of all contacts, deepest first."""
    import fcl

    def body(mesh: Mesh, place: Any) -> Any:
        made = fcl.BVHModel()
        made.beginModel(len(mesh[1]), len(mesh[0]))
        made.addSubModel(mesh[0], mesh[1])
        made.endModel()
        return fcl.CollisionObject(made, place)

    result = fcl.CollisionResult()
    tool = body(contact.tool, fcl.Transform(contact.pose[:3, :3], contact.pose[:3, 3]))
    request = fcl.CollisionRequest(num_max_contacts=MOST_CONTACTS, enable_contact=True)
    fcl.collide(tool, body(contact.mockup, fcl.Transform()), request, result)
    return sorted((abs(float(c.penetration_depth)) for c in result.contacts), reverse=True)


PEERS: dict[str, tuple[str, Callable[[Contact], list[float]]]] = {"Coal": ("coal", by_coal), "FCL": ("fcl", by_fcl)}


def depth_rows(cells: tuple[int, ...]) -> Iterator[list[str]]:
    """One row a case, pose and fineness: triangles, true depths, and what each engine says, in millimetres."""
    peers = {name: run for name, (module, run) in PEERS.items() if find_spec(module) is not None}

    def shown(depths: list[float] | tuple[float, ...]) -> str:
        return ", ".join(f"{1000 * d:.4f}" for d in depths) or "none"

    for name, make in CASES.items():
        for n in cells:
            for place, contact in (("flush", make(n)), ("turned", turned(make(n)))):
                start = time.perf_counter()
                count = len(contact.mockup[1]) + len(contact.tool[1])
                row = [f"{name}, {place}", f"{count:,}", shown(contact.depths), shown(by_feeler(contact))]
                for run in peers.values():
                    depths = run(contact)
                    row.append(f"{shown(depths[:1])} ({len(depths):,})")
                row += ["not installed"] * (len(PEERS) - len(peers))
                print(f"{row[0]}, {row[1]} triangles: {time.perf_counter() - start:.1f} s", file=sys.stderr)
                yield row


def depth_table(cells: tuple[int, ...]) -> str:
    """The table of depths."""
    peers = [f"{name}: largest (contacts)" for name in PEERS]
    lines = [
        "| contact | triangles | true depths, mm | feeler | " + " | ".join(peers) + " |",
        "|---|---:|---:|---:|" + "---:|" * len(peers),
        *("| " + " | ".join(row) + " |" for row in depth_rows(cells)),
    ]
    return "\n".join([*lines, "", f"`python bench/contacts.py --write`, Python {platform.python_version()}."])


def nominal(scene: feeler.Scene, count: int) -> Iterator[tuple[str, feeler.Tool, Floats]]:
    """The sample tools by name, with nominal poses; the first contacts of each, which fill the caches, are done."""
    for name in ("torque", "wrench", "square", "hand"):
        tool = feeler.sample_tool(name)
        poses = feeler.sample_poses(scene, tool, "nominal", count)
        scene.contacts(tool, poses[0], MARGIN)
        yield name, tool, poses


def time_table(triangles: int, count: int) -> str:
    """Microseconds of `contacts` at a margin of 2 mm on nominal poses of the engine, one core."""
    mockup = feeler.sample("engine", triangles=triangles)
    scene = feeler.Scene(mockup, threads=1)
    # The first contacts of a mock-up find its triangles' neighbours; those of a small tool are nothing beside them.
    tool = feeler.sample_tool("torque")
    pose = feeler.sample_poses(scene, tool, "nominal", 1)[0]
    start = time.perf_counter()
    scene.contacts(tool, pose, MARGIN)
    first = time.perf_counter() - start
    lines = [
        "| tool | triangles | planes, mean | median | p95 | p99 | worst | `collide`, median |",
        "|---|---:|---:|---:|---:|---:|---:|---:|",
    ]
    for name, tool, poses in nominal(scene, count):
        best, collide, planes = np.full(count, np.inf), np.full(count, np.inf), 0
        for _ in range(3):
            for i, pose in enumerate(poses):
                start = time.perf_counter()
                found = scene.contacts(tool, pose, MARGIN)
                middle = time.perf_counter()
                scene.collide(tool, pose)
                end = time.perf_counter()
                best[i], collide[i] = min(best[i], middle - start), min(collide[i], end - middle)
                planes += len(found)
        p = [f"{1e6 * x:,.0f}" for x in (*np.percentile(best, [50, 95, 99]), best.max(), np.median(collide))]
        lines.append(f"| {name} | {tool.triangle_count:,} | {planes / (3 * count):.1f} | " + " | ".join(p) + " |")
        print(lines[-1], file=sys.stderr)
    memory = scene.memory()
    lines += [
        "",
        f"Microseconds over {count} nominal poses of `engine` with {mockup.triangle_count:,} triangles, best of three "
        f"rounds, one core of {machine()['cpu']}; topology and convex bodies of the first call: "
        f"{memory['adjacency'] / mockup.triangle_count:.0f} bytes a triangle, "
        f"{first:.2f} s on all cores.",
    ]
    return "\n".join(lines)


def way_table(triangles: int, count: int) -> str:
    """Results and times of `penetration` at nominal poses of the engine, one core."""
    scene = feeler.Scene(feeler.sample("engine", triangles=triangles), threads=1)
    lines = [
        "| tool | bound | estimate | length of a bound, mm: median | p90 | ms: median | p99 |",
        "|---|---:|---:|---:|---:|---:|---:|",
    ]
    for name, tool, poses in nominal(scene, count):
        found, times = [], np.zeros(count)
        for i, pose in enumerate(poses):
            start = time.perf_counter()
            found.append(scene.penetration(tool, pose, MARGIN))
            times[i] = 1e3 * (time.perf_counter() - start)
        kinds = [sum(out.kind == kind for out in found) for kind in ("bound", "estimate")]
        bounds = [1e3 * out.depth for out in found if out.kind == "bound"] or [np.nan]
        numbers = [*np.percentile(bounds, [50, 90]), *np.percentile(times, [50, 99])]
        row = [name, *(f"{kind}" for kind in kinds), *(f"{x:.1f}" for x in numbers)]
        lines.append("| " + " | ".join(row) + " |")
        print(lines[-1], file=sys.stderr)
    mockup = f"`engine` with {scene.mockup.triangle_count:,} triangles"
    return "\n".join([*lines, "", f"{count} nominal poses of {mockup}, one core of {machine()['cpu']}."])


def put(text: str, markers: tuple[str, str], table: str) -> str:
    """The page with a table between its markers."""
    before, rest = text.split(markers[0])
    return f"{before}{markers[0]}\n{table}\n{markers[1]}{rest.split(markers[1])[1]}"


def main(arguments: list[str] | None = None) -> int:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--write", action="store_true", help="put the tables into docs/contacts-figures.md")
    parser.add_argument("--quick", action="store_true", help="small meshes, a small engine")
    parser.add_argument("--only", choices=("depths", "times", "ways"), help="one of the tables")
    options = parser.parse_args(arguments)
    text = PAGE.read_text(encoding="utf-8")
    size = (20_000, 10) if options.quick else (1_600_000, 300)
    tables: dict[str, tuple[tuple[str, str], Callable[[], str]]] = {
        "depths": (DEPTHS, lambda: depth_table(CELLS[:2] if options.quick else CELLS)),
        "times": (TIMES, lambda: time_table(*size)),
        "ways": (WAYS, lambda: way_table(*size)),
    }
    for name, (markers, make) in tables.items():
        if options.only in (None, name):
            table = make()
            print(table)
            text = put(text, markers, table)
    if options.write:
        PAGE.write_text(text, encoding="utf-8")
    return 0


if __name__ == "__main__":
    sys.exit(main())
