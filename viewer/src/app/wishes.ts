// Sends the hand's wishes to the engine, at most one per frame, and measures the time until the answer is drawn.

import type { Workbench } from "../actions/workbench";
import type { State } from "../link/protocol";
import { Recent } from "./recent";

export class Wishes {
  /** Milliseconds from an input to the end of the frame that draws the engine's answer to it. */
  readonly input_to_drawn = new Recent();
  private readonly sent_ms = new Map<number, number>();
  private is_sent = false;

  constructor(private readonly wb: Workbench) {}

  /** The hand has a new wish: the first of a frame goes out at once, others with the next frame. */
  wished(isHidden: boolean): void {
    if (!this.is_sent || isHidden) this.send();
  }

  /** A frame begins: the next wish goes out at once. */
  begin(): void {
    this.is_sent = false;
  }

  /** Sends what waits. */
  send(): void {
    const { hand, link } = this.wb;
    const wish = hand.take();
    if (!wish || !link) return;
    const seq = link.pose(wish);
    if (seq === null) return;
    this.is_sent = true;
    hand.sentAs(seq);
    this.sent_ms.set(seq, wish.time_ms);
  }

  /** The frame that draws a state is done at `end`. */
  drawn(state: State, end: number): void {
    const sent = this.sent_ms.get(state.pose_seq);
    if (sent === undefined) return;
    this.input_to_drawn.add(end - sent);
    for (const seq of this.sent_ms.keys()) if (seq <= state.pose_seq) this.sent_ms.delete(seq);
  }

  /** Sent wishes will get no answer. */
  forget(): void {
    this.sent_ms.clear();
  }
}
