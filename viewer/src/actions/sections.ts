// Commands for sections: through the selection, across the axis nearest to the line of sight.

import type { CommandRequest, Section, Viewpoint } from "../link/protocol";
import type { BoxFace } from "../math/box-faces";
import { isSame } from "../math/same";
import { type Box, centre, dot, isEmpty, type Point, type Vec3 } from "../math/vectors";
import { axisAlong, boxRound, withFace } from "../model/sections";
import type { Workbench } from "./workbench";

/** A cut across an axis through a point, the selection's middle or that of all. The near side is cut away. */
export function addSection(wb: Workbench, normal?: Vec3, through?: Vec3): Promise<boolean> {
  const request = sectionAdded(wb, normal, through);
  return wb.runOf(({ sections }) => {
    const [, plane] = request;
    const same = sections.find((each) => isSamePlane(each, plane));
    if (!same && sections.length >= MOST_CUTS)
      throw new Error(`There are ${MOST_CUTS} cuts already: remove or move one`);
    if (!same) return [request];
    return same.is_on ? [] : [["section_switch", { id: same.id, is_on: true }]];
  });
}

/** Of the six planes that a picture has for cuts. */
const MOST_CUTS = 6;

const isSamePlane = (a: Plane, b: Plane): boolean =>
  Math.abs(a.offset - b.offset) < 1e-9 && a.normal.every((value, k) => Math.abs(value - (b.normal[k] ?? 0)) < 1e-9);

type Plane = Pick<Section, "normal" | "offset">;

function sectionAdded(wb: Workbench, normal?: Vec3, through?: Vec3): readonly ["section_add", Plane] {
  const box = wb.boxOf([...wb.store.selection.peek()]);
  const whole = wb.store.manifest.peek();
  const middle = through ?? (isEmpty(box) ? (whole ? centre(whole) : ([0, 0, 0] as Vec3)) : centre(box));
  const { forward } = wb.stage.camera.arrived;
  const across = normal ? towards(normal, forward) : axisAlong(forward);
  wb.store.panel.value = "sections";
  return ["section_add", { normal: across, offset: dot(across, middle) }];
}

/** The normal, or its opposite, that points the way that the view looks. */
const towards = (normal: Vec3, forward: Vec3): Vec3 => (dot(normal, forward) < 0 ? opposite(normal) : normal);

const opposite = (normal: Vec3): Vec3 => normal.map((value) => (value === 0 ? 0 : -value)) as Vec3;

/** S: makes the first cut if there is none; else turns all off, or on again. */
export function toggleSections(wb: Workbench): Promise<boolean> {
  return wb.runOf(({ sections }) => {
    if (sections.length === 0) return [sectionAdded(wb)];
    const is_on = !sections.some((section) => section.is_on);
    return sections
      .filter((section) => section.is_on !== is_on)
      .map((section) => ["section_switch", { id: section.id, is_on }]);
  });
}

/** The command that keeps the other side of a section. */
export function flipped(section: Section): CommandRequest {
  return ["section_move", { id: section.id, normal: opposite(section.normal), offset: -section.offset }];
}

/** Moves a cut in the picture only; `settleSection` tells the server, one step of undo. */
export function draftSection(wb: Workbench, section: Section, offset: number): void {
  wb.store.section_draft.value = { id: section.id, normal: section.normal, offset };
  wb.redraw();
}

export async function settleSection(wb: Workbench): Promise<void> {
  const draft = wb.store.section_draft.peek();
  if (!draft) return;
  await wb.run("section_move", { id: draft.id, normal: draft.normal, offset: draft.offset });
  if (wb.store.section_draft.peek() === draft) wb.store.section_draft.value = null;
}

// ---- along a face ----

/** The next click on the picture cuts along the face there; a second call ends that. */
export function pickFace(wb: Workbench): void {
  const { store } = wb;
  store.is_picking_face.value = !store.is_picking_face.peek();
  if (!store.is_picking_face.peek()) return;
  store.panel.value = "sections";
  wb.say("Click a face to cut along it");
}

/** Cuts along the plane of the face that a pixel sees. The near side is cut away. */
export async function cutAlongFace(wb: Workbench, at: Point): Promise<void> {
  wb.store.is_picking_face.value = false;
  try {
    if ((wb.document?.explode ?? 0) > 0) throw new Error("The view is exploded: put the mock-up together to cut it");
    const hit = await wb.ask("ray", wb.stage.camera.ray(at.x, at.y));
    if (hit) await addSection(wb, [...hit.normal], [...hit.point]);
    else wb.store.notify("info", "There is no face to cut along");
  } catch (error) {
    wb.tell(error);
  }
}

// ---- the section box ----

/** B: makes a box if there is none; else turns it off, or on again. */
export function toggleBox(wb: Workbench): Promise<boolean> {
  return wb.runOf(({ section_box }) => {
    if (section_box) return [["section_box_switch", { is_on: !section_box.is_on }]];
    return boxFitted(wb);
  });
}

/** Puts the box round the selection, or round everything visible. */
export const fitBox = (wb: Workbench): Promise<boolean> => wb.runOf(() => boxFitted(wb));

function boxFitted(wb: Workbench): CommandRequest[] {
  const { store } = wb;
  const selected = wb.boxOf([...store.selection.peek()]);
  const box = boxRound(isEmpty(selected) ? wb.boxOf(wb.visible([...store.paths.peek().keys()])) : selected);
  store.panel.value = "sections";
  return box ? [["section_box", box]] : [];
}

/** Moves a face in the picture only; `settleBox` tells the server, one step of undo. */
export function draftFace(wb: Workbench, box: Box, face: BoxFace, place: number): void {
  wb.store.box_draft.value = withFace(box, face, place);
  wb.redraw();
}

export async function settleBox(wb: Workbench): Promise<void> {
  const draft = wb.store.box_draft.peek();
  if (!draft) return;
  await wb.run("section_box", draft);
  if (wb.store.box_draft.peek() === draft) wb.store.box_draft.value = null;
}

/** Puts a face of the box to a place that was typed; the other faces stay where earlier changes have them. */
export const setFace = (wb: Workbench, face: BoxFace, place: number): Promise<boolean> =>
  wb.runOf(({ section_box: box }) =>
    box ? [["section_box", withFace({ lower: [...box.lower], upper: [...box.upper] }, face, place)]] : [],
  );

/** Restores the cuts that a viewpoint was saved with, if they are others now. */
export function showCutsOf(wb: Workbench, viewpoint: Viewpoint): void {
  const { document } = wb;
  if (!document || !viewpoint.sections || !wb.store.can_look.peek()) return;
  const { sections, section_box } = document;
  if (isSame([sections, section_box], [viewpoint.sections, viewpoint.section_box])) return;
  void wb.run("viewpoint_show", { id: viewpoint.id });
}
