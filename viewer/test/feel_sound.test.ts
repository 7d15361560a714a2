import assert from "node:assert/strict";
import { test } from "node:test";
import { MATERIALS, type Material } from "../src/feel/materials";
import { modesOf, noiseSamples, slideSound, softClip } from "../src/feel/sound";

const ALL = Object.keys(MATERIALS) as Material[];
const first = (material: Material, size_m: number, speed = 0.1) => {
  const mode = modesOf(material, size_m, speed, 1)[0];
  assert.ok(mode);
  return mode;
};

test("larger parts sound lower and ring longer", () => {
  for (const material of ["steel", "aluminium", "plastic"] as const) {
    const small = first(material, 0.05);
    const large = first(material, 0.5);
    assert.ok(small.frequency_hz > 5 * large.frequency_hz, material);
    assert.ok(small.decay_s < large.decay_s, material);
  }
});

test("a steel bar of 0.3 m has its first mode at 1.44 kHz, a free bar's ratios above", () => {
  const modes = modesOf("steel", 0.3, 0.1, 1);
  assert.ok(Math.abs((modes[0]?.frequency_hz ?? 0) - 1443) < 1);
  assert.ok(Math.abs((modes[1]?.frequency_hz ?? 0) / (modes[0]?.frequency_hz ?? 1) - 2.757) < 1e-9);
});

test("metal rings, plastic clacks, rubber thuds", () => {
  const cycles = ALL.map((material) => first(material, 0.1).decay_s * first(material, 0.1).frequency_hz);
  assert.deepEqual(
    cycles,
    [...cycles].sort((a, b) => b - a),
  );
  assert.ok(first("steel", 0.1).decay_s > 5 * first("plastic", 0.1).decay_s);
  assert.ok(first("steel", 0.1).frequency_hz > 20 * first("rubber", 0.1).frequency_hz);
});

test("gains sum to the strength, and all can be heard and played", () => {
  for (const material of ALL) {
    for (const size of [0, 1e-4, 0.01, 0.1, 1, 100]) {
      for (const speed of [0, 1e-3, 0.1, 10]) {
        const modes = modesOf(material, size, speed, 0.6);
        assert.ok(modes.length >= 1 && modes.length <= 5);
        assert.ok(Math.abs(modes.reduce((sum, mode) => sum + mode.gain, 0) - 0.6) < 1e-12);
        for (const { frequency_hz, decay_s } of modes) {
          assert.ok(frequency_hz >= 60 && frequency_hz <= 14000, `${material} ${size}: ${frequency_hz} Hz`);
          assert.ok(decay_s >= 0.004 && decay_s <= 0.5);
        }
      }
    }
  }
});

test("a faster strike is brighter", () => {
  const high = (speed: number) => modesOf("steel", 0.3, speed, 1)[3]?.gain ?? 0;
  assert.ok(high(1) > 1.1 * high(0.01));
});

test("sliding is silent at rest and without force, louder and higher by speed, louder by force", () => {
  const slide = (speed_m_per_s: number, force_n: number, material: Material = "steel") =>
    slideSound({ speed_m_per_s, force_n, material });
  assert.equal(slide(0, 5).gain, 0);
  assert.equal(slide(0.1, 0).gain, 0);
  assert.ok(slide(0.1, 5).gain > slide(0.02, 5).gain);
  assert.ok(slide(0.1, 5).gain > slide(0.1, 0.5).gain);
  assert.ok(slide(0.1, 5).frequency_hz > slide(0.02, 5).frequency_hz);
  assert.ok(slide(0.1, 5).frequency_hz > slide(0.1, 5, "rubber").frequency_hz);
  assert.ok(slide(0.1, 50).quality > slide(0.1, 1).quality);
  assert.ok(slide(100, 1e6).gain <= 0.25);
  assert.ok(slide(100, 1).frequency_hz <= 6000);
});

test("the noise is white: full range, no mean, no memory", () => {
  const samples = noiseSamples(96000);
  const mean = (f: (k: number) => number) => samples.reduce((sum, _, k) => sum + f(k), 0) / samples.length;
  assert.ok(samples.every((sample) => Math.abs(sample) <= 1));
  assert.ok(Math.abs(mean((k) => samples[k] ?? 0)) < 0.01);
  assert.ok(Math.abs(mean((k) => (samples[k] ?? 0) ** 2) - 1 / 3) < 0.01);
  assert.ok(Math.abs(mean((k) => (samples[k] ?? 0) * (samples[k + 1] ?? 0))) < 0.01);
});

test("what is loud bends, what is soft stays as it is", () => {
  const curve = softClip();
  assert.equal(curve[512], 0);
  assert.ok(Math.abs((curve[640] ?? 0) - 0.25) < 1e-6);
  assert.ok((curve[1024] ?? 2) < 1);
  for (let k = 1; k < curve.length; k++) assert.ok((curve[k] ?? 0) > (curve[k - 1] ?? 0));
});
