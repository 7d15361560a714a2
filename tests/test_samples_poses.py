"""Sample poses and motions: what each kind promises, on sample and hand-made mock-ups."""

import numpy as np
import pytest

import feeler
from feeler import samples


@pytest.fixture(scope="module")
def engine():
    return feeler.Scene(samples.sample("engine", 60_000))


def share(scene, tool, pose):
    return len(scene.collide(tool, pose).tool_triangles) / tool.triangle_count


def assert_rigid(poses):
    rotation = poses[:, :3, :3]
    assert np.abs(rotation @ rotation.transpose(0, 2, 1) - np.eye(3)).max() < 1e-12
    assert np.linalg.det(rotation).min() > 0.0
    assert np.array_equal(poses[:, 3], np.tile([0.0, 0.0, 0.0, 1.0], (len(poses), 1)))


@pytest.mark.parametrize("name", ["torque", "wrench", "square", "hand"])
def test_nominal_poses(engine, name):
    tool = samples.sample_tool(name)
    poses = samples.sample_poses(engine, tool, "nominal", 12)
    assert poses.shape == (12, 4, 4) and poses.dtype == np.float64
    assert_rigid(poses)
    shares = [share(engine, tool, pose) for pose in poses]
    assert min(shares) >= 0.01 and max(shares) <= 0.05


@pytest.mark.parametrize("name", ["torque", "hand"])
def test_near_poses(engine, name):
    tool = samples.sample_tool(name)
    poses = samples.sample_poses(engine, tool, "near", 12)
    assert len(poses) == 12
    assert_rigid(poses)
    low, high = engine.mockup.bounds
    size = float(np.linalg.norm(tool.bounds[1] - tool.bounds[0]))
    pushes = np.concatenate(
        [np.eye(3), -np.eye(3), [v / np.linalg.norm(v) for v in np.random.default_rng(0).normal(size=(40, 3))]]
    )
    for pose in poses:
        assert not engine.is_colliding(tool, pose)
        middle = pose[:3, :3] @ tool.bounds.mean(axis=0) + pose[:3, 3]
        assert (middle >= low).all() and (middle <= high).all()
        pushed = np.repeat(pose[None], len(pushes), axis=0)
        pushed[:, :3, 3] += 0.02 * size * pushes
        assert any(engine.is_colliding(tool, p) for p in pushed)


@pytest.mark.parametrize("name", ["wrench", "hand"])
def test_deep_poses(engine, name):
    tool = samples.sample_tool(name)
    poses = samples.sample_poses(engine, tool, "deep", 12)
    assert len(poses) == 12
    assert_rigid(poses)
    assert min(share(engine, tool, pose) for pose in poses) > 0.10


def test_poses_repeat_and_do_not_depend_on_the_store(engine):
    tool = samples.sample_tool("wrench")
    first = samples.sample_poses(engine, tool, "nominal", 5, seed=4)
    dense = feeler.Scene(engine.mockup, voxel_size=0.05, storage="dense", threads=1)
    assert np.array_equal(first, samples.sample_poses(dense, tool, "nominal", 5, seed=4))
    assert not np.array_equal(first, samples.sample_poses(engine, tool, "nominal", 5, seed=5))


def test_no_poses_are_an_empty_array(engine):
    assert samples.sample_poses(engine, samples.sample_tool("torque"), "near", 0).shape == (0, 4, 4)


def test_progress_is_told(engine):
    seen = []
    samples.sample_poses(engine, samples.sample_tool("torque"), "near", 3, progress=lambda f, s: seen.append((f, s)))
    assert seen[-1][0] == 1.0


@pytest.mark.parametrize(("kind", "n", "seed"), [("far", 3, 0), ("near", -1, 0), ("near", 1.5, 0), ("near", 3, -1)])
def test_bad_options(engine, kind, n, seed):
    with pytest.raises(feeler.OptionError):
        samples.sample_poses(engine, samples.sample_tool("torque"), kind, n, seed)


CUBE = np.array([[x, y, z] for x in (0.0, 1.0) for y in (0.0, 1.0) for z in (0.0, 1.0)])
CUBE_FACES = np.array(
    [
        *([0, 1, 3], [0, 3, 2], [4, 6, 7], [4, 7, 5], [0, 4, 5], [0, 5, 1]),
        *([2, 3, 7], [2, 7, 6], [0, 2, 6], [0, 6, 4], [1, 5, 7], [1, 7, 3]),
    ]
)


def test_a_users_own_box_and_tool():
    scene = feeler.Scene(feeler.Mockup(CUBE, CUBE_FACES))
    tool = feeler.Tool(CUBE * 0.2, CUBE_FACES)
    for kind in ("near", "deep"):
        poses = samples.sample_poses(scene, tool, kind, 4)
        assert [scene.is_colliding(tool, pose) for pose in poses] == [kind == "deep"] * 4


def test_what_cannot_be_found_is_an_error():
    scene = feeler.Scene(feeler.Mockup(CUBE * 1e-4, CUBE_FACES))
    with pytest.raises(feeler.OptionError, match="same unit"):
        samples.sample_poses(scene, samples.sample_tool("hand"), "deep", 5)


def test_defective_triangles_are_never_picked():
    vertices = np.concatenate([CUBE, [[np.nan, 0.0, 0.0]]])
    faces = np.concatenate([CUBE_FACES, np.tile([[0, 1, 8], [0, 0, 1], [0, 1, 99]], (30, 1))])
    scene = feeler.Scene(feeler.Mockup(vertices, faces))
    poses = samples.sample_poses(scene, feeler.Tool(CUBE * 0.2, CUBE_FACES), "near", 4)
    assert poses.shape == (4, 4, 4) and np.isfinite(poses).all()


@pytest.mark.parametrize("name", ["wrench", "hand"])
def test_path(engine, name):
    tool = samples.sample_tool(name)
    poses = samples.sample_path(engine, tool, 400, seed=1)
    assert poses.shape == (400, 4, 4)
    assert_rigid(poses)
    assert np.array_equal(poses, samples.sample_path(engine, tool, 400, seed=1))
    hits = np.array([len(engine.collide(tool, pose).tool_triangles) for pose in poses])
    assert hits[0] == hits[-1] == 0
    assert (hits[130:270] > 0).mean() > 0.2  # it works on something
    low, high = engine.mockup.bounds
    middle = poses[:, :3, :3] @ tool.bounds.mean(axis=0) + poses[:, :3, 3]
    outside = ((middle < low) | (middle > high)).any(axis=1)
    assert outside[0] and outside[-1] and not outside[200]
    steps = np.diff(poses[:, :3, 3], axis=0)
    assert np.linalg.norm(steps, axis=1).max() < 0.06  # no jumps
    turns = np.einsum("nij,nij->n", poses[1:, :3, :3], poses[:-1, :3, :3])
    assert np.arccos(np.clip(0.5 * (turns - 1.0), -1.0, 1.0)).max() < 0.15


def test_path_needs_two_poses(engine):
    with pytest.raises(feeler.OptionError):
        samples.sample_path(engine, samples.sample_tool("wrench"), 1)
    assert samples.sample_path(engine, samples.sample_tool("wrench"), 2).shape == (2, 4, 4)
