// Pieces whose copies of other parts came as places of shapes: made whole again, as the server packed them.
//
// The layout is that of `Geometry.sent` in engine/geometry.py.

/** The first word of such a piece: as a float it is no number, and so no position. */
const SHARED = 0x7fc0fee1;
const SHAPE = 2 ** 31;
const HEAD = 5;

interface Shape {
  readonly positions: Float32Array;
  /** From 0 on. */
  readonly indices: Uint16Array;
}

const padded = (bytes: number): number => 4 * Math.ceil(bytes / 4);

/** Of one mock-up, whose pieces come in order: shapes are used in later pieces too. */
export class SharedShapes {
  readonly #shapes = new Map<number, Shape>();

  /** A piece as `readPiece` reads it; one without copies is given back as it is. Throws RangeError for one that is damaged. */
  whole(data: ArrayBuffer, partBytes: 2 | 4): ArrayBuffer {
    if (data.byteLength < 4 * HEAD) return data;
    const [word, runCount, placeCount, vertices, triangles] = new Uint32Array(data, 0, HEAD) as unknown as number[];
    if (word !== SHARED) return data;
    const [runsAt, placesAt] = [4 * HEAD, 4 * (HEAD + 4 * (runCount ?? 0))];
    const positionsAt = placesAt + 48 * (placeCount ?? 0);
    const partsAt = positionsAt + 12 * (vertices ?? 0);
    const indicesAt = partsAt + padded(partBytes * (vertices ?? 0));
    const runs = new Uint32Array(data, runsAt, 4 * (runCount ?? 0));
    const sent = {
      positions: new Float32Array(data, positionsAt, 3 * (vertices ?? 0)),
      parts: new (partBytes === 2 ? Uint16Array : Uint32Array)(data, partsAt, vertices ?? 0),
      indices: new Uint16Array(data, indicesAt, 3 * (triangles ?? 0)),
    };
    const places = new Float32Array(data, placesAt, 12 * (placeCount ?? 0));

    let [allVertices, allTriangles] = [0, 0];
    for (let run = 0; run < runs.length; run += 4) {
      allVertices += runs[run + 1] as number;
      allTriangles += runs[run + 2] as number;
    }
    const outPartsAt = 12 * allVertices;
    const outIndicesAt = outPartsAt + padded(partBytes * allVertices);
    const out = new ArrayBuffer(outIndicesAt + padded(6 * allTriangles));
    const positions = new Float32Array(out, 0, 3 * allVertices);
    const parts = new (partBytes === 2 ? Uint16Array : Uint32Array)(out, outPartsAt, allVertices);
    const indices = new Uint16Array(out, outIndicesAt, 3 * allTriangles);

    let [vertex, corner, place, sentVertex, sentCorner] = [0, 0, 0, 0, 0];
    for (let run = 0; run < runs.length; run += 4) {
      const [kind, count, faces, part] = runs.subarray(run, run + 4) as unknown as [number, number, number, number];
      if (kind === 0 || kind >= SHAPE) {
        positions.set(sent.positions.subarray(3 * sentVertex, 3 * (sentVertex + count)), 3 * vertex);
        parts.set(sent.parts.subarray(sentVertex, sentVertex + count), vertex);
        indices.set(sent.indices.subarray(sentCorner, sentCorner + 3 * faces), corner);
        if (kind >= SHAPE) {
          const own = indices.slice(corner, corner + 3 * faces);
          for (let k = 0; k < own.length; k++) own[k] = (own[k] as number) - vertex;
          this.#shapes.set(kind - SHAPE, {
            positions: positions.slice(3 * vertex, 3 * (vertex + count)),
            indices: own,
          });
        }
        sentVertex += count;
        sentCorner += 3 * faces;
      } else {
        const shape = this.#shapes.get(kind - 1);
        if (!shape || shape.positions.length !== 3 * count || shape.indices.length !== 3 * faces) {
          throw new RangeError("A piece repeats a shape that did not come: load again.");
        }
        turn(shape.positions, places.subarray(place, place + 12), positions, 3 * vertex);
        parts.fill(part, vertex, vertex + count);
        for (let k = 0; k < shape.indices.length; k++) indices[corner + k] = (shape.indices[k] as number) + vertex;
        place += 12;
      }
      vertex += count;
      corner += 3 * faces;
    }
    return out;
  }
}

/** Writes the positions of a copy to `out` from `at`. In doubles, rounded once, as the server checked it. */
function turn(shape: Float32Array, place: Float32Array, out: Float32Array, at: number): void {
  const [a, b, c, d, e, f, g, h, i, x, y, z] = place as unknown as number[] as [
    ...[number, number, number, number, number, number],
    ...[number, number, number, number, number, number],
  ];
  const [ox, oy, oz] = [shape[0] as number, shape[1] as number, shape[2] as number];
  for (let k = 0; k < shape.length; k += 3) {
    const [px, py, pz] = [(shape[k] as number) - ox, (shape[k + 1] as number) - oy, (shape[k + 2] as number) - oz];
    out[at + k] = x + (a * px + b * py + c * pz);
    out[at + k + 1] = y + (d * px + e * py + f * pz);
    out[at + k + 2] = z + (g * px + h * py + i * pz);
  }
}
