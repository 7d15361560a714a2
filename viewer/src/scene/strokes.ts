// Lines of a width in pixels and discs in space, each many in one draw call.

import {
  DoubleSide,
  DynamicDrawUsage,
  Float32BufferAttribute,
  GLSL3,
  InstancedBufferAttribute,
  InstancedBufferGeometry,
  type IUniform,
  Mesh,
  NormalBlending,
  RawShaderMaterial,
} from "three";
import { subtract, type Vec3 } from "../math/vectors";
import { define } from "./screen";
import { discFragment, discVertex, lineFragment, lineVertex } from "./shaders";

/** Red, green, blue and cover, 0 to 1. */
export type Tint = readonly [number, number, number, number];

/** A list of instances, `stride` floats each, with room that grows. */
class Instances {
  data = new Float32Array(0);
  count = 0;

  constructor(readonly stride: number) {}

  push(...values: number[]): void {
    const at = this.count * this.stride;
    if (at + this.stride > this.data.length) {
      const grown = new Float32Array(Math.max(64 * this.stride, 2 * this.data.length));
      grown.set(this.data);
      this.data = grown;
    }
    this.data.set(values, at);
    this.count++;
  }
}

/** Instances of a quad (-1 to 1), with attributes of their own. */
class Batch {
  readonly mesh: Mesh<InstancedBufferGeometry, RawShaderMaterial>;
  readonly instances: Instances;
  readonly #layout: readonly [string, number][];
  #room = 0;

  constructor(layout: readonly [string, number][], material: RawShaderMaterial) {
    this.#layout = layout;
    this.instances = new Instances(layout.reduce((sum, [, size]) => sum + size, 0));
    this.mesh = new Mesh(quad(), material);
    this.mesh.frustumCulled = false;
    this.mesh.matrixAutoUpdate = false;
    this.mesh.visible = false;
  }

  /** Uploads the pushed strokes to the device's buffers. */
  commit(): void {
    const { data, count } = this.instances;
    this.mesh.visible = count > 0;
    if (count === 0) return;
    if (this.#room < count) {
      // An attribute cannot grow: a new geometry with room to spare.
      this.mesh.geometry.dispose();
      this.mesh.geometry = quad();
      this.#room = Math.max(64, 2 * count);
      for (const [name, size] of this.#layout) {
        const attribute = new InstancedBufferAttribute(new Float32Array(size * this.#room), size);
        attribute.setUsage(DynamicDrawUsage);
        this.mesh.geometry.setAttribute(name, attribute);
      }
    }
    let offset = 0;
    for (const [name, size] of this.#layout) {
      const attribute = this.mesh.geometry.getAttribute(name) as InstancedBufferAttribute;
      for (let k = 0; k < count; k++) {
        for (let j = 0; j < size; j++)
          attribute.array[k * size + j] = data[k * this.instances.stride + offset + j] as number;
      }
      attribute.clearUpdateRanges();
      attribute.addUpdateRange(0, count * size);
      attribute.needsUpdate = true;
      offset += size;
    }
    this.mesh.geometry.instanceCount = count;
  }

  dispose(): void {
    this.mesh.geometry.dispose();
    this.mesh.material.dispose();
  }
}

function quad(): InstancedBufferGeometry {
  const geometry = new InstancedBufferGeometry();
  geometry.setAttribute("position", new Float32BufferAttribute([-1, -1, 0, 1, -1, 0, 1, 1, 0, -1, 1, 0], 3));
  geometry.setIndex([0, 1, 2, 0, 2, 3]);
  return geometry;
}

function strokeMaterial(
  vertexShader: string,
  fragmentShader: string,
  uniforms: Record<string, IUniform>,
  behind: number,
) {
  return new RawShaderMaterial({
    glslVersion: GLSL3,
    vertexShader,
    fragmentShader,
    uniforms: { ...uniforms, behind: { value: behind } },
    defines: { SECTIONS: 0 },
    depthTest: false,
    depthWrite: false,
    transparent: true,
    blending: NormalBlending,
    side: DoubleSide,
  });
}

/** Segments with round ends; `behind` is how much is left of one that the mock-up hides. */
export class Lines {
  readonly #batch: Batch;
  readonly #middle: Vec3;

  constructor(uniforms: Record<string, IUniform>, middle: Vec3, behind: number) {
    this.#middle = middle;
    const layout: [string, number][] = [
      ["from", 3],
      ["to", 3],
      ["tint", 4],
      ["widths", 2],
    ];
    this.#batch = new Batch(layout, strokeMaterial(lineVertex, lineFragment, uniforms, behind));
  }

  get mesh(): Mesh {
    return this.#batch.mesh;
  }

  get count(): number {
    return this.#batch.instances.count;
  }

  clear(): void {
    this.#batch.instances.count = 0;
  }

  /** A segment between two world points, `width` CSS pixels wide at its start and `toWidth` at its end. */
  add(from: Vec3, to: Vec3, tint: Tint, width: number, toWidth = width): void {
    this.#batch.instances.push(...subtract(from, this.#middle), ...subtract(to, this.#middle), ...tint, width, toWidth);
  }

  /** An arrow whose head is `head` metres long. */
  addArrow(from: Vec3, to: Vec3, head: number, tint: Tint, width: number): void {
    const along = subtract(to, from);
    const size = Math.hypot(...along);
    if (size === 0) return;
    const share = Math.max(0, 1 - head / size);
    const neck: Vec3 = [from[0] + along[0] * share, from[1] + along[1] * share, from[2] + along[2] * share];
    this.add(from, neck, tint, width);
    this.add(neck, to, tint, 4.5 * width, 0);
  }

  commit(): void {
    this.#batch.commit();
  }

  setSections(count: number): void {
    define(this.#batch.mesh.material, "SECTIONS", count);
  }

  dispose(): void {
    this.#batch.dispose();
  }
}

/** Discs in space, with a rim; `hole` is the share of the radius that is empty. */
export class Discs {
  readonly #batch: Batch;
  readonly #middle: Vec3;

  constructor(uniforms: Record<string, IUniform>, middle: Vec3, behind: number) {
    this.#middle = middle;
    const layout: [string, number][] = [
      ["middle", 3],
      ["across", 3],
      ["up", 3],
      ["tint", 4],
      ["hole", 1],
    ];
    this.#batch = new Batch(layout, strokeMaterial(discVertex, discFragment, uniforms, behind));
  }

  get mesh(): Mesh {
    return this.#batch.mesh;
  }

  clear(): void {
    this.#batch.instances.count = 0;
  }

  /** A disc about the world point `at`; `across` and `up` are its radii. */
  add(at: Vec3, across: Vec3, up: Vec3, tint: Tint, hole: number): void {
    this.#batch.instances.push(...subtract(at, this.#middle), ...across, ...up, ...tint, hole);
  }

  commit(): void {
    this.#batch.commit();
  }

  setSections(count: number): void {
    define(this.#batch.mesh.material, "SECTIONS", count);
  }

  dispose(): void {
    this.#batch.dispose();
  }
}
