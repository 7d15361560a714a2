// The page of the browser tests: a stage alone, driven from outside.

import { Geometry } from "../../src/geometry";
import { NO_MARKS } from "../../src/scene/marks";
import { PartState, Stage } from "../../src/scene/stage";

const canvas = document.querySelector("canvas") as HTMLCanvasElement;
const labels = document.querySelector("#labels") as HTMLElement;
const stage = new Stage(canvas, { pixelRatio: 1, labels });
const geometry = new Geometry(`${location.origin}/`, "token of the test");

/** Draws frames, as fast as the device takes them, until `isEnough` or `most` frames. Returns how many were drawn. */
async function frames(isEnough: () => boolean, most = 3000): Promise<number> {
  for (let k = 0; k < most; k++) {
    stage.frame(await new Promise<number>(requestAnimationFrame));
    if (isEnough()) return k + 1;
  }
  throw new Error(`not there after ${most} frames: ${JSON.stringify(stage.stats)}`);
}

const whole = () => frames(() => stage.stats.isWhole);

/** The colours at pixels of the canvas, from its upper left corner. */
async function coloursAt(pixels: [number, number][]): Promise<number[][]> {
  await whole();
  // A canvas forgets what it showed: read in the turn in which it is drawn.
  stage.invalidate();
  stage.frame(performance.now());
  const gl = stage.renderer.getContext();
  return pixels.map(([x, y]) => {
    const pixel = new Uint8Array(4);
    gl.readPixels(x, canvas.height - 1 - y, 1, 1, gl.RGBA, gl.UNSIGNED_BYTE, pixel);
    return Array.from(pixel.subarray(0, 3));
  });
}

function load(): Promise<void> {
  return new Promise((resolve, reject) => {
    geometry.load({
      onManifest: (manifest) => stage.setManifest(manifest),
      onPiece: (k, data) => stage.addPiece(k, data),
      onDone: resolve,
      onFailed: (what) => reject(new Error(what)),
    });
  });
}

const harness = {
  stage,
  geometry,
  NO_MARKS,
  PartState,
  frames,
  coloursAt,
  load,
  settled: () => frames(() => stage.stats.isSettled),
  whole,
};

declare global {
  interface Window {
    harness: typeof harness;
  }
}
window.harness = harness;
