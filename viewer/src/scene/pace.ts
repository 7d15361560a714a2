// How much may be drawn while the camera moves, from the measured cost of drawing. No clock: times are passed in.

const START_MS_PER_TRIANGLE = 10 / 1e6;
// While the camera moves, a frame aims at this; above `SLOW_MS` it draws less.
const SLOW_MS = 20;
const LEAST_TRIANGLES = 100_000;
/** The camera stands when it has not moved for this long. */
export const STILL_MS = 150;

export class Pace {
  #msPerTriangle = START_MS_PER_TRIANGLE;
  #isKnown = false;
  #scale = 1;

  /** A draw of `triangles` took `ms` on the device; `isDraft` when the camera was moving. */
  add(triangles: number, ms: number, isDraft: boolean): void {
    if (triangles < LEAST_TRIANGLES / 4) return;
    // Of two alike measurements the quicker one is nearer the truth: others wait for the display or for other work.
    const seen = ms / triangles;
    this.#isKnown = true;
    this.#msPerTriangle += (seen - this.#msPerTriangle) * (seen < this.#msPerTriangle ? 0.6 : 0.3);
    if (!isDraft) return;
    if (ms > 2 * SLOW_MS && triangles <= 2 * LEAST_TRIANGLES) this.#scale = 0.5;
    else if (ms < SLOW_MS) this.#scale = 1;
  }

  /** The triangles that `ms` allow; never so few that nothing could be told, and so few until something was. */
  triangles(ms: number): number {
    return this.#isKnown ? Math.max(LEAST_TRIANGLES, ms / this.#msPerTriangle) : LEAST_TRIANGLES;
  }

  /** Expected time for `triangles`, ms. */
  estimate(triangles: number): number {
    return triangles * this.#msPerTriangle;
  }

  /** The triangles of a frame while the camera moves. */
  get draft(): number {
    return this.triangles(SLOW_MS);
  }

  /** The share of the resolution while the camera moves. */
  get scale(): number {
    return this.#scale;
  }
}
