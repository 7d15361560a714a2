// The hint in the status line while the tool is moved by keys, and while nothing is under the pointer.

import type { Store } from "../model/store";

const AXES = ["X", "Y", "Z"] as const;

/** "Move along X (world): 12.5 mm"; empty while nothing is under way. */
export function poseHint(store: Store): string {
  const move = store.typed.value;
  if (!move) return "";
  const unit = move.kind === "move" ? store.unit.value : "°";
  const figure =
    move.text === ""
      ? "type a number, or use the pointer"
      : /[a-z°"]/i.test(move.text)
        ? move.text
        : `${move.text} ${unit}`;
  const how = move.kind === "move" ? "along" : "about";
  const axis =
    move.axis === null
      ? move.kind === "move"
        ? "in the view"
        : "about the view"
      : `${how} ${AXES[move.axis]} (${move.frame})`;
  return `${move.kind === "move" ? "Move" : "Turn"} ${axis}: ${figure} · Enter, Esc`;
}
