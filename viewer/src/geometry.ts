// The mock-up's geometry on its way from the server: one worker fetches, the page gets buffers as they come.

import type { Vec3 } from "./scene/vectors";

/** What `GET /scene` says of the mock-up. Lengths in metres; `unit` is what the files were drawn in. */
export interface Manifest {
  hash: string;
  name: string;
  unit: string;
  up: "x" | "y" | "z";
  middle: Vec3;
  lower: Vec3;
  upper: Vec3;
  triangles: number;
  vertices: number;
  part_bytes: 2 | 4;
  parts: { paths: string[]; triangles: number[]; lower: Vec3[]; upper: Vec3[]; small: number[] };
  pieces: PieceManifest[];
}

export interface PieceManifest {
  triangles: number;
  vertices: number;
  /** The packed index of its first triangle. */
  first: number;
  bytes: number;
  lower: Vec3;
  upper: Vec3;
  small: boolean;
  parts: number;
}

/** The held mesh: its pieces one behind the other in one buffer, positions in the hand's frame less `middle`. */
export interface HeldManifest {
  middle: Vec3;
  lower: Vec3;
  upper: Vec3;
  triangles: number;
  part_bytes: 2 | 4;
  pieces: { triangles: number; vertices: number; first: number; bytes: number }[];
}

/** What the worker says. */
export type GeometryMessage =
  | { kind: "manifest"; load: number; manifest: Manifest }
  | { kind: "piece"; load: number; k: number; data: ArrayBuffer }
  | { kind: "done"; load: number }
  | { kind: "held"; load: number; data: ArrayBuffer }
  | { kind: "failed"; load: number; what: string };

/** What the page asks the worker for. A new load ends the one before. */
export type GeometryWish =
  | { kind: "scene"; load: number; base: string; token: string }
  | { kind: "held"; load: number; base: string; token: string; version: number }
  | { kind: "abort"; load: number };

export interface GeometryListener {
  onManifest(manifest: Manifest): void;
  /** Pieces come in order; `share` is how much of the bytes has come, 0 to 1. */
  onPiece(k: number, data: ArrayBuffer, share: number): void;
  onDone(): void;
  onFailed(what: string): void;
}
