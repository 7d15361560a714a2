// Sound of contacts: decaying modes for an impact, filtered noise for sliding. No files.
//
// Impact: the modes of a free bar as long as the part is large (frequencies 1 : 2.76 : 5.40 : 8.93 : 13.3), which die
// away by the material's loss, excited by a half-sine strike that is the shorter the faster it is (Hertz: speed^-1/5).

import type { Felt, Impact, Slide } from "./events";
import { MATERIALS, type Material } from "./materials";

export interface Mode {
  readonly frequency_hz: number;
  /** Time in which the amplitude falls to 1/e. */
  readonly decay_s: number;
  /** Amplitude at the strike. */
  readonly gain: number;
}

export interface SlideSound {
  readonly gain: number;
  readonly frequency_hz: number;
  /** Quality of the band: high is a whistle, low is a hiss. */
  readonly quality: number;
}

/** Squares of the free bar's eigenvalues, by the first. */
const BAR_RATIOS = [1, 2.757, 5.404, 8.933, 13.344] as const;
/** First mode of a free bar a twelfth as thick as long: frequency = this * speed of sound / length. */
const BAR_FACTOR = 0.0857;
const LOWEST_HZ = 70;
const HIGHEST_FIRST_HZ = 5000;
const HIGHEST_HZ = 14000;
const LONGEST_DECAY_S = 0.5;
const SHORTEST_DECAY_S = 0.004;

/** At most this many impacts sound at once; the oldest makes room. */
export const VOICES = 12;
/** Peak of the strongest impact, so that a few at once do not clip. */
const IMPACT_PEAK = 0.5;
const SLIDE_PEAK = 0.25;
/** A sliding force at which the noise has half its greatest gain. */
const SLIDE_HALF_N = 5;
const SLIDE_HALF_M_PER_S = 0.05;
const SLIDE_LEAST_M_PER_S = 5e-4;
/** Gains follow within this time: a step in a gain clicks. */
const SMOOTH_S = 0.02;
/** The noise stops after this long without sliding. */
const SLIDE_REST_S = 0.5;

const clamp = (value: number, least: number, most: number): number => Math.min(most, Math.max(least, value));

/** The modes of a part `size_m` long that is struck at `speed_m_per_s`; their gains sum to `strength`. */
export function modesOf(material: Material, size_m: number, speed_m_per_s: number, strength: number): Mode[] {
  const { sound_m_per_s, loss, contact_s } = MATERIALS[material];
  const first_hz = clamp((BAR_FACTOR * sound_m_per_s) / Math.max(size_m, 1e-4), LOWEST_HZ, HIGHEST_FIRST_HZ);
  const strike_s = contact_s * Math.max(speed_m_per_s, 1e-3) ** -0.2;
  const modes: Mode[] = [];
  for (const ratio of BAR_RATIOS) {
    const frequency_hz = first_hz * ratio;
    if (frequency_hz > HIGHEST_HZ) break;
    const decay_s = clamp(1 / (Math.PI * frequency_hz * loss), SHORTEST_DECAY_S, LONGEST_DECAY_S);
    // A strike that takes long against the mode's period hardly excites it.
    modes.push({ frequency_hz, decay_s, gain: 1 / (1 + (2 * frequency_hz * strike_s) ** 2) / Math.sqrt(ratio) });
  }
  const sum = modes.reduce((total, mode) => total + mode.gain, 0);
  return modes.map((mode) => ({ ...mode, gain: (strength * mode.gain) / sum }));
}

export const modesOfImpact = (impact: Impact): Mode[] =>
  modesOf(impact.material, impact.part_size_m, impact.speed_m_per_s, impact.strength);

/** The noise of sliding: louder by speed and force, its band higher by speed and finer roughness. */
export function slideSound(slide: Slide): SlideSound {
  const { roughness_m } = MATERIALS[slide.material];
  const speed = slide.speed_m_per_s;
  const force = slide.force_n;
  const isSliding = speed >= SLIDE_LEAST_M_PER_S && force > 0;
  const bySpeed = speed / (speed + SLIDE_HALF_M_PER_S);
  const byForce = Math.sqrt(force / (force + SLIDE_HALF_N));
  return {
    gain: isSliding ? SLIDE_PEAK * bySpeed * byForce : 0,
    frequency_hz: clamp(speed / roughness_m, 120, 6000),
    // A firm press narrows the band: rubbing becomes scraping.
    quality: 0.7 + 1.5 * (force / (force + SLIDE_HALF_N)),
  };
}

/** An impact that sounds. */
export interface Voice {
  /** Fades out at once. */
  stop(): void;
}

/** Plays modes from `at_s` on, into `output`; `ended` is called when they have died away. */
export function playModes(
  context: BaseAudioContext,
  output: AudioNode,
  modes: readonly Mode[],
  at_s: number,
  ended: () => void,
): Voice {
  const envelope = context.createGain();
  envelope.connect(output);
  let sounding = 0;
  const oscillators: OscillatorNode[] = [];
  for (const mode of modes) {
    const oscillator = context.createOscillator();
    oscillator.frequency.value = mode.frequency_hz;
    const gain = context.createGain();
    gain.gain.setValueAtTime(IMPACT_PEAK * mode.gain, at_s);
    gain.gain.setTargetAtTime(0, at_s, mode.decay_s);
    oscillator.connect(gain).connect(envelope);
    oscillator.start(at_s);
    // exp(-7) is 60 dB down.
    oscillator.stop(at_s + 7 * mode.decay_s);
    sounding++;
    oscillator.onended = () => {
      gain.disconnect();
      if (--sounding > 0) return;
      envelope.disconnect();
      ended();
    };
    oscillators.push(oscillator);
  }
  return {
    stop() {
      envelope.gain.setTargetAtTime(0, context.currentTime, SMOOTH_S / 4);
      for (const oscillator of oscillators) oscillator.stop(context.currentTime + 2 * SMOOTH_S);
    },
  };
}

/** Two seconds of white noise, the same each time (xorshift). */
export function noiseSamples(count: number): Float32Array<ArrayBuffer> {
  const samples = new Float32Array(count);
  let state = 0x9e3779b9;
  for (let k = 0; k < count; k++) {
    state ^= state << 13;
    state ^= state >>> 17;
    state ^= state << 5;
    samples[k] = (state | 0) / 0x80000000;
  }
  return samples;
}

/** The noise of sliding, made when first needed and stopped after a rest. */
export class SlideVoice {
  private readonly filter: BiquadFilterNode;
  private readonly gain: GainNode;
  private readonly noise: AudioBuffer;
  private source: AudioBufferSourceNode | null = null;
  private silent_since: number | null = null;

  constructor(
    private readonly context: BaseAudioContext,
    output: AudioNode,
  ) {
    this.noise = context.createBuffer(1, 2 * context.sampleRate, context.sampleRate);
    this.noise.copyToChannel(noiseSamples(this.noise.length), 0);
    this.filter = context.createBiquadFilter();
    this.filter.type = "bandpass";
    this.gain = context.createGain();
    this.gain.gain.value = 0;
    this.filter.connect(this.gain).connect(output);
  }

  set(sound: SlideSound): void {
    const now = this.context.currentTime;
    if (sound.gain === 0) {
      this.rest(now);
      return;
    }
    this.silent_since = null;
    if (!this.source) {
      this.source = this.context.createBufferSource();
      this.source.buffer = this.noise;
      this.source.loop = true;
      this.source.connect(this.filter);
      this.source.start();
    }
    this.gain.gain.setTargetAtTime(sound.gain, now, SMOOTH_S);
    this.filter.frequency.setTargetAtTime(sound.frequency_hz, now, SMOOTH_S);
    this.filter.Q.setTargetAtTime(sound.quality, now, SMOOTH_S);
  }

  private rest(now: number): void {
    if (!this.source) return;
    if (this.silent_since === null) {
      this.silent_since = now;
      this.gain.gain.setTargetAtTime(0, now, SMOOTH_S);
    } else if (now - this.silent_since > SLIDE_REST_S) {
      this.source.stop();
      this.source.disconnect();
      this.source = null;
    }
  }
}

/** Loud sums bend instead of clipping: linear up to a half, then towards 1. */
export function softClip(count = 1025): Float32Array<ArrayBuffer> {
  const curve = new Float32Array(count);
  for (let k = 0; k < count; k++) {
    const x = (2 * k) / (count - 1) - 1;
    const size = Math.abs(x);
    curve[k] = size <= 0.5 ? x : Math.sign(x) * (0.5 + 0.5 * Math.tanh((size - 0.5) / 0.5));
  }
  return curve;
}

const GESTURES = ["pointerdown", "keydown", "touchend"] as const;

/**
 * The sound of the page.
 *
 * Browsers let no page sound before the user's first gesture: `unlockOn` waits for it. What happens before is not
 * played later.
 */
export class Sound {
  private context: AudioContext | null = null;
  private master: GainNode | null = null;
  private slide: SlideVoice | null = null;
  private readonly voices = new Set<Voice>();
  private level = 0.7;
  private isSilent = false;

  constructor(private readonly open: () => AudioContext = () => new AudioContext()) {}

  /** 0 to 1. */
  get volume(): number {
    return this.level;
  }

  set volume(level: number) {
    this.level = clamp(level, 0, 1);
    this.applyLevel();
  }

  get isMuted(): boolean {
    return this.isSilent;
  }

  set isMuted(isMuted: boolean) {
    if (isMuted === this.isSilent) return;
    this.isSilent = isMuted;
    this.applyLevel();
    if (!isMuted) {
      // Unmuting is a gesture, perhaps the user's first.
      void this.unlock();
      return;
    }
    for (const voice of this.voices) voice.stop();
    // A context at work costs the machine a thread, heard or not.
    void this.context?.suspend().catch(() => {});
  }

  /** Whether something would be heard now. */
  get isReady(): boolean {
    return this.context?.state === "running" && !this.isSilent;
  }

  /** Impacts that sound now, at most `VOICES`. */
  get sounding(): number {
    return this.voices.size;
  }

  /** Waits for the first gesture on `target`; returns how to wait no longer. */
  unlockOn(target: EventTarget): () => void {
    const stop = () => {
      for (const kind of GESTURES) target.removeEventListener(kind, unlock, true);
    };
    const unlock = () => {
      void this.unlock().then((isUnlocked) => {
        if (isUnlocked) stop();
      });
    };
    for (const kind of GESTURES) target.addEventListener(kind, unlock, true);
    return stop;
  }

  /** Opens the device; to be called in a user's gesture. False where the browser refuses or has no sound. */
  async unlock(): Promise<boolean> {
    if (this.isSilent) return false;
    try {
      this.context ??= this.build();
      if (this.context.state !== "running") await this.context.resume();
    } catch {
      return false;
    }
    return this.context.state === "running";
  }

  /** Plays the contacts; once a frame. */
  play(felt: Felt): void {
    if (!this.context || !this.master || !this.isReady) return;
    this.slide?.set(slideSound(felt.slide));
    for (const impact of felt.impacts) this.strike(this.context, this.master, impact);
  }

  async close(): Promise<void> {
    await this.context?.close();
    this.context = null;
    this.master = null;
    this.slide = null;
    this.voices.clear();
  }

  private strike(context: AudioContext, master: GainNode, impact: Impact): void {
    if (this.voices.size >= VOICES) {
      const oldest = this.voices.values().next().value;
      if (oldest) {
        oldest.stop();
        this.voices.delete(oldest);
      }
    }
    const voice = playModes(context, master, modesOfImpact(impact), context.currentTime, () =>
      this.voices.delete(voice),
    );
    this.voices.add(voice);
  }

  private build(): AudioContext {
    const context = this.open();
    const shaper = context.createWaveShaper();
    shaper.curve = softClip();
    this.master = context.createGain();
    this.master.gain.value = this.level;
    this.master.connect(shaper).connect(context.destination);
    this.slide = new SlideVoice(context, this.master);
    return context;
  }

  private applyLevel(): void {
    if (!this.context || !this.master) return;
    const level = this.isSilent ? 0 : this.level;
    this.master.gain.setTargetAtTime(level, this.context.currentTime, SMOOTH_S);
  }
}
