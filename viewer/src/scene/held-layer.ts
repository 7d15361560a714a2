// The held mesh over the kept picture: drawn aside, then put over it with an outline and its creases, and where the
// mock-up hides it, faintly. Only the pixels of its box are drawn.

import {
  AlwaysDepth,
  DepthFormat,
  DepthTexture,
  FloatType,
  NearestFilter,
  NormalBlending,
  type Texture,
  Vector3,
  type WebGLRenderer,
  WebGLRenderTarget,
} from "three";
import { centre, diagonal, type Vec3 } from "../math/vectors";
import type { Eye } from "./eye";
import type { Held } from "./held";
import { BoxPass, grown, rectOf } from "./rect";
import { define } from "./screen";
import { heldOverFragment } from "./shaders";
import type { SharedUniforms } from "./uniforms";

// Device pixels around the mesh: of the layer, and of the pass that outlines it.
const BORDER = 6;
const OUTLINE_PIXELS = 3;

function layerTarget(width: number, height: number): WebGLRenderTarget {
  const depthTexture = new DepthTexture(width, height, FloatType);
  depthTexture.format = DepthFormat;
  depthTexture.minFilter = depthTexture.magFilter = NearestFilter;
  return new WebGLRenderTarget(width, height, {
    minFilter: NearestFilter,
    magFilter: NearestFilter,
    generateMipmaps: false,
    depthTexture,
  });
}

export class HeldLayer {
  readonly #uniforms: SharedUniforms;
  readonly #pass: BoxPass;
  #isSeen = false;
  #target: WebGLRenderTarget | null = null;

  constructor(uniforms: SharedUniforms) {
    this.#uniforms = uniforms;
    this.#pass = new BoxPass(
      heldOverFragment,
      { ...uniforms, heldColour: { value: null as Texture | null }, heldDepth: { value: null as Texture | null } },
      { defines: { SECTIONS: 0 }, depthFunc: AlwaysDepth, blending: NormalBlending },
    );
  }

  setSections(count: number): void {
    define(this.#pass.material, "SECTIONS", count);
  }

  /** Draws `held` aside for a picture of that size. Before the picture: a device that changes targets in between waits. */
  prepare(renderer: WebGLRenderer, held: Held, eye: Eye, middle: Vec3, width: number, height: number): void {
    const rect = rectOf(held.box(), middle, eye, width, height, BORDER);
    this.#isSeen = rect !== null;
    if (!rect) return;
    const layer = this.#room(width, height);
    // With a border: the outline looks at the pixels around, and those of the last frame are still there.
    layer.scissorTest = true;
    layer.scissor.set(rect.left, rect.bottom, rect.width, rect.height);
    renderer.setRenderTarget(layer);
    const gl = renderer.getContext() as WebGL2RenderingContext;
    renderer.state.buffers.color.setMask(true);
    renderer.state.buffers.depth.setMask(true);
    gl.clearBufferfv(gl.COLOR, 0, [0, 0, 0, 0]);
    gl.clearBufferfv(gl.DEPTH, 0, [renderer.capabilities.reversedDepthBuffer ? 0 : 1]);
    const { hasKept } = this.#uniforms;
    const was = hasKept.value;
    hasKept.value = false;
    renderer.render(held.scene, eye);
    hasKept.value = was;
  }

  /** Puts it over the current target. */
  draw(renderer: WebGLRenderer, held: Held, eye: Eye): void {
    const layer = this.#target;
    if (!this.#isSeen || !layer) return;
    const { heldColour, heldDepth } = this.#pass.material.uniforms as Record<string, { value: Texture | null }>;
    if (heldColour) heldColour.value = layer.texture;
    if (heldDepth) heldDepth.value = layer.depthTexture;
    const { parallel, rayOf } = this.#uniforms;
    const box = held.pieceBox();
    const place = new Vector3(...centre(box)).applyMatrix4(held.matrix).applyMatrix4(eye.matrixWorldInverse);
    const far = Math.max(-place.z, 0) + diagonal(box) / 2;
    const pixel = rayOf.value.x * (parallel.value > 0 ? 1 : far);
    this.#pass.draw(renderer, grown(box, OUTLINE_PIXELS * pixel), held.matrix, eye);
  }

  dispose(): void {
    this.#target?.depthTexture?.dispose();
    this.#target?.dispose();
    this.#pass.dispose();
  }

  #room(width: number, height: number): WebGLRenderTarget {
    const known = this.#target;
    if (known && known.width === width && known.height === height) return known;
    known?.depthTexture?.dispose();
    known?.dispose();
    this.#target = layerTarget(width, height);
    return this.#target;
  }
}
