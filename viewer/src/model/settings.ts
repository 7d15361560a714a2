// The user's settings for this browser: kept over reloads. Only the name is sent.

import type { Frame } from "./hand";

/** The mock-up in VR: on a table, as large as one can reach around; or as large as it is. */
export type VrSize = "table" | "real";

export interface Settings {
  /** What others on the same project see; empty: "Guest 1". */
  readonly name: string;
  readonly theme: "system" | "dark" | "light";
  /** The id of a navigation style. */
  readonly style: string;
  /** Keys without Ctrl or Alt run commands; off for those whose keyboard is spoken to. */
  readonly has_single_keys: boolean;
  readonly step_m: number;
  readonly step_rad: number;
  readonly is_snapping: boolean;
  /** Parallel projection instead of perspective. */
  readonly is_parallel: boolean;
  /** The view glides to where commands send it; never where the system asks for reduced motion. */
  readonly has_glide: boolean;
  readonly frame: Exclude<Frame, "view">;
  readonly volume: number;
  readonly is_muted: boolean;
  readonly has_rumble: boolean;
  /** Of these by which it rumbles. */
  readonly has_event_rumble: boolean;
  readonly has_force_rumble: boolean;
  /** Share of a gamepad stick's deflection that counts as rest. */
  readonly dead_zone: number;
  readonly vr_size: VrSize;
  readonly has_seen_tour: boolean;
  /** The card with the first three questions is open. */
  readonly has_first_run: boolean;
  /** The question that is open in it, from 0; -1: none. */
  readonly first_run_step: number;
  /** The name of the open panel. */
  readonly panel: string;
  /** The engine's rate in the status line. */
  readonly has_figures: boolean;
  readonly is_tree_open: boolean;
  readonly are_panels_open: boolean;
}

export const DEFAULTS: Settings = {
  name: "",
  theme: "system",
  style: "feeler",
  has_single_keys: true,
  step_m: 1e-3,
  step_rad: (5 * Math.PI) / 180,
  is_snapping: false,
  is_parallel: false,
  has_glide: true,
  frame: "world",
  volume: 0.6,
  is_muted: false,
  has_rumble: true,
  has_event_rumble: true,
  has_force_rumble: true,
  dead_zone: 0.12,
  vr_size: "table",
  has_seen_tour: false,
  has_first_run: true,
  first_run_step: -1,
  panel: "pose",
  has_figures: false,
  is_tree_open: true,
  are_panels_open: true,
};

const KEY = "feeler.settings";

/** The settings of this browser; a default for each that is absent or of another type. */
export function loadSettings(storage: () => Pick<Storage, "getItem"> = () => localStorage): Settings {
  let kept: unknown;
  try {
    kept = JSON.parse(storage().getItem(KEY) ?? "{}");
  } catch {
    return DEFAULTS;
  }
  if (typeof kept !== "object" || kept === null) return DEFAULTS;
  const known = Object.entries(kept).filter(([key, value]) => typeof value === typeof DEFAULTS[key as keyof Settings]);
  return { ...DEFAULTS, ...Object.fromEntries(known) };
}

/** Keeps the settings; a browser that forbids it keeps none. */
export function saveSettings(settings: Settings, storage: () => Pick<Storage, "setItem"> = () => localStorage): void {
  try {
    storage().setItem(KEY, JSON.stringify(settings));
  } catch {
    // A private window or a file may refuse: the settings then last as long as the page.
  }
}
