import assert from "node:assert/strict";
import { test } from "node:test";
import { GIZMO_RADIUS_PX, layGizmo, shifted } from "../src/input/gizmo";
import {
  areaOf,
  distanceToHull,
  edgeArrow,
  hullOf,
  isInPicture,
  placeGizmo,
  pointsOf,
  slices,
} from "../src/input/gizmo-place";
import { IDENTITY } from "../src/math/matrix";
import { corners, type Vec3 } from "../src/math/vectors";
import { CameraRig } from "../src/scene/camera";

const PICTURE = { width: 800, height: 600 };
const R = GIZMO_RADIUS_PX;
const square = (x: number, y: number, half: number) => ({
  left: x - half,
  right: x + half,
  top: y - half,
  bottom: y + half,
});
const hull = ({ left, right, top, bottom }: ReturnType<typeof square>) =>
  hullOf([
    { x: left, y: top },
    { x: right, y: top },
    { x: left, y: bottom },
    { x: right, y: bottom },
  ]);

test("a hull holds its points, and a point knows how far from it it is", () => {
  const found = hullOf([
    { x: 0, y: 0 },
    { x: 10, y: 0 },
    { x: 5, y: 5 },
    { x: 10, y: 10 },
    { x: 0, y: 10 },
    { x: 5, y: 0 },
  ]);
  assert.equal(found.length, 4);
  assert.equal(distanceToHull(found, { x: 5, y: 5 }), 0);
  assert.equal(distanceToHull(found, { x: 13, y: 5 }), 3);
  assert.equal(distanceToHull(found, { x: 13, y: 14 }), 5);
  assert.equal(distanceToHull([], { x: 0, y: 0 }), Infinity);
});

test("the gizmo stands beside a small tool, wherever that is, and is never cut by the frame", () => {
  for (let x = 5; x <= 795; x += 79)
    for (let y = 5; y <= 595; y += 59) {
      const tool = hull(square(x, y, 20));
      const { dx, dy } = placeGizmo({ x, y }, tool, PICTURE, [], null);
      const at = { x: x + dx, y: y + dy };
      assert.ok(at.x >= R && at.x <= 800 - R && at.y >= R && at.y <= 600 - R, `cut at ${x}, ${y}`);
      assert.ok(distanceToHull(tool, at) >= 60, `the tool at ${x}, ${y} is covered`);
      assert.ok(Math.hypot(dx, dy) < 260);
    }
});

test("it stands beside a long tool that lies across the picture", () => {
  const tool = hullOf([
    { x: 100, y: 560 },
    { x: 120, y: 580 },
    { x: 600, y: 80 },
    { x: 620, y: 100 },
  ]);
  const { dx, dy, way } = placeGizmo({ x: 590, y: 110 }, tool, PICTURE, [], null);
  assert.notEqual(way, null);
  assert.ok(distanceToHull(tool, { x: 590 + dx, y: 110 + dy }) >= 70);
});

test("it stands on a tool that fills the picture, within the frame, and on a hand without a mesh", () => {
  assert.deepEqual(placeGizmo({ x: 400, y: 300 }, hull(square(400, 300, 390)), PICTURE, [], null), {
    dx: 0,
    dy: 0,
    way: null,
  });
  const { dx } = placeGizmo({ x: 790, y: 300 }, hull(square(500, 300, 480)), PICTURE, [], null);
  assert.equal(790 + dx, 800 - R);
  assert.equal(placeGizmo({ x: 400, y: 300 }, [], PICTURE, [], null).way, null);
});

test("it keeps clear of controls, and stays where it was while that is free", () => {
  const tool = hull(square(400, 300, 20));
  const free = placeGizmo({ x: 400, y: 300 }, tool, PICTURE, [], null);
  const control = square(400 + free.dx, 300 + free.dy, 10);
  const other = placeGizmo({ x: 400, y: 300 }, tool, PICTURE, [control], free.way);
  assert.notDeepEqual([other.dx, other.dy], [free.dx, free.dy]);
  assert.equal(placeGizmo({ x: 400, y: 300 }, tool, PICTURE, [], 4).way, 4);
});

test("handles elsewhere are the same handles", () => {
  const camera = new CameraRig();
  Object.assign(camera, PICTURE);
  camera.view(7, { lower: [-1, -1, -1], upper: [1, 1, 1] }, "z");
  const handles = layGizmo([0, 0, 0], IDENTITY, "world", camera);
  const moved = shifted(handles, 30, -20);
  moved.forEach(({ axis, kind, line }, k) => {
    assert.deepEqual([kind, axis], [handles[k]?.kind, handles[k]?.axis]);
    assert.equal(line[0]?.x, (handles[k]?.line[0]?.x ?? 0) + 30);
  });
});

test("a tool that reaches behind the eye covers the picture in its direction", () => {
  const camera = new CameraRig();
  Object.assign(camera, PICTURE);
  camera.view(1, { lower: [-1, -1, -1], upper: [1, 1, 1] }, "z");
  // From the middle to behind the eye, along the view and a little to the left.
  const area = areaOf(pointsOf(corners({ lower: [-0.2, -20, -0.1], upper: [0.1, 0, 0.1] }), camera));
  assert.ok(area && area.left < 0 && area.bottom > 600 && area.top < 0);
});

test("beside a tool that is out of the picture, the gizmo is not under what lies over it", () => {
  const cube = { left: 690, right: 800, top: 0, bottom: 160 };
  const tool = hull(square(1500, 100, 20));
  const bare = placeGizmo({ x: 1500, y: 100 }, tool, PICTURE, [], null);
  assert.deepEqual([1500 + bare.dx, 100 + bare.dy], [800 - GIZMO_RADIUS_PX, 100]);
  const { dx, dy } = placeGizmo({ x: 1500, y: 100 }, tool, PICTURE, [cube], null);
  assert.equal(1500 + dx, 800 - GIZMO_RADIUS_PX);
  assert.ok(100 + dy - GIZMO_RADIUS_PX >= 160 && 100 + dy < 160 + GIZMO_RADIUS_PX + 20);
});

test("the slices of a box lie along its longest side, and make up all of it", () => {
  const box = corners({ lower: [0, 0, 0], upper: [1, 2, 8] });
  const found = slices(box);
  assert.equal(found.length, 8);
  found.forEach((slice, k) => {
    assert.deepEqual(slice, corners({ lower: [0, 0, k], upper: [1, 2, k + 1] }));
  });
  assert.deepEqual(slices([]), []);
});

test("a tool out of the picture is known, and the arrow lies at the edge towards it", () => {
  const camera = new CameraRig();
  Object.assign(camera, PICTURE);
  camera.view(1, { lower: [-1, -1, -1], upper: [1, 1, 1] }, "z");
  const box = (x: number, y: number): Vec3[] => corners({ lower: [x - 0.1, y, -0.1], upper: [x + 0.1, y + 0.1, 0.1] });
  const seen = (points: Vec3[]) => isInPicture(areaOf(pointsOf(points, camera)), 800, 600);
  assert.ok(seen(box(0, 0)));
  assert.ok(!seen(box(9, 0)));
  assert.ok(!seen(box(0, -99)), "behind the eye");
  const right = edgeArrow({ x: 5000, y: 300 }, PICTURE, 30);
  assert.deepEqual([right.x, right.y, right.angle], [770, 300, 0]);
  const up = edgeArrow({ x: 400, y: -900 }, PICTURE, 30);
  assert.deepEqual([up.x, up.y], [400, 30]);
  assert.ok(Math.abs(up.angle + Math.PI / 2) < 1e-12);
  const beside = edgeArrow({ x: -5000, y: 100 }, PICTURE, 30, [square(30, 120, 100)]);
  assert.ok(beside.x === 30 && beside.y >= 250, "it slides along its edge, off a toolbar");
});
