// Vectors of three numbers, and boxes. Metres, the world's axes.

import type { Vec3 } from "../link/protocol";

export type { Vec3 };

/** A place in the picture: CSS pixels from its upper left corner. */
export interface Point {
  readonly x: number;
  readonly y: number;
}

/** A box along the axes. Empty when a lower corner lies above the upper one. */
export interface Box {
  lower: Vec3;
  upper: Vec3;
}

export const add = (a: Vec3, b: Vec3): Vec3 => [a[0] + b[0], a[1] + b[1], a[2] + b[2]];
export const subtract = (a: Vec3, b: Vec3): Vec3 => [a[0] - b[0], a[1] - b[1], a[2] - b[2]];
export const scale = (a: Vec3, by: number): Vec3 => [a[0] * by, a[1] * by, a[2] * by];
export const dot = (a: Vec3, b: Vec3): number => a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
export const length = (a: Vec3): number => Math.hypot(a[0], a[1], a[2]);
export const distance = (a: Vec3, b: Vec3): number => length(subtract(a, b));

/** The middle of two points; of one that is missing, the other. */
export const middleOf = (a: Vec3 | null, b: Vec3 | null): Vec3 =>
  a && b ? scale(add(a, b), 0.5) : (a ?? b ?? [0, 0, 0]);

export function cross(a: Vec3, b: Vec3): Vec3 {
  return [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]];
}

/** The unit vector along `a`; `otherwise` where `a` has no length. */
export function normalize(a: Vec3, otherwise: Vec3 = [0, 0, 0]): Vec3 {
  const size = length(a);
  return size > 0 ? scale(a, 1 / size) : otherwise;
}

/** A unit vector at right angles to the unit vector `a`. */
export function perpendicular(a: Vec3): Vec3 {
  const axis: Vec3 = Math.abs(a[0]) < 0.6 ? [1, 0, 0] : [0, 1, 0];
  return normalize(cross(a, axis));
}

/** `a` turned about the unit vector `axis` by `angle` rad (Rodrigues). */
export function rotate(a: Vec3, axis: Vec3, angle: number): Vec3 {
  const cos = Math.cos(angle);
  const along = dot(axis, a) * (1 - cos);
  return add(add(scale(a, cos), scale(cross(axis, a), Math.sin(angle))), scale(axis, along));
}

/** The point `p` moved by the row-by-row 4 x 4 matrix `m`. */
export function transform(m: ArrayLike<number>, p: Vec3): Vec3 {
  const at = (row: number) =>
    (m[4 * row] ?? 0) * p[0] + (m[4 * row + 1] ?? 0) * p[1] + (m[4 * row + 2] ?? 0) * p[2] + (m[4 * row + 3] ?? 0);
  return [at(0), at(1), at(2)];
}

export const emptyBox = (): Box => ({
  lower: [Infinity, Infinity, Infinity],
  upper: [-Infinity, -Infinity, -Infinity],
});

export const isEmpty = (box: Box): boolean => !(box.lower[0] <= box.upper[0]);

/** Grows `box` so that it holds the point `p`. */
export function include(box: Box, p: Vec3): void {
  for (let axis = 0; axis < 3; axis++) {
    box.lower[axis] = Math.min(box.lower[axis] as number, p[axis] as number);
    box.upper[axis] = Math.max(box.upper[axis] as number, p[axis] as number);
  }
}

/** The box that holds both. */
export const union = (a: Box, b: Box): Box => ({
  lower: [Math.min(a.lower[0], b.lower[0]), Math.min(a.lower[1], b.lower[1]), Math.min(a.lower[2], b.lower[2])],
  upper: [Math.max(a.upper[0], b.upper[0]), Math.max(a.upper[1], b.upper[1]), Math.max(a.upper[2], b.upper[2])],
});

/** The eight corners of `box`. */
export function corners(box: Box): Vec3[] {
  const found: Vec3[] = [];
  for (let bits = 0; bits < 8; bits++) {
    found.push([
      bits & 1 ? box.upper[0] : box.lower[0],
      bits & 2 ? box.upper[1] : box.lower[1],
      bits & 4 ? box.upper[2] : box.lower[2],
    ]);
  }
  return found;
}

export const centre = (box: Box): Vec3 => scale(add(box.lower, box.upper), 0.5);
export const diagonal = (box: Box): number => (isEmpty(box) ? 0 : distance(box.lower, box.upper));

/** The distance from `p` to `box`; 0 inside. */
export function distanceToBox(p: Vec3, box: Box): number {
  const out = p.map((value, axis) =>
    Math.max((box.lower[axis] as number) - value, 0, value - (box.upper[axis] as number)),
  );
  return Math.hypot(...out);
}
