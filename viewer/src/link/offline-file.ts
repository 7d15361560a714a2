// Reads the mock-up inside one HTML file: a frame of the link, whose pieces are filtered.
// `python/feeler/workbench/session/page.py` writes it and documents the filter.
//
//     const page = await readOffline();     // null: a server is behind this page
//
// Pieces have the server's form, so that the drawing code is the same.

import { decodeBinary, FrameError } from "./frames";
import type { SavedPage } from "./protocol";

/** The content of the file. */
export interface OfflinePage extends Pick<SavedPage, "document" | "camera" | "manifest" | "left_out"> {
  /** In the manifest's order, as `GET /scene/pieces/K` answers. */
  pieces: ArrayBuffer[];
  /** The frame of the rows of findings; null: there are none. */
  findings: ArrayBuffer | null;
}

/** The file cannot be read: it is cut short, or of another version. */
export class OfflineError extends Error {
  override name = "OfflineError";
}

/** The content of the element `#feeler-page`; null where there is none. Throws `OfflineError`. */
export async function readOffline(
  root: { getElementById(id: string): { textContent: string | null } | null } = document,
): Promise<OfflinePage | null> {
  const element = root.getElementById("feeler-page");
  if (!element) return null;
  const packed = fromBase64((element.textContent ?? "").trim());
  // The text is of no use any more, and large.
  element.textContent = "";
  return unpackOffline(await inflated(packed));
}

/** The same from the bytes after decompression. */
export function unpackOffline(data: ArrayBuffer): OfflinePage {
  const { document, camera, manifest, left_out, grid, findings, pieces: filtered } = saved(data);
  let offset = 0;
  const pieces = manifest.pieces.map(({ triangles, vertices }) => {
    const end = offset + 13 * vertices + 6 * triangles;
    if (end > filtered.length) throw new OfflineError("This file is cut short: copy it again.");
    const planes = new Planes(filtered.subarray(offset, end));
    offset = end;
    return piece(planes, vertices, triangles, manifest.part_bytes, grid.lower, grid.step);
  });
  const rows = findings.length > 0 ? findings.slice().buffer : null;
  return { document, camera, manifest, pieces, left_out, findings: rows };
}

function saved(data: ArrayBuffer): SavedPage {
  try {
    const message = decodeBinary(data);
    if (message.kind === "page") return message as unknown as SavedPage;
  } catch (error) {
    if (!(error instanceof FrameError)) throw error;
  }
  throw new OfflineError("This file is damaged, or was made by another version of feeler: make it again.");
}

function piece(
  planes: Planes,
  vertices: number,
  triangles: number,
  partBytes: number,
  lower: number[],
  step: number,
): ArrayBuffer {
  const partsAt = 12 * vertices;
  const indicesAt = partsAt + padded(partBytes * vertices);
  const data = new ArrayBuffer(indicesAt + padded(6 * triangles));
  const positions = new Float32Array(data, 0, 3 * vertices);
  for (let axis = 0; axis < 3; axis++) {
    const from = lower[axis] ?? 0;
    planes.differences(vertices, 3, (i, value) => {
      positions[3 * i + axis] = from + value * step;
    });
  }
  const parts = partBytes === 2 ? new Uint16Array(data, partsAt, vertices) : new Uint32Array(data, partsAt, vertices);
  planes.differences(vertices, 4, (i, value) => {
    parts[i] = value;
  });
  const indices = new Uint16Array(data, indicesAt, 3 * triangles);
  for (let corner = 0; corner < 3; corner++) {
    planes.numbers(triangles, 2, (i, value) => {
      indices[3 * i + corner] = value;
    });
  }
  // A corner is so far below the first vertex that none before it named.
  let next = 0;
  for (let i = 0; i < indices.length; i++) {
    const index = next - (indices[i] ?? 0);
    if (index < 0 || index >= vertices) throw new OfflineError("This file is damaged: make it again.");
    indices[i] = index;
    if (index === next) next++;
  }
  return data;
}

/** Numbers whose bytes lie apart: all lowest bytes, then all second ones, and so on. */
class Planes {
  private offset = 0;

  constructor(private readonly bytes: Uint8Array) {}

  numbers(count: number, width: number, take: (i: number, value: number) => void): void {
    const { bytes, offset } = this;
    for (let i = 0; i < count; i++) {
      let value = 0;
      for (let k = 0; k < width; k++) value |= (bytes[offset + k * count + i] ?? 0) << (8 * k);
      take(i, value >>> 0);
    }
    this.offset += width * count;
  }

  /** Numbers of which the difference to the one before is written: 0, -1, 1, -2, 2 as 0, 1, 2, 3, 4. */
  differences(count: number, width: number, take: (i: number, value: number) => void): void {
    let value = 0;
    this.numbers(count, width, (i, folded) => {
      value += (folded >>> 1) ^ -(folded & 1);
      take(i, value);
    });
  }
}

async function inflated(packed: Uint8Array<ArrayBuffer>): Promise<ArrayBuffer> {
  const stream = new Blob([packed]).stream().pipeThrough(new DecompressionStream("gzip"));
  try {
    return await new Response(stream).arrayBuffer();
  } catch {
    throw new OfflineError("This file is cut short: copy it again.");
  }
}

function fromBase64(text: string): Uint8Array<ArrayBuffer> {
  const native = Uint8Array as unknown as { fromBase64?: (text: string) => Uint8Array<ArrayBuffer> };
  try {
    if (native.fromBase64) return native.fromBase64(text);
    const binary = atob(text);
    const bytes = new Uint8Array(binary.length);
    for (let i = 0; i < bytes.length; i++) bytes[i] = binary.charCodeAt(i);
    return bytes;
  } catch {
    throw new OfflineError("This file is damaged: copy it again.");
  }
}

function padded(bytes: number): number {
  return Math.ceil(bytes / 4) * 4;
}
