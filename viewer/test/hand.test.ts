import assert from "node:assert/strict";
import { test } from "node:test";
import {
  axis,
  fromAxes,
  IDENTITY,
  isSamePose,
  multiply,
  type Pose,
  position,
  rotation,
  translation,
} from "../src/math/matrix";
import { Hand } from "../src/model/hand";

function setUp() {
  const placed: Pose[] = [];
  const waiting: (() => void)[] = [];
  let moves = 0;
  let ends = 0;
  const hand = new Hand(
    {
      moved: () => {
        moves++;
      },
      placed: (pose) => placed.push(pose),
      ended: () => {
        ends++;
      },
    },
    { set: (callback) => waiting.push(callback), clear: (handle) => waiting.splice(handle - 1, 1, () => {}) },
    () => 5,
  );
  const settle = (): void => {
    for (const callback of waiting.splice(0)) callback();
  };
  return { hand, placed, settle, moves: () => moves, ends: () => ends };
}

test("a wish goes out once, with the earliest input's time and the last pose", () => {
  const { hand } = setUp();
  hand.answered(IDENTITY, 0);
  hand.move(translation([1, 0, 0]), "mouse", 10);
  hand.move(translation([2, 0, 0]), "mouse", 12);
  const wish = hand.take();
  assert.equal(wish?.time_ms, 10);
  assert.deepEqual(wish && position(wish.pose), [2, 0, 0]);
  assert.equal(hand.take(), null);
});

test("a pose that is put down is placed once the engine answered the last wish and the tool stands", () => {
  const { hand, placed, settle } = setUp();
  hand.answered(IDENTITY, 0);
  hand.move(translation([1, 0, 0]), "mouse");
  hand.put();
  hand.answered(translation([0.2, 0, 0]), 0);
  settle();
  assert.equal(placed.length, 0, "the wish has not gone out yet");
  hand.take();
  hand.sentAs(7);
  hand.answered(translation([0.3, 0, 0]), 6);
  settle();
  assert.equal(placed.length, 0, "an answer to an older wish does not count");
  hand.answered(translation([0.4, 0, 0]), 7);
  settle();
  assert.deepEqual(placed.map(position), [[0.4, 0, 0]], "stopped by a contact: where the tool stands");
  assert.equal(hand.wish, null);
});

test("a wish that was reached is placed at once", () => {
  const { hand, placed } = setUp();
  hand.answered(IDENTITY, 0);
  hand.move(translation([1, 0, 0]), "keys");
  hand.take();
  hand.sentAs(1);
  hand.put();
  hand.answered(translation([1, 0, 0]), 1);
  assert.equal(placed.length, 1);
});

test("a movement that is given up goes back and places nothing", () => {
  const { hand, placed, settle } = setUp();
  hand.answered(IDENTITY, 0);
  hand.move(translation([1, 0, 0]), "keys");
  hand.take();
  hand.sentAs(1);
  hand.cancel(IDENTITY, "keys");
  assert.ok(isSamePose(hand.take()?.pose ?? [], IDENTITY));
  hand.sentAs(2);
  hand.answered(IDENTITY, 2);
  settle();
  assert.equal(placed.length, 0);
  assert.equal(hand.wish, null);
});

test("who waits for a movement to be put down is told once that it is over, after it was placed", () => {
  const { hand, placed, settle, ends } = setUp();
  hand.answered(IDENTITY, 0);
  const put = (): void => {
    hand.move(translation([1, 0, 0]), "mouse");
    hand.take();
    hand.sentAs(1);
    hand.put();
    assert.ok(hand.isPutting);
  };
  put();
  settle();
  assert.deepEqual([hand.isPutting, placed.length, ends()], [false, 1, 1]);
  put();
  hand.finish();
  assert.deepEqual([hand.isPutting, placed.length, ends()], [false, 2, 2]);
  hand.finish();
  hand.drop();
  assert.equal(ends(), 2, "there is nothing to end");
  put();
  hand.drop();
  assert.deepEqual([hand.isPutting, placed.length, ends()], [false, 2, 3]);
  put();
  hand.move(translation([2, 0, 0]), "mouse");
  assert.deepEqual([hand.isPutting, placed.length, ends()], [false, 2, 4]);
});

test("increments move along the frame's axes and turn about the pivot", () => {
  const { hand } = setUp();
  hand.answered(multiply(translation([1, 2, 3]), rotation([0, 0, 1], Math.PI / 2)), 0);
  hand.pivot = [0.5, 0, 0];
  hand.nudge({ translation: [0.1, 0, 0], rotation: [0, 0, 0] }, "tool", "spacemouse");
  assert.ok(isSamePose([...position(hand.pose ?? []), ...Array(13).fill(0)], [1, 2.1, 3, ...Array(13).fill(0)], 1e-12));
  const before = hand.center;
  hand.nudge({ translation: [0, 0, 0], rotation: [0.3, 0.2, -0.4] }, "tool", "spacemouse");
  const after = hand.center;
  for (const k of [0, 1, 2] as const) assert.ok(Math.abs((before?.[k] ?? 9) - (after?.[k] ?? 0)) < 1e-12);
  hand.viewAxes = () => fromAxes([0, 1, 0], [0, 0, 1], [1, 0, 0], [0, 0, 0]);
  const at = position(hand.pose ?? []);
  hand.nudge({ translation: [1, 0, 0], rotation: [0, 0, 0] }, "view", "gamepad");
  assert.ok(Math.abs(position(hand.pose ?? [])[1] - at[1] - 1) < 1e-12, "right of the picture is y");
});

/** The pose times its turn back: the identity for one whose axes are of unit length at right angles. */
const squared = (pose: Pose): Pose =>
  multiply(fromAxes(axis(pose, 0), axis(pose, 1), axis(pose, 2), [0, 0, 0]), [
    ...[...axis(pose, 0), 0, ...axis(pose, 1), 0],
    ...[...axis(pose, 2), 0, 0, 0, 0, 1],
  ]);

test("many small turns, and a pose that is bent a little, go out rigid", () => {
  const { hand } = setUp();
  hand.answered(IDENTITY, 0);
  for (let k = 0; k < 20_000; k++) {
    hand.nudge({ translation: [0, 0, 0], rotation: [0.01, 0.02, 0.03] }, "tool", "spacemouse");
  }
  assert.ok(isSamePose(squared(hand.pose ?? []), IDENTITY, 1e-12));
  const bent = [...rotation([0.6, 0, 0.8], 1)];
  bent[1] = (bent[1] ?? 0) + 1e-4;
  hand.move(bent, "api");
  assert.ok(isSamePose(squared(hand.take()?.pose ?? []), IDENTITY, 1e-12));
});

test("a hand that is locked, and numbers that are none, move nothing", () => {
  const { hand, moves } = setUp();
  hand.answered(IDENTITY, 0);
  hand.isLocked = true;
  hand.move(translation([1, 0, 0]), "mouse");
  hand.isLocked = false;
  hand.move(translation([Number.NaN, 0, 0]), "api");
  assert.equal(hand.take(), null);
  assert.equal(moves(), 0);
});
