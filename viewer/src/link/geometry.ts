// Fetches the mock-up's geometry from the server: one worker fetches, the page gets buffers as they arrive.

import type { FieldMesh, HeatField } from "../math/heat-field";
import type { Vec3 } from "../math/vectors";
import type { Manifest } from "./protocol";

/** Messages of the worker. */
export type GeometryMessage =
  | { kind: "manifest"; load: number; manifest: Manifest }
  | { kind: "piece"; load: number; k: number; data: ArrayBuffer }
  | { kind: "done"; load: number }
  | { kind: "held"; load: number; data: ArrayBuffer }
  | { kind: "field"; load: number; field: HeatField }
  | { kind: "failed"; load: number; what: string };

/** The page's requests to the worker. A new load ends the one before. */
export type GeometryWish =
  | { kind: "scene"; load: number; base: string; token: string }
  | { kind: "held"; load: number; base: string; token: string; version: number }
  /** Work for which the page would stand still. */
  | { kind: "field"; load: number; pieces: readonly FieldMesh[]; lower: Vec3; upper: Vec3 }
  /** The first piece is drawn. */
  | { kind: "go_on"; load: number }
  | { kind: "abort"; load: number };

export interface GeometryListener {
  onManifest(manifest: Manifest): void;
  /** Pieces come in order; `share` is how much of the bytes has come, 0 to 1. */
  onPiece(k: number, data: ArrayBuffer, share: number): void;
  onDone(): void;
  /** `what` says what went wrong and what to do. Nothing comes after it. */
  onFailed(what: string): void;
}

/** The page's side of the worker. `base` is the server's address with a slash at its end. */
export class Geometry {
  readonly #worker: Worker;
  readonly #base: string;
  readonly #token: string;
  readonly #held = new Map<number, { resolve: (data: ArrayBuffer) => void; reject: (error: Error) => void }>();
  readonly #fields = new Map<number, (field: HeatField) => void>();
  #loads = 0;
  #scene: { load: number; listener: GeometryListener; bytes: number; come: number; isFirstDrawn: boolean } | null =
    null;

  constructor(base: string, token: string, script = "geometry.js") {
    this.#base = base;
    this.#token = token;
    this.#worker = new Worker(script, { type: "module" });
    this.#worker.onmessage = ({ data }: MessageEvent<GeometryMessage>) => this.#take(data);
    this.#worker.onerror = (event) => {
      this.#fail(`The worker that loads the geometry failed (${event.message}): reload the page.`);
    };
  }

  /** Loads the mock-up; one that is still being loaded is given up. */
  load(listener: GeometryListener): void {
    this.abort();
    this.#loads++;
    this.#scene = { load: this.#loads, listener, bytes: 0, come: 0, isFirstDrawn: false };
    this.#send({ kind: "scene", load: this.#loads, base: this.#base, token: this.#token });
  }

  /** Loads the hand's load. Rejects with the error. */
  loadHeld(version: number): Promise<ArrayBuffer> {
    this.#loads++;
    const load = this.#loads;
    this.#send({ kind: "held", load, base: this.#base, token: this.#token, version });
    return new Promise((resolve, reject) => this.#held.set(load, { resolve, reject }));
  }

  /** The field of a mesh, as `heatField` makes it; never, if the worker fails. */
  fieldOf(pieces: readonly FieldMesh[], lower: Vec3, upper: Vec3): Promise<HeatField> {
    this.#loads++;
    const load = this.#loads;
    const own = pieces.map(({ positions, indices }) => ({ positions, indices }));
    this.#send({ kind: "field", load, pieces: own, lower, upper });
    return new Promise((resolve) => this.#fields.set(load, resolve));
  }

  /** The first piece is drawn: the others, which would have kept the machine from that, are fetched. */
  firstDrawn(): void {
    if (!this.#scene || this.#scene.isFirstDrawn) return;
    this.#scene.isFirstDrawn = true;
    this.#send({ kind: "go_on", load: this.#scene.load });
  }

  /** Gives up the mock-up that is being loaded: its listener hears no more. */
  abort(): void {
    if (this.#scene) this.#send({ kind: "abort", load: this.#scene.load });
    this.#scene = null;
  }

  dispose(): void {
    this.abort();
    this.#worker.terminate();
  }

  #send(wish: GeometryWish): void {
    this.#worker.postMessage(wish);
  }

  #take(message: GeometryMessage): void {
    if (message.kind === "held") {
      this.#held.get(message.load)?.resolve(message.data);
      this.#held.delete(message.load);
      return;
    }
    if (message.kind === "field") {
      this.#fields.get(message.load)?.(message.field);
      this.#fields.delete(message.load);
      return;
    }
    if (message.kind === "failed" && this.#held.has(message.load)) {
      this.#held.get(message.load)?.reject(new Error(message.what));
      this.#held.delete(message.load);
      return;
    }
    const scene = this.#scene;
    // Data under way when a load was given up still arrives.
    if (!scene || scene.load !== message.load) return;
    switch (message.kind) {
      case "manifest":
        scene.bytes = message.manifest.pieces.reduce((sum, piece) => sum + piece.bytes, 0);
        scene.listener.onManifest(message.manifest);
        break;
      case "piece":
        scene.come += message.data.byteLength;
        scene.listener.onPiece(message.k, message.data, scene.bytes > 0 ? scene.come / scene.bytes : 1);
        break;
      case "done":
        this.#scene = null;
        scene.listener.onDone();
        break;
      case "failed":
        this.#scene = null;
        scene.listener.onFailed(message.what);
    }
  }

  #fail(what: string): void {
    const scene = this.#scene;
    this.#scene = null;
    scene?.listener.onFailed(what);
    for (const { reject } of this.#held.values()) reject(new Error(what));
    this.#held.clear();
  }
}
