// Shows the engine's state: the tool and its ghost, highlights, the heat map and marks; at a lower rate the numbers in panels, and at a
// still lower one the words of the live region.

import type { Workbench } from "../actions/workbench";
import type { State } from "../link/protocol";
import { isSamePose, type Pose } from "../math/matrix";
import { touchedParts } from "../model/contact";
import { spokenState } from "../ui/words";
import { marksOf } from "./marks";
import { withLit } from "./part-states";

/** How often figures in panels follow the state. */
const SHOWN_INTERVAL_MS = 100;
/** How often the live region speaks of contacts. */
const SPOKEN_INTERVAL_MS = 1000;

const NONE = new Uint32Array(0);

export class StateView {
  /** The newest; null: nothing is known of the engine. */
  state: State | null = null;
  /** Something is to be drawn that is not in the picture yet. */
  isNew = false;

  private shown_ms = Number.NEGATIVE_INFINITY;
  private spoken_ms = Number.NEGATIVE_INFINITY;
  private base_states: Uint8Array = new Uint8Array(0);
  private solid: ArrayLike<number> | null = null;
  private wish: readonly number[] | null = null;
  private lit = "";
  private last_spoken = "";

  constructor(private readonly wb: Workbench) {}

  take(state: State | null): void {
    this.state = state;
    this.isNew = true;
  }

  /** The states of the parts except touched and near, which follow the engine. */
  setPartStates(states: Uint8Array): void {
    this.base_states = states;
    this.lit = "?";
    this.isNew = true;
  }

  /** In each frame, before the stage draws. */
  frame(now: number): void {
    if (this.isNew) this.takeState(now);
    // A hand that nobody moves has its ghost where the way ends that guides it.
    const end = this.wb.document?.guiding?.way.at(-1) ?? null;
    this.setPose(this.state?.pose ?? this.wb.document?.pose ?? null, this.wb.hand.wish ?? end);
  }

  /** Panels follow the state more slowly than the picture does; the last one always gets there. */
  show(now: number, is_last: boolean): void {
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

  private takeState(now: number): void {
    this.isNew = false;
    const { state } = this;
    const { stage, store } = this.wb;
    stage.setHits(state?.hits ?? NONE, state?.tool_hits ?? NONE);
    stage.setMarks(marksOf(store, state, this.wb.hand));
    stage.setHeat(state !== null && (state.clearance_parts.length > 0 || state.parts.length > 0));
    const lit = state ? touchedParts(state).join() : "";
    if (lit !== this.lit) {
      this.lit = lit;
      stage.setPartStates(withLit(this.base_states, state));
    }
    this.show(now, false);
  }

  /** The stage redraws for every pose that it gets, so that only changed ones are sent. */
  private setPose(solid: ArrayLike<number> | null, wish: readonly number[] | null): void {
    if (!solid || (solid === this.solid && wish === this.wish)) return;
    this.solid = solid;
    this.wish = wish;
    this.wb.stage.setPose(solid, ghostOf(wish, solid));
  }
}

/** The ghost is drawn if the hand is ahead of the tool. */
const ghostOf = (wish: readonly number[] | null, solid: ArrayLike<number>): Pose | null =>
  wish && !isSamePose(wish, solid, 1e-6) ? [...wish] : null;
