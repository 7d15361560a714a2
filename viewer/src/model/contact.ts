// What the tool touches, also while it rests: once the hand is let go, a state has no collision, only no room.

import type { State } from "../link/protocol";

// A stopped tool stands at most a micrometre before the contact; one that glides keeps a skin of 20 micrometres.
const STOPPED_M = 2e-6;
const GLIDING_M = 25e-6;

type Contact = Pick<State, "mode" | "parts" | "clearance" | "clearance_parts" | "distance">;

/** The gap within which the tool rests on a part, metres. */
export const restGap = (state: Pick<State, "mode">): number => (state.mode === "glide" ? GLIDING_M : STOPPED_M);

/** The touched parts: those that hinder the hand, and those on which the tool rests. */
export function touchedParts(state: Contact): number[] {
  const gap = restGap(state);
  const found = new Set(state.parts);
  state.clearance_parts.forEach((part, k) => {
    if ((state.clearance[7 * k] ?? Infinity) <= gap) found.add(part);
  });
  if (state.distance && state.distance.value <= gap) found.add(state.distance.part);
  return [...found];
}
