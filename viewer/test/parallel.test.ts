import assert from "node:assert/strict";
import { test } from "node:test";
import { Vector3 } from "three";
import { add, type Box, distance, dot, type Vec3 } from "../src/math/vectors";
import { aim } from "../src/scene/aim";
import { CameraRig } from "../src/scene/camera";
import { Eye } from "../src/scene/eye";
import { sharedUniforms } from "../src/scene/uniforms";

const BOX: Box = { lower: [-1, -2, -3], upper: [3, 1, 2] };

function parallel(): CameraRig {
  const camera = new CameraRig();
  Object.assign(camera, { width: 800, height: 600, isParallel: true });
  camera.view(7, BOX, "z");
  return camera;
}

const near = (a: readonly number[], b: readonly number[], slack = 1e-9) =>
  a.forEach((value, k) => {
    assert.ok(Math.abs(value - (b[k] as number)) <= slack, `${a} is not ${b}`);
  });

test("a parallel fit shows every corner, and no more than it must", () => {
  for (const n of [1, 2, 3, 4, 5, 6, 7]) {
    const camera = parallel();
    camera.view(n, BOX, "z");
    let widest = 0;
    for (let bits = 0; bits < 8; bits++) {
      const { x, y } = camera.project([0, 1, 2].map((k) => (bits & (1 << k) ? BOX.upper[k] : BOX.lower[k])) as Vec3);
      widest = Math.max(widest, Math.abs(x / 400 - 1), Math.abs(y / 300 - 1));
    }
    assert.ok(widest <= 1 && widest > 0.9, `view ${n}: ${widest}`);
  }
});

test("lengths across the view are alike at every depth, and both projections agree at the target", () => {
  const camera = parallel();
  const [a, b] = [add(camera.target, camera.right), add(camera.target, add(camera.right, camera.forward))];
  near([camera.project(a).x, camera.project(a).y], [camera.project(b).x, camera.project(b).y]);
  assert.equal(camera.metresPerPixel(0.1), camera.metresPerPixel(100));
  const seen = camera.project(a);
  camera.setParallel(false);
  assert.ok(camera.moved);
  near([camera.project(a).x, camera.project(a).y], [seen.x, seen.y]);
});

test("a parallel ray meets the point that is projected to its pixel, before the eye and behind it", () => {
  const camera = parallel();
  for (const point of [
    [0.3, -0.8, 1],
    [30, -80, 40],
  ] as Vec3[]) {
    const { x, y, depth, isAhead } = camera.project(point);
    assert.ok(isAhead);
    const { origin, direction } = camera.ray(x, y);
    near(add(origin, direction.map((value) => value * depth) as Vec3), point, 1e-6);
  }
});

test("zooming keeps the point under the pointer, and never passes through anything", () => {
  const camera = parallel();
  const at: Vec3 = [1.5, -0.5, 1];
  const before = camera.project(at);
  const depth = dot(camera.target, camera.forward);
  for (let k = 0; k < 40; k++) camera.dolly(0.8, at);
  const after = camera.project(at);
  near([after.x, after.y], [before.x, before.y], 1e-6);
  assert.ok(Math.abs(dot(camera.target, camera.forward) - depth) < 1e-9, "the target stays at its depth");
});

test("three's camera projects as the page's does, also a part of the picture", () => {
  for (const isReversed of [true, false]) {
    const camera = parallel();
    const eye = new Eye();
    Object.assign(eye, { _reversedDepth: isReversed });
    const uniforms = sharedUniforms();
    const middle: Vec3 = [0.5, 0.25, 0];
    aim(eye, uniforms, { camera, box: BOX, middle, isReversed, picture: { width: 800, height: 600, pixelRatio: 1 } });
    for (const point of [
      [0.3, -0.8, 1],
      [2, 0.5, -2],
    ] as Vec3[]) {
      const clip = new Vector3(point[0] - middle[0], point[1] - middle[1], point[2]).project(eye);
      const seen = camera.project(point);
      near([400 * (clip.x + 1), 300 * (1 - clip.y)], [seen.x, seen.y], 1e-6);
      const stored = isReversed ? clip.z : (clip.z + 1) / 2;
      const { x, y } = uniforms.depthLine.value;
      assert.ok(Math.abs(x * stored + y - seen.depth) < 1e-6 * camera.reach, "the stored depth is the distance");
      const ray = uniforms.rayOf.value;
      near(
        [seen.x * ray.x + ray.z, (600 - seen.y) * ray.y + ray.w],
        [
          dot(point, camera.right) - dot(camera.position, camera.right),
          dot(point, camera.top) - dot(camera.position, camera.top),
        ],
        1e-6,
      );
      eye.setViewOffset(800, 600, 200, 100, 400, 300);
      const part = new Vector3(point[0] - middle[0], point[1] - middle[1], point[2]).project(eye);
      near([200 + 200 * (part.x + 1), 100 + 150 * (1 - part.y)], [seen.x, seen.y], 1e-6);
      eye.clearViewOffset();
    }
  }
});

test("the projection is kept with the camera; older cameras are perspective", () => {
  const camera = parallel();
  const kept = camera.toJSON();
  assert.equal(kept.is_parallel, true);
  const { is_parallel: _, ...old } = kept;
  camera.fromJSON(old);
  assert.equal(camera.isParallel, false);
  camera.fromJSON(kept);
  assert.equal(camera.isParallel, true);
  assert.ok(distance(camera.position, kept.position) === 0);
});
