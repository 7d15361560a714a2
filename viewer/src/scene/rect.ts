// Passes over a part of the picture: what only concerns the surroundings of the hand costs no more than that.

import {
  BackSide,
  BufferAttribute,
  BufferGeometry,
  GLSL3,
  type IUniform,
  Matrix4,
  Mesh,
  RawShaderMaterial,
  Scene,
  type ShaderMaterialParameters,
  type WebGLRenderer,
} from "three";
import { type Box, corners, isEmpty, subtract, type Vec3 } from "../math/vectors";
import type { Eye } from "./eye";
import { boxVertex } from "./shaders";

/** Pixels of a target, from its lower left corner. */
export interface Rect {
  left: number;
  bottom: number;
  width: number;
  height: number;
}

/** The pixels that `box` (world metres) may cover in a picture of `width` x `height`, with `margin` more around; null: none. */
export function rectOf(box: Box, middle: Vec3, eye: Eye, width: number, height: number, margin: number): Rect | null {
  if (isEmpty(box)) return null;
  const clip = eye.projectionMatrix.clone().multiply(eye.matrixWorldInverse).elements;
  const low = [Infinity, Infinity];
  const high = [-Infinity, -Infinity];
  let isBehind = false;
  for (const corner of corners(box)) {
    const [x, y, z] = subtract(corner, middle);
    const row = (k: number) =>
      (clip[k] as number) * x + (clip[k + 4] as number) * y + (clip[k + 8] as number) * z + (clip[k + 12] as number);
    const w = row(3);
    if (w <= 1e-9) {
      isBehind = true;
      continue;
    }
    for (const k of [0, 1]) {
      const at = row(k) / w;
      low[k] = Math.min(low[k] as number, at);
      high[k] = Math.max(high[k] as number, at);
    }
  }
  // A box around the eye covers nobody knows how much; all of one behind it, nothing.
  if (isBehind && !Number.isFinite(low[0])) return null;
  const size = [width, height];
  const edge = (k: number, at: number) => ((at + 1) / 2) * (size[k] as number);
  const [left, right, bottom, top] = isBehind
    ? [0, width, 0, height]
    : [edge(0, low[0] as number), edge(0, high[0] as number), edge(1, low[1] as number), edge(1, high[1] as number)];
  const from = [Math.max(0, Math.floor(left - margin)), Math.max(0, Math.floor(bottom - margin))] as const;
  const to = [Math.min(width, Math.ceil(right + margin)), Math.min(height, Math.ceil(top + margin))] as const;
  if (!(to[0] > from[0] && to[1] > from[1])) return null;
  return { left: from[0], bottom: from[1], width: to[0] - from[0], height: to[1] - from[1] };
}

// The corners of a unit cube and its faces, against the clock from outside.
const CUBE = [0, 0, 0, 1, 0, 0, 0, 1, 0, 1, 1, 0, 0, 0, 1, 1, 0, 1, 0, 1, 1, 1, 1, 1];
const FACES = [
  [0, 2, 3, 1],
  [4, 5, 7, 6],
  [0, 1, 5, 4],
  [2, 6, 7, 3],
  [0, 4, 6, 2],
  [1, 3, 7, 5],
] as const;

/** A pass over the pixels of a box in space, each once: by its far side, which is there from inside as well. */
export class BoxPass {
  readonly material: RawShaderMaterial;
  readonly #scene = new Scene();
  readonly #geometry = new BufferGeometry();
  readonly #mesh: Mesh;

  constructor(fragmentShader: string, uniforms: Record<string, IUniform>, parameters: ShaderMaterialParameters = {}) {
    this.material = new RawShaderMaterial({
      glslVersion: GLSL3,
      vertexShader: boxVertex,
      fragmentShader,
      uniforms,
      transparent: true,
      side: BackSide,
      ...parameters,
    });
    this.#geometry.setAttribute("position", new BufferAttribute(new Float32Array(CUBE), 3));
    this.#geometry.setIndex(FACES.flatMap(([a, b, c, d]) => [a, b, c, a, c, d]));
    this.#mesh = new Mesh(this.#geometry, this.material);
    this.#mesh.frustumCulled = false;
    this.#mesh.matrixAutoUpdate = false;
    this.#scene.add(this.#mesh);
  }

  /** Draws over `box`, which `matrix` takes to the scene, to the current target. */
  draw(renderer: WebGLRenderer, box: Box, matrix: Matrix4, eye: Eye): void {
    const size = subtract(box.upper, box.lower);
    this.#mesh.matrix
      .makeTranslation(...box.lower)
      .multiply(new Matrix4().makeScale(...size))
      .premultiply(matrix);
    this.#mesh.matrixWorldNeedsUpdate = true;
    renderer.render(this.#scene, eye);
  }

  dispose(): void {
    this.#geometry.dispose();
    this.material.dispose();
  }
}

/** The box grown by `by` on all sides; an empty one stays empty. */
export const grown = (box: Box, by: number): Box =>
  isEmpty(box)
    ? box
    : { lower: box.lower.map((value) => value - by) as Vec3, upper: box.upper.map((value) => value + by) as Vec3 };
