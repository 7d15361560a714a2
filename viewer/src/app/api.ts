// `window.feeler`: the page for scripts and tests.

import { SHOT_HEIGHT, SHOT_WIDTH } from "../actions/exports";
import type { Workbench } from "../actions/workbench";
import type { Camera, CommandRequest, Document, State } from "../link/protocol";
import { isSamePose, type Pose } from "../math/matrix";
import type { Vec3 } from "../math/vectors";
import type { PeopleShown } from "../model/people";
import type { FrameStats } from "../scene/stage";
import { benchmark, type Drawn, type Figures, type ToolMotion, toolMotion } from "./benchmark";
import type { Loop } from "./loop";

export interface PageStats extends FrameStats, Drawn {
  /** Milliseconds from an input to the end of the frame that drew the engine's answer; the last 200. */
  readonly input_to_drawn: readonly number[];
}

/** Everything in metres, newtons and radians; poses are `world_from_tool`, 16 numbers row by row. */
export interface FeelerApi {
  /** The first whole picture is drawn. */
  readonly ready: boolean;
  /** Triangles of the mock-up's pieces that are in the picture. */
  readonly triangles: number;
  /** The tool's pose; null before the engine told one. */
  readonly pose: Pose | null;
  /** Wishes the tool at `pose`; resolves with the pose that the tool reached, in mode glide once it stands. */
  moveTo(pose: ArrayLike<number>): Promise<Pose>;
  /** Paths of the parts that are touched. */
  readonly touched: string[];
  readonly force: Vec3;
  /** Takes a part into the hand; rejects where it cannot be. */
  grip(path: string): Promise<void>;
  release(): Promise<void>;
  undo(): Promise<void>;
  /** Milliseconds from one drawn frame to the next, of the last 200. */
  readonly frames: readonly number[];
  readonly document: Document | null;
  readonly state: State | null;
  /** Who is there, where they are, and who has the tool. */
  readonly people: PeopleShown;
  readonly stats: PageStats;
  /** The camera of the picture; where it glides, that of the end. */
  readonly camera: Camera;
  /** Where a world point lies in the picture: CSS pixels from its upper left corner; null: behind the eye. */
  pixel(point: Vec3): [number, number] | null;
  /** The picture as PNG. */
  shot(width?: number, height?: number): Promise<Blob>;
  /** Measures drawing on this machine, camera and tool moving for `seconds` each; waits until the page is ready. */
  benchmark(seconds?: number): Promise<Figures>;
  /** The same of the tool alone, to and fro about where the hand wishes it. */
  moveAround(seconds?: number): Promise<ToolMotion>;
}

/** The tool stands in mode glide when its pose has not changed for so long. */
const STANDS_MS = 120;
/** A missing answer becomes an error instead of an endless wait. */
const ANSWER_MS = 10_000;
/** How long camera and tool move for `benchmark`. */
const BENCHMARK_S = 4;

export interface ApiSource {
  readonly wb: Workbench;
  readonly loop: Loop;
  readonly isReady: () => boolean;
  readonly whenReady: () => Promise<void>;
  readonly drawn: () => Drawn;
  readonly countTriangles: () => number;
  /** Calls back with every state; the function returned ends it. */
  readonly onState: (listener: (state: State) => void) => () => void;
}

export function createApi(source: ApiSource): FeelerApi {
  const { wb, loop, isReady, whenReady, drawn, countTriangles, onState } = source;
  const run = async (...request: CommandRequest): Promise<void> => {
    await wb.send(...request);
  };
  return {
    get ready() {
      return isReady();
    },
    get triangles() {
      return countTriangles();
    },
    get pose() {
      return poseOf(wb, loop.state);
    },
    moveTo: (pose) => moveTo(wb, onState, pose),
    get touched() {
      return (loop.state?.parts ?? []).map((part) => wb.path(part));
    },
    get force(): Vec3 {
      const force: Vec3 = loop.state?.force ?? [0, 0, 0];
      return [...force];
    },
    grip: (path) => run("grip", { parts: [path] }),
    release: () => run("release"),
    undo: () => run("undo"),
    get frames() {
      return [...loop.frames.values];
    },
    get document() {
      return wb.document;
    },
    get state() {
      return loop.state;
    },
    get people() {
      return wb.store.people.toJSON();
    },
    get stats() {
      return { ...wb.stage.stats, ...drawn(), input_to_drawn: [...loop.input_to_drawn.values] };
    },
    get camera() {
      return wb.stage.camera.toJSON();
    },
    pixel: (point) => {
      const { x, y, isAhead } = wb.stage.camera.arrived.project(point);
      return isAhead ? [x, y] : null;
    },
    shot: (width = SHOT_WIDTH, height = SHOT_HEIGHT) => wb.stage.shot(width, height),
    benchmark: async (seconds = BENCHMARK_S) => {
      await whenReady();
      return benchmark(wb, loop, drawn(), seconds);
    },
    moveAround: async (seconds = BENCHMARK_S) => {
      await whenReady();
      return toolMotion(wb, loop, seconds);
    },
  };
}

function poseOf(wb: Workbench, state: State | null): Pose | null {
  const pose = state?.pose ?? wb.document?.pose;
  return pose ? Array.from(pose) : null;
}

/** Somebody else has the tool. */
export class ToolError extends Error {
  override name = "ToolError";

  constructor(readonly holder: string) {
    super(`${holder || "somebody else"} has the tool`);
  }
}

export function moveTo(wb: Workbench, onState: ApiSource["onState"], pose: ArrayLike<number>): Promise<Pose> {
  const { hand } = wb;
  const { people } = wb.store;
  const barred = (): ToolError | null => (people.is_barred.peek() ? new ToolError(people.holder.peek()) : null);
  const refused = barred();
  if (refused) return Promise.reject(refused);
  if (hand.isLocked) return Promise.reject(new Error("the hand is empty, or the page is read-only"));
  if (pose.length !== 16) return Promise.reject(new RangeError("a pose has 16 numbers, row by row"));
  return new Promise((resolve, reject) => {
    let standing: ReturnType<typeof setTimeout> | undefined;
    let before: Pose | null = null;
    const done = (run: () => void): void => {
      clearTimeout(standing);
      clearTimeout(late);
      endBars();
      end();
      run();
    };
    const late = setTimeout(() => done(() => reject(barred() ?? new Error("the engine did not answer"))), ANSWER_MS);
    // Somebody else may take the tool on the way: nothing answers this wish then.
    const endBars = people.is_barred.subscribe(() => {
      const taken = barred();
      if (taken) done(() => reject(taken));
    });
    const end = onState((state) => {
      if (hand.isWaiting || state.pose_seq < hand.sentSeq) return;
      const reached = Array.from(state.pose);
      if (state.mode !== "glide") {
        done(() => resolve(reached));
        return;
      }
      if (before && isSamePose(before, reached)) return;
      before = reached;
      clearTimeout(standing);
      standing = setTimeout(() => done(() => resolve(reached)), STANDS_MS);
    });
    hand.move(pose, "api");
  });
}
