// A mock-up of blocks, packed as the server does: what the browser tests look at.

const SIDES = [
  [0, 2, 3, 1],
  [4, 5, 7, 6],
  [0, 1, 5, 4],
  [2, 6, 7, 3],
  [0, 4, 6, 2],
  [1, 3, 7, 5],
];

/** A box's 8 corners and 12 triangles, turned outwards. */
function block(lower, upper) {
  const corners = Array.from({ length: 8 }, (_, k) => [0, 1, 2].map((axis) => (k & (1 << axis) ? upper : lower)[axis]));
  const triangles = SIDES.flatMap(([a, b, c, d]) => [
    [a, b, c],
    [a, c, d],
  ]);
  return { corners, triangles };
}

function pack(boxes, partIds, middle) {
  const vertices = 8 * boxes.length;
  const padded = 4 * Math.ceil((2 * vertices) / 4);
  const data = Buffer.alloc(12 * vertices + padded + 6 * 12 * boxes.length);
  boxes.forEach(([lower, upper], n) => {
    const { corners, triangles } = block(lower, upper);
    corners.forEach((corner, k) => {
      for (let axis = 0; axis < 3; axis++) data.writeFloatLE(corner[axis] - middle[axis], 12 * (8 * n + k) + 4 * axis);
      data.writeUInt16LE(partIds[n], 12 * vertices + 2 * (8 * n + k));
    });
    triangles.flat().forEach((corner, k) => {
      data.writeUInt16LE(8 * n + corner, 12 * vertices + padded + 72 * n + 2 * k);
    });
  });
  return { data, size: { triangles: 12 * boxes.length, vertices, bytes: data.length } };
}

function bounds(boxes) {
  const pick = (corner, choose) => [0, 1, 2].map((axis) => choose(...boxes.map((box) => box[corner][axis])));
  return { lower: pick(0, Math.min), upper: pick(1, Math.max) };
}

/** `pieces`: lists of [lower, upper], a part each, in order. Returns the manifest and the pieces' bytes. */
export function mockupOf(pieces, name = "blocks", colours = []) {
  const all = pieces.flat();
  const { lower, upper } = bounds(all);
  const middle = lower.map((value, axis) => (value + upper[axis]) / 2);
  let part = 0;
  const packed = pieces.map((boxes) =>
    pack(
      boxes,
      boxes.map(() => part++),
      middle,
    ),
  );
  let first = 0;
  const said = packed.map(({ size }, k) => {
    first += size.triangles;
    return { ...size, ...bounds(pieces[k]), first: first - size.triangles, small: false, parts: pieces[k].length };
  });
  const manifest = {
    ...{ hash: name, name, unit: "mm", up: "z", middle, lower, upper, part_bytes: 2 },
    triangles: first,
    vertices: said.reduce((sum, piece) => sum + piece.vertices, 0),
    parts: {
      paths: all.map((_, k) => `${name}/block ${k}`),
      triangles: all.map(() => 12),
      lower: all.map((box) => box[0]),
      upper: all.map((box) => box[1]),
      small: all.map(() => 0),
      colours,
    },
    pieces: said,
  };
  return { manifest, data: packed.map((piece) => piece.data) };
}

/** What the hand holds: one block. */
export function heldOf(lower, upper) {
  const middle = [0.01, 0, 0];
  const { data, size } = pack([[lower, upper]], [0], middle);
  const manifest = { middle, lower, upper, triangles: 12, part_bytes: 2, pieces: [{ ...size, first: 0 }] };
  return { manifest, data };
}
