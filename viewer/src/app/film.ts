// Plays films of ways: once a frame the open film goes on, and the picture has its parts where it has them.

import { effect } from "@preact/signals";
import { fetchAnswer, filmPath, filmPlaces, hitAt, waysOf } from "../actions/cards";
import { guidePath } from "../actions/lines";
import type { Workbench } from "../actions/workbench";
import type { Vec3 } from "../math/vectors";
import { advanced, gapAt } from "../model/film";
import { placesAt } from "../model/joints";
import type { Loop } from "./loop";

/** A longer pause between two frames is none of the film's. */
const LONGEST_FRAME_S = 0.25;

/** Follows the store from now on; the function returned ends it. */
export function followFilm(wb: Workbench, loop: Loop): () => void {
  const { store, stage } = wb;
  let last_ms: number | null = null;
  const play = (now_ms: number): boolean => {
    const film = store.film.peek();
    const ways = waysOf(wb, film?.card);
    if (!film?.is_playing || ways.length === 0) {
      last_ms = null;
      return false;
    }
    const seconds = last_ms === null ? 0 : Math.min(LONGEST_FRAME_S, (now_ms - last_ms) / 1000);
    last_ms = now_ms;
    store.film.value = advanced(film, ways, store.speed.peek() * seconds);
    return true;
  };
  loop.each_frame.add(play);
  const ends = [
    // A question that is answered while its card is open shows its answer.
    effect(() => {
      const id = store.card.value;
      const card = store.document.value?.cards.find((each) => each.id === id);
      if (card?.state === "done" && !store.answers.value.has(card.id)) void fetchAnswer(wb, card.id);
      if (id !== null && store.document.value && !card) store.card.value = null;
    }),
    // The film is of the sequence as it was: of another one, none is there yet.
    effect(() => {
      void store.document.value?.sequence;
      store.sequence_film.value = null;
      if (store.film.peek()?.card === "sequence") store.film.value = null;
    }),
    effect(() => {
      void store.manifest.value;
      void [store.answers.value, store.sequence_film.value, store.document.value?.moved];
      const film = store.film.value;
      const document = store.document.value;
      const shown = store.joints_shown.value;
      const places = !film && document && shown ? placesAt(document, shown.poses) : filmPlaces(wb, film);
      stage.setMoved(new Map([...places].map(([part, pose]) => [part, [...pose]])));
      loop.request();
    }),
    effect(() => {
      const film = store.film.value;
      const reach = store.reach.value;
      const way = film ? waysOf(wb, film.card)[film.step] : undefined;
      const gap = film && way ? gapAt(way.gaps, film.share) : null;
      const hit = film && way ? hitAt(way, film.share) : null;
      const card = store.card.value;
      const open = film ?? (card === null ? null : { card, step: 0 });
      const guiding = store.document.value?.guiding ?? null;
      const ghost = store.joint_ghost.value;
      const worst = store.document.value?.joint_ranges.find((each) => each.name === ghost)?.worst ?? null;
      if (worst && !film) {
        const gap = { point: [...worst.points[1]] as Vec3, value: worst.gap, part: worst.other };
        const path = worst.points.map((point) => [...point] as Vec3);
        store.way_marks.value = { path, gap, fan: null };
        loop.remark();
        return;
      }
      const met = store.joints_shown.value && !film ? store.joint_place.value?.met : null;
      if (met) {
        const point = [...met.point] as Vec3;
        store.way_marks.value = { path: [point, point], gap: { point, value: 0, part: met.other }, fan: null };
        loop.remark();
        return;
      }
      store.way_marks.value = {
        path: guiding && !film ? guidePath(wb, guiding) : filmPath(wb, open),
        gap: hit
          ? { point: [...hit.point], value: 0, part: hit.part }
          : gap?.point && gap.gap !== null
            ? { point: [...gap.point], value: gap.gap, part: gap.part ?? -1 }
            : null,
        fan: reach
          ? { centre: [...reach.point], rim: reach.fan.map((each) => [...each]), isGood: reach.is_reachable }
          : null,
      };
      loop.remark();
    }),
  ];
  return () => {
    loop.each_frame.delete(play);
    for (const end of ends) end();
  };
}
