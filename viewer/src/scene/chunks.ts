// The mock-up's pieces: buffers as the server packed them, kept on the page, drawn by one material.

import { BufferAttribute, BufferGeometry, type BufferGeometry as Geometry, IntType, type Material, Mesh } from "three";
import type { Manifest } from "../link/protocol";
import type { Box } from "../math/vectors";
import type { PartTable } from "./parts";

/** The arrays of a piece: views of one buffer. */
export interface PieceArrays {
  /** (vertices, 3), metres less the middle. */
  positions: Float32Array;
  /** (vertices,). */
  parts: Uint16Array | Uint32Array;
  /** (triangles, 3). */
  indices: Uint16Array;
}

/** The bytes of a piece: float32 positions, part ids padded to 4 bytes, uint16 indices. */
export function pieceBytes(size: { triangles: number; vertices: number }, partBytes: 2 | 4): number {
  return 12 * size.vertices + 4 * Math.ceil((partBytes * size.vertices) / 4) + 6 * size.triangles;
}

/** Reads a piece at `offset` of `data`, without a copy if it is aligned. Throws RangeError if it is cut short. */
export function readPiece(
  data: ArrayBuffer,
  size: { triangles: number; vertices: number },
  partBytes: 2 | 4,
  offset = 0,
): PieceArrays {
  const bytes = pieceBytes(size, partBytes);
  if (data.byteLength < offset + bytes) {
    throw new RangeError(
      `A piece has ${data.byteLength - offset} bytes where its manifest asks for ${bytes}: load again.`,
    );
  }
  const [buffer, start] = offset % 4 === 0 ? [data, offset] : [data.slice(offset, offset + bytes), 0];
  const partsAt = start + 12 * size.vertices;
  const indicesAt = partsAt + 4 * Math.ceil((partBytes * size.vertices) / 4);
  return {
    positions: new Float32Array(buffer, start, 3 * size.vertices),
    parts:
      partBytes === 2
        ? new Uint16Array(buffer, partsAt, size.vertices)
        : new Uint32Array(buffer, partsAt, size.vertices),
    indices: new Uint16Array(buffer, indicesAt, 3 * size.triangles),
  };
}

/** Geometry on the arrays as they are: three keeps no copy. */
export function geometryOf(arrays: PieceArrays): Geometry {
  const geometry = new BufferGeometry();
  geometry.setAttribute("position", new BufferAttribute(arrays.positions, 3));
  const parts = new BufferAttribute(arrays.parts, 1);
  // Else the ids would arrive in the shader as floats.
  parts.gpuType = IntType;
  geometry.setAttribute("part", parts);
  geometry.setIndex(new BufferAttribute(arrays.indices, 1));
  return geometry;
}

/** A mesh without a transform, drawn on request. */
export function standingMesh(geometry: Geometry, material: Material): Mesh {
  const mesh = new Mesh(geometry, material);
  mesh.frustumCulled = false;
  mesh.matrixAutoUpdate = false;
  return mesh;
}

export interface Piece {
  k: number;
  /** The packed index of its first triangle. */
  first: number;
  triangles: number;
  box: Box;
  arrays: PieceArrays;
  /** The parts in it, each once, sorted. */
  partIds: Uint32Array;
  mesh: Mesh;
}

function unique(parts: ArrayLike<number>): Uint32Array {
  const found = new Set<number>();
  let last = -1;
  for (let k = 0; k < parts.length; k++) {
    const part = parts[k] as number;
    if (part !== last) found.add(part);
    last = part;
  }
  return Uint32Array.from(found).sort();
}

export class Pieces {
  /** In the order of the manifest: big shapes first, small fasteners last. */
  readonly all: Piece[] = [];

  constructor(
    readonly manifest: Pick<Manifest, "pieces" | "part_bytes">,
    readonly material: Material,
  ) {}

  /** Takes piece `k`. A second time: the same piece again. */
  add(k: number, data: ArrayBuffer): Piece {
    const known = this.all.find((piece) => piece.k === k);
    if (known) return known;
    const said = this.manifest.pieces[k];
    if (!said) throw new RangeError(`The manifest has no piece ${k}: load again.`);
    const arrays = readPiece(data, said, this.manifest.part_bytes);
    const piece: Piece = {
      k,
      first: said.first,
      triangles: said.triangles,
      box: { lower: said.lower, upper: said.upper },
      arrays,
      partIds: unique(arrays.parts),
      mesh: standingMesh(geometryOf(arrays), this.material),
    };
    let at = this.all.length;
    while (at > 0 && (this.all[at - 1] as Piece).k > k) at--;
    this.all.splice(at, 0, piece);
    return piece;
  }

  /** The piece that holds the packed triangle, null where it has not come yet. */
  find(packed: number): Piece | null {
    let [low, high] = [0, this.all.length];
    while (low < high) {
      const middle = (low + high) >> 1;
      if ((this.all[middle] as Piece).first <= packed) low = middle + 1;
      else high = middle;
    }
    const piece = this.all[low - 1];
    return piece && packed < piece.first + piece.triangles ? piece : null;
  }

  /** Corners of the packed triangles where their parts are now, 9 numbers each, less the middle; hidden ones left out. */
  corners(packed: Uint32Array, table: PartTable): Float32Array {
    const found = new Float32Array(9 * packed.length);
    let at = 0;
    for (const triangle of packed) {
      const piece = this.find(triangle);
      if (!piece) continue;
      const { indices, parts } = piece.arrays;
      const first = 3 * (triangle - piece.first);
      const part = parts[indices[first] as number] as number;
      if (table.isHidden(part)) continue;
      writeCorners(piece.arrays, first, found, at);
      table.placePoints(part, found, at, at + 9);
      at += 9;
    }
    return found.subarray(0, at);
  }

  dispose(): void {
    for (const piece of this.all) piece.mesh.geometry.dispose();
    this.all.length = 0;
  }
}

/** Writes the three corners of the triangle whose indices begin at `first` to `out` from `at`. */
export function writeCorners(arrays: PieceArrays, first: number, out: Float32Array, at: number): void {
  const { indices, positions } = arrays;
  for (let corner = 0; corner < 3; corner++) {
    const from = 3 * (indices[first + corner] as number);
    out[at + 3 * corner] = positions[from] as number;
    out[at + 3 * corner + 1] = positions[from + 1] as number;
    out[at + 3 * corner + 2] = positions[from + 2] as number;
  }
}
