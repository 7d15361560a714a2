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

/**
 * Whether a key adds to the figure: every sign does, so that none is lost, and letters once there is something.
 *
 * X, Y and Z stay axes; G and R stay movements, but behind a digit they are of `deg` and `rad`.
 */
export function isFigureKey(move: TypedMove, key: string): boolean {
  if (key === "Backspace") return move.text !== "";
  if ([...key].length !== 1 || /[xyz]/i.test(key)) return false;
  if (/[gr]/i.test(key)) return move.kind === "turn" && /\d/.test(move.text);
  return /[\p{L}\s]/u.test(key) ? move.text !== "" : true;
}

export function withKey(move: TypedMove, key: string): TypedMove {
  if (key === "Backspace") return { ...move, text: move.text.slice(0, -1) };
  // A minus anywhere turns the sign round, as typists of figures expect; behind the e of `1e-3` it is that of the power.
  if (key === "-" && !/[\d.,]e$/i.test(move.text))
    return { ...move, text: move.text.startsWith("-") ? move.text.slice(1) : `-${move.text}` };
  return { ...move, text: move.text + key };
}

/** The world direction along or about which it goes; null: as the view decides. */
export function directionOf(move: TypedMove): Vec3 | null {
  if (move.axis === null) return null;
  return axisOf(move.frame === "tool" ? move.start : IDENTITY, move.axis);
}

/** The figure, metres or radians; null where it cannot be read. */
const readFigure = ({ kind, text }: TypedMove, unit: Unit): number | null =>
  kind === "move" ? parseLength(text, unit) : parseAngle(text);

/** Why the text is no figure: "1.5.2 is no length"; empty if it is one, or there is none. */
export function wrongFigure(move: TypedMove, unit: Unit): string {
  if (move.text === "" || readFigure(move, unit) !== null) return "";
  return `${move.text} is no ${move.kind === "move" ? "length" : "angle"}`;
}

/**
 * The pose that the figure means; null while it cannot be read.
 *
 * Without an axis a length goes to the right of the picture, and an angle turns about the view direction.
 */
export function poseOfTyped(move: TypedMove, unit: Unit, view: { right: Vec3; towards: Vec3 }): Pose | null {
  const by = readFigure(move, unit);
  if (by === null) return null;
  const direction = directionOf(move);
  if (move.kind === "move") return movedBy(move.start, scale(direction ?? view.right, by));
  return turnedAbout(move.start, move.center, direction ?? view.towards, by);
}
