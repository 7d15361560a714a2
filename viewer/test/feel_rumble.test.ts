import assert from "node:assert/strict";
import { test } from "node:test";
import type { Felt, Impact } from "../src/feel/events";
import type { Material } from "../src/feel/materials";
import { burstOf, humOf, type Magnitudes, outputOf, outputsOf, Rumble, type RumbleOutput } from "../src/feel/rumble";

const impact = (strength: number, part_size_m = 0.1, material: Material = "steel"): Impact => ({
  ...{ part: 1, part_size_m, material, speed_m_per_s: 0.1, force_n: 1, point: [0, 0, 0], strength },
});
const felt = (parts: Partial<Felt> = {}): Felt => ({
  impacts: [],
  releases: [],
  slide: { speed_m_per_s: 0, force_n: 0, material: "steel" },
  press_n: 0,
  ...parts,
});

class FakeOutput implements RumbleOutput {
  readonly played: (Magnitudes & { duration_ms: number })[] = [];
  stops = 0;
  play(magnitudes: Magnitudes, duration_ms: number): void {
    this.played.push({ ...magnitudes, duration_ms });
  }
  stop(): void {
    this.stops++;
  }
}

/** Frames of 10 ms from `from_ms` on. */
function run(rumble: Rumble, from_ms: number, frames: number, each: Felt = felt()): void {
  for (let k = 0; k < frames; k++) rumble.play(each, from_ms + 10 * k);
}

test("a burst dies away and then the device is stopped, once", () => {
  const output = new FakeOutput();
  const rumble = new Rumble(() => [output]);
  assert.equal(rumble.play(felt({ impacts: [impact(0.8)] }), 1000), true);
  assert.equal(rumble.play(felt(), 1005), true, "frames are wanted while it dies away");
  run(rumble, 1010, 100);
  assert.equal(rumble.play(felt(), 2010), false);
  const strengths = output.played.map((each) => each.strong);
  assert.ok(strengths.length > 3);
  for (let k = 1; k < strengths.length; k++) assert.ok((strengths[k] ?? 1) < (strengths[k - 1] ?? 0));
  assert.ok(Math.abs((strengths[0] ?? 0) - 0.8 * 0.65) < 1e-9);
  assert.equal(output.stops, 1);
});

test("a device is told at most every 40 ms, and a rise at once", () => {
  const output = new FakeOutput();
  const rumble = new Rumble(() => [output]);
  run(rumble, 1000, 10, felt({ press_n: 10 }));
  assert.equal(output.played.length, 3);
  rumble.play(felt({ press_n: 10, impacts: [impact(1)] }), 1095);
  assert.equal(output.played.length, 4);
});

test("each telling ends by itself soon after the next is due", () => {
  const output = new FakeOutput();
  const rumble = new Rumble(() => [output]);
  run(rumble, 1000, 1, felt({ press_n: 10 }));
  const duration = output.played[0]?.duration_ms ?? 0;
  assert.ok(duration > 40 && duration <= 200);
});

test("large parts drive the strong motor, small ones the weak one, rubber is dull", () => {
  const large = burstOf(impact(1, 1), 0);
  const small = burstOf(impact(1, 0.01), 0);
  assert.ok(large.strong > large.weak && small.weak > small.strong);
  assert.ok(large.decay_ms > small.decay_ms);
  const soft = burstOf(impact(1, 0.01, "rubber"), 0);
  assert.ok(soft.weak < small.weak / 2);
  assert.ok(soft.decay_ms > small.decay_ms);
});

test("the hum grows with force and sliding and leaves room for bursts", () => {
  const slide = (speed_m_per_s: number, force_n: number) => ({ speed_m_per_s, force_n, material: "steel" as const });
  const hum = (press_n: number, speed = 0) => humOf({ press_n, slide: slide(speed, press_n) });
  assert.deepEqual(hum(0), { strong: 0, weak: 0 });
  assert.ok(hum(20).strong > hum(5).strong);
  assert.equal(hum(20).weak, 0);
  assert.ok(hum(20, 0.1).weak > hum(20, 0.01).weak);
  assert.ok(hum(1e9, 1e9).strong <= 0.4 && hum(1e9, 1e9).weak <= 0.4);
});

test("many at once stay within the motors' range", () => {
  const output = new FakeOutput();
  const rumble = new Rumble(() => [output]);
  rumble.play(felt({ impacts: Array.from({ length: 20 }, () => impact(1)), press_n: 100 }), 1000);
  assert.deepEqual([output.played[0]?.strong, output.played[0]?.weak], [1, 1]);
});

test("a release is a short tick of the weak motor", () => {
  const output = new FakeOutput();
  const rumble = new Rumble(() => [output]);
  rumble.play(felt({ releases: [3, 4] }), 1000);
  assert.deepEqual([output.played[0]?.strong, output.played[0]?.weak], [0, 0.25]);
});

test("each switch switches off its own, the main one stops what runs", () => {
  const output = new FakeOutput();
  const rumble = new Rumble(() => [output]);
  const both = felt({ impacts: [impact(1)], press_n: 20 });
  rumble.settings.hasForce = false;
  assert.equal(rumble.magnitudes(both, 0).strong, 0);
  rumble.settings.hasForce = true;
  rumble.settings.hasEvents = false;
  rumble.play(both, 1000);
  assert.ok((output.played[0]?.strong ?? 1) <= 0.4);
  rumble.settings.isOn = false;
  rumble.play(both, 1010);
  assert.equal(output.stops, 1);
  run(rumble, 1020, 50, both);
  assert.equal(output.played.length, 1);
  rumble.settings.isOn = true;
  rumble.play(felt(), 2000);
  assert.equal(output.played.length, 1);
});

test("a device that goes is stopped, one that comes is told", () => {
  const [old, fresh] = [new FakeOutput(), new FakeOutput()];
  let outputs = [old];
  const rumble = new Rumble(() => outputs);
  run(rumble, 1000, 1, felt({ press_n: 20 }));
  outputs = [fresh];
  run(rumble, 1100, 1, felt({ press_n: 20 }));
  assert.equal(old.stops, 1);
  assert.equal(fresh.played.length, 1);
});

test("gamepads get dual rumble, controllers a pulse, and a refusal is borne", async () => {
  const calls: unknown[] = [];
  const refused = () => Promise.reject(new Error("unplugged"));
  const vibrationActuator = {
    playEffect: (...given: unknown[]) => {
      calls.push(given);
      return refused();
    },
    reset: refused,
  };
  const pulsing = {
    pulse: (...given: unknown[]) => {
      calls.push(given);
      return refused();
    },
  };
  const pad = { vibrationActuator };
  const controller = { vibrationActuator: null, hapticActuators: [pulsing] };
  const [first, second] = outputsOf([null, pad, {}, controller]);
  first?.play({ strong: 0.5, weak: 0.2 }, 100);
  second?.play({ strong: 0.1, weak: 0.7 }, 100);
  first?.stop();
  second?.stop();
  assert.deepEqual(calls, [
    ["dual-rumble", { duration: 100, strongMagnitude: 0.5, weakMagnitude: 0.2 }],
    [0.7, 100],
    [0, 1],
  ]);
  assert.equal(outputOf(pad), first);
  // An unhandled rejection would fail the test.
  await new Promise((resolve) => setImmediate(resolve));
});
