// One byte per part: how it is drawn, by the document and the engine's contacts. Pure.

import type { Document, State } from "../link/protocol";
import { touchedParts } from "../model/contact";
import { PartState } from "../scene/stage";

/** The states of `count` parts, as `PartState` bits. */
export function partStates(
  count: number,
  document: Pick<Document, "hidden" | "ghost" | "gripped" | "isolated">,
  selection: ReadonlySet<number>,
): Uint8Array {
  const states = new Uint8Array(count);
  mark(states, document.hidden, PartState.hidden);
  mark(states, document.ghost, PartState.ghost);
  mark(states, selection, PartState.selected);
  mark(states, document.gripped, PartState.away);
  return states;
}

/** The same with touched parts. What is near is shown where it is near, by the heat map. */
export function withLit(base: Uint8Array, state: State | null): Uint8Array {
  const states = base.slice();
  if (state) {
    mark(states, touchedParts(state), PartState.hit);
  }
  return states;
}

function mark(states: Uint8Array, parts: Iterable<number>, bit: number): void {
  for (const part of parts) if (part < states.length) states[part] = (states[part] ?? 0) | bit;
}
