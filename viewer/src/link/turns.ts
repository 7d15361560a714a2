// The order of commands: they run in the order of the user's actions.
//
// A command that depends on the document waits until the previous ones are answered, so that a key pressed twice within a
// round trip is two steps. All wait while a movement of the tool is not finished, because it becomes a command before
// them.

/** The movement that commands wait for. */
export interface Movement {
  /** Whether it has ended for the person, and not yet as a command. */
  isOpen(): boolean;
  /** Ends it now. */
  end(): void;
}

export interface Timers {
  set(callback: () => void, delay_ms: number): number;
  clear(handle: number): void;
}

interface Turn {
  readonly begin: () => void;
  readonly isOfDocument: boolean;
}

/** A tool that comes to no rest holds commands up no longer. */
const MOST_WAIT_MS = 2000;

export const BROWSER_TIMERS: Timers = {
  set: (callback, delay_ms) => setTimeout(callback, delay_ms) as unknown as number,
  clear: (handle) => clearTimeout(handle),
};

/** Commands on their way to the engine. */
export class Turns {
  private readonly waiting: Turn[] = [];
  private unanswered = 0;
  private timer: number | null = null;

  constructor(
    private readonly movement: Movement,
    private readonly timers: Timers = BROWSER_TIMERS,
  ) {}

  /** Whether something is not answered yet, or will be asked for. */
  get isBusy(): boolean {
    return this.unanswered > 0 || this.waiting.length > 0 || this.movement.isOpen();
  }

  /** Does `work` in its turn: at once where nothing is before it. `isOfDocument`: once all before it is answered. */
  take<T>(work: () => Promise<T>, isOfDocument = false): Promise<T> {
    return new Promise((resolve, reject) => {
      const begin = (): void => {
        this.first(work).then(resolve, reject);
      };
      this.waiting.push({ begin, isOfDocument });
      this.go();
    });
  }

  /** Does `work` before all that waits. */
  async first<T>(work: () => Promise<T>): Promise<T> {
    this.unanswered++;
    try {
      return await work();
    } finally {
      this.unanswered--;
      this.go();
    }
  }

  /** Goes on: the movement may be over. */
  go(): void {
    for (let next = this.waiting[0]; next; next = this.waiting[0]) {
      if (this.movement.isOpen()) {
        this.timer ??= this.timers.set(() => this.endMovement(), MOST_WAIT_MS);
        return;
      }
      this.stopTimer();
      if (next.isOfDocument && this.unanswered > 0) return;
      this.waiting.shift();
      next.begin();
    }
  }

  private endMovement(): void {
    this.timer = null;
    this.movement.end();
    this.go();
  }

  private stopTimer(): void {
    if (this.timer !== null) this.timers.clear(this.timer);
    this.timer = null;
  }
}
