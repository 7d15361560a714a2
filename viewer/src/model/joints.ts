// Mechanisms: where the joints have the parts, how a pointer moves a joint, and the bar of its free range. Pure.

import type { Document, JointRange, Mechanism } from "../link/protocol";
import { carry, IDENTITY, isSamePose, type Pose, turn } from "../math/matrix";
import { alongAxis, type PointerView } from "../math/pointing";
import { formatLength, type Unit } from "../math/units";
import { add, cross, dot, length, type Point, scale, subtract, type Vec3 } from "../math/vectors";

export type JointNumber = Mechanism["numbers"][number];

/** Where the links are shown, before the document knows; null: where the document has them. */
export interface JointsShown {
  readonly poses: readonly (readonly number[])[];
  readonly values: Readonly<Record<string, number>>;
}

/** A part that is farther from its link than by rounding goes with it no longer. */
const SAME = 1e-7;
/** A slider without limits shows this much both ways, until its range is known. */
const WIDE = { turn: Math.PI, slide: 0.1 } as const;
/** Below this cosine an axis lies so flat in the picture that a pointer cannot turn about it. */
const FLAT = 0.3;
const LEAST_ARM_M = 1e-4;

/** The places of parts when the links are elsewhere: those in `moved`, and those that go with the links. */
export function placesAt(
  document: Pick<Document, "moved" | "mechanism" | "gripped" | "out">,
  poses: readonly (readonly number[])[] | null,
): Map<number, Pose> {
  const places = new Map(Object.entries(document.moved).map(([part, pose]) => [Number(part), [...pose]]));
  const { mechanism } = document;
  if (!mechanism || !poses || poses.length !== mechanism.links.length) return places;
  const away = new Set([...document.gripped, ...document.out]);
  mechanism.links.forEach((link, place) => {
    const pose = poses[place] ?? link.pose;
    for (const part of link.parts) {
      if (away.has(part) || !isSamePose(places.get(part) ?? IDENTITY, link.pose, SAME)) continue;
      places.set(part, [...pose]);
    }
  });
  return places;
}

/** The parts that a number moves: those of its link, and of all that hang on it. */
export function partsOf(mechanism: Mechanism, number: JointNumber): number[] {
  const links = new Set(mechanism.numbers.filter((each) => each.group === number.group).map((each) => each.link));
  let count = 0;
  while (count !== links.size) {
    count = links.size;
    mechanism.links.forEach((link, place) => {
      if (links.has(link.above)) links.add(place);
    });
  }
  return [...links].flatMap((link) => mechanism.links[link]?.parts ?? []);
}

/** The number that moves a part when it is dragged: of its link, or of the next one above that moves; null: none. */
export function numberOf(mechanism: Mechanism | null, part: number): JointNumber | null {
  if (!mechanism) return null;
  let link = mechanism.links.findIndex((each) => each.parts.includes(part));
  while (link >= 0) {
    const number = mechanism.numbers.find((each) => each.link === link);
    if (number) return number;
    link = mechanism.links[link]?.above ?? -1;
  }
  return null;
}

/** The axis of a number where the links are now: a unit direction, and a point on it. */
export function axisNow(mechanism: Mechanism, number: JointNumber): { direction: Vec3; point: Vec3 } {
  const frame = mechanism.links[mechanism.links[number.link]?.above ?? -1]?.pose ?? IDENTITY;
  return { direction: turn(frame, [...number.axis]), point: carry(frame, [...number.point]) };
}

/** The least and the greatest value of a slider. */
export function spanOf(number: JointNumber, range: JointRange | undefined, value: number): [number, number] {
  const isKnown = range !== undefined && range.state !== "failed" && range.share >= KNOWN_SHARE;
  const wide = WIDE[number.kind];
  const [low, high] = number.limits ?? (isKnown ? [range.lower, range.upper] : [-wide, wide]);
  const [least, most] = [Math.min(low, value), Math.max(high, value)];
  return least < most ? [least, most] : [least - wide / 100, most + wide / 100];
}

/** Gaps from which a bar has its colours, metres: nearer than the first it is at contact. */
const GAPS_M = [1e-4, 1e-3, 5e-3, 2e-2] as const;
export type GapClass = 0 | 1 | 2 | 3 | 4;
export const gapClass = (gap: number | null): GapClass => {
  const found = gap === null ? -1 : GAPS_M.findIndex((each) => gap < each);
  return (found < 0 ? 4 : found) as GapClass;
};

export const GAP_CLASSES: readonly GapClass[] = [0, 1, 2, 3, 4];
/** What a colour says. */
export function gapText(gap: GapClass, unit: Unit): string {
  if (gap === 0) return "contact";
  return gap === 4 ? `${formatLength(GAPS_M[3], unit)} or more` : `< ${formatLength(GAPS_M[gap], unit)}`;
}

/** Of the work on a range: from there on it is known how far the joint moves. */
export const KNOWN_SHARE = 0.2;
/** Ranges that are shorter are none: radians, metres. */
const FIXED = 1e-6;
export const isFixed = ({ lower, upper, below, above }: JointRange): boolean =>
  below !== null && above !== null && upper - lower < FIXED;

/** Whether a gap is none, but for rounding. */
export const isContact = (gap: number): boolean => gap < 1e-7;

/** Where a key moves a slider: by a step, ten of them, or to an end; with Shift by a tenth. Null: another key. */
export function stepped(
  { key, shiftKey }: Pick<KeyboardEvent, "key" | "shiftKey">,
  value: number,
  step: number,
  [least, most]: readonly [number, number],
): number | null {
  const fine = shiftKey ? 0.1 : 1;
  const by = { ArrowRight: 1, ArrowUp: 1, ArrowLeft: -1, ArrowDown: -1, PageUp: 10, PageDown: -10 }[key];
  if (by !== undefined) return Math.min(most, Math.max(least, value + by * fine * step));
  return key === "Home" ? least : key === "End" ? most : null;
}

/** A piece of a bar, in shares of the slider. `gap` null: not known yet. */
export interface BarPiece {
  readonly from: number;
  readonly to: number;
  readonly gap: GapClass | null;
}

/** The free range as a bar, coloured by the gap; alike neighbours are one piece. */
export function barOf(range: JointRange, [least, most]: readonly [number, number]): BarPiece[] {
  const share = (value: number): number => Math.min(1, Math.max(0, (value - least) / (most - least)));
  const { curve } = range;
  if (curve.length < 2) return [{ from: share(range.lower), to: share(range.upper), gap: null }];
  const pieces: BarPiece[] = [];
  curve.forEach(([value, gap], k) => {
    const before = curve[k - 1]?.[0] ?? value;
    const after = curve[k + 1]?.[0] ?? value;
    const piece = { from: share((before + value) / 2), to: share((value + after) / 2), gap: gapClass(gap) };
    const last = pieces.at(-1);
    if (last?.gap === piece.gap) pieces[pieces.length - 1] = { ...last, to: piece.to };
    else pieces.push(piece);
  });
  return pieces;
}

/** How far a pointer moves a joint: radians of a turn, metres of a slide. */
export interface JointDrag {
  by(view: PointerView, to: Point): number;
}

/** The drag that begins at a pixel, on a point of a part. */
export function beginDrag(
  kind: JointNumber["kind"],
  { direction, point }: { direction: Vec3; point: Vec3 },
  grabbed: Vec3,
  view: PointerView,
  from: Point,
): JointDrag {
  if (kind === "slide") return { by: (now, to) => alongAxis(grabbed, direction, now, from, to) };
  const foot = add(point, scale(direction, dot(subtract(grabbed, point), direction)));
  const arm = subtract(grabbed, foot);
  const radius = Math.max(length(arm), LEAST_ARM_M);
  const facing = dot(direction, view.towards(foot));
  if (Math.abs(facing) < FLAT) {
    // Seen from the side, the part goes along its tangent.
    const tangent = scale(cross(direction, arm), 1 / radius);
    if (length(tangent) < 0.5) return { by: () => 0 };
    return { by: (now, to) => alongAxis(grabbed, scale(tangent, 1 / length(tangent)), now, from, to) / radius };
  }
  // Summed up from move to move, so that it may go round more than once.
  const middle = view.project(foot);
  const angle = (at: Point): number => Math.atan2(middle.y - at.y, at.x - middle.x);
  let last = angle(from);
  let sum = 0;
  return {
    by: (_, to) => {
      let step = angle(to) - last;
      if (step > Math.PI) step -= 2 * Math.PI;
      if (step < -Math.PI) step += 2 * Math.PI;
      last = angle(to);
      sum += step;
      return facing < 0 ? -sum : sum;
    },
  };
}
