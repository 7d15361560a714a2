// Questions about parts, and what one does with their answers: watch a way, take it, go to a blocker, seat the tool.

import type { Card, CardAnswer, CardQuestion } from "../link/protocol";
import { carry, type Pose } from "../math/matrix";
import { corners, subtract, type Vec3 } from "../math/vectors";
import { type Film, placesAt } from "../model/film";
import type { Workbench } from "./workbench";

type Reach = CardAnswer["reaches"][number];

/** Asks about the selected parts, or about those under the pointer; of access: about all fasteners if there are none. */
export async function ask(
  wb: Workbench,
  question: CardQuestion,
  parts: readonly number[] = wb.targets(),
  without: readonly number[] = [],
  tools: readonly string[] = [],
): Promise<void> {
  const { store } = wb;
  if (parts.length === 0 && question !== "access") {
    store.notify("info", "Select the parts to ask about first");
    return;
  }
  store.panel.value = "ask";
  store.set({ are_panels_open: true });
  await wb.run("ask", {
    question,
    ...(parts.length > 0 ? { parts: [...parts] } : {}),
    ...(without.length > 0 ? { without: [...without] } : {}),
    ...(tools.length > 0 ? { tools: [...tools] } : {}),
  });
  const newest = store.document.peek()?.cards.at(-1);
  if (newest) await openCard(wb, newest.id);
}

/** Asks which of all tools reach the fasteners among the selected parts; without a selection, all fasteners. */
export function askTools(wb: Workbench): Promise<void> {
  return ask(wb, "access", wb.targets(), [], wb.store.document.peek()?.tools ?? []);
}

/** Shows a card with its whole answer; a film, if it has ways, stands at its start. */
export async function openCard(wb: Workbench, id: number | null): Promise<void> {
  const { store } = wb;
  store.card.value = id;
  store.film.value = null;
  store.reach.value = null;
  wb.stage.setRoom(null);
  if (id !== null) await fetchAnswer(wb, id);
  wb.redraw();
}

/** Fetches the answer of the open card, once there is one, and shows it in the picture. */
export async function fetchAnswer(wb: Workbench, id: number): Promise<void> {
  const { store } = wb;
  if (cardOf(wb, id)?.state !== "done") return;
  try {
    const answer = store.answers.peek().get(id) ?? (await wb.ask("card", { id }));
    if (!store.answers.peek().has(id)) store.answers.value = new Map([...store.answers.peek(), [id, answer]]);
    const piece = answer.room && wb.fetchRoom ? await wb.fetchRoom(id) : null;
    // Another card may have been opened meanwhile.
    if (store.card.peek() !== id) return;
    if (answer.ways.length > 0 && store.film.peek()?.card !== id)
      store.film.value = { card: id, step: 0, share: 0, is_playing: false };
    wb.stage.setRoom(piece && answer.room ? { piece, manifest: answer.room } : null);
    wb.redraw();
  } catch (error) {
    wb.tell(error);
  }
}

export const cardOf = (wb: Workbench, id: number): Card | undefined =>
  wb.store.document.peek()?.cards.find((card) => card.id === id);

/** Asks again; the old answer is gone. */
export async function askAgain(wb: Workbench, id: number): Promise<void> {
  forget(wb, id);
  await wb.run("card_again", { id });
}

export async function removeCard(wb: Workbench, id: number): Promise<void> {
  if (wb.store.card.peek() === id) await openCard(wb, null);
  forget(wb, id);
  await wb.run("card_remove", { id });
}

function forget(wb: Workbench, id: number): void {
  const { store } = wb;
  store.answers.value = new Map([...store.answers.peek()].filter(([each]) => each !== id));
  if (store.film.peek()?.card === id) store.film.value = null;
  wb.stage.setRoom(null);
}

/** Plays a film from where it is, or from the start if it is at its end; a second call pauses it. */
export function playFilm(wb: Workbench, card: number): void {
  const { film, answers } = wb.store;
  const ways = answers.peek().get(card)?.ways ?? [];
  const now = film.peek();
  const is_same = now?.card === card;
  if (is_same && now.is_playing) film.value = { ...now, is_playing: false };
  else {
    const is_over = is_same && now.step >= ways.length - 1 && now.share >= 1;
    film.value = is_same && !is_over ? { ...now, is_playing: true } : { card, step: 0, share: 0, is_playing: true };
  }
  wb.redraw();
}

/** Goes to a place of a film, and stands there. */
export function scrub(wb: Workbench, card: number, step: number, share: number): void {
  wb.store.film.value = { card, step, share, is_playing: false };
  wb.redraw();
}

/** Accepts the ways of a card into the sequence: the parts are out then. */
export async function takeWay(wb: Workbench, card: number, steps?: number): Promise<void> {
  const is_done = await wb.run("way_take", steps === undefined ? { id: card } : { id: card, steps });
  if (!is_done) return;
  wb.store.film.value = null;
  wb.store.panel.value = "sequence";
}

/** Selects a part and looks at it. */
export function showPart(wb: Workbench, part: number): void {
  wb.select([part]);
  wb.fit([part]);
}

/** Puts the tool into its seat on a fastener that it reaches, and looks at it. */
export async function seatTool(wb: Workbench, reach: Reach): Promise<void> {
  const { store } = wb;
  store.reach.value = reach;
  if (reach.part !== null) wb.select([reach.part]);
  if (reach.is_reachable) {
    const held = store.document.peek()?.tool?.name;
    if (held !== reach.tool) await wb.run("take_tool", { name: reach.tool });
    await wb.run("seat", { pose: [...reach.pose] });
  }
  wb.look((camera) => camera.translate(subtract(reach.point, camera.target)));
}

/** Corners of the boxes of parts at home: how far they travel. */
export function pointsOf(wb: Workbench, parts: readonly number[]): Vec3[] {
  const manifest = wb.store.manifest.peek();
  return parts.flatMap((part) => {
    const [lower, upper] = [manifest?.parts.lower[part], manifest?.parts.upper[part]];
    return lower && upper && lower[0] <= upper[0] ? corners({ lower: [...lower], upper: [...upper] }) : [];
  });
}

/** Where a film has its parts; empty: no film is open. */
export function filmPlaces(wb: Workbench, film: Film | null): Map<number, Pose> {
  const ways = film ? wb.store.answers.peek().get(film.card)?.ways : undefined;
  if (!film || !ways) return new Map();
  const moved = wb.store.document.peek()?.moved ?? {};
  const starts = Object.fromEntries(Object.entries(moved).map(([part, pose]) => [part, [...pose]]));
  return placesAt(film, ways, starts, (parts) => pointsOf(wb, parts));
}

/** The path of the middle of the parts of the way that plays, world. */
export function filmPath(wb: Workbench, film: Film | null): Vec3[] {
  const way = film ? wb.store.answers.peek().get(film.card)?.ways[film.step] : undefined;
  if (!way) return [];
  const box = wb.boxOf(way.parts);
  const middle: Vec3 = [
    (box.lower[0] + box.upper[0]) / 2,
    (box.lower[1] + box.upper[1]) / 2,
    (box.lower[2] + box.upper[2]) / 2,
  ];
  return way.poses.map((pose) => carry(pose, middle));
}
