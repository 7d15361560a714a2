// Rumble of contacts in gamepads and VR controllers.
//
// Two motors: a strong, slow one and a weak, fast one. An impact is a burst that dies away, on the strong motor for large
// parts and on the weak one for small ones; force is a hum on the strong motor, sliding one on the weak motor.

import type { Felt, Impact } from "./events";
import { MATERIALS } from "./materials";

export interface Magnitudes {
  /** 0 to 1. */
  readonly strong: number;
  readonly weak: number;
}

/** A device that rumbles. */
export interface RumbleOutput {
  /** For a duration, after which it stops by itself; a second call takes the place of the first. */
  play(magnitudes: Magnitudes, duration_ms: number): void;
  stop(): void;
}

export interface RumbleSettings {
  isOn: boolean;
  /** Bursts at impacts and releases. */
  hasEvents: boolean;
  /** Hum by force and sliding. */
  hasForce: boolean;
}

interface Burst extends Magnitudes {
  readonly start_ms: number;
  readonly decay_ms: number;
}

/** Parts of this size are felt half on either motor. */
const HALF_SIZE_M = 0.1;
/** A force at which the hum has half its greatest strength. */
const HALF_FORCE_N = 10;
const HALF_SLIDE_M_PER_S = 0.05;
/** The hum leaves room for bursts. */
const MOST_HUM = 0.4;
/** Below this no motor turns. */
const LEAST = 0.02;
const RELEASE: Magnitudes = { strong: 0, weak: 0.25 };
const RELEASE_DECAY_MS = 25;
/** Devices get a new value this often; if the page stops, they are silent `HOLD_MS` later. */
const INTERVAL_MS = 40;
const HOLD_MS = 120;
/** A rise by this much is sent at once. */
const RISE = 0.1;

/** The burst of an impact: a soft material's dies away more slowly and is duller. */
export function burstOf(impact: Impact, start_ms: number): Burst {
  const { contact_s } = MATERIALS[impact.material];
  const large = impact.part_size_m / (impact.part_size_m + HALF_SIZE_M);
  const softness = Math.min(1, contact_s / MATERIALS.rubber.contact_s);
  return {
    start_ms,
    decay_ms: 30 + 60 * large + 40 * softness,
    strong: impact.strength * (0.3 + 0.7 * large),
    weak: impact.strength * (1 - 0.7 * large) * (1 - 0.7 * softness),
  };
}

/** The hum of force and sliding. */
export function humOf(felt: Pick<Felt, "press_n" | "slide">): Magnitudes {
  const force = felt.press_n / (felt.press_n + HALF_FORCE_N);
  const { speed_m_per_s, force_n } = felt.slide;
  const isSliding = force_n > 0 && speed_m_per_s > 0;
  const slide = isSliding ? speed_m_per_s / (speed_m_per_s + HALF_SLIDE_M_PER_S) : 0;
  return { strong: MOST_HUM * force, weak: MOST_HUM * slide * (force_n / (force_n + HALF_FORCE_N)) };
}

const decayed = (burst: Burst, now_ms: number): number =>
  Math.exp(-Math.max(0, now_ms - burst.start_ms) / burst.decay_ms);

export class Rumble {
  readonly settings: RumbleSettings = { isOn: true, hasEvents: true, hasForce: true };
  private bursts: Burst[] = [];
  private told: Magnitudes = { strong: 0, weak: 0 };
  private told_ms = Number.NEGATIVE_INFINITY;
  private running: readonly RumbleOutput[] = [];

  /** `outputs` gives the devices that are there now. */
  constructor(private readonly outputs: () => readonly RumbleOutput[]) {}

  /** The motors' strengths, from the bursts up to now and the present contacts. */
  magnitudes(felt: Pick<Felt, "press_n" | "slide">, now_ms: number): Magnitudes {
    let { strong, weak } = this.settings.hasForce ? humOf(felt) : { strong: 0, weak: 0 };
    for (const burst of this.bursts) {
      strong += burst.strong * decayed(burst, now_ms);
      weak += burst.weak * decayed(burst, now_ms);
    }
    return { strong: Math.min(1, strong), weak: Math.min(1, weak) };
  }

  /** Plays the contacts; once a frame. Returns whether another frame is wanted: bursts decay frame by frame. */
  play(felt: Felt, now_ms: number): boolean {
    if (!this.settings.isOn) {
      this.bursts = [];
      this.silence();
      return false;
    }
    if (this.settings.hasEvents) {
      for (const impact of felt.impacts) this.bursts.push(burstOf(impact, now_ms));
      if (felt.releases.length > 0) this.bursts.push({ ...RELEASE, start_ms: now_ms, decay_ms: RELEASE_DECAY_MS });
    }
    this.bursts = this.bursts.filter((burst) => decayed(burst, now_ms) * Math.max(burst.strong, burst.weak) >= LEAST);
    const wanted = this.magnitudes(felt, now_ms);
    if (Math.max(wanted.strong, wanted.weak) < LEAST) {
      this.silence();
      return false;
    }
    const rise = Math.max(wanted.strong - this.told.strong, wanted.weak - this.told.weak);
    if (rise < RISE && now_ms - this.told_ms < INTERVAL_MS) return true;
    this.told = wanted;
    this.told_ms = now_ms;
    const outputs = this.outputs();
    for (const output of this.running) if (!outputs.includes(output)) output.stop();
    for (const output of outputs) output.play(wanted, HOLD_MS);
    this.running = outputs;
    return true;
  }

  /** Stops every device at once. */
  silence(): void {
    for (const output of this.running) output.stop();
    this.running = [];
    this.told = { strong: 0, weak: 0 };
    this.told_ms = Number.NEGATIVE_INFINITY;
  }
}

/** The features of a gamepad or VR controller; each browser has another subset. */
export interface HapticPad {
  readonly vibrationActuator?: object | null;
  readonly hapticActuators?: readonly object[];
}

interface DualActuator {
  playEffect(
    kind: "dual-rumble",
    effect: { duration: number; strongMagnitude: number; weakMagnitude: number },
  ): Promise<unknown>;
  reset?(): Promise<unknown>;
}

interface PulseActuator {
  pulse(value: number, duration: number): Promise<unknown>;
}

const OUTPUTS = new WeakMap<object, RumbleOutput>();
/** A device that was just unplugged refuses; there is nothing to do about it. */
const ignore = (): void => {};

function dual(actuator: DualActuator): RumbleOutput {
  return {
    play({ strong, weak }, duration) {
      actuator.playEffect("dual-rumble", { duration, strongMagnitude: strong, weakMagnitude: weak }).catch(ignore);
    },
    stop() {
      actuator.reset?.().catch(ignore);
    },
  };
}

function pulse(actuator: PulseActuator): RumbleOutput {
  return {
    play({ strong, weak }, duration) {
      actuator.pulse(Math.max(strong, weak), duration).catch(ignore);
    },
    stop() {
      actuator.pulse(0, 1).catch(ignore);
    },
  };
}

/** The output of a gamepad or controller, the same object each time; null where it has no motor. */
export function outputOf(pad: HapticPad): RumbleOutput | null {
  for (const actuator of [pad.vibrationActuator, pad.hapticActuators?.[0]]) {
    if (!actuator) continue;
    const known = OUTPUTS.get(actuator);
    if (known) return known;
    const output =
      "playEffect" in actuator
        ? dual(actuator as DualActuator)
        : "pulse" in actuator
          ? pulse(actuator as PulseActuator)
          : null;
    if (!output) continue;
    OUTPUTS.set(actuator, output);
    return output;
  }
  return null;
}

/** The outputs of the pads of `navigator.getGamepads()` and of a VR session. */
export function outputsOf(pads: Iterable<HapticPad | null | undefined>): RumbleOutput[] {
  const outputs: RumbleOutput[] = [];
  for (const pad of pads) {
    const output = pad ? outputOf(pad) : null;
    if (output) outputs.push(output);
  }
  return outputs;
}
