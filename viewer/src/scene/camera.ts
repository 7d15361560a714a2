// The camera: eye and target. Plain numbers, no GL.
//
// World metres and radians. `fov` is the angle over the picture's height. Every change raises `moved`, which the stage
// clears once it has drawn.

import type { Camera, UpAxis } from "../link/protocol";
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

/** A point of the picture: CSS pixels from its upper left corner, and the depth along the view direction in metres. */
export interface Projected {
  x: number;
  y: number;
  depth: number;
}

const LEAST_DISTANCE = 1e-6;
// The least angle between the view direction and the vertical: at the pole itself a turntable has no heading.
const LEAST_ANGLE_TO_POLE = 1e-3;

export class CameraRig {
  position: Vec3 = [2, -2, 1.5];
  target: Vec3 = [0, 0, 0];
  up: Vec3 = [0, 0, 1];
  fov = 0.7;
  moved = true;
  /** The picture's size in CSS pixels; the stage keeps it. */
  width = 1;
  height = 1;

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

  /** Metres a CSS pixel covers at the depth `depth`. */
  metresPerPixel(depth: number): number {
    return (2 * depth * Math.tan(this.fov / 2)) / this.height;
  }

  /** Turns about `pivot`: `dx` rad about the vertical (the picture goes right), `dy` rad over the top (it goes down). */
  orbit(dx: number, dy: number, pivot: Vec3): void {
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
    this.up = normalize(rotate(this.top, this.forward, angle));
    this.moved = true;
  }

  /** Moves with the picture: `dx` and `dy` CSS pixels, as far as a point at `depth` (else the target) moves with them. */
  pan(dx: number, dy: number, depth = distance(this.position, this.target)): void {
    const step = this.metresPerPixel(depth);
    this.translate(add(scale(this.right, -dx * step), scale(this.top, dy * step)));
  }

  /** Moves the eye and the target by `by` metres. */
  translate(by: Vec3): void {
    this.position = add(this.position, by);
    this.target = add(this.target, by);
    this.moved = true;
  }

  /** Brings the eye to `factor` times its distance from `at` (below 1: nearer); `at` keeps its place in the picture. */
  dolly(factor: number, at: Vec3 = this.target): void {
    const reach = distance(this.position, at) * factor;
    if (!Number.isFinite(reach) || reach < LEAST_DISTANCE) return;
    const ahead = distance(this.position, this.target);
    const forward = this.forward;
    this.position = add(at, scale(subtract(this.position, at), factor));
    this.target = add(this.position, scale(forward, Math.max(ahead * factor, LEAST_DISTANCE)));
    this.moved = true;
  }

  /** Looks from the same side at all of `box`. An empty box changes nothing. */
  fit(box: Box): void {
    if (isEmpty(box)) return;
    const [right, top, forward, middle] = [this.right, this.top, this.forward, centre(box)];
    const tanY = Math.tan(this.fov / 2) * 0.94;
    const tanX = (tanY * this.width) / this.height;
    let back = Math.max(diagonal(box), LEAST_DISTANCE) * 1e-3;
    for (const corner of corners(box)) {
      const p = subtract(corner, middle);
      back = Math.max(
        back,
        Math.abs(dot(p, right)) / tanX - dot(p, forward),
        Math.abs(dot(p, top)) / tanY - dot(p, forward),
      );
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
    const frame = {
      z: [
        [1, 0, 0],
        [0, 1, 0],
        [0, 0, 1],
      ],
      y: [
        [1, 0, 0],
        [0, 0, -1],
        [0, 1, 0],
      ],
      x: [
        [0, 1, 0],
        [0, 0, 1],
        [1, 0, 0],
      ],
    }[axis];
    const [right, ahead, above] = frame as [Vec3, Vec3, Vec3];
    const views: [Vec3, Vec3][] = [
      [ahead, above],
      [scale(ahead, -1), above],
      [right, above],
      [scale(right, -1), above],
      [scale(above, -1), ahead],
      [above, ahead],
      [normalize(add(add(scale(right, -0.8), ahead), scale(above, -0.7))), above],
    ];
    const found = views[n - 1];
    if (!found) return;
    // Straight up or down, the heading would be lost: the eye stays a little off the pole, the top of the picture ahead.
    const tilt = n === 5 || n === 6 ? scale(found[1], 2 * LEAST_ANGLE_TO_POLE) : ([0, 0, 0] as Vec3);
    this.up = [...above];
    this.target = isEmpty(box) ? [0, 0, 0] : centre(box);
    this.position = subtract(this.target, normalize(add(found[0], tilt)));
    this.moved = true;
    this.fit(box);
  }

  /** The near and far planes for a scene in `box`: nothing of it is cut, and the depth buffer is used well. */
  range(box: Box, isReversed: boolean): { near: number; far: number } {
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
    const direction = add(add(this.forward, scale(this.right, across)), scale(this.top, up));
    return { origin: [...this.position], direction: normalize(direction) };
  }

  /** Where the world point `p` is in the picture; a depth of zero or less is behind the eye. */
  project(p: Vec3): Projected {
    const to = subtract(p, this.position);
    const depth = dot(to, this.forward);
    const focal = this.height / (2 * Math.tan(this.fov / 2) * Math.max(depth, LEAST_DISTANCE));
    return { x: this.width / 2 + dot(to, this.right) * focal, y: this.height / 2 - dot(to, this.top) * focal, depth };
  }

  toJSON(): Camera {
    return { position: [...this.position], target: [...this.target], up: [...this.up], fov_rad: this.fov };
  }

  fromJSON(state: Camera): void {
    this.position = [...state.position];
    this.target = [...state.target];
    this.up = [...state.up];
    this.fov = state.fov_rad;
    this.moved = true;
  }
}
