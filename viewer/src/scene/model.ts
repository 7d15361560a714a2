// The drawn mock-up: its pieces, the states and places of its parts, the planes that cut it.

import type { Material } from "three";
import type { Manifest } from "../link/protocol";
import { type Box, emptyBox, include, isEmpty, type Vec3 } from "../math/vectors";
import { eyePlanes } from "./aim";
import { type Piece, Pieces } from "./chunks";
import { isCutAway, mayBeSeen } from "./culling";
import type { Eye } from "./eye";
import { PartTable } from "./parts";
import { clipBox, type SectionPlane } from "./sections";
import type { SharedUniforms } from "./uniforms";

export class Model {
  /** Of the mock-up that was shown last: it may come again after a reconnect. */
  hash: string | null = null;
  /** Where the scene's origin lies, world metres. */
  middle: Vec3 = [0, 0, 0];
  /** All of it, wherever parts were moved. */
  bounds: Box = emptyBox();
  /** The cuts, and behind them the faces of the section box. */
  sections: SectionPlane[] = [];
  section_box: Box | null = null;
  #pieces: Pieces | null = null;
  #table: PartTable | null = null;
  #shapeVersion = 0;

  constructor(readonly uniforms: SharedUniforms) {}

  /** The states and places of the parts; null without a mock-up. */
  get table(): PartTable | null {
    return this.#table;
  }

  /** Triangles of the pieces that came. */
  get triangles(): number {
    return this.#pieces?.all.reduce((sum, piece) => sum + piece.triangles, 0) ?? 0;
  }

  /** Begins a mock-up in place of the one before; its pieces are drawn with `material`. */
  begin(manifest: Manifest, material: Material): void {
    this.clear();
    this.hash = manifest.hash;
    this.middle = manifest.middle;
    this.bounds = { lower: manifest.lower, upper: manifest.upper };
    const { lower, upper } = manifest.parts;
    const boxes = lower.map((corner, part) => ({ lower: corner, upper: upper[part] as Vec3 }));
    this.#table = new PartTable(boxes, manifest.middle, manifest.parts.colours);
    this.#pieces = new Pieces(manifest, material);
    this.#shapeVersion = this.#table.shapeVersion;
  }

  clear(): void {
    this.#pieces?.dispose();
    this.#table?.dispose();
    this.#pieces = null;
    this.#table = null;
    this.bounds = emptyBox();
  }

  /** Takes piece `k`. Throws RangeError for one that does not fit. */
  add(k: number, data: ArrayBuffer): Piece {
    if (!this.#pieces) throw new RangeError("A piece came before its manifest: load again.");
    return this.#pieces.add(k, data);
  }

  /** Whether shapes are to be drawn anew since the last call. */
  takeShapes(): boolean {
    const version = this.#table?.shapeVersion ?? this.#shapeVersion;
    const isNew = version !== this.#shapeVersion;
    this.#shapeVersion = version;
    return isNew;
  }

  /** Whether some part of the piece is a ghost. */
  hasGhost(piece: Piece): boolean {
    return piece.partIds.some((part) => this.#table?.isGhost(part));
  }

  /** Whether some of the piece may be in the picture of `eye`. */
  isSeen(piece: Piece, eye: Eye): boolean {
    return this.#isWithin(piece, eyePlanes(eye, this.middle));
  }

  /** The pieces with surfaces and with ghosts, in their order: all, or those that may be in the picture of `eye`. */
  pieces(eye: Eye | null): { solid: Piece[]; ghosts: Piece[] } {
    const table = this.#table;
    if (!this.#pieces || !table) return { solid: [], ghosts: [] };
    this.uniforms.states.value = table.statesTexture;
    this.uniforms.places.value = table.placesTexture;
    this.uniforms.colours.value = table.coloursTexture;
    const planes = eye && eyePlanes(eye, this.middle);
    const { all } = this.#pieces;
    const seen = planes ? all.filter((piece) => this.#isWithin(piece, planes)) : all;
    return {
      solid: seen.filter((piece) => piece.partIds.some((part) => table.isSolid(part))),
      ghosts: seen.filter((piece) => this.hasGhost(piece)),
    };
  }

  /** The box of all visible geometry, without hidden and cut-away parts: of surfaces, else of ghosts. */
  visibleBox(): Box {
    const box = emptyBox();
    const table = this.#table;
    const take = (isWanted: (part: number) => boolean) => {
      for (let part = 0; table && part < table.count; part++) {
        if (!isWanted(part)) continue;
        const seen = clipBox(table.boxOf(part), this.sections);
        if (isEmpty(seen)) continue;
        include(box, seen.lower);
        include(box, seen.upper);
      }
    };
    take((part) => table?.isSolid(part) === true);
    if (isEmpty(box)) take((part) => table?.isGhost(part) === true);
    return box;
  }

  /** The box of `part` at its present place; empty for an unknown part. */
  partBox(part: number): Box {
    return this.#table && part < this.#table.count ? this.#table.boxOf(part) : emptyBox();
  }

  /** The corners of packed triangles at their present places, less the middle; without those of hidden parts. */
  corners(packed: Uint32Array): Float32Array {
    return this.#pieces && this.#table ? this.#pieces.corners(packed, this.#table) : new Float32Array(0);
  }

  /** A piece of parts that were moved may be anywhere. */
  #isWithin(piece: Piece, planes: Float64Array): boolean {
    if (piece.partIds.some((part) => this.#table?.isPlaced(part))) return true;
    return mayBeSeen(piece.box, planes) && !isCutAway(piece.box, this.sections);
  }
}
