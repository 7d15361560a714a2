import assert from "node:assert/strict";
import { test } from "node:test";
import { HEAT_REACH_M, heatAt, heatField } from "../src/math/heat-field";
import type { Vec3 } from "../src/math/vectors";

/** A box as a mesh, and the exact distance to its surface. */
function box(half: Vec3) {
  const positions = new Float32Array(24);
  for (let bits = 0; bits < 8; bits++)
    for (let k = 0; k < 3; k++) positions[3 * bits + k] = (bits >> k) & 1 ? (half[k] as number) : -(half[k] as number);
  const quads = [
    [0, 1, 3, 2],
    [4, 6, 7, 5],
    [0, 4, 5, 1],
    [2, 3, 7, 6],
    [0, 2, 6, 4],
    [1, 5, 7, 3],
  ] as const;
  const indices = Uint16Array.from(quads.flatMap(([a, b, c, d]) => [a, b, c, a, c, d]));
  const exact = (p: Vec3): number => {
    const out = p.map((value, k) => Math.abs(value) - (half[k] as number)) as Vec3;
    const beyond = Math.hypot(...out.map((value) => Math.max(value, 0)));
    return beyond > 0 ? beyond : -Math.max(...out);
  };
  return { piece: { positions, indices }, exact, lower: half.map((value) => -value) as Vec3, upper: half };
}

test("the field gives the distance to the surface, to a cell", () => {
  for (const half of [
    [0.02, 0.005, 0.15],
    [0.05, 0.05, 0.05],
    [0.4, 0.3, 0.2],
  ] as Vec3[]) {
    const { piece, exact, lower, upper } = box(half);
    const field = heatField([piece], lower, upper);
    let worst = 0;
    let seen = 0;
    let seed = 7;
    const random = () => {
      seed = (seed * 16807) % 2147483647;
      return seed / 2147483647;
    };
    for (let k = 0; k < 4000; k++) {
      const p = half.map((value) => (2 * random() - 1) * (value + HEAT_REACH_M)) as Vec3;
      const distance = exact(p);
      if (distance > HEAT_REACH_M) continue;
      seen++;
      worst = Math.max(worst, Math.abs(heatAt(field, p) - distance));
    }
    assert.ok(seen > 200);
    assert.ok(worst < field.cell, `${worst} of a cell of ${field.cell}`);
    assert.ok(field.data.length < 600_000);
  }
});

test("beyond the field nothing is near, and an empty mesh is far from everything", () => {
  const { piece, lower, upper } = box([0.02, 0.02, 0.02]);
  const field = heatField([piece], lower, upper);
  assert.equal(heatAt(field, [1, 0, 0]), Infinity);
  const empty = heatField([], lower, upper);
  assert.ok(heatAt(empty, [0, 0, 0]) >= HEAT_REACH_M);
});
