// The stage: all GL of the page behind one class.

import { Group, PerspectiveCamera, WebGLRenderer } from "three";
import type { HeldManifest, Manifest } from "../geometry";
import { CameraRig } from "./camera";
import type { Marks } from "./marks";
import { type Box, emptyBox, type Vec3 } from "./vectors";

/** The bits of a part's state. */
export const PartState = { hidden: 1, ghost: 2, near: 4, hit: 8, selected: 16, away: 32 } as const;

export type Theme = "dark" | "light";

export interface StageOptions {
  /** Device pixels a CSS pixel, at most. */
  pixelRatio?: number;
  /** Where the figures of the marks are put, over the canvas and as large; none without. */
  labels?: HTMLElement;
}

/** A plane of a section: kept where normal . x >= offset. */
export interface SectionPlane {
  normal: Vec3;
  offset: number;
}

export interface FrameStats {
  /** Whether anything was drawn. */
  drawn: boolean;
  /** Milliseconds the page spent on the frame; the device's own are not in it. */
  ms: number;
  calls: number;
  triangles: number;
  /** Whether the mock-up came from the kept layer. */
  isKept: boolean;
  /** Whether every piece that can be seen is in the picture, at its full resolution. */
  isWhole: boolean;
}

/** What is under a pixel: a part of the mock-up, or of the held mesh. */
export interface Pick {
  part: number;
  point: Vec3;
  held: boolean;
}

export class Stage {
  readonly camera = new CameraRig();
  /** For WebXR: the session goes here, and `eye` is its camera, in `rig`. */
  readonly renderer: WebGLRenderer;
  readonly eye = new PerspectiveCamera();
  readonly rig = new Group();
  /** What other modules draw over the picture (the gizmo): children in world coordinates. */
  readonly overlay = new Group();
  stats: FrameStats = { drawn: false, ms: 0, calls: 0, triangles: 0, isKept: false, isWhole: false };

  constructor(
    readonly canvas: HTMLCanvasElement,
    readonly options: StageOptions = {},
  ) {
    this.renderer = new WebGLRenderer({ canvas, reversedDepthBuffer: true });
  }

  setManifest(_manifest: Manifest): void {}
  addPiece(_k: number, _data: ArrayBuffer): void {}
  clear(): void {}
  setHeld(_held: { piece: ArrayBuffer; manifest: HeldManifest } | null): void {}
  setPartStates(_states: Uint8Array): void {}
  setMoved(_moved: Map<number, number[]>): void {}
  setExplode(_share: number): void {}
  setSections(_sections: SectionPlane[]): void {}
  setOutlines(_segments: Float32Array | null): void {}
  setPose(_pose: ArrayLike<number>, _wish: ArrayLike<number> | null): void {}
  setHits(_mockup: Uint32Array, _held: Uint32Array): void {}
  setMarks(_marks: Marks): void {}
  setTheme(_theme: Theme): void {}

  /** The box of what can be seen, sections and hidden parts obeyed: for `camera.fit` and `camera.view`. */
  visibleBox(): Box {
    return emptyBox();
  }

  pick(_x: number, _y: number): Pick | null {
    return null;
  }

  /** Asks for a redraw: what `overlay` holds has changed. */
  invalidate(): void {}

  frame(_now: number): FrameStats {
    return this.stats;
  }

  shot(_width: number, _height: number): Promise<Blob> {
    return Promise.reject(new Error("nothing is drawn yet"));
  }

  onRestored(_f: () => void): void {}

  dispose(): void {
    this.renderer.dispose();
  }
}
