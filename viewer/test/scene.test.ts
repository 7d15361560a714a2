import assert from "node:assert/strict";
import { test } from "node:test";
import { Matrix4, MeshBasicMaterial, PerspectiveCamera, Vector3, Vector4 } from "three";
import type { Manifest } from "../src/link/protocol";
import { isSame } from "../src/math/same";
import { type Box, distance, dot, isEmpty, type Vec3 } from "../src/math/vectors";
import { Pieces, pieceBytes, readPiece } from "../src/scene/chunks";
import { isCutAway, mayBeSeen, sidePlanes } from "../src/scene/culling";
import { take } from "../src/scene/kept";
import { arc, arrowLength } from "../src/scene/marks";
import { Pace } from "../src/scene/pace";
import { PartState, PartTable } from "../src/scene/parts";
import { clipBox, planeInBox, writePlanes } from "../src/scene/sections";
import { setProjection, sharedUniforms } from "../src/scene/uniforms";

/** A piece of triangles that each have three vertices of their own: corner c of triangle t at (t, c, part). */
function piece(parts: number[], partBytes: 2 | 4): ArrayBuffer {
  const size = { triangles: parts.length, vertices: 3 * parts.length };
  const data = new ArrayBuffer(pieceBytes(size, partBytes));
  const arrays = readPiece(data, size, partBytes);
  parts.forEach((part, t) => {
    for (let c = 0; c < 3; c++) {
      arrays.positions.set([t, c, part], 9 * t + 3 * c);
      arrays.parts[3 * t + c] = part;
      arrays.indices[3 * t + c] = 3 * t + c;
    }
  });
  return data;
}

function mockup(pieces: number[][], partBytes: 2 | 4 = 2): { pieces: Pieces; data: ArrayBuffer[]; table: PartTable } {
  const count = 1 + Math.max(...pieces.flat());
  const corners = Array.from({ length: count }, (_, part): Vec3 => [part, 0, 0]);
  let first = 0;
  const said = pieces.map((parts) => {
    const size = { triangles: parts.length, vertices: 3 * parts.length };
    first += parts.length;
    const ends = { lower: [0, 0, 0] as Vec3, upper: [9, 9, 9] as Vec3 };
    return {
      ...size,
      ...ends,
      first: first - parts.length,
      bytes: pieceBytes(size, partBytes),
      small: false,
      parts: 1,
    };
  });
  const manifest = { part_bytes: partBytes, pieces: said } as unknown as Manifest;
  const boxes = corners.map((lower): Box => ({ lower, upper: [lower[0] + 1, 1, 1] }));
  return {
    pieces: new Pieces(manifest, new MeshBasicMaterial()),
    data: pieces.map((parts) => piece(parts, partBytes)),
    table: new PartTable(boxes, [1, 2, 3]),
  };
}

test("a packed triangle is found in its piece, in whatever order the pieces came", () => {
  for (const partBytes of [2, 4] as const) {
    const { pieces, data, table } = mockup(
      [
        [0, 0, 1],
        [1, 2],
        [3, 3, 3, 3],
      ],
      partBytes,
    );
    for (const k of [2, 0]) pieces.add(k, data[k] as ArrayBuffer);
    assert.equal(pieces.find(3), null, "a piece that has not come");
    pieces.add(1, data[1] as ArrayBuffer);
    assert.deepEqual(
      [0, 2, 3, 4, 5, 8].map((t) => pieces.find(t)?.k),
      [0, 0, 1, 1, 2, 2],
    );
    assert.equal(pieces.find(9), null);
    const corners = pieces.corners(new Uint32Array([4, 8, 99]), table);
    assert.deepEqual(Array.from(corners), [1, 0, 2, 1, 1, 2, 1, 2, 2, 3, 0, 3, 3, 1, 3, 3, 2, 3]);
    assert.deepEqual(
      pieces.all.map((p) => Array.from(p.partIds)),
      [[0, 1], [1, 2], [3]],
    );
  }
});

test("a piece that is cut short, or that nobody announced, is refused", () => {
  const { pieces, data } = mockup([[0, 1]]);
  assert.throws(() => pieces.add(0, (data[0] as ArrayBuffer).slice(0, 40)), RangeError);
  assert.throws(() => pieces.add(1, data[0] as ArrayBuffer), RangeError);
  assert.equal(pieces.all.length, 0);
});

test("a piece that comes twice is taken once", () => {
  const { pieces, data } = mockup([[0, 1]]);
  assert.equal(pieces.add(0, data[0] as ArrayBuffer), pieces.add(0, data[0] as ArrayBuffer));
});

test("only what is hidden or ghost asks for a redraw; lighting does not", () => {
  const { table } = mockup([[0, 1, 2]]);
  const set = (...states: number[]) => {
    const before = table.shapeVersion;
    table.setStates(Uint8Array.from(states));
    return table.shapeVersion !== before;
  };
  assert.equal(set(PartState.hit, PartState.hit, PartState.selected), false);
  assert.equal(table.isAnyLit, true);
  assert.equal(set(0, 0, 0), false);
  assert.equal(table.isAnyLit, false);
  assert.equal(set(PartState.hidden, 0, 0), true);
  assert.equal(set(PartState.hidden | PartState.hit, 0, 0), false);
  assert.equal(set(0, PartState.ghost, PartState.away), true);
  assert.deepEqual(
    [0, 1, 2].map((part) => table.isSolid(part)),
    [true, false, false],
  );
  assert.deepEqual(
    [0, 1, 2].map((part) => table.isGhost(part)),
    [false, true, false],
  );
  assert.deepEqual(
    [0, 1, 2].map((part) => table.isHidden(part)),
    [false, false, true],
  );
});

test("a ghost that is hidden is hidden", () => {
  const { table } = mockup([[0, 1]]);
  table.setStates(Uint8Array.from([PartState.ghost | PartState.hidden, PartState.ghost | PartState.away]));
  assert.deepEqual([table.isGhost(0), table.isGhost(1)], [false, false]);
});

test("a moved part takes its triangles and its box along; states do not bring it back", () => {
  const { pieces, data, table } = mockup([[0, 1]]);
  pieces.add(0, data[0] as ArrayBuffer);
  // A quarter turn about z and a step of 10 along x, of world coordinates; the middle is (1, 2, 3).
  table.setMoved(new Map([[1, [0, -1, 0, 10, 1, 0, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1]]]));
  table.setStates(new Uint8Array(2));
  // Corner 0 of triangle 1: (1, 0, 1) less the middle, so (2, 2, 4); turned (-2, 2, 4), moved (8, 2, 4).
  const corners = pieces.corners(new Uint32Array([0, 1]), table);
  assert.deepEqual(Array.from(corners.subarray(0, 3)), [0, 0, 0]);
  assert.deepEqual(Array.from(corners.subarray(9, 12)), [7, 0, 1]);
  assert.deepEqual(table.boxOf(1), { lower: [9, 1, 0], upper: [10, 2, 1] });
  assert.deepEqual(table.boxOf(0), { lower: [0, 0, 0], upper: [1, 1, 1] });
  table.setMoved(new Map());
  assert.deepEqual(table.boxOf(1), { lower: [1, 0, 0], upper: [2, 1, 1] });
});

test("the explosion moves each part straight away from the middle, and home again", () => {
  const { table } = mockup([[0, 3]]);
  table.setExplode(0.5);
  const [home, away] = [{ lower: [3, 0, 0], upper: [4, 1, 1] } as Box, table.boxOf(3)];
  const step = away.lower.map((value, k) => value - (home.lower[k] as number));
  const out = [2.5, -1.5, -2.5];
  step.forEach((value, k) => {
    assert.ok(Math.abs(value / (out[k] as number) - (step[0] as number) / 2.5) < 1e-6);
  });
  assert.ok((step[0] as number) > 0);
  table.setExplode(0);
  assert.deepEqual(table.boxOf(3), home);
});

test("no box with a point in the picture is culled, and most of those without are", () => {
  const camera = new PerspectiveCamera(40, 1.5, 0.1, 100);
  camera.position.set(3, -4, 2);
  camera.up.set(0, 0, 1);
  camera.lookAt(0, 0, 0);
  camera.updateMatrixWorld();
  const clip = new Matrix4().multiplyMatrices(camera.projectionMatrix, camera.matrixWorldInverse);
  const planes = sidePlanes(clip.elements);
  let [state, outside, culled] = [1, 0, 0];
  const random = () => {
    state = (state * 16807) % 2147483647;
    return state / 2147483647;
  };
  for (let k = 0; k < 3000; k++) {
    const lower = [0, 1, 2].map(() => 12 * random() - 6) as Vec3;
    const upper = lower.map((value) => value + random()) as Vec3;
    const point = new Vector3(...(lower.map((value, j) => value + random() * ((upper[j] as number) - value)) as Vec3));
    const view = point.clone().applyMatrix4(camera.matrixWorldInverse);
    const seen = point.clone().applyMatrix4(clip);
    const isInside = view.z < 0 && Math.abs(seen.x) < 1 && Math.abs(seen.y) < 1;
    const isKept = mayBeSeen({ lower, upper }, planes);
    if (isInside) assert.ok(isKept);
    else {
      outside++;
      if (!isKept) culled++;
    }
  }
  assert.ok(culled > 0.7 * outside);
});

test("a box is cut away only when all of it is", () => {
  const box: Box = { lower: [0, 0, 0], upper: [1, 1, 1] };
  const normal: Vec3 = [0.6, -0.8, 0];
  assert.equal(isCutAway(box, [{ normal, offset: 0.59 }]), false);
  assert.equal(isCutAway(box, [{ normal, offset: 0.61 }]), true);
  assert.equal(
    isCutAway(box, [
      { normal, offset: -9 },
      { normal: [0, 0, -1], offset: 0.1 },
    ]),
    true,
  );
});

test("a plane meets a box in a convex polygon around it", () => {
  const box: Box = { lower: [0, 0, 0], upper: [1, 2, 3] };
  const axis = planeInBox({ normal: [0, 0, 1], offset: 1.5 }, box);
  assert.equal(axis.length, 4);
  for (let k = 0; k < 4; k++) {
    const step = distance(axis[k] as Vec3, axis[(k + 1) % 4] as Vec3);
    assert.ok(Math.abs(step - 1) < 1e-12 || Math.abs(step - 2) < 1e-12, "sides, not diagonals");
  }
  const normal: Vec3 = [1 / Math.sqrt(3), 1 / Math.sqrt(3), 1 / Math.sqrt(3)];
  assert.equal(planeInBox({ normal, offset: 0.5 / Math.sqrt(3) }, box).length, 3);
  assert.equal(planeInBox({ normal, offset: 9 }, box).length, 0);
  for (const p of planeInBox({ normal, offset: 1.7 }, box)) assert.ok(Math.abs(dot(normal, p) - 1.7) < 1e-12);
});

test("what sections leave of a box is in its clipped box", () => {
  const box: Box = { lower: [0, 0, 0], upper: [1, 2, 3] };
  assert.deepEqual(clipBox(box, [{ normal: [0, 0, 1], offset: 1 }]), { lower: [0, 0, 1], upper: [1, 2, 3] });
  assert.deepEqual(
    clipBox(box, [
      { normal: [0, 0, 1], offset: 1 },
      { normal: [0, -1, 0], offset: -0.5 },
    ]),
    {
      lower: [0, 0, 1],
      upper: [1, 0.5, 3],
    },
  );
  assert.ok(isEmpty(clipBox(box, [{ normal: [0, 0, 1], offset: 4 }])));
});

test("section planes say the same in view coordinates", () => {
  const [cut, view] = [[new Vector4()], [new Vector4()]];
  const camera = { position: [4, 5, 6], right: [0, 1, 0], top: [0, 0, 1], forward: [1, 0, 0] } as const;
  const section = { normal: [0, 0.6, 0.8] as Vec3, offset: 2 };
  const axes = camera as unknown as { position: Vec3; right: Vec3; top: Vec3; forward: Vec3 };
  writePlanes([section], [1, 1, 1], axes, cut, view);
  const p: Vec3 = [7, -2, 3];
  const inView: Vec3 = [p[1] - 5, p[2] - 6, -(p[0] - 4)];
  const [c, v] = [cut[0] as Vector4, view[0] as Vector4];
  const side = dot(section.normal, p) - section.offset;
  assert.ok(Math.abs(dot([v.x, v.y, v.z], inView) - v.w - side) < 1e-12);
  assert.ok(Math.abs(dot([c.x, c.y, c.z], [6, -3, 2]) - c.w - side) < 1e-12);
});

test("a stored depth becomes a distance, reversed or not", () => {
  for (const isReversed of [false, true]) {
    const uniforms = sharedUniforms();
    const projection = new Matrix4().makePerspective(-0.1, 0.1, 0.08, -0.08, 0.1, 50, undefined, isReversed);
    setProjection(uniforms, projection, isReversed, 200, 160);
    for (const far of [0.1, 0.7, 13, 50]) {
      const clip = new Vector4(0.3 * far, -0.2 * far, -far, 1).applyMatrix4(projection);
      const ndc = clip.z / clip.w;
      const { x, y } = uniforms.depthLine.value;
      assert.ok(Math.abs(1 / (x * (isReversed ? ndc : 0.5 * ndc + 0.5) + y) / far - 1) < 1e-9);
      const ray = uniforms.rayOf.value;
      const pixel = [((clip.x / clip.w + 1) / 2) * 200, ((clip.y / clip.w + 1) / 2) * 160] as const;
      assert.ok(Math.abs(pixel[0] * ray.x + ray.z - 0.3) < 1e-9 && Math.abs(pixel[1] * ray.y + ray.w + 0.2) < 1e-9);
    }
  }
});

test("pieces are taken from the front while they fit, and never none", () => {
  const { pieces, data } = mockup([[0, 0, 0], [1], [2, 2]]);
  for (const k of [0, 1, 2]) pieces.add(k, data[k] as ArrayBuffer);
  const left = [...pieces.all];
  assert.deepEqual(
    take(left, 1).map((p) => p.k),
    [0],
  );
  assert.deepEqual(
    take(left, 2).map((p) => p.k),
    [1],
  );
  assert.deepEqual(
    take(left, Infinity).map((p) => p.k),
    [2],
  );
  assert.deepEqual(take(left, Infinity), []);
});

test("a slow device gets fewer triangles while the camera moves, then fewer pixels; a quick one gets all back", () => {
  const pace = new Pace();
  assert.equal(pace.triangles(1000), pace.triangles(0), "nobody knows yet what a triangle costs");
  pace.add(1_000_000, 10, true);
  const start = pace.draft;
  for (let k = 0; k < 20; k++) pace.add(1_000_000, 300, true);
  assert.ok(pace.draft < start / 2);
  assert.equal(pace.scale, 1);
  pace.add(110_000, 90, true);
  assert.equal(pace.scale, 0.5);
  for (let k = 0; k < 20; k++) pace.add(5_000_000, 8, true);
  assert.ok(pace.draft > 5_000_000);
  assert.equal(pace.scale, 1);
});

test("a force's arrow grows with it and stays in bounds", () => {
  const lengths = [0, 1, 5, 50, 1e6].map(arrowLength);
  assert.deepEqual(
    [...lengths].sort((a, b) => a - b),
    lengths,
  );
  assert.ok((lengths[4] as number) <= 90);
});

test("the arc of an angle goes from leg to leg", () => {
  const bow = arc([2, 0, 0], [0, 0, 0], [0, 3, 0], 0.5);
  assert.ok(distance(bow[0] as Vec3, [0.5, 0, 0]) < 1e-12);
  assert.ok(distance(bow.at(-1) as Vec3, [0, 0.5, 0]) < 1e-12);
  assert.deepEqual(arc([0, 0, 0], [0, 0, 0], [0, 3, 0], 0.5), []);
});

test("what says the same is the same, by value", () => {
  const marks = { a: new Float32Array([1, 2]), b: [[1, 2, 3]], c: null, d: "x" };
  assert.equal(isSame(marks, structuredClone(marks)), true);
  for (const other of [
    { ...marks, a: new Float32Array([1, 3]) },
    { ...marks, a: [1, 2] },
    { ...marks, b: [[1, 2]] },
    { ...marks, c: undefined },
    { ...marks, e: 1 },
    { a: marks.a, b: marks.b, d: "x", f: null },
  ]) {
    assert.equal(isSame(marks, other), false);
  }
});

test("a table told what it knows says so", () => {
  const { table } = mockup([[0, 1]]);
  assert.equal(table.setStates(new Uint8Array(2)), false);
  assert.equal(table.setStates(Uint8Array.of(0, PartState.hit)), true);
  const moved = () => new Map([[1, [1, 0, 0, 5, 0, 1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1]]]);
  assert.deepEqual([table.setMoved(moved()), table.setMoved(moved()), table.setMoved(new Map())], [true, false, true]);
  assert.deepEqual([table.setExplode(0), table.setExplode(0.5), table.setExplode(0.5)], [false, true, false]);
});
