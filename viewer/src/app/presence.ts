// Tells the server where this page's person points and looks, while others are there.

import type { Workbench } from "../actions/workbench";
import { type Here, LEAST_HERE_MS, MOST_SELECTED } from "../link/protocol";
import { isSame } from "../math/same";

/** A page that says nothing for some seconds counts as away. */
const STILL_HERE_MS = 2000;

/** Tells where the person is: at most once in a time, and only what is new, but now and then in any case. */
export class Presence {
  private isShared = false;
  private told: Omit<Here, "kind"> | null = null;
  private waiting: ReturnType<typeof setTimeout> | null = null;
  private ticking: ReturnType<typeof setInterval> | null = null;

  constructor(private readonly wb: Workbench) {}

  /** Whether anybody is there to see it. */
  share(isShared: boolean): void {
    if (isShared === this.isShared) return;
    this.isShared = isShared;
    this.told = null;
    if (this.ticking !== null) clearInterval(this.ticking);
    this.ticking = isShared ? setInterval(() => this.tick(), STILL_HERE_MS) : null;
    this.changed();
  }

  changed(): void {
    if (!this.isShared || this.waiting !== null) return;
    this.waiting = setTimeout(() => {
      this.waiting = null;
      this.send(false);
    }, LEAST_HERE_MS);
  }

  private tick(): void {
    if (!globalThis.document?.hidden) this.send(true);
  }

  private send(isForced: boolean): void {
    if (!this.isShared) return;
    const here = this.here();
    if (!isForced && isSame(here, this.told)) return;
    this.told = here;
    this.wb.link?.here(here);
  }

  private here(): Omit<Here, "kind"> {
    const { store, stage, hand } = this.wb;
    const count = store.paths.peek().length;
    return {
      point: store.pointed.peek(),
      selection: [...store.selection.peek()].filter((part) => part < count).slice(0, MOST_SELECTED),
      camera: stage.camera.toJSON(),
      is_moving: (hand.wish !== null && hand.source !== "api") || store.typed.peek() !== null,
    };
  }
}
