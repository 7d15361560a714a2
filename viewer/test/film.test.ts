import assert from "node:assert/strict";
import { test } from "node:test";
import type { Pose } from "../src/math/matrix";
import { multiply, rotation, translation } from "../src/math/matrix";
import { formatTime } from "../src/math/units";
import type { Vec3 } from "../src/math/vectors";
import {
  advanced,
  gapAt,
  gapsOf,
  motionAt,
  placeAt,
  placesAt,
  secondsOf,
  sharesOf,
  tightest,
  timeOf,
} from "../src/model/film";

const HOME: Pose = translation([0, 0, 0]);
const BOX: Vec3[] = [
  [0, 0, 0],
  [1, 1, 1],
];
const way = (parts: number[], poses: Pose[], length = 0.3) => ({
  ...{ parts, poses: poses.map((pose) => [...pose]), length, clearance: null, legs: [], rotation: 0, gaps: [] },
});

test("shares follow the fastest point, and no motion has even ones", () => {
  const turned = rotation([0, 0, 1], Math.PI / 2);
  const shares = sharesOf([HOME, translation([3, 0, 0]), multiply(translation([3, 0, 0]), turned)], BOX);
  // The corner (1, 1) goes 2 in the turn, 3 in the step before it.
  assert.deepEqual(
    shares.map((each) => Math.round(100 * each)),
    [0, 60, 100],
  );
  assert.deepEqual(sharesOf([HOME, HOME, HOME], BOX), [0, 0.5, 1]);
  assert.deepEqual(sharesOf([HOME], BOX), [0]);
});

test("the motion at a share lies between its poses and is rigid", () => {
  const poses = [HOME, translation([2, 0, 0]), multiply(translation([2, 0, 0]), rotation([0, 0, 1], 1))];
  const shares = sharesOf(poses, BOX);
  assert.deepEqual([...motionAt(poses, shares, 0)], [...HOME]);
  assert.deepEqual([...motionAt(poses, [], 1)], [...(poses[2] as Pose)]);
  const half = motionAt(poses, shares, (shares[1] as number) / 2);
  assert.ok(Math.abs((half[3] as number) - 1) < 1e-12);
  const turning = motionAt(poses, shares, 0.9);
  const [a, b] = [turning.slice(0, 3), turning.slice(4, 7)] as [Vec3, Vec3];
  assert.ok(Math.abs(a[0] * b[0] + a[1] * b[1] + a[2] * b[2]) < 1e-9);
  assert.ok(Math.abs(Math.hypot(...a) - 1) < 1e-9);
  assert.deepEqual([...motionAt([HOME], [0], 0.5)], [...HOME]);
});

test("a film plays its ways one after the other and stands at the end", () => {
  const ways = [way([1], [HOME]), way([2], [HOME])];
  const each = secondsOf(ways[0] as { length: number });
  const start = { card: 1, step: 0, share: 0, is_playing: true };
  assert.deepEqual(advanced(start, ways, each / 2), { ...start, share: 0.5 });
  const second = advanced(start, ways, 1.25 * each);
  assert.deepEqual([second.step, second.is_playing], [1, true]);
  assert.ok(Math.abs(second.share - 0.25) < 1e-9);
  assert.deepEqual(advanced(start, ways, 10 * each), { card: 1, step: 1, share: 1, is_playing: false });
  assert.equal(advanced(start, [], 1).is_playing, false);
});

test("parts of earlier steps are at their ends, later ones where they lie", () => {
  const ways = [way([1], [HOME, translation([0, 0, 5])]), way([2], [HOME, translation([4, 0, 0])]), way([3], [HOME])];
  const starts = { "2": [...translation([1, 0, 0])] };
  const places = placesAt({ card: 1, step: 1, share: 0.5, is_playing: false }, ways, starts, () => BOX);
  assert.deepEqual([...places.keys()], [1, 2]);
  assert.equal(places.get(1)?.[11], 5);
  assert.equal(places.get(2)?.[3], 3);
});

test("gaps: the one looked for nearest to a place, and the tightest", () => {
  const gap = (share: number, value: number | null) => ({
    share,
    gap: value,
    part: value === null ? null : 1,
    point: null,
  });
  const gaps = [gap(0, 0.02), gap(0.5, null), gap(1, 0.01)];
  assert.equal(gapAt(gaps, 0.4), gaps[1]);
  assert.equal(gapAt([], 0.4), null);
  assert.equal(tightest(gaps), gaps[2]);
  assert.equal(tightest([gap(0, null)]), null);
});

test("a moment of a film is a place on one of its ways, and back", () => {
  const ways = [way([1], [HOME], 0.3), way([2], [HOME], 0.6)];
  const [first, second] = ways.map(secondsOf) as [number, number];
  assert.deepEqual(placeAt(ways, 0), { step: 0, share: 0 });
  assert.deepEqual(placeAt(ways, first), { step: 1, share: 0 });
  assert.deepEqual(placeAt(ways, first + second / 4), { step: 1, share: 0.25 });
  assert.deepEqual(placeAt(ways, 99), { step: 1, share: 1 });
  assert.deepEqual(placeAt([], 1), { step: 0, share: 1 });
  for (const at of [0.1, first - 0.1, first + 0.2]) assert.ok(Math.abs(timeOf(placeAt(ways, at), ways) - at) < 1e-12);
  const gap = { share: 0.5, gap: 0.01, part: 3, point: null };
  const gaps = gapsOf(ways.map((each) => ({ ...each, gaps: [gap] })));
  assert.deepEqual(
    gaps.map(({ share }) => Math.round(1e6 * share * (first + second)) / 1e6),
    [first / 2, first + second / 2],
  );
  assert.deepEqual([formatTime(0), formatTime(65.25), formatTime(-1)], ["0:00.0", "1:05.3", "0:00.0"]);
});

test("lines of a sequence begin where they began, and one part may go twice", () => {
  const line = (id: number, parts: number[], start: number, ...xs: number[]) => ({
    ...way(
      parts,
      xs.map((x) => translation([x, 0, 0])),
    ),
    id,
    starts: start === 0 ? {} : Object.fromEntries(parts.map((part) => [part, [...translation([start, 0, 0])]])),
  });
  const ways = [line(1, [4], 0, 0, 2), line(2, [7], 0, 0, 5), line(3, [4], 2, 0, 1)];
  const now = { "4": [...translation([3, 0, 0])], "7": [...translation([5, 0, 0])] };
  const at = (step: number, share: number) => {
    const places = placesAt({ card: "sequence", step, share, is_playing: false }, ways, now, () => BOX);
    return [places.get(4)?.[3], places.get(7)?.[3]];
  };
  assert.deepEqual(at(0, 0), [0, 0], "the later line waits at home, not where it lies now");
  assert.deepEqual(at(0, 1), [2, 0]);
  assert.deepEqual(at(1, 0.5), [2, 2.5]);
  assert.deepEqual(at(2, 1), [3, 5]);
});
