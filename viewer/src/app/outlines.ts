// The exact outlines of the cuts, requested from the engine.

import { effect } from "@preact/signals";
import type { Workbench } from "../actions/workbench";
import { floatsOf } from "../math/base64";
import type { Loop } from "./loop";

/** Keeps the exact outlines of the cuts that are on beside the picture: asked for once a drag has ended. */
export function followOutlines(wb: Workbench, loop: Loop): () => void {
  let asked = 0;
  return effect(() => {
    const document = wb.store.document.value;
    const isDragging = wb.store.section_draft.value !== null || wb.store.box_draft.value !== null;
    const isCut = document?.sections.some((section) => section.is_on) || document?.section_box?.is_on;
    // Hidden parts have no outline, and moved parts have another one: request them again.
    void [document?.hidden, document?.gripped, document?.moved];
    const mine = ++asked;
    wb.stage.setOutlines(null);
    // Outlines belong to parts at their places: an exploded mock-up has none.
    if (isDragging || !isCut || (document?.explode ?? 0) > 0) return;
    if (wb.store.is_read_only.value || !wb.store.manifest.value) return;
    wb.link
      ?.job("outline", {})
      .result.then((result) => {
        if (mine !== asked) return;
        wb.stage.setOutlines(floatsOf(result.segments));
        loop.request();
      })
      .catch((error: unknown) => {
        if (mine === asked) wb.tell(error);
      });
  });
}
