// One byte per part: how it is drawn, by the document and the engine's contacts. Pure.

import type { CardAnswer, Document, State } from "../link/protocol";
import { touchedParts } from "../model/contact";
import type { Focus } from "../model/finding-state";
import { OTHERS } from "../scene/parts";
import { PartState } from "../scene/stage";

/** The states of `count` parts, as `PartState` bits. `others`: what other people selected. */
export function partStates(
  count: number,
  document: Pick<Document, "hidden" | "ghost" | "gripped" | "isolated" | "out">,
  selection: ReadonlySet<number>,
  focus: Pick<Focus, "parts" | "cover"> | null = null,
  others: readonly (readonly number[])[] = [],
): Uint8Array {
  const states = new Uint8Array(count);
  if (focus) {
    // A finding is looked at: its parts are seen, whatever is hidden, and all else is faint.
    states.fill(PartState.ghost);
    mark(states, document.hidden, PartState.hidden);
    for (const part of focus.parts) states[part] = part === focus.cover ? PartState.ghost : 0;
  } else {
    mark(states, document.hidden, PartState.hidden);
    mark(states, document.ghost, PartState.ghost);
    // They were laid aside, and stop nothing.
    mark(states, document.out, PartState.ghost);
  }
  mark(states, selection, PartState.selected);
  others.slice(0, OTHERS.length).forEach((parts, k) => {
    for (const part of parts)
      if (part < count) states[part] = ((states[part] ?? 0) & ~PartState.other) | (OTHERS[k] ?? 0);
  });
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

/** As `feeler clash --html` draws them: the first part blue, the second orange. */
const TINTS = [0x4580cc, 0xff850d] as const;

/** Heads of fasteners by the answer: reached; reached without room for a hand, or not far enough; not reached. */
export const REACHED = { yes: 0x5fbf6b, partly: 0xe0b040, no: 0xd9583f } as const;

/** The colours of fasteners in an answer of access. */
export function reachTints(reaches: CardAnswer["reaches"]): Map<number, number> {
  const tints = new Map<number, number>();
  for (const { part, is_reachable, has_hand, swing_deg } of reaches) {
    if (part === null) continue;
    const isPartly = is_reachable ? has_hand === false : swing_deg > 0;
    tints.set(part, isPartly ? REACHED.partly : is_reachable ? REACHED.yes : REACHED.no);
  }
  return tints;
}

/** What stops parts that do not come out: red, as long as their card is open. */
export const BLOCKING = 0xd9402c;

/** The colours of parts in the answer of a card: heads by their reach, and what stops a part for which there is no way. */
export function answerTints(
  answer: Pick<CardAnswer, "reaches" | "blockers" | "ways"> | undefined,
): Map<number, number> {
  if (!answer) return new Map();
  const blockers = answer.ways.length === 0 ? answer.blockers : [];
  return new Map([...blockers.map(({ part }) => [part, BLOCKING] as const), ...reachTints(answer.reaches)]);
}

/** The colours of the parts of a finding. */
export function findingTints(focus: Focus | null): Map<number, number> {
  const { part_a = null, part_b = null } = focus?.finding ?? {};
  const tints = new Map<number, number>();
  if (part_a !== null) tints.set(part_a, TINTS[0]);
  if (part_b !== null) tints.set(part_b, TINTS[1]);
  return tints;
}
