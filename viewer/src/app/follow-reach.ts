// The tool of the catalogue of a row of access in its seat, as a ghost: fetched once, and shown while the row is chosen.

import { effect } from "@preact/signals";
import type { Workbench } from "../actions/workbench";
import type { CardAnswer, ToolGhost } from "../link/protocol";
import { bytesOf } from "../math/base64";
import type { Loop } from "./loop";

type Reach = CardAnswer["reaches"][number];

/** Follows the store from now on; the function returned ends it. */
export function followReach(wb: Workbench, loop: Loop): () => void {
  const { store, stage } = wb;
  const fetched = new WeakMap<Reach, Promise<ToolGhost | null>>();
  let drawn: Reach | null = null;
  return effect(() => {
    const reach = store.reach.value;
    const id = store.card.value;
    const row = reach && id !== null ? (store.answers.value.get(id)?.reaches.indexOf(reach) ?? -1) : -1;
    if (reach === null || id === null || row < 0) {
      if (drawn) stage.setRoom(null);
      drawn = null;
      // Its card was asked again: the row is gone.
      if (reach !== null) store.reach.value = null;
      return;
    }
    if (drawn === reach) return;
    if (drawn) stage.setRoom(null);
    drawn = reach;
    if (!reach.is_catalogue || reach.tool === "") return;
    const ghost = fetched.get(reach) ?? wb.ask("reach_tool", { id, row });
    fetched.set(reach, ghost);
    ghost.then(
      (found) => {
        if (drawn !== reach || !found) return;
        stage.setRoom({ piece: bytesOf(found.data), manifest: found.manifest });
        loop.request();
      },
      (error: unknown) => {
        fetched.delete(reach);
        wb.tell(error);
      },
    );
  });
}
