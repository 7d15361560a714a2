// Picks at a pixel: the kept layer's id and distance, and the held mesh drawn into that one pixel.

import {
  DepthTexture,
  FloatType,
  NearestFilter,
  type RawShaderMaterial,
  RGBAIntegerFormat,
  type Scene,
  UnsignedIntType,
  type WebGLRenderer,
  WebGLRenderTarget,
} from "three";
import type { Eye } from "./eye";
import { define, ScreenPass } from "./screen";
import { probeFragment } from "./shaders";
import type { SharedUniforms } from "./uniforms";

export interface Probed {
  part: number;
  held: boolean;
  /** Along the view direction, metres. */
  depth: number;
}

export class Probe {
  readonly #renderer: WebGLRenderer;
  readonly #uniforms: SharedUniforms;
  readonly #pass: ScreenPass;
  readonly #target: WebGLRenderTarget;
  readonly #found = new Uint32Array(4);
  readonly #asFloat = new Float32Array(this.#found.buffer);

  constructor(renderer: WebGLRenderer, uniforms: SharedUniforms) {
    this.#renderer = renderer;
    this.#uniforms = uniforms;
    this.#pass = new ScreenPass(probeFragment, uniforms, { defines: { SECTIONS: 0 } });
    this.#target = new WebGLRenderTarget(1, 1, {
      format: RGBAIntegerFormat,
      type: UnsignedIntType,
      internalFormat: "RGBA32UI",
      minFilter: NearestFilter,
      magFilter: NearestFilter,
      generateMipmaps: false,
      depthTexture: new DepthTexture(1, 1, FloatType),
    });
  }

  setSections(count: number): void {
    define(this.#pass.material, "SECTIONS", count);
  }

  /** The pick at the pixel (`x`, `y`) of a picture of `width` x `height`, from its lower left corner; null for nothing. */
  at(
    x: number,
    y: number,
    width: number,
    height: number,
    eye: Eye,
    held: Scene | null,
    material: RawShaderMaterial,
  ): Probed | null {
    const renderer = this.#renderer;
    const gl = renderer.getContext() as WebGL2RenderingContext;
    this.#uniforms.fragmentOffset.value.set(x, y);
    this.#pass.draw(renderer, this.#target);
    if (held) {
      renderer.state.buffers.depth.setMask(true);
      gl.clearBufferfv(gl.DEPTH, 0, [renderer.capabilities.reversedDepthBuffer ? 0 : 1]);
      eye.setViewOffset(width, height, x, height - 1 - y, 1, 1);
      held.overrideMaterial = material;
      renderer.render(held, eye);
      held.overrideMaterial = null;
      eye.clearViewOffset();
    }
    gl.readPixels(0, 0, 1, 1, gl.RGBA_INTEGER, gl.UNSIGNED_INT, this.#found);
    this.#uniforms.fragmentOffset.value.set(0, 0);
    const id = this.#found[0] as number;
    if (id === 0) return null;
    return { part: id - 1, held: this.#found[2] === 1, depth: this.#asFloat[1] as number };
  }

  dispose(): void {
    this.#pass.dispose();
    this.#target.depthTexture?.dispose();
    this.#target.dispose();
  }
}
