// The worst position of a joint as a ghost: fetched when it is asked for, gone with the range that it belongs to.

import { effect } from "@preact/signals";
import type { Workbench } from "../actions/workbench";
import { bytesOf } from "../math/base64";
import type { Loop } from "./loop";

/** Follows the store from now on; the function returned ends it. */
export function followJoints(wb: Workbench, loop: Loop): () => void {
  const { store, stage } = wb;
  let drawn = "";
  return effect(() => {
    const name = store.joint_ghost.value;
    const worst = store.document.value?.joint_ranges.find((each) => each.name === name)?.worst ?? null;
    const wanted = worst && name !== null ? `${name} ${worst.poses.join()}` : "";
    if (wanted === drawn) return;
    const wasDrawn = drawn !== "";
    drawn = wanted;
    if (wanted === "" || name === null) {
      if (wasDrawn) stage.setRoom(null);
      store.joint_ghost.value = null;
      loop.request();
      return;
    }
    wb.ask("joint_ghost", { name }).then(
      ({ manifest, data }) => {
        if (drawn !== wanted) return;
        stage.setRoom({ piece: bytesOf(data), manifest });
        loop.request();
      },
      (error: unknown) => {
        store.joint_ghost.value = null;
        wb.tell(error);
      },
    );
  });
}
