import assert from "node:assert/strict";
import { test } from "node:test";
import { cutCenter, faceOf, hitCut, layCuts } from "../src/input/cuts";
import type { GizmoView } from "../src/input/gizmo";
import type { Document, SequenceLine } from "../src/link/protocol";
import { boxPlanes } from "../src/math/box-faces";
import { translation } from "../src/math/matrix";
import type { Box, Vec3 } from "../src/math/vectors";
import { poseAt, replayed, secondsOf, startsOf } from "../src/model/offline-replay";
import { boxRound, withFace } from "../src/model/sections";

const BOX: Box = { lower: [0, 0, 0], upper: [2, 2, 2] };
/** Looks along +y from far away: a metre is 100 pixels, z is up. */
const VIEW: GizmoView = {
  towards: () => [0, -1, 0],
  project: ([x, y, z]: Vec3) => ({ x: 100 * x, y: -100 * z, isAhead: y > -100, depth: y + 100 }),
  metresPerPixel: () => 0.01,
};

test("the arrow of a cut is in the middle of what it shows, the other cuts obeyed", () => {
  const across_x = { id: 1, normal: [1, 0, 0] as Vec3, offset: 0.5 };
  const across_z = { id: 2, normal: [0, 0, 1] as Vec3, offset: 1 };
  assert.deepEqual(cutCenter(across_x, [], BOX), [0.5, 1, 1]);
  assert.deepEqual(cutCenter(across_x, [across_z], BOX), [0.5, 1, 1.5]);
  assert.deepEqual(cutCenter({ normal: [1, 0, 0], offset: 5 }, [], BOX), [5, 1, 1], "beside the box");
  const [x, z] = layCuts([across_x, across_z], BOX, VIEW);
  assert.deepEqual(
    x?.line.map((end) => [Math.round(end.x), end.y]),
    [
      [16, -150],
      [84, -150],
    ],
  );
  assert.equal(z?.line[0]?.x, z?.line[1]?.x);
});

test("an arrow that points at the eye is upright, one behind the eye is not there", () => {
  const away = { id: 3, normal: [0, 1, 0] as Vec3, offset: 1 };
  assert.deepEqual(layCuts([away], BOX, VIEW)[0]?.line, [
    { x: 100, y: -66 },
    { x: 100, y: -134 },
  ]);
  assert.deepEqual(layCuts([{ ...away, offset: -200 }], BOX, VIEW), []);
});

test("the nearest arrow within reach is hit", () => {
  const handles = layCuts(
    [
      { id: 1, normal: [1, 0, 0], offset: 0.5 },
      { id: 2, normal: [1, 0, 0], offset: 0.7 },
    ],
    BOX,
    VIEW,
  );
  assert.equal(hitCut(handles, { x: 20, y: -105 })?.id, 1);
  assert.equal(hitCut(handles, { x: 102, y: -105 })?.id, 2);
  assert.equal(hitCut(handles, { x: 60, y: -80 }), null);
});

test("a section box keeps what is inside of its faces, and has an arrow at each", () => {
  const inside = (p: Vec3): boolean =>
    boxPlanes(BOX).every(({ normal, offset }) => normal[0] * p[0] + normal[1] * p[1] + normal[2] * p[2] >= offset);
  assert.deepEqual(
    [inside([1, 1, 1]), inside([2, 0, 2]), inside([1, 1, 2.1]), inside([-0.1, 1, 1])],
    [true, true, false, false],
  );
  const across = { id: 7, normal: [1, 0, 0] as Vec3, offset: 0.5 };
  const handles = layCuts([across], { lower: [-9, -9, -9], upper: [9, 9, 9] }, VIEW, BOX);
  assert.deepEqual(
    handles.map((handle) => [faceOf(handle), handle.center]),
    [
      [null, [0.5, 1, 1]],
      [0, [0, 1, 1]],
      [1, [1, 0, 1]],
      [2, [1, 1, 0]],
      [3, [2, 1, 1]],
      [4, [1, 2, 1]],
      [5, [1, 1, 2]],
    ],
  );
});

test("a face of a section box moves alone, and never past the opposite one", () => {
  assert.deepEqual(withFace(BOX, 3, 5), { lower: [0, 0, 0], upper: [5, 2, 2] });
  assert.deepEqual(withFace(BOX, 1, -1), { lower: [0, -1, 0], upper: [2, 2, 2] });
  const thin = withFace(BOX, 2, 9);
  assert.ok(thin.lower[2] < 2 && thin.lower[2] > 1.99);
  assert.equal(boxRound({ lower: [1, 1, 1], upper: [0, 0, 0] }), null);
  const flat = boxRound({ lower: [0, 0, 1], upper: [3, 4, 1] });
  assert.deepEqual(flat, { lower: [-0.1, -0.1, 0.9], upper: [3.1, 4.1, 1.1] });
});

const line = (id: number, parts: number[], ...xs: number[]): SequenceLine => ({
  ...{ id, name: "", parts, least_clearance: null, touched: [], tool: null, joint: null, stale: {} },
  way: xs.map((x) => translation([x, 0, 0])),
});

test("a sequence is replayed without a server: from where the lines before it left the parts", () => {
  const sequence = [line(1, [4], 5, 6), line(2, [4, 7], 9, 9, 13)];
  const second = sequence[1] as SequenceLine;
  const starts = startsOf(sequence, second);
  assert.deepEqual([starts.get(4)?.[3], starts.get(7)?.[3]], [1, 0]);
  assert.equal(secondsOf(second), 16);
  assert.equal(poseAt(second, 0.25)[3], 10);
  const document = { sequence, moved: { 3: translation([1, 1, 1]) } } as unknown as Document;
  const half = replayed(document, second, starts, 0.5).moved;
  assert.deepEqual([half[4]?.[3], half[7]?.[3], half[3]?.[7]], [3, 2, 1]);
  const end = replayed(document, second, starts, 1).moved;
  assert.deepEqual([end[4]?.[3], end[7]?.[3]], [5, 4]);
});
