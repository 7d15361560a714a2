// From the kept layer to a whole picture: highlights, and everything drawn over the mock-up.

import type { WebGLRenderer, WebGLRenderTarget } from "three";
import type { Average } from "./average";
import { copyPicture } from "./copy";
import type { Eye } from "./eye";
import { JITTER, type Kept } from "./kept";
import type { Over } from "./over";
import { define, ScreenPass } from "./screen";
import { tintFragment } from "./shaders";
import type { SharedUniforms } from "./uniforms";

export class Composer {
  /** The highlights must be tinted anew. */
  isLitNew = true;
  readonly #renderer: WebGLRenderer;
  readonly #eye: Eye;
  readonly #over: Over;
  readonly #tint: ScreenPass;

  constructor(renderer: WebGLRenderer, uniforms: SharedUniforms, eye: Eye, over: Over) {
    this.#renderer = renderer;
    this.#eye = eye;
    this.#over = over;
    const { keptScale, keptId, states, others, resolution, pixelRatio } = uniforms;
    this.#tint = new ScreenPass(tintFragment, {
      kept: { value: null },
      ...{ keptScale, keptId, states, others, resolution, pixelRatio },
    });
  }

  /** Draws the picture into `target`, null: the canvas. `lit`: room for the kept picture with its lit parts, if there are any. */
  compose(kept: Kept, lit: WebGLRenderTarget, isAnyLit: boolean, target: WebGLRenderTarget | null): void {
    const renderer = this.#renderer;
    const { width, height } = target ?? renderer.domElement;
    kept.bind(width);
    if (isAnyLit && this.isLitNew) {
      define(this.#tint.material, "SCALED", kept.scale === 1 ? null : 1);
      (this.#tint.material.uniforms.kept as { value: unknown }).value = kept.picture.texture;
      this.#tint.draw(renderer, lit);
    }
    this.isLitNew = false;
    this.#over.prepare(renderer, this.#eye, width, height);
    // First the clear: a browser that has shown the canvas clears its colour as well, at the first clear or draw after.
    renderer.setRenderTarget(target);
    renderer.clear(false, true, false);
    copyPicture(renderer, isAnyLit ? lit : kept.picture, target, width, height);
    this.#over.draw(renderer, this.#eye);
  }

  /** Adds a picture drawn a part of a pixel aside: the shapes over the kept layer get smooth edges as well. */
  addSample(kept: Kept, lit: WebGLRenderTarget, isAnyLit: boolean, average: Average): void {
    const [x, y] = JITTER[average.samples] as [number, number];
    const { width, height } = average.sum;
    this.#eye.setViewOffset(width, height, x, y, width, height);
    this.compose(kept, lit, isAnyLit, average.once);
    this.#eye.clearViewOffset();
    average.add();
  }

  dispose(): void {
    this.#tint.dispose();
  }
}
