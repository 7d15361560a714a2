// Section planes and their outlines: data for the shaders, and lines.

import { type IUniform, Scene, type Vector4 } from "three";
import {
  add,
  type Box,
  corners,
  cross,
  dot,
  emptyBox,
  include,
  isEmpty,
  normalize,
  scale,
  subtract,
  type Vec3,
} from "../math/vectors";
import { Lines, type Tint } from "./strokes";

/** A plane of a section: kept where normal . x >= offset. World metres. */
export interface SectionPlane {
  normal: Vec3;
  offset: number;
}

const FRAME: Tint = [0.45, 0.72, 1.0, 0.7];
const OUTLINE: Tint = [0.05, 0.05, 0.07, 0.9];

/** The 12 edges of a box: along each axis, from the four corners of its face at the lower side. */
function edges(box: Box): [Vec3, Vec3][] {
  const found: [Vec3, Vec3][] = [];
  for (let axis = 0; axis < 3; axis++) {
    for (let bits = 0; bits < 4; bits++) {
      const from: Vec3 = [...box.lower];
      const [u, v] = [(axis + 1) % 3, (axis + 2) % 3];
      if (bits & 1) from[u] = box.upper[u] as number;
      if (bits & 2) from[v] = box.upper[v] as number;
      const to: Vec3 = [...from];
      to[axis] = box.upper[axis] as number;
      found.push([from, to]);
    }
  }
  return found;
}

/** The polygon in which the plane meets `box`, in order around it: 3 to 6 points, or none. */
export function planeInBox({ normal, offset }: SectionPlane, box: Box): Vec3[] {
  const points: Vec3[] = [];
  for (const [from, to] of edges(box)) {
    const [a, b] = [dot(normal, from) - offset, dot(normal, to) - offset];
    if (a < 0 === b < 0) continue;
    points.push(add(from, scale(subtract(to, from), a / (a - b))));
  }
  if (points.length < 3) return [];
  const middle = scale(points.reduce(add, [0, 0, 0] as Vec3), 1 / points.length);
  const across = normalize(subtract(points[0] as Vec3, middle), [1, 0, 0]);
  const up = cross(normalize(normal), across);
  const angle = (p: Vec3) => Math.atan2(dot(subtract(p, middle), up), dot(subtract(p, middle), across));
  return points.sort((p, q) => angle(p) - angle(q));
}

/** The part of `box` that `sections` leave, in a box of its own; empty where they leave nothing. */
export function clipBox(box: Box, sections: readonly SectionPlane[]): Box {
  let left = box;
  for (const section of sections) {
    if (isEmpty(left)) return left;
    const next = emptyBox();
    for (const corner of corners(left)) if (dot(section.normal, corner) >= section.offset) include(next, corner);
    for (const point of planeInBox(section, left)) include(next, point);
    left = next;
  }
  return left;
}

export class SectionLines {
  readonly scene = new Scene();
  readonly #frames: Lines;
  readonly #outlines: Lines;

  constructor(uniforms: Record<string, IUniform>, middle: Vec3) {
    this.#frames = new Lines(uniforms, middle, 0.25);
    this.#outlines = new Lines(uniforms, middle, 0);
    this.scene.add(this.#frames.mesh, this.#outlines.mesh);
  }

  get isEmpty(): boolean {
    return !this.#frames.mesh.visible && !this.#outlines.mesh.visible;
  }

  /** The frames of the cuts, where each meets `box`, and the edges of the section box. `count`: of all planes. */
  setFrames(cuts: readonly SectionPlane[], sectionBox: Box | null, box: Box, count: number): void {
    this.#frames.clear();
    for (const [from, to] of sectionBox ? edges(sectionBox) : []) this.#frames.add(from, to, FRAME, 1.5);
    for (const section of cuts) {
      const polygon = planeInBox(section, box);
      polygon.forEach((p, k) => {
        this.#frames.add(p, polygon[(k + 1) % polygon.length] as Vec3, FRAME, 1.5);
      });
    }
    this.#frames.commit();
    this.#frames.setSections(count);
    this.#outlines.setSections(count);
  }

  /** Exact outlines by the engine: (k, 2, 3), world metres. */
  setOutlines(segments: Float32Array | null): void {
    this.#outlines.clear();
    for (let at = 0; segments && at + 6 <= segments.length; at += 6) {
      const p = segments.subarray(at, at + 6) as unknown as number[];
      this.#outlines.add([p[0], p[1], p[2]] as Vec3, [p[3], p[4], p[5]] as Vec3, OUTLINE, 1.5);
    }
    this.#outlines.commit();
  }

  dispose(): void {
    this.#frames.dispose();
    this.#outlines.dispose();
  }
}

/** Writes `sections` into the uniforms: world coordinates less `middle`, and view coordinates of the camera's axes.
 *
 * `slack`: as much more is cut away, metres, so that a face in the plane of a cut is gone as a whole, not in specks. */
export function writePlanes(
  sections: readonly SectionPlane[],
  middle: Vec3,
  camera: { position: Vec3; right: Vec3; top: Vec3; forward: Vec3 },
  cut: Vector4[],
  view: Vector4[],
  slack = 0,
): void {
  sections.forEach(({ normal, offset }, k) => {
    cut[k]?.set(...normal, offset - dot(normal, middle) + slack);
    const [x, y, z] = [dot(normal, camera.right), dot(normal, camera.top), -dot(normal, camera.forward)];
    view[k]?.set(x, y, z, offset - dot(normal, camera.position));
  });
}
