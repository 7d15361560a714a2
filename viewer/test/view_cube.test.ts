import assert from "node:assert/strict";
import { test } from "node:test";
import { hitCube, isSameSide, layCube, nearestSide, neighbourSide, SIDES, sideName } from "../src/input/view-cube";
import { scaleBar } from "../src/math/scale-bar";
import type { Box, Vec3 } from "../src/math/vectors";
import { CameraRig } from "../src/scene/camera";

const BOX: Box = { lower: [-1, -2, -3], upper: [3, 1, 2] };

function from(side: Vec3, up: "x" | "y" | "z" = "z"): CameraRig {
  const camera = new CameraRig();
  Object.assign(camera, { width: 800, height: 600 });
  camera.viewFrom(side, BOX, up);
  return camera;
}

test("there are 26 sides, each is looked from and found again, whichever axis is up", () => {
  assert.equal(SIDES.length, 26);
  for (const up of ["x", "y", "z"] as const)
    for (const side of SIDES) assert.deepEqual(nearestSide(from(side, up), up), side);
});

test("what the eye looks at is in the middle of the cube, and every side can be clicked from somewhere", () => {
  for (const side of SIDES) {
    const cells = layCube(from(side), "z");
    const mine = cells.filter((cell) => isSameSide(cell.side, side));
    assert.ok(mine.length > 0);
    for (const { corners } of mine) {
      const middle = { x: 0, y: 0 };
      for (const { x, y } of corners) {
        middle.x += x / 4;
        middle.y += y / 4;
      }
      assert.deepEqual(hitCube(cells, middle), side);
    }
    assert.equal(hitCube(cells, { x: 1, y: 1 }), null, "beside the cube");
  }
  const front = hitCube(layCube(from([0, -1, 0]), "z"), { x: 52, y: 52 });
  assert.deepEqual(front, [0, -1, 0]);
  const right = hitCube(layCube(from([0, -1, 0]), "z"), { x: 52 + 24, y: 52 });
  assert.deepEqual(right, [1, -1, 0], "the edge to the right of the front");
});

test("arrow keys reach every side", () => {
  const seen = new Set<string>();
  const waiting: Vec3[] = [[0, -1, 0]];
  for (let side = waiting.pop(); side; side = waiting.pop()) {
    if (seen.has(side.join())) continue;
    seen.add(side.join());
    for (const [dx, dy] of [
      [1, 0],
      [-1, 0],
      [0, 1],
      [0, -1],
    ] as const)
      waiting.push(neighbourSide(side, dx, dy));
  }
  assert.equal(seen.size, 26);
  assert.deepEqual(neighbourSide([0, -1, 0], 1, 0), [1, -1, 0]);
  assert.deepEqual(neighbourSide([1, 0, 1], 0, 1), [0, 0, 1]);
});

test("sides have names", () => {
  assert.equal(sideName([0, -1, 0]), "front");
  assert.equal(sideName([1, -1, 1]), "front, right and top");
  assert.equal(new Set(SIDES.map(sideName)).size, 26);
});

test("the scale bar is a round length that fits, in the shown unit", () => {
  assert.deepEqual(scaleBar(0.001, 130, "mm"), { width_px: 100, metres: 0.1, text: "100 mm" });
  assert.equal(scaleBar(0.001, 130, "in")?.text, "5 in");
  assert.equal(scaleBar(0.0000013, 130, "mm")?.text, "0.1 mm");
  assert.equal(scaleBar(1e-9, 130, "mm")?.text, "0.0001 mm");
  assert.equal(scaleBar(0, 130, "mm"), null);
  for (const unit of ["mm", "cm", "m", "in"] as const)
    for (let size = 1e-9; size < 1e3; size *= 1.7) {
      const bar = scaleBar(size, 130, unit);
      assert.ok(bar && bar.width_px <= 130.001 && bar.width_px > 51, `${size} ${unit}`);
      assert.ok(!/^0 /.test(bar.text), `${bar.text} says something`);
    }
});
