// The page's own state: its connection to the server, and its open dialogs and panels.

import type { Point, Vec3 } from "../math/vectors";

/** How the page stands with the server. */
export type Connection = "connecting" | "open" | "lost" | "refused" | "full" | "outdated" | "offline";

export interface Notice {
  readonly id: number;
  readonly level: "info" | "warning" | "error";
  readonly text: string;
  /** The command that was refused, or when. */
  readonly of: string | undefined;
}

/** The panels on the right. */
export type Panel = "pose" | "ask" | "sections" | "measures" | "sequence" | "findings" | "mechanism" | "task";
export const PANELS: readonly Panel[] = [
  "pose",
  "ask",
  "sections",
  "measures",
  "sequence",
  "findings",
  "mechanism",
  "task",
];

/** A panel by its name; the first for a name of another version. */
export const knownPanel = (name: string): Panel => PANELS.find((panel) => panel === name) ?? "pose";

/** The cover of the page. */
export type Dialog = "palette" | "help" | "settings" | "people" | "open" | "doubts" | null;

/** In a narrow window, which of them is open. */
export type Drawer = "tree" | "panels" | null;

export interface ContextMenu {
  readonly x: number;
  readonly y: number;
  readonly part: number;
  readonly point: Vec3 | null;
  /** The pixel of the picture. */
  readonly at: Point;
  /** The ids of its commands; absent: those of a part, or of the background. */
  readonly items?: readonly string[];
}
