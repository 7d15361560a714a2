// Drawing data of each part: one byte of state, its colour, and its place. All are textures.

import {
  DataTexture,
  FloatType,
  NearestFilter,
  RedIntegerFormat,
  RGBAFormat,
  type Texture,
  UnsignedByteType,
} from "three";
import { isSame } from "../math/same";
import {
  add,
  type Box,
  centre,
  corners,
  emptyBox,
  include,
  scale,
  subtract,
  transform,
  type Vec3,
} from "../math/vectors";
import { paletteTexture, tint, untint } from "./palette";

/** The bits of a part's state. `away`: in the hand, or taken out of the mock-up. `other`: two, as of `OTHERS`. */
export const PartState = { hidden: 1, ghost: 2, other: 132, hit: 8, selected: 16, away: 32 } as const;

/** The bits of a part that another person selected: the first, the second, the third. */
export const OTHERS = [4, 128, 132] as const;

const PLACED = 64;
const HIDES = PartState.hidden | PartState.away;
const LIT = PartState.hit | PartState.selected | PartState.other;
// State changes that need a redraw; the others only tint.
const SHAPE = HIDES | PartState.ghost;
// The widths that the shaders know.
const STATES_WIDTH = 1024;
const PLACES_WIDTH = 256;
// Fully exploded, a part lies this many times as far from the middle as it was.
const EXPLODED = 1.2;

function whole(data: Uint8Array | Float32Array, width: number, isStates: boolean): DataTexture {
  const height = data.length / (isStates ? width : 4 * width);
  const texture = isStates
    ? new DataTexture(data, width, height, RedIntegerFormat, UnsignedByteType)
    : new DataTexture(data, width, height, RGBAFormat, FloatType);
  texture.internalFormat = isStates ? "R8UI" : "RGBA32F";
  texture.minFilter = texture.magFilter = NearestFilter;
  texture.generateMipmaps = false;
  texture.unpackAlignment = 1;
  texture.needsUpdate = true;
  return texture;
}

export class PartTable {
  /** Version of the drawn shapes: grows with each change of hidden, ghost or moved parts. */
  shapeVersion = 0;
  isAnyLit = false;
  readonly coloursTexture: DataTexture;
  readonly #count: number;
  readonly #middle: Vec3;
  readonly #boxes: Box[];
  readonly #states: Uint8Array;
  readonly #statesTexture: DataTexture;
  #placesTexture: DataTexture;
  #places: Float32Array | null = null;
  #moved = new Map<number, number[]>();
  #explode = 0;
  #tinted = new Map<number, Uint8Array>();

  /**
   * `boxes`: of each part, world metres, where it was loaded. `middle`: where the scene's origin lies. `colours`: as of
   * the manifest.
   */
  constructor(boxes: Box[], middle: Vec3, colours: readonly unknown[] = []) {
    this.coloursTexture = paletteTexture(boxes.length, colours);
    this.#count = boxes.length;
    this.#boxes = boxes;
    this.#middle = middle;
    this.#states = new Uint8Array(Math.max(1, Math.ceil(boxes.length / STATES_WIDTH)) * STATES_WIDTH);
    this.#statesTexture = whole(this.#states, STATES_WIDTH, true);
    this.#placesTexture = whole(new Float32Array(12), 3, false);
  }

  get count(): number {
    return this.#count;
  }

  get statesTexture(): Texture {
    return this.#statesTexture;
  }

  get placesTexture(): Texture {
    return this.#placesTexture;
  }

  /** Takes a byte a part. Parts beyond its end keep their state. Returns whether any changed. */
  setStates(states: Uint8Array): boolean {
    const count = Math.min(this.#count, states.length);
    let changed = 0;
    for (let part = 0; part < count; part++) {
      const old = this.#states[part] as number;
      const next = ((states[part] as number) & (SHAPE | LIT)) | (old & PLACED);
      changed |= old ^ next;
      this.#states[part] = next;
    }
    if (changed === 0) return false;
    if ((changed & SHAPE) !== 0) this.shapeVersion++;
    this.isAnyLit = this.#states.some((state) => (state & LIT) !== 0);
    this.#statesTexture.needsUpdate = true;
    return true;
  }

  /** Draws some parts in other colours (0xRRGGBB), and all others in their own. Returns whether any changed. */
  setTints(tints: ReadonlyMap<number, number>): boolean {
    if (tints.size === 0 && this.#tinted.size === 0) return false;
    untint(this.coloursTexture, this.#tinted);
    this.#tinted = tint(this.coloursTexture, tints);
    this.shapeVersion++;
    return true;
  }

  /** Takes world_from_part, row by row, of each part that is not where it was loaded. Returns whether any changed. */
  setMoved(moved: Map<number, number[]>): boolean {
    if (isSame([...moved], [...this.#moved])) return false;
    this.#moved = structuredClone(moved);
    this.#place();
    return true;
  }

  /** Moves every part away from the middle, by `share` (0 to 1) of the largest distance. Returns whether that is new. */
  setExplode(share: number): boolean {
    if (share === this.#explode) return false;
    this.#explode = share;
    this.#place();
    return true;
  }

  isHidden(part: number): boolean {
    return ((this.#states[part] as number) & HIDES) !== 0;
  }

  /** Whether the part is drawn with a surface: neither hidden nor ghost. */
  isSolid(part: number): boolean {
    return ((this.#states[part] as number) & SHAPE) === 0;
  }

  isGhost(part: number): boolean {
    return ((this.#states[part] as number) & SHAPE) === PartState.ghost;
  }

  isPlaced(part: number): boolean {
    return ((this.#states[part] as number) & PLACED) !== 0;
  }

  /** Moves the points of `part` in `points` (3 numbers each, less the middle) from their loaded places to their present ones. */
  placePoints(part: number, points: Float32Array, from: number, to: number): void {
    if (!this.#places || !this.isPlaced(part)) return;
    const rows = this.#places.subarray(12 * part, 12 * part + 12);
    for (let k = from; k < to; k += 3) {
      const p = transform(rows, [points[k] as number, points[k + 1] as number, points[k + 2] as number]);
      points.set(p, k);
    }
  }

  /** The box of `part` at its present place, world metres. */
  boxOf(part: number): Box {
    const loaded = this.#boxes[part] ?? emptyBox();
    if (!this.#places || !this.isPlaced(part)) return loaded;
    const rows = this.#places.subarray(12 * part, 12 * part + 12);
    const box = emptyBox();
    for (const corner of corners(loaded))
      include(box, add(transform(rows, subtract(corner, this.#middle)), this.#middle));
    return box;
  }

  dispose(): void {
    this.#statesTexture.dispose();
    this.#placesTexture.dispose();
    this.coloursTexture.dispose();
  }

  #place(): void {
    const isExploded = this.#explode > 0;
    for (let part = 0; part < this.#count; part++) {
      const isPlaced = isExploded || this.#moved.has(part);
      this.#states[part] = ((this.#states[part] as number) & ~PLACED) | (isPlaced ? PLACED : 0);
    }
    this.#statesTexture.needsUpdate = true;
    this.shapeVersion++;
    if (!this.#places) {
      const texels = Math.ceil(this.#count / PLACES_WIDTH) * PLACES_WIDTH * 3;
      this.#places = new Float32Array(4 * texels);
      this.#placesTexture.dispose();
      this.#placesTexture = whole(this.#places, 3 * PLACES_WIDTH, false);
    }
    for (let part = 0; part < this.#count; part++) if (this.isPlaced(part)) this.#writePlace(part, this.#places);
    this.#placesTexture.needsUpdate = true;
  }

  /** The three rows of `part`, both sides less the middle: R (p + m) + t - m, and the step of the explosion. */
  #writePlace(part: number, places: Float32Array): void {
    const world = this.#moved.get(part) ?? [1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0];
    const home = this.#boxes[part] ?? emptyBox();
    const step = this.#explode > 0 ? scale(subtract(centre(home), this.#middle), EXPLODED * this.#explode) : [0, 0, 0];
    const origin = subtract(transform(world, this.#middle), this.#middle);
    for (let row = 0; row < 3; row++) {
      places.set(world.slice(4 * row, 4 * row + 3), 12 * part + 4 * row);
      places[12 * part + 4 * row + 3] = (origin[row] as number) + (step[row] as number);
    }
  }
}
