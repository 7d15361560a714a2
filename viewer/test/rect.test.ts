import assert from "node:assert/strict";
import { test } from "node:test";
import { type Box, corners, type Vec3 } from "../src/math/vectors";
import { aim } from "../src/scene/aim";
import { CameraRig } from "../src/scene/camera";
import { Eye } from "../src/scene/eye";
import { rectOf } from "../src/scene/rect";
import { sharedUniforms } from "../src/scene/uniforms";

const SCENE: Box = { lower: [-1, -1, -1], upper: [1, 1, 1] };
const MIDDLE: Vec3 = [0.25, 0, -0.5];

function seen(isParallel: boolean): { camera: CameraRig; eye: Eye } {
  const camera = new CameraRig();
  Object.assign(camera, { width: 400, height: 300, isParallel });
  camera.view(7, SCENE, "z");
  const eye = new Eye();
  const picture = { width: 800, height: 600, pixelRatio: 2 };
  aim(eye, sharedUniforms(), { camera, box: SCENE, middle: MIDDLE, isReversed: true, picture });
  return { camera, eye };
}

test("the rectangle of a box holds its corners, in both projections, and hardly more", () => {
  const box: Box = { lower: [0.1, -0.2, 0.3], upper: [0.4, 0.1, 0.5] };
  for (const isParallel of [false, true]) {
    const { camera, eye } = seen(isParallel);
    const rect = rectOf(box, MIDDLE, eye, 800, 600, 0);
    assert.ok(rect);
    const places = corners(box).map((corner) => camera.project(corner));
    const [xs, ys] = [places.map(({ x }) => 2 * x), places.map(({ y }) => 600 - 2 * y)];
    assert.ok(Math.abs(Math.min(...xs) - rect.left) <= 1 && Math.abs(Math.max(...xs) - rect.left - rect.width) <= 1);
    assert.ok(
      Math.abs(Math.min(...ys) - rect.bottom) <= 1 && Math.abs(Math.max(...ys) - rect.bottom - rect.height) <= 1,
    );
    const wider = rectOf(box, MIDDLE, eye, 800, 600, 5);
    assert.equal(wider?.left, rect.left - 5);
    assert.equal(wider?.width, rect.width + 10);
  }
});

test("nothing out of the picture or behind the eye has one; around the eye it is the whole picture", () => {
  const { camera, eye } = seen(false);
  const at = (middle: Vec3, half: number): Box => ({
    lower: middle.map((value) => value - half) as Vec3,
    upper: middle.map((value) => value + half) as Vec3,
  });
  assert.equal(rectOf(at([0, 90, 90], 0.1), MIDDLE, eye, 800, 600, 4), null);
  const behind = camera.position.map((value, k) => value - 5 * (camera.forward[k] as number)) as Vec3;
  assert.equal(rectOf(at(behind, 0.1), MIDDLE, eye, 800, 600, 4), null);
  assert.deepEqual(rectOf(at([...camera.position], 0.5), MIDDLE, eye, 800, 600, 4), {
    left: 0,
    bottom: 0,
    width: 800,
    height: 600,
  });
  assert.equal(rectOf({ lower: [1, 1, 1], upper: [0, 0, 0] }, MIDDLE, eye, 800, 600, 4), null);
});
