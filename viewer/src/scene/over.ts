// Everything drawn over the mock-up: lines of sections, the hand, colliding triangles, marks with their labels, and the
// drawings of other modules.

import { type Group, Scene, type WebGLRenderer } from "three";
import { isSame } from "../math/same";
import type { Vec3 } from "../math/vectors";
import { BOX_FACES } from "../model/sections";
import type { CameraRig } from "./camera";
import type { Eye } from "./eye";
import { Heat } from "./heat";
import { Held } from "./held";
import { HeldLayer } from "./held-layer";
import { Hits } from "./hits";
import { LabelLayer, type Taken } from "./labels";
import { MarkLayer, type Marks, NO_MARKS } from "./marks";
import type { Model } from "./model";
import { SectionLines } from "./sections";
import type { SharedUniforms } from "./uniforms";

const NONE = new Uint32Array(0);

export class Over {
  readonly held: Held;
  /** A swept volume, drawn as a ghost. */
  readonly room: Held;
  readonly heat: Heat;
  readonly #hits: Hits;
  readonly #heldLayer: HeldLayer;
  #middle: Vec3 = [0, 0, 0];
  readonly #scene = new Scene();
  readonly #labels: LabelLayer | null;
  #marks: MarkLayer;
  #lines: SectionLines;
  #markValues: Marks = NO_MARKS;
  #outlines: Float32Array | null = null;
  #hitIds: { mockup: Uint32Array; held: Uint32Array } = { mockup: NONE, held: NONE };

  /** `group`: what other modules draw. `labels`: where figures are put; null: none are. */
  constructor(
    readonly uniforms: SharedUniforms,
    readonly group: Group,
    labels: HTMLElement | null,
  ) {
    this.held = new Held(uniforms);
    this.room = new Held(uniforms);
    this.heat = new Heat(uniforms);
    this.#hits = new Hits(uniforms);
    this.#heldLayer = new HeldLayer(uniforms);
    this.#marks = new MarkLayer(uniforms, [0, 0, 0]);
    this.#lines = new SectionLines(uniforms, [0, 0, 0]);
    this.#labels = labels ? new LabelLayer(labels) : null;
    this.#scene.add(group);
  }

  /** The scene's origin lies elsewhere: in the middle of another mock-up. */
  setOrigin({ middle }: Model): void {
    this.#middle = middle;
    this.group.position.set(-middle[0], -middle[1], -middle[2]);
    this.#marks.dispose();
    this.#marks = new MarkLayer(this.uniforms, middle);
    this.#marks.set(this.#markValues);
    this.#lines.dispose();
    this.#lines = new SectionLines(this.uniforms, middle);
    this.#lines.setOutlines(this.#outlines);
    this.held.setOrigin(middle);
    this.room.setOrigin(middle);
  }

  setSections({ sections, section_box, bounds }: Model): void {
    for (const room of [this.held, this.room, this.heat, this.#heldLayer, this.#hits, this.#marks])
      room.setSections(sections.length);
    const cuts = section_box ? sections.slice(0, -BOX_FACES.length) : sections;
    this.#lines.setFrames(cuts, section_box, bounds, sections.length);
  }

  /** The engine's outlines of the sections: (k, 2, 3) world metres, null for none. */
  setOutlines(segments: Float32Array | null): void {
    this.#outlines = segments;
    this.#lines.setOutlines(segments);
  }

  /** Sets colliding packed triangles, of the mock-up and of the held mesh; absent entries stay. Whether they changed. */
  setHits(ids: { mockup?: Uint32Array; held?: Uint32Array }, model: Model): boolean {
    const next = { ...this.#hitIds, ...ids };
    if (isSame(next, this.#hitIds)) return false;
    this.#hitIds = structuredClone(next);
    this.placeHits(model);
    return true;
  }

  /** Moves the colliding triangles to their present places. */
  placeHits(model: Model): void {
    const { mockup, held } = this.#hitIds;
    this.#hits.mockup.set(model.corners(mockup));
    this.#hits.held.set(this.held.corners(held));
  }

  /** Whether they are others than before. */
  setMarks(marks: Marks): boolean {
    if (isSame(marks, this.#markValues)) return false;
    this.#markValues = structuredClone(marks);
    this.#marks.set(this.#markValues);
    return true;
  }

  /** Makes the marks as large as the camera asks for. */
  build(camera: CameraRig): void {
    this.#marks.build(camera);
  }

  /** Puts the figures to their marks. */
  label(camera: CameraRig, taken: Taken): void {
    this.#labels?.update(this.#marks.anchors, camera, taken);
  }

  /** What is drawn aside, for a picture of that size: before `draw`, and before the picture itself. */
  prepare(renderer: WebGLRenderer, eye: Eye, width: number, height: number): void {
    if (!this.held.isEmpty) this.#heldLayer.prepare(renderer, this.held, eye, this.#middle, width, height);
  }

  draw(renderer: WebGLRenderer, eye: Eye): void {
    if (this.uniforms.hasKept.value && !this.held.isEmpty) this.heat.draw(renderer, this.held, eye);
    if (!this.#lines.isEmpty) renderer.render(this.#lines.scene, eye);
    this.#drawHeld(renderer, eye);
    if (!this.#hits.isEmpty) {
      this.#hits.held.place(this.held.matrix);
      renderer.render(this.#hits.scene, eye);
    }
    if (this.held.isGhostShown) renderer.render(this.held.ghostScene, eye);
    if (!this.room.isEmpty) renderer.render(this.room.ghostScene, eye);
    if (!this.#marks.isEmpty) renderer.render(this.#marks.scene, eye);
    if (this.group.visible && this.group.children.length > 0) renderer.render(this.#scene, eye);
  }

  /** In a headset there is no kept layer: the mesh alone. */
  #drawHeld(renderer: WebGLRenderer, eye: Eye): void {
    if (this.held.isEmpty) return;
    if (!this.uniforms.hasKept.value) {
      renderer.render(this.held.scene, eye);
      return;
    }
    this.#heldLayer.draw(renderer, this.held, eye);
  }

  dispose(): void {
    this.#labels?.dispose();
    for (const room of [this.held, this.room, this.heat, this.#heldLayer, this.#hits, this.#marks, this.#lines])
      room.dispose();
  }
}
