// The mesh in the hand: solid at the engine's pose, a ghost at the wished one.

import { DoubleSide, GLSL3, Group, Matrix4, type Mesh, NormalBlending, RawShaderMaterial, Scene } from "three";
import type { HeldManifest } from "../link/protocol";
import type { FieldMesh } from "../math/heat-field";
import { isSame } from "../math/same";
import { type Box, corners, emptyBox, include, subtract, transform, type Vec3 } from "../math/vectors";
import { geometryOf, type PieceArrays, readPiece, standingMesh, writeCorners } from "./chunks";
import { define } from "./screen";
import { heldFragment, heldVertex } from "./shaders";
import type { SharedUniforms } from "./uniforms";

interface HeldPiece {
  first: number;
  triangles: number;
  arrays: PieceArrays;
}

const IDENTITY = [1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1];
// A wish nearer to the pose than this in each number is the pose: metres, or shares of a unit vector.
const SAME_POSE = 1e-6;

export class Held {
  readonly scene = new Scene();
  readonly ghostScene = new Scene();
  readonly probeMaterial: RawShaderMaterial;
  readonly #solid = new Group();
  readonly #ghost = new Group();
  readonly #solidMaterial: RawShaderMaterial;
  readonly #ghostMaterial: RawShaderMaterial;
  #pieces: HeldPiece[] = [];
  #meshes: Mesh[] = [];
  #manifest: HeldManifest | null = null;
  #middle: Vec3 = [0, 0, 0];
  #pose: number[] = IDENTITY;
  #wish: number[] | null = null;

  constructor(uniforms: SharedUniforms) {
    const shared = {
      glslVersion: GLSL3,
      vertexShader: heldVertex,
      fragmentShader: heldFragment,
      uniforms,
      side: DoubleSide,
    };
    this.#solidMaterial = new RawShaderMaterial({ ...shared, defines: { SECTIONS: 0 } });
    this.probeMaterial = new RawShaderMaterial({ ...shared, defines: { SECTIONS: 0, PROBE: 1 } });
    this.#ghostMaterial = new RawShaderMaterial({
      ...shared,
      defines: { SECTIONS: 0, GHOST: 1 },
      depthWrite: false,
      transparent: true,
      blending: NormalBlending,
    });
    for (const group of [this.#solid, this.#ghost]) group.matrixAutoUpdate = false;
    this.scene.add(this.#solid);
    this.ghostScene.add(this.#ghost);
  }

  get isEmpty(): boolean {
    return this.#pieces.length === 0;
  }

  /** The pose of the solid, row by row. */
  get pose(): readonly number[] {
    return this.#pose;
  }

  /** Whether the wish is drawn: the hand is not empty, and the wish differs from its pose. */
  get isGhostShown(): boolean {
    const wish = this.#wish;
    return (
      wish !== null && !this.isEmpty && wish.some((value, k) => Math.abs(value - (this.#pose[k] as number)) > SAME_POSE)
    );
  }

  get triangles(): number {
    return this.#manifest?.triangles ?? 0;
  }

  /** Where the scene's origin lies, world metres. */
  setOrigin(middle: Vec3): void {
    this.#middle = middle;
    this.#placeBoth();
  }

  set(held: { piece: ArrayBuffer; manifest: HeldManifest } | null): void {
    for (const mesh of this.#meshes) mesh.geometry.dispose();
    this.#solid.clear();
    this.#ghost.clear();
    this.#meshes = [];
    this.#pieces = [];
    this.#manifest = held?.manifest ?? null;
    if (held) {
      let offset = 0;
      for (const said of held.manifest.pieces) {
        const arrays = readPiece(held.piece, said, held.manifest.part_bytes, offset);
        offset += said.bytes;
        this.#pieces.push({ first: said.first, triangles: said.triangles, arrays });
        const mesh = standingMesh(geometryOf(arrays), this.#solidMaterial);
        this.#meshes.push(mesh);
        this.#solid.add(mesh);
        this.#ghost.add(standingMesh(mesh.geometry, this.#ghostMaterial));
      }
    }
    this.#placeBoth();
  }

  /** world_from_tool, row by row, of the solid and of the wish (null: none). Returns whether either is new. */
  setPose(pose: ArrayLike<number>, wish: ArrayLike<number> | null): boolean {
    const [next, nextWish] = [Array.from(pose), wish ? Array.from(wish) : null];
    if (isSame([next, nextWish], [this.#pose, this.#wish])) return false;
    this.#pose = next;
    this.#wish = nextWish;
    this.#placeBoth();
    return true;
  }

  /** The meshes for the heat map's field, and their box, in the frame of the pieces; null for an empty hand. */
  fieldMesh(): { pieces: FieldMesh[]; lower: Vec3; upper: Vec3 } | null {
    return this.#manifest && { pieces: this.#pieces.map(({ arrays }) => arrays), ...this.pieceBox() };
  }

  /** The box of the mesh in the frame of the pieces; empty for an empty hand. */
  pieceBox(): Box {
    const manifest = this.#manifest;
    if (!manifest) return emptyBox();
    const { lower, middle, upper } = manifest;
    return { lower: subtract(lower, middle), upper: subtract(upper, middle) };
  }

  /** The corners of the mesh's box at a pose, world metres; none for an empty hand. */
  boxCorners(pose: ArrayLike<number>): Vec3[] {
    return this.#manifest ? corners(this.#manifest).map((corner) => transform(pose, corner)) : [];
  }

  /** The box of the solid, world metres. */
  box(): Box {
    const box = emptyBox();
    const manifest = this.#manifest;
    if (manifest) for (const corner of corners(manifest)) include(box, transform(this.#pose, corner));
    return box;
  }

  /** Corners of the packed triangles in the frame of the pieces, 9 numbers each. */
  corners(packed: Uint32Array): Float32Array {
    const found = new Float32Array(9 * packed.length);
    let at = 0;
    for (const triangle of packed) {
      const piece = this.#pieces.find((p) => triangle >= p.first && triangle < p.first + p.triangles);
      if (!piece) continue;
      writeCorners(piece.arrays, 3 * (triangle - piece.first), found, at);
      at += 9;
    }
    return found.subarray(0, at);
  }

  /** world_from_piece less the scene's middle: where `corners` belong. */
  get matrix(): Matrix4 {
    return this.#solid.matrix;
  }

  setSections(count: number): void {
    for (const material of [this.#solidMaterial, this.#ghostMaterial, this.probeMaterial])
      define(material, "SECTIONS", count);
  }

  dispose(): void {
    this.set(null);
    for (const material of [this.#solidMaterial, this.#ghostMaterial, this.probeMaterial]) material.dispose();
  }

  #placeBoth(): void {
    this.#place(this.#solid, this.#pose);
    if (this.#wish) this.#place(this.#ghost, this.#wish);
  }

  #place(group: Group, pose: number[]): void {
    group.matrix.fromArray(pose).transpose();
    const [x, y, z] = this.#middle;
    group.matrix.premultiply(new Matrix4().makeTranslation(-x, -y, -z));
    const own = this.#manifest?.middle;
    if (own) group.matrix.multiply(new Matrix4().makeTranslation(own[0], own[1], own[2]));
    group.matrixWorldNeedsUpdate = true;
  }
}
