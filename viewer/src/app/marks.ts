// The marks of the picture: contact planes, force, clearance lines and measures, with their values in the chosen unit.

import type { State } from "../link/protocol";
import { position } from "../math/matrix";
import { formatForce, formatLength, type Unit } from "../math/units";
import { length, type Vec3 } from "../math/vectors";
import { depthText, wayText } from "../model/findings";
import type { Store } from "../model/store";
import type { Marks } from "../scene/marks";
import { measureText } from "../ui/words";

/** Weaker forces are rounding. */
const LEAST_FORCE_N = 1e-3;

export function marksOf(store: Store, state: State | null): Marks {
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
    ...contactMarks(state, unit),
    measures: [...measures, ...pending],
    snap: store.snap.peek(),
    finding: focus && {
      points: focus.points,
      arrow: focus.arrow,
      text: depthText(focus.finding, unit),
      arrow_text: wayText(focus.finding, unit),
    },
  };
}

function contactMarks(state: State | null, unit: Unit): Pick<Marks, "planes" | "force" | "clearances" | "distance"> {
  if (!state) return { planes: null, force: null, clearances: null, distance: null };
  const strength = length(state.force);
  const texts: string[] = [];
  for (let k = 0; k < state.clearance.length; k += 7) {
    const value = state.clearance[k] ?? 0;
    // Touched parts are highlighted: a label would only cover the contact.
    texts.push(value > 0 ? formatLength(value, unit) : "");
  }
  const { distance } = state;
  const isListed = distance !== null && state.clearance_parts.includes(distance.part);
  return {
    planes: state.planes,
    force:
      strength > LEAST_FORCE_N
        ? { at: contactMiddle(state) ?? position(state.pose), vector: [...state.force], text: formatForce(strength) }
        : null,
    clearances: { rows: state.clearance, texts },
    distance:
      distance && distance.value > 0 && !isListed
        ? {
            from: [...distance.tool_point],
            to: [...distance.mockup_point],
            text: formatLength(distance.value, unit),
          }
        : null,
  };
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
