// The hand: the wished pose of the tool. Every device moves it; the engine answers with the pose that contact allows.
//
// A device either gives a whole pose (`move`) or an increment in a frame (`nudge`). A wish is sent at most once a
// frame (`take`). `put` ends a movement: once the engine has answered the last wish and the tool stands, the pose that
// the tool reached becomes one `place` command, one step of undo.

import type { Wish } from "../link/link";
import type { Source } from "../link/protocol";
import { BROWSER_TIMERS, type Timers } from "../link/turns";
import {
  axis,
  carry,
  fromAxes,
  isSamePose,
  movedBy,
  multiply,
  orthonormal,
  type Pose,
  rotationOf,
  translation,
  turn,
} from "../math/matrix";
import { scale, type Vec3 } from "../math/vectors";

/** The frame in which an increment is meant: the camera's (right, up, towards the viewer), the tool's or the world. */
export type Frame = "view" | "tool" | "world";

/** A movement (metres) and a turn (rotation vector, radians) about the hand's pivot, both in one frame. */
export interface Increment {
  readonly translation: Vec3;
  readonly rotation: Vec3;
}

export interface HandListener {
  /** The wish is new: a frame is due. */
  moved(): void;
  /** The movement ended with the tool at `pose`. */
  placed(pose: Pose): void;
  /** The movement that was put down is over: after `placed`, or without it where it was given up. */
  ended(): void;
}

/** The tool stands when no state moved it for this long after the last wish was answered. */
const SETTLE_MS = 120;

export class Hand {
  /** Increments of devices are multiplied by it (Shift: fine). Absolute poses are not. */
  increment_scale = 1;
  /** Steps to which `snapped` rounds; null: none. */
  step_m: number | null = null;
  step_rad: number | null = null;
  /** The point of the hand's frame about which increments turn; the middle of the held mesh. */
  pivot: Vec3 = [0, 0, 0];
  /** Input is off: the link is down, or the page only reads. */
  isLocked = false;
  /** `view_axes` as a pose at the origin: right, up, towards the viewer. */
  viewAxes: () => Pose = () => fromAxes([1, 0, 0], [0, 1, 0], [0, 0, 1], [0, 0, 0]);

  /** What moved the hand last. */
  source: Source | null = null;

  private current: Pose | null = null;
  private solid: Pose | null = null;
  private fresh: Wish | null = null;
  private sent_seq = 0;
  private is_putting = false;
  private isGivenUp = false;
  private putting_timer: number | null = null;

  constructor(
    private readonly listener: HandListener,
    private readonly timers: Timers = BROWSER_TIMERS,
    private readonly now: () => number = () => performance.now(),
  ) {}

  /** Where the hand wishes the tool to be; null while nobody moves it. Drawn as the ghost. */
  get wish(): Pose | null {
    return this.current;
  }

  /** From where a movement starts: the wish of the movement under way, else where the tool stands. */
  get pose(): Pose | null {
    return this.current ?? this.solid;
  }

  /** Where the engine has the tool; null before it told. */
  get tool(): Pose | null {
    return this.solid;
  }

  /** The pivot in the world, at the hand's pose. */
  get center(): Vec3 | null {
    const pose = this.pose;
    return pose && carry(pose, this.pivot);
  }

  /** A wish has not gone out yet. */
  get isWaiting(): boolean {
    return this.fresh !== null;
  }

  /** The movement was put down, and the tool is not at rest yet. */
  get isPutting(): boolean {
    return this.is_putting;
  }

  /** The number of the last wish that went out. */
  get sentSeq(): number {
    return this.sent_seq;
  }

  /** Wishes the tool at `pose` (`world_from_tool`, row by row). */
  move(pose: ArrayLike<number>, source: Source, time_ms = this.now()): void {
    if (this.isLocked) return;
    const wish = orthonormal(pose);
    if (!wish.every(Number.isFinite)) return;
    this.endPutting();
    this.current = wish;
    this.source = source;
    // The earliest input of a frame counts for the latency, the last one for the pose.
    this.fresh = { pose: wish, source, time_ms: this.fresh?.time_ms ?? time_ms };
    this.listener.moved();
  }

  /** Moves on by an increment; `increment_scale` applies. */
  nudge(increment: Increment, frame: Frame, source: Source, time_ms = this.now()): void {
    const pose = this.pose;
    if (!pose) return;
    const axes = this.axesOf(frame, pose);
    const by = turn(axes, scale(increment.translation, this.increment_scale));
    const spin = turn(axes, scale(increment.rotation, this.increment_scale));
    const center = carry(pose, this.pivot);
    const turned = multiply(
      translation(center),
      multiply(rotationOf(spin), multiply(translation(scale(center, -1)), pose)),
    );
    this.move(movedBy(turned, by), source, time_ms);
  }

  /** The axes of a frame as world directions, at the origin. */
  axesOf(frame: Frame, pose: ArrayLike<number>): Pose {
    if (frame === "view") return this.viewAxes();
    if (frame === "tool") return fromAxes(axis(pose, 0), axis(pose, 1), axis(pose, 2), [0, 0, 0]);
    return fromAxes([1, 0, 0], [0, 1, 0], [0, 0, 1], [0, 0, 0]);
  }

  /** A length or an angle rounded to its step, if one is set. */
  snapped(value: number, kind: "length" | "angle"): number {
    const step = kind === "length" ? this.step_m : this.step_rad;
    return step ? Math.round(value / step) * step : value;
  }

  /** The movement ends: the pose that the tool reaches becomes one step of undo. */
  put(): void {
    if (!this.current) return;
    this.is_putting = true;
    this.isGivenUp = false;
    if (!this.fresh) this.startSettling();
  }

  /** The movement that was put down is over, wherever the tool is now. */
  finish(): void {
    if (!this.is_putting) return;
    this.stopPutting();
    const pose = this.solid;
    this.current = null;
    if (pose && !this.isGivenUp) this.listener.placed(pose);
    this.listener.ended();
    this.listener.moved();
  }

  /** The movement is given up: the tool goes back to `pose`, and nothing is placed. */
  cancel(pose: ArrayLike<number>, source: Source): void {
    this.move(pose, source);
    this.put();
    this.isGivenUp = true;
  }

  /** Nobody moves the hand any more; the ghost goes. */
  drop(): void {
    this.current = null;
    this.fresh = null;
    this.endPutting();
    this.listener.moved();
  }

  /** The wish to send in this frame, once; null without a new one. */
  take(): Wish | null {
    const wish = this.fresh;
    this.fresh = null;
    return wish;
  }

  /** The wish that `take` gave went out under this number. */
  sentAs(seq: number): void {
    this.sent_seq = seq;
  }

  /** The engine's pose, and the number of the wish that it answers. */
  answered(pose: ArrayLike<number>, pose_seq: number): void {
    const isMoving = !this.solid || !isSamePose(this.solid, pose);
    this.solid = Array.from(pose);
    if (!this.is_putting || this.fresh || pose_seq < this.sent_seq) return;
    if (this.current && isSamePose(this.current, pose)) this.finish();
    else if (isMoving || this.putting_timer === null) this.startSettling();
  }

  private startSettling(): void {
    if (this.putting_timer !== null) this.timers.clear(this.putting_timer);
    this.putting_timer = this.timers.set(() => this.finish(), SETTLE_MS);
  }

  private endPutting(): void {
    const isOver = this.is_putting;
    this.stopPutting();
    if (isOver) this.listener.ended();
  }

  private stopPutting(): void {
    this.is_putting = false;
    if (this.putting_timer !== null) this.timers.clear(this.putting_timer);
    this.putting_timer = null;
  }
}
