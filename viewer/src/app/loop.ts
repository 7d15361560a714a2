// The frame loop: draws a frame only on request. A frame sends the wish, draws the newest state and the hand's ghost, and
// counts.

import type { Workbench } from "../actions/workbench";
import type { Pointer } from "../input/mouse";
import type { State } from "../link/protocol";
import { type HandleElements, Handles } from "./handles";
import { Recent } from "./recent";
import { StateView } from "./state-view";
import { Wishes } from "./wishes";

/** The stage finishes its picture (resolution, small parts, edges) up to so long after the last change. */
const LINGER_MS = 400;
/** Frames further apart than this were not drawn in a row. */
const GAP_MS = 250;

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

export class Loop {
  /** Milliseconds from a drawn frame to the next of the same run; the first of a run counts its own work. */
  readonly frames = new Recent();
  /** Called in each frame; true: another frame is due. Devices that have to be polled, sound and rumble. */
  readonly each_frame = new Set<(now: number) => boolean>();
  /** Called when a frame is drawn; true: another frame is due. What waits for a picture. */
  readonly after_frame = new Set<() => boolean>();

  private readonly wishes: Wishes;
  private readonly view: StateView;
  private readonly handles: Handles | null;
  private is_requested = false;
  private active_ms = Number.NEGATIVE_INFINITY;
  private drawn_ms = Number.NEGATIVE_INFINITY;

  constructor(
    private readonly wb: Workbench,
    private readonly pointer: Pointer | null,
    over: HandleElements | null,
    private readonly browser: Browser = BROWSER,
  ) {
    this.wishes = new Wishes(wb);
    this.view = new StateView(wb);
    this.handles = pointer && over && new Handles(wb, pointer, over);
  }

  /** The engine's newest answer; null: nothing is known of it. */
  get state(): State | null {
    return this.view.state;
  }

  /** Milliseconds from an input to the end of the frame that draws the engine's answer to it. */
  get input_to_drawn(): Recent {
    return this.wishes.input_to_drawn;
  }

  /** Asks for a frame. */
  readonly request = (): void => {
    this.active_ms = this.browser.now();
    this.schedule();
  };

  /** The hand has a new wish. */
  wished(): void {
    this.wishes.wished(this.browser.isHidden());
    this.request();
  }

  /** The engine's newest answer. */
  answered(state: State): void {
    this.view.take(state);
    this.wb.hand.answered(state.pose, state.pose_seq);
    this.request();
  }

  /** Nothing is known of the engine: the link is down, or another mock-up is open. */
  forget(): void {
    this.view.take(null);
    this.wishes.forget();
    this.request();
  }

  /** The states of the parts except touched and near, which follow the engine. */
  setPartStates(states: Uint8Array): void {
    this.view.setPartStates(states);
    this.request();
  }

  /** Marks have other texts or others are selected. */
  remark(): void {
    this.view.isNew = true;
    this.request();
  }

  /** A frame at once: a headset has its own rhythm. */
  drawNow(now: number): void {
    this.frame(now);
  }

  private schedule(): void {
    if (this.is_requested) return;
    this.is_requested = true;
    this.browser.requestFrame((now) => {
      this.is_requested = false;
      this.frame(now);
    });
  }

  private frame(now: number): void {
    const { view, wishes } = this;
    let isMore = false;
    this.handles?.measure();
    wishes.begin();
    for (const each of this.each_frame) isMore = each(now) || isMore;
    wishes.send();
    const { state, isNew: isAnswer } = view;
    view.frame(now);
    this.handles?.paint();
    const stats = this.wb.stage.frame(now);
    this.pointer?.frame();
    for (const each of this.after_frame) isMore = each() || isMore;
    const end = this.browser.now();
    if (isAnswer && state) wishes.drawn(state, end);
    if (stats.drawn) this.countFrame(now, end);
    if (stats.drawn || !stats.isSettled) this.active_ms = end;
    if (view.isNew || isMore || end - this.active_ms < LINGER_MS) this.schedule();
    else view.show(now, true);
  }

  private countFrame(now: number, end: number): void {
    const since = now - this.drawn_ms;
    this.frames.add(since < GAP_MS ? since : end - now);
    this.drawn_ms = now;
  }
}
