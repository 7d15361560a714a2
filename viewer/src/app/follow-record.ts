// The timeline of the record that the workbench was opened with.

import { effect } from "@preact/signals";
import type { Workbench } from "../actions/workbench";

/** Fetches the timeline of the record, and again when its gaps are known. */
export function followRecord(wb: Workbench): () => void {
  let known = "";
  return effect(() => {
    const record = wb.store.document.value?.record;
    const key = record && wb.store.connection.value === "open" ? `${record.name} ${record.has_gaps}` : "";
    if (key === known) return;
    known = key;
    if (key === "") return;
    wb.ask("record", {})
      .then((timeline) => {
        wb.store.timeline.value = timeline;
      })
      .catch((error: unknown) => {
        known = "";
        wb.tell(error);
      });
  });
}
