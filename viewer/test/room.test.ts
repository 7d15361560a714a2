import assert from "node:assert/strict";
import { test } from "node:test";
import { Matrix4, PerspectiveCamera, Vector4 } from "three";
import {
  GripTie,
  heading,
  type Placement,
  placed,
  roomPoint,
  type Stick,
  shifted,
  turnedIn,
  upright,
  Walk,
  worldFromRoom,
  worldPose,
} from "../src/input/room";
import { poseOfColumns, reverseDepth, stickOf } from "../src/input/xr";
import { fromAxes, IDENTITY, multiply, type Pose, position, rotation, translation } from "../src/math/matrix";
import { transform, type Vec3 } from "../src/math/vectors";

const near = (actual: ArrayLike<number>, wanted: ArrayLike<number>, tolerance = 1e-9): void => {
  assert.equal(actual.length, wanted.length);
  for (let k = 0; k < wanted.length; k++) {
    const apart = Math.abs((actual[k] ?? Number.NaN) - (wanted[k] ?? Number.NaN));
    assert.ok(apart <= tolerance, `${k}: [${Array.from(actual)}] is not [${Array.from(wanted)}]`);
  }
};
const BOX = { lower: [1, 2, 3] as Vec3, upper: [1.4, 2.2, 3.1] as Vec3 };
/** Standing at (0.5, 1.6, 0.5), looking along +x. */
const VIEWER = multiply(translation([0.5, 1.6, 0.5]), rotation([0, 1, 0], -Math.PI / 2));

test("each up axis of a mock-up becomes the room's", () => {
  near(position(multiply(upright("x"), translation([1, 0, 0]))), [0, 1, 0]);
  near(position(multiply(upright("y"), translation([0, 1, 0]))), [0, 1, 0]);
  near(position(multiply(upright("z"), translation([0, 0, 1]))), [0, 1, 0]);
});

test("the heading is level, also for who looks down or up", () => {
  near(heading(VIEWER), [1, 0, 0]);
  near(heading(multiply(VIEWER, rotation([1, 0, 0], -1.2))), [1, 0, 0]);
  near(heading(multiply(VIEWER, rotation([1, 0, 0], -Math.PI / 2))), [1, 0, 0]);
  near(heading(multiply(VIEWER, rotation([1, 0, 0], Math.PI / 2))), [1, 0, 0]);
});

test("on a table the mock-up is 0.8 m large, 0.75 m high and 0.7 m ahead", () => {
  for (const up of ["x", "y", "z"] as const) {
    const placement = placed("table", { ...BOX, up }, VIEWER);
    assert.ok(Math.abs(placement.scale - 2) < 1e-9);
    const axis = "xyz".indexOf(up);
    const bottom: Vec3 = [1.2, 2.1, 3.05];
    bottom[axis] = BOX.lower[axis] as number;
    near(roomPoint(placement, bottom), [1.2, 0.75, 0.5]);
    const top: Vec3 = [...bottom];
    top[axis] = BOX.upper[axis] as number;
    const [x, y, z] = roomPoint(placement, top);
    near([x, z], [1.2, 0.5]);
    assert.ok(y > 0.75);
  }
});

test("the mock-up's front looks at the viewer", () => {
  const placement = placed("real", { ...BOX, up: "y" }, VIEWER);
  const [x] = roomPoint(placement, [1.2, 2.1, 3.1]);
  const [behind] = roomPoint(placement, [1.2, 2.1, 3]);
  assert.ok(x < behind);
});

test("at its size a small mock-up floats before the chest, a large one stands on the floor", () => {
  const small = placed("real", { ...BOX, up: "y" }, VIEWER);
  assert.equal(small.scale, 1);
  near([roomPoint(small, [1.2, 2.1, 3.05])[1]], [1.1]);
  const large = placed("real", { lower: [0, 0, 0], upper: [4, 3, 2], up: "y" }, VIEWER);
  near([roomPoint(large, [2, 0, 1])[1]], [0]);
});

test("the world's pose of a controller and the room's are the same place", () => {
  const placement = placed("table", { ...BOX, up: "z" }, VIEWER);
  const room = multiply(translation([0.3, 1.2, -0.4]), rotation([0, 1, 0], 0.4));
  const world = worldPose(placement, room);
  near(roomPoint(placement, position(world)), position(room));
  near(transform(worldFromRoom(placement), position(room)), position(world));
  // A hand's breadth in the room is half of it in a world shown twice as large.
  const on = worldPose(placement, multiply(translation([0.08, 0, 0]), room));
  assert.ok(Math.abs(Math.hypot(...position(on).map((x, k) => x - (position(world)[k] ?? 0))) - 0.04) < 1e-9);
});

test("a turn about a point leaves the point", () => {
  const placement = placed("table", { ...BOX, up: "y" }, VIEWER);
  const middle: Vec3 = [1.2, 2.1, 3.05];
  near(roomPoint(turnedIn(placement, roomPoint(placement, middle), 1), middle), roomPoint(placement, middle));
  near(
    roomPoint(shifted(placement, [1, 2, 3]), middle),
    roomPoint(placement, middle).map((x, k) => x + k + 1),
  );
});

const REST: Stick = [0, 0];
const START: Placement = { scale: 1, pose: [...IDENTITY] };
const walked = (walk: Walk, kind: "table" | "real", tool: Stick, other: Stick, from = START) =>
  walk.step(from, kind, { tool, other }, VIEWER, [0, 0, 0], 0.5);

test("the other hand's stick walks to where the head looks", () => {
  near(roomPoint(walked(new Walk(), "real", REST, [0, -1]), [0, 0, 0]), [-0.5, 0, 0]);
  near(roomPoint(walked(new Walk(), "real", REST, [1, 0]), [0, 0, 0]), [0, 0, -0.5]);
  near(roomPoint(walked(new Walk(), "real", [0, -1], REST), [0, 0, 0]), [0, -0.5, 0]);
  near(walked(new Walk(), "real", [0.1, 0.1], [0.1, -0.1]).pose, START.pose);
});

test("at its size the view turns in steps of 30 degrees, one a push, about the viewer", () => {
  const walk = new Walk();
  const once = walked(walk, "real", [1, 0], REST);
  near(once.pose, turnedIn(START, position(VIEWER), Math.PI / 6).pose);
  near(walked(walk, "real", [1, 0], REST, once).pose, once.pose);
  near(walked(walk, "real", [0.4, 0], REST, once).pose, once.pose);
  walked(walk, "real", REST, REST, once);
  near(walked(walk, "real", [-1, 0], REST, once).pose, START.pose);
});

test("on a table the mock-up turns about its middle, as long as the stick is held", () => {
  const walk = new Walk();
  const once = walked(walk, "table", [1, 0], REST);
  near(once.pose, turnedIn(START, [0, 0, 0], 0.6).pose);
  near(walked(walk, "table", [1, 0], REST, once).pose, turnedIn(START, [0, 0, 0], 1.2).pose);
});

test("a tool that is taken stays where it is and goes along with the hand", () => {
  const tie = new GripTie();
  const grip = multiply(translation([1, 1, 1]), rotation([0, 0, 1], 0.3));
  const tool: Pose = fromAxes([0, 1, 0], [-1, 0, 0], [0, 0, 1], [1.1, 1, 1]);
  tie.take(grip, tool);
  near(tie.wish(grip), tool);
  const moved = multiply(translation([0, 0, 1]), grip);
  near(tie.wish(moved), multiply(translation([0, 0, 1]), tool));
});

test("a tool that is recalled has its pivot in the fist and keeps its turn", () => {
  const tie = new GripTie();
  const grip = multiply(translation([1, 1, 1]), rotation([0, 0, 1], 0.3));
  const tool: Pose = fromAxes([0, 1, 0], [-1, 0, 0], [0, 0, 1], [5, 6, 7]);
  tie.recall(grip, tool, [0.1, 0.2, 0.3]);
  const wish = tie.wish(grip);
  near(transform(wish, [0.1, 0.2, 0.3]), [1, 1, 1]);
  near([wish[0], wish[4], wish[8]] as number[], [0, 1, 0]);
});

test("WebXR's columns become rows, and touchpads serve where there is no stick", () => {
  const matrix = new Matrix4().makeTranslation(1, 2, 3);
  near(poseOfColumns(matrix.elements), translation([1, 2, 3]));
  assert.deepEqual(stickOf([0.1, 0.2, 0.3, 0.4]), [0.3, 0.4]);
  assert.deepEqual(stickOf([0.1, 0.2]), [0.1, 0.2]);
  assert.deepEqual(stickOf([null, null, 0.3, 0.4]), [0.3, 0.4]);
  assert.deepEqual(stickOf([]), [0, 0]);
});

test("a reversed projection has 1 at the near plane, 0 at the far one and the same picture", () => {
  const camera = new PerspectiveCamera(70, 1.3, 0.1, 50);
  camera.updateProjectionMatrix();
  const before = new Vector4(0.2, -0.3, -2, 1).applyMatrix4(camera.projectionMatrix);
  reverseDepth(camera.projectionMatrix.elements);
  const depth = (z: number) => {
    const point = new Vector4(0, 0, z, 1).applyMatrix4(camera.projectionMatrix);
    return point.z / point.w;
  };
  near([depth(-0.1), depth(-50)], [1, 0]);
  const after = new Vector4(0.2, -0.3, -2, 1).applyMatrix4(camera.projectionMatrix);
  near([after.x, after.y, after.w], [before.x, before.y, before.w]);
});
