// The gizmo: arrows to move and rings to turn the hand. Laid out, hit and drawn in the picture's pixels.

import { axis, IDENTITY, type Pose } from "../math/matrix";
import { add, cross, dot, normalize, type Point, perpendicular, scale, subtract, type Vec3 } from "../math/vectors";
import type { CameraRig } from "../scene/camera";
import type { Drag } from "./drag";

export interface Handle {
  readonly kind: Drag["kind"];
  /** 0, 1 or 2; null: the knob in the middle, which moves in the view plane. */
  readonly axis: 0 | 1 | 2 | null;
  /** World. */
  readonly direction: Vec3 | null;
  /** The shapes to draw and hit, pixels of the picture. */
  readonly line: readonly Point[];
}

export type GizmoView = Pick<CameraRig, "project" | "metresPerPixel" | "towards">;

const ARROW_PX = 62;
const RING_PX = 46;
const KNOB_PX = 9;
/** How far from a line it is still hit. */
const REACH_PX = 8;
const RING_STEPS = 48;
/** Half the side of the square that holds all of it. */
export const GIZMO_RADIUS_PX = 84;
// An arrow that points at the eye, or a ring seen from its edge, can be neither told apart nor dragged well.
const LEAST_ARROW_PX = 18;

/** The handles about a world point, along the axes of the tool or of the world; none if the point is behind the eye. */
export function layGizmo(center: Vec3, pose: Pose, frame: "world" | "tool", view: GizmoView): Handle[] {
  const middle = view.project(center);
  if (!middle.isAhead) return [];
  const metres = view.metresPerPixel(middle.depth);
  const towards = view.towards(center);
  const handles: Handle[] = [{ kind: "move", axis: null, direction: null, line: [middle] }];
  for (const index of [0, 1, 2] as const) {
    const direction = axis(frame === "tool" ? pose : IDENTITY, index);
    const tip = view.project(add(center, scale(direction, ARROW_PX * metres)));
    if (Math.hypot(tip.x - middle.x, tip.y - middle.y) >= LEAST_ARROW_PX) {
      const foot = view.project(add(center, scale(direction, 2 * KNOB_PX * metres)));
      handles.push({ kind: "move", axis: index, direction, line: [foot, tip] });
    }
    handles.push({
      kind: "turn",
      axis: index,
      direction,
      line: ring(center, direction, RING_PX * metres, towards, view),
    });
  }
  return handles;
}

/** The same handles elsewhere in the picture. */
export const shifted = (handles: readonly Handle[], dx: number, dy: number): Handle[] =>
  handles.map((handle) => ({ ...handle, line: handle.line.map(({ x, y }) => ({ x: x + dx, y: y + dy })) }));

/** The half of a ring that faces the eye. */
function ring(center: Vec3, about: Vec3, radius: number, towards: Vec3, view: GizmoView): Point[] {
  // The middle of the half ring looks at the eye, unless the ring does as a whole.
  const facing = subtract(towards, scale(about, dot(towards, about)));
  const u = normalize(facing, perpendicular(about));
  const v = cross(about, u);
  const isWhole = Math.abs(dot(towards, about)) > 0.98;
  const reach = isWhole ? Math.PI : Math.PI / 2;
  const points: Point[] = [];
  for (let k = 0; k <= RING_STEPS; k++) {
    const angle = -reach + (2 * reach * k) / RING_STEPS;
    const out = add(scale(u, radius * Math.cos(angle)), scale(v, radius * Math.sin(angle)));
    points.push(view.project(add(center, out)));
  }
  return points;
}

/** The handle at a pixel: the nearest within reach, the knob before arrows before rings. */
export function hitGizmo(handles: readonly Handle[], at: Point): Handle | null {
  let found: Handle | null = null;
  let nearest = REACH_PX;
  for (const handle of handles) {
    const reach = handle.axis === null ? KNOB_PX - REACH_PX : handle.kind === "turn" ? -1 : 0;
    const distance = distanceToLine(handle.line, at) - reach;
    if (distance <= nearest) {
      nearest = handle.axis === null ? Number.NEGATIVE_INFINITY : distance;
      found = handle;
    }
  }
  return found;
}

/** How far a pixel is from a line of pixels. */
export function distanceToLine(line: readonly Point[], at: Point): number {
  let least = Number.POSITIVE_INFINITY;
  for (const [k, end] of line.entries()) {
    const start = line[k - 1] ?? end;
    const [dx, dy] = [end.x - start.x, end.y - start.y];
    const size = dx * dx + dy * dy;
    const share = size > 0 ? Math.min(1, Math.max(0, ((at.x - start.x) * dx + (at.y - start.y) * dy) / size)) : 0;
    least = Math.min(least, Math.hypot(start.x + share * dx - at.x, start.y + share * dy - at.y));
  }
  return least;
}

/** Colours of the three axes, told apart by those who see red and green alike by their lightness and letters. */
const AXIS_COLOURS = ["#ff6b5e", "#8fd14f", "#5aa9ff"] as const;
const AXIS_NAMES = ["X", "Y", "Z"] as const;

/** Draws the handles on a canvas that covers `GIZMO_RADIUS_PX` about the middle, `lit` brighter. */
export function drawGizmo(
  context: CanvasRenderingContext2D,
  handles: readonly Handle[],
  lit: Handle | null,
  pixel_ratio: number,
): void {
  const middle = handles[0]?.line[0];
  const size = 2 * GIZMO_RADIUS_PX;
  context.setTransform(pixel_ratio, 0, 0, pixel_ratio, 0, 0);
  context.clearRect(0, 0, size, size);
  if (!middle) return;
  context.translate(GIZMO_RADIUS_PX - middle.x, GIZMO_RADIUS_PX - middle.y);
  context.lineCap = "round";
  context.lineJoin = "round";
  for (const handle of [...handles].sort((a, b) => rank(a) - rank(b))) {
    const isLit = lit !== null && lit.kind === handle.kind && lit.axis === handle.axis;
    const colour = handle.axis === null ? "#ffffff" : AXIS_COLOURS[handle.axis];
    context.beginPath();
    if (handle.axis === null) context.arc(middle.x, middle.y, KNOB_PX - 3, 0, 2 * Math.PI);
    else for (const point of handle.line) context.lineTo(point.x, point.y);
    // A dark rim keeps the lines in sight on light parts.
    context.strokeStyle = "rgba(0, 0, 0, 0.55)";
    context.lineWidth = isLit ? 7 : 5;
    context.stroke();
    context.strokeStyle = isLit ? "#ffe9a8" : colour;
    context.lineWidth = isLit ? 4 : 2.5;
    context.stroke();
    if (handle.kind === "move" && handle.axis !== null) drawHead(context, handle, isLit ? "#ffe9a8" : colour);
  }
}

const rank = (handle: Handle): number => (handle.kind === "turn" ? 0 : handle.axis === null ? 2 : 1);

function drawHead(context: CanvasRenderingContext2D, handle: Handle, colour: string): void {
  const [foot, tip] = handle.line;
  if (!foot || !tip || handle.axis === null) return;
  const size = Math.hypot(tip.x - foot.x, tip.y - foot.y) || 1;
  const [ux, uy] = [(tip.x - foot.x) / size, (tip.y - foot.y) / size];
  context.beginPath();
  context.moveTo(tip.x + 8 * ux, tip.y + 8 * uy);
  context.lineTo(tip.x - 6 * ux - 5 * uy, tip.y - 6 * uy + 5 * ux);
  context.lineTo(tip.x - 6 * ux + 5 * uy, tip.y - 6 * uy - 5 * ux);
  context.closePath();
  context.fillStyle = colour;
  context.fill();
  context.font = "600 11px system-ui, sans-serif";
  context.textAlign = "center";
  context.textBaseline = "middle";
  context.lineWidth = 3;
  context.strokeStyle = "rgba(0, 0, 0, 0.7)";
  const [x, y] = [tip.x + 16 * ux, tip.y + 16 * uy];
  context.strokeText(AXIS_NAMES[handle.axis], x, y);
  context.fillStyle = "#ffffff";
  context.fillText(AXIS_NAMES[handle.axis], x, y);
}
