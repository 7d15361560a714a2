// Moving the tool by the keyboard: G or R, an axis, a number, Enter. Pure: keys in, a pose out.

import { axis as axisOf, IDENTITY, movedBy, type Pose, turnedAbout } from "../math/matrix";
import { parseAngle, parseLength, type Unit } from "../math/units";
import { scale, type Vec3 } from "../math/vectors";

export interface TypedMove {
  readonly kind: "move" | "turn";
  readonly start: Pose;
  /** The point that is turned about, world. */
  readonly center: Vec3;
  /** 0, 1 or 2; null: the view plane, or the view direction for a turn. */
  readonly axis: 0 | 1 | 2 | null;
  readonly frame: "world" | "tool";
  /** The typed text so far. */
  readonly text: string;
}

export const startTyped = (
  kind: TypedMove["kind"],
  start: Pose,
  center: Vec3,
  frame: TypedMove["frame"],
): TypedMove => ({ kind, start, center, axis: null, frame, text: "" });

/** The same movement along another axis; the same axis again takes it from the other frame. */
export function withAxis(move: TypedMove, axis: 0 | 1 | 2): TypedMove {
  if (move.axis !== axis) return { ...move, axis };
  return { ...move, frame: move.frame === "world" ? "tool" : "world" };
}

/** Whether a key adds to the figure: digits and signs, and the letters of a unit once there is a digit. */
export function isFigureKey(move: TypedMove, key: string): boolean {
  if (key === "Backspace") return move.text !== "";
  if (/^[0-9.,\-/]$/.test(key)) return true;
  return /^[a-z]$/.test(key) && /\d/.test(move.text) && (move.kind === "move" ? "minc" : "degra").includes(key);
}

export function withKey(move: TypedMove, key: string): TypedMove {
  if (key === "Backspace") return { ...move, text: move.text.slice(0, -1) };
  // A minus anywhere turns the sign round, as typists of figures expect.
  if (key === "-") return { ...move, text: move.text.startsWith("-") ? move.text.slice(1) : `-${move.text}` };
  return { ...move, text: move.text + key };
}

/** The world direction along or about which it goes; null: as the view decides. */
export function directionOf(move: TypedMove): Vec3 | null {
  if (move.axis === null) return null;
  return axisOf(move.frame === "tool" ? move.start : IDENTITY, move.axis);
}

/**
 * The pose that the figure means; null while it cannot be read.
 *
 * Without an axis a length goes to the right of the picture, and an angle turns about the view direction.
 */
export function poseOfTyped(move: TypedMove, unit: Unit, view: { right: Vec3; towards: Vec3 }): Pose | null {
  if (move.kind === "move") {
    const by = parseLength(move.text, unit);
    return by === null ? null : movedBy(move.start, scale(directionOf(move) ?? view.right, by));
  }
  const angle_rad = parseAngle(move.text);
  return angle_rad === null ? null : turnedAbout(move.start, move.center, directionOf(move) ?? view.towards, angle_rad);
}
