// Where the gizmo stands in the picture: beside the tool that it would cover, and never cut by the frame. Pixels.

import { add, distance, type Point, scale, subtract, type Vec3 } from "../math/vectors";
import type { CameraRig } from "../scene/camera";
import type { Area } from "../scene/labels";
import { distanceToLine, GIZMO_RADIUS_PX } from "./gizmo";

/** How far the gizmo stands from the point that it moves, and in which of the directions; null: on it. */
export interface GizmoPlace {
  readonly dx: number;
  readonly dy: number;
  readonly way: number | null;
}

/** So far the middle of the gizmo stays away from the tool: its arrows then do not reach over it. */
const CLEAR_PX = 72;
const STEP_PX = 6;
/** Farther it would seem to belong to something else: it stands on the tool then. */
const MOST_PX = 240;
/** A place in the direction of before may be farther by so much: the gizmo does not jump about. */
const KEPT_PX = 60;
const WAYS = 16;

/** Where a box lies in the picture, by its eight corners in the order of `corners`; none if all are behind the eye. */
export function pointsOf(points: readonly Vec3[], view: Pick<CameraRig, "project">): Point[] {
  const places = points.map((point) => view.project(point));
  const seen = places.filter((each) => each.isAhead);
  if (seen.length === 0) return [];
  // An edge that goes behind the eye leaves the picture in its direction: it is cut close before the eye.
  const close = 1e-2 * Math.max(...seen.map(({ depth }) => depth));
  const cut = points.flatMap((point, k) =>
    [1, 2, 4].flatMap((bit) => {
      const [a, b] = [places[k], places[k ^ bit]];
      const end = points[k ^ bit];
      if (!a || !b || !end || !a.isAhead || b.isAhead || a.depth <= close) return [];
      const share = (a.depth - close) / (a.depth - b.depth);
      return [view.project(add(point, scale(subtract(end, point), share)))];
    }),
  );
  return [...seen, ...cut];
}

/** The rectangle around points of the picture; null for none. */
export function areaOf(points: readonly Point[]): Area | null {
  if (points.length === 0) return null;
  return {
    left: Math.min(...points.map(({ x }) => x)),
    right: Math.max(...points.map(({ x }) => x)),
    top: Math.min(...points.map(({ y }) => y)),
    bottom: Math.max(...points.map(({ y }) => y)),
  };
}

/** The corners of the convex hull of points, in order around it (Andrew's monotone chain). */
export function hullOf(points: readonly Point[]): Point[] {
  const sorted = [...points].sort((a, b) => a.x - b.x || a.y - b.y);
  if (sorted.length < 3) return sorted;
  const half = (all: readonly Point[]): Point[] => {
    const found: Point[] = [];
    for (const point of all) {
      while (found.length > 1 && turn(found.at(-2) as Point, found.at(-1) as Point, point) <= 0) found.pop();
      found.push(point);
    }
    return found.slice(0, -1);
  };
  return [...half(sorted), ...half(sorted.reverse())];
}

const SLIDE_PX = 12;
const MOST_SLIDES = 60;

const turn = (a: Point, b: Point, c: Point): number => (b.x - a.x) * (c.y - a.y) - (b.y - a.y) * (c.x - a.x);

/** How far a point is from a convex hull; 0 within. */
export function distanceToHull(hull: readonly Point[], at: Point): number {
  if (hull.length === 0) return Infinity;
  const closed = [...hull, hull[0] as Point];
  const isInside = hull.length > 2 && hull.every((a, k) => turn(a, closed[k + 1] as Point, at) >= 0);
  return isInside ? 0 : distanceToLine(closed, at);
}

/** Whether some of `area` is in a picture of that size, by at least `least` pixels. */
export const isInPicture = (area: Area | null, width: number, height: number, least = 2): boolean =>
  area !== null &&
  area.right >= least &&
  area.bottom >= least &&
  area.left <= width - least &&
  area.top <= height - least;

const doOverlap = (a: Area, b: Area): boolean =>
  a.left < b.right && b.left < a.right && a.top < b.bottom && b.top < a.bottom;

const around = ({ x, y }: Point): Area => ({
  left: x - GIZMO_RADIUS_PX,
  right: x + GIZMO_RADIUS_PX,
  top: y - GIZMO_RADIUS_PX,
  bottom: y + GIZMO_RADIUS_PX,
});

/**
 * The place of the gizmo that moves the point at `middle`: the nearest beside the tool, whose hull in the picture is given.
 * `taken`: what lies over the picture. `before`: the direction in which it stood, which it keeps where it can.
 */
export function placeGizmo(
  middle: Point,
  tool: readonly Point[],
  picture: { readonly width: number; readonly height: number },
  taken: readonly Area[],
  before: number | null,
): GizmoPlace {
  const { width, height } = picture;
  const isFree = (at: Point): boolean =>
    at.x >= GIZMO_RADIUS_PX &&
    at.y >= GIZMO_RADIUS_PX &&
    at.x <= width - GIZMO_RADIUS_PX &&
    at.y <= height - GIZMO_RADIUS_PX &&
    distanceToHull(tool, at) >= CLEAR_PX &&
    !taken.some((area) => doOverlap(area, around(at)));
  const at = (way: number, far: number): Point => {
    const angle = (2 * Math.PI * way) / WAYS;
    return { x: middle.x + far * Math.cos(angle), y: middle.y + far * Math.sin(angle) };
  };
  let best: { way: number; far: number; cost: number } | null = null;
  for (let way = 0; tool.length > 0 && way < WAYS; way++) {
    const favour = way === before ? KEPT_PX : 0;
    for (let far = 0; far <= MOST_PX && (!best || far - favour < best.cost); far += STEP_PX) {
      if (!isFree(at(way, far))) continue;
      best = { way, far, cost: far - favour };
      break;
    }
  }
  if (best) {
    const found = at(best.way, best.far);
    return { dx: found.x - middle.x, dy: found.y - middle.y, way: best.way };
  }
  const x = Math.min(Math.max(middle.x, GIZMO_RADIUS_PX), Math.max(width - GIZMO_RADIUS_PX, width / 2));
  const y = Math.min(Math.max(middle.y, GIZMO_RADIUS_PX), Math.max(height - GIZMO_RADIUS_PX, height / 2));
  // The tool is mostly out of the picture: at its edge, but not under what lies over it.
  const near = Array.from({ length: 2 * MOST_SLIDES }, (_, k) => ({ x, y: y + SLIDE_PX * slide(k) })).find(
    (each) =>
      each.y >= GIZMO_RADIUS_PX &&
      each.y <= height - GIZMO_RADIUS_PX &&
      !taken.some((area) => doOverlap(area, around(each))),
  );
  return { dx: x - middle.x, dy: (near?.y ?? y) - middle.y, way: null };
}

/** 0, 1, -1, 2, -2, ... */
const slide = (k: number): number => Math.ceil(k / 2) * (k % 2 === 0 ? -1 : 1);

const SLICES = 8;

/** A box in slices along its longest side, each by its corners: what lies aslant covers less than its rectangle. */
export function slices(box: readonly Vec3[]): Vec3[][] {
  const [first] = box;
  if (!first || box.length !== 8) return [];
  const along = [1, 2, 4].reduce((a, b) => (distance(first, box[b] as Vec3) > distance(first, box[a] as Vec3) ? b : a));
  return Array.from({ length: SLICES }, (_, k) =>
    box.map((corner, at) => {
      const [from, to] = at & along ? [box[at - along] as Vec3, corner] : [corner, box[at + along] as Vec3];
      return add(from, scale(subtract(to, from), (k + (at & along ? 1 : 0)) / SLICES));
    }),
  );
}

/**
 * Where an arrow at the edge of the picture points to something out of it, and by which angle (radians, clockwise from
 * right). It slides along its edge where `taken` is in its way.
 */
export function edgeArrow(
  target: Point,
  picture: { readonly width: number; readonly height: number },
  margin: number,
  taken: readonly Area[] = [],
): Point & { readonly angle: number } {
  const [halfX, halfY] = [picture.width / 2, picture.height / 2];
  const [dx, dy] = [target.x - halfX, target.y - halfY];
  const [mostX, mostY] = [Math.max(halfX - margin, 1), Math.max(halfY - margin, 1)];
  const [shareX, shareY] = [mostX / Math.max(Math.abs(dx), 1e-9), mostY / Math.max(Math.abs(dy), 1e-9)];
  const share = Math.min(shareX, shareY);
  const isAtSide = shareX <= shareY;
  const first = { x: halfX + dx * share, y: halfY + dy * share };
  const angle = Math.atan2(dy, dx);
  for (let k = 0; k < MOST_SLIDES; k++) {
    const by = SLIDE_PX * slide(k);
    const at = isAtSide ? { x: first.x, y: first.y + by } : { x: first.x + by, y: first.y };
    if (Math.abs(at.x - halfX) > mostX + 1e-6 || Math.abs(at.y - halfY) > mostY + 1e-6) continue;
    const area = { left: at.x - margin, right: at.x + margin, top: at.y - margin, bottom: at.y + margin };
    if (!taken.some((other) => doOverlap(area, other))) return { ...at, angle };
  }
  return { ...first, angle };
}
