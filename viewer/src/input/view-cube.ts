// The view cube and the triad of axes: how they lie in their own small picture, what a pixel of the cube means, and how
// both are drawn. A side is a direction from the middle of the mock-up: to the right, to the back and up of it, each -1, 0
// or 1; six faces, twelve edges and eight corners.

import type { UpAxis } from "../link/protocol";
import { add, cross, dot, normalize, type Point, scale, type Vec3 } from "../math/vectors";
import { type CameraRig, viewFrame } from "../scene/camera";

/** Both pictures are so large, CSS pixels. */
export const CUBE_PX = 104;
export const TRIAD_PX = 72;

const HALF_PX = 27;
/** The middle field of a face, of its half. */
const INNER = 0.52;
const ARM_PX = 20;

interface Face {
  readonly name: string;
  readonly out: Vec3;
  /** To the right and up, seen from outside. */
  readonly u: Vec3;
  readonly v: Vec3;
}

const FACES: readonly Face[] = [
  { name: "FRONT", out: [0, -1, 0], u: [1, 0, 0], v: [0, 0, 1] },
  { name: "BACK", out: [0, 1, 0], u: [-1, 0, 0], v: [0, 0, 1] },
  { name: "LEFT", out: [-1, 0, 0], u: [0, -1, 0], v: [0, 0, 1] },
  { name: "RIGHT", out: [1, 0, 0], u: [0, 1, 0], v: [0, 0, 1] },
  { name: "TOP", out: [0, 0, 1], u: [1, 0, 0], v: [0, 1, 0] },
  { name: "BOTTOM", out: [0, 0, -1], u: [1, 0, 0], v: [0, -1, 0] },
];

/** The part of the camera that both need. */
export type Facing = Pick<CameraRig, "right" | "top" | "forward">;

/** A field of the cube in its picture. */
export interface Cell {
  readonly side: Vec3;
  readonly face: Face;
  readonly corners: readonly Point[];
}

/** All 26 sides. */
export const SIDES: readonly Vec3[] = [-1, 0, 1].flatMap((x) =>
  [-1, 0, 1].flatMap((y) => [-1, 0, 1].filter((z) => x !== 0 || y !== 0 || z !== 0).map((z): Vec3 => [x, y, z])),
);

export const isSameSide = (a: Vec3 | null, b: Vec3 | null): boolean =>
  a === b || (a !== null && b !== null && a.every((value, k) => value === b[k]));

/** "front", "front, right and top". */
export function sideName([x, y, z]: Vec3): string {
  const words = [
    y < 0 ? "front" : y > 0 ? "back" : "",
    x < 0 ? "left" : x > 0 ? "right" : "",
    z < 0 ? "bottom" : z > 0 ? "top" : "",
  ].filter((word) => word !== "");
  return words.length < 2 ? (words[0] ?? "") : `${words.slice(0, -1).join(", ")} and ${words.at(-1)}`;
}

/** The axes of the picture in those of the cube. */
function axesOf(view: Facing, up: UpAxis): { right: Vec3; top: Vec3; towards: Vec3 } {
  const { right, ahead, above } = viewFrame(up);
  const local = (v: Vec3): Vec3 => [dot(v, right), dot(v, ahead), dot(v, above)];
  return { right: local(view.right), top: local(view.top), towards: local(scale(view.forward, -1)) };
}

/** The side from which the view looks, as nearly as there is one. */
export function nearestSide(view: Facing, up: UpAxis): Vec3 {
  const { towards } = axesOf(view, up);
  let found = SIDES[0] as Vec3;
  for (const side of SIDES) if (dot(normalize(side), towards) > dot(normalize(found), towards)) found = side;
  return found;
}

// The eight ways around, against the clock from above.
const AROUND: readonly (readonly [number, number])[] = [
  [0, -1],
  [1, -1],
  [1, 0],
  [1, 1],
  [0, 1],
  [-1, 1],
  [-1, 0],
  [-1, -1],
];

/** The next side by an arrow key: `dx` to the right, `dy` up; the same where there is none. */
export function neighbourSide([x, y, z]: Vec3, dx: number, dy: number): Vec3 {
  const at = AROUND.findIndex(([a, b]) => a === x && b === y);
  if (dx !== 0) {
    if (at < 0) return [x, y, z];
    const [a, b] = AROUND[(at + dx + AROUND.length) % AROUND.length] as readonly [number, number];
    return [a, b, z];
  }
  // At a pole the heading is lost: back to the front.
  if (at < 0) return dy === -Math.sign(z) ? [0, -1, z] : [x, y, z];
  if (Math.abs(z + dy) > 1) return [0, 0, z];
  return [x, y, z + dy];
}

/** The fields that face the eye, the face that looks at it most last. */
export function layCube(view: Facing, up: UpAxis): Cell[] {
  const { right, top, towards } = axesOf(view, up);
  const place = (p: Vec3): Point => ({
    x: CUBE_PX / 2 + HALF_PX * dot(p, right),
    y: CUBE_PX / 2 - HALF_PX * dot(p, top),
  });
  const ends = [-1, -INNER, INNER, 1] as const;
  return FACES.filter((face) => dot(face.out, towards) > 1e-3)
    .sort((a, b) => dot(a.out, towards) - dot(b.out, towards))
    .flatMap((face) =>
      [0, 1, 2].flatMap((i) =>
        [0, 1, 2].map((j): Cell => {
          const corner = (a: number, b: number) =>
            place(add(face.out, add(scale(face.u, ends[a] as number), scale(face.v, ends[b] as number))));
          const side = add(face.out, add(scale(face.u, i - 1), scale(face.v, j - 1)));
          return {
            side: side.map((value) => Math.round(value) + 0) as Vec3,
            face,
            corners: [corner(i, j), corner(i + 1, j), corner(i + 1, j + 1), corner(i, j + 1)],
          };
        }),
      ),
    );
}

/** The side whose field is at a pixel of the cube's picture; null: none. */
export function hitCube(cells: readonly Cell[], at: Point): Vec3 | null {
  return cells.find((cell) => isInside(cell.corners, at))?.side ?? null;
}

function isInside(corners: readonly Point[], at: Point): boolean {
  let sign = 0;
  for (const [k, a] of corners.entries()) {
    const b = corners[(k + 1) % corners.length] as Point;
    const turn = (b.x - a.x) * (at.y - a.y) - (b.y - a.y) * (at.x - a.x);
    if (turn === 0) continue;
    if (sign !== 0 && Math.sign(turn) !== sign) return false;
    sign = Math.sign(turn);
  }
  return sign !== 0;
}

const PAINT = {
  dark: { face: [66, 78, 96], line: "#0d1117", text: "#f2f6fb", lit: "#6db1ff", litText: "#08131f" },
  light: { face: [236, 241, 247], line: "#76859a", text: "#17202c", lit: "#0b5cad", litText: "#ffffff" },
} as const;

/** Draws the cube; the fields of the side `lit` bright. */
export function drawCube(
  context: CanvasRenderingContext2D,
  view: Facing,
  up: UpAxis,
  lit: Vec3 | null,
  theme: "dark" | "light",
  pixel_ratio: number,
): void {
  const cells = layCube(view, up);
  const { towards } = axesOf(view, up);
  const paint = PAINT[theme];
  context.setTransform(pixel_ratio, 0, 0, pixel_ratio, 0, 0);
  context.clearRect(0, 0, CUBE_PX, CUBE_PX);
  context.lineJoin = "round";
  for (const face of new Set(cells.map((cell) => cell.face))) {
    const mine = cells.filter((cell) => cell.face === face);
    const shade = 0.78 + 0.22 * dot(face.out, towards);
    const colour = `rgb(${paint.face.map((level) => Math.round(level * shade)).join(" ")} / 94%)`;
    for (const cell of mine) {
      context.beginPath();
      for (const { x, y } of cell.corners) context.lineTo(x, y);
      context.closePath();
      context.fillStyle = isSameSide(cell.side, lit) ? paint.lit : colour;
      context.fill();
      // A hair of the same colour closes the gaps between fields.
      context.strokeStyle = context.fillStyle;
      context.lineWidth = 0.6;
      context.stroke();
    }
    const [a, b, c, d] = outline(mine);
    context.beginPath();
    for (const { x, y } of [a, b, c, d]) context.lineTo(x, y);
    context.closePath();
    context.strokeStyle = paint.line;
    context.lineWidth = 1.5;
    context.stroke();
    write(context, face, [a, b, d], isSameSide(face.out, lit) ? paint.litText : paint.text, pixel_ratio);
  }
}

/** The corners of a face: lower left, lower right, upper right, upper left. */
function outline(cells: readonly Cell[]): [Point, Point, Point, Point] {
  const at = (cell: number, corner: number) => (cells[cell] as Cell).corners[corner] as Point;
  return [at(0, 0), at(6, 1), at(8, 2), at(2, 3)];
}

/** The name of a face, lying on it. */
function write(
  context: CanvasRenderingContext2D,
  face: Face,
  [origin, right, top]: readonly [Point, Point, Point],
  colour: string,
  pixel_ratio: number,
): void {
  // A unit of the text is 1/54 of the face's side, as large as the face is when it looks at the eye.
  const unit = 1 / (2 * HALF_PX);
  const [ux, uy] = [(right.x - origin.x) * unit, (right.y - origin.y) * unit];
  const [vx, vy] = [(top.x - origin.x) * unit, (top.y - origin.y) * unit];
  context.save();
  context.setTransform(
    pixel_ratio * ux,
    pixel_ratio * uy,
    -pixel_ratio * vx,
    -pixel_ratio * vy,
    pixel_ratio * (origin.x + HALF_PX * (ux + vx)),
    pixel_ratio * (origin.y + HALF_PX * (uy + vy)),
  );
  context.font = "600 12px system-ui, sans-serif";
  context.textAlign = "center";
  context.textBaseline = "middle";
  context.fillStyle = colour;
  context.fillText(face.name, 0, 0.5, 2 * HALF_PX - 8);
  context.restore();
}

const AXES: readonly { name: string; along: Vec3; colour: string }[] = [
  { name: "X", along: [1, 0, 0], colour: "#ff6b5e" },
  { name: "Y", along: [0, 1, 0], colour: "#8fd14f" },
  { name: "Z", along: [0, 0, 1], colour: "#5aa9ff" },
];

/** Draws the world's axes as they lie in the picture, the nearest last. */
export function drawTriad(
  context: CanvasRenderingContext2D,
  view: Facing,
  theme: "dark" | "light",
  pixel_ratio: number,
): void {
  context.setTransform(pixel_ratio, 0, 0, pixel_ratio, 0, 0);
  context.clearRect(0, 0, TRIAD_PX, TRIAD_PX);
  context.lineCap = "round";
  context.textAlign = "center";
  context.textBaseline = "middle";
  context.font = "700 12px system-ui, sans-serif";
  const middle = TRIAD_PX / 2;
  const towards = normalize(cross(view.right, view.top));
  const rim = theme === "dark" ? "rgb(0 0 0 / 65%)" : "rgb(255 255 255 / 85%)";
  for (const { along, colour, name } of [...AXES].sort((a, b) => dot(a.along, towards) - dot(b.along, towards))) {
    const [x, y] = [dot(along, view.right), -dot(along, view.top)];
    const [endX, endY] = [middle + ARM_PX * x, middle + ARM_PX * y];
    context.beginPath();
    context.moveTo(middle, middle);
    context.lineTo(endX, endY);
    context.strokeStyle = rim;
    context.lineWidth = 5;
    context.stroke();
    context.strokeStyle = colour;
    context.lineWidth = 3;
    context.stroke();
    const size = Math.hypot(x, y);
    // An axis that points at the eye has its letter on its tip.
    const reach = size > 0.25 ? 8 / size : 0;
    context.strokeStyle = rim;
    context.lineWidth = 4;
    context.strokeText(name, endX + reach * x, endY + reach * y);
    context.fillStyle = theme === "dark" ? "#ffffff" : "#17202c";
    context.fillText(name, endX + reach * x, endY + reach * y);
  }
}
