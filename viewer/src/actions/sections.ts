// Commands for sections: through the selection, across the axis nearest to the line of sight.

import type { CommandRequest, Section } from "../link/protocol";
import { centre, dot, isEmpty, type Vec3 } from "../math/vectors";
import { axisAlong } from "../model/sections";
import type { Workbench } from "./workbench";

/** A cut across an axis through a point, the selection's middle or that of all. The near side is cut away. */
export function addSection(wb: Workbench, normal?: Vec3, through?: Vec3): Promise<boolean> {
  return wb.run(...sectionAdded(wb, normal, through));
}

function sectionAdded(wb: Workbench, normal?: Vec3, through?: Vec3): CommandRequest {
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
