// Pieces with copies as Python wrote them (testdata/workbench; tests/test_shared_pieces.py reads them too).

import assert from "node:assert/strict";
import { readFileSync } from "node:fs";
import { test } from "node:test";
import { SharedShapes } from "../src/link/shared";

function golden(name: string): ArrayBuffer {
  const bytes = readFileSync(new URL(`../../testdata/workbench/${name}`, import.meta.url));
  return bytes.buffer.slice(bytes.byteOffset, bytes.byteOffset + bytes.length) as ArrayBuffer;
}

const bytesOf = (data: ArrayBuffer): Buffer => Buffer.from(data);

test("copies come back as the server packed them", () => {
  const sent = golden("shared.bin");
  const made = new SharedShapes().whole(sent, 2);
  assert.deepEqual(bytesOf(made), bytesOf(golden("shared_whole.bin")));
});

test("a piece without copies is left as it is", () => {
  const plain = golden("shared_whole.bin");
  assert.equal(new SharedShapes().whole(plain, 2), plain);
  assert.equal(new SharedShapes().whole(new ArrayBuffer(0), 2).byteLength, 0);
});

test("shapes are used in later pieces, and one that did not come is an error", () => {
  const shapes = new SharedShapes();
  const words = (kind: number): ArrayBuffer => {
    const data = new ArrayBuffer(4 * 5 + 16 + 48);
    new Uint32Array(data).set([0x7fc0fee1, 1, 1, 0, 0, kind, 8, 12, 5]);
    new Float32Array(data, 36).set([0, -1, 0, 1, 0, 0, 0, 0, 1, 10, 20, 30]);
    return data;
  };
  assert.throws(() => shapes.whole(words(1), 2), RangeError);
  shapes.whole(golden("shared.bin"), 2);
  const made = shapes.whole(words(1), 2);
  assert.deepEqual([...new Float32Array(made, 0, 3)], [10, 20, 30]);
  assert.deepEqual([...new Uint16Array(made, 96, 8)], Array(8).fill(5));
  assert.equal(made.byteLength, 8 * 14 + 12 * 6);
  assert.throws(() => shapes.whole(words(9), 2), RangeError);
});

test("a piece that is cut short is an error", () => {
  assert.throws(() => new SharedShapes().whole(golden("shared.bin").slice(0, 64), 2), RangeError);
});
