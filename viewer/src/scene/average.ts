// Averages pictures drawn a fraction of a pixel apart, which smooths edges.

import {
  DepthTexture,
  NearestFilter,
  NormalBlending,
  type Texture,
  UnsignedIntType,
  type WebGLRenderer,
  WebGLRenderTarget,
} from "three";
import { ScreenPass } from "./screen";
import { averageFragment } from "./shaders";

export class Average {
  samples = 0;
  /** Where the next picture is drawn; it has a depth buffer. */
  once: WebGLRenderTarget;
  sum: WebGLRenderTarget;
  readonly #renderer: WebGLRenderer;
  readonly #pass = new ScreenPass(
    averageFragment,
    { picture: { value: null as Texture | null }, share: { value: 1 } },
    { transparent: true, blending: NormalBlending },
  );

  constructor(renderer: WebGLRenderer) {
    this.#renderer = renderer;
    this.once = colourTarget(1, 1, true);
    this.sum = colourTarget(1, 1, false);
  }

  setSize(width: number, height: number): void {
    if (width === this.sum.width && height === this.sum.height) return;
    this.#disposeTargets();
    this.once = colourTarget(width, height, true);
    this.sum = colourTarget(width, height, false);
    this.samples = 0;
  }

  /** Adds the content of `once`. */
  add(): void {
    this.samples++;
    const uniforms = this.#pass.material.uniforms as { picture: { value: Texture | null }; share: { value: number } };
    uniforms.picture.value = this.once.texture;
    uniforms.share.value = 1 / this.samples;
    this.#pass.draw(this.#renderer, this.sum);
  }

  /** Draws the mean to `target`, as large as the pictures. */
  show(target: WebGLRenderTarget | null): void {
    const uniforms = this.#pass.material.uniforms as { picture: { value: Texture | null }; share: { value: number } };
    uniforms.picture.value = this.sum.texture;
    uniforms.share.value = 1;
    this.#pass.draw(this.#renderer, target);
  }

  dispose(): void {
    this.#disposeTargets();
    this.#pass.dispose();
  }

  #disposeTargets(): void {
    this.once.depthTexture?.dispose();
    this.once.dispose();
    this.sum.dispose();
  }
}

function colourTarget(width: number, height: number, hasDepth: boolean): WebGLRenderTarget {
  return new WebGLRenderTarget(width, height, {
    minFilter: NearestFilter,
    magFilter: NearestFilter,
    generateMipmaps: false,
    depthBuffer: hasDepth,
    depthTexture: hasDepth ? new DepthTexture(width, height, UnsignedIntType) : null,
  });
}
