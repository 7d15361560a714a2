// Where pixels point: onto a plane across the view, and along an axis.

import { add, dot, type Point, scale, subtract, type Vec3 } from "./vectors";

/** The part of a camera that this needs. */
export interface PointerView {
  /** The unit view direction. */
  readonly forward: Vec3;
  /** The pixel that shows a point. */
  project(p: Vec3): Point;
  /** The ray that a pixel sees: its unit direction. */
  ray(x: number, y: number): { origin: Vec3; direction: Vec3 };
  /** The unit direction from a point to the eye. */
  towards(p: Vec3): Vec3;
}

/** The point on the plane through `center` across the view direction that a pixel sees. */
function onViewPlane(center: Vec3, view: PointerView, at: Point): Vec3 {
  const { origin, direction } = view.ray(at.x, at.y);
  const depth = dot(subtract(center, origin), view.forward);
  return add(origin, scale(direction, depth / Math.max(dot(direction, view.forward), 1e-9)));
}

/** Where the pointer went in the plane through `center` across the view direction. */
export function inViewPlane(center: Vec3, view: PointerView, from: Point, to: Point): Vec3 {
  return subtract(onViewPlane(center, view, to), onViewPlane(center, view, from));
}

/** How far along an axis through `center` the pointer went, metres. */
export function alongAxis(center: Vec3, direction: Vec3, view: PointerView, from: Point, to: Point): number {
  const towards = scale(view.towards(center), -1);
  // An axis that points at the eye is a dot in the picture: the way up the picture then moves along it.
  if (Math.abs(dot(towards, direction)) > 0.995) {
    const moved = inViewPlane(center, view, from, { x: from.x, y: to.y });
    return Math.hypot(...moved) * Math.sign(from.y - to.y) * Math.sign(dot(towards, direction));
  }
  return placeOnAxis(center, direction, view, to) - placeOnAxis(center, direction, view, from);
}

/** How far along the axis through `center` the point lies that is nearest to a pixel's ray, metres. */
function placeOnAxis(center: Vec3, direction: Vec3, view: PointerView, at: Point): number {
  const ray = view.ray(at.x, at.y);
  const between = subtract(center, ray.origin);
  const cosine = dot(direction, ray.direction);
  const apart = Math.max(1 - cosine * cosine, 1e-6);
  return (cosine * dot(ray.direction, between) - dot(direction, between)) / apart;
}
