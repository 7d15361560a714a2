// The page of the browser tests: a stage alone, driven from outside.

import { metaQuest3, XRDevice } from "iwer";
import { Geometry } from "../../src/link/geometry";
import { NO_MARKS } from "../../src/scene/marks";
import { PartState, Stage } from "../../src/scene/stage";

const canvas = document.querySelector("canvas") as HTMLCanvasElement;
const labels = document.querySelector("#labels") as HTMLElement;
const geometry = new Geometry(`${location.origin}/`, "token of the test");
const stage = new Stage(canvas, { pixelRatio: 1, labels, fieldOf: (...mesh) => geometry.fieldOf(...mesh) });

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

/** The eyes' projections with a reversed depth, which three leaves to who opens the session. */
function reverseEyes(): void {
  if (!stage.renderer.capabilities.reversedDepthBuffer) return;
  const eyes = stage.renderer.xr.getCamera();
  Reflect.set(eyes, "_reversedDepth", true);
  for (const eye of eyes.cameras) {
    Reflect.set(eye, "_reversedDepth", true);
    const e = eye.projectionMatrix.elements;
    for (const z of [2, 6, 10, 14]) e[z] = ((e[z + 1] as number) - (e[z] as number)) / 2;
    eye.projectionMatrixInverse.copy(eye.projectionMatrix).invert();
  }
}

/** Enters an emulated headset at the world point `eye`, draws a frame, leaves: the colours of each eye's picture. */
async function inHeadset(eye: [number, number, number]): Promise<Set<string>[]> {
  const device = new XRDevice(metaQuest3);
  // Chromium has a navigator.xr of its own, without a headset.
  device.installRuntime({ forceInstall: true });
  device.stereoEnabled = true;
  device.position.set(0, 0, 0);
  const { renderer, rig } = stage;
  const session = await (navigator.xr as XRSystem).requestSession("immersive-vr", {
    requiredFeatures: ["local-floor"],
  });
  renderer.xr.enabled = true;
  renderer.xr.setReferenceSpaceType("local-floor");
  await renderer.xr.setSession(session);
  rig.position.set(...eye);
  rig.rotation.x = Math.PI / 2;
  const seen = await new Promise<Set<string>[]>((resolve) => {
    let count = 0;
    renderer.setAnimationLoop((now) => {
      reverseEyes();
      stage.frame(now);
      count++;
      if (count < 3) return;
      renderer.setAnimationLoop(null);
      const gl = renderer.getContext();
      const { drawingBufferWidth: width, drawingBufferHeight: height } = gl;
      const half = Math.floor(width / 2);
      const pixels = new Uint8Array(4 * half * height);
      resolve(
        [0, half].map((left) => {
          gl.readPixels(left, 0, half, height, gl.RGBA, gl.UNSIGNED_BYTE, pixels);
          const found = new Set<string>();
          for (let k = 0; k < pixels.length; k += 4) found.add(pixels.subarray(k, k + 3).join());
          return found;
        }),
      );
    });
  });
  await session.end();
  rig.position.set(0, 0, 0);
  rig.rotation.x = 0;
  renderer.xr.enabled = false;
  return seen;
}

const harness = {
  stage,
  geometry,
  NO_MARKS,
  PartState,
  frames,
  coloursAt,
  load,
  inHeadset,
  settled: () => frames(() => stage.stats.isSettled),
  whole,
};

declare global {
  interface Window {
    harness: typeof harness;
  }
}
window.harness = harness;
