// Passes over a rectangle of the picture: what only concerns the surroundings of the hand costs no more than that.

import {
  BufferAttribute,
  BufferGeometry,
  GLSL3,
  type IUniform,
  Mesh,
  OrthographicCamera,
  RawShaderMaterial,
  Scene,
  type ShaderMaterialParameters,
  Vector4,
  type WebGLRenderer,
} from "three";
import { type Box, corners, isEmpty, subtract, type Vec3 } from "../math/vectors";
import type { Eye } from "./eye";
import { rectVertex } from "./shaders";

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

export class RectPass {
  readonly material: RawShaderMaterial;
  readonly #rect = { value: new Vector4() };
  readonly #scene = new Scene();
  readonly #geometry = new BufferGeometry();
  readonly #camera = new OrthographicCamera();

  constructor(fragmentShader: string, uniforms: Record<string, IUniform>, parameters: ShaderMaterialParameters = {}) {
    this.material = new RawShaderMaterial({
      glslVersion: GLSL3,
      vertexShader: rectVertex,
      fragmentShader,
      uniforms: { ...uniforms, rect: this.#rect },
      transparent: true,
      ...parameters,
    });
    this.#geometry.setAttribute(
      "position",
      new BufferAttribute(new Float32Array([0, 0, 0, 1, 0, 0, 0, 1, 0, 1, 1, 0]), 3),
    );
    this.#geometry.setIndex([0, 1, 2, 2, 1, 3]);
    const mesh = new Mesh(this.#geometry, this.material);
    mesh.frustumCulled = false;
    this.#scene.add(mesh);
  }

  /** Draws over `rect` of the current target, `width` x `height` pixels. */
  draw(renderer: WebGLRenderer, rect: Rect, width: number, height: number): void {
    const x = (at: number) => (2 * at) / width - 1;
    const y = (at: number) => (2 * at) / height - 1;
    this.#rect.value.set(x(rect.left), y(rect.bottom), x(rect.left + rect.width), y(rect.bottom + rect.height));
    renderer.render(this.#scene, this.#camera);
  }

  dispose(): void {
    this.#geometry.dispose();
    this.material.dispose();
  }
}
