// The tool of a step of a task in its seat, as a ghost: fetched once, and shown while the film is at the step's beginning.

import { effect } from "@preact/signals";
import type { Workbench } from "../actions/workbench";
import type { ToolGhost } from "../link/protocol";
import { bytesOf } from "../math/base64";
import { seatedStep } from "../model/task";
import type { Loop } from "./loop";

/** Follows the store from now on; the function returned ends it. */
export function followTask(wb: Workbench, loop: Loop): () => void {
  const { store, stage } = wb;
  let fetched = new WeakMap<object, Map<number, Promise<ToolGhost | null>>>();
  let drawn: { answer: object; step: number } | null = null;
  const end = effect(() => {
    const film = store.film.value;
    const id = typeof film?.card === "number" ? film.card : null;
    const answer = id === null ? undefined : store.answers.value.get(id);
    const step = film && answer ? seatedStep(answer, film.step, film.share) : null;
    if (step === null || id === null || !answer) {
      if (drawn) stage.setRoom(null);
      drawn = null;
      return;
    }
    if (drawn?.answer === answer && drawn.step === step) return;
    if (drawn) stage.setRoom(null);
    const wanted = { answer, step };
    drawn = wanted;
    const known = fetched.get(answer) ?? new Map<number, Promise<ToolGhost | null>>();
    fetched.set(answer, known);
    const ghost = known.get(step) ?? wb.ask("task_tool", { id, step });
    known.set(step, ghost);
    ghost.then(
      (found) => {
        if (drawn !== wanted || !found) return;
        stage.setRoom({ piece: bytesOf(found.data), manifest: found.manifest });
        loop.request();
      },
      (error: unknown) => {
        known.delete(step);
        wb.tell(error);
      },
    );
  });
  const forgetting = forgetOld(wb);
  return () => {
    end();
    forgetting();
    fetched = new WeakMap();
  };
}

/** Drops answers of cards that are asked again, by an edit, by undo or by another person: they are fetched anew. */
function forgetOld({ store }: Workbench): () => void {
  const edits = new WeakMap<object, string>();
  return effect(() => {
    const answers = store.answers.value;
    const cards = new Map(store.document.value?.cards.map((card) => [card.id, card]));
    const kept = [...answers].filter(([id, answer]) => {
      const card = cards.get(id);
      if (card?.state !== "done") return false;
      const now = JSON.stringify(card.edits);
      const then = edits.get(answer) ?? now;
      edits.set(answer, then);
      return then === now;
    });
    if (kept.length < answers.size) store.answers.value = new Map(kept);
  });
}
