// The camera: eye and target. Plain numbers, no GL.
//
// World metres and radians. `fov` is the angle over the picture's height. In parallel projection the picture is as high as
// the perspective one is at the target, so that both show the target alike. Every change raises `moved`, which the stage
// clears once it has drawn.
//
// `glide` makes a change over some time. The camera then is somewhere on the way; whoever moves or saves it deals with its
// end: a change ends the glide at once, and `toJSON` says where it leads.

import type { Camera, UpAxis } from "../link/protocol";
import { isSame } from "../math/same";
import {
  add,
  type Box,
  centre,
  corners,
  cross,
  diagonal,
  distance,
  distanceToBox,
  dot,
  isEmpty,
  normalize,
  perpendicular,
  rotate,
  scale,
  subtract,
  type Vec3,
} from "../math/vectors";
import { between } from "./glide";

/** A point of the picture: CSS pixels from its upper left corner, and the depth along the view direction in metres. */
export interface Projected {
  x: number;
  y: number;
  depth: number;
  /** Before the eye. In parallel projection everything is. */
  isAhead: boolean;
}

const LEAST_DISTANCE = 1e-6;
// The least angle between the view direction and the vertical: at the pole itself a turntable has no heading.
const LEAST_ANGLE_TO_POLE = 1e-5;

export class CameraRig {
  position: Vec3 = [2, -2, 1.5];
  target: Vec3 = [0, 0, 0];
  up: Vec3 = [0, 0, 1];
  fov = 0.7;
  /** Parallel projection instead of perspective. */
  isParallel = false;
  moved = true;
  /** The picture's size in CSS pixels; the stage keeps it. */
  width = 1;
  height = 1;
  #glide: { from: Camera; to: Camera; began: number | null; ms: number } | null = null;

  /** The unit vector of the view direction. */
  get forward(): Vec3 {
    return normalize(subtract(this.target, this.position), [0, 1, 0]);
  }

  /** The unit vector to the right of the picture. */
  get right(): Vec3 {
    const forward = this.forward;
    return normalize(cross(forward, this.up), perpendicular(forward));
  }

  /** The unit vector to the top of the picture. */
  get top(): Vec3 {
    return cross(this.right, this.forward);
  }

  /** The distance of the target. */
  get reach(): number {
    return distance(this.position, this.target);
  }

  get isGliding(): boolean {
    return this.#glide !== null;
  }

  /** The unit vector from `p` to the eye. */
  towards(p: Vec3): Vec3 {
    return this.isParallel ? scale(this.forward, -1) : normalize(subtract(this.position, p), scale(this.forward, -1));
  }

  /** Metres a CSS pixel covers at the depth `depth`. */
  metresPerPixel(depth: number): number {
    return (2 * (this.isParallel ? this.reach : depth) * Math.tan(this.fov / 2)) / this.height;
  }

  /** Makes the changes of `change` within `ms` from the next frame on; at once where that is 0. */
  glide(change: (camera: CameraRig) => void, ms: number): void {
    const from = this.#now();
    this.finish();
    change(this);
    const to = this.#now();
    if (!(ms > 0) || isSame(from, to)) return;
    this.fromJSON(from);
    this.#glide = { from, to, began: null, ms };
  }

  /** Goes on with the glide; whether there is one. The first call is its beginning. */
  step(now: number): boolean {
    const glide = this.#glide;
    if (!glide) return false;
    glide.began ??= now;
    const share = (now - glide.began) / glide.ms;
    if (share >= 1) this.finish();
    else this.#take(between(glide.from, glide.to, share));
    return true;
  }

  /** Is at once where the glide leads. */
  finish(): void {
    const glide = this.#glide;
    if (glide) this.fromJSON(glide.to);
  }

  /** Turns about `pivot`: `dx` rad about the vertical (the picture goes right), `dy` rad over the top (it goes down). */
  orbit(dx: number, dy: number, pivot: Vec3): void {
    this.finish();
    const right = this.right;
    const toPole = Math.acos(Math.max(-1, Math.min(1, dot(this.forward, this.up))));
    // Tilting by `turn` moves the view direction towards the pole by as much: neither pole is passed.
    const turn = Math.max(toPole - Math.PI + LEAST_ANGLE_TO_POLE, Math.min(toPole - LEAST_ANGLE_TO_POLE, -dy));
    const about = (p: Vec3) => add(pivot, rotate(rotate(subtract(p, pivot), right, turn), this.up, -dx));
    const [position, target] = [about(this.position), about(this.target)];
    this.position = position;
    this.target = target;
    this.moved = true;
  }

  /** Turns the view about its own direction by `angle` rad. */
  roll(angle: number): void {
    this.finish();
    this.up = normalize(rotate(this.top, this.forward, angle));
    this.moved = true;
  }

  /** Moves with the picture: `dx` and `dy` CSS pixels, as far as a point at `depth` (else the target) moves with them. */
  pan(dx: number, dy: number, depth = this.reach): void {
    this.finish();
    const step = this.metresPerPixel(depth);
    this.translate(add(scale(this.right, -dx * step), scale(this.top, dy * step)));
  }

  /** Moves the eye and the target by `by` metres. */
  translate(by: Vec3): void {
    this.finish();
    this.position = add(this.position, by);
    this.target = add(this.target, by);
    this.moved = true;
  }

  /** Brings the eye to `factor` times its distance from `at` (below 1: nearer); `at` keeps its place in the picture. */
  dolly(factor: number, at: Vec3 = this.target): void {
    this.finish();
    const reach = (this.isParallel ? this.reach : distance(this.position, at)) * factor;
    if (!Number.isFinite(reach) || reach < LEAST_DISTANCE) return;
    const ahead = this.reach;
    const forward = this.forward;
    if (this.isParallel) {
      // Only across the view: the target stays in its depth.
      const away = subtract(at, this.target);
      const across = subtract(away, scale(forward, dot(away, forward)));
      this.target = add(this.target, scale(across, 1 - factor));
      this.position = subtract(this.target, scale(forward, ahead * factor));
      this.moved = true;
      return;
    }
    this.position = add(at, scale(subtract(this.position, at), factor));
    this.target = add(this.position, scale(forward, Math.max(ahead * factor, LEAST_DISTANCE)));
    this.moved = true;
  }

  /** Looks from the same side at all of `box`. An empty box changes nothing. */
  fit(box: Box): void {
    this.finish();
    if (isEmpty(box)) return;
    const [right, top, forward, middle] = [this.right, this.top, this.forward, centre(box)];
    const tanY = Math.tan(this.fov / 2) * 0.94;
    const tanX = (tanY * this.width) / this.height;
    let back = Math.max(diagonal(box), LEAST_DISTANCE) * 1e-3;
    for (const corner of corners(box)) {
      const p = subtract(corner, middle);
      const nearer = this.isParallel ? 0 : dot(p, forward);
      back = Math.max(back, Math.abs(dot(p, right)) / tanX - nearer, Math.abs(dot(p, top)) / tanY - nearer);
    }
    this.target = middle;
    this.position = subtract(middle, scale(forward, back));
    this.moved = true;
  }

  /**
   * One of the seven views of `box`: 1 front, 2 back, 3 left, 4 right, 5 top, 6 bottom, 7 from the front, right and above.
   * The vertical becomes `axis`. Any other number changes nothing.
   */
  view(n: number, box: Box, axis: UpAxis): void {
    const side = VIEWS[n - 1];
    if (side) this.viewFrom(side, box, axis);
  }

  /** Looks at `box` from the side `side`: its parts to the right, to the back and up, of any length. */
  viewFrom(side: Vec3, box: Box, axis: UpAxis): void {
    const { right, ahead, above } = viewFrame(axis);
    const [x, y, z] = normalize(side, [0, -1, 0]);
    // Straight up or down, the heading would be lost: the eye stays a little off the pole, the top of the picture ahead.
    const tilt = Math.hypot(x, y) < LEAST_ANGLE_TO_POLE ? -2 * LEAST_ANGLE_TO_POLE : 0;
    const away = add(add(scale(right, x), scale(ahead, y + tilt)), scale(above, z));
    this.finish();
    this.up = [...above];
    this.target = isEmpty(box) ? [0, 0, 0] : centre(box);
    this.position = add(this.target, normalize(away));
    this.moved = true;
    this.fit(box);
  }

  /** The near and far planes for a scene in `box`: nothing of it is cut, and the depth buffer is used well. */
  range(box: Box, isReversed: boolean, isParallel = this.isParallel): { near: number; far: number } {
    if (isParallel) {
      // The eye may be amid the scene, or behind it. Far more than the box: things in hand are anywhere.
      const depth = isEmpty(box) ? this.reach : dot(subtract(centre(box), this.position), this.forward);
      const room = 10 * Math.max(diagonal(box), 1e-3) + 2 * this.reach;
      return { near: depth - room, far: depth + room };
    }
    const size = Math.max(diagonal(box), distance(this.position, this.target) * 0.1, 1e-3);
    const clear = isEmpty(box) ? 0 : distanceToBox(this.position, box);
    // A reversed float depth resolves near and far alike; a fixed-point one spends its bits in front of the near plane.
    const near = isReversed ? size * 1e-4 : Math.max(size * 2e-3, clear * 0.5);
    return {
      near: Math.min(near, Math.max(distance(this.position, this.target) * 0.2, 1e-6)),
      far: (clear + size) * (isReversed ? 1e3 : 4),
    };
  }

  /** The ray through the point (`x`, `y`) of the picture, CSS pixels: the eye and a unit direction. */
  ray(x: number, y: number): { origin: Vec3; direction: Vec3 } {
    const tan = Math.tan(this.fov / 2);
    const across = ((2 * x) / this.width - 1) * tan * (this.width / this.height);
    const up = (1 - (2 * y) / this.height) * tan;
    const aside = add(scale(this.right, across), scale(this.top, up));
    if (this.isParallel) return { origin: add(this.position, scale(aside, this.reach)), direction: this.forward };
    const direction = add(this.forward, aside);
    return { origin: [...this.position], direction: normalize(direction) };
  }

  /** Where the world point `p` is in the picture; a depth of zero or less is behind the eye. */
  project(p: Vec3): Projected {
    const to = subtract(p, this.position);
    const depth = dot(to, this.forward);
    const focal = 1 / this.metresPerPixel(Math.max(depth, LEAST_DISTANCE));
    return {
      x: this.width / 2 + dot(to, this.right) * focal,
      y: this.height / 2 - dot(to, this.top) * focal,
      depth,
      isAhead: this.isParallel || depth > 0,
    };
  }

  /** The camera, at the end of its glide. */
  toJSON(): Camera {
    return this.#glide ? structuredClone(this.#glide.to) : this.#now();
  }

  /** The camera at the end of its glide, as one of its own. */
  get arrived(): CameraRig {
    const there = new CameraRig();
    Object.assign(there, { width: this.width, height: this.height });
    there.fromJSON(this.toJSON());
    return there;
  }

  setParallel(isParallel: boolean): void {
    if (isParallel === this.toJSON().is_parallel) return;
    this.finish();
    this.isParallel = isParallel;
    this.moved = true;
  }

  /** The camera is there at once. */
  fromJSON(state: Camera): void {
    this.#glide = null;
    this.#take(state);
  }

  #now(): Camera {
    return {
      position: [...this.position],
      target: [...this.target],
      up: [...this.up],
      fov_rad: this.fov,
      is_parallel: this.isParallel,
    };
  }

  #take(state: Camera): void {
    this.position = [...state.position];
    this.target = [...state.target];
    this.up = [...state.up];
    this.fov = state.fov_rad;
    this.isParallel = state.is_parallel ?? false;
    this.moved = true;
  }
}

// From which sides the seven views look: to the right, to the back, up.
const VIEWS: readonly Vec3[] = [
  [0, -1, 0],
  [0, 1, 0],
  [-1, 0, 0],
  [1, 0, 0],
  [0, 0, 1],
  [0, 0, -1],
  [0.8, -1, 0.7],
];

/** What is to the right, to the back and up in the view from the front, where `axis` is the vertical. */
export function viewFrame(axis: UpAxis): { right: Vec3; ahead: Vec3; above: Vec3 } {
  if (axis === "y") return { right: [1, 0, 0], ahead: [0, 0, -1], above: [0, 1, 0] };
  if (axis === "x") return { right: [0, 1, 0], ahead: [0, 0, 1], above: [1, 0, 0] };
  return { right: [1, 0, 0], ahead: [0, 1, 0], above: [0, 0, 1] };
}
