// Tasks: ask for one, go to a step, and edit the plan.

import type { Card, CardAnswer, TaskEditKind } from "../link/protocol";
import type { Vec3 } from "../math/vectors";
import type { TaskFile } from "../model/store";
import { ask, frameWay } from "./cards";
import { chooseFile } from "./choosing";
import { sentences, type Workbench } from "./workbench";

/** Of a file, as the server takes it. */
const MOST_BYTES = 90_000;

/** Asks how the selected parts are taken out. */
export function askTask(wb: Workbench): Promise<void> {
  const { store } = wb;
  const kind = store.task_tools.peek();
  const tools = kind === "catalogue" ? null : kind === "own" ? (store.document.peek()?.tools ?? []) : [];
  return ask(wb, "task", wb.targets(), [], tools, store.people_count.peek());
}

/** Goes to the beginning of a step: its tool in its seat, and its way. */
export function showStep(wb: Workbench, card: number, answer: CardAnswer, step: number): void {
  const way = answer.ways[step];
  const facts = answer.task?.steps[step];
  if (!way || !facts) return;
  wb.store.film.value = { card, step, share: 0, is_playing: false };
  wb.select([facts.part]);
  frameWay(wb, way, facts.tool_way.map(placeOf));
  wb.redraw();
}

const placeOf = (pose: readonly number[]): Vec3 => [pose[3] ?? 0, pose[7] ?? 0, pose[11] ?? 0];

/** Opens a table of times, or a catalogue of tools (TOML): tasks are planned again. Says in the panel what is wrong. */
export function openTaskFile(wb: Workbench, kind: TaskFile): void {
  chooseFile(".toml,text/plain", async (file) => {
    const trouble = wb.store.task_troubles[kind];
    trouble.value = "";
    if (file.size > MOST_BYTES) {
      trouble.value = `${file.name} is too long: ${MOST_BYTES} bytes at most.`;
      return;
    }
    try {
      const text = await file.text();
      // A blank text would take the built-in one.
      await wb.send(kind, { toml: text.trim() ? text : "#", name: file.name });
    } catch (error) {
      trouble.value = `${error instanceof Error ? sentences(error.message) : String(error)}.`;
    }
  });
}

/** Takes the example times, or the built-in catalogue, again. */
export function dropTaskFile(wb: Workbench, kind: TaskFile): Promise<unknown> {
  wb.store.task_troubles[kind].value = "";
  return wb.run(kind, { toml: "" });
}

/** Edits the plan of a task, which is searched again. */
export const editTask = (
  wb: Workbench,
  card: Card,
  edit: TaskEditKind,
  parts: string | number,
  more: { seconds?: number; later?: string | number } = {},
): Promise<unknown> => wb.run("task_edit", { id: card.id, edit, parts, ...more });
