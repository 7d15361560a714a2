// G and R: the typed movement in the store, and the hand that follows it.

import { scale, type Vec3 } from "../math/vectors";
import type { Frame } from "../model/hand";
import {
  isFigureKey,
  poseOfTyped,
  startTyped,
  type TypedMove,
  withAxis,
  withKey,
  wrongFigure,
} from "../model/typed-move";
import type { Workbench } from "./workbench";

/** Begins to move or turn the tool; the same key again begins anew from there. */
export function beginTyping(wb: Workbench, kind: TypedMove["kind"]): void {
  const { hand, store } = wb;
  if (store.typed.peek()) cancelTyping(wb);
  const { pose, center } = hand;
  store.is_typing_refused.value = !pose || !center || hand.isLocked;
  if (!pose || !center || hand.isLocked) {
    sayRefusal(wb);
    return;
  }
  store.typed.value = startTyped(kind, pose, center, store.settings.peek().frame);
  wb.say(kind === "move" ? "Move: X, Y or Z, a length, Enter" : "Turn: X, Y or Z, an angle, Enter");
}

/** Why the tool does not move by keys now: in the bar of turns, or in the live region. */
function sayRefusal(wb: Workbench): void {
  const { people } = wb.store;
  if (people.is_barred.peek()) people.tried();
  wb.say(
    people.is_barred.peek()
      ? `${people.holder.peek()} has the tool`
      : "The tool cannot be moved now: press G or R again",
  );
}

/**
 * A key after a movement that was refused: the keys of that movement say why, and do nothing else. Whether it was one.
 *
 * Esc, Enter, and every key that does not belong to a movement end this.
 */
export function refuseKey(wb: Workbench, isOfTyping: boolean, key: string): boolean {
  const { is_typing_refused } = wb.store;
  if (!is_typing_refused.peek()) return false;
  const ends = key === "Escape" || key === "Enter";
  if (ends || !isOfTyping) is_typing_refused.value = false;
  else sayRefusal(wb);
  return isOfTyping;
}

export function chooseAxis(wb: Workbench, axis: 0 | 1 | 2): void {
  const move = wb.store.typed.peek();
  if (move) apply(wb, withAxis(move, axis));
}

/** Adds a key to the figure; whether it took it. */
export function typeFigure(wb: Workbench, key: string): boolean {
  const move = wb.store.typed.peek();
  if (!move || !isFigureKey(move, key)) return false;
  apply(wb, withKey(move, key));
  return true;
}

function apply(wb: Workbench, move: TypedMove): void {
  wb.store.typed.value = move;
  const { camera } = wb.stage;
  const view = { right: camera.right, towards: scale(camera.forward, -1) };
  const pose = poseOfTyped(move, wb.store.unit.peek(), view);
  if (pose) wb.hand.move(pose, "keys");
  else if (!wb.hand.isLocked) wb.hand.move(move.start, "keys");
}

/** A step of the chosen size by an arrow key: in the view, or along the axis chosen. */
export function stepTyping(wb: Workbench, direction: Vec3): void {
  const move = wb.store.typed.peek();
  if (!move) return;
  const { step_m, step_rad } = wb.store.settings.peek();
  const [x, y, z] = direction;
  const sign = x + y + z;
  const along: Vec3 = move.axis === null ? direction : [0, 0, 0];
  if (move.axis !== null) along[move.axis] = sign;
  const frame: Frame = move.axis === null ? "view" : move.frame;
  const zero: Vec3 = [0, 0, 0];
  if (move.kind === "move") wb.hand.nudge({ translation: scale(along, step_m), rotation: zero }, frame, "keys");
  // In the view, an arrow to the right turns the tool about the vertical, as a hand on a ball would.
  else {
    const about: Vec3 = move.axis === null ? [-y, x, z] : along;
    wb.hand.nudge({ translation: zero, rotation: scale(about, step_rad) }, frame, "keys");
  }
}

/** The tool stays where it came to; a text that is no figure is refused, and stays to be mended. */
export function confirmTyping(wb: Workbench): void {
  const move = wb.store.typed.peek();
  if (!move) return;
  const wrong = wrongFigure(move, wb.store.unit.peek());
  if (wrong) {
    wb.say(wrong);
    return;
  }
  wb.store.typed.value = null;
  wb.hand.put();
}

/** The tool goes back to where it was. */
export function cancelTyping(wb: Workbench): void {
  const move = wb.store.typed.peek();
  if (!move) return;
  wb.store.typed.value = null;
  wb.hand.cancel(move.start, "keys");
}
