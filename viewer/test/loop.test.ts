import assert from "node:assert/strict";
import { test } from "node:test";
import { Workbench } from "../src/actions/workbench";
import { type Browser, Loop } from "../src/app/loop";
import { Recent } from "../src/app/recent";
import type { Link, Wish } from "../src/link/link";
import type { State } from "../src/link/protocol";
import { IDENTITY, position, translation } from "../src/math/matrix";
import { Hand } from "../src/model/hand";
import { Store } from "../src/model/store";
import type { FrameStats, Stage } from "../src/scene/stage";

function setUp() {
  let now = 0;
  let frame: ((now: number) => void) | null = null;
  let is_hidden = false;
  const browser: Browser = {
    requestFrame: (callback) => {
      assert.equal(frame, null, "one request at a time");
      frame = callback;
    },
    now: () => now,
    isHidden: () => is_hidden,
  };
  const stats: FrameStats = {
    drawn: true,
    ms: 1,
    calls: 1,
    triangles: 1,
    isKept: true,
    isWhole: true,
    isSettled: true,
    isShown: true,
    isPictured: true,
  };
  const poses: (readonly [number[], number[] | null])[] = [];
  const lit: Uint8Array[] = [];
  const frames = { count: 0 };
  const stage = {
    setPose: (pose: ArrayLike<number>, wish: ArrayLike<number> | null) => {
      poses.push([Array.from(pose), wish && Array.from(wish)]);
    },
    setPartStates: (states: Uint8Array) => lit.push(states),
    setHits() {},
    setMarks() {},
    setHeat() {},
    frame: () => {
      frames.count++;
      return stats;
    },
    stats,
  } as unknown as Stage;
  const sent: Wish[] = [];
  const link = { pose: (wish: Wish) => sent.push(wish) } as unknown as Link;
  let loop: Loop;
  const hand = new Hand(
    { moved: () => loop.wished(), placed() {}, ended() {} },
    { set: () => 0, clear() {} },
    () => now,
  );
  const store = new Store();
  const wb = new Workbench({
    store,
    stage,
    hand,
    link,
    redraw: () => loop.request(),
    fetchFile: () => Promise.reject(new Error("none")),
  });
  loop = new Loop(wb, null, null, browser);
  return {
    loop,
    hand,
    store,
    sent,
    poses,
    lit,
    frames,
    stats,
    hide: () => {
      is_hidden = true;
    },
    /** Lets time pass, and draws the frame that was asked for; whether there was one. */
    step(ms: number): boolean {
      now += ms;
      const callback = frame;
      frame = null;
      callback?.(now);
      return callback !== null;
    },
    at: (ms: number) => {
      now = ms;
    },
  };
}

const state = (pose: readonly number[], pose_seq: number, parts: number[] = []): State =>
  ({
    kind: "state",
    seq: pose_seq,
    pose_seq,
    mode: "stop",
    pose: Float64Array.from(pose),
    parts,
    force: [0, 0, 0],
    depth: 0,
    depth_kind: "exact",
    distance: null,
    contact_more: 0,
    hits: new Uint32Array(0),
    tool_hits: new Uint32Array(0),
    planes: new Float32Array(0),
    plane_parts: new Uint32Array(0),
    clearance: new Float32Array(0),
    clearance_parts: new Uint32Array(0),
  }) as unknown as State;

test("a page at rest asks for no frame", () => {
  const page = setUp();
  assert.equal(page.step(16), false);
  page.loop.request();
  page.stats.drawn = false;
  let frames = 0;
  while (page.step(16)) frames++;
  assert.ok(frames > 1 && frames < 60, "it lingers for the stage to finish, then stops");
});

test("the first wish of a frame goes out at once, the others with the next frame, as one", () => {
  const page = setUp();
  page.loop.answered(state(IDENTITY, 0));
  page.step(16);
  for (const x of [1, 2, 3]) page.hand.move(translation([x, 0, 0]), "mouse");
  assert.deepEqual(
    page.sent.map((wish) => position(wish.pose)[0]),
    [1],
  );
  page.step(16);
  assert.deepEqual(
    page.sent.map((wish) => position(wish.pose)[0]),
    [1, 3],
  );
  // The wish that a frame sent is the frame's own: the next one waits, and after a frame without one it does not.
  page.hand.move(translation([4, 0, 0]), "mouse");
  assert.equal(page.sent.length, 2);
  page.step(16);
  page.step(16);
  page.hand.move(translation([5, 0, 0]), "mouse");
  assert.equal(page.sent.length, 4);
});

test("in a hidden tab, which draws no frames, wishes go out all the same", () => {
  const page = setUp();
  page.hide();
  for (const x of [1, 2]) page.hand.move(translation([x, 0, 0]), "gamepad");
  assert.equal(page.sent.length, 2);
});

test("the hand is drawn at once as a ghost, the tool where the engine has it", () => {
  const page = setUp();
  page.loop.answered(state(IDENTITY, 0));
  page.step(16);
  page.hand.move(translation([1, 0, 0]), "mouse");
  page.step(16);
  assert.deepEqual(page.poses.at(-1), [[...IDENTITY], translation([1, 0, 0])]);
  page.loop.answered(state(translation([1, 0, 0]), 1));
  page.step(16);
  assert.deepEqual(page.poses.at(-1), [translation([1, 0, 0]), null], "no ghost where the tool is");
  const told = page.poses.length;
  page.step(16);
  assert.equal(page.poses.length, told, "a pose that is drawn is not told again");
});

test("the time from an input to the picture of its answer is measured", () => {
  const page = setUp();
  page.loop.answered(state(IDENTITY, 0));
  page.step(16);
  page.hand.move(translation([1, 0, 0]), "mouse", 10);
  page.at(20);
  page.loop.answered(state(translation([1, 0, 0]), 1));
  page.step(13);
  assert.deepEqual(page.loop.input_to_drawn.values, [23]);
});

test("a wish that was lost with the connection has no time", () => {
  const page = setUp();
  page.loop.answered(state(IDENTITY, 0));
  page.step(16);
  page.hand.move(translation([1, 0, 0]), "mouse", 10);
  page.loop.forget();
  page.loop.answered(state(translation([1, 0, 0]), 1));
  page.step(13);
  assert.deepEqual(page.loop.input_to_drawn.values, []);
});

test("frames of a run are counted from one to the next", () => {
  const page = setUp();
  page.loop.request();
  page.step(1000);
  page.step(17);
  page.step(20);
  assert.deepEqual(page.loop.frames.values, [0, 17, 20]);
});

test("what the engine touches is lit over the states of the parts, and told once", () => {
  const page = setUp();
  page.loop.setPartStates(Uint8Array.from([0, 1, 16]));
  page.loop.answered(state(IDENTITY, 0, [2]));
  page.step(16);
  assert.deepEqual([...(page.lit.at(-1) ?? [])], [0, 1, 24]);
  const told = page.lit.length;
  page.loop.answered(state(translation([1, 0, 0]), 1, [2]));
  page.step(16);
  assert.equal(page.lit.length, told);
  page.loop.forget();
  page.step(16);
  assert.deepEqual([...(page.lit.at(-1) ?? [])], [0, 1, 16]);
});

test("panels follow at most ten times a second, and get the last state", () => {
  const page = setUp();
  let changes = 0;
  page.store.state.subscribe(() => {
    changes++;
  });
  for (let k = 1; k <= 60; k++) {
    page.loop.answered(state(translation([k, 0, 0]), k));
    page.step(10);
  }
  assert.ok(changes <= 8, `${changes}`);
  page.stats.drawn = false;
  while (page.step(16)) {}
  assert.equal(page.store.state.value?.pose_seq, 60);
});

test("what is polled keeps the frames coming only as long as it wants", () => {
  const page = setUp();
  let left = 100;
  page.loop.each_frame.add(() => left-- > 0);
  page.stats.drawn = false;
  page.loop.request();
  let frames = 0;
  while (page.step(16)) frames++;
  assert.ok(frames >= 100 && frames < 140);
});

test("what waits for a picture is asked once it is drawn, and gets another as long as it wants", () => {
  const page = setUp();
  const seen: number[] = [];
  page.loop.after_frame.add(() => seen.push(page.frames.count) < 100);
  page.stats.drawn = false;
  page.loop.request();
  while (page.step(16)) {}
  assert.deepEqual(
    seen.slice(0, 100),
    Array.from({ length: 100 }, (_, k) => k + 1),
  );
  assert.ok(seen.length < 140);
});

test("the last two hundred are kept", () => {
  const recent = new Recent();
  for (let k = 0; k < 250; k++) recent.add(k);
  assert.deepEqual([recent.values.length, recent.values[0]], [200, 50]);
});
