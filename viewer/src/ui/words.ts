// Sentences of the page: what the live region and the status line say.

import type { State } from "../protocol";
import { formatLength, type Unit } from "../units";

/** At most so many part names are read out. */
const MOST_NAMES = 3;

/** "1 contact", "4 contacts". */
export const counted = (count: number, one: string, many = `${one}s`): string => `${count} ${count === 1 ? one : many}`;

/** "4 contacts, fuel pump, 1.2 mm deep"; "free, 3 mm to bracket". */
export function spokenState(state: State, unit: Unit, nameOf: (part: number) => string): string {
  const contacts = state.planes.length / 8 + state.contact_more;
  const names = state.parts.slice(0, MOST_NAMES).map(nameOf);
  const more = state.parts.length - names.length;
  if (more > 0) names.push(`${more} more`);
  if (state.parts.length > 0 || contacts > 0) {
    const words = [contacts > 0 ? counted(contacts, "contact") : "touching", ...names];
    if (state.depth > 0) words.push(`${formatLength(state.depth, unit)} deep`);
    return words.join(", ");
  }
  if (!state.distance) return "free";
  return `free, ${formatLength(state.distance.value, unit)} to ${nameOf(state.distance.part)}`;
}

/** "touches cone, shell and 3 more". */
export function touchedText(names: readonly string[]): string {
  if (names.length === 0) return "inside";
  const more = names.length - MOST_NAMES;
  return `touches ${names.slice(0, MOST_NAMES).join(", ")}${more > 0 ? ` and ${more} more` : ""}`;
}

/** "1 part", "4 316 parts". */
export const partsText = (count: number, format: (count: number) => string): string =>
  `${format(count)} ${count === 1 ? "part" : "parts"}`;
