// Dragging the hand by the pointer: in the view plane, along an axis, or about one. Pixels in, poses out.

import { movedBy, type Pose, turnedAbout } from "../math/matrix";
import { alongAxis, inViewPlane, type PointerView } from "../math/pointing";
import { dot, type Point, scale, type Vec3 } from "../math/vectors";
import { directionOf, type TypedMove } from "../model/typed-move";

/** The drag: of a pose, about or through a world point, along a unit world direction or (null) in the view plane. */
export interface Drag {
  readonly kind: "move" | "turn";
  readonly start: Pose;
  readonly center: Vec3;
  readonly direction: Vec3 | null;
}

/** A movement by keys, in the form of a pointer's drag. */
export const dragOf = (move: TypedMove): Drag => ({
  kind: move.kind,
  start: move.start,
  center: move.center,
  direction: directionOf(move),
});

/** Rounds a length (metres) or an angle (radians) to the step chosen; as it is where none is. */
export type Snap = (value: number, kind: "length" | "angle") => number;

/** The pose when the pointer has gone from one pixel to another. */
export function dragged(drag: Drag, view: PointerView, from: Point, to: Point, snap: Snap): Pose {
  if (drag.kind === "turn") return turnedBy(drag, view, angleBetween(drag, view, from, to), snap);
  const by = drag.direction
    ? alongAxis(drag.center, drag.direction, view, from, to)
    : inViewPlane(drag.center, view, from, to);
  return movedAlong(drag, by, snap);
}

/** The drag's pose moved by `by` metres along its direction, or by a vector in the view plane. */
function movedAlong(drag: Drag, by: number | Vec3, snap: Snap): Pose {
  if (typeof by !== "number") {
    const distance = Math.hypot(...by);
    const snapped = snap(distance, "length");
    return movedBy(drag.start, distance > 0 ? scale(by, snapped / distance) : by);
  }
  return movedBy(drag.start, scale(drag.direction ?? [0, 0, 0], snap(by, "length")));
}

function turnedBy(drag: Drag, view: PointerView, angle_rad: number, snap: Snap): Pose {
  const about = drag.direction ?? scale(view.forward, -1);
  return turnedAbout(drag.start, drag.center, about, snap(angle_rad, "angle"));
}

/** The angle that the pointer went about the centre in the picture, as seen against the axis: radians. */
function angleBetween(drag: Drag, view: PointerView, from: Point, to: Point): number {
  const middle = view.project(drag.center);
  const angle = (at: Point): number => Math.atan2(middle.y - at.y, at.x - middle.x);
  let turned = angle(to) - angle(from);
  if (turned > Math.PI) turned -= 2 * Math.PI;
  if (turned < -Math.PI) turned += 2 * Math.PI;
  if (!drag.direction) return turned;
  const towards = dot(drag.direction, view.towards(drag.center));
  return towards < 0 ? -turned : turned;
}
