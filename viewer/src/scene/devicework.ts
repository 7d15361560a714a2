// The device's workload: a fence after the last draw of pieces shows when it is done, and so its duration.

import type { WebGLRenderer } from "three";

export class DeviceWork {
  readonly #renderer: WebGLRenderer;
  #running: { fence: WebGLSync; at: number; triangles: number; isDraft: boolean } | null = null;

  constructor(renderer: WebGLRenderer) {
    this.#renderer = renderer;
  }

  get isRunning(): boolean {
    return this.#running !== null;
  }

  /** Puts a fence after the work sent to the device since `at` (ms): `triangles`, while the camera moves or not. */
  begin(at: number, triangles: number, isDraft: boolean): void {
    const gl = this.#renderer.getContext() as WebGL2RenderingContext;
    if (this.#running) gl.deleteSync(this.#running.fence);
    const fence = gl.fenceSync(gl.SYNC_GPU_COMMANDS_COMPLETE, 0);
    gl.flush();
    this.#running = fence ? { fence, at, triangles, isDraft } : null;
  }

  /** The work just done, and its greatest duration in ms; null while it is running, or if nothing was begun. */
  poll(): { triangles: number; ms: number; isDraft: boolean } | null {
    if (!this.#running) return null;
    const { fence, at, triangles, isDraft } = this.#running;
    const gl = this.#renderer.getContext() as WebGL2RenderingContext;
    if (gl.getSyncParameter(fence, gl.SYNC_STATUS) !== gl.SIGNALED) return null;
    gl.deleteSync(fence);
    this.#running = null;
    return { triangles, ms: performance.now() - at, isDraft };
  }

  /** Forgets running work: its context is lost. */
  forget(): void {
    this.#running = null;
  }
}
