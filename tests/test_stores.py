"""All stores give the same pairs: on every sample those of a brute force over all pairs, on large ones each other's."""

from __future__ import annotations

import itertools
import os
from functools import cache
from typing import Any

import numpy as np
import numpy.typing as npt
import oracle
import pytest

import feeler
from feeler.choices import SIMDS

LARGE = bool(os.environ.get("FEELER_LARGE"))
"""As `make exact` runs these: more voxel sizes, and a mock-up four times as large."""
SAMPLES = ["carcass", "differential", "turbine", "externals", "engine", "tay"]
KINDS = ["nominal", "near", "deep"]
STORES: list[dict[str, Any]] = [
    {"storage": "blocks"},
    {"storage": "dense"},
    {"storage": "hashed", "hashing": 0.3},
    {"storage": "hashed", "hashing": 0.95},
]


@cache
def mockup(name: str, triangles: int) -> feeler.Mockup:
    return feeler.sample(name, triangles, seed=1)


@cache
def tool(name: str) -> feeler.Tool:
    return feeler.sample_tool(name)


def poses_of_each_kind(scene: feeler.Scene, tool: feeler.Tool, n: int) -> npt.NDArray[np.float64]:
    return np.concatenate([feeler.sample_poses(scene, tool, kind, n, seed=2) for kind in KINDS])


def as_dict(pairs: npt.NDArray[np.uint32], kinds: npt.NDArray[np.uint8]) -> oracle.Found:
    return {(int(t), int(s)): int(k) for (t, s), k in zip(pairs, kinds, strict=True)}


@pytest.mark.parametrize("name", SAMPLES)
def test_every_sample_against_all_pairs(name: str) -> None:
    """10 thousand triangles; each store, several voxel sizes, one and two threads."""
    static = mockup(name, 10_000)
    moving = tool("torque" if name in ("turbine", "tay") else "wrench")
    poses = poses_of_each_kind(feeler.Scene(static), moving, 2)
    expected = []
    doubts = 0
    for pose in poses:
        pairs, doubtful = oracle.collide_floats(static, moving, pose)
        expected.append(pairs)
        doubts += doubtful
    nominal, near, deep = (sum(map(len, expected[i : i + 2])) for i in (0, 2, 4))
    assert near == 0
    assert nominal > 0 and deep > 0
    assert doubts < 2000, "the floats decide, but for the few cases that are close"

    extent = float(np.ptp(static.bounds, axis=0).max())
    sizes = (None, extent / 150, extent / 20, 2 * extent) if LARGE else (None, extent / 20)
    for store, size, threads in itertools.product(STORES, sizes, (1, 2)):
        what = f"{store}, voxel size {size}, {threads} threads"
        scene = feeler.Scene(static, voxel_size=size, tool=moving, threads=threads, **store)
        batch = scene.collide_batch(moving, poses)
        for i, pairs in enumerate(expected):
            first, last = int(batch.offsets[i]), int(batch.offsets[i + 1])
            assert as_dict(batch.pairs[first:last], batch.kind_codes[first:last]) == pairs, f"{what}, pose {i}"
        if threads == 1:
            scene.validate()
            for pose, pairs in zip(poses, expected, strict=True):
                hit = scene.collide(moving, pose)
                assert as_dict(hit.pairs, hit.kind_codes) == pairs, what
                assert scene.is_colliding(moving, pose) == bool(pairs), what


def test_a_fine_tool_against_all_pairs() -> None:
    """The tool larger than the mock-up: 50 thousand triangles against 10 thousand."""
    static, moving = mockup("differential", 10_000), feeler.sample_tool("wrench", fine=True)
    scene = feeler.Scene(static)
    pose = feeler.sample_poses(scene, moving, "nominal", 1, seed=3)[0]
    # In slices: all pairs at once would be 500 million.
    ids = np.arange(moving.triangle_count)
    expected: oracle.Found = {}
    for part in np.array_split(ids, 50):
        found, _ = oracle.collide_floats(static, (moving.vertices, moving.faces[part]), pose)
        expected.update({(int(part[t]), s): kind for (t, s), kind in found.items()})
    assert expected
    for store in STORES:
        hit = feeler.Scene(static, tool=moving, **store).collide(moving, pose)
        assert as_dict(hit.pairs, hit.kind_codes) == expected


LANES: list[dict[str, Any]] = [{"simd": simd} for simd in SIMDS]


@pytest.mark.parametrize("options", [*STORES, *LANES], ids=str)
def test_a_sample_without_parts_is_one_built_without_them(options: dict[str, Any]) -> None:
    """30 thousand triangles: the index has several levels, and whole nodes of it are out."""
    static, moving = mockup("differential", 30_000), tool("wrench")
    options = {"voxel_size": 0.01, **options}
    try:
        scene = feeler.Scene(static, **options)
    except feeler.OptionError:
        pytest.skip(f"this CPU lacks {options['simd']}")
    poses = poses_of_each_kind(scene, moving, 4)
    hit = np.unique(static.part_of_face[scene.collide_batch(moving, poses).pairs[:, 1]])
    assert len(hit) > 5
    rng = np.random.default_rng(11)
    for share in (0.02, 0.5, 0.95):
        gone = np.flatnonzero(rng.random(static.part_count) < share)
        gone = np.setdiff1d(np.union1d(gone, hit[::2]), hit[1::2])
        left = scene.without(gone)
        left.validate()
        kept = np.flatnonzero(~np.isin(static.part_of_face, gone))
        rest = feeler.Mockup(static.vertices, static.faces[kept], static.part_of_face[kept], static.part_names)
        other = feeler.Scene(rest, **options)
        ours, theirs = left.collide_batch(moving, poses), other.collide_batch(moving, poses)
        assert len(ours.pairs) > 0 and 0 < len(gone) < static.part_count
        assert (
            ours.offsets.tolist() == theirs.offsets.tolist() and ours.kind_codes.tolist() == theirs.kind_codes.tolist()
        )
        assert ours.pairs[:, 1].tolist() == kept[theirs.pairs[:, 1]].tolist()
        unfiltered = left.collide(moving, poses[-1], repeat_filter=False, box_filter=False)
        assert unfiltered.pairs.tolist() == ours[len(poses) - 1].tolist()
        assert [left.is_colliding(moving, pose) for pose in poses] == [len(ours[i]) > 0 for i in range(len(poses))]
        values = left.distance_batch(moving, poses).values
        assert values.tolist() == other.distance_batch(moving, poses).values.tolist()
        rows, expected = (each.clearance_batch(moving, poses, 0.02) for each in (left, other))
        assert rows.offsets.tolist() == expected.offsets.tolist()
        assert rows.distances.tolist() == expected.distances.tolist()
        for pose in poses[::3]:
            planes, expected_planes = left.contacts(moving, pose), other.contacts(moving, pose)
            np.testing.assert_allclose(planes.gaps, expected_planes.gaps, atol=1e-12)
            inside, expected_inside = left.containment(moving, pose), other.containment(moving, pose)
            assert inside.containing_pairs.tolist() == expected_inside.containing_pairs.tolist()
            assert inside.contained_pairs.tolist() == expected_inside.contained_pairs.tolist()
        for start, end in itertools.pairwise(poses[4:8]):  # near ones: nothing meets there
            casts = [each.cast(moving, start, end) for each in (left, other)]
            fractions = [1.0 if cast is None else cast.fraction for cast in casts]
            assert fractions[0] == pytest.approx(fractions[1], abs=1e-4)


@pytest.mark.slow
def test_all_stores_agree_on_a_large_engine() -> None:
    """400 thousand triangles, 100 poses of each kind."""
    static, moving = mockup("engine", 1_600_000 if LARGE else 400_000), tool("wrench")
    blocks = feeler.Scene(static)
    poses = poses_of_each_kind(blocks, moving, 100)
    first = blocks.collide_batch(moving, poses)
    counts = np.diff(first.offsets.astype(np.int64)).reshape(3, 100)
    assert (counts[0] > 0).all() and (counts[1] == 0).all() and (counts[2] > 0).all()
    for store in STORES[1:]:
        batch = feeler.Scene(static, tool=moving, **store).collide_batch(moving, poses)
        assert np.array_equal(batch.offsets, first.offsets), store
        assert np.array_equal(batch.pairs, first.pairs), store
        assert np.array_equal(batch.kind_codes, first.kind_codes), store
    alone = feeler.Scene(static, threads=1).collide_batch(moving, poses)
    assert np.array_equal(alone.pairs, first.pairs)
    assert np.array_equal(alone.kind_codes, first.kind_codes)
