// Colliding triangles: filled and outlined, so that thin ones are visible as well.

import {
  BufferAttribute,
  BufferGeometry,
  DoubleSide,
  DynamicDrawUsage,
  GLSL3,
  type IUniform,
  LineSegments,
  type Matrix4,
  Mesh,
  NormalBlending,
  type Object3D,
  RawShaderMaterial,
  Scene,
  Vector4,
} from "three";
import { define } from "./screen";
import { hitFragment, hitVertex } from "./shaders";

/** More are not drawn; the server sends no more. */
export const MAX_HITS = 20_000;
// Of more than these the outlines and the faint pass are left out: many triangles are seen without.
const MAX_OUTLINED = 3000;

const FILL = new Vector4(1.0, 0.55, 0.08, 0.85);
const EDGE = new Vector4(1.0, 0.85, 0.45, 1.0);

/** One set of triangles: of the mock-up, or of the held mesh. */
class HitSet {
  readonly objects: Object3D[];
  #geometry = new BufferGeometry();
  #edges = new BufferGeometry();
  #room = 0;
  readonly #meshes: (Mesh | LineSegments)[];

  readonly #front: RawShaderMaterial;

  constructor(behind: RawShaderMaterial, front: RawShaderMaterial, edges: RawShaderMaterial) {
    this.#front = front;
    this.#meshes = [
      new Mesh(this.#geometry, behind),
      new Mesh(this.#geometry, front),
      new LineSegments(this.#edges, edges),
    ];
    this.#meshes.forEach((mesh, order) => {
      mesh.frustumCulled = false;
      mesh.matrixAutoUpdate = false;
      mesh.visible = false;
      mesh.renderOrder = order;
    });
    this.objects = this.#meshes;
  }

  get isEmpty(): boolean {
    return !(this.#meshes[1] as Mesh).visible;
  }

  set(corners: Float32Array): void {
    const triangles = Math.min(MAX_HITS, corners.length / 9);
    for (const mesh of this.#meshes)
      mesh.visible = triangles > 0 && (mesh.material === this.#front || triangles <= MAX_OUTLINED);
    if (triangles === 0) return;
    if (triangles > this.#room) this.#grow(Math.min(MAX_HITS, Math.max(256, 2 * triangles)));
    const positions = this.#geometry.getAttribute("position") as BufferAttribute;
    (positions.array as Float32Array).set(corners.subarray(0, 9 * triangles));
    positions.clearUpdateRanges();
    positions.addUpdateRange(0, 9 * triangles);
    positions.needsUpdate = true;
    this.#geometry.setDrawRange(0, 3 * triangles);
    this.#edges.setDrawRange(0, 6 * triangles);
  }

  place(matrix: Matrix4): void {
    for (const mesh of this.#meshes) {
      mesh.matrix.copy(matrix);
      mesh.matrixWorldNeedsUpdate = true;
    }
  }

  dispose(): void {
    this.#geometry.dispose();
    this.#edges.dispose();
  }

  #grow(room: number): void {
    this.dispose();
    this.#room = room;
    const positions = new BufferAttribute(new Float32Array(9 * room), 3);
    positions.setUsage(DynamicDrawUsage);
    const index = new Uint32Array(6 * room);
    for (let k = 0; k < room; k++) {
      const a = 3 * k;
      index.set([a, a + 1, a + 1, a + 2, a + 2, a], 6 * k);
    }
    this.#geometry = new BufferGeometry();
    this.#edges = new BufferGeometry();
    this.#geometry.setAttribute("position", positions);
    this.#edges.setAttribute("position", positions);
    this.#edges.setIndex(new BufferAttribute(index, 1));
    for (const mesh of this.#meshes) mesh.geometry = mesh instanceof LineSegments ? this.#edges : this.#geometry;
  }
}

export class Hits {
  readonly scene = new Scene();
  readonly mockup: HitSet;
  readonly held: HitSet;
  readonly #materials: RawShaderMaterial[];

  constructor(uniforms: Record<string, IUniform>) {
    const material = (colour: Vector4, isBehind: boolean) =>
      new RawShaderMaterial({
        glslVersion: GLSL3,
        vertexShader: hitVertex,
        fragmentShader: hitFragment,
        uniforms: { ...uniforms, colour: { value: colour } },
        defines: isBehind ? { SECTIONS: 0, BEHIND: 1 } : { SECTIONS: 0 },
        depthTest: !isBehind,
        depthWrite: false,
        transparent: true,
        blending: NormalBlending,
        side: DoubleSide,
      });
    const [behind, front, edges] = [material(FILL, true), material(FILL, false), material(EDGE, false)];
    this.#materials = [behind, front, edges];
    this.mockup = new HitSet(behind, front, edges);
    this.held = new HitSet(behind, front, edges);
    this.scene.add(...this.mockup.objects, ...this.held.objects);
  }

  get isEmpty(): boolean {
    return this.mockup.isEmpty && this.held.isEmpty;
  }

  setSections(count: number): void {
    for (const material of this.#materials) define(material, "SECTIONS", count);
  }

  dispose(): void {
    this.mockup.dispose();
    this.held.dispose();
    for (const material of this.#materials) material.dispose();
  }
}
