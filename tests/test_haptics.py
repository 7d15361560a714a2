"""Sessions from Python: the names of the issue, what comes of them, records, grips, and what is no input."""

from __future__ import annotations

import json
from pathlib import Path

import numpy as np
import pytest
from shapes import box

import feeler
from feeler import haptics
from feeler.errors import LoadError, OptionError, PoseError, SessionError


def at(x: float = 0.0, y: float = 0.0, z: float = 0.0) -> np.ndarray:
    pose = np.eye(4)
    pose[:3, 3] = x, y, z
    return pose


@pytest.fixture
def scene() -> feeler.Scene:
    """A plate, and a block that stands on it 0.1 m off."""
    plate, block = box((-0.2, -0.2, -0.02), (0.2, 0.2, 0.0)), box((0.08, -0.02, 0.0), (0.12, 0.02, 0.04))
    vertices = np.concatenate([plate[0], block[0]])
    faces = np.concatenate([plate[1], block[1] + len(plate[0])])
    return feeler.Scene(feeler.Mockup(vertices, faces, np.repeat([0, 1], 12), ["plate", "block"]))


@pytest.fixture
def tool() -> feeler.Tool:
    return feeler.Tool(*box((-0.01, -0.01, 0.0), (0.01, 0.01, 0.05)), "pad")


def pressed(session: haptics.Session, depth: float, x: float = 0.0, floor: float = 0.0) -> haptics.Step:
    """Down from 2 mm over a floor to a depth, and held there."""
    for k in range(400):
        step = session.step(at(x, 0.0, floor + 0.002 - (depth + 0.002) * min(1.0, k / 200)))
    return step


def test_a_step_says_where_the_proxy_is_and_what_the_hand_feels(scene: feeler.Scene, tool: feeler.Tool) -> None:
    session = haptics.Session(scene, tool)
    assert session.start(at(z=0.002)) and session.gripped == ()
    step = pressed(session, 0.003)
    assert step.mode == "contact" and step.age == 0.0
    np.testing.assert_allclose(step.world_from_proxy, at(z=2e-5), atol=1e-9)
    np.testing.assert_allclose(step.force, [0, 0, 1000 * 0.00302], atol=1e-3)
    assert step.torque.shape == (3,) and np.abs(step.torque).max() < 1e-6
    assert len(step.planes) == 1 and step.planes.is_holding.tolist() == [True]
    np.testing.assert_allclose(step.planes.normals, [[0, 0, 1]], atol=1e-12)
    assert scene.mockup.parts[int(step.planes.parts[0])].name == "plate"
    assert not scene.is_colliding(tool, step.world_from_proxy)
    # Free again, and nothing is felt.
    for k in range(300):
        step = session.step(at(z=-0.003 + 0.0001 * min(k, 200)))
    assert step.mode == "free" and not step.force.any()


def test_the_coupling_is_what_is_felt(scene: feeler.Scene, tool: feeler.Tool) -> None:
    soft = haptics.Session(scene, tool, coupling=haptics.Coupling(stiffness_n_per_m=200.0, max_force_n=0.5), skin=1e-5)
    soft.start(at(z=0.002))
    assert pressed(soft, 0.002).force[2] == pytest.approx(200 * 0.00201, abs=1e-4)
    soft.start(at(z=0.002))
    assert pressed(soft, 0.02).force[2] == pytest.approx(0.5, abs=1e-9)


@pytest.mark.parametrize("off", [0.0, 0.3, 3.0, 3000.0])
def test_a_part_in_its_own_place_is_felt_alike_at_any_distance_from_the_origin(off: float) -> None:
    plate = box((off - 0.1, -0.1, -0.02), (off + 0.1, 0.1, 0.0))
    block = box((off - 0.01, -0.01, 0.001), (off + 0.01, 0.01, 0.021))
    vertices, faces = np.concatenate([plate[0], block[0]]), np.concatenate([plate[1], block[1] + len(plate[0])])
    mockup = feeler.Mockup(vertices, faces, np.repeat([0, 1], 12), ["plate", "block"])
    session = haptics.Session(feeler.Scene(mockup).without("block"), feeler.Tool.of_parts(mockup, ["block"]))
    assert session.start(np.eye(4))
    for k in range(400):
        step = session.step(at(z=-0.006 * min(1.0, k / 200)))
    np.testing.assert_allclose(step.force, [0.0, 0.0, 5.02], rtol=1e-6, atol=1e-6)
    np.testing.assert_allclose(step.torque, 0.0, atol=1e-6)


def test_contacts_may_be_found_more_seldom(scene: feeler.Scene, tool: feeler.Tool) -> None:
    session = haptics.Session(scene, tool, collision_hz=100)
    session.start(at(z=0.002))
    ages = [session.step(at(z=0.002 - 0.0001 * k)).age for k in range(40)]
    assert ages[:11] == pytest.approx([*(0.001 * k for k in range(10)), 0.0])


def test_the_same_steps_give_the_same_bits(scene: feeler.Scene, tool: feeler.Tool, tmp_path: Path) -> None:
    session = haptics.Session(scene, tool, collision_hz=300, within=0.001)
    path = tmp_path / "felt.npz"
    with session.record(path):
        session.start(at(z=0.05))
        for k in range(300):
            session.step(at(0.0004 * k, 0.0, 0.05 - 0.0003 * min(k, 170)))
        session.start(at(0.1, 0.0, 0.045))
        session.grip("block")
        for k in range(100):
            session.step(at(0.1, 0.0, 0.045 + 0.0005 * k))
        session.release()
        session.step(np.full((4, 4), np.nan))
    same = haptics.replay(path)
    assert same and same.steps == 401 and same.at is None
    assert haptics.replay(path, scene, tool)
    # Another session is told apart, and where.
    with np.load(path) as file:
        arrays = dict(file)
    arrays["outputs"][123, 14] = np.nextafter(arrays["outputs"][123, 14], np.inf)
    np.savez(path, **arrays)
    parted = haptics.replay(path)
    assert not parted and parted.at == 123 and 0 < parted.by < 1e-12
    with pytest.raises(LoadError, match="another tool"):
        haptics.replay(path, scene, feeler.sample_tool("wrench"))
    for content in (b"", b"PK\x03\x04 no", b"\x93NUMPY"):
        bad = tmp_path / "bad.npz"
        bad.write_bytes(content)
        with pytest.raises(LoadError, match="record"):
            haptics.replay(bad)
    with pytest.raises(LoadError, match="does not exist"):
        haptics.replay(tmp_path / "none.npz")


@pytest.mark.parametrize("rate", [None, 300.0])
def test_a_record_of_a_session_that_is_started_waits_for_a_start(
    scene: feeler.Scene, tool: feeler.Tool, tmp_path: Path, rate: float | None
) -> None:
    session, path = haptics.Session(scene, tool, collision_hz=rate), tmp_path / "felt.npz"
    session.start(at(z=0.002))
    pressed(session, 0.003)
    with session.record(path):
        for refused in (lambda: session.step(at(z=0.03)), lambda: session.grip("block"), session.release):
            with pytest.raises(feeler.SessionError, match=r"begins with a start: call start\(\)"):
                refused()
        session.start(at(z=0.03))
        for k in range(200):
            session.step(at(0.0002 * k, 0.0, 0.03 - 0.0001 * k))
    same = haptics.replay(path)
    assert same and same.steps == 200


def test_one_record_at_a_time_of_parts_in_their_places(scene: feeler.Scene, tool: feeler.Tool, tmp_path: Path) -> None:
    session = haptics.Session(scene, tool)
    with session.record(tmp_path / "one.npz"):
        with pytest.raises(feeler.SessionError, match=r"a record into 'one\.npz' is open"):
            session.record(tmp_path / "two.npz")
        session.start(at(0.1, 0.0, 0.045))
        session.grip("block")
    session.release()
    for held in (False, True):
        if held:
            session.grip("block")
        with pytest.raises(feeler.SessionError, match="'block' left its place before the record: put it back"):
            session.record(tmp_path / "late.npz")
    session.release(put_back=True)
    with session.record(tmp_path / "late.npz"):
        session.start(at(0.1, 0.0, 0.045))
        session.step(at(0.1, 0.0, 0.044))
    assert haptics.replay(tmp_path / "late.npz").steps == 1


def test_a_replay_puts_a_part_back_where_it_was(scene: feeler.Scene, tool: feeler.Tool, tmp_path: Path) -> None:
    session, path = haptics.Session(scene, tool), tmp_path / "felt.npz"
    with session.record(path):
        session.start(at(0.1, 0.0, 0.042))
        session.grip("block")
        for k in range(200):
            session.step(at(0.1 - 0.001 * k, 0.0, 0.06))
        session.release(put_back=True)
        # Nothing lies where it was let go, and it stands in its place.
        assert pressed(session, 0.003, x=-0.1, floor=0.04).mode == "free"
        session.start(at(0.1, 0.0, 0.042))
        assert pressed(session, 0.003, x=0.1, floor=0.04).mode == "contact"
    same = haptics.replay(path)
    assert same and same.steps == 1000


def test_shading_is_an_option_that_records_keep(tool: feeler.Tool, tmp_path: Path) -> None:
    # Askew on a tube of 24 facets the force is that of the smooth surface. A record from before it replays without.
    angle = np.arange(24) * (2 * np.pi / 24)
    ring = np.stack([0 * angle, 0.05 * np.sin(angle), 0.05 * np.cos(angle)], axis=1)
    end = np.array([0.2, 0.0, 0.0])
    k, after = np.arange(24), (np.arange(24) + 1) % 24
    faces = np.concatenate([np.stack([k, k + 24, after], 1), np.stack([after, k + 24, after + 24], 1)])
    scene = feeler.Scene(feeler.Mockup(np.concatenate([ring - end, ring + end]), faces))
    ends = []
    for shading in (True, False):
        path = tmp_path / f"{shading}.npz"
        session = haptics.Session(scene, tool, shading=shading)
        with session.record(path):
            session.start(at(z=0.1))
            ends += [[session.step(at(y=0.004, z=z)) for z in np.linspace(0.1, 0.05, 400)][-1]]
        assert haptics.replay(path)
    shaded, bare = ends
    assert np.array_equal(shaded.world_from_proxy, bare.world_from_proxy)
    assert not np.allclose(shaded.force, bare.force, rtol=0.01)
    with np.load(tmp_path / "False.npz") as file:
        arrays = dict(file)
    head = json.loads(str(arrays["head"]))
    del head["options"]["shading"]
    np.savez(tmp_path / "old.npz", **{**arrays, "head": np.array(json.dumps(head))})
    assert haptics.replay(tmp_path / "old.npz")


def test_large_meshes_are_not_in_a_record(tool: feeler.Tool, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("feeler.haptics.record.KEPT_TRIANGLES", 20)
    scene = feeler.Scene(feeler.Mockup(*box((-1, -1, -1), (1, 1, 0))))
    session = haptics.Session(scene, tool)
    with session.record(tmp_path / "felt.npz"):
        session.start(at(z=0.01))
        session.step(at(z=-0.01))
    with pytest.raises(LoadError, match="pass the scene and the tool"):
        haptics.replay(tmp_path / "felt.npz")
    assert haptics.replay(tmp_path / "felt.npz", scene, tool)


def test_a_gripped_part_moves_with_the_tool(scene: feeler.Scene, tool: feeler.Tool) -> None:
    session = haptics.Session(scene, tool)
    session.start(at(0.1, 0.0, 0.0402))
    for k in range(300):
        before = session.step(at(0.1, 0.0, 0.0402 - 0.000005 * k))
    session.grip("block")
    after = session.step(at(0.1, 0.0, 0.0402 - 0.000005 * 299))
    assert session.gripped == (1,) and np.abs(after.force - before.force).max() < 0.02 * np.abs(before.force).max()
    for k in range(400):
        step = session.step(at(0.1 - 0.0002 * k, 0.0, 0.06))
    assert step.mode == "free"
    session.release()
    # Where it was is nothing now, where it is it is felt.
    session.start(at(0.1, 0.0, 0.002))
    assert pressed(session, 0.003, x=0.1).mode == "contact"
    with pytest.raises(SessionError, match="holds no part"):
        session.release()
    session.start(at(0.02, 0.0, 0.11))
    assert pressed(session, 0.003, x=0.02, floor=0.0588).force[2] > 2.0
    session.grip(1)
    session.release(put_back=True)
    assert session.gripped == ()
    with pytest.raises(OptionError, match="no part"):
        session.grip("bolt")
    with pytest.raises(OptionError, match="names 2 parts"):
        session.grip("*")


def lying(shift: float) -> feeler.Scene:
    """The block alone, moved along x."""
    vertices, faces = box((0.08 + shift, -0.02, 0.0), (0.12 + shift, 0.02, 0.04))
    return feeler.Scene(feeler.Mockup(vertices, faces, part_names=["block"]))


def test_a_part_that_lies_elsewhere_is_felt_there_as_in_its_place(scene: feeler.Scene, tool: feeler.Tool) -> None:
    in_place = haptics.Session(scene, tool)
    in_place.start(at(0.1, 0.0, 0.042))
    expected = pressed(in_place, 0.003, x=0.1, floor=0.04)
    session = haptics.Session(scene, tool, put_down={"block": lying(-0.25)})
    session.start(at(-0.15, 0.0, 0.042))
    found = pressed(session, 0.003, x=-0.15, floor=0.04)
    assert found.mode == "contact" and found.planes.parts.tolist() == [1]
    np.testing.assert_allclose(found.force, expected.force, atol=1e-6)
    np.testing.assert_allclose(found.world_from_proxy, at(-0.25) @ expected.world_from_proxy, atol=1e-9)
    # Along it, and over its border.
    for k in range(100):
        along = session.step(at(-0.15 + 0.0001 * k, 0.0, 0.037))
    assert along.mode == "contact" and along.world_from_proxy[0, 3] == pytest.approx(-0.1401, abs=1e-4)
    assert along.force[2] == pytest.approx(expected.force[2], rel=1e-2)
    # It is not where it was; and it is where it lies after another scene, and when it was taken from there.
    assert session.start(at(0.1, 0.0, 0.01))
    assert not session.start(at(-0.15, 0.0, 0.035)) and not session.set_scene(scene.without("block"))
    way_out = session.start(at(-0.15, 0.0, 0.035)).way_out
    np.testing.assert_allclose(way_out, [0.0, 0.0, 0.005], atol=1e-6)
    session.start(at(-0.15, 0.0, 0.0402))
    session.grip("block")
    assert session.gripped == (1,)
    with pytest.raises(SessionError, match="part 1 has no place"):
        session.release(put_back=True)
    session.release()
    with pytest.raises(OptionError, match="no part"):
        haptics.Session(scene, tool, put_down={"bolt": lying(0.0)})
    with pytest.raises(SessionError, match="part 1 is put down twice, or as a scene of 2 parts"):
        haptics.Session(scene, tool, put_down={1: scene})
    with pytest.raises(OptionError, match=r"put_down has a Mockup for part 1: pass a feeler.Scene"):
        haptics.Session(scene, tool, put_down={1: lying(0.0).mockup})  # type: ignore[dict-item]
    with pytest.raises(OptionError):
        session.set_scene(lying(0.0))
    assert session.scene.mockup is scene.mockup


def test_a_record_has_the_parts_that_lay_elsewhere(
    scene: feeler.Scene, tool: feeler.Tool, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    path, large = tmp_path / "felt.npz", tmp_path / "large.npz"
    for file, most in ((path, 1000), (large, 10)):
        monkeypatch.setattr("feeler.haptics.record.KEPT_TRIANGLES", most)
        session = haptics.Session(scene, tool, put_down={1: lying(-0.25)})
        with session.record(file):
            session.start(at(-0.15, 0.0, 0.042))
            assert pressed(session, 0.003, x=-0.15, floor=0.04).mode == "contact"
            session.grip(1)
            session.step(at(-0.15, 0.0, 0.05))
    assert haptics.replay(path) and haptics.replay(path, scene, tool)
    assert haptics.replay(large, scene, tool, {1: lying(-0.25)})
    assert haptics.replay(large, scene, tool, {"block": lying(-0.25)})
    with pytest.raises(LoadError, match="pass put_down"):
        haptics.replay(large, scene, tool)
    for other in ({1: lying(-0.2)}, {}, {0: lying(-0.25)}):
        with pytest.raises(LoadError, match=r"other parts put down elsewhere: it has parts \[1\]"):
            haptics.replay(path, scene, tool, other)
    # What is older knows nothing of it; what is newer is not guessed at.
    monkeypatch.undo()
    plain = haptics.Session(scene, tool)
    with plain.record(path):
        plain.start(at(z=0.002))
        plain.step(at())
    with np.load(path) as file:
        arrays = dict(file)
    head = json.loads(str(arrays["head"]))
    del head["put_down"]
    for number in (1, 2, 3, 4):
        arrays["head"] = np.array(json.dumps({**head, "format": number}))
        np.savez(path, **arrays)
        if number < 4:
            assert haptics.replay(path)
        else:
            with pytest.raises(LoadError, match="format 4, this feeler reads 3"):
                haptics.replay(path)


def test_a_deep_start_is_sunk_and_shows_the_way_out(scene: feeler.Scene, tool: feeler.Tool) -> None:
    session = haptics.Session(scene, tool)
    start = session.start(at(z=-0.005))
    assert not start and start.way_out is not None
    np.testing.assert_allclose(start.way_out, [0, 0, 0.005], atol=1e-6)
    assert [seat.kind for seat in start.seats] == ["sunk"] and not start.is_free
    # Deeper it does not go; up it does, and is kept out from then on.
    pressed = [session.step(at(z=-0.008)) for _ in range(50)][-1]
    assert pressed.world_from_proxy[2, 3] > -0.005 - 2e-5 and pressed.force[2] > 1.0
    for z in (0.001, -0.005):
        last = [session.step(at(z=z)) for _ in range(100)][-1]
    assert last.world_from_proxy[2, 3] == pytest.approx(2e-5, abs=1e-6)


def test_a_start_that_touches_is_a_seat(scene: feeler.Scene, tool: feeler.Tool) -> None:
    session = haptics.Session(scene, tool)
    start = session.start(at())
    assert start and not start.is_free and start.way_out is None
    assert [(seat.part, seat.tool_part, seat.kind, seat.depth) for seat in start.seats] == [(0, 0, "touching", 0.0)]
    assert session.step(at(z=-0.001)).force[2] > 0.1
    last = [session.step(at(z=0.001)) for _ in range(50)][-1]
    assert last.world_from_proxy[2, 3] == pytest.approx(0.001, abs=1e-9) and not last.force.any()


def test_several_parts_are_gripped_as_one(scene: feeler.Scene, tool: feeler.Tool, tmp_path: Path) -> None:
    session = haptics.Session(scene, tool)
    path = tmp_path / "grips.npz"
    with session.record(path):
        session.start(at(z=0.1))
        with pytest.raises(OptionError, match="no part"):
            session.grip([])
        with pytest.raises(OptionError, match="twice"):
            session.grip([1, 1])
        session.grip([0, 1])
        assert session.gripped == (0, 1)
        session.step(at(z=0.101))
        session.release()
        assert session.gripped == () and session.step(at(z=0.102)).mode == "free"
    assert haptics.replay(path, scene, tool)


def test_what_a_device_may_tell_lets_go_and_what_a_program_may_pass_is_an_error(
    scene: feeler.Scene, tool: feeler.Tool
) -> None:
    session = haptics.Session(scene, tool)
    with pytest.raises(SessionError, match="start"):
        session.step(at())
    with pytest.raises(SessionError, match="start"):
        session.grip(1)
    with pytest.raises(PoseError):
        session.start(np.diag([2.0, 1.0, 1.0, 1.0]))
    session.start(at(z=0.002))
    assert pressed(session, 0.003).force[2] > 2.0
    odd = [np.full((4, 4), np.nan), np.zeros((4, 4)), np.diag([1.0, 1.0, -1.0, 1.0]), 1e300 * np.eye(4)]
    odd.append(at(x=np.inf))
    for pose in odd:
        step = session.step(pose)
        assert step.mode == "doubt" and not step.force.any() and not step.torque.any()
        np.testing.assert_allclose(step.world_from_proxy, at(z=2e-5), atol=1e-9)
    for pose in (np.eye(3), [1.0, 2.0], at()[None]):
        with pytest.raises(PoseError, match="shape"):
            session.step(pose)
    for dt in (0.0, -0.001, np.nan, np.inf, 1.5):
        with pytest.raises(OptionError, match="dt"):
            session.step(at(), dt)
    # A jump through all of it: no more than the bound, and the proxy stays on its side.
    for _ in range(300):
        step = session.step(at(z=-1.0))
        assert np.linalg.norm(step.force) <= 8.0 + 1e-9 and step.world_from_proxy[2, 3] > 0.0
    options = [
        {"within": 0.0},
        {"within": np.nan},
        {"skin": -1e-5},
        {"skin": 0.001},
        {"collision_hz": 0.0},
        {"coupling": 3},
    ]
    for wrong in options:
        with pytest.raises(OptionError):
            haptics.Session(scene, tool, **wrong)
    for value in (-1.0, np.nan, "abc"):
        with pytest.raises(OptionError, match="max_force_n"):
            haptics.Coupling(max_force_n=value)  # type: ignore[arg-type]
    with pytest.raises(OptionError, match="slew_n_per_s"):
        haptics.Coupling(slew_n_per_s=0.0)
    with pytest.raises(OptionError, match=r"feeler\.Scene"):
        haptics.Session(scene.mockup, tool)  # type: ignore[arg-type]


def test_old_keywords_answer(scene: feeler.Scene, tool: feeler.Tool) -> None:
    with pytest.warns(DeprecationWarning, match="within"):
        session = haptics.Session(scene, tool, margin=0.001)  # type: ignore[call-arg]
    session.start(at(z=0.01))
    with pytest.warns(DeprecationWarning, match="world_from_tool"):
        session.step(world_from_device=at(z=0.01))  # type: ignore[call-arg]
    with pytest.raises(feeler.SessionError, match="holds"):
        session.release(put_back=0)


def test_a_replay_of_a_folder_is_refused_in_words(tmp_path: Path) -> None:
    with pytest.raises(feeler.LoadError, match=r"give a file that Session\.record wrote"):
        feeler.haptics.replay(tmp_path)
