// Drawing speed of this machine: frames per second while the camera and the tool move, and the cost of single steps. It
// measures the real page, and restores its state afterwards.

import type { Workbench } from "../actions/workbench";
import { movedBy, type Pose } from "../math/matrix";
import { diagonal, scale, type Vec3 } from "../math/vectors";
import { offsetRange } from "../model/sections";
import type { FrameStats } from "../scene/stage";
import type { Loop } from "./loop";

/** Statistics of measurements in milliseconds (microseconds where the name says so). */
export interface Spread {
  readonly count: number;
  readonly p50: number;
  readonly p99: number;
}

/** Something that moved for a while, a step a frame. */
export interface Motion {
  readonly seconds: number;
  readonly frames: number;
  readonly frames_per_s: number;
  /** From one drawn frame to the next. */
  readonly interval_ms: Spread;
  /** The page's own time for a frame. */
  readonly page_ms: Spread;
}

export interface ToolMotion extends Motion {
  /** From the hand's wish to the end of the frame that draws the engine's answer. */
  readonly input_to_drawn_ms: Spread;
  readonly engine_us: Spread;
  /** Wishes that the engine had not answered yet, at most. */
  readonly most_unanswered: number;
  /** The share of the frames in which contact kept the tool from the hand. */
  readonly blocked: number;
}

/** A frame from its first call until the device is done with it: its cost, independent of the display's rate. */
export interface Cost extends Spread {
  readonly calls: number;
  readonly triangles: number;
}

export interface Figures {
  readonly renderer: string;
  readonly browser: string;
  /** Of the picture, device pixels. */
  readonly width: number;
  readonly height: number;
  readonly triangles: number;
  readonly parts: number;
  /** Milliseconds since 1970: when the page was opened, and its picture done by the device. */
  readonly opened_ms: number;
  readonly first_picture_ms: number | null;
  readonly whole_picture_ms: number | null;
  readonly camera: Motion;
  /** Null: the hand is empty. */
  readonly tool: ToolMotion | null;
  readonly camera_frame: Cost;
  readonly tool_frame: Cost | null;
  readonly whole_frame: Cost;
  readonly section_frame: Cost;
  readonly pick_ms: Spread;
  readonly hide_all_ms: Spread;
  readonly filter_all_ms: Spread;
}

/** When pictures were done, as `Figures` has them. */
export interface Drawn {
  readonly first_picture_ms: number | null;
  readonly whole_picture_ms: number | null;
}

const ORBIT_RAD = 0.01; // a frame
const SWING = 0.003; // of the tool to either side, of the mock-up's diagonal
const SWING_S = 1.5;
const COSTS = 40;
const WHOLE_COSTS = 4;
const STEPS = 20;
const MOST_TRIES = 3;
const SETTLE_MS = 1000;

/** Measures everything; `seconds` each for camera and tool. The page must be ready. */
export async function benchmark(wb: Workbench, loop: Loop, drawn: Drawn, seconds: number): Promise<Figures> {
  const { stage, store } = wb;
  const camera = stage.camera.toJSON();
  const gl = stage.renderer.getContext();
  const info = gl.getExtension("WEBGL_debug_renderer_info");
  const middle = stage.camera.target;
  const orbit = (): void => stage.camera.orbit(ORBIT_RAD, 0, middle);
  const hasHand = store.has_hand.peek() && !wb.hand.isLocked;
  const cameraMotion = await motion(wb, loop, seconds, orbit, (stats) => stats.drawn && !stats.isKept);
  const camera_frame = await cost(wb, COSTS, orbit);
  stage.camera.fromJSON(camera);
  await settled(loop);
  const figures: Figures = {
    renderer: String(gl.getParameter(info ? info.UNMASKED_RENDERER_WEBGL : gl.RENDERER)),
    browser: navigator.userAgent,
    width: stage.canvas.width,
    height: stage.canvas.height,
    triangles: store.manifest.peek()?.triangles ?? 0,
    parts: store.part_count.peek(),
    opened_ms: performance.timeOrigin,
    ...drawn,
    camera: cameraMotion,
    tool: hasHand ? await toolMotion(wb, loop, seconds) : null,
    camera_frame,
    tool_frame: hasHand ? await toolCost(wb) : null,
    whole_frame: await wholeCost(wb),
    section_frame: await sectionCost(wb),
    pick_ms: picks(wb),
    hide_all_ms: await hidings(wb),
    filter_all_ms: await filterings(wb),
  };
  loop.request();
  return figures;
}

/** The tool to and fro in the picture, about where the hand wishes it, a wish a frame. */
export async function toolMotion(wb: Workbench, loop: Loop, seconds: number): Promise<ToolMotion> {
  const { hand } = wb;
  const from = hand.pose ?? wb.document?.pose;
  if (!from) throw new Error("the hand is empty");
  const start: Pose = Array.from(from);
  const isHeld = hand.wish !== null;
  const engine_us: number[] = [];
  let most_unanswered = 0;
  let blocked = 0;
  let told = -1;
  loop.input_to_drawn.clear();
  const moved = await motion(
    wb,
    loop,
    seconds,
    (time_s) => {
      const { state } = loop;
      if (state && state.seq !== told) {
        told = state.seq;
        engine_us.push(state.engine_us);
        if (state.blocked) blocked++;
        if (state.pose_seq > 0) most_unanswered = Math.max(most_unanswered, hand.sentSeq - state.pose_seq);
      }
      hand.move(swung(wb, start, time_s), "api");
    },
    (stats) => stats.drawn,
  );
  hand.move(start, "api");
  const found = {
    ...moved,
    input_to_drawn_ms: spread(loop.input_to_drawn.values),
    engine_us: spread(engine_us),
    most_unanswered,
    blocked: engine_us.length > 0 ? blocked / engine_us.length : 0,
  };
  await settled(loop);
  if (!isHeld) hand.drop();
  return found;
}

function swung(wb: Workbench, start: Pose, time_s: number): Pose {
  const way = SWING * sizeOf(wb) * Math.sin((2 * Math.PI * time_s) / SWING_S);
  return movedBy(start, scale(wb.stage.camera.right, way));
}

function sizeOf(wb: Workbench): number {
  const manifest = wb.store.manifest.peek();
  return manifest ? diagonal(manifest) : 1;
}

/** Steps once a frame for a while. */
function motion(
  wb: Workbench,
  loop: Loop,
  seconds: number,
  step: (time_s: number) => void,
  isCounted: (stats: FrameStats) => boolean,
): Promise<Motion> {
  return new Promise((resolve) => {
    const times: number[] = [];
    const page_ms: number[] = [];
    let begun = Number.NaN;
    let before = Number.NaN;
    const each = (now: number): boolean => {
      const { stats } = wb.stage;
      // The work of the previous frame.
      if (!Number.isNaN(before) && isCounted(stats)) {
        times.push(before);
        page_ms.push(stats.ms);
      }
      if (Number.isNaN(begun)) begun = now;
      before = now;
      if (now - begun < 1000 * seconds) {
        step((now - begun) / 1000);
        return true;
      }
      loop.each_frame.delete(each);
      const took = (now - begun) / 1000;
      const intervals = times.slice(1).map((time, k) => time - (times[k] ?? time));
      resolve({
        seconds: took,
        frames: times.length,
        frames_per_s: times.length / took,
        interval_ms: spread(intervals),
        page_ms: spread(page_ms),
      });
      return false;
    };
    loop.each_frame.add(each);
    loop.request();
  });
}

/** Frames one by one, each waited for: a step, its calls, and the device's work. Those that drew nothing do not count. */
async function cost(wb: Workbench, count: number, step: (k: number) => void): Promise<Cost> {
  const { stage } = wb;
  const found: number[] = [];
  let last: FrameStats | null = null;
  for (let k = 0; k < MOST_TRIES * count && found.length < count; k++) {
    await frame();
    finish(wb);
    // A fence tells that it was passed in the next task at the earliest.
    await new Promise((resolve) => setTimeout(resolve, 0));
    const start = performance.now();
    step(k);
    const stats = stage.frame(start);
    finish(wb);
    if (!stats.drawn) continue;
    found.push(performance.now() - start);
    if (!last || stats.triangles >= last.triangles) last = stats;
  }
  return { ...spread(found), calls: last?.calls ?? 0, triangles: last?.triangles ?? 0 };
}

/** Reading a pixel waits until everything before it is drawn. */
function finish(wb: Workbench): void {
  const { renderer } = wb.stage;
  const gl = renderer.getContext();
  renderer.setRenderTarget(null);
  gl.readPixels(0, 0, 1, 1, gl.RGBA, gl.UNSIGNED_BYTE, new Uint8Array(4));
}

async function toolCost(wb: Workbench): Promise<Cost> {
  const start = Array.from(wb.hand.pose ?? wb.document?.pose ?? []);
  const found = await cost(wb, COSTS, (k) => wb.stage.setPose(swung(wb, start, k / 60), start));
  wb.stage.setPose(start, null);
  return found;
}

/** The mock-up drawn anew, all of it in one frame: another theme changes every pixel and nothing else. */
async function wholeCost(wb: Workbench): Promise<Cost> {
  const theme = wb.store.theme.peek();
  const other = theme === "dark" ? "light" : "dark";
  const found = await cost(wb, WHOLE_COSTS, (k) => wb.stage.setTheme(k % 2 === 0 ? other : theme));
  wb.stage.setTheme(theme);
  return found;
}

async function sectionCost(wb: Workbench): Promise<Cost> {
  const { stage, store } = wb;
  const manifest = store.manifest.peek();
  const normal: Vec3 = [0, 1, 0];
  const [least, most] = manifest ? offsetRange(manifest.lower, manifest.upper, normal) : [0, 1];
  const found = await cost(wb, STEPS, (k) => {
    stage.setSections([{ normal, offset: least + ((most - least) * (k + 1)) / (2 * STEPS) }]);
  });
  stage.setSections(
    store.drawn_sections.peek().map(({ normal, offset }) => ({ normal, offset })),
    store.drawn_box.peek(),
  );
  return found;
}

/** The query of the pointer: the part under a pixel. */
function picks(wb: Workbench): Spread {
  const { camera } = wb.stage;
  const found: number[] = [];
  wb.stage.frame(performance.now());
  wb.stage.pick(camera.width / 2, camera.height / 2);
  for (let k = 0; k < STEPS; k++) {
    const [x, y] = [((k * 7) % STEPS) / STEPS, ((k * 3) % STEPS) / STEPS];
    const start = performance.now();
    wb.stage.pick(x * camera.width, y * camera.height);
    found.push(performance.now() - start);
  }
  return spread(found);
}

async function hidings(wb: Workbench): Promise<Spread> {
  const { store } = wb;
  const before = store.document.peek()?.hidden ?? [];
  const all = store.paths.peek().map((_path, part) => part);
  const hide = (hidden: readonly number[]): void => {
    const document = store.document.peek();
    if (document) store.document.value = { ...document, hidden: [...hidden] };
  };
  return changes(
    wb,
    () => hide(all),
    () => hide(before),
  );
}

async function filterings(wb: Workbench): Promise<Spread> {
  const { store } = wb;
  const before = store.search.peek();
  // A letter that most names have: the longest list there is.
  return changes(
    wb,
    () => {
      store.search.value = "e";
    },
    () => {
      store.search.value = before;
    },
  );
}

/** The page's own time until a change is laid out and sent to the device. */
async function changes(wb: Workbench, change: () => void, back: () => void): Promise<Spread> {
  const found: number[] = [];
  for (let k = 0; k < STEPS; k++) {
    await frame();
    finish(wb);
    const start = performance.now();
    change();
    // Components render in a microtask, effects of theirs in the next.
    for (let turn = 0; turn < 3; turn++) await Promise.resolve();
    document.body.getBoundingClientRect();
    wb.stage.frame(performance.now());
    found.push(performance.now() - start);
    finish(wb);
    back();
    await frame();
  }
  return spread(found);
}

function spread(values: readonly number[]): Spread {
  const sorted = [...values].sort((a, b) => a - b);
  const at = (share: number): number =>
    sorted[Math.min(sorted.length - 1, Math.floor(share * sorted.length))] ?? Number.NaN;
  return sorted.length === 0 ? { count: 0, p50: 0, p99: 0 } : { count: sorted.length, p50: at(0.5), p99: at(0.99) };
}

const frame = (): Promise<number> => new Promise((resolve) => requestAnimationFrame(resolve));

/** Waits until the picture is complete and the requests are answered. */
const settled = (loop: Loop): Promise<void> => {
  loop.request();
  return new Promise((resolve) => setTimeout(resolve, SETTLE_MS));
};
