// Copies a picture: with a software renderer ten times cheaper than a pass over its pixels.

import type { WebGLRenderer, WebGLRenderTarget } from "three";

/**
 * Copies the viewport of `from` to all of `to` (null: the canvas), `width` x `height` pixels. Leaves `to` the current target.
 */
export function copyPicture(
  renderer: WebGLRenderer,
  from: WebGLRenderTarget,
  to: WebGLRenderTarget | null,
  width: number,
  height: number,
): void {
  const gl = renderer.getContext() as WebGL2RenderingContext;
  const { z: across, w: up } = from.viewport;
  const bound = () => gl.getParameter(gl.DRAW_FRAMEBUFFER_BINDING) as WebGLFramebuffer | null;
  renderer.setRenderTarget(from);
  const source = bound();
  renderer.setRenderTarget(to);
  gl.bindFramebuffer(gl.READ_FRAMEBUFFER, source);
  const filter = across === width && up === height ? gl.NEAREST : gl.LINEAR;
  gl.blitFramebuffer(0, 0, across, up, 0, 0, width, height, gl.COLOR_BUFFER_BIT, filter);
  // Three assumes that the render target is also read from.
  gl.bindFramebuffer(gl.READ_FRAMEBUFFER, bound());
}
