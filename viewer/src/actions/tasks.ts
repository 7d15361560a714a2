// Tasks: ask for one, go to a step, and edit the plan.

import type { Card, CardAnswer, TaskEditKind } from "../link/protocol";
import type { Vec3 } from "../math/vectors";
import { ask, frameWay } from "./cards";
import { chooseFile } from "./findings";
import type { Workbench } from "./workbench";

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

/** Opens a table of times (TOML): all tasks are planned again. */
export function openTimes(wb: Workbench): void {
  chooseFile(".toml,text/plain", async (file) => wb.run("task_times", { toml: await file.text(), name: file.name }));
}

/** Takes the example times again. */
export const dropTimes = (wb: Workbench): Promise<unknown> => wb.run("task_times", { toml: "" });

/** Edits the plan of a task, which is searched again. */
export const editTask = (
  wb: Workbench,
  card: Card,
  edit: TaskEditKind,
  parts: string | number,
  more: { seconds?: number; later?: string | number } = {},
): Promise<unknown> => wb.run("task_edit", { id: card.id, edit, parts, ...more });
