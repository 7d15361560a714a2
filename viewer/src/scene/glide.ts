// The way between two cameras, for a view that glides there. Pure.

import type { Camera } from "../link/protocol";
import {
  add,
  cross,
  distance,
  dot,
  normalize,
  perpendicular,
  rotate,
  scale,
  subtract,
  type Vec3,
} from "../math/vectors";

/** Fast at first, slow at the end; 0 to 1. */
export const eased = (share: number): number => 1 - (1 - Math.min(1, Math.max(0, share))) ** 3;

const mix = (a: number, b: number, share: number): number => a + (b - a) * share;

/** The camera at `share` (0 to 1, before easing) of the way: it turns about its target as a turntable does. */
export function between(from: Camera, to: Camera, share: number): Camera {
  const t = eased(share);
  const target = add(from.target, scale(subtract(to.target, from.target), t));
  const [near, far] = [distance(from.position, from.target), distance(to.position, to.target)];
  const reach = near > 0 && far > 0 ? near * (far / near) ** t : mix(near, far, t);
  const { forward, up } = turned(from, to, t);
  return {
    position: subtract(target, scale(forward, reach)),
    target,
    up,
    fov_rad: mix(from.fov_rad, to.fov_rad, t),
    is_parallel: to.is_parallel ?? false,
  };
}

const forwardOf = (camera: Camera): Vec3 => normalize(subtract(camera.target, camera.position), [0, 1, 0]);

/** By heading and height where the vertical stays, which never rolls the view; else straight from one to the other. */
function turned(from: Camera, to: Camera, t: number): { forward: Vec3; up: Vec3 } {
  const [a, b] = [forwardOf(from), forwardOf(to)];
  if (dot(from.up, to.up) > 1 - 1e-9) {
    const up = to.up;
    const u = perpendicular(up);
    const v = cross(up, u);
    const heading = (f: Vec3) => Math.atan2(dot(f, v), dot(f, u));
    const height = (f: Vec3) => Math.asin(Math.max(-1, Math.min(1, dot(f, up))));
    let turn = heading(b) - heading(a);
    if (turn > Math.PI) turn -= 2 * Math.PI;
    if (turn < -Math.PI) turn += 2 * Math.PI;
    const [h, e] = [heading(a) + turn * t, mix(height(a), height(b), t)];
    const level = add(scale(u, Math.cos(h)), scale(v, Math.sin(h)));
    return { forward: add(scale(level, Math.cos(e)), scale(up, Math.sin(e))), up };
  }
  const forward = part(a, b, t);
  const up = part(from.up, to.up, t);
  return { forward, up: normalize(subtract(up, scale(forward, dot(up, forward))), perpendicular(forward)) };
}

/** The unit vector at `t` of the arc from `a` to `b`. */
function part(a: Vec3, b: Vec3, t: number): Vec3 {
  const angle = Math.acos(Math.max(-1, Math.min(1, dot(normalize(a), normalize(b)))));
  if (angle < 1e-6) return normalize(b);
  const about = normalize(cross(a, b), perpendicular(a));
  return rotate(normalize(a), about, angle * t);
}
