// Questions about parts, and what one does with their answers: watch a way, take it, go to a blocker, seat the tool.

import type { Card, CardAnswer, CardQuestion } from "../link/protocol";
import { carry, type Pose } from "../math/matrix";
import { isSame } from "../math/same";
import { type Box, centre, corners, emptyBox, include, subtract, type Vec3 } from "../math/vectors";
import { type Film, type FilmOf, placeAt, placesAt, startsOf, timeOf, type Way } from "../model/film";
import type { Workbench } from "./workbench";

type Reach = CardAnswer["reaches"][number];

/** The question that was asked last, for as long as the same one would be the second click on it. */
let asking: object | null = null;
const TWICE_MS = 600;

/** How near to where a way meets something a film says so, as a share of the way. */
const AT_HIT = 0.004;

/** Asks about the selected parts, or about those under the pointer; of access: about all fasteners if there are none. */
export async function ask(
  wb: Workbench,
  question: CardQuestion,
  parts: readonly number[] = wb.targets(),
  without: readonly number[] = [],
  tools: readonly string[] | null = null,
  people = 1,
  is_of_catalogue = false,
): Promise<void> {
  const { store } = wb;
  if (parts.length === 0 && question !== "access") {
    store.notify("info", "Select the parts to ask about first");
    return;
  }
  store.panel.value = question === "task" ? "task" : "ask";
  store.set({ are_panels_open: true });
  const given = {
    question,
    ...(parts.length > 0 ? { parts: [...parts] } : {}),
    ...(without.length > 0 ? { without: [...without] } : {}),
    ...(people > 1 ? { people } : {}),
    ...(tools !== null ? { tools: [...tools] } : {}),
    ...(is_of_catalogue ? { catalogue: true } : {}),
  };
  // A double click asks once.
  if (isSame(given, asking)) return;
  asking = given;
  let is_asked = false;
  try {
    is_asked = await wb.run("ask", given);
  } finally {
    setTimeout(() => {
      asking = null;
    }, TWICE_MS);
  }
  const newest = store.document.peek()?.cards.at(-1);
  if (is_asked && newest) await openCard(wb, newest.id);
}

/**
 * Asks which tools reach the fasteners among the selected parts; without a selection, all fasteners. Opened tools are
 * tried first, then those of the catalogue.
 */
export const askTools = (wb: Workbench): Promise<void> => ask(wb, "access", wb.targets(), [], null, 1, true);

/** Shows a card with its whole answer; a film of parts that are still there stands at its start. */
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
    // A film of a removal in the sequence has the parts where they were: it begins when it is asked for.
    const film = store.film.peek();
    if (answer.ways.length > 0 && film?.card !== id && cardOf(wb, id)?.line === null)
      store.film.value = { card: id, step: 0, share: 0, is_playing: false };
    // Asked again, it may have fewer steps.
    else if (film?.card === id && film.step >= answer.ways.length)
      store.film.value = { card: id, step: Math.max(0, answer.ways.length - 1), share: 0, is_playing: false };
    wb.stage.setRoom(piece && answer.room ? { piece, manifest: answer.room } : null);
    wb.redraw();
  } catch (error) {
    wb.tell(error);
  }
}

export const cardOf = (wb: Workbench, id: number): Card | undefined =>
  wb.store.document.peek()?.cards.find((card) => card.id === id);

/** Whether a part is out of the mock-up, or in the hand: it cannot be asked about then. */
export function isAway(wb: Workbench, part: number): boolean {
  const { out = [], gripped = [] } = wb.store.document.value ?? {};
  return out.includes(part) || gripped.includes(part);
}

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
  if (store.card.peek() === id) store.reach.value = null;
  wb.stage.setRoom(null);
}

/** The ways of a film; none before they were fetched. */
export const waysOf = ({ store }: Workbench, of: FilmOf | undefined): readonly Way[] =>
  (of === "sequence" ? store.sequence_film.value : of === undefined ? null : store.answers.value.get(of)?.ways) ?? [];

/** Plays a film from where it is, or from the start if it is at its end; a second call pauses it. */
export function playFilm(wb: Workbench, card: FilmOf): void {
  const { film } = wb.store;
  const ways = waysOf(wb, card);
  const now = film.peek();
  const is_same = now?.card === card;
  if (is_same && now.is_playing) film.value = { ...now, is_playing: false };
  else {
    const is_over = is_same && now.step >= ways.length - 1 && now.share >= 1;
    film.value = is_same && !is_over ? { ...now, is_playing: true } : { card, step: 0, share: 0, is_playing: true };
  }
  wb.redraw();
}

/** Goes to a moment of a film, seconds, and stands there. */
export function scrub(wb: Workbench, card: FilmOf, seconds: number): void {
  wb.store.film.value = { card, ...placeAt(waysOf(wb, card), seconds), is_playing: false };
  wb.redraw();
}

/** Fetches the sequence as a film, if it is not there, and shows its start. */
export async function openSequenceFilm(wb: Workbench): Promise<void> {
  const { store } = wb;
  if (store.sequence_film.peek()) {
    scrub(wb, "sequence", 0);
    return;
  }
  try {
    const sequence = store.document.peek()?.sequence;
    const film = await wb.job("film", {}, "Film of the sequence")?.result;
    if (!film || store.document.peek()?.sequence !== sequence) return;
    store.sequence_film.value = film.ways;
    scrub(wb, "sequence", 0);
  } catch (error) {
    wb.tell(error);
  }
}

/** The film ends: the picture has the parts where they are. */
export function endFilm(wb: Workbench): void {
  wb.store.film.value = null;
  wb.redraw();
}

/** So soon after it, another click belongs to the same double click. */
const TAKEN_MS = 500;
/** Cards whose ways are being accepted. */
const taking = new Set<number>();

/** Accepts the ways of a card into the sequence: the parts are out then. A second click of a double click does nothing. */
export async function takeWay(wb: Workbench, card: number, steps?: number): Promise<void> {
  if (taking.has(card)) return;
  taking.add(card);
  const is_done = await wb.run("way_take", steps === undefined ? { id: card } : { id: card, steps });
  // The page shows that the parts are out a moment later.
  setTimeout(() => taking.delete(card), TAKEN_MS);
  if (!is_done) return;
  wb.store.film.value = null;
  wb.store.panel.value = "sequence";
}

/** Selects a part and looks at it. */
export function showPart(wb: Workbench, part: number): void {
  wb.select([part]);
  wb.fit([part]);
}

/** Puts the tool into its seat on a fastener that it reaches, and looks at its swing. One of the catalogue is drawn there. */
export async function seatTool(wb: Workbench, reach: Reach): Promise<void> {
  const { store } = wb;
  store.reach.value = reach;
  if (reach.part !== null) wb.select([reach.part]);
  if (reach.is_reachable && !reach.is_catalogue) {
    const held = store.document.peek()?.tool?.name;
    if (held !== reach.tool) await wb.run("take_tool", { name: reach.tool });
    await wb.run("seat", { pose: [...reach.pose] });
  }
  if (reach.fan.length === 0) {
    wb.look((camera) => camera.translate(subtract(reach.point, camera.target)));
    return;
  }
  const box = wb.boxOf(reach.part === null ? [] : [reach.part]);
  for (const point of [reach.point, ...reach.fan]) include(box, point);
  wb.look((camera) => camera.fit(box));
}

/** Corners of the boxes of parts at home: how far they travel. */
export function pointsOf(wb: Workbench, parts: readonly number[]): Vec3[] {
  const manifest = wb.store.manifest.peek();
  return parts.flatMap((part) => {
    const [lower, upper] = [manifest?.parts.lower[part], manifest?.parts.upper[part]];
    return lower && upper && lower[0] <= upper[0] ? corners({ lower: [...lower], upper: [...upper] }) : [];
  });
}

/** Where parts lie when a way begins, by their number: for a removal in the sequence as that has them, else as they lie now. */
function beginningsOf(wb: Workbench, way: Way | undefined): Record<string, Pose> {
  const places = way?.places ?? wb.store.document.peek()?.moved ?? {};
  return Object.fromEntries(Object.entries(places).map(([part, pose]) => [part, [...pose]]));
}

/** Where the picture has all parts that are not where they were loaded, with those of a film on their way. */
export function filmPlaces(wb: Workbench, film: Film | null): Map<number, Pose> {
  const ways = waysOf(wb, film?.card);
  const starts = beginningsOf(wb, film ? ways[film.step] : undefined);
  const places = new Map(Object.entries(starts).map(([part, pose]) => [Number(part), pose]));
  if (!film || ways.length === 0) return places;
  return new Map([...places, ...placesAt(film, ways, starts, (parts) => pointsOf(wb, parts))]);
}

/** The box of the parts of a way where it begins, or all along it. */
function boxOfWay(wb: Workbench, way: Way, isAlong: boolean): Box {
  const box = emptyBox();
  const starts = startsOf(way) ?? beginningsOf(wb, way);
  for (const part of way.parts) {
    const start = starts[part];
    for (const corner of pointsOf(wb, [part])) {
      const point = start ? carry([...start], corner) : corner;
      if (isAlong) for (const pose of way.poses) include(box, carry(pose, point));
      else include(box, point);
    }
  }
  return box;
}

/** The path of the middle of the parts of the way that plays, world. */
export function filmPath(wb: Workbench, film: Pick<Film, "card" | "step"> | null): Vec3[] {
  const way = film ? waysOf(wb, film.card)[film.step] : undefined;
  if (!way) return [];
  const middle = centre(boxOfWay(wb, way, false));
  return way.poses.map((pose) => carry(pose, middle));
}

/** Glides to where a whole way and its parts are in sight, and more points. */
export function frameWay(wb: Workbench, way: Way, more: readonly Vec3[] = []): void {
  const box = boxOfWay(wb, way, true);
  for (const point of more) include(box, point);
  wb.look((camera) => camera.fit(box));
}

/** Goes to where a way meets something, and looks at it. */
export function showHit(wb: Workbench, card: number, step: number, way: Way): void {
  const { hit } = way;
  if (!hit) return;
  wb.select([hit.part]);
  scrub(wb, card, timeOf({ step, share: hit.share }, waysOf(wb, card)));
  wb.look((camera) => camera.translate(subtract([...hit.point], camera.target)));
}

/** What a way meets at a share of it; null: nothing there. */
export const hitAt = (way: Way, share: number): Way["hit"] | null =>
  way.hit && Math.abs(way.hit.share - share) < AT_HIT ? way.hit : null;
