// What one does with other people: looks where they look, and takes the tool by turns.

import type { TurnWish } from "../link/protocol";
import type { Workbench } from "./workbench";

/** The view goes to where another person looks. */
export function lookWhere(wb: Workbench, person: number): void {
  const camera = wb.store.people.seen.peek().get(person)?.camera;
  if (!camera) return;
  wb.store.dialog.value = null;
  wb.store.set({ is_parallel: camera.is_parallel ?? false });
  wb.look((each) => each.fromJSON(camera));
}

export async function wishTurn(wb: Workbench, wish: TurnWish, to: number | null = null): Promise<void> {
  if (wb.link) await wb.told(wb.link.turn(wish, to));
}

/** Gives the tool to whoever asked first. */
export async function giveTurn(wb: Workbench): Promise<void> {
  const [first] = wb.store.people.asking.peek();
  if (first) await wishTurn(wb, "give", first.id);
}

/** Lets the tool go, takes it, or asks for it: the next thing that makes sense. */
export function changeTurn(wb: Workbench): Promise<void> {
  const { people } = wb.store;
  if (people.is_mine.peek()) return wishTurn(wb, "let_go");
  if (people.is_barred.peek()) people.tried();
  return wishTurn(wb, people.is_barred.peek() ? "ask" : "take");
}
