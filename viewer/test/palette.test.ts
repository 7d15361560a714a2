import assert from "node:assert/strict";
import { test } from "node:test";
import { paletteTexture, toned } from "../src/scene/palette";

const lightness = ([r, g, b]: [number, number, number]) => 0.3 * r + 0.59 * g + 0.11 * b;

test("a stated colour keeps its hue and its place between dark and light", () => {
  const [r, g, b] = toned(0x204080) ?? [0, 0, 0];
  assert.ok(r < g && g < b);
  const greys = [0x000000, 0x1a1a1c, 0x808080, 0xffffff].map((stated) => lightness(toned(stated) ?? [0, 0, 0]));
  assert.deepEqual(
    greys,
    [...greys].sort((a, b) => a - b),
  );
  assert.ok((greys[0] ?? 0) >= 40, "shades and edges are seen on black");
  assert.ok((greys[3] ?? 255) <= 235, "light is seen on white");
});

test("what is no colour is none: the part gets one of the page's own", () => {
  for (const wrong of [-1, 0x1000000, 0.5, Number.NaN, Number.POSITIVE_INFINITY, null, undefined, "16711680", [255]])
    assert.equal(toned(wrong), null);
});

test("a part has a texel, however few or many colours came", () => {
  const data = (count: number, stated?: unknown[]) => paletteTexture(count, stated).image.data as Uint8Array;
  const opacities = (...args: Parameters<typeof data>) =>
    Array.from({ length: args[0] }, (_, part) => data(...args)[4 * part + 3]);
  assert.deepEqual(opacities(3, [0xff0000, -1, 0]), [255, 0, 255]);
  assert.deepEqual(opacities(3, [0xff0000]), [255, 0, 0]);
  assert.deepEqual(opacities(2, [1, 2, 3, 4]), [255, 255]);
  assert.deepEqual(opacities(2, undefined), [0, 0]);
  assert.equal(data(0, [1]).length, 4 * 1024);
  assert.equal(data(1025, []).length, 4 * 2048);
  const many = Array.from({ length: 2000 }, (_, part) => part);
  assert.deepEqual([...data(2000, many).subarray(4 * 1999, 4 * 2000)], [...(toned(1999) ?? []), 255]);
});
