// One byte a part: how it is drawn. Pure.

import type { Document } from "../model/document";
import { PartState } from "../scene/stage";

/** The states of `count` parts, as `PartState` bits. */
export function partStates(
  count: number,
  document: Pick<Document, "hidden" | "ghost" | "gripped" | "isolated">,
  selection: ReadonlySet<number>,
): Uint8Array {
  const states = new Uint8Array(count);
  const mark = (parts: Iterable<number>, bit: number): void => {
    for (const part of parts) if (part < count) states[part] = (states[part] ?? 0) | bit;
  };
  mark(document.hidden, PartState.hidden);
  mark(document.ghost, PartState.ghost);
  mark(selection, PartState.selected);
  mark(document.gripped, PartState.away);
  return states;
}
