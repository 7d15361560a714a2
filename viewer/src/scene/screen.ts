// Passes over every pixel: one triangle that covers the picture.

import {
  BufferAttribute,
  BufferGeometry,
  type Camera,
  GLSL3,
  type IUniform,
  Mesh,
  NoBlending,
  OrthographicCamera,
  RawShaderMaterial,
  Scene,
  type ShaderMaterialParameters,
  type WebGLRenderer,
  type WebGLRenderTarget,
} from "three";
import { screenVertex } from "./shaders";

export class ScreenPass {
  readonly material: RawShaderMaterial;
  readonly #scene = new Scene();
  readonly #geometry = new BufferGeometry();
  readonly #camera = new OrthographicCamera();

  constructor(fragmentShader: string, uniforms: Record<string, IUniform>, parameters: ShaderMaterialParameters = {}) {
    this.material = new RawShaderMaterial({
      glslVersion: GLSL3,
      vertexShader: screenVertex,
      fragmentShader,
      uniforms,
      depthTest: false,
      depthWrite: false,
      blending: NoBlending,
      ...parameters,
    });
    this.#geometry.setAttribute("position", new BufferAttribute(new Float32Array([-1, -1, 0, 3, -1, 0, -1, 3, 0]), 3));
    const mesh = new Mesh(this.#geometry, this.material);
    mesh.frustumCulled = false;
    this.#scene.add(mesh);
  }

  /** The pass looks through no camera; three asks for one. */
  draw(renderer: WebGLRenderer, target: WebGLRenderTarget | null, camera: Camera = this.#camera): void {
    renderer.setRenderTarget(target);
    renderer.render(this.#scene, camera);
  }

  dispose(): void {
    this.#geometry.dispose();
    this.material.dispose();
  }
}

/** Gives `material` the value `value` (null: none) of a define; compiles anew only when it changed. */
export function define(material: RawShaderMaterial, name: string, value: number | null): void {
  const defines = material.defines as Record<string, number>;
  if ((defines[name] ?? null) === value) return;
  if (value === null) delete defines[name];
  else defines[name] = value;
  material.needsUpdate = true;
}
