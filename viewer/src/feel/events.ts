// From the engine's states and impacts to sound and rumble: numbers, without a clock or a device.
//
// States and impacts are passed in as they arrive; `step`, once a frame, returns the result, which sound and rumble play.

import { carry, invert, multiply } from "../math/matrix";
import { dot, length, scale, subtract, type Vec3 } from "../math/vectors";
import { type Material, materialOf } from "./materials";

/** The part of a state that is felt. */
export interface ContactState {
  /** The engine's pose of the tool, `world_from_tool`. */
  readonly pose: ArrayLike<number>;
  /** Newtons, world directions. */
  readonly force: ArrayLike<number>;
  /** Eight numbers a contact plane: point (3), unit normal (3), gap, share of the force in newtons. */
  readonly planes: ArrayLike<number>;
  /** Ids of the parts that are touched. */
  readonly parts: ArrayLike<number>;
  /** How old the state was when it was sent. */
  readonly age_ms: number;
}

/** The engine's message of a new contact. */
export interface ImpactMessage {
  readonly part: number;
  readonly part_size_m: number;
  readonly speed_m_per_s: number;
  readonly point: ArrayLike<number>;
  readonly material: string | null;
  readonly force: number;
}

export interface Impact {
  readonly part: number;
  readonly part_size_m: number;
  readonly material: Material;
  readonly speed_m_per_s: number;
  readonly force_n: number;
  readonly point: Vec3;
  /** 0 to 1, as loud and hard as it is perceived. */
  readonly strength: number;
}

/** The events in the states and impacts since the previous step. */
export interface Felt {
  readonly impacts: readonly Impact[];
  /** Parts that are no longer touched. */
  readonly releases: readonly number[];
  readonly slide: Slide;
  /** Force on the tool, newtons. */
  readonly press_n: number;
}

export interface Slide {
  /** Speed along the contact planes, the mean by their shares of the force. */
  readonly speed_m_per_s: number;
  /** Force on the planes along which the tool slides, newtons. */
  readonly force_n: number;
  readonly material: Material;
}

/** Impacts at this speed and beyond are as strong as can be told. */
const FULL_SPEED_M_PER_S = 0.5;
/** Slower ones are neither heard nor felt. */
const LEAST_SPEED_M_PER_S = 1e-3;
/** A part that is struck again so soon chatters: one impact, unless the second is twice as fast. */
const CHATTER_MS = 80;
/** A part is released when no state has named it for this long. */
const RELEASE_MS = 60;
/** Speeds are smoothed over this time: the arrival of states jitters by milliseconds. */
const SMOOTHING_MS = 30;
/** The least time between two poses of which a speed is taken. */
const LEAST_INTERVAL_MS = 4;
/** Without a state for this long, the tool stands. */
const STANDS_MS = 120;
/** A contact that moves faster is a tool that was put elsewhere (undo, a typed pose), not one that slides. */
const JUMP_M_PER_S = 20;

/** 0 to 1: the square root of the speed, which loudness and felt hardness follow more nearly than the speed itself. */
export function strengthOf(speed_m_per_s: number): number {
  if (!(speed_m_per_s >= LEAST_SPEED_M_PER_S)) return 0;
  return Math.min(1, Math.sqrt(speed_m_per_s / FULL_SPEED_M_PER_S));
}

/** Speed along the planes and the force on them, of a tool that went from one pose to another in `seconds`. */
export function slideOf(
  before: ArrayLike<number>,
  after: ArrayLike<number>,
  planes: ArrayLike<number>,
  seconds: number,
): { speed_m_per_s: number; force_n: number } {
  // A point of the tool that is at `p` now was at `before * inverse(after) * p`.
  const before_from_after = multiply(before, invert(after));
  let weighted = 0;
  let force_n = 0;
  for (let k = 0; k + 8 <= planes.length; k += 8) {
    const n = (column: number) => planes[k + column] ?? 0;
    const share = Math.abs(n(7));
    if (!(share > 0)) continue;
    const point: Vec3 = [n(0), n(1), n(2)];
    const normal: Vec3 = [n(3), n(4), n(5)];
    const velocity = scale(subtract(point, carry(before_from_after, point)), 1 / seconds);
    const along = subtract(velocity, scale(normal, dot(velocity, normal)));
    weighted += share * length(along);
    force_n += share;
  }
  return { speed_m_per_s: force_n > 0 ? weighted / force_n : 0, force_n };
}

export class Feel {
  /** The material of parts that name none. */
  material: string | null = null;

  private pose: ArrayLike<number> | null = null;
  private posed_ms = 0;
  private heard_ms = Number.NEGATIVE_INFINITY;
  private speed = 0;
  private slide_n = 0;
  private press_n = 0;
  private readonly touched = new Map<number, number>();
  private readonly struck = new Map<number, { time_ms: number; speed: number }>();
  private impacts: Impact[] = [];

  /** A state arrived at `now_ms`. */
  state(state: ContactState, now_ms: number): void {
    this.heard_ms = now_ms;
    this.press_n = Math.hypot(state.force[0] ?? 0, state.force[1] ?? 0, state.force[2] ?? 0);
    for (let k = 0; k < state.parts.length; k++) this.touched.set(state.parts[k] as number, now_ms);
    this.follow(state, now_ms - state.age_ms);
  }

  /** The engine told of a new contact. */
  strike(message: ImpactMessage, now_ms: number): void {
    const speed_m_per_s = Math.abs(message.speed_m_per_s);
    const strength = strengthOf(speed_m_per_s);
    if (strength === 0) return;
    const last = this.struck.get(message.part);
    if (last && now_ms - last.time_ms < CHATTER_MS && speed_m_per_s < 2 * last.speed) return;
    this.struck.set(message.part, { time_ms: now_ms, speed: speed_m_per_s });
    this.touched.set(message.part, now_ms);
    this.impacts = this.impacts.filter((impact) => impact.part !== message.part);
    this.impacts.push({
      part: message.part,
      part_size_m: message.part_size_m,
      material: materialOf(message.material ?? this.material),
      speed_m_per_s,
      force_n: Math.abs(message.force),
      point: [message.point[0] ?? 0, message.point[1] ?? 0, message.point[2] ?? 0],
      strength,
    });
  }

  /** The contacts since the previous step; once a frame. */
  step(now_ms: number): Felt {
    const impacts = this.impacts;
    this.impacts = [];
    const releases: number[] = [];
    for (const [part, time_ms] of this.touched) {
      // States that stop coming say nothing of a release: the tool stands where it was.
      if (this.heard_ms - time_ms < RELEASE_MS) continue;
      releases.push(part);
      this.touched.delete(part);
    }
    for (const [part, last] of this.struck) if (now_ms - last.time_ms >= CHATTER_MS) this.struck.delete(part);
    if (now_ms - this.heard_ms > STANDS_MS) this.speed = 0;
    const slide = { speed_m_per_s: this.speed, force_n: this.slide_n, material: materialOf(this.material) };
    return { impacts, releases, slide, press_n: this.press_n };
  }

  /** Clears all contacts without release events: the link is down, or another mock-up is open. */
  reset(): void {
    this.pose = null;
    this.heard_ms = Number.NEGATIVE_INFINITY;
    this.speed = 0;
    this.slide_n = 0;
    this.press_n = 0;
    this.touched.clear();
    this.struck.clear();
    this.impacts = [];
  }

  private follow(state: ContactState, time_ms: number): void {
    const interval_ms = time_ms - this.posed_ms;
    if (this.pose && interval_ms >= 0 && interval_ms < LEAST_INTERVAL_MS) return;
    let { speed_m_per_s, force_n } = slideOf(this.pose ?? state.pose, state.pose, state.planes, interval_ms / 1000);
    const isKnown = this.pose !== null && interval_ms > 0 && interval_ms < STANDS_MS && speed_m_per_s < JUMP_M_PER_S;
    if (!isKnown) speed_m_per_s = 0;
    const share = isKnown ? 1 - Math.exp(-interval_ms / SMOOTHING_MS) : 1;
    this.speed = force_n > 0 ? this.speed + share * (speed_m_per_s - this.speed) : 0;
    this.slide_n = force_n;
    this.pose = Array.from(state.pose);
    this.posed_ms = time_ms;
  }
}
