// The heat map: surfaces near the held mesh in colours of their distance to it. Drawn over the kept picture, only where the
// surroundings of the mesh are.

import {
  ClampToEdgeWrapping,
  Data3DTexture,
  LinearFilter,
  Matrix4,
  NormalBlending,
  RedFormat,
  UnsignedByteType,
  Vector3,
  type WebGLRenderer,
} from "three";
import { HEAT_REACH_M, type HeatField } from "../math/heat-field";
import type { Vec3 } from "../math/vectors";
import type { Eye } from "./eye";
import type { Held } from "./held";
import { BoxPass, grown } from "./rect";
import { define } from "./screen";
import { heatFragment } from "./shaders";
import type { SharedUniforms } from "./uniforms";

export class Heat {
  /** Whether anything is near enough to be shown. */
  isOn = false;
  readonly #pass: BoxPass;
  readonly #uniforms = {
    field: { value: null as Data3DTexture | null },
    fieldFromView: { value: new Matrix4() },
    fieldScale: { value: 1 },
    heatReach: { value: HEAT_REACH_M },
    fieldEdge: { value: new Vector3() },
  };
  #field: HeatField | null = null;

  constructor(uniforms: SharedUniforms) {
    this.#pass = new BoxPass(
      heatFragment,
      { ...uniforms, ...this.#uniforms },
      { defines: { SECTIONS: 0 }, depthTest: false, depthWrite: false, blending: NormalBlending },
    );
  }

  /** The distance between the nodes of the field: how exact the colours are, metres. Null before there is one. */
  get accuracy(): number | null {
    return this.#field?.cell ?? null;
  }

  setField(field: HeatField | null): void {
    this.#field = field;
    this.#uniforms.field.value?.dispose();
    this.#uniforms.field.value = null;
    if (!field) return;
    const texture = new Data3DTexture(field.data as Uint8Array<ArrayBuffer>, ...field.size);
    texture.format = RedFormat;
    texture.type = UnsignedByteType;
    texture.minFilter = texture.magFilter = LinearFilter;
    texture.wrapS = texture.wrapT = texture.wrapR = ClampToEdgeWrapping;
    texture.unpackAlignment = 1;
    texture.needsUpdate = true;
    this.#uniforms.field.value = texture;
    this.#uniforms.fieldScale.value = field.most;
    this.#uniforms.fieldEdge.value.set(...(field.size.map((count) => 0.5 / count) as Vec3));
  }

  setSections(count: number): void {
    define(this.#pass.material, "SECTIONS", count);
  }

  /** Draws it to the current target. */
  draw(renderer: WebGLRenderer, held: Held, eye: Eye): void {
    const field = this.#field;
    if (!this.isOn || !field) return;
    // From view coordinates into those of the texture, in which nodes are the middles of texels.
    const { size, origin, cell } = field;
    const toTexture = new Matrix4()
      .makeScale(1 / (cell * size[0]), 1 / (cell * size[1]), 1 / (cell * size[2]))
      .multiply(new Matrix4().makeTranslation(-origin[0] + cell / 2, -origin[1] + cell / 2, -origin[2] + cell / 2));
    this.#uniforms.fieldFromView.value.copy(toTexture).multiply(held.matrix.clone().invert()).multiply(eye.matrixWorld);
    this.#pass.draw(renderer, grown(held.pieceBox(), HEAT_REACH_M), held.matrix, eye);
  }

  dispose(): void {
    this.setField(null);
    this.#pass.dispose();
  }
}
