// Sentences of the live region and the status line.

import type { Measure, State } from "../link/protocol";
import { formatAngle, formatLength, type Unit } from "../math/units";
import { touchedParts } from "../model/contact";

/** The most part names that are read out. */
const MOST_NAMES = 3;

/** Letters and signs that turn the direction of a line. */
const TURNING = /[\u0590-\u08ff\u200e\u200f\u202a-\u202e\u2066-\u2069\ufb1d-\ufdff\ufe70-\ufeff]/;

/** A name inside a sentence: one of another direction does not turn the rest. */
export const isolated = (name: string): string => (TURNING.test(name) ? `\u2068${name}\u2069` : name);

/** The first letters of the first two words. */
export const initials = (name: string): string =>
  name
    .split(" ")
    .slice(0, 2)
    .map((word) => (Array.from(word)[0] ?? "").toUpperCase())
    .join("");

/** "1 contact", "4 contacts". */
export const counted = (count: number, one: string, many = `${one}s`): string => `${count} ${count === 1 ? one : many}`;

/** "1.2 mm deep", "at most 1.2 mm deep" if a shorter way out may exist; "" without a collision. */
export function depthText(state: State, unit: Unit): string {
  if (state.depth <= 0) return "";
  if (state.depth_kind === "estimate") return "no way out found";
  return `${state.depth_kind === "bound" ? "at most " : ""}${formatLength(state.depth, unit)} deep`;
}

/** Whether the tool meets something, or is inside of it. */
export const isTouching = (state: State): boolean => !state.is_free || touchedParts(state).length > 0;

/** "4 contacts, fuel pump, 1.2 mm deep"; "inside, 8 mm deep"; "free, 3 mm to bracket". */
export function spokenState(state: State, unit: Unit, nameOf: (part: number) => string): string {
  const contacts = state.planes.length / 8 + state.contact_more;
  const touched = touchedParts(state);
  const names = touched.slice(0, MOST_NAMES).map((part) => isolated(nameOf(part)));
  const more = touched.length - names.length;
  if (more > 0) names.push(`${more} more`);
  if (isTouching(state) || contacts > 0) {
    const how = contacts > 0 ? counted(contacts, "contact") : names.length > 0 ? "touching" : "inside";
    const depth = depthText(state, unit);
    return [how, ...names, ...(depth ? [depth] : [])].join(", ");
  }
  if (!state.distance) return "free";
  return `free, ${formatLength(state.distance.value, unit)} to ${isolated(nameOf(state.distance.part))}`;
}

/** "touches cone, shell and 3 more". */
export function touchedText(names: readonly string[]): string {
  if (names.length === 0) return "inside";
  const more = names.length - MOST_NAMES;
  return `touches ${names.slice(0, MOST_NAMES).map(isolated).join(", ")}${more > 0 ? ` and ${more} more` : ""}`;
}

/** A name of at most `most` letters, cut in its middle: the ends tell names apart. */
export function shortened(name: string, most: number): string {
  const letters = [...name];
  if (letters.length <= most) return name;
  const head = Math.ceil((most - 1) / 2);
  return `${letters.slice(0, head).join("")}…${letters.slice(letters.length - (most - 1 - head)).join("")}`;
}

/** A measure's figure. */
export const measureText = (measure: Pick<Measure, "unit" | "value">, unit: Unit): string =>
  measure.unit === "rad" ? formatAngle(measure.value) : formatLength(measure.value, unit);

/** "1 part", "4 316 parts". */
export const partsText = (count: number, format: (count: number) => string): string =>
  `${format(count)} ${count === 1 ? "part" : "parts"}`;

/** "1 triangle", "50 124 triangles". */
export const trianglesText = (count: number, format: (count: number) => string): string =>
  `${format(count)} ${count === 1 ? "triangle" : "triangles"}`;
