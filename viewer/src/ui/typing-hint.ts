// The hint in the status line while the tool is moved by keys, and while nothing is under the pointer.

import type { Store } from "../model/store";
import { type TypedMove, wrongFigure } from "../model/typed-move";

const AXES = ["X", "Y", "Z"] as const;

/** "X 12.5 mm": what is typed, for the picture; empty while nothing is. */
export function typedText(store: Store): string {
  const move = store.typed.peek();
  if (!move) return "";
  const axis = move.axis === null ? "" : `${AXES[move.axis]} `;
  return `${move.kind === "move" ? "Move" : "Turn"} ${axis}${figureOf(store, move) || "…"}`;
}

/** The typed figure with its unit, or that it is none; empty before any. */
function figureOf(store: Store, move: TypedMove): string {
  if (move.text === "") return "";
  const wrong = wrongFigure(move, store.unit.peek());
  if (wrong) return wrong;
  return /[a-zµ°"]\s*$/i.test(move.text) ? move.text : `${move.text} ${move.kind === "move" ? store.unit.peek() : "°"}`;
}

/** "Move along X (world): 12.5 mm"; empty while nothing is under way. */
export function poseHint(store: Store): string {
  const move = store.typed.value;
  if (!move) return "";
  const figure = figureOf(store, move) || "type a number, or use the pointer";
  const how = move.kind === "move" ? "along" : "about";
  const axis =
    move.axis === null
      ? move.kind === "move"
        ? "in the view"
        : "about the view"
      : `${how} ${AXES[move.axis]} (${move.frame})`;
  return `${move.kind === "move" ? "Move" : "Turn"} ${axis}: ${figure} · Enter, Esc`;
}
