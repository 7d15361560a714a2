"""The tool catalogue: shapes, files, and which tool `access` chooses, against closed forms and the gearbox's truth."""

from __future__ import annotations

import math
import pickle
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from shapes import box, mockup_of

import feeler
from feeler.plan.catalogue import built_in_text, core_of, shaped, tool_of
from feeler.plan.choosing import Chosen, room_of
from feeler.plan.reach_question import SeatSearch
from feeler.plan.swings import turned
from feeler.plan.tool_solids import disc, lathed, prism

BUILT_IN = feeler.catalogue()
FLATS, HEAD = 0.013, 0.0053
HEXAGON = [
    (FLATS / math.sqrt(3.0) * math.cos(a), FLATS / math.sqrt(3.0) * math.sin(a)) for a in np.arange(6) * math.pi / 3
]
KINDS = {"socket": {"socket"}, "hex key": {"bit", "hex_key"}, "open-end wrench": {"open"}}


def head(**more: Any) -> feeler.Fasteners:
    """A hexagon head M8, whose top is at the origin."""
    facts = {"part": 0, "path": "bolt", "kind": "bolt", "frame": np.eye(4), "size": 0.008, "across_flats": FLATS}
    facts |= {"length": 0.03, "head_height": HEAD, "confidence": 1.0, "because": "", "drive": "hexagon"}
    return feeler.Fasteners([feeler.Fastener(**{**facts, **more})])


def around(parts: dict[str, Any], bolt: Any = None) -> feeler.Scene:
    """The head on a plate, and other parts."""
    plate = box((-0.3, -0.3, -0.02), (0.3, 0.3, -HEAD))
    mockup = mockup_of({"bolt": bolt or prism(HEXAGON, -HEAD, 0.0), "plate": plate, **parts})
    return feeler.Scene(mockup)


def rotated(mesh: Any, degrees: float) -> Any:
    c, s = np.cos(np.radians(degrees)), np.sin(np.radians(degrees))
    return mesh[0] @ np.array([[c, -s, 0.0], [s, c, 0.0], [0.0, 0.0, 1.0]]).T, mesh[1]


def test_each_tool_is_closed_and_faces_outwards() -> None:
    assert len(BUILT_IN) > 200 and len({row.name for row in BUILT_IN}) == len(BUILT_IN)
    for row in BUILT_IN:
        tool = tool_of((row,))
        shape = shaped((row,))
        for name, (vertices, faces) in shape.solids:
            corners = vertices[faces]
            volume = np.einsum("ij,ij->i", corners[:, 0], np.cross(corners[:, 1], corners[:, 2])).sum() / 6.0
            edges = np.sort(faces[:, [0, 1, 1, 2, 2, 0]].reshape(-1, 2), axis=1)
            assert volume > 0.0 and (np.unique(edges, axis=0, return_counts=True)[1] % 2 == 0).all(), (row.name, name)
        assert not tool.defects["zero_area"].count and not tool.defects["duplicate"].count, row.name
        assert tool.bounds[0, 2] > -1e-12 - 0.5 * row.size * (row.kind == "hex_key") and np.allclose(
            shape.grip[:3, :3] @ shape.grip[:3, :3].T, np.eye(3)
        )


def test_where_a_core_collides_its_chain_does_at_any_angle() -> None:
    """Random small cubes in and around chains: they collide with the chain, or are inside of it."""
    rng = np.random.default_rng(1)
    chains = [*BUILT_IN.fitting("hexagon", FLATS, 0.008)[:60:9], *BUILT_IN.fitting("hexagon socket", 0.006, 0.0)[:9:3]]
    hits = 0
    for chain in chains:
        core, tool = core_of(chain), tool_of(chain)
        assert core is not None
        low, high = core.bounds
        for place in rng.uniform(1.1 * low, 1.1 * high, (25, 3)):
            cube = feeler.Scene(mockup_of({"cube": box(place - 5e-4, place + 5e-4)}))
            if not len(cube.collide(core, np.eye(4))):
                continue
            hits += 1
            for angle in rng.uniform(0.0, 360.0, 4):
                pose = turned(angle)
                assert len(cube.collide(tool, pose)) or cube.containment(tool, pose), (chain, place)
    assert hits > 20


def walls_of(rng: np.random.Generator) -> list[tuple[float, float]]:
    """Distances and directions: some leave wide gaps, some narrow ones."""
    count, far = rng.integers(1, 6), rng.choice([0.07, 0.17])
    return [(float(rng.uniform(0.03, far)), float(rng.uniform(0.0, 360.0))) for _ in range(count)]


def free_swing(walls: list[tuple[float, float]], corner: float, skew: float, start: float = 0.0) -> float:
    """The largest free swing of a bar whose far corners are at a radius and an angle beside its axis, between planes
    (distance, direction in degrees); it is as wide as thin: no other corner meets one first."""
    blocked = []
    for distance, direction in walls:
        if distance < corner:
            half = math.degrees(math.acos(distance / corner)) + skew
            blocked.append(((direction - half - start) % 360.0, 2.0 * half))
    if not blocked:
        return 360.0
    steps = sorted(blocked)
    best, reach = 0.0, max(low + span for low, span in steps) - 360.0
    for low, span in steps:
        best, reach = max(best, low - reach), max(reach, low + span)
    return best


def test_a_ratchet_swings_between_walls_as_far_as_the_closed_form_says() -> None:
    """Random upright walls around a head; the ratchet's handle ends in two corners."""
    rng = np.random.default_rng(7)
    tools = BUILT_IN.where("socket 13 (6.3)", "ratchet (6.3)")
    ratchet = BUILT_IN.pieces("ratchet (6.3)")[0]
    length, width = ratchet.length("length"), ratchet.length("width")
    corner, skew = math.hypot(length, 0.5 * width), math.degrees(math.atan2(0.5 * width, length))
    answers = []
    for _ in range(80):
        walls = walls_of(rng)
        parts = {
            f"wall {k}": rotated(box((distance, -0.4, -HEAD), (distance + 0.01, 0.4, 0.4)), direction)
            for k, (distance, direction) in enumerate(walls)
        }
        (row,) = feeler.access(around(parts), tools, head(), threads=1)
        truth = free_swing(walls, corner, skew)
        if truth >= 15.0:
            assert row.is_reachable and truth - 0.01 < row.swing_deg <= truth + 1e-6, (walls, row)
            stroke = 360.0 if truth == 360.0 else 5.0 * math.floor(row.swing_deg / 5.0)
            assert row.stroke_deg == stroke and row.strokes == math.ceil(360.0 / stroke)
            assert row.comes_from == pytest.approx([0.0, 0.0, 1.0])
        else:
            assert not row.is_reachable and row.strokes is None and row.blockers
        answers.append(truth)
    narrow = [truth for truth in answers if 15.0 <= truth < 60.0]
    assert len(narrow) > 8 and min(answers) < 15.0


def test_the_shortest_extension_that_stands_out_of_a_well_is_chosen() -> None:
    """A head at the bottom of a well: of each chain it is known how high its first wide piece is."""
    rng = np.random.default_rng(3)
    chosen = set()
    for high in rng.uniform(0.0, 0.38, 14):
        bore = 0.0135
        well = lathed([disc(bore, -HEAD), disc(0.1, -HEAD), disc(0.1, high), disc(bore, high)], is_ring=True)
        (row,) = feeler.access(around({"well": well}), BUILT_IN, head(), approach=0.5, threads=1)
        fitting = [c for c in BUILT_IN.fitting("hexagon", FLATS, 0.008) if c[0].kind == "socket"]
        for chain in fitting:
            depth = min(HEAD - 2e-4, chain[0].length("depth"))
            wide = max(chain[0].length("outer"), chain[0].length("body"), *(e.length("end") for e in chain[1:-1]))
            top = -depth + chain[0].length("length") + sum(each.size for each in chain[1:-1])
            if chain[-1].kind == "driver":
                top += chain[-1].length("reach")
            elif chain[-1].length("head") < 2.0 * bore / 1.01:
                top += chain[-1].length("height") - chain[-1].length("thick")
            if wide < 2.0 * bore / 1.01 and top > high:
                break
        assert row.is_reachable and row.tool == " + ".join(each.name for each in chain), (high, row)
        assert all(each.because and each.blockers for each in row.tried)
        chosen.add(row.tool)
    assert len(chosen) > 5


def test_a_glove_takes_what_the_closed_form_says() -> None:
    """A bar with a hand at its end, beside a wall: its corners keep the clearance."""
    bar = feeler.Tool(*box((0.0, -0.004, 0.02), (0.1, 0.004, 0.03)))
    hand = feeler.Tool(*box((0.06, -0.03, 0.015), (0.1, 0.03, 0.05)), name="hand")
    corner, skew = math.hypot(0.1, 0.03), math.degrees(math.atan2(0.03, 0.1))
    for distance in (0.07, 0.09, 0.103):
        scene = around({"wall": box((distance, -0.4, -HEAD), (0.2, 0.4, 0.4))})
        for clearance in (0.0, 0.002, 0.01):
            (row,) = feeler.access(scene, bar, head(), 30.0, 12, hand, clearance=clearance, threads=1)
            least = distance - clearance
            truth = free_swing([(least, 0.0)], corner, skew)
            assert truth - 0.15 < row.swing_deg <= truth + 1e-6 and row.is_reachable
    tight = feeler.access(scene, bar, head(), 30.0, 12, hand, clearance=0.2, threads=1)
    assert not tight[0].is_reachable and "200 mm around the hand" in tight[0].because


def test_a_glove_has_room_on_the_way_too() -> None:
    """A bar with a hand in a well, whose mouth is narrower than its bottom."""
    bar = feeler.Tool(*box((0.0, -0.004, 0.0), (0.06, 0.004, 0.004)))
    hand = feeler.Tool(*box((0.03, -0.004, 0.001), (0.06, 0.004, 0.004)))
    corner = math.hypot(0.06, 0.004)
    levels = [(corner + 0.007, -HEAD), (0.2, -HEAD), (0.2, 0.06), (corner + 0.002, 0.06), (corner + 0.002, 0.05)]
    rings = [disc(radius, z) for radius, z in [*levels, (corner + 0.007, 0.05)]]
    scene = around({"well": lathed(rings, is_ring=True)})
    reach = [feeler.access(scene, bar, head(), 90.0, 12, hand, clearance=gap, threads=1)[0] for gap in (0.001, 0.003)]
    assert [row.is_reachable for row in reach] == [True, False]
    assert [row.swing_deg for row in reach] == [360.0, 360.0] and reach[1].blockers[0].path == "well"


def test_a_hand_at_the_grip_needs_room_that_the_tool_does_not() -> None:
    tools = BUILT_IN.where("socket 13 (6.3)", "ratchet (6.3)")
    roof = {
        "shelf": box((0.02, -0.4, 0.012), (0.4, 0.4, 0.016)),
        "other": box((-0.4, -0.4, 0.012), (-0.02, 0.4, 0.016)),
    }
    scene = around(roof)
    (bare,) = feeler.access(scene, tools, head(), threads=1)
    (held,) = feeler.access(scene, tools, head(), hand=BUILT_IN.hand, threads=1)
    assert bare.is_reachable and not held.is_reachable
    assert {each.path for each in held.blockers} <= {"shelf", "other", "plate"}
    (far,) = feeler.access(around({}), tools, head(), hand=BUILT_IN.hand, threads=1)
    assert far.is_reachable and far.swing_deg == 360.0


def test_a_ring_does_not_come_off_along_a_pipe_but_an_open_spanner_does() -> None:
    pipe = lathed([disc(0.004, -0.01), disc(0.004, 0.6)])
    scene = around({"pipe": pipe})
    (ring,) = feeler.access(scene, BUILT_IN.where("ring"), head(kind="nut", length=HEAD), threads=1)
    assert not ring.is_reachable and ring.swing_deg == 360.0 and ring.blockers[0].path == "pipe"
    (row,) = feeler.access(scene, BUILT_IN, head(kind="nut", length=HEAD), threads=1)
    assert row.is_reachable and row.tool == "open 13" and abs(row.comes_from[2]) < 1e-9
    assert {BUILT_IN.pieces(each.tool)[0].kind for each in row.tried} == {"socket", "ring"}


def test_an_open_spanner_comes_off_along_the_flats_at_any_turn_of_the_head() -> None:
    """A roof leaves no way up, and the jaw passes the corners only where it is on the flats."""
    roof = {"roof": box((-0.3, -0.3, 0.001), (0.3, 0.3, 0.01)), "wall": box((-0.3, 0.04, -HEAD), (0.3, 0.05, 0.001))}
    for degrees in np.random.default_rng(4).uniform(0.0, 60.0, 6):
        scene = around(roof, rotated(prism(HEXAGON, -HEAD, 0.0), degrees))
        (row,) = feeler.access(scene, BUILT_IN, head(), threads=1)
        assert row.is_reachable and row.tool == "open 13" and abs(row.comes_from[2]) < 1e-9, degrees
        assert scene.cast(BUILT_IN.tool(row.tool), row.way[1], row.way[0], touching="free") is None


def test_parts_beyond_the_room_of_a_fastener_have_no_influence() -> None:
    hand = BUILT_IN.hand
    assert hand is not None
    (bolt,) = head()
    bare, held = room_of(BUILT_IN, bolt, 0.1), room_of(BUILT_IN, bolt, 0.1, (hand, np.eye(4)))
    assert (held[0] <= bare[0]).all() and (held[1] >= bare[1]).all() and (held != bare).any()
    (low, high), reach = bare, []
    for parts in (
        {},
        {"far": box(high + 0.001, high + 1.0), "side": box((high[0] + 1e-3, -1, -1), (high[0] + 1, 1, 1))},
    ):
        reach += list(feeler.access(around(parts), BUILT_IN, head(), threads=1))
    assert low[0] < -0.2 and high[2] > 0.7
    assert (reach[0].tool, reach[0].swing_deg, reach[0].tried) == (reach[1].tool, reach[1].swing_deg, reach[1].tried)


def test_a_plug_on_the_head_keeps_sockets_off() -> None:
    tall = prism(HEXAGON, -HEAD, 0.0), lathed([disc(0.008, 0.0), disc(0.008, 0.05)])
    bolt = np.concatenate([each[0] for each in tall]), np.concatenate([tall[0][1], tall[1][1] + len(tall[0][0])])
    (row,) = feeler.access(around({}, bolt), BUILT_IN, head(), threads=1)
    assert row.tool == "open 13" and "the fastener itself stands 50 mm" in row.tried[0].because


def test_no_tool_fits() -> None:
    scene = around({})
    for facts, words in [
        ({"across_flats": 0.0135}, "13.5 mm across flats; the nearest is"),
        ({"drive": ""}, "does not show its drive"),
        ({"drive": "cross", "size": 0.05, "across_flats": float("nan")}, "a cross on a thread of 50 mm"),
        ({"drive": "pentagon"}, "is for a drive of 'pentagon'"),
        ({"drive": "torx", "across_flats": float("nan"), "width": 0.0136}, "13.6 mm across its points; the nearest is"),
        ({"drive": "slot", "across_flats": float("nan"), "width": 0.008}, "for a slot of 8 mm"),
    ]:
        (row,) = feeler.access(scene, BUILT_IN, head(**facts), threads=1)
        assert not row.is_reachable and row.tool is None and words in row.because and not row.tried
        assert np.isnan(row.comes_from).all()
    with pytest.raises(feeler.OptionError, match=r"give feeler\.Fasteners"):
        feeler.access(scene, BUILT_IN, np.eye(4))
    with pytest.raises(feeler.OptionError, match="know their seat"):
        feeler.access(scene, BUILT_IN, head(), lift=0.01)
    with pytest.raises(feeler.OptionError, match="turns is"):
        feeler.access(scene, BUILT_IN, head(), turns=[1.0, 2.0])


def test_what_is_seen_and_strokes_for_turns() -> None:
    scene = around({"roof": box((-0.3, -0.3, 0.4), (0.3, 0.3, 0.41))})
    above, hidden = [[0.0, 0.0, 0.3]], [[0.0, 0.0, 0.5]]
    (row,) = feeler.access(scene, BUILT_IN, head(), eyes=above, turns=12.5, threads=1)
    assert row.seen == 1.0 and row.strokes == 13 and row.stroke_deg == 360.0
    assert feeler.access(scene, BUILT_IN, head(), eyes=hidden)[0].seen == 0.0
    assert math.isnan(feeler.access(scene, BUILT_IN, head())[0].seen)


def test_tools_of_the_truth_are_found_on_the_gearbox(gearbox: Any) -> None:
    """For each fastener, with what goes before out; and casts along the way and around say so, too."""
    found = {row.path: row for row in feeler.find_fasteners(gearbox.mockup)}
    for fastener in gearbox.truth.fasteners[::3]:
        step = next(step for step in gearbox.truth.steps if fastener.path in step.parts)  # where it is loosened
        scene = gearbox.scene.without(gearbox.out(step))
        tools = BUILT_IN.where("open") if fastener.tool == "open-end wrench" else BUILT_IN
        (row,) = feeler.access(scene, tools, feeler.Fasteners([found[fastener.path]]), threads=1)
        assert row.is_reachable, (fastener.path, row.because)
        pieces = BUILT_IN.pieces(str(row.tool))
        assert pieces[0].kind in KINDS[fastener.tool] and pieces[0].size == pytest.approx(fastener.size_m, rel=0.01)
        tool = BUILT_IN.tool(str(row.tool))
        ignore = [("*", fastener.path)]
        for start, end in zip(row.way[:-1], row.way[1:], strict=True):
            assert scene.cast(tool, start, end, touching="free", ignore=ignore) is None
        axis, top = found[fastener.path].axis, found[fastener.path].frame[:3, 3]
        for share in (-0.499, 0.499):
            screw = feeler.Screw(axis, top, np.radians(share * row.swing_deg))
            assert scene.cast(tool, row.pose, screw=screw, ignore=ignore) is None
        assert row.swing_deg >= pieces[-1].swing_deg


def test_no_tool_reaches_the_bolt_under_the_planted_guard(faulty_gearbox: Any) -> None:
    bolt, *guards = faulty_gearbox.fault["blocked_bolt"].parts
    scene = faulty_gearbox.scene.without(faulty_gearbox.out(faulty_gearbox.step(bolt)))
    targets = feeler.find_fasteners(faulty_gearbox.mockup, bolt)
    straight = feeler.access(scene, BUILT_IN.where("socket", "extension", "ratchet", "driver", "ring"), targets)[0]
    every = feeler.access(scene, BUILT_IN, targets)[0]  # open spanners, too
    held = feeler.access(scene, BUILT_IN, targets, hand=BUILT_IN.hand)[0]
    for row in (straight, every, held):
        assert not row.is_reachable and {each.path for each in row.blockers} & {*guards}
        assert "none of the" in row.because and len(row.tried) > 2
    (free,) = feeler.access(scene.without(guards), BUILT_IN, targets, threads=1)
    assert free.is_reachable


def test_any_threads_one_answer_in_order(gearbox: Any) -> None:
    targets = feeler.find_fasteners(gearbox.mockup)[::9]
    one = feeler.access(gearbox.scene, BUILT_IN, targets, threads=1)
    other = feeler.access(gearbox.scene, pickle.loads(pickle.dumps(BUILT_IN)), targets, threads=3)
    keys = [
        [(r.path, r.tool, r.swing_deg, r.because, r.tried, r.pose.tobytes()) for r in rows] for rows in (one, other)
    ]
    assert keys[0] == keys[1]
    assert sum(one.tools.values()) == one.is_reachable.sum()


def test_names_lead_to_tools() -> None:
    chain = "socket 10 (6.3) + extension 100 (6.3) + ratchet (6.3)"
    tool = BUILT_IN.tool(chain)
    assert tool.name == chain and tool.part_names[0] == "socket" and tool.part_names[-1] == "grip"
    with pytest.raises(feeler.OptionError, match="has no 'socket 1000'"):
        BUILT_IN.tool("socket 1000 + ratchet (6.3)")
    with pytest.raises(feeler.OptionError, match="no tool of the catalogue is"):
        BUILT_IN.where("hammer")
    assert {row.kind for row in BUILT_IN.where("ring", "open")} == {"ring", "open"}


def test_the_users_file_is_read(tmp_path: Path) -> None:
    own = tmp_path / "own.toml"
    own.write_text(built_in_text())
    assert feeler.catalogue(own) == BUILT_IN and hash(feeler.catalogue(own)) == hash(BUILT_IN)
    text = "version = 1\n[[open]]\nsizes_mm = [13, 17]\nwidth_mm = [28, 36]\n"
    text += "thick_mm = 5\nlength_mm = 150\nshaft_mm = 10\n"
    own.write_text(text)
    mine = feeler.catalogue(own)
    assert [row.name for row in mine] == ["open 13", "open 17"] and mine.hand is None
    usual = "socket 13 (6.3) + ratchet (6.3)"
    for tools, chosen in ((mine, "open 13"), (own, "open 13"), ("catalogue", usual), ("built-in", usual)):
        assert feeler.access(around({}), tools, head())[0].tool == chosen
    for wrong, words in [
        (text.replace("version = 1", "version = 2"), "version is 2"),
        (text.replace("[[open]]", "[[opne]]"), "'opne' is unknown"),
        (text.replace("width_mm = [28, 36]", "width_mm = [28]"), "1 numbers for 2 sizes"),
        (text.replace("width_mm = [28, 36]", "width_mm = [28, 17]"), "leaves no wall"),
        (text.replace("thick_mm = 5", "thick_mm = -5"), "thick_mm is -5"),
        (text.replace("thick_mm = 5", ""), "thick_mm is None"),
        (text.replace("[13, 17]", "[13, 13]"), "two tools of the catalogue are named 'open 13'"),
        (text.replace("[13, 17]", "13"), "give a list of numbers"),
        (text.replace("[[open]]", "[open]"), "begin each with"),
        ("version = 1\n", "there is no tool"),
        (text + "[hand]\nwidth_mm = 3\n", "give width_mm, depth_mm, height_mm"),
        ("version = ", "not valid TOML"),
    ]:
        own.write_text(wrong)
        with pytest.raises(feeler.LoadError, match=words):
            feeler.catalogue(own)
    with pytest.raises(feeler.MissingFileError, match="write-catalogue"):
        feeler.catalogue(tmp_path / "none.toml")


@pytest.mark.parametrize(
    ("drive", "widths_mm"),
    [
        ("hexagon socket", (0.7, 0.9, 1.3, 1.5, 2, 2.5, 3, 4, 5, 6, 8, 10, 12, 14, 17, 19, 22, 24, 27, 32, 36, 41, 46)),
        ("hexagon", (3.2, 4, 5, 5.5, 6, 7, 8, 10, 13, 16, 17, 18, 19, 21, 22, 24, 27, 30, 32, 34, 36, 41, 46, 50, 55)),
    ],
)
def test_the_built_in_one_has_a_tool_for_each_standard_width(drive: str, widths_mm: tuple[float, ...]) -> None:
    for width in widths_mm:
        found = BUILT_IN.fitting(drive, 1e-3 * width, 1e-3 * width)
        assert found, width
        assert all(
            Chosen(BUILT_IN, SeatSearch(60.0, 4, 0.1, 0.0), None, None).seated(pieces).tool for pieces in found[:3]
        )


@pytest.mark.parametrize(("drive", "most_mm"), [("torx socket", 24.0), ("cross", 12.0), ("slot", 12.0)])
def test_the_built_in_one_has_a_tool_for_each_thread(drive: str, most_mm: float) -> None:
    for size in np.arange(1.6, most_mm, 0.1):
        assert BUILT_IN.fitting(drive, math.nan, 1e-3 * size), size
