// The drawing loop: a frame only when something asks for one. Wishes go out, the newest state and the hand's ghost are
// drawn, and the time from an input to the picture of its answer is measured.

import type { Workbench } from "../actions/workbench";
import { type CutHandle, drawCuts } from "../input/cuts";
import { drawGizmo, GIZMO_RADIUS_PX, type Handle } from "../input/gizmo";
import type { Pointer } from "../input/mouse";
import type { State } from "../link/protocol";
import { isSamePose, type Pose } from "../math/matrix";
import { PartState } from "../scene/stage";
import { spokenState } from "../ui/words";
import { marksOf } from "./marks";

/** The stage finishes its picture (resolution, small parts, edges) up to so long after the last change. */
const LINGER_MS = 400;
/** How often figures in panels follow the state. */
const SHOWN_INTERVAL_MS = 100;
/** How often the live region speaks of contacts. */
const SPOKEN_INTERVAL_MS = 1000;
/** Frames further apart than this were not drawn in a row. */
const GAP_MS = 250;
const KEPT = 200;

/** The last `KEPT` values, the oldest first. */
export class Recent {
  readonly values: number[] = [];

  add(value: number): void {
    this.values.push(value);
    if (this.values.length > KEPT) this.values.shift();
  }

  clear(): void {
    this.values.length = 0;
  }
}

export interface Browser {
  requestFrame(callback: (now: number) => void): void;
  now(): number;
  isHidden(): boolean;
}

const BROWSER: Browser = {
  requestFrame: (callback) => requestAnimationFrame(callback),
  now: () => performance.now(),
  isHidden: () => document.hidden,
};

export class Drawing {
  /** Milliseconds from a drawn frame to the next of the same run; the first of a run counts its own work. */
  readonly frames = new Recent();
  /** Milliseconds from an input to the end of the frame that draws the engine's answer to it. */
  readonly input_to_drawn = new Recent();
  /** Called in each frame; true: another frame is due. Devices that have to be polled, sound and rumble. */
  readonly each_frame = new Set<(now: number) => boolean>();
  /** Called when a frame is drawn; true: another frame is due. What waits for a picture. */
  readonly after_frame = new Set<() => boolean>();
  state: State | null = null;

  private readonly sent_ms = new Map<number, number>();
  private is_requested = false;
  private is_sent = false;
  private is_state_new = false;
  private active_ms = Number.NEGATIVE_INFINITY;
  private drawn_ms = Number.NEGATIVE_INFINITY;
  private shown_ms = Number.NEGATIVE_INFINITY;
  private spoken_ms = Number.NEGATIVE_INFINITY;
  private base_states: Uint8Array = new Uint8Array(0);
  private solid: ArrayLike<number> | null = null;
  private wish: Pose | null = null;
  private lit = "";
  private last_spoken = "";
  private gizmo_drawn = "";
  private cuts_drawn = "";

  constructor(
    private readonly wb: Workbench,
    private readonly pointer: Pointer | null,
    private readonly over: { readonly gizmo: HTMLCanvasElement; readonly cuts: HTMLElement } | null,
    private readonly browser: Browser = BROWSER,
  ) {}

  /** Asks for a frame. */
  readonly request = (): void => {
    this.active_ms = this.browser.now();
    this.schedule();
  };

  /** The hand has a new wish: the first of a frame goes out at once, others with the next frame. */
  wished(): void {
    if (!this.is_sent || this.browser.isHidden()) this.sendWish();
    this.request();
  }

  /** The engine's newest answer. */
  answered(state: State): void {
    this.state = state;
    this.is_state_new = true;
    this.wb.hand.answered(state.pose, state.pose_seq);
    this.request();
  }

  /** Nothing is known of the engine: the link is down, or another mock-up is open. */
  forget(): void {
    this.state = null;
    this.is_state_new = true;
    this.sent_ms.clear();
    this.request();
  }

  /** The states of the parts but for what is touched and near, which follows the engine. */
  setPartStates(states: Uint8Array): void {
    this.base_states = states;
    this.lit = "?";
    this.is_state_new = true;
    this.request();
  }

  /** Marks have other texts or others are selected. */
  remark(): void {
    this.is_state_new = true;
    this.request();
  }

  private schedule(): void {
    if (this.is_requested) return;
    this.is_requested = true;
    this.browser.requestFrame((now) => this.onFrame(now));
  }

  private sendWish(): void {
    const { hand, link } = this.wb;
    const wish = hand.take();
    if (!wish || !link) return;
    const seq = link.pose(wish);
    if (seq === null) return;
    this.is_sent = true;
    hand.sentAs(seq);
    this.sent_ms.set(seq, wish.time_ms);
  }

  /** A frame at once: a headset has its own rhythm. */
  drawNow(now: number): void {
    this.frame(now);
  }

  private onFrame(now: number): void {
    this.is_requested = false;
    this.frame(now);
  }

  private frame(now: number): void {
    this.is_sent = false;
    const { stage, hand } = this.wb;
    let isMore = false;
    for (const each of this.each_frame) isMore = each(now) || isMore;
    this.sendWish();
    const { state } = this;
    const isAnswer = this.is_state_new;
    if (isAnswer) this.takeState(now);
    this.setPose(state?.pose ?? this.wb.document?.pose ?? null, hand.wish);
    this.paintGizmo();
    this.paintCuts();
    const stats = stage.frame(now);
    this.pointer?.frame();
    for (const each of this.after_frame) isMore = each() || isMore;
    const end = this.browser.now();
    if (isAnswer && state) this.countLatency(state, end);
    if (stats.drawn) this.countFrame(now, end);
    if (stats.drawn || !stats.isSettled) this.active_ms = end;
    if (this.is_state_new || isMore || end - this.active_ms < LINGER_MS) this.schedule();
    else this.showState(now, true);
  }

  /** The stage draws anew for every pose it is told, so that it is told only others. */
  private setPose(solid: ArrayLike<number> | null, wish: Pose | null): void {
    if (!solid || (solid === this.solid && wish === this.wish)) return;
    this.solid = solid;
    this.wish = wish;
    this.wb.stage.setPose(solid, ghostOf(wish, solid));
  }

  private takeState(now: number): void {
    this.is_state_new = false;
    const { state } = this;
    const { stage, store } = this.wb;
    stage.setHits(state?.hits ?? NONE, state?.tool_hits ?? NONE);
    stage.setMarks(marksOf(store, state));
    const lit = state ? `${state.parts.join()}|${state.clearance_parts.join()}` : "";
    if (lit !== this.lit) {
      this.lit = lit;
      stage.setPartStates(withLit(this.base_states, state));
    }
    this.showState(now, false);
  }

  /** Panels follow the state more slowly than the picture does; the last one always gets there. */
  private showState(now: number, is_last: boolean): void {
    const { store } = this.wb;
    if (!is_last && now - this.shown_ms < SHOWN_INTERVAL_MS) return;
    this.shown_ms = now;
    if (store.state.peek() !== this.state) store.state.value = this.state;
    if (!is_last && now - this.spoken_ms < SPOKEN_INTERVAL_MS) return;
    const text = this.state && spokenState(this.state, store.unit.peek(), (part) => store.nameOf(part));
    if (!text || text === this.last_spoken) return;
    this.last_spoken = text;
    this.spoken_ms = now;
    store.spoken.value = text;
  }

  private countLatency(state: State, end: number): void {
    const sent = this.sent_ms.get(state.pose_seq);
    if (sent === undefined) return;
    this.input_to_drawn.add(end - sent);
    for (const seq of this.sent_ms.keys()) if (seq <= state.pose_seq) this.sent_ms.delete(seq);
  }

  private countFrame(now: number, end: number): void {
    const since = now - this.drawn_ms;
    this.frames.add(since < GAP_MS ? since : end - now);
    this.drawn_ms = now;
  }

  private paintCuts(): void {
    const { over, pointer } = this;
    if (!over || !pointer) return;
    const handles = pointer.cuts();
    const key = `${pointer.cut}|${handles.map(describeCut).join(";")}`;
    if (key === this.cuts_drawn) return;
    this.cuts_drawn = key;
    drawCuts(over.cuts, handles, pointer.cut);
  }

  private paintGizmo(): void {
    const { pointer } = this;
    const gizmo = this.over?.gizmo;
    const context = gizmo?.getContext("2d");
    if (!gizmo || !pointer || !context) return;
    const handles = pointer.handles();
    const middle = handles[0]?.line[0];
    const key = middle ? describe(handles, pointer.handle) : "";
    if (key === this.gizmo_drawn) return;
    this.gizmo_drawn = key;
    gizmo.hidden = !middle;
    if (!middle) return;
    const ratio = Math.min(globalThis.devicePixelRatio || 1, 2);
    const size = Math.round(2 * GIZMO_RADIUS_PX * ratio);
    if (gizmo.width !== size) gizmo.width = gizmo.height = size;
    gizmo.style.transform = `translate(${middle.x - GIZMO_RADIUS_PX}px, ${middle.y - GIZMO_RADIUS_PX}px)`;
    drawGizmo(context, handles, pointer.handle, ratio);
  }
}

const NONE = new Uint32Array(0);

/** The ghost is drawn where the hand is ahead of the tool. */
const ghostOf = (wish: Pose | null, solid: ArrayLike<number>): Pose | null =>
  wish && !isSamePose(wish, solid, 1e-6) ? wish : null;

function withLit(base: Uint8Array, state: State | null): Uint8Array {
  const states = base.slice();
  const mark = (parts: ArrayLike<number>, bit: number): void => {
    for (let k = 0; k < parts.length; k++) {
      const part = parts[k] ?? -1;
      if (part >= 0 && part < states.length) states[part] = (states[part] ?? 0) | bit;
    }
  };
  if (state) {
    mark(state.clearance_parts, PartState.near);
    mark(state.parts, PartState.hit);
  }
  return states;
}

const describeCut = ({ id, line: [a, b] }: CutHandle): string =>
  `${id},${[a.x, a.y, b.x, b.y].map((value) => value.toFixed(1)).join()}`;

const describe = (handles: readonly Handle[], lit: Handle | null): string =>
  `${lit?.kind}${lit?.axis}|${handles.map(({ line }) => `${line[0]?.x.toFixed(1)},${line[0]?.y.toFixed(1)},${line.at(-1)?.x.toFixed(1)},${line.at(-1)?.y.toFixed(1)}`).join(";")}`;
