// Rigid poses: a pose is sixteen numbers row by row (`world_from_tool`), metres; angles are radians.

import type { Pose } from "../link/protocol";
import { add, cross, dot, length, normalize, scale, subtract, type Vec3 } from "./vectors";

export type { Pose };

export const IDENTITY: readonly number[] = [1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1];

/** The number at row `row`, column `column`. */
export const at = (pose: ArrayLike<number>, row: number, column: number): number =>
  pose[4 * row + column] ?? Number.NaN;

/** Where the pose's origin is. */
export const position = (pose: ArrayLike<number>): Vec3 => [at(pose, 0, 3), at(pose, 1, 3), at(pose, 2, 3)];

/** The pose's axis 0, 1 or 2, in world directions. */
export const axis = (pose: ArrayLike<number>, index: number): Vec3 => [
  at(pose, 0, index),
  at(pose, 1, index),
  at(pose, 2, index),
];

/** A pose from its three axes and its origin. */
export const fromAxes = (x: Vec3, y: Vec3, z: Vec3, origin: Vec3): Pose => [
  ...[x[0], y[0], z[0], origin[0]],
  ...[x[1], y[1], z[1], origin[1]],
  ...[x[2], y[2], z[2], origin[2]],
  ...[0, 0, 0, 1],
];

/** `a` after `b`: `world_from_tool = multiply(world_from_grip, grip_from_tool)`. */
export function multiply(a: ArrayLike<number>, b: ArrayLike<number>): Pose {
  const product = new Array<number>(16);
  for (let row = 0; row < 4; row++) {
    for (let column = 0; column < 4; column++) {
      let sum = 0;
      for (let k = 0; k < 4; k++) sum += at(a, row, k) * at(b, k, column);
      product[4 * row + column] = sum;
    }
  }
  return product;
}

/** The inverse of a rigid pose. */
export function invert(pose: ArrayLike<number>): Pose {
  const origin = position(pose);
  const x = axis(pose, 0);
  const y = axis(pose, 1);
  const z = axis(pose, 2);
  return [
    ...[x[0], x[1], x[2], -dot(x, origin)],
    ...[y[0], y[1], y[2], -dot(y, origin)],
    ...[z[0], z[1], z[2], -dot(z, origin)],
    ...[0, 0, 0, 1],
  ];
}

/** A direction of the pose's frame, in world directions. */
export const turn = (pose: ArrayLike<number>, direction: Vec3): Vec3 => [
  at(pose, 0, 0) * direction[0] + at(pose, 0, 1) * direction[1] + at(pose, 0, 2) * direction[2],
  at(pose, 1, 0) * direction[0] + at(pose, 1, 1) * direction[1] + at(pose, 1, 2) * direction[2],
  at(pose, 2, 0) * direction[0] + at(pose, 2, 1) * direction[1] + at(pose, 2, 2) * direction[2],
];

/** A point of the pose's frame, in the world. */
export const carry = (pose: ArrayLike<number>, point: Vec3): Vec3 => add(turn(pose, point), position(pose));

export const translation = (by: Vec3): Pose => fromAxes([1, 0, 0], [0, 1, 0], [0, 0, 1], by);

/** A turn by `angle_rad` about the unit `direction` through the origin (Rodrigues). */
export function rotation(direction: Vec3, angle_rad: number): Pose {
  const [x, y, z] = direction;
  const c = Math.cos(angle_rad);
  const s = Math.sin(angle_rad);
  const t = 1 - c;
  return [
    ...[t * x * x + c, t * x * y - s * z, t * x * z + s * y, 0],
    ...[t * x * y + s * z, t * y * y + c, t * y * z - s * x, 0],
    ...[t * x * z - s * y, t * y * z + s * x, t * z * z + c, 0],
    ...[0, 0, 0, 1],
  ];
}

/** A rotation vector (radians along the axis) as a pose. */
export function rotationOf(vector: Vec3): Pose {
  const angle = length(vector);
  return angle > 0 ? rotation(scale(vector, 1 / angle), angle) : [...IDENTITY];
}

/** `pose` turned about a world axis through a world point. */
export const turnedAbout = (pose: ArrayLike<number>, center: Vec3, direction: Vec3, angle_rad: number): Pose =>
  multiply(
    translation(center),
    multiply(rotation(direction, angle_rad), multiply(translation(scale(center, -1)), pose)),
  );

export const movedBy = (pose: ArrayLike<number>, by: Vec3): Pose => multiply(translation(by), pose);

/**
 * The same pose with axes of unit length at right angles.
 *
 * Rounding of many small turns adds up; the engine refuses a pose that is off by 1e-6.
 */
export function orthonormal(pose: ArrayLike<number>): Pose {
  const x = normalize(axis(pose, 0));
  const bent = axis(pose, 1);
  const y = normalize(subtract(bent, scale(x, dot(x, bent))));
  return fromAxes(x, y, cross(x, y), position(pose));
}

/** Angles about X, then Y, then Z of the world, of a pose: `Rz * Ry * Rx`. */
export function anglesOf(pose: ArrayLike<number>): Vec3 {
  const sine = Math.min(1, Math.max(-1, -at(pose, 2, 0)));
  const y = Math.asin(sine);
  if (Math.abs(sine) > 1 - 1e-12) return [0, y, Math.atan2(-at(pose, 0, 1), at(pose, 1, 1))];
  return [Math.atan2(at(pose, 2, 1), at(pose, 2, 2)), y, Math.atan2(at(pose, 1, 0), at(pose, 0, 0))];
}

/** The pose at `origin` with the angles that `anglesOf` reads. */
export function fromAngles(angles: Vec3, origin: Vec3): Pose {
  const turned = multiply(
    rotation([0, 0, 1], angles[2]),
    multiply(rotation([0, 1, 0], angles[1]), rotation([1, 0, 0], angles[0])),
  );
  return multiply(translation(origin), turned);
}

/** Whether no number differs by more than `tolerance`. */
export function isSamePose(a: ArrayLike<number>, b: ArrayLike<number>, tolerance = 1e-7): boolean {
  for (let k = 0; k < 16; k++) {
    if (!(Math.abs((a[k] ?? Number.NaN) - (b[k] ?? Number.NaN)) <= tolerance)) return false;
  }
  return true;
}
