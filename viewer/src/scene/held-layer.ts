// The held mesh over the kept picture: drawn aside, then put over it with an outline and its creases, and where the
// mock-up hides it, faintly. Only the rectangle that it covers is drawn.

import {
  AlwaysDepth,
  DepthFormat,
  DepthTexture,
  FloatType,
  NearestFilter,
  NormalBlending,
  type Texture,
  type WebGLRenderer,
  WebGLRenderTarget,
} from "three";
import type { Eye } from "./eye";
import type { Held } from "./held";
import { type Rect, RectPass } from "./rect";
import { define } from "./screen";
import { heldOverFragment } from "./shaders";
import type { SharedUniforms } from "./uniforms";

const BORDER = 4;

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
  readonly #pass: RectPass;
  #target: WebGLRenderTarget | null = null;

  constructor(uniforms: SharedUniforms) {
    this.#uniforms = uniforms;
    this.#pass = new RectPass(
      heldOverFragment,
      { ...uniforms, heldColour: { value: null as Texture | null }, heldDepth: { value: null as Texture | null } },
      { defines: { SECTIONS: 0 }, depthFunc: AlwaysDepth, blending: NormalBlending },
    );
  }

  setSections(count: number): void {
    define(this.#pass.material, "SECTIONS", count);
  }

  /** Draws `held`, which covers `rect` at most, to the current target. */
  draw(renderer: WebGLRenderer, held: Held, eye: Eye, rect: Rect): void {
    const target = renderer.getRenderTarget();
    const { width, height } = target ?? renderer.domElement;
    const layer = this.#room(width, height);
    // With a border: the outline looks at the pixels around, and those of the last frame are still there.
    layer.scissorTest = true;
    layer.scissor.set(rect.left - BORDER, rect.bottom - BORDER, rect.width + 2 * BORDER, rect.height + 2 * BORDER);
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
    renderer.setRenderTarget(target);
    const { heldColour, heldDepth } = this.#pass.material.uniforms as Record<string, { value: Texture | null }>;
    if (heldColour) heldColour.value = layer.texture;
    if (heldDepth) heldDepth.value = layer.depthTexture;
    this.#pass.draw(renderer, rect, width, height);
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
