// Rate devices (gamepad, SpaceMouse): deflections become increments in the view's frame, frame by frame.

import type { Source } from "../link/protocol";
import { scale, type Vec3 } from "../math/vectors";
import type { Increment } from "../model/hand";

/** Deflections from -1 to 1 along and about the view's axes: right, up, towards the viewer. */
export interface SixRates {
  readonly translation: Vec3;
  readonly rotation: Vec3;
}

/** The speed at full deflection. */
export interface RateSpeeds {
  readonly translation_m_per_s: number;
  readonly rotation_rad_per_s: number;
}

/** The target of a rate device: the hand, or the camera behind the same two calls. */
export interface RateTarget {
  nudge(increment: Increment, frame: "view", source: Source, time_ms: number): void;
  put(): void;
}

export const REST: SixRates = { translation: [0, 0, 0], rotation: [0, 0, 0] };

export const isRest = (rates: SixRates): boolean =>
  [...rates.translation, ...rates.rotation].every((rate) => rate === 0);

/** A frame that comes late moves no farther than this: a tab that was hidden must not fling the tool. */
const LONGEST_STEP_S = 0.05;
const FIRST_STEP_S = 1 / 60;

/**
 * A deflection beyond the dead zone, from 0 at its edge to 1.
 *
 * `bend` mixes the cube in: 0 is straight, 1 all cube, so that small deflections are fine and full ones are not slower.
 */
export function curved(value: number, dead_zone: number, bend: number): number {
  const size = Math.min(1, Math.abs(value));
  if (!(size > dead_zone)) return 0;
  const beyond = (size - dead_zone) / (1 - dead_zone);
  return Math.sign(value) * ((1 - bend) * beyond + bend * beyond ** 3);
}

/** A stick's two axes: the dead zone is a circle, so that the direction stays the thumb's. */
export function curvedStick(x: number, y: number, dead_zone: number, bend: number): [number, number] {
  const size = Math.hypot(x, y);
  const gain = size > 0 ? curved(size, dead_zone, bend) / size : 0;
  return [x * gain, y * gain];
}

export class RateDriver {
  private last_ms: number | null = null;

  constructor(
    private readonly target: () => RateTarget,
    private readonly source: Source,
    private readonly speeds: () => RateSpeeds,
  ) {}

  /** Moves the target by one frame's worth; at rest after a movement it is put down. Whether it moves. */
  drive(rates: SixRates, now_ms: number): boolean {
    if (isRest(rates)) {
      if (this.last_ms !== null) this.target().put();
      this.last_ms = null;
      return false;
    }
    const since_s = this.last_ms === null ? FIRST_STEP_S : (now_ms - this.last_ms) / 1000;
    const step_s = Math.min(LONGEST_STEP_S, Math.max(0, since_s));
    this.last_ms = now_ms;
    const speeds = this.speeds();
    const increment = {
      translation: scale(rates.translation, speeds.translation_m_per_s * step_s),
      rotation: scale(rates.rotation, speeds.rotation_rad_per_s * step_s),
    };
    this.target().nudge(increment, "view", this.source, now_ms);
    return true;
  }
}
