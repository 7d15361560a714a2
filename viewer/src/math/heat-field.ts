// Distances to the held mesh on a grid around it, for the heat map: made once for a mesh, looked up for each pixel.
//
// The surface is sampled; each sample gives its distance to the nodes around it, and an exact squared distance transform
// carries these on (Felzenszwalb and Huttenlocher 2012, three passes along the axes).

import type { Vec3 } from "./vectors";

/** The heat map shows what is nearer to the tool than this, metres. */
export const HEAT_REACH_M = 0.02;

/** The mesh: pieces of positions (3 numbers each) and triangles. */
export interface FieldMesh {
  readonly positions: Float32Array;
  readonly indices: ArrayLike<number>;
}

export interface HeatField {
  /** Nodes along x, y and z; the first lies at `origin`. */
  readonly size: readonly [number, number, number];
  readonly origin: Vec3;
  /** Between nodes, metres. */
  readonly cell: number;
  /** x fastest; 255 stands for `most`. */
  readonly data: Uint8Array;
  /** Metres. */
  readonly most: number;
}

const MOST_NODES = 400_000;
const LEAST_CELL_M = HEAT_REACH_M / 10;
const MOST_M = 1.25 * HEAT_REACH_M;
const MOST_SAMPLES = 1_500_000;
const FAR = 1e12;

/** The field of a mesh in the box from `lower` to `upper`, all in the frame of its positions. */
export function heatField(pieces: readonly FieldMesh[], lower: Vec3, upper: Vec3): HeatField {
  const sides = [0, 1, 2].map((k) => (upper[k] as number) - (lower[k] as number) + 2 * MOST_M) as Vec3;
  const cell = Math.max(LEAST_CELL_M, Math.cbrt((sides[0] * sides[1] * sides[2]) / MOST_NODES));
  const size = sides.map((side) => Math.max(2, Math.ceil(side / cell) + 1)) as unknown as [number, number, number];
  const origin = lower.map((value) => value - MOST_M) as Vec3;
  // Squared, in cells.
  const far = new Float32Array(size[0] * size[1] * size[2]).fill(FAR);
  for (const piece of pieces) seed(piece, far, size, origin, cell);
  spread(far, size);
  const data = new Uint8Array(far.length);
  const scale = (255 * cell) / MOST_M;
  for (let k = 0; k < far.length; k++) data[k] = Math.min(255, Math.round(Math.sqrt(far[k] as number) * scale));
  return { size, origin, cell, data, most: MOST_M };
}

/** The distance that the field gives at a point, metres; infinite beyond it. For tests: the shader does the same. */
export function heatAt(field: HeatField, point: Vec3): number {
  const at = point.map((value, k) => (value - (field.origin[k] as number)) / field.cell) as Vec3;
  if (at.some((value, k) => value < 0 || value > (field.size[k] as number) - 1)) return Infinity;
  const low = at.map((value, k) => Math.min(Math.floor(value), (field.size[k] as number) - 2)) as Vec3;
  let sum = 0;
  for (let bits = 0; bits < 8; bits++) {
    let share = 1;
    const node = low.map((value, k) => {
      const up = (bits >> k) & 1;
      const part = (at[k] as number) - value;
      share *= up ? part : 1 - part;
      return value + up;
    }) as Vec3;
    sum += share * (field.data[node[0] + field.size[0] * (node[1] + field.size[1] * node[2])] as number);
  }
  return (sum / 255) * field.most;
}

/** Gives the nodes around samples of the surface their distances. */
function seed(
  { positions, indices }: FieldMesh,
  far: Float32Array,
  [nx, ny, nz]: readonly [number, number, number],
  origin: Vec3,
  cell: number,
): void {
  const [ox, oy, oz] = origin;
  const touch = (x: number, y: number, z: number): void => {
    const [u, v, w] = [(x - ox) / cell, (y - oy) / cell, (z - oz) / cell];
    const [i0, j0, k0] = [Math.floor(u), Math.floor(v), Math.floor(w)];
    for (let k = Math.max(k0, 0); k <= Math.min(k0 + 1, nz - 1); k++)
      for (let j = Math.max(j0, 0); j <= Math.min(j0 + 1, ny - 1); j++)
        for (let i = Math.max(i0, 0); i <= Math.min(i0 + 1, nx - 1); i++) {
          const d = (u - i) ** 2 + (v - j) ** 2 + (w - k) ** 2;
          const at = i + nx * (j + ny * k);
          if (d < (far[at] as number)) far[at] = d;
        }
  };
  const triangles = indices.length / 3;
  // Half a cell between samples; coarser where that would be too many.
  const most = Math.max(1, Math.floor(Math.sqrt((2 * MOST_SAMPLES) / Math.max(triangles, 1))));
  const p = new Float64Array(9);
  for (let t = 0; t < triangles; t++) {
    for (let c = 0; c < 3; c++)
      for (let k = 0; k < 3; k++) p[3 * c + k] = positions[3 * (indices[3 * t + c] as number) + k] as number;
    const [ax, ay, az, bx, by, bz, cx, cy, cz] = p as unknown as number[] as [
      number,
      number,
      number,
      number,
      number,
      number,
      number,
      number,
      number,
    ];
    const side = Math.max(
      Math.hypot(bx - ax, by - ay, bz - az),
      Math.hypot(cx - ax, cy - ay, cz - az),
      Math.hypot(cx - bx, cy - by, cz - bz),
    );
    const steps = Math.max(1, Math.min(most, Math.ceil((2 * side) / cell)));
    for (let i = 0; i <= steps; i++)
      for (let j = 0; j <= steps - i; j++) {
        const [u, v] = [i / steps, j / steps];
        touch(
          ax + u * (bx - ax) + v * (cx - ax),
          ay + u * (by - ay) + v * (cy - ay),
          az + u * (bz - az) + v * (cz - az),
        );
      }
  }
}

/** The squared distance transform, along one axis after the other. */
function spread(far: Float32Array, size: readonly [number, number, number]): void {
  const strides = [1, size[0], size[0] * size[1]] as const;
  const longest = Math.max(...size);
  const [line, places, bounds] = [new Float64Array(longest), new Int32Array(longest), new Float64Array(longest + 1)];
  for (const axis of [0, 1, 2] as const) {
    const [count, stride] = [size[axis], strides[axis]];
    const [a, b] = [0, 1, 2].filter((each) => each !== axis) as [0 | 1 | 2, 0 | 1 | 2];
    for (let i = 0; i < size[a]; i++)
      for (let j = 0; j < size[b]; j++) {
        const start = i * strides[a] + j * strides[b];
        lower(far, start, stride, count, line, places, bounds);
      }
  }
}

/** Replaces a line of values f(q) by the lower envelope of the parabolas (x - q)^2 + f(q). */
function lower(
  far: Float32Array,
  start: number,
  stride: number,
  count: number,
  line: Float64Array,
  places: Int32Array,
  bounds: Float64Array,
): void {
  let last = -1;
  for (let q = 0; q < count; q++) {
    const value = far[start + q * stride] as number;
    line[q] = value;
    if (value >= FAR) continue;
    let from = -Infinity;
    while (last >= 0) {
      const p = places[last] as number;
      from = (value + q * q - ((line[p] as number) + p * p)) / (2 * (q - p));
      if (from > (bounds[last] as number)) break;
      last--;
      from = -Infinity;
    }
    last++;
    places[last] = q;
    bounds[last] = from;
  }
  if (last < 0) return;
  let k = 0;
  for (let x = 0; x < count; x++) {
    while (k < last && (bounds[k + 1] as number) < x) k++;
    const q = places[k] as number;
    far[start + x * stride] = (x - q) ** 2 + (line[q] as number);
  }
}
