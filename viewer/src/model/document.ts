// The document: what the server draws and knows, as it comes over the link, and how a patch changes it.

import type { RecordFacts } from "../link/protocol";
import type { Pose } from "../math/matrix";
import type { Unit } from "../math/units";
import type { Vec3 } from "../math/vectors";
import type { CameraState } from "../scene/camera";

export type ContactMode = "stop" | "glide" | "pass";
export const MODES: readonly ContactMode[] = ["stop", "glide", "pass"];

export interface Section {
  readonly id: number;
  readonly normal: Vec3;
  /** Kept is where `normal . x >= offset`. */
  readonly offset: number;
  readonly is_on: boolean;
}

export interface Removal {
  readonly id: number;
  readonly name: string;
  readonly parts: readonly number[];
  readonly way: readonly Pose[];
  readonly least_clearance: number | null;
  readonly touched: readonly string[];
  readonly tool: string | null;
}

export type MeasureType = "point" | "edge" | "angle" | "parts";

export interface Measure {
  readonly id: number;
  readonly name: string;
  readonly type: MeasureType;
  readonly points: readonly Vec3[];
  readonly value: number;
  readonly unit: "m" | "rad";
  readonly is_exact: boolean;
}

export interface Viewpoint {
  readonly id: number;
  readonly name: string;
  readonly camera: CameraState;
}

/** What the server draws and knows: one value, changed by patches only. World metres; poses row by row. */
export interface Document {
  readonly mockup: { name: string; hash: string; triangles: number; parts: number } | null;
  readonly loading: { stage: string; share: number } | null;
  readonly failed: string | null;
  readonly tool: { name: string; triangles: number } | null;
  /** Names of what can be taken in hand. */
  readonly tools: readonly string[];
  readonly record: RecordFacts | null;
  /** Parts that were left out of the scene from the start: they have no geometry here, and no path. */
  readonly absent: readonly number[];
  readonly held_version: number;
  readonly unit: Unit;
  readonly mode: ContactMode;
  readonly hidden: readonly number[];
  readonly ghost: readonly number[];
  readonly explode: number;
  readonly isolated: boolean;
  readonly sections: readonly Section[];
  readonly pose: Pose;
  readonly gripped: readonly number[];
  readonly moved: Readonly<Record<string, Pose>>;
  readonly out: readonly number[];
  readonly sequence: readonly Removal[];
  readonly replaying: number | null;
  readonly measures: readonly Measure[];
  readonly viewpoints: readonly Viewpoint[];
  readonly findings: Findings | null;
  readonly material: string | null;
}

export interface Findings {
  readonly groups: readonly FindingGroup[];
  readonly status: Readonly<Record<string, string>>;
  readonly is_touching_hidden: boolean;
}

export interface FindingGroup {
  readonly name: string;
  readonly findings: readonly Finding[];
}

/** What a clash check says of two parts. */
export interface Finding {
  readonly id: string;
  /** Part paths, and the parts' ids where they are in this mock-up. */
  readonly a: string;
  readonly b: string;
  readonly part_a: number | null;
  readonly part_b: number | null;
  readonly verdict: string;
  /** Metres. */
  readonly depth: number | null;
  readonly gap: number | null;
  readonly point_a: Vec3 | null;
  readonly point_b: Vec3 | null;
  readonly is_touching: boolean;
  readonly sentence: string;
}

/** The document with the patch's fields in place of its own. */
export const patched = (document: Document, fields: Partial<Document>): Document => ({ ...document, ...fields });

/** How the page stands with the server. */
export type Connection = "connecting" | "open" | "lost" | "refused" | "outdated" | "offline";

export interface Notice {
  readonly id: number;
  readonly level: "info" | "warning" | "error";
  readonly text: string;
}

/** What is on the right. */
export type Panel = "pose" | "sections" | "measures" | "sequence" | "findings";
export const PANELS: readonly Panel[] = ["pose", "sections", "measures", "sequence", "findings"];

/** What covers the page. */
export type Dialog = "palette" | "help" | "settings" | null;

export interface ContextMenu {
  readonly x: number;
  readonly y: number;
  readonly part: number;
  readonly point: Vec3 | null;
  /** The pixel of the picture. */
  readonly at: { readonly x: number; readonly y: number };
}
