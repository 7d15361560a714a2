import assert from "node:assert/strict";
import { test } from "node:test";
import { GamepadInput, type PadCommand, type PadReading, ratesOf } from "../src/input/gamepad";
import { curved, curvedStick } from "../src/input/rate";
import type { Increment } from "../src/model/hand";

const STRAIGHT = { isOn: true, dead_zone: 0, bend: 0 };

function pad(axes: number[] = [0, 0, 0, 0], pressed: Record<number, number> = {}, mapping = "standard"): PadReading {
  const buttons = Array.from({ length: 17 }, (_, k) => ({ pressed: (pressed[k] ?? 0) > 0.5, value: pressed[k] ?? 0 }));
  return { id: "pad", index: 0, connected: true, mapping, axes, buttons };
}

function bench() {
  const nudges: Increment[] = [];
  const commands: PadCommand[] = [];
  const notices: string[] = [];
  const counts = { puts: 0 };
  const pads: (PadReading | null)[] = [null];
  const input = new GamepadInput(
    {
      target: () => ({
        nudge: (increment, frame, source) => {
          assert.deepEqual([frame, source], ["view", "gamepad"]);
          nudges.push(increment);
        },
        put: () => {
          counts.puts++;
        },
      }),
      speeds: () => ({ translation_m_per_s: 0.2, rotation_rad_per_s: 2 }),
      command: (command) => commands.push(command),
      notice: (text) => notices.push(text),
    },
    () => pads,
  );
  return { input, pads, nudges, commands, notices, counts };
}

test("each stick and trigger moves its own freedom, in the view's directions", () => {
  const rates = (reading: PadReading) => {
    const { translation, rotation } = ratesOf(reading, STRAIGHT);
    return [...translation, ...rotation].map((value) => value || 0);
  };
  assert.deepEqual(rates(pad([1, 0, 0, 0])), [1, 0, 0, 0, 0, 0]);
  assert.deepEqual(rates(pad([0, -1, 0, 0])), [0, 1, 0, 0, 0, 0]);
  assert.deepEqual(rates(pad(undefined, { 6: 1 })), [0, 0, 1, 0, 0, 0]);
  assert.deepEqual(rates(pad(undefined, { 7: 1 })), [0, 0, -1, 0, 0, 0]);
  assert.deepEqual(rates(pad([0, 0, 0, 1])), [0, 0, 0, 1, 0, 0]);
  assert.deepEqual(rates(pad([0, 0, 1, 0])), [0, 0, 0, 0, 1, 0]);
  assert.deepEqual(rates(pad(undefined, { 4: 1 })), [0, 0, 0, 0, 0, 1]);
  assert.deepEqual(rates(pad(undefined, { 5: 1 })), [0, 0, 0, 0, 0, -1]);
});

test("the dead zone is rest, begins at nothing and ends at full", () => {
  assert.equal(curved(0.1, 0.12, 0.7), 0);
  assert.ok(curved(0.1201, 0.12, 0.7) < 1e-3);
  assert.equal(curved(1, 0.12, 0.7), 1);
  assert.equal(curved(-1.1, 0.12, 0.7), -1);
  assert.equal(curved(Number.NaN, 0.12, 0.7), 0);
  assert.ok(curved(0.5, 0, 0.7) < 0.5);
});

test("a stick's dead zone is a circle: a slanted push keeps its direction", () => {
  const [x, y] = curvedStick(0.6, 0.1, 0.12, 0.7);
  assert.ok(Math.abs(y / x - 1 / 6) < 1e-12);
  assert.deepEqual(curvedStick(0.08, 0.08, 0.12, 0.7), [0, 0]);
  const [a, b] = curvedStick(1, 1, 0.12, 0.7);
  assert.ok(Math.hypot(a, b) <= 1 + 1e-12);
});

test("the hand moves by speed and time, and is put down once at rest", () => {
  const { input, pads, nudges, counts } = bench();
  pads[0] = pad([1, 0, 0, 0]);
  for (let k = 0; k <= 10; k++) input.frame(1000 + 10 * k);
  const way = nudges.slice(1).reduce((sum, each) => sum + each.translation[0], 0);
  assert.ok(Math.abs(way - 0.2 * 0.1) < 1e-12);
  assert.equal(counts.puts, 0);
  pads[0] = pad();
  input.frame(1110);
  input.frame(1120);
  assert.equal(counts.puts, 1);
  assert.equal(nudges.length, 11);
});

test("a late frame does not fling the tool, and time does not run backwards", () => {
  const { input, pads, nudges } = bench();
  pads[0] = pad([1, 0, 0, 0]);
  for (const now of [1000, 9000, 8000]) input.frame(now);
  assert.ok((nudges[1]?.translation[0] ?? 1) <= 0.2 * 0.05 + 1e-12);
  assert.equal(nudges[2]?.translation[0], 0);
});

test("a button gives its command once a press, and none that was held when the pad was first seen", () => {
  const { input, pads, commands } = bench();
  pads[0] = pad(undefined, { 1: 1 });
  input.frame(0);
  for (const buttons of [{ 0: 1 }, { 0: 1 }, {}, { 0: 1, 2: 1 }, { 1: 1, 3: 1 }]) {
    pads[0] = pad(undefined, buttons);
    input.frame(0);
  }
  assert.deepEqual(commands, ["grip", "grip", "mode", "undo", "redo"]);
});

test("the cross changes the speed within bounds", () => {
  const { input, pads, nudges } = bench();
  const press = (button: number) => {
    pads[0] = pad(undefined, { [button]: 1 });
    input.frame(0);
    pads[0] = pad();
    input.frame(0);
  };
  input.frame(0);
  pads[0] = pad();
  input.frame(0);
  press(13);
  assert.equal(input.gear, 0.5);
  pads[0] = pad([1, 0, 0, 0]);
  input.frame(100);
  assert.ok(Math.abs((nudges[0]?.translation[0] ?? 0) - (0.5 * 0.2) / 60) < 1e-12);
  for (let k = 0; k < 20; k++) press(12);
  assert.equal(input.gear, 4);
  for (let k = 0; k < 20; k++) press(13);
  assert.equal(input.gear, 1 / 16);
});

test("frames are wanted only while a pad is there, and an unknown mapping is told once", () => {
  const { input, pads, nudges, notices } = bench();
  assert.equal(input.frame(0), false);
  pads[0] = pad([1, 0, 0, 0], {}, "");
  assert.equal(input.frame(0), false);
  input.frame(0);
  assert.equal(notices.length, 1);
  pads[0] = pad([1, 0, 0, 0], {}, "xr-standard");
  assert.equal(input.frame(0), false);
  assert.equal(notices.length, 1);
  assert.equal(nudges.length, 0);
  pads[0] = pad();
  assert.equal(input.frame(0), true);
});

test("switched off, or unplugged while it moves, it puts the hand down", () => {
  const { input, pads, counts, nudges } = bench();
  pads[0] = pad([1, 0, 0, 0]);
  input.frame(0);
  input.settings.isOn = false;
  assert.equal(input.frame(10), false);
  assert.equal(counts.puts, 1);
  input.settings.isOn = true;
  input.frame(20);
  pads[0] = null;
  input.frame(30);
  assert.equal(counts.puts, 2);
  assert.equal(nudges.length, 2);
});
