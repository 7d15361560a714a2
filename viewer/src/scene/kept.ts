// The kept layer: the mock-up drawn once into colour, part id and depth, and kept while nothing of it changes.
//
// Raw: colour (premultiplied), id (part + 1, 0 for nothing, the highest bit for the fill of a section) and depth. Shown:
// the raw picture with its edges, over the background; averaged with redraws a fraction of a pixel aside while the camera rests.

import {
  CustomBlending,
  DepthFormat,
  DepthTexture,
  DoubleSide,
  FloatType,
  GLSL3,
  LinearFilter,
  NearestFilter,
  NormalBlending,
  OneFactor,
  OneMinusSrcAlphaFactor,
  RawShaderMaterial,
  RedIntegerFormat,
  RGBAFormat,
  Scene,
  type Texture,
  UnsignedByteType,
  UnsignedIntType,
  Vector2,
  Vector3,
  type WebGLRenderer,
  WebGLRenderTarget,
} from "three";
import type { Piece } from "./chunks";
import type { Eye } from "./eye";
import { define, ScreenPass } from "./screen";
import { pieceFragment, pieceVertex, resolveFragment } from "./shaders";
import type { Colours } from "./theme";
import type { SharedUniforms } from "./uniforms";

/** Where in the pixel the redraws are taken; the first is the middle. */
export const JITTER: readonly [number, number][] = [
  [0, 0],
  [0.25, -0.375],
  [-0.375, -0.125],
  [0.125, 0.375],
  [-0.125, -0.4375],
  [0.4375, 0.0625],
  [-0.25, 0.25],
  [-0.4375, 0.4375],
];

function rawTarget(width: number, height: number): WebGLRenderTarget {
  const target = new WebGLRenderTarget(width, height, {
    count: 2,
    minFilter: NearestFilter,
    magFilter: NearestFilter,
    generateMipmaps: false,
    depthTexture: new DepthTexture(
      width,
      height,
      FloatType,
      undefined,
      undefined,
      undefined,
      NearestFilter,
      NearestFilter,
      undefined,
      DepthFormat,
    ),
  });
  const [colour, id] = target.textures as [Texture, Texture];
  colour.format = RGBAFormat;
  colour.type = UnsignedByteType;
  id.format = RedIntegerFormat;
  id.type = UnsignedIntType;
  id.internalFormat = "R32UI";
  return target;
}

/** The programs of the pieces: surfaces and ghosts. */
export class PieceMaterials {
  readonly solid: RawShaderMaterial;
  readonly ghost: RawShaderMaterial;

  constructor(uniforms: SharedUniforms) {
    const shared = {
      glslVersion: GLSL3,
      vertexShader: pieceVertex,
      fragmentShader: pieceFragment,
      uniforms,
      side: DoubleSide,
    };
    this.solid = new RawShaderMaterial({ ...shared, defines: { SECTIONS: 0 } });
    this.ghost = new RawShaderMaterial({
      ...shared,
      defines: { SECTIONS: 0, GHOST: 1 },
      depthWrite: false,
      transparent: true,
      blending: CustomBlending,
      blendSrc: OneFactor,
      blendDst: OneMinusSrcAlphaFactor,
    });
  }

  setSections(count: number): void {
    define(this.solid, "SECTIONS", count);
    define(this.ghost, "SECTIONS", count);
  }

  dispose(): void {
    this.solid.dispose();
    this.ghost.dispose();
  }
}

export class Kept {
  isWhole = false;
  /** How many redraws are averaged; 0 before the first. */
  samples = 0;
  /** How many redraws are to be averaged. */
  wanted = JITTER.length;
  /** The share of the resolution that is drawn. */
  scale = 1;
  /** Triangles drawn of the mock-up since `begin`. */
  triangles = 0;
  readonly #renderer: WebGLRenderer;
  readonly #uniforms: SharedUniforms;
  readonly #materials: PieceMaterials;
  readonly #resolve: ScreenPass;
  readonly #scene = new Scene();
  #raw: WebGLRenderTarget;
  #aside: WebGLRenderTarget | null = null;
  #shown: WebGLRenderTarget;
  #drawn: Piece[] = [];
  #missing: Piece[] = [];
  #ghosts: Piece[] = [];
  // The rest of the current offset redraw, null if there is none.
  #refining: Piece[] | null = null;

  constructor(renderer: WebGLRenderer, uniforms: SharedUniforms, materials: PieceMaterials) {
    this.#renderer = renderer;
    this.#uniforms = uniforms;
    this.#materials = materials;
    this.#scene.matrixWorldAutoUpdate = false;
    this.#raw = rawTarget(1, 1);
    this.#shown = shownTarget(1, 1);
    this.#resolve = new ScreenPass(
      resolveFragment,
      {
        rawColour: { value: null },
        rawId: { value: null },
        rawDepth: { value: null },
        depthLine: uniforms.depthLine,
        drawn: { value: new Vector2() },
        focal: { value: 1 },
        parallel: uniforms.parallel,
        share: { value: 1 },
        above: { value: new Vector3() },
        below: { value: new Vector3() },
        line: { value: new Vector3() },
      },
      { transparent: true, blending: NormalBlending },
    );
  }

  /** The kept picture; at a lower resolution, its lower left part. */
  get picture(): WebGLRenderTarget {
    return this.#shown;
  }

  get width(): number {
    return this.#raw.width;
  }

  get height(): number {
    return this.#raw.height;
  }

  get isRefined(): boolean {
    return this.isWhole && this.samples >= this.wanted;
  }

  setSize(width: number, height: number): void {
    if (width === this.width && height === this.height) return;
    this.#disposeTargets();
    this.#raw = rawTarget(width, height);
    this.#shown = shownTarget(width, height);
    this.forget();
  }

  setColours(colours: Colours): void {
    const uniforms = this.#resolve.material.uniforms;
    for (const [name, value] of Object.entries(colours)) (uniforms[name] as { value: Vector3 }).value.copy(value);
  }

  /** Forgets the kept layer: the next frame begins anew. */
  forget(): void {
    this.isWhole = false;
    this.samples = 0;
    this.#drawn = [];
    this.#missing = [];
    this.#refining = null;
  }

  /** Begins a new picture: `solid` pieces in their order, then `ghosts`, at `scale` of the resolution. */
  begin(solid: Piece[], ghosts: Piece[], scale: number): void {
    this.forget();
    this.scale = scale;
    this.triangles = 0;
    this.#missing = [...solid];
    this.#ghosts = ghosts;
    this.#setViewport(this.#raw);
    this.#setViewport(this.#shown);
    this.#clear(this.#raw);
  }

  /** Makes this the layer that other programs look at, from a picture `width` pixels wide. */
  bind(width: number): void {
    const uniforms = this.#uniforms;
    uniforms.keptDepth.value = this.#raw.depthTexture;
    uniforms.keptId.value = this.#raw.textures[1] as Texture;
    const scale = (this.width * this.scale) / width;
    uniforms.keptScale.value.set(scale, scale);
    uniforms.hasKept.value = true;
  }

  /** Takes a piece that came after `begin`. False: it cannot be added to the picture, begin anew. */
  append(piece: Piece): boolean {
    if (this.#ghosts.length > 0) return false;
    this.#missing.push(piece);
    this.isWhole = false;
    this.samples = 0;
    this.#refining = null;
    return true;
  }

  /** Whether the rest can be drawn into this picture: it has the full resolution, and no ghosts over it. */
  get isContinuable(): boolean {
    return this.scale === 1 && (this.#ghosts.length === 0 || this.#drawn.length === 0);
  }

  /** Draws missing pieces, at most `budget` triangles but at least a piece, and resolves. Returns the triangles drawn. */
  draw(eye: Eye, budget: number): number {
    const batch = take(this.#missing, budget);
    const before = this.triangles;
    this.#drawPieces(eye, this.#raw, batch);
    this.#drawn.push(...batch);
    this.isWhole = this.#missing.length === 0;
    this.#drawGhosts(eye, this.#raw, this.isWhole ? Infinity : budget);
    this.samples = 1;
    define(this.#resolve.material, "CREASES", this.scale === 1 ? 1 : null);
    this.#drawResolved(this.#raw, 1);
    return this.triangles - before;
  }

  /** A part of a redraw aside, at most `budget` triangles but at least a piece. True once a redraw was averaged in. */
  refine(eye: Eye, budget: number): boolean {
    const [x, y] = JITTER[this.samples] as [number, number];
    const [width, height] = [this.width, this.height];
    eye.setViewOffset(width, height, x, y, width, height);
    if (!this.#aside) this.#aside = rawTarget(width, height);
    if (!this.#refining) {
      this.#refining = [...this.#drawn];
      this.#clear(this.#aside);
    }
    this.#drawPieces(eye, this.#aside, take(this.#refining, budget));
    const isDone = this.#refining.length === 0;
    if (isDone) {
      this.#drawGhosts(eye, this.#aside, Infinity);
      this.#refining = null;
      this.samples++;
      this.#drawResolved(this.#aside, 1 / this.samples);
    }
    eye.clearViewOffset();
    return isDone;
  }

  dispose(): void {
    this.#disposeTargets();
    this.#resolve.dispose();
  }

  #disposeTargets(): void {
    for (const target of [this.#raw, this.#shown, this.#aside]) {
      target?.depthTexture?.dispose();
      target?.dispose();
    }
    this.#aside = null;
  }

  #setViewport(target: WebGLRenderTarget): void {
    target.viewport.set(0, 0, Math.round(this.width * this.scale), Math.round(this.height * this.scale));
  }

  #clear(target: WebGLRenderTarget): void {
    const renderer = this.#renderer;
    const gl = renderer.getContext() as WebGL2RenderingContext;
    renderer.setRenderTarget(target);
    renderer.state.buffers.color.setMask(true);
    renderer.state.buffers.depth.setMask(true);
    gl.clearBufferfv(gl.COLOR, 0, [0, 0, 0, 0]);
    // An integer target has a clear of its own; `clear` leaves it undefined.
    gl.clearBufferuiv(gl.COLOR, 1, [0, 0, 0, 0]);
    gl.clearBufferfv(gl.DEPTH, 0, [renderer.capabilities.reversedDepthBuffer ? 0 : 1]);
  }

  #drawPieces(eye: Eye, target: WebGLRenderTarget, pieces: Piece[]): void {
    if (pieces.length === 0) return;
    const renderer = this.#renderer;
    // An array, not add(): three would look for each mesh in the list of its siblings.
    this.#scene.children = pieces.map((piece) => piece.mesh);
    renderer.setRenderTarget(target);
    renderer.render(this.#scene, eye);
    for (const piece of pieces) this.triangles += piece.triangles;
  }

  #drawGhosts(eye: Eye, target: WebGLRenderTarget, budget: number): void {
    const ghosts = take([...this.#ghosts], budget);
    if (ghosts.length === 0) return;
    const renderer = this.#renderer;
    const gl = renderer.getContext() as WebGL2RenderingContext;
    renderer.setRenderTarget(target);
    // The ids stay those of the surfaces behind: integer targets do not blend.
    gl.drawBuffers([gl.COLOR_ATTACHMENT0, gl.NONE]);
    this.#scene.overrideMaterial = this.#materials.ghost;
    this.#drawPieces(eye, target, ghosts);
    this.#scene.overrideMaterial = null;
    gl.drawBuffers([gl.COLOR_ATTACHMENT0, gl.COLOR_ATTACHMENT1]);
  }

  #drawResolved(raw: WebGLRenderTarget, share: number): void {
    const uniforms = this.#resolve.material.uniforms as Record<string, { value: unknown }>;
    const set = (name: string, value: unknown) => {
      (uniforms[name] as { value: unknown }).value = value;
    };
    set("rawColour", raw.textures[0]);
    set("rawId", raw.textures[1]);
    set("rawDepth", raw.depthTexture);
    set("share", share);
    (uniforms.drawn as { value: Vector2 }).value.set(this.#shown.viewport.z, this.#shown.viewport.w);
    set("focal", 1 / (this.#uniforms.rayOf.value.x / this.scale));
    this.#resolve.draw(this.#renderer, this.#shown);
  }
}

export function shownTarget(width: number, height: number): WebGLRenderTarget {
  return new WebGLRenderTarget(width, height, {
    minFilter: LinearFilter,
    magFilter: LinearFilter,
    generateMipmaps: false,
    depthBuffer: false,
  });
}

/** Takes pieces from the front of `pieces` while they fit in `budget` triangles, at least one. */
export function take(pieces: Piece[], budget: number): Piece[] {
  let count = 0;
  let triangles = 0;
  while (count < pieces.length) {
    triangles += (pieces[count] as Piece).triangles;
    if (count > 0 && triangles > budget) break;
    count++;
  }
  return pieces.splice(0, count);
}
