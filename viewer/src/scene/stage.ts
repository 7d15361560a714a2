// The stage: all GL of the page behind one class.
//
// A frame redraws the mock-up only when the camera, a part or a section changed; else it shows the kept layer and draws
// moving objects over it. While nothing changes, the edges are smoothed, a little each frame.

import { Group, type RawShaderMaterial, Scene, WebGLRenderer } from "three";
import type { HeldManifest, Manifest } from "../link/protocol";
import { boxPlanes } from "../math/box-faces";
import type { FieldMesh, HeatField } from "../math/heat-field";
import { IDENTITY } from "../math/matrix";
import { isSame } from "../math/same";
import { add, type Box, diagonal, dot, isEmpty, scale, union, type Vec3 } from "../math/vectors";
import { aim } from "./aim";
import { Average } from "./average";
import { CameraRig } from "./camera";
import type { Piece } from "./chunks";
import { Composer } from "./composer";
import { DeviceWork } from "./devicework";
import { Eye } from "./eye";
import { JITTER, Kept, PieceMaterials, shownTarget } from "./kept";
import { NOTHING_TAKEN, type Taken } from "./labels";
import type { Marks } from "./marks";
import { Model } from "./model";
import { Over } from "./over";
import { Pace, STILL_MS } from "./pace";
import { Probe } from "./pick";
import { ScreenPass } from "./screen";
import { type SectionPlane, writePlanes } from "./sections";
import { backFragment } from "./shaders";
import { pngOf } from "./shot";
import { channels, coloursOf, ghostOf, type Theme } from "./theme";
import { CUT_SLACK, MAX_SECTIONS, sharedUniforms } from "./uniforms";
import { warmUp } from "./warmup";

export { PartState } from "./parts";
export type { SectionPlane } from "./sections";
export type { Theme } from "./theme";

export interface StageOptions {
  /** Device pixels a CSS pixel, at most. */
  pixelRatio?: number;
  /** Where the figures of the marks are put, over the canvas and as large; none without. */
  labels?: HTMLElement;
  /** Makes the field of a held mesh for the heat map; there is none without. */
  fieldOf?: (pieces: readonly FieldMesh[], lower: Vec3, upper: Vec3) => Promise<HeatField>;
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
  /** Whether every piece that came and can be seen is in the picture, at its full resolution. */
  isWhole: boolean;
  /** Whether the picture is final: whole, its edges smooth, nothing left to do. */
  isSettled: boolean;
  /** Whether the device has drawn all that `isWhole` speaks of. */
  isShown: boolean;
  /** Whether the device has drawn some of this mock-up. */
  isPictured: boolean;
}

/** The pick under a pixel: a part of the mock-up, or of the held mesh. */
export interface Pick {
  part: number;
  point: Vec3;
  held: boolean;
}

// Above this many pixels the picture is drawn coarser: the targets of a 4K screen would take 300 MB.
const MOST_PIXELS = 2560 * 1440;
// Time without changes before edges are smoothed, and the time per frame for that or for late pieces.
const IDLE_MS = 300;
const REFINE_MS = 12;
const SLICE_MS = 120;
// Where a redraw takes longer than this, edges are smoothed by half as many.
const SLOW_REDRAW_MS = 250;
// A picture for keeping is averaged from fewer redraws where they would take longer than this.
const SHOT_MS = 2000;

export class Stage {
  readonly camera = new CameraRig();
  /** For WebXR: the session goes here, and `eye` is its camera, in `rig`, which stands in world coordinates less the middle. */
  readonly renderer: WebGLRenderer;
  readonly eye = new Eye();
  readonly rig = new Group();
  /** Shapes that other modules draw over the picture (the gizmo): children in world coordinates. */
  readonly overlay = new Group();
  stats: FrameStats = {
    drawn: false,
    ms: 0,
    calls: 0,
    triangles: 0,
    isKept: false,
    isWhole: false,
    isSettled: false,
    isShown: false,
    isPictured: false,
  };

  /** Called when a frame is due that nobody asked for. */
  onStale: (() => void) | null = null;
  /** What the figures keep clear of. */
  taken: () => Taken = () => NOTHING_TAKEN;

  readonly #uniforms = sharedUniforms();
  readonly #materials: PieceMaterials;
  readonly #kept: Kept;
  readonly #average: Average;
  // The kept picture with its lit parts.
  readonly #lit = shownTarget(1, 1);
  readonly #probe: Probe;
  readonly #model: Model;
  readonly #over: Over;
  readonly #composer: Composer;
  readonly #back: ScreenPass;
  readonly #pieceScene = new Scene();
  readonly #pace = new Pace();
  readonly #work: DeviceWork;
  readonly #restored: (() => void)[] = [];
  readonly #resizes: ResizeObserver;

  #held: object | null = null;
  #theme: Theme = "dark";
  #isLost = false;
  #isPictured = false;
  #isShown = false;
  #isFieldDue = false;
  #isSizeNew = true;
  #isViewNew = true;
  #isShapeNew = true;
  #isOverlayNew = true;
  #movedAt = -Infinity;
  #changedAt = -Infinity;

  constructor(
    readonly canvas: HTMLCanvasElement,
    readonly options: StageOptions = {},
  ) {
    this.renderer = new WebGLRenderer({
      canvas,
      alpha: false,
      antialias: false,
      stencil: false,
      powerPreference: "high-performance",
      reversedDepthBuffer: true,
    });
    this.renderer.autoClear = false;
    this.renderer.sortObjects = false;
    this.renderer.info.autoReset = false;
    this.#materials = new PieceMaterials(this.#uniforms);
    this.#kept = new Kept(this.renderer, this.#uniforms, this.#materials);
    this.#average = new Average(this.renderer);
    this.#work = new DeviceWork(this.renderer);
    this.#probe = new Probe(this.renderer, this.#uniforms);
    this.#model = new Model(this.#uniforms);
    this.#over = new Over(this.#uniforms, this.overlay, options.labels ?? null);
    this.#composer = new Composer(this.renderer, this.#uniforms, this.eye, this.#over);
    const { above, below } = coloursOf("dark");
    const [high, low] = [above.clone(), below.clone()];
    this.#back = new ScreenPass(backFragment, {
      drawn: this.#uniforms.resolution,
      above: { value: high },
      below: { value: low },
    });
    this.rig.add(this.eye);
    this.#pieceScene.matrixWorldAutoUpdate = false;
    this.#colour();
    // Three tells a camera of the reversed depth when it first draws something with it: too late for the first aim.
    this.#back.draw(this.renderer, null, this.eye);
    warmUp(this.#kept, this.#materials, this.#uniforms, this.eye);
    this.#resizes = new ResizeObserver(() => {
      this.#isSizeNew = true;
    });
    this.#resizes.observe(canvas);
    canvas.addEventListener("webglcontextlost", this.#onLost);
    canvas.addEventListener("webglcontextrestored", this.#onRestored);
  }

  /** Begins a mock-up; its pieces follow by `addPiece`. The camera looks at all of it, unless it is the one shown before. */
  setManifest(manifest: Manifest): void {
    const isAnother = this.#model.hash !== manifest.hash;
    this.clear();
    this.#model.begin(manifest, this.#materials.solid);
    this.#over.setOrigin(this.#model);
    this.#cut();
    if (isAnother) this.camera.view(7, this.#model.bounds, manifest.up);
    this.#touch();
  }

  /** Takes piece `k` of the manifest; the buffer stays the stage's. Throws RangeError for one that does not fit. */
  addPiece(k: number, data: ArrayBuffer): void {
    const piece = this.#model.add(k, data);
    if (!this.#isShapeNew && !this.#isViewNew && this.#model.isSeen(piece, this.eye)) {
      if (this.#model.hasGhost(piece) || !this.#kept.append(piece)) this.#isShapeNew = true;
    }
    this.#placeHits();
  }

  /** Removes the mock-up. The held mesh stays. */
  clear(): void {
    this.#model.clear();
    this.#kept.forget();
    this.#work.forget();
    this.#isPictured = false;
    this.#isShapeNew = true;
    this.#over.setHits({ mockup: new Uint32Array(0) }, this.#model);
    this.#touch();
  }

  /** The held mesh: its pieces one after the other in `piece`; null for an empty hand. */
  setHeld(held: { piece: ArrayBuffer; manifest: HeldManifest } | null): void {
    this.#held = held;
    this.#over.held.set(held);
    this.#over.heat.setField(null);
    this.#isFieldDue = held !== null;
    this.#over.setHits({ held: new Uint32Array(0) }, this.#model);
    this.#touch();
  }

  /** A swept volume in the world's frame, drawn as a ghost; null: none. */
  setRoom(room: { piece: ArrayBuffer; manifest: HeldManifest } | null): void {
    if (!room && this.#over.room.isEmpty) return;
    this.#over.room.set(room);
    this.#over.room.setPose([...IDENTITY], [...IDENTITY]);
    this.#touch();
  }

  /** A byte a part, of the bits of `PartState`. Lighting parts redraws nothing; hiding them redraws the mock-up. */
  setPartStates(states: Uint8Array): void {
    if (!this.#model.table?.setStates(states)) return;
    this.#composer.isLitNew = true;
    this.#followTable();
  }

  /** The colours (0xRRGGBB) of other people, in the order of their bits in the parts' states. */
  setOthers(colours: readonly number[]): void {
    this.#uniforms.others.value.forEach((each, k) => {
      each.set(...channels(colours[k] ?? 0));
    });
    this.#composer.isLitNew = true;
    this.#touch();
  }

  /** world_from_part, row by row, of every part that is not where it was loaded. */
  setMoved(moved: Map<number, number[]>): void {
    if (this.#model.table?.setMoved(moved)) this.#followTable();
  }

  /** Draws some parts in other colours, 0xRRGGBB, and all others in their own. */
  setTints(tints: ReadonlyMap<number, number>): void {
    if (this.#model.table?.setTints(tints)) this.#followTable();
  }

  /** Moves the parts apart, by `share` from 0 to 1. */
  setExplode(share: number): void {
    if (!this.#model.table?.setExplode(share)) return;
    this.#followTable();
    this.#stir();
  }

  /** The planes that cut the mock-up: at most six, the others cut nothing. And the section box, if there is one. */
  setSections(cuts: SectionPlane[], box: Box | null = null): void {
    const faces = box ? boxPlanes(box) : [];
    const next = [...cuts.slice(0, MAX_SECTIONS - faces.length), ...faces];
    if (isSame(next, this.#model.sections)) return;
    this.#model.sections = structuredClone(next);
    this.#model.section_box = structuredClone(box);
    this.#cut();
    this.#stir();
  }

  /** The engine's exact outlines of the sections: (k, 2, 3) world metres, null for none. */
  setOutlines(segments: Float32Array | null): void {
    this.#over.setOutlines(segments);
    this.#touch();
  }

  /** world_from_tool, row by row: where the engine has it (solid), and where the hand wishes it (ghost; null: nowhere else). */
  setPose(pose: ArrayLike<number>, wish: ArrayLike<number> | null): void {
    if (this.#over.held.setPose(pose, wish)) this.#touch();
  }

  /** Packed triangles that meet: of the mock-up, and of the held mesh. */
  setHits(mockup: Uint32Array, held: Uint32Array): void {
    if (this.#over.setHits({ mockup, held }, this.#model)) this.#touch();
  }

  setMarks(marks: Marks): void {
    if (this.#over.setMarks(marks)) this.#touch();
  }

  setTheme(theme: Theme): void {
    if (theme === this.#theme) return;
    this.#theme = theme;
    this.#colour();
  }

  /** The box of all visible geometry with the held mesh, without hidden and cut-away parts. World metres. */
  visibleBox(): Box {
    return union(this.#model.visibleBox(), this.#over.held.box());
  }

  /** The box of the held mesh, world metres; empty for an empty hand. */
  heldBox(): Box {
    return this.#over.held.box();
  }

  /** The corners of the held mesh's box at a pose, world metres; none for an empty hand. */
  heldCorners(pose: ArrayLike<number>): Vec3[] {
    return this.#over.held.boxCorners(pose);
  }

  /** The box of `part` at its present place, world metres; empty for an unknown part. */
  partBox(part: number): Box {
    return this.#model.partBox(part);
  }

  /** The pick at (`x`, `y`), CSS pixels from the canvas' upper left corner: never hidden or cut-away geometry. */
  pick(x: number, y: number): Pick | null {
    if (this.#isLost) return null;
    this.#resize();
    if (this.camera.moved || this.#isViewNew || this.#isShapeNew) {
      this.#takeCamera(performance.now());
      this.#redraw(this.#isMoving(performance.now()));
    }
    const { width, height } = this.#kept;
    const ratio = width / this.camera.width;
    const [column, row] = [Math.floor(x * ratio), height - 1 - Math.floor(y * ratio)];
    if (column < 0 || row < 0 || column >= width || row >= height) return null;
    this.#kept.bind(width);
    const { held } = this.#over;
    const scene = held.isEmpty ? null : held.scene;
    const found = this.#probe.at(column, row, width, height, this.eye, scene, held.probeMaterial);
    if (!found) return null;
    const ray = this.camera.ray((column + 0.5) / ratio, (height - row - 0.5) / ratio);
    const point = add(ray.origin, scale(ray.direction, found.depth / dot(ray.direction, this.camera.forward)));
    return { part: found.part, point, held: found.held };
  }

  /** Asks for a new frame: what `overlay` holds has changed. */
  invalidate(): void {
    this.#touch();
  }

  /** Draws changes; call it once per animation frame, with its `now` in ms. */
  frame(now: number): FrameStats {
    const start = performance.now();
    const stats: FrameStats = { ...this.stats, drawn: false, isKept: true, ms: 0, calls: 0, triangles: 0 };
    this.stats = stats;
    if (this.#isLost) return stats;
    this.renderer.info.reset();
    let isGliding = false;
    if (this.renderer.xr.isPresenting) {
      this.#drawDirect();
      // Once the headset is left, its camera is not the page's.
      this.camera.moved = true;
      stats.drawn = true;
      stats.isKept = false;
    } else {
      this.#resize();
      isGliding = this.camera.step(now);
      this.#takeCamera(now);
      const done = this.#work.poll();
      if (done) {
        this.#pace.add(done.triangles, done.ms, done.isDraft);
        this.#isPictured ||= done.triangles > 0;
        this.#isShown = this.#kept.isWhole;
      }
      this.#step(now, stats);
    }
    stats.isWhole = this.#kept.isWhole && this.#kept.scale === 1 && !this.#isViewNew && !this.#isShapeNew && !isGliding;
    stats.isShown = stats.isWhole && this.#isShown;
    stats.isPictured = this.#isPictured;
    if (this.#isFieldDue && stats.isShown) this.#makeField();
    stats.isSettled = stats.isWhole && this.#kept.isRefined && this.#average.samples === JITTER.length;
    const { calls, triangles } = this.renderer.info.render;
    Object.assign(stats, { calls, triangles, ms: performance.now() - start });
    return stats;
  }

  /** The picture as the camera has it at `width` x `height` pixels, as a PNG; without figures and gizmo. */
  async shot(width: number, height: number): Promise<Blob> {
    if (this.#isLost) throw new Error("The graphics context is lost: ask again once it is back.");
    this.camera.finish();
    this.#resize();
    const kept = new Kept(this.renderer, this.#uniforms, this.#materials);
    const average = new Average(this.renderer);
    const lit = shownTarget(width, height);
    const isOverlay = this.overlay.visible;
    try {
      this.overlay.visible = false;
      kept.setSize(width, height);
      kept.setColours(coloursOf(this.#theme));
      average.setSize(width, height);
      this.#aim(width, height, height / this.camera.height);
      const { solid, ghosts } = this.#model.pieces(this.eye);
      kept.begin(solid, ghosts, 1);
      kept.draw(this.eye, Infinity);
      const samples = Math.floor(SHOT_MS / Math.max(this.#pace.estimate(kept.triangles), 1));
      while (kept.samples < Math.max(1, Math.min(JITTER.length, samples))) kept.refine(this.eye, Infinity);
      this.#over.build(this.camera);
      this.#composer.isLitNew = true;
      while (average.samples < JITTER.length) this.#composer.addSample(kept, lit, this.#isAnyLit, average);
      // The pixels are read before the first wait: no frame of the page comes between.
      return pngOf(this.renderer, average.sum);
    } finally {
      kept.dispose();
      average.dispose();
      lit.dispose();
      this.#composer.isLitNew = true;
      this.overlay.visible = isOverlay;
      this.renderer.setRenderTarget(null);
      this.#aimAtCanvas();
      this.#touch();
    }
  }

  /** The surfaces near the held mesh get colours of their distance to it. */
  setHeat(isOn: boolean): void {
    if (isOn === this.#over.heat.isOn) return;
    this.#over.heat.isOn = isOn;
    this.#touch();
  }

  /** How exact the heat map is, metres; null while none is shown. */
  get heatAccuracy(): number | null {
    return this.#over.heat.isOn ? this.#over.heat.accuracy : null;
  }

  /** Calls `f` whenever a lost graphics context came back; the next frame draws everything anew. */
  onRestored(f: () => void): void {
    this.#restored.push(f);
  }

  dispose(): void {
    this.#resizes.disconnect();
    this.canvas.removeEventListener("webglcontextlost", this.#onLost);
    this.canvas.removeEventListener("webglcontextrestored", this.#onRestored);
    this.clear();
    for (const room of [this.#kept, this.#average, this.#lit, this.#probe, this.#over, this.#composer]) room.dispose();
    this.#back.dispose();
    this.#materials.dispose();
    this.renderer.dispose();
  }

  /** Once the whole mock-up is shown, which would have to wait for it otherwise. */
  #makeField(): void {
    const held = this.#held;
    const mesh = this.#over.held.fieldMesh();
    this.#isFieldDue = false;
    if (!mesh) return;
    void this.options.fieldOf?.(mesh.pieces, mesh.lower, mesh.upper).then((field) => {
      if (this.#held !== held) return;
      this.#over.heat.setField(field);
      this.#touch();
      this.onStale?.();
    });
  }

  readonly #onLost = (event: Event): void => {
    // Else the browser would never give it back.
    event.preventDefault();
    this.#isLost = true;
    this.#work.forget();
  };

  readonly #onRestored = (): void => {
    // Three brings buffers, textures and programs back as they are drawn: every array is still on the page.
    this.#isLost = false;
    this.#kept.forget();
    this.#average.samples = 0;
    this.#isSizeNew = true;
    this.#isShapeNew = true;
    this.#touch();
    for (const f of this.#restored) f();
  };

  /** The shapes over the mock-up are to be drawn anew. */
  #touch(): void {
    this.#isOverlayNew = true;
    this.#average.samples = 0;
    this.#changedAt = Infinity;
  }

  #cut(): void {
    const count = this.#model.sections.length;
    for (const room of [this.#materials, this.#probe]) room.setSections(count);
    this.#over.setSections(this.#model);
    this.#aimAtCanvas();
    this.#isShapeNew = true;
    this.#touch();
  }

  #placeHits(): void {
    this.#over.placeHits(this.#model);
    this.#touch();
  }

  #colour(): void {
    const colours = coloursOf(this.#theme);
    this.#kept.setColours(colours);
    this.#uniforms.ghost.value.copy(ghostOf(this.#theme));
    const { above, below } = this.#back.material.uniforms as Record<string, { value: typeof colours.above }>;
    above?.value.copy(colours.above);
    below?.value.copy(colours.below);
    this.#isShapeNew = true;
    this.#touch();
  }

  #followTable(): void {
    if (this.#model.takeShapes()) {
      this.#isShapeNew = true;
      // A triangle of a part that was hidden or moved is not where it was.
      this.#placeHits();
    }
    this.#touch();
  }

  /** A drag changes the shapes at every step: if a redraw is slow, they are drawn as while the camera moves. */
  #stir(): void {
    if (this.#pace.estimate(this.#model.triangles) > SLOW_REDRAW_MS) this.#movedAt = performance.now();
  }

  #isMoving(now: number): boolean {
    return now - this.#movedAt < STILL_MS;
  }

  #resize(): void {
    if (!this.#isSizeNew) return;
    this.#isSizeNew = false;
    const width = Math.max(1, this.canvas.clientWidth);
    const height = Math.max(1, this.canvas.clientHeight);
    const wanted = Math.min(window.devicePixelRatio, this.options.pixelRatio ?? 2);
    const ratio = Math.min(wanted, Math.sqrt(MOST_PIXELS / (width * height)));
    this.renderer.setPixelRatio(ratio);
    this.renderer.setSize(width, height, false);
    this.#kept.setSize(this.canvas.width, this.canvas.height);
    this.#lit.setSize(this.canvas.width, this.canvas.height);
    Object.assign(this.camera, { width, height });
    this.#isViewNew = true;
    this.#aimAtCanvas();
    this.#touch();
  }

  #takeCamera(now: number): void {
    if (!this.camera.moved) return;
    this.camera.moved = false;
    this.#movedAt = now;
    this.#isViewNew = true;
    this.#aimAtCanvas();
    this.#touch();
  }

  #aimAtCanvas(): void {
    this.#aim(this.canvas.width, this.canvas.height, this.canvas.height / this.camera.height);
    this.#over.build(this.camera);
  }

  #aim(width: number, height: number, pixelRatio: number): void {
    // Not of moving parts: the kept layer's depths are read by the planes that it was drawn with.
    const { bounds, middle, sections } = this.#model;
    const box = isEmpty(bounds) ? this.#over.held.box() : bounds;
    const isReversed = this.renderer.capabilities.reversedDepthBuffer;
    const picture = { width, height, pixelRatio };
    aim(this.eye, this.#uniforms, { camera: this.camera, box, middle, isReversed, picture });
    const { cutPlanes, viewPlanes } = this.#uniforms;
    const slack = CUT_SLACK * diagonal(bounds);
    writePlanes(sections, middle, this.camera, cutPlanes.value, viewPlanes.value, slack);
  }

  /** Redraws the mock-up: all of it, or as much as the pace allows while the camera moves. */
  #redraw(isDraft: boolean): void {
    this.#isViewNew = false;
    this.#isShapeNew = false;
    const { solid, ghosts } = this.#model.pieces(this.eye);
    const triangles = solid.reduce((sum, piece) => sum + piece.triangles, 0);
    this.#kept.begin(solid, ghosts, isDraft ? this.#pace.scale : 1);
    this.#kept.wanted = this.#pace.estimate(triangles) < SLOW_REDRAW_MS ? JITTER.length : JITTER.length / 2;
    // While there was no picture yet, a part of it at once is better than all of it later.
    const whole = this.#isPictured ? Infinity : this.#pace.triangles(SLICE_MS);
    this.#drawKept(isDraft ? this.#pace.draft : whole, isDraft);
  }

  #drawKept(budget: number, isDraft: boolean): void {
    const at = performance.now();
    const triangles = this.#kept.draw(this.eye, budget);
    this.#isShown = false;
    this.#composer.isLitNew = true;
    this.#work.begin(at, triangles, isDraft);
    this.#touch();
  }

  #step(now: number, stats: FrameStats): void {
    const kept = this.#kept;
    const isMoving = this.#isMoving(now);
    if (this.#isViewNew || this.#isShapeNew) {
      // The device is still busy with the frame before: another one would only wait behind it.
      if (isMoving && this.#work.isRunning) return;
      this.#redraw(isMoving);
      stats.isKept = false;
    } else if ((!kept.isWhole || kept.scale !== 1) && !isMoving && !this.#work.isRunning) {
      // At least as many as are drawn already: each slice shades the whole picture anew.
      if (kept.isContinuable) this.#drawKept(Math.max(this.#pace.triangles(SLICE_MS), kept.triangles), false);
      else this.#redraw(false);
      stats.isKept = false;
    }
    const isIdle = now - this.#changedAt >= IDLE_MS && !this.#work.isRunning;
    if (this.#isOverlayNew) {
      this.#present();
      this.#changedAt = now;
      stats.drawn = true;
    } else if (isIdle && kept.isWhole && !kept.isRefined) {
      const before = kept.triangles;
      const at = performance.now();
      this.#composer.isLitNew = kept.refine(this.eye, this.#pace.triangles(REFINE_MS));
      if (this.#composer.isLitNew) this.#composer.compose(kept, this.#lit, this.#isAnyLit, null);
      this.#work.begin(at, kept.triangles - before, false);
      stats.drawn = true;
    } else if (isIdle && kept.isRefined && this.#average.samples < JITTER.length) {
      this.#average.setSize(this.canvas.width, this.canvas.height);
      this.#composer.addSample(kept, this.#lit, this.#isAnyLit, this.#average);
      // The canvas keeps its content until the mean is complete.
      if (this.#average.samples === JITTER.length) this.#average.show(null);
      stats.drawn = true;
    }
  }

  /** The frame as it is now, on the canvas, with its figures. */
  #present(): void {
    this.#isOverlayNew = false;
    this.#over.build(this.camera);
    this.#composer.compose(this.#kept, this.#lit, this.#isAnyLit, null);
    this.#over.label(this.camera, this.taken());
  }

  get #isAnyLit(): boolean {
    return this.#model.table?.isAnyLit === true;
  }

  /** Everything at once, as a headset needs it: the head never stands, so nothing is worth keeping. */
  #drawDirect(): void {
    const { renderer, eye } = this;
    const target = renderer.getRenderTarget();
    // No scene holds the rig that would bring it up to date.
    this.rig.updateMatrixWorld();
    renderer.clear(true, true, false);
    this.#uniforms.hasKept.value = false;
    if (eye.half !== null) {
      // Eyes see in perspective, and planes behind them are not for a headset.
      eye.half = null;
      Object.assign(eye, this.camera.range(this.#model.bounds, renderer.capabilities.reversedDepthBuffer, false));
      this.#uniforms.parallel.value = 0;
    }
    this.#back.draw(renderer, target);
    const { solid, ghosts } = this.#model.pieces(null);
    this.#drawMeshes(solid, null);
    this.#drawMeshes(ghosts, this.#materials.ghost);
    this.#over.draw(renderer, eye);
  }

  #drawMeshes(pieces: Piece[], material: RawShaderMaterial | null): void {
    if (pieces.length === 0) return;
    this.#pieceScene.children = pieces.map((piece) => piece.mesh);
    this.#pieceScene.overrideMaterial = material;
    this.renderer.render(this.#pieceScene, this.eye);
  }
}
