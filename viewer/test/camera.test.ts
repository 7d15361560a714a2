import assert from "node:assert/strict";
import { test } from "node:test";
import { type Box, cross, distance, dot, length, subtract, type Vec3 } from "../src/math/vectors";
import { CameraRig } from "../src/scene/camera";

const BOX: Box = { lower: [-1, -2, -3], upper: [3, 1, 2] };

function rig(): CameraRig {
  const camera = new CameraRig();
  Object.assign(camera, { width: 800, height: 600 });
  camera.view(7, BOX, "z");
  return camera;
}

function near(a: Vec3, b: Vec3, slack = 1e-9): void {
  assert.ok(distance(a, b) <= slack, `${a} is not ${b}`);
}

test("a fit shows every corner, and no more than it must", () => {
  for (const n of [1, 2, 3, 4, 5, 6, 7]) {
    for (const [width, height] of [
      [800, 600],
      [300, 900],
    ] as const) {
      const camera = rig();
      Object.assign(camera, { width, height });
      camera.view(n, BOX, "z");
      let widest = 0;
      for (let bits = 0; bits < 8; bits++) {
        const corner = [0, 1, 2].map((k) => (bits & (1 << k) ? BOX.upper[k] : BOX.lower[k])) as Vec3;
        const { x, y, depth } = camera.project(corner);
        assert.ok(depth > 0);
        widest = Math.max(widest, Math.abs((2 * x) / width - 1), Math.abs((2 * y) / height - 1));
      }
      assert.ok(widest <= 1 && widest > 0.85, `view ${n}: ${widest}`);
    }
  }
});

test("the views look along the axes, whichever is up", () => {
  const camera = rig();
  const seen = (n: number, axis: "x" | "y" | "z") => {
    camera.view(n, BOX, axis);
    return camera.forward.map((value) => Math.round(value)) as Vec3;
  };
  assert.deepEqual(seen(1, "z").map(Math.abs), [0, 1, 0]);
  near(seen(1, "z"), [0, 1, 0]);
  near(seen(2, "z"), [0, -1, 0]);
  near(seen(3, "z"), [1, 0, 0]);
  near(seen(5, "z"), [0, 0, -1]);
  near(seen(6, "z"), [0, 0, 1]);
  near(seen(1, "y"), [0, 0, -1]);
  near(seen(5, "y"), [0, -1, 0]);
  near(seen(5, "x"), [-1, 0, 0]);
});

test("an orbit keeps the pivot where it is in the picture, and the distance to it", () => {
  const camera = rig();
  const pivot: Vec3 = [1.5, -0.5, 1];
  const before = camera.project(pivot);
  const reach = distance(camera.position, pivot);
  camera.orbit(0.4, -0.2, pivot);
  const after = camera.project(pivot);
  assert.ok(Math.abs(before.x - after.x) < 1e-6 && Math.abs(before.y - after.y) < 1e-6);
  assert.ok(Math.abs(distance(camera.position, pivot) - reach) < 1e-9);
  assert.ok(Math.abs(dot(camera.right, [0, 0, 1])) < 1e-12, "the horizon stays level");
});

test("an orbit to the right turns the picture to the right, one down shows more of the top", () => {
  const camera = rig();
  const inFront: Vec3 = [camera.target[0], camera.target[1], camera.target[2]].map(
    (value, k) => value - 0.5 * (camera.forward[k] as number),
  ) as Vec3;
  const x = camera.project(inFront).x;
  camera.orbit(0.1, 0, camera.target);
  assert.ok(camera.project(inFront).x > x);
  const height = camera.position[2];
  camera.orbit(0, 0.1, camera.target);
  assert.ok(camera.position[2] > height);
});

test("no orbit passes a pole", () => {
  const camera = rig();
  for (const dy of [10, -20, 3, 0.5]) {
    camera.orbit(0, dy, camera.target);
    assert.ok(length(cross(camera.forward, camera.up)) > 5e-6);
    assert.ok(dot(camera.top, camera.up) > 0, "the picture is not upside down");
  }
});

test("a pan moves the point at its depth by as many pixels", () => {
  const camera = rig();
  const at = camera.project(camera.target);
  const target = camera.target;
  camera.pan(30, -20);
  const after = camera.project(target);
  assert.ok(Math.abs(after.x - at.x - 30) < 1e-6 && Math.abs(after.y - at.y + 20) < 1e-6);
});

test("a dolly keeps what is under the pointer there, and the view direction", () => {
  const camera = rig();
  const at: Vec3 = [2.5, 0.5, 1.5];
  const [before, forward] = [camera.project(at), camera.forward];
  camera.dolly(0.4, at);
  const after = camera.project(at);
  assert.ok(Math.abs(before.x - after.x) < 1e-6 && Math.abs(before.y - after.y) < 1e-6);
  assert.ok(Math.abs(after.depth - 0.4 * before.depth) < 1e-9);
  near(camera.forward, forward);
  for (let k = 0; k < 200; k++) camera.dolly(0.5, at);
  assert.ok(camera.position.every(Number.isFinite) && distance(camera.position, at) > 0);
});

test("a ray goes through the point that is projected to its pixel", () => {
  const camera = rig();
  const point: Vec3 = [0.3, -0.7, 0.9];
  const { x, y } = camera.project(point);
  const { origin, direction } = camera.ray(x, y);
  const to = subtract(point, origin);
  assert.ok(length(cross(direction, to)) < 1e-9 && dot(direction, to) > 0);
});

test("near and far hold the whole box, from outside and from inside", () => {
  for (const isReversed of [true, false]) {
    const camera = rig();
    for (const back of [30, 1, 0.01]) {
      camera.dolly(back);
      const { near, far } = camera.range(BOX, isReversed);
      assert.ok(near > 0 && near < far);
      for (let bits = 0; bits < 8; bits++) {
        const corner = [0, 1, 2].map((k) => (bits & (1 << k) ? BOX.upper[k] : BOX.lower[k])) as Vec3;
        assert.ok(camera.project(corner).depth < far);
      }
    }
  }
});

test("what is written is read again, and says that it moved", () => {
  const camera = rig();
  const state = JSON.parse(JSON.stringify(camera));
  const other = new CameraRig();
  other.moved = false;
  other.fromJSON(state);
  assert.deepEqual(other.toJSON(), camera.toJSON());
  assert.equal(other.moved, true);
});
