// A picture of a fixed size: the content of a render target, as a PNG.

import type { WebGLRenderer, WebGLRenderTarget } from "three";

/** The pixels of `target` as a PNG; the first row of a target is the lowest, that of a picture the highest. */
export function pngOf(renderer: WebGLRenderer, target: WebGLRenderTarget): Promise<Blob> {
  const { width, height } = target;
  const gl = renderer.getContext() as WebGL2RenderingContext;
  const pixels = new Uint8ClampedArray(4 * width * height);
  renderer.setRenderTarget(target);
  gl.readPixels(0, 0, width, height, gl.RGBA, gl.UNSIGNED_BYTE, pixels);
  const canvas = document.createElement("canvas");
  canvas.width = width;
  canvas.height = height;
  const context = canvas.getContext("2d");
  if (!context) return Promise.reject(new Error("The browser gave no 2D canvas for the picture: close other pages."));
  const image = context.createImageData(width, height);
  for (let row = 0; row < height; row++) {
    image.data.set(pixels.subarray(4 * width * (height - 1 - row), 4 * width * (height - row)), 4 * width * row);
  }
  for (let at = 3; at < image.data.length; at += 4) image.data[at] = 255;
  context.putImageData(image, 0, 0);
  return new Promise((resolve, reject) => {
    canvas.toBlob((blob) => {
      if (blob) resolve(blob);
      else
        reject(
          new Error(`A picture of ${width} x ${height} pixels could not be written as PNG: ask for a smaller one.`),
        );
    }, "image/png");
  });
}
