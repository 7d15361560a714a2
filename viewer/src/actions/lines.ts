// Removals in the sequence: are their ways free, can they be shorter; and ways that guide the hand.

import type { Guiding } from "../link/protocol";
import { carry } from "../math/matrix";
import type { Vec3 } from "../math/vectors";
import { openCard } from "./cards";
import type { Workbench } from "./workbench";

/** A way that can guide the hand: a step of a card, or a line of the sequence. */
export type GuideOf = { readonly card: number; readonly step: number } | { readonly line: number };

/** Asks whether the way of a line holds, or for a shorter one; its answer opens. */
export async function askOfLine(wb: Workbench, command: "way_check" | "way_shorten", line: number): Promise<void> {
  const isDone = await wb.run(command, { id: line });
  const newest = wb.store.document.peek()?.cards.at(-1);
  if (isDone && newest?.line === line) await openCard(wb, newest.id);
}

/** Checks the ways of all lines. */
export async function checkWays(wb: Workbench): Promise<void> {
  wb.store.panel.value = "sequence";
  for (const line of wb.store.document.peek()?.sequence ?? []) await wb.run("way_check", { id: line.id });
}

/** Puts the shorter way of a card into the sequence. */
export async function keepWay(wb: Workbench, card: number, isAdded: boolean): Promise<void> {
  await wb.run("way_keep", isAdded ? { id: card, is_added: true } : { id: card });
}

/** Whether this way guides the hand now. */
export function isGuiding(guiding: Guiding | null | undefined, of: GuideOf): boolean {
  if (!guiding) return false;
  return "line" in of ? guiding.line === of.line : guiding.card === of.card && guiding.step === of.step;
}

/** Lets a way guide the hand, which grips its parts first if it is empty; a second call ends it. */
export async function toggleGuide(wb: Workbench, of: GuideOf, parts: readonly number[]): Promise<void> {
  const { store } = wb;
  const document = store.document.peek();
  if (isGuiding(document?.guiding, of)) {
    await endGuide(wb);
    return;
  }
  const gripped = document?.gripped ?? [];
  if (parts.some((part) => !gripped.includes(part))) {
    if (gripped.length > 0) {
      store.notify("info", "The hand holds other parts: let go of them first (E)");
      return;
    }
    if (!(await wb.run("grip", { parts: [...parts] }))) return;
  }
  store.film.value = null;
  if (await wb.run("guide", of)) store.notify("info", "The way draws your hand while you are near it. Esc ends it.");
}

export async function endGuide(wb: Workbench): Promise<void> {
  await wb.run("guide_end");
}

/** The path of the middle of what is in the hand along the way that guides it, world. */
export function guidePath(wb: Workbench, guiding: Guiding | null): Vec3[] {
  return guiding ? guiding.way.map((pose) => carry(pose, wb.hand.pivot)) : [];
}
