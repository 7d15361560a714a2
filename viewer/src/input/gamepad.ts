// Gamepads of the standard mapping: sticks and triggers move the hand in the view's frame, buttons give commands.
//
//     left stick       right, up              right stick   turn about the view's up and right axes
//     right trigger    away from the viewer   left trigger  towards the viewer
//     shoulder buttons roll about the line of sight
//     A grip   B undo   X contact mode   Y redo   cross up, down: faster, finer

import { curved, curvedStick, isRest, RateDriver, type RateSpeeds, type RateTarget, REST, type SixRates } from "./rate";

export type PadCommand = "grip" | "mode" | "undo" | "redo";

/** The fields used of a `Gamepad`. */
export interface PadReading {
  readonly id: string;
  readonly index: number;
  readonly connected: boolean;
  readonly mapping: string;
  readonly axes: readonly number[];
  readonly buttons: readonly { readonly pressed: boolean; readonly value: number }[];
}

export interface PadSettings {
  isOn: boolean;
  /** Share of the deflection that counts as rest: worn sticks rest beside the middle. */
  dead_zone: number;
  /** 0: straight, 1: cubic. */
  bend: number;
}

const BUTTONS: Readonly<Record<number, PadCommand>> = { 0: "grip", 1: "undo", 2: "mode", 3: "redo" };
const LEFT_SHOULDER = 4;
const RIGHT_SHOULDER = 5;
const LEFT_TRIGGER = 6;
const RIGHT_TRIGGER = 7;
const CROSS_UP = 12;
const CROSS_DOWN = 13;
const GEAR_FACTOR = 2;
const LEAST_GEAR = 1 / 16;
const MOST_GEAR = 4;

/** The six deflections of a pad of the standard mapping. */
export function ratesOf(pad: PadReading, settings: PadSettings): SixRates {
  const axis = (index: number) => pad.axes[index] ?? 0;
  const button = (index: number) => pad.buttons[index]?.value ?? 0;
  const { dead_zone, bend } = settings;
  // A stick pushed away reads -1.
  const [right, down] = curvedStick(axis(0), axis(1), dead_zone, bend);
  const [turn_right, turn_down] = curvedStick(axis(2), axis(3), dead_zone, bend);
  const near = curved(button(LEFT_TRIGGER), dead_zone, bend) - curved(button(RIGHT_TRIGGER), dead_zone, bend);
  const roll = button(LEFT_SHOULDER) - button(RIGHT_SHOULDER);
  return { translation: [right, -down, near], rotation: [turn_down, turn_right, roll] };
}

/** Buttons that are pressed in `after` and were not in `before`. */
export function pressedAnew(before: readonly boolean[], after: readonly boolean[]): number[] {
  return after.flatMap((isPressed, index) => (isPressed && !before[index] ? [index] : []));
}

export interface PadHost {
  readonly target: () => RateTarget;
  readonly speeds: () => RateSpeeds;
  command(command: PadCommand): void;
  notice(text: string): void;
}

export class GamepadInput {
  readonly settings: PadSettings = { isOn: true, dead_zone: 0.12, bend: 0.7 };
  /** Factor of all speeds, by the cross. */
  gear = 1;

  private readonly driver: RateDriver;
  /** Buttons that are held, by the pad's index. */
  private readonly held = new Map<number, boolean[]>();
  private readonly refused = new Set<string>();

  constructor(
    private readonly host: PadHost,
    private readonly pads: () => readonly (PadReading | null)[] = () => navigator.getGamepads?.() ?? [],
  ) {
    this.driver = new RateDriver(host.target, "gamepad", () => {
      const speeds = host.speeds();
      return {
        translation_m_per_s: speeds.translation_m_per_s * this.gear,
        rotation_rad_per_s: speeds.rotation_rad_per_s * this.gear,
      };
    });
  }

  /** Reads the pads; once a frame. Whether another frame is wanted, since pads tell nothing by themselves. */
  frame(now_ms: number): boolean {
    const usable = this.settings.isOn ? this.pads().filter((pad) => pad !== null && this.isUsable(pad)) : [];
    let rates = REST;
    for (const pad of usable as PadReading[]) {
      this.readButtons(pad);
      const own = ratesOf(pad, this.settings);
      if (!isRest(own)) rates = own;
    }
    for (const index of this.held.keys()) if (!usable.some((pad) => pad?.index === index)) this.held.delete(index);
    this.driver.drive(rates, now_ms);
    return usable.length > 0;
  }

  private isUsable(pad: PadReading): boolean {
    if (!pad.connected) return false;
    if (pad.mapping === "standard") return true;
    // VR controllers are listed too, with a mapping of their own.
    if (pad.mapping !== "xr-standard" && !this.refused.has(pad.id)) {
      this.refused.add(pad.id);
      this.host.notice(`The browser does not know the buttons of the gamepad ${pad.id}; it is not used.`);
    }
    return false;
  }

  private readButtons(pad: PadReading): void {
    const now = pad.buttons.map((button) => button.pressed);
    // Buttons pressed when the pad first appears give no command: browsers show a pad at the first press of any button.
    const before = this.held.get(pad.index) ?? now;
    this.held.set(pad.index, now);
    for (const index of pressedAnew(before, now)) {
      const command = BUTTONS[index];
      if (command) this.host.command(command);
      if (index === CROSS_UP) this.gear = Math.min(MOST_GEAR, this.gear * GEAR_FACTOR);
      if (index === CROSS_DOWN) this.gear = Math.max(LEAST_GEAR, this.gear / GEAR_FACTOR);
    }
  }
}
