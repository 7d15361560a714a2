// The mock-up of one HTML file, as Python wrote it (testdata/workbench; tests/test_workbench_page.py reads it too).

import assert from "node:assert/strict";
import { readFileSync } from "node:fs";
import { test } from "node:test";
import { gzipSync } from "node:zlib";
import { OfflineError, readOffline, unpackOffline } from "../src/link/offline-file";

// The bundle runs in target/viewer-tests.
function golden(name: string): ArrayBuffer {
  const bytes = readFileSync(new URL(`../../testdata/workbench/${name}`, import.meta.url));
  return bytes.buffer.slice(bytes.byteOffset, bytes.byteOffset + bytes.byteLength) as ArrayBuffer;
}

/** A document with the element of a file. */
function carrying(text: string | null) {
  const element = text === null ? null : { textContent: text as string | null };
  return { element, getElementById: (id: string) => (id === "feeler-page" ? element : null) };
}

function base64(data: ArrayBuffer): string {
  return gzipSync(Buffer.from(data)).toString("base64");
}

test("pieces come out as the server sends them", () => {
  const page = unpackOffline(golden("page.bin"));
  assert.equal(page.left_out, 0);
  assert.equal(page.document.unit, "mm");
  assert.equal(page.camera?.fov_rad, 0.75);
  assert.equal(page.manifest.pieces.length, page.pieces.length);
  const whole = Buffer.concat(page.pieces.map((piece) => Buffer.from(piece)));
  assert.deepEqual(whole, Buffer.from(golden("page_pieces.bin")));
  page.pieces.forEach((piece, k) => {
    assert.equal(piece.byteLength, page.manifest.pieces[k]?.bytes);
  });
});

test("a file carries it in an element, which is emptied", async () => {
  const root = carrying(`\n${base64(golden("page.bin"))}\n`);
  const page = await readOffline(root);
  assert.equal(page?.manifest.hash, "00ff");
  assert.equal(root.element?.textContent, "");
});

test("a page of a server carries none", async () => {
  assert.equal(await readOffline(carrying(null)), null);
});

test("part ids of four bytes", () => {
  const packed = golden("page.bin");
  const size = new DataView(packed).getUint32(4, true);
  const text = new TextDecoder().decode(new Uint8Array(packed, 8, size)).replace('"part_bytes":2', '"part_bytes":4');
  const changed = new Uint8Array(packed.slice(0));
  changed.set(new TextEncoder().encode(text), 8);
  const [wide] = unpackOffline(changed.buffer).pieces;
  const [narrow] = unpackOffline(packed).pieces;
  const vertices = unpackOffline(packed).manifest.pieces[0]?.vertices ?? 0;
  assert.ok(wide && narrow);
  assert.deepEqual(
    [...new Uint32Array(wide, 12 * vertices, vertices)],
    [...new Uint16Array(narrow, 12 * vertices, vertices)],
  );
});

test("what is damaged or cut short is said", async () => {
  const whole = golden("page.bin");
  const other = whole.slice(0);
  new DataView(other).setUint32(0, 2, true);
  const wrong = whole.slice(0);
  // The last plane has corners: one that is far below the first names no vertex.
  new Uint8Array(wrong).fill(255, wrong.byteLength - 16);
  for (const bad of [new ArrayBuffer(0), new ArrayBuffer(8), other, wrong, whole.slice(0, whole.byteLength - 8)]) {
    assert.throws(() => unpackOffline(bad), OfflineError);
  }
  const text = base64(whole);
  for (const bad of ["", "!", "AAAA", text.slice(0, text.length / 2), text.slice(8)]) {
    await assert.rejects(readOffline(carrying(bad)), OfflineError);
  }
});
