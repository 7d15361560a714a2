// One byte a part: how it is drawn, by the document and by what the engine touches. Pure.

import type { Document, State } from "../link/protocol";
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

/** The same with what the tool touches and is near. */
export function withLit(base: Uint8Array, state: State | null): Uint8Array {
  const states = base.slice();
  const mark = (parts: ArrayLike<number>, bit: number): void => {
    for (let k = 0; k < parts.length; k++) {
      const part = parts[k] ?? -1;
      if (part >= 0 && part < states.length) states[part] = (states[part] ?? 0) | bit;
    }
  };
  if (state) {
    mark(state.clearance_parts, PartState.near);
    mark(state.parts, PartState.hit);
  }
  return states;
}
