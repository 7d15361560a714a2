// The marks of the picture: contact planes, force, clearance lines and measures, with their values in the chosen unit.

import type { State } from "../link/protocol";
import { carry, position } from "../math/matrix";
import { formatForce, formatLength, type Unit } from "../math/units";
import { distance, length, type Vec3 } from "../math/vectors";
import { touchedParts } from "../model/contact";
import { depthText, wayText } from "../model/findings";
import type { Hand } from "../model/hand";
import { isContact } from "../model/joints";
import { colourOf, numberOf } from "../model/people";
import type { Store } from "../model/store";
import type { Marks } from "../scene/marks";
import { typedText } from "../ui/typing-hint";
import { isolated, measureText, shortened } from "../ui/words";

/** Weaker forces are rounding. */
const LEAST_FORCE_N = 1e-3;

/** Figures at this many of the nearest parts: more would hide what they are about. */
const MOST_FIGURES = 6;
const MOST_TOUCHES = 3;
/** A hand nearer to its tool is not held back by anything worth telling, metres. */
const LEAST_BAND_M = 2e-5;
const MOST_LETTERS = 22;

/** The part of the hand that marks need. */
export type HandPlace = Pick<Hand, "pivot" | "center" | "wish">;

export function marksOf(store: Store, state: State | null, hand: HandPlace): Marks {
  const unit = store.unit.peek();
  const picks = store.measuring.peek()?.picks ?? [];
  const measures = (store.document.peek()?.measures ?? []).map((measure) => ({
    id: measure.id,
    points: measure.points.map((point): Vec3 => [...point]),
    text: measureText(measure, unit),
    isSelected: false,
  }));
  const first = picks[0];
  const pending = first ? [{ id: "pending", points: [first.point], text: "", isSelected: true }] : [];
  const focus = store.findings.focus.peek();
  return {
    ...contactMarks(store, state, unit),
    band: state && bandOf(state, hand, unit),
    typed: typedMark(store, hand),
    measures: [...measures, ...pending],
    snap: store.snap.peek(),
    way: wayOf(store, unit),
    people: peopleMarks(store, hand),
    finding: focus && {
      points: focus.points,
      arrow: focus.arrow,
      text: depthText(focus.finding, unit),
      arrow_text: wayText(focus.finding, unit),
    },
  };
}

/** Where others point, and whose hand moves the tool. */
function peopleMarks({ people, has_hand }: Store, { center }: HandPlace): Marks["people"] {
  const { person, is_free } = people.turn.peek();
  return people.others.peek().flatMap(({ id, name, colour, is_away }) => {
    if (is_away) return [];
    const mark = {
      id,
      name: isolated(shortened(name, MOST_LETTERS)),
      colour: colourOf(colour),
      number: numberOf(colour),
    };
    const point = people.seen.peek().get(id)?.point;
    const hasTool = person === id && !is_free && center !== null && has_hand.peek();
    return [
      ...(point ? [{ ...mark, at: [...point] as Vec3, isTool: false }] : []),
      ...(hasTool ? [{ ...mark, at: center, isTool: true }] : []),
    ];
  });
}

function wayOf(store: Store, unit: Unit): Marks["way"] {
  const { path, gap, fan } = store.way_marks.peek();
  if (path.length === 0 && !fan) return null;
  return {
    path: [...path],
    gap: gap && { point: gap.point, text: gapText(gap.value, store.nameOf(gap.part), unit) },
    fan: fan && { centre: fan.centre, rim: [...fan.rim], isGood: fan.isGood },
  };
}

const gapText = (gap: number, name: string, unit: Unit): string =>
  isContact(gap) ? `meets ${name}` : `${formatLength(gap, unit)} to ${name}`;

type ContactMarks = Pick<Marks, "planes" | "force" | "clearances" | "distance" | "touches">;

function contactMarks(store: Store, state: State | null, unit: Unit): ContactMarks {
  if (!state) return { planes: null, force: null, clearances: null, distance: null, touches: [] };
  const named = (part: number) => shortened(store.nameOf(part), MOST_LETTERS);
  const touched = touchedParts(state);
  const nearest = [...state.clearance_parts.keys()].sort(
    (a, b) => (state.clearance[7 * a] ?? 0) - (state.clearance[7 * b] ?? 0),
  );
  const figured = new Set(
    nearest.filter((k) => !touched.includes(state.clearance_parts[k] ?? -1)).slice(0, MOST_FIGURES),
  );
  const strength = length(state.force);
  const texts = [...state.clearance_parts].map((part, k) =>
    figured.has(k) ? `${formatLength(state.clearance[7 * k] ?? 0, unit)} to ${named(part)}` : "",
  );
  const { distance: near } = state;
  const isListed = near !== null && state.clearance_parts.includes(near.part);
  return {
    planes: state.planes,
    force:
      strength > LEAST_FORCE_N
        ? { at: contactMiddle(state) ?? position(state.pose), vector: [...state.force], text: formatForce(strength) }
        : null,
    clearances: { rows: state.clearance, texts },
    distance:
      near && near.value > 0 && !isListed && !touched.includes(near.part)
        ? {
            from: [...near.tool_point],
            to: [...near.mockup_point],
            text: `${formatLength(near.value, unit)} to ${named(near.part)}`,
          }
        : null,
    touches: touched.slice(0, MOST_TOUCHES).flatMap((part) => {
      const at = touchPoint(state, part);
      return at ? [{ at, text: `touches ${named(part)}` }] : [];
    }),
  };
}

/** A point of the contact with a part: the middle of its contact planes, else where it is nearest. */
function touchPoint(state: State, part: number): Vec3 | null {
  const middle: Vec3 = [0, 0, 0];
  let count = 0;
  state.plane_parts.forEach((each, k) => {
    if (each !== part) return;
    count++;
    for (const axis of [0, 1, 2] as const) middle[axis] += state.planes[8 * k + axis] ?? 0;
  });
  if (count > 0) return [middle[0] / count, middle[1] / count, middle[2] / count];
  const row = state.clearance_parts.indexOf(part);
  if (row >= 0) return [4, 5, 6].map((k) => state.clearance[7 * row + k] ?? 0) as Vec3;
  return state.distance?.part === part ? [...state.distance.mockup_point] : null;
}

/** From the tool to the hand that moves on without it; null: they are together, or nobody moves the hand. */
function bandOf(state: State, hand: HandPlace, unit: Unit): Marks["band"] {
  if (!state.blocked || !hand.wish) return null;
  const [from, to] = [carry(state.pose, hand.pivot), carry(state.wish, hand.pivot)];
  const gap = distance(from, to);
  return gap > LEAST_BAND_M ? { from, to, text: `${formatLength(gap, unit)} held back` } : null;
}

/** What is typed, beside the tool. */
function typedMark(store: Store, { center }: HandPlace): Marks["typed"] {
  const text = typedText(store);
  return text && center ? { at: center, text } : null;
}

/** The middle of the contact planes by their shares of the force: where the hand feels it. */
function contactMiddle(state: State): Vec3 | null {
  const middle: Vec3 = [0, 0, 0];
  let shares = 0;
  for (let k = 0; k + 8 <= state.planes.length; k += 8) {
    const share = Math.abs(state.planes[k + 7] ?? 0);
    for (const axis of [0, 1, 2] as const) middle[axis] += share * (state.planes[k + axis] ?? 0);
    shares += share;
  }
  return shares > 0 ? [middle[0] / shares, middle[1] / shares, middle[2] / shares] : null;
}
