// Sections by command: through what is selected, across the axis that the view looks along.

import { centre, dot, isEmpty, type Vec3 } from "../math/vectors";
import type { Section } from "../model/document";
import type { Request, Workbench } from "./workbench";

/** The world axis that is nearest to the view direction, towards what is farther: the near side is cut away. */
export function axisAlong(forward: Vec3): Vec3 {
  const sizes = forward.map(Math.abs);
  const k = sizes.indexOf(Math.max(...sizes));
  const normal: Vec3 = [0, 0, 0];
  normal[k] = Math.sign(forward[k] ?? 1) || 1;
  return normal;
}

/** A cut across an axis through a point, the selection's middle or that of all. The near side is cut away. */
export function addSection(wb: Workbench, normal?: Vec3, through?: Vec3): Promise<boolean> {
  return wb.run(...sectionAdded(wb, normal, through));
}

function sectionAdded(wb: Workbench, normal?: Vec3, through?: Vec3): Request {
  const box = wb.boxOf([...wb.store.selection.peek()]);
  const whole = wb.store.manifest.peek();
  const middle = through ?? (isEmpty(box) ? (whole ? centre(whole) : ([0, 0, 0] as Vec3)) : centre(box));
  const { forward } = wb.stage.camera;
  const across = normal ? towards(normal, forward) : axisAlong(forward);
  wb.store.panel.value = "sections";
  return ["section_add", { normal: across, offset: dot(across, middle) }];
}

/** The normal, or its opposite, that points the way that the view looks. */
const towards = (normal: Vec3, forward: Vec3): Vec3 =>
  dot(normal, forward) < 0 ? (normal.map((value) => (value === 0 ? 0 : -value)) as Vec3) : normal;

/** S: the first cut where there is none; else all off, or on again. */
export function toggleSections(wb: Workbench): Promise<boolean> {
  return wb.runOf(({ sections }) => {
    if (sections.length === 0) return [sectionAdded(wb)];
    const is_on = !sections.some((section) => section.is_on);
    return sections
      .filter((section) => section.is_on !== is_on)
      .map((section) => ["section_switch", { id: section.id, is_on }]);
  });
}

/** What keeps the other side. */
export function flipped(section: Section): Request {
  const normal = section.normal.map((value) => (value === 0 ? 0 : -value));
  return ["section_move", { id: section.id, normal, offset: -section.offset }];
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

/** 1 where a cut keeps what is farther along its axis, -1 for the near side: `sense * offset` is where it lies on it. */
export function senseOf(normal: Vec3): 1 | -1 {
  const sizes = normal.map(Math.abs);
  return (normal[sizes.indexOf(Math.max(...sizes))] ?? 0) < 0 ? -1 : 1;
}

/** The least and the greatest offset at which a cut across `normal` meets the mock-up. */
export function offsetRange(lower: Vec3, upper: Vec3, normal: Vec3): [number, number] {
  let least = 0;
  let most = 0;
  for (const k of [0, 1, 2] as const) {
    const ends = [normal[k] * lower[k], normal[k] * upper[k]];
    least += Math.min(...ends);
    most += Math.max(...ends);
  }
  return [least, most];
}

/** The cuts that are drawn: those that are on, the dragged one where it is dragged to. */
export function drawnSections(
  sections: readonly Section[],
  draft: { id: number; normal: Vec3; offset: number } | null,
): { id: number; normal: Vec3; offset: number }[] {
  return sections
    .filter((section) => section.is_on)
    .map((section) => (draft?.id === section.id ? draft : section))
    .map(({ id, normal, offset }) => ({ id, normal: [...normal] as Vec3, offset }));
}
