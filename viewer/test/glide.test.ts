import assert from "node:assert/strict";
import { test } from "node:test";
import { type Box, distance, dot, length, type Vec3 } from "../src/math/vectors";
import { CameraRig } from "../src/scene/camera";

const BOX: Box = { lower: [-1, -2, -3], upper: [3, 1, 2] };

function rig(): CameraRig {
  const camera = new CameraRig();
  Object.assign(camera, { width: 800, height: 600 });
  camera.view(7, BOX, "z");
  camera.moved = false;
  return camera;
}

test("a glide begins where the camera is, ends exactly where it leads, and never rolls", () => {
  const camera = rig();
  const from = camera.toJSON();
  const there = rig();
  there.view(2, BOX, "z");
  camera.glide((each) => each.view(2, BOX, "z"), 250);
  assert.ok(camera.isGliding);
  assert.deepEqual(camera.position, from.position);
  assert.deepEqual(camera.toJSON(), there.toJSON(), "scripts see the end of it");
  assert.deepEqual(camera.arrived.position, there.position);
  let before = -1;
  for (let now = 1000; now < 1250; now += 25) {
    assert.ok(camera.step(now));
    assert.ok(Math.abs(dot(camera.right, [0, 0, 1])) < 1e-9, "the horizon stays level");
    const way = distance(camera.position, from.position as Vec3);
    assert.ok(way > before, "it goes on");
    before = way;
  }
  assert.ok(camera.moved);
  assert.ok(camera.step(1250));
  assert.deepEqual(camera.toJSON(), there.toJSON());
  assert.ok(!camera.isGliding && !camera.step(1300));
});

test("a change ends the glide: it acts on where that leads", () => {
  const [camera, there] = [rig(), rig()];
  for (const each of [camera, there]) each.glide((c) => c.view(5, BOX, "z"), each === camera ? 250 : 0);
  camera.step(0);
  camera.step(100);
  for (const each of [camera, there]) each.orbit(0.2, 0.1, [0, 0, 0]);
  assert.ok(!camera.isGliding);
  assert.deepEqual(camera.toJSON(), there.toJSON());
});

test("a second glide starts from what is shown, and leads on from where the first one would", () => {
  const camera = rig();
  camera.glide((c) => c.view(1, BOX, "z"), 250);
  camera.step(0);
  camera.step(60);
  const shown = [...camera.position] as Vec3;
  camera.glide((c) => c.translate([1, 0, 0]), 250);
  assert.ok(distance(camera.position, shown) < 1e-12);
  const there = rig();
  there.view(1, BOX, "z");
  there.translate([1, 0, 0]);
  assert.deepEqual(camera.toJSON(), there.toJSON());
});

test("without time, and where nothing changes, there is no glide", () => {
  const camera = rig();
  camera.glide((c) => c.view(1, BOX, "z"), 0);
  assert.ok(!camera.isGliding);
  camera.glide((c) => c.view(1, BOX, "z"), 250);
  assert.ok(!camera.isGliding);
});

test("where the vertical changes the way is straight, and ends upright", () => {
  const camera = rig();
  camera.roll(0.5);
  camera.glide((c) => c.view(4, BOX, "y"), 250);
  for (const now of [0, 50, 120, 200, 249]) {
    camera.step(now);
    assert.ok(Math.abs(length(camera.up) - 1) < 1e-9 && Number.isFinite(camera.position[0]));
  }
  camera.step(250);
  assert.deepEqual(camera.up, [0, 1, 0]);
});
