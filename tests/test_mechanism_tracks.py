"""`feeler.load_tracks`: animations of glTF as motions of parts."""

from __future__ import annotations

import json
import math
from pathlib import Path
from typing import Any

import numpy as np
import numpy.typing as npt
import pytest
from shapes import box, prism_ring

import feeler
from feeler import Chain, Tracks, load_tracks
from feeler.errors import LoadError, OptionError

Floats = npt.NDArray[np.float64]


class Gltf:
    """A .gltf file under construction: nodes with boxes, and channels."""

    def __init__(self) -> None:
        self.data = b""
        self.root: dict[str, Any] = {
            "asset": {"version": "2.0", "generator": "feeler"},
            "scenes": [{"nodes": []}],
            **{key: [] for key in ("nodes", "meshes", "accessors", "bufferViews")},
            "animations": [{"name": "run", "samplers": [], "channels": []}],
        }

    def accessor(self, values: npt.ArrayLike, kind: str, component: int = 5126) -> int:
        array = np.asarray(values, dtype=np.float32 if component == 5126 else np.uint32)
        self.root["bufferViews"].append({"buffer": 0, "byteOffset": len(self.data), "byteLength": array.nbytes})
        self.data += array.tobytes()
        count = len(array) if kind != "SCALAR" else array.size
        view = len(self.root["bufferViews"]) - 1
        self.root["accessors"].append({"bufferView": view, "componentType": component, "count": count, "type": kind})
        return len(self.root["accessors"]) - 1

    def node(self, name: str, above: int = -1, size: float | None = 0.1, **placed: Any) -> int:
        entry: dict[str, Any] = {"name": name, **placed}
        number = len(self.root["nodes"])
        if size is not None:
            vertices, faces = box((-size, -size, -size), (size, size, size))
            mesh = {"attributes": {"POSITION": self.accessor(vertices, "VEC3")}}
            mesh["indices"] = self.accessor(np.ravel(faces), "SCALAR", 5125)
            entry["mesh"] = len(self.root["meshes"])
            self.root["meshes"].append({"primitives": [mesh]})
        self.root["nodes"].append(entry)
        if above < 0:
            self.root["scenes"][0]["nodes"].append(number)
        else:
            self.root["nodes"][above].setdefault("children", []).append(number)
        return number

    def mesh(self, node: int, vertices: Floats, faces: npt.NDArray[np.int64]) -> None:
        attributes = {"POSITION": self.accessor(vertices, "VEC3")}
        self.root["nodes"][node]["mesh"] = len(self.root["meshes"])
        indices = self.accessor(np.ravel(faces), "SCALAR", 5125)
        self.root["meshes"].append({"primitives": [{"attributes": attributes, "indices": indices}]})

    def channel(self, node: int, path: str, times: list[float], values: Any, kind: str = "LINEAR") -> None:
        entry = self.root["animations"][-1]
        width = "VEC4" if path == "rotation" else "VEC3" if path != "weights" else "SCALAR"
        sampler = {"input": self.accessor(times, "SCALAR"), "output": self.accessor(values, width)}
        entry["channels"].append({"sampler": len(entry["samplers"]), "target": {"node": node, "path": path}})
        entry["samplers"].append({**sampler, "interpolation": kind})

    def write(self, path: Path) -> Path:
        path.with_suffix(".bin").write_bytes(self.data)
        self.root["buffers"] = [{"uri": path.with_suffix(".bin").name, "byteLength": len(self.data)}]
        path.write_text(json.dumps(self.root))
        return path


def about(axis: tuple[float, float, float], angle: float) -> list[float]:
    """A unit quaternion."""
    unit = np.array(axis) / np.linalg.norm(axis)
    return [*(math.sin(angle / 2) * unit).tolist(), math.cos(angle / 2)]


def quaternion(rng: np.random.Generator) -> list[float]:
    q = rng.normal(size=4)
    return (q / np.linalg.norm(q)).tolist()


def matrix(move: Floats, turn: Floats, size: Floats) -> Floats:
    """As the standard says: translation times rotation times scale."""
    x, y, z, w = turn / np.linalg.norm(turn)
    left = np.array([[w, -z, y, x], [z, w, -x, y], [-y, x, w, z], [-x, -y, -z, w]])
    right = np.array([[w, -z, y, -x], [z, w, -x, -y], [-y, x, w, -z], [x, y, z, w]])
    found = np.asarray(left @ right)  # q p q*, on vectors
    found[:3, :3] *= size
    found[:3, 3] = move
    return found


def sampled(times: list[float], values: Floats, kind: str, time: float) -> Floats:
    """The value of a sampler by appendix C of the standard, written a second time."""
    time = min(max(time, times[0]), times[-1])
    k = max(i for i, each in enumerate(times) if each <= time)
    if kind == "STEP" or k == len(times) - 1:
        return values[k] if kind != "CUBICSPLINE" else values[3 * k + 1]
    span = times[k + 1] - times[k]
    t = (time - times[k]) / span
    if kind == "CUBICSPLINE":
        v, b, w, a = values[3 * k + 1], values[3 * k + 2], values[3 * k + 4], values[3 * k + 3]
        return np.asarray(
            (2 * t**3 - 3 * t**2 + 1) * v
            + span * (t**3 - 2 * t**2 + t) * b
            + (-2 * t**3 + 3 * t**2) * w
            + span * (t**3 - t**2) * a
        )
    one, other = values[k], values[k + 1]
    if values.shape[1] == 3:
        return np.asarray((1 - t) * one + t * other)
    dot = float(one @ other)
    angle = math.acos(min(1.0, abs(dot)))
    if angle < 1e-6:
        return np.asarray((1 - t) * one + t * math.copysign(1.0, dot) * other)
    back = math.copysign(1.0, dot)
    return np.asarray((math.sin(angle * (1 - t)) * one + back * math.sin(angle * t) * other) / math.sin(angle))


class Random:
    """A random tree of nodes, what moves them, and where they are by the standard."""

    def __init__(self, tmp_path: Path, seed: int, kinds: tuple[str, ...], spread: float = 0.5) -> None:
        rng = np.random.default_rng(seed)
        made = Gltf()
        self.nodes: list[dict[str, Any]] = []
        for number in range(5):
            above = int(rng.integers(-1, number)) if number else -1
            even = float(rng.uniform(0.5, 2.0)) * float(rng.choice([-1.0, 1.0]))
            placed = {
                "translation": np.float32(rng.uniform(-spread, spread, 3)).tolist(),
                "rotation": np.float32(quaternion(rng)).tolist(),
                "scale": [even] * 3,
            }
            made.node(f"n{number}", above, **placed)
            self.nodes.append({**placed, "above": above, "tracks": {}})
            for path, width in (("translation", 3), ("rotation", 4)):
                if rng.random() < 0.3:
                    continue
                kind = str(rng.choice(kinds))
                times = np.unique(np.float32(rng.uniform(0.0, 3.0, int(rng.integers(1, 5))))).tolist()
                values = np.float32([quaternion(rng) if width == 4 else rng.uniform(-spread, spread, 3) for _ in times])
                if kind == "CUBICSPLINE":
                    slopes = [np.float32(rng.normal(0, 0.2, (len(times), width))) for _ in range(2)]
                    values = np.stack([slopes[0], values, slopes[1]], axis=1).reshape(-1, width)
                made.channel(number, path, times, values, kind)
                values = values.astype(np.float64)
                if width == 4 and kind != "CUBICSPLINE":  # of length one but for float32
                    values = values / np.linalg.norm(values, axis=1)[:, None]
                self.nodes[-1]["tracks"][path] = (times, values, kind)
        self.file = made.write(tmp_path / f"r{seed}.gltf")

    def worlds(self, time: float | None) -> list[Floats]:
        found: list[Floats] = []
        for node in self.nodes:
            placed = {key: np.array(node[key]) for key in ("translation", "rotation", "scale")}
            for path, track in node["tracks"].items() if time is not None else ():
                placed[path] = sampled(*track, time)  # type: ignore[arg-type]
            own = matrix(placed["translation"], placed["rotation"], placed["scale"])
            found.append(own if node["above"] < 0 else found[node["above"]] @ own)
        return found


KINDS = [("LINEAR",), ("STEP", "LINEAR"), ("CUBICSPLINE", "LINEAR"), ("LINEAR", "STEP", "CUBICSPLINE")]


@pytest.mark.parametrize("kinds", KINDS)
def test_parts_are_where_the_standard_puts_them(tmp_path: Path, kinds: tuple[str, ...]) -> None:
    asked = 0
    for seed in range(12):
        made = Random(tmp_path, seed, kinds)
        if not any(node["tracks"] for node in made.nodes):
            continue
        tracks = load_tracks(made.file)
        rest = made.worlds(None)
        for time in np.random.default_rng(seed).uniform(-0.5, 3.5, 8):
            worlds, poses = made.worlds(float(time)), tracks.poses(float(time))
            for path, pose in poses.items():
                number = int(path.rsplit("/n", 1)[1][0])
                expected = worlds[number] @ np.linalg.inv(rest[number])
                assert pose == pytest.approx(expected, abs=1e-9)
                asked += 1
        there = tracks.scene(1.5).mockup
        assert there.part_paths == tracks.mockup.part_paths
        for part, path in enumerate(there.part_paths):
            pose = tracks.poses(1.5).get(path, np.eye(4))
            corners = [mock.vertices[mock.faces[mock.part_of_face == part]] for mock in (tracks.mockup, there)]
            assert corners[1] == pytest.approx(corners[0] @ pose[:3, :3].T + pose[:3, 3], abs=1e-12)
    assert asked > 100


@pytest.mark.parametrize("kinds", [("LINEAR",), ("LINEAR", "CUBICSPLINE")])
def test_chains_follow_the_poses(tmp_path: Path, kinds: tuple[str, ...]) -> None:
    asked = 0
    for seed in range(20, 23):
        made = Random(tmp_path, seed, kinds)
        if not any(node["tracks"] for node in made.nodes):
            continue
        tracks = load_tracks(made.file)
        for body in [each for each in tracks._bodies if each >= 0]:
            points = np.asarray(tracks._tool(body).vertices)
            for step in tracks._steps(body, -1, tracks.start, tracks.end, 1e-2):
                for share in (0.0, 0.3, 0.5, 0.8, 1.0):
                    pose = Chain(step.joints).at(step.pose, share)
                    time = step.begin + share * (step.end - step.begin)
                    true = tracks._relative(body, -1, time)
                    off = points @ (pose - true)[:3, :3].T + (pose - true)[:3, 3]
                    assert np.linalg.norm(off, axis=1).max() <= step.error + 1e-9
                    assert step.error <= 1e-2
                    asked += 1
    assert asked > 200


def test_bodies_that_both_move_are_followed_against_each_other(tmp_path: Path) -> None:
    asked = 0
    for seed in range(40, 44):
        made = Random(tmp_path, seed, ("LINEAR",))
        tracks = load_tracks(made.file)
        bodies = [each for each in tracks._bodies if each >= 0]
        for one in bodies:
            for other in bodies:
                if one == other:
                    continue
                for step in tracks._steps(one, other, tracks.start, tracks.end, 1e-3):
                    for share in (0.0, 0.4, 1.0):
                        pose = Chain(step.joints).at(step.pose, share)
                        time = step.begin + share * (step.end - step.begin)
                        assert pose == pytest.approx(tracks._relative(one, other, time), abs=1e-9)
                        asked += 1
    assert asked > 200


def swing(tmp_path: Path) -> Tracks:
    """A box on an arm of 1 m turns a quarter in a second, and meets one that stands 45 degrees on; then it goes on."""
    made = Gltf()
    hub = made.node("hub", size=None)
    made.node("bob", hub, translation=[1.0, 0.0, 0.0])
    made.node("post", translation=[math.sqrt(0.5), math.sqrt(0.5), 0.0])
    made.channel(hub, "rotation", [0.0, 1.0, 2.0], [about((0, 0, 1), q * math.pi / 2) for q in range(3)])
    return load_tracks(made.write(tmp_path / "swing.gltf"))


def test_clashes_have_their_first_time(tmp_path: Path) -> None:
    tracks = swing(tmp_path)
    assert tracks.moving == ("swing/hub/bob",) and (tracks.start, tracks.end) == (0.0, 2.0)
    (file,) = tracks.mockup.source.files
    assert any("not played" in note for note in feeler.load_mockup(file).source.notes)
    assert tracks.mockup.source.notes == (), "the animation is what is read"
    found = tracks.clash()
    assert [(each.path, each.other_path) for each in found.contacts] == [("swing/hub/bob", "swing/post")]
    time = found.contacts[0].value

    def gap(at: float) -> float:
        pose, tool = tracks.poses(at)["swing/hub/bob"], feeler.Tool.of_parts(tracks.mockup, "*bob")
        return float(feeler.Scene(tracks.mockup).only("*post").distance(tool, pose).value)

    assert 0.0 < gap(time - 1e-6) < 1e-5 and gap(time + 1e-6) == 0.0
    path = (
        feeler.Scene(tracks.mockup)
        .without("*bob")
        .check_path(feeler.Tool.of_parts(tracks.mockup, "*bob"), tracks.chain("*bob"))
    )
    assert path.fractions[0] == pytest.approx(time, abs=1e-6)
    assert tracks.clash(start=1.0).contacts == () and tracks.clash(end=time - 1e-4).contacts == ()


def test_clearance_bounds_all_times(tmp_path: Path) -> None:
    tracks = swing(tmp_path)
    found = tracks.clearance(1e-4, start=0.0, end=0.3)
    assert found.upper - found.lower <= 1e-4 and found.worst["time"] == pytest.approx(0.3)
    assert (found.path, found.other_path) == ("swing/hub/bob", "swing/post") and found.points is not None
    assert np.linalg.norm(np.subtract(*found.points)) == pytest.approx(found.upper)
    assert found.curve.shape == (61, 3) and found.curve[0, 1] > found.curve[-1, 1]
    assert tracks.clearance().upper == 0.0 == tracks.clearance().lower


def test_bounds_hold_between_the_positions_that_were_asked(tmp_path: Path) -> None:
    # The bob passes the post in the midst of a turn, outside of it.
    for angle in (0.3, 0.62, 0.9, 1.1):
        made = Gltf()
        hub = made.node("hub", size=None)
        made.node("bob", hub, translation=[1.0, 0.0, 0.0])
        made.node(
            "post", translation=[1.4 * math.cos(angle), 1.4 * math.sin(angle), 0.0], rotation=about((1, 2, 3), 0.7)
        )
        made.channel(hub, "rotation", [0.0, 1.0], [about((0, 0, 1), q * math.pi / 2) for q in range(2)])
        tracks = load_tracks(made.write(tmp_path / "pass.gltf"))
        found = tracks.clearance(0.05)
        near = found.worst["time"] + np.linspace(-0.2, 0.2, 2001)
        truth = min(tracks._gap(time, [None]) for time in np.clip(near, 0.0, 1.0).tolist())
        assert found.lower <= truth <= found.upper and found.upper - found.lower <= 0.05
        if found.upper > truth + 1e-5:
            return
    pytest.fail("the worst position was found exactly each time: give others")


@pytest.mark.parametrize("kinds", KINDS)
def test_bounds_are_never_above_samples(tmp_path: Path, kinds: tuple[str, ...]) -> None:
    asked = 0
    for seed in range(60, 63):
        made = Random(tmp_path, seed, kinds, spread=4.0)
        tracks = load_tracks(made.file)
        found = tracks.clearance(1e-2, ignore_touching=False)
        pairs = list(tracks._pairs())
        times = np.linspace(tracks.start, tracks.end, 60).tolist()
        times += np.clip(found.worst["time"] + np.linspace(-0.05, 0.05, 120), tracks.start, tracks.end).tolist()
        least = min(tracks._gap(time, [None] * len(pairs)) for time in times)
        assert found.lower <= least + 1e-12 and found.upper - found.lower <= 1e-2
        assert bool(tracks.clash(1e-2, ignore_touching=False).contacts) == (found.upper == 0.0)
        asked += found.lower > 0.0
    assert asked


def test_contacts_at_the_start_are_seats(tmp_path: Path) -> None:
    made = Gltf()
    slide = made.node("slide", translation=[0.0, 0.0, 0.2])
    made.node("bed")
    made.channel(slide, "translation", [0.0, 1.0], [[0, 0, 0.2], [0.5, 0, 0.2]])
    tracks = load_tracks(made.write(tmp_path / "slide.gltf"))
    found = tracks.clearance()
    assert [(each.path, each.other_path) for each in found.seats] == [("slide/slide", "slide/bed")]
    assert found.upper == math.inf and found.part is None
    assert tracks.clearance(ignore_touching=False).upper < 1e-6
    assert tracks.clash().contacts == ()


def test_a_seat_that_goes_deeper_jams(tmp_path: Path) -> None:
    """A block slides along its bed, off it, back, and is pressed into it from 3.5 s on."""
    made = Gltf()
    slide = made.node("slide", translation=[0.0, 0.0, 0.2])
    made.node("bed")
    ways = [[0, 0, 0.2], [0.15, 0, 0.2], [0.5, 0, 0.3], [0, 0, 0.2], [0, 0, 0.2], [0.01, 0, 0.19]]
    made.channel(slide, "translation", [0.0, 1.0, 2.0, 3.0, 3.5, 4.5], ways)
    tracks = load_tracks(made.write(tmp_path / "slide.gltf"))
    (met,) = tracks.clash().contacts
    assert (met.path, met.other_path) == ("slide/slide", "slide/bed") and 3.5 - 1e-9 <= met.value <= 3.5002
    assert tracks.clash(end=3.5).contacts == ()
    found = tracks.clearance()
    assert found.upper == found.lower == 0.0 and found.jams == (met,) and found.worst == {"time": met.value}
    assert (found.path, found.other_path) == ("slide/slide", "slide/bed")
    late = found.curve[:, 0] >= met.value
    assert (found.curve[late, 1] == 0.0).all() and (found.curve[~late, 1] > 0.0).all()
    assert tracks.clearance(end=3.5).jams == ()


def test_a_seat_jumps_back_but_not_into_its_bed(tmp_path: Path) -> None:
    made = Gltf()
    slide = made.node("slide", translation=[0.0, 0.0, 0.2])
    made.node("bed")
    ways = [[0, 0, 0.2], [0.0, 0, 0.5], [0, 0, 0.2], [0, 0, 0.19]]
    made.channel(slide, "translation", [0.0, 1.0, 2.0, 3.0], ways, "STEP")
    tracks = load_tracks(made.write(tmp_path / "slide.gltf"))
    assert [met.value for met in tracks.clash().contacts] == [3.0]


def test_facets_of_a_pin_that_turns_in_its_hole_do_not_clash(tmp_path: Path) -> None:
    """A pin of 12 sides in a hole of 12; and one with a square end in a square hole, which does."""
    for is_square, count in ((False, 0), (True, 1)):
        made, sides = Gltf(), 4 if is_square else 12
        turn = made.node("pin", size=None)
        made.mesh(turn, *prism_ring(0.02, 0.0, sides, -0.05, 0.05))
        made.mesh(made.node("plate", size=None), *prism_ring(0.04, 0.02, sides, -0.01, 0.01))
        turned = [[0.0, 0.0, math.sin(a / 2), math.cos(a / 2)] for a in (0.0, 0.8)]
        made.channel(turn, "rotation", [0.0, 1.0], turned)
        tracks = load_tracks(made.write(tmp_path / f"pin{count}.gltf"))
        found = tracks.clash()
        assert len(found.seats) == 1 and len(found.contacts) == count, is_square
        assert found.seats[0].kind != "round" or not is_square


def test_steps_jump(tmp_path: Path) -> None:
    made = Gltf()
    jump = made.node("jump", translation=[0.0, 0.0, 0.0])
    made.node("there", translation=[1.0, 0.0, 0.0])
    made.node("between", translation=[0.5, 0.0, 0.0])
    made.channel(jump, "translation", [0.0, 1.0, 2.0], [[0, 0, 0], [0, 0, 0], [1, 0, 0]], "STEP")
    tracks = load_tracks(made.write(tmp_path / "jump.gltf"))
    found = tracks.clash()
    assert [(each.other_path, each.value) for each in found.contacts] == [("jump/there", 2.0)]
    with pytest.raises(OptionError, match="jump at 2 s"):
        tracks.chain("*jump")
    assert tracks.clearance(end=1.9).upper == pytest.approx(0.3)


@pytest.mark.parametrize("end", [1.5, 2.0])
def test_what_is_met_just_before_a_jump_is_met(tmp_path: Path, end: float) -> None:
    """A block slides to another one, from 0.7 on into it, and is lifted away in a jump."""
    made = Gltf()
    lift = made.node("lift", size=None)
    slide = made.node("slide", lift)
    made.node("block", translation=[0.9, 0.0, 0.0])
    made.channel(slide, "translation", [0.0, 2.0], [[0, 0, 0], [1, 0, 0]])
    made.channel(lift, "translation", [0.0, 1.5, 2.0], [[0, 0, 0], [0, 0, 5], [0, 0, 5]], "STEP")
    tracks = load_tracks(made.write(tmp_path / "jump.gltf"))
    found = tracks.clearance(end=end)
    assert (found.lower, found.upper) == (0.0, 0.0) and 1.4 <= found.worst["time"] < 1.5
    (pose,) = tracks.poses(found.worst["time"]).values()
    assert pose[2, 3] == 0.0 and pose[0, 3] > 0.7
    far = tracks.clearance(1e-3, start=1.0, end=1.2)
    assert far.upper == pytest.approx(0.1, abs=1e-6) and far.worst["time"] == 1.2


def test_axes_are_turned_with_the_parts(tmp_path: Path) -> None:
    made = Gltf()
    made.root["asset"]["generator"] = "another"
    lift = made.node("lift")
    made.channel(lift, "translation", [0.0, 1.0], [[0, 0, 0], [0, 2, 0]])
    file = made.write(tmp_path / "lift.gltf")
    assert load_tracks(file).poses(1.0)["lift/lift"][:3, 3].tolist() == [0.0, 2.0, 0.0]
    assert load_tracks(file, up="z").poses(1.0)["lift/lift"][:3, 3].tolist() == [0.0, 0.0, 2.0]


def test_animations_are_chosen_by_name_or_number(tmp_path: Path) -> None:
    made = Gltf()
    door = made.node("door")
    made.channel(door, "translation", [0.0, 1.0], [[0, 0, 0], [1, 0, 0]])
    made.root["animations"].append({"name": "close", "samplers": [], "channels": []})
    made.channel(door, "translation", [0.0, 1.0], [[1, 0, 0], [0, 0, 0]])
    file = made.write(tmp_path / "two.gltf")
    with pytest.raises(OptionError, match="2 animations: give animation= one of 'run', 'close'"):
        load_tracks(file)
    assert load_tracks(file, "close").names == ("run", "close") and load_tracks(file, 0).name == "run"
    for wrong in ("open", 2, -1, True):
        with pytest.raises(OptionError):
            load_tracks(file, wrong)


def broken(what: str, made: Gltf, node: int) -> None:
    entry = made.root["animations"][0]
    if what == "scaled":
        made.channel(node, "scale", [0.0, 1.0], [[1, 1, 1], [2, 2, 2]])
    elif what == "weights":
        made.channel(node, "weights", [0.0, 1.0], [0.0, 1.0])
    elif what == "times":
        made.channel(node, "rotation", [1.0, 0.0], [about((0, 0, 1), 0.0)] * 2)
    elif what == "count":
        made.channel(node, "rotation", [0.0, 1.0], [about((0, 0, 1), 0.0)] * 3)
    elif what == "zero":
        made.channel(node, "rotation", [0.0, 1.0], [[0, 0, 0, 0]] * 2)
    elif what == "twice":
        made.channel(node, "translation", [0.0, 1.0], [[0, 0, 0]] * 2)
    elif what == "kind":
        entry["samplers"][0]["interpolation"] = "SMOOTH"
    elif what == "sampler":
        entry["channels"][0]["sampler"] = 7
    elif what == "target":
        entry["channels"][0]["target"] = None
    elif what == "path":
        entry["channels"][0]["target"]["path"] = "colour"
    elif what == "matrix":
        made.root["nodes"][node]["matrix"] = np.eye(4).ravel().tolist()
    elif what == "none":
        del made.root["animations"]
    elif what == "still":
        entry["channels"] = []
    elif what == "sheared":
        made.root["nodes"][0]["scale"] = [1, 2, 1]
        made.channel(node, "rotation", [0.0, 1.0], [about((0, 0, 1), 0.0), about((0, 0, 1), 1.0)])
    elif what == "pointer":
        pointed = {"KHR_animation_pointer": {"pointer": f"/nodes/{node}/translation"}}
        entry["channels"][0]["target"] = {"path": "pointer", "extensions": pointed}


@pytest.mark.parametrize(
    ("what", "says"),
    [
        ("scaled", "channel 1 scales 'door'"),
        ("weights", "channel 1 changes the shape of 'door'"),
        ("times", "channel 1 has times that do not ascend"),
        ("count", "2 times and 3 values"),
        ("zero", "rotation of length zero"),
        ("twice", "the translation of 'door' a second time"),
        ("kind", "interpolation 'SMOOTH'"),
        ("sampler", "sampler 7"),
        ("target", "channel 0 has no target"),
        ("path", "the path 'colour'"),
        ("matrix", "placed by a matrix"),
        ("none", "no animation in it"),
        ("still", "moves no node"),
        ("sheared", "'door' turns below a scale that differs"),
        ("pointer", "by a pointer"),
    ],
)
def test_animations_that_cannot_be(tmp_path: Path, what: str, says: str) -> None:
    made = Gltf()
    door = made.node("door", made.node("house", size=None))
    made.channel(door, "translation", [0.0, 1.0], [[0, 0, 0], [1, 0, 0]])
    broken(what, made, door)
    with pytest.raises(LoadError, match=says):
        load_tracks(made.write(tmp_path / "door.gltf"))


def test_scales_that_are_written_and_do_not_change_are_no_scaling(tmp_path: Path) -> None:
    made = Gltf()
    door = made.node("door", scale=[2, 2, 2])
    made.channel(door, "translation", [0.0, 1.0], [[0, 0, 0], [1, 0, 0]])
    made.channel(door, "scale", [0.0, 1.0], [[2, 2, 2]] * 2)
    assert load_tracks(made.write(tmp_path / "door.gltf")).poses(1.0)["door/door"][0, 3] == 1.0


def test_files_of_other_formats_and_times_that_cannot_be_are_refused(tmp_path: Path) -> None:
    feeler.io.write_stl(tmp_path / "a.stl", swing(tmp_path).mockup)
    with pytest.raises(LoadError, match="no glTF file"):
        load_tracks(tmp_path / "a.stl")
    with pytest.raises(OptionError, match="start before the end"):
        swing(tmp_path).clearance(start=2.0, end=1.0)
    with pytest.raises(OptionError, match="do not move as one"):
        swing(tmp_path).chain("*post")
