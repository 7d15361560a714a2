// The frames that Python wrote (testdata/workbench; tests/test_workbench_protocol.py reads them too).

import assert from "node:assert/strict";
import { readFileSync } from "node:fs";
import { test } from "node:test";
import { decodeFrame, encodeFrame, FrameError } from "../src/link/frames";
import type { State, Wish } from "../src/link/protocol";

// The bundle runs in target/viewer-tests.
function golden(name: string): ArrayBuffer {
  const bytes = readFileSync(new URL(`../../testdata/workbench/${name}.bin`, import.meta.url));
  return bytes.buffer.slice(bytes.byteOffset, bytes.byteOffset + bytes.byteLength) as ArrayBuffer;
}

const TURNED = [0, -1, 0, 0.25, 1, 0, 0, -0.5, 0, 0, 1, 1.125, 0, 0, 0, 1];
const POSE: Wish = { kind: "pose", seq: 41, time_ms: 1234.5, source: "spacemouse", pose: new Float64Array(TURNED) };

function state(frame: ArrayBuffer): State {
  const message = decodeFrame(frame);
  assert.equal(message.kind, "state");
  return message as State;
}

/** The frame with its header changed. */
function changed(frame: ArrayBuffer, change: (header: { arrays: Record<string, unknown[]> }) => void): ArrayBuffer {
  const size = new DataView(frame).getUint32(4, true);
  const header = JSON.parse(new TextDecoder().decode(new Uint8Array(frame, 8, size)));
  change(header);
  const json = JSON.stringify(header);
  const text = new TextEncoder().encode(json.padEnd(Math.ceil(json.length / 8) * 8));
  const made = new Uint8Array(8 + text.length + frame.byteLength - 8 - size);
  made.set(new Uint8Array(frame, 0, 8));
  new DataView(made.buffer).setUint32(4, text.length, true);
  made.set(text, 8);
  made.set(new Uint8Array(frame, 8 + size), 8 + text.length);
  return made.buffer;
}

test("a pose is written byte for byte as Python writes it", () => {
  assert.deepEqual(Buffer.from(encodeFrame(POSE) as ArrayBuffer), Buffer.from(golden("pose")));
});

test("a pose of any array of sixteen numbers is the same, wherever its numbers lie", () => {
  const wide = new Float64Array([9, ...TURNED, 9]);
  const frame = encodeFrame({ ...POSE, pose: wide.subarray(1, 17) }) as ArrayBuffer;
  assert.deepEqual(Buffer.from(frame), Buffer.from(golden("pose")));
  assert.throws(() => encodeFrame({ ...POSE, pose: wide }), FrameError);
});

test("a state is read to the last number", () => {
  const read = state(golden("state"));
  assert.equal(read.seq, 7);
  assert.equal(read.pose_seq, 41);
  assert.equal(read.mode, "stop");
  assert.equal(read.blocked, true);
  assert.deepEqual(read.force, [0.5, -1.5, 2.25]);
  assert.deepEqual(read.distance?.mockup_point, [1.5, 0.5, 0.2375]);
  assert.deepEqual(read.parts, [3, 4315]);
  assert.deepEqual([...read.pose], TURNED);
  assert.deepEqual([...read.wish], [1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1]);
  assert.deepEqual([...read.hits], [0, 70_000, 4_000_000_000]);
  assert.deepEqual([...read.tool_hits], [9]);
  assert.deepEqual(
    [...read.planes],
    Array.from({ length: 16 }, (_, i) => i / 8),
  );
  assert.deepEqual([...read.plane_parts], [3, 4315]);
  assert.deepEqual(
    [...read.clearance],
    Array.from({ length: 7 }, (_, i) => i / 4),
  );
  assert.deepEqual([...read.clearance_parts], [12]);
  assert.ok(read.pose instanceof Float64Array && read.hits instanceof Uint32Array);
  assert.ok(!("arrays" in read));
});

test("a state without hits has empty arrays", () => {
  const read = state(golden("state_free"));
  assert.equal(read.distance, null);
  for (const array of [read.hits, read.tool_hits, read.planes, read.plane_parts, read.clearance]) {
    assert.equal(array.length, 0);
  }
});

test("text is JSON both ways", () => {
  assert.equal(encodeFrame({ kind: "ack", seq: 3 }), '{"kind":"ack","seq":3}');
  assert.deepEqual(decodeFrame('{"kind":"reply","ok":true,"id":1,"result":null}'), {
    kind: "reply",
    ok: true,
    id: 1,
    result: null,
  });
});

test("what is no frame throws", () => {
  const whole = golden("state");
  const bad: (string | ArrayBuffer)[] = ["", "[]", "null", "{}", '{"kind":1}', new ArrayBuffer(0), new ArrayBuffer(8)];
  for (let end = 0; end < whole.byteLength; end += 8) {
    bad.push(whole.slice(0, end));
  }
  const other = whole.slice(0);
  new DataView(other).setUint32(0, 2, true);
  bad.push(other);
  const places: unknown[] = [
    null,
    ["u4", [3], 4],
    ["u4", [3], -8],
    ["u4", [-3], 0],
    ["u4", [3.5], 0],
    ["u4", ["3"], 0],
    ["u4", [1e9], 0],
    ["u4", [3, 1], 0],
    ["f4", [3], 0],
  ];
  for (const place of places) {
    bad.push(changed(whole, (header) => Object.assign(header.arrays, { hits: place })));
  }
  // The rows of two arrays that belong together differ.
  bad.push(changed(whole, (header) => header.arrays.plane_parts?.splice(1, 1, [1])));
  for (const frame of bad) {
    assert.throws(() => decodeFrame(frame), FrameError);
  }
});
